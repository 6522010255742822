!> The table of a study, x.study: one row a variant (doc/manual, "Studies").
module study_table
  use kinds, only: wp
  use text, only: string_t
  use errors, only: error_t
  use text_files, only: text_file_t, create_text_file, write_line, flush_text_file
  use tables, only: table_t, create_reaction_table, write_rows, close_table
  use study_types, only: study_t
  implicit none
  private
  public :: create_study_table, write_variant, result_t, write_reactions

  !> What a variant has come to.
  type :: result_t
    integer :: code = 0 !! exit code
    integer :: step = 0 !! its last end time
    integer :: iterations = 0 !! linear solves
    integer :: cuts = 0 !! of increments
    real(wp), allocatable :: reactions(:, :, :) !! (3, sets, end times) [force]
  end type result_t

contains

  !> Creates the table.
  subroutine create_study_table(table, path, title, study, sets, error)
    type(text_file_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: title !! title of the deck
    type(study_t), intent(in) :: study !! its parameters
    type(string_t), intent(in) :: sets(:) !! sets of the reactions
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: line
    integer :: i, k

    call create_text_file(table, path, error)
    call write_line(table, '# '//trim(adjustl(title)), error)
    call write_line(table, '# study '//study%name// &
      ': reactions at the last output time of each variant', error)
    line = '# variant'
    do i = 1, size(study%varied)
      line = line//right(study%varied(i)%name, 23)
    end do
    line = line//'  exit    step'
    do i = 1, size(sets)
      do k = 1, 3
        line = line//right('R'//achar(48 + k)//':'//sets(i)%s, 23)
      end do
    end do
    line = line//'  iterations    cuts'
    call write_line(table, line, error)
    call flush_text_file(table, error)
  end subroutine create_study_table

  !> Writes the row of one variant.
  subroutine write_variant(table, study, number, result, error)
    type(text_file_t), intent(inout) :: table !! open table
    type(study_t), intent(in) :: study !! values
    integer, intent(in) :: number !! of the variant
    type(result_t), intent(in) :: result !! what it has come to
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: line
    character(23) :: number_text
    character(40) :: counts
    integer :: i, k

    write (counts, '(i9)') number
    line = counts(:9)
    do i = 1, size(study%varied)
      write (number_text, '(2x,es21.12e3)') study%variants(i, number)
      line = line//number_text
    end do
    write (counts, '(i6,i8)') result%code, result%step
    line = line//counts(:14)
    do i = 1, size(result%reactions, 2)
      do k = 1, 3
        write (number_text, '(2x,es21.12e3)') last_reaction(result, k, i)
        line = line//number_text
      end do
    end do
    write (counts, '(i12,i8)') result%iterations, result%cuts
    call write_line(table, line//counts(:20), error)
    call flush_text_file(table, error)
  end subroutine write_variant

  !> A reaction at the last end time that was reached; zero before the first.
  pure real(wp) function last_reaction(result, k, i) result(reaction)
    type(result_t), intent(in) :: result !! what a variant has come to
    integer, intent(in) :: k !! direction
    integer, intent(in) :: i !! node set

    reaction = 0.0_wp
    if (result%step > 0) reaction = result%reactions(k, i, result%step)
  end function last_reaction

  !> A name at the right end of a column.
  pure function right(name, width) result(t)
    character(*), intent(in) :: name !! the name
    integer, intent(in) :: width !! of the column
    character(max(width, len(name) + 2)) :: t
    integer :: i

    t = ' '
    t(len(t) - len(name) + 1:) = name
    do i = len(t) - len(name) + 1, len(t)
      if (t(i:i) == ' ') t(i:i) = '_'
    end do
  end function right

  !> The reactions of one variant at all its end times, as a table of its own.
  subroutine write_reactions(base, number, title, sets, times, result, error)
    character(*), intent(in) :: base !! path of the files without ending
    integer, intent(in) :: number !! the variant
    character(*), intent(in) :: title !! title of the deck
    type(string_t), intent(in) :: sets(:) !! sets of the reactions
    real(wp), intent(in) :: times(:) !! end times
    type(result_t), intent(in) :: result !! its reactions
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(table_t) :: table
    character(8) :: text
    integer :: i

    write (text, '(i0.3)') number
    call create_reaction_table(table, base//'.'//trim(text)//'.rea', title, sets, error)
    do i = 1, result%step
      call write_rows(table, i, times(i), result%reactions(:, :, i), error)
    end do
    call close_table(table, error)
  end subroutine write_reactions
end module study_table

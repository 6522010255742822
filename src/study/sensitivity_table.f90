!> The table of derivatives, x.sen (doc/manual, "Derivatives along the run").
module sensitivity_table
  use kinds, only: wp
  use errors, only: error_t
  use tables, only: row_start, reals, padded
  use text_files, only: text_file_t, create_text_file, write_line, flush_text_file
  use model_types, only: model_t
  use system_types, only: state_t
  use result_types, only: derivative_rows_t
  use sensitivity_types, only: sensitivity_t
  implicit none
  private
  public :: sensitivity_table_t, create_sensitivity_table, derivative_rows, write_sensitivities

  !> The table, open for writing.
  type :: sensitivity_table_t
    type(text_file_t) :: file !! its file
    integer :: quantity = 8 !! width of the column of quantities
    integer :: parameter = 9 !! width of the column of parameters
  end type sensitivity_table_t

contains

  !> Creates the table.
  subroutine create_sensitivity_table(table, path, model, s, error)
    type(sensitivity_table_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    type(model_t), intent(in) :: model !! title, pairs
    type(sensitivity_t), intent(in) :: s !! sets, parameters
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call create_text_file(table%file, path, error)
    do i = 1, size(s%sets)
      table%quantity = max(table%quantity, len(s%sets(i)%s))
    end do
    do i = 1, size(model%pairs)
      table%quantity = max(table%quantity, len(model%pairs(i)%name))
    end do
    do i = 1, s%shown
      table%parameter = max(table%parameter, len(s%slopes(i)%name))
    end do
    call write_line(table%file, '# '//trim(adjustl(model%title)), error)
    call write_line(table%file, '# derivatives of reactions (sets) '// &
      'and of contact sums (pairs) by parameters', error)
    call write_line(table%file, '#   step'//repeat(' ', 19)// 'time  '//padded('quantity', &
      table%quantity)//'  '//padded('parameter', table%parameter)// repeat(' ', 21)//'d1'// &
      repeat(' ', 21)//'d2'//repeat(' ', 21)//'d3   kinks'// repeat(' ', 18)//'range', error)
    call flush_text_file(table%file, error)
  end subroutine create_sensitivity_table

  !> The derivatives at one end time, sets before pairs; a range without an end is 0.
  function derivative_rows(model, s) result(rows)
    type(model_t), intent(in) :: model !! pairs
    type(sensitivity_t), intent(in) :: s !! derivatives
    type(derivative_rows_t) :: rows
    integer :: i, j, n

    n = (size(s%sets) + size(model%pairs))*s%shown
    allocate (rows%quantity(n), rows%parameter(n), rows%kinks(n), rows%values(4, n))
    n = 0
    do i = 1, size(s%sets)
      do j = 1, s%shown
        call add(s%sets(i)%s, s%reaction(:, i, j), sum(s%kinks), minval(s%range(j, :)))
      end do
    end do
    do i = 1, size(model%pairs)
      do j = 1, s%shown
        call add(model%pairs(i)%name, s%contact(:, i, j), s%kinks(i), s%range(j, i))
      end do
    end do

  contains

    !> One more row.
    subroutine add(quantity, d, kinks, range)
      character(*), intent(in) :: quantity !! name of the set or pair
      real(wp), intent(in) :: d(3) !! the derivative
      integer, intent(in) :: kinks !! points at a border
      real(wp), intent(in) :: range !! of the parameter

      n = n + 1
      rows%quantity(n) = quantity
      rows%parameter(n) = s%slopes(j)%name
      rows%kinks(n) = kinks
      rows%values(:, n) = [merge(0.0_wp, d, abs(d) <= 0.0_wp), &
        merge(0.0_wp, range, range >= huge(1.0_wp))]
    end subroutine add
  end function derivative_rows

  !> Writes the rows of one end time.
  subroutine write_sensitivities(table, state, rows, error)
    type(sensitivity_table_t), intent(inout) :: table !! open table
    type(state_t), intent(in) :: state !! step and time
    type(derivative_rows_t), intent(in) :: rows !! derivatives
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(8) :: kinks
    integer :: i

    do i = 1, size(rows%kinks)
      write (kinks, '(i8)') rows%kinks(i)
      call write_line(table%file, row_start(state%step, state%time)//'  '// &
        padded(trim(rows%quantity(i)), table%quantity)//'  '//padded(trim(rows%parameter(i)), &
        table%parameter)//reals(rows%values(1:3, i))//kinks//reals(rows%values(4:4, i)), error)
    end do
    call flush_text_file(table%file, error)
  end subroutine write_sensitivities
end module sensitivity_table

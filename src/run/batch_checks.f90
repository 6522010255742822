!> What the solution commands name: states and files of REST, nodes of DISP and REAC. Looked up when
!! the deck is read, before any file is touched.
module batch_checks
  use text, only: to_text
  use deck_types, only: deck_t, location_t
  use records, only: item_location
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use batch_types, only: batch_command_t
  use printing, only: numbers_to_print
  use saved_states, only: file_of
  use results_names, only: bodies_ending, state_ending, find_results
  implicit none
  private
  public :: check_files, check_nodes

contains

  !> REST needs a state that a SAVE before it keeps, or a file that is there.
  subroutine check_files(deck, commands, base, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(batch_command_t), intent(in) :: commands(:) !! its solution commands
    character(*), intent(in) :: base !! path of the run's files without their endings
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: path
    type(location_t) :: at
    integer :: i
    logical :: there

    do i = 1, size(commands)
      if (commands(i)%command /= 'rest') cycle
      path = commands(i)%text
      if (scan(path, './') == 0) path = file_of(base, path)
      inquire (file=find_results(path), exist=there)
      if (there .or. is_written(path, commands(:i - 1), base)) cycle
      at = commands(i)%at
      if (len(commands(i)%text) > 0) at = item_location(deck%batch(i)%head, 2)
      if (scan(commands(i)%text, './') > 0) then
        call report_error(diagnostics, at, 'there is no file '//path//' to go back to', &
          'name the .vtkhdf file of a run, or one that SAVE has written, as it is found from '// &
          'the working directory')
      else
        call report_error(diagnostics, at, 'no SAVE before it keeps this state, and '// &
          'there is no file '//path, 'write SAVE'//comma_name(commands(i)%text)// &
          ' where the state is reached, or name a file: REST,run.vtkhdf')
      end if
    end do
  end subroutine check_files

  !> A comma and a name, nothing without a name.
  pure function comma_name(name) result(t)
    character(*), intent(in) :: name !! may be empty
    character(:), allocatable :: t

    t = ''
    if (len(name) > 0) t = ','//name
  end function comma_name

  !> The run itself writes a file of this name: its results, or a state that a command keeps.
  pure logical function is_written(path, commands, base) result(yes)
    character(*), intent(in) :: path !! the file
    type(batch_command_t), intent(in) :: commands(:) !! the commands before
    character(*), intent(in) :: base !! path of the run's files without their endings
    integer :: i

    yes = last_part(path) == last_part(base//bodies_ending) .or. &
      last_part(path) == last_part(base//state_ending)
    do i = 1, size(commands)
      if (commands(i)%command /= 'save') cycle
      yes = yes .or. last_part(path) == last_part(file_of(base, commands(i)%text))
    end do
  end function is_written

  !> A path without its folder.
  pure function last_part(path) result(name)
    character(*), intent(in) :: path !! any path
    character(:), allocatable :: name

    name = path(index(path, '/', back=.true.) + 1:)
  end function last_part

  !> DISP and REAC need at least one node to print, STRE an element or a node.
  subroutine check_nodes(deck, commands, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(batch_command_t), intent(in) :: commands(:) !! its solution commands
    type(mesh_t), intent(in) :: mesh !! the complete mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: names, noun
    logical, allocatable :: there(:)
    integer :: i, first, last, stride

    do i = 1, size(commands)
      if (.not. any(commands(i)%command == ['disp', 'reac', 'stre'])) cycle
      there = mesh%defined
      noun = 'node'
      if (commands(i)%command == 'stre' .and. commands(i)%option /= 'node') then
        there = mesh%ix(1, :mesh%elements) > 0
        noun = 'element'
      end if
      call numbers_to_print(commands(i), size(there), first, last, stride)
      if (any(there(first:min(last, size(there)):stride))) cycle
      names = noun//' '//to_text(first)//' does not exist'
      if (last /= first) names = 'there is no '//noun//' from '//to_text(first)//' to '// &
        to_text(last)//' in steps of '//to_text(stride)
      call report_error(diagnostics, item_location(deck%batch(i)%head, 3), names, &
        'the mesh has '//to_text(count(there))//' '//noun//'s, the highest number is '// &
        to_text(size(there)))
    end do
  end subroutine check_nodes
end module batch_checks

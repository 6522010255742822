!> Turns the solution commands of the deck into a checked list.
module batch_reader
  use kinds, only: wp
  use text, only: to_text, lower
  use deck_types, only: deck_t, data_set_t, record_t, location_t, item_word, item_quoted
  use records, only: item_location, item_count
  use diagnostics, only: diagnostics_t, report_error
  use batch_types, only: batch_command_t
  implicit none
  private
  public :: read_batch

contains

  !> Reads all solution commands; the list is complete even if some of them are wrong.
  subroutine read_batch(deck, diagnostics, commands)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(batch_command_t), allocatable, intent(out) :: commands(:) !! the commands
    integer :: i
    logical :: has_increment

    allocate (commands(size(deck%batch)))
    has_increment = .false.
    do i = 1, size(commands)
      commands(i) = command_of(deck%batch(i))
      call check_command(commands(i), deck%batch(i)%head, has_increment, diagnostics)
    end do
    call pair_loops(diagnostics, commands)
  end subroutine read_batch

  !> The fields of one command.
  pure function command_of(set) result(command)
    type(data_set_t), intent(in) :: set !! the command
    type(batch_command_t) :: command
    integer :: i

    command%command = set%command
    command%at = set%head%at
    if (item_count(set%head) > 1) then
      associate (item => set%head%items(2))
        if (item%kind == item_word .or. item%kind == item_quoted) then
          command%option = lower(item%text)
        end if
      end associate
    end if
    do i = 1, min(3, item_count(set%head) - 2)
      command%v(i) = set%head%items(i + 2)%value
    end do
  end function command_of

  !> Checks the values of one command, and that time can advance where it must.
  subroutine check_command(command, head, has_increment, diagnostics)
    type(batch_command_t), intent(in) :: command !! the command
    type(record_t), intent(in) :: head !! its record
    logical, intent(inout) :: has_increment !! a DT stands before
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    select case (command%command)
    case ('dt')
      has_increment = .true.
      if (command%v(1) > 0.0_wp) return
      call report_error(diagnostics, value_at(head), 'the time increment is '// &
        to_text(command%v(1)), 'write DT,, and a value above 0')
    case ('step', 'loop')
      if (command%v(1) < 1.0_wp) then
        call report_error(diagnostics, value_at(head), trim(command%command)//' counts to '// &
          to_text(command%v(1)), 'write '//trim(command%command)//',,n with n of 1 or more')
      end if
      if (command%command == 'step') call check_increment(command, has_increment, diagnostics)
    case ('time')
      call check_increment(command, has_increment, diagnostics)
      if (command%v(1) < 0.0_wp) then
        call report_error(diagnostics, value_at(head), 'time ends at '// &
          to_text(command%v(1)), 'time starts at 0: write TIME,, and a value above 0')
      end if
    case ('tol')
      if (command%v(1) > 0.0_wp) return
      call report_error(diagnostics, value_at(head), 'the tolerance is '// &
        to_text(command%v(1)), 'write TOL,, or TOL,RESI, and a value above 0')
    case default
      return
    end select
  end subroutine check_command

  !> Place of the first value of a command, or of the command where there is none.
  pure type(location_t) function value_at(head) result(at)
    type(record_t), intent(in) :: head !! the command's record

    at = head%at
    if (item_count(head) > 2) at = item_location(head, 3)
  end function value_at

  !> Time can advance only when DT has been given.
  subroutine check_increment(command, has_increment, diagnostics)
    type(batch_command_t), intent(in) :: command !! the command
    logical, intent(in) :: has_increment !! a DT stands before
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (has_increment) return
    call report_error(diagnostics, command%at, 'no time increment has been given', &
      'write DT,, and a value before it')
  end subroutine check_increment

  !> Finds the NEXT of each LOOP.
  subroutine pair_loops(diagnostics, commands)
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(batch_command_t), intent(inout) :: commands(:) !! the commands
    integer, allocatable :: started(:)
    integer :: i, depth

    allocate (started(size(commands)))
    depth = 0
    do i = 1, size(commands)
      if (commands(i)%command == 'loop') then
        depth = depth + 1
        started(depth) = i
      else if (commands(i)%command == 'next') then
        if (depth == 0) then
          call report_error(diagnostics, commands(i)%at, 'NEXT without LOOP', &
            'write LOOP,,n before it, or delete it')
          cycle
        end if
        commands(i)%partner = started(depth)
        commands(started(depth))%partner = i
        depth = depth - 1
      end if
    end do
    do i = 1, depth
      call report_error(diagnostics, commands(started(i))%at, 'LOOP without NEXT', &
        'write NEXT behind the commands to repeat')
    end do
  end subroutine pair_loops
end module batch_reader

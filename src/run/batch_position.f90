!> Where a run stands in the commands of BATCh, and which of its end times a restart passes over.
module batch_position
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use batch_types, only: batch_command_t
  implicit none
  private
  public :: check_increment, position_t, is_passing, pass_end_time, look_for, end_times_to_pass, &
    count_steps

  !> Times count as equal when they differ by less than this share.
  real(wp), parameter :: same_time = 1.0e-9_wp

  !> The place in the batch, counted in end times.
  type :: position_t
    real(wp) :: clock = 0.0_wp !! time of the last end time, solved or passed over
    integer :: passed = 0 !! end times so far, solved or passed over
    integer :: skip = 0 !! end times that are passed over
    logical :: found = .false. !! in a rehearsal: no need to go on
    integer :: step = 0 !! step that is looked for, 0 for none
    real(wp) :: time = 0.0_wp !! its time
    logical :: beyond = .false. !! an end time has been later than that
    integer :: up_to_time = 0 !! end times before that one
  end type position_t

contains

  !> Number of rows the deck will write, for the progress line; loops count in full.
  pure integer function count_steps(commands) result(steps)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    integer :: i, times, factor(size(commands))
    integer(int64) :: n

    n = 0
    factor = 1
    times = 1
    do i = 1, size(commands)
      select case (commands(i)%command)
      case ('loop')
        factor(i) = max(1, min(nint(commands(i)%v(1)), huge(1)/max(1, 2*times)))
        times = times*factor(i)
      case ('next')
        times = times/factor(commands(i)%partner)
      case ('step')
        n = n + int(times, int64)*nint(commands(i)%v(1))
      case ('time')
        n = n + times
      case ('back')
        n = max(0_int64, n - times)
      case default
        cycle
      end select
    end do
    steps = int(min(n, int(huge(1), int64)))
  end function count_steps

  !> An increment has to move the time: by what the tables show (13 digits), so that a 1024th of it,
  !! the shortest that it is cut to, is more than round-off.
  subroutine check_increment(increment, clock, error)
    real(wp), intent(in) :: increment !! DT
    real(wp), intent(in) :: clock !! the last end time
    type(error_t), allocatable, intent(out) :: error !! it is too short
    real(wp), parameter :: shortest = 1.0e-11_wp

    if (increment > shortest*abs(clock)) return
    call raise(error, exit_deck, 'error: DT = '//to_text(increment)//' does not move the '// &
      'time '//to_text(clock, 12)//' any more: times have 13 digits'//new_line('a')// &
      '  give it a larger DT, or let the times of the deck begin near 0; everything up to time '// &
      to_text(clock, 12)//' is on disk')
  end subroutine check_increment

  !> A position that passes over everything until it has found where a state belongs.
  pure function look_for(step, time) result(position)
    integer, intent(in) :: step !! step of the state
    real(wp), intent(in) :: time !! its time
    type(position_t) :: position

    position%skip = huge(1)
    position%step = step
    position%time = time
  end function look_for

  !> Whether the next end time is passed over.
  pure logical function is_passing(position) result(passing)
    type(position_t), intent(in) :: position !! where the run stands

    passing = position%passed < position%skip
  end function is_passing

  !> Counts an end time.
  pure subroutine pass_end_time(position, time)
    type(position_t), intent(inout) :: position !! moved on
    real(wp), intent(in) :: time !! the end time
    real(wp) :: margin

    position%passed = position%passed + 1
    position%clock = time
    if (position%step == 0) return
    margin = same_time*max(abs(time), abs(position%time))
    if (position%passed == position%step .and. abs(time - position%time) <= margin) then
      position%up_to_time = position%passed
      position%found = .true.
      return
    end if
    if (time > position%time + margin) position%beyond = .true.
    if (.not. position%beyond) position%up_to_time = position%passed
    position%found = position%beyond .and. position%passed >= position%step
  end subroutine pass_end_time

  !> What a rehearsal has found: all end times up to the one with the step and the time of the
  !! state; if there is none (another DT, say), all that are not later than the state.
  pure integer function end_times_to_pass(position) result(n)
    type(position_t), intent(in) :: position !! after a rehearsal

    n = position%up_to_time
  end function end_times_to_pass
end module batch_position

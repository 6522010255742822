!> SIGINT and SIGTERM ask the run to stop; the run looks here, closes its files and ends.
!!
!! A second signal of the same kind ends the program at once, for runs that hang in a factorisation.
!! SIGXFSZ (a file may not grow any more) is ignored: the write that fails then says so.
module signals
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_funptr, c_funloc, &
    c_null_funptr
  use errors, only: exit_interrupted, exit_terminated
  implicit none
  private
  public :: catch_signals, stop_requested, stop_exit_code

  integer(c_int), parameter :: signal_interrupt = 2_c_int !! SIGINT
  integer(c_int), parameter :: signal_terminate = 15_c_int !! SIGTERM
  integer(c_int), parameter :: signal_file_size = 25_c_int !! SIGXFSZ
  integer(c_intptr_t), parameter :: ignore = 1_c_intptr_t !! SIG_IGN

  !> The stop flag, the only module variable of the program: a signal handler has no arguments.
  integer(c_int), volatile :: caught = 0_c_int

  interface
    !> C's signal: sets the handler and returns the one before.
    function c_signal(number, handler) bind(c, name='signal') result(before)
      import :: c_int, c_funptr
      implicit none
      integer(c_int), value :: number !! signal number
      type(c_funptr), value :: handler !! new handler
      type(c_funptr) :: before
    end function c_signal
  end interface

contains

  !> From now on SIGINT and SIGTERM set the stop flag, and no file limit ends the program.
  subroutine catch_signals()
    type(c_funptr) :: before

    caught = 0_c_int
    before = c_signal(signal_interrupt, c_funloc(handle_signal))
    before = c_signal(signal_terminate, c_funloc(handle_signal))
    before = c_signal(signal_file_size, transfer(ignore, c_null_funptr))
  end subroutine catch_signals

  !> Whether a signal has asked the run to stop.
  logical function stop_requested() result(yes)
    yes = caught /= 0_c_int
  end function stop_requested

  !> The exit code that belongs to the signal; 0 without one.
  integer function stop_exit_code() result(code)
    select case (caught)
    case (0_c_int)
      code = 0
    case (signal_interrupt)
      code = exit_interrupted
    case default
      code = exit_terminated
    end select
  end function stop_exit_code

  !> Keeps the signal's number, and lets the next one of this kind end the program.
  subroutine handle_signal(number) bind(c)
    integer(c_int), value :: number !! signal number
    type(c_funptr) :: before

    caught = number
    before = c_signal(number, c_null_funptr)
  end subroutine handle_signal
end module signals

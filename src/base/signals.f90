!> SIGINT, SIGTERM, SIGHUP and SIGXCPU ask the run to stop; the run looks here, closes its files
!! and ends.
!!
!! A run that does not look for a second, inside a factorisation say, is ended from the alarm's
!! handler: between `begin_writing` and `end_writing` the handler waits, at all other times the
!! files are complete. So a signal ends a run at any time. A second one does not wait for the alarm.
!! SIGXFSZ (a file may not grow any more) and SIGPIPE (nobody reads what is printed) are ignored:
!! the write that fails then says so, or does not matter.
!!
!! The run looks (`stop_requested`) before each end time (batch_steps), TANG (batch_tangent),
!! variant (study_run) and iteration (newton), and after each round of multipliers. `raise_outcome`
!! of stepping makes an error of it, session closes the files, and the program ends with its code.
module signals
  use, intrinsic :: iso_c_binding, only: c_int, c_intptr_t, c_funptr, c_funloc, c_null_funptr, &
    c_char, c_size_t, c_long
  use errors, only: exit_hung_up, exit_interrupted, exit_terminated, exit_out_of_time
  implicit none
  private
  public :: catch_signals, stop_requested, stop_exit_code, begin_writing, end_writing, &
    note_log, last_words

  integer(c_int), parameter :: signal_hang_up = 1_c_int !! SIGHUP
  integer(c_int), parameter :: signal_interrupt = 2_c_int !! SIGINT
  integer(c_int), parameter :: signal_pipe = 13_c_int !! SIGPIPE
  integer(c_int), parameter :: signal_alarm = 14_c_int !! SIGALRM
  integer(c_int), parameter :: signal_terminate = 15_c_int !! SIGTERM
  integer(c_int), parameter :: signal_time = 24_c_int !! SIGXCPU: `ulimit -St`
  integer(c_int), parameter :: signal_file_size = 25_c_int !! SIGXFSZ
  integer(c_intptr_t), parameter :: ignore = 1_c_intptr_t !! SIG_IGN
  integer(c_int), parameter :: standard_error = 2_c_int !! its descriptor
  !> Seconds that a run has to end by itself.
  integer(c_int), parameter :: seconds_to_end = 1_c_int

  character(*, c_char), parameter :: stopped = 'stopped by a signal'
  character(*, c_char), parameter :: in_order = &
    '; the files end with the last converged increment'

  ! Module variables, as a signal handler has no arguments.
  integer(c_int), volatile :: caught = 0_c_int !! the signal that asks the run to stop
  integer(c_int), volatile :: writing = 0_c_int !! files are being written, so many levels deep
  integer(c_int), volatile :: log_descriptor = -1_c_int !! of the log while it is open

  interface
    !> C's signal: sets the handler and returns the one before.
    function c_signal(number, handler) bind(c, name='signal') result(before)
      import :: c_int, c_funptr
      implicit none
      integer(c_int), value :: number !! signal number
      type(c_funptr), value :: handler !! new handler
      type(c_funptr) :: before
    end function c_signal

    !> C's alarm: SIGALRM comes after so many seconds.
    function c_alarm(seconds) bind(c, name='alarm') result(left)
      import :: c_int
      implicit none
      integer(c_int), value :: seconds !! from now
      integer(c_int) :: left
    end function c_alarm

    !> C's write: bytes to an open file; it may be called from a signal handler.
    function c_write(descriptor, bytes, count) bind(c, name='write') result(written)
      import :: c_int, c_char, c_size_t, c_long
      implicit none
      integer(c_int), value :: descriptor !! the file
      character(kind=c_char), intent(in) :: bytes(*) !! what to write
      integer(c_size_t), value :: count !! how many
      integer(c_long) :: written
    end function c_write

    !> C's _exit: ends at once; it may be called from a signal handler.
    subroutine c_end_now(code) bind(c, name='_exit')
      import :: c_int
      implicit none
      integer(c_int), value :: code !! exit code
    end subroutine c_end_now
  end interface

contains

  !> From now on signals set the stop flag, and no file limit or closed pipe ends the program. A
  !! hang-up that was ignored (nohup) stays so.
  subroutine catch_signals()
    type(c_funptr) :: before

    caught = 0_c_int
    before = c_signal(signal_interrupt, c_funloc(handle_signal))
    before = c_signal(signal_terminate, c_funloc(handle_signal))
    before = c_signal(signal_time, c_funloc(handle_signal))
    before = c_signal(signal_hang_up, c_funloc(handle_signal))
    if (transfer(before, ignore) == ignore) before = c_signal(signal_hang_up, before)
    before = c_signal(signal_alarm, c_funloc(handle_alarm))
    before = c_signal(signal_file_size, transfer(ignore, c_null_funptr))
    before = c_signal(signal_pipe, transfer(ignore, c_null_funptr))
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
    case (signal_hang_up)
      code = exit_hung_up
    case (signal_time)
      code = exit_out_of_time
    case default
      code = exit_terminated
    end select
  end function stop_exit_code

  !> From here to end_writing no signal ends the program: the files are not complete.
  subroutine begin_writing()
    writing = writing + 1_c_int
  end subroutine begin_writing

  !> The files are complete again.
  subroutine end_writing()
    writing = max(0_c_int, writing - 1_c_int)
  end subroutine end_writing

  !> Tells where the log is, so that it can say why it ends; -1 when it is closed.
  subroutine note_log(descriptor)
    integer(c_int), intent(in) :: descriptor !! file descriptor

    log_descriptor = descriptor
  end subroutine note_log

  !> Writes a line to standard error and to the log, without any memory.
  subroutine last_words(text)
    character(*, c_char), intent(in) :: text !! what the program ends with
    integer(c_long) :: ignored

    ignored = c_write(standard_error, text, len(text, c_size_t))
    ignored = c_write(standard_error, new_line('a'), 1_c_size_t)
    if (log_descriptor < 0_c_int) return
    ignored = c_write(log_descriptor, new_line('a'), 1_c_size_t)
    ignored = c_write(log_descriptor, text, len(text, c_size_t))
    ignored = c_write(log_descriptor, new_line('a'), 1_c_size_t)
  end subroutine last_words

  !> Keeps the signal's number and sets the alarm; a second signal is as good as the alarm.
  subroutine handle_signal(number) bind(c)
    integer(c_int), value :: number !! signal number
    integer(c_int) :: left

    if (caught /= 0_c_int) then
      call handle_alarm(signal_alarm)
    else
      caught = number
      left = c_alarm(seconds_to_end)
    end if
  end subroutine handle_signal

  !> Ends the program if the files are complete; else looks again later.
  subroutine handle_alarm(number) bind(c)
    integer(c_int), value :: number !! SIGALRM
    integer(c_int) :: left

    if (number /= signal_alarm .or. caught == 0_c_int) return
    if (writing > 0_c_int) then
      left = c_alarm(seconds_to_end)
      return
    end if
    if (log_descriptor < 0_c_int) then
      call last_words(stopped)
    else
      call last_words(stopped//in_order)
    end if
    call c_end_now(int(stop_exit_code(), c_int))
  end subroutine handle_alarm
end module signals

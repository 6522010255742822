!> The one way by which a procedure says that it could not do its work.
!!
!! `type(error_t), allocatable, intent(out) :: error` is the last argument of whatever can fail; the
!! caller returns at once `if (allocated(error))`. Only the main program prints an error and ends.
module errors
  implicit none
  private
  public :: error_t, raise
  public :: exit_done, exit_deck, exit_no_convergence, exit_resources, exit_hung_up, &
    exit_interrupted, exit_terminated, exit_out_of_time

  !> Exit codes of the program (doc/manual, "Command line").
  integer, parameter :: exit_done = 0
  integer, parameter :: exit_deck = 1
  integer, parameter :: exit_no_convergence = 2
  integer, parameter :: exit_resources = 3
  integer, parameter :: exit_hung_up = 129
  integer, parameter :: exit_interrupted = 130
  integer, parameter :: exit_terminated = 143
  integer, parameter :: exit_out_of_time = 152

  !> What went wrong, where, and what to do about it.
  type :: error_t
    integer :: code = exit_deck !! exit code the program ends with
    character(:), allocatable :: message !! complete text; may hold several lines
    logical :: at_once = .false. !! libraries are not asked to end: they would wait for ever
  end type error_t

contains

  !> Fills `error` with an exit code and a message.
  subroutine raise(error, code, message)
    type(error_t), allocatable, intent(out) :: error !! the error to report
    integer, intent(in) :: code !! one of the exit codes above
    character(*), intent(in) :: message !! what, where, what to do; lines parted by new_line('a')

    allocate (error)
    error%code = code
    error%message = message
  end subroutine raise
end module errors

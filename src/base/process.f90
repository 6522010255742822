!> Ends the process with an exit code and without a word (Fortran's stop prints to standard error).
module process
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  implicit none
  private
  public :: end_process

  interface
    !> C's exit.
    subroutine c_exit(status) bind(c, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: status !! exit code
    end subroutine c_exit
  end interface

contains

  !> Flushes standard output and standard error, and ends.
  subroutine end_process(code)
    integer, intent(in) :: code !! exit code

    flush (output_unit)
    flush (error_unit)
    call c_exit(int(code, c_int))
  end subroutine end_process
end module process

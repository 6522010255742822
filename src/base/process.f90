!> The process as the system sees it: its memory, and its end with an exit code and without a word
!! (Fortran's stop prints to standard error).
module process
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  implicit none
  private
  public :: end_process, keep_memory

  ! Options of glibc's mallopt (malloc.h)
  integer(c_int), parameter :: trim_threshold = -1_c_int
  integer(c_int), parameter :: top_pad = -2_c_int
  integer(c_int), parameter :: mmap_threshold = -3_c_int
  !> Blocks up to this size come from the heap, and so much of it is kept when it is free [bytes].
  integer(c_int), parameter :: kept_bytes = 1073741824_c_int
  !> The heap grows by this much at a time [bytes].
  integer(c_int), parameter :: growth_bytes = 67108864_c_int

  interface
    !> C's exit.
    subroutine c_exit(status) bind(c, name='exit')
      import :: c_int
      implicit none
      integer(c_int), value :: status !! exit code
    end subroutine c_exit

    !> glibc's mallopt: 1 when the option was taken.
    integer(c_int) function c_mallopt(option, value) bind(c, name='mallopt')
      import :: c_int
      implicit none
      integer(c_int), value :: option !! which option
      integer(c_int), value :: value !! its value
    end function c_mallopt
  end interface

contains

  !> Keeps freed memory for the next factorisation instead of giving it back to the system, which
  !! costs a quarter of the time of a run with many large factors.
  subroutine keep_memory()
    integer(c_int) :: taken

    taken = c_mallopt(mmap_threshold, kept_bytes)
    if (taken == 1_c_int) taken = c_mallopt(trim_threshold, kept_bytes)
    if (taken == 1_c_int) taken = c_mallopt(top_pad, growth_bytes)
  end subroutine keep_memory

  !> Flushes standard output and standard error, and ends.
  subroutine end_process(code)
    integer, intent(in) :: code !! exit code

    flush (output_unit)
    flush (error_unit)
    call c_exit(int(code, c_int))
  end subroutine end_process
end module process

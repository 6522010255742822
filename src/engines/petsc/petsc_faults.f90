!> The first error that a routine of PETSc or MPI has returned (doc/theory, "Iterative solution in
!! parallel").
module petsc_faults
  use, intrinsic :: iso_c_binding, only: c_int
  implicit none
  private
  public :: note

contains

  !> Keeps the first error.
  pure subroutine note(fault, status)
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int), intent(in) :: status !! what a routine has returned

    if (fault == 0_c_int) fault = status
  end subroutine note
end module petsc_faults

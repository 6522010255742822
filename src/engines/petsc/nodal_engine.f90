!> The back end that takes its matrix by nodes: PETSc.
module nodal_engine
  use back_ends, only: back_end_t
  use petsc_solver, only: petsc_t
  implicit none
  private
  public :: has_nodal_engine, start_nodal_engine

contains

  !> This program has it.
  pure logical function has_nodal_engine() result(has)
    has = .true.
  end function has_nodal_engine

  !> Makes it.
  subroutine start_nodal_engine(engine)
    class(back_end_t), allocatable, intent(out) :: engine !! it

    allocate (petsc_t :: engine)
  end subroutine start_nodal_engine
end module nodal_engine

!> The back ends of this program: those of one machine, and PETSc.
module engines
  use back_ends, only: back_end_t
  use umfpack_solver, only: umfpack_t
  use cholmod_solver, only: cholmod_t
  use petsc_solver, only: petsc_t
  implicit none
  private
  public :: has_engine, start_engine

contains

  !> This program has a back end.
  pure logical function has_engine(name) result(has)
    character(*), intent(in) :: name !! UMFPACK, CHOLMOD, PETSC

    has = name == 'UMFPACK' .or. name == 'CHOLMOD' .or. name == 'PETSC'
  end function has_engine

  !> Makes a back end.
  subroutine start_engine(name, engine)
    character(*), intent(in) :: name !! one that there is
    class(back_end_t), allocatable, intent(out) :: engine !! it

    select case (name)
    case ('PETSC')
      allocate (petsc_t :: engine)
    case ('CHOLMOD')
      allocate (cholmod_t :: engine)
    case default
      allocate (umfpack_t :: engine)
    end select
  end subroutine start_engine
end module engines

!> The back ends: each one's words, and how it is made. One that takes its matrix by nodes belongs
!! to another program, mfec-petsc; this one knows its word.
module engines
  use text, only: upper
  use back_ends, only: back_end_t, solver_words_t, n_back_ends, solver_cholmod, solver_petsc
  use umfpack_solver, only: umfpack_t, umfpack_words
  use cholmod_solver, only: cholmod_t, cholmod_words
  use nodal_engine, only: has_nodal_engine, start_nodal_engine
  implicit none
  private
  public :: back_end_words, has_engine, start_engine, engine_name

  type(solver_words_t), parameter :: petsc_words = solver_words_t('PETSc', &
    'iterates; mfec-petsc alone has it', &
    'PETSc, GMRES on multigrid of the bulk and a factor of what contact holds')

  !> All of them, in the order of their numbers.
  type(solver_words_t), parameter :: back_end_words(n_back_ends) = [umfpack_words, cholmod_words, &
    petsc_words]

contains

  !> This program has a back end.
  pure logical function has_engine(k) result(has)
    integer, intent(in) :: k !! its place in the list

    has = k /= solver_petsc .or. has_nodal_engine()
  end function has_engine

  !> Makes a back end.
  subroutine start_engine(k, engine)
    integer, intent(in) :: k !! its place in the list; there is one
    class(back_end_t), allocatable, intent(out) :: engine !! it

    select case (k)
    case (solver_petsc)
      call start_nodal_engine(engine)
    case (solver_cholmod)
      allocate (cholmod_t :: engine)
    case default
      allocate (umfpack_t :: engine)
    end select
  end subroutine start_engine

  !> Its name in logs and tables.
  pure function engine_name(k) result(name)
    integer, intent(in) :: k !! its place in the list
    character(:), allocatable :: name

    name = upper(trim(back_end_words(k)%word))
  end function engine_name
end module engines

!> The one linear solver that Newton and the line search call: UMFPACK for unsymmetric systems,
!! CHOLMOD for symmetric ones, whichever the matrix at hand and the user allow.
module linear_solver
  use kinds, only: wp
  use text, only: lower
  use costs, only: cost_t
  use csc_matrix, only: csc_matrix_t
  use umfpack_solver, only: umfpack_t, forget_pattern, factorise, solve, drop_factor, &
    free_umfpack, solver_done, solver_out_of_memory
  use cholmod_solver, only: cholmod_t, forget_symmetric, factorise_symmetric, solve_symmetric, &
    drop_symmetric_factor, free_cholmod, solver_not_definite
  implicit none
  private
  public :: linear_solver_t, factorise_matrix, solve_system, start_pattern, solver_name, &
    free_solver, solver_of
  public :: solver_unknown, solver_auto, solver_umfpack, solver_cholmod, solver_reduced

  !> What SOLVer and --solver ask for.
  integer, parameter :: solver_unknown = -1
  integer, parameter :: solver_auto = 0
  integer, parameter :: solver_umfpack = 1
  integer, parameter :: solver_cholmod = 2
  integer, parameter :: solver_reduced = 3

  !> Both back ends; each keeps its analysis while the pattern holds, one of them has the factor.
  type :: linear_solver_t
    type(umfpack_t) :: umfpack !! unsymmetric
    type(cholmod_t) :: cholmod !! symmetric
    logical :: symmetric_allowed = .true. !! CHOLMOD takes symmetric matrices
    integer :: holds = solver_unknown !! back end with the factor, unknown if there is none
    logical :: indefinite = .false. !! the last matrix was symmetric, but not positive definite
  end type linear_solver_t

contains

  !> Factorises, unless the values are those of the factor at hand. A symmetric matrix that is not
  !! positive definite goes to UMFPACK.
  subroutine factorise_matrix(solver, a, symmetric, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(inout) :: a !! matrix; is marked as unchanged
    logical, intent(in) :: symmetric !! its values are symmetric
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    outcome = solver_done
    if (.not. a%changed .and. solver%holds /= solver_unknown) return
    a%changed = .false.
    solver%indefinite = .false.
    if (symmetric .and. solver%symmetric_allowed) then
      if (solver%holds == solver_umfpack) call drop_factor(solver%umfpack)
      solver%holds = solver_unknown
      call factorise_symmetric(solver%cholmod, a, costs, outcome)
      if (outcome == solver_done) solver%holds = solver_cholmod
      if (outcome /= solver_not_definite) return
      solver%indefinite = .true.
    end if
    if (solver%holds /= solver_umfpack) call drop_symmetric_factor(solver%cholmod)
    solver%holds = solver_unknown
    call factorise(solver%umfpack, a, costs, outcome)
    if (outcome == solver_done) solver%holds = solver_umfpack
  end subroutine factorise_matrix

  !> x = A^-1 b with the last factor.
  subroutine solve_system(solver, a, b, x, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in) :: a !! the matrix that was factorised
    real(wp), intent(in), contiguous :: b(:) !! (n) right-hand side
    real(wp), intent(inout), contiguous :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    if (solver%holds == solver_cholmod) then
      call solve_symmetric(solver%cholmod, b, x, costs, outcome)
    else
      call solve(solver%umfpack, a, b, x, costs, outcome)
    end if
  end subroutine solve_system

  !> Drops analyses and factors: the pattern has changed.
  subroutine start_pattern(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles

    call forget_pattern(solver%umfpack)
    call forget_symmetric(solver%cholmod)
    solver%holds = solver_unknown
  end subroutine start_pattern

  !> Name of the back end that has the factor.
  pure function solver_name(solver) result(name)
    type(linear_solver_t), intent(in) :: solver !! handles
    character(:), allocatable :: name

    select case (solver%holds)
    case (solver_umfpack)
      name = 'UMFPACK'
    case (solver_cholmod)
      name = 'CHOLMOD'
    case default
      name = 'none'
    end select
  end function solver_name

  !> The solver that a word of SOLVer or --solver means; four letters count.
  pure integer function solver_of(word) result(solver)
    character(*), intent(in) :: word !! AUTO, UMFPack, CHOLmod, REDUced
    character(4) :: short

    short = lower(word)
    select case (short)
    case ('auto')
      solver = solver_auto
    case ('umfp')
      solver = solver_umfpack
    case ('chol')
      solver = solver_cholmod
    case ('redu')
      solver = solver_reduced
    case default
      solver = solver_unknown
    end select
  end function solver_of

  !> Releases everything.
  subroutine free_solver(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles

    call free_umfpack(solver%umfpack)
    call free_cholmod(solver%cholmod)
    solver%holds = solver_unknown
  end subroutine free_solver
end module linear_solver

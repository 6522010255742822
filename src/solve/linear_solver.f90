!> The one linear solver that Newton and the line search call: UMFPACK for unsymmetric systems,
!! CHOLMOD for symmetric ones, whichever the matrix at hand and the user allow.
module linear_solver
  use kinds, only: wp
  use memory, only: memory_left
  use threads, only: count_threads
  use blas_info, only: set_blas_threads
  use text, only: lower
  use costs, only: cost_t
  use csc_matrix, only: csc_matrix_t
  use umfpack_solver, only: umfpack_t, forget_pattern, drop_factor, analyse, is_analysed, &
    factor_bytes, factorise, solve, free_umfpack, solver_done, solver_singular, &
    solver_out_of_memory
  use cholmod_solver, only: cholmod_t, forget_symmetric, drop_symmetric_factor, &
    analyse_symmetric, is_analysed_symmetric, symmetric_factor_bytes, factorise_symmetric, &
    solve_symmetric, free_cholmod, solver_not_definite
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

  !> From this size on a factor is worth several threads of the BLAS [byte].
  real(wp), parameter :: large_factor = 5.0e7_wp

  !> Both back ends; each keeps its analysis while the pattern holds, one of them has the factor.
  type :: linear_solver_t
    type(umfpack_t) :: umfpack !! unsymmetric
    type(cholmod_t) :: cholmod !! symmetric
    logical :: symmetric_allowed = .true. !! CHOLMOD takes symmetric matrices
    integer :: holds = solver_unknown !! back end with the factor, unknown if there is none
    real(wp) :: granted = 0.0_wp !! largest factor that has been found to fit [byte]
    real(wp) :: wanted = 0.0_wp !! factor that did not fit [byte]
    real(wp) :: left = 0.0_wp !! memory that was left for it [byte]
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
      call factorise_cholesky(solver, a, costs, outcome)
      if (outcome /= solver_not_definite) return
      solver%indefinite = .true.
    end if
    if (solver%holds /= solver_umfpack) call drop_symmetric_factor(solver%cholmod)
    solver%holds = solver_unknown
    call factorise_lu(solver, a, costs, outcome)
  end subroutine factorise_matrix

  !> Symmetric factor, if it fits into the memory.
  subroutine factorise_cholesky(solver, a, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in) :: a !! matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes, or not definite
    integer :: threads

    outcome = solver_done
    if (.not. is_analysed_symmetric(solver%cholmod)) then
      call analyse_symmetric(solver%cholmod, a, costs, outcome)
      if (outcome == solver_done) call ask_for_memory(solver, &
        symmetric_factor_bytes(solver%cholmod), outcome)
    end if
    if (outcome == solver_done) then
      threads = threads_for(symmetric_factor_bytes(solver%cholmod))
      if (threads > 1) call set_blas_threads(threads)
      call factorise_symmetric(solver%cholmod, a, costs, outcome)
      if (threads > 1) call set_blas_threads(1)
    end if
    if (outcome == solver_done) solver%holds = solver_cholmod
  end subroutine factorise_cholesky

  !> Unsymmetric factor, if it fits into the memory.
  subroutine factorise_lu(solver, a, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in) :: a !! matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer :: threads

    outcome = solver_done
    if (.not. is_analysed(solver%umfpack)) then
      call analyse(solver%umfpack, a, costs, outcome)
      if (outcome == solver_done) call ask_for_memory(solver, factor_bytes(solver%umfpack), outcome)
    end if
    if (outcome == solver_done) then
      threads = threads_for(factor_bytes(solver%umfpack))
      if (threads > 1) call set_blas_threads(threads)
      call factorise(solver%umfpack, a, costs, outcome)
      if (threads > 1) call set_blas_threads(1)
    end if
    if (outcome == solver_done) solver%holds = solver_umfpack
  end subroutine factorise_lu

  !> Threads of the BLAS for one factor: all of the program's if it is large, else one.
  integer function threads_for(bytes) result(n)
    real(wp), intent(in) :: bytes !! size of the factor [byte]

    n = 1
    if (bytes > large_factor) n = count_threads()
  end function threads_for

  !> Compares the memory of a coming factor with what is left, and with what an earlier factor had.
  subroutine ask_for_memory(solver, bytes, outcome)
    type(linear_solver_t), intent(inout) :: solver !! gets granted, or wanted and left
    real(wp), intent(in) :: bytes !! memory of the factor [byte]
    integer, intent(out) :: outcome !! done, or out of memory

    outcome = solver_done
    if (bytes <= solver%granted) return
    solver%left = memory_left() + solver%granted
    if (bytes > solver%left) then
      solver%wanted = bytes
      outcome = solver_out_of_memory
    else
      solver%granted = bytes
    end if
  end subroutine ask_for_memory

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
      if (outcome == solver_done .and. .not. all(abs(x) <= huge(1.0_wp))) outcome = solver_singular
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

!> The one linear solver that Newton and the line search call: the back end that the matrix at hand
!! and the user allow, CHOLMOD for symmetric matrices, UMFPACK for unsymmetric ones.
module linear_solver
  use kinds, only: wp
  use memory, only: memory_left
  use threads, only: count_threads
  use blas_info, only: set_blas_threads
  use text, only: lower
  use costs, only: cost_t
  use csc_matrix, only: csc_matrix_t
  use back_ends, only: back_end_t, solver_done, solver_out_of_memory, solver_not_definite, &
    solver_singular
  use umfpack_solver, only: umfpack_t
  use cholmod_solver, only: cholmod_t
  implicit none
  private
  public :: linear_solver_t, factorise_matrix, solve_system, start_pattern, solver_name, &
    free_solver, solver_of
  public :: solver_unknown, solver_auto, solver_umfpack, solver_cholmod, solver_reduced

  !> What SOLVer and --solver ask for; the first ones are back ends for the whole matrix.
  integer, parameter :: solver_unknown = -1
  integer, parameter :: solver_auto = 0
  integer, parameter :: solver_umfpack = 1
  integer, parameter :: solver_cholmod = 2
  integer, parameter :: solver_reduced = 3
  integer, parameter :: n_back_ends = 2
  !> Their words, of which four letters count, and the names of the back ends.
  character(7), parameter :: words(0:3) = [character(7) :: 'auto', 'umfpack', 'cholmod', 'reduced']
  character(7), parameter :: names(n_back_ends) = [character(7) :: 'UMFPACK', 'CHOLMOD']

  !> From this size on a factor is worth several threads of the BLAS [byte].
  real(wp), parameter :: large_factor = 5.0e7_wp

  !> One back end, started when it is first needed.
  type :: engine_t
    class(back_end_t), allocatable :: is !! it
  end type engine_t

  !> The back ends; each keeps its analysis while the pattern holds, one of them has the factor.
  type :: linear_solver_t
    type(engine_t) :: engine(n_back_ends) !! allocated where one has been needed
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
      call factorise_with(solver, solver_cholmod, a, costs, outcome)
      if (outcome /= solver_not_definite) return
      solver%indefinite = .true.
    end if
    call factorise_with(solver, solver_umfpack, a, costs, outcome)
  end subroutine factorise_matrix

  !> The factor of one back end, if it fits into the memory; that of another one goes first.
  subroutine factorise_with(solver, choice, a, costs, outcome)
    type(linear_solver_t), intent(inout) :: solver !! handles
    integer, intent(in) :: choice !! which one
    type(csc_matrix_t), intent(in) :: a !! matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer :: k, threads

    do k = 1, n_back_ends
      if (k /= choice .and. allocated(solver%engine(k)%is)) call solver%engine(k)%is%drop_factor()
    end do
    solver%holds = solver_unknown
    if (.not. allocated(solver%engine(choice)%is)) call start_engine(choice, solver%engine(choice))
    outcome = solver_done
    associate (engine => solver%engine(choice)%is)
      if (.not. engine%is_analysed()) then
        call engine%analyse(a, costs, outcome)
        if (outcome == solver_done) call ask_for_memory(solver, engine%factor_bytes(), outcome)
      end if
      if (outcome /= solver_done) return
      threads = threads_for(engine%factor_bytes())
      if (threads > 1) call set_blas_threads(threads)
      call engine%factorise(a, costs, outcome)
      if (threads > 1) call set_blas_threads(1)
    end associate
    if (outcome == solver_done) solver%holds = choice
  end subroutine factorise_with

  !> Makes a back end.
  subroutine start_engine(choice, engine)
    integer, intent(in) :: choice !! which one
    type(engine_t), intent(inout) :: engine !! gets it

    select case (choice)
    case (solver_cholmod)
      allocate (cholmod_t :: engine%is)
    case default
      allocate (umfpack_t :: engine%is)
    end select
  end subroutine start_engine

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

    outcome = solver_singular
    if (solver%holds == solver_unknown) return
    call solver%engine(solver%holds)%is%solve(a, b, x, costs, outcome)
  end subroutine solve_system

  !> Drops analyses and factors: the pattern has changed.
  subroutine start_pattern(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles
    integer :: k

    do k = 1, n_back_ends
      if (allocated(solver%engine(k)%is)) call solver%engine(k)%is%forget_pattern()
    end do
    solver%holds = solver_unknown
  end subroutine start_pattern

  !> Name of the back end that has the factor.
  pure function solver_name(solver) result(name)
    type(linear_solver_t), intent(in) :: solver !! handles
    character(:), allocatable :: name

    name = 'none'
    if (solver%holds /= solver_unknown) name = names(solver%holds)
  end function solver_name

  !> The solver that a word of SOLVer or --solver means; four letters count.
  pure integer function solver_of(word) result(solver)
    character(*), intent(in) :: word !! AUTO, UMFPack, CHOLmod, REDUced
    character(4) :: short
    integer :: k

    short = lower(word)
    solver = solver_unknown
    do k = lbound(words, 1), ubound(words, 1)
      if (short == words(k) (:4)) solver = k
    end do
  end function solver_of

  !> Releases everything.
  subroutine free_solver(solver)
    type(linear_solver_t), intent(inout) :: solver !! handles
    integer :: k

    do k = 1, n_back_ends
      if (allocated(solver%engine(k)%is)) call solver%engine(k)%is%free()
    end do
    solver%holds = solver_unknown
  end subroutine free_solver
end module linear_solver

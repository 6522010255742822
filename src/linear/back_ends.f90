!> What Newton's method wants of a program that solves with a whole matrix: one abstract type, the
!! outcomes of its calls, and the list of such programs that a run has started.
module back_ends
  use kinds, only: wp
  use costs, only: cost_t
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t
  implicit none
  private
  public :: back_end_t, nodal_back_end_t, linear_solver_t, nodes_t, solver_words_t
  public :: n_back_ends, solver_unknown, solver_auto, solver_umfpack, solver_cholmod, &
    solver_petsc, solver_reduced
  public :: solver_done, solver_singular, solver_out_of_memory, solver_failed, solver_not_definite

  !> The back ends for the whole matrix, in the order of engines, and what SOLVer and --solver ask
  !! for beside them.
  integer, parameter :: solver_umfpack = 1
  integer, parameter :: solver_cholmod = 2
  integer, parameter :: solver_petsc = 3
  integer, parameter :: n_back_ends = 3
  integer, parameter :: solver_unknown = -1
  integer, parameter :: solver_auto = 0
  integer, parameter :: solver_reduced = n_back_ends + 1

  !> Outcomes.
  integer, parameter :: solver_done = 0
  integer, parameter :: solver_singular = 1
  integer, parameter :: solver_out_of_memory = 2
  integer, parameter :: solver_failed = 3
  integer, parameter :: solver_not_definite = 4 !! a symmetric factor does not exist

  !> What decks, help and log say of a solver.
  type :: solver_words_t
    character(7) :: word = '' !! as SOLVer and --solver have it; four letters count
    character(72) :: use = '' !! what it does, for the help
    character(96) :: way = '' !! what it does, for the log
  end type solver_words_t

  !> What a back end may want to know of the nodes.
  type :: nodes_t
    real(wp), allocatable :: x(:, :) !! (3, nodes) reference positions [length]
    logical, allocatable :: touched(:) !! (nodes) of closed contact elements
    logical :: linear = .true. !! the tangent of the bulk is constant
    logical :: loose = .false. !! the tangent of the bulk alone is singular
    logical :: symmetric = .false. !! the tangent is symmetric
    logical :: apart = .false. !! contact's share of the tangent comes apart from the bulk's
  end type nodes_t

  !> An analysis of a pattern, which is kept while the pattern holds, and one factor.
  type, abstract :: back_end_t
    real(wp) :: accuracy = 1.0e-10_wp !! residual over right-hand side that may be left, where it
    !! iterates
  contains
    procedure(analyse_pattern), deferred :: analyse !! of the matrix
    procedure(tell), deferred :: is_analysed !! the pattern has been analysed
    procedure(count_bytes), deferred :: factor_bytes !! memory a factorisation will take
    procedure(factorise_values), deferred :: factorise !! the analysis is kept
    procedure(solve_with_factor), deferred :: solve !! with the last factor
    procedure(change), deferred :: forget_pattern !! the pattern has changed
    procedure(change), deferred :: drop_factor !! keeps the analysis
    procedure(change), deferred :: free !! releases everything
    procedure :: determinant_sign => unknown_sign !! of the last factor
  end type back_end_t

  !> One that takes its matrix by nodes; the matrices of the calls above stay empty.
  type, abstract, extends(back_end_t) :: nodal_back_end_t
  contains
    procedure(describe_nodes), deferred :: describe !! before it is factorised
    procedure(tell_nodes), deferred :: has_bulk !! it keeps the bulk's share, which came apart
    procedure(multiply_nodes), deferred :: multiply !! by that
  end type nodal_back_end_t

  !> One back end, started when it is first needed.
  type :: engine_t
    class(back_end_t), allocatable :: is !! it
  end type engine_t

  !> The back ends; each keeps its analysis while the pattern holds, one of them has the factor.
  type :: linear_solver_t
    type(engine_t) :: engine(n_back_ends) !! allocated where one has been needed
    integer :: alone = solver_unknown !! back end for all matrices; unknown: CHOLMOD for symmetric
    !! ones, UMFPACK for the others
    logical :: by_nodes = .false. !! it takes them by describe_matrix
    real(wp) :: accuracy = 1.0e-10_wp !! residual over right-hand side that the next solve may
    !! leave, where it iterates
    integer :: holds = solver_unknown !! back end with the factor, unknown if there is none
    real(wp) :: granted = 0.0_wp !! largest factor that has been found to fit [byte]
    real(wp) :: wanted = 0.0_wp !! factor that did not fit [byte]
    real(wp) :: left = 0.0_wp !! memory that was left for it [byte]
    logical :: indefinite = .false. !! the last matrix was symmetric, but not positive definite
  end type linear_solver_t

  abstract interface
    !> Takes the matrix.
    subroutine describe_nodes(solver, matrix, bulk, equation, nodes, costs)
      import :: nodal_back_end_t, nodes_t, block_matrix_t, cost_t
      class(nodal_back_end_t), intent(inout) :: solver !! handles
      type(block_matrix_t), intent(in) :: matrix !! tangent of bulk and contact; apart: contact's
      !! alone, without nodes if there is none
      type(block_matrix_t), intent(in) :: bulk !! tangent of the bulk
      integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
      type(nodes_t), intent(in) :: nodes !! what is known of the nodes
      type(cost_t), intent(inout) :: costs !! cost table
    end subroutine describe_nodes

    !> Something is so.
    logical function tell_nodes(solver)
      import :: nodal_back_end_t
      class(nodal_back_end_t), intent(in) :: solver !! handles
    end function tell_nodes

    !> y = A x, or |A| |x|, with A the bulk's share between free degrees of freedom.
    subroutine multiply_nodes(solver, equation, x, absolute, y)
      import :: nodal_back_end_t, wp
      class(nodal_back_end_t), intent(inout) :: solver !! has it
      integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
      real(wp), intent(in) :: x(:, :) !! (3, nodes)
      logical, intent(in) :: absolute !! |A| |x|
      real(wp), intent(out) :: y(:, :) !! (3, nodes) 0 where restrained
    end subroutine multiply_nodes

    !> Analyses the pattern; an older analysis is dropped.
    subroutine analyse_pattern(solver, a, costs, outcome)
      import :: back_end_t, csc_matrix_t, cost_t
      class(back_end_t), intent(inout) :: solver !! handles
      type(csc_matrix_t), intent(in), target :: a !! matrix
      type(cost_t), intent(inout) :: costs !! cost table
      integer, intent(out) :: outcome !! one of the outcomes
    end subroutine analyse_pattern

    !> Something is so.
    logical function tell(solver)
      import :: back_end_t
      class(back_end_t), intent(in) :: solver !! handles
    end function tell

    !> Memory that a factorisation will take [byte].
    real(wp) function count_bytes(solver)
      import :: back_end_t, wp
      class(back_end_t), intent(in) :: solver !! analysed
    end function count_bytes

    !> Factorises; analyses first where that is still to be done.
    subroutine factorise_values(solver, a, costs, outcome)
      import :: back_end_t, csc_matrix_t, cost_t
      class(back_end_t), intent(inout) :: solver !! handles
      type(csc_matrix_t), intent(in), target :: a !! matrix
      type(cost_t), intent(inout) :: costs !! cost table
      integer, intent(out) :: outcome !! one of the outcomes
    end subroutine factorise_values

    !> x = A^-1 b with the last factor.
    subroutine solve_with_factor(solver, a, b, x, costs, outcome)
      import :: back_end_t, csc_matrix_t, cost_t, wp
      class(back_end_t), intent(inout) :: solver !! handles
      type(csc_matrix_t), intent(in), target :: a !! the matrix that was factorised
      real(wp), intent(in), target, contiguous :: b(:) !! (n) right-hand side
      real(wp), intent(inout), target, contiguous :: x(:) !! (n) solution
      type(cost_t), intent(inout) :: costs !! cost table
      integer, intent(out) :: outcome !! one of the outcomes
    end subroutine solve_with_factor

    !> Changes what is kept.
    subroutine change(solver)
      import :: back_end_t
      class(back_end_t), intent(inout) :: solver !! handles
    end subroutine change
  end interface

contains

  !> A back end that does not know the sign of a determinant.
  integer function unknown_sign(solver) result(s)
    class(back_end_t), intent(in) :: solver !! handles

    s = merge(0, 0, solver%accuracy > 0.0_wp)
  end function unknown_sign
end module back_ends

!> The cost table: how often each kind of work was done, and how long it took.
!!
!! Tests read the counts from the log: a scene does not pay for what it does not need.
module costs
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  implicit none
  private
  public :: cost_t, begin_cost, end_cost, count_cost, keep_largest, add_costs, cost_names, &
    wall_seconds, n_costs
  public :: cost_reading, cost_search, cost_pattern, cost_bulk_tangent, cost_contact_tangent, &
    cost_residual, cost_symbolic, cost_unsymmetric_factor, cost_symmetric_factor, cost_solve, &
    cost_output, cost_fields, cost_dense_factor, cost_compliance, cost_interior, cost_audit, &
    cost_touch, cost_krylov, cost_bulk_krylov, cost_modified_newton, cost_cells, cost_multigrid, &
    cost_flush, cost_rounds, cost_weighed, cost_node_compliance, cost_longest

  !> Kinds of work.
  integer, parameter :: cost_reading = 1
  integer, parameter :: cost_search = 2
  integer, parameter :: cost_pattern = 3
  integer, parameter :: cost_bulk_tangent = 4
  integer, parameter :: cost_contact_tangent = 5
  integer, parameter :: cost_residual = 6
  integer, parameter :: cost_symbolic = 7
  integer, parameter :: cost_unsymmetric_factor = 8
  integer, parameter :: cost_symmetric_factor = 9
  integer, parameter :: cost_solve = 10
  integer, parameter :: cost_output = 11
  integer, parameter :: cost_fields = 12
  integer, parameter :: cost_dense_factor = 13
  integer, parameter :: cost_compliance = 14
  integer, parameter :: cost_interior = 15
  integer, parameter :: cost_audit = 16
  integer, parameter :: cost_touch = 17
  integer, parameter :: cost_krylov = 18
  integer, parameter :: cost_bulk_krylov = 19
  integer, parameter :: cost_modified_newton = 20
  integer, parameter :: cost_cells = 21
  integer, parameter :: cost_multigrid = 22
  integer, parameter :: cost_flush = 23
  integer, parameter :: cost_rounds = 24
  integer, parameter :: cost_weighed = 25
  integer, parameter :: cost_node_compliance = 26
  integer, parameter :: cost_longest = 27
  integer, parameter :: n_costs = 27

  !> Names of the rows, in the order of the constants.
  character(28), parameter :: cost_names(n_costs) = [character(28) :: 'reading and meshing', &
    'contact search', 'matrix pattern', 'bulk tangent', 'contact tangent', 'residual', &
    'symbolic factorisation', 'unsymmetric factorisation', 'symmetric factorisation', 'solve', &
    'output', 'output fields', 'dense factorisation', 'compliance columns', &
    'recovery of interior dofs', 'audit', 'contact initiations', 'GMRES iterations', &
    'GMRES iterations, bulk', 'modified Newton steps', 'segmented facets', &
    'set-ups of multigrid', 'flushes of results', 'mortar iterations', 'mortar weights made', &
    'mortar compliances', 'most iterations of a solve']

  !> Counts and wall-clock seconds of one run.
  type :: cost_t
    integer(int64) :: count(n_costs) = 0_int64 !! how often
    real(wp) :: seconds(n_costs) = 0.0_wp !! how long [s]
    real(wp) :: started(n_costs) = 0.0_wp !! clock at the last begin_cost [s]
  end type cost_t

contains

  !> Wall clock [s] from an arbitrary start.
  real(wp) function wall_seconds() result(t)
    integer(int64) :: ticks, rate

    call system_clock(ticks, rate)
    t = real(ticks, wp)/real(rate, wp)
  end function wall_seconds

  !> Starts the clock of one kind of work.
  subroutine begin_cost(costs, what)
    type(cost_t), intent(inout) :: costs !! the table
    integer, intent(in) :: what !! kind of work

    costs%started(what) = wall_seconds()
  end subroutine begin_cost

  !> Stops the clock of one kind of work and counts it.
  subroutine end_cost(costs, what)
    type(cost_t), intent(inout) :: costs !! the table
    integer, intent(in) :: what !! kind of work

    costs%count(what) = costs%count(what) + 1
    costs%seconds(what) = costs%seconds(what) + wall_seconds() - costs%started(what)
  end subroutine end_cost

  !> Adds the counts and seconds of another table: what several threads did at the same time is
  !! summed.
  subroutine add_costs(costs, other)
    type(cost_t), intent(inout) :: costs !! the table
    type(cost_t), intent(in) :: other !! the other

    costs%count = costs%count + other%count
    costs%seconds = costs%seconds + other%seconds
  end subroutine add_costs

  !> Keeps the largest number of times that something was done at once.
  subroutine keep_largest(costs, what, n)
    type(cost_t), intent(inout) :: costs !! the table
    integer, intent(in) :: what !! kind of work
    integer, intent(in) :: n !! how often this time

    costs%count(what) = max(costs%count(what), int(n, int64))
  end subroutine keep_largest

  !> Counts work without a clock.
  subroutine count_cost(costs, what, n)
    type(cost_t), intent(inout) :: costs !! the table
    integer, intent(in) :: what !! kind of work
    integer, intent(in) :: n !! how often

    costs%count(what) = costs%count(what) + n
  end subroutine count_cost
end module costs

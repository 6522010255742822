!> Symmetric positive definite linear systems through CHOLMOD: supernodal, METIS ordering or
!! the matrix as it is, long integers.
module cholmod_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_associated, c_loc, c_int, c_size_t, &
    c_f_pointer, c_sizeof, c_double
  use kinds, only: wp, sp, long
  use costs, only: cost_t, begin_cost, end_cost, cost_symbolic, cost_symmetric_factor, &
    cost_solve
  use supernodes, only: supernodes_t, supernodes_of, values_before, place_last
  use supernode_panels, only: split_supernodes, expand_supernodes
  use row_runs, only: gather_rows
  use csc_matrix, only: csc_matrix_t
  use back_ends, only: back_end_t, solver_words_t, solver_done, solver_singular, &
    solver_out_of_memory, solver_failed, solver_not_definite
  use cholmod_interface, only: cholmod_common_t, cholmod_sparse_t, cholmod_dense_t, &
    cholmod_factor_t, cholmod_l_start, cholmod_l_finish, cholmod_l_analyze_p, &
    cholmod_l_factorize, cholmod_l_change_factor, cholmod_l_solve2, cholmod_l_free_factor, &
    cholmod_l_free_dense, cholmod_l_realloc
  implicit none
  private
  public :: cholmod_t, analyse_in_order, analyse_nodes, expand_nodes, solve_symmetric, &
    factor_order, trailing_block, drop_trailing_block, forget_half, factor_work, make_room, &
    cholmod_words

  type(solver_words_t), parameter :: cholmod_words = solver_words_t('CHOLmod', &
    'factorises symmetric matrices (no slip with friction)', 'CHOLMOD, a symmetric factor')

  integer(c_int), parameter :: system_a = 0, ordering_natural = 0, ordering_given = 1, &
    cholmod_metis = 3, always_supernodal = 2, use_lower = -1, real_values = 1, cholmod_memory = -2
  integer(c_size_t), parameter :: usual_columns(3) = [4_c_size_t, 16_c_size_t, 48_c_size_t]

  !> Equations of a node.
  integer, parameter :: node_equations = 3

  !> Neighbouring supernodes become one of at most so many columns: the first in any case, the
  !! others if less than such a share of it would be zero, and of any number if less than the last.
  !! Products with few columns are slow, and zeros take memory.
  integer(c_size_t), parameter :: merged_columns(3) = [8_c_size_t, 32_c_size_t, 64_c_size_t]
  real(c_double), parameter :: merged_zeros(3) = [0.9_c_double, 0.1_c_double, 0.03_c_double]

  !> Handles and settings of one factorisation.
  type, extends(back_end_t) :: cholmod_t
    type(cholmod_common_t) :: common !! settings and work space
    type(c_ptr) :: factor = c_null_ptr !! analysis and factor
    type(c_ptr) :: y = c_null_ptr, e = c_null_ptr !! work space of the solution
    logical :: started = .false. !! common is in use
    logical :: definite = .false. !! the factor holds values
    real(sp), pointer, contiguous :: half(:) => null() !! its values in single precision, in place
    !! of the others
    logical :: half_inside = .false. !! they lie where the others were, in CHOLMOD's memory
  contains
    procedure :: analyse
    procedure :: is_analysed
    procedure :: factor_bytes
    procedure :: factorise
    procedure :: solve
    procedure :: forget_pattern
    procedure :: drop_factor
    procedure :: free
  end type cholmod_t

contains

  !> Starts CHOLMOD, and checks on the defaults it sets that the mirror of its structure is true.
  subroutine start(solver, outcome)
    type(cholmod_t), intent(inout) :: solver !! settings
    integer, intent(out) :: outcome !! one of the outcomes

    outcome = solver_done
    if (solver%started) return
    solver%started = cholmod_l_start(solver%common) == 1_c_int
    associate (common => solver%common)
      if (.not. solver%started .or. common%supernodal /= 1_c_int .or. common%print /= 3_c_int &
        .or. common%prefer_upper /= 1_c_int .or. common%postorder /= 1_c_int &
        .or. common%nmethods /= 0_c_int .or. common%ordering /= ordering_given &
        .or. common%status /= 0_c_int .or. any(common%nrelax /= usual_columns)) then
        outcome = solver_failed
        return
      end if
      common%print = 0_c_int
      common%quick_return = 1_c_int
      common%supernodal = always_supernodal
      common%nmethods = 1_c_int
      common%nrelax = merged_columns
      common%zrelax = merged_zeros
    end associate
  end subroutine start

  !> Forgets the values in single precision; CHOLMOD frees what lies in its memory.
  subroutine forget_half(solver)
    class(cholmod_t), intent(inout) :: solver !! handles

    if (associated(solver%half) .and. .not. solver%half_inside) deallocate (solver%half)
    nullify (solver%half)
    solver%half_inside = .false.
  end subroutine forget_half

  !> Drops analysis and factor: the pattern has changed.
  subroutine forget_pattern(solver)
    class(cholmod_t), intent(inout) :: solver !! handles
    integer(c_int) :: status

    solver%definite = .false.
    call forget_half(solver)
    if (c_associated(solver%factor)) status = cholmod_l_free_factor(solver%factor, solver%common)
    solver%factor = c_null_ptr
  end subroutine forget_pattern

  !> Releases the values of the factor and keeps the analysis.
  subroutine drop_factor(solver)
    class(cholmod_t), intent(inout) :: solver !! handles
    integer(c_int) :: status

    solver%definite = .false.
    call forget_half(solver)
    if (c_associated(solver%factor)) status = cholmod_l_change_factor(0_c_int, 1_c_int, 1_c_int, &
      1_c_int, 1_c_int, solver%factor, solver%common)
  end subroutine drop_factor

  !> Analyses the pattern: ordered by METIS and postordered; a lower triangle in the order it has.
  subroutine analyse(solver, a, costs, outcome)
    class(cholmod_t), intent(inout) :: solver !! handles; an older analysis is dropped
    type(csc_matrix_t), intent(in), target :: a !! matrix; its lower triangle counts
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    call analyse_by(solver, a, merge(ordering_natural, cholmod_metis, a%lower), c_null_ptr, &
      costs, outcome)
  end subroutine analyse

  !> Analyses a pattern in an order that is given, but for its postorder.
  subroutine analyse_in_order(solver, a, order, costs, outcome)
    type(cholmod_t), intent(inout) :: solver !! handles; an older analysis is dropped
    type(csc_matrix_t), intent(in), target :: a !! matrix; its lower triangle counts
    integer(long), intent(in), target :: order(:) !! (n) the column at each place, 0-based
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    call analyse_by(solver, a, ordering_given, c_loc(order), costs, outcome)
  end subroutine analyse_in_order

  !> Analyses the graph of nodes of some equations each, in the order it has but for columns that
  !! change their places within a supernode.
  subroutine analyse_nodes(solver, graph, m, order, costs, outcome)
    type(cholmod_t), intent(inout) :: solver !! handles; an older analysis is dropped
    type(csc_matrix_t), intent(in), target :: graph !! a lower triangle
    integer, intent(in) :: m !! nodes at the end that stay
    integer, intent(out) :: order(:) !! (nodes) the node that stood at each place before
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    call analyse_by(solver, graph, ordering_natural, c_null_ptr, costs, outcome, node_equations)
    if (outcome /= solver_done) return
    call begin_cost(costs, cost_symbolic)
    call gather_rows(supernodes_of(solver%factor), m, order)
    call end_cost(costs, cost_symbolic)
  end subroutine analyse_nodes

  !> Makes the analysis of a graph that of the equations of its nodes.
  subroutine expand_nodes(solver, before, costs, outcome)
    type(cholmod_t), intent(inout) :: solver !! the graph is analysed
    integer(long), intent(in) :: before(:) !! (nodes+1) equations before those of each node
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    call begin_cost(costs, cost_symbolic)
    call expand_supernodes(solver%factor, before, solver%common)
    call end_cost(costs, cost_symbolic)
    outcome = outcome_of(solver)
    if (outcome /= solver_done) call solver%forget_pattern()
  end subroutine expand_nodes

  !> Analyses a pattern with one of CHOLMOD's orderings; all but the natural one are postordered.
  subroutine analyse_by(solver, a, ordering, order, costs, outcome, each)
    class(cholmod_t), intent(inout) :: solver !! handles; an older analysis is dropped
    type(csc_matrix_t), intent(in), target :: a !! matrix; its lower triangle counts
    integer(c_int), intent(in) :: ordering !! which
    type(c_ptr), intent(in) :: order !! the order that is given, else null
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer, intent(in), optional :: each !! equations of a column, which is a node of a graph
    type(cholmod_sparse_t) :: view

    call start(solver, outcome)
    if (outcome /= solver_done) return
    call solver%forget_pattern()
    call begin_cost(costs, cost_symbolic)
    if (present(each)) solver%common%nrelax = merged_columns/each
    call view_of(a, view)
    solver%common%ordering = ordering
    solver%common%postorder = merge(0_c_int, 1_c_int, ordering == ordering_natural)
    solver%factor = cholmod_l_analyze_p(view, order, c_null_ptr, 0_c_size_t, solver%common)
    solver%common%nrelax = merged_columns
    if (c_associated(solver%factor) .and. .not. present(each)) call split_supernodes( &
      solver%factor, solver%common)
    call end_cost(costs, cost_symbolic)
    outcome = outcome_of(solver)
    if (outcome == solver_done .and. .not. c_associated(solver%factor)) outcome = solver_failed
    if (outcome /= solver_done) call solver%forget_pattern()
  end subroutine analyse_by

  !> The pattern has been analysed.
  logical function is_analysed(solver)
    class(cholmod_t), intent(in) :: solver !! handles

    is_analysed = c_associated(solver%factor)
  end function is_analysed

  !> Memory that a factorisation will take [byte]: values and rows of the supernodes, and work space
  !! for the largest of them.
  real(wp) function factor_bytes(solver) result(bytes)
    class(cholmod_t), intent(in) :: solver !! analysed
    type(cholmod_factor_t), pointer :: factor

    call c_f_pointer(solver%factor, factor)
    bytes = 8.0_wp*(real(factor%xsize, wp) + real(factor%ssize, wp) + real(factor%maxcsize, wp))
  end function factor_bytes

  !> Factorises; the analysis is kept as long as the pattern holds.
  subroutine factorise(solver, a, costs, outcome)
    class(cholmod_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in), target :: a !! matrix; its lower triangle counts
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes, or not definite
    type(cholmod_factor_t), pointer :: factor
    type(cholmod_sparse_t) :: view
    integer(c_int) :: status

    if (.not. c_associated(solver%factor)) then
      call solver%analyse(a, costs, outcome)
      if (outcome /= solver_done) return
    end if
    call forget_half(solver)
    call view_of(a, view)
    call begin_cost(costs, cost_symmetric_factor)
    status = cholmod_l_factorize(view, solver%factor, solver%common)
    call end_cost(costs, cost_symmetric_factor)
    outcome = outcome_of(solver)
    if (outcome == solver_done .and. status /= 1_c_int) outcome = solver_failed
    call c_f_pointer(solver%factor, factor)
    if (outcome == solver_done .and. factor%minor < factor%n) outcome = solver_not_definite
    solver%definite = outcome == solver_done
  end subroutine factorise

  !> Room for the values of an analysed factor, which somebody else makes.
  subroutine make_room(solver, outcome)
    type(cholmod_t), intent(inout) :: solver !! analysed
    integer, intent(out) :: outcome !! one of the outcomes
    integer(c_int) :: status

    call forget_half(solver)
    solver%definite = .false.
    status = cholmod_l_change_factor(real_values, 1_c_int, 1_c_int, 1_c_int, 1_c_int, &
      solver%factor, solver%common)
    outcome = outcome_of(solver)
    if (outcome == solver_done .and. status /= 1_c_int) outcome = solver_failed
  end subroutine make_room

  !> x = A^-1 b with the last factor.
  subroutine solve(solver, a, b, x, costs, outcome)
    class(cholmod_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in), target :: a !! the matrix that was factorised
    real(wp), intent(in), target, contiguous :: b(:) !! (n) right-hand side
    real(wp), intent(inout), target, contiguous :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    call solve_symmetric(solver, b(:a%n), x(:a%n), costs, outcome)
    if (outcome == solver_done .and. .not. all(abs(x) <= huge(1.0_wp))) outcome = solver_singular
  end subroutine solve

  !> The same without the matrix, which CHOLMOD does not need.
  subroutine solve_symmetric(solver, b, x, costs, outcome)
    class(cholmod_t), intent(inout) :: solver !! handles
    real(wp), intent(in), target, contiguous :: b(:) !! (n) right-hand side
    real(wp), intent(inout), target, contiguous :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    type(cholmod_dense_t), target :: right, left
    type(c_ptr) :: handle
    integer(c_int) :: status

    outcome = solver_not_definite
    if (.not. solver%definite) return
    call begin_cost(costs, cost_solve)
    right%nrow = size(b, kind=c_size_t)
    right%ncol = 1_c_size_t
    right%nzmax = right%nrow
    right%d = right%nrow
    left = right
    right%x = c_loc(b)
    left%x = c_loc(x)
    handle = c_loc(left)
    status = cholmod_l_solve2(system_a, solver%factor, right, c_null_ptr, handle, c_null_ptr, &
      solver%y, solver%e, solver%common)
    call end_cost(costs, cost_solve)
    outcome = outcome_of(solver)
    if (outcome == solver_done .and. status /= 1_c_int) outcome = solver_failed
  end subroutine solve_symmetric

  !> The matrix as CHOLMOD wants it, without a copy.
  subroutine view_of(a, view)
    type(csc_matrix_t), intent(in), target :: a !! the matrix
    type(cholmod_sparse_t), intent(out) :: view !! the same

    view%nrow = int(a%n, c_size_t)
    view%ncol = view%nrow
    view%nzmax = size(a%row, kind=c_size_t)
    view%stype = use_lower
    if (a%lower) view%sorted = 0_c_int
    view%p = c_loc(a%ptr)
    view%i = c_loc(a%row)
    view%x = c_loc(a%val)
  end subroutine view_of

  !> Outcome of CHOLMOD's last call.
  pure integer function outcome_of(solver) result(outcome)
    type(cholmod_t), intent(in) :: solver !! status inside

    outcome = solver_done
    if (solver%common%status < 0_c_int) outcome = solver_failed
    if (solver%common%status == cholmod_memory) outcome = solver_out_of_memory
  end function outcome_of

  !> The permutation of the analysis, 0-based: place k holds the equation that is eliminated k-th.
  function factor_order(solver) result(permutation)
    type(cholmod_t), intent(in) :: solver !! analysed
    integer(long), allocatable :: permutation(:) !! (n)
    type(cholmod_factor_t), pointer :: factor
    integer(long), pointer :: perm(:)

    call c_f_pointer(solver%factor, factor)
    call c_f_pointer(factor%perm, perm, [factor%n])
    permutation = perm
  end function factor_order

  !> The last rows and columns of the factor, gathered from its supernodes: L22, whose product
  !! L22 L22^T is the Schur complement of the unknowns that are eliminated last.
  subroutine trailing_block(solver, block)
    type(cholmod_t), intent(in) :: solver !! factorised
    real(wp), intent(out) :: block(:, :) !! (m, m) its lower triangle; zero above
    type(supernodes_t) :: nodes

    nodes = supernodes_of(solver%factor)
    associate (skipped => values_before(nodes, size(block, 1)))
      call place_last(nodes, nodes%x(skipped + 1:), skipped, block)
    end associate
  end subroutine trailing_block

  !> Gives the memory of the last m columns back, which are the last values of the factor: it cannot
  !! solve any more, but complete.
  subroutine drop_trailing_block(solver, m)
    type(cholmod_t), intent(inout) :: solver !! factorised
    integer, intent(in) :: m !! columns
    type(supernodes_t) :: nodes

    nodes = supernodes_of(solver%factor)
    solver%definite = .false.
    associate (kept => values_before(nodes, m))
      if (kept > 0) nodes%factor%x = cholmod_l_realloc(int(kept, c_size_t), c_sizeof(1.0_wp), &
        nodes%factor%x, nodes%factor%xsize, solver%common)
    end associate
  end subroutine drop_trailing_block

  !> Work of a factorisation, and entries of its factor: column by column.
  subroutine factor_work(solver, work, entries)
    type(cholmod_t), intent(in) :: solver !! analysed
    real(wp), intent(out) :: work !! products and sums
    real(wp), intent(out) :: entries !! of the factor
    type(supernodes_t) :: nodes
    integer(long) :: j
    integer :: k

    work = 0.0_wp
    entries = 0.0_wp
    nodes = supernodes_of(solver%factor)
    do k = 1, int(nodes%factor%nsuper)
      do j = 0, nodes%super(k + 1) - nodes%super(k) - 1
        associate (below => real(nodes%pi(k + 1) - nodes%pi(k) - j, wp))
          work = work + below**2
          entries = entries + below
        end associate
      end do
    end do
  end subroutine factor_work

  !> Releases everything.
  subroutine free(solver)
    class(cholmod_t), intent(inout) :: solver !! handles
    integer(c_int) :: status

    if (.not. solver%started) return
    call solver%forget_pattern()
    if (c_associated(solver%y)) status = cholmod_l_free_dense(solver%y, solver%common)
    if (c_associated(solver%e)) status = cholmod_l_free_dense(solver%e, solver%common)
    status = cholmod_l_finish(solver%common)
    solver%started = .false.
  end subroutine free
end module cholmod_solver

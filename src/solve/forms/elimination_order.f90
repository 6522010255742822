!> The order in which the equations of a condensed body are eliminated (doc/theory, "Static
!! condensation").
module elimination_order
  use kinds, only: long
  use costs, only: cost_t, begin_cost, end_cost, cost_symbolic
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t, build_pattern, build_lower
  use back_ends, only: solver_done
  use nested_dissection, only: dissect
  use cholmod_solver, only: cholmod_t, analyse_in_order, analyse_nodes, expand_nodes, factor_order
  use condensed_types, only: condensed_body_t
  implicit none
  private
  public :: order_equations

  !> Weight of a node next to a candidate beside that of one far away, and the distance from where
  !! on nothing of it is left.
  integer, parameter :: next_to_candidates = 30, farthest_layer = 6

contains

  !> The equations in the order of elimination: the graph of the other nodes by nested dissection,
  !! their equations together; then the candidates in their queue, unless these are ordered among
  !! the others. The body is analysed so.
  subroutine order_equations(blocks, equation, queue, body, ordered, costs, outcome)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    integer, intent(in) :: equation(:, :) !! (3, nodes) equations of this body
    integer, intent(in) :: queue(:) !! (nodes) place among its candidates, 0 for no candidate
    type(condensed_body_t), intent(inout) :: body !! gets node, direction, equation, m, analysis
    integer, intent(out) :: ordered(:, :) !! (3, nodes) equations in that order
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    integer, allocatable :: inner(:), outer(:), nodes(:), order(:), candidates(:), numbers(:)
    integer :: last(size(queue))
    integer(long) :: before(count(any(equation > 0, 1)) + 1)
    integer :: i, filled

    candidates = pack([(i, i=1, size(equation, 2))], queue > 0)
    candidates(queue(candidates)) = candidates
    candidates = pack(candidates, any(equation(:, candidates) > 0, 1))
    outer = pack(candidates, spread(.not. body%tree%used, 1, size(candidates)))
    last = merge(0, queue, body%tree%used)
    inner = pack([(i, i=1, size(equation, 2))], any(equation > 0, 1) .and. last == 0)
    outcome = solver_done
    if (size(inner) > 0) call dissect_nodes(blocks, last, inner, costs, outcome)
    if (outcome /= solver_done) return
    nodes = [inner, outer]
    allocate (order(size(nodes)))
    call analyse_nodes(body%solver, graph_of(blocks, nodes, .true.), size(outer), order, costs, &
      outcome)
    if (outcome /= solver_done) return
    nodes = nodes(order)
    body%node = spread(0, 1, count(equation > 0))
    body%direction = body%node
    ordered = 0
    filled = 0
    call number_nodes(nodes(:size(inner)), equation, body, ordered, filled)
    call number_nodes(outer, equation, body, ordered, filled)
    numbers = reshape(ordered(:, candidates), [3*size(candidates)])
    body%equation = pack(numbers, numbers > 0)
    body%m = size(body%equation)
    before(1) = 0
    do i = 1, size(nodes)
      before(i + 1) = before(i) + count(equation(:, nodes(i)) > 0)
    end do
    call expand_nodes(body%solver, before, costs, outcome)
  end subroutine order_equations

  !> The nodes inside by nested dissection of their graph, in postorder. METIS draws from one series
  !! of random numbers: it orders one body at a time.
  subroutine dissect_nodes(blocks, queue, inner, costs, outcome)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    integer, intent(in) :: queue(:) !! (nodes) place among the candidates of this body, or 0
    integer, intent(inout) :: inner(:) !! its other nodes; get their order
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    integer(long), allocatable :: order(:)
    integer, allocatable :: weight(:)
    logical :: found
    type(csc_matrix_t) :: graph
    type(cholmod_t) :: orderer

    call begin_cost(costs, cost_symbolic)
    graph = graph_of(blocks, inner, .false.)
    weight = weights(blocks, queue, inner)
    !$omp critical (order_by_metis)
    call dissect(graph, weight, order, found)
    !$omp end critical (order_by_metis)
    call end_cost(costs, cost_symbolic)
    if (found) then
      call analyse_in_order(orderer, graph, order, costs, outcome)
    else
      !$omp critical (order_by_metis)
      call orderer%analyse(graph, costs, outcome)
      !$omp end critical (order_by_metis)
    end if
    if (outcome == solver_done) inner = inner(factor_order(orderer) + 1)
    call orderer%free()
  end subroutine dissect_nodes

  !> The graph of some nodes in their order: both triangles, or the lower one.
  function graph_of(blocks, nodes, lower) result(graph)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    integer, intent(in) :: nodes(:) !! in their order
    logical, intent(in) :: lower !! the lower triangle alone
    type(csc_matrix_t) :: graph
    integer :: vertex(3, blocks%nodes), i

    vertex = 0
    vertex(1, nodes) = [(i, i=1, size(nodes))]
    if (lower) then
      call build_lower(blocks, vertex, graph)
    else
      call build_pattern(blocks, vertex, graph)
    end if
  end function graph_of

  !> Weights of the other nodes for their dissection. The rows of the candidates fill the columns of
  !! what is near them: both halves shall have their share of these.
  function weights(blocks, queue, inner) result(weight)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    integer, intent(in) :: queue(:) !! (nodes) place among the candidates of this body, or 0
    integer, intent(in) :: inner(:) !! the other nodes of this body
    integer :: weight(size(inner))
    integer :: distance(size(queue)), step, i
    integer, allocatable :: front(:)
    logical :: fresh(size(queue))

    distance = merge(0, farthest_layer, queue > 0)
    front = pack([(i, i=1, size(queue))], queue > 0)
    do step = 1, farthest_layer - 1
      fresh = .false.
      do i = 1, size(front)
        associate (near => blocks%row(blocks%ptr(front(i)):blocks%ptr(front(i) + 1) - 1))
          fresh(near) = fresh(near) .or. distance(near) > step
        end associate
      end do
      where (fresh) distance = step
      front = pack([(i, i=1, size(queue))], fresh)
    end do
    weight = 1 + next_to_candidates/distance(inner)**2
  end function weights

  !> Numbers the equations of a list of nodes.
  pure subroutine number_nodes(nodes, equation, body, ordered, filled)
    integer, intent(in) :: nodes(:) !! the list
    integer, intent(in) :: equation(:, :) !! (3, nodes) equations of the body, 0 elsewhere
    type(condensed_body_t), intent(inout) :: body !! gets node and direction
    integer, intent(inout) :: ordered(:, :) !! (3, nodes) gets the numbers
    integer, intent(inout) :: filled !! numbers that are given
    integer :: i, k

    do i = 1, size(nodes)
      do k = 1, 3
        if (equation(k, nodes(i)) == 0) cycle
        filled = filled + 1
        ordered(k, nodes(i)) = filled
        body%node(filled) = nodes(i)
        body%direction(filled) = k
      end do
    end do
  end subroutine number_nodes
end module elimination_order

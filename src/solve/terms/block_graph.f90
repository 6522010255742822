!> The graph of element lists: which nodes are coupled, and the place of each element's blocks in
!! the matrix on it, looked up once.
module block_graph
  use kinds, only: wp
  use element_lists, only: node_list_t
  use element_types, only: routine_none
  use block_matrix, only: block_matrix_t, find_block, find_column
  implicit none
  private
  public :: build_graph, locate_elements, graph_holds

contains

  !> Graph of the element lists: nodes that share an element are coupled.
  subroutine build_graph(nodes, first, matrix, second, third)
    integer, intent(in) :: nodes !! number of nodes
    class(node_list_t), intent(in) :: first !! elements
    type(block_matrix_t), intent(out) :: matrix !! graph and values, the values zero
    class(node_list_t), intent(in), optional :: second !! more elements
    class(node_list_t), intent(in), optional :: third !! and more
    integer, allocatable :: start(:), owner(:)
    integer :: before

    matrix%nodes = nodes
    allocate (start(nodes + 1), source=0)
    call count_elements(first, start)
    if (present(second)) call count_elements(second, start)
    if (present(third)) call count_elements(third, start)
    call to_offsets(start)
    allocate (owner(start(nodes + 1) - 1))
    call enter_elements(first, 0, start, owner)
    before = first%n
    if (present(second)) call enter_elements(second, before, start, owner)
    if (present(second)) before = before + second%n
    if (present(third)) call enter_elements(third, before, start, owner)
    start = cshift(start, -1)
    start(1) = 1
    call columns(first, before, start, owner, matrix, second, third)
  end subroutine build_graph

  !> Counts how many elements hold each node, in start(node).
  pure subroutine count_elements(list, start)
    class(node_list_t), intent(in) :: list !! elements
    integer, intent(inout) :: start(:) !! (nodes+1) counters
    integer :: k, a

    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      do a = 1, list%nel(k)
        start(list%ix(a, k)) = start(list%ix(a, k)) + 1
      end do
    end do
  end subroutine count_elements

  !> Counters to offsets: start(i) becomes the place of the first entry of i.
  pure subroutine to_offsets(start)
    integer, intent(inout) :: start(:) !! (n+1) counters, then offsets
    integer :: i, next, n

    next = 1
    do i = 1, size(start)
      n = start(i)
      start(i) = next
      next = next + n
    end do
  end subroutine to_offsets

  !> Enters the elements of a list with each of their nodes.
  pure subroutine enter_elements(list, shift, start, owner)
    class(node_list_t), intent(in) :: list !! elements
    integer, intent(in) :: shift !! added to the element's place
    integer, intent(inout) :: start(:) !! (nodes+1) next free place of each node
    integer, intent(inout) :: owner(:) !! element of each entry
    integer :: k, a, node

    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      do a = 1, list%nel(k)
        node = list%ix(a, k)
        owner(start(node)) = shift + k
        start(node) = start(node) + 1
      end do
    end do
  end subroutine enter_elements

  !> Columns of the graph: the nodes of all elements around each node, ascending.
  subroutine columns(first, before, start, owner, matrix, second, third)
    class(node_list_t), intent(in) :: first !! elements
    integer, intent(in) :: before !! elements before those of the third list
    integer, intent(in) :: start(:) !! (nodes+1) first entry of each node
    integer, intent(in) :: owner(:) !! element of each entry
    type(block_matrix_t), intent(inout) :: matrix !! gets ptr, row, val
    class(node_list_t), intent(in), optional :: second !! more elements
    class(node_list_t), intent(in), optional :: third !! and more
    integer, allocatable :: around(:), mark(:), row(:), longer(:)
    integer :: node, entry, n, filled

    allocate (mark(matrix%nodes), source=0)
    allocate (matrix%ptr(matrix%nodes + 1), around(matrix%nodes), row(32*matrix%nodes + 64))
    filled = 0
    do node = 1, matrix%nodes
      matrix%ptr(node) = filled + 1
      n = 0
      do entry = start(node), start(node + 1) - 1
        if (owner(entry) <= first%n) then
          call collect(first, owner(entry), node, mark, around, n)
        else if (owner(entry) <= before) then
          call collect(second, owner(entry) - first%n, node, mark, around, n)
        else
          call collect(third, owner(entry) - before, node, mark, around, n)
        end if
      end do
      call sort(around(1:n))
      if (filled + n > size(row)) then
        allocate (longer(2*(filled + n)))
        longer(1:filled) = row(1:filled)
        call move_alloc(longer, row)
      end if
      row(filled + 1:filled + n) = around(1:n)
      filled = filled + n
    end do
    matrix%ptr(matrix%nodes + 1) = filled + 1
    allocate (matrix%row(filled))
    matrix%row = row(1:filled)
    allocate (matrix%val(3, 3, filled), source=0.0_wp)
  end subroutine columns

  !> Adds the nodes of an element that `node` has not met yet.
  pure subroutine collect(list, k, node, mark, around, n)
    class(node_list_t), intent(in) :: list !! elements
    integer, intent(in) :: k !! the element
    integer, intent(in) :: node !! the column
    integer, intent(inout) :: mark(:) !! (nodes) last column that met each node
    integer, intent(inout) :: around(:) !! nodes met
    integer, intent(inout) :: n !! how many
    integer :: a, other

    do a = 1, list%nel(k)
      other = list%ix(a, k)
      if (mark(other) == node) cycle
      mark(other) = node
      n = n + 1
      around(n) = other
    end do
  end subroutine collect

  !> Sorts a short list by insertion.
  pure subroutine sort(a)
    integer, intent(inout) :: a(:) !! ascending on return
    integer :: i, j, item

    do i = 2, size(a)
      item = a(i)
      do j = i - 1, 1, -1
        if (a(j) <= item) exit
        a(j + 1) = a(j)
      end do
      a(j + 1) = item
    end do
  end subroutine sort

  !> Looks up the places of all elements of a list.
  pure subroutine locate_elements(matrix, list)
    type(block_matrix_t), intent(in) :: matrix !! the matrix
    class(node_list_t), intent(inout) :: list !! gets block
    integer :: k, b

    if (.not. allocated(list%block)) allocate (list%block(size(list%ix, 1), size(list%ix, 1), &
      list%n), source=0)
    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      associate (nodes => list%ix(:list%nel(k), k))
        do b = 1, size(nodes)
          call find_column(matrix, nodes, nodes(b), list%block(:size(nodes), b, k))
        end do
      end associate
    end do
  end subroutine locate_elements

  !> Every coupling of the list is in the graph.
  pure logical function graph_holds(matrix, list) result(holds)
    type(block_matrix_t), intent(in) :: matrix !! the matrix
    class(node_list_t), intent(in) :: list !! elements
    integer :: k, a, b

    holds = allocated(matrix%ptr)
    if (.not. holds) return
    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      do b = 1, list%nel(k)
        do a = 1, list%nel(k)
          if (find_block(matrix, list%ix(a, k), list%ix(b, k)) == 0) then
            holds = .false.
            return
          end if
        end do
      end do
    end do
  end function graph_holds
end module block_graph

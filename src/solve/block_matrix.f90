!> A sparse matrix of 3 x 3 blocks on the graph of the nodes.
!!
!! Columns of blocks, rows ascending within a column; the graph is symmetric, the values need not
!! be. Elements add to it through places that are looked up once.
module block_matrix
  use kinds, only: wp
  use element_lists, only: node_list_t
  use elmlib, only: routine_none
  implicit none
  private
  public :: block_matrix_t, build_graph, find_block, locate_elements, multiply, multiply_some, &
    multiply_absolute, graph_holds

  !> Blocks of one matrix.
  type :: block_matrix_t
    integer :: nodes = 0 !! number of nodes
    integer, allocatable :: ptr(:) !! (nodes+1) first block of each column
    integer, allocatable :: row(:) !! (blocks) node of the row
    real(wp), allocatable :: val(:, :, :) !! (3, 3, blocks) values [force/length]
  end type block_matrix_t

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

  !> Place of block (row, column), 0 if the graph does not hold it.
  pure integer function find_block(matrix, row, column) result(place)
    type(block_matrix_t), intent(in) :: matrix !! the matrix
    integer, intent(in) :: row !! node of the row
    integer, intent(in) :: column !! node of the column
    integer :: low, high, middle

    place = 0
    low = matrix%ptr(column)
    high = matrix%ptr(column + 1) - 1
    do while (low <= high)
      middle = (low + high)/2
      if (matrix%row(middle) == row) then
        place = middle
        return
      else if (matrix%row(middle) < row) then
        low = middle + 1
      else
        high = middle - 1
      end if
    end do
  end function find_block

  !> Looks up the places of all elements of a list.
  pure subroutine locate_elements(matrix, list)
    type(block_matrix_t), intent(in) :: matrix !! the matrix
    class(node_list_t), intent(inout) :: list !! gets block
    integer :: k, a, b

    if (.not. allocated(list%block)) allocate (list%block(size(list%ix, 1), size(list%ix, 1), &
      list%n), source=0)
    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      do b = 1, list%nel(k)
        do a = 1, list%nel(k)
          list%block(a, b, k) = find_block(matrix, list%ix(a, k), list%ix(b, k))
        end do
      end do
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

  !> y = A x, by block columns.
  pure subroutine multiply(matrix, x, y)
    type(block_matrix_t), intent(in) :: matrix !! A
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(out) :: y(:, :) !! (3, nodes)
    integer :: j, k

    y = 0.0_wp
    do j = 1, matrix%nodes
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        associate (i => matrix%row(k))
          y(:, i) = y(:, i) + matrix%val(:, 1, k)*x(1, j) + matrix%val(:, 2, k)*x(2, j) &
            + matrix%val(:, 3, k)*x(3, j)
        end associate
      end do
    end do
  end subroutine multiply

  !> y = A x at some nodes alone, with a symmetric A: the columns of these nodes hold their rows.
  pure subroutine multiply_some(matrix, wanted, x, y)
    type(block_matrix_t), intent(in) :: matrix !! A, symmetric
    logical, intent(in) :: wanted(:) !! (nodes) where y is wanted
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(inout) :: y(:, :) !! (3, nodes) elsewhere it stays
    integer :: j, k

    do j = 1, matrix%nodes
      if (.not. wanted(j)) cycle
      y(:, j) = 0.0_wp
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        y(:, j) = y(:, j) + matmul(x(:, matrix%row(k)), matrix%val(:, :, k))
      end do
    end do
  end subroutine multiply_some

  !> y = |A| |x|: the size of the terms that A x sums, for estimates of round-off.
  pure subroutine multiply_absolute(matrix, x, y)
    type(block_matrix_t), intent(in) :: matrix !! A
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(out) :: y(:, :) !! (3, nodes)
    real(wp) :: size_x(3)
    integer :: j, k

    y = 0.0_wp
    do j = 1, matrix%nodes
      size_x = abs(x(:, j))
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        associate (i => matrix%row(k))
          y(:, i) = y(:, i) + (abs(matrix%val(:, 1, k))*size_x(1) &
            + abs(matrix%val(:, 2, k))*size_x(2) + abs(matrix%val(:, 3, k))*size_x(3))
        end associate
      end do
    end do
  end subroutine multiply_absolute
end module block_matrix

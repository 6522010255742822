!> Facets of elements: which are exterior, which way they look, and how they hang together.
module facets
  use kinds, only: wp
  use cells, only: shapes, kind_of, facet_name, most_cell_facets
  use mesh_types, only: mesh_t
  use key_sorting, only: sort_columns, comes_before, ascending
  use cell_geometry, only: facet_vector
  implicit none
  private
  public :: facet_table_t, exterior_facets, find_facet, find_key, facet_neighbours, node_facets, &
    node_elements, tributary_areas

  !> All exterior facets of a mesh, ordered by their ascending corner numbers.
  type :: facet_table_t
    integer :: count = 0 !! number of facets
    integer, allocatable :: corners(:, :) !! (3, count) corners, counter-clockwise from outside
    integer, allocatable :: keys(:, :) !! (3, count) corners ascending; columns lexicographic
    integer, allocatable :: elements(:) !! (count) element behind
    integer :: crowded(3) = 0 !! three elements that share one facet; zeros if there are none
  end type facet_table_t

contains

  !> Facets that belong to one element only.
  subroutine exterior_facets(mesh, table)
    type(mesh_t), intent(in) :: mesh !! nodes and elements
    type(facet_table_t), intent(out) :: table !! its exterior facets
    integer, allocatable :: keys(:, :), order(:)
    integer :: e, k, n, first, last, element

    n = most_cell_facets*mesh%elements
    allocate (keys(3, n), source=0)
    do e = 1, mesh%elements
      do k = 1, shapes(kind_of(mesh%ix(:, e)))%facets
        keys(:, most_cell_facets*(e - 1) + k) = ascending(facet_name(mesh%ix(:, e), k))
      end do
    end do
    call sort_columns(keys, order)
    allocate (table%corners(3, n), table%keys(3, n), table%elements(n))
    first = 1
    do while (first <= n)
      last = last_equal(keys, order, first)
      if (keys(1, order(first)) == 0) then
        ! of an element that is not there, or that has fewer
      else if (last == first) then
        element = (order(first) - 1)/most_cell_facets + 1
        k = order(first) - most_cell_facets*(element - 1)
        table%count = table%count + 1
        table%corners(:, table%count) = facet_name(mesh%ix(:, element), k)
        table%keys(:, table%count) = keys(:, order(first))
        table%elements(table%count) = element
      else if (last > first + 1 .and. table%crowded(1) == 0) then
        table%crowded = (order(first:first + 2) - 1)/most_cell_facets + 1
      end if
      first = last + 1
    end do
    table%corners = table%corners(:, :table%count)
    table%keys = table%keys(:, :table%count)
    table%elements = table%elements(:table%count)
  end subroutine exterior_facets

  !> Place in the table of the facet with these corners, in any order; 0 if it is not exterior.
  pure integer function find_facet(table, corners) result(place)
    type(facet_table_t), intent(in) :: table !! exterior facets
    integer, intent(in) :: corners(3) !! node numbers

    place = find_key(table%keys(:, :table%count), corners)
  end function find_facet

  !> Place of three corners, in any order, in a list of ascending corners; 0 if they are not there.
  pure integer function find_key(keys, corners) result(place)
    integer, intent(in) :: keys(:, :) !! (3, n) corners ascending; columns lexicographic
    integer, intent(in) :: corners(3) !! node numbers
    integer :: key(3), low, high, middle

    key = ascending(corners)
    low = 1
    high = size(keys, 2)
    place = 0
    do while (low <= high)
      middle = (low + high)/2
      if (all(keys(:, middle) == key)) then
        place = middle
        return
      else if (comes_before(keys(:, middle), key)) then
        low = middle + 1
      else
        high = middle - 1
      end if
    end do
  end function find_key

  !> The last place of the columns that are equal to that at a place, in their order.
  pure integer function last_equal(keys, order, first) result(last)
    integer, intent(in) :: keys(:, :) !! (rows, n) columns
    integer, intent(in) :: order(:) !! (n) lexicographic
    integer, intent(in) :: first !! the place

    do last = first, size(order) - 1
      if (any(keys(:, order(last + 1)) /= keys(:, order(first)))) return
    end do
  end function last_equal

  !> The facet across each edge. An edge of one facet is the boundary; so is one of three or more,
  !! because there the surface does not say which way it goes on.
  subroutine facet_neighbours(corners, neighbours, non_manifold)
    integer, intent(in) :: corners(:, :) !! (3, n) corners of the facets of a surface
    integer, allocatable, intent(out) :: neighbours(:, :) !! (3, n) facet facing corner k, or 0
    integer, intent(out) :: non_manifold !! number of edges that hold more than two facets
    integer, allocatable :: edges(:, :), order(:)
    integer :: f, k, a, b, n, first, last, i, j

    n = 3*size(corners, 2)
    allocate (neighbours(3, size(corners, 2)), source=0)
    allocate (edges(2, n))
    do f = 1, size(corners, 2)
      do k = 1, 3
        a = corners(mod(k, 3) + 1, f)
        b = corners(mod(k + 1, 3) + 1, f)
        edges(:, 3*(f - 1) + k) = [min(a, b), max(a, b)]
      end do
    end do
    call sort_columns(edges, order)
    non_manifold = 0
    first = 1
    do while (first <= n)
      last = last_equal(edges, order, first)
      if (last == first + 1) then
        i = order(first) - 1
        j = order(last) - 1
        neighbours(mod(i, 3) + 1, i/3 + 1) = j/3 + 1
        neighbours(mod(j, 3) + 1, j/3 + 1) = i/3 + 1
      else if (last > first + 1) then
        non_manifold = non_manifold + 1
      end if
      first = last + 1
    end do
  end subroutine facet_neighbours

  !> Facets around each node: those of node i are list(start(i):start(i + 1) - 1), ascending.
  pure subroutine node_facets(corners, nodes, start, list)
    integer, intent(in) :: corners(:, :) !! (3 or more, n) corners of facets or elements, or 0
    integer, intent(in) :: nodes !! highest node number
    integer, allocatable, intent(out) :: start(:) !! (nodes + 1) first place of each node
    integer, allocatable, intent(out) :: list(:) !! facets
    integer, allocatable :: next(:)
    integer :: f, k, i

    allocate (start(nodes + 1), source=0)
    do f = 1, size(corners, 2)
      do k = 1, size(corners, 1)
        i = corners(k, f)
        if (i > 0) start(i) = start(i) + 1
      end do
    end do
    allocate (list(sum(start)))
    start(nodes + 1) = size(list) + 1
    do i = nodes, 1, -1
      start(i) = start(i + 1) - start(i)
    end do
    next = start
    do f = 1, size(corners, 2)
      do k = 1, size(corners, 1)
        i = corners(k, f)
        if (i == 0) cycle
        list(next(i)) = f
        next(i) = next(i) + 1
      end do
    end do
  end subroutine node_facets

  !> Elements around each node that is a corner of them, in the same way.
  pure subroutine node_elements(mesh, chosen, start, list)
    type(mesh_t), intent(in) :: mesh !! nodes and elements
    logical, intent(in) :: chosen(:) !! (elements) these count
    integer, allocatable, intent(out) :: start(:) !! (nodes + 1) first place of each node
    integer, allocatable, intent(out) :: list(:) !! elements
    integer :: corners(maxval(shapes%corners), mesh%elements), e, k

    corners = 0
    do e = 1, mesh%elements
      k = kind_of(mesh%ix(:, e))
      if (chosen(e)) corners(:shapes(k)%corners, e) = mesh%ix(:shapes(k)%corners, e)
    end do
    call node_facets(corners, mesh%nodes, start, list)
  end subroutine node_elements

  !> Tributary area of each node: a third of each facet it is a corner of.
  pure subroutine tributary_areas(corners, x, area)
    integer, intent(in) :: corners(:, :) !! (3, n) corners of the facets of a surface
    real(wp), intent(in) :: x(:, :) !! (3, nodes) coordinates [length]
    real(wp), allocatable, intent(out) :: area(:) !! (nodes) area [length^2], 0 off the surface
    real(wp) :: a
    integer :: f, k

    allocate (area(size(x, 2)), source=0.0_wp)
    do f = 1, size(corners, 2)
      a = norm2(facet_vector(x(:, corners(:, f))))/3.0_wp
      do k = 1, 3
        area(corners(k, f)) = area(corners(k, f)) + a
      end do
    end do
  end subroutine tributary_areas
end module facets

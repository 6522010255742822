!> Moves slave nodes with a small gap or penetration onto the master, in the reference
!! configuration, before anything is built on it (doc/theory, "Initial gap adjustment").
module gap_adjustment
  use kinds, only: wp
  use mesh_types, only: mesh_t
  use facets, only: facet_neighbours, node_facets, node_elements
  use cells, only: corners_of
  use cell_geometry, only: cell_volume, cell_aspect, longest_edge
  use facet_geometry, only: project_on_facet, barycentric, facet_size
  use surface_sag, only: find_sags
  use facet_tree, only: facet_tree_t, build_tree, nearest_facet
  implicit none
  private
  public :: adjustment_t, adjust_gaps

  !> The tolerance that is taken if none is given is the sag of the facets on both sides, but at
  !! least and at most these shares of the slave's facets around the node.
  real(wp), parameter :: least_gap_share = 1.0e-3_wp
  real(wp), parameter :: most_gap_share = 0.05_wp
  !> A node lies on the facet if its distance is below this share of the longest edge.
  real(wp), parameter :: on_surface = 1.0e-12_wp
  !> A projection outside the boundary by more than this, in shape functions, is not over the
  !! master.
  real(wp), parameter :: boundary_tolerance = 1.0e-6_wp
  !> No element keeps less than this share of its volume,
  real(wp), parameter :: least_volume = 0.5_wp
  !> nor gets an aspect ratio larger than this many times its own.
  real(wp), parameter :: most_aspect = 2.0_wp
  !> Nodes that had to stay are tried again after the others have moved, so often.
  integer, parameter :: most_sweeps = 4

  !> What an adjustment has done.
  type :: adjustment_t
    integer :: moved = 0 !! nodes moved
    integer :: left = 0 !! nodes within the tolerance that had to stay
    real(wp) :: largest = 0.0_wp !! longest way of a node [length]
    integer :: farthest = 0 !! the node that has gone it
    integer :: left_node = 0 !! first of the nodes that had to stay
    integer :: left_element = 0 !! the element that it would have spoilt
  end type adjustment_t

  !> The elements around each node.
  type :: around_t
    integer, allocatable :: first(:) !! (nodes+1) where the elements of a node begin
    integer, allocatable :: element(:) !! elements
  end type around_t

contains

  !> Moves the slave nodes that are within the tolerance of the master.
  subroutine adjust_gaps(slave, slave_facets, facets, neighbours, tolerance, mesh, done)
    integer, intent(in) :: slave(:) !! slave nodes
    integer, intent(in) :: slave_facets(:, :) !! (3, facets) corners of the facets between them
    integer, intent(in) :: facets(:, :) !! (3, facets) corners of the master's facets
    integer, intent(in) :: neighbours(:, :) !! (3, facets) facet facing corner k, 0 at the boundary
    real(wp), intent(in) :: tolerance !! largest gap or penetration, 0 for the default [length]
    type(mesh_t), intent(inout) :: mesh !! its nodes are moved
    type(adjustment_t), intent(out) :: done !! what was done
    type(facet_tree_t) :: tree
    type(around_t) :: around
    real(wp), allocatable :: before(:, :)
    real(wp) :: longest, way(3), limit(2, size(slave)), sag(size(facets, 2))
    integer :: f, i, sweep, moved, element, target

    longest = 0.0_wp
    do f = 1, size(facets, 2)
      longest = max(longest, facet_size(mesh%x(:, facets(:, f))))
    end do
    before = mesh%x
    call build_tree(tree, facets, mesh%x)
    call node_elements(mesh, spread(.true., 1, mesh%elements), around%first, around%element)
    sag = 0.0_wp
    limit = tolerance
    if (tolerance <= 0.0_wp) then
      call find_sags(facets, neighbours, mesh%x, sag)
      call find_slave_sags(slave, slave_facets, around, mesh, limit)
    end if
    do sweep = 1, most_sweeps
      moved = 0
      done%left = 0
      do i = 1, size(slave)
        call way_to_master(tree, facets, neighbours, mesh%x, mesh%x(:, slave(i)), target, way)
        if (target == 0 .or. norm2(way) <= on_surface*longest) cycle
        if (norm2(way) > allowed(limit(:, i), sag(target), tolerance)) cycle
        call try_move(slave(i), way, around, before, mesh, element)
        if (element == 0) then
          moved = moved + 1
        else
          done%left = done%left + 1
          if (done%left > 1) cycle
          done%left_node = slave(i)
          done%left_element = element
        end if
      end do
      if (moved == 0 .or. done%left == 0) exit
    end do
    call measure(slave, before, mesh, done)
  end subroutine adjust_gaps

  !> Sag of the slave's facets around each of its nodes, and their mean size; where there are none,
  !! the mean edge of the elements around the node.
  subroutine find_slave_sags(slave, slave_facets, around, mesh, values)
    integer, intent(in) :: slave(:) !! slave nodes
    integer, intent(in) :: slave_facets(:, :) !! (3, facets) corners of the facets between them
    type(around_t), intent(in) :: around !! elements around the nodes
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(out) :: values(:, :) !! (2, slave nodes) sag, size [length]
    integer, allocatable :: neighbours(:, :), start(:), list(:)
    real(wp) :: sag(size(slave_facets, 2)), h
    integer :: non_manifold, i, k

    call facet_neighbours(slave_facets, neighbours, non_manifold)
    call node_facets(slave_facets, mesh%nodes, start, list)
    call find_sags(slave_facets, neighbours, mesh%x, sag)
    values = 0.0_wp
    do i = 1, size(slave)
      h = 0.0_wp
      do k = start(slave(i)), start(slave(i) + 1) - 1
        values(1, i) = max(values(1, i), sag(list(k)))
        h = h + facet_size(mesh%x(:, slave_facets(:, list(k))))
      end do
      values(2, i) = h/real(max(1, start(slave(i) + 1) - start(slave(i))), wp)
      if (values(2, i) > 0.0_wp) cycle
      do k = around%first(slave(i)), around%first(slave(i) + 1) - 1
        values(2, i) = values(2, i) + longest_edge(mesh%x(:, corners_of(mesh%ix(:, &
          around%element(k)))))/real(around%first(slave(i) + 1) - around%first(slave(i)), wp)
      end do
    end do
  end subroutine find_slave_sags

  !> How far a node may be moved.
  pure real(wp) function allowed(at, sag, tolerance)
    real(wp), intent(in) :: at(2) !! sag and size of the slave's facets there [length]
    real(wp), intent(in) :: sag !! of the master's facet [length]
    real(wp), intent(in) :: tolerance !! as the deck has it, 0 for the default [length]

    allowed = tolerance
    if (tolerance <= 0.0_wp) allowed &
      = min(max(at(1) + sag, least_gap_share*at(2)), most_gap_share*at(2))
  end function allowed

  !> Number and longest way of the nodes that have moved.
  pure subroutine measure(slave, before, mesh, done)
    integer, intent(in) :: slave(:) !! slave nodes
    real(wp), intent(in) :: before(:, :) !! (3, nodes) positions as the deck gives them [length]
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(adjustment_t), intent(inout) :: done !! gets moved, largest, farthest
    real(wp) :: length
    integer :: i

    do i = 1, size(slave)
      length = norm2(mesh%x(:, slave(i)) - before(:, slave(i)))
      if (length <= 0.0_wp) cycle
      done%moved = done%moved + 1
      if (length <= done%largest) cycle
      done%largest = length
      done%farthest = slave(i)
    end do
  end subroutine measure

  !> The way from a point to the closest point of the master, zero if it is not over it.
  subroutine way_to_master(tree, facets, neighbours, x, y, facet, way)
    type(facet_tree_t), intent(in) :: tree !! tree of the master
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    integer, intent(in) :: neighbours(:, :) !! (3, facets) neighbours
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(out) :: facet !! the facet next to it, 0 for none
    real(wp), intent(out) :: way(3) !! the way [length]
    real(wp) :: xi(2), gap, distance, n(3), candidate(3)
    integer :: k

    way = 0.0_wp
    call nearest_facet(tree, facets, x, y, facet, distance)
    if (facet == 0) return
    associate (corners => x(:, facets(:, facet)))
      call project_on_facet(corners, y, xi, gap)
      n = barycentric(xi)
      if (any(n < -boundary_tolerance .and. neighbours(:, facet) == 0)) return
      if (all(n >= -boundary_tolerance)) then
        way = matmul(corners, n) - y
        return
      end if
      way = to_edge(corners(:, 1), corners(:, 2), y)
      do k = 2, 3
        candidate = to_edge(corners(:, k), corners(:, mod(k, 3) + 1), y)
        if (norm2(candidate) < norm2(way)) way = candidate
      end do
    end associate
  end subroutine way_to_master

  !> The way from a point to the closest point of an edge.
  pure function to_edge(a, b, y) result(way)
    real(wp), intent(in) :: a(3) !! one end [length]
    real(wp), intent(in) :: b(3) !! other end [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp) :: way(3), s

    s = dot_product(y - a, b - a)/dot_product(b - a, b - a)
    way = a + min(1.0_wp, max(0.0_wp, s))*(b - a) - y
  end function to_edge

  !> Moves a node unless that spoils an element.
  subroutine try_move(node, way, around, before, mesh, element)
    integer, intent(in) :: node !! the node
    real(wp), intent(in) :: way(3) !! where to [length]
    type(around_t), intent(in) :: around !! elements around the nodes
    real(wp), intent(in) :: before(:, :) !! (3, nodes) positions as the deck gives them [length]
    type(mesh_t), intent(inout) :: mesh !! the node is moved
    integer, intent(out) :: element !! the element that it would spoil, 0 if it was moved
    real(wp) :: old(3)
    integer :: k

    old = mesh%x(:, node)
    mesh%x(:, node) = old + way
    do k = around%first(node), around%first(node + 1) - 1
      element = around%element(k)
      if (is_spoilt(mesh%ix(:, element), before, mesh%x)) then
        mesh%x(:, node) = old
        return
      end if
    end do
    element = 0
  end subroutine try_move

  !> An element has lost too much of its volume or of its shape.
  pure logical function is_spoilt(element, before, after) result(spoilt)
    integer, intent(in) :: element(:) !! its nodes
    real(wp), intent(in) :: before(:, :) !! (3, nodes) positions as the deck gives them [length]
    real(wp), intent(in) :: after(:, :) !! (3, nodes) positions now [length]

    spoilt = cell_volume(after, element) < least_volume*cell_volume(before, element)
    if (.not. spoilt) spoilt = cell_aspect(after, element) > &
      most_aspect*cell_aspect(before, element)
  end function is_spoilt
end module gap_adjustment

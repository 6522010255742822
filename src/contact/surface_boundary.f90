!> Boundary of a master: whether a point is still over the surface, and which of two faces side by
!! side it belongs to (doc/theory, "Target facet", "Boundary edges", eq. (10.1)).
!!
!! A node stands for the area around it. At the boundary of its own surface all of that lies on one
!! side of it: bodies that lie edge on edge stay in contact there, whichever edge has moved farther.
!! Such a node passes the boundary of the master by a quarter of the way to the middle of its slave
!! facets, about a tenth of a facet, before it lets go.
module surface_boundary
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_position
  use concave_edges, only: same_face
  use convex_edges, only: find_rings, kink
  use smooth_normals, only: project_on_master
  use facet_geometry, only: corners, facet_normal, barycentric, altitude
  implicit none
  private
  public :: find_boundary, facet_across, walk, beyond_boundary, has_left, stays, &
    boundary_tolerance, &
    on_edge, longest_walk

  !> A projection further than this outside a facet, in shape functions, has left it.
  real(wp), parameter :: boundary_tolerance = 1.0e-6_wp
  !> A projection that is not further outside lies on the edge: it belongs to the facet that it had.
  real(wp), parameter :: on_edge = 0.1_wp*boundary_tolerance
  !> An apex may stay outside its facet by this over the sine of the kink at the edge, eq. (10.1):
  !! so much the plane of the facet departs from the surface, in shape functions. More would leave
  !! the choice of the facet, and with it the force, to the start of the iteration.
  real(wp), parameter :: departure = 1.0e-12_wp
  !> Share of the way from a node at the boundary of its surface to the middle of its slave facets.
  real(wp), parameter :: inward = 0.25_wp
  !> Steps of one walk; a walk that comes back to a facet ends at once.
  integer, parameter :: longest_walk = 1000

contains

  !> Marks the slave nodes at the boundary of their surface: on an edge of one slave facet alone.
  subroutine find_boundary(pair)
    type(pair_t), intent(inout) :: pair !! slave_facets given; gets at_boundary, ring, ring_end
    integer :: p, i, k, first, n

    if (allocated(pair%points%at_boundary)) deallocate (pair%points%at_boundary)
    if (pair%segmented .or. pair%points%n_slaves > 1) return
    if (.not. allocated(pair%points%slave_facets)) return
    n = count_points(pair)/pair%points%slots
    allocate (pair%points%at_boundary(n), source=.false.)
    if (n == 0 .or. size(pair%points%slave_facets, 2) == 0) return
    call find_rings(pair)
    first = 1
    do p = 1, n
      associate (last => pair%points%ring_end(p), node => pair%points%point_nodes(1, p), &
        around => pair%points%slave_facets(:, pair%points%ring(first:pair%points%ring_end(p))))
        do i = 1, last - first + 1
          do k = 1, 3
            if (around(k, i) == node) cycle
            if (count(around == around(k, i)) == 1) pair%points%at_boundary(p) = .true.
          end do
        end do
        first = last + 1
      end associate
    end do
  end subroutine find_boundary

  !> The way from a node at the boundary of its surface into the area that it stands for; none for
  !! other points.
  pure function way_in(pair, p, x) result(way)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: way(3), middle(3)
    integer :: node, first, last, i

    way = 0.0_wp
    if (.not. allocated(pair%points%at_boundary)) return
    node = mod(p - 1, size(pair%points%at_boundary)) + 1
    if (.not. pair%points%at_boundary(node)) return
    first = 1
    if (node > 1) first = pair%points%ring_end(node - 1) + 1
    last = pair%points%ring_end(node)
    middle = 0.0_wp
    do i = first, last
      middle = middle + sum(corners(x, pair%points%slave_facets(:, pair%points%ring(i))), 2)/3.0_wp
    end do
    way = inward*(middle/real(last - first + 1, wp) - point_position(pair, p, x))
  end function way_in

  !> The facet across the edge behind which a point of facet `target` lies, 0 if it stays: it lies
  !! inside, or outside by no more than eq. (10.1) allows.
  pure integer function facet_across(pair, x, target, xi, tolerance, barred) result(next)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: target !! the facet
    real(wp), intent(in) :: xi(2) !! (xi, eta) of the point
    real(wp), intent(in) :: tolerance !! most that is allowed outside, in shape functions
    logical, intent(in) :: barred(3) !! edges that are not crossed
    real(wp) :: n(3), allowed
    integer :: trial, k, across

    next = 0
    n = barycentric(xi)
    do trial = 1, 3
      k = minloc(n, 1)
      if (n(k) >= 0.0_wp) return
      across = pair%surface%neighbours(k, target)
      if (pair%surface%concave(k, target) .or. barred(k)) across = 0
      if (across > 0) then
        allowed = 0.0_wp
        if (tolerance > 0.0_wp) allowed = min(tolerance, departure/max(departure, &
          kink(pair, x, target, across)))
        if (n(k) < -max(allowed, on_edge)) then
          next = across
          return
        end if
      end if
      n(k) = 1.0_wp
    end do
  end function facet_across

  !> Walks with the projection of a point; ends inside a facet, at the boundary, or between two
  !! facets.
  pure subroutine walk(pair, x, y, target)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(inout) :: target !! in: where to start; out: where it ended
    real(wp) :: xi(2), gap
    integer :: step, next, before, first

    before = 0
    first = target
    do step = 1, longest_walk
      call project_on_master(pair, target, x, y, xi, gap)
      next = facet_across(pair, x, target, xi, 0.0_wp, spread(.false., 1, 3))
      if (next == 0 .or. next == before .or. (step > 1 .and. next == first)) exit
      before = target
      target = next
    end do
  end subroutine walk

  !> A point that has a facet is over the surface no more: a node at the boundary of its own surface
  !! may pass the boundary by as much as the middle of its area lies within.
  pure logical function has_left(pair, x, p, target) result(left)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: p !! the point
    integer, intent(in) :: target !! facet to start from

    left = beyond_boundary(pair, x, point_position(pair, p, x), target, norm2(way_in(pair, p, x)))
  end function has_left

  !> The projection of a place lies outside every facet: it has passed the boundary of the surface.
  !! A point below its facet is projected along a normal that may lean outwards, by less than its
  !! depth (doc/theory, "Boundary edges").
  pure logical function beyond_boundary(pair, x, y, target, zone) result(beyond)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the place [length]
    integer, intent(in) :: target !! facet to start from
    real(wp), intent(in) :: zone !! what it may lie outside [length]
    integer :: facet, k
    real(wp) :: xi(2), gap, n(3), outside, allowed

    facet = target
    call walk(pair, x, y, facet)
    call project_on_master(pair, facet, x, y, xi, gap)
    n = barycentric(xi)
    outside = zone + max(-gap, 0.0_wp)
    beyond = .false.
    do k = 1, 3
      if (n(k) >= -boundary_tolerance .or. pair%surface%neighbours(k, facet) /= 0) cycle
      allowed = boundary_tolerance + outside/altitude(corners(x, pair%surface%facets(:, facet)), k)
      if (n(k) < -allowed) beyond = .true.
    end do
  end function beyond_boundary

  !> An open point stays with its facet where one of another face beside it is closer now, as long
  !! as it is at the boundary of both.
  pure logical function stays(pair, x, p, own, other)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: p !! the point
    integer, intent(in) :: own !! its facet, 0 for none
    integer, intent(in) :: other !! the closest facet, 0 for none
    real(wp) :: y(3), way(3)

    way = way_in(pair, p, x)
    stays = any(abs(way) > 0.0_wp) .and. own > 0 .and. other > 0 .and. own /= other
    if (.not. stays) return
    stays = dot_product(facet_normal(corners(x, pair%surface%facets(:, own))), &
      facet_normal(corners(x, pair%surface%facets(:, other)))) > same_face
    if (stays) stays = .not. has_left(pair, x, p, own)
    if (.not. stays) return
    y = point_position(pair, p, x)
    stays = beyond_boundary(pair, x, y + way, other, 0.0_wp)
    if (.not. stays) stays = beyond_boundary(pair, x, y - way, other, 0.0_wp)
  end function stays
end module surface_boundary

!> The way on which open points come to a surface within an increment (doc/theory, "Contact
!! initiation", eqs. (10.5), (10.6), (10.7), (10.8)).
module touch_path
  use kinds, only: wp
  use touch_types, only: touch_t
  use contact_types, only: pair_t, master_surface_t, contact_point_t
  use contact_points, only: point_facet, corner_weights
  use facet_geometry, only: project_on_facet, barycentric, facet_normal, corners
  use exact_touch, only: round_off
  use surface_boundary, only: on_edge
  use master_facets, only: is_quadratic, facet_kind, all_nodes
  use quadratic_facet, only: project_on_quadratic
  use smooth_patch, only: patch_point_t, patch_at, project_on_patch, patch_from_values, &
    n_patch_values
  implicit none
  private
  public :: touch_time, way_before, closing_time, first_target, meet, free_way, never

  !> The first touch of a body that touches nothing in the increment.
  real(wp), parameter :: free_way = 1.0_wp
  !> Time of a point that does not come closer on its free way.
  real(wp), parameter :: never = huge(1.0_wp)
  !> When such a point touches.
  real(wp), parameter :: unforeseen = 0.5_wp
  !> Share of the straight way that a point has made when the front of contact comes to it; one over
  !! it is the power of its distance from the front that its gap grows with.
  real(wp), parameter :: behind_front = 2.0_wp/3.0_wp
  !> Facets that a point may pass on its way.
  integer, parameter :: longest_walk = 1000

contains

  !> Something on its way at the time t of the increment, 0 to 1: a place or the shape of a patch.
  pure function between(old, free, last, start, t) result(x)
    real(wp), intent(in) :: old(:) !! at the begin of the increment
    real(wp), intent(in) :: free(:) !! at its end if nothing touches
    real(wp), intent(in) :: last(:) !! at the end of the first pass
    real(wp), intent(in) :: start !! the first touch of the body, share of the increment
    real(wp), intent(in) :: t !! share of the increment
    real(wp) :: x(size(old))

    x = old + min(t, start)*(free - old)
    if (t > start) x = x + (t - start)/(1.0_wp - start)*(last - x)
  end function between

  !> Positions of several nodes.
  pure function places_at(touch, start, x_old, nodes, t) result(x)
    type(touch_t), intent(in) :: touch !! free and end positions
    real(wp), intent(in) :: start !! the first touch of the body, share of the increment
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) positions at its begin [length]
    integer, intent(in) :: nodes(:) !! the nodes
    real(wp), intent(in) :: t !! share of the increment
    real(wp) :: x(3, size(nodes))
    integer :: i

    do i = 1, size(nodes)
      x(:, i) = between(x_old(:, nodes(i)), touch%x_free(:, nodes(i)), touch%x_end(:, nodes(i)), &
        start, t)
    end do
  end function places_at

  !> Where the way of a point begins: its target at the start of the increment, if it had one.
  pure integer function first_target(pair, p) result(target)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point, with a target

    target = pair%history%new(p)%target
    if (pair%segmented) return
    if (pair%history%start(p)%target > 0) target = pair%history%start(p)%target
  end function first_target

  !> When the free way of a point meets the surface, as a share of the increment; more than 1 if it
  !! does so later. One that touches exactly does so at once.
  pure real(wp) function touch_time(pair, touch, x_old, p) result(time)
    type(pair_t), intent(in) :: pair !! the pair
    type(touch_t), intent(in) :: touch !! free positions
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) positions at the begin [length]
    integer, intent(in) :: p !! the point, with a target
    type(contact_point_t) :: point
    real(wp) :: gap, gap_free, none

    point%target = first_target(pair, p)
    call meet(pair, touch, free_way, x_old, p, 0.0_wp, point, gap)
    none = round_off(corners(x_old, pair%surface%facets(:, point%target)), x_old(:, &
      pair%points%point_nodes(1, p)))
    call meet(pair, touch, free_way, x_old, p, 1.0_wp, point, gap_free)
    time = closing_time(gap, gap_free, none)
  end function touch_time

  !> When a gap closes that goes evenly from what it was to what it would be, as a share of the
  !! increment: 0 if it was closed, never if it hardly shrinks.
  pure real(wp) function closing_time(gap, gap_free, none) result(time)
    real(wp), intent(in) :: gap !! at the start of the increment [length]
    real(wp), intent(in) :: gap_free !! at its end [length]
    real(wp), intent(in) :: none !! gaps up to this are none [length]

    if (gap <= none) then
      time = 0.0_wp
    else if (gap_free >= gap - none) then
      time = never
    else
      time = gap/(gap - gap_free)
    end if
  end function closing_time

  !> The part of its path that counts as a point's way before it touches, as a share of the
  !! increment: to where its free way meets the surface; where contact spreads, to where the front
  !! comes to it.
  pure real(wp) function way_before(touch, body, k, time) result(way)
    type(touch_t), intent(in) :: touch !! first touches of the bodies
    integer, intent(in) :: body !! the slave body
    integer, intent(in) :: k !! number of the pair
    real(wp), intent(in) :: time !! when its free way meets the surface, share of the increment
    real(wp) :: ratio

    if (touch%empty(body, k) .or. touch%span_before <= 0.0_wp .or. time <= 0.0_wp) then
      way = merge(unforeseen, min(1.0_wp, time), time >= never)
      way = max(touch%start(body, k), way)
    else if (time >= never) then
      way = behind_front*unforeseen
    else
      ratio = touch%span/touch%span_before
      way = behind_front*min(1.0_wp, 1.0_wp/(ratio*((1.0_wp + 1.0_wp/(ratio*time))**behind_front &
        - 1.0_wp)))
    end if
  end function way_before

  !> Where a point is over the surface at the time t: walks to the facet below it.
  pure subroutine meet(pair, touch, start, x_old, p, t, point, gap)
    type(pair_t), intent(in) :: pair !! the pair
    type(touch_t), intent(in) :: touch !! free and end positions
    real(wp), intent(in) :: start !! the first touch of the body, share of the increment
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) positions at the begin [length]
    integer, intent(in) :: p !! number of the point
    real(wp), intent(in) :: t !! share of the increment
    type(contact_point_t), intent(inout) :: point !! target: where to begin; gets it and apex there
    real(wp), intent(out) :: gap !! distance, positive outside [length]
    real(wp) :: y(3), slaves(3, size(pair%points%point_nodes, 1))
    integer :: step, next, before, first

    slaves = places_at(touch, start, x_old, pair%points%point_nodes(:, p), t)
    y = matmul(slaves, pair%points%point_weights(:, p))
    if (allocated(pair%points%side%patch_way)) y = y + lift_at(pair, p, start, t, slaves)
    before = 0
    first = point%target
    do step = 1, longest_walk
      call project(pair, places_at(touch, start, x_old, all_nodes(pair, point%target), t), &
        point%target, start, t, y, point%apex, gap)
      if (pair%segmented) return
      next = across(pair, point%target, point%apex)
      if (next == 0 .or. next == before .or. (step > 1 .and. next == first)) return
      before = point%target
      point%target = next
    end do
  end subroutine meet

  !> How far a point stands over its slave facet on the way.
  pure function lift_at(pair, p, start, t, slaves) result(way)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: start !! the first touch of the body, share of the increment
    real(wp), intent(in) :: t !! share of the increment
    real(wp), intent(in) :: slaves(:, :) !! (3, 3) corners of the facet then [length]
    real(wp) :: way(3), l(3)
    type(patch_point_t) :: point

    l = corner_weights(pair, p)
    point = patch_at(patch_from_values(patch_then(pair%points%side, point_facet(pair, p), start, &
      t)), l(1:2))
    way = point%x(3)*facet_normal(slaves)
  end function lift_at

  !> The patch of a facet on the way.
  pure function patch_then(surface, facet, start, t) result(values)
    type(master_surface_t), intent(in) :: surface !! it has patches along the way
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: start !! the first touch of the body, share of the increment
    real(wp), intent(in) :: t !! share of the increment
    real(wp) :: values(n_patch_values)

    associate (way => surface%patch_way(:, facet, :))
      values = between(way(:, 1), way(:, 2), way(:, 3), start, t)
    end associate
  end function patch_then

  !> Projection on a facet or its patch.
  pure subroutine project(pair, nodes, facet, start, t, y, xi, gap)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: nodes(:, :) !! (3, 3 or 6) of the facet [length]
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: start !! the first touch of the body, share of the increment
    real(wp), intent(in) :: t !! share of the increment
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(out) :: xi(2) !! (xi, eta)
    real(wp), intent(out) :: gap !! distance, positive outside [length]

    if (is_quadratic(pair, facet)) then
      call project_on_quadratic(nodes, facet_kind(pair, facet), y, xi, gap)
    else if (pair%smooth) then
      call project_on_patch(nodes, patch_from_values(patch_then(pair%surface, facet, start, t)), &
        y, xi, gap)
    else
      call project_on_facet(nodes, y, xi, gap)
    end if
  end subroutine project

  !> The neighbour behind the edge that a projection is furthest outside of, 0 if it is inside or
  !! nothing is there; no way leads over a concave edge.
  pure integer function across(pair, target, xi) result(next)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the facet
    real(wp), intent(in) :: xi(2) !! the projection
    real(wp) :: n(3)
    integer :: trial, k

    next = 0
    n = barycentric(xi)
    do trial = 1, 3
      k = minloc(n, 1)
      if (n(k) >= -on_edge) return
      if (pair%surface%neighbours(k, target) > 0 .and. .not. pair%surface%concave(k, target)) then
        next = pair%surface%neighbours(k, target)
        return
      end if
      n(k) = 1.0_wp
    end do
  end function across
end module touch_path

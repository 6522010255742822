!> Where the apex of a contact point goes (doc/theory, "Target facet").
module contact_apexes
  use kinds, only: wp
  use element_types, only: element_t, task_residual
  use elmlib, only: element_routine
  use element_parameters, only: n_parameters
  use contact_types, only: pair_t, contact_point_t, status_open
  use contact_points, only: point_position
  use contact_overlap, only: withheld_gap
  use contact_parameters, only: point_parameters, point_shift, stiffest_plain
  use exact_touch, only: round_off
  use facet_geometry, only: corners
  use smooth_normals, only: project_on_master
  use master_facets, only: is_quadratic, facet_routine
  implicit none
  private
  public :: apex_of, find_apex, find_apex_from, touches, open_if_touching

contains

  !> Where the apex goes at positions x with the point's target and start apex.
  function apex_of(pair, p, point, x) result(apex)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(in) :: point !! target and start apex
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: apex(2)
    integer :: status

    call find_apex(pair, p, point, x, apex, status)
  end function apex_of

  !> The same, and what the point does there.
  subroutine find_apex(pair, p, point, x, apex, status)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(in) :: point !! target and start apex
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(out) :: apex(2) !! (xi, eta) in the target
    integer, intent(out) :: status !! open, stick or slip

    call find_apex_from(pair, p, point, point_position(pair, p, x), x, apex, status)
  end subroutine find_apex

  !> The same for a point at a given place.
  subroutine find_apex_from(pair, p, point, y, x, apex, status)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point, or one with its penalty
    type(contact_point_t), intent(in) :: point !! target and start apex
    real(wp), intent(in) :: y(3) !! the place [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(out) :: apex(2) !! (xi, eta) in the target
    integer, intent(out) :: status !! open, stick or slip
    real(wp) :: d(n_parameters)
    type(element_t) :: e

    d = point_parameters(pair, p, point%target)
    e%xl(:, 1) = y
    e%nel = 4
    e%xl(:, 2:4) = corners(x, pair%surface%facets(:, point%target))
    if (is_quadratic(pair, point%target)) then
      e%nel = 7
      e%xl(:, 5:7) = corners(x, pair%surface%middles(:, point%target))
    end if
    e%h1 = point%apex
    e%path1 = point%path
    e%shift = point_shift(pair, p, point)
    e%offset = withheld_gap(pair, p)
    call element_routine(facet_routine(pair, point%target), task_residual, d, e)
    apex = e%h2
    status = e%status
  end subroutine find_apex_from

  !> A point lies on or below the plane of a facet, its shift included.
  pure logical function touches(pair, x, p, facet)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: p !! the point
    integer, intent(in) :: facet !! the facet, 0 for none
    real(wp) :: xi(2), gap, kappa(3)

    touches = .false.
    if (facet == 0) return
    call project_on_master(pair, facet, x, point_position(pair, p, x), xi, gap)
    kappa = point_shift(pair, p, pair%history%new(p))
    touches = gap + kappa(3) + withheld_gap(pair, p) <= 0.0_wp
  end function touches

  !> Opens a closed point whose depth is round-off: it carries nothing that means anything, and
  !! whether it is closed at all is chance. What a stiffer penalty makes of a depth tells more.
  pure subroutine open_if_touching(pair, p, point, y, x)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(inout) :: point !! its state; may be opened
    real(wp), intent(in) :: y(3) !! where it is [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: xi(2), gap, kappa(3), least

    if (point%status <= status_open .or. point%target == 0) return
    call project_on_master(pair, point%target, x, y, xi, gap)
    kappa = point_shift(pair, p, point)
    least = round_off(corners(x, pair%surface%facets(:, point%target)), y)
    if (pair%points%relative > stiffest_plain) least = least*stiffest_plain/pair%points%relative
    if (abs(gap + kappa(3) + withheld_gap(pair, p)) >= least) return
    point%status = status_open
    point%path = 0.0_wp
    point%way = 0.0_wp
  end subroutine open_if_touching
end module contact_apexes

!> The master under a point of a pair with multipliers: weights of its nodes, normal, axis of
!! friction (doc/theory, "Mortar contact", eq. (7.13)).
module mortar_under
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_parameters, only: point_parameters
  use contact_points, only: point_position
  use element_parameters, only: n_parameters
  use facet_geometry, only: corners, facet_normal, project_on_facet, barycentric
  use friction_axes, only: axes_t, find_axes
  use master_facets, only: is_quadratic, facet_kind, all_nodes, all_corners
  use quadratic_facet, only: facet_weights, projection_t, project_quadratic, facet_flat
  implicit none
  private
  public :: under_t, look_under, most_masters

  !> Nodes of a master facet that a point has weights at.
  integer, parameter :: most_masters = 6

  !> Where a point lies on the master.
  type :: under_t
    integer :: n = 0 !! nodes of the facet
    integer :: node(most_masters) = 0 !! these
    real(wp) :: now(most_masters) = 0.0_wp !! their weights at the projection
    real(wp) :: before(most_masters) = 0.0_wp !! those at the apex
    real(wp) :: normal(3) = 0.0_wp !! outward unit normal there
    real(wp) :: axis(3) = 0.0_wp !! principal axis of mu1
    real(wp) :: gap = 0.0_wp !! distance, positive outside [length]
  end type under_t

contains

  !> The master under a point: weights of its nodes at the projection and at the apex, the normal
  !! and the axis of friction.
  pure subroutine look_under(pair, p, x, under)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point, with a target
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(under_t), intent(out) :: under !! what is there
    real(wp) :: y(3), xi(2), t(3, 2), c(3, 6), d(n_parameters)
    integer :: kind
    type(projection_t) :: at
    type(axes_t) :: axes

    y = point_position(pair, p, x)
    associate (point => pair%history%new(p), facet => pair%history%new(p)%target)
      if (is_quadratic(pair, facet)) then
        under%n = 6
        under%node = all_nodes(pair, facet)
        c = all_corners(pair, facet, x)
        kind = facet_kind(pair, facet)
        at = project_quadratic(c, y, kind)
        if (.not. at%found) at = project_quadratic(c, y, facet_flat)
        xi = at%xi
        under%gap = at%gap
        t = at%t
        under%normal = at%normal
        under%now = facet_weights(xi, kind, c)
        under%before = facet_weights(point%apex, kind, c)
      else
        under%n = 3
        under%node(:3) = pair%surface%facets(:, facet)
        c(:, :3) = corners(x, under%node(:3))
        call project_on_facet(c(:, :3), y, xi, under%gap)
        t = c(:, 1:2) - spread(c(:, 3), 2, 2)
        under%normal = facet_normal(c(:, :3))
        under%now(:3) = barycentric(xi)
        under%before(:3) = barycentric(point%apex)
      end if
      d = point_parameters(pair, p, facet)
      call find_axes(d, t(:, 1), t(:, 2), under%normal, xi, y, axes)
      under%axis = axes%p(:, 1)
    end associate
  end subroutine look_under
end module mortar_under

!> How deep the bodies of a pair lie in each other where no contact point is: at nodes and middles
!! of edges of slave facets, and at nodes of the master (doc/theory, "Contact resolution").
module edge_audit
  use kinds, only: wp
  use vectors, only: cross
  use contact_types, only: pair_t, form_quadrature_to_surface
  use contact_points, only: count_points, point_facet, is_too_deep
  use facet_geometry, only: corners
  use smooth_normals, only: project_on_master
  implicit none
  private
  public :: deepest_edge

  !> Cosine between the normals of facets that look at each other: from a side wall the nodes below
  !! the bottom of a body seem deep in it.
  real(wp), parameter :: facing_away_cosine = -0.5_wp

contains

  !> The deepest place of a pair whose points lie inside of slave facets, 0 if none is inside the
  !! other body. Only facets are looked at that have a master under one of their points.
  subroutine deepest_edge(pair, x, deepest)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(out) :: deepest !! below the surface of the other body [length]
    integer :: p, f, target, last(2)

    deepest = 0.0_wp
    if (pair%form /= form_quadrature_to_surface) return
    if (pair%shrinking%withheld > 0.0_wp) return
    last = 0
    do p = 1, count_points(pair)
      target = pair%history%old(p)%target
      if (target == 0) cycle
      f = point_facet(pair, p)
      if (f == 0 .or. all(last == [f, target])) cycle
      last = [f, target]
      associate (c => corners(x, pair%points%point_nodes(:3, p)))
        call look_below(pair, target, x, c, deepest)
        if (pair%surface%exact) cycle
        call look_into(c, corners(x, pair%surface%facets(:, target)), deepest)
      end associate
    end do
  end subroutine deepest_edge

  !> Corners of a slave facet and middles of its edges that lie over a master facet, or below it.
  subroutine look_below(pair, target, x, c, deepest)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: c(3, 3) !! corners of the slave facet [length]
    real(wp), intent(inout) :: deepest !! deepest place so far [length]
    real(wp) :: xi(2), gap
    integer :: k

    do k = 1, 6
      if (k <= 3) then
        call project_on_master(pair, target, x, c(:, k), xi, gap)
      else
        call project_on_master(pair, target, x, 0.5_wp*(c(:, k - 3) + c(:, 1 + mod(k - 3, 3))), &
          xi, gap)
      end if
      if (min(xi(1), xi(2), 1.0_wp - sum(xi)) < 0.0_wp) cycle
      if (is_too_deep(pair, target, gap)) cycle
      deepest = max(deepest, -gap)
    end do
  end subroutine look_below

  !> Corners of a master facet below a slave facet that looks at it: no deeper than that is long, or
  !! they would be those of another side of its body.
  pure subroutine look_into(c, m, deepest)
    real(wp), intent(in) :: c(3, 3) !! corners of the slave facet [length]
    real(wp), intent(in) :: m(3, 3) !! corners of the master facet [length]
    real(wp), intent(inout) :: deepest !! deepest place so far [length]
    real(wp) :: normal(3), other(3), a(3), b(3), y(3), xi(2), depth, double_area
    integer :: k

    a = c(:, 1) - c(:, 3)
    b = c(:, 2) - c(:, 3)
    normal = cross(a, b)
    double_area = norm2(normal)
    other = cross(m(:, 1) - m(:, 3), m(:, 2) - m(:, 3))
    if (dot_product(normal, other) > facing_away_cosine*double_area*norm2(other)) return
    normal = normal/double_area
    do k = 1, 3
      y = m(:, k) - c(:, 3)
      depth = -dot_product(y, normal)
      if (depth <= deepest .or. depth > max(norm2(a), norm2(b), norm2(a - b))) cycle
      xi = [dot_product(cross(y, b), normal), dot_product(cross(a, y), normal)]/double_area
      if (min(xi(1), xi(2), 1.0_wp - sum(xi)) >= 0.0_wp) deepest = depth
    end do
  end subroutine look_into
end module edge_audit

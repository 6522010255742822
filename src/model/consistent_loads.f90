!> Consistent nodal values of loads on facets and in cells: here, and nowhere else, the shape of a
!! facet or a cell counts (doc/theory, "Loads", eq. (9.2)).
module consistent_loads
  use kinds, only: wp
  use vectors, only: cross
  use facet_quadrature, only: make_rule
  use quadratic_facet, only: facet_shapes_t, facet_shapes, facet_bent
  use solid_shapes, only: shape_slopes, shape_values
  use cells, only: most_facet_nodes, tet4, tet10
  implicit none
  private
  public :: facet_loads, cell_volumes, place_facet_points, facet_points

  !> Points on a facet of six nodes: degree 4, exact for N_a times its normal.
  integer, parameter :: facet_points = 6
  !> Volume coordinates and shares of the rule of 14 points, degree 5, exact for N_a times the
  !! Jacobian of ten nodes: two times four points near corners and facets, six near edges.
  real(wp), parameter :: l_near(2) = [0.31088591926330060980_wp, 0.092735250310891226402_wp]
  real(wp), parameter :: near_weight(2) = [0.11268792571801585080_wp, 0.073493043116361949544_wp]
  real(wp), parameter :: l_edge = 0.045503704125649649492_wp
  real(wp), parameter :: edge_share = 0.042546020777081466438_wp

contains

  !> Integrals of the shape functions over a facet, and of these times its outward normal: what a
  !! traction and a pressure that pulls give its nodes.
  pure subroutine facet_loads(x, areas, normals)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) 3 corners, or 6 with mid nodes, seen from outside
    real(wp), intent(out) :: areas(:) !! (nodes) [length^2]
    real(wp), intent(out) :: normals(:, :) !! (3, nodes) [length^2]
    real(wp) :: n(most_facet_nodes, facet_points), slopes(2, most_facet_nodes, facet_points), &
      weights(facet_points), normal(3)
    integer :: q, a, nodes, points

    nodes = size(x, 2)
    if (nodes == 3) then
      normal = cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))/6.0_wp
      normals = spread(normal, 2, 3)
      areas = norm2(normal)
      return
    end if
    areas = 0.0_wp
    normals = 0.0_wp
    call place_facet_points(nodes, points, n, slopes, weights)
    do q = 1, points
      normal = weights(q)*cross(matmul(x, slopes(1, :, q)), matmul(x, slopes(2, :, q)))
      do a = 1, nodes
        areas(a) = areas(a) + n(a, q)*norm2(normal)
        normals(:, a) = normals(:, a) + n(a, q)*normal
      end do
    end do
  end subroutine facet_loads

  !> Points of a facet: shape functions, their slopes by xi and eta, weights. What is
  !! summed there is exact for N_a times the normal.
  pure subroutine place_facet_points(nodes, points, n, slopes, weights)
    integer, intent(in) :: nodes !! 3 or 6
    integer, intent(out) :: points !! how many
    real(wp), intent(out) :: n(:, :) !! (6, points or more) shape functions
    real(wp), intent(out) :: slopes(:, :, :) !! (2, 6, points or more)
    real(wp), intent(out) :: weights(:) !! (points or more) of the parent, whose area is 1/2
    type(facet_shapes_t) :: s
    real(wp) :: l(3, facet_points)
    integer :: q

    n = 0.0_wp
    slopes = 0.0_wp
    weights = 0.0_wp
    points = 1
    if (nodes == 3) then
      n(:3, 1) = 1.0_wp/3.0_wp
      slopes(:, :3, 1) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, -1.0_wp, -1.0_wp], [2, 3])
      weights(1) = 0.5_wp
      return
    end if
    points = facet_points
    call make_rule(facet_points, l, weights(:facet_points))
    weights = 0.5_wp*weights
    do q = 1, facet_points
      s = facet_shapes(l(:2, q), facet_bent)
      n(:, q) = s%n
      slopes(:, :, q) = transpose(s%d)
    end do
  end subroutine place_facet_points

  !> Integrals of the shape functions over a reference cell, what a unit of load per volume gives.
  pure function cell_volumes(x) result(volumes)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) 4 corners, or 10 with mid nodes [length]
    real(wp) :: volumes(size(x, 2)), l(4)
    integer :: i, j

    if (size(x, 2) == tet4%nodes) then
      volumes = dot_product(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1)), x(:, 4) - x(:, 1))/24.0_wp
      return
    end if
    volumes = 0.0_wp
    do i = 1, 4
      do j = 1, 2
        l = l_near(j)
        l(i) = 1.0_wp - 3.0_wp*l_near(j)
        call add_point(x, l, near_weight(j), volumes)
      end do
      do j = 1, i - 1
        l = l_edge
        l([i, j]) = 0.5_wp - l_edge
        call add_point(x, l, edge_share, volumes)
      end do
    end do
  end function cell_volumes

  !> Adds a point of the rule for ten nodes.
  pure subroutine add_point(x, l, share, volumes)
    real(wp), intent(in) :: x(3, 10) !! nodes [length]
    real(wp), intent(in) :: l(4) !! volume coordinates
    real(wp), intent(in) :: share !! of the volume of the parent
    real(wp), intent(inout) :: volumes(10) !! integrals of the shape functions [length^3]
    real(wp) :: slopes(3, 10), j(3, 3), weight

    slopes = shape_slopes(tet10%nodes, l)
    j = matmul(x, transpose(slopes))
    weight = share/6.0_wp*dot_product(cross(j(:, 1), j(:, 2)), j(:, 3))
    volumes = volumes + weight*shape_values(tet10%nodes, l)
  end subroutine add_point
end module consistent_loads

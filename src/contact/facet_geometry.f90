!> Geometry of one facet: projection of a point, its closest point, and unfolding across an edge.
module facet_geometry
  use kinds, only: wp
  use vectors, only: cross, length
  implicit none
  private
  public :: altitude, corners, project_on_facet, project_points, &
    plane_t, plane_of, project_corners, distance_to_facet, unfold, &
    barycentric, kink_sine, facet_size, facet_area, facet_normal, facet_frame, unfold_vector, &
    is_concave, is_convex

  !> Edges that rise with a larger sine of their angle (25 degrees) are concave.
  real(wp), parameter :: concave_sine = 0.42_wp
  !> Facets whose normals have a smaller cosine (60 degrees) are two sides of a convex edge, if each
  !! lies below the other.
  real(wp), parameter :: convex_cosine = 0.5_wp

  !> The plane of a facet: corner 3, unit normal, and the dual vectors times the size of the normal.
  type :: plane_t
    real(wp) :: origin(3) !! [length]
    real(wp) :: n(3) !! outward unit normal
    real(wp) :: d1(3), d2(3) !! [length]
    real(wp) :: size !! twice the area [length^2]
  end type plane_t

contains

  !> Projection (xi, eta) of a point on the plane of a facet, and its signed distance.
  pure subroutine project_on_facet(x, y, xi, gap)
    real(wp), intent(in) :: x(3, 3) !! corners, counter-clockwise seen from outside [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(out) :: xi(2) !! (xi, eta) of its projection
    real(wp), intent(out) :: gap !! distance, positive outside [length]
    real(wp) :: gaps(1)

    call project_points(x, 1, y, xi, gaps)
    gap = gaps(1)
  end subroutine project_on_facet

  !> The same for several points.
  pure subroutine project_points(x, n_points, y, xi, gap)
    real(wp), intent(in) :: x(3, 3) !! corners, counter-clockwise seen from outside [length]
    integer, intent(in) :: n_points !! how many
    real(wp), intent(in) :: y(3, n_points) !! the points [length]
    real(wp), intent(out) :: xi(2, n_points) !! (xi, eta) of their projections
    real(wp), intent(out) :: gap(n_points) !! distances, positive outside [length]
    type(plane_t) :: plane
    real(wp) :: z(3)
    integer :: k

    plane = plane_of(x)
    do k = 1, n_points
      z = y(:, k) - plane%origin
      gap(k) = dot_product(z, plane%n)
      xi(:, k) = [dot_product(plane%d1, z), dot_product(plane%d2, z)]/plane%size
    end do
  end subroutine project_points

  !> What projections on a facet need of it.
  pure type(plane_t) function plane_of(x) result(plane)
    real(wp), intent(in) :: x(3, 3) !! corners, counter-clockwise seen from outside [length]
    real(wp) :: a1(3), a2(3)

    a1 = x(:, 1) - x(:, 3)
    a2 = x(:, 2) - x(:, 3)
    plane%origin = x(:, 3)
    plane%n = product_of(a1, a2)
    plane%size = length(plane%n)
    plane%n = plane%n/plane%size
    plane%d1 = product_of(a2, plane%n)
    plane%d2 = product_of(plane%n, a1)
  end function plane_of

  !> Projections (xi, eta) of the corners of one facet on the plane of another.
  pure function project_corners(plane, x) result(xi)
    type(plane_t), intent(in) :: plane !! of the other one
    real(wp), intent(in) :: x(3, 3) !! the corners [length]
    real(wp) :: xi(2, 3)
    real(wp) :: z(3)
    integer :: k

    do k = 1, 3
      z = x(:, k) - plane%origin
      xi(:, k) = [dot_product(plane%d1, z), dot_product(plane%d2, z)]/plane%size
    end do
  end function project_corners

  !> Vector product, as `cross` of another module, but here the compiler can put it in place: search
  !! spends a tenth of its time in calls of it.
  pure function product_of(a, b) result(c)
    real(wp), intent(in) :: a(3) !! first vector
    real(wp), intent(in) :: b(3) !! second vector
    real(wp) :: c(3)

    c(1) = a(2)*b(3) - a(3)*b(2)
    c(2) = a(3)*b(1) - a(1)*b(3)
    c(3) = a(1)*b(2) - a(2)*b(1)
  end function product_of

  !> Positions of the corners of a facet; x(:, nodes) as an argument would be copied to the heap.
  pure function corners(x, nodes) result(y)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(3) !! corner nodes
    real(wp) :: y(3, 3)
    integer :: k

    do k = 1, 3
      y(:, k) = x(:, nodes(k))
    end do
  end function corners

  !> The three shape functions at (xi, eta).
  pure function barycentric(xi) result(n)
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: n(3)

    n = [xi(1), xi(2), 1.0_wp - xi(1) - xi(2)]
  end function barycentric

  !> Longest edge of a facet.
  pure real(wp) function facet_size(x) result(h)
    real(wp), intent(in) :: x(3, 3) !! corners [length]

    h = max(norm2(x(:, 2) - x(:, 1)), norm2(x(:, 3) - x(:, 2)), norm2(x(:, 1) - x(:, 3)))
  end function facet_size

  !> Area of a facet.
  pure real(wp) function facet_area(x) result(area)
    real(wp), intent(in) :: x(3, 3) !! corners [length]

    area = 0.5_wp*norm2(cross(x(:, 1) - x(:, 3), x(:, 2) - x(:, 3)))
  end function facet_area

  !> Distance from a point to the closest point of a facet, its edges and corners included.
  pure real(wp) function distance_to_facet(x, y) result(distance)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp) :: xi(2), gap
    integer :: k

    call project_on_facet(x, y, xi, gap)
    if (all(barycentric(xi) >= 0.0_wp)) then
      distance = abs(gap)
    else
      distance = huge(1.0_wp)
      do k = 1, 3
        distance = min(distance, distance_to_edge(x(:, k), x(:, mod(k, 3) + 1), y))
      end do
    end if
  end function distance_to_facet

  !> Distance from a point to a straight edge.
  pure real(wp) function distance_to_edge(a, b, y) result(distance)
    real(wp), intent(in) :: a(3) !! one end [length]
    real(wp), intent(in) :: b(3) !! other end [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp) :: s

    s = dot_product(y - a, b - a)/dot_product(b - a, b - a)
    s = min(1.0_wp, max(0.0_wp, s))
    distance = norm2(y - a - s*(b - a))
  end function distance_to_edge

  !> Corner of `to` that is no corner of `from`, 0 if they share no edge.
  pure integer function far_corner(from, to) result(k)
    integer, intent(in) :: from(3) !! corner nodes
    integer, intent(in) :: to(3) !! corner nodes
    integer :: i, found

    k = 0
    found = 0
    do i = 1, 3
      if (any(from == to(i))) cycle
      k = i
      found = found + 1
    end do
    if (found /= 1) k = 0
  end function far_corner

  !> Outward unit normal.
  pure function facet_normal(x) result(n)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    real(wp) :: n(3)

    n = product_of(x(:, 1) - x(:, 3), x(:, 2) - x(:, 3))
    n = n/length(n)
  end function facet_normal

  !> The orthonormal frame of a facet: along its first base vector, e x that, outward normal.
  pure function facet_frame(x) result(q)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    real(wp) :: q(3, 3)

    q(:, 3) = facet_normal(x)
    q(:, 1) = x(:, 1) - x(:, 3)
    q(:, 1) = q(:, 1)/length(q(:, 1))
    q(:, 2) = cross(q(:, 3), q(:, 1))
  end function facet_frame

  !> The neighbour b rises from the plane of facet a by more than that angle: a node can
  !! touch both.
  pure logical function is_concave(nodes_a, nodes_b, x)
    integer, intent(in) :: nodes_a(3) !! corner nodes
    integer, intent(in) :: nodes_b(3) !! corner nodes of the neighbour
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: far
    real(wp) :: rise(3)

    is_concave = .false.
    far = far_corner(nodes_a, nodes_b)
    if (far == 0) return
    if (kink_sine(x(:, nodes_a), x(:, nodes_b)) < concave_sine .and. dot_product(facet_normal( &
      x(:, nodes_a)), facet_normal(x(:, nodes_b))) > 0.0_wp) return
    rise = x(:, nodes_b(far)) - x(:, nodes_b(mod(far, 3) + 1))
    is_concave = dot_product(rise, facet_normal(x(:, nodes_a))) > 0.0_wp
  end function is_concave

  !> Two facets are sides of a convex edge: the surface bends away from itself, by more than 60
  !! degrees.
  pure logical function is_convex(xa, xb)
    real(wp), intent(in) :: xa(3, 3) !! corners of one facet [length]
    real(wp), intent(in) :: xb(3, 3) !! corners of the other one [length]
    real(wp) :: na(3), nb(3), way(3)

    na = facet_normal(xa)
    nb = facet_normal(xb)
    way = sum(xb - xa, 2)
    is_convex = dot_product(na, nb) < convex_cosine .and. dot_product(way, na) < 0.0_wp &
      .and. dot_product(way, nb) > 0.0_wp
  end function is_convex

  !> Sine of the angle between the normals of two facets.
  pure real(wp) function kink_sine(xa, xb) result(sine)
    real(wp), intent(in) :: xa(3, 3) !! corners of one facet [length]
    real(wp), intent(in) :: xb(3, 3) !! corners of its neighbour [length]
    real(wp) :: na(3), nb(3)

    na = cross(xa(:, 1) - xa(:, 3), xa(:, 2) - xa(:, 3))
    nb = cross(xb(:, 1) - xb(:, 3), xb(:, 2) - xb(:, 3))
    sine = norm2(cross(na/norm2(na), nb/norm2(nb)))
  end function kink_sine

  !> Turns a point in the plane of facet a about the edge shared with facet b into the plane of b
  !! (doc/theory, "Crossing an edge", eq. (10.2)): lengths, and with them the friction force, are
  !! kept.
  pure subroutine unfold(nodes_a, nodes_b, x, xi_a, xi_b)
    integer, intent(in) :: nodes_a(3) !! corner nodes of the facet that is left
    integer, intent(in) :: nodes_b(3) !! corner nodes of the facet that is entered
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: xi_a(2) !! (xi, eta) in facet a
    real(wp), intent(out) :: xi_b(2) !! (xi, eta) in facet b
    real(wp) :: origin(3), t(3), out_a(3), in_b(3), y(3), n(3), gap
    integer :: ka, kb

    n = barycentric(xi_a)
    y = n(1)*x(:, nodes_a(1)) + n(2)*x(:, nodes_a(2)) + n(3)*x(:, nodes_a(3))
    ka = far_corner(nodes_b, nodes_a)
    kb = far_corner(nodes_a, nodes_b)
    if (ka > 0 .and. kb > 0) then
      origin = x(:, nodes_a(mod(ka, 3) + 1))
      t = x(:, nodes_a(mod(ka + 1, 3) + 1)) - origin
      t = t/norm2(t)
      out_a = -away_from(x(:, nodes_a(ka)) - origin, t)
      in_b = away_from(x(:, nodes_b(kb)) - origin, t)
      y = y - origin
      y = origin + dot_product(y, t)*t + dot_product(y, out_a)*in_b
    end if
    call project_on_facet(x(:, nodes_b), y, xi_b, gap)
  end subroutine unfold

  !> Turns a vector of facet a about the edge shared with facet b, as the facet is turned: its parts
  !! along the edge, across it and along the normal are kept.
  pure function unfold_vector(nodes_a, nodes_b, x, v_a) result(v_b)
    integer, intent(in) :: nodes_a(3) !! corner nodes of the facet that is left
    integer, intent(in) :: nodes_b(3) !! corner nodes of the facet that is entered
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: v_a(3) !! components in the frame of facet a
    real(wp) :: v_b(3)
    real(wp) :: a(3, 3), b(3, 3), t(3), v(3)
    integer :: ka

    v_b = v_a
    ka = far_corner(nodes_b, nodes_a)
    if (ka == 0) return
    a = facet_frame(x(:, nodes_a))
    b = facet_frame(x(:, nodes_b))
    t = x(:, nodes_a(mod(ka + 1, 3) + 1)) - x(:, nodes_a(mod(ka, 3) + 1))
    t = t/norm2(t)
    v = v_a(1)*a(:, 1) + v_a(2)*a(:, 2)
    v = dot_product(v, t)*t + dot_product(v, cross(a(:, 3), t))*cross(b(:, 3), t)
    v_b(1:2) = [dot_product(v, b(:, 1)), dot_product(v, b(:, 2))]
  end function unfold_vector

  !> Unit vector of the part of v that is normal to the unit vector t.
  pure function away_from(v, t) result(w)
    real(wp), intent(in) :: v(3) !! any vector
    real(wp), intent(in) :: t(3) !! unit vector
    real(wp) :: w(3)

    w = v - dot_product(v, t)*t
    w = w/norm2(w)
  end function away_from

  !> Distance of a corner of a triangle from the opposite edge [length].
  pure real(wp) function altitude(c, k)
    real(wp), intent(in) :: c(3, 3) !! corners in columns [length]
    integer, intent(in) :: k !! the corner
    real(wp) :: edge(3), side(3)

    edge = c(:, modulo(k + 1, 3) + 1) - c(:, modulo(k, 3) + 1)
    side = c(:, k) - c(:, modulo(k, 3) + 1)
    side = side - edge*dot_product(edge, side)/dot_product(edge, edge)
    altitude = sqrt(dot_product(side, side))
  end function altitude
end module facet_geometry

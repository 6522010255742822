!> Facets of six nodes: shape functions, and the projection of a point (doc/theory, "Six-node
!! facets", eq. (6.13)). Nodes: the corners, then the middles of the edges 12, 23, 31; of a round
!! facet, the corners and what each of them is round about (doc/theory, "Exact tools", eqs. (6.15),
!! (6.16)).
module quadratic_facet
  use kinds, only: wp
  use vectors, only: cross
  use element_types, only: routine_quadratic, routine_round
  implicit none
  private
  public :: facet_shapes_t, facet_shapes, facet_weights, projection_t, project_quadratic
  public :: project_on_quadratic, place_on_quadratic
  public :: facet_flat, facet_bent, facet_round, facet_of_routine

  !> What a facet is: the plane of its corners, the surface through six nodes, or a part of a sphere
  !! or cylinder that cannot be deformed.
  integer, parameter :: facet_flat = 0, facet_bent = 1, facet_round = 2

  !> Steps of a projection, and how many of them leave the curvature out.
  integer, parameter :: most_facet_steps = 30, first_steps = 2
  !> A step below this is the last: Newton's method leaves its square.
  real(wp), parameter :: last_facet_step = 1.0e-8_wp
  !> A projection further outside, in shape functions of the corners, is none.
  real(wp), parameter :: outermost_shape = 2.0_wp
  !> The curvature may take this share of the metric: beyond it the point is near the centre of a
  !! sphere that lies in the facet, and has no projection of its own.
  real(wp), parameter :: least_curved_share = 0.05_wp

  !> Shape functions at a place.
  type :: facet_shapes_t
    real(wp) :: n(6) = 0.0_wp !! values
    real(wp) :: d(6, 2) = 0.0_wp !! slopes by xi and eta
    real(wp) :: dd(6, 3) = 0.0_wp !! second derivatives 11, 22, 12
  end type facet_shapes_t

  !> A facet that is no round one, as a polynomial about its third corner.
  type :: polynomial_t
    real(wp) :: slope(3, 2) !! by xi and eta there [length]
    real(wp) :: bent(3, 3) !! second derivatives 11, 22, 12 [length]
  end type polynomial_t

  !> The projection of a point on a facet.
  type :: projection_t
    real(wp) :: xi(2) = 0.0_wp !! (xi, eta)
    real(wp) :: gap = 0.0_wp !! distance, positive outside [length]
    real(wp) :: t(3, 2) = 0.0_wp !! tangents there [length]
    real(wp) :: bent(3, 3) = 0.0_wp !! second derivatives 11, 22, 12 of the surface [length]
    real(wp) :: normal(3) = 0.0_wp !! outward unit normal
    real(wp) :: inverse(2, 2) = 0.0_wp !! of A_ij = t_i.t_j - d.x_,ij [1/length^2]
    logical :: found = .false. !! there is one
  end type projection_t

contains

  !> What kind of facet a contact element has: flat (patches too), bent or round.
  elemental integer function facet_of_routine(number) result(kind)
    integer, intent(in) :: number !! which routine

    select case (number)
    case (routine_quadratic)
      kind = facet_bent
    case (routine_round)
      kind = facet_round
    case default
      kind = facet_flat
    end select
  end function facet_of_routine

  !> Shape functions of six nodes, or those of the corners alone if the facet is taken as flat.
  pure type(facet_shapes_t) function facet_shapes(xi, kind, x) result(s)
    real(wp), intent(in) :: xi(2) !! (xi, eta): L1 and L2
    integer, intent(in) :: kind !! flat, bent or round
    real(wp), intent(in), optional :: x(3, 6) !! nodes of a round one [length]
    real(wp) :: l(3)

    l = [xi, 1.0_wp - sum(xi)]
    if (kind /= facet_bent) then
      s%n(1:3) = l
      s%d(1:3, 1) = [1.0_wp, 0.0_wp, -1.0_wp]
      s%d(1:3, 2) = [0.0_wp, 1.0_wp, -1.0_wp]
      if (kind == facet_round .and. present(x)) call make_round(x, s)
      return
    end if
    s%n = [l*(2.0_wp*l - 1.0_wp), 4.0_wp*l(1)*l(2), 4.0_wp*l(2)*l(3), 4.0_wp*l(3)*l(1)]
    s%d(:, 1) = [4.0_wp*l(1) - 1.0_wp, 0.0_wp, 1.0_wp - 4.0_wp*l(3), 4.0_wp*l(2), -4.0_wp*l(2), &
      4.0_wp*(l(3) - l(1))]
    s%d(:, 2) = [0.0_wp, 4.0_wp*l(2) - 1.0_wp, 1.0_wp - 4.0_wp*l(3), 4.0_wp*l(1), &
      4.0_wp*(l(3) - l(2)), -4.0_wp*l(1)]
    s%dd(:, 1) = [4.0_wp, 0.0_wp, 4.0_wp, 0.0_wp, 0.0_wp, -8.0_wp]
    s%dd(:, 2) = [0.0_wp, 4.0_wp, 4.0_wp, 0.0_wp, -8.0_wp, 0.0_wp]
    s%dd(:, 3) = [0.0_wp, 0.0_wp, 4.0_wp, 4.0_wp, -4.0_wp, -4.0_wp]
  end function facet_shapes

  !> Their values alone.
  pure function facet_weights(xi, kind, x) result(n)
    real(wp), intent(in) :: xi(2) !! (xi, eta): L1 and L2
    integer, intent(in) :: kind !! flat, bent or round
    real(wp), intent(in), optional :: x(3, 6) !! nodes of a round one [length]
    real(wp) :: n(6), l(3)
    type(facet_shapes_t) :: s

    if (kind == facet_bent) then
      l = [xi, 1.0_wp - sum(xi)]
      n = [l*(2.0_wp*l - 1.0_wp), 4.0_wp*l(1)*l(2), 4.0_wp*l(2)*l(3), 4.0_wp*l(3)*l(1)]
    else
      s = facet_shapes(xi, kind, x)
      n = s%n
    end if
  end function facet_weights

  !> Shape functions of a round facet. With r_a from the inner node to the corner and p = sum l_a
  !! r_a the place is that of the inner nodes plus s p, s = radius/|p|: weights s l_a at the
  !! corners, (1 - s) l_a inside. They do not change while the nodes move as one rigid body.
  pure subroutine make_round(x, s)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    type(facet_shapes_t), intent(inout) :: s !! those of the flat corners; become those of six nodes
    integer, parameter :: i(3) = [1, 2, 1], j(3) = [1, 2, 2]
    real(wp) :: r(3, 3), p(3), t(3, 2), l(3), d(3, 2), scale, slope(2), square, bent
    integer :: k

    r = x(:, 1:3) - x(:, 4:6)
    l = s%n(1:3)
    d = s%d(1:3, :)
    p = matmul(r, l)
    t = matmul(r, d)
    square = dot_product(p, p)
    scale = norm2(r(:, 1))/sqrt(square)
    slope = -scale*matmul(p, t)/square
    s%n = [scale*l, (1.0_wp - scale)*l]
    do k = 1, 2
      s%d(:, k) = [slope(k)*l + scale*d(:, k), (1.0_wp - scale)*d(:, k) - slope(k)*l]
    end do
    do k = 1, 3
      bent = 3.0_wp*slope(i(k))*slope(j(k))/scale &
        - scale*dot_product(t(:, i(k)), t(:, j(k)))/square
      s%dd(1:3, k) = bent*l + slope(i(k))*d(:, j(k)) + slope(j(k))*d(:, i(k))
      s%dd(4:6, k) = -s%dd(1:3, k)
    end do
  end subroutine make_round

  !> Projection along the normal: t_i.(y - x(xi)) = 0, by Newton's method from the flat corners.
  pure type(projection_t) function project_quadratic(x, y, kind) result(p)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(in) :: kind !! flat, bent or round
    type(polynomial_t) :: surface
    real(wp) :: d(3), a(2, 2), metric(2, 2), det, step(2)
    integer :: i

    p%xi = flat_place(x, y)
    if (kind /= facet_round) then
      surface = polynomial_of(x, kind)
      p%bent = surface%bent
    end if
    do i = 1, most_facet_steps
      call look_at_place(x, kind, surface, y, p, d)
      metric = metric_of(p%t)
      a = metric
      if (i > first_steps) call bend(d, p%bent, a)
      det = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
      if (.not. (det > least_curved_share*(metric(1, 1)*metric(2, 2) - metric(1, 2)**2) .and. &
        a(1, 1) > 0.0_wp)) return
      p%inverse = inverse_of(a, det)
      step = matmul(p%inverse, [dot_product(d, p%t(:, 1)), dot_product(d, p%t(:, 2))])
      p%xi = p%xi + step
      if (kind /= facet_flat .and. (any(abs(p%xi) > outermost_shape) .or. abs(sum(p%xi)) &
        > outermost_shape)) &
        return
      p%found = maxval(abs(step)) <= last_facet_step .and. i > first_steps
      if (kind == facet_flat .and. i > first_steps) p%found = .true.
      if (p%found) exit
    end do
    if (.not. p%found) return
    call look_at_place(x, kind, surface, y, p, d)
    p%normal = cross(p%t(:, 1), p%t(:, 2))
    p%normal = p%normal/norm2(p%normal)
    p%gap = dot_product(p%normal, d)
    a = metric_of(p%t)
    call bend(d, p%bent, a)
    p%inverse = inverse_of(a, a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1))
  end function project_quadratic

  !> Tangents and second derivatives at the place xi, and the way from there to the point.
  pure subroutine look_at_place(x, kind, surface, y, p, d)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    integer, intent(in) :: kind !! flat, bent or round
    type(polynomial_t), intent(in) :: surface !! unless it is round
    real(wp), intent(in) :: y(3) !! the point [length]
    type(projection_t), intent(inout) :: p !! xi and, unless it is round, bent given; gets t, bent
    real(wp), intent(out) :: d(3) !! from the surface to the point [length]
    type(facet_shapes_t) :: s
    integer :: k

    if (kind == facet_round) then
      s = facet_shapes(p%xi, kind, x)
      d = y - matmul(x, s%n)
      p%t = matmul(x, s%d)
      p%bent = matmul(x, s%dd)
      return
    end if
    associate (xi => p%xi(1), eta => p%xi(2))
      do k = 1, 3
        p%t(k, 1) = surface%slope(k, 1) + xi*surface%bent(k, 1) + eta*surface%bent(k, 3)
        p%t(k, 2) = surface%slope(k, 2) + eta*surface%bent(k, 2) + xi*surface%bent(k, 3)
        d(k) = y(k) - x(k, 3) - 0.5_wp*(xi*(surface%slope(k, 1) + p%t(k, 1)) &
          + eta*(surface%slope(k, 2) + p%t(k, 2)))
      end do
    end associate
  end subroutine look_at_place

  !> A facet by its slopes and second derivatives: those of the shape functions of `facet_shapes`.
  pure type(polynomial_t) function polynomial_of(x, kind) result(surface)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    integer, intent(in) :: kind !! flat or bent
    real(wp) :: r(3, 6)
    integer :: k

    do k = 1, merge(6, 2, kind == facet_bent)
      r(:, k) = x(:, k) - x(:, 3)
    end do
    surface%slope = r(:, 1:2)
    surface%bent = 0.0_wp
    if (kind /= facet_bent) return
    surface%slope(:, 1) = 4.0_wp*r(:, 6) - r(:, 1)
    surface%slope(:, 2) = 4.0_wp*r(:, 5) - r(:, 2)
    surface%bent(:, 1) = 4.0_wp*r(:, 1) - 8.0_wp*r(:, 6)
    surface%bent(:, 2) = 4.0_wp*r(:, 2) - 8.0_wp*r(:, 5)
    surface%bent(:, 3) = 4.0_wp*(r(:, 4) - r(:, 5) - r(:, 6))
  end function polynomial_of

  !> Projection and gap of a point; where the facet has none, those of the plane of its corners.
  pure subroutine project_on_quadratic(x, kind, y, xi, gap)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    integer, intent(in) :: kind !! bent or round
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(out) :: xi(2) !! (xi, eta)
    real(wp), intent(out) :: gap !! distance, positive outside [length]
    type(projection_t) :: p

    p = project_quadratic(x, y, kind)
    if (.not. p%found) p = project_quadratic(x, y, facet_flat)
    xi = p%xi
    gap = p%gap
  end subroutine project_on_quadratic

  !> t_i.t_j. (matmul and reshape, which the compiler leaves to its library here, took half of the
  !! time of a projection.)
  pure function metric_of(t) result(metric)
    real(wp), intent(in) :: t(3, 2) !! tangents [length]
    real(wp) :: metric(2, 2)

    metric(1, 1) = dot_product(t(:, 1), t(:, 1))
    metric(2, 2) = dot_product(t(:, 2), t(:, 2))
    metric(1, 2) = dot_product(t(:, 1), t(:, 2))
    metric(2, 1) = metric(1, 2)
  end function metric_of

  !> The inverse of a matrix with a known determinant.
  pure function inverse_of(a, det) result(inverse)
    real(wp), intent(in) :: a(2, 2) !! the matrix
    real(wp), intent(in) :: det !! its determinant
    real(wp) :: inverse(2, 2)

    inverse(:, 1) = [a(2, 2), -a(2, 1)]/det
    inverse(:, 2) = [-a(1, 2), a(1, 1)]/det
  end function inverse_of

  !> A_ij = t_i.t_j - d.x_,ij.
  pure subroutine bend(d, bent, a)
    real(wp), intent(in) :: d(3) !! from the surface to the point [length]
    real(wp), intent(in) :: bent(3, 3) !! second derivatives 11, 22, 12 [length]
    real(wp), intent(inout) :: a(2, 2) !! metric; gets A [length^2]
    real(wp) :: c

    c = dot_product(d, bent(:, 3))
    a(1, 1) = a(1, 1) - dot_product(d, bent(:, 1))
    a(2, 2) = a(2, 2) - dot_product(d, bent(:, 2))
    a(1, 2) = a(1, 2) - c
    a(2, 1) = a(2, 1) - c
  end subroutine bend

  !> (xi, eta) of the projection on the plane of the corners.
  pure function flat_place(x, y) result(xi)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp) :: xi(2), a(3), b(3), n(3), d(3)

    a = x(:, 1) - x(:, 3)
    b = x(:, 2) - x(:, 3)
    n = cross(a, b)
    d = y - x(:, 3)
    xi = [dot_product(cross(d, b), n), dot_product(cross(a, d), n)]/dot_product(n, n)
  end function flat_place

  !> The point of a facet at a place.
  pure function place_on_quadratic(x, xi, kind) result(y)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    integer, intent(in) :: kind !! bent or round
    real(wp) :: y(3)

    y = matmul(x, facet_weights(xi, kind, x))
  end function place_on_quadratic
end module quadratic_facet

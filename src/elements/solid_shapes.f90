!> Shape functions of tetrahedra and the points that integrals over them are summed at
!! (doc/theory, "Ten-node tetrahedron", eqs. (8.2), (8.3)).
module solid_shapes
  use kinds, only: wp
  use vectors, only: cross, sum_products
  use cells, only: most_nodes, tet10
  use cell_geometry, only: point_towards, shares_of_points
  use solid_types, only: most_points
  implicit none
  private
  public :: solid_rule_t, solid_rule, flat_gradients, shape_values, shape_slopes, sample_places

  !> Mid nodes nearer than this share of their edge to its middle are in the middle.
  real(wp), parameter :: straight = 1.0e-10_wp

  !> Points of one element in its reference shape.
  type :: solid_rule_t
    integer :: n = 0 !! number of points
    real(wp) :: l(4, most_points) !! (4, n) volume coordinates
    real(wp) :: gradient(3, most_nodes, most_points) !! (3, nel, n) dN_a/dX [1/length]
    real(wp) :: weight(most_points) !! (n) share of the volume [length^3]
  end type solid_rule_t

contains

  !> The points of an element: one for four nodes; for ten, four where its edges are straight, and
  !! eight where they are not: only then a constant stress is in balance.
  pure subroutine solid_rule(nel, x, rule)
    integer, intent(in) :: nel !! nodes of the element, 4 or 10
    real(wp), intent(in) :: x(3, nel) !! reference coordinates [length]
    type(solid_rule_t), intent(out) :: rule !! points, gradients, weights
    real(wp) :: slope(3, nel), j(3, 3), cofactor(3, 3), determinant
    integer :: q, a

    if (nel == 4) then
      rule%n = 1
      rule%l(:, 1) = 0.25_wp
      call flat_gradients(x, rule%gradient(:, :4, 1), rule%weight(1))
      return
    end if
    call place_points(x, rule)
    do q = 1, rule%n
      slope = shape_slopes(nel, rule%l(:, q))
      j = sum_products(x, slope)
      cofactor(:, 1) = cross(j(:, 2), j(:, 3))
      cofactor(:, 2) = cross(j(:, 3), j(:, 1))
      cofactor(:, 3) = cross(j(:, 1), j(:, 2))
      determinant = dot_product(j(:, 1), cofactor(:, 1))
      do a = 1, nel
        rule%gradient(:, a, q) = (cofactor(:, 1)*slope(1, a) + cofactor(:, 2)*slope(2, a) &
          + cofactor(:, 3)*slope(3, a))/determinant
      end do
      rule%weight(q) = determinant/(6.0_wp*real(rule%n, wp))
    end do
  end subroutine solid_rule

  !> Gradients of the shape functions of four nodes, and the volume.
  pure subroutine flat_gradients(x, gradient, volume)
    real(wp), intent(in) :: x(3, 4) !! corner coordinates [length]
    real(wp), intent(out) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(out) :: volume !! [length^3]
    real(wp) :: a(3), b(3), c(3), six_volume

    a = x(:, 2) - x(:, 1)
    b = x(:, 3) - x(:, 1)
    c = x(:, 4) - x(:, 1)
    gradient(:, 2) = cross(b, c)
    gradient(:, 3) = cross(c, a)
    gradient(:, 4) = cross(a, b)
    six_volume = dot_product(a, gradient(:, 2))
    gradient(:, 2:4) = gradient(:, 2:4)/six_volume
    gradient(:, 1) = -(gradient(:, 2) + gradient(:, 3) + gradient(:, 4))
    volume = six_volume/6.0_wp
  end subroutine flat_gradients

  !> Volume coordinates of the points of ten nodes.
  pure subroutine place_points(x, rule)
    real(wp), intent(in) :: x(3, 10) !! reference coordinates [length]
    type(solid_rule_t), intent(out) :: rule !! gets n, l
    real(wp), parameter :: s4 = 1.0_wp/sqrt(5.0_wp)
    real(wp) :: share(2)
    integer :: i

    if (is_straight(x)) then
      rule%n = 4
      do i = 1, 4
        rule%l(:, i) = point_towards(i, s4)
      end do
    else
      share = shares_of_points()
      rule%n = 8
      do i = 1, 4
        rule%l(:, i) = point_towards(i, share(1))
        rule%l(:, 4 + i) = point_towards(i, share(2))
      end do
    end if
  end subroutine place_points

  !> Where the points of an element are.
  pure subroutine sample_places(nel, x, n, places)
    integer, intent(in) :: nel !! nodes of the element, 4 or 10
    real(wp), intent(in) :: x(3, nel) !! reference coordinates [length]
    integer, intent(out) :: n !! number of points
    real(wp), intent(out) :: places(3, most_points) !! (3, n) reference positions [length]
    type(solid_rule_t) :: rule
    integer :: q

    if (nel == 4) then
      n = 1
      places(:, 1) = 0.25_wp*sum(x, 2)
      return
    end if
    call place_points(x, rule)
    n = rule%n
    do q = 1, n
      places(:, q) = matmul(x, shape_values(nel, rule%l(:, q)))
    end do
  end subroutine sample_places

  !> All nodes of the edges lie in their middles.
  pure logical function is_straight(x)
    real(wp), intent(in) :: x(3, 10) !! reference coordinates [length]
    integer :: m

    is_straight = .true.
    do m = 5, 10
      associate (a => x(:, tet10%ends(1, m)), b => x(:, tet10%ends(2, m)))
        is_straight = is_straight .and. norm2(x(:, m) - 0.5_wp*(a + b)) <= straight*norm2(a - b)
      end associate
    end do
  end function is_straight

  !> The shape functions.
  pure function shape_values(nel, l) result(value)
    integer, intent(in) :: nel !! nodes of the element, 4 or 10
    real(wp), intent(in) :: l(4) !! volume coordinates
    real(wp) :: value(nel)

    value(:4) = l
    if (nel == 4) return
    value(:4) = l*(2.0_wp*l - 1.0_wp)
    value(5:) = 4.0_wp*l(tet10%ends(1, 5:))*l(tet10%ends(2, 5:))
  end function shape_values

  !> Slopes of the shape functions by the volume coordinates 2, 3, 4, the first being the rest.
  pure function shape_slopes(nel, l) result(slope)
    integer, intent(in) :: nel !! nodes of the element, 4 or 10
    real(wp), intent(in) :: l(4) !! volume coordinates
    real(wp) :: slope(3, nel)
    real(wp), parameter :: by_l(3, 4) = reshape([-1.0_wp, -1.0_wp, -1.0_wp, 1.0_wp, 0.0_wp, &
      0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 4])
    integer :: m, a

    slope(:, :4) = by_l
    if (nel == 4) return
    do a = 1, 4
      slope(:, a) = (4.0_wp*l(a) - 1.0_wp)*by_l(:, a)
    end do
    do m = 5, 10
      associate (a => tet10%ends(1, m), b => tet10%ends(2, m))
        slope(:, m) = 4.0_wp*(l(a)*by_l(:, b) + l(b)*by_l(:, a))
      end associate
    end do
  end function shape_slopes
end module solid_shapes

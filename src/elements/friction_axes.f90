!> The principal axes of friction of the contact element.
module friction_axes
  use kinds, only: wp
  use vectors, only: cross, length
  use element_parameters, only: d03_axis_kind, d03_axis, d03_turn, d03_place, axis_convected, &
    axis_space_fixed, axis_circumferential, axis_radial
  implicit none
  private
  public :: axes_t, find_axes, turn_of_axes, direction_in_space

  !> Projected vectors shorter than this share of the vector count as normal to the facet.
  real(wp), parameter :: shortest_projection = 1.0e-8_wp

  !> Principal axes and how they turn in the facet's plane.
  type :: axes_t
    real(wp) :: p(3, 2) !! p1 and p2 = e x p1
    real(wp) :: share(3) !! share of a1, a2 and of the projected vector in the rotation of p
    real(wp) :: q2(3) !! e x (projected vector), before it is turned
    real(wp) :: slave_share(3) !! share of the slave point
    logical :: varies !! p depends on the projection (xi, eta), too
    real(wp) :: place_share(2) !! share of that
  end type axes_t

contains

  !> Finds p1, p2 = e x p1 and what turns them (doc/theory, "Friction axes", eqs. (3.5), (5.4)).
  pure subroutine find_axes(d, a1, a2, e, xi, slave, axes)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    real(wp), intent(in) :: a1(3) !! x1 - x3 of the facet [length]
    real(wp), intent(in) :: a2(3) !! x2 - x3 [length]
    real(wp), intent(in) :: e(3) !! outward unit normal
    real(wp), intent(in) :: xi(2) !! (xi, eta) of the slave point's projection
    real(wp), intent(in) :: slave(3) !! current position of the slave point [length]
    type(axes_t), intent(out) :: axes !! axes and shares
    real(wp) :: v(3), p(3), size_p
    logical :: found

    axes%slave_share = 0.0_wp
    axes%place_share = 0.0_wp
    axes%varies = .false.
    if (nint(d(d03_axis_kind)) == axis_convected) then
      call convected_axes(d, a1, a2, e, xi, axes, found)
      if (found) return
    else
      v = direction_in_space(d, slave)
      p = v - dot_product(e, v)*e
      size_p = length(p)
      if (size_p > shortest_projection*length(v)) then
        call space_axes(d, v, p/size_p, size_p, e, axes)
        return
      end if
    end if
    size_p = length(a1)
    axes%share = [1.0_wp/size_p, 0.0_wp, 0.0_wp]
    axes%varies = .false.
    call set_axes(a1/size_p, e, axes)
  end subroutine find_axes

  !> Sets p1, and p2 to e x p1.
  pure subroutine set_axes(p1, e, axes)
    real(wp), intent(in) :: p1(3) !! unit vector in the facet
    real(wp), intent(in) :: e(3) !! outward unit normal
    type(axes_t), intent(inout) :: axes !! gets p and q2

    axes%p(:, 1) = p1
    axes%p(:, 2) = cross(e, p1)
    axes%q2 = axes%p(:, 2)
  end subroutine set_axes

  !> Axes that are carried with the facet: p = c1 a1 + c2 a2, where c may be linear in the place
  !! (xi, eta) of the projection (doc/theory, "Varying lay", eqs. (3.7), (5.5), (5.6)).
  pure subroutine convected_axes(d, a1, a2, e, xi, axes, found)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    real(wp), intent(in) :: a1(3) !! x1 - x3 of the facet [length]
    real(wp), intent(in) :: a2(3) !! x2 - x3 [length]
    real(wp), intent(in) :: e(3) !! outward unit normal
    real(wp), intent(in) :: xi(2) !! (xi, eta) of the slave point's projection
    type(axes_t), intent(inout) :: axes !! gets axes and shares
    logical, intent(out) :: found !! false: no direction there
    real(wp) :: c(2), p(3), size_p, slope(2, 2), longest

    c = d(d03_axis:d03_axis + 1)
    slope = reshape(d(d03_place:d03_place + 3), [2, 2])
    longest = (maxval(abs(c)) + maxval(abs(slope)))*(length(a1) + length(a2))
    axes%varies = any(abs(slope) > 0.0_wp)
    if (axes%varies) c = c + matmul(slope, xi)
    p = c(1)*a1 + c(2)*a2
    size_p = length(p)
    found = size_p > shortest_projection*longest
    if (.not. found) return
    axes%share = [c(1)/size_p, c(2)/size_p, 0.0_wp]
    call set_axes(p/size_p, e, axes)
    if (axes%varies) axes%place_share = matmul([dot_product(axes%p(:, 2), a1), &
      dot_product(axes%p(:, 2), a2)], slope)/size_p
  end subroutine convected_axes

  !> The direction that is projected on the facet: a fixed one, or that about an axis where the
  !! slave point is.
  pure function direction_in_space(d, slave) result(v)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    real(wp), intent(in) :: slave(3) !! current position of the slave point [length]
    real(wp) :: v(3)
    real(wp) :: arm(3)

    v = d(d03_axis:d03_axis + 2)
    if (nint(d(d03_axis_kind)) == axis_space_fixed) return
    arm = slave - d(d03_place:d03_place + 2)
    if (nint(d(d03_axis_kind)) == axis_circumferential) then
      v = cross(v, arm)
    else
      v = arm - dot_product(v, arm)*v
    end if
  end function direction_in_space

  !> Axes along the projection of a direction, turned about the normal.
  pure subroutine space_axes(d, v, p, size_p, e, axes)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    real(wp), intent(in) :: v(3) !! the direction
    real(wp), intent(in) :: p(3) !! its projection, made a unit vector
    real(wp), intent(in) :: size_p !! the length that had
    real(wp), intent(in) :: e(3) !! outward unit normal
    type(axes_t), intent(inout) :: axes !! gets axes and shares
    real(wp) :: q2(3), axis(3)

    q2 = cross(e, p)
    call set_axes(d(d03_turn)*p + d(d03_turn + 1)*q2, e, axes)
    axes%q2 = q2
    axes%share = [0.0_wp, 0.0_wp, -dot_product(e, v)/size_p]
    axis = d(d03_axis:d03_axis + 2)
    select case (nint(d(d03_axis_kind)))
    case (axis_circumferential)
      axes%slave_share = cross(q2, axis)/size_p
    case (axis_radial)
      axes%slave_share = (q2 - dot_product(q2, axis)*axis)/size_p
    case default
      ! A vector that is fixed in space does not turn when the slave point moves.
    end select
  end subroutine space_axes

  !> The turn w of the axes in the facet's plane, dp1 = p2 w - e (p1 . de), as far as it comes from
  !! the corners of the facet and from the slave point.
  pure function turn_of_axes(axes, de) result(w)
    type(axes_t), intent(in) :: axes !! axes and shares
    real(wp), intent(in) :: de(3, 12) !! derivative of the normal by S, 1, 2, 3 [1/length]
    real(wp) :: w(12)

    w = axes%share(3)*matmul(axes%q2, de)
    w(1:3) = w(1:3) + axes%slave_share
    w(4:6) = w(4:6) + axes%share(1)*axes%p(:, 2)
    w(7:9) = w(7:9) + axes%share(2)*axes%p(:, 2)
    w(10:12) = w(10:12) - (axes%share(1) + axes%share(2))*axes%p(:, 2)
  end function turn_of_axes
end module friction_axes

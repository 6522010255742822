!> The principal axis of friction on the master facets of a pair, in the reference configuration.
module lay_directions
  use kinds, only: wp, pi
  use contact_types, only: pair_t, direction_vector, direction_circumferential, direction_radial, &
    direction_field
  use cell_geometry, only: facet_vector
  use vectors, only: cross
  implicit none
  private
  public :: lay_on_facet, convected_lay
  public :: lay_fine, lay_normal, lay_nowhere

  !> What can be said of the lay at the centre of a facet.
  integer, parameter :: lay_fine = 0 !! it has a direction
  integer, parameter :: lay_normal = 1 !! the direction is normal to the facet
  integer, parameter :: lay_nowhere = 2 !! it has none: the axis goes through the centre

  !> A direction whose part in the facet is below this is taken as normal to it; one that is
  !! shorter than this part of the facet, as none.
  real(wp), parameter :: normal_limit = 1.0e-6_wp

contains

  !> The lay at the centre of a facet: the direction there, projected and turned by the pair's angle
  !! about the outward normal.
  pure subroutine lay_on_facet(pair, facet, x, lay, fault)
    type(pair_t), intent(in) :: pair !! has the direction
    integer, intent(in) :: facet !! number of the facet
    real(wp), intent(in) :: x(3, 3) !! (3, corners) its corners [length]
    real(wp), intent(out) :: lay(3) !! unit vector in the facet
    integer, intent(out) :: fault !! one of the constants above
    real(wp) :: e(3), v(3), p(3), shortest

    e = facet_vector(x)
    e = e/norm2(e)
    v = direction_at(pair, facet, sum(x, dim=2)/3.0_wp)
    p = v - dot_product(v, e)*e
    lay = 0.0_wp
    shortest = 0.0_wp
    if (pair%friction%direction == direction_circumferential .or. pair%friction%direction == &
      direction_radial) then
      shortest = normal_limit*max(norm2(x(:, 1) - x(:, 2)), norm2(x(:, 1) - x(:, 3)))
    end if
    fault = lay_nowhere
    if (norm2(v) <= shortest) return
    fault = lay_normal
    if (norm2(p) <= normal_limit*norm2(v)) return
    fault = lay_fine
    lay = turned(pair, e, p/norm2(p))
  end subroutine lay_on_facet

  !> What elmt03 needs for a convected lay: the components c of the lay at corner 3 and their
  !! derivatives by xi and eta (doc/theory, "Varying lay", eq. (3.6)).
  pure function convected_lay(pair, facet, x) result(c)
    type(pair_t), intent(in) :: pair !! has the direction
    integer, intent(in) :: facet !! number of the facet
    real(wp), intent(in) :: x(3, 3) !! (3, corners) its corners [length]
    real(wp) :: c(6)
    real(wp) :: e(3), v(3), at_corner(2, 3)
    integer :: k, fault

    c = 0.0_wp
    if (pair%friction%direction == direction_vector .or. pair%friction%direction == &
      direction_field) then
      call lay_on_facet(pair, facet, x, v, fault)
      c(1:2) = components(x, v)
      return
    end if
    e = facet_vector(x)
    e = e/norm2(e)
    do k = 1, 3
      v = direction_at(pair, facet, x(:, k))
      at_corner(:, k) = components(x, turned(pair, e, v - dot_product(v, e)*e))
    end do
    c(1:2) = at_corner(:, 3)
    c(3:4) = at_corner(:, 1) - at_corner(:, 3)
    c(5:6) = at_corner(:, 2) - at_corner(:, 3)
  end function convected_lay

  !> The direction that the deck gives, at a place on a facet.
  pure function direction_at(pair, facet, x) result(v)
    type(pair_t), intent(in) :: pair !! has the direction
    integer, intent(in) :: facet !! number of the facet
    real(wp), intent(in) :: x(3) !! the place [length]
    real(wp) :: v(3)

    select case (pair%friction%direction)
    case (direction_circumferential)
      v = cross(pair%friction%axis, x - pair%friction%point)
    case (direction_radial)
      v = x - pair%friction%point
      v = v - dot_product(pair%friction%axis, v)*pair%friction%axis
    case (direction_field)
      v = pair%surface%facet_axis(:, facet)
    case default
      v = pair%friction%axis
    end select
  end function direction_at

  !> A vector in a facet turned by the pair's angle about the outward normal.
  pure function turned(pair, e, p) result(lay)
    type(pair_t), intent(in) :: pair !! has the angle
    real(wp), intent(in) :: e(3) !! outward unit normal
    real(wp), intent(in) :: p(3) !! the vector
    real(wp) :: lay(3)

    lay = p*cos(pair%friction%angle*pi/180.0_wp) + cross(e, p)*sin(pair%friction%angle*pi/180.0_wp)
  end function turned

  !> Components c of a vector p in the facet, p = c1 (x1 - x3) + c2 (x2 - x3).
  pure function components(x, p) result(c)
    real(wp), intent(in) :: x(3, 3) !! (3, corners) corners of the facet
    real(wp), intent(in) :: p(3) !! vector in its plane
    real(wp) :: c(2)
    real(wp) :: a1(3), a2(3), m11, m12, m22, determinant

    a1 = x(:, 1) - x(:, 3)
    a2 = x(:, 2) - x(:, 3)
    m11 = dot_product(a1, a1)
    m12 = dot_product(a1, a2)
    m22 = dot_product(a2, a2)
    determinant = m11*m22 - m12**2
    c = [m22*dot_product(a1, p) - m12*dot_product(a2, p), &
      m11*dot_product(a2, p) - m12*dot_product(a1, p)]/determinant
  end function components
end module lay_directions

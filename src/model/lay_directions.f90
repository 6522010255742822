!> The principal axis of friction on the master facets of a pair, in the reference configuration.
module lay_directions
  use kinds, only: wp, pi
  use contact_types, only: pair_t
  use tetrahedra, only: facet_vector
  use vectors, only: cross
  implicit none
  private
  public :: lay_on_facet, convected_lay

  !> An axis whose part in the facet is below this is taken as normal to it.
  real(wp), parameter :: normal_limit = 1.0e-6_wp

contains

  !> The axis projected on a facet and turned by the pair's angle about the outward normal.
  pure subroutine lay_on_facet(pair, x, lay, found)
    type(pair_t), intent(in) :: pair !! has axis and angle
    real(wp), intent(in) :: x(3, 3) !! (3, corners) corners of the facet
    real(wp), intent(out) :: lay(3) !! unit vector in the facet
    logical, intent(out) :: found !! false: the axis is normal to the facet
    real(wp) :: e(3), p(3)

    e = facet_vector(x)
    e = e/norm2(e)
    p = pair%axis - dot_product(pair%axis, e)*e
    found = norm2(p) > normal_limit*norm2(pair%axis)
    lay = 0.0_wp
    if (.not. found) return
    p = p/norm2(p)
    lay = p*cos(pair%angle*pi/180.0_wp) + cross(e, p)*sin(pair%angle*pi/180.0_wp)
  end subroutine lay_on_facet

  !> Components c of a vector p in the facet: p = c1 (x1 - x3) + c2 (x2 - x3).
  pure function convected_lay(x, p) result(c)
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
  end function convected_lay
end module lay_directions

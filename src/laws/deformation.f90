!> Measures of a deformation by its displacement gradient, so that the digits of small strains stay:
!! of F = I + H only those beyond 1e-16 would be left (doc/theory, "Finite strain", eq. (8.12)).
module deformation
  use kinds, only: wp
  use vectors, only: cross
  implicit none
  private
  public :: volume_growth, log_one_plus, green_strain, small_strain, rotation_vector

contains

  !> det(I + H) - 1: the three invariants of H.
  pure real(wp) function volume_growth(h)
    real(wp), intent(in) :: h(3, 3) !! displacement gradient

    volume_growth = h(1, 1) + h(2, 2) + h(3, 3) &
      + (h(1, 1)*h(2, 2) - h(1, 2)*h(2, 1)) + (h(2, 2)*h(3, 3) - h(2, 3)*h(3, 2)) &
      + (h(3, 3)*h(1, 1) - h(3, 1)*h(1, 3)) + dot_product(h(:, 1), cross(h(:, 2), h(:, 3)))
  end function volume_growth

  !> log(1 + x): what 1 + x loses, the quotient loses as well.
  pure real(wp) function log_one_plus(x)
    real(wp), intent(in) :: x !! > -1
    real(wp) :: y

    y = 1.0_wp + x
    log_one_plus = x
    if (abs(y - 1.0_wp) > 0.0_wp) log_one_plus = x*(log(y)/(y - 1.0_wp))
  end function log_one_plus

  !> Green's strain (F^T F - I)/2.
  pure function green_strain(h) result(e)
    real(wp), intent(in) :: h(3, 3) !! displacement gradient
    real(wp) :: e(3, 3)

    e = 0.5_wp*(h + transpose(h) + matmul(transpose(h), h))
  end function green_strain

  !> Strain xx yy zz xy yz zx of a small displacement gradient, shear half of gamma.
  pure function small_strain(h) result(strain)
    real(wp), intent(in) :: h(3, 3) !! displacement gradient
    real(wp) :: strain(6)

    strain(1:3) = [h(1, 1), h(2, 2), h(3, 3)]
    strain(4:6) = 0.5_wp*[h(1, 2) + h(2, 1), h(2, 3) + h(3, 2), h(3, 1) + h(1, 3)]
  end function small_strain

  !> Rotation vector of a small displacement gradient: half the curl.
  pure function rotation_vector(h) result(w)
    real(wp), intent(in) :: h(3, 3) !! displacement gradient
    real(wp) :: w(3)

    w = 0.5_wp*[h(3, 2) - h(2, 3), h(1, 3) - h(3, 1), h(2, 1) - h(1, 2)]
  end function rotation_vector
end module deformation

!> Stresses as one number.
module von_mises_stress
  use kinds, only: wp
  implicit none
  private
  public :: von_mises

contains

  !> sqrt(3/2 s:s) with the deviator s.
  pure function von_mises(stress) result(value)
    real(wp), intent(in) :: stress(:, :) !! (6, n) xx yy zz xy yz zx
    real(wp) :: value(1, size(stress, 2))
    integer :: k

    do k = 1, size(stress, 2)
      associate (s => stress(:, k))
        value(1, k) = sqrt(0.5_wp*((s(1) - s(2))**2 + (s(2) - s(3))**2 + (s(3) - s(1))**2) &
          + 3.0_wp*sum(s(4:6)**2))
      end associate
    end do
  end function von_mises
end module von_mises_stress

!> SOLId LINEar: Hooke's law for small strain, isotropic.
module law_linear
  use kinds, only: wp
  use law_types, only: bulk_law_t
  implicit none
  private
  public :: linear_law, lame, linear_stress

  type(bulk_law_t), parameter :: linear_law = bulk_law_t('LINEar', 'linear elastic', &
    linear=.true., may_mean=.true.)

contains

  !> Lame's constants.
  pure subroutine lame(youngs_modulus, nu, lambda, g)
    real(wp), intent(in) :: youngs_modulus !! E [force/length^2]
    real(wp), intent(in) :: nu !! Poisson's ratio
    real(wp), intent(out) :: lambda !! first constant [force/length^2]
    real(wp), intent(out) :: g !! shear modulus [force/length^2]

    lambda = youngs_modulus*nu/((1.0_wp + nu)*(1.0_wp - 2.0_wp*nu))
    g = 0.5_wp*youngs_modulus/(1.0_wp + nu)
  end subroutine lame

  !> Stress of a strain.
  pure function linear_stress(lambda, g, strain) result(stress)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(in) :: strain(6) !! xx yy zz xy yz zx, shear half of gamma
    real(wp) :: stress(6)

    stress = 2.0_wp*g*strain
    stress(1:3) = stress(1:3) + lambda*(strain(1) + strain(2) + strain(3))
  end function linear_stress
end module law_linear

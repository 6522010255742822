!> SOLId NEOHookean: compressible, the energy of FEAPpv (doc/theory, "Finite strain").
!!
!! W = G/2 (I1 - 3) - G ln J + lambda/2 (ln J)^2.
module law_neohooke
  use kinds, only: wp
  use vectors, only: invert
  use deformation, only: volume_growth, log_one_plus, green_strain
  implicit none
  private
  public :: neohooke_point, neohooke_volume

contains

  !> First Piola-Kirchhoff stress, its derivative and the energy of one point. With lambda 0 the
  !! part that the mean dilatation leaves to the point.
  pure subroutine neohooke_point(lambda, g, gradient, p, energy, a)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(in) :: gradient(3, 3) !! displacement gradient F - I, det F > 0
    real(wp), intent(out) :: p(3, 3) !! stress P_iJ [force/length^2]
    real(wp), intent(out) :: energy !! W [force/length^2]
    real(wp), intent(out), optional :: a(3, 3, 3, 3) !! A_iJkL = dP_iJ/dF_kL [force/length^2]
    real(wp) :: f(3, 3), h(3, 3), strain(3, 3), log_j, j
    integer :: i, k, l, m

    f = gradient
    do i = 1, 3
      f(i, i) = f(i, i) + 1.0_wp
    end do
    call invert(f, h, j)
    h = transpose(h)
    log_j = log_one_plus(volume_growth(gradient))
    strain = green_strain(gradient)
    ! F - F^-T = F^-T (F^T F - I)
    p = 2.0_wp*g*matmul(h, strain) + lambda*log_j*h
    energy = g*(strain(1, 1) + strain(2, 2) + strain(3, 3) - log_j) + 0.5_wp*lambda*log_j**2
    if (.not. present(a)) return
    do l = 1, 3
      do k = 1, 3
        do m = 1, 3
          do i = 1, 3
            ! h = F^-T: F^-T_iL F^-T_kJ
            a(i, m, k, l) = lambda*h(i, m)*h(k, l) + (g - lambda*log_j)*h(i, l)*h(k, m)
          end do
        end do
        a(k, l, k, l) = a(k, l, k, l) + g
      end do
    end do
  end subroutine neohooke_point

  !> The volumetric energy U = lambda/2 (ln J)^2 and its slopes.
  pure subroutine neohooke_volume(lambda, growth, u, slope, curvature)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: growth !! J - 1: growth of the volume over that of the reference, > -1
    real(wp), intent(out) :: u !! U [force/length^2]
    real(wp), intent(out) :: slope !! dU/dJ [force/length^2]
    real(wp), intent(out) :: curvature !! d2U/dJ2 [force/length^2]
    real(wp) :: log_j

    log_j = log_one_plus(growth)
    u = 0.5_wp*lambda*log_j**2
    slope = lambda*log_j/(1.0_wp + growth)
    curvature = lambda*(1.0_wp - log_j)/(1.0_wp + growth)**2
  end subroutine neohooke_volume
end module law_neohooke

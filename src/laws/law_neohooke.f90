!> SOLId NEOHookean: compressible, the energy of FEAPpv (doc/theory, "Finite strain").
!!
!! W = G/2 (I1 - 3) - G ln J + lambda/2 (ln J)^2.
module law_neohooke
  use kinds, only: wp
  use vectors, only: invert
  implicit none
  private
  public :: neohooke_point, neohooke_volume

contains

  !> First Piola-Kirchhoff stress, its derivative and the energy of one point. With lambda 0 the
  !! part that the mean dilatation leaves to the point.
  pure subroutine neohooke_point(lambda, g, f, p, a, energy)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(in) :: f(3, 3) !! deformation gradient, det > 0
    real(wp), intent(out) :: p(3, 3) !! stress P_iJ [force/length^2]
    real(wp), intent(out) :: a(3, 3, 3, 3) !! A_iJkL = dP_iJ/dF_kL [force/length^2]
    real(wp), intent(out) :: energy !! W [force/length^2]
    real(wp) :: h(3, 3), log_j, j
    integer :: k, l

    call invert(f, h, j)
    h = transpose(h)
    log_j = log(j)
    p = g*(f - h) + lambda*log_j*h
    energy = 0.5_wp*g*(sum(f**2) - 3.0_wp) - g*log_j + 0.5_wp*lambda*log_j**2
    do l = 1, 3
      do k = 1, 3
        ! h = F^-T: F^-T_iL F^-T_kJ
        a(:, :, k, l) = lambda*h*h(k, l) &
          + (g - lambda*log_j)*spread(h(:, l), 2, 3)*spread(h(k, :), 1, 3)
        a(k, l, k, l) = a(k, l, k, l) + g
      end do
    end do
  end subroutine neohooke_point

  !> The volumetric energy U = lambda/2 (ln J)^2 and its slopes.
  pure subroutine neohooke_volume(lambda, j, u, slope, curvature)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: j !! volume over that of the reference, > 0
    real(wp), intent(out) :: u !! U [force/length^2]
    real(wp), intent(out) :: slope !! dU/dJ [force/length^2]
    real(wp), intent(out) :: curvature !! d2U/dJ2 [force/length^2]

    u = 0.5_wp*lambda*log(j)**2
    slope = lambda*log(j)/j
    curvature = lambda*(1.0_wp - log(j))/j**2
  end subroutine neohooke_volume
end module law_neohooke

!> SOLId NEOHookean: compressible, the energy of FEAPpv (doc/theory, "Finite strain", eqs. (8.9),
!! (8.10)).
!!
!! W = G/2 (I1 - 3) - G ln J + lambda/2 (ln J)^2.
module law_neohooke
  use kinds, only: wp
  use law_types, only: bulk_law_t, bulk_point_t
  use vectors, only: invert
  use deformation, only: volume_growth, log_one_plus, green_strain
  implicit none
  private
  public :: neohooke_law, neohooke_point, neohooke_points, neohooke_volume, points_at_once

  type(bulk_law_t), parameter :: neohooke_law = bulk_law_t('NEOHookean', &
    'neo-Hooke, finite strain', finite=.true., may_mean=.true.)

  !> Points that are computed at once.
  integer, parameter :: points_at_once = 16

contains

  !> Stress, energy and derivative of one point. With lambda 0 the part that the mean dilatation
  !! leaves to the point.
  pure subroutine neohooke_point(slope, q)
    logical, intent(in) :: slope !! the derivative is asked for
    type(bulk_point_t), intent(inout) :: q !! gradient given; gets p, energy, a
    real(wp) :: f(3, 3), h(3, 3), strain(3, 3), log_j, j
    integer :: i, k, l, m

    f = q%gradient
    do i = 1, 3
      f(i, i) = f(i, i) + 1.0_wp
    end do
    call invert(f, h, j)
    h = transpose(h)
    log_j = log_one_plus(volume_growth(q%gradient))
    strain = green_strain(q%gradient)
    ! F - F^-T = F^-T (F^T F - I)
    q%p = 2.0_wp*q%g*matmul(h, strain) + q%lambda*log_j*h
    q%energy = q%g*(strain(1, 1) + strain(2, 2) + strain(3, 3) - log_j) &
      + 0.5_wp*q%lambda*log_j**2
    if (.not. slope) return
    do l = 1, 3
      do k = 1, 3
        do m = 1, 3
          do i = 1, 3
            ! h = F^-T: F^-T_iL F^-T_kJ
            q%a(i, m, k, l) = q%lambda*h(i, m)*h(k, l) &
              + (q%g - q%lambda*log_j)*h(i, l)*h(k, m)
          end do
        end do
        q%a(k, l, k, l) = q%a(k, l, k, l) + q%g
      end do
    end do
  end subroutine neohooke_point

  !> The same of many points, one statement for all of them. Where det F is not above zero the rest
  !! is without meaning.
  pure subroutine neohooke_points(lambda, g, h, p, energy, away, j, turning)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(in) :: h(points_at_once, 3, 3) !! displacement gradients F - I
    real(wp), intent(out) :: p(points_at_once, 3, 3) !! stress P_iJ [force/length^2]
    real(wp), intent(out) :: energy(points_at_once) !! W [force/length^2]
    real(wp), intent(out) :: away(points_at_once, 3, 3) !! F^-T
    real(wp), intent(out) :: j(points_at_once) !! det F
    real(wp), intent(out) :: turning(points_at_once) !! A_iJkL = lambda F^-T_iJ F^-T_kL
    !! + G d_ik d_JL + this F^-T_iL F^-T_kJ [force/length^2]
    real(wp) :: growth(points_at_once), log_j(points_at_once), share(points_at_once)
    real(wp) :: f(3, 3), a(3, 3), strain(3, 3)
    integer :: m, i, k

    do m = 1, points_at_once
      do k = 1, 3
        do i = 1, 3
          f(i, k) = h(m, i, k)
        end do
      end do
      growth(m) = f(1, 1) + f(2, 2) + f(3, 3) + (f(1, 1)*f(2, 2) - f(1, 2)*f(2, 1)) &
        + (f(2, 2)*f(3, 3) - f(2, 3)*f(3, 2)) + (f(3, 3)*f(1, 1) - f(3, 1)*f(1, 3)) &
        + f(1, 1)*(f(2, 2)*f(3, 3) - f(3, 2)*f(2, 3)) + f(2, 1)*(f(3, 2)*f(1, 3) &
        - f(1, 2)*f(3, 3)) + f(3, 1)*(f(1, 2)*f(2, 3) - f(2, 2)*f(1, 3))
      do i = 1, 3
        f(i, i) = f(i, i) + 1.0_wp
      end do
      a(:, 1) = [f(2, 2)*f(3, 3) - f(3, 2)*f(2, 3), f(3, 2)*f(1, 3) - f(1, 2)*f(3, 3), &
        f(1, 2)*f(2, 3) - f(2, 2)*f(1, 3)]
      a(:, 2) = [f(2, 3)*f(3, 1) - f(3, 3)*f(2, 1), f(3, 3)*f(1, 1) - f(1, 3)*f(3, 1), &
        f(1, 3)*f(2, 1) - f(2, 3)*f(1, 1)]
      a(:, 3) = [f(2, 1)*f(3, 2) - f(3, 1)*f(2, 2), f(3, 1)*f(1, 2) - f(1, 1)*f(3, 2), &
        f(1, 1)*f(2, 2) - f(2, 1)*f(1, 2)]
      j(m) = f(1, 1)*a(1, 1) + f(2, 1)*a(2, 1) + f(3, 1)*a(3, 1)
      do k = 1, 3
        do i = 1, 3
          away(m, i, k) = a(i, k)
        end do
      end do
    end do
    do m = 1, points_at_once
      share(m) = 1.0_wp
      if (j(m) > 0.0_wp) share(m) = 1.0_wp/j(m)
      log_j(m) = log_one_plus(max(growth(m), epsilon(1.0_wp) - 1.0_wp))
    end do
    do m = 1, points_at_once
      do k = 1, 3
        do i = 1, 3
          a(i, k) = share(m)*away(m, i, k)
          away(m, i, k) = a(i, k)
          strain(i, k) = 0.5_wp*(h(m, i, k) + h(m, k, i) + (h(m, 1, i)*h(m, 1, k) &
            + h(m, 2, i)*h(m, 2, k) + h(m, 3, i)*h(m, 3, k)))
        end do
      end do
      do k = 1, 3
        do i = 1, 3
          p(m, i, k) = 2.0_wp*g*(a(i, 1)*strain(1, k) + a(i, 2)*strain(2, k) &
            + a(i, 3)*strain(3, k)) + lambda*log_j(m)*a(i, k)
        end do
      end do
      energy(m) = g*(strain(1, 1) + strain(2, 2) + strain(3, 3) - log_j(m)) &
        + 0.5_wp*lambda*log_j(m)**2
      turning(m) = g - lambda*log_j(m)
    end do
  end subroutine neohooke_points

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

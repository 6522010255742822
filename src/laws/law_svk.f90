!> SOLId SVK: Saint-Venant-Kirchhoff (doc/theory, "Finite strain", eq. (8.11)).
!!
!! S = lambda tr E I + 2 G E. It softens in compression: at a stretch of 1/sqrt(3) it gives way.
module law_svk
  use kinds, only: wp
  use deformation, only: green_strain
  implicit none
  private
  public :: svk_point

contains

  !> First Piola-Kirchhoff stress, its derivative and the energy of one point.
  pure subroutine svk_point(lambda, g, gradient, p, energy, a)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(in) :: gradient(3, 3) !! displacement gradient F - I
    real(wp), intent(out) :: p(3, 3) !! stress P_iJ [force/length^2]
    real(wp), intent(out) :: energy !! W [force/length^2]
    real(wp), intent(out), optional :: a(3, 3, 3, 3) !! A_iJkL = dP_iJ/dF_kL [force/length^2]
    real(wp) :: f(3, 3), strain(3, 3), s(3, 3), b(3, 3), trace
    integer :: i, k, l

    f = gradient
    do i = 1, 3
      f(i, i) = f(i, i) + 1.0_wp
    end do
    strain = green_strain(gradient)
    trace = strain(1, 1) + strain(2, 2) + strain(3, 3)
    s = 2.0_wp*g*strain
    do i = 1, 3
      s(i, i) = s(i, i) + lambda*trace
    end do
    p = matmul(f, s)
    energy = 0.5_wp*lambda*trace**2 + g*sum(strain**2)
    if (.not. present(a)) return
    b = matmul(f, transpose(f))
    do l = 1, 3
      do k = 1, 3
        a(:, :, k, l) = lambda*f*f(k, l) + g*spread(f(:, l), 2, 3)*spread(f(k, :), 1, 3)
        a(:, l, k, l) = a(:, l, k, l) + g*b(:, k)
        a(k, :, k, l) = a(k, :, k, l) + s(:, l)
      end do
    end do
  end subroutine svk_point
end module law_svk

!> SOLId SVK: Saint-Venant-Kirchhoff (doc/theory, "Finite strain", eq. (8.11)).
!!
!! S = lambda tr E I + 2 G E. It softens in compression: at a stretch of 1/sqrt(3) it gives way.
module law_svk
  use kinds, only: wp
  use law_types, only: bulk_law_t, bulk_point_t
  use deformation, only: green_strain
  implicit none
  private
  public :: svk_law, svk_point

  type(bulk_law_t), parameter :: svk_law = bulk_law_t('SVK', &
    'Saint-Venant-Kirchhoff, finite strain', finite=.true.)

contains

  !> Stress, energy and derivative of one point.
  pure subroutine svk_point(slope, q)
    logical, intent(in) :: slope !! the derivative is asked for
    type(bulk_point_t), intent(inout) :: q !! gradient given; gets p, energy, a
    real(wp) :: f(3, 3), strain(3, 3), s(3, 3), b(3, 3), trace
    integer :: i, k, l

    f = q%gradient
    do i = 1, 3
      f(i, i) = f(i, i) + 1.0_wp
    end do
    strain = green_strain(q%gradient)
    trace = strain(1, 1) + strain(2, 2) + strain(3, 3)
    s = 2.0_wp*q%g*strain
    do i = 1, 3
      s(i, i) = s(i, i) + q%lambda*trace
    end do
    q%p = matmul(f, s)
    q%energy = 0.5_wp*q%lambda*trace**2 + q%g*sum(strain**2)
    if (.not. slope) return
    b = matmul(f, transpose(f))
    do l = 1, 3
      do k = 1, 3
        q%a(:, :, k, l) = q%lambda*f*f(k, l) + q%g*spread(f(:, l), 2, 3)*spread(f(k, :), 1, 3)
        q%a(:, l, k, l) = q%a(:, l, k, l) + q%g*b(:, k)
        q%a(k, :, k, l) = q%a(k, :, k, l) + s(:, l)
      end do
    end do
  end subroutine svk_point
end module law_svk

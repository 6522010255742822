!> Element 5 with four nodes and the neo-Hookean law, several at once, so that each statement works
!! on all of them: what elmt05 does with one point, in other words (doc/theory, "Finite strain").
module tetrahedra_at_once
  use kinds, only: wp
  use law_neohooke, only: neohooke_points, points_at_once
  implicit none
  private
  public :: points_at_once, tetrahedra_t, deform_tetrahedra, strain_tetrahedra, form_tangents, &
    is_reach_far

  !> The elements; index 1 of all arrays but s is that of the element.
  type :: tetrahedra_t
    real(wp) :: x(points_at_once, 3, 4) !! reference coordinates [length]
    real(wp) :: u(points_at_once, 3, 4) !! displacements [length]
    real(wp) :: gradient(points_at_once, 3, 2:4) !! dN_a/dX of the last three nodes [1/length]
    real(wp) :: volume(points_at_once) !! in the reference [length^3]
    real(wp) :: h(points_at_once, 3, 3) !! displacement gradient F - I
    real(wp) :: p(points_at_once, 3, 3) !! stress P_iJ [force/length^2]
    real(wp) :: away(points_at_once, 3, 3) !! F^-T
    real(wp) :: j(points_at_once) !! det F; not above zero: inside out
    real(wp) :: turning(points_at_once) !! G - lambda ln J [force/length^2]
    real(wp) :: energy(points_at_once) !! strain energy [force length]
    real(wp) :: r(points_at_once, 3, 4) !! internal force of the nodes [force]
    real(wp) :: s(3, 3, 4, 4, points_at_once) !! tangents dr_a/du_b [force/length]
  end type tetrahedra_t

contains

  !> Slopes of the shape functions, volumes and displacement gradients.
  pure subroutine deform_tetrahedra(e)
    type(tetrahedra_t), intent(inout) :: e !! x, u given; gets gradient, volume, h
    real(wp) :: a(3), b(3), c(3), six, slope(3, 2:4), u(3, 2:4)
    integer :: n, i, k

    do n = 1, points_at_once
      a = e%x(n, :, 2) - e%x(n, :, 1)
      b = e%x(n, :, 3) - e%x(n, :, 1)
      c = e%x(n, :, 4) - e%x(n, :, 1)
      slope(:, 2) = [b(2)*c(3) - b(3)*c(2), b(3)*c(1) - b(1)*c(3), b(1)*c(2) - b(2)*c(1)]
      slope(:, 3) = [c(2)*a(3) - c(3)*a(2), c(3)*a(1) - c(1)*a(3), c(1)*a(2) - c(2)*a(1)]
      slope(:, 4) = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
      six = a(1)*slope(1, 2) + a(2)*slope(2, 2) + a(3)*slope(3, 2)
      e%volume(n) = six/6.0_wp
      six = 1.0_wp/six
      do k = 2, 4
        do i = 1, 3
          slope(i, k) = slope(i, k)*six
          e%gradient(n, i, k) = slope(i, k)
          u(i, k) = e%u(n, i, k) - e%u(n, i, 1)
        end do
      end do
      do k = 1, 3
        do i = 1, 3
          e%h(n, i, k) = u(i, 2)*slope(k, 2) + u(i, 3)*slope(k, 3) + u(i, 4)*slope(k, 4)
        end do
      end do
    end do
  end subroutine deform_tetrahedra

  !> Stress, energy and internal force: r_a = V P grad N_a, and all four are in balance.
  pure subroutine strain_tetrahedra(lambda, g, e)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    type(tetrahedra_t), intent(inout) :: e !! h given; gets all behind it
    real(wp) :: r(3, 2:4)
    integer :: n, i, k

    call neohooke_points(lambda, g, e%h, e%p, e%energy, e%away, e%j, e%turning)
    do n = 1, points_at_once
      e%energy(n) = e%volume(n)*e%energy(n)
      do k = 2, 4
        do i = 1, 3
          r(i, k) = e%volume(n)*(e%p(n, i, 1)*e%gradient(n, 1, k) &
            + e%p(n, i, 2)*e%gradient(n, 2, k) + e%p(n, i, 3)*e%gradient(n, 3, k))
          e%r(n, i, k) = r(i, k)
        end do
      end do
      do i = 1, 3
        e%r(n, i, 1) = -(r(i, 2) + r(i, 3) + r(i, 4))
      end do
    end do
  end subroutine strain_tetrahedra

  !> Their tangents: with h_a = F^-T grad N_a
  !! K_ab = V (G grad N_a . grad N_b I + lambda h_a h_b^T + (G - lambda ln J) h_b h_a^T).
  pure subroutine form_tangents(lambda, g, e)
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    type(tetrahedra_t), intent(inout) :: e !! strained; gets s
    real(wp) :: slope(3, 4), h(3, 4), along(3), across(3), even
    integer :: n, a, b, k

    do n = 1, points_at_once
      slope(:, 2:4) = e%gradient(n, :, :)
      slope(:, 1) = -(slope(:, 2) + slope(:, 3) + slope(:, 4))
      do a = 1, 4
        h(:, a) = e%away(n, :, 1)*slope(1, a) + e%away(n, :, 2)*slope(2, a) &
          + e%away(n, :, 3)*slope(3, a)
      end do
      do b = 1, 4
        along = e%volume(n)*lambda*h(:, b)
        across = e%volume(n)*e%turning(n)*h(:, b)
        do a = 1, b
          even = e%volume(n)*g*(slope(1, a)*slope(1, b) + slope(2, a)*slope(2, b) &
            + slope(3, a)*slope(3, b))
          do k = 1, 3
            e%s(:, k, a, b, n) = h(:, a)*along(k) + across*h(k, a)
            e%s(k, k, a, b, n) = e%s(k, k, a, b, n) + even
          end do
          if (a < b) e%s(:, :, b, a, n) = transpose(e%s(:, :, a, b, n))
        end do
      end do
    end do
  end subroutine form_tangents

  !> Ways of which twice the length would turn no F inside out: |cof F| |dF| < det F/2.
  pure subroutine is_reach_far(e, du, far)
    type(tetrahedra_t), intent(in) :: e !! deformed
    real(wp), intent(in) :: du(points_at_once, 3, 4) !! ways on from there [length]
    logical, intent(out) :: far(points_at_once) !! it is so
    real(wp) :: room(points_at_once), f(3, 3), cofactor(3, 3), u(3, 2:4), square, way, j
    integer :: n, i, k

    do n = 1, points_at_once
      do k = 1, 3
        do i = 1, 3
          f(i, k) = e%h(n, i, k)
          u(i, k + 1) = du(n, i, k + 1) - du(n, i, 1)
        end do
        f(k, k) = f(k, k) + 1.0_wp
      end do
      cofactor(:, 1) = [f(2, 2)*f(3, 3) - f(3, 2)*f(2, 3), f(3, 2)*f(1, 3) - f(1, 2)*f(3, 3), &
        f(1, 2)*f(2, 3) - f(2, 2)*f(1, 3)]
      cofactor(:, 2) = [f(2, 3)*f(3, 1) - f(3, 3)*f(2, 1), f(3, 3)*f(1, 1) - f(1, 3)*f(3, 1), &
        f(1, 3)*f(2, 1) - f(2, 3)*f(1, 1)]
      cofactor(:, 3) = [f(2, 1)*f(3, 2) - f(3, 1)*f(2, 2), f(3, 1)*f(1, 2) - f(1, 1)*f(3, 2), &
        f(1, 1)*f(2, 2) - f(2, 1)*f(1, 2)]
      j = f(1, 1)*cofactor(1, 1) + f(2, 1)*cofactor(2, 1) + f(3, 1)*cofactor(3, 1)
      square = 0.0_wp
      way = 0.0_wp
      do k = 1, 3
        do i = 1, 3
          square = square + cofactor(i, k)**2
          way = way + (u(i, 2)*e%gradient(n, k, 2) + u(i, 3)*e%gradient(n, k, 3) &
            + u(i, 4)*e%gradient(n, k, 4))**2
        end do
      end do
      room(n) = j - 2.0_wp*sqrt(square*way)
    end do
    far = room > 0.0_wp
  end subroutine is_reach_far
end module tetrahedra_at_once

!> Element 1: linear tetrahedron (T4), small strain, isotropic linear elastic.
!!
!! Constant strain; the matrix is exact (doc/theory, "Bulk elements"). Parameters d: E, nu.
!! task_stress gives the stress as xx yy zz xy yz zx in stress(1:6), and in stress(7:9) the rotation
!! vector, half the curl of the displacements.
module elmt01
  use kinds, only: wp
  use vectors, only: cross
  use element_types, only: element_t, task_tangent, task_residual, task_stress, max_dofs
  implicit none
  private
  public :: elmt01_t4, d01_youngs_modulus, d01_poissons_ratio, d01_size

  integer, parameter :: d01_youngs_modulus = 1 !! place of E in d [force/length^2]
  integer, parameter :: d01_poissons_ratio = 2 !! place of nu in d
  integer, parameter :: d01_size = 2 !! length of d

contains

  !> Does one task for one element.
  pure subroutine elmt01_t4(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (d01_size) parameters
    type(element_t), intent(inout) :: e !! local data
    real(wp) :: gradient(3, 4), volume, lambda, g

    call shape_gradients(e%xl(:, 1:4), gradient, volume)
    call lame(d(d01_youngs_modulus), d(d01_poissons_ratio), lambda, g)
    select case (task)
    case (task_tangent)
      call stiffness(gradient, volume, lambda, g, e%s(:, 1:12))
      call internal_force(gradient, volume, stress_of(gradient, e%ul(:, 1:4), lambda, g), e%r)
    case (task_residual)
      call internal_force(gradient, volume, stress_of(gradient, e%ul(:, 1:4), lambda, g), e%r)
    case (task_stress)
      e%stress(1:6) = stress_of(gradient, e%ul(:, 1:4), lambda, g)
      e%stress(7:9) = rotation_of(gradient, e%ul(:, 1:4))
    case default
      ! What other routines know (task_stick_tangent) is nothing here.
    end select
  end subroutine elmt01_t4

  !> Lame's constants.
  pure subroutine lame(youngs_modulus, nu, lambda, g)
    real(wp), intent(in) :: youngs_modulus !! E [force/length^2]
    real(wp), intent(in) :: nu !! Poisson's ratio
    real(wp), intent(out) :: lambda !! first constant [force/length^2]
    real(wp), intent(out) :: g !! shear modulus [force/length^2]

    lambda = youngs_modulus*nu/((1.0_wp + nu)*(1.0_wp - 2.0_wp*nu))
    g = 0.5_wp*youngs_modulus/(1.0_wp + nu)
  end subroutine lame

  !> Gradients of the four shape functions, and the volume.
  pure subroutine shape_gradients(x, gradient, volume)
    real(wp), intent(in) :: x(3, 4) !! corner coordinates [length]
    real(wp), intent(out) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(out) :: volume !! [length^3]
    real(wp) :: a(3), b(3), c(3), six_volume

    a = x(:, 2) - x(:, 1)
    b = x(:, 3) - x(:, 1)
    c = x(:, 4) - x(:, 1)
    gradient(:, 2) = cross(b, c)
    gradient(:, 3) = cross(c, a)
    gradient(:, 4) = cross(a, b)
    six_volume = dot_product(a, gradient(:, 2))
    gradient(:, 2:4) = gradient(:, 2:4)/six_volume
    gradient(:, 1) = -(gradient(:, 2) + gradient(:, 3) + gradient(:, 4))
    volume = six_volume/6.0_wp
  end subroutine shape_gradients

  !> K_ab = V (lambda g_a g_b^T + G g_b g_a^T + G (g_a.g_b) I).
  pure subroutine stiffness(gradient, volume, lambda, g, s)
    real(wp), intent(in) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(in) :: volume !! [length^3]
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(inout) :: s(max_dofs, 12) !! its first 12 rows: tangent [force/length]
    integer :: a, b, i, j
    real(wp) :: product_ab

    do b = 1, 4
      do a = 1, 4
        product_ab = dot_product(gradient(:, a), gradient(:, b))
        do j = 1, 3
          do i = 1, 3
            s(3*a - 3 + i, 3*b - 3 + j) = volume*(lambda*gradient(i, a)*gradient(j, b) &
              + g*gradient(j, a)*gradient(i, b))
          end do
          s(3*a - 3 + j, 3*b - 3 + j) = s(3*a - 3 + j, 3*b - 3 + j) + volume*g*product_ab
        end do
      end do
    end do
  end subroutine stiffness

  !> Stress of the constant strain, as xx yy zz xy yz zx.
  pure function stress_of(gradient, ul, lambda, g) result(stress)
    real(wp), intent(in) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(in) :: ul(3, 4) !! displacements [length]
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp) :: stress(6), h(3, 3)

    h = matmul(ul, transpose(gradient))
    stress(1:3) = lambda*(h(1, 1) + h(2, 2) + h(3, 3)) + 2.0_wp*g*[h(1, 1), h(2, 2), h(3, 3)]
    stress(4:6) = g*[h(1, 2) + h(2, 1), h(2, 3) + h(3, 2), h(3, 1) + h(1, 3)]
  end function stress_of

  !> Rotation vector of the constant displacement gradient.
  pure function rotation_of(gradient, ul) result(w)
    real(wp), intent(in) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(in) :: ul(3, 4) !! displacements [length]
    real(wp) :: w(3), h(3, 3)

    h = matmul(ul, transpose(gradient))
    w = 0.5_wp*[h(3, 2) - h(2, 3), h(1, 3) - h(3, 1), h(2, 1) - h(1, 2)]
  end function rotation_of

  !> Internal force of a constant stress: r_a = V sigma g_a.
  pure subroutine internal_force(gradient, volume, stress, r)
    real(wp), intent(in) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(in) :: volume !! [length^3]
    real(wp), intent(in) :: stress(6) !! xx yy zz xy yz zx [force/length^2]
    real(wp), intent(out) :: r(12) !! [force]
    integer :: a
    real(wp) :: sigma(3, 3)

    sigma = reshape([stress(1), stress(4), stress(6), stress(4), stress(2), stress(5), &
      stress(6), stress(5), stress(3)], [3, 3])
    do a = 1, 4
      r(3*a - 2:3*a) = volume*matmul(sigma, gradient(:, a))
    end do
  end subroutine internal_force
end module elmt01

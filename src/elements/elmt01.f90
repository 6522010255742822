!> Element 1: linear tetrahedron (T4), small strain, isotropic linear elastic.
!!
!! Constant strain; the matrix is exact (doc/theory, "Four-node tetrahedron", eq. (8.1)). The
!! rotation vector of its state is half the curl of the displacements.
module elmt01
  use kinds, only: wp
  use element_types, only: task_tangent, task_residual, task_stress
  use solid_types, only: solid_t, most_solid_dofs, d_youngs_modulus, d_poissons_ratio, &
    state_stress, state_rotation, state_strain
  use solid_shapes, only: flat_gradients
  use law_linear, only: lame, linear_stress
  use deformation, only: small_strain, rotation_vector
  implicit none
  private
  public :: elmt01_t4

contains

  !> Does one task for one element.
  pure subroutine elmt01_t4(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (n_solid_parameters) parameters
    type(solid_t), intent(inout) :: e !! local data
    real(wp) :: gradient(3, 4), volume, lambda, g, h(3, 3), strain(6), stress(6)

    call flat_gradients(e%xl(:, 1:4), gradient, volume)
    call lame(d(d_youngs_modulus), d(d_poissons_ratio), lambda, g)
    h = matmul(e%ul(:, 1:4), transpose(gradient))
    strain = small_strain(h)
    stress = linear_stress(lambda, g, strain)
    e%energy = 0.5_wp*volume*(dot_product(stress(1:3), strain(1:3)) &
      + 2.0_wp*dot_product(stress(4:6), strain(4:6)))
    select case (task)
    case (task_tangent)
      call stiffness(gradient, volume, lambda, g, e%s(:, 1:12))
      call internal_force(gradient, volume, stress, e%r)
    case (task_residual)
      call internal_force(gradient, volume, stress, e%r)
    case (task_stress)
      e%state(state_stress) = stress
      e%state(state_strain) = strain
      e%state(state_rotation) = rotation_vector(h)
    case default
      ! task_reach: small strain never turns an element inside out.
    end select
  end subroutine elmt01_t4

  !> K_ab = V (lambda g_a g_b^T + G g_b g_a^T + G (g_a.g_b) I).
  pure subroutine stiffness(gradient, volume, lambda, g, s)
    real(wp), intent(in) :: gradient(3, 4) !! dN_a/dx [1/length]
    real(wp), intent(in) :: volume !! [length^3]
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(inout) :: s(most_solid_dofs, 12) !! its first 12 rows: tangent [force/length]
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

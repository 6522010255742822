!> Element 2: tetrahedra of any number of nodes, small strain, isotropic linear elastic.
!!
!! Sums over the points of solid_shapes. With d_mean the volumetric part goes with the mean
!! dilatation of the element (doc/theory, "Near incompressibility", eqs. (8.4), (8.5)).
module elmt02
  use kinds, only: wp
  use element_types, only: task_tangent, task_residual, task_stress
  use solid_types, only: solid_t, most_solid_dofs, d_youngs_modulus, d_poissons_ratio, d_mean, &
    state_stress, state_rotation, state_strain
  use solid_shapes, only: solid_rule_t, solid_rule
  use law_linear, only: lame, linear_stress
  use deformation, only: small_strain, rotation_vector
  implicit none
  private
  public :: elmt02_small

contains

  !> Does one task for one element.
  pure subroutine elmt02_small(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (n_solid_parameters) parameters
    type(solid_t), intent(inout) :: e !! local data
    type(solid_rule_t) :: rule
    real(wp) :: lambda, g, dilatation
    logical :: mean

    call solid_rule(e%nel, e%xl(:, :e%nel), rule)
    call lame(d(d_youngs_modulus), d(d_poissons_ratio), lambda, g)
    mean = d(d_mean) > 0.0_wp
    dilatation = mean_dilatation(rule, e)
    select case (task)
    case (task_tangent)
      call add_forces(rule, lambda, g, mean, dilatation, e)
      call add_stiffness(rule, lambda, g, mean, e)
    case (task_residual)
      call add_forces(rule, lambda, g, mean, dilatation, e)
    case (task_stress)
      call find_state(rule, lambda, g, mean, dilatation, e)
    case default
      ! task_reach: small strain never turns an element inside out.
    end select
  end subroutine elmt02_small

  !> Displacement gradient at one point.
  pure function slope_at(rule, q, e) result(h)
    type(solid_rule_t), intent(in) :: rule !! points
    integer, intent(in) :: q !! the point
    type(solid_t), intent(in) :: e !! displacements
    real(wp) :: h(3, 3)

    h = matmul(e%ul(:, :e%nel), transpose(rule%gradient(:, :e%nel, q)))
  end function slope_at

  !> Stress of one point: W = G e:e with the strain of the point, lambda/2 (tr e)^2 with that of the
  !! element if it goes with the mean dilatation.
  pure function stress_at(h, lambda, g, mean, dilatation) result(stress)
    real(wp), intent(in) :: h(3, 3) !! displacement gradient
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    logical, intent(in) :: mean !! the volumetric part is that of the element
    real(wp), intent(in) :: dilatation !! mean dilatation of the element
    real(wp) :: stress(6)

    stress = linear_stress(merge(0.0_wp, lambda, mean), g, small_strain(h))
    if (mean) stress(1:3) = stress(1:3) + lambda*dilatation
  end function stress_at

  !> Mean of tr e over the element.
  pure real(wp) function mean_dilatation(rule, e) result(mean)
    type(solid_rule_t), intent(in) :: rule !! points
    type(solid_t), intent(in) :: e !! displacements
    integer :: q

    mean = 0.0_wp
    do q = 1, rule%n
      mean = mean + rule%weight(q)*sum(rule%gradient(:, :e%nel, q)*e%ul(:, :e%nel))
    end do
    mean = mean/sum(rule%weight(:rule%n))
  end function mean_dilatation

  !> r_a = sum over the points of w sigma g_a, and the energy.
  pure subroutine add_forces(rule, lambda, g, mean, dilatation, e)
    type(solid_rule_t), intent(in) :: rule !! points
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    logical, intent(in) :: mean !! the volumetric part is that of the element
    real(wp), intent(in) :: dilatation !! mean dilatation of the element
    type(solid_t), intent(inout) :: e !! displacements; gets r, energy
    real(wp) :: stress(6), strain(6), force(3, e%nel)
    integer :: q

    e%r(:3*e%nel) = 0.0_wp
    e%energy = 0.0_wp
    do q = 1, rule%n
      associate (h => slope_at(rule, q, e))
        stress = stress_at(h, lambda, g, mean, dilatation)
        strain = small_strain(h)
      end associate
      force = rule%weight(q)*matmul(reshape(stress([1, 4, 6, 4, 2, 5, 6, 5, 3]), [3, 3]), &
        rule%gradient(:, :e%nel, q))
      e%r(:3*e%nel) = e%r(:3*e%nel) + reshape(force, [3*e%nel])
      e%energy = e%energy + 0.5_wp*rule%weight(q)*(dot_product(stress(1:3), strain(1:3)) &
        + 2.0_wp*dot_product(stress(4:6), strain(4:6)))
    end do
  end subroutine add_forces

  !> K_ab = sum w (lambda g_a g_b^T + G g_b g_a^T + G (g_a.g_b) I); with the mean dilatation the
  !! first term is lambda/V b_a b_b^T with b_a = sum w g_a.
  pure subroutine add_stiffness(rule, lambda, g, mean, e)
    type(solid_rule_t), intent(in) :: rule !! points
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    logical, intent(in) :: mean !! the volumetric part is that of the element
    type(solid_t), intent(inout) :: e !! gets s
    real(wp) :: whole(3, e%nel)
    integer :: q

    e%s(:3*e%nel, :3*e%nel) = 0.0_wp
    whole = 0.0_wp
    do q = 1, rule%n
      call add_point(rule%gradient(:, :e%nel, q), rule%weight(q), merge(0.0_wp, lambda, mean), g, &
        e%s)
      whole = whole + rule%weight(q)*rule%gradient(:, :e%nel, q)
    end do
    if (mean) call add_point(whole, 1.0_wp, lambda/sum(rule%weight(:rule%n)), 0.0_wp, e%s)
  end subroutine add_stiffness

  !> The matrix of one point.
  pure subroutine add_point(gradient, weight, lambda, g, s)
    real(wp), intent(in) :: gradient(:, :) !! (3, nel) dN_a/dX [1/length]
    real(wp), intent(in) :: weight !! share of the volume [length^3]
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    real(wp), intent(inout) :: s(most_solid_dofs, most_solid_dofs) !! tangent [force/length]
    integer :: a, b, i, j
    real(wp) :: both

    do b = 1, size(gradient, 2)
      do a = 1, size(gradient, 2)
        both = weight*g*dot_product(gradient(:, a), gradient(:, b))
        do j = 1, 3
          do i = 1, 3
            s(3*a - 3 + i, 3*b - 3 + j) = s(3*a - 3 + i, 3*b - 3 + j) + weight*(lambda &
              *gradient(i, a)*gradient(j, b) + g*gradient(j, a)*gradient(i, b))
          end do
          s(3*a - 3 + j, 3*b - 3 + j) = s(3*a - 3 + j, 3*b - 3 + j) + both
        end do
      end do
    end do
  end subroutine add_point

  !> Stress and strain of the points, and their means by volume.
  pure subroutine find_state(rule, lambda, g, mean, dilatation, e)
    type(solid_rule_t), intent(in) :: rule !! points
    real(wp), intent(in) :: lambda !! Lame's first constant [force/length^2]
    real(wp), intent(in) :: g !! shear modulus [force/length^2]
    logical, intent(in) :: mean !! the volumetric part is that of the element
    real(wp), intent(in) :: dilatation !! mean dilatation of the element
    type(solid_t), intent(inout) :: e !! displacements; gets state
    real(wp) :: share
    integer :: q

    call add_forces(rule, lambda, g, mean, dilatation, e)
    e%state = 0.0_wp
    e%even = 0.0_wp
    if (mean) e%even = [lambda*dilatation, dilatation/3.0_wp]
    e%state(state_stress(1:3)) = e%even(1)
    e%state(state_strain(1:3)) = e%even(2)
    do q = 1, rule%n
      share = rule%weight(q)/sum(rule%weight(:rule%n))
      associate (h => slope_at(rule, q, e))
        e%points(:6, q) = stress_at(h, lambda, g, mean, 0.0_wp)
        e%points(7:, q) = small_strain(h)
        if (mean) e%points(7:9, q) = e%points(7:9, q) - sum(e%points(7:9, q))/3.0_wp
        e%state(state_stress) = e%state(state_stress) + share*e%points(:6, q)
        e%state(state_strain) = e%state(state_strain) + share*e%points(7:, q)
        e%state(state_rotation) = e%state(state_rotation) + share*rotation_vector(h)
      end associate
    end do
  end subroutine find_state
end module elmt02

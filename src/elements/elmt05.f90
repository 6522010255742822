!> Element 5: tetrahedra of any number of nodes, total Lagrangian, any law of finite strain, and
!! those of small strain that are not linear.
!!
!! F = I + u_a (x) grad N_a, r_a = int P grad N_a dV; the volume integrals are those of the
!! reference (doc/theory, "Finite strain", eqs. (8.8), (8.13)). With d_mean the volumetric energy
!! goes with the mean dilatation of the element.
module elmt05
  use kinds, only: wp
  use vectors, only: cross, invert, sum_products
  use element_types, only: task_tangent, task_stress, task_reach
  use solid_types, only: solid_t, most_solid_dofs, d_youngs_modulus, d_poissons_ratio, d_mean, &
    d_own, state_stress, state_strain, state_rotation
  use solid_shapes, only: solid_rule_t, solid_rule
  use law_linear, only: lame
  use deformation, only: volume_growth, green_strain, small_strain, rotation_vector
  use law_neohooke, only: neohooke_volume
  use law_types, only: bulk_point_t
  use cubic_roots, only: first_positive_root
  implicit none
  private
  public :: elmt05_finite

  !> A way of which so many times the length could not turn F inside out is not looked at closer.
  real(wp), parameter :: short_way = 2.0_wp

contains

  !> Does one task for one element. Where it is turned inside out it only says so.
  pure subroutine elmt05_finite(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (n_solid_parameters) parameters
    type(solid_t), intent(inout) :: e !! local data
    type(solid_rule_t) :: rule

    call solid_rule(e%nel, e%xl(:, :e%nel), rule)
    if (task == task_reach) then
      call find_reach(rule, e)
      return
    end if
    e%r(:3*e%nel) = 0.0_wp
    if (task == task_tangent) e%s(:3*e%nel, :3*e%nel) = 0.0_wp
    e%energy = 0.0_wp
    e%state = 0.0_wp
    e%even = 0.0_wp
    call add_points(task, d, rule, e)
    if (e%inverted) return
    if (d(d_mean) > 0.0_wp) call add_volume(task, d, rule, e)
  end subroutine elmt05_finite

  !> Deformation gradient at one point, its determinant, and the displacement gradient.
  pure subroutine deform(rule, q, e, f, j, gradient)
    type(solid_rule_t), intent(in) :: rule !! points
    integer, intent(in) :: q !! the point
    type(solid_t), intent(in) :: e !! displacements
    real(wp), intent(out) :: f(3, 3) !! F
    real(wp), intent(out) :: j !! det F
    real(wp), intent(out) :: gradient(3, 3) !! F - I
    integer :: i

    gradient = sum_products(e%ul(:, :e%nel), rule%gradient(:, :e%nel, q))
    f = gradient
    do i = 1, 3
      f(i, i) = f(i, i) + 1.0_wp
    end do
    j = dot_product(f(:, 1), cross(f(:, 2), f(:, 3)))
  end subroutine deform

  !> What the points give: force, matrix, energy, state.
  pure subroutine add_points(task, d, rule, e)
    integer, intent(in) :: task !! what is wanted
    real(wp), intent(in) :: d(:) !! parameters
    type(solid_rule_t), intent(in) :: rule !! points
    type(solid_t), intent(inout) :: e !! local data
    type(bulk_point_t) :: point
    real(wp) :: f(3, 3), j
    integer :: q

    call lame(d(d_youngs_modulus), d(d_poissons_ratio), point%lambda, point%g)
    if (d(d_mean) > 0.0_wp) point%lambda = 0.0_wp
    point%own = d(d_own:)
    e%inverted = .false.
    do q = 1, rule%n
      call deform(rule, q, e, f, j, point%gradient)
      e%inverted = e%finite .and. .not. j > 0.0_wp
      if (e%inverted) return
      point%old = e%old(:, q)
      call e%point(task == task_tangent, point)
      e%new(:, q) = point%new
      associate (w => rule%weight(q), gradient => rule%gradient(:, :e%nel, q))
        e%energy = e%energy + w*point%energy
        call add_force(gradient, w*point%p, e%r)
        if (task == task_tangent) call add_matrix(gradient, w*point%a, e%s)
        if (task == task_stress) call add_state(q, w/sum(rule%weight(:rule%n)), f, j, &
          point, e)
      end associate
    end do
  end subroutine add_points

  !> r_a = P grad N_a.
  pure subroutine add_force(gradient, p, r)
    real(wp), intent(in) :: gradient(:, :) !! (3, nel) dN_a/dX [1/length]
    real(wp), intent(in) :: p(3, 3) !! weight times P [force length]
    real(wp), intent(inout) :: r(most_solid_dofs) !! internal force [force]
    integer :: n

    do n = 1, size(gradient, 2)
      r(3*n - 2:3*n) = r(3*n - 2:3*n) + p(:, 1)*gradient(1, n) + p(:, 2)*gradient(2, n) &
        + p(:, 3)*gradient(3, n)
    end do
  end subroutine add_force

  !> K_aibk = N_a,J A_iJkL N_b,L.
  pure subroutine add_matrix(gradient, a, s)
    real(wp), intent(in) :: gradient(:, :) !! (3, nel) dN_a/dX [1/length]
    real(wp), intent(in) :: a(3, 3, 3, 3) !! weight times A [force length]
    real(wp), intent(inout) :: s(most_solid_dofs, most_solid_dofs) !! tangent [force/length]
    real(wp) :: half(3, 3, 3)
    integer :: na, nb, k

    do nb = 1, size(gradient, 2)
      half = a(:, :, :, 1)*gradient(1, nb) + a(:, :, :, 2)*gradient(2, nb) &
        + a(:, :, :, 3)*gradient(3, nb)
      do na = 1, size(gradient, 2)
        do k = 1, 3
          s(3*na - 2:3*na, 3*nb - 3 + k) = s(3*na - 2:3*na, 3*nb - 3 + k) &
            + (half(:, 1, k)*gradient(1, na) + half(:, 2, k)*gradient(2, na) &
               + half(:, 3, k)*gradient(3, na))
        end do
      end do
    end do
  end subroutine add_matrix

  !> Cauchy stress sigma = P F^T/J and Green's strain, or stress, strain and rotation where strain
  !! is small, of the point and as means.
  pure subroutine add_state(q, share, f, j, point, e)
    integer, intent(in) :: q !! the point
    real(wp), intent(in) :: share !! of the element's volume
    real(wp), intent(in) :: f(3, 3) !! deformation gradient
    real(wp), intent(in) :: j !! its determinant
    type(bulk_point_t), intent(in) :: point !! gradient, stress
    type(solid_t), intent(inout) :: e !! gets state

    associate (h => point%gradient)
      if (e%finite) then
        e%points(:6, q) = components(matmul(point%p, transpose(f))/j)
        e%points(7:, q) = components(green_strain(h))
      else
        e%points(:6, q) = components(point%p)
        e%points(7:, q) = small_strain(h)
        e%state(state_rotation) = e%state(state_rotation) + share*rotation_vector(h)
      end if
    end associate
    e%state(state_stress) = e%state(state_stress) + share*e%points(:6, q)
    e%state(state_strain) = e%state(state_strain) + share*e%points(7:, q)
  end subroutine add_state

  !> xx yy zz xy yz zx of a symmetric tensor.
  pure function components(a) result(c)
    real(wp), intent(in) :: a(3, 3) !! the tensor
    real(wp) :: c(6)

    c = [a(1, 1), a(2, 2), a(3, 3), a(1, 2), a(2, 3), a(3, 1)]
  end function components

  !> The volumetric energy V U(J_e) on the mean dilatation J_e: with b_a = int J F^-T grad N_a,
  !! r_a = U' b_a, K_ab = U''/V b_a b_b^T + U' int J (c_a c_b^T - c_b c_a^T), c_a = F^-T grad N_a.
  pure subroutine add_volume(task, d, rule, e)
    integer, intent(in) :: task !! what is wanted
    real(wp), intent(in) :: d(:) !! parameters
    type(solid_rule_t), intent(in) :: rule !! points
    type(solid_t), intent(inout) :: e !! local data
    real(wp) :: lambda, g, f(3, 3), j, h(3, 3), growth, volume, u, slope, curvature
    real(wp) :: b(3*e%nel), c(3, e%nel, rule%n), js(rule%n)
    integer :: q, n

    n = 3*e%nel
    call lame(d(d_youngs_modulus), d(d_poissons_ratio), lambda, g)
    volume = sum(rule%weight(:rule%n))
    b = 0.0_wp
    growth = 0.0_wp
    do q = 1, rule%n
      call deform(rule, q, e, f, j, h)
      growth = growth + rule%weight(q)*volume_growth(h)
      call invert(f, h, j)
      c(:, :, q) = matmul(transpose(h), rule%gradient(:, :e%nel, q))
      js(q) = rule%weight(q)*j
      b = b + reshape(js(q)*c(:, :, q), [n])
    end do
    call neohooke_volume(lambda, growth/volume, u, slope, curvature)
    e%energy = e%energy + volume*u
    e%r(:n) = e%r(:n) + slope*b
    if (task == task_stress) e%state(state_stress(1:3)) = e%state(state_stress(1:3)) + slope
    if (task == task_stress) e%even(1) = slope
    if (task /= task_tangent) return
    e%s(:n, :n) = e%s(:n, :n) + curvature/volume*spread(b, 2, n)*spread(b, 1, n)
    do q = 1, rule%n
      call add_turning(slope*js(q), c(:, :, q), e%s)
    end do
  end subroutine add_volume

  !> factor (c_a c_b^T - c_b c_a^T).
  pure subroutine add_turning(factor, c, s)
    real(wp), intent(in) :: factor !! U' J dV [force length]
    real(wp), intent(in) :: c(:, :) !! (3, nel) F^-T grad N_a [1/length]
    real(wp), intent(inout) :: s(most_solid_dofs, most_solid_dofs) !! tangent [force/length]
    integer :: na, nb, k

    do nb = 1, size(c, 2)
      do na = 1, size(c, 2)
        do k = 1, 3
          s(3*na - 2:3*na, 3*nb - 3 + k) = s(3*na - 2:3*na, 3*nb - 3 + k) &
            + factor*(c(:, na)*c(k, nb) - c(:, nb)*c(k, na))
        end do
      end do
    end do
  end subroutine add_turning

  !> Share of the way dul at which det F is zero first: along it det(F + a dF) is a cubic in a.
  pure subroutine find_reach(rule, e)
    type(solid_rule_t), intent(in) :: rule !! points
    type(solid_t), intent(inout) :: e !! ul, dul given; gets reach
    real(wp) :: f(3, 3), h(3, 3), df(3, 3), cofactor(3, 3), dcofactor(3, 3), j
    integer :: q

    e%reach = huge(1.0_wp)
    if (.not. e%finite) return
    do q = 1, rule%n
      call deform(rule, q, e, f, j, h)
      df = sum_products(e%dul(:, :e%nel), rule%gradient(:, :e%nel, q))
      cofactor = cofactors(f)
      if (short_way*norm2(cofactor)*norm2(df) < j) cycle
      dcofactor = cofactors(df)
      e%reach = min(e%reach, first_positive_root([j, sum(cofactor*df), sum(dcofactor*f), &
        dot_product(df(:, 1), dcofactor(:, 1))]))
    end do
  end subroutine find_reach

  !> Cofactors of a matrix: its inverse transposed times its determinant.
  pure function cofactors(a) result(c)
    real(wp), intent(in) :: a(3, 3) !! the matrix
    real(wp) :: c(3, 3)

    c(:, 1) = cross(a(:, 2), a(:, 3))
    c(:, 2) = cross(a(:, 3), a(:, 1))
    c(:, 3) = cross(a(:, 1), a(:, 2))
  end function cofactors
end module elmt05

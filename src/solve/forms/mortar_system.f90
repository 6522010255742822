!> The system of the multipliers in the condensed form: what their weighted gaps are without them,
!! and their compliance (doc/theory, "Mortar contact", eqs. (7.17), (7.18)).
module mortar_system
  use kinds, only: wp
  use model_types, only: model_t
  use mortar_history, only: add_forces
  use mortar_unknowns, only: mortar_system_t, join_rows, find_gaps, take_cones, local_forces, across
  use mortar_compliance, only: add_body, find_motions
  use live_candidates, only: gather_compliance, complete_compliance
  use system_types, only: form_t, system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: build_mortar, anchor_mortar, spread_forces

contains

  !> Gaps, compliance, rigid motions and cones of all multipliers.
  subroutine build_mortar(model, system, form, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(in) :: system !! loaded displacements, prescribed u; compliances
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    type(mortar_system_t), intent(out) :: unknowns !! the system
    real(wp) :: x(3, size(system%u, 2))
    integer :: b, c

    call join_rows(model, unknowns)
    if (form%condensed%rigid%modes + system%tools%unknowns > 0) then
      call find_gaps(model, system, system%position%x_now, unknowns)
      unknowns%near = unknowns%gap
    end if
    x = model%mesh%x + system%u
    associate (condensed => form%condensed)
      do c = 1, condensed%n
        x(condensed%direction(c), condensed%node(c)) = model%mesh%x(condensed%direction(c), &
          condensed%node(c)) + condensed%outer%loaded(c)
      end do
    end associate
    call find_gaps(model, system, x, unknowns)
    call gather_compliance(form%condensed)
    call complete_compliance(form%condensed)
    allocate (unknowns%compliance(3*unknowns%n, 3*unknowns%n), source=0.0_wp)
    do b = 1, size(form%condensed%bodies)
      if (form%condensed%bodies(b)%n_live > 0) call add_body(form%condensed, &
        form%condensed%bodies(b), unknowns)
    end do
    call find_motions(system, form, unknowns)
    allocate (unknowns%hold(size(unknowns%load), size(unknowns%load)), source=0.0_wp)
    associate (modes => form%condensed%rigid%modes)
      if (modes > 0) unknowns%hold(:modes, :modes) = form%condensed%rigid%spring
    end associate
    call add_penalties(model, unknowns)
    call drop_supported(system%equation, unknowns)
    call drop_compliance(system%equation, unknowns)
    call take_cones(model, unknowns)
  end subroutine build_mortar

  !> The same system with other rows: its gaps are the true ones at the forces and motions so far,
  !! and change with them by the compliance that is at hand. Rigid bodies with a point are where
  !! their motions have put them: these begin anew.
  subroutine anchor_mortar(model, system, form, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers, the same as before
    type(system_t), intent(in) :: system !! where forces and motions so far have put the bodies
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets gap, motion, push, cones
    integer :: i

    call find_gaps(model, system, system%position%x_now, unknowns)
    call find_motions(system, form, unknowns)
    call drop_supported(system%equation, unknowns)
    associate (z => local_forces(model, unknowns), alpha => form%condensed%rigid%alpha)
      unknowns%gap = unknowns%gap - matmul(unknowns%compliance, z)
      if (size(alpha) > 0) unknowns%gap = unknowns%gap - matmul(unknowns%motion(:, :size(alpha)), &
        alpha)
      do i = 1, unknowns%n
        associate (own => unknowns%gap(3*i - 2:3*i), mine => z(3*i - 2:3*i))
          own = own + unknowns%penalty(i)*mine + unknowns%stiff(i)*(mine - matmul(across( &
            system%equation(:, unknowns%rows%node(i)) > 0, unknowns%rows%frame(:, :, i)), mine))
        end associate
      end do
    end associate
    call take_cones(model, unknowns)
  end subroutine anchor_mortar

  !> Points of other forms give way by their penalties, eq. (7.22).
  pure subroutine add_penalties(model, unknowns)
    type(model_t), intent(in) :: model !! pairs with their rows
    type(mortar_system_t), intent(inout) :: unknowns !! compliance grows; gets penalty
    integer :: k, i

    allocate (unknowns%penalty(unknowns%n))
    do k = 1, size(model%pairs)
      unknowns%penalty(unknowns%start(k) + 1:unknowns%start(k + 1)) = &
        model%pairs(k)%nodes%compliance(:model%pairs(k)%nodes%n)
    end do
    do i = 1, 3*unknowns%n
      unknowns%compliance(i, i) = unknowns%compliance(i, i) + unknowns%penalty((i + 2)/3)
    end do
  end subroutine add_penalties

  !> A slave node whose own motion along an axis is prescribed has no compliance there: its
  !! multiplier carries no force along it, eq. (7.18).
  pure subroutine drop_supported(equation, unknowns)
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    type(mortar_system_t), intent(inout) :: unknowns !! gap, motion lose what supports carry
    real(wp) :: q(3, 3)
    integer :: i

    do i = 1, unknowns%n
      associate (free => equation(:, unknowns%rows%node(i)) > 0, r => 3*i - 2)
        if (all(free) .or. unknowns%penalty(i) > 0.0_wp) cycle
        q = across(free, unknowns%rows%frame(:, :, i))
        unknowns%gap(r:r + 2) = matmul(q, unknowns%gap(r:r + 2))
        unknowns%motion(r:r + 2, :) = matmul(q, unknowns%motion(r:r + 2, :))
      end associate
    end do
  end subroutine drop_supported

  !> The same for the compliance.
  pure subroutine drop_compliance(equation, unknowns)
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    type(mortar_system_t), intent(inout) :: unknowns !! compliance loses what supports carry
    real(wp) :: q(3, 3)
    integer :: i, k

    unknowns%stiff = spread(0.0_wp, 1, unknowns%n)
    do i = 1, unknowns%n
      associate (free => equation(:, unknowns%rows%node(i)) > 0, r => 3*i - 2)
        if (all(free) .or. unknowns%penalty(i) > 0.0_wp) cycle
        q = across(free, unknowns%rows%frame(:, :, i))
        unknowns%stiff(i) = maxval([(unknowns%compliance(r + k, r + k), k=0, 2)])
        unknowns%compliance(r:r + 2, :) = matmul(q, unknowns%compliance(r:r + 2, :))
        unknowns%compliance(:, r:r + 2) = matmul(unknowns%compliance(:, r:r + 2), q)
        do k = 1, 3
          associate (own => unknowns%compliance(r:r + 2, r + k - 1))
            own = own - unknowns%stiff(i)*q(:, k)
            own(k) = own(k) + unknowns%stiff(i)
          end associate
        end do
      end associate
    end do
  end subroutine drop_compliance

  !> Hands the forces of the multipliers to the nodes: what contact asks of the bulk.
  pure subroutine spread_forces(model, contact_force, condensed)
    type(model_t), intent(in) :: model !! pairs with forces of their multipliers
    real(wp), intent(inout) :: contact_force(:, :) !! (3, nodes) gets them [force]
    type(condensed_t), intent(inout) :: condensed !! candidates; gets their forces
    integer :: k, c

    contact_force = 0.0_wp
    do k = 1, size(model%pairs)
      call add_forces(model%pairs(k)%nodes, contact_force)
    end do
    do c = 1, condensed%n
      condensed%bulk%force(c) = contact_force(condensed%direction(c), condensed%node(c))
    end do
  end subroutine spread_forces
end module mortar_system

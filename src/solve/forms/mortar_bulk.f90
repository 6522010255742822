!> A bulk that is not linear under multipliers: each round condenses its tangent anew and moves it
!! by their forces (doc/theory, "Mortar contact", eqs. (7.19), (7.20), (7.21)).
module mortar_bulk
  use kinds, only: wp
  use costs, only: cost_t
  use lapack_interface, only: dsymv
  use back_ends, only: solver_done, solver_not_definite
  use bulk_term, only: form_bulk_force, bulk_step
  use bulk_factors, only: condense_at
  use condensed_motions, only: fixing_stiffness
  use condensation, only: reduce_body, complete_body
  use condensed_types, only: condensed_body_t
  use model_types, only: model_t
  use mortar_unknowns, only: mortar_system_t, join_rows, find_gaps, take_cones, across, &
    local_forces
  use force_scales, only: least_forces, force_scale
  use residuals, only: residual_norm, round_off_factor
  use system_types, only: form_t, system_t
  use system_parts, only: bulk_answer_t
  implicit none
  private
  public :: linearise_bulk, take_gaps, move_bulk, is_in_balance

contains

  !> Condenses the tangent at the iterate, or at the last state where what is prescribed jumps. What
  !! forces out of balance without contact make of the candidates stands in for the influence of
  !! loads on a linear bulk.
  subroutine linearise_bulk(system, form, x, outcome)
    type(system_t), intent(in) :: system !! u, bulk_force given
    type(form_t), intent(inout) :: form !! gets bodies, loaded, pushes
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! as in back_ends
    real(wp) :: u(3, size(x, 2))
    integer :: b, i

    u = system%u
    if (form%inner%linearised) u = form%inner%u_start
    call condense_at(system, form, u, spread(.true., 1, system%body%bodies), outcome)
    if (outcome == solver_not_definite .and. form%condensed%refusals == 0) then
      form%condensed%refusals = 1
      call condense_at(system, form, u, spread(.true., 1, system%body%bodies), outcome)
    end if
    if (outcome /= solver_done) return
    associate (condensed => form%condensed)
      condensed%rigid%alpha = 0.0_wp
      condensed%rigid%spring = spread(condensed%rigid%alpha, 2, condensed%rigid%modes)
      condensed%outer%factors = [1.0_wp]
      condensed%outer%pushes = reshape(condensed%rigid%alpha, [condensed%rigid%modes, 1])
      u = free_forces(system, form%inner)
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          if (.not. allocated(body%node)) cycle
          if (body%motions%n > 0) call find_modes(system, form, b)
          call reduce_body(body, u, 0.0_wp, form%costs)
          call displace(body, body%reduced(body%equation), &
            condensed%outer%loaded(body%first + 1:body%first + body%m))
        end associate
      end do
      do i = 1, condensed%n
        condensed%outer%loaded(i) = condensed%outer%loaded(i) &
          + system%u(condensed%direction(i), condensed%node(i))
      end do
    end associate
  end subroutine linearise_bulk

  !> Rows, gaps and laws of all multipliers where no force moves anything; with the compliances that
  !! multipliers had in the round before, or where some have come or gone, as if bodies had the
  !! stiffness of the scene. Gaps along supports of slave nodes are none, as in eq. (7.18).
  subroutine take_gaps(model, system, form, last, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! gets loaded
    type(mortar_system_t), intent(in) :: last !! of the round before; in the first without any
    type(mortar_system_t), intent(out) :: unknowns !! gets rows, gap, cone
    real(wp), allocatable :: z(:)
    real(wp) :: q(3, 3)
    integer :: i
    logical :: same

    associate (condensed => form%condensed)
      do i = 1, condensed%n
        condensed%outer%loaded(i) = system%u(condensed%direction(i), condensed%node(i))
      end do
    end associate
    call join_rows(model, unknowns)
    call find_gaps(model, system, model%mesh%x + system%u, unknowns)
    z = local_forces(model, unknowns)
    same = last%n == unknowns%n
    do i = 1, unknowns%n
      associate (gap => unknowns%gap(3*i - 2:3*i), mine => z(3*i - 2:3*i))
        q = across(system%equation(:, unknowns%rows%node(i)) > 0, unknowns%rows%frame(:, :, i))
        gap = matmul(q, gap)
        if (same) gap = gap + last%stiff(i)*(mine - matmul(q, mine))
      end associate
    end do
    allocate (unknowns%compliance(3*unknowns%n, 3*unknowns%n), source=0.0_wp)
    do i = 1, 3*unknowns%n
      unknowns%compliance(i, i) = 1.0_wp/system%scale%stiffest
      if (same) unknowns%compliance(i, i) = last%compliance(i, i)
    end do
    call take_cones(model, unknowns)
  end subroutine take_gaps

  !> Forces out of balance without contact.
  pure function free_forces(system, inner) result(force)
    type(system_t), intent(in) :: system !! loads
    type(bulk_answer_t), intent(in) :: inner !! bulk_force
    real(wp) :: force(3, size(system%u, 2))

    force = merge(system%loads%external - inner%bulk_force, 0.0_wp, system%equation > 0)
  end function free_forces

  !> What fixings let a body do for a unit at each of them, the work of forces out of balance on
  !! that, and what resists it, eq. (7.21).
  subroutine find_modes(system, form, b)
    type(system_t), intent(in) :: system !! condensed
    type(form_t), intent(inout) :: form !! gets modes of a body, pushes, spring
    integer, intent(in) :: b !! the body
    real(wp) :: way(3, size(system%u, 2)), spring(form%condensed%bodies(b)%motions%n)
    integer :: k, l

    spring = fixing_stiffness(form, b)
    way = 0.0_wp
    associate (condensed => form%condensed, body => form%condensed%bodies(b), &
      first => form%condensed%bodies(b)%first_mode)
      do l = 1, body%motions%n
        call answer_body(body, fixing_forces(system, form, b, merge(spring, 0.0_wp, &
          [(k == l, k=1, body%motions%n)])), spread(0.0_wp, 1, body%m), form%costs, way)
        do k = 1, body%m
          body%modes(k, l) = way(body%direction(body%equation(k)), body%node(body%equation(k)))
        end do
        condensed%outer%pushes(first + l, 1) = sum(way*free_forces(system, form%inner))
        condensed%rigid%spring(first + l, first + l) = spring(l)
        do k = 1, body%motions%n
          associate (at => condensed%rigid%spring(first + k, first + l))
            at = at - spring(k)*way(body%fixing_direction(k), body%fixing_node(k))
          end associate
        end do
      end do
    end associate
  end subroutine find_modes

  !> Forces at the fixings of a body as a nodal field.
  pure function fixing_forces(system, form, b, at_fixings) result(force)
    type(system_t), intent(in) :: system !! condensed
    type(form_t), intent(in) :: form !! what the condensed form keeps
    integer, intent(in) :: b !! the body
    real(wp), intent(in) :: at_fixings(:) !! (motions) [force]
    real(wp) :: force(3, size(system%u, 2))
    integer :: k

    force = 0.0_wp
    associate (body => form%condensed%bodies(b))
      do k = 1, size(at_fixings)
        force(body%fixing_direction(k), body%fixing_node(k)) = at_fixings(k)
      end do
    end associate
  end function fixing_forces

  !> Displacements of a body with fixings under forces and contact.
  subroutine answer_body(body, force, contact, costs, way)
    type(condensed_body_t), intent(inout) :: body !! condensed; reduced changes
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(in) :: contact(:) !! (m) at the candidates [force]
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp), intent(inout) :: way(:, :) !! (3, nodes) gets those of the body [length]
    real(wp) :: moved(body%m)

    call reduce_body(body, force, 0.0_wp, costs)
    call displace(body, body%reduced(body%equation) - contact, moved)
    call complete_body(body, moved, way, costs)
  end subroutine answer_body

  !> Moves the bulk by the forces of multipliers and by what it lacked, as far as no element turns
  !! inside out; what it lacks then.
  subroutine move_bulk(system, form, x, share)
    type(system_t), intent(inout) :: system !! condensed, its forces and motions; gets u, right
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(out) :: share !! of the way that it has gone
    integer :: b

    form%du = 0.0_wp
    associate (condensed => form%condensed)
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          if (.not. allocated(body%node)) cycle
          call answer_body(body, free_forces(system, form%inner) + fixing_forces(system, form, b, &
            fixing_stiffness(form, b)*condensed%rigid%alpha(body%first_mode + 1:body%first_mode &
            + body%motions%n)), &
            condensed%bulk%force(body%first + 1:body%first + body%m), form%costs, form%du)
        end associate
      end do
    end associate
    where (system%equation == 0) form%du = 0.0_wp
    call bulk_step(x, system%bulk, system%u, form%inner, form%du, share)
    system%u = system%u + share*form%du
    form%inner%linearised = .false.
    call form_bulk_force(x, system, form)
    call form%kind%gather(system, form, 0.0_wp, .false.)
    system%scale%seen_forces = least_forces(system, form)
  end subroutine move_bulk

  !> The bulk is in balance with the forces of multipliers.
  logical function is_in_balance(system, form, wanted) result(balanced)
    type(system_t), intent(in) :: system !! its round-off
    type(form_t), intent(in) :: form !! right given, its kind answers
    real(wp), intent(in) :: wanted !! residual over forces

    balanced = residual_norm(system, form) <= max(wanted*force_scale(system%scale), &
      round_off_factor*system%scale%round_off)
  end function is_in_balance

  !> Displacements of the candidates of a body under forces there.
  subroutine displace(body, force, moved)
    type(condensed_body_t), intent(in) :: body !! its compliance
    real(wp), intent(in) :: force(:) !! (m) [force]
    real(wp), intent(inout) :: moved(:) !! (m) [length]

    if (body%m > 0) call dsymv('L', body%m, 1.0_wp, body%compliance, body%m, force, 1, 0.0_wp, &
      moved, 1)
  end subroutine displace
end module mortar_bulk

!> One increment of pairs with multipliers at their slave nodes: rounds of weights, forces and
!! displacements until they fit each other (doc/theory, "Mortar contact").
module mortar_increment
  use kinds, only: wp
  use model_types, only: model_t
  use mortar_unknowns, only: mortar_system_t, join_rows, local_forces
  use mortar_system, only: build_mortar, anchor_mortar, spread_forces
  use mortar_newton, only: mortar_result_t, mortar_factor_t, forget_factor, solve_multipliers, &
    what_is_left, all_round_off
  use mortar_rounds, only: most_rounds, law_share, weigh_all, cut_moved, take_result, tell, show_all
  use mortar_bulk_rounds, only: follow_bulk
  use mortar_touch, only: find_touched
  use increment_conditions, only: begin_at
  use increment_start, only: prepare_start
  use contact_system, only: restart_points, move_targets, load_contact
  use condensed_system, only: couple_condensed, restore_forces, find_defects, &
    place_candidates
  use force_scales, only: force_scale
  use costs, only: begin_cost, end_cost, cost_node_compliance
  use rigid_bodies, only: return_rigid, move_rigid
  use touch_types, only: touch_none, touch_waits
  use newton_progress, only: newton_t, outcome_converged, outcome_restless, outcome_stopped, &
    outcome_memory, heed_stop
  use monitors, only: monitor_t
  use newton_settings, only: settings_t, tol_energy, tol_residual
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: solve_mortar

  !> The compliance serves on while so many pairs of rounds as the last one would be the last: they
  !! cost what a new one does. What weights and forces lack comes down in turn: one round tells
  !! little.
  integer, parameter :: pairs_worth_one = 5
  !> Beyond most_rounds there are more, up to so many, while two of them leave no more than this
  !! share: a body that only weak springs hold where it can slide takes some 40.
  integer, parameter :: rounds_at_most = 80
  real(wp), parameter :: gets_on_share = 0.6_wp

contains

  !> Solves for the state at `time`; nothing is accepted here.
  subroutine solve_mortar(model, system, form, state, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u is the new state on success
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! how far an apex may lie outside its target
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(out) :: progress !! how it ended
    logical :: waits, touched, foretold
    integer :: changes, k

    if (.not. (form%condensed%active .or. form%condensed%preconditions)) then
      progress%outcome = outcome_memory
      return
    end if
    call begin_at(model, state, time, system%equation, system%u, system%loads, system%tools)
    call prepare_start(model, system, form, state, time, foretold)
    ! a body that contact alone holds may need the friction of its new nodes
    waits = system%touch%stage == touch_waits .and. .not. any(system%body%floating)
    system%touch%stage = touch_none
    system%u = system%position%carried
    call return_rigid(system%u, system%tools)
    system%position%x_now = model%mesh%x + system%u
    do k = 1, size(model%pairs)
      model%pairs(k)%nodes = model%pairs(k)%old_nodes
    end do
    call restart_points(model, form%costs, system%position)
    do k = 1, size(model%pairs)
      model%pairs(k)%history%softened = .false.
      model%pairs(k)%history%raise = 1.0_wp
    end do
    call move_targets(model, system, form%costs, 0.0_wp, changes)
    if (system%bulk%linear) call restore_forces(form%condensed)
    if (system%bulk%linear .and. form%condensed%rigid%modes > 0) call find_defects(system, form)
    call follow(model, system, form, waits, time, settings, monitor, progress)
    if (.not. waits .or. progress%outcome /= outcome_converged) return
    call find_touched(model, system, form%costs, touched)
    if (.not. touched) return
    call monitor%detail('  slave nodes have touched first in this increment: friction from there')
    call follow(model, system, form, .false., time, settings, monitor, progress)
  end subroutine solve_mortar

  !> Rounds of either kind of bulk.
  subroutine follow(model, system, form, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    type(form_t), intent(inout) :: form !! the linearised system in its form
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended

    if (system%bulk%linear) then
      call follow_anchored(model, system, form, waits, time, settings, monitor, progress)
    else
      call follow_bulk(model, system, form, waits, time, settings, monitor, progress)
    end if
  end subroutine follow

  !> Rounds until forces, gaps and weights fit each other. The compliance of the multipliers and its
  !! factors serve as long as rounds get on with them: all else is true at each place.
  subroutine follow_anchored(model, system, form, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    type(form_t), intent(inout) :: form !! the linearised system in its form
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(mortar_system_t) :: unknowns
    type(mortar_factor_t) :: factor
    real(wp) :: cut_at(3, size(system%u, 2)), left, before, earlier, allowed
    integer :: round, changes
    logical :: same, gets_on

    gets_on = .false.
    before = huge(before)
    earlier = before
    cut_at = system%position%x_ahead
    call foretell(model, system, form, waits)
    call cut_moved(model, system, form, settings, cut_at, changes)
    do round = 1, rounds_at_most
      if (round > most_rounds .and. .not. gets_on) exit
      gets_on = .false.
      progress%outcome = outcome_restless
      call weigh_all(model, system, waits, form%costs, same)
      same = same .and. round > 1
      if (same) then
        call return_to_balance(model, system, form, settings, unknowns, left, allowed)
        if (left <= allowed) then
          progress%outcome = outcome_converged
          call show_all(model, system%contact, system%place)
          return
        end if
        gets_on = left <= gets_on_share*earlier
        if (round == 2) earlier = norm2(system%contact_force)
        same = left*(left/earlier)**pairs_worth_one <= allowed
        earlier = before
        before = left
      end if
      if (.not. same) then
        call begin_cost(form%costs, cost_node_compliance)
        call build_mortar(model, system, form, unknowns)
        call end_cost(form%costs, cost_node_compliance)
        call forget_factor(factor)
      end if
      call solve_anchored(model, system, form, time, unknowns, round == 1, factor, monitor, &
        progress)
      if (progress%outcome /= outcome_converged) return
      call heed_stop(progress)
      if (progress%outcome == outcome_stopped) return
      call cut_moved(model, system, form, settings, cut_at, changes)
    end do
    progress%outcome = outcome_restless
    call monitor%detail('  the weights of multipliers do not settle')
  end subroutine follow_anchored

  !> Where the forces of the last state put the bodies if they act by the weights at the place that
  !! is foretold: on a body that slides they go along.
  subroutine foretell(model, system, form, waits)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! u: the predictor's; follows the forces
    type(form_t), intent(inout) :: form !! the linearised system in its form
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    integer :: k

    call load_contact(model, system)
    call couple_condensed(system, form)
    ! under new loads old forces put bodies that contact holds anywhere
    if (form%condensed%rigid%modes + system%tools%unknowns > 0) return
    call weigh_all(model, system, waits, form%costs)
    if (any([(any(abs(model%pairs(k)%nodes%force) > 0.0_wp), k=1, size(model%pairs))])) &
      call move_bodies(model, system, form)
  end subroutine foretell

  !> Forces of the round before act by the present weights: what nodes lacked without that, and what
  !! the law lacks then.
  subroutine return_to_balance(model, system, form, settings, unknowns, left, allowed)
    type(model_t), intent(in) :: model !! pairs with forces of the multipliers
    type(system_t), intent(inout) :: system !! u, contact_force of the round before; gets new ones
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    type(settings_t), intent(in) :: settings !! tolerances
    type(mortar_system_t), intent(inout) :: unknowns !! gets the present rows and gaps
    real(wp), intent(out) :: left !! norm of what they lack [force]
    real(wp), intent(out) :: allowed !! what they may [force]
    real(wp) :: before(3, size(system%u, 2))

    before = system%contact_force
    call join_rows(model, unknowns)
    call move_bodies(model, system, form)
    call anchor_mortar(model, system, form, unknowns)
    left = norm2([norm2(system%contact_force - before), what_is_left(unknowns, &
      local_forces(model, unknowns), motions_of(system, form))])
    allowed = max(max(settings%asked(tol_residual), law_share*sqrt(settings%asked(tol_energy))) &
      *max(norm2(before), force_scale(system%scale)), all_round_off(unknowns))
  end subroutine return_to_balance

  !> Moves the bodies to where forces of the multipliers, loads and rigid motions put them.
  subroutine move_bodies(model, system, form)
    type(model_t), intent(in) :: model !! reference positions, forces
    type(system_t), intent(inout) :: system !! gets forces of contact, u, x_now
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes

    call spread_forces(model, system%contact_force, form%condensed)
    form%condensed%rigid%imbalance = 0.0_wp
    form%condensed%bulk%defect = 0.0_wp
    call place_candidates(form%condensed, spread(.true., 1, form%condensed%n), system%u)
    system%position%x_now = model%mesh%x + system%u
    if (allocated(system%contact%reached)) deallocate (system%contact%reached)
  end subroutine move_bodies

  !> Forces of the multipliers with frozen weights, and the displacements that they make.
  subroutine solve_anchored(model, system, form, time, unknowns, begins, factor, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(system_t), intent(inout) :: system !! u and forces of contact
    type(form_t), intent(inout) :: form !! gets condensed, solution, trial
    real(wp), intent(in) :: time !! end of the increment
    type(mortar_system_t), intent(in) :: unknowns !! the system of the multipliers
    logical, intent(in) :: begins !! forces and status are those of the last state or pass
    type(mortar_factor_t), intent(inout) :: factor !! of its matrix
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(mortar_result_t) :: result
    real(wp), allocatable :: near(:)
    integer, allocatable :: status(:)
    integer :: k

    associate (z => local_forces(model, unknowns), alpha => motions_of(system, form))
      ! what the loads alone make of bodies that contact holds says nothing of status
      if (size(alpha) > 0 .and. all(abs(z) <= 0.0_wp)) near = unknowns%near
      if (begins .and. any(abs(z) > 0.0_wp)) status = [(model%pairs(k)%nodes%status, k=1, &
        size(model%pairs))]
      call solve_multipliers(unknowns, z, alpha, factor, result, near, status)
    end associate
    call take_result(model, unknowns, result, progress, form%costs)
    associate (modes => form%condensed%rigid%modes)
      form%condensed%rigid%alpha = result%motion(:modes)
      if (system%tools%unknowns > 0) call move_rigid(system%equations, system%u, system%tools, &
        form, result%motion(modes + 1:))
    end associate
    call move_bodies(model, system, form)
    if (result%steps > 0) call tell(time, result, progress, monitor)
  end subroutine solve_anchored

  !> Rigid motions so far: of bodies that deform, and of rigid bodies with a point from where they
  !! are.
  pure function motions_of(system, form) result(motion)
    type(system_t), intent(in) :: system !! motions of the condensed form
    type(form_t), intent(in) :: form !! what the condensed form keeps
    real(wp) :: motion(form%condensed%rigid%modes + system%tools%unknowns)

    motion = 0.0_wp
    motion(:form%condensed%rigid%modes) = form%condensed%rigid%alpha
  end function motions_of
end module mortar_increment

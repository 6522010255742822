!> One increment of pairs with multipliers at their slave nodes: rounds of weights, forces and
!! displacements until the weights stay (doc/theory, "Mortar contact").
module mortar_increment
  use kinds, only: wp
  use model_types, only: model_t
  use mortar_types, only: mortar_t
  use mortar_functions, only: find_faces
  use mortar_weights, only: weigh_nodes
  use mortar_history, only: take_history, take_forces, show_points
  use mortar_system, only: mortar_system_t, build_mortar, take_rows, anchor_mortar, &
    spread_multipliers, local_forces
  use mortar_newton, only: mortar_result_t, mortar_factor_t, forget_factor, solve_multipliers, &
    what_is_left, round_off
  use mortar_touch, only: find_touched, place_new
  use elmlib, only: routine_none
  use increment_start, only: begin_at, prepare_start
  use contact_system, only: restart_points, move_targets, load_contact
  use condensed_system, only: couple_condensed, restore_forces, find_defects, &
    place_candidates
  use touch_path, only: touch_none, touch_waits
  use newton_progress, only: newton_t, outcome_converged, outcome_stalled, &
    outcome_singular, outcome_restless, outcome_stopped, outcome_memory
  use force_scales, only: force_scale
  use costs, only: begin_cost, end_cost, count_cost, cost_rounds, cost_weighed, &
    cost_node_compliance, cost_dense_factor, cost_modified_newton
  use solution_settings, only: tol_energy, tol_residual
  use signals, only: stop_requested
  use parallel, only: any_rank
  use monitors, only: monitor_t, iteration_t
  use system_types, only: system_t, state_t, settings_t
  use element_lists, only: element_list_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: solve_mortar

  !> Rounds of an increment, with a margin: a wavy master has taken 3.
  integer, parameter :: most_rounds = 20
  !> The compliance serves on while two rounds leave no more than this share: what weights and
  !! forces lack comes down in turn, so that one round tells little.
  real(wp), parameter :: compliance_serves = 0.5_wp
  !> What the law may lack at the end, over the forces: this share of the root of TOL. Nodes are in
  !! balance to round-off after each round.
  real(wp), parameter :: law_share = 0.1_wp
  !> Facets are cut anew only after nodes have moved by more than this share of a facet since the
  !! last cut: as far as cells stay on a plane where points slip.
  real(wp), parameter :: hardly = 1.0e-2_wp

contains

  !> Solves for the state at `time`; nothing is accepted here.
  subroutine solve_mortar(model, system, state, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u is the new state on success
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! how far an apex may lie outside its target
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(out) :: progress !! how it ended
    logical :: waits, touched, foretold
    integer :: changes, k

    if (system%form%knows_inside) then
      progress%outcome = outcome_memory
      return
    end if
    call begin_at(model, system, state, time)
    call prepare_start(model, system, state, time, foretold)
    ! a body that contact alone holds may need the friction of its new nodes
    waits = system%touch%stage == touch_waits .and. .not. any(system%body%floating)
    system%touch%stage = touch_none
    system%u = system%position%carried
    system%position%x_now = model%mesh%x + system%u
    do k = 1, size(model%pairs)
      if (.not. allocated(model%pairs(k)%faces)) call find_faces(model%pairs(k), model%mesh%x)
      model%pairs(k)%nodes = model%pairs(k)%old_nodes
    end do
    call restart_points(model, system%costs, system%position)
    call move_targets(model, system, 0.0_wp, changes)
    call restore_forces(system%condensed)
    if (system%condensed%rigid%modes > 0) call find_defects(system)
    call follow_weights(model, system, waits, time, settings, monitor, progress)
    if (.not. waits .or. progress%outcome /= outcome_converged) return
    call find_touched(model, system, touched)
    if (.not. touched) return
    call monitor%detail('  slave nodes have touched first in this increment: friction from there')
    call follow_weights(model, system, .false., time, settings, monitor, progress)
  end subroutine solve_mortar

  !> Rounds until forces, gaps and weights fit each other. The compliance of the multipliers and its
  !! factors serve as long as rounds get on with them: all else is true at each place.
  subroutine follow_weights(model, system, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(mortar_system_t) :: unknowns
    type(mortar_factor_t) :: factor
    real(wp) :: cut_at(3, size(system%u, 2)), left, before, earlier, allowed
    integer :: round, changes
    logical :: same

    before = huge(before)
    earlier = before
    cut_at = system%position%x_ahead
    call foretell(model, system, waits, unknowns)
    call cut_moved(model, system, settings, cut_at, changes)
    do round = 1, most_rounds
      progress%outcome = outcome_restless
      call weigh_all(model, system, waits, same)
      same = same .and. round > 1
      if (same) then
        call return_to_balance(model, system, settings, unknowns, left, allowed)
        if (left <= allowed .and. changes == 0) then
          progress%outcome = outcome_converged
          call show_all(model, system%contact, system%place)
          return
        end if
        same = left <= compliance_serves*earlier
        earlier = before
        before = left
      end if
      if (.not. same) then
        call begin_cost(system%costs, cost_node_compliance)
        call build_mortar(model, system, unknowns)
        call end_cost(system%costs, cost_node_compliance)
        call forget_factor(factor)
      end if
      call solve_round(model, system, time, unknowns, factor, monitor, progress)
      if (progress%outcome /= outcome_converged) return
      if (any_rank(stop_requested())) progress%outcome = outcome_stopped
      if (progress%outcome == outcome_stopped) return
      call cut_moved(model, system, settings, cut_at, changes)
    end do
    progress%outcome = outcome_restless
    call monitor%warning('the weights of multipliers do not settle')
  end subroutine follow_weights

  !> Where the forces of the last state put the bodies if they act by the weights at the place that
  !! is foretold: on a body that slides they go along.
  subroutine foretell(model, system, waits, unknowns)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! u: the predictor's; follows the forces
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    type(mortar_system_t), intent(inout) :: unknowns !! gets rows
    logical :: same

    call load_contact(model, system)
    call couple_condensed(system)
    call weigh_all(model, system, waits, same)
    call take_rows(model, unknowns)
    associate (z => local_forces(model, unknowns))
      ! under new loads old forces put bodies that contact holds anywhere
      if (system%condensed%rigid%modes == 0 .and. any(abs(z) > 0.0_wp)) &
        call move_bodies(model, unknowns, z, system)
    end associate
  end subroutine foretell

  !> Cuts facets anew where nodes have moved so far that it matters.
  subroutine cut_moved(model, system, settings, cut_at, changes)
    type(model_t), intent(inout) :: model !! pairs: cells
    type(system_t), intent(inout) :: system !! contact elements follow
    type(settings_t), intent(in) :: settings !! how far an apex may lie outside its target
    real(wp), intent(inout) :: cut_at(:, :) !! (3, nodes) positions at the last cut [length]
    integer, intent(out) :: changes !! points of facets that have been cut

    changes = 0
    if (maxval(abs(system%position%x_now - cut_at)) <= hardly*system%scale%facet_size) return
    call move_targets(model, system, settings%extrapolation, changes)
    cut_at = system%position%x_now
    if (changes == 0) return
    call load_contact(model, system)
    call couple_condensed(system)
  end subroutine cut_moved

  !> Forces of the round before act by the present weights: what nodes lacked without that, and what
  !! the law lacks then.
  subroutine return_to_balance(model, system, settings, unknowns, left, allowed)
    type(model_t), intent(in) :: model !! pairs with forces of the multipliers
    type(system_t), intent(inout) :: system !! u, contact_force of the round before; gets new ones
    type(settings_t), intent(in) :: settings !! tolerances
    type(mortar_system_t), intent(inout) :: unknowns !! gets the present rows and gaps
    real(wp), intent(out) :: left !! norm of what they lack [force]
    real(wp), intent(out) :: allowed !! what they may [force]
    real(wp) :: before(3, size(system%u, 2))

    before = system%contact_force
    call take_rows(model, unknowns)
    call move_bodies(model, unknowns, local_forces(model, unknowns), system)
    call anchor_mortar(model, system, unknowns)
    left = norm2([norm2(system%contact_force - before), what_is_left(unknowns, &
      local_forces(model, unknowns), system%condensed%rigid%alpha)])
    allowed = max(max(settings%asked(tol_residual), law_share*sqrt(settings%asked(tol_energy))) &
      *max(norm2(before), force_scale(system)), &
      round_off(unknowns, maxval(abs(system%position%x_now))))
  end subroutine return_to_balance

  !> Moves the bodies to where forces of the multipliers, loads and rigid motions put them.
  subroutine move_bodies(model, unknowns, z, system)
    type(model_t), intent(in) :: model !! reference positions
    type(mortar_system_t), intent(in) :: unknowns !! rows of the multipliers
    real(wp), intent(in) :: z(:) !! (3 n) their forces [force]
    type(system_t), intent(inout) :: system !! gets forces of contact, u, x_now

    call spread_multipliers(unknowns, z, system)
    system%condensed%rigid%imbalance = 0.0_wp
    system%condensed%bulk%defect = 0.0_wp
    call place_candidates(system)
    system%position%x_now = model%mesh%x + system%u
    if (allocated(system%contact%reached)) deallocate (system%contact%reached)
  end subroutine move_bodies

  !> Points show what the multipliers around them do.
  subroutine show_all(model, contact, place)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(element_list_t), intent(inout) :: contact !! contact elements; gets status
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    integer :: k

    do k = 1, size(model%pairs)
      call show_points(model%pairs(k), contact%status(place%first_point(k): &
        place%first_point(k + 1) - 1))
    end do
  end subroutine show_all

  !> Weights at the present positions.
  subroutine weigh_all(model, system, waits, same)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! contact elements; cost table
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    logical, intent(out) :: same !! the multipliers are those of before
    type(mortar_t) :: nodes
    integer :: k

    same = .true.
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k), first => system%place%first_point(k), &
        last => system%place%first_point(k + 1) - 1)
        call weigh_nodes(pair, system%contact%routine(first:last) /= routine_none, &
          system%position%x_now, nodes)
        call take_history(pair%old_nodes, pair%nodes, nodes)
        if (are_same(pair%nodes, nodes)) then
          nodes%status = pair%nodes%status
          nodes%gap = pair%nodes%gap
          nodes%criterion = pair%nodes%criterion
        else
          same = .false.
        end if
        call place_new(pair, system, k, waits, nodes)
        pair%nodes = nodes
        call count_cost(system%costs, cost_weighed, nodes%n)
      end associate
    end do
  end subroutine weigh_all

  !> The multipliers are those of another iterate.
  pure logical function are_same(last, nodes)
    type(mortar_t), intent(in) :: last !! before
    type(mortar_t), intent(in) :: nodes !! now

    are_same = last%n == nodes%n .and. allocated(last%status)
    if (are_same) are_same = all(last%node == nodes%node) .and. all(last%face == nodes%face)
  end function are_same

  !> Forces of the multipliers with frozen weights, and the displacements that they make.
  subroutine solve_round(model, system, time, unknowns, factor, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(system_t), intent(inout) :: system !! u and forces of contact
    real(wp), intent(in) :: time !! end of the increment
    type(mortar_system_t), intent(in) :: unknowns !! the system of the multipliers
    type(mortar_factor_t), intent(inout) :: factor !! of its matrix
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(mortar_result_t) :: result
    integer :: k

    associate (condensed => system%condensed)
      call solve_multipliers(unknowns, local_forces(model, unknowns), condensed%rigid%alpha, &
        factor, result)
      progress%solves = max(1, progress%solves + result%steps)
      call count_cost(system%costs, cost_rounds, 1)
      call count_cost(system%costs, cost_dense_factor, result%steps)
      call count_cost(system%costs, cost_modified_newton, result%repeated)
      progress%outcome = outcome_stalled
      if (result%singular) progress%outcome = outcome_singular
      if (result%converged) progress%outcome = outcome_converged
      do k = 1, size(model%pairs)
        associate (own => unknowns%start(k) + 1, end => unknowns%start(k + 1))
          call take_forces(result%force(3*own - 2:3*end), result%gap(3*own - 2:3*end), &
            result%closed(own:end), result%slips(own:end), result%criterion(own:end), &
            model%pairs(k)%nodes)
        end associate
      end do
      condensed%rigid%alpha = result%motion
    end associate
    call move_bodies(model, unknowns, result%force, system)
    if (result%steps > 0) call tell(time, result, progress, monitor)
  end subroutine solve_round

  !> Reports a round with factors of its own.
  subroutine tell(time, result, progress, monitor)
    real(wp), intent(in) :: time !! end of the increment
    type(mortar_result_t), intent(in) :: result !! of the round
    type(newton_t), intent(in) :: progress !! solves so far
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(iteration_t) :: report

    report%time = time
    report%number = progress%solves
    report%residual = result%left
    report%relative = result%left/max(maxval([0.0_wp, abs(result%force)]), tiny(1.0_wp))
    report%step_length = 1.0_wp
    report%active = count(result%closed)
    report%slip = count(result%closed .and. result%slips)
    report%stick = report%active - report%slip
    report%solver = 'REDUCED'
    call monitor%iteration(report)
  end subroutine tell
end module mortar_increment

!> One increment of pairs with multipliers at their slave nodes: rounds of weights, forces and
!! displacements until the weights stay (doc/theory, "Mortar contact").
!! In more than 400 lines, since both kinds of bulk go over the same weights and results.
module mortar_increment
  use kinds, only: wp, machine_epsilon
  use solution_settings, only: tol_energy, tol_residual
  use model_types, only: model_t
  use mortar_types, only: mortar_t
  use mortar_weights, only: weigh_nodes
  use mortar_points, only: weigh_points, take_point_history
  use mortar_history, only: take_history, take_forces, show_points
  use mortar_system, only: mortar_system_t, build_mortar, join_rows, anchor_mortar, &
    spread_multipliers, local_forces
  use mortar_newton, only: mortar_result_t, mortar_factor_t, forget_factor, solve_multipliers, &
    what_is_left, what_law_lacks, round_off
  use mortar_bulk, only: linearise_bulk, take_gaps, move_bulk, is_in_balance
  use back_ends, only: solver_done
  use bulk_term, only: return_bulk, form_bulk_force
  use residuals, only: residual_norm, round_off_factor
  use mortar_touch, only: find_touched, place_new
  use elmlib, only: routine_none
  use element_types, only: status_open
  use increment_start, only: begin_at, prepare_start
  use contact_system, only: restart_points, move_targets, load_contact
  use condensed_system, only: couple_condensed, restore_forces, find_defects, &
    place_candidates
  use force_scales, only: force_scale
  use costs, only: cost_t, begin_cost, end_cost, count_cost, cost_rounds, cost_weighed, &
    cost_node_compliance, cost_dense_factor, cost_modified_newton
  use rigid_bodies, only: return_rigid, move_rigid
  use touch_path, only: touch_none, touch_waits
  use newton_progress, only: newton_t, wanted_share, outcome_inverted, outcome_converged, &
    outcome_stalled, outcome_singular, outcome_restless, outcome_stopped, outcome_memory
  use signals, only: stop_requested
  use parallel, only: any_rank
  use monitors, only: monitor_t, iteration_t
  use system_types, only: system_t, state_t, settings_t
  use element_lists, only: element_list_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: solve_mortar

  !> What the law may lack where the bulk is in balance, over the largest force: this share of the
  !! root of TOL.
  real(wp), parameter :: law_share = 0.1_wp
  !> Weights are foretold after so many rounds, each of whose ways was a share of the one before
  !! within these bounds: below, rounds settle by themselves.
  integer, parameter :: least_trail = 3
  real(wp), parameter :: settles = 0.1_wp, strays = 0.9_wp
  !> Rounds of an increment, with a margin: a wavy master has taken 3.
  integer, parameter :: most_rounds = 20
  !> The compliance serves on while two rounds leave no more than this share: what weights and
  !! forces lack comes down in turn, so that one round tells little.
  real(wp), parameter :: compliance_serves = 0.5_wp
  !> Weights and frames that change by less have stayed: forces follow them to first order.
  real(wp), parameter :: unchanged = 1.0e-6_wp
  !> Rigid bodies with a point that a round has moved by less, in facets, are where they are: the
  !! levers of their loads and contact follow to round-off.
  real(wp), parameter :: at_rest = 1.0e-9_wp
  !> Facets are cut anew only after nodes have moved by more than this share of a facet since the
  !! last cut: cells stay within ten times that anyway.
  real(wp), parameter :: hardly = 1.0e-4_wp
  !> The same where the compliance serves: as far as cells stay on a plane where points slip.
  real(wp), parameter :: nearly = 1.0e-2_wp

  !> Rounds of a bulk that is not linear.
  type :: trail_t
    real(wp), allocatable :: x(:, :) !! (3, nodes) positions of the last round [length]
    real(wp), allocatable :: way(:, :) !! (3, nodes) its way [length]
    integer :: rounds = 0 !! since weights were foretold
  end type trail_t

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

    if (.not. (system%condensed%active .or. system%condensed%preconditions)) then
      progress%outcome = outcome_memory
      return
    end if
    call begin_at(model, system, state, time)
    call prepare_start(model, system, state, time, foretold)
    ! a body that contact alone holds may need the friction of its new nodes
    waits = system%touch%stage == touch_waits .and. .not. any(system%body%floating)
    system%touch%stage = touch_none
    system%u = system%position%carried
    call return_rigid(system%u, system%tools)
    system%position%x_now = model%mesh%x + system%u
    do k = 1, size(model%pairs)
      model%pairs(k)%nodes = model%pairs(k)%old_nodes
    end do
    call restart_points(model, system%costs, system%position)
    do k = 1, size(model%pairs)
      model%pairs(k)%history%softened = .false.
      model%pairs(k)%history%raise = 1.0_wp
    end do
    call move_targets(model, system, 0.0_wp, changes)
    if (system%bulk%linear) call restore_forces(system%condensed)
    if (system%bulk%linear .and. system%condensed%rigid%modes > 0) call find_defects(system)
    call follow(model, system, waits, time, settings, monitor, progress)
    if (.not. waits .or. progress%outcome /= outcome_converged) return
    call find_touched(model, system, touched)
    if (.not. touched) return
    call monitor%detail('  slave nodes have touched first in this increment: friction from there')
    call follow(model, system, .false., time, settings, monitor, progress)
  end subroutine solve_mortar

  !> Rounds of either kind of bulk.
  subroutine follow(model, system, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended

    if (system%bulk%linear .and. system%tools%border%n == 0 .and. all(model%pairs%mortar)) then
      call follow_anchored(model, system, waits, time, settings, monitor, progress)
    else if (system%bulk%linear) then
      call follow_weights(model, system, waits, time, settings, monitor, progress)
    else
      call follow_bulk(model, system, waits, time, settings, monitor, progress)
    end if
  end subroutine follow

  !> Rounds of a bulk that is not linear, steps of Newton's method at present weights, until bulk
  !! and law are in balance with these.
  subroutine follow_bulk(model, system, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(mortar_system_t) :: unknowns
    real(wp) :: change, cut_at(3, size(system%u, 2))
    type(trail_t) :: trail
    integer :: round, changes
    logical :: balanced

    changes = 0
    cut_at = system%position%x_ahead
    trail%x = system%position%x_now
    system%form%near = .false.
    call return_bulk(model%mesh%x, system)
    call form_bulk_force(model%mesh%x, system)
    do round = 1, most_rounds
      progress%outcome = outcome_restless
      call load_contact(model, system)
      call couple_condensed(system)
      call weigh_all(model, system, waits, change)
      call take_gaps(model, system, unknowns)
      associate (z => local_forces(model, unknowns))
        call spread_multipliers(unknowns, z, system)
        call system%form%gather(system, 0.0_wp, .false.)
        balanced = is_in_balance(system, model%mesh%x, wanted_share(settings))
        balanced = balanced .and. round > 1 .and. changes == 0 .and. &
          what_law_lacks(unknowns, z) <= max(law_share*sqrt(settings%asked(tol_energy)) &
          *maxval([0.0_wp, abs(z)]), &
          round_off_factor*machine_epsilon*system%scale%stiffest*maxval(abs(system%position%x_now)))
      end associate
      if (balanced) progress%outcome = outcome_converged
      if (balanced) exit
      call weigh_ahead(model, system, waits, trail, unknowns)
      call solve_bulk_round(model, system, time, unknowns%gap, monitor, progress)
      if (progress%outcome /= outcome_restless) return
      if (any_rank(stop_requested())) progress%outcome = outcome_stopped
      if (progress%outcome == outcome_stopped) return
      changes = 0
      if (maxval(abs(system%position%x_now - cut_at)) <= hardly*system%scale%facet_size) cycle
      call move_targets(model, system, settings%extrapolation, changes)
      cut_at = system%position%x_now
    end do
    if (progress%outcome == outcome_converged) call show_all(model, system%contact, system%place)
  end subroutine follow_bulk

  !> Weights and frames where the rounds lead to, if the last ways shrink by a share (Aitken): those
  !! of a steep master turn with what they move.
  subroutine weigh_ahead(model, system, waits, trail, unknowns)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! x_now; contact elements
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    type(trail_t), intent(inout) :: trail !! the rounds so far
    type(mortar_system_t), intent(inout) :: unknowns !! gaps at these weights
    real(wp), dimension(3, size(trail%x, 2)) :: way, x
    real(wp) :: share, change

    x = system%position%x_now
    way = x - trail%x
    trail%x = x
    trail%rounds = trail%rounds + 1
    share = 0.0_wp
    if (trail%rounds > least_trail) share = sum(way*trail%way)/max(sum(trail%way**2), &
      tiny(1.0_wp))
    trail%way = way
    if (abs(share) < settles .or. abs(share) > strays) return
    trail%rounds = 0
    system%position%x_now = x + share/(1.0_wp - share)*way
    call weigh_all(model, system, waits, change)
    system%position%x_now = x
    call take_gaps(model, system, unknowns)
  end subroutine weigh_ahead

  !> Forces of the multipliers with frozen weights and a linearised bulk, and how this goes on.
  subroutine solve_bulk_round(model, system, time, gap, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(system_t), intent(inout) :: system !! u and forces of contact
    real(wp), intent(in) :: time !! end of the increment
    real(wp), intent(in) :: gap(:) !! (3 n) slip and gap of the iterate [length]
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(mortar_system_t) :: unknowns
    type(mortar_factor_t) :: factor
    type(mortar_result_t) :: result
    integer :: outcome
    real(wp) :: share

    call linearise_bulk(system, model%mesh%x, outcome)
    if (outcome /= solver_done) progress%outcome = outcome_stalled
    if (outcome /= solver_done) return
    call build_mortar(model, system, unknowns)
    associate (z => local_forces(model, unknowns), alpha => system%condensed%rigid%alpha)
      if (system%condensed%refusals == 0) then
        call solve_multipliers(unknowns, z, alpha, factor, result)
      else
        ! what a compliance that is not definite makes of z alone says nothing of status
        call solve_multipliers(unknowns, z, alpha, factor, result, gap)
      end if
    end associate
    call take_result(model, unknowns, result, progress, system%costs)
    if (progress%outcome /= outcome_converged) return
    call spread_multipliers(unknowns, result%force, system)
    system%condensed%rigid%alpha = result%motion
    call move_bulk(system, model%mesh%x, share)
    system%position%x_now = model%mesh%x + system%u
    if (allocated(system%contact%reached)) deallocate (system%contact%reached)
    progress%outcome = merge(outcome_restless, outcome_inverted, share > 0.0_wp)
    result%left = residual_norm(system)
    call tell(time, result, progress, monitor)
  end subroutine solve_bulk_round

  !> Rounds until forces, gaps and weights fit each other. The compliance of the multipliers and its
  !! factors serve as long as rounds get on with them: all else is true at each place.
  subroutine follow_anchored(model, system, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(mortar_system_t) :: unknowns
    type(mortar_factor_t) :: factor
    real(wp) :: cut_at(3, size(system%u, 2)), left, before, earlier, allowed, change
    integer :: round, changes
    logical :: same

    before = huge(before)
    earlier = before
    cut_at = system%position%x_ahead
    call foretell(model, system, waits, unknowns)
    call cut_moved(model, system, settings, cut_at, changes)
    do round = 1, most_rounds
      progress%outcome = outcome_restless
      call weigh_all(model, system, waits, change, same)
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
      call solve_anchored(model, system, time, unknowns, factor, monitor, progress)
      if (progress%outcome /= outcome_converged) return
      if (any_rank(stop_requested())) progress%outcome = outcome_stopped
      if (progress%outcome == outcome_stopped) return
      call cut_moved(model, system, settings, cut_at, changes)
    end do
    progress%outcome = outcome_restless
    call monitor%warning('the weights of multipliers do not settle')
  end subroutine follow_anchored

  !> Where the forces of the last state put the bodies if they act by the weights at the place that
  !! is foretold: on a body that slides they go along.
  subroutine foretell(model, system, waits, unknowns)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! u: the predictor's; follows the forces
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    type(mortar_system_t), intent(inout) :: unknowns !! gets rows
    real(wp) :: change
    logical :: same

    call load_contact(model, system)
    call couple_condensed(system)
    call weigh_all(model, system, waits, change, same)
    call join_rows(model, unknowns)
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
    if (maxval(abs(system%position%x_now - cut_at)) <= nearly*system%scale%facet_size) return
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
    call join_rows(model, unknowns)
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

  !> Forces of the multipliers with frozen weights, and the displacements that they make.
  subroutine solve_anchored(model, system, time, unknowns, factor, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(system_t), intent(inout) :: system !! u and forces of contact
    real(wp), intent(in) :: time !! end of the increment
    type(mortar_system_t), intent(in) :: unknowns !! the system of the multipliers
    type(mortar_factor_t), intent(inout) :: factor !! of its matrix
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(mortar_result_t) :: result

    call solve_multipliers(unknowns, local_forces(model, unknowns), &
      system%condensed%rigid%alpha, factor, result)
    call take_result(model, unknowns, result, progress, system%costs)
    system%condensed%rigid%alpha = result%motion
    call move_bodies(model, unknowns, result%force, system)
    if (result%steps > 0) call tell(time, result, progress, monitor)
  end subroutine solve_anchored

  !> Rounds until the weights stay, where rigid bodies with a point or points of other forms take
  !! part: the compliance is formed in each.
  subroutine follow_weights(model, system, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! how far an apex may lie outside its target
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    real(wp) :: change, moved, cut_at(3, size(system%u, 2))
    integer :: round, changes

    progress%outcome = outcome_restless
    changes = 0
    moved = 0.0_wp
    cut_at = system%position%x_ahead
    do round = 1, most_rounds
      call load_contact(model, system)
      call couple_condensed(system)
      call weigh_all(model, system, waits, change)
      if (round > 1 .and. changes == 0 .and. change <= unchanged .and. moved <= &
        at_rest*system%scale%facet_size) then
        progress%outcome = outcome_converged
        call show_all(model, system%contact, system%place)
        return
      end if
      call solve_round(model, system, time, monitor, progress, moved)
      if (progress%outcome /= outcome_converged) return
      progress%outcome = outcome_restless
      if (any_rank(stop_requested())) progress%outcome = outcome_stopped
      if (progress%outcome == outcome_stopped) return
      changes = 0
      if (maxval(abs(system%position%x_now - cut_at)) <= hardly*system%scale%facet_size) cycle
      call move_targets(model, system, settings%extrapolation, changes)
      cut_at = system%position%x_now
    end do
    call monitor%warning('the weights of multipliers do not settle')
  end subroutine follow_weights

  !> Points show what the multipliers around them do.
  subroutine show_all(model, contact, place)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(element_list_t), intent(inout) :: contact !! contact elements; gets status, slip
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    integer :: k

    do k = 1, size(model%pairs)
      associate (first => place%first_point(k), last => place%first_point(k + 1) - 1)
        call show_points(model%pairs(k), contact%status(first:last), contact%slip(:, first:last))
      end associate
    end do
  end subroutine show_all

  !> Weights at the present positions, and by how much they have changed.
  subroutine weigh_all(model, system, waits, change, same)
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! contact elements; cost table
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(out) :: change !! largest change of a weight or a frame
    logical, intent(out), optional :: same !! the multipliers are those of before
    type(mortar_t) :: nodes
    integer :: k

    change = 0.0_wp
    if (present(same)) same = .true.
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k), first => system%place%first_point(k), &
        last => system%place%first_point(k + 1) - 1)
        if (pair%mortar) then
          call weigh_nodes(pair, system%contact%routine(first:last) /= routine_none, &
            system%position%x_now, nodes)
          call take_history(pair%old_nodes, pair%nodes, nodes)
          nodes%status = kept_status(pair%nodes, nodes)
        else
          call weigh_points(pair, system%contact%routine(first:last) /= routine_none, &
            system%position%x_now, nodes)
          call take_point_history(pair, system%position%x_old, nodes)
        end if
        change = max(change, difference(pair%nodes, nodes))
        if (present(same)) same = same .and. are_same(pair%nodes, nodes)
        call place_new(system, k, waits, nodes)
        if (nodes%n == pair%nodes%n .and. allocated(pair%nodes%gap)) then
          nodes%gap = pair%nodes%gap
          nodes%criterion = pair%nodes%criterion
        end if
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

  !> Status of the multipliers so far.
  pure function kept_status(last, nodes) result(status)
    type(mortar_t), intent(in) :: last !! last iterate
    type(mortar_t), intent(in) :: nodes !! new ones
    integer :: status(nodes%n)

    status = status_open
    if (last%n == nodes%n .and. allocated(last%status)) status = last%status
  end function kept_status

  !> Largest difference of weights and frames; huge where other multipliers or nodes have come.
  pure real(wp) function difference(last, nodes) result(change)
    type(mortar_t), intent(in) :: last !! before
    type(mortar_t), intent(in) :: nodes !! now
    logical :: same

    change = huge(1.0_wp)
    if (.not. allocated(last%column)) return
    same = last%n == nodes%n .and. size(last%column) == size(nodes%column)
    if (same) same = all(last%node == nodes%node) .and. all(last%face == nodes%face) .and. &
      all(last%column == nodes%column)
    if (same) change = maxval([0.0_wp, maxval(abs(last%now - nodes%now)), &
      maxval(abs(last%frame - nodes%frame))])
  end function difference

  !> Forces of the multipliers with frozen weights, and the displacements that they make.
  subroutine solve_round(model, system, time, monitor, progress, moved)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(system_t), intent(inout) :: system !! u and forces of contact
    real(wp), intent(in) :: time !! end of the increment
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! solves, outcome
    real(wp), intent(out) :: moved !! by rigid bodies with a point in the round [length]
    type(mortar_system_t) :: unknowns
    type(mortar_factor_t) :: factor
    type(mortar_result_t) :: result

    call build_mortar(model, system, unknowns)
    associate (condensed => system%condensed)
      call solve_multipliers(unknowns, local_forces(model, unknowns), [condensed%rigid%alpha, &
        spread(0.0_wp, 1, system%tools%border%n)], factor, result)
      call take_result(model, unknowns, result, progress, system%costs)
      call spread_multipliers(unknowns, result%force, system)
      condensed%rigid%alpha = result%motion(:condensed%rigid%modes)
      call move_rigid(system, result%motion(condensed%rigid%modes + 1:))
      moved = maxval([0.0_wp, abs(result%motion(condensed%rigid%modes + 1:))])
      condensed%rigid%imbalance = 0.0_wp
      condensed%bulk%defect = 0.0_wp
      call place_candidates(system)
      system%position%x_now = model%mesh%x + system%u
      if (allocated(system%contact%reached)) deallocate (system%contact%reached)
    end associate
    call tell(time, result, progress, monitor)
  end subroutine solve_round

  !> Hands forces and status to the multipliers of the pairs, and says how the solve ended.
  subroutine take_result(model, unknowns, result, progress, costs)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(mortar_system_t), intent(in) :: unknowns !! which belong to which
    type(mortar_result_t), intent(in) :: result !! of the round
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(cost_t), intent(inout) :: costs !! cost table
    integer :: k

    progress%solves = max(1, progress%solves + result%steps)
    call count_cost(costs, cost_rounds, 1)
    call count_cost(costs, cost_dense_factor, result%steps)
    call count_cost(costs, cost_modified_newton, result%repeated)
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
  end subroutine take_result

  !> Reports a round.
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

!> Semismooth Newton with line search on a system whose contact hosts are frozen.
module newton
  use kinds, only: wp
  use costs, only: wall_seconds
  use signals, only: stop_requested
  use threads, only: notice_others
  use parallel, only: any_rank
  use bulk_term, only: form_bulk_change, bulk_step
  use back_ends, only: solver_done, solver_singular, solver_out_of_memory
  use linear_solver, only: solver_name
  use rigid_border, only: factorise_bordered, solve_bordered
  use contact_system, only: contact_counts
  use surface_shapes, only: follow_shape
  use residuals, only: form_residual, form_tangent, residual_norm, find_worst, estimate_round_off, &
    round_off_factor
  use force_scales, only: note_forces, force_scale, longest_step, needed_accuracy
  use supports, only: drop_bodies
  use piles, only: is_pile
  use drag, only: begin_drag, settle_drag, count_way
  use expected_status, only: forget_expected, turned_back, most_single
  use line_search, only: search_line, approach
  use live_values, only: direction_work
  use chord_steps, only: chords_t, follow_chords, settle_hidden
  use equation_values, only: spread_direction
  use condensed_system, only: find_defects, renew_defects
  use condensed_direction, only: find_condensed_direction, defect_energy
  use bulk_preconditioner, only: find_bulk_direction
  use near_steps, only: judge_nearness
  use model_types, only: model_t
  use multiplier_motion, only: take_multipliers, add_multipliers, settle_multipliers, &
    multipliers_fit
  use ground_release, only: release_ground
  use newton_progress, only: newton_t, is_converged, is_close, meets_energy, may_go_on, &
    wanted_share, count_creeping, judge_progress, judge_settled, outcome_going_on, &
    outcome_converged, outcome_stalled, outcome_too_many, outcome_singular, outcome_memory, &
    outcome_stopped, outcome_open, outcome_restless, outcome_gaps, outcome_inverted, &
    outcome_adrift, outcome_through, outcome_turned, outcome_thrown
  use monitors, only: monitor_t, iteration_t
  use system_types, only: system_t, settings_t
  implicit none
  private
  public :: newton_t, solve_frozen, iterate, is_converged
  public :: outcome_going_on, outcome_converged, outcome_stalled, outcome_too_many, &
    outcome_singular, outcome_memory, outcome_stopped, outcome_open, outcome_restless, &
    outcome_gaps, outcome_inverted, outcome_adrift, outcome_through, &
    outcome_turned, outcome_thrown

  !> Iterations in a row without progress after which the natural test is left out of the line
  !! search, and after which the solve has stalled.
  integer, parameter :: circling = 4, patience = 12
  !> Iterations with points that turn back after which a solve relies on the line search alone. In
  !! piles of bodies the search for the points that open uses up some of them.
  integer, parameter :: most_turns = 6, most_turns_of_pile = 14
  !> A point has turned back if it had slipped by more than this share of what it slips now: less is
  !! round-off of a solution.
  real(wp), parameter :: least_slip = 1.0e-6_wp
  !> What has converged may have this share of the forces left when its defects are renewed.
  real(wp), parameter :: true_share = 1.0e-10_wp
  !> A step that may go less than this share of its way leads nowhere.
  real(wp), parameter :: shortest_step = 1.0_wp/256.0_wp
  !> Iterations in balance whose multipliers do not fit, after which a solve is given up.
  integer, parameter :: most_misfits = 5

contains

  !> Iterates until the residual is in balance, or until that is hopeless.
  subroutine solve_frozen(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved
    real(wp), intent(in) :: time !! time of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of each iteration
    type(newton_t), intent(inout) :: progress !! counts on

    if (system%motion%active) call take_multipliers(model, system)
    call begin_drag(system)
    if (.not. system%place%begun) call form_residual(system, model%mesh%x)
    system%place%begun = .false.
    system%contact%slip_before = 0.0_wp
    if (progress%solves == 0) system%body%settled = .false.
    progress%share = 0.0_wp
    progress%lowest = residual_norm(system)
    progress%shortest = huge(1.0_wp)
    progress%fewest = huge(1)
    progress%since_lowest = 0
    progress%since_fewest = 0
    progress%energy_met = .false.
    progress%creeping = 0
    progress%short = 0
    progress%misfits = 0
    progress%halved = .true.
    progress%turns = 0
    progress%outcome = outcome_going_on
    do
      call judge(model, system, settings, progress)
      if (progress%outcome /= outcome_going_on) exit
      call iterate(model, system, time, settings, monitor, progress)
      if (progress%outcome == outcome_going_on) call go_on(model, system, settings, progress)
    end do
    call settle_hidden(model, system)
  end subroutine solve_frozen

  !> Whether the iterate is in balance, and if not, whether to go on.
  subroutine judge(model, system, settings, progress)
    type(model_t), intent(in) :: model !! mesh, pairs
    type(system_t), intent(inout) :: system !! residual formed before and after
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(inout) :: progress !! gets outcome
    logical :: sound, rests, hopeless

    do
      call estimate_round_off(system, model%mesh%x)
      call settle_drag(system, model%mesh%x, progress%halved, rests, hopeless)
      if (.not. rests) exit
      if (.not. is_converged(system, settings, progress)) exit
      if (.not. system%inner%linearised) then
        sound = settings%roughly
        if (.not. sound) call look_again(system, model%mesh%x, settings, sound)
        if (sound) call judge_multipliers(model, system, progress)
        exit
      end if
      system%inner%linearised = .false.
      call form_residual(system, model%mesh%x)
      if (system%inner%inverted > 0) progress%outcome = outcome_inverted
      if (progress%outcome /= outcome_going_on) exit
    end do
    if (progress%outcome /= outcome_going_on) return
    if (system%body%adrift) then
      progress%outcome = outcome_adrift
    else if (progress%solves >= settings%most_solves) then
      progress%outcome = outcome_too_many
    else if (hopeless .or. (max(progress%since_fewest, progress%short) >= patience .and. &
      system%body%drag <= 0.0_wp)) then
      progress%outcome = outcome_stalled
    else if (any_rank(stop_requested())) then
      progress%outcome = outcome_stopped
    end if
  end subroutine judge

  !> What is in balance has converged if its multipliers fit. If they do not, iteration after
  !! iteration, no more iterations will make them.
  subroutine judge_multipliers(model, system, progress)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(inout) :: system !! in balance
    type(newton_t), intent(inout) :: progress !! gets outcome, counts misfits

    progress%outcome = outcome_converged
    if (.not. system%motion%active) return
    if (multipliers_fit(model, system)) return
    progress%misfits = progress%misfits + 1
    progress%outcome = merge(outcome_gaps, outcome_going_on, progress%misfits >= most_misfits)
  end subroutine judge_multipliers

  !> Takes more steps with the factor of an iteration that went its whole way (doc/theory, "Modified
  !! Newton steps").
  subroutine go_on(model, system, settings, progress)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(inout) :: progress !! gets energy_met, halved
    type(chords_t) :: chords

    chords%bends = any(model%pairs%smooth) .and. is_close(progress)
    ! what single precision has left shows with the next step
    if (system%condensed%bulk%hidden > 0.0_wp) progress%energy_met = .false.
    if (progress%energy_met .or. .not. may_go_on(system, progress)) then
      call settle_hidden(model, system)
      return
    end if
    call follow_chords(model, system, settings%energy_tolerance, progress%first_energy, &
      progress%energy, force_scale(system)*wanted_share(settings), chords)
    progress%energy_met = chords%energy_met .or. chords%settled
    progress%halved = progress%halved .and. .not. chords%settled .and. &
      residual_norm(system) <= 0.5_wp*progress%start
  end subroutine go_on

  !> Directions of bodies that hardly anything holds are long and lose digits, and with them the
  !! defects that the condensed form carries on: what has converged is looked at with true ones.
  subroutine look_again(system, x, settings, sound)
    type(system_t), intent(inout) :: system !! residual is formed anew
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(settings_t), intent(in) :: settings !! tolerances
    logical, intent(out) :: sound !! it is small all the same

    sound = .true.
    if (.not. system%condensed%active .or. .not. any(system%body%weak)) return
    call renew_defects(system)
    call form_residual(system, x)
    sound = residual_norm(system) <= max(round_off_factor*system%scale%round_off, &
      max(true_share, settings%residual_tolerance)*force_scale(system))
  end subroutine look_again

  !> One iteration: tangent, factor, direction, line search.
  subroutine iterate(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved; residual formed before and after
    real(wp), intent(in) :: time !! time of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the iteration
    type(newton_t), intent(inout) :: progress !! counts on
    type(iteration_t) :: report
    real(wp) :: begin, length, longest
    integer, allocatable :: before(:)
    integer :: outcome
    logical :: dropped

    begin = wall_seconds()
    call notice_others()
    if (any(system%body%weak) .and. system%body%euler%iterations == 0) then
      call drop_bodies(model%mesh%x, system, dropped)
      if (dropped .and. system%condensed%active) call find_defects(system)
      if (dropped .and. system%body%drag > 0.0_wp) call begin_drag(system)
      if (dropped) call form_residual(system, model%mesh%x)
    end if
    progress%start = residual_norm(system)
    call choose_held(system, progress)
    call find_direction(system, model%mesh%x, settings, progress, outcome)
    if (outcome /= solver_done) then
      progress%outcome = merge(outcome_memory, outcome_singular, outcome == solver_out_of_memory)
      return
    end if
    if (system%motion%active) call add_multipliers(model, system, .true.)
    if (any(system%body%weak)) before = system%contact%status
    if (system%whole%solver%indefinite .and. .not. progress%indefinite) call monitor%detail( &
      '  the matrix is not positive definite: UMFPACK until the end of the increment')
    progress%indefinite = progress%indefinite .or. system%whole%solver%indefinite
    call forget_expected(system%contact)
    if (progress%solves >= most_single) system%contact%slide = .true.
    progress%solves = progress%solves + 1
    progress%energy = abs(direction_work(system)) + defect_energy(system)
    progress%most_energy = max(progress%energy, progress%most_energy)
    if (progress%solves == 1) progress%first_energy = max(progress%energy, &
      settings%first_energy)
    call bulk_step(model%mesh%x, system, longest)
    if (longest < shortest_step) then
      progress%outcome = outcome_inverted
      return
    end if
    longest = min(longest, longest_step(system))
    if (system%body%drag > 0.0_wp) then
      call search_line(system, model%mesh%x, progress%start, system%body%euler%iterations == 0, &
        .true., longest, length)
      call count_way(system, length)
    else if (any(system%body%grounded)) then
      call approach(system, model%mesh%x, progress%start, longest, length)
    else
      call search_line(system, model%mesh%x, progress%start, progress%updated .or. &
        system%inner%linearised .or. &
        any(system%contact%hold), progress%since_lowest < circling, longest, length)
    end if
    call judge_nearness(system, progress%start, length)
    progress%linearised = system%inner%linearised
    system%inner%linearised = .false.
    if (system%inner%inverted > 0) then
      progress%outcome = outcome_inverted
      return
    end if
    if (system%motion%active) call settle_multipliers(system, length)
    progress%length = length
    if (allocated(before)) call judge_settled(before, length, system)
    if (is_close(progress)) call follow_shape(model, system)
    progress%updated = .false.
    progress%energy_met = .false.
    if (length >= 1.0_wp .and. system%body%euler%iterations <= 1) &
      progress%energy_met = meets_energy(system, settings, progress)
    call count_creeping(system, settings, progress)
    progress%share = residual_norm(system)/max(progress%start, tiny(1.0_wp))
    progress%halved = progress%share <= 0.5_wp
    call note_forces(system)
    call describe(system, progress, time, length, wall_seconds() - begin, report)
    call judge_progress(system, report%stick, progress)
    call monitor%iteration(report)
  end subroutine iterate

  !> Tangent, factor, direction. Bodies that tracks alone were thought to hold are grounded if there
  !! is none.
  subroutine find_direction(system, x, settings, progress, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution, du
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! whether a matrix has been indefinite
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    call try_direction(system, x, settings, progress, outcome)
    if (outcome /= solver_singular .or. .not. system%body%settled .or. &
      system%condensed%active) return
    system%body%settled = .false.
    call try_direction(system, x, settings, progress, outcome)
  end subroutine find_direction

  !> Tangent, factor, direction of the system as it is held.
  subroutine try_direction(system, x, settings, progress, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution, du
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! whether a matrix has been indefinite
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    if (system%condensed%active) then
      call find_condensed_direction(system, x, outcome)
      system%contact%slip_before = system%contact%slip
      return
    end if
    if (system%condensed%preconditions) then
      call find_bulk_direction(system, x, force_scale(system)*wanted_share(settings), outcome)
      system%contact%slip_before = system%contact%slip
      if (outcome == solver_done) call spread_direction(system)
      return
    end if
    call form_tangent(system, x)
    system%contact%slip_before = system%contact%slip
    system%whole%solver%accuracy = needed_accuracy(system, progress%share, &
      wanted_share(settings))
    call factorise_bordered(system, system%whole%symmetric .and. .not. progress%indefinite, outcome)
    if (outcome == solver_done) call solve_bordered(system, system%right, system%solution, outcome)
    if (outcome /= solver_done) return
    call release_ground(system, x)
    call spread_direction(system)
    call form_bulk_change(system)
  end subroutine try_direction

  !> Chooses the points that stick in the next tangent: those whose slip has turned back since the
  !! iteration before, which else may flip for ever.
  subroutine choose_held(system, progress)
    type(system_t), intent(inout) :: system !! contact elements; gets hold
    type(newton_t), intent(inout) :: progress !! counts the iterations with such points

    if (progress%updated) return
    system%contact%hold = .false.
    if (progress%turns < merge(most_turns_of_pile, most_turns, is_pile(system))) &
      system%contact%hold = turned_back(system%contact, least_slip)
    if (any(system%contact%hold)) progress%turns = progress%turns + 1
  end subroutine choose_held

  !> The report of one iteration.
  subroutine describe(system, progress, time, length, seconds, report)
    type(system_t), intent(in) :: system !! state after the iteration
    type(newton_t), intent(in) :: progress !! counts and energies
    real(wp), intent(in) :: time !! time of the increment
    real(wp), intent(in) :: length !! accepted step length
    real(wp), intent(in) :: seconds !! wall clock [s]
    type(iteration_t), intent(out) :: report !! the report
    real(wp) :: forces

    report%time = time
    report%number = progress%solves
    report%residual = residual_norm(system)
    forces = force_scale(system)
    if (forces > 0.0_wp) report%relative = report%residual/forces
    call find_worst(system, report%worst_node, report%worst_dof, report%worst)
    report%energy = progress%energy
    report%step_length = length
    call contact_counts(system, 1, system%contact%n, report%active, report%stick, report%slip)
    report%solver = solver_name(system%whole%solver)
    if (system%condensed%active .or. system%condensed%preconditions) report%solver = 'REDUCED'
    report%seconds = seconds
  end subroutine describe
end module newton

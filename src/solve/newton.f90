!> Semismooth Newton with line search on a system whose contact hosts are frozen.
module newton
  use kinds, only: wp
  use costs, only: wall_seconds
  use signals, only: stop_requested
  use parallel, only: any_rank
  use bulk_term, only: form_bulk_change, bulk_step
  use back_ends, only: solver_done, solver_out_of_memory
  use linear_solver, only: solver_name
  use rigid_border, only: factorise_bordered, solve_bordered
  use contact_system, only: contact_counts
  use residuals, only: form_residual, form_tangent, residual_norm, find_worst, estimate_round_off, &
    round_off_factor
  use force_scales, only: note_forces, force_scale, in_bounds, longest_step, &
    needed_accuracy, least_meaning
  use supports, only: drop_bodies
  use drag, only: begin_drag, settle_drag, count_way
  use expected_status, only: forget_expected
  use line_search, only: search_line, approach, next_energy
  use live_values, only: direction_norm, direction_work
  use chord_steps, only: chords_t, follow_chords
  use equation_values, only: spread_direction
  use condensed_system, only: find_defects, renew_defects
  use condensed_direction, only: find_condensed_direction, defect_energy
  use bulk_preconditioner, only: find_bulk_direction
  use model_types, only: model_t
  use multiplier_motion, only: take_multipliers, add_multipliers, settle_multipliers, &
    multipliers_fit
  use ground_release, only: release_ground
  use monitors, only: monitor_t, iteration_t
  use system_types, only: system_t, settings_t
  implicit none
  private
  public :: newton_t, solve_frozen, iterate, is_converged
  public :: outcome_going_on, outcome_converged, outcome_stalled, outcome_too_many, &
    outcome_singular, outcome_memory, outcome_stopped, outcome_open, outcome_restless, &
    outcome_gaps, outcome_inverted, outcome_adrift

  !> How a solve ended.
  integer, parameter :: outcome_going_on = 0
  integer, parameter :: outcome_converged = 1
  integer, parameter :: outcome_stalled = 2
  integer, parameter :: outcome_too_many = 3
  integer, parameter :: outcome_singular = 4
  integer, parameter :: outcome_memory = 5
  integer, parameter :: outcome_stopped = 6
  integer, parameter :: outcome_open = 7
  integer, parameter :: outcome_restless = 8
  integer, parameter :: outcome_gaps = 9 !! AUGMent has not closed the gaps
  integer, parameter :: outcome_inverted = 10 !! an element would be turned inside out
  integer, parameter :: outcome_adrift = 11 !! a step of a body with a drag is done

  !> Iterations in a row without progress after which the natural test is left out of the line
  !! search, and after which the solve has stalled.
  integer, parameter :: circling = 4, patience = 12
  !> Below this share of the estimate it is converged at once.
  real(wp), parameter :: round_off_share = 0.1_wp
  !> The same in the condensed form, where another iteration costs next to nothing.
  real(wp), parameter :: condensed_share = 1.0e-3_wp
  !> Iterations with points that turn back after which a solve relies on the line search alone.
  integer, parameter :: most_turns = 6
  !> What has converged may have this share of the forces left when its defects are renewed.
  real(wp), parameter :: true_share = 1.0e-10_wp
  !> A step that may go less than this share of its way leads nowhere.
  real(wp), parameter :: shortest_step = 1.0_wp/256.0_wp
  !> Iterations of an increment after which points that stick on their cone slip in the tangent;
  !! else Newton lets go of one or two of them an iteration (doc/theory, "First direction").
  integer, parameter :: most_single = 5
  !> An energy test of TOL v also wants a relative residual of this times sqrt(v).
  real(wp), parameter :: residual_share = 1.0e-3_wp

  !> Progress of the iteration within one increment.
  type :: newton_t
    integer :: solves = 0 !! linear solves of the increment
    real(wp) :: first_energy = 0.0_wp !! |R.du| of the first iteration
    real(wp) :: energy = 0.0_wp !! |R.du| of the last iteration
    real(wp) :: start = 0.0_wp !! residual norm before the last iteration
    real(wp) :: lowest = 0.0_wp !! lowest residual norm of this solve
    real(wp) :: shortest = huge(1.0_wp) !! shortest direction of this solve
    integer :: fewest = huge(1) !! sticking points of this solve, lowest number
    integer :: since_lowest = 0 !! iterations since residual or direction has fallen
    integer :: since_fewest = 0 !! iterations since one of the three has fallen
    integer :: turns = 0 !! iterations of this solve with a point whose slip has turned back
    real(wp) :: length = 0.0_wp !! share of its direction that the last iteration went
    logical :: updated = .false. !! this solve follows an update of multipliers, its first iteration
    logical :: indefinite = .false. !! a symmetric matrix was not positive definite
    logical :: halved = .true. !! the last iteration, or step with a drag, has halved the residual
    logical :: energy_met = .false. !! the last full step met the energy tolerance
    integer :: outcome = outcome_going_on !! one of the outcomes
  end type newton_t

contains

  !> Iterates until the residual is in balance, or until that is hopeless.
  subroutine solve_frozen(model, system, time, settings, monitor, progress)
    type(model_t), intent(in) :: model !! mesh, pairs
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
    progress%lowest = residual_norm(system)
    progress%shortest = huge(1.0_wp)
    progress%fewest = huge(1)
    progress%since_lowest = 0
    progress%since_fewest = 0
    progress%energy_met = .false.
    progress%halved = .true.
    progress%turns = 0
    progress%outcome = outcome_going_on
    do
      call judge(model, system, settings, progress)
      if (progress%outcome /= outcome_going_on) exit
      call iterate(model, system, time, settings, monitor, progress)
      if (progress%outcome == outcome_going_on) call go_on(model, system, settings, progress)
    end do
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
        call look_again(system, model%mesh%x, settings, sound)
        if (sound .and. system%motion%active) sound = multipliers_fit(model, system)
        if (sound) progress%outcome = outcome_converged
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
    else if (hopeless .or. (progress%since_fewest >= patience .and. &
      system%body%drag <= 0.0_wp)) then
      progress%outcome = outcome_stalled
    else if (any_rank(stop_requested())) then
      progress%outcome = outcome_stopped
    end if
  end subroutine judge

  !> Takes more steps with the factor of an iteration that went its whole way (doc/theory, "Steps
  !! with the same factor"). Not where a body is grounded or dragged.
  subroutine go_on(model, system, settings, progress)
    type(model_t), intent(in) :: model !! mesh, pairs
    type(system_t), intent(inout) :: system !! u is moved
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(inout) :: progress !! gets energy_met, halved
    type(chords_t) :: chords

    if (progress%energy_met .or. progress%length < 1.0_wp) return
    if (system%contact%n == 0 .or. system%tools%border%n > 0) return
    if (system%body%drag > 0.0_wp .or. any(system%body%grounded)) return
    call follow_chords(model, system, settings%energy_tolerance, progress%first_energy, &
      progress%energy, chords)
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

  !> The residual is zero, at its round-off, or within the tolerance the deck sets; and no node has
  !! gone farther than a body can (doc/theory, "When an increment has converged").
  logical function is_converged(system, settings, progress) result(converged)
    type(system_t), intent(in) :: system !! residual formed
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! energies
    real(wp) :: norm, floor_factor

    converged = .false.
    if (.not. in_bounds(system)) return
    norm = residual_norm(system)
    floor_factor = merge(round_off_share, round_off_factor, progress%halved .and. &
      system%contact%n > 0)
    if (system%condensed%active .and. progress%halved) floor_factor = condensed_share
    if (norm <= min(floor_factor*system%scale%round_off, least_meaning(system))) then
      converged = .true.
    else if (settings%residual_tolerance > 0.0_wp) then
      converged = norm <= settings%residual_tolerance*force_scale(system)
    else
      converged = progress%energy_met .and. &
        norm <= residual_share*sqrt(settings%energy_tolerance)*force_scale(system)
    end if
  end function is_converged

  !> One iteration: tangent, factor, direction, line search.
  subroutine iterate(model, system, time, settings, monitor, progress)
    type(model_t), intent(in) :: model !! mesh, pairs
    type(system_t), intent(inout) :: system !! u is moved; residual formed before and after
    real(wp), intent(in) :: time !! time of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the iteration
    type(newton_t), intent(inout) :: progress !! counts on
    type(iteration_t) :: report
    real(wp) :: begin, length, longest
    integer :: outcome
    logical :: dropped

    begin = wall_seconds()
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
    if (system%whole%solver%indefinite .and. .not. progress%indefinite) call monitor%detail( &
      '  the matrix is not positive definite: UMFPACK until the end of the increment')
    progress%indefinite = progress%indefinite .or. system%whole%solver%indefinite
    call forget_expected(system%contact)
    if (progress%solves >= most_single) system%contact%slide = .true.
    progress%solves = progress%solves + 1
    progress%energy = abs(direction_work(system)) + defect_energy(system)
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
    system%inner%linearised = .false.
    if (system%inner%inverted > 0) then
      progress%outcome = outcome_inverted
      return
    end if
    if (system%motion%active) call settle_multipliers(system, length)
    progress%length = length
    progress%updated = .false.
    progress%energy_met = .false.
    if (length >= 1.0_wp .and. system%body%euler%iterations <= 1) &
      progress%energy_met = meets_energy(system, settings, progress)
    progress%halved = residual_norm(system) <= 0.5_wp*progress%start
    call note_forces(system)
    call describe(system, progress, time, length, wall_seconds() - begin, report)
    call judge_progress(system, report%stick, progress)
    call monitor%iteration(report)
  end subroutine iterate

  !> A full step has met the energy tolerance: its own energy did, or what it has left is so small,
  !! by the factor at hand, that the next step's would by far.
  logical function meets_energy(system, settings, progress) result(met)
    type(system_t), intent(inout) :: system !! factor and residual after the step; next is used
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! energies

    associate (tolerance => settings%energy_tolerance, first => progress%first_energy)
      met = progress%energy <= tolerance*first
      if (met .or. progress%energy > sqrt(tolerance)*first .or. any(system%body%grounded)) return
      met = next_energy(system) <= tolerance**1.5_wp*first
    end associate
  end function meets_energy

  !> An iteration has led on if residual or direction are smaller than ever in this solve. Where
  !! slip spreads along a surface, ring of points by ring, neither need be until it is through: so
  !! has one after which fewer points stick than ever (doc/theory, "Nonlinear solution").
  subroutine judge_progress(system, sticking, progress)
    type(system_t), intent(in) :: system !! state after the iteration
    integer, intent(in) :: sticking !! points that stick now
    type(newton_t), intent(inout) :: progress !! gets counts and lowest values

    progress%since_lowest = progress%since_lowest + 1
    progress%since_fewest = progress%since_fewest + 1
    if (residual_norm(system) < progress%lowest .or. &
      direction_norm(system) < progress%shortest) progress%since_lowest = 0
    if (progress%since_lowest == 0 .or. sticking < progress%fewest) progress%since_fewest = 0
    progress%lowest = min(progress%lowest, residual_norm(system))
    progress%shortest = min(progress%shortest, direction_norm(system))
    progress%fewest = min(progress%fewest, sticking)
  end subroutine judge_progress

  !> Tangent, factor, direction.
  subroutine find_direction(system, x, settings, progress, outcome)
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
      call find_bulk_direction(system, x, force_scale(system)*max(settings%residual_tolerance, &
        residual_share*sqrt(settings%energy_tolerance)), outcome)
      system%contact%slip_before = system%contact%slip
      if (outcome /= solver_done) return
      call release_ground(system, x)
      call spread_direction(system)
      return
    end if
    call form_tangent(system, x)
    system%contact%slip_before = system%contact%slip
    system%whole%solver%accuracy = needed_accuracy(system, &
      max(settings%residual_tolerance, residual_share*sqrt(settings%energy_tolerance)))
    call factorise_bordered(system, system%whole%symmetric .and. .not. progress%indefinite, outcome)
    if (outcome == solver_done) call solve_bordered(system, system%right, system%solution, outcome)
    if (outcome /= solver_done) return
    call release_ground(system, x)
    call spread_direction(system)
    call form_bulk_change(system)
  end subroutine find_direction

  !> Chooses the points that stick in the next tangent: those whose slip has turned back since the
  !! iteration before, which else may flip for ever.
  subroutine choose_held(system, progress)
    type(system_t), intent(inout) :: system !! contact elements; gets hold
    type(newton_t), intent(inout) :: progress !! counts the iterations with such points

    if (progress%updated) return
    system%contact%hold = .false.
    if (progress%turns < most_turns) system%contact%hold = &
      sum(system%contact%slip*system%contact%slip_before, 1) < 0.0_wp
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

!> Semismooth Newton with line search on a system whose contact targets are frozen.
module newton
  use kinds, only: wp
  use back_ends, only: solver_done, solver_out_of_memory
  use residuals, only: form_residual, follow_shape, residual_norm, round_off_of, &
    round_off_factor
  use force_scales, only: least_forces, force_scale, longest_step
  use supports, only: close_bodies
  use pseudo_time, only: begin_pseudo_time, settle_pseudo_step, count_way
  use point_status, only: forget_expected
  use line_search, only: choose_length
  use modified_newton, only: modified_newton_t, follow_modified_newton
  use model_types, only: model_t
  use multiplier_types, only: settle_multipliers
  use newton_progress, only: newton_t, is_converged, is_close, meets_energy, may_go_on, &
    wanted_share, judge_progress, judge_settled, begin_iteration, choose_held, heed_stop, &
    describe, outcome_going_on, &
    outcome_converged, outcome_stalled, outcome_too_many, outcome_singular, outcome_memory, &
    outcome_stopped, outcome_open, outcome_restless, outcome_gaps, outcome_inverted, &
    outcome_step_done, outcome_through, outcome_turned, outcome_thrown
  use monitors, only: monitor_t, iteration_t
  use newton_settings, only: settings_t, tol_energy, tol_residual
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: newton_t, solve_frozen, iterate, is_converged
  public :: outcome_going_on, outcome_converged, outcome_stalled, outcome_too_many, &
    outcome_singular, outcome_memory, outcome_stopped, outcome_open, outcome_restless, &
    outcome_gaps, outcome_inverted, outcome_step_done, outcome_through, &
    outcome_turned, outcome_thrown

  !> Iterations in a row without progress after which the solve has stalled.
  integer, parameter :: iterations_without_gain = 12
  !> What has converged may have this share of the forces left when its defects are renewed.
  real(wp), parameter :: true_share = 1.0e-10_wp
  !> A step that may go less than this share of its way leads nowhere.
  real(wp), parameter :: shortest_step = 1.0_wp/256.0_wp
  !> Iterations in balance whose multipliers do not fit, after which a solve is given up.
  integer, parameter :: most_misfits = 5

contains

  !> Iterates until the residual is in balance, or until that is hopeless.
  subroutine solve_frozen(model, system, form, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! time of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of each iteration
    type(newton_t), intent(inout) :: progress !! counts on

    call begin_pseudo_time(progress%pseudo_time, system%u, system%tools, system%body, form)
    if (.not. system%place%begun) call form_residual(system, form, model%mesh%x)
    system%place%begun = .false.
    system%contact%slip_before = 0.0_wp
    if (progress%solves == 0) system%body%settled = .false.
    progress%share = 0.0_wp
    progress%lowest = residual_norm(system, form)
    progress%shortest = huge(1.0_wp)
    progress%fewest = huge(1)
    progress%since_lowest = 0
    progress%since_fewest = 0
    progress%energy_met = .false.
    progress%short = 0
    progress%misfits = 0
    progress%halved = .true.
    progress%turns = 0
    progress%outcome = outcome_going_on
    do
      call judge(model, system, form, settings, progress)
      if (progress%outcome /= outcome_going_on) exit
      call iterate(model, system, form, time, settings, monitor, progress)
      if (progress%outcome == outcome_going_on) call go_on(model, system, form, settings, progress)
    end do
  end subroutine solve_frozen

  !> Whether the iterate is in balance, and if not, whether to go on.
  subroutine judge(model, system, form, settings, progress)
    type(model_t), intent(in) :: model !! mesh, pairs
    type(system_t), intent(inout) :: system !! residual formed before and after
    type(form_t), intent(inout) :: form !! its kind answers
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(inout) :: progress !! gets outcome
    logical :: sound, rests, hopeless

    do
      system%scale%round_off = round_off_of(system, form, model%mesh%x)
      call settle_pseudo_step(progress%pseudo_time, system, form, model%mesh%x, progress%halved, &
        rests, hopeless)
      if (.not. rests) exit
      if (.not. is_converged(system, form, settings, progress)) exit
      if (.not. form%inner%linearised) then
        sound = settings%coarsely
        if (.not. sound) call look_again(system, form, model%mesh%x, settings, sound)
        if (sound) call judge_multipliers(model, system, progress)
        exit
      end if
      form%inner%linearised = .false.
      call form_residual(system, form, model%mesh%x)
      if (form%inner%inverted > 0) progress%outcome = outcome_inverted
      if (progress%outcome /= outcome_going_on) exit
    end do
    if (progress%outcome /= outcome_going_on) return
    if (progress%pseudo_time%step_done) then
      progress%outcome = outcome_step_done
    else if (progress%solves >= settings%most_solves) then
      progress%outcome = outcome_too_many
    else if (hopeless .or. (max(progress%since_fewest, progress%short) >= iterations_without_gain &
      .and. system%body%damping <= 0.0_wp)) then
      progress%outcome = outcome_stalled
    else
      call heed_stop(progress)
    end if
  end subroutine judge

  !> What is in balance has converged if its multipliers fit. If they do not, iteration after
  !! iteration, no more iterations will make them.
  subroutine judge_multipliers(model, system, progress)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! in balance
    type(newton_t), intent(inout) :: progress !! gets outcome, counts misfits

    progress%outcome = outcome_converged
    if (.not. system%motion%active) return
    if (system%terms%multipliers_fit(model, system)) return
    progress%misfits = progress%misfits + 1
    progress%outcome = merge(outcome_gaps, outcome_going_on, progress%misfits >= most_misfits)
  end subroutine judge_multipliers

  !> Takes more steps with the factor of an iteration that went its whole way (doc/theory, "Modified
  !! Newton steps").
  subroutine go_on(model, system, form, settings, progress)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved
    type(form_t), intent(inout) :: form !! gets trial
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(inout) :: progress !! gets energy_met, halved
    type(modified_newton_t) :: modified

    modified%bends = any(model%pairs%smooth) .and. is_close(progress)
    if (progress%energy_met .or. .not. may_go_on(system, form, progress)) return
    call follow_modified_newton(model, system, form, settings%asked(tol_energy), &
      progress%first_energy, progress%energy, force_scale(system%scale)*wanted_share(settings), &
      modified)
    progress%energy_met = modified%energy_met .or. modified%settled
    progress%halved = progress%halved .and. .not. modified%settled .and. &
      residual_norm(system, form) <= 0.5_wp*progress%start
  end subroutine go_on

  !> What has converged is looked at without what iterations have carried on and lost digits of.
  subroutine look_again(system, form, x, settings, sound)
    type(system_t), intent(inout) :: system !! residual is formed anew
    type(form_t), intent(inout) :: form !! its kind answers
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(settings_t), intent(in) :: settings !! tolerances
    logical, intent(out) :: sound !! it is small all the same

    sound = .true.
    if (.not. associated(form%kind%renew)) return
    call form%kind%renew(form, system%u)
    call form_residual(system, form, x)
    sound = residual_norm(system, form) <= max(round_off_factor*system%scale%round_off, &
      max(true_share, settings%asked(tol_residual))*force_scale(system%scale))
  end subroutine look_again

  !> One iteration: tangent, factor, direction, line search.
  subroutine iterate(model, system, form, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved; residual formed before and after
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! time of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the iteration
    type(newton_t), intent(inout) :: progress !! counts on
    type(iteration_t) :: report
    real(wp) :: length, longest
    integer, allocatable :: before(:)
    integer :: outcome
    logical :: dropped

    call begin_iteration(report)
    if (any(system%body%floating) .and. progress%pseudo_time%iterations == 0) then
      call close_bodies(model%mesh%x, system, form, dropped)
      if (dropped .and. associated(form%kind%note_moved)) call form%kind%note_moved(system, form)
      if (dropped .and. system%body%damping > 0.0_wp) call begin_pseudo_time( &
        progress%pseudo_time, system%u, system%tools, system%body, form)
      if (dropped) call form_residual(system, form, model%mesh%x)
    end if
    progress%start = residual_norm(system, form)
    call choose_held(system%contact, system%body, progress)
    form%wish%share = progress%share
    form%wish%wanted = wanted_share(settings)
    form%wish%indefinite = progress%indefinite
    call form%kind%find_direction(system, form, model%mesh%x, outcome)
    system%contact%slip_before = system%contact%slip
    if (outcome /= solver_done) then
      progress%outcome = merge(outcome_memory, outcome_singular, outcome == solver_out_of_memory)
      return
    end if
    if (system%motion%active) call system%terms%add_multipliers(model, system, form, .true.)
    if (any(system%body%floating)) before = system%contact%status
    if (form%whole%solver%indefinite .and. .not. progress%indefinite) call monitor%detail( &
      '  the matrix is not positive definite: UMFPACK until the end of the increment')
    progress%indefinite = progress%indefinite .or. form%whole%solver%indefinite
    call forget_expected(system%contact)
    progress%solves = progress%solves + 1
    progress%energy = abs(form%kind%direction_work(system, form))
    if (associated(form%kind%defect_energy)) progress%energy = progress%energy + &
      form%kind%defect_energy(form)
    progress%most_energy = max(progress%energy, progress%most_energy)
    if (progress%solves == 1) progress%first_energy = max(progress%energy, settings%first_energy)
    call system%terms%step_share(model%mesh%x, system%bulk, system%u, form%inner, form%du, &
      longest)
    if (longest < shortest_step) then
      progress%outcome = outcome_inverted
      return
    end if
    longest = min(longest, longest_step(system, form%du))
    call choose_length(system, form, model%mesh%x, settings, progress, longest, length)
    if (system%body%damping > 0.0_wp) call count_way(progress%pseudo_time, system%equations, &
      system%body, form%solution, length)
    if (associated(form%kind%judge_step)) call form%kind%judge_step(system, form, progress%start, &
      length)
    progress%linearised = form%inner%linearised
    form%inner%linearised = .false.
    if (form%inner%inverted > 0) then
      progress%outcome = outcome_inverted
      return
    end if
    if (system%motion%active) call settle_multipliers(system%motion, length)
    progress%length = length
    if (allocated(before)) call judge_settled(before, length, system%contact, system%body)
    if (is_close(progress)) call follow_shape(model, system, form)
    progress%updated = .false.
    progress%energy_met = .false.
    if (length >= 1.0_wp .and. progress%pseudo_time%iterations <= 1) &
      progress%energy_met = meets_energy(system, form, settings, progress)
    progress%share = residual_norm(system, form)/max(progress%start, tiny(1.0_wp))
    progress%halved = progress%share <= 0.5_wp
    system%scale%seen_forces = least_forces(system, form)
    call describe(system, form, progress, time, report)
    call judge_progress(system, form, report%stick, progress)
    call monitor%iteration(report)
  end subroutine iterate

end module newton

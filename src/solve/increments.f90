!> One increment: start, solves with frozen hosts, multipliers, acceptance.
module increments
  use kinds, only: wp
  use linear_solver, only: rest_solver
  use model_types, only: model_t
  use increment_start, only: take_overlaps, begin_at, choose_start, start_here, start_again, &
    start_rubbing
  use contact_system, only: move_hosts, renew_surfaces, load_contact, couple, settle_contact
  use touch_path, only: touch_waits
  use first_touch, only: begin_touch_again, find_touches, keep_path
  use force_scales, only: force_scale
  use drag, only: let_free
  use solver_choice, only: choose_solver
  use condensed_system, only: refresh_candidates, recover_interior, keep_forces
  use linear_sums, only: can_do_without, form_sums, take_sums
  use newton, only: newton_t, solve_frozen, outcome_converged, outcome_stalled, &
    outcome_too_many, outcome_restless, outcome_singular, outcome_gaps, outcome_adrift, &
    is_converged
  use contact_report, only: restless_point
  use contact_parameters, only: is_stiff, shifts_gap, raise_along, most_updates
  use contact_types, only: forget_moves
  use augmentation, only: augmentation_t, check_gaps, update_multipliers
  use multiplier_motion, only: hand_back_multipliers
  use follower_pressure, only: take_pressure_force
  use springs, only: spring_reactions
  use rigid_bodies, only: keep_rigid
  use monitors, only: monitor_t
  use system_types, only: system_t, state_t, settings_t
  use text, only: to_text, count_noun
  implicit none
  private
  public :: solve_increment, follow_solution, settle_touches, accept

  !> A smooth surface whose height has changed by less than this share of a facet has its shape.
  real(wp), parameter :: patch_tolerance = 1.0e-12_wp
  !> Changes of the shape of smooth surfaces after which an increment is solved once more.
  integer, parameter :: most_renewals = 16
  !> With a drag a body first goes this share of a facet in an iteration, and has this many times
  !! the solves, passes and updates of multipliers.
  real(wp), parameter :: drag_way = 0.05_wp
  integer, parameter :: drag_patience = 6
  !> Energy tolerance of the first solve where surfaces are smooth.
  real(wp), parameter :: rough_energy = 1.0e-2_wp

contains

  !> Solves for the state at `time`. On failure nothing is accepted: history and state stay.
  subroutine solve_increment(model, system, state, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! history of its pairs is committed on success
    type(system_t), intent(inout) :: system !! u is the new state on success
    type(state_t), intent(inout) :: state !! last converged state; the new one on success
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(out) :: progress !! how it ended
    logical :: choice, stayed, failed

    call choose_solver(model, system, monitor)
    model%pairs%history%softened = is_stiff(model%pairs)
    system%position%x_old = model%mesh%x + state%u
    call take_overlaps(model, time)
    call begin_at(model, system, state, time)
    call choose_start(model, system, state, time, monitor)
    choice = any(abs(system%position%carried - system%position%left) > 0.0_wp)
    stayed = any(abs(system%position%carried - system%u) > 0.0_wp)
    if (any(shifts_gap(model%pairs))) then
      call solve_with_multipliers(model, system, time, settings, monitor, progress)
    else
      call solve_from_start(model, system, time, settings, monitor, progress)
    end if
    failed = any(progress%outcome == [outcome_stalled, outcome_too_many, outcome_restless])
    if (system%touch%stage == touch_waits) then
      choice = .true.
      failed = failed .or. progress%outcome == outcome_singular
    end if
    if (choice .and. failed) then
      call start_again(model, system, stayed, monitor)
      progress = newton_t()
      call solve_from_start(model, system, time, settings, monitor, progress)
    end if
    if (any(system%body%weak) .and. any(progress%outcome == [outcome_stalled, outcome_too_many, &
      outcome_restless, outcome_singular])) then
      call let_down(model, system, time, settings, monitor, progress)
    end if
    if (any(model%pairs%history%crowded)) call tell_crowded(model, monitor)
    if (progress%outcome /= outcome_converged) return
    system%motion%hopeless = .false.
    call accept(model, system, state, time)
  end subroutine solve_increment

  !> Once more, now with a drag on the bodies that contact alone holds: they move by a share of a
  !! facet in an iteration, as if they sank through honey (doc/theory, "Bodies that contact holds").
  subroutine let_down(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left given; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(newton_t), intent(inout) :: progress !! how it ended
    type(settings_t) :: patient
    real(wp) :: norm

    call monitor%detail('  no convergence: once more with a drag on bodies that contact holds')
    system%u = system%position%left
    call start_here(model, system, norm)
    progress = newton_t()
    patient = settings
    patient%most_solves = drag_patience*settings%most_solves
    patient%most_passes = drag_patience*settings%most_passes
    system%body%first_drag = max(force_scale(system), norm)/(drag_way*max(system%scale%facet_size, &
      tiny(1.0_wp)))
    call solve_from_start(model, system, time, patient, monitor, progress)
    call let_free(system)
  end subroutine let_down

  !> Says once that a segmented pair has fewer points than its cells want.
  subroutine tell_crowded(model, monitor)
    type(model_t), intent(inout) :: model !! pairs: what has been told
    class(monitor_t), intent(inout) :: monitor !! hears of it
    integer :: k

    do k = 1, size(model%pairs)
      if (model%pairs(k)%history%crowd_told .or. .not. model%pairs(k)%history%crowded) cycle
      model%pairs(k)%history%crowd_told = .true.
      call monitor%warning('pair '//model%pairs(k)%name//': the slave lies on more facets than '// &
        'there is room for ('//to_text(size(model%pairs(k)%history%cells))//' points): some '// &
        'slave facets have one point a cell or fewer, and what they carry is not exact from '// &
        'here on; write a number of points in place of SEGMent, or make '// &
        'the coarser surface the master')
    end do
  end subroutine tell_crowded

  !> Lets the multipliers come along with Newton's iteration; if that fails, they are updated
  !! between solves (doc/theory, "Multipliers that come along").
  subroutine solve_with_multipliers(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    real(wp) :: start(3, size(system%u, 2)), norm
    integer :: k
    logical :: failed

    start = system%u
    system%motion%active = .true.
    do k = 1, size(model%pairs)
      model%pairs(k)%history%raise = raise_along(model%pairs(k))
    end do
    call solve_from_start(model, system, time, settings, monitor, progress)
    system%motion%active = .false.
    failed = any(progress%outcome == [outcome_stalled, outcome_too_many, outcome_restless, &
      outcome_singular, outcome_gaps])
    if (.not. failed .or. system%motion%hopeless) return
    call monitor%detail('  no convergence: once more with multipliers that rest while Newton '// &
      'iterates')
    call begin_touch_again(system)
    system%u = start
    call start_here(model, system, norm)
    progress = newton_t()
    call solve_from_start(model, system, time, settings, monitor, progress)
    system%motion%hopeless = progress%outcome /= outcome_converged
  end subroutine solve_with_multipliers

  !> Solves with fixed multipliers, and with better ones until the gaps are closed.
  subroutine solve_from_start(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(augmentation_t) :: augmentation
    type(settings_t) :: budget

    call solve_with_hosts(model, system, time, settings, monitor, progress)
    if (.not. any(shifts_gap(model%pairs))) return
    if (system%motion%active .and. progress%outcome == outcome_converged) then
      call follow_freely(model, system, time, settings, monitor, progress)
    end if
    budget = settings
    augmentation%gentle = system%body%first_drag > 0.0_wp
    do while (progress%outcome == outcome_converged)
      call check_gaps(model, system, augmentation, monitor)
      if (augmentation%closed) return
      if (augmentation%updates >= merge(drag_patience, 1, augmentation%gentle)* &
        maxval(most_updates(model%pairs), shifts_gap(model%pairs))) then
        progress%outcome = outcome_gaps
        return
      end if
      call update_multipliers(model, system, augmentation, monitor)
      progress%updated = .true.
      budget%most_solves = progress%solves + settings%most_solves
      call solve_with_hosts(model, system, time, budget, monitor, progress)
    end do
  end subroutine solve_from_start

  !> Hosts chosen far from the solution may be left again for those that points come from: if any
  !! is, the increment is solved on.
  subroutine follow_freely(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! converged
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! counts on
    type(settings_t) :: budget
    integer :: renewals, k
    logical :: settled

    do k = 1, size(model%pairs)
      if (shifts_gap(model%pairs(k))) call forget_moves(model%pairs(k))
    end do
    renewals = 0
    call follow_solution(model, system, settings, monitor, renewals, settled)
    if (settled) return
    budget = settings
    budget%most_solves = progress%solves + settings%most_solves
    call solve_with_hosts(model, system, time, budget, monitor, progress)
  end subroutine follow_freely

  !> Solves with frozen hosts until the hosts stay and smooth surfaces have their shape. While the
  !! shape changes, solves are rough (doc/theory, "Smooth surfaces").
  subroutine solve_with_hosts(model, system, time, given, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: given !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(settings_t) :: settings, budget
    integer :: pass, renewals, before
    logical :: settled, rough

    settings = given
    rough = any(model%pairs%smooth) .and. progress%solves == 0
    renewals = 0
    pass = 0
    do while (pass < settings%most_passes)
      budget = settings
      if (rough) budget = roughened(settings, progress, renewals)
      if (.not. system%place%begun) call load_contact(model, system)
      if (.not. (system%place%begun .and. system%condensed%active)) call couple(system)
      call solve_frozen(model, system, time, budget, monitor, progress)
      if (system%motion%active) call hand_back_multipliers(model, system)
      if (progress%outcome == outcome_too_many .and. &
        budget%most_solves < settings%most_solves) then
        progress%outcome = outcome_converged
      end if
      if (progress%outcome == outcome_adrift) then
        call follow_solution(model, system, settings, monitor, renewals, settled)
        cycle
      end if
      if (progress%outcome /= outcome_converged .or. size(model%pairs) == 0) return
      if (rough) rough = .not. is_fine(system, settings, progress)
      if (.not. rough) budget = settings
      before = renewals
      call follow_solution(model, system, budget, monitor, renewals, settled)
      if (settled .and. .not. rough) then
        call settle_touches(model, system, monitor, settled)
        if (settled) return
        call start_rubbing(model, system, settings)
        pass = 0
        renewals = 0
        rough = any(model%pairs%smooth)
        settings%most_solves = progress%solves + given%most_solves
        cycle
      end if
      rough = rough .and. renewals > before
      if (renewals == before) pass = pass + 1
    end do
    progress%outcome = outcome_restless
    call monitor%warning('contact points do not settle on a facet: '//restless_point(model))
  end subroutine solve_with_hosts

  !> Settings of a rough solve: few digits at first, then a single iteration for each new shape.
  !! A host that a point leaves in between may take it back.
  pure type(settings_t) function roughened(settings, progress, renewals) result(budget)
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! its solves so far
    integer, intent(in) :: renewals !! changes of shape so far

    budget = settings
    budget%energy_tolerance = max(rough_energy, settings%energy_tolerance)
    budget%extrapolation = 0.0_wp
    if (renewals > 0 .and. progress%energy <= rough_energy**2*progress%first_energy) &
      budget%most_solves = min(progress%solves + 1, settings%most_solves)
  end function roughened

  !> A solve, rough or not, has met the settings.
  logical function is_fine(system, settings, progress) result(fine)
    type(system_t), intent(in) :: system !! residual formed
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! energies
    type(newton_t) :: exact

    exact = progress
    exact%energy_met = progress%energy <= settings%energy_tolerance*progress%first_energy
    fine = is_converged(system, settings, exact)
  end function is_fine

  !> After a solve: hosts follow the tips, and smooth surfaces take the shape of their facets.
  subroutine follow_solution(model, system, settings, monitor, renewals, settled)
    type(model_t), intent(inout) :: model !! pairs: working points, patches
    type(system_t), intent(inout) :: system !! converged with the hosts and patches so far
    type(settings_t), intent(in) :: settings !! how far a tip may lie outside its host
    class(monitor_t), intent(inout) :: monitor !! hears of changes
    integer, intent(inout) :: renewals !! changes of shape in this increment that counted
    logical, intent(out) :: settled !! nothing has changed; else it is to be solved again
    integer :: changes

    if (system%condensed%active) call refresh_candidates(system)
    system%position%x_now = model%mesh%x + system%u
    call move_hosts(model, system, settings%extrapolation, changes)
    call renew_surfaces(model, system, patch_tolerance, settled)
    if (renewals == most_renewals) settled = .true.
    if (.not. settled) renewals = renewals + 1
    if (changes > 0) then
      call monitor%detail('  '//to_text(changes)//' contact points moved to another facet')
    else if (.not. settled) then
      call monitor%detail('  the smooth surface has changed its shape')
    end if
    settled = settled .and. changes == 0
  end subroutine follow_solution

  !> After a solve that has settled: points whose friction has waited get their tips.
  subroutine settle_touches(model, system, monitor, settled)
    type(model_t), intent(inout) :: model !! pairs: start tips
    type(system_t), intent(inout) :: system !! touch
    class(monitor_t), intent(inout) :: monitor !! hears of it
    logical, intent(out) :: settled !! no such point has touched
    integer :: touches

    call find_touches(model, system, touches)
    settled = touches == 0
    if (.not. settled) call monitor%detail('  '//count_noun(touches, 'contact point')// &
      ' touched first in this increment: friction from there')
  end subroutine settle_touches

  !> Takes the converged iterate as the new state.
  subroutine accept(model, system, state, time)
    type(model_t), intent(inout) :: model !! history is committed
    type(system_t), intent(inout) :: system !! converged
    type(state_t), intent(inout) :: state !! becomes the new state
    real(wp), intent(in) :: time !! its time

    if (can_do_without(model, system)) then
      state%whole = system%inside_due
      if (.not. system%condensed%sums%known) call form_sums(model, system)
    else
      state%whole = .true.
    end if
    if (system%condensed%active) then
      if (state%whole) call recover_interior(system)
      if (.not. state%whole) call refresh_candidates(system)
      call keep_forces(system%condensed)
    end if
    call keep_path(model, system, state, time)
    state%u = system%u
    state%time = time
    if (state%whole) then
      call take_pressure_force(model%mesh%x, system)
      where (system%equation == 0)
        state%reaction = system%inner%bulk_force + system%contact_force - system%loads%external
      else where
        state%reaction = 0.0_wp
      end where
      call spring_reactions(system, state)
      call keep_rigid(system, state)
    else
      call take_sums(system)
    end if
    system%position%x_now = model%mesh%x + state%u
    call settle_contact(model, system)
    call rest_solver(system%whole%solver)
  end subroutine accept
end module increments

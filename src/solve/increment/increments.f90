!> One increment: start, solves with frozen hosts, multipliers, acceptance.
module increments
  use kinds, only: wp
  use threads, only: notice_others
  use linear_solver, only: rest_solver
  use model_types, only: model_t
  use increment_start, only: take_overlaps, begin_at, choose_start, start_here, &
    start_again, leave_bodies
  use contact_system, only: settle_contact
  use touch_path, only: touch_waits
  use first_touch, only: keep_path
  use force_scales, only: force_scale
  use drag, only: let_free, drag_patience
  use solver_choice, only: choose_solver
  use condensed_system, only: refresh_candidates, recover_interior, keep_forces
  use linear_sums, only: can_do_without, form_sums, take_sums
  use newton, only: newton_t, outcome_converged, outcome_stalled, outcome_too_many, &
    outcome_restless, outcome_singular, outcome_through, outcome_turned, &
    outcome_thrown
  use contact_parameters, only: is_stiff, shifts_gap
  use contact_entries, only: has_gone_through
  use multiplier_ways, only: solve_with_multipliers, solve_from_start, rest_then_along, &
    has_failed
  use follower_pressure, only: take_pressure_force
  use springs, only: spring_reactions
  use rigid_bodies, only: keep_rigid
  use soft_penalties, only: may_soften, solve_from_soft
  use lost_contact, only: has_thrown, has_turned
  use late_look, only: look_inside
  use monitors, only: monitor_t
  use system_types, only: system_t, state_t, settings_t
  use text, only: to_text
  implicit none
  private
  public :: solve_increment, accept, look_for_strays, complete_state

  !> With a drag a body first goes this share of a facet in an iteration.
  real(wp), parameter :: drag_way = 0.05_wp
  !> A drag that has led nowhere so often since the last increment that was accepted is not tried
  !! with shorter ones: these start near their end, if they have one.
  integer, parameter :: most_in_vain = 2
  !> An increment is solved so often with nodes that touch where nobody foresaw it.
  integer, parameter :: most_looks = 8

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
    logical :: known, missed
    integer :: look

    call notice_others()
    call choose_solver(model, system, monitor)
    model%pairs%history%softened = is_stiff(model%pairs)
    system%position%x_old = model%mesh%x + state%u
    call take_overlaps(model, time)
    do look = 1, most_looks
      call begin_at(model, system, state, time)
      call choose_start(model, system, state, time, monitor)
      call solve_usual(model, system, time, settings, monitor, progress)
      if (any(model%pairs%history%crowded)) call tell_crowded(model, monitor)
      if (progress%outcome /= outcome_converged) return
      call look_inside(model, system, state, settings, monitor, known, missed)
      if (.not. missed) exit
      progress%outcome = outcome_restless
    end do
    if (progress%outcome == outcome_converged) call look_for_strays(model, system, progress)
    if (progress%outcome /= outcome_converged) return
    system%motion%hopeless = .false.
    system%body%in_vain = 0
    call accept(model, system, state, time, known)
  end subroutine solve_increment

  !> Solves from the start that has been chosen, then from the other one, then with a drag.
  subroutine solve_usual(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    logical :: choice, stayed, failed, thrown

    choice = any(abs(system%position%carried - system%position%left) > 0.0_wp)
    stayed = any(abs(system%position%carried - system%u) > 0.0_wp)
    if (any(shifts_gap(model%pairs))) then
      call solve_with_multipliers(model, system, time, settings, monitor, progress)
    else
      call solve_from_start(model, system, time, settings, monitor, progress)
    end if
    call look_for_thrown(model, system, progress, monitor, thrown)
    failed = any(progress%outcome == [outcome_stalled, outcome_too_many, outcome_restless]) .or. &
      thrown
    if (system%touch%stage == touch_waits) then
      choice = .true.
      failed = failed .or. progress%outcome == outcome_singular
    end if
    if (choice .and. failed) then
      call start_again(model, system, stayed, monitor)
      progress = newton_t()
      call solve_from_start(model, system, time, settings, monitor, progress)
      call look_for_thrown(model, system, progress, monitor, thrown)
    end if
    if (may_soften(model) .and. any(progress%outcome == [outcome_stalled, outcome_too_many])) then
      call solve_from_soft(model, system, time, settings, monitor, progress)
      call look_for_thrown(model, system, progress, monitor, thrown)
    end if
    failed = any(progress%outcome == [outcome_stalled, outcome_too_many, outcome_restless, &
      outcome_singular]) .or. thrown
    if (failed .and. any(system%body%weak) .and. system%body%in_vain < most_in_vain) then
      call let_down(model, system, time, settings, monitor, progress)
      if (progress%outcome /= outcome_converged) system%body%in_vain = system%body%in_vain + 1
    end if
  end subroutine solve_usual

  !> Says it where what has converged has thrown bodies out of contact, or turned them farther than
  !! small strain can mean: the next start may lead elsewhere.
  subroutine look_for_thrown(model, system, progress, monitor, thrown)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! the last iterate
    type(newton_t), intent(in) :: progress !! how it ended
    class(monitor_t), intent(inout) :: monitor !! hears of it
    logical, intent(out) :: thrown !! it has

    thrown = .false.
    if (progress%outcome /= outcome_converged) return
    thrown = has_thrown(model, system)
    if (thrown) then
      call monitor%detail('  bodies have flown out of contact, which has no force left on '// &
        'them: not taken for the solution')
      return
    end if
    thrown = has_turned(model, system)
    if (thrown) call monitor%detail('  a body has turned farther than small strain can mean: '// &
      'not taken for the solution')
  end subroutine look_for_thrown

  !> What has converged with a slave that has gone through a master is no solution; nor where bodies
  !! have been thrown out of contact, or turned too far.
  subroutine look_for_strays(model, system, progress)
    type(model_t), intent(inout) :: model !! pairs with their hosts; trees are fitted
    type(system_t), intent(in) :: system !! converged
    type(newton_t), intent(inout) :: progress !! gets outcome
    integer :: k

    if (has_thrown(model, system)) progress%outcome = outcome_thrown
    if (has_turned(model, system)) progress%outcome = outcome_turned
    do k = 1, size(model%pairs)
      if (has_gone_through(model%pairs(k), system%position%x_old, model%mesh%x + system%u)) &
        progress%outcome = outcome_through
    end do
  end subroutine look_for_strays

  !> Once more, now with a drag on the bodies that contact alone holds: they move by a share of a
  !! facet in an iteration, as if they sank through honey (doc/theory, "Continuation").
  subroutine let_down(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left given; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(newton_t), intent(inout) :: progress !! how it ended
    type(settings_t) :: patient
    logical :: rested

    call monitor%detail('  no convergence: once more with a drag on bodies that contact holds')
    call begin_drift(model, system, settings, patient)
    progress = newton_t()
    if (any(shifts_gap(model%pairs))) then
      call rest_then_along(model, system, time, patient, monitor, progress, rested)
      if (.not. (rested .and. has_failed(progress))) then
        call let_free(system)
        return
      end if
      call monitor%detail('  no convergence: once more with a drag, and multipliers that rest')
      call begin_drift(model, system, settings, patient)
      progress = newton_t()
    end if
    call solve_from_start(model, system, time, patient, monitor, progress)
    call let_free(system)
  end subroutine let_down

  !> From where the bodies were, with a drag and more patience than usual.
  subroutine begin_drift(model, system, settings, patient)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left given; u becomes the start, gets first_drag
    type(settings_t), intent(in) :: settings !! tolerances
    type(settings_t), intent(out) :: patient !! those with a drag
    real(wp) :: norm

    call leave_bodies(system)
    call start_here(model, system, norm)
    patient = settings
    patient%most_solves = drag_patience*settings%most_solves
    patient%most_passes = drag_patience*settings%most_passes
    system%body%first_drag = max(force_scale(system), norm)/(drag_way*max(system%scale%facet_size, &
      tiny(1.0_wp)))
  end subroutine begin_drift

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

  !> Takes the converged iterate as the new state.
  subroutine accept(model, system, state, time, known)
    type(model_t), intent(inout) :: model !! history is committed
    type(system_t), intent(inout) :: system !! converged
    type(state_t), intent(inout) :: state !! becomes the new state
    real(wp), intent(in) :: time !! its time
    logical, intent(in), optional :: known !! the displacements inside are known
    logical :: recover

    if (can_do_without(model, system)) then
      state%whole = system%inside_due
      if (.not. system%condensed%sums%known) call form_sums(model, system)
    else
      state%whole = .true.
    end if
    if (system%condensed%active) then
      recover = state%whole
      if (present(known)) recover = recover .and. .not. known
      if (recover) call recover_interior(system)
      if (.not. state%whole) call refresh_candidates(system)
      call keep_forces(system%condensed)
    end if
    call keep_path(model, system, state, time)
    state%u = system%u
    state%time = time
    if (state%whole) then
      call take_reactions(model, system, state)
    else
      call take_sums(system)
    end if
    system%position%x_now = model%mesh%x + state%u
    call settle_contact(model, system)
    call rest_solver(system%whole%solver)
  end subroutine accept

  !> Forces of the supports, from those of the bulk.
  subroutine take_reactions(model, system, state)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! bulk_force given
    type(state_t), intent(inout) :: state !! gets reaction, rigid

    call take_pressure_force(model%mesh%x, system)
    where (system%equation == 0)
      state%reaction = system%inner%bulk_force + system%contact_force - system%loads%external
    else where
      state%reaction = 0.0_wp
    end where
    call spring_reactions(system, state)
    call keep_rigid(system, state)
  end subroutine take_reactions

  !> Displacements inside and reactions of the state, where they have been spared.
  subroutine complete_state(model, system, state)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! as accepted
    type(state_t), intent(inout) :: state !! becomes whole

    if (state%whole) return
    call recover_interior(system)
    state%whole = .true.
    state%u = system%u
    call take_reactions(model, system, state)
  end subroutine complete_state
end module increments

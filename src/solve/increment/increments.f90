!> One increment: its start and the ways to solve it.
module increments
  use kinds, only: wp
  use model_types, only: model_t
  use increment_conditions, only: take_overlaps, begin_at
  use increment_start, only: choose_start
  use touch_types, only: touch_waits
  use solver_choice, only: choose_solver
  use newton, only: newton_t, outcome_converged, outcome_restless
  use contact_parameters, only: is_stiff, shifts_gap
  use attempts, only: attempt_t, trail_t, failed_t, plan_attempts, is_called_for, has_failed, &
    plan_text, path_damping
  use attempt_paths, only: try_attempt
  use accepted_state, only: accept
  use stacks, only: is_stack
  use soft_penalties, only: may_soften
  use lost_contact, only: look_for_thrown, look_for_strays
  use late_look, only: look_inside
  use mortar_increment, only: solve_mortar
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use text, only: to_text
  implicit none
  private
  public :: solve_increment

  !> Damping that has led nowhere so often since the last increment that was accepted is not tried
  !! with shorter ones: these start near their end, if they have one.
  integer, parameter :: most_in_vain = 2
  !> An increment is solved so often with nodes that touch where nobody foresaw it.
  integer, parameter :: most_looks = 8

contains

  !> Solves for the state at `time`. On failure nothing is accepted: history and state stay.
  subroutine solve_increment(model, system, form, state, time, settings, failed, monitor, progress)
    type(model_t), intent(inout) :: model !! history of its pairs is committed on success
    type(system_t), intent(inout) :: system !! u is the new state on success
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! last converged state; the new one on success
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    type(failed_t), intent(inout) :: failed !! before; forgotten on success
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(out) :: progress !! how it ended
    logical :: known, missed
    integer :: look

    call choose_solver(model, system, form, monitor)
    model%pairs%history%softened = is_stiff(model%pairs)
    system%position%x_old = model%mesh%x + state%u
    call take_overlaps(model, time)
    if (any(model%pairs%mortar)) then
      call solve_mortar(model, system, form, state, time, settings, monitor, progress)
      if (any(model%pairs%history%crowded)) call tell_crowded(model, monitor)
      if (progress%outcome == outcome_converged) call look_for_strays(model, system, form, progress)
      if (progress%outcome == outcome_converged) call accept(model, system, form, state, time, &
        settings%inside_due)
      return
    end if
    do look = 1, most_looks
      call begin_at(model, state, time, system%equation, system%u, system%loads, system%tools)
      call choose_start(model, system, form, state, time, monitor)
      call follow_plan(model, system, form, time, settings, failed, monitor, progress)
      if (any(model%pairs%history%crowded)) call tell_crowded(model, monitor)
      if (progress%outcome /= outcome_converged) return
      call look_inside(model, system, form, state, settings, monitor, known, missed)
      if (.not. missed) exit
      progress%outcome = outcome_restless
    end do
    if (progress%outcome == outcome_converged) call look_for_strays(model, system, form, progress)
    if (progress%outcome /= outcome_converged) return
    failed = failed_t()
    call accept(model, system, form, state, time, settings%inside_due, known)
  end subroutine solve_increment

  !> Tries one way after the other, until one leads to a solution.
  subroutine follow_plan(model, system, form, time, settings, failed, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    type(failed_t), intent(inout) :: failed !! counts on
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(attempt_t), allocatable :: plan(:)
    type(trail_t) :: trail
    real(wp) :: start(3, size(system%u, 2))
    integer :: k

    plan = plan_attempts(any(shifts_gap(model%pairs)), is_stack(system%body), failed%all_ways, &
      may_soften(model))
    start = system%u
    trail%other_start = any(abs(system%position%carried - system%position%left) > 0.0_wp)
    trail%carried_left = any(abs(system%position%carried - start) > 0.0_wp)
    do k = 1, size(plan)
      trail%waits = system%touch%stage == touch_waits
      trail%floats = any(system%body%floating) .and. failed%dampings < most_in_vain
      if (.not. is_called_for(plan(k), k, trail)) cycle
      if (trail%last == 1) call monitor%detail('  attempts: '//plan_text(plan))
      call try_attempt(plan(k), start, model, system, form, time, settings, monitor, progress, &
        trail)
      trail%last = k
      trail%outcome = progress%outcome
      call look_for_thrown(model, system, form, progress, monitor, trail%thrown)
    end do
    if (has_failed(progress%outcome)) failed%all_ways = .true.
    if (plan(trail%last)%path == path_damping .and. progress%outcome /= outcome_converged) &
      failed%dampings = failed%dampings + 1
  end subroutine follow_plan

  !> Says once that a segmented pair has fewer points than its cells want.
  subroutine tell_crowded(model, monitor)
    type(model_t), intent(inout) :: model !! pairs: what has been told
    class(monitor_t), intent(inout) :: monitor !! hears of it
    character(:), allocatable :: other
    integer :: k

    do k = 1, size(model%pairs)
      if (model%pairs(k)%history%crowd_told .or. .not. model%pairs(k)%history%crowded) cycle
      model%pairs(k)%history%crowd_told = .true.
      other = 'a number of points in place of SEGMent'
      if (model%pairs(k)%mortar) other = 'GTOS in place of MORTar'
      call monitor%warning('pair '//model%pairs(k)%name//': the slave lies on more facets than '// &
        'there is storage for ('//to_text(size(model%pairs(k)%history%cells))//' points): some '// &
        'slave facets have one point a cell or fewer, and what they carry is not exact from '// &
        'here on; write '//other//', or make the coarser surface the master')
    end do
  end subroutine tell_crowded
end module increments

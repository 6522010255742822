!> One way to solve an increment: its start, its continuation, and how multipliers move.
module attempt_paths
  use kinds, only: wp
  use model_types, only: model_t
  use increment_start, only: start_here, start_again
  use predictor, only: leave_bodies
  use first_touch, only: begin_touch_again
  use softening, only: begin_softening
  use force_scales, only: force_scale
  use pseudo_time, only: let_free, pseudo_patience, pseudo_time_t
  use newton, only: newton_t
  use attempts, only: attempt_t, trail_t, start_chosen, start_same, start_other, path_penalties, &
    path_damping, multipliers_along, multipliers_rest_first
  use multiplier_updates, only: solve_from_start, rest_then_along, come_along
  use soft_penalties, only: solve_from_soft
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: try_attempt

  !> With damping a body first goes this share of a facet in an iteration.
  real(wp), parameter :: damping_way = 0.05_wp

contains

  !> Solves in one way.
  subroutine try_attempt(attempt, start, model, system, form, time, settings, monitor, progress, &
    trail)
    type(attempt_t), intent(in) :: attempt !! the way
    real(wp), intent(in) :: start(:, :) !! (3, nodes) displacements of the start chosen [length]
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(trail_t), intent(inout) :: trail !! gets rested
    type(settings_t) :: now

    if (attempt%told /= '') call monitor%detail('  no convergence: once more '//trim(attempt%told))
    call go_to_start(attempt%start, start, trail%carried_left, model, system, form, monitor)
    if (attempt%start /= start_chosen) progress = newton_t()
    now = settings
    if (attempt%path == path_damping) call begin_drift(model, system, form, settings, now, &
      progress%pseudo_time)
    if (attempt%path == path_penalties) then
      call solve_from_soft(model, system, form, time, settings, monitor, progress)
    else if (attempt%multipliers == multipliers_along) then
      call come_along(model, system, form, time, now, monitor, progress)
    else if (attempt%multipliers == multipliers_rest_first) then
      call rest_then_along(model, system, form, time, now, monitor, progress, trail%rested)
    else
      call solve_from_start(model, system, form, time, now, monitor, progress)
    end if
    if (attempt%path == path_damping) call let_free(progress%pseudo_time, system%body, &
      form)
  end subroutine try_attempt

  !> Where an attempt starts; those with a continuation of their own start where the bodies were.
  subroutine go_to_start(which, start, carried, model, system, form, monitor)
    integer, intent(in) :: which !! one of the starts
    real(wp), intent(in) :: start(:, :) !! (3, nodes) displacements of the start chosen [length]
    logical, intent(in) :: carried !! the other start is that of the bodies carried along
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! u becomes the start
    type(form_t), intent(inout) :: form !! its kind given; gets matrix
    class(monitor_t), intent(inout) :: monitor !! hears of it
    real(wp) :: norm

    if (which == start_other) call start_again(model, system, form, carried, monitor)
    if (which /= start_same) return
    call begin_touch_again(system%touch)
    call begin_softening(model, system%softening)
    system%u = start
    call start_here(model, system, form, norm)
  end subroutine go_to_start

  !> From where the bodies were, with damping and more patience than usual.
  subroutine begin_drift(model, system, form, settings, patient, pseudo_time)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left given; u becomes the start
    type(form_t), intent(inout) :: form !! its kind given; gets matrix
    type(settings_t), intent(in) :: settings !! tolerances
    type(settings_t), intent(out) :: patient !! those with damping
    type(pseudo_time_t), intent(inout) :: pseudo_time !! gets first_damping
    real(wp) :: norm

    call leave_bodies(system%u, system%position, system%tools)
    call start_here(model, system, form, norm)
    patient = settings
    patient%most_solves = pseudo_patience*settings%most_solves
    patient%most_passes = pseudo_patience*settings%most_passes
    pseudo_time%first_damping = max(force_scale(system%scale), &
      norm)/(damping_way*max(system%scale%facet_size, tiny(1.0_wp)))
  end subroutine begin_drift
end module attempt_paths

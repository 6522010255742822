!> Solves with frozen contact targets until these stay, and until smooth surfaces have their shape.
module target_passes
  use kinds, only: wp
  use model_types, only: model_t
  use increment_start, only: start_rubbing
  use contact_system, only: move_targets, load_contact
  use first_touch, only: find_touches
  use softening, only: find_softening
  use touch_bodies, only: some_drift
  use touch_types, only: touch_waits
  use late_look, only: has_flown
  use newton, only: newton_t, solve_frozen, outcome_converged, outcome_singular, &
    outcome_restless, outcome_step_done, is_converged
  use residuals, only: follow_shape
  use contact_report, only: restless_point
  use multiplier_motion, only: take_multipliers, hand_back_multipliers
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t
  use text, only: to_text, count_noun
  use costs, only: cost_t
  implicit none
  private
  public :: solve_with_targets, follow_solution, settle_touches

contains

  !> Solves with frozen targets until the targets stay and smooth surfaces have their shape
  !! (doc/theory, "Surface smoothing").
  subroutine solve_with_targets(model, system, form, time, given, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: given !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(settings_t) :: settings
    integer :: pass
    logical :: settled

    settings = given
    pass = 0
    do while (pass < settings%most_passes)
      if (.not. system%place%begun) call load_contact(model, system)
      if (.not. (system%place%begun .and. system%place%coupled)) call form%kind%couple(system, form)
      if (system%motion%active) call take_multipliers(model, system%equation, system%tools, &
        system%contact, system%place, system%motion)
      call solve_frozen(model, system, form, time, settings, monitor, progress)
      if (system%motion%active) call hand_back_multipliers(model, system)
      if (progress%outcome == outcome_step_done) then
        call follow_solution(model, system, form, settings, monitor, progress, settled)
        cycle
      end if
      if (progress%outcome /= outcome_converged .or. size(model%pairs) == 0) return
      call follow_solution(model, system, form, settings, monitor, progress, settled)
      pass = pass + 1
      if (.not. settled) cycle
      if (given%coarsely) return
      if (has_drifted(model, system, monitor)) then
        progress%outcome = outcome_singular
        return
      end if
      call settle_touches(model, system, form%costs, monitor, settled)
      if (settled) return
      call start_rubbing(model, system, form, settings)
      pass = 0
      settings%most_solves = progress%solves + given%most_solves
    end do
    progress%outcome = outcome_restless
    call monitor%warning('contact points do not settle on a facet: '//restless_point(model))
  end subroutine solve_with_targets

  !> After a solve: smooth surfaces take the shape of their facets, and targets follow the apexes.
  subroutine follow_solution(model, system, form, settings, monitor, progress, settled)
    type(model_t), intent(inout) :: model !! pairs: working points, patches
    type(system_t), intent(inout) :: system !! converged with the targets and patches so far
    type(form_t), intent(inout) :: form !! condensed, its kind
    type(settings_t), intent(in) :: settings !! tolerances, and how far an apex may lie outside
    class(monitor_t), intent(inout) :: monitor !! hears of changes
    type(newton_t), intent(in) :: progress !! how far the solve has come
    logical, intent(out) :: settled !! it has converged with these targets and patches, too
    integer :: changes

    if (associated(form%kind%refresh)) call form%kind%refresh(form, system%u)
    if (has_flown(model, system, form)) call form%kind%recover(system, form)
    system%position%x_now = model%mesh%x + system%u
    settled = .true.
    if (any(model%pairs%smooth)) then
      call follow_shape(model, system, form)
      settled = is_converged(system, form, settings, progress)
    end if
    if (.not. settled .and. progress%outcome == outcome_converged) then
      ! apexes that change their facets are carried with the shape: it has to settle first
      call monitor%detail('  the smooth surface has changed its shape')
      return
    end if
    call move_targets(model, system, form%costs, settings%extrapolation, changes)
    if (changes > 0) then
      call monitor%detail('  '//to_text(changes)//' contact points moved to another facet')
    end if
    settled = settled .and. changes == 0
  end subroutine follow_solution

  !> A pass without friction at new points has left bodies where nothing resists them: the increment
  !! wants their friction from the start (doc/theory, "Contact initiation").
  logical function has_drifted(model, system, monitor) result(drift)
    type(model_t), intent(in) :: model !! pairs: working points
    type(system_t), intent(in) :: system !! converged; touch
    class(monitor_t), intent(inout) :: monitor !! hears of it

    drift = system%touch%stage == touch_waits .and. any(system%body%floating)
    if (drift) drift = some_drift(model, system)
    if (drift) call monitor%detail('  friction alone holds a body that touches: not without it')
  end function has_drifted

  !> After a solve that has settled: points whose friction has waited get their apexes; if there are
  !! none, those that slip begin to soften.
  subroutine settle_touches(model, system, costs, monitor, settled)
    type(model_t), intent(inout) :: model !! pairs: start apexes
    type(system_t), intent(inout) :: system !! touch
    type(cost_t), intent(inout) :: costs !! cost table
    class(monitor_t), intent(inout) :: monitor !! hears of it
    logical, intent(out) :: settled !! there is no such point
    integer :: touches, softer

    call find_touches(model, system, costs, touches)
    settled = touches == 0
    if (.not. settled) call monitor%detail('  '//count_noun(touches, 'contact point')// &
      ' touched first in this increment: friction from there')
    if (.not. settled) return
    call find_softening(model, system%contact, system%place, system%softening, softer)
    settled = softer == 0
    if (.not. settled) call monitor%detail('  '//count_noun(softer, 'contact point')// &
      ' slipped: their friction softens from there')
  end subroutine settle_touches
end module target_passes

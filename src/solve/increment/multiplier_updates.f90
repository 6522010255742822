!> How multipliers move while an increment is solved: they come along with Newton's iteration, rest
!! first, or are updated in between (doc/theory, "Simultaneous multiplier update").
module multiplier_updates
  use kinds, only: wp
  use model_types, only: model_t
  use target_passes, only: solve_with_targets, follow_solution
  use pseudo_time, only: let_free, pseudo_patience
  use newton, only: newton_t, outcome_converged, outcome_gaps
  use contact_parameters, only: shifts_gap, raise_along, most_updates
  use contact_types, only: forget_moves
  use augmentation, only: augmentation_t, check_gaps, update_multipliers
  use point_status, only: hold_sticking
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: solve_from_start, rest_then_along, come_along

contains

  !> Multipliers rest until it is known which points stick, slip and are open, or with damping until
  !! bodies lie still; then they come along, and nothing is dragged.
  subroutine rest_then_along(model, system, form, time, settings, monitor, progress, rested)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    logical, intent(out) :: rested !! the first part of it came to an end
    type(settings_t) :: now

    now = settings
    now%coarsely = progress%pseudo_time%first_damping <= 0.0_wp
    call solve_with_targets(model, system, form, time, now, monitor, progress)
    rested = progress%outcome == outcome_converged
    if (.not. rested) return
    if (progress%pseudo_time%first_damping > 0.0_wp) call let_free( &
      progress%pseudo_time, system%body, form)
    now = settings
    now%most_solves = progress%solves + settings%most_solves
    call come_along(model, system, form, time, now, monitor, progress)
  end subroutine rest_then_along

  !> Multipliers come along with Newton's iteration.
  subroutine come_along(model, system, form, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! counts on
    integer :: k

    system%motion%active = .true.
    system%body%settled = .false.
    do k = 1, size(model%pairs)
      model%pairs(k)%history%raise = raise_along(model%pairs(k))
    end do
    call solve_from_start(model, system, form, time, settings, monitor, progress)
    system%motion%active = .false.
  end subroutine come_along

  !> Solves with fixed multipliers, and with better ones until the gaps are closed.
  subroutine solve_from_start(model, system, form, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(augmentation_t) :: augmentation
    type(settings_t) :: budget

    call solve_with_targets(model, system, form, time, settings, monitor, progress)
    if (.not. any(shifts_gap(model%pairs))) return
    if (system%motion%active .and. progress%outcome == outcome_converged) then
      call follow_freely(model, system, form, time, settings, monitor, progress)
    end if
    budget = settings
    augmentation%gentle = progress%pseudo_time%first_damping > 0.0_wp
    do while (progress%outcome == outcome_converged)
      call check_gaps(model, system, augmentation, monitor)
      if (augmentation%closed) return
      if (augmentation%updates >= merge(pseudo_patience, 1, augmentation%gentle)* &
        maxval(most_updates(model%pairs), shifts_gap(model%pairs))) then
        progress%outcome = outcome_gaps
        return
      end if
      call hold_sticking(system%contact)
      call update_multipliers(model, system, augmentation, monitor)
      progress%updated = .true.
      budget%most_solves = progress%solves + settings%most_solves
      call solve_with_targets(model, system, form, time, budget, monitor, progress)
    end do
  end subroutine solve_from_start

  !> Targets chosen far from the solution may be left again for those that points come from: if any
  !! is, the increment is solved on.
  subroutine follow_freely(model, system, form, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! converged
    type(form_t), intent(inout) :: form !! gets trial, wish
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! counts on
    type(settings_t) :: budget
    integer :: k
    logical :: settled

    do k = 1, size(model%pairs)
      if (shifts_gap(model%pairs(k))) call forget_moves(model%pairs(k))
    end do
    call follow_solution(model, system, form, settings, monitor, progress, settled)
    if (settled) return
    budget = settings
    budget%most_solves = progress%solves + settings%most_solves
    call solve_with_targets(model, system, form, time, budget, monitor, progress)
  end subroutine follow_freely
end module multiplier_updates

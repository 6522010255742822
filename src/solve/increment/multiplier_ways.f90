!> An increment with multipliers: they come along with Newton's iteration, or rest while it
!! iterates, and which of it is tried when (doc/theory, "Uzawa iteration").
module multiplier_ways
  use kinds, only: wp
  use model_types, only: model_t
  use increment_start, only: start_here
  use host_passes, only: solve_with_hosts, follow_solution
  use first_touch, only: begin_touch_again
  use softening, only: begin_softening
  use drag, only: let_free, drag_patience
  use newton, only: newton_t, outcome_converged, outcome_stalled, outcome_too_many, &
    outcome_restless, outcome_singular, outcome_gaps, outcome_inverted
  use contact_parameters, only: shifts_gap, raise_along, most_updates
  use contact_types, only: forget_moves
  use augmentation, only: augmentation_t, check_gaps, update_multipliers
  use monitors, only: monitor_t
  use piles, only: is_pile
  use system_types, only: system_t, settings_t
  implicit none
  private
  public :: solve_with_multipliers, solve_from_start, rest_then_along, has_failed

  !> Ways: multipliers come along from the start, rest until it is known which points stick, slip
  !! and are open, or rest while Newton iterates and are updated in between.
  integer, parameter :: along = 1, rest_first = 2, updates = 3

contains

  !> Tries one way after the other.
  subroutine solve_with_multipliers(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    real(wp) :: start(3, size(system%u, 2)), norm
    integer :: ways(3), i
    logical :: rested

    start = system%u
    rested = .false.
    ways = [along, rest_first, updates]
    if (is_pile(system)) ways = [rest_first, along, updates]
    do i = 1, size(ways)
      if (ways(i) == updates .and. .not. rested) exit
      if (i > 1) then
        call tell_way(ways(i), monitor)
        call begin_touch_again(system)
        call begin_softening(model, system)
        system%u = start
        call start_here(model, system, norm)
        progress = newton_t()
      end if
      select case (ways(i))
      case (along)
        call come_along(model, system, time, settings, monitor, progress)
      case (rest_first)
        call rest_then_along(model, system, time, settings, monitor, progress, rested)
      case default
        call solve_from_start(model, system, time, settings, monitor, progress)
      end select
      if (.not. has_failed(progress) .or. system%motion%hopeless) return
    end do
    system%motion%hopeless = .true.
  end subroutine solve_with_multipliers

  !> Says which way is tried next.
  subroutine tell_way(way, monitor)
    integer, intent(in) :: way !! the next one
    class(monitor_t), intent(inout) :: monitor !! hears of it

    select case (way)
    case (along)
      call monitor%detail('  no convergence: once more with multipliers that come along at once')
    case (rest_first)
      call monitor%detail('  no convergence: once more with multipliers that rest at first')
    case default
      call monitor%detail('  no convergence: once more with multipliers that rest while Newton '// &
        'iterates')
    end select
  end subroutine tell_way

  !> Another way may lead where this one has not.
  pure logical function has_failed(progress) result(failed)
    type(newton_t), intent(in) :: progress !! how it ended

    failed = any(progress%outcome == [outcome_stalled, outcome_too_many, outcome_restless, &
      outcome_singular, outcome_gaps, outcome_inverted])
  end function has_failed

  !> Multipliers rest until it is known which points stick, slip and are open, or with a drag until
  !! bodies lie still; then they come along, and nothing is dragged.
  subroutine rest_then_along(model, system, time, settings, monitor, progress, rested)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    logical, intent(out) :: rested !! the first part of it came to an end
    type(settings_t) :: now

    now = settings
    now%roughly = system%body%first_drag <= 0.0_wp
    call solve_with_hosts(model, system, time, now, monitor, progress)
    rested = progress%outcome == outcome_converged
    if (.not. rested) return
    if (system%body%first_drag > 0.0_wp) call let_free(system)
    now = settings
    now%most_solves = progress%solves + settings%most_solves
    call come_along(model, system, time, now, monitor, progress)
  end subroutine rest_then_along

  !> Multipliers come along with Newton's iteration.
  subroutine come_along(model, system, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
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
    call solve_from_start(model, system, time, settings, monitor, progress)
    system%motion%active = .false.
  end subroutine come_along

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
    integer :: k
    logical :: settled

    do k = 1, size(model%pairs)
      if (shifts_gap(model%pairs(k))) call forget_moves(model%pairs(k))
    end do
    call follow_solution(model, system, settings, monitor, progress, settled)
    if (settled) return
    budget = settings
    budget%most_solves = progress%solves + settings%most_solves
    call solve_with_hosts(model, system, time, budget, monitor, progress)
  end subroutine follow_freely
end module multiplier_ways

!> How far to go along the direction of an iteration (doc/theory, "Step length", eqs. (11.3),
!! (11.4)).
module line_search
  use kinds, only: wp
  use residuals, only: form_trial, residual_norm, round_off_factor
  use supports, only: closing_length
  use newton_progress, only: newton_t
  use newton_settings, only: settings_t, search_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: choose_length

contains

  !> Goes along the direction: to the next touch if bodies are regularised, else as far as the line
  !! search says. Multipliers that are new, a bulk that answers by its tangent, points held in stick
  !! and the first of the steps with damping take the whole way.
  subroutine choose_length(system, form, x, settings, progress, longest, length)
    type(system_t), intent(inout) :: system !! u is moved
    type(form_t), intent(inout) :: form !! gets trial
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(settings_t), intent(in) :: settings !! how to search
    type(newton_t), intent(in) :: progress !! residual before the step, iterations in vain
    real(wp), intent(in) :: longest !! share of du that it may go, at most 1
    real(wp), intent(out) :: length !! share of du

    associate (search => settings%search, start => progress%start)
      if (system%body%damping > 0.0_wp) then
        call search_line(system, form, x, search, start, progress%pseudo_time%iterations == 0, &
          .true., longest, length)
      else if (any(system%body%regularised)) then
        call approach(system, form, x, search, start, longest, length)
      else
        call search_line(system, form, x, search, start, progress%updated .or. &
          form%inner%linearised .or. any(system%contact%hold), progress%since_lowest < &
          search%circling, longest, length)
      end if
    end associate
  end subroutine choose_length

  !> A step with regularised bodies goes to the next touch and no further.
  subroutine approach(system, form, x, search, start, longest, length)
    type(system_t), intent(inout) :: system !! u is moved
    type(form_t), intent(inout) :: form !! gets trial
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(search_t), intent(in) :: search !! how to search
    real(wp), intent(in) :: start !! norm of the residual before the step
    real(wp), intent(in) :: longest !! share of du that it may go, at most 1
    real(wp), intent(out) :: length !! share of du

    length = closing_length(x, system, form)
    if (length < longest) then
      call form_trial(system, form, x, length)
      call form%kind%take_trial(form, length, system%u, system%tools)
    else
      call search_line(system, form, x, search, start, .false., .true., longest, length)
    end if
  end subroutine approach

  !> Backtracking on the residual norm or, where a stiff penalty makes that blind, on the length of
  !! the next direction with the same factor (Deuflhard's natural test); if no length passes, the
  !! one with the shortest next direction is taken. Without the natural test, which may go in
  !! circles, that is the one with the smallest residual. If no length passes from a residual that
  !! is round-off, the system stays where it is.
  subroutine search_line(system, form, x, search, start, full, natural, longest, length)
    type(system_t), intent(inout) :: system !! u is moved to the accepted length
    type(form_t), intent(inout) :: form !! gets trial
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(search_t), intent(in) :: search !! how to search
    real(wp), intent(in) :: start !! norm of the residual before the step
    logical, intent(in) :: full !! take the full step whatever its residual
    logical, intent(in) :: natural !! the length of the next direction counts as well
    real(wp), intent(in) :: longest !! share of du to begin with, at most 1
    real(wp), intent(out) :: length !! accepted share of du
    real(wp) :: next, best, best_length, du, work
    integer :: halving

    best = huge(1.0_wp)
    best_length = longest
    length = longest
    du = form%kind%direction_norm(system, form)
    work = form%kind%direction_work(system, form)
    do halving = 0, search%most_halvings
      call form_trial(system, form, x, length)
      if (full .or. residual_norm(system, form) <= &
        (1.0_wp - search%sufficient_decrease*length)*start) exit
      next = residual_norm(system, form)
      if (natural) next = form%kind%next_length(system, form)
      if (natural .and. next <= (1.0_wp - search%sufficient_shortening*length)*du) exit
      if (next < best) then
        best = next
        best_length = length
      end if
      if (halving == 0) then
        if (has_energy(system, form) .and. work > 0.0_wp .and. &
          start > round_off_factor*system%scale%round_off) then
          call search_energy(system, form, x, search, longest, work, length)
          call form%kind%take_trial(form, length, system%u, system%tools)
          return
        end if
      end if
      length = 0.5_wp*length
    end do
    if (halving > search%most_halvings) then
      length = best_length
      if (start <= round_off_factor*system%scale%round_off) length = 0.0_wp
      call form_trial(system, form, x, length)
    end if
    call form%kind%take_trial(form, length, system%u, system%tools)
  end subroutine search_line

  !> The equations are those of a least energy, by the tangent at hand: a direction leads down.
  pure logical function has_energy(system, form) result(has)
    type(system_t), intent(in) :: system !! tangent formed
    type(form_t), intent(in) :: form !! its kind, matrix

    has = form%kind%has_energy .and. form%whole%symmetric .and. .not. system%motion%active &
      .and. system%tools%unknowns == 0
  end function has_energy

  !> Goes to where the energy is least along the direction, nearly: its slope, the work of the
  !! residual on the direction, is found zero by halving and the rule of false position (Illinois).
  subroutine search_energy(system, form, x, search, longest, work, length)
    type(system_t), intent(inout) :: system !! the trial at `longest` is formed; out: that at length
    type(form_t), intent(inout) :: form !! its kind, solution given; gets trial
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(search_t), intent(in) :: search !! how to search
    real(wp), intent(in) :: longest !! share of du that it may go
    real(wp), intent(in) :: work !! of the residual on du at the iterate [force length]
    real(wp), intent(out) :: length !! share of du
    real(wp) :: low, high, work_low, work_high, now
    integer :: i, side

    low = 0.0_wp
    high = longest
    work_low = work
    length = longest
    work_high = form%kind%direction_work(system, form)
    side = 0
    if (work_high >= -search%flat*work) return
    do i = 1, search%most_trials
      length = (low*work_high - high*work_low)/(work_high - work_low)
      length = min(max(length, low + search%least_part*(high - low)), &
        high - search%least_part*(high - low))
      call form_trial(system, form, x, length)
      now = form%kind%direction_work(system, form)
      if (abs(now) <= search%flat*abs(work)) exit
      if (now > 0.0_wp) then
        low = length
        work_low = now
        if (side == 1) work_high = 0.5_wp*work_high
        side = 1
      else
        high = length
        work_high = now
        if (side == -1) work_low = 0.5_wp*work_low
        side = -1
      end if
    end do
  end subroutine search_energy
end module line_search

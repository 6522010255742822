!> An increment without friction that has led nowhere with the penalties of the deck is solved with
!! soft ones first (doc/theory, "Continuation").
module soft_penalties
  use kinds, only: wp
  use solution_settings, only: tol_energy
  use friction_return, only: has_friction
  use model_types, only: model_t
  use increment_start, only: start_here
  use predictor, only: leave_bodies
  use target_passes, only: solve_with_targets
  use contact_parameters, only: shifts_gap
  use point_status, only: forget_expected
  use newton, only: newton_t, outcome_converged
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: may_soften, solve_from_soft

  !> The first penalty over E/h.
  real(wp), parameter :: softest = 0.01_wp
  !> Each next one is so many times as stiff.
  real(wp), parameter :: stiffening = 10.0_wp
  !> Energy tolerance of all solves but the last: their states are no more than starts.
  real(wp), parameter :: start_energy = 1.0e-4_wp

contains

  !> Softer penalties are another way: no pair has friction, whose apexes a soft state would move,
  !! or multipliers, which have a way of their own.
  pure logical function may_soften(model) result(may)
    type(model_t), intent(in) :: model !! pairs
    integer :: k

    may = size(model%pairs) > 0 .and. .not. any(shifts_gap(model%pairs))
    do k = 1, size(model%pairs)
      if (any(has_friction(model%pairs(k)%friction%mu))) may = .false.
    end do
    if (may) may = any(model%pairs%points%relative > softest)
  end function may_soften

  !> Solves from where the bodies were with soft penalties, then with ever stiffer ones from the
  !! state before, the last time with those of the deck.
  subroutine solve_from_soft(model, system, form, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left given; out: the last iterate
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(newton_t), intent(inout) :: progress !! how it ended
    type(settings_t) :: now
    real(wp) :: norm

    call leave_bodies(system%u, system%position, system%tools)
    call start_here(model, system, form, norm)
    call forget_expected(system%contact)
    model%pairs%history%raise = min(1.0_wp, softest/max(model%pairs%points%relative, softest))
    do
      now = settings
      if (any(model%pairs%history%raise < 1.0_wp)) now%asked(tol_energy) = max(start_energy, &
        settings%asked(tol_energy))
      system%place%begun = .false.
      progress = newton_t()
      call solve_with_targets(model, system, form, time, now, monitor, progress)
      if (progress%outcome /= outcome_converged) exit
      if (all(model%pairs%history%raise >= 1.0_wp)) exit
      model%pairs%history%raise = min(1.0_wp, stiffening*model%pairs%history%raise)
    end do
    model%pairs%history%raise = 1.0_wp
  end subroutine solve_from_soft
end module soft_penalties

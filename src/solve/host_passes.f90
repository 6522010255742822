!> Solves with frozen contact hosts until these stay, and until smooth surfaces have their shape.
module host_passes
  use kinds, only: wp
  use model_types, only: model_t
  use increment_start, only: start_rubbing
  use contact_system, only: move_hosts, renew_surfaces, load_contact, couple
  use first_touch, only: find_touches
  use softening, only: find_softening
  use touch_bodies, only: some_drift
  use touch_path, only: touch_waits
  use condensed_system, only: refresh_candidates, recover_interior
  use late_look, only: has_flown
  use newton, only: newton_t, solve_frozen, outcome_converged, outcome_too_many, outcome_singular, &
    outcome_restless, outcome_adrift, outcome_hosts, is_converged
  use early_hosts, only: may_look_early
  use contact_report, only: restless_point
  use multiplier_motion, only: hand_back_multipliers
  use monitors, only: monitor_t
  use system_types, only: system_t, settings_t
  use text, only: to_text, count_noun
  implicit none
  private
  public :: solve_with_hosts, follow_solution, settle_touches

  !> A smooth surface whose height has changed by less than this share of a facet has its shape.
  real(wp), parameter :: patch_tolerance = 1.0e-12_wp
  !> Changes of the shape of smooth surfaces after which an increment is solved once more, and those
  !! of them after rough solves: these may go to and fro between two shapes.
  integer, parameter :: most_renewals = 24, most_rough = 12
  !> Energy tolerance of the first solve where surfaces are smooth.
  real(wp), parameter :: rough_energy = 1.0e-2_wp

contains

  !> Solves with frozen hosts until the hosts stay and smooth surfaces have their shape. While the
  !! shape changes, solves are rough (doc/theory, "Smooth surfaces"). Points that touch first get no
  !! tips from a rough state.
  subroutine solve_with_hosts(model, system, time, given, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! in: start; out: the last iterate
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: given !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(settings_t) :: settings, budget
    integer :: pass, renewals, before, changes
    logical :: settled, rough

    settings = given
    rough = any(model%pairs%smooth) .and. progress%solves == 0
    progress%looks = may_look_early(model)
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
      if (progress%outcome == outcome_hosts) then
        call follow_solution(model, system, settings, monitor, renewals, changes, settled)
        progress%looks = .not. settled
        system%inner%known = .true.
        pass = pass + 1
        cycle
      end if
      if (progress%outcome == outcome_adrift) then
        call follow_solution(model, system, settings, monitor, renewals, changes, settled)
        cycle
      end if
      if (progress%outcome /= outcome_converged .or. size(model%pairs) == 0) return
      if (rough) rough = .not. is_fine(system, settings, progress)
      if (.not. rough) budget = settings
      before = renewals
      call follow_solution(model, system, budget, monitor, renewals, changes, settled)
      if (settled .and. .not. rough) then
        if (given%roughly) return
        if (has_drifted(model, system, monitor)) then
          progress%outcome = outcome_singular
          return
        end if
        call settle_touches(model, system, monitor, settled)
        if (settled) return
        call start_rubbing(model, system, settings)
        pass = 0
        renewals = 0
        rough = any(model%pairs%smooth)
        settings%most_solves = progress%solves + given%most_solves
        cycle
      end if
      rough = rough .and. renewals > before .and. renewals < most_rough
      if (begins_anew(renewals, changes, rough)) then
        renewals = 0
        pass = pass + 1
      else if (renewals == before) then
        pass = pass + 1
      end if
    end do
    progress%outcome = outcome_restless
    call monitor%warning('contact points do not settle on a facet: '//restless_point(model))
  end subroutine solve_with_hosts

  !> Changes of shape are counted anew: most of them were made before hosts changed for which shapes
  !! have to settle once more.
  pure logical function begins_anew(renewals, changes, rough) result(anew)
    integer, intent(in) :: renewals !! changes of shape so far
    integer, intent(in) :: changes !! points with a new host
    logical, intent(in) :: rough !! the next solve is rough

    anew = changes > 0 .and. .not. rough .and. renewals > most_rough/2
  end function begins_anew

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
  subroutine follow_solution(model, system, settings, monitor, renewals, changes, settled)
    type(model_t), intent(inout) :: model !! pairs: working points, patches
    type(system_t), intent(inout) :: system !! converged with the hosts and patches so far
    type(settings_t), intent(in) :: settings !! how far a tip may lie outside its host
    class(monitor_t), intent(inout) :: monitor !! hears of changes
    integer, intent(inout) :: renewals !! changes of shape in this increment that counted
    integer, intent(out) :: changes !! points with a new host
    logical, intent(out) :: settled !! nothing has changed; else it is to be solved again

    if (system%condensed%active) call refresh_candidates(system)
    if (has_flown(model, system)) call recover_interior(system)
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

  !> A pass without friction at new points has left bodies where nothing resists them: the increment
  !! wants their friction from the start (doc/theory, "First touch").
  logical function has_drifted(model, system, monitor) result(drift)
    type(model_t), intent(in) :: model !! pairs: working points
    type(system_t), intent(in) :: system !! converged; touch
    class(monitor_t), intent(inout) :: monitor !! hears of it

    drift = system%touch%stage == touch_waits .and. any(system%body%weak)
    if (drift) drift = some_drift(model, system)
    if (drift) call monitor%detail('  friction alone holds a body that touches: not without it')
  end function has_drifted

  !> After a solve that has settled: points whose friction has waited get their tips; if there are
  !! none, those that slip begin to soften.
  subroutine settle_touches(model, system, monitor, settled)
    type(model_t), intent(inout) :: model !! pairs: start tips
    type(system_t), intent(inout) :: system !! touch
    class(monitor_t), intent(inout) :: monitor !! hears of it
    logical, intent(out) :: settled !! there is no such point
    integer :: touches, softer

    call find_touches(model, system, touches)
    settled = touches == 0
    if (.not. settled) call monitor%detail('  '//count_noun(touches, 'contact point')// &
      ' touched first in this increment: friction from there')
    if (.not. settled) return
    call find_softening(model, system, softer)
    settled = softer == 0
    if (.not. settled) call monitor%detail('  '//count_noun(softer, 'contact point')// &
      ' slipped: their friction softens from there')
  end subroutine settle_touches
end module host_passes

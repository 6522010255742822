!> Rounds of an increment with multipliers where the bulk is not linear: steps of Newton's method at
!! present weights, until bulk and law are in balance with these (doc/theory, "Mortar contact").
module mortar_bulk_rounds
  use kinds, only: wp, machine_epsilon
  use solution_settings, only: tol_energy
  use model_types, only: model_t
  use mortar_unknowns, only: mortar_system_t, local_forces
  use mortar_system, only: build_mortar, spread_forces
  use mortar_newton, only: mortar_result_t, mortar_factor_t, solve_multipliers, what_law_lacks
  use mortar_bulk, only: linearise_bulk, take_gaps, move_bulk, is_in_balance
  use mortar_rounds, only: most_rounds, law_share, weigh_all, cut_moved, take_result, tell, show_all
  use back_ends, only: solver_done
  use bulk_term, only: return_bulk, form_bulk_force
  use residuals, only: residual_norm, round_off_factor, round_off_of
  use contact_system, only: load_contact
  use condensed_system, only: couple_condensed
  use newton_progress, only: newton_t, wanted_share, outcome_inverted, outcome_converged, &
    outcome_stalled, outcome_restless, outcome_stopped, heed_stop
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: follow_bulk

contains

  !> Rounds of a bulk that is not linear, steps of Newton's method at present weights, until bulk
  !! and law are in balance with these.
  subroutine follow_bulk(model, system, form, waits, time, settings, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: cells and multipliers
    type(system_t), intent(inout) :: system !! u: start, and solution
    type(form_t), intent(inout) :: form !! the linearised system in its form
    logical, intent(in) :: waits !! nodes that were open have no friction yet
    real(wp), intent(in) :: time !! end of the increment
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! how it ended
    type(mortar_system_t) :: unknowns, last
    real(wp) :: cut_at(3, size(system%u, 2))
    integer :: round, changes
    logical :: balanced, still

    changes = 0
    still = .false.
    cut_at = system%position%x_ahead
    form%kind%near = .false.
    call return_bulk(model%mesh%x, system%bulk, system%volumes, system%loads, form)
    call form_bulk_force(model%mesh%x, system, form)
    call load_contact(model, system)
    call couple_condensed(system, form)
    do round = 1, most_rounds
      progress%outcome = outcome_restless
      call weigh_all(model, system, waits, form%costs)
      call take_gaps(model, system, form, last, unknowns)
      associate (z => local_forces(model, unknowns))
        call spread_forces(model, system%contact_force, form%condensed)
        call form%kind%gather(system, form, 0.0_wp, .false.)
        system%scale%round_off = round_off_of(system, form, model%mesh%x)
        balanced = is_in_balance(system, form, wanted_share(settings))
        balanced = balanced .and. round > 1 .and. changes == 0
        ! forces that no step changes any more are as good as they get
        if (balanced .and. .not. still) balanced = what_law_lacks(unknowns, z) <= max(law_share &
          *sqrt(settings%asked(tol_energy))*maxval([0.0_wp, abs(z)]), round_off_factor &
          *machine_epsilon*system%scale%stiffest*maxval(abs(system%position%x_now)))
      end associate
      if (balanced) progress%outcome = outcome_converged
      if (balanced) exit
      call solve_bulk_round(model, system, form, time, unknowns%gap, last, still, monitor, &
        progress)
      if (progress%outcome /= outcome_restless) return
      call heed_stop(progress)
      if (progress%outcome == outcome_stopped) return
      call cut_moved(model, system, form, settings, cut_at, changes)
    end do
    if (progress%outcome == outcome_converged) call show_all(model, system%contact, system%place)
  end subroutine follow_bulk

  !> Forces of the multipliers with frozen weights and a linearised bulk, and how this goes on.
  subroutine solve_bulk_round(model, system, form, time, gap, unknowns, still, monitor, progress)
    type(model_t), intent(inout) :: model !! pairs: forces and status of the multipliers
    type(system_t), intent(inout) :: system !! u and forces of contact
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: time !! end of the increment
    real(wp), intent(in) :: gap(:) !! (3 n) slip and gap of the iterate [length]
    type(mortar_system_t), intent(out) :: unknowns !! the system of the round
    logical, intent(out) :: still !! the forces are what they were
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(newton_t), intent(inout) :: progress !! solves, outcome
    type(mortar_factor_t) :: factor
    type(mortar_result_t) :: result
    integer :: outcome
    real(wp) :: share

    still = .false.
    call linearise_bulk(system, form, model%mesh%x, outcome)
    if (outcome /= solver_done) progress%outcome = outcome_stalled
    if (outcome /= solver_done) return
    call build_mortar(model, system, form, unknowns)
    associate (z => local_forces(model, unknowns), alpha => form%condensed%rigid%alpha)
      if (form%condensed%refusals == 0) then
        call solve_multipliers(unknowns, z, alpha, factor, result)
      else
        ! what a compliance that is not definite makes of z alone says nothing of status
        call solve_multipliers(unknowns, z, alpha, factor, result, gap)
      end if
    end associate
    still = result%steps + result%repeated == 0
    call take_result(model, unknowns, result, progress, form%costs)
    if (progress%outcome /= outcome_converged) return
    call spread_forces(model, system%contact_force, form%condensed)
    form%condensed%rigid%alpha = result%motion
    call move_bulk(system, form, model%mesh%x, share)
    system%position%x_now = model%mesh%x + system%u
    if (allocated(system%contact%reached)) deallocate (system%contact%reached)
    progress%outcome = merge(outcome_restless, outcome_inverted, share > 0.0_wp)
    result%left = residual_norm(system, form)
    call tell(time, result, progress, monitor)
  end subroutine solve_bulk_round
end module mortar_bulk_rounds

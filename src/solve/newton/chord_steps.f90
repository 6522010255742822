!> More steps with the factor of an iteration, while each leads on (doc/theory, "Modified Newton
!! steps", eq. (11.5)).
module chord_steps
  use kinds, only: wp
  use costs, only: count_cost, cost_chord
  use back_ends, only: solver_done
  use bulk_preconditioner, only: solve_tangent
  use near_steps, only: find_near_again, note_near_step
  use condensed_direction, only: find_chord
  use rough_tangent, only: show_direction
  use condensed_system, only: settle_live
  use residuals, only: form_residual, form_trial, residual_norm
  use live_values, only: direction_norm, direction_work
  use line_search, only: take_trial
  use newton_progress, only: is_round_off
  use bulk_term, only: form_bulk_change, bulk_step
  use multiplier_motion, only: add_multipliers, settle_multipliers
  use multiplier_types, only: shift_multipliers
  use equation_values, only: spread_direction
  use surface_shapes, only: follow_shape
  use model_types, only: model_t
  use system_types, only: system_t
  implicit none
  private
  public :: chords_t, follow_chords, settle_hidden

  !> What the steps with one factor have led to.
  type :: chords_t
    integer :: steps = 0 !! taken
    logical :: settled = .false. !! nothing is left but round-off
    logical :: energy_met = .false. !! the next one would have next to no energy
    logical :: bends = .false. !! smooth surfaces follow each
  end type chords_t

  !> Most steps with one factor.
  integer, parameter :: most_chords = 20
  !> A step is taken if its direction and the residual that it leaves are shorter than this share of
  !! what they were before,
  real(wp), parameter :: contraction = 0.9_wp
  !> or than this where a direction is found by iteration, and costs about as much as a new tangent,
  !! and between smooth surfaces that do not follow yet.
  real(wp), parameter :: strict_contraction = 0.2_wp
  !> No further one is tried after a step that leaves more than this, where a direction is found by
  !! iteration, with blocks of groups too.
  real(wp), parameter :: promising = 0.5_wp
  !> What steps in single precision may hide, over what counts as converged,
  real(wp), parameter :: hidden_share = 0.03_wp
  !> and over the residual before the next of them: that leaves no less.
  real(wp), parameter :: early_share = 1.0e-5_wp
  !> Nor is one needed where no more than this share of what counts as converged is left.
  real(wp), parameter :: well_within = 0.1_wp
  !> Residual over right-hand side that an iterative solver may leave of a step.
  real(wp), parameter :: chord_accuracy = 1.0e-4_wp
  !> The same where the bulk is not linear and passes are long: a step leaves such a share anyway.
  real(wp), parameter :: rough_accuracy = 1.0e-2_wp

contains

  !> Goes on with the factor at hand after a full step. What steps in single precision have left of
  !! equilibrium is found at their end; more of them follow, in double, if it shows.
  subroutine follow_chords(model, system, tolerance, first_energy, energy, wanted, chords)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved; residual formed before and after
    real(wp), intent(in) :: tolerance !! of the energy
    real(wp), intent(in) :: first_energy !! |R.du| of the first iteration [force length]
    real(wp), intent(in) :: energy !! |R.du| of the step before [force length]
    real(wp), intent(in) :: wanted !! residual that would have converged [force]
    type(chords_t), intent(inout) :: chords !! bends given; gets what has been done

    call take_chords(model, system, tolerance, first_energy, energy, wanted, hidden_share*wanted, &
      chords)
    if (system%condensed%bulk%hidden <= 0.0_wp) return
    call settle_hidden(model, system)
    if (.not. (chords%settled .or. chords%energy_met)) return
    if (residual_norm(system) <= wanted) return
    chords%settled = .false.
    chords%energy_met = .false.
    call take_chords(model, system, tolerance, first_energy, energy, wanted, 0.0_wp, chords)
  end subroutine follow_chords

  !> Puts displacements where the forces have them, if single precision has hidden some of that.
  subroutine settle_hidden(model, system)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! residual formed before and after

    if (system%condensed%bulk%hidden <= 0.0_wp) return
    call settle_live(system)
    call form_residual(system, model%mesh%x)
  end subroutine settle_hidden

  !> Steps with the factor at hand, while each leads on.
  subroutine take_chords(model, system, tolerance, first_energy, energy, wanted, sought, chords)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved; residual formed before and after
    real(wp), intent(in) :: tolerance !! of the energy
    real(wp), intent(in) :: first_energy !! |R.du| of the first iteration [force length]
    real(wp), intent(in) :: energy !! |R.du| of the step before [force length]
    real(wp), intent(in) :: wanted !! residual that would have converged [force]
    real(wp), intent(in) :: sought !! by what displacements may be off, as forces [force]
    type(chords_t), intent(inout) :: chords !! bends given; gets what has been done
    real(wp) :: before, after, length, last, work, last_work, share
    integer :: status(system%contact%n)
    logical :: found

    last = huge(1.0_wp) ! what steps have hidden may be longer than the last of them
    if (sought > 0.0_wp) last = direction_norm(system)
    last_work = energy
    share = merge(strict_contraction, contraction, finds_by_iteration(system) .or. &
      (any(model%pairs%smooth) .and. .not. chords%bends))
    do while (chords%steps < most_chords)
      before = residual_norm(system)
      if (before <= 0.0_wp) return
      status = system%contact%status
      call find_direction_again(model, system, found)
      if (found .and. system%condensed%active) call show_direction(system, &
        merge(max(sought, early_share*before), 0.0_wp, sought > 0.0_wp))
      length = direction_norm(system)
      found = found .and. length <= share*last
      if (found) then
        work = abs(direction_work(system))
        call form_trial(system, model%mesh%x, 1.0_wp)
        after = residual_norm(system)
        chords%settled = after > 0.5_wp*before .and. work <= tolerance*first_energy .and. &
          all(status == system%contact%status)
        found = (after <= share*before .or. (after <= before .and. chords%settled)) .and. &
          system%inner%inverted == 0
      end if
      if (.not. found) then
        call stay(model, system)
        return
      end if
      if (system%condensed%near) call note_near_step(system, after/before)
      call take_trial(system, 1.0_wp)
      if (system%motion%active) call settle_multipliers(system, 1.0_wp)
      chords%steps = chords%steps + 1
      call count_cost(system%costs, cost_chord, 1)
      if (chords%bends) then
        call follow_shape(model, system)
        after = residual_norm(system)
      end if
      chords%energy_met = (work*(work/last_work) <= tolerance**1.5_wp*first_energy .and. &
        .not. (chords%bends .and. after > well_within*wanted)) .or. &
        (work <= tolerance*first_energy .and. after <= well_within*wanted)
      if (system%condensed%preconditions) chords%energy_met = after <= wanted .and. &
        (chords%energy_met .or. (work <= tolerance*first_energy .and. &
         after <= system%scale%round_off))
      if (chords%settled .or. chords%energy_met) return
      if (.not. system%condensed%active) then
        if (is_round_off(system, .true.)) return
      end if
      if (answers_by_blocks(system) .and. after > promising*before) return
      last = length
      last_work = work
    end do
  end subroutine take_chords

  !> A direction with the factor at hand is no substitution, and costs about what a tangent does;
  !! with the blocks of groups of points it costs far less.
  pure logical function finds_by_iteration(system) result(iterated)
    type(system_t), intent(in) :: system !! its solver

    iterated = system%condensed%preconditions .or. (answers_by_blocks(system) .and. &
      .not. system%condensed%tangent%parts%grouped)
  end function finds_by_iteration

  !> Blocks stand in for the small matrix of contact in the condensed form.
  pure logical function answers_by_blocks(system) result(blocks)
    type(system_t), intent(in) :: system !! its solver

    blocks = system%condensed%active .and. system%condensed%tangent%parts%iterated
  end function answers_by_blocks

  !> Leaves the system where it is: no share of the direction is taken.
  subroutine stay(model, system)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! residual is formed again

    if (system%motion%active) then
      system%motion%way = 0.0_wp
      call shift_multipliers(system%motion, 0.0_wp, system%contact%shift)
    end if
    call form_residual(system, model%mesh%x)
  end subroutine stay

  !> The direction that the factor at hand gives for the present residual.
  subroutine find_direction_again(model, system, found)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(inout) :: system !! right given; gets solution, du, bulk_change
    logical, intent(out) :: found !! there is one
    real(wp) :: share
    integer :: outcome

    if (system%condensed%active) then
      call find_chord(system, found)
    else if (system%condensed%near) then
      call find_near_again(system, found)
      if (found) call spread_direction(system)
    else
      system%whole%solver%accuracy = chord_accuracy
      system%condensed%norm_before = norm2(system%right)
      call solve_tangent(system, system%right, system%solution, outcome, left=rough_accuracy)
      found = outcome == solver_done
      if (found) call spread_direction(system)
      if (found) call form_bulk_change(system)
      if (found) call bulk_step(model%mesh%x, system, share)
      if (found) found = share >= 1.0_wp
    end if
    if (found .and. system%motion%active) call add_multipliers(model, system, .false.)
  end subroutine find_direction_again
end module chord_steps

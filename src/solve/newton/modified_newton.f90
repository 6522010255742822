!> More steps with the factor of an iteration, while each leads on (doc/theory, "Modified Newton
!! steps", eq. (11.5)).
module modified_newton
  use kinds, only: wp
  use costs, only: count_cost, cost_modified_newton
  use residuals, only: form_residual, form_trial, follow_shape, residual_norm
  use newton_progress, only: is_round_off
  use multiplier_types, only: shift_multipliers, settle_multipliers
  use model_types, only: model_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: modified_newton_t, follow_modified_newton

  !> What the steps with one factor have led to.
  type :: modified_newton_t
    integer :: steps = 0 !! taken
    logical :: settled = .false. !! nothing is left but round-off
    logical :: energy_met = .false. !! the next one would have next to no energy
    logical :: bends = .false. !! smooth surfaces follow each
  end type modified_newton_t

  !> Most steps with one factor.
  integer, parameter :: most_modified = 20
  !> A step is taken if its direction and the residual that it leaves are shorter than this share of
  !! what they were before,
  real(wp), parameter :: contraction = 0.9_wp
  !> or than this where a direction is found by iteration, and costs about as much as a new tangent,
  !! and between smooth surfaces that do not follow yet.
  real(wp), parameter :: strict_contraction = 0.2_wp
  !> No further one is tried after a step that leaves more than this, where a direction is found by
  !! iteration, with blocks of groups too.
  real(wp), parameter :: promising = 0.5_wp
  !> Nor is one needed where no more than this share of what counts as converged is left.
  real(wp), parameter :: well_within = 0.1_wp

contains

  !> Goes on with the factor at hand after a full step, while each leads on.
  subroutine follow_modified_newton(model, system, form, tolerance, first_energy, energy, wanted, &
    modified)
    type(model_t), intent(inout) :: model !! mesh, pairs: patches
    type(system_t), intent(inout) :: system !! u is moved; residual formed before and after
    type(form_t), intent(inout) :: form !! gets trial
    real(wp), intent(in) :: tolerance !! of the energy
    real(wp), intent(in) :: first_energy !! |R.du| of the first iteration [force length]
    real(wp), intent(in) :: energy !! |R.du| of the step before [force length]
    real(wp), intent(in) :: wanted !! residual that would have converged [force]
    type(modified_newton_t), intent(inout) :: modified !! bends given; gets what has been done
    real(wp) :: before, after, length, last, work, last_work, share
    integer :: status(system%contact%n)
    logical :: found

    last = form%kind%direction_norm(system, form)
    last_work = energy
    share = merge(strict_contraction, contraction, finds_by_iteration(form) .or. &
      (any(model%pairs%smooth) .and. .not. modified%bends))
    do while (modified%steps < most_modified)
      before = residual_norm(system, form)
      if (before <= 0.0_wp) return
      status = system%contact%status
      call find_direction_again(model, system, form, found)
      length = form%kind%direction_norm(system, form)
      found = found .and. length <= share*last
      if (found) then
        work = abs(form%kind%direction_work(system, form))
        call form_trial(system, form, model%mesh%x, 1.0_wp)
        after = residual_norm(system, form)
        modified%settled = after > 0.5_wp*before .and. work <= tolerance*first_energy .and. &
          all(status == system%contact%status)
        found = (after <= share*before .or. (after <= before .and. modified%settled)) .and. &
          form%inner%inverted == 0
      end if
      if (.not. found) then
        call stay(model, system, form)
        return
      end if
      if (associated(form%kind%note_repeated)) call form%kind%note_repeated(form, after/before)
      call form%kind%take_trial(form, 1.0_wp, system%u, system%tools)
      if (system%motion%active) call settle_multipliers(system%motion, 1.0_wp)
      modified%steps = modified%steps + 1
      call count_cost(form%costs, cost_modified_newton, 1)
      if (modified%bends) then
        call follow_shape(model, system, form)
        after = residual_norm(system, form)
      end if
      modified%energy_met = (work*(work/last_work) <= tolerance**1.5_wp*first_energy .and. &
        .not. (modified%bends .and. after > well_within*wanted)) .or. &
        (work <= tolerance*first_energy .and. after <= well_within*wanted)
      if (form%kind%inexact) modified%energy_met = after <= wanted .and. (modified%energy_met .or. &
        (work <= tolerance*first_energy .and. after <= system%scale%round_off))
      if (modified%settled .or. modified%energy_met) return
      if (.not. form%kind%iterates_cheaply) then
        if (is_round_off(system, form, .true.)) return
      end if
      if (wants_promise(form) .and. after > promising*before) return
      last = length
      last_work = work
    end do
  end subroutine follow_modified_newton

  !> A direction with the factor at hand costs about what a new tangent does.
  pure logical function finds_by_iteration(form) result(iterated)
    type(form_t), intent(in) :: form !! its form

    iterated = form%kind%inexact
    if (associated(form%kind%repeats_by_iteration)) iterated = form%kind%repeats_by_iteration(form)
  end function finds_by_iteration

  !> Another step is not worth its direction after one that has left much.
  pure logical function wants_promise(form) result(wants)
    type(form_t), intent(in) :: form !! its form

    wants = .false.
    if (associated(form%kind%repeats_if_promising)) wants = form%kind%repeats_if_promising(form)
  end function wants_promise

  !> Leaves the system where it is: no share of the direction is taken.
  subroutine stay(model, system, form)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! residual is formed again
    type(form_t), intent(inout) :: form !! its kind answers

    if (system%motion%active) then
      system%motion%way = 0.0_wp
      call shift_multipliers(system%motion, 0.0_wp, system%contact%shift)
    end if
    call form_residual(system, form, model%mesh%x)
  end subroutine stay

  !> The direction that the factor at hand gives for the present residual.
  subroutine find_direction_again(model, system, form, found)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(inout) :: system !! right given; gets solution, du, bulk_change
    type(form_t), intent(inout) :: form !! du
    logical, intent(out) :: found !! there is one
    real(wp) :: share

    call form%kind%repeat_direction(system, form, found)
    if (found) call system%terms%step_share(model%mesh%x, system%bulk, system%u, form%inner, &
      form%du, share)
    if (found) found = share >= 1.0_wp
    if (found .and. system%motion%active) &
      call system%terms%add_multipliers(model, system, form, .false.)
  end subroutine find_direction_again
end module modified_newton

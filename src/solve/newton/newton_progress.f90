!> How far Newton's iteration is: what it counts, how it ends, and when it has converged
!! (doc/theory, "Convergence criteria", eqs. (11.7), (11.8)).
module newton_progress
  use kinds, only: wp
  use costs, only: wall_seconds
  use threads, only: notice_others
  use signals, only: stop_requested
  use parallel, only: any_rank
  use element_types, only: status_open
  use residuals, only: residual_norm, round_off_factor
  use pseudo_time, only: pseudo_time_t
  use force_scales, only: force_scale, in_bounds, least_meaning
  use newton_settings, only: settings_t, tol_energy, tol_residual
  use system_types, only: form_t, system_t
  use element_lists, only: element_list_t
  use point_status, only: contact_counts, turned_back
  use stacks, only: is_stack
  use monitors, only: iteration_t
  use system_parts, only: bodies_t
  implicit none
  private
  public :: newton_t, is_converged, is_round_off, is_close, meets_energy, may_go_on, wanted_share, &
    judge_progress, judge_settled, begin_iteration, choose_held, heed_stop, describe
  public :: outcome_going_on, outcome_converged, outcome_stalled, outcome_too_many, &
    outcome_singular, outcome_memory, outcome_stopped, outcome_open, outcome_restless, &
    outcome_gaps, outcome_inverted, outcome_step_done, outcome_through, &
    outcome_turned, outcome_thrown

  !> How a solve ended.
  integer, parameter :: outcome_going_on = 0
  integer, parameter :: outcome_converged = 1
  integer, parameter :: outcome_stalled = 2
  integer, parameter :: outcome_too_many = 3
  integer, parameter :: outcome_singular = 4
  integer, parameter :: outcome_memory = 5
  integer, parameter :: outcome_stopped = 6
  integer, parameter :: outcome_open = 7
  integer, parameter :: outcome_restless = 8
  integer, parameter :: outcome_gaps = 9 !! AUGMent has not closed the gaps
  integer, parameter :: outcome_inverted = 10 !! an element would be turned inside out
  integer, parameter :: outcome_step_done = 11 !! a step of a body with damping is done
  integer, parameter :: outcome_through = 12 !! the slave has gone through a master
  integer, parameter :: outcome_turned = 13 !! a body has turned too far for small strain
  integer, parameter :: outcome_thrown = 14 !! a body has separated from contact altogether

  !> Below this share of the estimate it is converged at once.
  real(wp), parameter :: round_off_share = 0.1_wp
  !> The same where another iteration costs next to nothing.
  real(wp), parameter :: cheap_share = 1.0e-3_wp
  !> Round-off at many nodes has a resultant of up to this many times its norm, unless that is more
  !! than this share of the forces.
  real(wp), parameter :: resultant_factor = 8.0_wp, resultant_share = 1.0e-4_wp
  !> An energy test of TOL v also wants a relative residual of this times sqrt(v).
  real(wp), parameter :: residual_share = 1.0e-3_wp
  !> Points are settled if a full step changes no more than this share of the closed ones,
  real(wp), parameter :: settled_share = 0.02_wp
  !> and which of them stick and slip is known once its energy is below this share of the first.
  real(wp), parameter :: coarse_energy = 1.0e-3_wp
  !> Smooth surfaces follow steps after one whose energy is below this share of the largest: with
  !! points that still close, open, stick and slip single steps against ever new shapes went in
  !! circles. The first energy will not do: an increment may begin in balance, and targets change.
  real(wp), parameter :: close_energy = 1.0e-4_wp
  !> Steps up to this length count as short.
  real(wp), parameter :: short_step = 1.0_wp/16.0_wp

  !> Iterations with points that turn back after which a solve relies on the line search alone. In
  !! stacks of bodies the search for the points that open uses up some of them.
  integer, parameter :: turns_of_solve = 6, most_turns_of_stack = 14
  !> A point has turned back if it had slipped by more than this share of what it slips now: less is
  !! round-off of a solution.
  real(wp), parameter :: least_slip = 1.0e-6_wp

  !> Progress of the iteration within one increment.
  type :: newton_t
    integer :: solves = 0 !! linear solves of the increment
    real(wp) :: first_energy = 0.0_wp !! |R.du| of the first iteration
    real(wp) :: energy = 0.0_wp !! |R.du| of the last iteration
    real(wp) :: most_energy = 0.0_wp !! the largest |R.du| of the increment so far
    real(wp) :: start = 0.0_wp !! residual norm before the last iteration
    real(wp) :: share = 0.0_wp !! residual norm after it over that, 0 before the first iteration
    real(wp) :: lowest = 0.0_wp !! lowest residual norm of this solve
    real(wp) :: shortest = huge(1.0_wp) !! shortest direction of this solve
    integer :: fewest = huge(1) !! sticking points of this solve, lowest number
    integer :: since_lowest = 0 !! iterations since residual or direction has fallen
    integer :: since_fewest = 0 !! iterations since one of the three has fallen
    integer :: turns = 0 !! iterations of this solve with a point whose slip has turned back
    real(wp) :: length = 0.0_wp !! share of its direction that the last iteration went
    logical :: updated = .false. !! this solve follows an update of multipliers, its first iteration
    logical :: indefinite = .false. !! a symmetric matrix was not positive definite
    logical :: halved = .true. !! the last iteration, or step with damping, has halved the residual
    integer :: short = 0 !! iterations on end that went hardly anywhere
    integer :: misfits = 0 !! iterations in balance whose multipliers did not fit
    logical :: linearised = .false. !! the last iteration had the bulk's tangent of the last state
    logical :: energy_met = .false. !! the last full step met the energy tolerance
    type(pseudo_time_t) :: pseudo_time !! damping on floating bodies, and its steps
    integer :: outcome = outcome_going_on !! one of the outcomes
  end type newton_t

contains

  !> The residual is zero, at its round-off, or within the tolerance the deck sets; and no node has
  !! gone farther than a body can (doc/theory, "Convergence criteria").
  logical function is_converged(system, form, settings, progress) result(converged)
    type(system_t), intent(in) :: system !! residual formed
    type(form_t), intent(in) :: form !! its kind answers
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! energies
    real(wp) :: norm

    converged = .false.
    if (.not. in_bounds(system)) return
    norm = residual_norm(system, form)
    if (is_round_off(system, form, progress%halved)) then
      converged = .true.
    else if (settings%coarsely) then
      converged = system%body%settled .and. progress%energy <= coarse_energy*progress%first_energy
    else if (settings%asked(tol_residual) > 0.0_wp) then
      converged = norm <= settings%asked(tol_residual)*force_scale(system%scale)
    else
      converged = progress%energy_met .and. norm <= wanted_share(settings)*force_scale(system%scale)
    end if
  end function is_converged

  !> The residual is at its round-off, and so are its resultants: where it only seems so, as nodes
  !! are many, a body still lacks a share of its weight.
  logical function is_round_off(system, form, halved)
    type(system_t), intent(in) :: system !! residual formed
    type(form_t), intent(in) :: form !! its kind answers
    logical, intent(in) :: halved !! the last iteration, or step with damping, has halved it
    real(wp) :: factor

    factor = merge(round_off_share, round_off_factor, halved .and. system%contact%n > 0)
    if (form%kind%iterates_cheaply .and. halved) factor = cheap_share
    is_round_off = residual_norm(system, form) <= min(factor*system%scale%round_off, &
      least_meaning(system))
    if (.not. (is_round_off .and. associated(form%kind%largest_resultant))) return
    is_round_off = form%kind%largest_resultant(system, form) <= round_off_factor* &
      max(system%scale%round_off, min(resultant_factor*system%scale%round_off, &
      resultant_share*force_scale(system%scale)))
  end function is_round_off

  !> The last step was so small that hardly any point will close, open, stick or slip any more.
  pure logical function is_close(progress) result(close)
    type(newton_t), intent(in) :: progress !! energies

    close = progress%energy <= close_energy*progress%most_energy
  end function is_close

  !> The residual that a converged increment may have, over the forces.
  pure real(wp) function wanted_share(settings) result(share)
    type(settings_t), intent(in) :: settings !! tolerances

    share = max(settings%asked(tol_residual), residual_share*sqrt(settings%asked(tol_energy)))
  end function wanted_share

  !> Whether nearly all points are what they were before the last step.
  pure subroutine judge_settled(before, length, contact, body)
    integer, intent(in) :: before(:) !! (contact elements) their status before it
    real(wp), intent(in) :: length !! share of its direction that was gone
    type(element_list_t), intent(in) :: contact !! contact elements
    type(bodies_t), intent(inout) :: body !! gets settled

    body%settled = length >= 1.0_wp .and. real(count(contact%status /= before), wp) <= &
      settled_share*real(count(before > status_open), wp)
  end subroutine judge_settled

  !> A full step has met the energy tolerance: its own energy did, or what it has left is so small,
  !! by the factor at hand, that the next step's would by far.
  logical function meets_energy(system, form, settings, progress) result(met)
    type(system_t), intent(in) :: system !! factor and residual after the step; next is used
    type(form_t), intent(inout) :: form !! its kind answers
    type(settings_t), intent(in) :: settings !! tolerances
    type(newton_t), intent(in) :: progress !! energies

    associate (tolerance => settings%asked(tol_energy), first => progress%first_energy)
      met = progress%energy <= tolerance*first
      if (met .or. progress%energy > sqrt(tolerance)*first .or. any(system%body%regularised)) return
      ! a step with the same tangent asks the same
      if (form%kind%inexact .and. may_go_on(system, form, progress)) return
      met = form%kind%next_energy(system, form) <= tolerance**1.5_wp*first
    end associate
  end function meets_energy

  !> More steps with the tangent of the last iteration may follow. Not where a body is regularised
  !! or damped, or the form would rather have a new one.
  pure logical function may_go_on(system, form, progress) result(may)
    type(system_t), intent(in) :: system !! contact elements, bodies
    type(form_t), intent(in) :: form !! its kind answers
    type(newton_t), intent(in) :: progress !! the last iteration

    may = progress%length >= 1.0_wp .and. system%contact%n > 0 .and. system%tools%unknowns == 0 &
      .and. system%body%damping <= 0.0_wp .and. .not. any(system%body%regularised)
    if (.not. (may .and. associated(form%kind%may_repeat))) return
    may = form%kind%may_repeat(system, form, progress%start, progress%linearised)
  end function may_go_on

  !> An iteration has led on if residual or direction are smaller than ever in this solve. Where
  !! slip spreads along a surface, ring of points by ring, neither need be until it is through: so
  !! has one after which fewer points stick than ever (doc/theory, "Algorithms").
  subroutine judge_progress(system, form, sticking, progress)
    type(system_t), intent(in) :: system !! state after the iteration
    type(form_t), intent(in) :: form !! its kind answers
    integer, intent(in) :: sticking !! points that stick now
    type(newton_t), intent(inout) :: progress !! gets counts and lowest values

    progress%since_lowest = progress%since_lowest + 1
    progress%since_fewest = progress%since_fewest + 1
    progress%short = merge(progress%short + 1, 0, progress%length <= short_step)
    if (residual_norm(system, form) < progress%lowest .or. &
      form%kind%direction_norm(system, form) < progress%shortest) progress%since_lowest = 0
    if (progress%since_lowest == 0 .or. sticking < progress%fewest) progress%since_fewest = 0
    progress%lowest = min(progress%lowest, residual_norm(system, form))
    progress%shortest = min(progress%shortest, form%kind%direction_norm(system, form))
    progress%fewest = min(progress%fewest, sticking)
  end subroutine judge_progress

  !> An iteration begins: its clock, and whether others want the processors.
  subroutine begin_iteration(report)
    type(iteration_t), intent(inout) :: report !! gets the clock as seconds

    report%seconds = wall_seconds()
    call notice_others()
  end subroutine begin_iteration

  !> A signal that has come to some rank ends the solve.
  subroutine heed_stop(progress)
    type(newton_t), intent(inout) :: progress !! may get outcome

    if (any_rank(stop_requested())) progress%outcome = outcome_stopped
  end subroutine heed_stop

  !> Chooses the points that stick in the next tangent: those whose slip has turned back since the
  !! iteration before, which else may flip for ever.
  subroutine choose_held(contact, body, progress)
    type(element_list_t), intent(inout) :: contact !! contact elements; gets hold
    type(bodies_t), intent(in) :: body !! connected bodies
    type(newton_t), intent(inout) :: progress !! counts the iterations with such points

    if (progress%updated) return
    contact%hold = .false.
    if (progress%turns < merge(most_turns_of_stack, turns_of_solve, is_stack(body))) &
      contact%hold = turned_back(contact, least_slip)
    if (any(contact%hold)) progress%turns = progress%turns + 1
  end subroutine choose_held

  !> The report of one iteration.
  subroutine describe(system, form, progress, time, report)
    type(system_t), intent(in) :: system !! state after the iteration
    type(form_t), intent(in) :: form !! its kind, matrix
    type(newton_t), intent(in) :: progress !! counts and energies
    real(wp), intent(in) :: time !! time of the increment
    type(iteration_t), intent(inout) :: report !! of an iteration that has begun; filled
    real(wp) :: forces

    report%time = time
    report%number = progress%solves
    report%residual = residual_norm(system, form)
    forces = force_scale(system%scale)
    if (forces > 0.0_wp) report%relative = report%residual/forces
    call form%kind%find_worst(system, form, report%worst_node, report%worst_dof, report%worst)
    report%energy = progress%energy
    report%step_length = progress%length
    call contact_counts(system%contact, 1, system%contact%n, report%active, report%stick, &
      report%slip)
    report%solver = form%kind%name
    report%seconds = wall_seconds() - report%seconds
  end subroutine describe
end module newton_progress

!> The ways to solve an increment, as a list that is made once: from which start, by which
!! continuation, how multipliers move, and after what (doc/theory, "Start").
module attempts
  use newton_progress, only: outcome_going_on, outcome_stalled, &
    outcome_too_many, outcome_singular, outcome_restless, outcome_gaps, outcome_inverted
  implicit none
  private
  public :: attempt_t, trail_t, failed_t, plan_attempts, is_called_for, has_failed, plan_text
  public :: start_chosen, start_same, start_other, path_penalties, path_damping, &
    multipliers_updated, multipliers_along, multipliers_rest_first

  !> Starts: of the predictor and where the bodies were, the one that leaves less; the same once
  !! more; the other of them; where the bodies were.
  integer, parameter :: start_chosen = 1, start_same = 2, start_other = 3, start_left = 4
  !> Continuations: none, from soft penalties to those of the deck, damping on floating bodies.
  integer, parameter :: path_none = 1, path_penalties = 2, path_damping = 3
  !> Multipliers (if there are any) are updated between solves, come along with Newton's iteration,
  !! or rest first and then come along.
  integer, parameter :: multipliers_updated = 1, multipliers_along = 2, multipliers_rest_first = 3

  !> One way.
  type :: attempt_t
    integer :: start = start_chosen !! where from
    integer :: path = path_none !! continuation
    integer :: multipliers = multipliers_updated !! how they move
    integer :: after(6) = outcome_going_on !! outcomes of the last attempt that call for it
    logical :: after_thrown = .false. !! so does a solution that has thrown bodies out of contact
    logical :: follows = .false. !! it is of use only right after the one before it in the plan
    logical :: wants_rest = .false. !! and if multipliers that rested have come to an end
    logical :: wants_floating = .false. !! and if contact alone holds a body
    character(80) :: told = '' !! in the log
  end type attempt_t

  !> What attempts have led to so far.
  type :: trail_t
    integer :: last = 0 !! place in the plan of the last attempt, 0 if there was none
    integer :: outcome = outcome_going_on !! of the last attempt
    logical :: thrown = .false. !! it has thrown bodies out of contact
    logical :: rested = .false. !! multipliers that rested first have come to an end
    logical :: other_start = .false. !! the predictor moves something
    logical :: carried_left = .false. !! the start with the predictor was not the one chosen
    logical :: waits = .false. !! friction of points that touch first waits
    logical :: floats = .false. !! contact alone holds a body, and dampings have not failed too
    !! often
  end type trail_t

  !> What has failed since the last increment that was accepted.
  type :: failed_t
    logical :: all_ways = .false. !! the last increment, with and without multipliers along
    integer :: dampings = 0 !! that have led nowhere
  end type failed_t

  !> Outcomes after which another way may lead where this one has not.
  integer, parameter :: failures(6) = [outcome_stalled, outcome_too_many, outcome_restless, &
    outcome_singular, outcome_gaps, outcome_inverted]

contains

  !> All ways in their order.
  pure function plan_attempts(multipliers, stack, hopeless, soft) result(plan)
    logical, intent(in) :: multipliers !! some pair has them
    logical, intent(in) :: stack !! floating bodies lean on each other: multipliers rest first
    logical, intent(in) :: hopeless !! the last increment has failed in all ways
    logical, intent(in) :: soft !! softer penalties are a way
    type(attempt_t), allocatable :: plan(:)

    allocate (plan(0))
    if (multipliers) then
      plan = [plan, moving(merge(multipliers_rest_first, multipliers_along, stack), 1)]
      if (.not. hopeless) plan = [plan, moving(merge(multipliers_along, multipliers_rest_first, &
        stack), 2), moving(multipliers_updated, 3)]
    else
      plan = [plan, attempt_t()]
    end if
    plan = [plan, attempt_t(start=start_other, after=[failures(:4), 0, 0], after_thrown=.true.)]
    if (soft) plan = [plan, attempt_t(start=start_left, path=path_penalties, &
      after=[failures(:2), 0, 0, 0, 0], told='from a state with softer penalties')]
    plan = [plan, attempt_t(start=start_left, path=path_damping, multipliers=merge( &
      multipliers_rest_first, multipliers_updated, multipliers), after=[failures(:4), 0, 0], &
      after_thrown=.true., wants_floating=.true., &
      told='with viscous stabilisation of floating bodies')]
    if (multipliers) plan = [plan, attempt_t(start=start_left, path=path_damping, after=failures, &
      follows=.true., wants_rest=.true., told='with viscous stabilisation, multipliers fixed')]
  end function plan_attempts

  !> A way for multipliers from the start chosen; the first one, or one after it.
  pure function moving(multipliers, place) result(attempt)
    integer, intent(in) :: multipliers !! how they move
    integer, intent(in) :: place !! among these ways
    type(attempt_t) :: attempt

    attempt%multipliers = multipliers
    if (place == 1) return
    attempt%start = start_same
    attempt%after = failures
    attempt%follows = .true.
    attempt%wants_rest = multipliers == multipliers_updated
    select case (multipliers)
    case (multipliers_along)
      attempt%told = 'with multipliers updated simultaneously'
    case (multipliers_rest_first)
      attempt%told = 'with multipliers fixed at first'
    case default
      attempt%told = 'with multipliers fixed during Newton iterations'
    end select
  end function moving

  !> Whether what has happened so far calls for an attempt. A singular matrix calls for the other
  !! start only where friction of points that touch first waits.
  pure logical function is_called_for(attempt, place, trail) result(called)
    type(attempt_t), intent(in) :: attempt !! the attempt
    integer, intent(in) :: place !! in the plan
    type(trail_t), intent(in) :: trail !! what has happened

    called = trail%last == 0
    if (called) return
    called = any(attempt%after == trail%outcome .and. attempt%after /= outcome_going_on) .or. &
      (attempt%after_thrown .and. trail%thrown)
    if (attempt%follows) called = called .and. trail%last == place - 1
    if (attempt%wants_rest) called = called .and. trail%rested
    if (attempt%wants_floating) called = called .and. trail%floats
    if (attempt%start /= start_other) return
    called = called .and. (trail%other_start .or. trail%waits)
    if (trail%outcome == outcome_singular) called = called .and. trail%waits
  end function is_called_for

  !> Another way may lead where this one has not.
  pure logical function has_failed(outcome) result(failed)
    integer, intent(in) :: outcome !! how a solve ended

    failed = any(outcome == failures)
  end function has_failed

  !> The plan in words, for the log.
  pure function plan_text(plan) result(t)
    type(attempt_t), intent(in) :: plan(:) !! the ways
    character(:), allocatable :: t
    character(*), parameter :: start_words(4) = [character(28) :: 'start chosen', 'same start', &
      'other start', 'bodies where they were'], &
      paths(3) = [character(28) :: '', ', soft penalties first', ', with viscous stabilisation'], &
      moves(3) = [character(28) :: '', ', multipliers updated', ', multipliers fixed first']
    integer :: k

    t = ''
    do k = 1, size(plan)
      if (k > 1) t = t//'; '
      t = t//trim(start_words(plan(k)%start))//trim(paths(plan(k)%path))// &
        trim(moves(plan(k)%multipliers))
    end do
  end function plan_text
end module attempts

!> From one end time to the next: automatic cut and growth of the increment.
!!
!! An increment that leads to no solution is halved. One that has been solved is doubled where the
!! longer one would begin: when both halves of what was halved are behind. Nothing is undone by a
!! cut: `solve_increment` leaves the last converged state alone, and starts from it again.
module stepping
  use kinds, only: wp
  use threads, only: notice_others
  use errors, only: error_t, raise, exit_no_convergence, exit_resources
  use text, only: to_text
  use memory, only: memory_text
  use model_types, only: model_t
  use monitors, only: monitor_t
  use newton, only: newton_t, outcome_converged, outcome_stalled, outcome_too_many, outcome_open, &
    outcome_singular, outcome_memory, outcome_stopped, outcome_restless, outcome_gaps, &
    outcome_inverted, outcome_through, outcome_turned, outcome_thrown
  use attempts, only: failed_t
  use increments, only: solve_increment
  use diagnosis, only: explain_failure, unrestrained_bodies, has_flying_body
  use statics, only: verdict_t, judge_statics, judge_at_rest, close_by, statics_carried
  use solver_choice, only: decline_condensed, retry_condensed
  use free_bodies, only: tell_free_bodies
  use signals, only: stop_exit_code
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use system_parts, only: whole_form_t
  implicit none
  private
  public :: advance, raise_outcome

  !> The interval between two end times is divided into this many parts at most.
  integer, parameter :: finest_division = 1024
  !> The whole system, which is tried after REDUced has failed, cuts its increments into so many
  !! parts at most where there are more equations than these: each solve takes a sparse factor.
  integer, parameter :: finest_whole = 16, few_equations = 5000

contains

  !> Solves from the state's time to `end_time`, in one increment (or settings%parts) if that
  !! converges.
  subroutine advance(model, system, form, state, end_time, settings, monitor, error)
    type(model_t), intent(inout) :: model !! history of its pairs
    type(system_t), intent(inout) :: system !! the system
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! last converged state
    real(wp), intent(in) :: end_time !! where to arrive
    type(settings_t), intent(in) :: settings !! tolerances
    class(monitor_t), intent(inout) :: monitor !! hears of the work
    type(error_t), allocatable, intent(out) :: error !! no convergence, singular, stopped
    type(newton_t) :: progress
    type(failed_t) :: failed
    type(error_t), allocatable :: first
    integer :: done, part, least, longest
    logical :: hopeless, flies
    real(wp) :: begin, time

    call retry_condensed(form%whole)
    begin = state%time
    done = 0
    longest = finest_division/settings%parts
    part = longest
    least = 1
    do while (done < finest_division)
      do while (done + part > finest_division)
        part = part/2
      end do
      time = begin + (end_time - begin)*(real(done + part, wp)/real(finest_division, wp))
      if (done + part == finest_division) time = end_time
      call notice_others()
      call solve_increment(model, system, form, state, time, settings, failed, monitor, progress)
      if (progress%outcome == outcome_converged) then
        call monitor%accepted(model, system, form, state)
        call tell_free_bodies(model, system, form, monitor)
        done = done + part
        if (done < finest_division .and. mod(done, 2*part) == 0) part = min(2*part, longest)
        cycle
      end if
      hopeless = part <= least
      if (.not. hopeless) hopeless = is_final(progress%outcome, model, system, time)
      if (hopeless) then
        call raise_outcome(model, system, form, state, progress, time, part <= least, error, &
          end_time)
        if (state%whole) &
          call try_otherwise(model, system, form, progress, time, monitor, first, error, flies)
        if (allocated(error)) return
        failed = failed_t()
        call begin_whole(system%equations, done, flies, part, least)
        part = min(part, longest)
        cycle
      end if
      part = part/2
      call monitor%cut(state%time, 2.0_wp*size_of(part), size_of(part), reason(progress%outcome))
    end do

  contains

    !> An increment of so many parts.
    real(wp) function size_of(parts)
      integer, intent(in) :: parts !! number of parts

      size_of = (end_time - begin)*(real(parts, wp)/real(finest_division, wp))
    end function size_of
  end subroutine advance

  !> Once more with the whole system, where REDUced has failed and AUTO may choose the solver
  !! (doc/theory, "Choice of the solver"). A factor that the memory does not hold is no news then.
  subroutine try_otherwise(model, system, form, progress, time, monitor, first, error, flies)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system at the failed iterate
    type(form_t), intent(inout) :: form !! gets matrix
    type(newton_t), intent(in) :: progress !! how the solve ended
    real(wp), intent(in) :: time !! the time that was tried
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(error_t), allocatable, intent(inout) :: first !! why REDUced has failed, once it has
    type(error_t), allocatable, intent(inout) :: error !! of this failure; none: go on
    logical, intent(out) :: flies !! a body is in flight
    logical :: otherwise

    flies = .false.
    if (allocated(first)) then
      if (progress%outcome == outcome_memory) then
        call monitor%event('  the memory does not hold the factor of the whole system')
        call move_alloc(first, error)
      else if (progress%outcome /= outcome_stopped) then
        error%message = error%message//new_line('a')//'  AUTO has tried REDUced before, and '// &
          'then the whole system'
      end if
      return
    end if
    if (any(progress%outcome == [outcome_memory, outcome_stopped])) return
    flies = has_flying_body(model, system)
    if (.not. flies) then
      if (cannot_rest(model, system, time)) return
    end if
    call decline_condensed(system%whole_factors, form%whole, otherwise)
    if (.not. otherwise) return
    call move_alloc(error, first)
    if (flies) then
      call monitor%event('  a body is in free motion, and REDUced has not found '// &
        'where it closes: once more with the whole system, to the next output time')
    else
      call monitor%event('  REDUced has not converged: once more with the whole system, to '// &
        'the next output time')
    end if
  end subroutine try_otherwise

  !> The first increment of the whole system: as long as can be, with a body in flight as long as
  !! would have come after the last one that was accepted.
  pure subroutine begin_whole(equations, done, flies, part, least)
    integer, intent(in) :: equations !! free degrees of freedom
    integer, intent(in) :: done !! parts that are solved
    logical, intent(in) :: flies !! a body is in flight
    integer, intent(out) :: part !! parts of the increment
    integer, intent(out) :: least !! it is cut no further than to these

    least = 1
    part = finest_division
    do while (part > finest_division - done)
      part = part/2
    end do
    if (flies) then
      if (done > 0) part = iand(done, -done)
    else if (equations > few_equations) then
      least = max(1, part/finest_whole)
    end if
  end subroutine begin_whole

  !> A body that touches in the last converged state has no equilibrium there: it slides or tips,
  !! whatever solves for it.
  logical function cannot_rest(model, system, time) result(gets_away)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system, with the last converged positions
    real(wp), intent(in) :: time !! whose loads are to be carried
    type(verdict_t) :: verdict

    call judge_statics(model, system, time, verdict)
    gets_away = verdict%kind > statics_carried .and. verdict%apart <= close_by
  end function cannot_rest

  !> A shorter increment cannot help.
  logical function is_final(outcome, model, system, time) result(final)
    integer, intent(in) :: outcome !! how the solve ended
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    real(wp), intent(in) :: time !! the time that was tried
    type(verdict_t) :: verdict

    final = outcome == outcome_memory .or. outcome == outcome_stopped
    if (outcome == outcome_singular) final = unrestrained_bodies(model, system) > 0
    if (outcome /= outcome_turned) return
    call judge_at_rest(model, system, time, verdict)
    final = verdict%kind > statics_carried
  end function is_final

  !> Why an increment is cut.
  pure function reason(outcome) result(t)
    integer, intent(in) :: outcome !! how the solve ended
    character(:), allocatable :: t

    select case (outcome)
    case (outcome_stalled)
      t = 'Newton with line search has stalled'
    case (outcome_restless)
      t = 'contact points do not settle on a facet'
    case (outcome_too_many)
      t = 'all linear solves of an increment are used up'
    case (outcome_open)
      t = 'TIME or END comes before the increment has met TOL,'
    case (outcome_gaps)
      t = 'all updates of the multipliers are made, and gaps or forces are not within tolerance,'
    case (outcome_singular)
      t = 'the matrix is singular'
    case (outcome_through)
      t = 'a slave has passed through a master undetected,'
    case (outcome_inverted)
      t = 'an element would be inverted'
    case (outcome_thrown)
      t = 'a body has separated from contact altogether'
    case (outcome_turned)
      t = 'a body has rotated beyond the limit of small strain'
    case default
      t = 'the solve failed'
    end select
  end function reason

  !> What is said of a factor that does not fit.
  function memory_message(equations, whole) result(t)
    integer, intent(in) :: equations !! free degrees of freedom
    type(whole_form_t), intent(in) :: whole !! matrix
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')

    t = 'error: out of memory while factorising '//to_text(equations)//' equations'
    if (whole%solver%wanted > 0.0_wp) t = 'error: the memory does not hold the factor of '// &
      to_text(equations)//' equations: it takes about '// &
      memory_text(whole%solver%wanted)//', and '//memory_text(whole%solver%left)//' are left'
    t = t//nl//'  use a coarser mesh or a machine with more memory'
  end function memory_message

  !> Turns the end of a solve into an error that says what, where, and what to do.
  subroutine raise_outcome(model, system, form, state, progress, time, cut, error, goal)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system at the failed iterate
    type(form_t), intent(in) :: form !! its kind, right, matrix
    type(state_t), intent(in) :: state !! last converged state
    type(newton_t), intent(in) :: progress !! how it ended
    real(wp), intent(in) :: time !! the time that was tried
    logical, intent(in) :: cut !! increments have been cut as far as it goes
    type(error_t), allocatable, intent(out) :: error !! the error
    real(wp), intent(in), optional :: goal !! the end time that it leads to
    character(:), allocatable :: text
    character(1), parameter :: nl = new_line('a')

    select case (progress%outcome)
    case (outcome_memory)
      call raise(error, exit_resources, memory_message(system%equations, form%whole))
    case (outcome_stopped)
      call raise(error, stop_exit_code(), 'stopped by a signal at time ' &
        //to_text(state%time, 12)//'; the files end with the last converged increment')
    case default
      call explain_failure(model, system, form, progress, time, cut, text, goal)
      call raise(error, exit_no_convergence, 'error: '//reason(progress%outcome)//' at time ' &
        //to_text(time, 12)//nl//text//nl//'  everything up to time ' &
        //to_text(state%time, 12)//' is on disk')
    end select
  end subroutine raise_outcome
end module stepping

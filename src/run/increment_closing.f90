!> Closes the increment that TIME and TANG have worked on, when another command begins.
module increment_closing
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: wall_seconds
  use newton, only: outcome_open, outcome_through, outcome_thrown, outcome_turned
  use lost_contact, only: look_for_strays
  use accepted_state, only: accept
  use stepping, only: raise_outcome
  use batch_position, only: is_passing, pass_end_time
  use run_audit, only: audit_end_time
  use end_time_output, only: finish_end_time
  use run_context, only: context_t
  use run_progress, only: run_state_t
  implicit none
  private
  public :: close_increment

contains

  !> Accepts the pending increment and writes its rows; one that has not converged is an error.
  !! What TANG solves at time 0, where end times follow, is where these begin, and has no row.
  subroutine close_increment(run, context, error)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! not converged, trouble with a file
    logical :: counts

    if (.not. run%pending) return
    run%pending = .false.
    counts = run%pending_time > 0.0_wp .or. .not. run%goes_on
    if (is_passing(run%position)) then
      if (counts) call pass_end_time(run%position, run%pending_time)
      return
    end if
    if (run%converged) call look_for_strays(context%model, context%system, context%form, &
      run%progress)
    if (.not. run%converged) run%progress%outcome = outcome_open
    if (any(run%progress%outcome == [outcome_open, outcome_through, outcome_thrown, &
      outcome_turned])) then
      call raise_outcome(context%model, context%system, context%form, context%state, run%progress, &
        run%pending_time, .false., error)
      return
    end if
    call accept(context%model, context%system, context%form, context%state, run%pending_time, &
      .true.)
    call context%monitor%accepted(context%model, context%system, context%form, context%state)
    if (.not. counts) then
      context%monitor%solves_before = context%monitor%solves
      call audit_end_time(context, run%settings, error)
      return
    end if
    call pass_end_time(run%position, run%pending_time)
    call finish_end_time(run, wall_seconds(), context, error)
  end subroutine close_increment
end module increment_closing

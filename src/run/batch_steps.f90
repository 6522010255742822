!> STEP: computes its end times, one after the other.
module batch_steps
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: wall_seconds
  use parallel, only: any_rank
  use signals, only: stop_requested
  use newton_settings, only: settings_t
  use newton, only: outcome_stopped
  use stepping, only: advance, raise_outcome
  use batch_position, only: is_passing, pass_end_time
  use end_time_output, only: is_inside_due, finish_end_time
  use run_context, only: context_t
  use run_progress, only: run_state_t
  implicit none
  private
  public :: run_steps

contains

  !> STEP,,n: n increments of DT, each to convergence.
  subroutine run_steps(n, goes_on, run, context, error)
    integer, intent(in) :: n !! number of end times
    logical, intent(in) :: goes_on !! more increments follow at once
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    type(settings_t) :: settings
    real(wp) :: begin, end_time, seconds
    integer :: k

    begin = run%position%clock
    settings = run%settings
    do k = 1, n
      end_time = begin + real(k, wp)*run%increment
      if (is_passing(run%position)) then
        call pass_end_time(run%position, end_time)
        if (run%position%found) return
        cycle
      end if
      if (any_rank(stop_requested())) then
        run%progress%outcome = outcome_stopped
        call raise_outcome(context%model, context%system, context%form, context%state, &
          run%progress, context%state%time, .false., error)
        return
      end if
      context%monitor%step = context%state%step + 1
      settings%inside_due = (k == n .and. .not. goes_on) .or. &
        is_inside_due(context, context%monitor%step)
      seconds = wall_seconds()
      call advance(context%model, context%system, context%form, context%state, end_time, &
        settings, context%monitor, error)
      if (allocated(error)) return
      call pass_end_time(run%position, end_time)
      call finish_end_time(run, seconds, context, error)
      if (allocated(error)) return
    end do
  end subroutine run_steps
end module batch_steps

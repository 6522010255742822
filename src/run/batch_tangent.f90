!> One iteration at a time: TANG, FORM, SOLV of an increment that TIME has begun, and BACK.
module batch_tangent
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use newton, only: newton_t, iterate, is_converged, outcome_going_on
  use increment_conditions, only: take_overlaps, begin_at
  use increment_start, only: choose_start
  use target_passes, only: follow_solution, settle_touches
  use contact_system, only: load_contact
  use residuals, only: round_off_of, form_residual, residual_norm
  use solver_choice, only: choose_solver
  use stepping, only: raise_outcome
  use augmentation, only: augmentation_t
  use run_log, only: log_line
  use batch_types, only: batch_command_t
  use batch_position, only: is_passing
  use run_context, only: context_t
  use run_progress, only: run_state_t
  use newton_progress, only: heed_stop
  implicit none
  private
  public :: prepare, run_tangent, run_form, run_back

  !> Times that targets follow an iterate in balance before another iteration is asked for.
  integer, parameter :: most_target_passes = 10

contains

  !> Marks an increment as begun; its first TANG sets it up.
  subroutine prepare(run, context)
    type(run_state_t), intent(inout) :: run !! gets a pending increment
    type(context_t), target, intent(inout) :: context !! what the run works on

    run%pending = .true.
    run%converged = .false.
    run%started = .false.
    run%progress = newton_t()
    run%augmentation = augmentation_t()
    if (is_passing(run%position)) return
    call take_overlaps(context%model, run%pending_time)
    call begin_at(context%model, context%state, run%pending_time, context%system%equation, &
      context%system%u, context%system%loads, context%system%tools)
  end subroutine prepare

  !> Makes the pending increment ready for iterations, once; without TIME before it, one at the
  !! present time. What a restart passes over counts as converged.
  subroutine set_up(run, context)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(context_t), target, intent(inout) :: context !! what the run works on

    if (.not. run%pending) then
      run%pending_time = run%position%clock
      call prepare(run, context)
    end if
    if (is_passing(run%position)) run%converged = .true.
    if (run%converged .or. run%started) return
    associate (model => context%model, system => context%system, form => context%form, state => &
      context%state, monitor => context%monitor)
      monitor%step = state%step + 1
      call choose_solver(model, system, form, monitor)
      model%pairs%history%softened = .false.
      system%position%x_old = model%mesh%x + state%u
      call choose_start(model, system, form, state, run%pending_time, monitor)
      call form%kind%couple(system, form)
      system%contact%slip_before = 0.0_wp
      run%started = .true.
    end associate
  end subroutine set_up

  !> TANG, UTAN: one Newton iteration of the pending increment; without TIME before it, one at the
  !! present time.
  subroutine run_tangent(run, context, error)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! singular, out of memory, stopped

    call set_up(run, context)
    if (run%converged) return
    associate (model => context%model, system => context%system, form => context%form, state => &
      context%state, monitor => context%monitor)
      system%scale%round_off = round_off_of(system, form, model%mesh%x)
      call iterate(model, system, form, run%pending_time, run%settings, monitor, run%progress)
      if (run%progress%outcome == outcome_going_on) then
        call heed_stop(run%progress)
      end if
      if (run%progress%outcome /= outcome_going_on) then
        call raise_outcome(model, system, form, state, run%progress, run%pending_time, .false., &
          error)
        return
      end if
      ! at the start there may have been nothing to round
      system%scale%round_off = round_off_of(system, form, model%mesh%x)
      run%converged = is_converged(system, form, run%settings, run%progress)
      if (.not. run%converged .or. size(model%pairs) == 0) return
      call settle_targets(run, context)
    end associate
  end subroutine run_tangent

  !> Target facets and first touches follow an iterate in balance. Where that changes them, it has
  !! converged all the same if nothing is left of the residual then.
  subroutine settle_targets(run, context)
    type(run_state_t), intent(inout) :: run !! the pending increment; gets converged
    type(context_t), target, intent(inout) :: context !! what the run works on
    integer :: pass

    associate (model => context%model, system => context%system, form => context%form, &
      monitor => context%monitor)
      do pass = 1, most_target_passes
        call follow_solution(model, system, form, run%settings, monitor, run%progress, &
          run%converged)
        if (run%converged) call settle_touches(model, system, form%costs, monitor, &
          run%converged)
        if (run%converged) return
        call load_contact(model, system)
        call form%kind%couple(system, form)
        call form_residual(system, form, model%mesh%x)
        run%progress%energy_met = .false.
        system%scale%round_off = round_off_of(system, form, model%mesh%x)
        if (.not. is_converged(system, form, run%settings, run%progress)) return
      end do
    end associate
  end subroutine settle_targets

  !> FORM: forms the residual of the pending increment, and tells its norm.
  subroutine run_form(run, context, error)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! trouble with the log

    call set_up(run, context)
    if (is_passing(run%position)) return
    call form_residual(context%system, context%form, context%model%mesh%x)
    call log_line(context%files%log, '  FORM: residual '//to_text(residual_norm(context%system, &
      context%form), 6)//' at time '//to_text(run%pending_time, 12), error)
  end subroutine run_form

  !> BACK[,,dt]: gives up the pending increment: time, displacements and contact history are those
  !! of the last end time; with a DT for what follows.
  subroutine run_back(command, run, context, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(run_state_t), intent(inout) :: run !! the pending increment; there is none afterwards
    type(context_t), target, intent(inout) :: context !! its log
    type(error_t), allocatable, intent(out) :: error !! trouble with the log

    if (command%v(1) > 0.0_wp) run%increment = command%v(1)
    if (.not. run%pending) return
    run%pending = .false.
    run%converged = .false.
    run%started = .false.
    if (is_passing(run%position)) return
    call log_line(context%files%log, '  BACK: from time '//to_text(run%pending_time, 12)// &
      ' to time '//to_text(run%position%clock, 12), error)
  end subroutine run_back
end module batch_tangent

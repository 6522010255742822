!> Audits the end times of a run: table to the log, each warning to the terminal once, and an error
!! where a body is out of balance or has left small strain (doc/manual, "The audit").
module run_audit
  use kinds, only: wp
  use errors, only: error_t, raise, exit_no_convergence
  use text, only: to_text
  use costs, only: begin_cost, end_cost, cost_audit
  use audit_types, only: audit_t, n_checks, check_balance, check_turning, check_volume, &
    check_answers, verdict_warning, verdict_failed
  use audit, only: audit_state
  use answers_audit, only: judge_answers
  use audit_text, only: audit_table, audit_record, audit_warning, audit_finding, &
    balance_message, shape_message
  use accepted_state, only: complete_state
  use newton_settings, only: settings_t
  use element_types, only: task_stress
  use assembly, only: recover
  use mortar_rows, only: fill_mortar_points
  use element_fields, only: recover_fields
  use run_log, only: log_full, log_line
  use json_lines, only: print_record
  use run_context, only: context_t
  implicit none
  private
  public :: audit_end_time, tell_warnings, tell_answers

contains

  !> Audits the state that is about to be written, and recovers what that and the files want.
  subroutine audit_end_time(context, settings, error)
    type(context_t), target, intent(inout) :: context !! the run; its audit gets the results
    type(settings_t), intent(in) :: settings !! tolerances asked for
    type(error_t), allocatable, intent(out) :: error !! out of balance, or out of small strain
    real(wp) :: before
    logical :: full, last

    associate (audit => context%audit, model => context%model, system => context%system, &
      form => context%form)
      call begin_cost(form%costs, cost_audit)
      before = audit%time
      last = context%state%step == context%monitor%steps
      full = audit%step == 0 .or. last
      call recover(system%contact, task_stress, model%mesh%x, context%state%u, &
        context%files%point_state)
      call fill_mortar_points(model, system, context%files%point_state)
      call audit_whole(context, settings, last)
      call recover_fields(model, system, context%state, last, context%files%stress, &
        context%files%strain, context%files%nodal, audit)
      full = full .or. any(audit%verdict == verdict_failed) .or. context%files%log%level == log_full
      call context%monitor%event(audit_table(model, system, audit, full))
      if (context%terminal%json) call print_record('audit', audit_record(model, system, audit))
      call tell_warnings(context)
      call end_cost(form%costs, cost_audit)
      if (any(audit%verdict([check_turning, check_volume]) == verdict_failed)) then
        call raise(error, exit_no_convergence, shape_message(model, system, audit, before))
      else if (audit%verdict(check_balance) == verdict_failed) then
        call raise(error, exit_no_convergence, balance_message(model, system, audit, before))
      end if
    end associate
  end subroutine audit_end_time

  !> Audits the state. Where displacements inside have been spared, the sums of supports know
  !! nothing of what a body is strained by them alone, and of the round-off of that: what is out of
  !! balance then is looked at with all that is there.
  subroutine audit_whole(context, settings, last)
    type(context_t), target, intent(inout) :: context !! the run; its audit gets the results
    type(settings_t), intent(in) :: settings !! tolerances asked for
    logical, intent(in) :: last !! end time of the run
    type(audit_t), allocatable :: before

    associate (audit => context%audit, model => context%model, system => context%system, &
      form => context%form)
      if (.not. context%state%whole) before = audit
      call audit_state(model, system, form, context%state, settings, context%files%point_state, &
        last, audit)
      if (context%state%whole .or. audit%verdict(check_balance) /= verdict_failed) return
      audit = before
      call complete_state(model, system, form, context%state)
      call recover(system%contact, task_stress, model%mesh%x, context%state%u, &
        context%files%point_state)
      call fill_mortar_points(model, system, context%files%point_state)
      call audit_state(model, system, form, context%state, settings, context%files%point_state, &
        last, audit)
    end associate
  end subroutine audit_whole

  !> CHEC,UNIQ: what is known of other answers beside the end time's, with second starts.
  subroutine tell_answers(context, error)
    type(context_t), target, intent(inout) :: context !! the run, audited
    type(error_t), allocatable, intent(out) :: error !! trouble with the log
    type(audit_t) :: audit
    character(:), allocatable :: t

    if (context%audit%step == 0 .or. context%audit%step /= context%state%step .or. &
      abs(context%audit%time - context%state%time) > 0.0_wp) then
      t = 'answers: no output time has been solved since the state was taken'
    else
      audit = context%audit
      call judge_answers(context%model, context%system, context%form, context%state, &
        context%files%point_state, .true., .true., audit)
      t = audit_finding(context%model, context%system, audit, check_answers)
    end if
    call log_line(context%files%log, '  time '//to_text(context%state%time, 12)//', '//t, error)
  end subroutine tell_answers

  !> Tells each warning once; before the first end time those of the scene.
  subroutine tell_warnings(context)
    type(context_t), target, intent(inout) :: context !! the run, audited
    integer :: i

    associate (audit => context%audit)
      do i = 1, n_checks
        if (audit%verdict(i) /= verdict_warning .or. audit%told(i)) cycle
        audit%told(i) = .true.
        call context%monitor%warning(audit_warning(context%model, context%system, audit, i))
      end do
    end associate
  end subroutine tell_warnings
end module run_audit

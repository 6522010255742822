!> What is due at an end time: displacements inside, audit, derivatives, rows, its line of the log.
module end_time_output
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: wall_seconds, begin_cost, end_cost, count_cost, cost_output, cost_fields, &
    cost_flush
  use signals, only: begin_writing, end_writing
  use model_types, only: state_none
  use rigid_paths, only: count_rigid
  use result_types, only: derivative_rows_t
  use results_file, only: fields_due
  use sensitivity_table, only: derivative_rows, write_sensitivities
  use kept_slopes, only: keep_slopes
  use touch_report, only: keep_touches
  use run_audit, only: audit_end_time
  use run_files, only: write_row
  use run_log, only: log_increment, log_increment_t
  use run_monitor, only: foresee_end, tell_end_time
  use run_context, only: context_t
  use run_progress, only: run_state_t
  implicit none
  private
  public :: is_inside_due, finish_end_time

  !> At every so many end times the audit has displacements inside, whoever else asks for them.
  integer, parameter :: every_audit = 64

contains

  !> Displacements inside are asked for at an end time: by fields, state or tables, and at every so
  !! many by the audit.
  pure logical function is_inside_due(context, step) result(due)
    type(context_t), intent(in) :: context !! what the run works on
    integer, intent(in) :: step !! number of the end time

    associate (output => context%model%output)
      due = fields_due(output, step) .and. (any(output%field) .or. output%contact .or. &
        output%state /= state_none)
      due = due .or. mod(step, every_audit) == 0 .or. size(output%history) > 0 .or. &
        context%sensitivity%active .or. count_rigid(context%model) > 0
    end associate
  end function is_inside_due

  !> Counts an end time, audits it, writes its rows and its line.
  subroutine finish_end_time(run, seconds, context, error)
    type(run_state_t), intent(in) :: run !! its increment of time, tolerances
    real(wp), intent(in) :: seconds !! clock at its start [s]
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! trouble with a file
    type(log_increment_t) :: line
    type(derivative_rows_t), allocatable :: derivatives

    context%state%step = context%state%step + 1
    call audit_end_time(context, run%settings, error)
    if (allocated(error)) return
    if (context%sensitivity%active .and. context%model%output%state /= state_none) &
      call keep_slopes(context%model, context%sensitivity, context%state)
    if (context%sensitivity%active) derivatives = derivative_rows(context%model, &
      context%sensitivity)
    call keep_touches(context%model, context%touched)
    call begin_writing()
    call begin_cost(context%form%costs, cost_output)
    call write_row(context%files, context%model, context%system, context%form, context%state, &
      run%increment, context%audit, derivatives, error)
    if (fields_due(context%model%output, context%state%step)) call count_cost( &
      context%form%costs, cost_fields, count([context%model%output%field, &
      context%model%output%contact]))
    context%form%costs%count(cost_flush) = context%files%results%file%flushes + &
      context%files%surfaces%file%flushes
    call end_cost(context%form%costs, cost_output)
    if (allocated(derivatives) .and. .not. allocated(error)) call write_sensitivities( &
      context%derivatives, context%state, derivatives, error)
    call end_writing()
    context%form%condensed%goes_on = context%model%output%state == state_none .or. &
      .not. fields_due(context%model%output, context%state%step)
    if (allocated(context%monitor%trouble) .and. .not. allocated(error)) call move_alloc( &
      context%monitor%trouble, error)
    if (allocated(error)) return
    line%step = context%state%step
    line%increment = 1
    line%time = context%state%time
    line%size = run%increment
    line%iterations = context%monitor%solves - context%monitor%solves_before
    line%residual = norm2(context%form%right)
    line%seconds = wall_seconds() - seconds
    context%monitor%solves_before = context%monitor%solves
    call log_increment(context%files%log, line, error)
    call foresee_end(context%monitor, line%step, wall_seconds())
    call tell_end_time(context%monitor, line)
  end subroutine finish_end_time
end module end_time_output

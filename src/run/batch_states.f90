!> SAVE and REST: keeps states on the way, and goes back to them.
module batch_states
  use errors, only: error_t
  use text, only: to_text
  use batch_types, only: batch_command_t
  use batch_position, only: is_passing
  use run_log, only: log_line
  use signals, only: begin_writing, end_writing
  use run_context, only: context_t
  use run_progress, only: run_state_t
  use result_types, only: saved_state_t
  use saved_states, only: keep_state, read_kept_state, take_state, note_passed
  use restored_balance, only: check_time, check_balance
  use kept_slopes, only: keep_slopes, resume_slopes
  implicit none
  private
  public :: run_save, run_rest

contains

  !> SAVE[,name]: keeps the present state in a file of its own.
  subroutine run_save(command, run, context, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(run_state_t), intent(inout) :: run !! where states are kept
    type(context_t), intent(inout) :: context !! problem, converged state, log
    type(error_t), allocatable, intent(out) :: error !! trouble with a file
    character(:), allocatable :: path

    if (is_passing(run%position)) then
      call note_passed(run%states, command%text)
      return
    end if
    if (context%sensitivity%active) call keep_slopes(context%model, context%sensitivity, &
      context%state)
    call begin_writing()
    call keep_state(run%states, command%text, context%model, context%system, context%form, &
      context%state, run%increment, path, error)
    call end_writing()
    context%form%condensed%goes_on = .false.
    if (.not. allocated(error)) call log_line(context%files%log, '  state of time '// &
      to_text(context%state%time, 12)//' saved in '//path, error)
  end subroutine run_save

  !> REST[,name] or REST,file[,step]: goes back to a saved state; steps count on.
  subroutine run_rest(command, run, context, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(run_state_t), intent(inout) :: run !! where states are kept; its clock is set back
    type(context_t), intent(inout) :: context !! problem, converged state, log
    type(error_t), allocatable, intent(out) :: error !! no such state
    type(saved_state_t) :: saved
    character(:), allocatable :: path

    call read_kept_state(run%states, command%text, nint(command%v(1)), context%model, saved, &
      path, error)
    if (.not. allocated(error)) call check_time(path, saved, error)
    if (allocated(error)) return
    run%position%clock = saved%time
    if (is_passing(run%position)) return
    if (allocated(saved%note)) call context%monitor%warning(saved%note)
    call take_state(saved, context%model, context%system, context%form, context%state)
    call check_balance(path, context%model, context%system, context%form, context%state, saved, &
      error)
    if (context%sensitivity%active .and. .not. allocated(error)) call resume_slopes(path, &
      context%model, context%system%place, context%state, context%sensitivity, error)
    if (allocated(error)) return
    call log_line(context%files%log, '  back to the state of time '// &
      to_text(context%state%time, 12)//' in '//path, error)
  end subroutine run_rest
end module batch_states

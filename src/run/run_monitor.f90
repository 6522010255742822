!> Passes what the solution procedures report on to the log and to the live line of the terminal.
module run_monitor
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text, count_noun
  use monitors, only: monitor_t, iteration_t
  use terminal, only: terminal_t, show_progress, print_line, print_warning, print_detail
  use json_lines, only: item, print_record
  use errors, only: raise, exit_no_convergence
  use model_types, only: model_t
  use system_types, only: form_t, system_t, state_t
  use sensitivity_types, only: sensitivity_t
  use sensitivities, only: follow_increment
  use run_log, only: log_t, log_increment_t, log_iteration, log_line, log_warning, log_cut, &
    log_brief, log_full
  implicit none
  private
  public :: run_monitor_t, step_text, time_left, foresee_end, tell_end_time

  !> Runs that have taken longer than this say how long the rest may take [s].
  real(wp), parameter :: seconds_of_long_run = 20.0_wp

  !> The log and the terminal of a run. Trouble with the log is kept until the run layer looks.
  type, extends(monitor_t) :: run_monitor_t
    type(log_t), pointer :: log => null() !! the log
    type(terminal_t), pointer :: terminal => null() !! the terminal
    type(sensitivity_t), pointer :: sensitivity => null() !! derivatives, if they are asked for
    type(error_t), allocatable :: trouble !! the log could not be written
    integer :: step = 0 !! end time that is worked for
    integer :: steps = 0 !! end times of the whole deck
    integer :: first_step = 0 !! end time that the run began with
    real(wp) :: began = 0.0_wp !! clock when it did [s]
    real(wp) :: left = -1.0_wp !! what the rest may take, negative while unknown [s]
    integer :: solves = 0 !! linear solves of the run
    integer :: solves_before = 0 !! linear solves before the present step
  contains
    procedure :: iteration => take_iteration !! one line of the log
    procedure :: event => take_event !! one line of the log
    procedure :: detail => take_detail !! one line of a log that is not brief
    procedure :: warning => take_warning !! one line of the log and of the terminal
    procedure :: cut => take_cut !! one line of the log
    procedure :: accepted => take_accepted !! derivatives of the increment
  end type run_monitor_t

contains

  !> Logs one iteration and shows it.
  subroutine take_iteration(self, report)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    type(iteration_t), intent(in) :: report !! the iteration
    type(error_t), allocatable :: error

    self%solves = self%solves + 1
    if (associated(self%log)) then
      call log_iteration(self%log, self%step, report, error)
      if (self%log%level == log_full .and. report%worst_node > 0) then
        call log_line(self%log, '  largest residual '//to_text(report%worst, 4)//' at node '// &
          to_text(report%worst_node)//', dof '//to_text(report%worst_dof), error)
      end if
    end if
    if (allocated(error)) call move_alloc(error, self%trouble)
    if (.not. associated(self%terminal)) return
    if (self%terminal%json) then
      call print_record('iteration', item('step', self%step)//item('steps', self%steps)// &
        item('time', report%time)//item('solve', report%number)//item('residual', &
        report%residual)//item('relative', report%relative)//item('energy', report%energy)// &
        item('line_search', report%step_length)//item('active', report%active)//item('stick', &
        report%stick)//item('slip', report%slip)//item('solver', trim(report%solver))// &
        item('seconds', report%seconds))
      return
    end if
    call show_progress(self%terminal, step_text(self, self%step)//', time '// &
      to_text(report%time)//', solve '//to_text(report%number)//', residual '// &
      to_text(report%relative, 3)//', contact '//to_text(report%active)//' ('// &
      to_text(report%slip)//' slip)'//time_left(self))
  end subroutine take_iteration

  !> Logs one line.
  subroutine take_event(self, text)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    character(*), intent(in) :: text !! the line
    type(error_t), allocatable :: error

    if (associated(self%terminal)) call print_detail(self%terminal, text)
    if (associated(self%log)) call log_line(self%log, text, error)
    if (allocated(error)) call move_alloc(error, self%trouble)
  end subroutine take_event

  !> Logs one line of an iteration, unless the log is to be brief.
  subroutine take_detail(self, text)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    character(*), intent(in) :: text !! the line

    if (associated(self%log)) then
      if (self%log%level == log_brief) return
    end if
    call self%event(text)
  end subroutine take_detail

  !> Logs a warning and shows it.
  subroutine take_warning(self, text)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    character(*), intent(in) :: text !! the warning
    type(error_t), allocatable :: error

    if (associated(self%terminal)) call print_warning(self%terminal, 'warning: '//text)
    if (associated(self%log)) call log_warning(self%log, text, error)
    if (allocated(error)) call move_alloc(error, self%trouble)
  end subroutine take_warning

  !> Logs a cut.
  subroutine take_cut(self, time, old_size, new_size, reason)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    real(wp), intent(in) :: time !! time of the last converged increment
    real(wp), intent(in) :: old_size !! increment that failed
    real(wp), intent(in) :: new_size !! increment tried next
    character(*), intent(in) :: reason !! why it failed
    type(error_t), allocatable :: error

    if (associated(self%terminal)) then
      if (self%terminal%json) call print_record('cut', item('step', self%step)//item('time', &
        time)//item('size', old_size)//item('new_size', new_size)//item('reason', reason))
      if (self%terminal%verbose) call print_detail(self%terminal, 'cut: from time '// &
        to_text(time)//', size '//to_text(old_size)//' to '//to_text(new_size)//': '//reason)
    end if
    if (associated(self%log)) then
      call log_cut(self%log, self%step, time, old_size, new_size, reason, error)
    end if
    if (allocated(error)) call move_alloc(error, self%trouble)
  end subroutine take_cut

  !> Takes the derivatives through an increment that has been accepted.
  subroutine take_accepted(self, model, system, form, state)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    type(model_t), intent(in) :: model !! with its new history
    type(system_t), intent(inout) :: system !! as it was solved
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(in) :: state !! the new state
    type(error_t), allocatable :: error
    character(:), allocatable :: trouble

    if (.not. associated(self%sensitivity)) return
    call follow_increment(model, system, form, state, self%sensitivity, trouble)
    if (len(trouble) == 0) then
      call self%detail('  derivatives: penalties, moduli and forces make the reactions to '// &
        to_text(self%sensitivity%euler%error, 2)//' (Euler), '// &
        count_noun(sum(self%sensitivity%kinks), 'point')//' at a border')
      return
    end if
    call raise(error, exit_no_convergence, 'error: no derivatives at time '// &
      to_text(state%time, 12)//': '//trouble//new_line('a')//'  leave SENSitivity out')
    call move_alloc(error, self%trouble)
  end subroutine take_accepted

  !> Shows an end time that is on disk.
  subroutine tell_end_time(self, line)
    class(run_monitor_t), intent(inout) :: self !! the receiver
    type(log_increment_t), intent(in) :: line !! what is known of it

    if (self%terminal%json) then
      call print_record('end_time', item('step', line%step)//item('steps', self%steps)// &
        item('time', line%time)//item('solves', line%iterations)//item('residual', &
        line%residual)//item('seconds', line%seconds))
      return
    end if
    call print_line(self%terminal, step_text(self, line%step)//'  time '//to_text(line%time)// &
      '  '//to_text(line%iterations)//' solves  '//to_text(line%seconds, 3)//' s'//time_left(self))
  end subroutine tell_end_time

  !> The number of an end time, and of how many where the deck says.
  pure function step_text(self, step) result(t)
    class(run_monitor_t), intent(in) :: self !! the receiver
    integer, intent(in) :: step !! the end time
    character(:), allocatable :: t

    t = 'step '//to_text(step)
    if (self%steps >= step) t = t//' of '//to_text(self%steps)
  end function step_text

  !> What the rest of a long run may take, in words; empty for a short one.
  pure function time_left(self) result(t)
    class(run_monitor_t), intent(in) :: self !! the receiver
    character(:), allocatable :: t

    t = ''
    if (self%left < 0.0_wp) return
    if (self%left < 100.0_wp) then
      t = ', about '//to_text(nint(self%left))//' s left'
    else if (self%left < 6000.0_wp) then
      t = ', about '//to_text(nint(self%left/60.0_wp))//' min left'
    else
      t = ', about '//to_text(self%left/3600.0_wp, 2)//' h left'
    end if
  end function time_left

  !> Foresees the end from the end times so far.
  pure subroutine foresee_end(self, step, now)
    class(run_monitor_t), intent(inout) :: self !! the receiver; gets left
    integer, intent(in) :: step !! end time that is done
    real(wp), intent(in) :: now !! clock [s]

    self%left = -1.0_wp
    if (now - self%began < seconds_of_long_run .or. step >= self%steps) return
    self%left = (now - self%began)*real(self%steps - step, wp)/real(step - self%first_step, wp)
  end subroutine foresee_end
end module run_monitor

!> Carries out the solution commands of a deck, one after the other.
module batch_run
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: wall_seconds
  use solution_settings, only: take_setting
  use linear_solver, only: solver_of
  use back_ends, only: solver_auto
  use solver_choice, only: ask_for_solver
  use batch_types, only: batch_command_t
  use batch_position, only: check_increment, is_passing, look_for, end_times_to_pass, count_steps
  use saved_states, only: saved_states_t
  use run_log, only: log_warning
  use run_context, only: context_t
  use run_progress, only: run_state_t
  use end_time_output, only: is_inside_due
  use increment_closing, only: close_increment
  use batch_steps, only: run_steps
  use batch_states, only: run_save, run_rest
  use batch_augment, only: run_augment
  use batch_tangent, only: prepare, run_tangent, run_form, run_back
  use printing, only: print_request
  implicit none
  private
  public :: run_batch

contains

  !> Carries out all commands; after a restart, those behind the state's end time.
  subroutine run_batch(commands, states, context, error)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    type(saved_states_t), intent(in) :: states !! where states are kept; the restart
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    type(run_state_t) :: run
    integer :: skip, k

    context%monitor%steps = count_steps(commands)
    context%system%spared = count([(.not. is_inside_due(context, k), k=1, context%monitor%steps)])
    skip = 0
    call ask_for_solver(context%form%whole, solver_auto)
    if (states%step > 0) then
      run%states = states
      run%goes_on = has_end_times(commands)
      run%position = look_for(states%step, states%time)
      call run_commands(commands, run, context, error)
      skip = end_times_to_pass(run%position)
      context%monitor%steps = context%monitor%steps - skip + states%step
      run = run_state_t()
      if (allocated(error)) deallocate (error)
      call ask_for_solver(context%form%whole, solver_auto)
    end if
    run%states = states
    run%goes_on = has_end_times(commands)
    run%position%skip = skip
    run%settings%parts = context%parts
    context%monitor%began = wall_seconds()
    context%monitor%first_step = context%state%step
    call run_commands(commands, run, context, error)
    if (allocated(error) .or. states%step == 0 .or. context%state%step > states%step) return
    call log_warning(context%files%log, &
      'the deck has no output time behind the state restarted from', error)
  end subroutine run_batch

  !> Carries out commands to the last, or until a rehearsal has found what it looks for.
  subroutine run_commands(commands, run, context, error)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    integer :: next, turns(size(commands))

    turns = 0
    next = 1
    do while (next <= size(commands))
      call run_command(commands, next, turns, run, context, error)
      if (allocated(context%monitor%trouble) .and. .not. allocated(error)) then
        call move_alloc(context%monitor%trouble, error)
      end if
      if (allocated(error) .or. run%position%found) return
      next = next + 1
    end do
    call close_increment(run, context, error)
  end subroutine run_commands

  !> Carries out one command; LOOP and NEXT move `next`.
  subroutine run_command(commands, next, turns, run, context, error)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    integer, intent(inout) :: next !! the command; moved by loops
    integer, intent(inout) :: turns(:) !! turns made of each LOOP
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    logical :: taken

    associate (command => commands(next))
      select case (command%command)
      case ('dt')
        run%increment = command%v(1)
      case ('step')
        call close_increment(run, context, error)
        if (.not. allocated(error)) call check_increment(run%increment, run%position%clock, error)
        if (.not. allocated(error)) call run_steps(nint(command%v(1)), steps_on(commands, next), &
          run, context, error)
      case ('time')
        call close_increment(run, context, error)
        if (.not. allocated(error)) call check_increment(run%increment, run%position%clock, error)
        if (allocated(error)) return
        if (is_over(command%v(1), run)) then
          next = end_of_loop(commands, next)
        else
          call begin_time(command%v(1), run, context)
        end if
      case ('save', 'rest')
        call close_increment(run, context, error)
        if (allocated(error)) return
        if (command%command == 'save') call run_save(command, run, context, error)
        if (command%command == 'rest') call run_rest(command, run, context, error)
      case ('tang', 'utan')
        if (command%solves) call run_tangent(run, context, error)
      case ('form')
        call run_form(run, context, error)
      case ('back')
        call run_back(command, run, context, error)
      case ('augm')
        call run_augment(run, context%model, context%system, context%form, context%monitor)
      case ('solv')
        if (command%solves) call run_tangent(run, context, error)
        if (.not. command%solves) call ask_for_solver(context%form%whole, solver_of(command%option))
      case ('loop')
        turns(next) = 1
        if (nothing_to_do(run, command%v(1))) next = command%partner
      case ('next')
        call turn_loop(commands, next, turns, run)
      case ('disp', 'reac', 'stre', 'chec')
        if (run%converged) call close_increment(run, context, error)
        if (allocated(error) .or. is_passing(run%position)) return
        call print_request(command, context, error)
      case default
        ! PROP has been obeyed when the deck was read.
        call take_setting(command%command, command%option, command%v(1), run%settings%asked, taken)
      end select
    end associate
  end subroutine run_command

  !> A loop of no turns.
  pure logical function nothing_to_do(run, turns) result(nothing)
    type(run_state_t), intent(in) :: run !! where the run stands
    real(wp), intent(in) :: turns !! turns of the loop

    nothing = turns < 1.0_wp .and. .not. run%pending
  end function nothing_to_do

  !> NEXT: back to the loop's first command, unless its turns are made or it has converged.
  subroutine turn_loop(commands, next, turns, run)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    integer, intent(inout) :: next !! the NEXT; moved to its LOOP for another turn
    integer, intent(inout) :: turns(:) !! turns made of each LOOP
    type(run_state_t), intent(in) :: run !! where the run stands
    integer :: begin
    logical :: iterates

    begin = commands(next)%partner
    iterates = .not. any(commands(begin:next)%command == 'time' .or. &
      commands(begin:next)%command == 'step')
    if (iterates .and. run%converged) return
    if (turns(begin) >= nint(commands(begin)%v(1))) return
    turns(begin) = turns(begin) + 1
    next = begin
  end subroutine turn_loop

  !> The next command that does more than set values is STEP: nothing looks at the state before.
  pure logical function steps_on(commands, next) result(on)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    integer, intent(in) :: next !! number of a STEP
    integer :: i

    on = .false.
    do i = next + 1, size(commands)
      if (any(commands(i)%command == ['dt  ', 'tol ', 'prop'])) cycle
      if (commands(i)%command == 'step') on = nint(commands(i)%v(1)) > 0
      return
    end do
  end function steps_on

  !> TIME: moves to the next end time and begins its increment.
  subroutine begin_time(last, run, context)
    real(wp), intent(in) :: last !! latest time, 0 for none
    type(run_state_t), intent(inout) :: run !! gets a pending increment
    type(context_t), target, intent(inout) :: context !! what the run works on

    run%pending_time = run%position%clock + run%increment
    if (last > 0.0_wp) run%pending_time = min(run%pending_time, last)
    call prepare(run, context)
  end subroutine begin_time

  !> TIME,,tmax has arrived at tmax, to round-off.
  pure logical function is_over(last, run)
    real(wp), intent(in) :: last !! tmax, 0 for none
    type(run_state_t), intent(in) :: run !! where the run stands

    is_over = last > 0.0_wp .and. run%position%clock >= last - 1.0e-10_wp*max(last, run%increment)
  end function is_over

  !> The NEXT of the innermost LOOP around a command; the command itself outside of loops.
  pure integer function end_of_loop(commands, command) result(last)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    integer, intent(in) :: command !! index of the command
    integer :: i

    last = command
    do i = command + 1, size(commands)
      if (commands(i)%command /= 'next') cycle
      if (commands(i)%partner > command) cycle
      last = i
      return
    end do
  end function end_of_loop

  !> The batch has commands that make end times.
  pure logical function has_end_times(commands) result(has)
    type(batch_command_t), intent(in) :: commands(:) !! the commands

    has = any(commands%command == 'time' .or. commands%command == 'step')
  end function has_end_times
end module batch_run

!> Carries out the solution commands of a deck, one after the other.
module batch_run
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use costs, only: wall_seconds
  use model_types, only: model_t
  use system_types, only: system_t, state_t
  use contact_system, only: load_contact, couple, move_hosts
  use newton, only: newton_t, iterate, is_converged, outcome_going_on, outcome_open, &
    outcome_stopped
  use increments, only: begin_at, choose_start, accept
  use residuals, only: estimate_round_off
  use condensed_system, only: refresh_candidates
  use linear_solver, only: solver_of, solver_auto
  use solver_choice, only: ask_for_solver, choose_solver
  use stepping, only: advance, raise_outcome
  use signals, only: stop_requested
  use batch_types, only: batch_command_t
  use run_files, only: run_files_t, write_row
  use run_log, only: log_increment, log_increment_t, log_warning
  use run_monitor, only: run_monitor_t
  use terminal, only: terminal_t, print_line
  use batch_position, only: is_passing, pass_end_time, look_for, &
    end_times_to_pass, count_steps
  use saved_states, only: saved_states_t
  use run_progress, only: run_state_t
  use batch_states, only: run_save, run_rest
  use batch_augment, only: run_augment
  use augmentation, only: augmentation_t
  use printing, only: print_displacements, print_reactions
  implicit none
  private
  public :: run_batch

contains

  !> Carries out all commands; after a restart, those behind the state's end time.
  subroutine run_batch(commands, states, model, system, state, files, monitor, terminal, error)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    type(saved_states_t), intent(in) :: states !! where states are kept; the restart
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(inout) :: state !! the converged state, that of the restart
    type(run_files_t), intent(inout) :: files !! open files
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    type(run_state_t) :: run
    integer :: skip

    monitor%steps = count_steps(commands)
    skip = 0
    call ask_for_solver(system, solver_auto)
    if (states%step > 0) then
      run%states = states
      run%position = look_for(states%step, states%time)
      call run_commands(commands, run, model, system, state, files, monitor, terminal, error)
      skip = end_times_to_pass(run%position)
      monitor%steps = monitor%steps - skip + states%step
      run = run_state_t()
      if (allocated(error)) deallocate (error)
      call ask_for_solver(system, solver_auto)
    end if
    run%states = states
    run%position%skip = skip
    call run_commands(commands, run, model, system, state, files, monitor, terminal, error)
    if (allocated(error) .or. states%step == 0 .or. state%step > states%step) return
    call log_warning(files%log, 'the deck has no end time behind the state restarted from', error)
  end subroutine run_batch

  !> Carries out commands to the last, or until a rehearsal has found what it looks for.
  subroutine run_commands(commands, run, model, system, state, files, monitor, terminal, error)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(inout) :: state !! the converged state
    type(run_files_t), intent(inout) :: files !! open files
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    integer :: next, turns(size(commands))

    turns = 0
    next = 1
    do while (next <= size(commands))
      call run_command(commands, next, turns, run, model, system, state, files, monitor, &
        terminal, error)
      if (allocated(monitor%trouble) .and. .not. allocated(error)) then
        call move_alloc(monitor%trouble, error)
      end if
      if (allocated(error) .or. run%position%found) return
      next = next + 1
    end do
    call close_increment(run, model, system, state, files, monitor, terminal, error)
  end subroutine run_commands

  !> Carries out one command; LOOP and NEXT move `next`.
  subroutine run_command(commands, next, turns, run, model, system, state, files, monitor, &
                         terminal, error)
    type(batch_command_t), intent(in) :: commands(:) !! the commands
    integer, intent(inout) :: next !! the command; moved by loops
    integer, intent(inout) :: turns(:) !! turns made of each LOOP
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(inout) :: state !! the converged state
    type(run_files_t), intent(inout) :: files !! open files
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble

    associate (command => commands(next))
      select case (command%command)
      case ('dt')
        run%increment = command%v(1)
      case ('tol')
        if (command%option == 'resi') then
          run%settings%residual_tolerance = command%v(1)
        else
          run%settings%energy_tolerance = command%v(1)
        end if
      case ('step')
        call close_increment(run, model, system, state, files, monitor, terminal, error)
        if (.not. allocated(error)) then
          call run_steps(nint(command%v(1)), run, model, system, state, files, monitor, terminal, &
            error)
        end if
      case ('time')
        call close_increment(run, model, system, state, files, monitor, terminal, error)
        if (allocated(error)) return
        if (is_over(command%v(1), run)) then
          next = end_of_loop(commands, next)
        else
          call begin_time(command%v(1), run, model, system, state)
        end if
      case ('save', 'rest')
        call close_increment(run, model, system, state, files, monitor, terminal, error)
        if (allocated(error)) return
        if (command%command == 'save') call run_save(command, run, model, system, state, files, &
          error)
        if (command%command == 'rest') call run_rest(command, run, model, system, state, files, &
          error)
      case ('tang', 'utan')
        call run_tangent(run, model, system, state, monitor, error)
      case ('augm')
        call run_augment(run, model, system, monitor)
      case ('solv')
        call ask_for_solver(system, solver_of(command%option))
      case ('loop')
        turns(next) = 1
        if (nothing_to_do(run, command%v(1))) next = command%partner
      case ('next')
        call turn_loop(commands, next, turns, run)
      case ('disp', 'reac')
        if (run%converged) call close_increment(run, model, system, state, files, monitor, &
          terminal, error)
        if (allocated(error) .or. is_passing(run%position)) return
        if (command%command == 'disp') call print_displacements(command, model, state, &
          files%log, error)
        if (command%command == 'reac') call print_reactions(command, model, state, files%log, &
          error)
      case default
        ! PROP has been obeyed when the deck was read.
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

  !> STEP,,n: n increments of DT, each to convergence.
  subroutine run_steps(n, run, model, system, state, files, monitor, terminal, error)
    integer, intent(in) :: n !! number of end times
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(inout) :: state !! the converged state
    type(run_files_t), intent(inout) :: files !! open files
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! no convergence, trouble
    real(wp) :: begin, end_time, seconds
    integer :: k

    begin = run%position%clock
    do k = 1, n
      end_time = begin + real(k, wp)*run%increment
      if (is_passing(run%position)) then
        call pass_end_time(run%position, end_time)
        if (run%position%found) return
        cycle
      end if
      if (stop_requested()) then
        run%progress%outcome = outcome_stopped
        call raise_outcome(model, system, state, run%progress, state%time, error)
        return
      end if
      monitor%step = state%step + 1
      seconds = wall_seconds()
      call advance(model, system, state, end_time, run%settings, monitor, error)
      if (allocated(error)) return
      call pass_end_time(run%position, end_time)
      call finish_step(run%increment, seconds, model, system, state, files, monitor, terminal, &
        error)
      if (allocated(error)) return
    end do
  end subroutine run_steps

  !> Counts an end time, writes its rows and its line.
  subroutine finish_step(increment, seconds, model, system, state, files, monitor, terminal, error)
    real(wp), intent(in) :: increment !! its increment of time
    real(wp), intent(in) :: seconds !! clock at its start [s]
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(inout) :: state !! the converged state
    type(run_files_t), intent(inout) :: files !! open files
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! trouble with a file
    type(log_increment_t) :: line

    state%step = state%step + 1
    call write_row(files, model, system, state, increment, error)
    if (allocated(error)) return
    line%step = state%step
    line%increment = 1
    line%time = state%time
    line%size = increment
    line%iterations = monitor%solves - monitor%solves_before
    line%residual = norm2(system%right)
    line%seconds = wall_seconds() - seconds
    monitor%solves_before = monitor%solves
    call log_increment(files%log, line, error)
    call print_line(terminal, 'step '//to_text(state%step)//' of '//to_text(monitor%steps) &
      //'  time '//to_text(state%time)//'  '//to_text(line%iterations)//' solves  ' &
      //to_text(line%seconds, 3)//' s')
  end subroutine finish_step

  !> TIME: moves to the next end time and begins its increment.
  subroutine begin_time(last, run, model, system, state)
    real(wp), intent(in) :: last !! latest time, 0 for none
    type(run_state_t), intent(inout) :: run !! gets a pending increment
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(in) :: state !! the converged state

    run%pending_time = run%position%clock + run%increment
    if (last > 0.0_wp) run%pending_time = min(run%pending_time, last)
    call prepare(run, model, system, state)
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

  !> Marks an increment as begun; its first TANG sets it up.
  subroutine prepare(run, model, system, state)
    type(run_state_t), intent(inout) :: run !! gets a pending increment
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(in) :: state !! the converged state

    run%pending = .true.
    run%converged = .false.
    run%started = .false.
    run%progress = newton_t()
    run%augmentation = augmentation_t()
    if (.not. is_passing(run%position)) call begin_at(model, system, state, run%pending_time)
  end subroutine prepare

  !> TANG, UTAN: one Newton iteration of the pending increment; without TIME before it, one at the
  !! present time.
  subroutine run_tangent(run, model, system, state, monitor, error)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(in) :: state !! the converged state
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(error_t), allocatable, intent(out) :: error !! singular, out of memory, stopped
    integer :: changes

    if (.not. run%pending) then
      run%pending_time = run%position%clock
      call prepare(run, model, system, state)
    end if
    if (is_passing(run%position)) run%converged = .true.
    if (run%converged) return
    monitor%step = state%step + 1
    if (.not. run%started) then
      call choose_solver(model, system, monitor)
      system%x_old = model%mesh%x + state%u
      call choose_start(model, system, state, run%pending_time, monitor)
      call couple(system)
      system%contact%slip_before = 0.0_wp
      run%started = .true.
    end if
    call estimate_round_off(system, model%mesh%x)
    call iterate(system, model%mesh%x, run%pending_time, run%settings, monitor, &
      run%progress)
    if (run%progress%outcome == outcome_going_on .and. stop_requested()) then
      run%progress%outcome = outcome_stopped
    end if
    if (run%progress%outcome /= outcome_going_on) then
      call raise_outcome(model, system, state, run%progress, run%pending_time, error)
      return
    end if
    run%converged = is_converged(system, run%settings, run%progress)
    if (.not. run%converged .or. size(model%pairs) == 0) return
    if (system%condensed%active) call refresh_candidates(system)
    system%x_now = model%mesh%x + system%u
    call move_hosts(model, system, run%settings%extrapolation, changes)
    if (changes == 0) return
    run%converged = .false.
    call load_contact(model, system)
    call couple(system)
  end subroutine run_tangent

  !> Accepts the pending increment and writes its rows; one that has not converged is an error.
  subroutine close_increment(run, model, system, state, files, monitor, terminal, error)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(state_t), intent(inout) :: state !! the converged state
    type(run_files_t), intent(inout) :: files !! open files
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! not converged, trouble with a file

    if (.not. run%pending) return
    run%pending = .false.
    if (is_passing(run%position)) then
      call pass_end_time(run%position, run%pending_time)
      return
    end if
    if (.not. run%converged) then
      run%progress%outcome = outcome_open
      call raise_outcome(model, system, state, run%progress, run%pending_time, error)
      return
    end if
    call accept(model, system, state, run%pending_time)
    call pass_end_time(run%position, run%pending_time)
    call finish_step(run%increment, wall_seconds(), model, system, state, files, monitor, &
      terminal, error)
  end subroutine close_increment
end module batch_run

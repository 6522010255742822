!> Carries out the solution commands of a deck, one after the other.
module batch_run
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: wall_seconds, begin_cost, end_cost, count_cost, cost_output, cost_fields, &
    cost_flush
  use solution_settings, only: take_setting
  use newton, only: outcome_open, outcome_stopped, outcome_through, outcome_thrown, outcome_turned
  use accepted_state, only: accept
  use lost_contact, only: look_for_strays
  use parallel, only: any_rank
  use linear_solver, only: solver_of
  use back_ends, only: solver_auto
  use solver_choice, only: ask_for_solver
  use stepping, only: advance, raise_outcome
  use signals, only: stop_requested, begin_writing, end_writing
  use batch_types, only: batch_command_t
  use run_files, only: write_row
  use results_file, only: fields_due
  use rigid_paths, only: count_rigid
  use model_types, only: state_none
  use touch_report, only: keep_touches
  use run_audit, only: audit_end_time, tell_answers
  use run_log, only: log_increment, log_increment_t, log_warning
  use batch_position, only: check_increment, is_passing, pass_end_time, look_for, &
    end_times_to_pass, count_steps
  use saved_states, only: saved_states_t
  use run_monitor, only: foresee_end, tell_end_time
  use run_context, only: context_t
  use sensitivity_table, only: derivative_rows, write_sensitivities
  use result_types, only: derivative_rows_t
  use kept_slopes, only: keep_slopes
  use run_progress, only: run_state_t
  use batch_states, only: run_save, run_rest
  use batch_augment, only: run_augment
  use batch_tangent, only: prepare, run_tangent, run_form, run_back
  use printing, only: print_displacements, print_reactions, print_stresses, print_mesh
  implicit none
  private
  public :: run_batch

  !> At every so many end times the audit has displacements inside, whoever else asks for them.
  integer, parameter :: every_audit = 64

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

  !> DISP, REAC, STRE, CHEC: prints to the log.
  subroutine print_request(command, context, error)
    type(batch_command_t), intent(in) :: command !! the command
    type(context_t), target, intent(inout) :: context !! problem, accepted state, log
    type(error_t), allocatable, intent(out) :: error !! trouble with the log

    associate (model => context%model, state => context%state, log => context%files%log)
      select case (command%command)
      case ('disp')
        call print_displacements(command, model, state, log, error)
      case ('reac')
        call print_reactions(command, model, state, log, error)
      case ('stre')
        call print_stresses(command, model, context%system, state, log, error)
      case default
        if (command%option == 'uniq') call tell_answers(context, error)
        if (command%option /= 'uniq') call print_mesh(model%mesh, log, error)
      end select
    end associate
  end subroutine print_request

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
  subroutine run_steps(n, goes_on, run, context, error)
    integer, intent(in) :: n !! number of end times
    logical, intent(in) :: goes_on !! more increments follow at once
    type(run_state_t), intent(inout) :: run !! where the run stands
    type(context_t), target, intent(inout) :: context !! what the run works on
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
      if (any_rank(stop_requested())) then
        run%progress%outcome = outcome_stopped
        call raise_outcome(context%model, context%system, context%form, context%state, &
          run%progress, context%state%time, .false., error)
        return
      end if
      context%monitor%step = context%state%step + 1
      context%system%inside_due = (k == n .and. .not. goes_on) .or. &
        is_inside_due(context, context%monitor%step)
      seconds = wall_seconds()
      call advance(context%model, context%system, context%form, context%state, end_time, &
        run%settings, context%monitor, error)
      if (allocated(error)) return
      call pass_end_time(run%position, end_time)
      call finish_step(run, seconds, context, error)
      if (allocated(error)) return
    end do
  end subroutine run_steps

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
  subroutine finish_step(run, seconds, context, error)
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
    call begin_cost(context%system%costs, cost_output)
    call write_row(context%files, context%model, context%system, context%form, context%state, &
      run%increment, context%audit, derivatives, error)
    if (fields_due(context%model%output, context%state%step)) call count_cost( &
      context%system%costs, cost_fields, count([context%model%output%field, &
      context%model%output%contact]))
    context%system%costs%count(cost_flush) = context%files%results%file%flushes + &
      context%files%surfaces%file%flushes
    call end_cost(context%system%costs, cost_output)
    if (allocated(derivatives) .and. .not. allocated(error)) call write_sensitivities( &
      context%derivatives, context%state, derivatives, error)
    call end_writing()
    context%system%inside_due = .true.
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
  end subroutine finish_step

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
    call accept(context%model, context%system, context%form, context%state, run%pending_time)
    call context%monitor%accepted(context%model, context%system, context%form, context%state)
    if (.not. counts) then
      context%monitor%solves_before = context%monitor%solves
      call audit_end_time(context, run%settings, error)
      return
    end if
    call pass_end_time(run%position, run%pending_time)
    call finish_step(run, wall_seconds(), context, error)
  end subroutine close_increment
end module batch_run

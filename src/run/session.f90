!> One run from the deck to its files. In more than 400 lines, since each stage of it hands on what
!! the one before has made.
module session
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text, count_noun
  use costs, only: begin_cost, end_cost, wall_seconds, cost_reading, wall_seconds
  use blas_info, only: blas_name, is_reference_blas, set_blas_threads, start_blas
  use threads, only: set_threads, count_cores
  use version, only: program_version
  use deck_types, only: deck_t
  use deck_reader, only: read_deck
  use changed_decks, only: change_deck, refuse_changes, settings_text
  use diagnostics, only: diagnostics_t, error_count, diagnostics_to_error, note_lines, warning_lines
  use mesh_building, only: drop_rows
  use model_types, only: model_t, state_none
  use model_reader, only: read_model
  use batch_types, only: batch_command_t
  use batch_reader, only: read_batch
  use batch_checks, only: check_files, check_nodes
  use mortar_limits, only: check_mortar
  use output_checks, only: written_files, guard_files, refuse_pipes
  use system_types, only: form_t, system_t, state_t
  use system_building, only: build_system
  use ranks, only: this_rank, count_ranks
  use linear_solver, only: free_solver
  use diagnosis, only: check_supports
  use check_files, only: write_check_files
  use scene_audit, only: begin_audit
  use run_files, only: run_files_t, create_files, close_files
  use run_log, only: log_costs, log_line, log_warning
  use run_monitor, only: run_monitor_t
  use run_context, only: context_t
  use batch_run, only: run_batch
  use batch_position, only: count_steps
  use touch_report, only: tell_untouched
  use run_audit, only: tell_warnings
  use check_report, only: print_check, report_gaps
  use json_report, only: tell_start, tell_problems, tell_costs
  use saved_states, only: saved_states_t, take_state, restart_base
  use state_reader, only: read_state
  use restored_balance, only: check_time, check_balance
  use result_types, only: origin_t, saved_state_t
  use signals, only: begin_writing, end_writing
  use terminal, only: terminal_t, open_terminal, print_line, close_terminal
  use command_line, only: options_t
  use sensitivity_types, only: sensitivity_t
  use sensitivity_reader, only: read_sensitivities
  use study_types, only: study_t
  use study_reader, only: read_study
  use study_run, only: run_study, check_run
  use sensitivity_start, only: check_slopes, begin_sensitivities
  use kept_slopes, only: announce_slopes, resume_slopes
  use sensitivity_table, only: create_sensitivity_table
  use text_files, only: close_text_file
  implicit none
  private
  public :: run_session

contains

  !> One run, and what a program that reads along wants to know of its deck.
  subroutine run_session(options, error)
    type(options_t), intent(in) :: options !! the command line
    type(error_t), allocatable, intent(out) :: error !! whatever stopped the run
    type(context_t), target :: context
    type(diagnostics_t) :: diagnostics

    context%terminal = open_terminal(this_rank() > 0 .or. options%quiet, this_rank() == 0)
    context%terminal%json = this_rank() == 0 .and. options%json
    context%terminal%verbose = options%verbose
    call carry_out(options, context, diagnostics, error)
    if (context%terminal%json) call tell_problems(diagnostics)
  end subroutine run_session

  !> Reads the deck, and unless only a check is asked for, carries out its commands.
  subroutine carry_out(options, context, diagnostics, error)
    type(options_t), intent(in) :: options !! the command line
    type(context_t), target, intent(inout) :: context !! what the run works on
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's lines
    type(error_t), allocatable, intent(out) :: error !! whatever stopped the run
    type(batch_command_t), allocatable :: commands(:)
    character(:), allocatable :: deck_text
    type(study_t) :: study
    type(error_t), allocatable :: unsound

    call set_threads(options%threads)
    context%parts = options%increments
    call set_blas_threads(1)
    context%form%whole%forced = options%solver
    call begin_cost(context%form%costs, cost_reading)
    call read_problem(options, context%model, commands, deck_text, context%sensitivity, study, &
      diagnostics, error)
    if (allocated(error)) return
    if (count_ranks() > 1 .and. study%active) then
      call raise(error, exit_deck, 'error: a STUDy works on one rank, and mpirun has started '// &
        to_text(count_ranks())//new_line('a')//'  run it without mpirun')
      return
    end if
    call end_cost(context%form%costs, cost_reading)
    if (options%check) then
      call check_derivatives(context%model, context%sensitivity, diagnostics, error)
      if (.not. allocated(error)) call check_restart(options, context%model, error)
      if (allocated(error)) return
      call print_check(commands, context, unsound)
      if (this_rank() == 0) call write_check_files(base_name(options), options%folder, &
        context%model, origin_of(options, commands, deck_text, context%sensitivity%active, &
        study), error)
      if (.not. allocated(error)) call print_line(context%terminal, 'to be looked at: '// &
        base_name(options)//'.check.*')
      if (.not. allocated(error)) call move_alloc(unsound, error)
      return
    end if
    call run_problem(options, context, commands, deck_text, study, diagnostics, error)
    call close_terminal(context%terminal)
    call free_solver(context%form%whole%solver)
  end subroutine carry_out

  !> What makes the files of this run.
  function origin_of(options, commands, deck_text, derivatives, study) result(origin)
    type(options_t), intent(in) :: options !! the command line
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    character(*), intent(in) :: deck_text !! the deck as read
    logical, intent(in) :: derivatives !! derivatives along the run are asked for
    type(study_t), intent(in) :: study !! variants that are asked for
    type(origin_t) :: origin

    origin%program = 'mfec '//program_version
    origin%deck = deck_text
    origin%settings = settings_text(options)
    origin%blas = blas_name()
    origin%end_times = count_steps(commands)
    origin%derivatives = derivatives
    if (study%active) origin%varied = size(study%varied)
  end function origin_of

  !> Deck to model; every error of the deck in one report.
  subroutine read_problem(options, model, commands, deck_text, sensitivity, study, diagnostics, &
    error)
    type(options_t), intent(in) :: options !! the command line
    type(model_t), intent(out) :: model !! the problem
    type(batch_command_t), allocatable, intent(out) :: commands(:) !! the solution commands
    character(:), allocatable, intent(out) :: deck_text !! the deck as written
    type(sensitivity_t), intent(inout) :: sensitivity !! derivatives that are asked for
    type(study_t), intent(inout) :: study !! variants that are asked for
    type(diagnostics_t), intent(out) :: diagnostics !! the deck's lines, what was said of them
    type(error_t), allocatable, intent(out) :: error !! what is wrong with the deck
    type(deck_t) :: deck

    deck_text = ''
    allocate (commands(0))
    call read_deck(options%deck, options%overrides, deck, diagnostics, error)
    if (allocated(error)) return
    call change_deck(options, deck, diagnostics)
    call read_model(deck, diagnostics, model)
    call read_batch(deck, model%pairs, diagnostics, commands)
    call check_files(deck, commands, restart_base(base_name(options), options%restart), diagnostics)
    if (allocated(model%pairs)) call check_nodes(deck, commands, model%mesh, diagnostics)
    call read_sensitivities(deck, options%deck, options%overrides, options%sens, diagnostics, &
      model, sensitivity)
    call read_study(deck, options%vary, diagnostics, study)
    if (study%active .or. sensitivity%active) call refuse_changes(options, error)
    if (allocated(error)) return
    if (error_count(diagnostics) == 0) call check_mortar(model, commands, options, &
      sensitivity%active, diagnostics)
    if (study%active .and. error_count(diagnostics) == 0) call check_run(options, commands, study, &
      diagnostics, error)
    if (allocated(error)) return
    if (error_count(diagnostics) == 0 .and. (sensitivity%active .or. study%active)) &
      call refuse_pipes(diagnostics)
    if (error_count(diagnostics) == 0) call guard_files(written_files(restart_base( &
      base_name(options), options%restart), model, commands, sensitivity%active, study%active, &
      options%check), options%restart, diagnostics, error)
    if (allocated(error)) return
    if (error_count(diagnostics) > 0) then
      call diagnostics_to_error(diagnostics, error)
      return
    end if
    model%notes = note_lines(diagnostics)
    model%warnings = warning_lines(diagnostics)
    deck_text = diagnostics%source%files(1)%text
  end subroutine read_problem

  !> Builds the system, opens the files, runs the commands, closes the files whatever happens.
  subroutine run_problem(options, context, commands, deck_text, study, diagnostics, error)
    type(options_t), intent(in) :: options !! the command line
    type(context_t), target, intent(inout) :: context !! the problem; what the run works on
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    character(*), intent(in) :: deck_text !! the deck as written
    type(study_t), intent(in) :: study !! variants that are asked for
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's lines
    type(error_t), allocatable, intent(out) :: error !! whatever stopped the run
    type(error_t), allocatable :: trouble
    type(saved_states_t) :: states
    real(wp), allocatable :: variant_seconds(:)

    call start_blas(error)
    if (allocated(error)) return
    associate (model => context%model, system => context%system, form => context%form, &
      files => context%files)
      call drop_rows(model%mesh)
      call build_system(model, system, form, context%state)
      call check_slopes(model, system, context%sensitivity, diagnostics)
      call diagnostics_to_error(diagnostics, error)
      if (allocated(error)) return
      if (context%sensitivity%active) call announce_slopes(system%contact%n, context%sensitivity, &
        model)
      states%deck = deck_name(options)
      states%base = base_name(options)
      states%restart = options%restart
      if (len(options%restart) > 0) call go_on(options, model, system, form, context%state, &
        states, error)
      if (allocated(error)) return
      call begin_audit(model, system, context%state, context%audit)
      call begin_writing()
      call create_files(files, states%base, options%folder, model, system, &
        origin_of(options, commands, deck_text, context%sensitivity%active, study), error)
      call end_writing()
      if (allocated(error)) return
      files%log%level = options%log_level
      context%monitor%log => context%files%log
      context%monitor%terminal => context%terminal
      if (context%terminal%json) call tell_start(context, states%base, options%deck, commands)
      call report_start(options, states, context, error)
      if (.not. allocated(error)) call start_derivatives(options, states, context, error)
      if (.not. allocated(error)) call check_supports(model, system, form, context%monitor, error)
      context%system%whole_factors = study%active
      context%system%slopes_due = context%sensitivity%active
      if (.not. allocated(error)) call run_batch(commands, states, context, error)
      if (.not. allocated(error)) call tell_untouched(context)
      if (study%active .and. .not. allocated(error)) call run_study(options, commands, &
        states%base, study, context, variant_seconds, error)
      if (allocated(error) .and. .not. study%active) call advise_restart(states, context, error)
      if (allocated(error)) call log_line(files%log, new_line('a')//error%message, trouble)
      call log_costs(files%log, form%costs, &
        wall_seconds() - form%costs%started(cost_reading), variant_seconds, trouble)
      if (context%terminal%json) call tell_costs(context)
      call begin_writing()
      call close_files(files, form%costs, trouble)
      if (context%sensitivity%active) call close_text_file(context%derivatives%file, trouble)
      call end_writing()
    end associate
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
  end subroutine run_problem

  !> What a run can go on from, as the last line of the message that ends it.
  subroutine advise_restart(states, context, error)
    type(saved_states_t), intent(in) :: states !! where it began, its files
    type(context_t), intent(in) :: context !! the problem, the last end time
    type(error_t), intent(inout) :: error !! gets the line
    integer :: last

    last = context%state%step
    associate (output => context%model%output)
      if (error%code == exit_deck .or. output%state == state_none) return
      if (any(context%model%pairs%mortar)) return
      if (last - mod(last, max(1, output%every)) <= states%step) return
    end associate
    error%message = error%message//new_line('a')//'  to go on from the last state that is '// &
      'kept: the same command with --restart '//states%base//'.vtkhdf'
  end subroutine advise_restart

  !> Reports what derivatives do not know of the scene, which is built for it on a copy: a check
  !! builds its own.
  subroutine check_derivatives(model, sensitivity, diagnostics, error)
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: sensitivity !! derivatives that are asked for
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's lines
    type(error_t), allocatable, intent(out) :: error !! the report
    type(model_t) :: scene
    type(system_t) :: system
    type(form_t) :: form
    type(state_t) :: state

    if (.not. sensitivity%active) return
    scene = model
    call build_system(scene, system, form, state)
    call check_slopes(scene, system, sensitivity, diagnostics)
    call diagnostics_to_error(diagnostics, error)
  end subroutine check_derivatives

  !> Reports what keeps a run from going on from the state of --restart, on a copy of the scene.
  subroutine check_restart(options, model, error)
    type(options_t), intent(in) :: options !! the command line
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! no such file or state, another mesh
    type(model_t) :: scene
    type(system_t) :: system
    type(form_t) :: form
    type(state_t) :: state
    type(saved_states_t) :: states

    if (len(options%restart) == 0) return
    call start_blas(error)
    if (allocated(error)) return
    scene = model
    call drop_rows(scene%mesh)
    call build_system(scene, system, form, state)
    states%base = base_name(options)
    call go_on(options, scene, system, form, state, states, error)
    call free_solver(form%whole%solver)
  end subroutine check_restart

  !> SENSitivity: the state before the first increment, and the table.
  subroutine start_derivatives(options, states, context, error)
    type(options_t), intent(in) :: options !! the command line
    type(saved_states_t), intent(in) :: states !! name of the files, the restart
    type(context_t), target, intent(inout) :: context !! the problem; gets derivatives
    type(error_t), allocatable, intent(out) :: error !! what derivatives do not know

    if (.not. context%sensitivity%active) return
    call begin_sensitivities(context%model, context%system, context%sensitivity)
    if (states%step > 0) call resume_slopes(options%restart, &
      context%model, context%system%place, context%state, context%sensitivity, error)
    if (.not. allocated(error)) call create_sensitivity_table(context%derivatives, &
      states%base//'.sen', context%model, context%sensitivity, error)
    context%monitor%sensitivity => context%sensitivity
  end subroutine start_derivatives

  !> Logs what is worth to know before the first command: BLAS, restart, threads, gaps.
  subroutine report_start(options, states, context, error)
    type(options_t), intent(in) :: options !! the command line
    type(saved_states_t), intent(in) :: states !! the restart
    type(context_t), target, intent(inout) :: context !! problem, log and terminal
    type(error_t), allocatable, intent(out) :: error !! trouble with the log
    integer :: i

    do i = 1, size(context%model%warnings)
      call context%monitor%warning(context%model%warnings(i)%s)
    end do
    if (is_reference_blas()) call log_warning(context%files%log, 'this is the reference '// &
      'BLAS, which is 10 to 20 times slower than OpenBLAS: install libopenblas-dev', error)
    if (.not. allocated(error) .and. len(states%restart) > 0) call report_restart(states, &
      context%files, context%terminal, error)
    if (allocated(states%note)) call context%monitor%warning(states%note)
    if (options%threads > 1) call report_threads(options%threads, context%monitor)
    call report_gaps(context, .false.)
    call tell_warnings(context)
  end subroutine report_start

  !> Logs the number of threads; more than there are cores are worth a warning.
  subroutine report_threads(n, monitor)
    integer, intent(in) :: n !! threads
    type(run_monitor_t), intent(inout) :: monitor !! log and terminal

    if (n > count_cores()) then
      call monitor%warning(count_noun(n, 'thread')//' on '//count_noun(count_cores(), 'core')// &
        ' wait for each other: use --threads '//to_text(count_cores())//' at most')
    else
      call monitor%event('threads   '//to_text(n)//' of '//to_text(count_cores()))
    end if
  end subroutine report_threads

  !> --restart: takes the state of a results file.
  subroutine go_on(options, model, system, form, state, states, error)
    type(options_t), intent(in) :: options !! the command line
    type(model_t), intent(inout) :: model !! gets the contact history
    type(system_t), intent(inout) :: system !! gets the pattern of its matrix
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! becomes the state
    type(saved_states_t), intent(inout) :: states !! gets step, time and where to write
    type(error_t), allocatable, intent(out) :: error !! no such state, another mesh
    type(saved_state_t) :: saved

    call read_state(options%restart, model, options%step, saved, error)
    if (allocated(error)) return
    states%base = restart_base(states%base, options%restart)
    if (saved%step == 0) return
    call check_time(options%restart, saved, error)
    if (allocated(error)) return
    call take_state(saved, model, system, form, state)
    call check_balance(options%restart, model, system, form, state, saved, error)
    if (allocated(error)) return
    state%step = saved%step
    states%step = saved%step
    states%time = saved%time
    call move_alloc(saved%note, states%note)
  end subroutine go_on

  !> Says where a restarted run begins and where it writes.
  subroutine report_restart(states, files, terminal, error)
    type(saved_states_t), intent(in) :: states !! the restart
    type(run_files_t), intent(inout) :: files !! the log
    type(terminal_t), intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! trouble with the log
    character(:), allocatable :: line

    line = 'goes on from step '//to_text(states%step)//', time '//to_text(states%time)//' of '// &
      states%restart//'; writes '//states%base//'.*'
    if (states%step == 0) line = states%restart//' holds no state yet: begins at time 0; '// &
      'writes '//states%base//'.*'
    call print_line(terminal, line)
    call log_line(files%log, line, error)
  end subroutine report_restart

  !> Name of the deck without its folder and ending.
  function deck_name(options) result(name)
    type(options_t), intent(in) :: options !! the command line
    character(:), allocatable :: name
    integer :: dot

    name = options%deck(index(options%deck, '/', back=.true.) + 1:)
    dot = index(name, '.', back=.true.)
    if (dot > 1) name = name(:dot - 1)
  end function deck_name

  !> Path of the files without their endings: the deck's name in the output folder.
  function base_name(options) result(base)
    type(options_t), intent(in) :: options !! the command line
    character(:), allocatable :: base

    base = deck_name(options)
    if (len(options%folder) > 0) base = options%folder//'/'//base
  end function base_name
end module session

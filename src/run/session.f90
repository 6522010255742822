!> One run from the deck to its files.
module session
  use errors, only: error_t
  use text, only: string_t, to_text, count_noun
  use costs, only: begin_cost, end_cost, wall_seconds, cost_reading, wall_seconds
  use blas_info, only: blas_name, is_reference_blas
  use version, only: program_version
  use deck_types, only: deck_t
  use deck_reader, only: read_deck
  use diagnostics, only: diagnostics_t, error_count, diagnostics_to_error, note_lines
  use source, only: file_text
  use model_types, only: model_t
  use model_reader, only: read_model
  use batch_types, only: batch_command_t
  use batch_reader, only: read_batch
  use system_types, only: system_t, state_t
  use system_building, only: build_system
  use umfpack_solver, only: free_umfpack
  use diagnosis, only: check_supports
  use run_files, only: run_files_t, create_files, close_files
  use run_log, only: log_costs, log_error, log_warning
  use run_monitor, only: run_monitor_t
  use batch_run, only: run_batch, count_steps
  use terminal, only: terminal_t, open_terminal, print_line, close_terminal
  use command_line, only: options_t
  implicit none
  private
  public :: run_session

contains

  !> Reads the deck, and unless only a check is asked for, carries out its commands.
  subroutine run_session(options, error)
    type(options_t), intent(in) :: options !! the command line
    type(error_t), allocatable, intent(out) :: error !! whatever stopped the run
    type(model_t) :: model
    type(system_t) :: system
    type(batch_command_t), allocatable :: commands(:)
    character(:), allocatable :: deck_text
    type(terminal_t), target :: terminal

    terminal = open_terminal(options%quiet)
    call begin_cost(system%costs, cost_reading)
    call read_problem(options, model, commands, deck_text, error)
    if (allocated(error)) return
    call end_cost(system%costs, cost_reading)
    if (options%check) then
      call print_check(model, commands, terminal)
      return
    end if
    call run_problem(options, model, system, commands, deck_text, terminal, error)
    call close_terminal(terminal)
    call free_umfpack(system%umfpack)
  end subroutine run_session

  !> Deck to model; every error of the deck in one report.
  subroutine read_problem(options, model, commands, deck_text, error)
    type(options_t), intent(in) :: options !! the command line
    type(model_t), intent(out) :: model !! the problem
    type(batch_command_t), allocatable, intent(out) :: commands(:) !! the solution commands
    character(:), allocatable, intent(out) :: deck_text !! the deck as written
    type(error_t), allocatable, intent(out) :: error !! what is wrong with the deck
    type(deck_t) :: deck
    type(diagnostics_t) :: diagnostics

    deck_text = ''
    allocate (commands(0))
    call read_deck(options%deck, options%overrides, deck, diagnostics, error)
    if (allocated(error)) return
    call read_model(deck, diagnostics, model)
    call read_batch(deck, diagnostics, commands)
    if (error_count(diagnostics) > 0) then
      call diagnostics_to_error(diagnostics, error)
      return
    end if
    model%notes = note_lines(diagnostics)
    deck_text = file_text(diagnostics%source, 1)
  end subroutine read_problem

  !> What --check says of a deck without errors.
  subroutine print_check(model, commands, terminal)
    type(model_t), intent(in) :: model !! the problem
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(terminal_t), intent(inout) :: terminal !! standard output
    integer :: k

    call print_line(terminal, 'the deck is sound: '// &
      count_noun(count(model%mesh%defined), 'node')//', '// &
      count_noun(count(model%mesh%ix(1, :) > 0), 'element')//', '// &
      count_noun(size(model%materials), 'material')//', '// &
      count_noun(size(model%pairs), 'contact pair')//', '// &
      count_noun(count_steps(commands), 'end time'))
    do k = 1, size(model%notes)
      call print_line(terminal, model%notes(k)%s)
    end do
  end subroutine print_check

  !> Builds the system, opens the files, runs the commands, closes the files whatever happens.
  subroutine run_problem(options, model, system, commands, deck_text, terminal, error)
    type(options_t), intent(in) :: options !! the command line
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! the system
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    character(*), intent(in) :: deck_text !! the deck as written
    type(terminal_t), target, intent(inout) :: terminal !! standard output
    type(error_t), allocatable, intent(out) :: error !! whatever stopped the run
    type(state_t) :: state
    type(run_files_t), target :: files
    type(run_monitor_t) :: monitor
    type(error_t), allocatable :: trouble

    call build_system(model, system, state)
    call create_files(files, base_name(options), options%folder, model, system, deck_text, &
      'mfec '//program_version, settings_text(options), blas_name(), error)
    if (allocated(error)) return
    monitor%log => files%log
    monitor%terminal => terminal
    monitor%steps = count_steps(commands)
    if (is_reference_blas()) call log_warning(files%log, 'this is the reference BLAS, '// &
      'which is 10 to 20 times slower than OpenBLAS: install libopenblas-dev', error)
    if (.not. allocated(error)) call check_supports(model, system, monitor, error)
    if (.not. allocated(error)) call run_batch(commands, model, system, state, files, monitor, &
      terminal, error)
    if (allocated(error)) call log_error(files%log, error%message, trouble)
    call log_costs(files%log, system%costs, &
      wall_seconds() - system%costs%started(cost_reading), trouble)
    call close_files(files, system, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
  end subroutine run_problem

  !> Path of the files without their endings: the deck's name in the output folder.
  function base_name(options) result(base)
    type(options_t), intent(in) :: options !! the command line
    character(:), allocatable :: base
    integer :: dot

    base = options%deck(index(options%deck, '/', back=.true.) + 1:)
    dot = index(base, '.', back=.true.)
    if (dot > 1) base = base(:dot - 1)
    if (len(options%folder) > 0) base = options%folder//'/'//base
  end function base_name

  !> Deck and --set, for the log and the results.
  function settings_text(options) result(t)
    type(options_t), intent(in) :: options !! the command line
    character(:), allocatable :: t
    integer :: k

    t = options%deck
    do k = 1, size(options%overrides)
      t = t//' --set '//options%overrides(k)%name//'='//options%overrides(k)%value
    end do
  end function settings_text
end module session

!> The command line: `./mfec deck.inp [--set name=value]... [--out DIR] ...`.
module command_line
  use kinds, only: wp
  use text, only: edit_distance, to_text, count_noun
  use threads, only: count_cores
  use deck_types, only: override_t
  use errors, only: error_t, raise, exit_deck
  use results_names, only: find_results
  use linear_solver, only: solver_of, solver_list, refusal
  use back_ends, only: solver_unknown
  use run_log, only: log_normal, log_level
  implicit none
  private
  public :: options_t, read_command_line

  character(*), parameter :: usage_line = &
    'usage: mfec deck.inp [--set name=value]... [--out DIR] [--check] [--solver S] '// &
    '[--threads N] [--restart run.vtkhdf [--step K]] [--sens NAME,NAME] '// &
    '[--vary NAME=VALUES]... [--mesh FILE] [--increments N] [--penalty-factor F] '// &
    '[--log LEVEL] [--quiet] [--verbose] [--json]'

  !> An interval between end times is still cut where Newton's method wants it: sixteen times.
  integer, parameter :: most_increments = 64

  !> All options this version knows, for hints.
  character(16), parameter :: known_options(20) = [character(16) :: '--set', '--out', '--check', &
    '--solver', '--threads', '--restart', '--step', '--sens', '--vary', '--mesh', &
    '--increments', '--penalty-factor', '--log', '--quiet', &
    '--verbose', '-v', '--json', '--version', '--help', '-h']

  !> What the command line asks for.
  type :: options_t
    character(:), allocatable :: deck !! path of the deck
    character(:), allocatable :: folder !! where files are written; empty: the working directory
    character(:), allocatable :: topic !! keyword of --help, empty for all
    character(:), allocatable :: sens !! parameters to differentiate by, parted by commas
    character(:), allocatable :: vary !! parameters of a study with their values, parted by blanks
    character(:), allocatable :: restart !! results file to go on from, empty for none
    character(:), allocatable :: mesh !! mesh file in place of the deck's mesh, empty for none
    real(wp) :: penalty_factor = 1.0_wp !! times the penalty of each pair
    integer :: increments = 1 !! of an interval between end times
    integer :: threads = 1 !! threads of the program
    integer :: solver = solver_unknown !! back end, unknown to leave it to the deck
    integer :: log_level = log_normal !! how much the log tells
    integer :: step = 0 !! end time in that file, 0 for the last
    type(override_t), allocatable :: overrides(:) !! parameters of --set
    logical :: check = .false. !! read and report only
    logical :: quiet = .false. !! nothing on standard output
    logical :: verbose = .false. !! lines of the log on standard output, too
    logical :: json = .false. !! standard output is for a program
    logical :: version = .false. !! print the version
    logical :: help = .false. !! print help
  end type options_t

contains

  !> Reads and checks the arguments of the program.
  subroutine read_command_line(options, error)
    type(options_t), intent(out) :: options !! what is asked for
    type(error_t), allocatable, intent(out) :: error !! unknown or incomplete option
    character(:), allocatable :: item
    integer :: i

    options%deck = ''
    options%folder = ''
    options%topic = ''
    options%restart = ''
    options%sens = ''
    options%vary = ''
    options%mesh = ''
    allocate (options%overrides(0))
    ! First of all, so that what is wrong with the others is told as it wants it.
    do i = 1, command_argument_count()
      options%json = argument(i) == '--json' .or. options%json
    end do
    i = 1
    do while (i <= command_argument_count())
      item = argument(i)
      if (index(item, '-') == 1 .and. len(item) > 1) then
        call read_option(item, i, options, error)
      else if (len(options%deck) == 0) then
        options%deck = item
      else
        call raise(error, exit_deck, 'command line: error: a second deck, '//item// &
          new_line('a')//'  run one deck at a time; '//usage_line)
      end if
      if (allocated(error)) return
      i = i + 1
    end do
    if (options%step > 0 .and. len(options%restart) == 0) then
      call raise(error, exit_deck, 'command line: error: --step without --restart'// &
        new_line('a')//'  write --restart run.vtkhdf --step K')
      return
    end if
    if (len(options%deck) > 0 .or. options%version .or. options%help) return
    call raise(error, exit_deck, 'command line: error: no deck'//new_line('a')//'  '//usage_line)
  end subroutine read_command_line

  !> Reads one option and its value; both `--name value` and `--name=value` are taken.
  subroutine read_option(item, i, options, error)
    character(*), intent(in) :: item !! the option as written
    integer, intent(inout) :: i !! its place; moved on if it takes the next argument
    type(options_t), intent(inout) :: options !! what is asked for
    type(error_t), allocatable, intent(out) :: error !! unknown or incomplete
    character(:), allocatable :: name, value
    integer :: equals

    equals = index(item, '=')
    name = item
    if (equals > 0) name = item(:equals - 1)
    if (equals > 0 .and. any(name == [character(9) :: '--check', '--quiet', '--version', &
      '--verbose', '-v', '--json'])) then
      call raise(error, exit_deck, 'command line: error: '//item//new_line('a')//'  '//name// &
        ' takes no value')
      return
    end if
    select case (name)
    case ('--check')
      options%check = .true.
    case ('--quiet')
      options%quiet = .true.
    case ('--verbose', '-v')
      options%verbose = .true.
    case ('--json') ! read before
    case ('--version')
      options%version = .true.
    case ('--help', '-h')
      options%help = .true.
      if (equals > 0) then
        options%topic = item(equals + 1:)
      else if (i < command_argument_count()) then
        if (index(argument(i + 1), '--') /= 1) then
          i = i + 1
          options%topic = argument(i)
        end if
      end if
    case ('--set', '--out', '--solver', '--threads', '--restart', '--step', '--sens', &
          '--vary', '--log', '--mesh', '--increments', '--penalty-factor')
      call take_value(item, equals, i, value, error)
      if (allocated(error)) return
      call keep_value(name, value, options, error)
    case default
      call raise(error, exit_deck, 'command line: error: unknown option '//name// &
        new_line('a')//'  did you mean '//nearest_option(name)//'? '//usage_line)
    end select
  end subroutine read_option

  !> The value of an option: behind its `=`, or the next argument.
  subroutine take_value(item, equals, i, value, error)
    character(*), intent(in) :: item !! the option as written
    integer, intent(in) :: equals !! place of its `=`, 0 for none
    integer, intent(inout) :: i !! its place; moved on if the next argument is taken
    character(:), allocatable, intent(out) :: value !! the value
    type(error_t), allocatable, intent(out) :: error !! there is none

    value = ''
    if (equals > 0) then
      value = item(equals + 1:)
    else if (i < command_argument_count()) then
      i = i + 1
      value = argument(i)
    end if
    if (len(value) == 0) then
      call raise(error, exit_deck, 'command line: error: '//item//' wants a value'// &
        new_line('a')//'  '//usage_line)
    end if
  end subroutine take_value

  !> Enters the value of an option.
  subroutine keep_value(name, value, options, error)
    character(*), intent(in) :: name !! the option
    character(*), intent(in) :: value !! its value
    type(options_t), intent(inout) :: options !! what is asked for
    type(error_t), allocatable, intent(out) :: error !! --set without =, no such step or solver
    type(override_t), allocatable :: longer(:)
    integer :: equals, n

    if (name == '--out') options%folder = value
    if (name == '--restart') options%restart = find_results(value)
    if (name == '--sens') options%sens = value
    if (name == '--vary') options%vary = trim(adjustl(options%vary//' '//value))
    if (name == '--mesh') options%mesh = value
    if (name == '--penalty-factor') call take_factor(value, options%penalty_factor, error)
    if (name == '--increments') call take_increments(value, options%increments, error)
    if (name == '--step') call take_count(value, 'number of an output time, 1 or more; without '// &
      'it the last one is taken', name, options%step, error)
    if (name == '--threads') call take_count(value, 'number of threads, 1 or more', name, &
      options%threads, error)
    if (name == '--threads' .and. .not. allocated(error)) call check_threads(options%threads, error)
    if (name == '--solver') call take_solver(value, options%solver, error)
    if (name == '--log') then
      options%log_level = log_level(value)
      if (options%log_level == 0) call raise(error, exit_deck, 'command line: error: --log '// &
        value//new_line('a')//'  use --log brief, --log normal or --log full')
    end if
    if (allocated(error)) return
    if (name /= '--set') return
    equals = index(value, '=')
    if (equals < 2 .or. equals == len(value)) then
      call raise(error, exit_deck, 'command line: error: --set '//value//new_line('a')// &
        '  write --set name=value')
      return
    end if
    n = size(options%overrides)
    allocate (longer(n + 1))
    longer(1:n) = options%overrides
    longer(n + 1)%name = value(:equals - 1)
    longer(n + 1)%value = value(equals + 1:)
    call move_alloc(longer, options%overrides)
  end subroutine keep_value

  !> Enters the value of an option that counts from 1.
  subroutine take_count(value, wanted, name, n, error)
    character(*), intent(in) :: value !! as written
    character(*), intent(in) :: wanted !! what it should be
    character(*), intent(in) :: name !! the option
    integer, intent(inout) :: n !! its number
    type(error_t), allocatable, intent(out) :: error !! no such number
    integer :: status

    status = 1
    if (len(value) > 0 .and. len(value) < 10 .and. verify(value, '0123456789') == 0) then
      read (value, *, iostat=status) n
    end if
    if (status == 0 .and. n > 0) return
    call raise(error, exit_deck, 'command line: error: '//name//' '//value//new_line('a')// &
      '  '//name//' wants the '//wanted)
  end subroutine take_count

  !> Intervals between end times are cut into halves, so that a failed increment can be, too.
  subroutine take_increments(value, n, error)
    character(*), intent(in) :: value !! as written
    integer, intent(inout) :: n !! increments of an interval
    type(error_t), allocatable, intent(out) :: error !! no power of 2, or too many
    character(*), parameter :: wanted = 'number of increments of each interval between output '// &
      'times: 1, 2, 4, ... 64'

    call take_count(value, wanted, '--increments', n, error)
    if (allocated(error)) return
    if (popcnt(n) == 1 .and. n <= most_increments) return
    call raise(error, exit_deck, 'command line: error: --increments '//value//new_line('a')// &
      '  --increments wants the '//wanted)
  end subroutine take_increments

  !> Enters a factor above 0.
  subroutine take_factor(value, factor, error)
    character(*), intent(in) :: value !! as written
    real(wp), intent(inout) :: factor !! the factor
    type(error_t), allocatable, intent(out) :: error !! no such number
    real(wp) :: number
    integer :: status

    read (value, *, iostat=status) number
    if (status == 0 .and. verify(value, '0123456789.eEdD+-') == 0) then
      if (number > 0.0_wp .and. number <= huge(number)) then
        factor = number
        return
      end if
    end if
    call raise(error, exit_deck, 'command line: error: --penalty-factor '//value//new_line('a')// &
      '  --penalty-factor wants a number above 0')
  end subroutine take_factor

  !> More threads than cores wait for each other; so many that no machine has the cores are a slip,
  !! and the runtime does not survive the stack that it takes for them.
  subroutine check_threads(n, error)
    integer, intent(in) :: n !! threads that are asked for
    type(error_t), allocatable, intent(out) :: error !! too many
    integer, parameter :: sane = 1024

    if (n <= max(sane, count_cores())) return
    call raise(error, exit_deck, 'command line: error: --threads '//to_text(n)//new_line('a')// &
      '  this machine has '//count_noun(count_cores(), 'core')//': use --threads '// &
      to_text(count_cores())//' at most')
  end subroutine check_threads

  !> The back end of --solver; the first four letters count, as in the deck.
  subroutine take_solver(value, solver, error)
    character(*), intent(in) :: value !! what --solver asks for
    integer, intent(out) :: solver !! the back end
    type(error_t), allocatable, intent(out) :: error !! unknown
    character(:), allocatable :: obstacle

    solver = solver_of(value)
    if (solver == solver_unknown) call raise(error, exit_deck, &
      'command line: error: unknown solver '//value//new_line('a')// &
      '  use --solver '//solver_list(', ', ' or '))
    if (allocated(error)) return
    obstacle = refusal(solver)
    if (len(obstacle) > 0) call raise(error, exit_deck, 'command line: error: --solver '//value// &
      ': '//obstacle)
  end subroutine take_solver

  !> The known option that looks most like a word.
  function nearest_option(name) result(best)
    character(*), intent(in) :: name !! an unknown option
    character(:), allocatable :: best
    integer :: k, distance, least

    least = huge(least)
    do k = 1, size(known_options)
      distance = edit_distance(name, trim(known_options(k)))
      if (distance >= least) cycle
      least = distance
      best = trim(known_options(k))
    end do
  end function nearest_option

  !> One argument of the program.
  function argument(i) result(t)
    integer, intent(in) :: i !! its number
    character(:), allocatable :: t
    integer :: length

    call get_command_argument(i, length=length)
    allocate (character(length) :: t)
    call get_command_argument(i, t)
  end function argument
end module command_line

!> Turns the solution commands of the deck into a checked list.
module batch_reader
  use kinds, only: wp
  use text, only: lower, to_text
  use deck_types, only: deck_t, data_set_t, item_word, item_quoted
  use records, only: item_count, is_word, four_letters
  use source, only: source_t, source_line
  use diagnostics, only: diagnostics_t, report_error, report_note
  use contact_types, only: pair_t
  use contact_parameters, only: is_round_off
  use linear_solver, only: solver_of, refusal
  use batch_types, only: batch_command_t
  implicit none
  private
  public :: read_batch

  !> End times that the tables' column of steps has room for.
  integer, parameter :: most_end_times = 99999999

contains

  !> Reads all solution commands; the list is complete even if some of them are wrong.
  subroutine read_batch(deck, pairs, diagnostics, commands)
    type(deck_t), intent(in) :: deck !! the deck
    type(pair_t), allocatable, intent(in) :: pairs(:) !! its contact pairs; none if it has errors
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(batch_command_t), allocatable, intent(out) :: commands(:) !! the commands
    integer :: i
    logical :: has_increment, has_state

    allocate (commands(size(deck%batch)))
    has_increment = has_errors(diagnostics)
    has_state = has_increment
    do i = 1, size(commands)
      commands(i) = command_of(deck%batch(i))
      if (commands(i)%command == 'solv') call check_solver(commands(i), diagnostics)
      call check_command(commands(i), has_increment, has_state, diagnostics)
      if (commands(i)%command == 'augm' .and. .not. has_multipliers(deck)) call report_error( &
        diagnostics, commands(i)%at, 'no contact pair has multipliers to update', &
        'write AUGMent into a PAIR of CONTact')
    end do
    if (allocated(pairs)) then
      call check_tangents(pairs, commands, diagnostics)
      call check_updates(pairs, commands, diagnostics)
    end if
    call pair_loops(commands)
    call mark_solves(commands)
    call check_order(commands, has_errors(diagnostics), diagnostics)
  end subroutine read_batch

  !> SOLVer with one that this program has.
  subroutine check_solver(command, diagnostics)
    type(batch_command_t), intent(in) :: command !! a SOLVer
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: text
    integer :: cut

    text = refusal(solver_of(command%option))
    cut = index(text, new_line('a'))
    if (cut > 0) call report_error(diagnostics, command%at, text(:cut - 1), trim(adjustl( &
      text(cut + 1:))))
  end subroutine check_solver

  !> Which commands make an iteration: SOLV without the name of a solver, and TANG, unless a SOLV
  !! stands in the deck and TANG does not say 1.
  pure subroutine mark_solves(commands)
    type(batch_command_t), intent(inout) :: commands(:) !! the commands
    logical :: apart
    integer :: i

    apart = .false.
    do i = 1, size(commands)
      if (commands(i)%command /= 'solv') cycle
      commands(i)%solves = commands(i)%option == '' .or. commands(i)%option == 'line'
      apart = apart .or. commands(i)%solves
    end do
    do i = 1, size(commands)
      if (commands(i)%command /= 'tang' .and. commands(i)%command /= 'utan') cycle
      commands(i)%solves = commands(i)%v(1) > 0.0_wp .or. .not. apart
    end do
  end subroutine mark_solves

  !> SOLV wants the tangent of a TANG and the residual of a FORM; BACK wants an increment that is
  !! not accepted yet.
  subroutine check_order(commands, unsure, diagnostics)
    type(batch_command_t), intent(in) :: commands(:) !! the commands, in the order of the deck
    logical, intent(in) :: unsure !! commands may be missing
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i
    logical :: tangent, residual, pending

    if (unsure) return
    tangent = .false.
    residual = .false.
    pending = .false.
    do i = 1, size(commands)
      select case (commands(i)%command)
      case ('time')
        pending = .true.
      case ('tang', 'utan')
        tangent = .true.
        pending = .true.
      case ('form')
        residual = .true.
        pending = .true.
      case ('solv')
        if (.not. commands(i)%solves) cycle
        if (.not. tangent) call report_error(diagnostics, commands(i)%at, &
          'SOLV without a tangent', 'write TANG before it; SOLVer AUTO chooses a solver')
        if (tangent .and. .not. residual) call report_error(diagnostics, commands(i)%at, &
          'SOLV without a residual', 'write FORM before it')
      case ('back')
        if (.not. pending) call report_error(diagnostics, commands(i)%at, &
          'BACK without an increment to give up', 'it stands behind TIME and TANG, before the '// &
          'next TIME, STEP, DISP or SAVE accepts the increment')
        pending = .false.
      case ('step', 'save', 'rest', 'disp', 'reac', 'stre', 'chec')
        pending = .false.
      case default
        cycle
      end select
    end do
  end subroutine check_order

  !> TANG uses the penalty as it is: between bodies that deform it may be all round-off.
  subroutine check_tangents(pairs, commands, diagnostics)
    type(pair_t), intent(in) :: pairs(:) !! the contact pairs, penalties set
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i, k

    do k = 1, size(pairs)
      if (pairs(k)%points%n_slaves > 1 .or. .not. is_round_off(pairs(k))) cycle
      do i = 1, size(commands)
        if (commands(i)%command /= 'tang' .and. commands(i)%command /= 'utan') cycle
        call report_note(diagnostics, commands(i)%at, 'TANG takes the penalty as it is, '// &
          'and the '//to_text(pairs(k)%points%relative, 3)//' E/h of pair '//pairs(k)%name// &
          ' make forces of the round-off of a gap between bodies that yield: '// &
          'STEP,,n helps it by multipliers')
        return
      end do
    end do
  end subroutine check_tangents

  !> Between TIME and the next one multipliers move by AUGM alone.
  subroutine check_updates(pairs, commands, diagnostics)
    type(pair_t), intent(in) :: pairs(:) !! the contact pairs
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i, k

    if (any(commands%command == 'augm')) return
    k = findloc(pairs%augmented, .true., 1)
    if (k == 0) return
    do i = 1, size(commands)
      if (commands(i)%command /= 'tang' .and. commands(i)%command /= 'utan') cycle
      call report_note(diagnostics, commands(i)%at, 'no AUGM behind TANG: the multipliers of '// &
        'pair '//pairs(k)%name//' stay as they are, and it penetrates as without AUGMent')
      return
    end do
  end subroutine check_updates

  !> Whether solution commands may be missing, because there is an error behind BATCh, or in a file
  !! that may be included there.
  logical function has_errors(diagnostics)
    type(diagnostics_t), intent(in) :: diagnostics !! the deck's errors
    integer :: i, first
    logical :: including

    has_errors = .false.
    if (diagnostics%kept == 0) return
    call find_batch(diagnostics%source, first, including)
    do i = 1, diagnostics%kept
      associate (at => diagnostics%messages(i)%at)
        has_errors = has_errors .or. at%file == 1 .and. at%line > first .or. including .and. &
          at%file > 1
      end associate
    end do
  end function has_errors

  !> The line of the main file at which BATCh stands, 0 if it stands in another one.
  subroutine find_batch(source, first, including)
    type(source_t), intent(in) :: source !! the deck's files
    integer, intent(out) :: first !! the line
    logical, intent(out) :: including !! an INCLude follows, or BATCh stands in one
    character(4) :: word
    integer :: i

    first = 0
    including = .true.
    if (source%count == 0) return
    do i = 1, source%files(1)%lines
      word = four_letters(adjustl(source_line(source, 1, i)//'    '))
      if (first == 0 .and. (word == 'batc' .or. word == 'macr')) then
        first = i
        including = .false.
      else if (first > 0) then
        including = including .or. word == 'incl'
      end if
    end do
  end subroutine find_batch

  !> A contact pair of the deck has AUGMent.
  pure logical function has_multipliers(deck) result(yes)
    type(deck_t), intent(in) :: deck !! the deck
    integer :: i, k

    yes = .false.
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'cont') cycle
      do k = 1, deck%mesh(i)%count
        yes = yes .or. is_word(deck%mesh(i)%records(k)%items(1), 'augment')
      end do
    end do
  end function has_multipliers

  !> The fields of one command.
  pure function command_of(set) result(command)
    type(data_set_t), intent(in) :: set !! the command
    type(batch_command_t) :: command
    integer :: i

    command%command = set%command
    command%at = set%head%at
    command%text = ''
    if (item_count(set%head) > 1) then
      associate (item => set%head%items(2))
        if (item%kind == item_word .or. item%kind == item_quoted) then
          command%option = lower(item%text)
          command%text = item%text
        end if
      end associate
    end if
    do i = 1, min(3, item_count(set%head) - 2)
      command%v(i) = set%head%items(i + 2)%value
    end do
  end function command_of

  !> Time can advance only when DT has been given, and a state be saved only when there is one.
  subroutine check_command(command, has_increment, has_state, diagnostics)
    type(batch_command_t), intent(in) :: command !! the command
    logical, intent(inout) :: has_increment !! a DT stands before
    logical, intent(inout) :: has_state !! something that makes a state stands before
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    select case (command%command)
    case ('dt')
      has_increment = .true.
    case ('tang', 'utan', 'form', 'rest')
      has_state = .true.
    case ('save')
      if (.not. has_state) call report_error(diagnostics, command%at, &
        'SAVE before the first output time', 'write it behind STEP, or behind TIME and TANG')
    case ('step', 'time')
      has_state = .true.
      if (command%command == 'step' .and. command%v(1) > real(most_end_times, wp)) &
        call report_error( &
        diagnostics, command%at, 'STEP of '//to_text(nint(command%v(1)))//' output times', &
        'the tables number up to '//to_text(most_end_times)//' of them: raise DT')
      if (has_increment) return
      call report_error(diagnostics, command%at, 'no time increment has been given', &
        'write DT,, and a value before it')
    case default
      return
    end select
  end subroutine check_command

  !> Finds the NEXT of each LOOP; that they match has been checked by the reader of the deck.
  pure subroutine pair_loops(commands)
    type(batch_command_t), intent(inout) :: commands(:) !! the commands
    integer, allocatable :: started(:)
    integer :: i, depth

    allocate (started(size(commands)))
    depth = 0
    do i = 1, size(commands)
      if (commands(i)%command == 'loop') then
        depth = depth + 1
        started(depth) = i
      else if (commands(i)%command == 'next') then
        if (depth == 0) cycle
        commands(i)%partner = started(depth)
        commands(started(depth))%partner = i
        depth = depth - 1
      end if
    end do
  end subroutine pair_loops
end module batch_reader

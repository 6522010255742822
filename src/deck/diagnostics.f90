!> Gathers all that is wrong with a deck, so that one report can name it all.
module diagnostics
  use errors, only: error_t, raise, exit_deck
  use text, only: string_t, to_text
  use deck_types, only: location_t
  use source, only: source_t, source_line, file_name
  implicit none
  private
  public :: diagnostics_t, message_t, problem_t, report_error, report_note, report_warning, &
    error_count, diagnostics_to_error, list_problems, note_lines, warning_lines, printable

  !> Errors that one report shows.
  integer, parameter :: most_errors_shown = 20
  !> Errors that are kept; more are only counted.
  integer, parameter :: most_kept = 5000
  !> Columns of a source line that are shown.
  integer, parameter :: shown_width = 160

  !> One error or note.
  type :: message_t
    type(location_t) :: at !! where
    character(:), allocatable :: what !! what is wrong
    character(:), allocatable :: remedy !! what would be right
  end type message_t

  !> One error with its place in words.
  type :: problem_t
    character(:), allocatable :: file !! name of the file, `command line`
    integer :: line = 0 !! line, 0 for none
    integer :: column = 0 !! column, 0 for none
    character(:), allocatable :: what !! what is wrong
    character(:), allocatable :: text !! the line
    character(:), allocatable :: remedy !! what would be right
  end type problem_t

  !> The source, and all that was found to be wrong or worth a remark in it.
  type :: diagnostics_t
    type(source_t) :: source !! all files read
    integer :: errors = 0 !! number of errors, kept or not
    type(message_t), allocatable :: messages(:) !! errors (may be larger than kept)
    integer :: kept = 0 !! errors in messages
    type(message_t), allocatable :: notes(:) !! remarks for the log (may be larger than n_notes)
    integer :: n_notes = 0 !! remarks in notes
    type(message_t), allocatable :: warnings(:) !! for log and terminal (may be larger)
    integer :: n_warnings = 0 !! how many
  end type diagnostics_t

contains

  !> Notes an error, once: what several readers look up is found more than once.
  subroutine report_error(diagnostics, at, what, remedy)
    type(diagnostics_t), intent(inout) :: diagnostics !! where it is gathered
    type(location_t), intent(in) :: at !! file, line, column; file 0 is the command line
    character(*), intent(in) :: what !! what is wrong
    character(*), intent(in) :: remedy !! what would be right

    if (is_known(diagnostics, at, what)) return
    diagnostics%errors = diagnostics%errors + 1
    if (diagnostics%kept >= most_kept) return
    call append(diagnostics%messages, diagnostics%kept, at, what, remedy)
  end subroutine report_error

  !> True if the same has been said of this place.
  pure logical function is_known(diagnostics, at, what) result(known)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    type(location_t), intent(in) :: at !! file, line, column
    character(*), intent(in) :: what !! what is wrong
    integer :: i

    known = .false.
    do i = 1, diagnostics%kept
      associate (other => diagnostics%messages(i))
        if (other%at%line /= at%line .or. other%at%column /= at%column) cycle
        if (other%at%file /= at%file .or. at%file == 0) cycle
        known = other%what == what
        if (known) return
      end associate
    end do
  end function is_known

  !> Notes a remark that goes to the log.
  subroutine report_note(diagnostics, at, what)
    type(diagnostics_t), intent(inout) :: diagnostics !! where it is gathered
    type(location_t), intent(in) :: at !! file, line, column
    character(*), intent(in) :: what !! the remark

    call append(diagnostics%notes, diagnostics%n_notes, at, what, '')
  end subroutine report_note

  !> Notes what deserves a look: it goes to the log and to the terminal.
  subroutine report_warning(diagnostics, at, what)
    type(diagnostics_t), intent(inout) :: diagnostics !! where it is gathered
    type(location_t), intent(in) :: at !! file, line, column
    character(*), intent(in) :: what !! the warning

    call append(diagnostics%warnings, diagnostics%n_warnings, at, what, '')
  end subroutine report_warning

  !> Appends a message to a list that grows by doubling.
  subroutine append(messages, count, at, what, remedy)
    type(message_t), allocatable, intent(inout) :: messages(:) !! the list
    integer, intent(inout) :: count !! messages in it
    type(location_t), intent(in) :: at !! file, line, column
    character(*), intent(in) :: what !! what is wrong
    character(*), intent(in) :: remedy !! what would be right
    type(message_t), allocatable :: more(:)
    integer :: i

    if (.not. allocated(messages)) allocate (messages(16))
    if (count == size(messages)) then
      allocate (more(2*count))
      do i = 1, count
        more(i)%at = messages(i)%at
        call move_alloc(messages(i)%what, more(i)%what)
        call move_alloc(messages(i)%remedy, more(i)%remedy)
      end do
      call move_alloc(more, messages)
    end if
    count = count + 1
    messages(count)%at = at
    messages(count)%what = what
    messages(count)%remedy = remedy
  end subroutine append

  !> Number of errors so far.
  pure integer function error_count(diagnostics) result(n)
    type(diagnostics_t), intent(in) :: diagnostics !! where they are gathered

    n = diagnostics%errors
  end function error_count

  !> Makes the one report of all errors, in the order of files and lines; nothing if there is none.
  subroutine diagnostics_to_error(diagnostics, error)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    type(error_t), allocatable, intent(out) :: error !! the report
    character(:), allocatable :: report
    integer, allocatable :: order(:)
    integer :: i

    if (diagnostics%errors == 0) return
    allocate (order(diagnostics%kept))
    order(:) = reading_order(diagnostics)
    report = ''
    do i = 1, min(most_errors_shown, size(order))
      if (i > 1) report = report//new_line('a')
      report = report//message_text(diagnostics, diagnostics%messages(order(i)))
    end do
    if (diagnostics%errors > most_errors_shown) report = report//new_line('a')//'... and '// &
      to_text(diagnostics%errors - most_errors_shown)//' more'
    call raise(error, exit_deck, report)
  end subroutine diagnostics_to_error

  !> The errors that are kept, in the order of files and lines.
  subroutine list_problems(diagnostics, problems)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    type(problem_t), allocatable, intent(out) :: problems(:) !! the errors
    integer :: order(diagnostics%kept), i

    order = reading_order(diagnostics)
    allocate (problems(diagnostics%kept))
    do i = 1, diagnostics%kept
      associate (message => diagnostics%messages(order(i)))
        problems(i)%file = printable(file_name(diagnostics%source, message%at%file))
        problems(i)%what = printable(message%what)
        problems(i)%remedy = printable(message%remedy)
        problems(i)%text = ''
        if (message%at%file == 0) cycle
        problems(i)%line = message%at%line
        problems(i)%column = message%at%column
        problems(i)%text = printable(source_line(diagnostics%source, message%at%file, &
          message%at%line))
      end associate
    end do
  end subroutine list_problems

  !> Numbers of the messages sorted by file, line and column (stable merge by insertion).
  function reading_order(diagnostics) result(order)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    integer :: order(diagnostics%kept)
    integer :: i, j, moved

    do i = 1, diagnostics%kept
      order(i) = i
    end do
    do i = 2, diagnostics%kept
      moved = order(i)
      j = i - 1
      do while (j >= 1)
        if (.not. before(diagnostics%messages(moved)%at, diagnostics%messages(order(j))%at)) exit
        order(j + 1) = order(j)
        j = j - 1
      end do
      order(j + 1) = moved
    end do
  end function reading_order

  !> Whether `a` stands before `b`.
  pure logical function before(a, b)
    type(location_t), intent(in) :: a !! one place
    type(location_t), intent(in) :: b !! another place

    if (a%file /= b%file) then
      before = a%file < b%file
    else if (a%line /= b%line) then
      before = a%line < b%line
    else
      before = a%column < b%column
    end if
  end function before

  !> One error as text: place, what, the line, a caret, the remedy.
  function message_text(diagnostics, message) result(t)
    type(diagnostics_t), intent(in) :: diagnostics !! holds the source
    type(message_t), intent(in) :: message !! the error
    character(:), allocatable :: t

    t = place_text(diagnostics, message%at)//': error: '//printable(message%what)
    if (message%at%file > 0) t = t//new_line('a')//excerpt( &
      source_line(diagnostics%source, message%at%file, message%at%line), message%at%column)
    if (len(message%remedy) > 0) t = t//new_line('a')//'  '//printable(message%remedy)
  end function message_text

  !> A place as file:line:column.
  function place_text(diagnostics, at) result(t)
    type(diagnostics_t), intent(in) :: diagnostics !! holds the names of the files
    type(location_t), intent(in) :: at !! the place
    character(:), allocatable :: t

    t = printable(file_name(diagnostics%source, at%file))
    if (at%file > 0) t = t//':'//to_text(at%line)//':'//to_text(at%column)
  end function place_text

  !> A source line and, below it, a caret; a long line is shown around the caret only.
  function excerpt(line, column) result(t)
    character(*), intent(in) :: line !! the line as read
    integer, intent(in) :: column !! column of the caret, may be beyond the line
    character(:), allocatable :: t, shown, below
    integer :: first, last, i, code

    first = 1
    if (len(line) > shown_width .and. column > shown_width/2) first = column - shown_width/2
    last = min(len(line), first + shown_width - 1)
    first = min(first, last + 1)
    shown = printable(line(first:last))
    below = ''
    do i = 1, column - first
      if (i > len(shown)) then
        if (i <= max(last - first + 1, 1) + 2) below = below//' '
        cycle
      end if
      code = iachar(shown(i:i))
      if (shown(i:i) == achar(9)) then
        below = below//achar(9)
      else if (code < 128 .or. code > 191) then
        below = below//' '
      end if
    end do
    t = shown//new_line('a')//below//'^'
  end function excerpt

  !> Text that a terminal can show: control characters and broken UTF-8 become question marks.
  pure function printable(s) result(t)
    character(*), intent(in) :: s !! any bytes
    character(len(s)) :: t
    integer :: i, code, more, length

    t = s
    i = 1
    do while (i <= len(s))
      code = ichar(s(i:i))
      more = merge(1, 0, code >= 194) + merge(1, 0, code >= 224) + merge(1, 0, code >= 240)
      length = 1
      if (code < 32 .and. code /= 9 .and. code /= 10 .or. code == 127) then
        t(i:i) = '?'
      else if (code >= 128) then
        if (valid_sequence(s(i:), more)) then
          length = 1 + more
        else
          t(i:i) = '?'
        end if
      end if
      i = i + length
    end do
  end function printable

  !> Whether `s` starts with a UTF-8 character of one leading and `more` further bytes.
  pure logical function valid_sequence(s, more) result(valid)
    character(*), intent(in) :: s !! text from the leading byte on
    integer, intent(in) :: more !! bytes that must follow, 0 if the first is no leading byte
    integer :: i, code(4)

    valid = more > 0 .and. more < len(s)
    if (.not. valid) return
    code = 0
    do i = 1, more + 1
      code(i) = ichar(s(i:i))
      if (i > 1 .and. (code(i) < 128 .or. code(i) > 191)) valid = .false.
    end do
    ! overlong forms, surrogates and numbers beyond U+10FFFF
    if (code(1) == 224 .and. code(2) < 160) valid = .false.
    if (code(1) == 237 .and. code(2) > 159) valid = .false.
    if (code(1) == 240 .and. code(2) < 144) valid = .false.
    if (code(1) > 244 .or. code(1) == 244 .and. code(2) > 143) valid = .false.
  end function valid_sequence

  !> The remarks, ready for the log.
  function note_lines(diagnostics) result(lines)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    type(string_t), allocatable :: lines(:)
    integer :: i

    allocate (lines(diagnostics%n_notes))
    do i = 1, diagnostics%n_notes
      lines(i)%s = place_text(diagnostics, diagnostics%notes(i)%at)//': note: '// &
        printable(diagnostics%notes(i)%what)
    end do
  end function note_lines

  !> The warnings, ready for log and terminal.
  function warning_lines(diagnostics) result(lines)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    type(string_t), allocatable :: lines(:)
    integer :: i

    allocate (lines(diagnostics%n_warnings))
    do i = 1, diagnostics%n_warnings
      lines(i)%s = place_text(diagnostics, diagnostics%warnings(i)%at)//': '// &
        printable(diagnostics%warnings(i)%what)
    end do
  end function warning_lines
end module diagnostics

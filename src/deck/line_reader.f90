!> Walks through the lines of a deck and the files it includes, record by record.
module line_reader
  use text, only: to_text, lower
  use deck_types, only: record_t, location_t, item_word, item_quoted, item_empty, longest_line
  use source, only: add_file, source_line, beside
  use diagnostics, only: diagnostics_t, report_error
  use scanner, only: scan_t, scan_line, start_scan, first_item
  implicit none
  private
  public :: line_reader_t, open_reader, next_record, next_title, open_include
  public :: status_record, status_blank, status_end, status_damaged

  !> What next_record found.
  integer, parameter :: status_record = 1 !! a record
  integer, parameter :: status_blank = 2 !! a blank line
  integer, parameter :: status_end = 3 !! the end of the deck
  integer, parameter :: status_damaged = 4 !! a record with an error in its form, reported

  !> Deepest nesting of included files.
  integer, parameter :: deepest_include = 9

  !> Where reading stands.
  type :: line_reader_t
    integer :: depth = -1 !! number of open includes, -1 at the end of the deck
    integer :: file(0:deepest_include) = 0 !! open files
    integer :: line(0:deepest_include) = 0 !! last line read of each
    type(scan_t) :: scan !! the record at hand
    logical :: equals = .false. !! whether = follows its first item
    integer :: record_file = 1 !! file it stands in
  end type line_reader_t

contains

  !> Starts at the first line of the first file.
  subroutine open_reader(reader)
    type(line_reader_t), intent(out) :: reader !! ready to read

    reader%depth = 0
    reader%file(0) = 1
  end subroutine open_reader

  !> Goes to the next line; false at the end of the deck.
  logical function next_line(reader, diagnostics)
    type(line_reader_t), intent(inout) :: reader !! where reading stands
    type(diagnostics_t), intent(in) :: diagnostics !! holds the source

    next_line = .false.
    do while (reader%depth >= 0)
      associate (line => reader%line(reader%depth))
        if (line < diagnostics%source%files(reader%file(reader%depth))%lines) then
          line = line + 1
          next_line = .true.
          return
        end if
      end associate
      reader%depth = reader%depth - 1
    end do
  end function next_line

  !> Reads a record with the lines that & joins to it; comment lines are skipped.
  subroutine next_record(reader, diagnostics, record, status)
    type(line_reader_t), intent(inout) :: reader !! where reading stands
    type(diagnostics_t), intent(inout) :: diagnostics !! source and errors
    type(record_t), intent(out) :: record !! its items; words, quoted or empty, not yet evaluated
    integer, intent(out) :: status !! one of the constants above
    integer :: depth, count
    logical :: joining

    call start_scan(reader%scan)
    do
      depth = reader%depth
      joining = reader%scan%continued
      count = reader%scan%count
      if (.not. next_line(reader, diagnostics)) exit
      if (reader%scan%continued .and. reader%depth < depth) then
        ! nothing is joined across the end of a file: this line is read again
        reader%line(reader%depth) = reader%line(reader%depth) - 1
        exit
      end if
      call scan_current(reader, diagnostics)
      if (reader%scan%fault /= 0) exit
      ! a comment line between joined lines is skipped
      if (joining .and. reader%scan%count == count .and. reader%scan%comment) then
        reader%scan%continued = .true.
      end if
      if (reader%scan%continued) cycle
      if (reader%scan%count > 0 .or. .not. reader%scan%comment) exit
    end do
    if (reader%scan%fault /= 0) then
      status = status_damaged
    else if (reader%scan%count > 0) then
      status = status_record
    else if (reader%depth < 0) then
      status = status_end
    else
      status = status_blank
    end if
    if (status == status_record .or. status == status_damaged) then
      call fill_record(reader, diagnostics, record)
    end if
  end subroutine next_record

  !> Adds the items of the current line to the record at hand and reports faults of its form.
  subroutine scan_current(reader, diagnostics)
    type(line_reader_t), intent(inout) :: reader !! where reading stands
    type(diagnostics_t), intent(inout) :: diagnostics !! source and errors
    type(location_t) :: at
    integer :: first, last, past

    at%file = reader%file(reader%depth)
    at%line = reader%line(reader%depth)
    reader%record_file = at%file
    first = diagnostics%source%files(at%file)%first(at%line)
    last = diagnostics%source%files(at%file)%last(at%line)
    past = past_longest(diagnostics%source%files(at%file)%text, first, last)
    call scan_line(diagnostics%source%files(at%file)%text, first, past - 1, at%line, reader%scan)
    if (past <= last) then
      reader%scan%fault = past
      reader%scan%what = 'a line of more than '//to_text(longest_line)//' characters'
      reader%scan%remedy = 'join shorter lines by & at their ends'
    end if
    if (reader%scan%fault == 0) return
    at%column = reader%scan%fault - first + 1
    call report_error(diagnostics, at, reader%scan%what, reader%scan%remedy)
  end subroutine scan_current

  !> Place behind the longest line that may begin at a place, or behind the line if it is shorter. A
  !! character of UTF-8 counts as one, whatever its bytes.
  pure integer function past_longest(text, first, last) result(past)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: first, last !! the line
    integer :: characters

    past = last + 1
    if (last - first < longest_line) return
    characters = 0
    do past = first, last
      if (iand(iachar(text(past:past)), 192) /= 128) characters = characters + 1
      if (characters > longest_line) return
    end do
  end function past_longest

  !> Makes a record of the items found.
  subroutine fill_record(reader, diagnostics, record)
    type(line_reader_t), intent(inout) :: reader !! where reading stands
    type(diagnostics_t), intent(in) :: diagnostics !! holds the source
    type(record_t), intent(inout) :: record !! the record
    integer :: i, file

    reader%equals = reader%scan%equals
    file = reader%record_file
    allocate (record%items(reader%scan%count))
    do i = 1, reader%scan%count
      associate (span => reader%scan%spans(i), item => record%items(i))
        item%at = location_t(file, span%line, span%column)
        item%text = diagnostics%source%files(file)%text(span%first:span%last)
        item%kind = item_word
        if (span%last < span%first) item%kind = item_empty
        if (span%quoted) item%kind = item_quoted
      end associate
    end do
    if (size(record%items) > 0) record%at = record%items(1)%at
  end subroutine fill_record

  !> Takes the next line that is neither blank nor a comment as it is, if it begins as a title does.
  subroutine next_title(reader, diagnostics, title, found, includes)
    type(line_reader_t), intent(inout) :: reader !! where reading stands
    type(diagnostics_t), intent(in) :: diagnostics !! holds the source
    character(:), allocatable, intent(out) :: title !! what follows MFEC * *
    logical, intent(out) :: found !! whether there is a title; else the line is read again
    logical, intent(out) :: includes !! that line begins with INCLude
    character(:), allocatable :: line
    integer :: first, last

    title = ''
    found = .false.
    includes = .false.
    do while (next_line(reader, diagnostics))
      line = source_line(diagnostics%source, reader%file(reader%depth), &
                         reader%line(reader%depth))
      call first_item(line, first, last)
      if (last < first) cycle
      select case (line(first:last))
      case ('MFEC', 'mfec', 'Mfec', 'FEAP', 'feap', 'Feap')
        found = .true.
        title = line(last + 1:)
        first = verify(title, ' *,'//achar(9))
        if (first > 0) title = trim(title(first:))
        if (first == 0) title = ''
      case default
        reader%line(reader%depth) = reader%line(reader%depth) - 1
        includes = lower(line(first:min(last, first + 3))) == 'incl'
      end select
      return
    end do
  end subroutine next_title

  !> Goes on in the file that an INCLude record names.
  subroutine open_include(reader, diagnostics, record)
    type(line_reader_t), intent(inout) :: reader !! where reading stands
    type(diagnostics_t), intent(inout) :: diagnostics !! source and errors
    type(record_t), intent(in) :: record !! the record, its second item the file
    character(:), allocatable :: path, problem

    associate (item => record%items(2))
      if (reader%depth == deepest_include) then
        call report_error(diagnostics, item%at, 'files included more than '// &
                          to_text(deepest_include)//' deep', 'does a file include itself?')
        return
      end if
      path = beside(diagnostics%source, item%at%file, item%text)
      call add_file(diagnostics%source, path, problem)
      if (allocated(problem)) then
        call report_error(diagnostics, item%at, 'cannot include '''//path//''': '//problem, &
                          'the path is relative to the file that includes')
        return
      end if
    end associate
    reader%depth = reader%depth + 1
    reader%file(reader%depth) = diagnostics%source%count
    reader%line(reader%depth) = 0
  end subroutine open_include
end module line_reader

!> Reads a deck: text becomes checked records, and all that is wrong is gathered.
module deck_reader
  use errors, only: error_t, raise, exit_deck
  use deck_types, only: deck_t, data_set_t, record_t, override_t, location_t, parameter_t, &
    item_word, item_empty
  use numbers, only: is_digit
  use text, only: to_text
  use records, only: item_count, item_integer, is_word
  use hints, only: word_list_t, add_candidate, nearest_word
  use signatures, only: compile_signature
  use keywords, only: keyword_table
  use source, only: add_file
  use foreign_decks, only: foreign_deck, has_batch
  use keyword_types, only: find_keyword, table_mesh
  use diagnostics, only: diagnostics_t, error_count, report_error, report_note, &
    diagnostics_to_error
  use line_reader, only: open_reader, status_record, status_blank, status_end, &
    status_damaged
  use matching, only: match_t, match_record
  use reading, only: reading_t, fetch_record, fetch_title, push_back, take_sets, move_record, &
    close_set, lose
  use deck_parameters, only: check_overrides
  use mesh_section, only: read_mesh_record, read_blank_line
  use batch_section, only: read_batch_record, read_table_record, check_loops
  implicit none
  private
  public :: read_deck, read_source

  !> Sections of a deck.
  integer, parameter :: in_mesh = 1
  integer, parameter :: in_batch = 2
  integer, parameter :: in_tables = 3

contains

  !> Reads a deck with all it includes.
  subroutine read_deck(path, overrides, deck, diagnostics, error)
    character(*), intent(in) :: path !! the main file
    type(override_t), intent(in) :: overrides(:) !! parameters that the command line sets
    type(deck_t), intent(out) :: deck !! what was read
    type(diagnostics_t), intent(inout) :: diagnostics !! takes the source and all errors
    type(error_t), allocatable, intent(out) :: error !! only if the main file cannot be read
    character(:), allocatable :: problem

    call add_file(diagnostics%source, path, problem)
    if (allocated(problem)) then
      call raise(error, exit_deck, 'command line: error: cannot read the deck '''//path// &
        ''': '//problem//new_line('a')//'  name a file that you may read, as it is found from '// &
        'the working directory; a pipe will do: cat deck.inp | mfec /dev/stdin')
      return
    end if
    problem = foreign_deck(diagnostics%source%files(1)%text, path)
    if (len(problem) > 0) then
      call raise(error, exit_deck, path//':1:1: error: this is no deck: '//problem)
      return
    end if
    call read_source(overrides, deck, diagnostics)
    ! what else might be wrong with it is of no use to anybody
    if (deck%hopeless) call diagnostics_to_error(diagnostics, error)
  end subroutine read_deck

  !> Reads the deck whose main file is the first of the source.
  subroutine read_source(overrides, deck, diagnostics)
    type(override_t), intent(in) :: overrides(:) !! parameters that the command line sets
    type(deck_t), intent(out) :: deck !! what was read
    type(diagnostics_t), intent(inout) :: diagnostics !! holds the source, takes all errors
    type(reading_t) :: reading
    integer :: section
    logical :: empty

    call start_reading(reading, overrides)
    call locate_end(diagnostics, deck%last)
    call read_title(reading, deck, diagnostics, empty)
    if (empty) then
      if (error_count(diagnostics) == 0) call report_error(diagnostics, deck%last, &
        'the deck is empty', 'a deck begins with MFEC * * title')
    else if (.not. deck%hopeless) then
      section = in_mesh
      call read_sections(reading, deck, diagnostics, section)
      call close_set(reading)
      call check_whole(reading, deck, diagnostics, section)
    end if
    call check_overrides(reading, diagnostics)
    call take_sets(reading%mesh, deck%mesh)
    allocate (deck%losses(0))
    if (allocated(reading%losses)) call move_alloc(reading%losses, deck%losses)
    call take_sets(reading%batch, deck%batch)
    call take_parameters(reading, deck%parameters)
    if (.not. allocated(deck%tables)) allocate (deck%tables(0))
  end subroutine read_source

  !> Makes ready to read.
  subroutine start_reading(reading, overrides)
    type(reading_t), intent(out) :: reading !! where reading stands
    type(override_t), intent(in) :: overrides(:) !! parameters that the command line sets
    integer :: i

    call open_reader(reading%lines)
    call keyword_table(reading%table)
    allocate (reading%parameters(16))
    allocate (reading%overrides(size(overrides)), reading%used(size(overrides)))
    do i = 1, size(overrides)
      reading%overrides(i)%name = overrides(i)%name
      reading%overrides(i)%value = overrides(i)%value
    end do
    reading%used = .false.
  end subroutine start_reading

  !> The last line of the main file.
  subroutine locate_end(diagnostics, last)
    type(diagnostics_t), intent(in) :: diagnostics !! holds the source
    type(location_t), intent(out) :: last !! its place

    last = location_t(1, max(1, diagnostics%source%files(1)%lines), 1)
  end subroutine locate_end

  !> Reads the title and the control record.
  subroutine read_title(reading, deck, diagnostics, empty)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(deck_t), intent(inout) :: deck !! takes title and control record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: empty !! whether there is nothing in the deck
    type(record_t) :: record
    integer :: status
    logical :: found

    empty = .false.
    call fetch_title(reading, diagnostics, deck%title, found)
    do
      call fetch_record(reading, diagnostics, record, status)
      if (status /= status_blank) exit
    end do
    if (.not. found) then
      empty = status == status_end
      if (empty) return
      if (is_misspelt_title(record)) then
        call report_error(diagnostics, record%at, 'a title that begins with '''// &
                          record%items(1)%text//'''', 'write MFEC * * title')
        call fetch_record(reading, diagnostics, record, status)
      else if (is_command(reading, record, status) .or. has_batch(diagnostics%source)) then
        call report_error(diagnostics, location_of(record, deck%last), &
                          'the title is missing', 'a deck begins with MFEC * * title')
      else
        deck%hopeless = .true.
        call report_error(diagnostics, location_of(record, deck%last), 'this is no deck: it '// &
          'has no title and no BATCh', 'a deck begins with MFEC * * title; MESH file in it '// &
          'reads a mesh of Gmsh, Abaqus or CalculiX')
        return
      end if
    end if
    if (status == status_record) then
      if (is_control(record)) then
        call read_control(reading, record, deck, diagnostics)
        return
      end if
    end if
    call push_back(reading, record, status)
  end subroutine read_title

  !> Whether the first record of a deck without a title is one whose first word is misspelt.
  logical function is_misspelt_title(record) result(misspelt)
    type(record_t), intent(in) :: record !! the first record
    type(word_list_t) :: words

    misspelt = item_count(record) > 1
    if (misspelt) misspelt = record%items(2)%text == '*'
    if (.not. misspelt) return
    call add_candidate(words, 'MFEC')
    call add_candidate(words, 'FEAP')
    misspelt = len(nearest_word(words, record%items(1)%text)) > 0
  end function is_misspelt_title

  !> A record begins with a command of the mesh section.
  logical function is_command(reading, record, status) result(yes)
    type(reading_t), intent(in) :: reading !! holds the table
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: status !! what was found

    yes = status == status_record
    if (yes) yes = find_keyword(reading%table, table_mesh, record%items(1)) > 0 .or. &
      is_control(record)
  end function is_command

  !> Whether a record is the control record: what it has first is a number, fields before it may be
  !> left empty (FEAP counts them), as in `,,,3,3,4`.
  pure logical function is_control(record)
    type(record_t), intent(in) :: record !! not without items
    integer :: i

    is_control = .false.
    do i = 1, size(record%items)
      if (record%items(i)%kind == item_empty) cycle
      is_control = record%items(i)%kind == item_word .and. is_digit(record%items(i)%text(1:1))
      return
    end do
  end function is_control

  !> Reads the control record.
  subroutine read_control(reading, record, deck, diagnostics)
    type(reading_t), intent(in) :: reading !! holds the parameters
    type(record_t), intent(inout) :: record !! the record
    type(deck_t), intent(inout) :: deck !! takes its numbers
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(match_t) :: match
    logical :: good
    integer :: i

    match%name = 'the control record'
    call match_record(record, compile_signature( &
                      'n:numnp n:numel n:nummat [n:ndm] [n:ndf] [n:nen] [n:npd] [n:nud] '// &
                      '[n:nad]'), match, &
                      reading%parameters(:reading%n_parameters), diagnostics, good)
    if (.not. good) return
    do i = 1, min(size(record%items), size(deck%control))
      deck%control(i) = item_integer(record, i)
    end do
    do i = size(deck%control) + 1, size(record%items)
      if (item_integer(record, i) == 0) cycle
      call report_note(diagnostics, record%items(i)%at, 'items behind nen are ignored')
      exit
    end do
    deck%hopeless = any(deck%control(4) == [1, 2])
    if (deck%hopeless) then
      call report_error(diagnostics, record%items(4)%at, 'a deck in '// &
        to_text(deck%control(4))//' dimensions (ndm)', 'this program computes bodies of '// &
        'tetrahedra: give the mesh a thickness of one cell along x3 (BLOCk; a mesh of Gmsh: '// &
        'Extrude), and for plane strain restrain x3 on both of its faces (BOUNdary 0 0 1)')
      return
    end if
    do i = 4, 5
      if (deck%control(i) /= 0 .and. deck%control(i) /= 3) call report_error(diagnostics, &
        record%items(i)%at, 'ndm and ndf are 3 in this program', 'write 3 or 0, or leave the '// &
        'control record out')
    end do
    call move_record(record, deck%control_record)
  end subroutine read_control

  !> Reads mesh commands, solution commands and tables.
  subroutine read_sections(reading, deck, diagnostics, section)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(deck_t), intent(inout) :: deck !! takes the tables
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer, intent(out) :: section !! the section in which the deck ends
    type(record_t) :: record
    type(data_set_t) :: tables
    character(4) :: command
    integer :: status, group

    section = in_mesh
    group = 1
    do
      call fetch_record(reading, diagnostics, record, status)
      command = ''
      select case (status)
      case (status_end)
        exit
      case (status_blank)
        if (section == in_mesh) call read_blank_line(reading)
        if (section == in_tables .and. tables%count > 0) group = group + 1
      case (status_damaged)
        reading%set%complete = .false.
        call lose(reading, '?')
      case default
        if (section == in_mesh) then
          call read_mesh_record(reading, record, diagnostics, command)
        else if (section == in_batch) then
          call read_batch_record(reading, record, diagnostics, command)
        else if (section == in_tables) then
          call read_behind_end(reading, record, group, tables, diagnostics, command)
        end if
      end select
      if (command == 'stop') exit
      call change_section(reading, command, section)
    end do
    allocate (deck%tables(tables%count))
    do group = 1, tables%count
      call move_record(tables%records(group), deck%tables(group))
    end do
  end subroutine read_sections

  !> Goes to the next section of the deck where a command says so.
  subroutine change_section(reading, command, section)
    type(reading_t), intent(inout) :: reading !! where reading stands
    character(4), intent(in) :: command !! the command just obeyed
    integer, intent(inout) :: section !! the section at hand

    if (section /= in_batch .and. (command == 'batc' .or. command == 'macr')) then
      section = in_batch
    else if (section == in_batch .and. command == 'end') then
      section = in_tables
      reading%passing = .false.
    end if
  end subroutine change_section

  !> Obeys a record behind the END of BATCh.
  subroutine read_behind_end(reading, record, group, tables, diagnostics, command)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record
    integer, intent(inout) :: group !! number of its block
    type(data_set_t), intent(inout) :: tables !! the records so far
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    character(4), intent(out) :: command !! stop, batc or empty

    command = ''
    if (is_word(record%items(1), 'stop')) then
      command = 'stop'
    else if (is_word(record%items(1), 'batch') .or. is_word(record%items(1), 'macro')) then
      command = 'batc'
      if (tables%count > 0) group = group + 1
    else if (is_word(record%items(1), 'interactive')) then
      call report_note(diagnostics, record%at, 'INTEractive is ignored')
    else
      call read_table_record(reading, record, group, tables, diagnostics)
    end if
  end subroutine read_behind_end

  !> Reports what is missing in the deck as a whole.
  subroutine check_whole(reading, deck, diagnostics, section)
    type(reading_t), intent(in) :: reading !! what was read
    type(deck_t), intent(in) :: deck !! knows the last line
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer, intent(in) :: section !! the section in which the deck ends
    logical :: elements, torn
    integer :: i

    ! nobody knows what stands in a file that could not be included
    torn = .false.
    if (allocated(reading%losses)) torn = any(reading%losses%command == '?')
    elements = reading%refused .or. torn
    do i = 1, reading%mesh%count
      select case (reading%mesh%sets(i)%command)
      case ('mesh')
        elements = .true.
      case ('elem', 'bloc')
        elements = elements .or. reading%mesh%sets(i)%count > 0 &
          .or. .not. reading%mesh%sets(i)%complete
      case default
        continue
      end select
    end do
    if (.not. elements) call report_error(diagnostics, deck%last, 'the deck has no elements', &
                                          'ELEMents, BLOCk or MESH make them')
    if (section == in_mesh) then
      if (.not. torn .and. .not. reading%solution) call report_error(diagnostics, deck%last, &
        'the deck has no BATCh', &
        'solution commands stand between BATCh and END')
    else if (section == in_batch) then
      call report_error(diagnostics, deck%last, 'BATCh is not ended', &
                        'write END behind the last solution command')
    end if
    call check_loops(reading, diagnostics)
  end subroutine check_whole

  !> Where a record stands, or the end of the deck if it has no items.
  pure type(location_t) function location_of(record, last) result(at)
    type(record_t), intent(in) :: record !! the record
    type(location_t), intent(in) :: last !! last line of the deck

    at = last
    if (allocated(record%items)) at = record%at
  end function location_of

  !> Gives the parameters to the deck.
  subroutine take_parameters(reading, parameters)
    type(reading_t), intent(in) :: reading !! what was read
    type(parameter_t), allocatable, intent(out) :: parameters(:) !! exactly as many as there are
    integer :: i

    allocate (parameters(reading%n_parameters))
    do i = 1, reading%n_parameters
      parameters(i)%name = reading%parameters(i)%name
      parameters(i)%value = reading%parameters(i)%value
    end do
  end subroutine take_parameters
end module deck_reader

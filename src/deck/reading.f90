!> What the reader of a deck keeps in mind from record to record.
module reading
  use deck_types, only: record_t, data_set_t, parameter_t, override_t, loss_t, item_word, &
    item_quoted
  use records, only: is_word, item_count
  use keyword_types, only: keyword_table_t
  use diagnostics, only: diagnostics_t, report_error, error_count
  use line_reader, only: line_reader_t, next_record, next_title, open_include, status_record
  implicit none
  private
  public :: reading_t, set_list_t, fetch_record, fetch_title, push_back, append_record, &
    append_set, take_sets, move_record, close_set, skip_data, lose

  !> Data sets gathered so far.
  type :: set_list_t
    type(data_set_t), allocatable :: sets(:) !! may be larger than count
    integer :: count = 0 !! number of data sets
  end type set_list_t

  !> Where reading stands and what it found.
  type :: reading_t
    type(line_reader_t) :: lines !! lines and files
    type(keyword_table_t) :: table !! the commands
    type(parameter_t), allocatable :: parameters(:) !! may be larger than n_parameters
    integer :: n_parameters = 0 !! parameters defined so far
    type(override_t), allocatable :: overrides(:) !! parameters that the command line sets
    logical, allocatable :: used(:) !! whether the deck defines them
    type(set_list_t) :: mesh !! mesh commands
    type(set_list_t) :: batch !! solution commands
    type(data_set_t) :: set !! the data set that is open
    integer :: open = 0 !! its index in the keyword table, 0 if none is open
    logical :: keep = .false. !! whether the open set goes to the deck
    logical :: in_parameters = .false. !! whether a PARAmeter set is open
    logical :: skipping = .false. !! whether stray numbers belong to what was refused before
    logical :: passing = .false. !! whether all records belong to it, up to a blank line
    logical :: refused = .false. !! whether any command was refused
    type(loss_t), allocatable :: losses(:) !! what was left out because of errors
    integer :: closed = 0 !! index of the last set that a blank line ended
    logical :: contact = .false. !! whether there was a CONTact
    logical :: told_comment = .false. !! a comment of others has been reported
    logical :: told_card = .false. !! a card of Abaqus has been reported
    logical :: solution = .false. !! whether a solution command stood among the mesh commands
    logical :: feap_contact = .false. !! whether records are FEAP's contact input, up to its END
    type(record_t) :: pending !! a record that is to be read again
    integer :: pending_status = 0 !! its status, 0 if there is none
  end type reading_t

contains

  !> Reads a record; INCLude is obeyed here, wherever it stands.
  subroutine fetch_record(reading, diagnostics, record, status)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(diagnostics_t), intent(inout) :: diagnostics !! source and errors
    type(record_t), intent(out) :: record !! the record
    integer, intent(out) :: status !! as next_record has it

    if (reading%pending_status /= 0) then
      call move_record(reading%pending, record)
      status = reading%pending_status
      reading%pending_status = 0
      return
    end if
    do
      call next_record(reading%lines, diagnostics, record, status)
      if (status /= status_record) return
      if (.not. is_word(record%items(1), 'include')) return
      if (reading%in_parameters .and. reading%lines%equals) return
      call obey_include(reading, record, diagnostics)
    end do
  end subroutine fetch_record

  !> The title, in the file that the deck begins with: the first ones may be included.
  subroutine fetch_title(reading, diagnostics, title, found)
    type(reading_t), intent(inout) :: reading !! at the first line; then behind the title
    type(diagnostics_t), intent(inout) :: diagnostics !! source and errors
    character(:), allocatable, intent(out) :: title !! what follows MFEC * *
    logical, intent(out) :: found !! there is one
    type(record_t) :: record
    integer :: status
    logical :: includes

    do
      call next_title(reading%lines, diagnostics, title, found, includes)
      if (found .or. .not. includes) return
      call next_record(reading%lines, diagnostics, record, status)
      if (status == status_record) call obey_include(reading, record, diagnostics)
    end do
  end subroutine fetch_title

  !> INCLude: reading goes on in another file.
  subroutine obey_include(reading, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! begins with INCLude
    type(diagnostics_t), intent(inout) :: diagnostics !! source and errors
    integer :: errors

    errors = error_count(diagnostics)
    if (item_count(record) /= 2) then
      call refuse_include(record, diagnostics)
    else if (len(record%items(2)%text) == 0) then
      call refuse_include(record, diagnostics)
    else
      call open_include(reading%lines, diagnostics, record)
    end if
    if (error_count(diagnostics) > errors) call lose(reading, '?')
  end subroutine obey_include

  !> Reports an INCLude without a file, or with more than one.
  subroutine refuse_include(record, diagnostics)
    type(record_t), intent(in) :: record !! begins with INCLude
    type(diagnostics_t), intent(inout) :: diagnostics !! errors

    call report_error(diagnostics, record%items(min(2, item_count(record)))%at, &
                      'INCLude takes one file name', &
                      'INCLude file; a name with blanks stands in quotes')
  end subroutine refuse_include

  !> Makes fetch_record return a record once more.
  subroutine push_back(reading, record, status)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record; left empty
    integer, intent(in) :: status !! its status

    call move_record(record, reading%pending)
    reading%pending_status = status
  end subroutine push_back

  !> Adds a record to the open set.
  subroutine append_record(set, record)
    type(data_set_t), intent(inout) :: set !! the open set
    type(record_t), intent(inout) :: record !! the record; left empty
    type(record_t), allocatable :: more(:)
    integer :: i

    if (.not. allocated(set%records)) allocate (set%records(8))
    if (set%count == size(set%records)) then
      allocate (more(2*set%count))
      do i = 1, set%count
        call move_record(set%records(i), more(i))
      end do
      call move_alloc(more, set%records)
    end if
    set%count = set%count + 1
    call move_record(record, set%records(set%count))
  end subroutine append_record

  !> Hands a record over without copying its items.
  subroutine move_record(from, to)
    type(record_t), intent(inout) :: from !! left without items
    type(record_t), intent(inout) :: to !! filled

    call move_alloc(from%items, to%items)
    to%at = from%at
    to%word = from%word
    to%group = from%group
  end subroutine move_record

  !> Adds a data set to a list.
  subroutine append_set(list, set)
    type(set_list_t), intent(inout) :: list !! the list
    type(data_set_t), intent(inout) :: set !! the data set; left empty
    type(data_set_t), allocatable :: more(:)
    integer :: i

    if (.not. allocated(list%sets)) allocate (list%sets(16))
    if (list%count == size(list%sets)) then
      allocate (more(2*list%count))
      do i = 1, list%count
        call move_set(list%sets(i), more(i))
      end do
      call move_alloc(more, list%sets)
    end if
    list%count = list%count + 1
    call move_set(set, list%sets(list%count))
  end subroutine append_set

  !> Hands a data set over without copying its records.
  subroutine move_set(from, to)
    type(data_set_t), intent(inout) :: from !! left empty
    type(data_set_t), intent(inout) :: to !! filled

    to%command = from%command
    call move_record(from%head, to%head)
    if (.not. allocated(from%records)) allocate (from%records(0))
    call move_alloc(from%records, to%records)
    to%count = from%count
    to%complete = from%complete
    to%unknown = from%unknown
    from%command = ''
    from%count = 0
    from%complete = .true.
    from%unknown = .false.
  end subroutine move_set

  !> The data sets of a list, exactly as many as there are.
  subroutine take_sets(list, sets)
    type(set_list_t), intent(inout) :: list !! the list; left empty
    type(data_set_t), allocatable, intent(out) :: sets(:) !! its data sets
    integer :: i

    allocate (sets(list%count))
    do i = 1, list%count
      call move_set(list%sets(i), sets(i))
    end do
    list%count = 0
  end subroutine take_sets

  !> Ends the open set and gives it to the deck.
  subroutine close_set(reading)
    type(reading_t), intent(inout) :: reading !! where reading stands

    if (reading%open > 0) then
      if (reading%keep) call append_set(reading%mesh, reading%set)
    end if
    reading%open = 0
    reading%keep = .false.
    reading%in_parameters = .false.
    reading%set%count = 0
    reading%set%complete = .true.
    reading%set%unknown = .false.
  end subroutine close_set

  !> Keeps in mind that data are missing because of an error.
  subroutine lose(reading, command, record)
    type(reading_t), intent(inout) :: reading !! where reading stands
    character(*), intent(in) :: command !! first four letters, or as in loss_t
    type(record_t), intent(in), optional :: record !! the head of the data
    type(loss_t), allocatable :: longer(:)
    integer :: n

    n = 0
    if (allocated(reading%losses)) n = size(reading%losses)
    allocate (longer(n + 1))
    if (n > 0) longer(:n) = reading%losses
    longer(n + 1)%command = command
    longer(n + 1)%name = ''
    if (present(record)) then
      if (item_count(record) > 1) then
        if (any(record%items(2)%kind == [item_word, item_quoted])) &
          longer(n + 1)%name = record%items(2)%text
      end if
    end if
    call move_alloc(longer, reading%losses)
  end subroutine lose

  !> Passes over the data of a command that is refused.
  subroutine skip_data(reading)
    type(reading_t), intent(inout) :: reading !! where reading stands

    call close_set(reading)
    reading%skipping = .true.
    reading%passing = .true.
    reading%refused = .true.
  end subroutine skip_data
end module reading

!> Reads proportional loads: the PROPortional data sets, and FEAP's tables behind the batch.
module loads_reader
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: deck_t, data_set_t, record_t, location_t, item_number
  use records, only: item_count, item_integer, item_real
  use diagnostics, only: diagnostics_t, report_error
  use model_types, only: model_t, load_table_t
  use loads, only: has_load
  implicit none
  private
  public :: read_loads

  !> The records behind END, and how many of them have been read.
  type :: table_reader_t
    integer :: next = 1 !! next record of deck%tables
  end type table_reader_t

contains

  !> Fills model%loads.
  subroutine read_loads(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the loads
    type(table_reader_t) :: reader
    integer :: i

    allocate (model%loads(0))
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command == 'prop') call read_mesh_table(deck%mesh(i), diagnostics, model)
    end do
    do i = 1, size(deck%batch)
      if (deck%batch(i)%command == 'prop') then
        call read_batch_tables(deck, deck%batch(i)%head, reader, diagnostics, model)
      end if
    end do
    if (.not. allocated(deck%tables)) return
    do i = reader%next, size(deck%tables)
      if (item_count(deck%tables(i)) == 0) cycle
      call report_error(diagnostics, deck%tables(i)%at, 'data that no PROP command reads', &
        'write PROP,,n in the batch for each table behind its END')
      return
    end do
  end subroutine read_loads

  !> PROPortional n with one record `t p` for each point.
  subroutine read_mesh_table(set, diagnostics, model)
    type(data_set_t), intent(in) :: set !! the data set
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the table
    type(load_table_t) :: table
    logical :: good
    integer :: i

    table%number = item_integer(set%head, 2)
    allocate (table%t(set%count), table%p(set%count))
    good = .true.
    do i = 1, set%count
      table%t(i) = item_real(set%records(i), 1)
      table%p(i) = item_real(set%records(i), 2)
      if (i == 1) cycle
      call check_time(table%t(i - 1), table%t(i), set%records(i), diagnostics, good)
    end do
    if (set%count == 0) then
      call report_error(diagnostics, set%head%at, 'proportional load '// &
        to_text(table%number)//' has no points', 'write records of time and factor below it')
      good = .false.
    end if
    call add_table(table, set%head, good, diagnostics, model)
  end subroutine read_mesh_table

  !> Times must ascend.
  subroutine check_time(before, this, record, diagnostics, good)
    real(wp), intent(in) :: before !! time of the record before
    real(wp), intent(in) :: this !! time of this record
    type(record_t), intent(in) :: record !! this record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical, intent(inout) :: good !! becomes false with an error

    if (this > before) return
    good = .false.
    call report_error(diagnostics, record%at, 'time '//to_text(this, 10)// &
      ' does not lie behind '//to_text(before, 10), 'write the points by ascending time')
  end subroutine check_time

  !> Adds a table unless its number is taken; a bad table is added too, so that its number is known.
  subroutine add_table(table, head, good, diagnostics, model)
    type(load_table_t), intent(inout) :: table !! the table
    type(record_t), intent(in) :: head !! the record that numbers it
    logical, intent(in) :: good !! false: replaced by a constant
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the table

    if (has_load(model%loads, table%number)) then
      call report_error(diagnostics, head%at, 'proportional load '//to_text(table%number)// &
        ' has a table already', 'give the second table another number')
      return
    end if
    if (.not. good) then
      table%function_form = .false.
      table%t = [0.0_wp]
      table%p = [0.0_wp]
    end if
    model%loads = [model%loads, table]
  end subroutine add_table

  !> FEAP's PROP,,n1,n2: tables n1 to n2 stand behind the END of the batch.
  subroutine read_batch_tables(deck, head, reader, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(record_t), intent(in) :: head !! the PROP command
    type(table_reader_t), intent(inout) :: reader !! where the next table stands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the tables
    type(load_table_t) :: table
    integer :: first, last, number
    logical :: good, found

    first = 0
    last = 0
    if (item_count(head) > 2) first = item_integer(head, 3)
    if (item_count(head) > 3) last = item_integer(head, 4)
    first = max(first, 1)
    last = max(first, last)
    do number = first, last
      call read_feap_table(deck, reader, diagnostics, table, found, good)
      if (.not. found) then
        call report_error(diagnostics, head%at, 'the table of proportional load '// &
          to_text(number)//' is missing', &
          'write it behind the END of the batch, or as PROPortional among the mesh commands')
        return
      end if
      table%number = number
      call add_table(table, head, good, diagnostics, model)
    end do
  end subroutine read_batch_tables

  !> The next table behind END: of type 1 (one record), or of type 2 (a record, then points).
  subroutine read_feap_table(deck, reader, diagnostics, table, found, good)
    type(deck_t), intent(in) :: deck !! the deck
    type(table_reader_t), intent(inout) :: reader !! where the table starts
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(load_table_t), intent(out) :: table !! the table
    logical, intent(out) :: found !! there was one
    logical, intent(out) :: good !! and it is right
    integer :: kind

    good = .true.
    found = .false.
    if (.not. allocated(deck%tables)) return
    do while (reader%next <= size(deck%tables))
      if (item_count(deck%tables(reader%next)) > 0) exit
      reader%next = reader%next + 1
    end do
    found = reader%next <= size(deck%tables)
    if (.not. found) return
    associate (head => deck%tables(reader%next))
      reader%next = reader%next + 1
      kind = item_integer(head, 1)
      select case (kind)
      case (0)
        table = ramp_table()
      case (1)
        call read_function(head, diagnostics, table, good)
      case (2)
        call read_points(deck, head, reader, diagnostics, table, good)
      case default
        good = .false.
        call report_error(diagnostics, head%at, 'proportional load of type '//to_text(kind), &
          'types 1 (function) and 2 (table of points) can be used')
      end select
    end associate
  end subroutine read_feap_table

  !> FEAP's default: the factor is the time.
  function ramp_table() result(table)
    type(load_table_t) :: table

    table%function_form = .true.
    allocate (table%t(2), table%p(6))
    table%t = [0.0_wp, 1.0e20_wp]
    table%p = [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
  end function ramp_table

  !> Type 1: `1 k tmin tmax a0 a1 a2 a3 a4`, missing items are 0, and an exponent below 1 is 1.
  subroutine read_function(record, diagnostics, table, good)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(load_table_t), intent(out) :: table !! the table
    logical, intent(out) :: good !! it is right
    real(wp) :: values(9)
    integer :: i

    values = 0.0_wp
    do i = 1, min(9, item_count(record))
      values(i) = item_real(record, i)
    end do
    table%function_form = .true.
    allocate (table%t(2), table%p(6))
    table%t = values(3:4)
    table%p = [values(5:9), max(1.0_wp, min(1000.0_wp, values(2)))]
    good = table%t(2) > table%t(1)
    if (.not. good) then
      call report_error(diagnostics, record%at, 'the load ends at time '// &
        to_text(table%t(2))//', not behind its start at '//to_text(table%t(1)), &
        'write: 1, exponent, tmin, tmax, a0, a1, a2, a3, a4')
    end if
  end subroutine read_function

  !> Type 2: `2 l`, then records of l pairs `t p`; a blank record, or the end, ends the table.
  subroutine read_points(deck, head, reader, diagnostics, table, good)
    type(deck_t), intent(in) :: deck !! the deck
    type(record_t), intent(in) :: head !! the record `2 l`
    type(table_reader_t), intent(inout) :: reader !! where the points start
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(load_table_t), intent(out) :: table !! the table
    logical, intent(out) :: good !! it is right
    real(wp), allocatable :: t(:), p(:)
    integer :: n, i, pairs

    pairs = 1
    if (item_count(head) > 1) pairs = max(1, min(8, item_integer(head, 2)))
    good = .true.
    n = 0
    allocate (t(pairs*size(deck%tables)), p(pairs*size(deck%tables)))
    do while (reader%next <= size(deck%tables))
      associate (record => deck%tables(reader%next))
        if (ends_table(record, pairs, n)) exit
        do i = 1, (item_count(record) + 1)/2
          n = n + 1
          t(n) = item_real(record, 2*i - 1)
          p(n) = 0.0_wp
          if (2*i <= item_count(record)) p(n) = item_real(record, 2*i)
          if (n > 1) call check_time(t(n - 1), t(n), record, diagnostics, good)
        end do
      end associate
      reader%next = reader%next + 1
    end do
    if (n == 0) then
      call report_error(diagnostics, head%at, 'the table has no points', &
        'write records of time and factor below it')
      good = .false.
    end if
    table%t = t(:n)
    table%p = p(:n)
  end subroutine read_points

  !> Whether a record ends a table of points: it is blank, or all zero behind the first point, or
  !! longer than the table's records.
  pure logical function ends_table(record, pairs, n)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: pairs !! points in a record of the table
    integer, intent(in) :: n !! points read so far
    integer :: i

    ends_table = item_count(record) == 0 .or. item_count(record) > 2*pairs
    if (ends_table .or. n == 0) return
    do i = 1, item_count(record)
      if (abs(record%items(i)%value) > 0.0_wp) return
    end do
    ends_table = .true.
  end function ends_table
end module loads_reader

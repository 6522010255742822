!> Reads proportional loads: the PROPortional data sets, and FEAP's tables behind the batch.
module loads_reader
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t, data_set_t, record_t
  use deck_losses, only: is_lost
  use records, only: item_count, item_integer, item_location, item_real
  use diagnostics, only: diagnostics_t, report_error
  use model_types, only: model_t, load_table_t
  use loads, only: has_load
  implicit none
  private
  public :: read_loads, add_lost_tables

  !> Tables that may be those of a PROPortional that was refused have numbers up to this.
  integer, parameter :: most_refused_tables = 100

contains

  !> Fills model%tables.
  subroutine read_loads(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the loads
    integer :: i, next

    allocate (model%tables(0))
    next = 1
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command == 'prop') call read_mesh_table(deck%mesh(i), diagnostics, model)
    end do
    do i = 1, size(deck%batch)
      if (deck%batch(i)%command == 'prop') then
        call read_batch_table(deck, deck%batch(i)%head, next, diagnostics, model)
      end if
    end do
    if (next > size(deck%tables)) return
    call report_error(diagnostics, deck%tables(next)%at, &
      'data that no PROP command reads', &
      'write PROP,,n in the batch for each table behind its END')
  end subroutine read_loads

  !> Where tables were left out because of an error, each number may be one of theirs.
  subroutine add_lost_tables(deck, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(inout) :: model !! receives tables that are 0
    type(load_table_t) :: table
    integer :: n

    if (.not. is_lost(deck, 'prop')) return
    table%t = [0.0_wp]
    table%p = [0.0_wp]
    do n = 1, most_refused_tables
      if (has_load(model%tables, n)) cycle
      table%number = n
      call append_table(table, model%tables)
    end do
  end subroutine add_lost_tables

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
    if (set%count == 0 .and. set%complete) then
      call report_error(diagnostics, set%head%at, 'proportional load '// &
        to_text(table%number)//' has no points', 'write records of time and factor below it')
    end if
    good = good .and. set%count > 0
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

    if (has_load(model%tables, table%number)) then
      call report_error(diagnostics, head%at, 'proportional load '//to_text(table%number)// &
        ' has a table already', 'give the second table another number')
      return
    end if
    if (.not. good) then
      table%function_form = .false.
      table%t = [0.0_wp]
      table%p = [0.0_wp]
    end if
    call append_table(table, model%tables)
  end subroutine add_table

  !> Appends a table to the list.
  subroutine append_table(table, tables)
    type(load_table_t), intent(in) :: table !! the table
    type(load_table_t), allocatable, intent(inout) :: tables(:) !! the list
    type(load_table_t), allocatable :: longer(:)

    allocate (longer(size(tables) + 1))
    longer(:size(tables)) = tables
    longer(size(longer)) = table
    call move_alloc(longer, tables)
  end subroutine append_table

  !> FEAP's PROP,,n: table n stands behind the END of the batch.
  subroutine read_batch_table(deck, head, next, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(record_t), intent(in) :: head !! the PROP command
    integer, intent(inout) :: next !! record where the next table stands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the table
    type(load_table_t) :: table
    logical :: good, found

    call read_feap_table(deck, next, diagnostics, table, found, good)
    table%number = max(1, item_integer(head, 3))
    if (found) then
      call add_table(table, head, good, diagnostics, model)
    else
      call report_error(diagnostics, head%at, 'the table of proportional load '// &
        to_text(table%number)//' is missing', &
        'write it behind the END of the batch, or as PROPortional among the mesh commands')
    end if
  end subroutine read_batch_table

  !> The next table behind END: of type 1 (one record), or of type 2 (a record, then points).
  subroutine read_feap_table(deck, next, diagnostics, table, found, good)
    type(deck_t), intent(in) :: deck !! the deck
    integer, intent(inout) :: next !! record where the table starts
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(load_table_t), intent(out) :: table !! the table
    logical, intent(out) :: found !! there was one
    logical, intent(out) :: good !! and it is right
    integer :: kind

    good = .true.
    found = .false.
    found = next <= size(deck%tables)
    if (.not. found) return
    associate (head => deck%tables(next))
      next = next + 1
      kind = item_integer(head, 1)
      select case (kind)
      case (0)
        call make_ramp(table)
      case (1)
        call read_function(head, diagnostics, table, good)
      case (2)
        call read_points(deck, head, next, diagnostics, table, good)
      case default
        good = .false.
        call report_error(diagnostics, head%at, 'proportional load of type '//to_text(kind), &
          'types 1 (function) and 2 (table of points) can be used')
      end select
    end associate
  end subroutine read_feap_table

  !> FEAP's default: the factor is the time.
  pure subroutine make_ramp(table)
    type(load_table_t), intent(out) :: table !! the table

    table%function_form = .true.
    allocate (table%t(2), table%p(6))
    table%t = [0.0_wp, 1.0e20_wp]
    table%p = [0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp]
  end subroutine make_ramp

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
  subroutine read_points(deck, head, next, diagnostics, table, good)
    type(deck_t), intent(in) :: deck !! the deck
    type(record_t), intent(in) :: head !! the record `2 l`
    integer, intent(inout) :: next !! record where the points start
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
    do while (next <= size(deck%tables))
      associate (record => deck%tables(next))
        if (record%group /= head%group) exit
        if (item_count(record) > 2*pairs) then
          good = .false.
          call report_error(diagnostics, item_location(record, 2*pairs + 1), 'a record of '// &
            to_text(item_count(record))//' items in a table of '//count_noun(pairs, 'point')// &
            ' a record', 'write the points of a record into the head of the table: 2, '// &
            to_text((item_count(record) + 1)/2))
        end if
        do i = 1, min(pairs, (item_count(record) + 1)/2)
          n = n + 1
          t(n) = item_real(record, 2*i - 1)
          p(n) = 0.0_wp
          if (2*i <= item_count(record)) p(n) = item_real(record, 2*i)
          if (n > 1) call check_time(t(n - 1), t(n), record, diagnostics, good)
        end do
      end associate
      next = next + 1
    end do
    if (n == 0) then
      call report_error(diagnostics, head%at, 'the table has no points', &
        'write records of time and factor below it')
      good = .false.
    end if
    table%t = t(:n)
    table%p = p(:n)
  end subroutine read_points
end module loads_reader

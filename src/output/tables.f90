!> The text tables: reactions (.rea), contact (.con), requested displacements (.his), rigid bodies
!! (.rig).
!!
!! One row per end time and name, flushed at once. Nothing in them depends on the machine or the
!! clock; -0 is printed as 0.
module tables
  use kinds, only: wp
  use errors, only: error_t
  use text, only: string_t, to_text
  use model_types, only: history_request_t, rigid_body_t
  use contact_types, only: pair_t
  use result_types, only: contact_row_t
  use table_columns, only: reaction_columns, contact_columns, rigid_columns, contact_counts, &
    contact_values
  use point_rows, only: point_row_t
  use text_files, only: text_file_t, create_text_file, write_line, flush_text_file, close_text_file
  implicit none
  private
  public :: table_t, create_reaction_table, create_contact_table, write_contacts, &
    create_history_table, write_history, create_point_table, write_points, create_rigid_table, &
    write_rows, close_table, row_start, reals, padded

  !> A table open for writing.
  type :: table_t
    type(text_file_t) :: file !! its file
    character(:), allocatable :: key !! name of the column of names, empty for none
    type(string_t), allocatable :: names(:) !! name of each row of an end time, padded
  end type table_t

  !> Width of a real in the format of the tables.
  integer, parameter :: real_width = 21
  !> Width of the column of the step.
  integer, parameter :: step_width = 8

contains

  !> Creates the table of reactions; `write_rows` writes it.
  subroutine create_reaction_table(table, path, title, sets, error)
    type(table_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: title !! title of the deck
    type(string_t), intent(in) :: sets(:) !! names of the sets, in the order of the rows
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call open_table(table, path, 'set', sets, error)
    call write_head(table, title, 'reactions: the force each support exerts on the structure', &
      reaction_columns%name, error=error)
  end subroutine create_reaction_table

  !> Creates the table of contact.
  subroutine create_contact_table(table, path, title, pairs, error)
    type(table_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: title !! title of the deck
    type(pair_t), intent(in) :: pairs(:) !! the pairs, in the order of the rows
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call open_table(table, path, 'pair', pair_names(pairs), error)
    call write_head(table, title, 'contact: forces on the slave side, moments about the origin', &
      contact_columns%name, '  active   stick    slip', error)
  end subroutine create_contact_table

  !> Writes the contact sums of one end time.
  subroutine write_contacts(table, step, time, rows, error)
    type(table_t), intent(inout) :: table !! open table
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    type(contact_row_t), intent(in) :: rows(:) !! (pairs) sums over the points of each pair
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp) :: values(size(contact_columns), size(rows))
    character(3*step_width) :: counts(size(rows))
    integer :: i

    do i = 1, size(rows)
      write (counts(i), '(3i8)') contact_counts(rows(i))
      values(:, i) = contact_values(rows(i))
    end do
    call write_rows(table, step, time, values, error, counts)
  end subroutine write_contacts

  !> Creates the table of displacements of single degrees of freedom.
  subroutine create_history_table(table, path, title, requests, error)
    type(table_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: title !! title of the deck
    type(history_request_t), intent(in) :: requests(:) !! the columns
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(19), allocatable :: columns(:)
    integer :: i

    call open_table(table, path, '', [string_t ::], error)
    allocate (columns(size(requests)))
    do i = 1, size(requests)
      columns(i) = 'u'//to_text(requests(i)%dof)//'@'//to_text(requests(i)%node)
    end do
    call write_head(table, title, 'displacements: u<direction>@<node>', columns, error=error)
  end subroutine create_history_table

  !> Writes the requested displacements of one end time.
  subroutine write_history(table, step, time, values, error)
    type(table_t), intent(inout) :: table !! open table
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    real(wp), intent(in) :: values(:) !! (requests) displacements [length]
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_line(table%file, row_start(step, time)//reals(values), error)
    call flush_text_file(table%file, error)
  end subroutine write_history

  !> Creates the table of rigid bodies; `write_rows` writes it.
  subroutine create_rigid_table(table, path, title, bodies, error)
    type(table_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: title !! title of the deck
    type(rigid_body_t), intent(in) :: bodies(:) !! the bodies, in the order of the rows
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(string_t) :: names(size(bodies))
    integer :: i

    do i = 1, size(bodies)
      names(i)%s = bodies(i)%name
    end do
    call open_table(table, path, 'body', names, error)
    call write_head(table, title, 'rigid bodies: translation and '// &
      'rotation vector of the point, force and moment of its constraint on the body', &
      rigid_columns%name, error=error)
  end subroutine create_rigid_table

  !> Creates the table of contact points.
  subroutine create_point_table(table, path, title, pairs, error)
    type(table_t), intent(out) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: title !! title of the deck
    type(pair_t), intent(in) :: pairs(:) !! its pairs
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(4), parameter :: columns(6) = [character(4) :: 'p', 't1', 't2', 't3', 'gap', 'slip']

    call open_table(table, path, 'pair', pair_names(pairs), error)
    call write_head(table, title, &
      'contact points: slave nodes (NTOS) or slave facets (GTOS), tractions on the slave side', &
      columns, '    point  status', error)
  end subroutine create_point_table

  !> Writes the points of one pair at one end time.
  subroutine write_points(table, step, time, pair, rows, error)
    type(table_t), intent(inout) :: table !! open table
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    integer, intent(in) :: pair !! place of the pair in the table
    type(point_row_t), intent(in) :: rows(:) !! its points
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(17) :: numbers
    integer :: i

    do i = 1, size(rows)
      write (numbers, '(i9, i8)') rows(i)%point, rows(i)%status
      call write_line(table%file, row_start(step, time)//'  '//table%names(pair)%s//numbers// &
        reals(rows(i)%values), error)
    end do
    call flush_text_file(table%file, error)
  end subroutine write_points

  !> Writes the rows of one end time.
  subroutine write_rows(table, step, time, rows, error, counts)
    type(table_t), intent(inout) :: table !! open table
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    real(wp), intent(in) :: rows(:, :) !! (columns, names) the numbers
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(*), intent(in), optional :: counts(:) !! (names) columns of integers, as printed
    character(:), allocatable :: line
    integer :: i

    do i = 1, size(table%names)
      line = row_start(step, time)//'  '//table%names(i)%s
      if (present(counts)) line = line//counts(i)
      call write_line(table%file, line//reals(rows(:, i)), error)
    end do
    call flush_text_file(table%file, error)
  end subroutine write_rows

  !> Closes a table; one that was never created is left alone.
  subroutine close_table(table, error)
    type(table_t), intent(inout) :: table !! the table
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call close_text_file(table%file, error)
  end subroutine close_table

  !> Opens a table and keeps the names of its rows.
  subroutine open_table(table, path, key, names, error)
    type(table_t), intent(inout) :: table !! the table, open
    character(*), intent(in) :: path !! file name
    character(*), intent(in) :: key !! name of the column of names, empty for none
    type(string_t), intent(in) :: names(:) !! name of each row of an end time
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    table%key = key
    call pad_names(names, key, table%names)
    call create_text_file(table%file, path, error)
  end subroutine open_table

  !> Names of pairs.
  pure function pair_names(pairs) result(names)
    type(pair_t), intent(in) :: pairs(:) !! the pairs
    type(string_t) :: names(size(pairs))
    integer :: i

    do i = 1, size(pairs)
      names(i)%s = pairs(i)%name
    end do
  end function pair_names

  !> Writes the header lines: what the table is, and the names of its columns.
  subroutine write_head(table, title, what, columns, counts, error)
    type(table_t), intent(inout) :: table !! open table
    character(*), intent(in) :: title !! title of the deck
    character(*), intent(in) :: what !! meaning of the table
    character(*), intent(in) :: columns(:) !! names of the columns of reals
    character(*), intent(in), optional :: counts !! names of the columns of integers, as printed
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: line
    character(real_width + 2) :: column
    integer :: i

    call write_line(table%file, '# '//trim(adjustl(title)), error)
    call write_line(table%file, '# '//what, error)
    line = '#   step'//repeat(' ', real_width - 2)//'time'
    if (table%key /= '') line = line//'  '//padded(table%key, name_width(table%names, table%key))
    if (present(counts)) line = line//counts
    do i = 1, size(columns)
      column = repeat(' ', max(0, len(column) - len_trim(columns(i))))//columns(i)
      line = line//column
    end do
    call write_line(table%file, line, error)
    call flush_text_file(table%file, error)
  end subroutine write_head

  !> Step and time of a row.
  pure function row_start(step, time) result(line)
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    character(step_width + real_width + 2) :: line

    write (line, '(i8)') step
    line(step_width + 1:) = reals([time])
  end function row_start

  !> Reals as text, two blanks before each.
  pure function reals(values) result(line)
    real(wp), intent(in) :: values(:) !! any numbers
    character((real_width + 2)*size(values)) :: line
    integer :: i, first

    do i = 1, size(values)
      first = (i - 1)*(real_width + 2) + 1
      write (line(first:first + real_width + 1), '(2x,es21.12e3)') &
        merge(0.0_wp, values(i), abs(values(i)) <= 0.0_wp)
    end do
  end function reals

  !> Pads names to one width.
  pure subroutine pad_names(names, key, padded_names)
    type(string_t), intent(in) :: names(:) !! the names
    character(*), intent(in) :: key !! name of their column
    type(string_t), allocatable, intent(out) :: padded_names(:) !! the same, of one width
    integer :: i, width

    width = name_width(names, key)
    allocate (padded_names(size(names)))
    do i = 1, size(names)
      padded_names(i)%s = padded(names(i)%s, width)
    end do
  end subroutine pad_names

  !> Width of a column of names.
  pure integer function name_width(names, key) result(width)
    type(string_t), intent(in) :: names(:) !! the names
    character(*), intent(in) :: key !! name of their column
    integer :: i

    width = len(key)
    do i = 1, size(names)
      width = max(width, len_trim(names(i)%s))
    end do
  end function name_width

  !> A name with blanks behind it and underscores for those within, for blanks part the columns.
  pure function padded(name, width) result(t)
    character(*), intent(in) :: name !! name
    integer, intent(in) :: width !! length of the result
    character(width) :: t
    integer :: i

    t = name
    do i = 1, min(width, len_trim(name))
      if (t(i:i) == ' ' .or. t(i:i) == achar(9)) t(i:i) = '_'
    end do
  end function padded
end module tables

!> The tables of a results file: /history, one data set a column.
module results_tables
  use kinds, only: wp
  use errors, only: error_t
  use deck_types, only: name_length
  use model_types, only: model_t
  use result_types, only: end_row_t
  use table_columns, only: column_t, reaction_columns, count_columns, contact_columns, &
    rigid_columns, contact_counts, contact_values
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_data, only: make_series, make_text_series, write_block, at_end, stored_real, &
    stored_integer
  implicit none
  private
  public :: create_history_part, append_history, create_rigid_part, append_rigid

  !> Groups of the tables.
  character(*), parameter :: reactions = '/history/reactions/'
  character(*), parameter :: contact = '/history/contact/'
  character(*), parameter :: rigid = '/history/rigid/'

contains

  !> Makes the empty columns of the reaction and contact tables.
  subroutine create_history_part(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_group(file, '/history', error)
    call create_keys(file, reactions, 'set', error)
    call create_columns(file, reactions, reaction_columns, stored_real, &
      'force the support exerts on the structure', error)
    call create_keys(file, contact, 'pair', error)
    call create_columns(file, contact, count_columns, stored_integer, 'number of points', error)
    call create_columns(file, contact, contact_columns, stored_real, 'as in the .con table', error)
  end subroutine create_history_part

  !> Makes the empty columns of the table of rigid bodies.
  subroutine create_rigid_part(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call create_keys(file, rigid, 'body', error)
    call create_columns(file, rigid, rigid_columns, stored_real, 'as in the .rig table', error)
  end subroutine create_rigid_part

  !> Writes the rows of the rigid bodies of one end time.
  subroutine append_rigid(file, model, row, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(end_row_t), intent(in) :: row !! sums of an end time, rigid bodies among them
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(name_length) :: names(size(row%rigid, 2))
    integer :: i

    do i = 1, size(names)
      names(i) = model%conditions%rigid(i)%name
    end do
    call append_keys(file, rigid, 'body', row, names, error)
    call append_columns(file, rigid, rigid_columns, row%rigid, error)
  end subroutine append_rigid

  !> Makes a group with the empty columns that say what a row is about.
  subroutine create_keys(file, group, key, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group, with a slash at its end
    character(*), intent(in) :: key !! name of the column of names
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_group(file, group(:len(group) - 1), error)
    call make_series(file, group//'step', stored_integer, [integer ::], 1, '1', &
      'number of the output time', error)
    call make_series(file, group//'time', stored_real, [integer ::], 1, 'time', 'its time', error)
    call make_text_series(file, group//key, name_length, 'name of the '//key, error)
  end subroutine create_keys

  !> Makes the empty columns of numbers of a table.
  subroutine create_columns(file, group, columns, stored, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! its group, with a slash at its end
    type(column_t), intent(in) :: columns(:) !! the columns
    integer, intent(in) :: stored !! one of the stored constants
    character(*), intent(in) :: description !! what they mean
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    do i = 1, size(columns)
      call make_series(file, group//trim(columns(i)%name), stored, [integer ::], 1, &
        trim(columns(i)%unit), description, error)
    end do
  end subroutine create_columns

  !> Writes the rows of one end time.
  subroutine append_history(file, model, row, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(end_row_t), intent(in) :: row !! sums of an end time
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(name_length) :: sets(size(row%reactions, 2)), pairs(size(row%pairs))
    real(wp) :: values(size(contact_columns), size(pairs))
    integer :: counts(size(pairs), size(count_columns)), i

    do i = 1, size(sets)
      sets(i) = model%output%reactions(i)%s
    end do
    call append_keys(file, reactions, 'set', row, sets, error)
    call append_columns(file, reactions, reaction_columns, row%reactions, error)
    do i = 1, size(pairs)
      pairs(i) = model%pairs(i)%name
      counts(i, :) = contact_counts(row%pairs(i))
      values(:, i) = contact_values(row%pairs(i))
    end do
    call append_keys(file, contact, 'pair', row, pairs, error)
    do i = 1, size(count_columns)
      call write_block(file, contact//trim(count_columns(i)%name), counts(:, i), at_end, error)
    end do
    call append_columns(file, contact, contact_columns, values, error)
  end subroutine append_history

  !> Writes the columns that say what a row is about.
  subroutine append_keys(file, group, key, row, names, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group, with a slash at its end
    character(*), intent(in) :: key !! name of the column of names
    type(end_row_t), intent(in) :: row !! the end time
    character(*), intent(in), contiguous :: names(:) !! names of the rows
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_block(file, group//'step', spread(row%step, 1, size(names)), at_end, error)
    call write_block(file, group//'time', spread(row%time, 1, size(names)), at_end, error)
    call write_block(file, group//key, names, at_end, error)
  end subroutine append_keys

  !> Writes columns of numbers of a table.
  subroutine append_columns(file, group, columns, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! its group, with a slash at its end
    type(column_t), intent(in) :: columns(:) !! the columns
    real(wp), intent(in) :: values(:, :) !! (columns, rows) the numbers
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp) :: column(size(values, 2))
    integer :: i

    do i = 1, size(columns)
      column = values(i, :)
      call write_block(file, group//trim(columns(i)%name), column, at_end, error)
    end do
  end subroutine append_columns
end module results_tables

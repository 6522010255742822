!> The tables of a results file: /history, one data set a column, and /contact, the contact points.
module results_tables
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use deck_types, only: name_length
  use friction_laws, only: keeps_path, path_state
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use model_types, only: model_t
  use result_types, only: end_row_t, point_fields_t
  use table_columns, only: column_t, reaction_columns, count_columns, contact_columns, &
    rigid_columns, contact_counts, contact_values
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, make_text_series, write_block, at_end, stored_real, &
    stored_integer
  implicit none
  private
  public :: create_history_part, append_history, create_rigid_part, append_rigid, &
    create_contact_part, append_contact

  !> Groups of the tables.
  character(*), parameter :: reactions = '/history/reactions/'
  character(*), parameter :: contact = '/history/contact/'
  character(*), parameter :: rigid = '/history/rigid/'

contains

  !> Makes the empty columns of the reaction and contact tables.
  subroutine create_history_part(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_group(file, '/history', error)
    if (allocated(error)) return
    call create_keys(file, reactions, 'set', error)
    if (allocated(error)) return
    call create_columns(file, reactions, reaction_columns, stored_real, &
      'force the support exerts on the structure', error)
    if (allocated(error)) return
    call create_keys(file, contact, 'pair', error)
    if (allocated(error)) return
    call create_columns(file, contact, count_columns, stored_integer, 'number of points', error)
    if (allocated(error)) return
    call create_columns(file, contact, contact_columns, stored_real, 'as in the .con table', error)
  end subroutine create_history_part

  !> Makes the empty columns of the table of rigid bodies.
  subroutine create_rigid_part(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call create_keys(file, rigid, 'body', error)
    if (.not. allocated(error)) call create_columns(file, rigid, rigid_columns, stored_real, &
      'as in the .rig table', error)
  end subroutine create_rigid_part

  !> Writes the rows of the rigid bodies of one end time.
  subroutine append_rigid(file, model, row, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(end_row_t), intent(in) :: row !! sums of an end time, rigid bodies among them
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(name_length) :: names(size(row%rigid, 2))
    integer :: i

    do i = 1, size(names)
      names(i) = model%conditions%rigid(i)%name
    end do
    call append_keys(file, rigid, 'body', row, names, error)
    if (.not. allocated(error)) call append_columns(file, rigid, rigid_columns, row%rigid, error)
  end subroutine append_rigid

  !> Makes a group with the empty columns that say what a row is about.
  subroutine create_keys(file, group, key, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group, with a slash at its end
    character(*), intent(in) :: key !! name of the column of names
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_group(file, group(:len(group) - 1), error)
    if (allocated(error)) return
    call make_series(file, group//'step', stored_integer, [integer ::], 1, '1', &
      'number of the end time', error)
    if (allocated(error)) return
    call make_series(file, group//'time', stored_real, [integer ::], 1, 'time', 'its time', error)
    if (allocated(error)) return
    call make_text_series(file, group//key, name_length, 'name of the '//key, error)
  end subroutine create_keys

  !> Makes the empty columns of numbers of a table.
  subroutine create_columns(file, group, columns, stored, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! its group, with a slash at its end
    type(column_t), intent(in) :: columns(:) !! the columns
    integer, intent(in) :: stored !! one of the stored constants
    character(*), intent(in) :: description !! what they mean
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    do i = 1, size(columns)
      call make_series(file, group//trim(columns(i)%name), stored, [integer ::], 1, &
        trim(columns(i)%unit), description, error)
      if (allocated(error)) return
    end do
  end subroutine create_columns

  !> Writes the rows of one end time.
  subroutine append_history(file, model, row, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(end_row_t), intent(in) :: row !! sums of an end time
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(name_length) :: sets(size(row%reactions, 2)), pairs(size(row%pairs))
    real(wp) :: values(size(contact_columns), size(pairs))
    integer :: counts(size(pairs), size(count_columns)), i

    do i = 1, size(sets)
      sets(i) = model%output%reactions(i)%s
    end do
    call append_keys(file, reactions, 'set', row, sets, error)
    if (allocated(error)) return
    call append_columns(file, reactions, reaction_columns, row%reactions, error)
    if (allocated(error)) return
    do i = 1, size(pairs)
      pairs(i) = model%pairs(i)%name
      counts(i, :) = contact_counts(row%pairs(i))
      values(:, i) = contact_values(row%pairs(i))
    end do
    call append_keys(file, contact, 'pair', row, pairs, error)
    do i = 1, size(count_columns)
      if (allocated(error)) return
      call write_block(file, contact//trim(count_columns(i)%name), counts(:, i), at_end, error)
    end do
    if (.not. allocated(error)) call append_columns(file, contact, contact_columns, values, error)
  end subroutine append_history

  !> Writes the columns that say what a row is about.
  subroutine append_keys(file, group, key, row, names, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group, with a slash at its end
    character(*), intent(in) :: key !! name of the column of names
    type(end_row_t), intent(in) :: row !! the end time
    character(*), intent(in), contiguous :: names(:) !! names of the rows
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call write_block(file, group//'step', spread(row%step, 1, size(names)), at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'time', spread(row%time, 1, size(names)), at_end, error)
    if (allocated(error)) return
    call write_block(file, group//key, names, at_end, error)
  end subroutine append_keys

  !> Writes columns of numbers of a table.
  subroutine append_columns(file, group, columns, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! its group, with a slash at its end
    type(column_t), intent(in) :: columns(:) !! the columns
    real(wp), intent(in) :: values(:, :) !! (columns, rows) the numbers
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: column(size(values, 2))
    integer :: i

    do i = 1, size(columns)
      column = values(i, :)
      call write_block(file, group//trim(columns(i)%name), column, at_end, error)
      if (allocated(error)) return
    end do
  end subroutine append_columns

  !> Makes the empty data sets of the contact points, and writes what does not change.
  subroutine create_contact_part(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    call make_group(file, '/contact', error)
    if (allocated(error)) return
    call make_series(file, '/contact/step', stored_integer, [integer ::], 1, '1', &
      'number of the end time', error)
    if (allocated(error)) return
    call make_series(file, '/contact/time', stored_real, [integer ::], 1, 'time', 'its time', error)
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call create_pair(file, model%pairs(i), error)
    end do
  end subroutine create_contact_part

  !> Makes the group of one pair.
  subroutine create_pair(file, pair, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(:), allocatable :: group

    group = '/contact/'//to_text(pair%number)
    call make_group(file, group, error)
    if (allocated(error)) return
    call write_attribute(file, group, 'name', pair%name, error)
    if (allocated(error)) return
    call create_points(file, pair, group, error)
    if (allocated(error)) return
    call make_series(file, group//'/facets', stored_integer, [3], size(pair%surface%facets, 2), &
      '1', &
      'corner nodes of the master facets, counter-clockwise seen from outside', error)
    if (allocated(error)) return
    call write_block(file, group//'/facets', pair%surface%facets, at_end, error)
    if (allocated(error)) return
    call create_point_fields(file, group, count_points(pair), error)
    if (allocated(error) .or. .not. keeps_path(pair%law)) return
    call make_series(file, group//'/'//trim(path_state%name), stored_real, [count_points(pair)], &
      1, trim(path_state%unit), trim(path_state%description), error)
  end subroutine create_pair

  !> Writes what the points are made of: a node each, or nodes and weights.
  subroutine create_points(file, pair, group, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    character(*), intent(in) :: group !! its group
    type(error_t), allocatable, intent(out) :: error !! file trouble

    if (pair%points%n_slaves == 1) then
      call make_series(file, group//'/node', stored_integer, [integer ::], count_points(pair), &
        '1', 'slave node of each point', error)
      if (allocated(error)) return
      call write_block(file, group//'/node', reshape(pair%points%point_nodes, &
        [count_points(pair)]), at_end, error)
    else if (pair%segmented) then
      call make_series(file, group//'/node', stored_integer, [3, count_points(pair)], 1, '1', &
        'corner nodes of the slave facet of each point', error)
      if (allocated(error)) return
      call make_series(file, group//'/weight', stored_real, [3, count_points(pair)], 1, '1', &
        'weights of the corners: a point is the weighted sum of its nodes', error)
    else
      call make_series(file, group//'/node', stored_integer, [pair%points%n_slaves], &
        count_points(pair), &
        '1', 'corner nodes of the slave facet of each point', error)
      if (allocated(error)) return
      call write_block(file, group//'/node', pair%points%point_nodes, at_end, error)
      if (allocated(error)) return
      call make_series(file, group//'/weight', stored_real, [pair%points%n_slaves], &
        count_points(pair), &
        '1', 'weights of the corners: a point is the weighted sum of its nodes', error)
      if (allocated(error)) return
      call write_block(file, group//'/weight', pair%points%point_weights, at_end, error)
    end if
  end subroutine create_points

  !> Makes the empty data sets of the points of one pair.
  subroutine create_point_fields(file, group, points, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    integer, intent(in) :: points !! number of points
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, group//'/host', stored_integer, [points], 1, '1', &
      'master facet that holds the tip, from 1, 0 for none', error)
    if (allocated(error)) return
    call make_series(file, group//'/status', stored_integer, [points], 1, '1', &
      '-1 off, 0 open, 1 stick, 2 slip', error)
    if (allocated(error)) return
    call make_series(file, group//'/traction', stored_real, [3, points], 1, 'force', &
      'contact traction times tributary area: the force on the slave point', error)
    if (allocated(error)) return
    call make_series(file, group//'/gap', stored_real, [points], 1, 'length', &
      'normal gap g_N, negative in contact', error)
    if (allocated(error)) return
    call make_series(file, group//'/tip', stored_real, [2, points], 1, '1', &
      '(xi, eta) of the tip of the friction cone in its facet', error)
    if (allocated(error)) return
    call make_series(file, group//'/lay', stored_real, [3, points], 1, '1', &
      'unit principal axis of mu1 in the current facet', error)
    if (allocated(error)) return
    call make_series(file, group//'/lay_traction', stored_real, [3, points], 1, 'force', &
      'traction along the axis of mu1, across it, and along the outward normal', error)
    if (allocated(error)) return
    call make_series(file, group//'/elastic_slip', stored_real, [points], 1, 'length', &
      'length of the tangential part of the gap vector', error)
    if (allocated(error)) return
    call make_series(file, group//'/dissipation', stored_real, [points], 1, 'force length', &
      'work that friction has taken up to now', error)
  end subroutine create_point_fields

  !> Writes the contact points of one end time.
  subroutine append_contact(file, model, step, time, pairs, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    type(point_fields_t), intent(in) :: pairs(:) !! the points of each pair
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    do i = 1, size(pairs)
      call append_points(file, '/contact/'//to_text(model%pairs(i)%number), pairs(i), error)
      if (allocated(error)) return
    end do
    call write_block(file, '/contact/time', [time], at_end, error)
    if (allocated(error)) return
    call write_block(file, '/contact/step', [step], at_end, error)
  end subroutine append_contact

  !> Writes the points of one pair.
  subroutine append_points(file, group, points, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    type(point_fields_t), intent(in) :: points !! the points
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call write_block(file, group//'/host', points%host, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/status', points%status, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/traction', points%traction, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/gap', points%gap, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/tip', points%tip, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/lay', points%lay, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/lay_traction', points%lay_traction, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/elastic_slip', points%elastic_slip, at_end, error)
    if (allocated(error)) return
    call write_block(file, group//'/dissipation', points%dissipation, at_end, error)
    if (allocated(error)) return
    if (allocated(points%path)) call write_block(file, group//'/'//trim(path_state%name), &
      points%path, at_end, error)
    if (allocated(error) .or. .not. allocated(points%node)) return
    call write_block(file, group//'/node', points%node, at_end, error)
    if (.not. allocated(error)) call write_block(file, group//'/weight', points%weight, at_end, &
      error)
  end subroutine append_points
end module results_tables

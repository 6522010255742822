!> The contact points of a results file: /contact, a group for each pair.
module results_points
  use, intrinsic :: iso_c_binding, only: c_associated, c_ptr
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use element_types, only: status_open
  use friction_return, only: has_friction
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use model_types, only: model_t
  use result_fields, only: field_t, native_type, create_field, over_near, over_closed
  use point_fields, only: point_fields_t, contact_fields, address_of, is_written
  use results_scene, only: write_pair_scene
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, write_block, at_end, stored_real, stored_integer
  use hdf5_held, only: hold_block, hold_any
  implicit none
  private
  public :: create_contact_part, append_contact

contains

  !> Makes the empty data sets of the contact points, and writes what does not change.
  subroutine create_contact_part(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call make_group(file, '/contact', error)
    call make_series(file, '/contact/step', stored_integer, [integer ::], 1, '1', &
      'number of the output time', error)
    call make_series(file, '/contact/time', stored_real, [integer ::], 1, 'time', 'its time', error)
    call make_series(file, '/contact/begin', stored_real, [integer ::], 1, 'time', &
      'when the increment began that ended then', error)
    do i = 1, size(model%pairs)
      call create_pair(file, model%pairs(i), error)
    end do
  end subroutine create_contact_part

  !> Makes the group of one pair.
  subroutine create_pair(file, pair, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: group
    integer :: i

    group = '/contact/'//to_text(pair%number)
    call make_group(file, group, error)
    call write_attribute(file, group, 'name', pair%name, error)
    call create_points(file, pair, group, error)
    call make_series(file, group//'/facets', stored_integer, [3], size(pair%surface%facets, 2), &
      '1', 'corner nodes of the master facets, counter-clockwise seen from outside', error)
    call write_block(file, group//'/facets', pair%surface%facets, at_end, error)
    do i = 1, size(contact_fields)
      if (.not. is_written(contact_fields(i), pair)) cycle
      call create_field(file, group//'/', contact_fields(i), [0, count_points(pair), 0], &
        file%blocks, error)
    end do
    if (any(has_friction(pair%friction%mu))) call create_touches(file, group, error)
    call write_pair_scene(file, pair, group, error)
  end subroutine create_pair

  !> Makes the empty data sets of first touches.
  subroutine create_touches(file, group, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_series(file, group//'/touch_node', stored_integer, [integer ::], 1, '1', &
      'nodes of closed points where some touched first; 0 begins an output time', error)
    call make_series(file, group//'/touch', stored_real, [4], 1, 'length', &
      'number of the output time; displacement of a node without friction at new '// &
      'points, and the first touch of its body as a share of the increment, -1: not foreseen', &
      error)
  end subroutine create_touches

  !> Writes what the points are made of: a node each, or nodes and weights.
  subroutine create_points(file, pair, group, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    character(*), intent(in) :: group !! its group
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    if (pair%points%n_slaves == 1) then
      call make_series(file, group//'/node', stored_integer, [integer ::], count_points(pair), &
        '1', 'slave node of each point', error)
      call write_block(file, group//'/node', reshape(pair%points%point_nodes, &
        [count_points(pair)]), at_end, error)
    else if (pair%segmented) then
      call make_series(file, group//'/node', stored_integer, [pair%points%n_slaves, &
        count_points(pair)], 1, '1', 'nodes of the slave facet of each point', error, &
        file%blocks)
      call make_series(file, group//'/weight', stored_real, [pair%points%n_slaves, &
        count_points(pair)], 1, '1', 'weights of its nodes: a point is their weighted sum', &
        error, file%blocks)
    else
      call make_series(file, group//'/node', stored_integer, [pair%points%n_slaves], &
        count_points(pair), &
        '1', 'corner nodes of the slave facet of each point', error)
      call write_block(file, group//'/node', pair%points%point_nodes, at_end, error)
      call make_series(file, group//'/weight', stored_real, [pair%points%n_slaves], &
        count_points(pair), &
        '1', 'weights of the corners: a point is the weighted sum of its nodes', error)
      call write_block(file, group//'/weight', pair%points%point_weights, at_end, error)
    end if
    call create_areas(file, pair, group, error)
  end subroutine create_points

  !> Makes the areas of the points; where these do not change, they are written.
  subroutine create_areas(file, pair, group, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    character(*), intent(in) :: group !! its group
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(*), parameter :: meaning = 'reference area of each point, 0 without facets'

    if (pair%segmented) then
      call make_series(file, group//'/area', stored_real, [count_points(pair)], 1, 'length^2', &
        meaning, error, file%blocks)
    else
      call make_series(file, group//'/area', stored_real, [integer ::], count_points(pair), &
        'length^2', meaning, error)
      call write_block(file, group//'/area', pair%points%area, at_end, error)
    end if
  end subroutine create_areas

  !> Adds the contact points of one end time, which wait in memory.
  subroutine append_contact(file, model, step, time, began, pairs, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time [time]
    real(wp), intent(in) :: began !! when its increment began [time]
    type(point_fields_t), intent(in) :: pairs(:) !! the points of each pair
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    do i = 1, size(pairs)
      call append_points(file, '/contact/'//to_text(model%pairs(i)%number), pairs(i), step, error)
    end do
    call hold_block(file, '/contact/time', [time], error)
    call hold_block(file, '/contact/begin', [began], error)
    call hold_block(file, '/contact/step', [step], error)
  end subroutine append_contact

  !> Adds the points of one pair.
  subroutine append_points(file, group, points, step, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    type(point_fields_t), intent(in), target :: points !! the points
    integer, intent(in) :: step !! number of the end time
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    do i = 1, size(contact_fields)
      call append_field(file, group, contact_fields(i), points, error)
    end do
    if (allocated(points%patch)) call hold_block(file, group//'/patch', points%patch, error)
    if (allocated(points%touch)) then
      call hold_block(file, group//'/touch_node', [0, points%touch_node], error)
      call hold_block(file, group//'/touch', reshape([real(step, wp), 0.0_wp, 0.0_wp, 0.0_wp, &
        points%touch], [4, size(points%touch_node) + 1]), error)
    end if
    if (.not. allocated(points%node)) return
    call hold_block(file, group//'/node', points%node, error)
    call hold_block(file, group//'/weight', points%weight, error)
    call hold_block(file, group//'/area', points%cell, error)
  end subroutine append_points

  !> Adds one field of them, if they have it.
  subroutine append_field(file, group, field, points, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    type(field_t), intent(in) :: field !! the field
    type(point_fields_t), intent(in), target :: points !! the points
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(c_ptr) :: address

    address = address_of(points, field%name)
    if (c_associated(address)) call hold_any(file, group//'/'//trim(field%name), &
      native_type(field), address, field%components*rows_of(field, points), error)
  end subroutine append_field

  !> How many points a field has values of.
  pure integer function rows_of(field, points) result(n)
    type(field_t), intent(in) :: field !! one of contact_fields
    type(point_fields_t), intent(in) :: points !! the points

    select case (field%over)
    case (over_near)
      n = count(points%target > 0)
    case (over_closed)
      n = count(points%status > status_open)
    case default
      n = size(points%target)
    end select
  end function rows_of
end module results_points

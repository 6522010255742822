!> How a field of a results file is declared: once, with what its data set, those who write and read
!! it, and the tables of doc/manual.md take from there (doc/fields.py).
module result_fields
  use hdf5, only: hid_t, h5t_native_integer, h5t_native_double
  use errors, only: error_t
  use hdf5_io, only: hdf5_file_t, exists_in
  use hdf5_data, only: make_series, series_shape, stored_real
  implicit none
  private
  public :: field_t, field_shape, native_type, create_field, entries_of, over_one, over_nodes, &
    over_points, over_bodies, over_apex_slopes, over_node_slopes, over_contact_nodes, over_memory, &
    over_near, over_closed

  !> What a field has values for: the end time as a whole, the nodes, the points of a pair, rigid
  !! bodies; with derivatives the points of all pairs and the nodes of their surfaces, parameter
  !! after parameter, and those nodes once; what the points of the bulk remember. Of points with a
  !! facet and of closed points there are as many at an end time as `host` and `status` say: a row
  !! each, one end time behind the other.
  integer, parameter :: over_one = 0
  integer, parameter :: over_nodes = 1
  integer, parameter :: over_points = 2
  integer, parameter :: over_bodies = 3
  integer, parameter :: over_apex_slopes = 4
  integer, parameter :: over_node_slopes = 5
  integer, parameter :: over_contact_nodes = 6
  integer, parameter :: over_memory = 7
  integer, parameter :: over_near = 8
  integer, parameter :: over_closed = 9

  !> A field: a data set with one entry for each end time.
  type :: field_t
    character(20) :: name = '' !! of its data set
    integer :: stored = 0 !! one of the stored constants of hdf5_data
    integer :: components = 1 !! numbers for each of what it has values for
    integer :: over = over_one !! what it has values for
    character(16) :: unit = '' !! [1], [length] and so on
    character(144) :: description = '' !! for people
    integer :: part = 0 !! when it is there: one of the parts its list knows, 0 for always
  end type field_t

contains

  !> Dimensions of an entry.
  pure function field_shape(field, counts) result(dims)
    type(field_t), intent(in) :: field !! the field
    integer, intent(in) :: counts(:) !! (7) how many of each there are
    integer, allocatable :: dims(:)

    dims = [integer ::]
    if (field%components > 1) dims = [field%components]
    if (field%over /= over_one) dims = [dims, counts(field%over)]
  end function field_shape

  !> HDF5's type of its numbers in memory.
  integer(hid_t) function native_type(field)
    type(field_t), intent(in) :: field !! the field

    native_type = merge(h5t_native_double, h5t_native_integer, field%stored == stored_real)
  end function native_type

  !> Makes the empty data set.
  subroutine create_field(file, group, field, counts, blocks, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! its group, with a slash at its end
    type(field_t), intent(in) :: field !! the field
    integer, intent(in) :: counts(:) !! (7) how many of each there are
    integer, intent(in) :: blocks !! entries in a chunk
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    if (field%over >= over_near) then
      call make_series(file, group//trim(field%name), field%stored, pack([field%components], &
        field%components > 1), counts(over_points), trim(field%unit), trim(field%description), &
        error)
    else
      call make_series(file, group//trim(field%name), field%stored, field_shape(field, counts), 1, &
        trim(field%unit), trim(field%description), error, blocks)
    end if
  end subroutine create_field

  !> Entries that a data set has; 0 if it is not there.
  integer function entries_of(file, path) result(n)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set; its group is there
    integer :: dims(3), rank

    n = 0
    if (.not. exists_in(file, path)) return
    call series_shape(file, path, dims, rank)
    if (rank > 0) n = dims(rank)
  end function entries_of
end module result_fields

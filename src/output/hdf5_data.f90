!> HDF5 in three layers, the middle one: data sets that grow along their last dimension.
!!
!! All are chunked, large ones of integers shuffled and deflated; they carry a unit and a
!! description, and record no times, so that equal runs give equal files. Fortran's (3, n) is
!! (n, 3) in C and Python.
module hdf5_data
  use, intrinsic :: iso_c_binding, only: c_f_pointer, c_loc, c_long, c_ptr
  use, intrinsic :: iso_fortran_env, only: int32
  use hdf5, only: hid_t, hsize_t, h5screate_simple_f, h5sclose_f, h5pcreate_f, h5pclose_f, &
    h5pset_chunk_f, h5pset_shuffle_f, h5pset_deflate_f, h5pset_obj_track_times_f, h5dcreate_f, &
    h5dget_space_f, h5dset_extent_f, h5dwrite_f, h5dread_f, &
    h5sselect_hyperslab_f, h5tclose_f, &
    h5p_dataset_create_f, h5s_select_set_f, h5s_unlimited_f, h5t_std_i32le, h5t_std_i64le, &
    h5t_std_u8le, h5t_ieee_f32le, h5t_ieee_f64le, h5t_native_integer, h5t_native_double, &
    size_t, h5p_dataset_access_f, h5pset_chunk_cache_f
  use kinds, only: wp
  use errors, only: error_t
  use checksums, only: block_sum
  use hdf5_io, only: hdf5_file_t, data_set_t, raise_hdf5, string_type, keep_open, find_data_set, &
    ask_extent, max_rank
  use hdf5_index, only: chunk_entries, chunk_least
  use hdf5_attributes, only: write_attribute
  implicit none
  private
  public :: make_series, make_text_series, write_block, read_block, move_block, words_at, &
    series_shape
  public :: stored_real, stored_integer, stored_long, stored_byte, stored_single, at_end

  !> How numbers are stored: 64-bit real, 32-bit integer, 64-bit integer, unsigned byte, 32-bit
  !! real.
  integer, parameter :: stored_real = 1
  integer, parameter :: stored_integer = 2
  integer, parameter :: stored_long = 3
  integer, parameter :: stored_byte = 4
  integer, parameter :: stored_single = 5

  !> In place of a first entry: behind the last one.
  integer, parameter :: at_end = 0
  !> Bytes of a chunk of strings, as long as one is not longer.
  integer, parameter :: text_chunk = 4096
  !> Level of compression: higher ones cost time and gain next to nothing. Reals are stored as they
  !! are: their digits hardly compress, and trying to would be a large share of a short run.
  integer, parameter :: deflate_level = 1

  !> Writes a block of whole entries of the last dimension: behind the last one, or from the entry
  !! `first` on.
  interface write_block
    module procedure write_reals
    module procedure write_real_columns
    module procedure write_integers
    module procedure write_integer_columns
    module procedure write_texts
  end interface write_block

  !> Reads a block of whole entries of the last dimension, from the entry `first` on.
  interface read_block
    module procedure read_reals
    module procedure read_real_columns
    module procedure read_integers
    module procedure read_integer_columns
  end interface read_block

contains

  !> Makes an empty data set of numbers; its last dimension grows.
  subroutine make_series(file, path, stored, leading, block, unit, description, error, blocks)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! name with its groups
    integer, intent(in) :: stored !! one of the stored constants
    integer, intent(in) :: leading(:) !! dimensions before the last
    integer, intent(in) :: block !! entries of the last dimension that come in one go
    character(*), intent(in) :: unit !! unit of the numbers, '1' for none
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, intent(in), optional :: blocks !! in a chunk: 1 if it is not given
    integer(hid_t) :: type_id

    select case (stored)
    case (stored_integer)
      type_id = h5t_std_i32le
    case (stored_long)
      type_id = h5t_std_i64le
    case (stored_byte)
      type_id = h5t_std_u8le
    case (stored_single)
      type_id = h5t_ieee_f32le
    case default
      type_id = h5t_ieee_f64le
    end select
    call make_data_set(file, path, type_id, leading, block, error, blocks=blocks)
    if (allocated(error)) return
    file%sets(file%n_open)%single = stored == stored_single
    call describe(file, path, unit, description, error)
  end subroutine make_series

  !> Makes an empty data set of strings of one length.
  subroutine make_text_series(file, path, length, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! name with its groups
    integer, intent(in) :: length !! length of the strings
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: type_id
    integer :: status, none(0)

    call string_type(length, type_id, status)
    call make_data_set(file, path, type_id, none, 1, error, max(1, min(chunk_least, &
      text_chunk/max(1, length))))
    call h5tclose_f(type_id, status)
    call describe(file, path, '1', description, error)
  end subroutine make_text_series

  !> Writes the two attributes that every data set carries.
  subroutine describe(file, path, unit, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    character(*), intent(in) :: unit !! unit of the numbers
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_attribute(file, path, 'unit', unit, error)
    call write_attribute(file, path, 'description', description, error)
  end subroutine describe

  !> Makes an empty data set of any type.
  subroutine make_data_set(file, path, type_id, leading, block, error, entries, blocks)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! name with its groups
    integer(hid_t), intent(in) :: type_id !! type in the file
    integer, intent(in) :: leading(:) !! dimensions before the last
    integer, intent(in) :: block !! entries of the last dimension that come in one go
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, intent(in), optional :: entries !! of the last dimension in a chunk
    integer, intent(in), optional :: blocks !! in a chunk
    integer(hsize_t) :: dims(max_rank), limits(max_rank), chunk(max_rank)
    integer(hid_t) :: space, creation, access, data_set
    integer :: s(12), rank, width, n

    if (allocated(error)) return
    s = 0
    space = -1_hid_t
    creation = -1_hid_t
    access = -1_hid_t
    data_set = -1_hid_t
    rank = size(leading) + 1
    width = max(1, product(leading))
    dims(:rank) = [int(leading, hsize_t), 0_hsize_t]
    limits(:rank) = [int(leading, hsize_t), h5s_unlimited_f]
    n = block
    if (present(blocks)) n = block*max(1, blocks)
    chunk(:rank) = max(1_hsize_t, [int(leading, hsize_t), chunk_entries(width, n)])
    if (present(entries)) chunk(rank) = int(entries, hsize_t)
    file%ahead = file%ahead + 8_c_long*width*max(0_hsize_t, chunk(rank) - block)
    call h5screate_simple_f(rank, dims, space, s(1), limits)
    call h5pcreate_f(h5p_dataset_create_f, creation, s(2))
    call h5pset_chunk_f(creation, rank, chunk, s(3))
    if (n == block .and. width*block >= chunk_least .and. type_id /= h5t_ieee_f64le &
        .and. type_id /= h5t_ieee_f32le) then
      call h5pset_shuffle_f(creation, s(4))
      call h5pset_deflate_f(creation, deflate_level, s(5))
    end if
    call h5pset_obj_track_times_f(creation, .false., s(6))
    call h5pcreate_f(h5p_dataset_access_f, access, s(10))
    ! no cache: a flush looks through all chunks that are in one, and so took longer with each
    call h5pset_chunk_cache_f(access, 1_size_t, 0_size_t, 0.0, s(11))
    call h5dcreate_f(file%id, path, type_id, space, data_set, s(7), dcpl_id=creation, &
      dapl_id=access)
    call h5pclose_f(access, s(12))
    call h5pclose_f(creation, s(8))
    call h5sclose_f(space, s(9))
    if (any(s < 0)) then
      call raise_hdf5(error, file, 'making the data set '//path)
    else
      call keep_open(file, path, data_set)
    end if
  end subroutine make_data_set

  !> Shape of a data set; zeros if it is not there.
  subroutine series_shape(file, path, dims, rank)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(out) :: dims(:) !! its dimensions, zeros behind the last and if they are more
    integer, intent(out) :: rank !! number of dimensions, 0 if it is not there
    integer :: place

    dims = 0
    rank = 0
    call find_data_set(file, path, place)
    if (place == 0) return
    associate (set => file%sets(place))
      if (set%rank == 0) call ask_extent(set%id, set%rank, set%extent)
      rank = set%rank
      if (rank <= size(dims)) dims(:rank) = int(set%extent(:rank))
    end associate
  end subroutine series_shape

  !> Selects a block of a data set: makes it long enough, and gives the two spaces.
  subroutine select_block(set, n_numbers, first, spaces, status)
    type(data_set_t), intent(inout) :: set !! open
    integer, intent(in) :: n_numbers !! numbers in the block
    integer, intent(in) :: first !! first entry from 1, or at_end
    integer(hid_t), intent(out) :: spaces(2) !! in memory, in the file
    integer, intent(out) :: status !! negative: failed
    integer(hsize_t) :: start(max_rank), n(max_rank)
    integer :: s(4)

    s = 0
    spaces = -1_hid_t
    status = -1
    if (set%rank == 0) call ask_extent(set%id, set%rank, set%extent)
    if (set%rank == 0) return
    associate (rank => set%rank, extent => set%extent)
      start = 0_hsize_t
      start(rank) = merge(extent(rank), int(first - 1, hsize_t), first == at_end)
      n = extent
      n(rank) = n_numbers/max(1_hsize_t, product(extent(:rank - 1)))
      if (start(rank) + n(rank) > extent(rank)) then
        extent(rank) = start(rank) + n(rank)
        call h5dset_extent_f(set%id, extent(:rank), s(1))
      end if
      call h5dget_space_f(set%id, spaces(2), s(2))
      call h5screate_simple_f(rank, n(:rank), spaces(1), s(3))
      call h5sselect_hyperslab_f(spaces(2), h5s_select_set_f, start(:rank), n(:rank), s(4))
    end associate
    if (s(1) < 0) set%rank = 0
    status = minval(s)
  end subroutine select_block

  !> Writes a block that lies anywhere in memory, or reads it.
  subroutine move_block(file, path, type_id, address, n_numbers, first, writes, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer(hid_t), intent(in) :: type_id !! type in memory
    type(c_ptr), intent(in) :: address !! the numbers, or where they go
    integer, intent(in) :: n_numbers !! how many
    integer, intent(in) :: first !! first entry, or at_end
    logical, intent(in) :: writes !! to the file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: spaces(2)
    type(c_ptr) :: target_address
    integer :: s(4), place

    if (n_numbers == 0 .or. allocated(error)) return
    s = 0
    spaces = -1_hid_t
    target_address = address
    call find_data_set(file, path, place)
    if (place == 0) then
      s(1) = -1
    else
      associate (set => file%sets(place))
        call select_block(set, n_numbers, first, spaces, s(1))
        if (s(1) >= 0 .and. writes) call h5dwrite_f(set%id, type_id, address, s(2), spaces(1), &
          spaces(2))
        if (s(1) >= 0 .and. .not. writes) call h5dread_f(set%id, type_id, target_address, s(2), &
          spaces(1), spaces(2))
      end associate
    end if
    call h5sclose_f(spaces(1), s(3))
    call h5sclose_f(spaces(2), s(4))
    if (any(s < 0)) call raise_hdf5(error, file, trim(merge('writing', 'reading', writes))// &
      ' the data set '//path)
    if (first /= at_end) call add_to_sum(file, path, type_id, address, n_numbers)
  end subroutine move_block

  !> The words of numbers of 32 or 64 bits.
  function words_at(address, type_id, n_numbers) result(words)
    type(c_ptr), intent(in) :: address !! the numbers
    integer(hid_t), intent(in) :: type_id !! their type
    integer, intent(in) :: n_numbers !! how many
    integer(int32), pointer :: words(:)

    call c_f_pointer(address, words, [merge(2, 1, type_id == h5t_native_double)*n_numbers])
  end function words_at

  !> Adds a block of numbers that has its place to the sum of the file; strings do not count.
  subroutine add_to_sum(file, path, type_id, address, n_numbers)
    type(hdf5_file_t), intent(inout) :: file !! its sum changes
    character(*), intent(in) :: path !! data set
    integer(hid_t), intent(in) :: type_id !! type in memory
    type(c_ptr), intent(in) :: address !! the numbers
    integer, intent(in) :: n_numbers !! how many

    if (type_id /= h5t_native_double .and. type_id /= h5t_native_integer) return
    file%sum = ieor(file%sum, block_sum(path, words_at(address, type_id, n_numbers)))
  end subroutine add_to_sum

  !> Writes a list of reals.
  subroutine write_reals(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(in), target, contiguous :: values(:) !! the numbers
    integer, intent(in) :: first !! first entry, or at_end
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_double, c_loc(values), size(values), first, .true., &
      error)
  end subroutine write_reals

  !> Writes columns of reals.
  subroutine write_real_columns(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(in), target, contiguous :: values(:, :) !! the numbers
    integer, intent(in) :: first !! first entry, or at_end
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_double, c_loc(values), size(values), first, .true., &
      error)
  end subroutine write_real_columns

  !> Writes a list of integers.
  subroutine write_integers(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(in), target, contiguous :: values(:) !! the numbers
    integer, intent(in) :: first !! first entry, or at_end
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_integer, c_loc(values), size(values), first, .true., &
      error)
  end subroutine write_integers

  !> Writes columns of integers.
  subroutine write_integer_columns(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(in), target, contiguous :: values(:, :) !! the numbers
    integer, intent(in) :: first !! first entry, or at_end
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_integer, c_loc(values), size(values), first, .true., &
      error)
  end subroutine write_integer_columns

  !> Writes strings.
  subroutine write_texts(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    character(*), intent(in), target, contiguous :: values(:) !! strings, as long as the data set's
    integer, intent(in) :: first !! first entry, or at_end
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: type_id
    integer :: status

    call string_type(len(values), type_id, status)
    call move_block(file, path, type_id, c_loc(values), size(values), first, .true., &
      error)
    call h5tclose_f(type_id, status)
  end subroutine write_texts

  !> Reads a list of reals.
  subroutine read_reals(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(out), target, contiguous :: values(:) !! the numbers
    integer, intent(in) :: first !! first entry
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_double, c_loc(values), size(values), first, .false., &
      error)
  end subroutine read_reals

  !> Reads columns of reals.
  subroutine read_real_columns(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    real(wp), intent(out), target, contiguous :: values(:, :) !! the numbers
    integer, intent(in) :: first !! first entry
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_double, c_loc(values), size(values), first, .false., &
      error)
  end subroutine read_real_columns

  !> Reads a list of integers.
  subroutine read_integers(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(out), target, contiguous :: values(:) !! the numbers
    integer, intent(in) :: first !! first entry
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_integer, c_loc(values), size(values), first, .false., &
      error)
  end subroutine read_integers

  !> Reads columns of integers.
  subroutine read_integer_columns(file, path, values, first, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(out), target, contiguous :: values(:, :) !! the numbers
    integer, intent(in) :: first !! first entry
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call move_block(file, path, h5t_native_integer, c_loc(values), size(values), first, .false., &
      error)
  end subroutine read_integer_columns
end module hdf5_data

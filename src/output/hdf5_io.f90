!> HDF5 in three layers, the lowest: files and groups, with every status checked.
!!
!! Attributes are in `hdf5_attributes`, data sets in `hdf5_data`; what stands where in a results
!! file is in `results_file`.
module hdf5_io
  use, intrinsic :: iso_c_binding, only: c_associated, c_char, c_int, c_long, c_null_char, c_ptr, &
    c_size_t
  use, intrinsic :: iso_fortran_env, only: int32, int64
  use hdf5, only: hid_t, hsize_t, size_t, h5open_f, h5dont_atexit_f, h5eset_auto_f, h5fcreate_f, &
    h5fopen_f, h5fclose_f, h5fflush_f, h5fget_filesize_f, h5gcreate_f, h5gclose_f, h5lexists_f, &
    h5pcreate_f, h5pclose_f, h5pset_obj_track_times_f, h5pset_istore_k_f, h5f_acc_trunc_f, &
    h5f_acc_rdonly_f, h5f_scope_global_f, h5p_file_create_f, h5dopen_f, h5dclose_f, &
    h5dget_space_f, h5sget_simple_extent_ndims_f, h5sget_simple_extent_dims_f, h5sclose_f
  use hdf5, only: h5tcopy_f, h5tset_size_f, h5tset_strpad_f, h5t_c_s1, h5t_str_nullpad_f
  use errors, only: error_t, raise, exit_resources
  use libc, only: c_fopen, c_fileno, c_fclose, c_posix_fallocate, c_truncate, c_pread, c_pwrite
  use text_files, only: rename_file, remove_file
  implicit none
  private
  public :: unfinished, hdf5_file_t, data_set_t, create_hdf5, publish_hdf5, open_hdf5, &
    reserve_room, flush_hdf5, close_hdf5, make_group, exists_in, raise_hdf5, string_type, &
    keep_open, find_data_set, ask_extent, max_rank

  !> Most dimensions that a data set of a results file has.
  integer, parameter :: max_rank = 4
  !> Ending of a file that is not complete.
  character(*), parameter :: unfinished = '.new'
  !> What HDF5 itself may need for its lists when all data sets grow [byte].
  integer(c_long), parameter :: overhead = 1048576_c_long

  !> A data set of an open file, and what is to be written behind its end.
  type :: data_set_t
    integer(hid_t) :: id = -1_hid_t !! its handle
    character(:), allocatable :: path !! its name with its groups
    integer :: rank = 0 !! its dimensions, 0 until they are asked for
    integer(hsize_t) :: extent(max_rank) = 0_hsize_t !! how long these are
    logical :: single = .false. !! reals have 32 bits in it
    integer(hid_t) :: held_type = -1_hid_t !! type of the numbers that wait in memory
    integer :: n_held = 0 !! how many they are
    integer(int32), allocatable :: held(:) !! the numbers, in words of 32 bits
  end type data_set_t

  !> An HDF5 file, and its data sets that are kept open: opening one costs more than writing a row.
  type :: hdf5_file_t
    integer(hid_t) :: id = -1_hid_t !! handle, negative while closed
    character(:), allocatable :: path !! name of the file
    integer :: end_times = 1 !! that will be written, foreseen
    integer :: blocks = 1 !! of these, as many as have their fields in one chunk
    integer(c_long) :: ahead = 0_c_long !! what chunks take beyond the blocks they begin with [byte]
    integer :: n_open = 0 !! number of data sets that are open
    type(data_set_t), allocatable :: sets(:) !! these
    integer :: last = 0 !! the one asked for last: they are asked for in turn
    integer :: flushes = 0 !! how often all was handed to the system
    integer(int64) :: sum = 0_int64 !! sum over the numbers written to given
    !! places or read since it was cleared
    logical :: reserved = .false. !! there may be reserved room behind its end
    integer(c_long) :: promised = 0_c_long !! length that its head has been given last [byte]
  end type hdf5_file_t

contains

  !> Creates a file, or empties the one that is there.
  subroutine create_hdf5(file, path, error, chunks)
    type(hdf5_file_t), intent(out) :: file !! the file, open
    character(*), intent(in) :: path !! its name
    type(error_t), allocatable, intent(inout) :: error !! no permission, no such folder
    integer, intent(in), optional :: chunks !! that a node of a data set's tree has room for, even
    integer(hid_t) :: creation
    integer :: s(4), status

    if (allocated(error)) return
    s = 0
    file%path = trim(path)
    creation = -1_hid_t
    call start_library(s(1))
    call h5pcreate_f(h5p_file_create_f, creation, s(2))
    call h5pset_obj_track_times_f(creation, .false., s(3))
    if (present(chunks)) call h5pset_istore_k_f(creation, chunks/2, s(4))
    call h5fcreate_f(file%path, h5f_acc_trunc_f, file%id, status, creation_prp=creation)
    if (any(s < 0) .or. status < 0) call raise_hdf5(error, file, 'creating')
    call h5pclose_f(creation, status)
  end subroutine create_hdf5

  !> Gives a file that was created under the name `path` with the ending `unfinished` its name, now
  !! that it can be read, in place of the file that has that name. One that could not be begun for
  !! an error is removed.
  subroutine publish_hdf5(file, path, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! its name
    type(error_t), allocatable, intent(inout) :: error !! why it is not complete; file trouble

    call flush_hdf5(file, error)
    if (.not. allocated(error)) call rename_file(file%path, path, error)
    if (allocated(error)) then
      call close_hdf5(file, error)
      call remove_file(path//unfinished)
    else
      file%path = path
    end if
  end subroutine publish_hdf5

  !> Opens a file for reading.
  subroutine open_hdf5(file, path, error)
    type(hdf5_file_t), intent(out) :: file !! the file, open
    character(*), intent(in) :: path !! its name
    type(error_t), allocatable, intent(out) :: error !! no such file, no HDF5 file
    integer :: s(2)

    file%path = trim(path)
    call start_library(s(1))
    call h5fopen_f(file%path, h5f_acc_rdonly_f, file%id, s(2))
    if (any(s < 0)) call raise_hdf5(error, file, 'opening')
  end subroutine open_hdf5

  !> Starts the HDF5 library. It shall not print, and not write at the end of the program what it
  !! could not write before: it crashes there when the disk is full.
  subroutine start_library(status)
    integer, intent(out) :: status !! negative: failed
    integer :: s(3)

    call h5dont_atexit_f(s(1))
    call h5open_f(s(2))
    call h5eset_auto_f(0, s(3))
    status = min(s(2), s(3))
  end subroutine start_library

  !> Hands everything written so far to the system. Reserved room is given back, and the head of the
  !! file tells what is there: whoever writes on has to reserve room anew.
  subroutine flush_hdf5(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! disk full
    integer :: status

    if (allocated(error)) return
    file%flushes = file%flushes + 1
    call h5fflush_f(file%id, h5f_scope_global_f, status)
    if (status >= 0) return
    call lengthen(file, file%promised)
    call raise_hdf5(error, file, 'flushing')
  end subroutine flush_hdf5

  !> Makes sure that the disk has room for what will be written next: HDF5 leaves a file that
  !! cannot be read if it finds no room half-way. The head of the file gets the new length at once:
  !! HDF5 writes it last, and a run killed before that leaves data beyond the end it tells.
  subroutine reserve_room(file, bytes, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer(c_long), intent(in) :: bytes !! what the data sets will grow by at most
    type(error_t), allocatable, intent(inout) :: error !! disk full
    type(c_ptr) :: stream
    integer(hsize_t) :: length
    integer(c_int) :: refused, ignored
    integer(c_long) :: room
    integer :: status

    if (allocated(error)) return
    room = bytes + file%ahead + overhead
    call h5fget_filesize_f(file%id, length, status)
    stream = c_fopen(file%path//c_null_char, 'r+'//c_null_char)
    refused = 1_c_int
    if (c_associated(stream) .and. status >= 0) then
      file%reserved = .true.
      refused = c_posix_fallocate(c_fileno(stream), int(length, c_long), room)
      if (refused == 0_c_int) then
        call promise_length(file, stream, int(length, c_long) + room)
      end if
      ignored = c_fclose(stream)
    end if
    if (refused /= 0_c_int) call raise_hdf5(error, file, 'making room for more')
  end subroutine reserve_room

  !> Writes a length of the file into its head, where that is of the first format, without a
  !! checksum (superblock version 0, or 1 with the room of a node; numbers of 8 bytes). A length
  !! that grows is written from the highest byte that changes down, with all lower ones full, and
  !! the file is made as long before: wherever a kill tears it, the head tells more than there was,
  !! and not more than there is. One that shrinks keeps to that if its low bytes come first. (Where
  !! the file crosses a multiple of 16 MB it would become longer by as much: there it is one write.)
  subroutine promise_length(file, stream, length)
    type(hdf5_file_t), intent(inout) :: file !! the file; what it has been promised
    type(c_ptr), intent(in) :: stream !! the same, open for writing
    integer(c_long), intent(in) :: length !! its length [byte]
    integer(c_long), parameter :: address_places(0:1) = [40_c_long, 44_c_long]
    integer, parameter :: version_at = 9, width_at = 14, most_top = 2
    character(kind=c_char) :: head(52)
    integer(c_long) :: done, old, new
    integer :: i, top, version

    file%promised = length
    done = c_pread(c_fileno(stream), head, size(head, kind=c_size_t), 0_c_long)
    if (done < size(head)) return
    version = iachar(head(version_at))
    if (version > ubound(address_places, 1) .or. iachar(head(width_at)) /= 8) return
    old = transfer(head(address_places(version) + 1:address_places(version) + 8), old)
    top = int(bit_size(old) - 1 - leadz(ieor(old, length)))/8
    if (length <= old .or. top > most_top) then
      done = c_pwrite(c_fileno(stream), bytes_of(length), 8_c_size_t, address_places(version))
      if (done < 8) file%promised = max(old, length)
      return
    end if
    new = ior(length, maskr(8*top, c_long))
    call lengthen(file, new)
    file%promised = new
    do i = top, 0, -1
      associate (byte => bytes_of(new))
        done = c_pwrite(c_fileno(stream), byte(i + 1:), 1_c_size_t, address_places(version) + i)
      end associate
    end do
  end subroutine promise_length

  !> The bytes of a number, lowest first.
  pure function bytes_of(number) result(bytes)
    integer(c_long), intent(in) :: number !! not negative
    character(kind=c_char) :: bytes(8)
    integer :: i

    do i = 1, 8
      bytes(i) = achar(int(ibits(number, 8*(i - 1), 8)), c_char)
    end do
  end function bytes_of

  !> Makes the file at least so long; what is added takes no room on the disk.
  subroutine lengthen(file, length)
    type(hdf5_file_t), intent(in) :: file !! the file
    integer(c_long), intent(in) :: length !! its length [byte]
    integer(c_int) :: ignored
    integer(c_long) :: present_length

    inquire (file=file%path, size=present_length)
    if (present_length < length) ignored = c_truncate(file%path//c_null_char, length)
  end subroutine lengthen

  !> Gives reserved room back when the file is closed, and its head the true length. Where the head
  !! cannot be written any more the file stays as long as that tells.
  subroutine give_back(file, length)
    type(hdf5_file_t), intent(inout) :: file !! the file
    integer(hsize_t), intent(in) :: length !! its bytes when it was closed
    integer(c_int) :: ignored
    integer(hsize_t) :: present_length
    type(c_ptr) :: stream

    stream = c_fopen(file%path//c_null_char, 'r+'//c_null_char)
    if (c_associated(stream)) then
      if (length < huge(length)) call promise_length(file, stream, int(length, c_long))
      ignored = c_fclose(stream)
    end if
    inquire (file=file%path, size=present_length)
    if (present_length > length) then
      ignored = c_truncate(file%path//c_null_char, max(int(length, c_long), file%promised))
    end if
    file%reserved = .false.
  end subroutine give_back

  !> Closes the file; a file that is not open is left alone.
  subroutine close_hdf5(file, error)
    type(hdf5_file_t), intent(inout) :: file !! the file
    type(error_t), allocatable, intent(inout) :: error !! disk full; one that came before
    !! stays
    integer(hsize_t) :: length
    integer :: s(3), i

    if (file%id < 0) return
    s = 0
    length = 0
    if (file%reserved) then
      call h5fflush_f(file%id, h5f_scope_global_f, s(3))
      call h5fget_filesize_f(file%id, length, s(1))
      if (s(1) < 0) length = huge(length)
    end if
    if (s(3) < 0) then
      ! what HDF5 holds back cannot be written: the file stays as the last end time has left it
      call lengthen(file, file%promised)
      call raise_hdf5(error, file, 'closing')
      file%id = -1_hid_t
      return
    end if
    do i = 1, file%n_open
      call h5dclose_f(file%sets(i)%id, s(2))
      s(1) = min(s(1), s(2))
    end do
    call h5fclose_f(file%id, s(2))
    if (any(s < 0)) call raise_hdf5(error, file, 'closing')
    if (file%reserved) call give_back(file, length)
    file%id = -1_hid_t
    file%n_open = 0
  end subroutine close_hdf5

  !> Keeps a data set open until the file is closed.
  subroutine keep_open(file, path, id)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! the data set
    integer(hid_t), intent(in) :: id !! its handle
    type(data_set_t), allocatable :: more(:)

    if (.not. allocated(file%sets)) allocate (file%sets(64))
    if (file%n_open == size(file%sets)) then
      allocate (more(2*file%n_open))
      more(:file%n_open) = file%sets
      call move_alloc(more, file%sets)
    end if
    file%n_open = file%n_open + 1
    file%sets(file%n_open)%id = id
    file%sets(file%n_open)%path = path
  end subroutine keep_open

  !> Finds a data set, opened if it is not open yet.
  subroutine find_data_set(file, path, place)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! the data set
    integer, intent(out) :: place !! among those that are open, 0 if it is not there
    integer(hid_t) :: id
    integer :: i, status

    do i = file%last + 1, file%last + file%n_open
      place = 1 + mod(i - 1, file%n_open)
      file%last = place
      if (len(file%sets(place)%path) /= len(path)) cycle
      if (file%sets(place)%path == path) return
    end do
    place = 0
    call h5dopen_f(file%id, path, id, status)
    if (status < 0) return
    call keep_open(file, path, id)
    place = file%n_open
  end subroutine find_data_set

  !> How many dimensions a data set has, and how long it is.
  subroutine ask_extent(data_set, rank, extent)
    integer(hid_t), intent(in) :: data_set !! its handle
    integer, intent(out) :: rank !! its dimensions, 0 if they cannot be had or are too many
    integer(hsize_t), intent(out) :: extent(:) !! (max_rank) how long each is
    integer(hsize_t) :: limits(max_rank)
    integer(hid_t) :: space
    integer :: s(4)

    s = 0
    extent = 0_hsize_t
    call h5dget_space_f(data_set, space, s(1))
    call h5sget_simple_extent_ndims_f(space, rank, s(2))
    if (any(s < 0) .or. rank < 1 .or. rank > max_rank) then
      rank = 0
    else
      call h5sget_simple_extent_dims_f(space, extent, limits, s(3))
      if (s(3) < 0) rank = 0
    end if
    call h5sclose_f(space, s(4))
  end subroutine ask_extent

  !> Makes a group.
  subroutine make_group(file, path, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: path !! group; those above it are there
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hid_t) :: group
    integer :: s(2)

    if (allocated(error)) return
    group = -1_hid_t
    call h5gcreate_f(file%id, path, group, s(1))
    call h5gclose_f(group, s(2))
    if (any(s < 0)) call raise_hdf5(error, file, 'making the group '//path)
  end subroutine make_group

  !> Whether a group or data set is there; those above it are.
  logical function exists_in(file, path) result(there)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: path !! group or data set
    integer :: status

    call h5lexists_f(file%id, path, there, status)
    if (status < 0) there = .false.
  end function exists_in

  !> A type for strings of one length, without a null at the end; to be closed by the caller.
  subroutine string_type(length, type_id, status)
    integer, intent(in) :: length !! length of the strings
    integer(hid_t), intent(out) :: type_id !! handle of the type
    integer, intent(out) :: status !! negative: failed
    integer :: s(3)

    call h5tcopy_f(h5t_c_s1, type_id, s(1))
    call h5tset_size_f(type_id, int(max(1, length), size_t), s(2))
    call h5tset_strpad_f(type_id, h5t_str_nullpad_f, s(3))
    status = minval(s)
  end subroutine string_type

  !> The error of an HDF5 call that failed.
  subroutine raise_hdf5(error, file, what)
    type(error_t), allocatable, intent(inout) :: error !! filled, unless one came before
    type(hdf5_file_t), intent(in) :: file !! the file
    character(*), intent(in) :: what !! what was tried, as in 'closing'

    if (.not. allocated(error)) call raise(error, exit_resources, 'error: '//what//' failed in '// &
      'the HDF5 file '//file%path//new_line('a')//'  Is the folder there, may you write to it, '// &
      'and is there room on the disk?')
  end subroutine raise_hdf5
end module hdf5_io

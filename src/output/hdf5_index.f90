!> Chunks of data sets, and lists of them that a kill cannot take away.
!!
!! HDF5 keeps the chunks of a data set in a tree. It makes the tree with the first entry and splits
!! it when it is full, and both times writes what points to a new node before the node: of a run
!! that is killed between the two the data set, with all that was in it before, cannot be read. So
!! every data set of a file that grows has its tree from the start (`begin_indexes`), and the nodes
!! are large enough for the end times to come (`node_chunks`).
module hdf5_index
  use, intrinsic :: iso_c_binding, only: c_char, c_loc, c_null_char
  use hdf5, only: hid_t, hsize_t, size_t, h5dget_space_f, h5dget_type_f, h5dset_extent_f, &
    h5dwrite_f, h5screate_simple_f, h5sclose_f, h5sselect_hyperslab_f, h5s_select_set_f, &
    h5tclose_f, h5tget_size_f
  use errors, only: error_t
  use hdf5_io, only: hdf5_file_t, raise_hdf5, ask_extent, max_rank
  implicit none
  private
  public :: begin_indexes, node_chunks, chunk_entries, blocks_in_chunk, chunk_least

  !> Chunks a node has room for: HDF5's own number, and the most. A node takes up to 49 bytes a
  !! chunk, in each data set.
  integer, parameter :: least_chunks = 64, most_chunks = 1024
  !> Numbers a chunk holds at most, and at least. A chunk that is filled in several goes is left
  !! uncompressed, so that it keeps its place in the file.
  integer, parameter :: chunk_limit = 131072
  integer, parameter :: chunk_least = 64
  !> Blocks of end times in a chunk, at most: the list of chunks, written with each new one, and the
  !! calls that write it are then a small part of what an end time costs.
  integer, parameter :: blocks_held = 64

contains

  !> Chunks a node of a tree shall have room for.
  elemental integer function node_chunks(entries) result(n)
    integer, intent(in) :: entries !! chunks that a data set will have, foreseen

    n = max(least_chunks, min(most_chunks, entries + mod(entries, 2)))
  end function node_chunks

  !> Entries of the last dimension in a chunk: whole blocks while they are small, so that a block
  !! does not touch a chunk that is already written; parts of a large one.
  pure integer(hsize_t) function chunk_entries(width, block) result(n)
    integer, intent(in) :: width !! numbers in an entry of the last dimension
    integer, intent(in) :: block !! entries that come in one go
    integer :: parts

    n = int(max(1, block), hsize_t)
    if (n*width > chunk_limit) then
      parts = int((n*width + chunk_limit - 1)/chunk_limit)
      n = (n + parts - 1)/parts
    else if (n*width < chunk_least) then
      n = n*(chunk_least/(n*width))
    end if
  end function chunk_entries

  !> Blocks in a chunk: as many as the limits allow, but so that the last chunk is about full.
  pure integer function blocks_in_chunk(numbers, blocks) result(n)
    integer, intent(in) :: numbers !! in a block
    integer, intent(in) :: blocks !! that will come, foreseen
    integer :: chunks

    n = max(1, min(blocks_held, chunk_limit/numbers))
    chunks = (max(1, blocks) + n - 1)/n
    n = (max(1, blocks) + chunks - 1)/chunks
  end function blocks_in_chunk

  !> Gives each empty data set of a file its tree.
  subroutine begin_indexes(file, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(hsize_t) :: dims(max_rank)
    integer :: i, rank, status

    if (allocated(error)) return
    do i = 1, file%n_open
      call ask_extent(file%sets(i)%id, rank, dims)
      status = min(0, rank - 1)
      if (rank > 0) then
        if (all(dims(:rank - 1) > 0) .and. dims(rank) == 0) call begin_index(file%sets(i)%id, &
          dims(:rank), status)
      end if
      if (status >= 0) cycle
      call raise_hdf5(error, file, 'beginning the data set '//file%sets(i)%path)
      return
    end do
  end subroutine begin_indexes

  !> Gives an empty data set its tree: writes an entry, and takes it back before it is on disk.
  subroutine begin_index(data_set, dims, status)
    integer(hid_t), intent(in) :: data_set !! the data set
    integer(hsize_t), intent(in) :: dims(:) !! its dimensions, the last 0
    integer, intent(out) :: status !! negative: failed
    integer(hsize_t) :: one(size(dims))
    integer(size_t) :: bytes
    integer(hid_t) :: type_id, space, memory
    character(kind=c_char), allocatable, target :: nothing(:)
    integer :: s(10)

    one = 1_hsize_t
    s = 0
    call h5dget_type_f(data_set, type_id, s(1))
    call h5tget_size_f(type_id, bytes, s(2))
    if (s(2) >= 0) allocate (nothing(bytes), source=c_null_char)
    call h5dset_extent_f(data_set, max(dims, one), s(3))
    call h5dget_space_f(data_set, space, s(4))
    call h5sselect_hyperslab_f(space, h5s_select_set_f, 0*one, one, s(5))
    call h5screate_simple_f(size(dims), one, memory, s(6))
    if (all(s >= 0)) call h5dwrite_f(data_set, type_id, c_loc(nothing), s(7), memory, space)
    call h5sclose_f(memory, s(8))
    call h5sclose_f(space, s(9))
    call h5tclose_f(type_id, s(10))
    status = minval(s)
    call h5dset_extent_f(data_set, dims, s(1))
    status = min(status, s(1))
  end subroutine begin_index
end module hdf5_index

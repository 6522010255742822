!> The restart part of a results file: the state before the last increment, from which first touches
!! are foreseen (doc/theory, "First touch"). It is empty in runs without friction.
module path_state
  use kinds, only: wp
  use errors, only: error_t
  use result_types, only: saved_state_t
  use hdf5_io, only: hdf5_file_t, exists_in
  use hdf5_data, only: make_series, series_shape, write_block, read_block, stored_real
  implicit none
  private
  public :: create_before, write_before, read_before

contains

  !> Makes the empty data sets.
  subroutine create_before(file, root, nodes, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: nodes !! number of nodes
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, root//'span_before', stored_real, [integer ::], 1, 'time', &
      'length of the increment that ended here; 0 or empty if it is not needed', error)
    if (allocated(error)) return
    call make_series(file, root//'displacement_before', stored_real, [3, nodes], 1, 'length', &
      'displacement at its start; empty if it is not needed', error)
  end subroutine create_before

  !> Writes the state before, if it is kept.
  subroutine write_before(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble

    if (.not. allocated(state%displacement_before)) return
    call write_block(file, root//'span_before', [state%span_before], slot, error)
    if (allocated(error)) return
    call write_block(file, root//'displacement_before', state%displacement_before, slot, error)
  end subroutine write_before

  !> Reads the state before, if it was kept; a file of an older program has none.
  subroutine read_before(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(inout) :: state !! displacement given; gets those before
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: values(1)
    integer :: dims(3), rank

    if (.not. exists_in(file, root//'span_before')) return
    call series_shape(file, root//'displacement_before', dims, rank)
    if (dims(rank) < slot) return
    call read_block(file, root//'span_before', values, slot, error)
    if (allocated(error)) return
    state%span_before = values(1)
    allocate (state%displacement_before, mold=state%displacement)
    call read_block(file, root//'displacement_before', state%displacement_before, slot, error)
  end subroutine read_before
end module path_state

!> The restart part of a results file: the free motions of rigid bodies with a point.
module rigid_state
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use model_types, only: model_t
  use rigid_paths, only: count_rigid
  use result_types, only: saved_state_t
  use hdf5_io, only: hdf5_file_t, exists_in
  use hdf5_data, only: make_series, series_shape, write_block, read_block, stored_real
  implicit none
  private
  public :: create_rigid, write_rigid, read_rigid_motions

  !> Name of the data set.
  character(*), parameter :: name = 'rigid'

contains

  !> Makes the empty data set, if there are such bodies.
  subroutine create_rigid(file, root, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    type(model_t), intent(in) :: model !! rigid bodies
    type(error_t), allocatable, intent(out) :: error !! file trouble

    if (count_rigid(model) == 0) return
    call make_series(file, root//name, stored_real, [6, count_rigid(model)], 1, &
      'length, radian', 'free translation and rotation vector of the points of rigid bodies', error)
  end subroutine create_rigid

  !> Writes the motions.
  subroutine write_rigid(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble

    if (.not. allocated(state%rigid)) return
    if (size(state%rigid, 2) > 0) call write_block(file, root//name, state%rigid, slot, error)
  end subroutine write_rigid

  !> Reads the motions; those of bodies that the deck does not have any more are dropped.
  subroutine read_rigid_motions(file, root, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    type(model_t), intent(in) :: model !! rigid bodies
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(inout) :: state !! gets rigid
    type(error_t), allocatable, intent(out) :: error !! file trouble, other bodies
    integer :: dims(3), rank, n

    n = count_rigid(model)
    dims = 0
    if (exists_in(file, root//name)) then
      call series_shape(file, root//name, dims, rank)
      allocate (state%rigid(6, dims(2)))
      call read_block(file, root//name, state%rigid, slot, error)
      if (allocated(error)) return
    end if
    if (n > 0 .and. dims(2) /= n) then
      call raise(error, exit_deck, 'it has '//to_text(dims(2))//' rigid bodies (RIGId), the '// &
        'deck '//to_text(n))
    else if (n == 0) then
      if (allocated(state%rigid)) deallocate (state%rigid)
      allocate (state%rigid(6, 0))
    end if
  end subroutine read_rigid_motions
end module rigid_state

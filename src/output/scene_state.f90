!> The restart part of a results file: the scene that a state belongs to, and how well it was in
!! balance (doc/manual, "Going on from a state").
module scene_state
  use kinds, only: wp
  use errors, only: error_t
  use result_types, only: saved_state_t
  use hdf5_io, only: hdf5_file_t, exists_in
  use hdf5_data, only: make_series, write_block, read_block, stored_real, stored_integer
  implicit none
  private
  public :: create_scene, write_scene, read_scene

contains

  !> Makes the empty data sets.
  subroutine create_scene(file, root, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, root//'scene', stored_integer, [4], 1, '1', &
      'sums over what its balance rests on (loads, supports, materials, pairs) and its time', error)
    if (allocated(error)) return
    call make_series(file, root//'residual', stored_real, [integer ::], 1, '1', &
      'residual over the force scale when it was accepted', error)
  end subroutine create_scene

  !> Writes both.
  subroutine write_scene(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call write_block(file, root//'scene', state%scene, slot, error)
    if (.not. allocated(error)) call write_block(file, root//'residual', [state%residual], slot, &
      error)
  end subroutine write_scene

  !> Reads both; a file of an older program has none, and its balance is not known.
  subroutine read_scene(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(inout) :: state !! gets scene, residual
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: values(1)

    if (.not. exists_in(file, root//'scene')) return
    call read_block(file, root//'scene', state%scene, slot, error)
    if (allocated(error)) return
    call read_block(file, root//'residual', values, slot, error)
    if (.not. allocated(error)) state%residual = values(1)
  end subroutine read_scene
end module scene_state

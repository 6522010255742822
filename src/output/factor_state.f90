!> The restart part of a results file: the state at which the factors of a bulk that is not linear
!! were made, and how long they have served (doc/theory, "A bulk that is not linear"). It is empty
!! where they are those of the bodies at rest.
module factor_state
  use kinds, only: wp
  use errors, only: error_t
  use result_types, only: saved_state_t
  use hdf5_io, only: hdf5_file_t, exists_in
  use hdf5_data, only: make_series, series_shape, write_block, read_block, stored_real
  implicit none
  private
  public :: create_factor, write_factor, read_factor

contains

  !> Makes the empty data sets.
  subroutine create_factor(file, root, nodes, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: nodes !! number of nodes
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, root//'factor_wear', stored_real, [2], 1, '1', &
      'passes that the factors of a nonlinear bulk have cost so far, tangents in a row that '// &
      'were not positive definite; empty with other solvers', error)
    if (allocated(error)) return
    call make_series(file, root//'factor_displacement', stored_real, [3, nodes], 1, 'length', &
      'displacement at which they were made; empty if they are those of the bodies at rest', error)
  end subroutine create_factor

  !> Writes what belongs to the factors, if they are in use; over those of an older state with this
  !! place if they are not.
  subroutine write_factor(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: dims(3), rank

    call series_shape(file, root//'factor_wear', dims, rank)
    if (dims(rank) < slot .and. .not. allocated(state%factor_displacement) &
      .and. all(state%factor_wear <= 0.0_wp)) return
    call write_block(file, root//'factor_wear', state%factor_wear, slot, error)
    if (allocated(error)) return
    if (allocated(state%factor_displacement)) then
      call write_block(file, root//'factor_displacement', state%factor_displacement, slot, error)
    else
      call write_block(file, root//'factor_displacement', 0.0_wp*state%displacement, slot, error)
    end if
  end subroutine write_factor

  !> Reads it, if it is there; a file of an older program has none.
  subroutine read_factor(file, root, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: root !! group of the states
    integer, intent(in) :: slot !! place of the state in the file
    type(saved_state_t), intent(inout) :: state !! displacement given; gets what is there
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: dims(3), rank

    if (.not. exists_in(file, root//'factor_wear')) return
    call series_shape(file, root//'factor_wear', dims, rank)
    if (dims(rank) < slot) return
    call read_block(file, root//'factor_wear', state%factor_wear, slot, error)
    if (allocated(error)) return
    allocate (state%factor_displacement, mold=state%displacement)
    call read_block(file, root//'factor_displacement', state%factor_displacement, slot, error)
    if (allocated(error)) return
    if (all(abs(state%factor_displacement) <= 0.0_wp)) deallocate (state%factor_displacement)
  end subroutine read_factor
end module factor_state

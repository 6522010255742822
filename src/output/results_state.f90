!> Writes the restart part of a results file: all that a run needs to go on, bit for bit, and the
!! mesh it belongs to. `state_reader` reads it.
!!
!! Of `STATe LAST` two are kept in turn, so that a run killed while it writes leaves one of them.
module results_state
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use friction_laws, only: keeps_path, path_state
  use contact_types, only: pair_t
  use contact_parameters, only: has_multipliers
  use contact_points, only: count_points
  use mesh_types, only: mesh_t
  use model_types, only: model_t, state_last
  use result_types, only: saved_state_t, pair_history_t
  use hdf5_io, only: hdf5_file_t, create_hdf5, flush_hdf5, close_hdf5, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, series_shape, write_block, at_end, stored_real, stored_integer
  use checksums, only: block_sum
  use cell_state, only: create_cells, write_cells
  use path_state, only: create_before, write_before
  use factor_state, only: create_factor, write_factor
  use scene_state, only: create_scene, write_scene
  use rigid_state, only: create_rigid, write_rigid
  use text_files, only: rename_file
  implicit none
  private
  public :: create_state_part, write_state, complete_state, save_state, pair_group, &
    defined_coordinates, slave_nodes, state_mark

  !> Root of this part of the file.
  character(*), parameter :: root = '/state/'

contains

  !> Makes the empty data sets, and writes the mesh that the states belong to.
  subroutine create_state_part(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    call make_group(file, '/state', error)
    if (allocated(error)) return
    call make_series(file, root//'step', stored_integer, [integer ::], 1, '1', &
      'number of the end time; 0 or below: not complete', error)
    if (allocated(error)) return
    call make_series(file, root//'time', stored_real, [integer ::], 1, 'time', 'its time', error)
    if (allocated(error)) return
    call make_series(file, root//'increment', stored_real, [integer ::], 1, 'time', &
      'increment size to go on with', error)
    if (allocated(error)) return
    call make_series(file, root//'checksum', stored_integer, [2], 1, '1', &
      'sum over all numbers of the state', error)
    if (allocated(error)) return
    call make_series(file, root//'displacement', stored_real, [3, model%mesh%nodes], 1, 'length', &
      'displacement of all node numbers from 1', error)
    if (allocated(error)) return
    call make_series(file, root//'reaction', stored_real, [3, model%mesh%nodes], 1, 'force', &
      'force of the supports on all node numbers from 1', error)
    if (allocated(error)) return
    call create_before(file, root, model%mesh%nodes, error)
    if (.not. allocated(error)) call create_factor(file, root, model%mesh%nodes, error)
    if (allocated(error)) return
    call create_scene(file, root, error)
    if (.not. allocated(error)) call create_rigid(file, root, model, error)
    if (allocated(error)) return
    call make_series(file, root//'candidate', stored_integer, [model%mesh%nodes], 1, '1', &
      'nodes that the condensed solver holds for contact; empty if it was not in use', error)
    if (allocated(error)) return
    call make_series(file, root//'contact_force', stored_real, [3, model%mesh%nodes], 1, 'force', &
      'contact forces of the condensed solver; empty if it was not in use', error)
    if (allocated(error)) return
    call write_mesh(file, model, error)
    if (allocated(error)) return
    call make_group(file, root//'contact', error)
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call create_pair(file, model%pairs(i), error)
    end do
  end subroutine create_state_part

  !> Writes what tells whether a state fits a deck.
  subroutine write_mesh(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    call make_series(file, root//'coordinates', stored_real, [3], max(1, model%mesh%nodes), &
      'length', 'reference position of all node numbers from 1', error)
    if (allocated(error)) return
    call write_block(file, root//'coordinates', defined_coordinates(model%mesh), at_end, error)
    if (allocated(error)) return
    call make_series(file, root//'elements', stored_integer, [size(model%mesh%ix, 1)], &
      max(1, size(model%mesh%ix, 2)), '1', 'nodes of all element numbers from 1', error)
    if (allocated(error)) return
    call write_block(file, root//'elements', model%mesh%ix, at_end, error)
    if (allocated(error)) return
    call make_series(file, root//'pairs', stored_integer, [integer ::], &
      max(1, size(model%pairs)), '1', 'numbers of the contact pairs', error)
    if (allocated(error)) return
    call write_block(file, root//'pairs', [(model%pairs(i)%number, i=1, size(model%pairs))], &
      at_end, error)
  end subroutine write_mesh

  !> Coordinates, zero for node numbers that are not defined.
  pure function defined_coordinates(mesh) result(x)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), allocatable :: x(:, :)
    integer :: i

    allocate (x(3, mesh%nodes), source=0.0_wp)
    do i = 1, mesh%nodes
      if (mesh%defined(i)) x(:, i) = mesh%x(:, i)
    end do
  end function defined_coordinates

  !> Makes the data sets of one pair, empty but for its nodes and facets.
  subroutine create_pair(file, pair, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(:), allocatable :: group
    integer :: points

    group = pair_group(pair%number)
    points = count_points(pair)
    call make_group(file, group, error)
    if (allocated(error)) return
    call make_series(file, group//'/host', stored_integer, [points], 1, '1', &
      'facet of the pair that holds the tip, from 1, 0 for none', error)
    if (allocated(error)) return
    call make_series(file, group//'/status', stored_integer, [points], 1, '1', &
      '-1 off, 0 open, 1 stick, 2 slip', error)
    if (allocated(error)) return
    call make_series(file, group//'/tip', stored_real, [2, points], 1, '1', &
      '(xi, eta) of the tip in its facet', error)
    if (allocated(error)) return
    call make_series(file, group//'/dissipation', stored_real, [points], 1, 'force length', &
      'work that friction has taken up to now', error)
    if (allocated(error)) return
    if (keeps_path(pair%law)) call make_series(file, group//'/'//trim(path_state%name), &
      stored_real, [points], 1, trim(path_state%unit), trim(path_state%description), error)
    if (allocated(error)) return
    call make_series(file, group//'/coupled', stored_integer, [points], 1, '1', &
      'host when the pattern of the matrix was built, 0 for none', error)
    if (allocated(error)) return
    if (has_multipliers(pair)) call create_multipliers(file, group, points, error)
    if (allocated(error)) return
    if (pair%segmented) call create_cells(file, group, points, error)
    if (allocated(error)) return
    call make_series(file, group//'/nodes', stored_integer, [integer ::], &
      max(1, size(slave_nodes(pair))), '1', 'nodes of the points, or of the slave facets', error)
    if (allocated(error)) return
    call write_block(file, group//'/nodes', slave_nodes(pair), at_end, error)
    if (allocated(error)) return
    call make_series(file, group//'/facets', stored_integer, [3], max(1, &
      size(pair%surface%facets, 2)), &
      '1', 'nodes of the master facets', error)
    if (allocated(error)) return
    call write_block(file, group//'/facets', pair%surface%facets, at_end, error)
  end subroutine create_pair

  !> Nodes of the points in their order; of a segmented pair, those of its slave facets.
  pure function slave_nodes(pair) result(nodes)
    type(pair_t), intent(in) :: pair !! the pair
    integer, allocatable :: nodes(:)

    if (pair%segmented) then
      nodes = reshape(pair%points%slave_facets, [size(pair%points%slave_facets)])
    else
      nodes = reshape(pair%points%point_nodes, [size(pair%points%point_nodes)])
    end if
  end function slave_nodes

  !> Makes the data set of a pair with multipliers.
  subroutine create_multipliers(file, group, points, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    integer, intent(in) :: points !! number of its points
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, group//'/multiplier', stored_real, [3, points], 1, 'force', &
      'force without a gap, along a1, e x a1 and e of the facet', error)
  end subroutine create_multipliers

  !> Writes one state; it counts only after complete_state, when all of it is on disk.
  subroutine write_state(file, model, written, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: slot

    slot = slot_of(model, written)
    call write_block(file, root//'step', [0], slot, error)
    if (allocated(error)) return
    if (slot <= written) call flush_hdf5(file, error)
    if (.not. allocated(error)) call write_slot(file, model, slot, state, error)
  end subroutine write_state

  !> Makes a state count.
  subroutine complete_state(file, model, written, step, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one
    integer, intent(in) :: step !! number of its end time
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call write_block(file, root//'step', [step], slot_of(model, written), error)
  end subroutine complete_state

  !> Place of a state in the file.
  pure integer function slot_of(model, written) result(slot)
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one

    slot = written + 1
    if (model%output%state == state_last) slot = mod(written, 2) + 1
  end function slot_of

  !> Writes one state, but for its number, to its place.
  subroutine write_slot(file, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! its place
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    file%sum = state_mark(state%step)
    call write_block(file, root//'time', [state%time], slot, error)
    if (allocated(error)) return
    call write_block(file, root//'increment', [state%increment], slot, error)
    if (allocated(error)) return
    call write_block(file, root//'displacement', state%displacement, slot, error)
    if (allocated(error)) return
    call write_block(file, root//'reaction', state%reaction, slot, error)
    if (allocated(error)) return
    call write_before(file, root, slot, state, error)
    if (.not. allocated(error)) call write_factor(file, root, slot, state, error)
    if (.not. allocated(error)) call write_scene(file, root, slot, state, error)
    if (.not. allocated(error)) call write_rigid(file, root, slot, state, error)
    if (allocated(error)) return
    if (allocated(state%candidate)) then
      call write_block(file, root//'candidate', state%candidate, slot, error)
      if (.not. allocated(error)) call write_block(file, root//'contact_force', &
        state%contact_force, slot, error)
    else
      call clear_condensed(file, model, slot, error)
    end if
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call write_pair(file, model%pairs(i)%number, state, i, slot, error)
      if (allocated(error)) return
      if (keeps_path(model%pairs(i)%law)) call write_block(file, pair_group(model%pairs(i)%number) &
        //'/'//trim(path_state%name), state%pairs(i)%points%path, slot, error)
      if (allocated(error)) return
      if (has_multipliers(model%pairs(i))) call write_multipliers(file, model%pairs(i)%number, &
        state%pairs(i), slot, error)
      if (allocated(error)) return
      if (model%pairs(i)%segmented) call write_cells(file, pair_group(model%pairs(i)%number), &
        state%pairs(i)%cells, slot, error)
    end do
    if (.not. allocated(error)) call write_block(file, root//'checksum', &
      transfer(file%sum, [0, 0]), slot, error)
  end subroutine write_slot

  !> What the sum over a state begins with: another number for each step.
  pure integer(int64) function state_mark(step) result(mark)
    integer, intent(in) :: step !! number of the end time

    mark = block_sum(root//'step', [step])
  end function state_mark

  !> Overwrites what the state that had this place before has left of the condensed form.
  subroutine clear_condensed(file, model, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! place of the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer, allocatable :: none(:)
    integer :: dims(3), rank

    call series_shape(file, root//'candidate', dims, rank)
    if (dims(2) < slot) return
    allocate (none(model%mesh%nodes), source=0)
    call write_block(file, root//'candidate', none, slot, error)
    if (.not. allocated(error)) call write_block(file, root//'contact_force', &
      spread(real(none, wp), 1, 3), slot, error)
  end subroutine clear_condensed

  !> Writes a file of one state (SAVE); it takes its name when it is complete.
  subroutine save_state(path, model, state, version, error)
    character(*), intent(in) :: path !! name of the file
    type(model_t), intent(in) :: model !! the problem
    type(saved_state_t), intent(in) :: state !! the state
    character(*), intent(in) :: version !! version of the program
    type(error_t), allocatable, intent(out) :: error !! file trouble
    type(error_t), allocatable :: trouble
    type(hdf5_file_t) :: file

    call create_hdf5(file, path//'.new', error)
    if (allocated(error)) return
    call create_state_part(file, model, error)
    if (.not. allocated(error)) call write_attribute(file, '/state', 'version', version, error)
    if (.not. allocated(error)) call write_slot(file, model, 1, state, error)
    if (.not. allocated(error)) call complete_state(file, model, 0, state%step, error)
    call close_hdf5(file, trouble)
    if (allocated(trouble) .and. .not. allocated(error)) call move_alloc(trouble, error)
    if (.not. allocated(error)) call rename_file(path//'.new', path, error)
  end subroutine save_state

  !> Writes the contact history of one pair.
  subroutine write_pair(file, number, state, pair, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: number !! number of the pair
    type(saved_state_t), intent(in) :: state !! the state
    integer, intent(in) :: pair !! index of the pair
    integer, intent(in) :: slot !! place of the state in the file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: tip(2, size(state%pairs(pair)%points)), dissipation(size(tip, 2))
    integer :: host(size(tip, 2)), status(size(tip, 2)), i

    associate (points => state%pairs(pair)%points)
      do i = 1, size(points)
        host(i) = points(i)%host
        status(i) = points(i)%status
        tip(:, i) = points(i)%tip
        dissipation(i) = points(i)%dissipation
      end do
    end associate
    call write_block(file, pair_group(number)//'/host', host, slot, error)
    if (allocated(error)) return
    call write_block(file, pair_group(number)//'/status', status, slot, error)
    if (allocated(error)) return
    call write_block(file, pair_group(number)//'/tip', tip, slot, error)
    if (allocated(error)) return
    call write_block(file, pair_group(number)//'/dissipation', dissipation, slot, error)
    if (allocated(error)) return
    call write_block(file, pair_group(number)//'/coupled', state%pairs(pair)%coupled, slot, error)
  end subroutine write_pair

  !> Writes the multipliers of a pair that has them.
  subroutine write_multipliers(file, number, history, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: number !! number of the pair
    type(pair_history_t), intent(in) :: history !! its history
    integer, intent(in) :: slot !! place of the state in the file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: lambda(3, size(history%points))
    integer :: i

    do i = 1, size(history%points)
      lambda(:, i) = history%points(i)%lambda
    end do
    call write_block(file, pair_group(number)//'/multiplier', lambda, slot, error)
  end subroutine write_multipliers

  !> Group of a pair.
  function pair_group(number) result(group)
    integer, intent(in) :: number !! number of the pair
    character(:), allocatable :: group

    group = root//'contact/'//to_text(number)
  end function pair_group
end module results_state

!> Writes the restart part of a results file: all that a run needs to go on, bit for bit, and the
!! mesh it belongs to. `state_reader` reads it.
!!
!! Of `STATe LAST n` there are n + 1 places, written in turn: while one is written, n states count.
module results_state
  use, intrinsic :: iso_c_binding, only: c_associated, c_loc, c_ptr
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  use errors, only: error_t
  use text, only: to_text
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use mesh_types, only: mesh_t
  use rigid_paths, only: count_rigid
  use bulk_memory, only: memory_shape
  use model_types, only: model_t, state_last
  use result_types, only: saved_state_t, pair_history_t
  use hdf5_io, only: hdf5_file_t, unfinished, create_hdf5, close_hdf5, make_group
  use hdf5_index, only: blocks_in_chunk
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, write_block, move_block, at_end, stored_real, stored_integer
  use checksums, only: block_sum
  use result_fields, only: field_t, field_shape, native_type, create_field, entries_of
  use state_fields, only: fields_of_state, fields_of_pair, is_mark, in_use, is_kept, address_of, &
    real_component, integer_component
  use text_files, only: rename_file
  implicit none
  private
  public :: create_state_part, write_state, complete_state, save_state, pair_group, &
    defined_coordinates, slave_nodes, state_mark

  !> Root of this part of the file.
  character(*), parameter :: state_root = '/state/'

contains

  !> Makes the empty data sets, and writes the mesh that the states belong to.
  subroutine create_state_part(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i, blocks

    blocks = blocks_in_chunk(max(1, 3*model%mesh%nodes), states_of(model, file%end_times))
    call make_group(file, '/state', error)
    do i = 1, size(fields_of_state)
      if (.not. in_use(fields_of_state(i), model)) cycle
      call create_field(file, state_root, fields_of_state(i), counts_of(model), blocks, error)
    end do
    call write_mesh(file, model, error)
    call make_group(file, state_root//'contact', error)
    do i = 1, size(model%pairs)
      call create_pair(file, model%pairs(i), blocks, error)
    end do
  end subroutine create_state_part

  !> What fields of a state have values for: nodes, no points, rigid bodies, derivatives,
  !! numbers that points of the bulk remember.
  pure function counts_of(model) result(counts)
    type(model_t), intent(in) :: model !! the problem
    integer :: counts(7)

    counts = [model%mesh%nodes, 0, count_rigid(model), model%output%slopes, &
      product(memory_shape(model))]
  end function counts_of

  !> Writes what tells whether a state fits a deck.
  subroutine write_mesh(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call make_series(file, state_root//'coordinates', stored_real, [3], max(1, model%mesh%nodes), &
      'length', 'reference position of all node numbers from 1', error)
    call write_block(file, state_root//'coordinates', defined_coordinates(model%mesh), at_end, &
      error)
    call make_series(file, state_root//'elements', stored_integer, [size(model%mesh%ix, 1)], &
      max(1, size(model%mesh%ix, 2)), '1', 'nodes of all element numbers from 1', error)
    call write_block(file, state_root//'elements', model%mesh%ix, at_end, error)
    call make_series(file, state_root//'pairs', stored_integer, [integer ::], &
      max(1, size(model%pairs)), '1', 'numbers of the contact pairs', error)
    call write_block(file, state_root//'pairs', [(model%pairs(i)%number, i=1, size(model%pairs))], &
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
  subroutine create_pair(file, pair, blocks, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: blocks !! states in a chunk
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: group
    integer :: i

    group = pair_group(pair%number)
    call make_group(file, group, error)
    do i = 1, size(fields_of_pair)
      if (.not. in_use(fields_of_pair(i), pair)) cycle
      call create_field(file, group//'/', fields_of_pair(i), [0, count_points(pair)], &
        blocks, error)
    end do
    call make_series(file, group//'/nodes', stored_integer, [integer ::], &
      max(1, size(slave_nodes(pair))), '1', 'nodes of the points, or of the slave facets', error)
    call write_block(file, group//'/nodes', slave_nodes(pair), at_end, error)
    call make_series(file, group//'/facets', stored_integer, [3], max(1, &
      size(pair%surface%facets, 2)), &
      '1', 'nodes of the master facets', error)
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

  !> Writes one state; it counts only after complete_state, when all of it is on disk. What stood at
  !! its place does not count any more since the last state does.
  subroutine write_state(file, model, written, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: slot

    slot = slot_of(model, written)
    if (slot > written) call write_block(file, state_root//'step', [0], slot, error)
    call write_slot(file, model, slot, state, error)
  end subroutine write_state

  !> Makes a state count, and the one whose place is the next to be written not count any more.
  subroutine complete_state(file, model, written, step, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one
    integer, intent(in) :: step !! number of its end time
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    integer :: next

    call write_block(file, state_root//'step', [step], slot_of(model, written), error)
    next = slot_of(model, written + 1)
    if (next > written + 1 .or. allocated(error)) return
    call write_block(file, state_root//'step', [0], next, error)
  end subroutine complete_state

  !> Places for states that a file has.
  pure integer function states_of(model, end_times) result(n)
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: end_times !! that will be written, foreseen

    n = end_times
    if (model%output%state == state_last) n = min(n, model%output%kept_states + 1)
  end function states_of

  !> Place of a state in the file.
  pure integer function slot_of(model, written) result(slot)
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one

    slot = written + 1
    if (model%output%state == state_last) slot = mod(written, &
      model%output%kept_states + 1) + 1
  end function slot_of

  !> Writes one state, but for its number, to its place.
  subroutine write_slot(file, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! its place
    type(saved_state_t), intent(in), target :: state !! the state
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    file%sum = state_mark(state%step)
    do i = 1, size(fields_of_state)
      if (is_mark(fields_of_state(i)) .or. .not. in_use(fields_of_state(i), model)) cycle
      call write_field(file, fields_of_state(i), counts_of(model), state, slot, error)
    end do
    do i = 1, size(model%pairs)
      call write_pair(file, model%pairs(i), state%pairs(i), slot, error)
    end do
    call write_block(file, state_root//'checksum', transfer(file%sum, [0, 0]), slot, error)
  end subroutine write_slot

  !> Writes one field of a state; zeros over that of an older state with its place, if it has
  !! nothing to keep.
  subroutine write_field(file, field, counts, state, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(field_t), intent(in) :: field !! the field
    integer, intent(in) :: counts(:) !! what it may have values for
    type(saved_state_t), intent(in), target :: state !! the state
    integer, intent(in) :: slot !! place of the state in the file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(c_ptr) :: address
    integer, allocatable, target :: zeros(:)
    integer, allocatable :: dims(:)

    if (.not. is_kept(field, state)) then
      if (entries_of(file, state_root//trim(field%name)) < slot) return
    end if
    dims = field_shape(field, counts)
    address = address_of(state, field%name, dims, .false.)
    if (.not. c_associated(address)) then
      allocate (zeros(2*product(dims)), source=0) ! words enough for reals
      address = c_loc(zeros)
    end if
    call move_block(file, state_root//trim(field%name), native_type(field), address, &
      product(dims), slot, .true., error)
  end subroutine write_field

  !> What the sum over a state begins with: another number for each step.
  pure integer(int64) function state_mark(step) result(mark)
    integer, intent(in) :: step !! number of the end time

    mark = block_sum(state_root//'step', [step])
  end function state_mark

  !> Writes a file of one state (SAVE); it takes its name when it is complete.
  subroutine save_state(path, model, state, version, error)
    character(*), intent(in) :: path !! name of the file
    type(model_t), intent(in) :: model !! the problem
    type(saved_state_t), intent(in) :: state !! the state
    character(*), intent(in) :: version !! version of the program
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(hdf5_file_t) :: file

    call create_hdf5(file, path//unfinished, error)
    call create_state_part(file, model, error)
    call write_attribute(file, '/state', 'version', version, error)
    call write_slot(file, model, 1, state, error)
    call complete_state(file, model, 0, state%step, error)
    call close_hdf5(file, error)
    if (.not. allocated(error)) call rename_file(path//unfinished, path, error)
  end subroutine save_state

  !> Writes the contact history of one pair.
  subroutine write_pair(file, pair, history, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    type(pair_history_t), intent(in), target :: history !! its history
    integer, intent(in) :: slot !! place of the state in the file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: values(:, :)
    real(wp), pointer :: component(:)
    integer, pointer :: number(:)
    character(:), allocatable :: path
    integer :: i, k

    do i = 1, size(fields_of_pair)
      associate (field => fields_of_pair(i))
        if (.not. in_use(field, pair)) cycle
        path = pair_group(pair%number)//'/'//trim(field%name)
        if (field%stored == stored_real) then
          allocate (values(field%components, size(history%points)))
          do k = 1, field%components
            component => real_component(history, field%name, k)
            values(k, :) = component
          end do
          call write_block(file, path, values, slot, error)
          deallocate (values)
        else
          number => integer_component(history, field%name)
          call write_block(file, path, number, slot, error)
        end if
      end associate
    end do
  end subroutine write_pair

  !> Group of a pair.
  function pair_group(number) result(group)
    integer, intent(in) :: number !! number of the pair
    character(:), allocatable :: group

    group = state_root//'contact/'//to_text(number)
  end function pair_group
end module results_state

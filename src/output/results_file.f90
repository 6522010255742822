!> The results file (.vtkhdf), HDF5 in three layers, the highest: what a run hands over goes where
!! deck.md 6 says, and what is in the file stays valid when the run is killed.
!!
!! /VTKHDF fields for ParaView; /history tables; /audit; /contact points; /state restart; /run
!! the deck.
module results_file
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: cost_t, cost_names, n_costs
  use model_types, only: model_t, output_request_t, state_none
  use rigid_paths, only: count_rigid
  use deck_types, only: name_length
  use smooth_patch, only: n_patch_values
  use result_types, only: origin_t, end_row_t, frame_t, saved_state_t, variant_row_t
  use audit_types, only: audit_t
  use hdf5_index, only: begin_indexes, node_chunks, blocks_in_chunk
  use hdf5_io, only: hdf5_file_t, unfinished, create_hdf5, publish_hdf5, flush_hdf5, close_hdf5, &
    make_group, reserve_room
  use hdf5_data, only: make_series, make_text_series, write_block, at_end, stored_long, &
    stored_real, stored_integer
  use vtk_grid, only: are_frames_due, write_frames, count_frames
  use results_vtk, only: vtk_part_t, create_vtk_part, append_vtk_frame
  use results_tables, only: create_history_part, append_history, create_rigid_part, append_rigid
  use results_study, only: create_derivatives_part, append_derivatives, create_study_part, &
    begin_study_part, append_variant
  use results_scene, only: write_scene
  use results_points, only: create_contact_part, append_contact
  use results_audit, only: create_audit_part, append_audit
  use results_state, only: create_state_part, write_state, complete_state
  implicit none
  private
  public :: results_t, create_results, append_results, append_picture, close_results, fields_due, &
    begin_variants, append_variant_row

  !> What the rows of one end time need at most [byte].
  integer(int64), parameter :: bytes_of_rows = 65536_int64
  !> And each of their derivatives.
  integer(int64), parameter :: bytes_of_derivative = 160_int64

  !> A results file open for writing.
  type :: results_t
    type(hdf5_file_t) :: file !! the HDF5 file
    type(vtk_part_t) :: vtk !! what stands in /VTKHDF
    integer :: states = 0 !! states written
    integer(int64) :: bytes = 0_int64 !! what fields and state of one end time need at most [byte]
  end type results_t

contains

  !> Creates the file with all that is known before the first increment. It takes its name when it
  !! can be read, in place of the file that has that name.
  subroutine create_results(results, path, model, bodies, origin, error)
    type(results_t), intent(out) :: results !! the file, open
    character(*), intent(in) :: path !! its name
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: bodies !! its connected pieces
    type(origin_t), intent(in) :: origin !! what makes it
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call create_hdf5(results%file, path//unfinished, error, node_chunks(origin%end_times))
    if (allocated(error)) return
    results%file%end_times = origin%end_times
    results%file%blocks = blocks_in_chunk(6*max(model%mesh%nodes, model%mesh%elements, 1), &
      origin%end_times)
    results%bytes = bytes_of_fields(model)
    call reserve_room(results%file, 3*results%bytes + len(origin%deck, int64), error)
    call write_beginning(results, model, bodies, origin, error)
    call begin_indexes(results%file, error)
    call publish_hdf5(results%file, path, error)
  end subroutine create_results

  !> Writes what is known before the first increment.
  subroutine write_beginning(results, model, bodies, origin, error)
    type(results_t), intent(inout) :: results !! the file, open
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: bodies !! its connected pieces
    type(origin_t), intent(in) :: origin !! what makes it
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_run(results%file, model, origin, error)
    call write_scene(results%file, model, error)
    call create_vtk_part(results%vtk, results%file, model%mesh, model%output, error)
    call create_history_part(results%file, error)
    if (count_rigid(model) > 0) call create_rigid_part(results%file, error)
    if (origin%derivatives) call create_derivatives_part(results%file, error)
    if (origin%varied > 0) call create_study_part(results%file, origin, &
      size(model%output%reactions), error)
    call create_audit_part(results%file, bodies, error)
    if (model%output%contact) call create_contact_part(results%file, model, error)
    if (model%output%state /= state_none) call create_state_part(results%file, model, error)
    call write_costs(results%file, cost_t(), error)
  end subroutine write_beginning

  !> Whether fields and state are written at this end time; if not they need not be computed.
  pure logical function fields_due(request, step) result(due)
    type(output_request_t), intent(in) :: request !! the OUTPut data set
    integer, intent(in) :: step !! number of the end time

    due = mod(step, max(1, request%every)) == 0
  end function fields_due

  !> What fields and state of one end time need at most [byte].
  pure integer(int64) function bytes_of_fields(model) result(bytes)
    type(model_t), intent(in) :: model !! the problem
    integer :: k

    bytes = 20*int(model%mesh%nodes, int64) + 13*int(model%mesh%elements, int64)
    do k = 1, size(model%pairs)
      bytes = bytes + 27*size(model%pairs(k)%points%point_nodes, kind=int64)
      if (model%pairs(k)%smooth) bytes = bytes + n_patch_values*size( &
        model%pairs(k)%surface%facets, 2, kind=int64)
    end do
    bytes = 8*bytes
  end function bytes_of_fields

  !> Writes one end time, the fields and the state if they are given, and hands it to the system.
  !! Fields may wait in memory for those of later ones (vtk_grid: are_frames_due). What counts is
  !! told when it is there, by a flush of its own.
  subroutine append_results(results, model, row, audit, frame, state, error)
    type(results_t), intent(inout) :: results !! open file
    type(model_t), intent(in) :: model !! the problem
    type(end_row_t), intent(in) :: row !! sums of the end time
    type(audit_t), intent(in) :: audit !! the audit of the end time
    type(frame_t), intent(in), optional :: frame !! fields; those that are wanted are allocated
    type(saved_state_t), intent(in), optional :: state !! state for a restart
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer(int64) :: bytes
    logical :: with_frames, with_state

    if (present(frame)) then
      call append_vtk_frame(results%vtk, results%file, row%time, frame, error)
      if (model%output%contact) call append_contact(results%file, model, row%step, row%time, &
        frame%began, frame%pairs, error)
    end if
    with_state = present(state) .and. model%output%state /= state_none
    with_frames = are_frames_due(results%vtk%grid, results%file)
    bytes = bytes_of_rows
    if (with_frames .or. with_state) bytes = bytes + results%bytes
    if (allocated(row%derivatives)) bytes = bytes + bytes_of_derivative*size( &
      row%derivatives%kinks, kind=int64)
    call reserve_room(results%file, bytes, error)
    call append_history(results%file, model, row, error)
    if (allocated(row%rigid)) call append_rigid(results%file, model, row, error)
    if (allocated(row%derivatives)) call append_derivatives(results%file, row%step, row%time, &
      row%derivatives, error)
    call append_audit(results%file, audit, error)
    if (with_state) call write_state(results%file, model, results%states, state, error)
    if (with_frames) call write_frames(results%vtk%grid, results%file, error)
    call flush_hdf5(results%file, error)
    if (allocated(error) .or. .not. (with_frames .or. with_state)) return
    call reserve_room(results%file, bytes, error)
    if (with_state) then
      call complete_state(results%file, model, results%states, row%step, error)
      results%states = results%states + 1
    end if
    if (with_frames) call count_frames(results%vtk%grid, results%file, error)
    call flush_hdf5(results%file, error)
  end subroutine append_results

  !> Adds the bodies at one time without an end time of a run, to be looked at.
  subroutine append_picture(results, time, frame, error)
    type(results_t), intent(inout) :: results !! open file
    real(wp), intent(in) :: time !! time [time]
    type(frame_t), intent(in) :: frame !! fields; those that are wanted are allocated
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call append_vtk_frame(results%vtk, results%file, time, frame, error)
  end subroutine append_picture

  !> Writes what a study varies, before its first variant.
  subroutine begin_variants(results, parameters, sets, error)
    type(results_t), intent(inout) :: results !! open file
    character(name_length), intent(in) :: parameters(:) !! what is varied
    character(name_length), intent(in) :: sets(:) !! sets of the reactions
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call reserve_room(results%file, bytes_of_rows, error)
    call begin_study_part(results%file, parameters, sets, error)
    call flush_hdf5(results%file, error)
  end subroutine begin_variants

  !> Writes what one variant has come to, and hands it to the system.
  subroutine append_variant_row(results, row, error)
    type(results_t), intent(inout) :: results !! open file
    type(variant_row_t), intent(in) :: row !! the variant
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call reserve_room(results%file, bytes_of_rows + 8*size(row%reactions, kind=int64), error)
    call append_variant(results%file, row, error)
    call flush_hdf5(results%file, error)
  end subroutine append_variant_row

  !> Writes what waits and the cost table, and closes the file; one that is not open is left alone.
  subroutine close_results(results, costs, error)
    type(results_t), intent(inout) :: results !! the file
    type(cost_t), intent(in) :: costs !! what the run cost
    type(error_t), allocatable, intent(inout) :: error !! file trouble, unless some came before
    type(error_t), allocatable :: trouble

    if (results%file%id < 0) return
    call reserve_room(results%file, bytes_of_rows + results%bytes, trouble)
    call write_frames(results%vtk%grid, results%file, trouble)
    call flush_hdf5(results%file, trouble)
    call count_frames(results%vtk%grid, results%file, trouble)
    ! written over: closing a file must not change what tells where its data are
    call write_block(results%file, '/run/cost_counts', int(costs%count), 1, trouble)
    call write_block(results%file, '/run/cost_seconds', costs%seconds, 1, trouble)
    call flush_hdf5(results%file, trouble)
    call close_hdf5(results%file, trouble)
    if (.not. allocated(error)) call move_alloc(trouble, error)
  end subroutine close_results

  !> Writes /run: what made this file.
  subroutine write_run(file, model, origin, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(origin_t), intent(in) :: origin !! what makes it
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: regions
    integer :: i

    regions = ''
    do i = 1, size(model%mesh%regions)
      regions = regions//model%mesh%regions(i)%name//new_line('a')
    end do
    call make_group(file, '/run', error)
    call write_text(file, '/run/title', model%title, 'title of the deck', error)
    call write_text(file, '/run/deck', origin%deck, 'the deck as read', error)
    call write_text(file, '/run/version', origin%program, 'version of the program', error)
    call write_text(file, '/run/settings', origin%settings, 'command line and settings', error)
    call write_text(file, '/run/regions', regions, 'names of the regions, one a line', error)
    call write_sets(file, model, error)
    call write_surfaces(file, model, error)
  end subroutine write_run

  !> Writes /run/sets: the nodes of each set, so that postprocessing can use the deck's names.
  subroutine write_sets(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call make_group(file, '/run/sets', error)
    do i = 1, size(model%mesh%sets)
      associate (path => '/run/sets/'//model%mesh%sets(i)%name, nodes => model%mesh%sets(i)%nodes)
        call make_series(file, path, stored_integer, [integer ::], size(nodes), '1', &
          'node numbers of the set', error)
        call write_block(file, path, nodes, at_end, error)
      end associate
    end do
  end subroutine write_sets

  !> Writes /run/surfaces: the facets of each surface of the deck, for what makes meshes anew.
  subroutine write_surfaces(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call make_group(file, '/run/surfaces', error)
    do i = 1, size(model%mesh%surfaces)
      associate (name => '/run/surfaces/'//model%mesh%surfaces(i)%name, &
        facets => model%mesh%surfaces(i)%facets)
        if (size(facets, 2) == 0) cycle
        call make_series(file, name, stored_integer, [3], size(facets, 2), '1', &
          'corner nodes of the facets, counter-clockwise seen from outside', error)
        call write_block(file, name, facets, at_end, error)
      end associate
    end do
  end subroutine write_surfaces

  !> Writes a text as a data set of one string.
  subroutine write_text(file, path, value, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    character(*), intent(in) :: value !! the text
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(max(1, len(value))), allocatable :: one(:)

    allocate (one(1))
    one(1) = value
    call make_text_series(file, path, len(one), description, error)
    call write_block(file, path, one, at_end, error)
  end subroutine write_text

  !> Makes the cost table.
  subroutine write_costs(file, costs, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(cost_t), intent(in) :: costs !! what the run cost
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_text_series(file, '/run/cost_names', len(cost_names), 'kinds of work', error)
    call write_block(file, '/run/cost_names', cost_names, at_end, error)
    call make_series(file, '/run/cost_counts', stored_long, [integer ::], n_costs, '1', &
      'how often each was done', error)
    call write_block(file, '/run/cost_counts', int(costs%count), at_end, error)
    call make_series(file, '/run/cost_seconds', stored_real, [integer ::], n_costs, 's', &
      'wall-clock time of each', error)
    call write_block(file, '/run/cost_seconds', costs%seconds, at_end, error)
  end subroutine write_costs
end module results_file

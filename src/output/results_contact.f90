!> The file of the contact surfaces (.contact.vtkhdf): both sides of each pair with what contact
!! does to them, for ParaView and PyVista.
module results_contact
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  use errors, only: error_t
  use contact_types, only: form_quadrature_to_surface
  use model_types, only: model_t
  use result_types, only: frame_t
  use contact_sides, only: contact_surface_t, find_slave_surface, find_master_surface
  use contact_surfaces, only: find_slave_fields, find_master_fields, n_columns, at_pressure, &
    at_traction, at_shear, at_gap, at_status, at_slip, at_energy, at_lay, at_force, at_way, &
    at_path, at_stick, at_slipping
  use hdf5_index, only: begin_indexes, node_chunks, blocks_in_chunk
  use hdf5_io, only: hdf5_file_t, unfinished, create_hdf5, publish_hdf5, flush_hdf5, close_hdf5, &
    reserve_room
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: stored_single
  use vtk_grid, only: vtk_grid_t, create_grid, add_constant, add_field, begin_frame, add_values, &
    are_frames_due, write_frames, count_frames, on_points, on_cells, vtk_vertex, &
    vtk_triangle, vtk_six_nodes
  implicit none
  private
  public :: contact_file_t, create_contact_file, append_contact_frame, close_contact_file

  !> One field of the file.
  type :: column_t
    character(20) :: name !! its name
    integer :: at !! place of its first component
    integer :: components !! 1 or 3
    character(20) :: unit !! its unit
    character(80) :: description !! its meaning
  end type column_t

  !> The fields, those of nodes alone at the end.
  type(column_t), parameter :: columns(13) = [ &
    column_t('pressure', at_pressure, 1, 'force/length^2', 'normal force over reference area'), &
    column_t('traction', at_traction, 3, 'force/length^2', &
    'contact force on this side over reference area'), &
    column_t('shear_traction', at_shear, 3, 'force/length^2', 'its part along the master'), &
    column_t('gap', at_gap, 1, 'length', 'normal gap, negative in contact; slave side'), &
    column_t('status', at_status, 1, '1', '-1 off, 0 open, 1 stick, 2 slip: the largest there'), &
    column_t('slip', at_slip, 3, 'length', &
    'displacement against the master along it, since the start; slave side'), &
    column_t('dissipated_energy', at_energy, 1, 'force/length', &
    'work of friction so far, over reference area; slave side'), &
    column_t('frictional_slip', at_way, 3, 'length', &
    'slip since the touch: sum of the paths of the cones over the master; slave side'), &
    column_t('slip_path', at_path, 1, 'length', &
    'length of the path slipped since closure; slave side'), &
    column_t('stick_share', at_stick, 1, '1', 'share of the area that sticks; slave side'), &
    column_t('slip_share', at_slipping, 1, '1', 'share of the area that slips; slave side'), &
    column_t('lay', at_lay, 3, '1', 'unit axis of mu1, zero without one'), &
    column_t('force', at_force, 3, 'force', 'contact force on this node')]

  !> A file open for writing.
  type :: contact_file_t
    type(hdf5_file_t) :: file !! the HDF5 file
    type(vtk_grid_t) :: grid !! its grid
    type(contact_surface_t), allocatable :: surfaces(:) !! slave, master of each pair in turn
    integer, allocatable :: nodes(:) !! (points) node numbers of the deck
    integer, allocatable :: first_point(:) !! (surfaces + 1) first point of each
    integer, allocatable :: first_cell(:) !! (surfaces + 1) first cell of each
    logical :: on_facets = .false. !! all fields stand on the facets, too: where points lie in
    !! these. Of points at nodes, those of the slave alone would be the means of corners
  end type contact_file_t

contains

  !> Creates the file with the surfaces of all pairs, side by side; each has points of its own.
  subroutine create_contact_file(contact, path, model, end_times, error)
    type(contact_file_t), intent(out) :: contact !! the file, open
    character(*), intent(in) :: path !! its name
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: end_times !! that will be written, foreseen
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: k, n

    allocate (contact%surfaces(2*size(model%pairs)))
    do k = 1, size(model%pairs)
      call find_slave_surface(model%pairs(k), model%mesh, contact%surfaces(2*k - 1))
      call find_master_surface(model%pairs(k), model%mesh, contact%surfaces(2*k))
    end do
    contact%on_facets = any(model%pairs%form == form_quadrature_to_surface)
    call number_points(contact)
    n = blocks_in_chunk(3*max(size(contact%nodes), n_cells(contact)), end_times)
    call create_hdf5(contact%file, path//unfinished, error, node_chunks(1 + end_times/n))
    if (allocated(error)) return
    contact%file%blocks = n
    call reserve_room(contact%file, bytes_of_frame(contact) + 64*size(contact%nodes, kind=int64), &
      error)
    call write_beginning(contact, model, error)
    call begin_indexes(contact%file, error)
    call publish_hdf5(contact%file, path, error)
  end subroutine create_contact_file

  !> Writes what does not change, and makes the fields.
  subroutine write_beginning(contact, model, error)
    type(contact_file_t), intent(inout) :: contact !! the file, open
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: k

    call write_geometry(contact, model, error)
    call write_sides(contact, model, error)
    do k = 1, size(columns)
      call make_column(contact, columns(k), error)
    end do
    call add_field(contact%grid, contact%file, on_points, 'displacement', &
      stored_single, 3, 'length', 'displacement', error)
  end subroutine write_beginning

  !> Where the points and cells of each surface begin.
  pure subroutine number_points(contact)
    type(contact_file_t), intent(inout) :: contact !! surfaces given
    integer :: i, n

    n = size(contact%surfaces)
    allocate (contact%first_point(n + 1), contact%first_cell(n + 1), source=1)
    do i = 1, n
      associate (surface => contact%surfaces(i))
        contact%first_point(i + 1) = contact%first_point(i) + size(surface%nodes)
        contact%first_cell(i + 1) = contact%first_cell(i) + size(surface%facets, 2) &
          + size(surface%lone)
      end associate
    end do
    allocate (contact%nodes(contact%first_point(n + 1) - 1))
    do i = 1, n
      contact%nodes(contact%first_point(i):contact%first_point(i + 1) - 1) = &
        contact%surfaces(i)%nodes
    end do
  end subroutine number_points

  !> Facets and lone nodes of all surfaces.
  pure integer function n_cells(contact)
    type(contact_file_t), intent(in) :: contact !! the file

    n_cells = contact%first_cell(size(contact%first_cell)) - 1
  end function n_cells

  !> What the fields of one end time need [byte].
  pure integer(int64) function bytes_of_frame(contact) result(bytes)
    type(contact_file_t), intent(in) :: contact !! the file

    bytes = 8*(n_columns + 3)*size(contact%nodes, kind=int64) &
      + 8*n_columns*int(n_cells(contact) + 1, int64)
  end function bytes_of_frame

  !> Writes points and cells.
  subroutine write_geometry(contact, model, error)
    type(contact_file_t), intent(inout) :: contact !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, allocatable :: list(:), offsets(:), types(:)
    real(wp), allocatable :: x(:, :)
    integer :: i, f, n, cells

    cells = n_cells(contact)
    allocate (list(6*cells), offsets(cells + 1), types(cells), x(3, size(contact%nodes)))
    x(:, :) = model%mesh%x(:, contact%nodes)
    n = 0
    offsets(1) = 0
    do i = 1, size(contact%surfaces)
      associate (surface => contact%surfaces(i), before => contact%first_point(i) - 2)
        do f = 1, size(surface%facets, 2)
          if (surface%middles(1, f) > 0) then
            call add_cell(vtk_six_nodes, before + [surface%facets(:, f), surface%middles(:, f)], &
              n, list, offsets, types)
          else
            call add_cell(vtk_triangle, before + surface%facets(:, f), n, list, offsets, types)
          end if
        end do
        do f = 1, size(surface%lone)
          call add_cell(vtk_vertex, before + surface%lone(f:f), n, list, offsets, types)
        end do
      end associate
    end do
    call create_grid(contact%grid, contact%file, x, list(:offsets(cells + 1)), offsets, types, &
      error)
  end subroutine write_geometry

  !> Adds a cell to the lists.
  pure subroutine add_cell(type, points, n, list, offsets, types)
    integer, intent(in) :: type !! VTK's cell type
    integer, intent(in) :: points(:) !! its points, from 0
    integer, intent(inout) :: n !! cells so far
    integer, intent(inout) :: list(:) !! points of the cells
    integer, intent(inout) :: offsets(:) !! where cells begin
    integer, intent(inout) :: types(:) !! types of the cells

    n = n + 1
    types(n) = type
    list(offsets(n) + 1:offsets(n) + size(points)) = points
    offsets(n + 1) = offsets(n) + size(points)
  end subroutine add_cell

  !> Writes pair and side of all cells and points, and the nodes of the deck.
  subroutine write_sides(contact, model, error)
    type(contact_file_t), intent(inout) :: contact !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, allocatable :: pair(:), side(:)
    integer :: k

    do k = 1, size(model%pairs)
      call write_attribute(contact%file, '/VTKHDF', 'pair_'//model%pairs(k)%name, &
        model%pairs(k)%number, error)
    end do
    call add_constant(contact%grid, contact%file, on_points, 'node_number', contact%nodes, &
      'node number of the deck', error)
    call spread_sides(contact%first_point, model, pair, side)
    call write_both(on_points)
    call spread_sides(contact%first_cell, model, pair, side)
    call write_both(on_cells)

  contains

    !> Writes pair and side of points or cells.
    subroutine write_both(group)
      character(*), intent(in) :: group !! on_points or on_cells

      call add_constant(contact%grid, contact%file, group, 'pair', pair, &
        'number of the contact pair; names in attributes of /VTKHDF', error)
      call add_constant(contact%grid, contact%file, group, 'side', side, '1 slave, 2 master', &
        error)
    end subroutine write_both
  end subroutine write_sides

  !> Pair and side of points or cells.
  pure subroutine spread_sides(first, model, pair, side)
    integer, intent(in) :: first(:) !! (surfaces + 1) first point or cell of each surface
    type(model_t), intent(in) :: model !! pairs
    integer, allocatable, intent(out) :: pair(:) !! number of the pair
    integer, allocatable, intent(out) :: side(:) !! 1 slave, 2 master
    integer :: i

    allocate (pair(first(size(first)) - 1), side(first(size(first)) - 1))
    do i = 1, size(first) - 1
      pair(first(i):first(i + 1) - 1) = model%pairs((i + 1)/2)%number
      side(first(i):first(i + 1) - 1) = 2 - mod(i, 2)
    end do
  end subroutine spread_sides

  !> Makes one field at points, and at cells if it says more there.
  subroutine make_column(contact, column, error)
    type(contact_file_t), intent(inout) :: contact !! open file
    type(column_t), intent(in) :: column !! the field
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call add_field(contact%grid, contact%file, on_points, trim(column%name), stored_single, &
      column%components, trim(column%unit), trim(column%description), error)
    if (.not. is_on_facets(contact, column)) return
    call add_field(contact%grid, contact%file, on_cells, trim(column%name), stored_single, &
      column%components, trim(column%unit), trim(column%description), error)
  end subroutine make_column

  !> Adds the surfaces at one end time; they may wait in memory for those of later ones.
  subroutine append_contact_frame(contact, model, time, frame, error)
    type(contact_file_t), intent(inout) :: contact !! open file
    type(model_t), intent(in) :: model !! the problem
    real(wp), intent(in) :: time !! its time [time]
    type(frame_t), intent(in) :: frame !! points and displacements
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: at_nodes(:, :), at_cells(:, :)
    integer :: k

    call find_fields(contact, model, frame, at_nodes, at_cells)
    call begin_frame(contact%grid, contact%file, time, error)
    do k = 1, size(columns)
      call add_column(contact, columns(k), at_nodes, at_cells, error)
    end do
    at_nodes = frame%motion(:, contact%nodes)
    call add_values(contact%file, on_points, 'displacement', at_nodes, error)
    if (are_frames_due(contact%grid, contact%file)) call write_waiting(contact, error)
  end subroutine append_contact_frame

  !> Writes the end times that wait, and hands them to the system; what counts is told when it is
  !! there.
  subroutine write_waiting(contact, error)
    type(contact_file_t), intent(inout) :: contact !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call reserve_room(contact%file, bytes_of_frame(contact), error)
    call write_frames(contact%grid, contact%file, error)
    call flush_hdf5(contact%file, error)
    call reserve_room(contact%file, bytes_of_frame(contact), error)
    call count_frames(contact%grid, contact%file, error)
    call flush_hdf5(contact%file, error)
  end subroutine write_waiting

  !> The fields of all surfaces.
  subroutine find_fields(contact, model, frame, at_nodes, at_cells)
    type(contact_file_t), intent(in) :: contact !! surfaces
    type(model_t), intent(in) :: model !! pairs
    type(frame_t), intent(in) :: frame !! points and displacements
    real(wp), allocatable, intent(out) :: at_nodes(:, :) !! (n_columns, points)
    real(wp), allocatable, intent(out) :: at_cells(:, :) !! (n_columns, cells)
    real(wp), allocatable :: x(:, :)
    integer :: k

    allocate (at_nodes(n_columns, size(contact%nodes)))
    allocate (at_cells(n_columns, n_cells(contact)))
    x = model%mesh%x(:, :size(frame%motion, 2)) + frame%motion
    do k = 1, size(model%pairs)
      associate (p => contact%first_point(2*k - 1:2*k + 1), &
                 c => contact%first_cell(2*k - 1:2*k + 1))
        call find_slave_fields(model%pairs(k), contact%surfaces(2*k - 1), frame%pairs(k), &
          size(x, 2), at_nodes(:, p(1):p(2) - 1), at_cells(:, c(1):c(2) - 1))
        call find_master_fields(model%pairs(k), contact%surfaces(2*k), frame%pairs(k), x, &
          at_nodes(:, p(2):p(3) - 1), at_cells(:, c(2):c(3) - 1))
      end associate
    end do
  end subroutine find_fields

  !> A field stands on the facets, too.
  pure logical function is_on_facets(contact, column) result(yes)
    type(contact_file_t), intent(in) :: contact !! the file
    type(column_t), intent(in) :: column !! the field

    yes = any(column%at == [at_pressure, at_traction, at_shear, at_status]) .or. &
      (contact%on_facets .and. column%at /= at_force)
  end function is_on_facets

  !> Adds one field.
  subroutine add_column(contact, column, at_nodes, at_cells, error)
    type(contact_file_t), intent(inout) :: contact !! open file
    type(column_t), intent(in) :: column !! the field
    real(wp), intent(in) :: at_nodes(:, :) !! (n_columns, points)
    real(wp), intent(in) :: at_cells(:, :) !! (n_columns, cells)
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call add_values(contact%file, on_points, trim(column%name), part_of(at_nodes, column), error)
    if (.not. is_on_facets(contact, column)) return
    call add_values(contact%file, on_cells, trim(column%name), part_of(at_cells, column), error)
  end subroutine add_column

  !> The rows of one field.
  pure function part_of(values, column) result(part)
    real(wp), intent(in) :: values(:, :) !! (n_columns, n) all fields
    type(column_t), intent(in) :: column !! the field
    real(wp) :: part(column%components, size(values, 2))

    part = values(column%at:column%at + column%components - 1, :)
  end function part_of

  !> Writes what waits and closes the file; a file that is not open is left alone.
  subroutine close_contact_file(contact, error)
    type(contact_file_t), intent(inout) :: contact !! the file
    type(error_t), allocatable, intent(inout) :: error !! file trouble, unless some came before
    type(error_t), allocatable :: trouble

    if (contact%file%id < 0) return
    if (contact%grid%frames > contact%grid%counted) call write_waiting(contact, trouble)
    call close_hdf5(contact%file, trouble)
    if (.not. allocated(error)) call move_alloc(trouble, error)
  end subroutine close_contact_file
end module results_contact

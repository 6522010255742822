!> The bodies in a results file as ParaView reads them: /VTKHDF with stresses, displacements and the
!! sets of the deck.
module results_vtk
  use kinds, only: wp
  use errors, only: error_t
  use cells, only: most_nodes, shapes, kind_of
  use mesh_types, only: mesh_t
  use body_fields, only: body_field_t, fields_of_bodies, n_body_fields
  use model_types, only: output_request_t
  use result_types, only: frame_t
  use hdf5_io, only: hdf5_file_t
  use hdf5_data, only: stored_real
  use vtk_grid, only: vtk_grid_t, create_grid, add_constant, add_flags, add_field, begin_frame, &
    add_values, on_points, on_cells
  implicit none
  private
  public :: vtk_part_t, create_vtk_part, append_vtk_frame

  !> What stands in the file, and the nodes and elements behind it.
  type :: vtk_part_t
    type(vtk_grid_t) :: grid !! the grid
    integer, allocatable :: nodes(:) !! deck numbers of the points
    integer, allocatable :: elements(:) !! deck numbers of the cells
    logical :: field(n_body_fields) = .false. !! these are among the fields
  end type vtk_part_t

contains

  !> Writes the geometry and makes the empty fields.
  subroutine create_vtk_part(part, file, mesh, request, error)
    type(vtk_part_t), intent(out) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(output_request_t), intent(in) :: request !! which fields are wanted
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    part%nodes = pack([(i, i=1, mesh%nodes)], mesh%defined(:mesh%nodes))
    part%elements = pack([(i, i=1, mesh%elements)], mesh%ix(1, :mesh%elements) > 0)
    part%field = request%field
    call write_geometry(part, file, mesh, error)
    call write_numbers(part, file, mesh, error)
    call write_sets(part, file, mesh, error)
    call make_fields(part, file, error)
  end subroutine create_vtk_part

  !> Writes points and cells.
  subroutine write_geometry(part, file, mesh, error)
    type(vtk_part_t), intent(inout) :: part !! nodes and elements given; gets the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, allocatable :: point(:), list(:), offsets(:), types(:)
    real(wp), allocatable :: x(:, :)
    integer :: i, k, n, e

    allocate (point(0:mesh%nodes), source=0)
    do i = 1, size(part%nodes)
      point(part%nodes(i)) = i
    end do
    n = size(part%elements)
    allocate (list(most_nodes*n), offsets(n + 1), types(n), x(3, size(part%nodes)))
    x(:, :) = mesh%x(:, part%nodes)
    offsets(1) = 0
    do i = 1, n
      e = part%elements(i)
      k = kind_of(mesh%ix(:, e))
      types(i) = shapes(k)%vtk
      offsets(i + 1) = offsets(i) + shapes(k)%nodes
      list(offsets(i) + 1:offsets(i + 1)) = point(mesh%ix(:shapes(k)%nodes, e)) - 1
    end do
    call create_grid(part%grid, file, x, list(:offsets(n + 1)), offsets, types, error)
  end subroutine write_geometry

  !> Writes the numbers of the deck.
  subroutine write_numbers(part, file, mesh, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer, allocatable :: listed(:)

    call add_constant(part%grid, file, on_points, 'node_number', part%nodes, &
      'node number of the deck', error)
    call add_constant(part%grid, file, on_cells, 'element_number', part%elements, &
      'element number of the deck', error)
    listed = mesh%material(part%elements)
    call add_constant(part%grid, file, on_cells, 'material', listed, &
      'material number of the deck', error)
    listed = mesh%region(part%elements)
    call add_constant(part%grid, file, on_cells, 'region', listed, &
      'region, from 1 in the order of the deck, 0 for none; names in /run/regions', error)
  end subroutine write_numbers

  !> Writes which nodes belong to each set.
  subroutine write_sets(part, file, mesh, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    logical, allocatable :: inside(:)
    integer :: i

    if (.not. allocated(mesh%sets)) return
    allocate (inside(mesh%nodes))
    do i = 1, size(mesh%sets)
      inside = .false.
      inside(mesh%sets(i)%nodes) = .true.
      call add_flags(part%grid, file, on_points, 'set_'//mesh%sets(i)%name, inside(part%nodes), &
        '1 at the nodes of this set', error)
    end do
  end subroutine write_sets

  !> Makes the fields that the deck asks for.
  subroutine make_fields(part, file, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: k

    do k = 1, n_body_fields
      if (.not. part%field(k)) cycle
      associate (field => fields_of_bodies(k))
        call add_field(part%grid, file, group_of(field), trim(field%name), &
          stored_real, field%components, trim(field%unit), trim(field%description), error)
      end associate
    end do
  end subroutine make_fields

  !> Where a field stands.
  pure function group_of(field) result(group)
    type(body_field_t), intent(in) :: field !! the field
    character(:), allocatable :: group

    group = on_cells
    if (field%at_nodes) group = on_points
  end function group_of

  !> Adds the fields of one end time, which wait in memory (vtk_grid: write_frames, count_frames).
  subroutine append_vtk_frame(part, file, time, frame, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    real(wp), intent(in) :: time !! its time [time]
    type(frame_t), intent(in) :: frame !! the fields; those that are wanted are allocated
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: k

    call begin_frame(part%grid, file, time, error)
    do k = 1, n_body_fields
      if (.not. part%field(k)) cycle
      associate (field => fields_of_bodies(k))
        if (field%at_nodes) then
          call append_field(file, field, part%nodes, frame%body(k)%values, error)
        else
          call append_field(file, field, part%elements, frame%body(k)%values, error)
        end if
      end associate
    end do
  end subroutine append_vtk_frame

  !> Adds one field of one end time.
  subroutine append_field(file, field, list, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(body_field_t), intent(in) :: field !! the field
    integer, intent(in) :: list(:) !! nodes or elements that are written
    real(wp), intent(in) :: values(:, :) !! (components, all nodes or elements) the field
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    real(wp), allocatable :: listed(:, :)

    allocate (listed(size(values, 1), size(list)))
    listed(:, :) = values(:, list)
    call add_values(file, group_of(field), trim(field%name), listed, error)
  end subroutine append_field
end module results_vtk

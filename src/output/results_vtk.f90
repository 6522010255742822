!> The bodies in a results file as ParaView reads them: /VTKHDF with stresses, displacements and the
!! sets of the deck.
module results_vtk
  use kinds, only: wp
  use errors, only: error_t
  use cells, only: most_nodes, shape_t, shape_of
  use mesh_types, only: mesh_t
  use model_types, only: output_request_t
  use result_types, only: frame_t
  use hdf5_io, only: hdf5_file_t
  use vtk_grid, only: vtk_grid_t, create_grid, add_constant, add_flags, add_field, begin_frame, &
    write_field, end_frame, on_points, on_cells
  use nodal_stress, only: average_stress, von_mises
  implicit none
  private
  public :: vtk_part_t, create_vtk_part, append_vtk_frame, end_vtk_frame

  !> What stands in the file, and the nodes and elements behind it.
  type :: vtk_part_t
    type(vtk_grid_t) :: grid !! the grid
    integer, allocatable :: nodes(:) !! deck numbers of the points
    integer, allocatable :: elements(:) !! deck numbers of the cells
    logical :: strain = .false. !! strain is among the fields
    logical :: lay = .false. !! lay is among the fields
    logical :: displacement = .true. !! displacement is among the fields
    logical :: reaction = .true. !! reaction is among the fields
    logical :: stress = .true. !! stress is among the fields
  end type vtk_part_t

contains

  !> Writes the geometry and makes the empty fields.
  subroutine create_vtk_part(part, file, mesh, request, error)
    type(vtk_part_t), intent(out) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(output_request_t), intent(in) :: request !! which fields are wanted
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    part%nodes = pack([(i, i=1, mesh%nodes)], mesh%defined(:mesh%nodes))
    part%elements = pack([(i, i=1, mesh%elements)], mesh%ix(1, :mesh%elements) > 0)
    part%displacement = request%displacement
    part%reaction = request%reaction
    part%stress = request%stress
    part%strain = request%strain
    part%lay = request%lay
    call write_geometry(part, file, mesh, error)
    if (allocated(error)) return
    call write_numbers(part, file, mesh, error)
    if (allocated(error)) return
    call write_sets(part, file, mesh, error)
    if (allocated(error)) return
    call make_fields(part, file, error)
  end subroutine create_vtk_part

  !> Writes points and cells.
  subroutine write_geometry(part, file, mesh, error)
    type(vtk_part_t), intent(inout) :: part !! nodes and elements given; gets the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer, allocatable :: point(:), list(:), offsets(:), types(:)
    real(wp), allocatable :: x(:, :)
    type(shape_t) :: shape
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
      shape = shape_of(mesh%ix(:, e))
      k = shape%nodes
      types(i) = shape%vtk
      list(offsets(i) + 1:offsets(i) + k) = point(mesh%ix(:k, e)) - 1
      offsets(i + 1) = offsets(i) + k
    end do
    call create_grid(part%grid, file, x, list(:offsets(n + 1)), offsets, types, error)
  end subroutine write_geometry

  !> Writes the numbers of the deck.
  subroutine write_numbers(part, file, mesh, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer, allocatable :: listed(:)

    call add_constant(part%grid, file, on_points, 'node_number', part%nodes, &
      'node number of the deck', error)
    if (allocated(error)) return
    call add_constant(part%grid, file, on_cells, 'element_number', part%elements, &
      'element number of the deck', error)
    if (allocated(error)) return
    listed = mesh%material(part%elements)
    call add_constant(part%grid, file, on_cells, 'material', listed, &
      'material number of the deck', error)
    if (allocated(error)) return
    listed = mesh%region(part%elements)
    call add_constant(part%grid, file, on_cells, 'region', listed, &
      'region, from 1 in the order of the deck, 0 for none; names in /run/regions', error)
  end subroutine write_numbers

  !> Writes which nodes belong to each set.
  subroutine write_sets(part, file, mesh, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(out) :: error !! file trouble
    logical, allocatable :: inside(:)
    integer :: i

    if (.not. allocated(mesh%sets)) return
    allocate (inside(mesh%nodes))
    do i = 1, size(mesh%sets)
      inside = .false.
      inside(mesh%sets(i)%nodes) = .true.
      call add_flags(part%grid, file, on_points, 'set_'//mesh%sets(i)%name, inside(part%nodes), &
        '1 at the nodes of this set', error)
      if (allocated(error)) return
    end do
  end subroutine write_sets

  !> Makes the fields that the deck asks for.
  subroutine make_fields(part, file, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble

    if (part%displacement) call add_field(part%grid, file, on_points, 'displacement', 3, &
      'length', 'displacement', error)
    if (allocated(error)) return
    if (part%reaction) call add_field(part%grid, file, on_points, 'reaction', 3, 'force', &
      'force that the support exerts on the structure', error)
    if (allocated(error)) return
    if (part%lay) call add_field(part%grid, file, on_points, 'lay', 3, '1', &
      'unit axis of mu1 on master surfaces, zero elsewhere', error)
    if (allocated(error)) return
    if (part%stress) call make_stresses(part, file, error)
    if (allocated(error)) return
    if (part%strain) call add_field(part%grid, file, on_cells, 'strain', 6, '1', &
      'strain xx yy zz xy yz zx; xy is half of the shear angle', error)
  end subroutine make_fields

  !> Makes the stresses of cells and points.
  subroutine make_stresses(part, file, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(*), parameter :: unit = 'force/length^2'

    call add_field(part%grid, file, on_cells, 'stress', 6, unit, &
      'Cauchy stress xx yy zz xy yz zx', error)
    if (allocated(error)) return
    call add_field(part%grid, file, on_cells, 'von_mises', 1, unit, &
      'von Mises stress of the cell', error)
    if (allocated(error)) return
    call add_field(part%grid, file, on_points, 'nodal_stress', 6, unit, &
      'mean stress of the cells around a node, weighted by volume', error)
    if (allocated(error)) return
    call add_field(part%grid, file, on_points, 'nodal_von_mises', 1, unit, &
      'von Mises stress of nodal_stress', error)
  end subroutine make_stresses

  !> Writes the fields of one end time; it counts only after end_vtk_frame.
  subroutine append_vtk_frame(part, file, mesh, time, frame, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(in) :: time !! its time [time]
    type(frame_t), intent(in) :: frame !! the fields; those that are wanted are allocated
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call begin_frame(part%grid, file, time, error)
    if (allocated(error)) return
    if (part%displacement) call append_field(part%grid, file, on_points, 'displacement', &
      part%nodes, frame%displacement, error)
    if (allocated(error)) return
    if (part%reaction) call append_field(part%grid, file, on_points, 'reaction', part%nodes, &
      frame%reaction, error)
    if (allocated(error)) return
    if (part%lay) call append_field(part%grid, file, on_points, 'lay', part%nodes, frame%lay, &
      error)
    if (allocated(error)) return
    if (part%stress) call append_stresses(part, file, mesh, frame%stress, error)
    if (allocated(error)) return
    if (part%strain) call append_field(part%grid, file, on_cells, 'strain', part%elements, &
      frame%strain, error)
  end subroutine append_vtk_frame

  !> Writes the stresses of one end time.
  subroutine append_stresses(part, file, mesh, stress, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(in) :: stress(:, :) !! (6, elements) stresses [force/length^2]
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp), allocatable :: nodal(:, :)

    call append_field(part%grid, file, on_cells, 'stress', part%elements, stress, error)
    if (allocated(error)) return
    call append_field(part%grid, file, on_cells, 'von_mises', part%elements, von_mises(stress), &
      error)
    if (allocated(error)) return
    call average_stress(mesh, stress, nodal)
    call append_field(part%grid, file, on_points, 'nodal_stress', part%nodes, nodal, error)
    if (allocated(error)) return
    call append_field(part%grid, file, on_points, 'nodal_von_mises', part%nodes, &
      von_mises(nodal), error)
  end subroutine append_stresses

  !> Writes one field of one end time.
  subroutine append_field(grid, file, group, name, list, values, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: list(:) !! nodes or elements that are written
    real(wp), intent(in) :: values(:, :) !! (components, all nodes or elements) the field
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp), allocatable :: listed(:, :)

    allocate (listed(size(values, 1), size(list)))
    listed(:, :) = values(:, list)
    call write_field(grid, file, group, name, listed, error)
  end subroutine append_field

  !> Makes the end time count, when all of it is on disk.
  subroutine end_vtk_frame(part, file, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call end_frame(part%grid, file, error)
  end subroutine end_vtk_frame
end module results_vtk

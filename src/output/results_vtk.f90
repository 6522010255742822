!> The VTKHDF part of a results file: geometry, fields and end times as ParaView reads them.
!!
!! Layout: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format (UnstructuredGrid with
!! a `Steps` group). The geometry is written once; each field has an offset for each end time.
module results_vtk
  use kinds, only: wp
  use errors, only: error_t
  use mesh_types, only: mesh_t, max_element_nodes
  use model_types, only: output_request_t
  use result_types, only: frame_t
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, write_block, at_end, stored_real, &
    stored_long, stored_integer, stored_byte
  implicit none
  private
  public :: vtk_part_t, create_vtk_part, append_vtk_frame, end_vtk_frame

  !> Root of this part of the file.
  character(*), parameter :: root = '/VTKHDF/'
  !> VTK's numbers of cell types.
  integer, parameter :: vtk_tetra = 10, vtk_quadratic_tetra = 24

  !> What stands in the file, and the nodes and elements behind it.
  type :: vtk_part_t
    integer, allocatable :: nodes(:) !! deck numbers of the points
    integer, allocatable :: elements(:) !! deck numbers of the cells
    integer :: frames = 0 !! end times written
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
    call make_group(file, '/VTKHDF', error)
    if (allocated(error)) return
    call write_attribute(file, '/VTKHDF', 'Version', [2, 0], error)
    if (allocated(error)) return
    call write_attribute(file, '/VTKHDF', 'Type', 'UnstructuredGrid', error)
    if (allocated(error)) return
    call write_points(part, file, mesh, error)
    if (allocated(error)) return
    call write_cells(part, file, mesh, error)
    if (allocated(error)) return
    call make_steps(part, file, error)
    if (allocated(error)) return
    call make_fields(part, file, mesh, error)
  end subroutine create_vtk_part

  !> Writes the points.
  subroutine write_points(part, file, mesh, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp), allocatable :: x(:, :)
    integer :: n

    n = size(part%nodes)
    allocate (x(3, n))
    x(:, :) = mesh%x(:, part%nodes)
    call write_long(file, root//'NumberOfPoints', [n], 'number of points', error)
    if (allocated(error)) return
    call make_series(file, root//'Points', stored_real, [3], n, 'length', &
      'reference coordinates', error)
    if (allocated(error)) return
    call write_block(file, root//'Points', x, at_end, error)
  end subroutine write_points

  !> Writes the cells.
  subroutine write_cells(part, file, mesh, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer, allocatable :: point(:), list(:), offsets(:), types(:)
    integer :: i, k, n, e

    allocate (point(0:mesh%nodes), source=0)
    do i = 1, size(part%nodes)
      point(part%nodes(i)) = i
    end do
    n = size(part%elements)
    allocate (list(max_element_nodes*n), offsets(n + 1), types(n))
    offsets(1) = 0
    do i = 1, n
      e = part%elements(i)
      k = count(mesh%ix(:, e) > 0)
      types(i) = merge(vtk_quadratic_tetra, vtk_tetra, k == 10)
      list(offsets(i) + 1:offsets(i) + k) = point(mesh%ix(:k, e)) - 1
      offsets(i + 1) = offsets(i) + k
    end do
    call write_long(file, root//'NumberOfCells', [n], 'number of cells', error)
    if (allocated(error)) return
    call write_long(file, root//'NumberOfConnectivityIds', [offsets(n + 1)], &
      'length of the list of points of cells', error)
    if (allocated(error)) return
    call write_long(file, root//'Connectivity', list(:offsets(n + 1)), &
      'points of the cells, from 0', error)
    if (allocated(error)) return
    call write_long(file, root//'Offsets', offsets, 'start of each cell in Connectivity', error)
    if (allocated(error)) return
    call make_series(file, root//'Types', stored_byte, [integer ::], n, '1', &
      'VTK cell types: 10 four-node, 24 ten-node tetrahedron', error)
    if (allocated(error)) return
    call write_block(file, root//'Types', types, at_end, error)
  end subroutine write_cells

  !> Makes the table of end times.
  subroutine make_steps(part, file, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(13), parameter :: one_each(3) = [character(13) :: 'PartOffsets', 'NumberOfParts', &
      'PointOffsets']
    integer :: i

    call make_group(file, root//'Steps', error)
    if (allocated(error)) return
    call write_attribute(file, root//'Steps', 'NSteps', part%frames, error)
    if (allocated(error)) return
    call make_series(file, root//'Steps/Values', stored_real, [integer ::], 1, 'time', &
      'times of the fields', error)
    do i = 1, size(one_each)
      if (allocated(error)) return
      call make_series(file, root//'Steps/'//trim(one_each(i)), stored_long, [integer ::], 1, '1', &
        'VTKHDF bookkeeping: the geometry is the same at each end time', error)
    end do
    if (allocated(error)) return
    call make_series(file, root//'Steps/CellOffsets', stored_long, [1], 1, '1', &
      'VTKHDF bookkeeping: the geometry is the same at each end time', error)
    if (allocated(error)) return
    call make_series(file, root//'Steps/ConnectivityIdOffsets', stored_long, [1], 1, '1', &
      'VTKHDF bookkeeping: the geometry is the same at each end time', error)
  end subroutine make_steps

  !> Makes the fields, the constant ones with their values.
  subroutine make_fields(part, file, mesh, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(22), parameter :: groups(4) = [character(22) :: 'PointData', 'CellData', &
      'Steps/PointDataOffsets', 'Steps/CellDataOffsets']
    integer, allocatable :: listed(:)
    integer :: i

    do i = 1, size(groups)
      call make_group(file, root//trim(groups(i)), error)
      if (allocated(error)) return
    end do
    allocate (listed(size(part%elements)))
    call write_constant(file, 'PointData', 'node_number', part%nodes, 'node number of the deck', &
      error)
    if (allocated(error)) return
    call write_constant(file, 'CellData', 'element_number', part%elements, &
      'element number of the deck', error)
    if (allocated(error)) return
    listed(:) = mesh%material(part%elements)
    call write_constant(file, 'CellData', 'material', listed, 'material number of the deck', error)
    if (allocated(error)) return
    listed(:) = mesh%region(part%elements)
    call write_constant(file, 'CellData', 'region', listed, &
      'region, from 1 in the order of the deck, 0 for none; names in /run/regions', error)
    if (allocated(error)) return
    if (part%displacement) call make_field(file, 'PointData', 'displacement', 3, &
      size(part%nodes), 'length', 'displacement', error)
    if (allocated(error)) return
    if (part%reaction) call make_field(file, 'PointData', 'reaction', 3, size(part%nodes), &
      'force', 'force that the support exerts on the structure', error)
    if (allocated(error)) return
    if (part%lay) call make_field(file, 'PointData', 'lay', 3, size(part%nodes), '1', &
      'unit axis of mu1 on master surfaces, zero elsewhere', error)
    if (allocated(error)) return
    if (part%stress) call make_field(file, 'CellData', 'stress', 6, size(part%elements), &
      'force/length^2', 'Cauchy stress xx yy zz xy yz zx', error)
    if (allocated(error)) return
    if (part%strain) call make_field(file, 'CellData', 'strain', 6, size(part%elements), '1', &
      'strain xx yy zz xy yz zx; xy is half of the shear angle', error)
  end subroutine make_fields

  !> Makes one field and its offsets.
  subroutine make_field(file, group, name, components, n, unit, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! PointData or CellData
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: components !! numbers a point or cell
    integer, intent(in) :: n !! points or cells
    character(*), intent(in) :: unit !! unit
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, root//group//'/'//name, stored_real, [components], n, unit, &
      description, error)
    if (allocated(error)) return
    call make_series(file, root//'Steps/'//group//'Offsets/'//name, stored_long, [integer ::], 1, &
      '1', 'first entry of each end time', error)
  end subroutine make_field

  !> Writes a field of integers that is the same at each end time.
  subroutine write_constant(file, group, name, values, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! PointData or CellData
    character(*), intent(in) :: name !! name of the field
    integer, intent(in), contiguous :: values(:) !! its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, root//group//'/'//name, stored_integer, [integer ::], size(values), &
      '1', description, error)
    if (allocated(error)) return
    call write_block(file, root//group//'/'//name, values, at_end, error)
    if (allocated(error)) return
    call make_series(file, root//'Steps/'//group//'Offsets/'//name, stored_long, [integer ::], 1, &
      '1', 'first entry of each end time: always 0', error)
  end subroutine write_constant

  !> Writes a list of integers with 64 bits, as VTK wants its lists.
  subroutine write_long(file, path, values, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    integer, intent(in), contiguous :: values(:) !! its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, path, stored_long, [integer ::], size(values), '1', description, error)
    if (allocated(error)) return
    call write_block(file, path, values, at_end, error)
  end subroutine write_long

  !> Writes the fields of one end time; it counts only after end_vtk_frame.
  subroutine append_vtk_frame(part, file, time, frame, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    real(wp), intent(in) :: time !! its time [time]
    type(frame_t), intent(in) :: frame !! the fields; those that are wanted are allocated
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call append_steps(part, file, time, error)
    if (allocated(error)) return
    if (part%displacement) call append_field(part%frames, file, 'PointData', 'displacement', &
      part%nodes, frame%displacement, error)
    if (allocated(error)) return
    if (part%reaction) call append_field(part%frames, file, 'PointData', 'reaction', part%nodes, &
      frame%reaction, error)
    if (allocated(error)) return
    if (part%lay) call append_field(part%frames, file, 'PointData', 'lay', part%nodes, frame%lay, &
      error)
    if (allocated(error)) return
    if (part%stress) call append_field(part%frames, file, 'CellData', 'stress', part%elements, &
      frame%stress, error)
    if (allocated(error)) return
    if (part%strain) call append_field(part%frames, file, 'CellData', 'strain', part%elements, &
      frame%strain, error)
  end subroutine append_vtk_frame

  !> Lengthens the table of end times, and the offsets of what is always the same.
  subroutine append_steps(part, file, time, error)
    type(vtk_part_t), intent(in) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    real(wp), intent(in) :: time !! time of the fields [time]
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(30), parameter :: zeros(9) = [character(30) :: 'PartOffsets', 'PointOffsets', &
      'CellOffsets', 'ConnectivityIdOffsets', 'PointDataOffsets/node_number', &
      'CellDataOffsets/element_number', 'CellDataOffsets/material', 'CellDataOffsets/region', &
      'NumberOfParts']
    integer :: i, n

    n = part%frames + 1
    call write_block(file, root//'Steps/Values', [time], n, error)
    do i = 1, size(zeros)
      if (allocated(error)) return
      call write_block(file, root//'Steps/'//trim(zeros(i)), [merge(1, 0, i == size(zeros))], n, &
        error)
    end do
  end subroutine append_steps

  !> Writes one field of one end time.
  subroutine append_field(frames, file, group, name, list, values, error)
    integer, intent(in) :: frames !! end times before this one
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! PointData or CellData
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: list(:) !! nodes or elements that are written
    real(wp), intent(in) :: values(:, :) !! (components, all nodes or elements) the field
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp), allocatable :: listed(:, :)

    allocate (listed(size(values, 1), size(list)))
    listed(:, :) = values(:, list)
    call write_block(file, root//group//'/'//name, listed, frames*size(list) + 1, error)
    if (allocated(error)) return
    call write_block(file, root//'Steps/'//group//'Offsets/'//name, [frames*size(list)], &
      frames + 1, error)
  end subroutine append_field

  !> Makes the end time count, when all of it is on disk.
  subroutine end_vtk_frame(part, file, error)
    type(vtk_part_t), intent(inout) :: part !! what stands in the file
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble

    part%frames = part%frames + 1
    call write_attribute(file, root//'Steps', 'NSteps', part%frames, error)
  end subroutine end_vtk_frame
end module results_vtk

!> An unstructured grid in the VTKHDF layout with fields that change in time: geometry, constants,
!! end times, fields. What is in the grid is the business of those who use it.
!!
!! Layout: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format (UnstructuredGrid with
!! a `Steps` group). The geometry is written once; each field has an offset for each end time.
module vtk_grid
  use kinds, only: wp
  use errors, only: error_t
  use text, only: string_t
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, write_block, at_end, stored_real, stored_long, stored_integer, &
    stored_byte
  implicit none
  private
  public :: vtk_grid_t, create_grid, add_constant, add_flags, add_field, begin_frame, &
    write_field, end_frame
  public :: on_points, on_cells
  public :: vtk_vertex, vtk_triangle, vtk_six_nodes

  !> Where a field lives.
  character(*), parameter :: on_points = 'PointData'
  character(*), parameter :: on_cells = 'CellData'

  !> VTK's numbers of cells of the contact surfaces; shapes of bulk elements know theirs.
  integer, parameter :: vtk_vertex = 1, vtk_triangle = 5, vtk_six_nodes = 22

  !> Root of this part of the file.
  character(*), parameter :: root = '/VTKHDF/'
  !> What VTK's offsets say where the geometry is the same at each end time.
  character(*), parameter :: bookkeeping = &
    'VTKHDF bookkeeping: the geometry is the same at each end time'

  !> End times whose offsets are written in one go: they are known beforehand, and writing one
  !! number costs as much as writing a field. Those behind the last end time mean nothing.
  integer, parameter :: ahead = 64

  !> A grid that is being written.
  type :: vtk_grid_t
    integer :: points = 0 !! number of points
    integer :: cells = 0 !! number of cells
    integer :: frames = 0 !! end times written
    type(string_t), allocatable :: constants(:) !! offsets of what never changes
  end type vtk_grid_t

contains

  !> Writes the geometry and the empty table of end times.
  subroutine create_grid(grid, file, x, connectivity, offsets, types, error)
    type(vtk_grid_t), intent(out) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    real(wp), intent(in), contiguous :: x(:, :) !! (3, points) reference coordinates [length]
    integer, intent(in), contiguous :: connectivity(:) !! points of the cells, from 0
    integer, intent(in), contiguous :: offsets(:) !! (cells + 1) where each cell begins, from 0
    integer, intent(in), contiguous :: types(:) !! (cells) VTK's cell types
    type(error_t), allocatable, intent(out) :: error !! file trouble

    grid%points = size(x, 2)
    grid%cells = size(types)
    allocate (grid%constants(0))
    call make_group(file, '/VTKHDF', error)
    if (allocated(error)) return
    call write_attribute(file, '/VTKHDF', 'Version', [2, 0], error)
    if (allocated(error)) return
    call write_attribute(file, '/VTKHDF', 'Type', 'UnstructuredGrid', error)
    if (allocated(error)) return
    call write_long(file, 'NumberOfPoints', [grid%points], 'number of points', error)
    if (allocated(error)) return
    call make_series(file, root//'Points', stored_real, [3], grid%points, 'length', &
      'reference coordinates', error)
    if (allocated(error)) return
    call write_block(file, root//'Points', x, at_end, error)
    if (allocated(error)) return
    call write_cells(grid, file, connectivity, offsets, types, error)
    if (allocated(error)) return
    call make_steps(grid, file, error)
  end subroutine create_grid

  !> Writes the cells.
  subroutine write_cells(grid, file, connectivity, offsets, types, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in), contiguous :: connectivity(:) !! points of the cells, from 0
    integer, intent(in), contiguous :: offsets(:) !! (cells + 1) where each cell begins, from 0
    integer, intent(in), contiguous :: types(:) !! (cells) VTK's cell types
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call write_long(file, 'NumberOfCells', [grid%cells], 'number of cells', error)
    if (allocated(error)) return
    call write_long(file, 'NumberOfConnectivityIds', [size(connectivity)], &
      'length of the list of points of cells', error)
    if (allocated(error)) return
    call write_long(file, 'Connectivity', connectivity, 'points of the cells, from 0', error)
    if (allocated(error)) return
    call write_long(file, 'Offsets', offsets, 'start of each cell in Connectivity', error)
    if (allocated(error)) return
    call make_series(file, root//'Types', stored_byte, [integer ::], max(1, grid%cells), '1', &
      'VTK cell types: 1 vertex, 5 triangle, 22 six-node triangle, 10 four-node, 24 ten-node '// &
      'tetrahedron', error)
    if (allocated(error)) return
    call write_block(file, root//'Types', types, at_end, error)
  end subroutine write_cells

  !> Makes the groups, and the table of end times.
  subroutine make_steps(grid, file, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(22), parameter :: groups(5) = [character(22) :: 'Steps', on_points, on_cells, &
      'Steps/PointDataOffsets', 'Steps/CellDataOffsets']
    character(13), parameter :: one_each(3) = [character(13) :: 'PartOffsets', 'NumberOfParts', &
      'PointOffsets']
    character(21), parameter :: by_topology(2) = [character(21) :: 'CellOffsets', &
      'ConnectivityIdOffsets']
    integer :: i

    do i = 1, size(groups)
      call make_group(file, root//trim(groups(i)), error)
      if (allocated(error)) return
    end do
    call write_attribute(file, root//'Steps', 'NSteps', grid%frames, error)
    if (allocated(error)) return
    call make_series(file, root//'Steps/Values', stored_real, [integer ::], 1, 'time', &
      'times of the fields', error)
    do i = 1, size(one_each)
      if (allocated(error)) return
      call make_series(file, root//'Steps/'//trim(one_each(i)), stored_long, [integer ::], 1, '1', &
        bookkeeping, error)
    end do
    do i = 1, size(by_topology)
      if (allocated(error)) return
      call make_series(file, root//'Steps/'//trim(by_topology(i)), stored_long, [1], 1, '1', &
        bookkeeping, error)
    end do
  end subroutine make_steps

  !> Writes integers that are the same at each end time.
  subroutine add_constant(grid, file, group, name, values, description, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    integer, intent(in), contiguous :: values(:) !! (points or cells) its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call add_numbers(grid, file, group, name, stored_integer, values, description, error)
  end subroutine add_constant

  !> Writes a mark of some points or cells: 1, and 0 elsewhere.
  subroutine add_flags(grid, file, group, name, marked, description, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    logical, intent(in) :: marked(:) !! (points or cells) which
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer, allocatable :: flags(:)

    allocate (flags(size(marked)))
    flags(:) = merge(1, 0, marked)
    call add_numbers(grid, file, group, name, stored_byte, flags, description, error)
  end subroutine add_flags

  !> Writes integers that are the same at each end time, and makes their offsets.
  subroutine add_numbers(grid, file, group, name, stored, values, description, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: stored !! one of the stored constants
    integer, intent(in), contiguous :: values(:) !! (points or cells) its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble
    type(string_t), allocatable :: longer(:)
    integer :: n

    call make_series(file, root//group//'/'//name, stored, [integer ::], max(1, size(values)), &
      '1', description, error)
    if (allocated(error)) return
    call write_block(file, root//group//'/'//name, values, at_end, error)
    if (allocated(error)) return
    n = size(grid%constants)
    allocate (longer(n + 1))
    longer(:n) = grid%constants
    longer(n + 1)%s = root//'Steps/'//group//'Offsets/'//name
    call move_alloc(longer, grid%constants)
    call make_series(file, grid%constants(n + 1)%s, stored_long, [integer ::], 1, '1', &
      'first entry of each end time: always 0', error)
  end subroutine add_numbers

  !> Makes one field and its offsets.
  subroutine add_field(grid, file, group, name, components, unit, description, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: components !! numbers a point or cell
    character(*), intent(in) :: unit !! unit
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: n

    n = max(1, merge(grid%points, grid%cells, group == on_points))
    if (components == 1) then
      call make_series(file, root//group//'/'//name, stored_real, [integer ::], n, unit, &
        description, error, file%end_times)
    else
      call make_series(file, root//group//'/'//name, stored_real, [components], n, unit, &
        description, error, file%end_times)
    end if
    if (allocated(error)) return
    call make_series(file, root//'Steps/'//group//'Offsets/'//name, stored_long, [integer ::], 1, &
      '1', 'first entry of each end time', error)
  end subroutine add_field

  !> Lengthens the table of end times, and the offsets of what is always the same; the end time
  !! counts only after end_frame.
  subroutine begin_frame(grid, file, time, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    real(wp), intent(in) :: time !! time of the fields [time]
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(21), parameter :: zeros(5) = [character(21) :: 'PartOffsets', 'PointOffsets', &
      'CellOffsets', 'ConnectivityIdOffsets', 'NumberOfParts']
    integer :: i, n

    n = grid%frames + 1
    call write_block(file, root//'Steps/Values', [time], n, error)
    if (mod(grid%frames, ahead) > 0) return
    do i = 1, size(zeros)
      if (allocated(error)) return
      call write_block(file, root//'Steps/'//trim(zeros(i)), &
        spread(merge(1, 0, i == size(zeros)), 1, ahead), n, error)
    end do
    do i = 1, size(grid%constants)
      if (allocated(error)) return
      call write_block(file, grid%constants(i)%s, spread(0, 1, ahead), n, error)
    end do
  end subroutine begin_frame

  !> Writes one field of the end time that has begun.
  subroutine write_field(grid, file, group, name, values, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    real(wp), intent(in), contiguous :: values(:, :) !! (components, points or cells)
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: n, k

    n = size(values, 2)
    call write_block(file, root//group//'/'//name, values, grid%frames*n + 1, error)
    if (allocated(error) .or. mod(grid%frames, ahead) > 0) return
    call write_block(file, root//'Steps/'//group//'Offsets/'//name, &
      [(k*n, k=grid%frames, grid%frames + ahead - 1)], grid%frames + 1, error)
  end subroutine write_field

  !> Makes the end time count, when all of it is on disk.
  subroutine end_frame(grid, file, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! file trouble

    grid%frames = grid%frames + 1
    call write_attribute(file, root//'Steps', 'NSteps', grid%frames, error)
  end subroutine end_frame

  !> Writes a list of integers with 64 bits, as VTK wants its lists.
  subroutine write_long(file, name, values, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: name !! data set of /VTKHDF
    integer, intent(in), contiguous :: values(:) !! its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, root//name, stored_long, [integer ::], max(1, size(values)), '1', &
      description, error)
    if (allocated(error)) return
    call write_block(file, root//name, values, at_end, error)
  end subroutine write_long
end module vtk_grid

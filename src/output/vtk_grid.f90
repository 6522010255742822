!> An unstructured grid in the VTKHDF layout with fields that change in time: geometry, constants,
!! end times, fields. What is in the grid is the business of those who use it.
!!
!! Layout: https://docs.vtk.org/en/latest/vtk_file_formats/vtkhdf_file_format (UnstructuredGrid with
!! a `Steps` group). The geometry is written once; each field has an offset for each end time.
module vtk_grid
  use kinds, only: wp
  use errors, only: error_t
  use costs, only: wall_seconds
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_attributes, only: write_attribute
  use hdf5_data, only: make_series, write_block, at_end, stored_real, stored_long, stored_integer, &
    stored_byte
  use hdf5_held, only: hold_block, write_held
  implicit none
  private
  public :: vtk_grid_t, create_grid, add_constant, add_flags, add_field, begin_frame, add_values, &
    are_frames_due, write_frames, count_frames
  public :: on_points, on_cells
  public :: vtk_vertex, vtk_triangle, vtk_six_nodes

  !> Where a field lives.
  character(*), parameter :: on_points = 'PointData'
  character(*), parameter :: on_cells = 'CellData'

  !> VTK's numbers of cells of the contact surfaces; shapes of bulk elements know theirs.
  integer, parameter :: vtk_vertex = 1, vtk_triangle = 5, vtk_six_nodes = 22

  !> Root of this part of the file.
  character(*), parameter :: grid_root = '/VTKHDF/'
  !> End times whose offsets are written in one go: they are known beforehand, and writing one
  !! number costs as much as writing a field. Those behind the last end time mean nothing.
  integer, parameter :: ahead = 64
  !> Fields wait in memory for at most this long while end times come [s], and not at all where one
  !! takes so long that writing it, some ms, costs next to nothing [s].
  real(wp), parameter :: seconds_held = 1.0_wp, slow = 0.05_wp

  !> A grid that is being written.
  type :: vtk_grid_t
    integer :: points = 0 !! number of points
    integer :: cells = 0 !! number of cells
    integer :: frames = 0 !! end times, those that wait in memory among them
    integer :: counted = 0 !! end times that count
    integer :: listed = 0 !! end times whose offsets are written
    integer, allocatable :: known(:, :) !! (3, sets) data sets of numbers that are known beforehand:
    !! place in the file, number of the first end time, how much more it is for each one
    real(wp) :: written_at = 0.0_wp !! clock when all was written last [s]
    real(wp) :: seen_at = 0.0_wp !! clock at the last end time [s]
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
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    grid%points = size(x, 2)
    grid%cells = size(types)
    allocate (grid%known(3, 0))
    call make_group(file, '/VTKHDF', error)
    call write_attribute(file, '/VTKHDF', 'Version', [2, 0], error)
    call write_attribute(file, '/VTKHDF', 'Type', 'UnstructuredGrid', error)
    call write_long(file, 'NumberOfPoints', [grid%points], 'number of points', error)
    call make_series(file, grid_root//'Points', stored_real, [3], grid%points, 'length', &
      'reference coordinates', error)
    call write_block(file, grid_root//'Points', x, at_end, error)
    call write_cells(grid, file, connectivity, offsets, types, error)
    call make_steps(grid, file, error)
  end subroutine create_grid

  !> Writes the cells.
  subroutine write_cells(grid, file, connectivity, offsets, types, error)
    type(vtk_grid_t), intent(in) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in), contiguous :: connectivity(:) !! points of the cells, from 0
    integer, intent(in), contiguous :: offsets(:) !! (cells + 1) where each cell begins, from 0
    integer, intent(in), contiguous :: types(:) !! (cells) VTK's cell types
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_long(file, 'NumberOfCells', [grid%cells], 'number of cells', error)
    call write_long(file, 'NumberOfConnectivityIds', [size(connectivity)], &
      'length of the list of points of cells', error)
    call write_long(file, 'Connectivity', connectivity, 'points of the cells, from 0', error)
    call write_long(file, 'Offsets', offsets, 'start of each cell in Connectivity', error)
    call make_series(file, grid_root//'Types', stored_byte, [integer ::], max(1, grid%cells), '1', &
      'VTK cell types: 1 vertex, 5 triangle, 22 six-node triangle, 10 four-node, 24 ten-node '// &
      'tetrahedron', error)
    call write_block(file, grid_root//'Types', types, at_end, error)
  end subroutine write_cells

  !> Makes the groups, and the table of end times.
  subroutine make_steps(grid, file, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(22), parameter :: groups(5) = [character(22) :: 'Steps', on_points, on_cells, &
      'Steps/PointDataOffsets', 'Steps/CellDataOffsets']
    character(22), parameter :: known(5) = [character(22) :: 'PartOffsets', 'NumberOfParts', &
      'PointOffsets', 'CellOffsets', 'ConnectivityIdOffsets']
    integer :: i, one(1)

    one = 1
    do i = 1, size(groups)
      call make_group(file, grid_root//trim(groups(i)), error)
    end do
    call write_attribute(file, grid_root//'Steps', 'NSteps', grid%frames, error)
    call make_series(file, grid_root//'Steps/Values', stored_real, [integer ::], 1, 'time', &
      'times of the fields', error)
    do i = 1, size(known)
      call add_known(grid, file, trim(known(i)), one(:merge(1, 0, i > 3)), &
        merge(1, 0, i == 2), 0, &
        'VTKHDF bookkeeping: the geometry is the same at each output time', error)
    end do
  end subroutine make_steps

  !> Makes a data set of numbers that are known beforehand.
  subroutine add_known(grid, file, name, leading, first, each, description, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: name !! data set of /VTKHDF/Steps
    integer, intent(in) :: leading(:) !! dimensions before the last
    integer, intent(in) :: first !! number of the first end time
    integer, intent(in) :: each !! how much more it is for each one
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_series(file, grid_root//'Steps/'//name, stored_long, leading, 1, '1', description, &
      error)
    grid%known = reshape([grid%known, file%n_open, first, each], [3, size(grid%known, 2) + 1])
  end subroutine add_known

  !> Writes integers that are the same at each end time.
  subroutine add_constant(grid, file, group, name, values, description, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    integer, intent(in), contiguous :: values(:) !! (points or cells) its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble

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
    type(error_t), allocatable, intent(inout) :: error !! file trouble
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
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_series(file, grid_root//group//'/'//name, stored, [integer ::], &
      max(1, size(values)), &
      '1', description, error)
    call write_block(file, grid_root//group//'/'//name, values, at_end, error)
    call add_known(grid, file, group//'Offsets/'//name, [integer ::], 0, 0, &
      'first entry of each output time: always 0', error)
  end subroutine add_numbers

  !> Makes one field and its offsets.
  subroutine add_field(grid, file, group, name, stored, components, unit, description, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: stored !! stored_real or stored_single
    integer, intent(in) :: components !! numbers a point or cell
    character(*), intent(in) :: unit !! unit
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: leading(1), n

    leading = components
    n = merge(grid%points, grid%cells, group == on_points)
    call make_series(file, grid_root//group//'/'//name, stored, &
      leading(:merge(1, 0, components > 1)), &
      max(1, n), unit, description, error, file%blocks)
    call add_known(grid, file, group//'Offsets/'//name, [integer ::], 0, n, &
      'first entry of each output time', error)
  end subroutine add_field

  !> Begins an end time: it waits in memory until write_frames, and counts after count_frames.
  subroutine begin_frame(grid, file, time, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    real(wp), intent(in) :: time !! time of the fields [time]
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call hold_block(file, grid_root//'Steps/Values', [time], error)
    grid%frames = grid%frames + 1
  end subroutine begin_frame

  !> Adds one field to the end time that has begun.
  subroutine add_values(file, group, name, values, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! on_points or on_cells
    character(*), intent(in) :: name !! name of the field
    real(wp), intent(in), contiguous :: values(:, :) !! (components, points or cells)
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call hold_block(file, grid_root//group//'/'//name, values, error)
  end subroutine add_values

  !> It is time to write the end times that wait: they fill a chunk, or have waited for long, or the
  !! last one took so long that writing does not count. Asked once at each end time.
  logical function are_frames_due(grid, file) result(due)
    type(vtk_grid_t), intent(inout) :: grid !! the grid; its clock
    type(hdf5_file_t), intent(in) :: file !! its file
    real(wp) :: now

    now = wall_seconds()
    due = grid%frames > grid%counted .and. (mod(grid%frames, file%blocks) == 0 .or. &
      now > grid%written_at + seconds_held .or. now > grid%seen_at + slow)
    grid%seen_at = now
    if (due .or. grid%frames == grid%counted) grid%written_at = now
  end function are_frames_due

  !> Writes the end times that wait.
  subroutine write_frames(grid, file, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    character(:), allocatable :: path
    integer :: i, k

    if (allocated(error)) return
    do while (grid%listed < grid%frames)
      do i = 1, size(grid%known, 2)
        path = file%sets(grid%known(1, i))%path
        call write_block(file, path, [(grid%known(2, i) + k*grid%known(3, i), k=grid%listed, &
          grid%listed + ahead - 1)], grid%listed + 1, error)
        if (allocated(error)) return
      end do
      grid%listed = grid%listed + ahead
    end do
    call write_held(file, error)
  end subroutine write_frames

  !> Makes the end times count that have been written, when all of them are on disk.
  subroutine count_frames(grid, file, error)
    type(vtk_grid_t), intent(inout) :: grid !! the grid
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    if (allocated(error)) return
    grid%counted = grid%frames
    call write_attribute(file, grid_root//'Steps', 'NSteps', grid%counted, error)
  end subroutine count_frames

  !> Writes a list of integers with 64 bits, as VTK wants its lists.
  subroutine write_long(file, name, values, description, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: name !! data set of /VTKHDF
    integer, intent(in), contiguous :: values(:) !! its values
    character(*), intent(in) :: description !! meaning
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_series(file, grid_root//name, stored_long, [integer ::], max(1, size(values)), '1', &
      description, error)
    call write_block(file, grid_root//name, values, at_end, error)
  end subroutine write_long
end module vtk_grid

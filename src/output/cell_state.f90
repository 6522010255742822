!> The restart part of a results file: the cells of segmented pairs.
module cell_state
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use contact_types, only: cell_t
  use hdf5_io, only: hdf5_file_t
  use hdf5_data, only: make_series, write_block, read_block, stored_real, stored_integer
  implicit none
  private
  public :: create_cells, write_cells, read_cells

contains

  !> Makes the data sets of a segmented pair.
  subroutine create_cells(file, group, points, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    integer, intent(in) :: points !! number of its points
    type(error_t), allocatable, intent(out) :: error !! file trouble

    call make_series(file, group//'/slave', stored_integer, [points], 1, '1', &
      'slave facet of the point, from 1, 0 while it is not in use', error)
    if (allocated(error)) return
    call make_series(file, group//'/weight', stored_real, [3, points], 1, '1', &
      'weights of the corners of the slave facet', error)
    if (allocated(error)) return
    call make_series(file, group//'/area', stored_real, [points], 1, 'length^2', &
      'reference area of the point', error)
    if (allocated(error)) return
    call make_series(file, group//'/place', stored_real, [2, points], 1, '1', &
      '(xi, eta) of the point in its host when its cell was made', error)
  end subroutine create_cells

  !> Writes the cells of one pair.
  subroutine write_cells(file, group, cells, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    type(cell_t), intent(in) :: cells(:) !! (points) the cells
    integer, intent(in) :: slot !! place of the state in the file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: weight(3, size(cells)), place(2, size(cells)), area(size(cells))
    integer :: slave(size(cells)), p

    do p = 1, size(cells)
      slave(p) = cells(p)%slave
      area(p) = cells(p)%area
      weight(:, p) = cells(p)%weight
      place(:, p) = cells(p)%place
    end do
    call write_block(file, group//'/slave', slave, slot, error)
    if (allocated(error)) return
    call write_block(file, group//'/weight', weight, slot, error)
    if (allocated(error)) return
    call write_block(file, group//'/area', area, slot, error)
    if (allocated(error)) return
    call write_block(file, group//'/place', place, slot, error)
  end subroutine write_cells

  !> Reads the cells of one pair.
  subroutine read_cells(file, group, facets, slot, cells, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: group !! group of the pair
    integer, intent(in) :: facets !! number of its slave facets
    integer, intent(in) :: slot !! place of the state in the file
    type(cell_t), intent(inout) :: cells(:) !! (points) the cells
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: weight(3, size(cells)), place(2, size(cells)), area(size(cells))
    integer :: slave(size(cells)), p

    call read_block(file, group//'/slave', slave, slot, error)
    if (allocated(error)) return
    call read_block(file, group//'/weight', weight, slot, error)
    if (allocated(error)) return
    call read_block(file, group//'/area', area, slot, error)
    if (allocated(error)) return
    call read_block(file, group//'/place', place, slot, error)
    if (allocated(error)) return
    if (any(slave < 0 .or. slave > facets)) then
      call raise(error, exit_deck, 'slave facet out of range')
      return
    end if
    do p = 1, size(cells)
      cells(p)%slave = slave(p)
      cells(p)%weight = weight(:, p)
      cells(p)%area = area(p)
      cells(p)%place = place(:, p)
    end do
  end subroutine read_cells
end module cell_state

!> Regular meshes of a block that eight master points span.
module mesh_generation
  use kinds, only: wp
  use tetrahedra, only: relative_volume, flat_limit
  implicit none
  private
  public :: block_t, block_nodes, block_elements, block_point, block_cell, cell_tetrahedra, &
    block_fits, check_block, orientation_right, orientation_left, orientation_bad

  !> Orientation of a block: its tetrahedra have positive, negative, or mixed and zero volumes.
  integer, parameter :: orientation_right = 1
  integer, parameter :: orientation_left = -1
  integer, parameter :: orientation_bad = 0

  !> The six tetrahedra of a cell (all hold the diagonal 1-7): corners 1-4 the lower face, 5-8
  !! above, so that neighbouring cells share the diagonals of their common faces.
  integer, parameter :: cell_tetrahedra(4, 6) = reshape([1, 2, 3, 7, 1, 3, 4, 7, 1, 4, 8, 7, &
    1, 8, 5, 7, 1, 5, 6, 7, 1, 6, 2, 7], [4, 6])

  !> Natural coordinates of the master points.
  integer, parameter :: natural(3, 8) = reshape([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, &
    -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1], [3, 8])

  !> A block: cells along its three edges, and its corners.
  type :: block_t
    integer :: cells(3) = 0 !! cells along the three edges
    real(wp) :: corner(3, 8) = 0.0_wp !! master points [length]
  end type block_t

contains

  !> True if the counts of a block stay within the given limits (safe against overflow).
  pure logical function block_fits(cells, max_nodes, max_elements) result(fits)
    integer, intent(in) :: cells(3) !! cells along the three edges, > 0
    integer, intent(in) :: max_nodes !! most nodes
    integer, intent(in) :: max_elements !! most elements

    fits = product(real(cells, wp) + 1.0_wp) <= real(max_nodes, wp) .and. &
      6.0_wp*product(real(cells, wp)) <= real(max_elements, wp)
  end function block_fits

  !> Number of nodes of a block.
  pure integer function block_nodes(cells) result(n)
    integer, intent(in) :: cells(3) !! cells along the three edges

    n = product(cells + 1)
  end function block_nodes

  !> Number of tetrahedra of a block.
  pure integer function block_elements(cells) result(n)
    integer, intent(in) :: cells(3) !! cells along the three edges

    n = 6*product(cells)
  end function block_elements

  !> Coordinates of node `n` of a block (from 1, direction 1 fastest): trilinear map.
  pure function block_point(block, n) result(x)
    type(block_t), intent(in) :: block !! the block
    integer, intent(in) :: n !! node within the block
    real(wp) :: x(3), r(3)
    integer :: i(3), c

    i(1) = mod(n - 1, block%cells(1) + 1)
    i(2) = mod((n - 1)/(block%cells(1) + 1), block%cells(2) + 1)
    i(3) = (n - 1)/((block%cells(1) + 1)*(block%cells(2) + 1))
    ! weights (1 -+ r)/2 as fractions of the cells: exact at the corners
    r = real(i, wp)/real(block%cells, wp)
    x = 0.0_wp
    do c = 1, 8
      x = x + product(merge(r, 1.0_wp - r, natural(:, c) > 0))*block%corner(:, c)
    end do
  end function block_point

  !> Nodes of the cell `n` of a block (from 1, direction 1 fastest), numbered within the block.
  pure function block_cell(cells, n) result(nodes)
    integer, intent(in) :: cells(3) !! cells along the three edges
    integer, intent(in) :: n !! cell within the block
    integer :: nodes(8), i(3), row, layer

    row = cells(1) + 1
    layer = row*(cells(2) + 1)
    i(1) = mod(n - 1, cells(1))
    i(2) = mod((n - 1)/cells(1), cells(2))
    i(3) = (n - 1)/(cells(1)*cells(2))
    nodes(1) = 1 + i(1) + row*i(2) + layer*i(3)
    nodes(2:4) = nodes(1) + [1, row + 1, row]
    nodes(5:8) = nodes(1:4) + layer
  end function block_cell

  !> Orientation of all tetrahedra of a block, and the first one that spoils it.
  pure subroutine check_block(block, orientation, cell)
    type(block_t), intent(in) :: block !! the block
    integer, intent(out) :: orientation !! one of the orientation constants
    integer, intent(out) :: cell !! cell of the first bad tetrahedron, 0 if there is none
    integer :: n, t, c, nodes(8)
    real(wp) :: x(3, 8), v

    orientation = orientation_bad
    do n = 1, product(block%cells)
      nodes = block_cell(block%cells, n)
      do c = 1, 8
        x(:, c) = block_point(block, nodes(c))
      end do
      do t = 1, 6
        v = relative_volume(x(:, cell_tetrahedra(:, t)))
        if (orientation == orientation_bad) orientation = nint(sign(1.0_wp, v))
        if (v*real(orientation, wp) > flat_limit) cycle
        orientation = orientation_bad
        cell = n
        return
      end do
    end do
    cell = 0
  end subroutine check_block
end module mesh_generation

!> Regular meshes of a block that 8 to 27 master points span.
module mesh_generation
  use kinds, only: wp
  use cells, only: brick, tet4, tet10, most_nodes
  use cell_geometry, only: cell_orientation, no_volume
  implicit none
  private
  public :: block_t, complete_block, block_nodes, block_elements, block_point, block_tetrahedron, &
    block_fits, check_block

  !> Natural coordinates of the master points, numbered as in FEAP: the corners, the edges along
  !! direction 3, lower face, upper face, side faces, centre.
  integer, parameter :: natural(3, 27) = reshape([-1, -1, -1, 1, -1, -1, 1, 1, -1, -1, 1, -1, &
    -1, -1, 1, 1, -1, 1, 1, 1, 1, -1, 1, 1, &
    -1, -1, 0, 1, -1, 0, 1, 1, 0, -1, 1, 0, &
    0, -1, -1, 1, 0, -1, 0, 1, -1, -1, 0, -1, 0, 0, -1, &
    0, -1, 1, 1, 0, 1, 0, 1, 1, -1, 0, 1, 0, 0, 1, &
    0, -1, 0, 1, 0, 0, 0, 1, 0, -1, 0, 0, 0, 0, 0], [3, 27])

  !> A block: cells along its three edges, and its master points.
  type :: block_t
    integer :: cells(3) = 0 !! cells along the three edges
    integer :: order = 1 !! 1: elements of four nodes, 2: of ten
    logical :: curved = .false. !! more than the corners are given
    real(wp) :: point(3, 27) = 0.0_wp !! master points, the first eight the corners [length]
  end type block_t

contains

  !> Gives the master points that the deck leaves out their places: edges straight, faces and centre
  !! as the edges around them have it (transfinite: FEAP's faces, and a centre that fits them).
  pure subroutine complete_block(block, there)
    type(block_t), intent(inout) :: block !! corners and points of `there` given
    logical, intent(in) :: there(27) !! points that are given
    logical :: edges(27), corners(27)
    integer :: c, zeros

    block%curved = any(there(9:))
    do zeros = 1, 2
      do c = 9, 26
        if (there(c) .or. count(natural(:, c) == 0) /= zeros) cycle
        corners = on_same_side(c) .and. count(natural == 0, dim=1) == 0
        edges = on_same_side(c) .and. count(natural == 0, dim=1) == 1
        if (zeros == 1) block%point(:, c) = 0.5_wp*total(corners)
        if (zeros == 2) block%point(:, c) = 0.5_wp*total(edges) - 0.25_wp*total(corners)
      end do
    end do
    edges = count(natural == 0, dim=1) == 1
    corners = count(natural == 0, dim=1) == 0
    if (.not. there(27)) block%point(:, 27) = 0.5_wp*total(count(natural == 0, dim=1) == 2) - &
      0.25_wp*total(edges) + 0.125_wp*total(corners)

  contains

    !> Master points that share the coordinates of point `c` that are not zero.
    pure function on_same_side(c) result(same)
      integer, intent(in) :: c !! a master point
      logical :: same(27)
      integer :: i

      do i = 1, 27
        same(i) = all(natural(:, c) == 0 .or. natural(:, c) == natural(:, i))
      end do
    end function on_same_side

    !> Sum of the chosen points.
    pure function total(chosen) result(x)
      logical, intent(in) :: chosen(27) !! which points
      real(wp) :: x(3)

      x = sum(block%point, dim=2, mask=spread(chosen, 1, 3))
    end function total
  end subroutine complete_block

  !> True if the counts of a block stay within the given limits (safe against overflow).
  pure logical function block_fits(block, max_nodes, max_elements) result(fits)
    type(block_t), intent(in) :: block !! its cells, > 0, and order
    integer, intent(in) :: max_nodes !! most nodes
    integer, intent(in) :: max_elements !! most elements

    fits = product(real(block%order, wp)*real(block%cells, wp) + 1.0_wp) <= real(max_nodes, wp) &
      .and. real(brick%pieces, wp)*product(real(block%cells, wp)) <= real(max_elements, wp)
  end function block_fits

  !> Number of nodes of a block.
  pure integer function block_nodes(block) result(n)
    type(block_t), intent(in) :: block !! the block

    n = product(block%order*block%cells + 1)
  end function block_nodes

  !> Number of tetrahedra of a block.
  pure integer function block_elements(cells) result(n)
    integer, intent(in) :: cells(3) !! cells along the three edges

    n = brick%pieces*product(cells)
  end function block_elements

  !> Coordinates of node `n` of a block (from 1, direction 1 fastest): trilinear map of the
  !! corners, triquadratic map of all master points.
  pure function block_point(block, n) result(x)
    type(block_t), intent(in) :: block !! the block
    integer, intent(in) :: n !! node within the block
    real(wp) :: x(3), r(3), share(3, -1:1)
    integer :: i(3), c, points(3)

    points = block%order*block%cells + 1
    i(1) = mod(n - 1, points(1))
    i(2) = mod((n - 1)/points(1), points(2))
    i(3) = (n - 1)/(points(1)*points(2))
    ! weights (1 -+ r)/2 as fractions of the cells: exact at the corners
    r = real(i, wp)/real(block%order*block%cells, wp)
    x = 0.0_wp
    if (.not. block%curved) then
      do c = 1, 8
        x = x + product(merge(r, 1.0_wp - r, natural(:, c) > 0))*block%point(:, c)
      end do
      return
    end if
    share(:, -1) = (2.0_wp*r - 1.0_wp)*(r - 1.0_wp)
    share(:, 0) = 4.0_wp*r*(1.0_wp - r)
    share(:, 1) = r*(2.0_wp*r - 1.0_wp)
    do c = 1, 27
      x = x + share(1, natural(1, c))*share(2, natural(2, c))*share(3, natural(3, c))* &
        block%point(:, c)
    end do
  end function block_point

  !> Nodes of a tetrahedron of the cell `n` of a block (from 1, direction 1 fastest), numbered
  !! within the block: the middles of its edges are points of the block as well.
  pure function block_tetrahedron(block, n, t) result(nodes)
    type(block_t), intent(in) :: block !! the block
    integer, intent(in) :: n !! cell within the block
    integer, intent(in) :: t !! its tetrahedron, 1 to 6
    integer, allocatable :: nodes(:)
    integer :: first(3), place(3, most_nodes), points(3), k

    first(1) = mod(n - 1, block%cells(1))
    first(2) = mod((n - 1)/block%cells(1), block%cells(2))
    first(3) = (n - 1)/(block%cells(1)*block%cells(2))
    do k = 1, 4
      place(:, k) = block%order*(first + (natural(:, brick%piece(k, t)) + 1)/2)
    end do
    do k = 5, tet10%nodes
      place(:, k) = (place(:, tet10%ends(1, k)) + place(:, tet10%ends(2, k)))/2
    end do
    points = block%order*block%cells + 1
    nodes = 1 + place(1, :) + points(1)*(place(2, :) + points(2)*place(3, :))
    if (block%order == 1) nodes = nodes(:tet4%nodes)
  end function block_tetrahedron

  !> Orientation of all tetrahedra of a block, and the first one that spoils it.
  pure subroutine check_block(block, orientation, cell)
    type(block_t), intent(in) :: block !! the block
    integer, intent(out) :: orientation !! no_volume, right_handed or left_handed
    integer, intent(out) :: cell !! cell of the first bad tetrahedron, 0 if there is none
    integer :: n, t, c, own
    real(wp) :: x(3, 4)

    orientation = no_volume
    do n = 1, product(block%cells)
      do t = 1, brick%pieces
        associate (nodes => block_tetrahedron(block, n, t))
          do c = 1, 4
            x(:, c) = block_point(block, nodes(c))
          end do
        end associate
        own = cell_orientation(x, [1, 2, 3, 4])
        if (orientation == no_volume) orientation = own
        if (own == orientation .and. own /= no_volume) cycle
        orientation = no_volume
        cell = n
        return
      end do
    end do
    cell = 0
  end subroutine check_block
end module mesh_generation

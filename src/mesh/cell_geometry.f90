!> Geometry of cells and triangles: what is asked of a cell is asked of the tetrahedra between its
!! corners.
module cell_geometry
  use kinds, only: wp
  use vectors, only: cross, determinant
  use cells, only: shapes, kind_of, corners_of
  implicit none
  private
  public :: cell_volume, cell_growth, cell_orientation, cell_aspect, cell_height, cell_middle
  public :: longest_edge, facet_vector, point_towards, shares_of_points
  public :: right_handed, left_handed, no_volume

  !> Orientation of a cell: its tetrahedra have positive, negative, or mixed and zero volumes.
  integer, parameter :: right_handed = 1
  integer, parameter :: left_handed = -1
  integer, parameter :: no_volume = 0

  !> A tetrahedron whose six-fold volume is below this part of its cubed longest edge is flat.
  real(wp), parameter :: flat_limit = 1.0e-12_wp

contains

  !> Volume between the corners of a cell; negative if it is left-handed.
  pure real(wp) function cell_volume(x, nodes) result(volume)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell, zeros behind the last
    integer :: i, k

    volume = 0.0_wp
    k = kind_of(nodes)
    do i = 1, shapes(k)%pieces
      volume = volume + tetrahedron_volume(piece_of(x, nodes, k, i))
    end do
  end function cell_volume

  !> What the volume of a cell changes by where its nodes move: that of each tetrahedron times the
  !! gradients of its shape functions.
  pure function cell_growth(x, nodes) result(g)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell, zeros behind the last
    real(wp) :: g(3, size(nodes)), part(3, 4), y(3, 4)
    integer :: i, k

    g = 0.0_wp
    k = kind_of(nodes)
    do i = 1, shapes(k)%pieces
      y = piece_of(x, nodes, k, i)
      part(:, 2) = cross(y(:, 3) - y(:, 1), y(:, 4) - y(:, 1))/6.0_wp
      part(:, 3) = cross(y(:, 4) - y(:, 1), y(:, 2) - y(:, 1))/6.0_wp
      part(:, 4) = cross(y(:, 2) - y(:, 1), y(:, 3) - y(:, 1))/6.0_wp
      part(:, 1) = -(part(:, 2) + part(:, 3) + part(:, 4))
      g(:, shapes(k)%piece(:, i)) = g(:, shapes(k)%piece(:, i)) + part
    end do
  end function cell_growth

  !> Orientation of a cell: right_handed, left_handed or no_volume.
  pure integer function cell_orientation(x, nodes) result(orientation)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell, zeros behind the last
    real(wp) :: volume
    integer :: i, k, signs

    signs = 0
    k = kind_of(nodes)
    do i = 1, shapes(k)%pieces
      volume = relative_volume(piece_of(x, nodes, k, i))
      if (abs(volume) > flat_limit) signs = signs + nint(sign(1.0_wp, volume))
    end do
    orientation = signs/shapes(k)%pieces
  end function cell_orientation

  !> Longest edge over the shortest height of the worst tetrahedron of a cell; sqrt(3/2) for a
  !! regular one, huge for a flat one.
  pure real(wp) function cell_aspect(x, nodes) result(ratio)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell, zeros behind the last
    integer :: i, k

    ratio = 0.0_wp
    k = kind_of(nodes)
    do i = 1, shapes(k)%pieces
      ratio = max(ratio, aspect_ratio(piece_of(x, nodes, k, i)))
    end do
  end function cell_aspect

  !> The least height of a tetrahedron of a cell.
  pure real(wp) function cell_height(x, nodes) result(height)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell, zeros behind the last
    integer :: i, k

    height = huge(1.0_wp)
    k = kind_of(nodes)
    do i = 1, shapes(k)%pieces
      height = min(height, least_height(piece_of(x, nodes, k, i)))
    end do
  end function cell_height

  !> The mean of the corners of a cell.
  pure function cell_middle(x, nodes) result(middle)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell, zeros behind the last
    real(wp) :: middle(3)

    associate (corners => corners_of(nodes))
      middle = sum(x(:, corners), 2)/real(size(corners), wp)
    end associate
  end function cell_middle

  !> Where the points of a curved element of ten nodes lie on the way from its centre to a corner:
  !! two tetrahedra of points, degree 3 with equal weights.
  pure function shares_of_points() result(share)
    real(wp) :: share(2)
    real(wp) :: sum_s, root

    sum_s = 2.0_wp*sqrt(0.4_wp)*cos((acos(-sqrt(10.0_wp)/6.0_wp) + 4.0_wp*acos(-1.0_wp))/3.0_wp)
    root = sqrt(0.25_wp*sum_s**2 - 0.5_wp*(sum_s**2 - 0.4_wp))
    share = 0.5_wp*sum_s + [root, -root]
  end function shares_of_points

  !> The point at a share of the way from the centre to a corner.
  pure function point_towards(corner, share) result(l)
    integer, intent(in) :: corner !! 1 to 4
    real(wp), intent(in) :: share !! of the way; negative: away from it
    real(wp) :: l(4)

    l = 0.25_wp*(1.0_wp - share)
    l(corner) = 0.25_wp*(1.0_wp + 3.0_wp*share)
  end function point_towards

  !> Signed volume; positive if nodes 1, 2, 3 run counter-clockwise seen from node 4.
  pure real(wp) function tetrahedron_volume(x) result(v)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)

    v = determinant(edges_of(x))/6.0_wp
  end function tetrahedron_volume

  !> Six-fold volume over the cube of the longest edge: does not depend on the unit of length.
  pure real(wp) function relative_volume(x) result(v)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    real(wp) :: l

    v = 0.0_wp
    l = longest_edge(x)
    if (l > 0.0_wp) v = determinant(edges_of(x)/l)
  end function relative_volume

  !> The corners of a tetrahedron of a cell.
  pure function piece_of(x, nodes, k, i) result(y)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! of the cell
    integer, intent(in) :: k !! its shape
    integer, intent(in) :: i !! which tetrahedron
    real(wp) :: y(3, 4)
    integer :: a

    do a = 1, 4
      y(:, a) = x(:, nodes(shapes(k)%piece(a, i)))
    end do
  end function piece_of

  !> From the first corner of a tetrahedron to the others.
  pure function edges_of(x) result(edges)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    real(wp) :: edges(3, 3)
    integer :: i

    do i = 1, 3
      edges(:, i) = x(:, i + 1) - x(:, 1)
    end do
  end function edges_of

  !> The longest way between two corners.
  pure real(wp) function longest_edge(x) result(l)
    real(wp), intent(in) :: x(:, :) !! (3, corners) [length]
    integer :: i, j

    l = 0.0_wp
    do j = 2, size(x, 2)
      do i = 1, j - 1
        l = max(l, norm2(x(:, j) - x(:, i)))
      end do
    end do
  end function longest_edge

  !> Longest edge over the shortest height of a tetrahedron, huge if it is flat.
  pure real(wp) function aspect_ratio(x) result(ratio)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    real(wp) :: l, y(3, 4)

    ratio = huge(1.0_wp)
    l = longest_edge(x)
    if (.not. l > 0.0_wp) return
    y = (x - spread(x(:, 1), 2, 4))/l
    if (abs(tetrahedron_volume(y)) > flat_limit) ratio = 1.0_wp/least_height(y)
  end function aspect_ratio

  !> Least height of a tetrahedron: three times its volume over its largest face.
  pure real(wp) function least_height(x) result(height)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    integer, parameter :: face(3, 4) = reshape([3, 1, 2, 4, 1, 2, 4, 1, 3, 4, 2, 3], [3, 4])
    integer :: i

    height = 3.0_wp*abs(tetrahedron_volume(x))/maxval([(norm2(facet_vector(x(:, face(:, i)))), &
      i=1, 4)])
  end function least_height

  !> Area vector of a triangle: its normal (right-handed about 1, 2, 3) times its area.
  pure function facet_vector(x) result(a)
    real(wp), intent(in) :: x(3, 3) !! corners [length] (direction, corner)
    real(wp) :: a(3), u(3), v(3)

    u = x(:, 2) - x(:, 1)
    v = x(:, 3) - x(:, 1)
    a = 0.5_wp*cross(u, v)
  end function facet_vector
end module cell_geometry

!> Geometry of tetrahedra and triangles.
module tetrahedra
  use kinds, only: wp
  implicit none
  private
  public :: tetrahedron_volume, relative_volume, longest_edge, aspect_ratio, facet_vector
  public :: point_towards, shares_of_points
  public :: flat_limit

  !> A tetrahedron whose six-fold volume is below this part of its cubed longest edge is flat.
  real(wp), parameter :: flat_limit = 1.0e-12_wp

contains

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

    v = determinant(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1), x(:, 4) - x(:, 1))/6.0_wp
  end function tetrahedron_volume

  !> Six-fold volume over the cube of the longest edge: does not depend on the unit of length.
  pure real(wp) function relative_volume(x) result(v)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    real(wp) :: l

    v = 0.0_wp
    l = longest_edge(x)
    if (l > 0.0_wp) v = determinant((x(:, 2) - x(:, 1))/l, (x(:, 3) - x(:, 1))/l, &
      (x(:, 4) - x(:, 1))/l)
  end function relative_volume

  !> Length of the longest edge.
  pure real(wp) function longest_edge(x) result(l)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    integer :: i, j

    l = 0.0_wp
    do j = 2, 4
      do i = 1, j - 1
        l = max(l, norm2(x(:, j) - x(:, i)))
      end do
    end do
  end function longest_edge

  !> Longest edge over the shortest height; sqrt(3/2) for a regular tetrahedron.
  pure real(wp) function aspect_ratio(x) result(ratio)
    real(wp), intent(in) :: x(3, 4) !! corners [length] (direction, corner)
    integer, parameter :: facet(3, 4) = reshape([1, 3, 2, 1, 2, 4, 2, 3, 4, 1, 4, 3], [3, 4])
    real(wp) :: largest, l, y(3, 4), v
    integer :: i

    ratio = huge(1.0_wp)
    l = longest_edge(x)
    if (.not. l > 0.0_wp) return
    y = (x - spread(x(:, 1), 2, 4))/l
    largest = 0.0_wp
    do i = 1, 4
      largest = max(largest, norm2(facet_vector(y(:, facet(:, i)))))
    end do
    v = abs(tetrahedron_volume(y))
    ! height = 3 v / area, longest edge = 1
    if (v > flat_limit) ratio = largest/(3.0_wp*v)
  end function aspect_ratio

  !> Area vector of a triangle: its normal (right-handed about 1, 2, 3) times its area.
  pure function facet_vector(x) result(a)
    real(wp), intent(in) :: x(3, 3) !! corners [length] (direction, corner)
    real(wp) :: a(3), u(3), v(3)

    u = x(:, 2) - x(:, 1)
    v = x(:, 3) - x(:, 1)
    a = 0.5_wp*[u(2)*v(3) - u(3)*v(2), u(3)*v(1) - u(1)*v(3), u(1)*v(2) - u(2)*v(1)]
  end function facet_vector

  !> Triple product a . (b x c).
  pure real(wp) function determinant(a, b, c) result(d)
    real(wp), intent(in) :: a(3) !! first vector
    real(wp), intent(in) :: b(3) !! second vector
    real(wp), intent(in) :: c(3) !! third vector

    d = a(1)*(b(2)*c(3) - b(3)*c(2)) + a(2)*(b(3)*c(1) - b(1)*c(3)) + &
      a(3)*(b(1)*c(2) - b(2)*c(1))
  end function determinant
end module tetrahedra

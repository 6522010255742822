!> Intersections of facets: the part of a slave facet that lies under a master facet, and quadrature
!! on it (doc/theory, "Segmentation", eq. (6.3)). All in the (xi, eta) of the slave facet.
module facet_clipping
  use kinds, only: wp
  implicit none
  private
  public :: clip_outline, polygon_area, polygon_points, most_corners, cell_points

  !> Corners of a polygon: six where two triangles meet, nine where one of them has six nodes, and
  !! room for what round-off or an outline that bends inwards may add.
  integer, parameter :: most_corners = 15
  !> Points of a cell.
  integer, parameter :: cell_points = 3
  !> A polygon with a smaller ratio of its second moments is taken for a line.
  real(wp), parameter :: least_moment_ratio = 1.0e-12_wp
  !> A corner is further away than another if it is by this share.
  real(wp), parameter :: clearly_further = 1.0e-6_wp
  !> Of corners that are equally far away, as all of a triangle and of a parallelogram are, the one
  !! is taken that lies furthest along this in the slave facet: round-off decides where a polygon
  !! begins. No two corners of simple cuts are equally far along an irrational direction.
  real(wp), parameter :: preferred(2) = [1.0_wp, sqrt(2.0_wp)]

contains

  !> The part of an outline within the unit triangle xi, eta, 1 - xi - eta >= 0: it is cut at one
  !! edge after the other. An outline that turns clockwise gives a polygon that does.
  pure subroutine clip_outline(outline, polygon, n)
    real(wp), intent(in) :: outline(:, :) !! (2, 3 or 6) its corners
    real(wp), intent(out) :: polygon(2, most_corners) !! corners of what is left
    integer, intent(out) :: n !! how many
    integer :: edge

    polygon = 0.0_wp
    n = size(outline, 2)
    polygon(:, 1:n) = outline
    do edge = 1, 3
      call cut(edge, polygon, n)
      if (n < 3) then
        n = 0
        return
      end if
    end do
  end subroutine clip_outline

  !> Keeps the part of a polygon on the inner side of one edge of the unit triangle.
  pure subroutine cut(edge, polygon, n)
    integer, intent(in) :: edge !! the edge that faces this corner
    real(wp), intent(inout) :: polygon(2, most_corners) !! the polygon
    integer, intent(inout) :: n !! its corners
    real(wp) :: from(2, most_corners), here, there
    integer :: i, k, next

    from = polygon
    k = 0
    do i = 1, n
      next = mod(i, n) + 1
      here = distance(edge, from(:, i))
      there = distance(edge, from(:, next))
      if (here >= 0.0_wp .and. k < most_corners) then
        k = k + 1
        polygon(:, k) = from(:, i)
      end if
      if (min(here, there) < 0.0_wp .and. max(here, there) > 0.0_wp .and. k < most_corners) then
        k = k + 1
        polygon(:, k) = from(:, i) + here/(here - there)*(from(:, next) - from(:, i))
      end if
    end do
    n = k
  end subroutine cut

  !> Shape function that is zero at an edge of the unit triangle, and positive inside.
  pure real(wp) function distance(edge, xi)
    integer, intent(in) :: edge !! the edge that faces this corner
    real(wp), intent(in) :: xi(2) !! a point

    select case (edge)
    case (1)
      distance = xi(1)
    case (2)
      distance = xi(2)
    case default
      distance = 1.0_wp - xi(1) - xi(2)
    end select
  end function distance

  !> Area of a polygon over that of the unit triangle, negative if it turns clockwise.
  pure real(wp) function polygon_area(polygon, n) result(area)
    real(wp), intent(in) :: polygon(:, :) !! (2, n) its corners
    integer, intent(in) :: n !! how many
    integer :: i

    area = 0.0_wp
    do i = 2, n - 1
      area = area + cross2(polygon(:, i) - polygon(:, 1), polygon(:, i + 1) - polygon(:, 1))
    end do
  end function polygon_area

  !> Three points of equal weight that integrate polynomials of degree 2 over a convex polygon
  !! exactly: on its inertia ellipse, which lies inside. One of them looks at the corner that is
  !! furthest from the centroid, seen in units of the ellipse.
  pure subroutine polygon_points(polygon, n, points)
    real(wp), intent(in) :: polygon(:, :) !! (2, n) its corners
    integer, intent(in) :: n !! how many, at least 3
    real(wp), intent(out) :: points(2, cell_points) !! the points
    real(wp) :: center(2), moment(2, 2), root(2, 2), ray(2)
    integer :: k
    real(wp), parameter :: half = 0.5_wp
    real(wp), parameter :: third_turn(2, 2) &
      = reshape([-half, sqrt(0.75_wp), -sqrt(0.75_wp), -half], &
      [2, 2])

    call moments(polygon, n, center, moment)
    call square_root(moment, root)
    ray = sqrt(2.0_wp)*direction(polygon, n, center, root)
    do k = 1, cell_points
      points(:, k) = center + matmul(root, ray)
      ray = matmul(third_turn, ray)
    end do
  end subroutine polygon_points

  !> Centroid of a polygon and its second moments about it, over its area.
  pure subroutine moments(polygon, n, center, moment)
    real(wp), intent(in) :: polygon(:, :) !! (2, n) its corners
    integer, intent(in) :: n !! how many
    real(wp), intent(out) :: center(2) !! centroid
    real(wp), intent(out) :: moment(2, 2) !! second moments
    real(wp) :: a(2), b(2), area, part, first(2)
    integer :: i

    area = 0.0_wp
    first = 0.0_wp
    moment = 0.0_wp
    do i = 2, n - 1
      a = polygon(:, i) - polygon(:, 1)
      b = polygon(:, i + 1) - polygon(:, 1)
      part = cross2(a, b)
      area = area + part
      first = first + part*(a + b)/3.0_wp
      moment = moment + part*(dyad2(a, a) + dyad2(b, b) + dyad2(a + b, a + b))/12.0_wp
    end do
    center = first/area
    moment = moment/area - dyad2(center, center)
    center = polygon(:, 1) + center
  end subroutine moments

  !> Root of a symmetric positive matrix; zero where it is none, for a figure that crosses itself.
  pure subroutine square_root(a, root)
    real(wp), intent(in) :: a(2, 2) !! the matrix
    real(wp), intent(out) :: root(2, 2) !! its root
    real(wp) :: s, trace

    s = sqrt(max(0.0_wp, a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)))
    trace = a(1, 1) + a(2, 2) + 2.0_wp*s
    root = 0.0_wp
    if (.not. trace > 0.0_wp) return
    root = a
    root(1, 1) = root(1, 1) + s
    root(2, 2) = root(2, 2) + s
    root = root/sqrt(trace)
  end subroutine square_root

  !> Unit vector to the corner that is furthest from the centroid, in units of the ellipse.
  pure function direction(polygon, n, center, root) result(ray)
    real(wp), intent(in) :: polygon(:, :) !! (2, n) corners
    integer, intent(in) :: n !! how many
    real(wp), intent(in) :: center(2) !! centroid
    real(wp), intent(in) :: root(2, 2) !! root of the second moments
    real(wp) :: ray(2), y(2, most_corners), det, far(most_corners)
    integer :: i

    ray = [1.0_wp, 0.0_wp]
    det = root(1, 1)*root(2, 2) - root(1, 2)*root(2, 1)
    if (det <= sqrt(least_moment_ratio)*(root(1, 1) + root(2, 2))**2) return
    do i = 1, n
      associate (c => polygon(:, i) - center)
        y(:, i) = [root(2, 2)*c(1) - root(1, 2)*c(2), root(1, 1)*c(2) - root(2, 1)*c(1)]
      end associate
      far(i) = norm2(y(:, i))
    end do
    i = maxloc(matmul(preferred, polygon(:, :n)), 1, &
      far(:n) >= (1.0_wp - clearly_further)*maxval(far(:n)))
    ray = y(:, i)/far(i)
  end function direction

  !> The cross product of plane vectors.
  pure real(wp) function cross2(a, b)
    real(wp), intent(in) :: a(2), b(2) !! plane vectors

    cross2 = a(1)*b(2) - a(2)*b(1)
  end function cross2

  !> The dyad of plane vectors.
  pure function dyad2(a, b) result(c)
    real(wp), intent(in) :: a(2), b(2) !! plane vectors
    real(wp) :: c(2, 2)

    c(:, 1) = a*b(1)
    c(:, 2) = a*b(2)
  end function dyad2
end module facet_clipping

!> What is left of a convex polygon without another one: cells of a slave facet that lie over each
!! other would press twice (doc/theory, "Segmentation"). All in the (xi, eta) of the slave facet.
module polygon_parts
  use kinds, only: wp
  use facet_clipping, only: polygon_area, most_corners
  implicit none
  private
  public :: lie_over, take_away, most_polygon_parts

  !> Parts below this share of the unit triangle are round-off of corners that were computed twice.
  real(wp), parameter :: least_part_area = 1.0e-10_wp
  !> Parts of a polygon that are kept; each polygon taken away leaves one at each of its edges.
  integer, parameter :: most_polygon_parts = 24

contains

  !> Two convex polygons share more than round-off.
  pure logical function lie_over(p, q) result(over)
    real(wp), intent(in) :: p(:, :) !! (2, corners) the one
    real(wp), intent(in) :: q(:, :) !! (2, corners) the other
    real(wp) :: part(2, most_corners)
    integer :: k, n

    over = .false.
    do k = 1, 2
      if (minval(p(k, :)) >= maxval(q(k, :)) .or. maxval(p(k, :)) <= minval(q(k, :))) return
    end do
    n = size(p, 2)
    part(:, :n) = p
    do k = 1, size(q, 2)
      call cut_at(q, k, .true., part, n)
      if (n < 3) return
    end do
    over = abs(polygon_area(part, n)) > least_part_area
  end function lie_over

  !> Takes a convex polygon away from the parts of another: behind each of its edges lies what the
  !! edges before have left inside.
  pure subroutine take_away(q, parts, sizes, n)
    real(wp), intent(in) :: q(:, :) !! (2, corners) what is taken away
    real(wp), intent(inout) :: parts(2, most_corners, most_polygon_parts) !! convex parts
    integer, intent(inout) :: sizes(most_polygon_parts) !! their corners
    integer, intent(inout) :: n !! how many
    real(wp) :: old(2, most_corners, most_polygon_parts), inside(2, most_corners), &
      beyond(2, most_corners)
    integer :: old_sizes(most_polygon_parts), i, k, m, corners, old_n

    old = parts
    old_sizes = sizes
    old_n = n
    n = 0
    do i = 1, old_n
      if (.not. lie_over(old(:, :old_sizes(i), i), q)) then
        call keep(old(:, :, i), old_sizes(i), parts, sizes, n)
        cycle
      end if
      inside = old(:, :, i)
      m = old_sizes(i)
      do k = 1, size(q, 2)
        beyond = inside
        corners = m
        call cut_at(q, k, .false., beyond, corners)
        if (corners >= 3) call keep(beyond, corners, parts, sizes, n)
        call cut_at(q, k, .true., inside, m)
        if (m < 3) exit
      end do
    end do
  end subroutine take_away

  !> Keeps a part that is more than round-off, while there is room.
  pure subroutine keep(part, corners, parts, sizes, n)
    real(wp), intent(in) :: part(2, most_corners) !! the part
    integer, intent(in) :: corners !! its corners
    real(wp), intent(inout) :: parts(2, most_corners, most_polygon_parts) !! gets it
    integer, intent(inout) :: sizes(most_polygon_parts) !! gets its corners
    integer, intent(inout) :: n !! grows

    if (n == most_polygon_parts .or. abs(polygon_area(part, corners)) <= least_part_area) return
    n = n + 1
    parts(:, :, n) = part
    sizes(n) = corners
  end subroutine keep

  !> Keeps the part of a polygon on one side of the edge of another, which may turn either way.
  pure subroutine cut_at(q, edge, inner, part, n)
    real(wp), intent(in) :: q(:, :) !! (2, corners) the other
    integer, intent(in) :: edge !! number of its edge
    logical, intent(in) :: inner !! the side on which it lies
    real(wp), intent(inout) :: part(2, most_corners) !! the polygon
    integer, intent(inout) :: n !! its corners
    real(wp) :: from(2, most_corners), side(most_corners), along(2), turn
    integer :: i, k, next

    along = q(:, 1 + mod(edge, size(q, 2))) - q(:, edge)
    turn = merge(1.0_wp, -1.0_wp, (polygon_area(q, size(q, 2)) > 0.0_wp) .eqv. inner)
    do i = 1, n
      side(i) = turn*(along(1)*(part(2, i) - q(2, edge)) - along(2)*(part(1, i) - q(1, edge)))
    end do
    from = part
    k = 0
    do i = 1, n
      next = mod(i, n) + 1
      if (side(i) >= 0.0_wp .and. k < most_corners) then
        k = k + 1
        part(:, k) = from(:, i)
      end if
      if (min(side(i), side(next)) < 0.0_wp .and. max(side(i), side(next)) > 0.0_wp .and. k < &
        most_corners) then
        k = k + 1
        part(:, k) = from(:, i) + side(i)/(side(i) - side(next))*(from(:, next) - from(:, i))
      end if
    end do
    n = k
  end subroutine cut_at
end module polygon_parts

!> What points of old cells hand on to those of new ones: elastic slip, multiplier, friction work
!! (doc/theory, "History on new cells", eq. (6.5)).
module cell_history
  use kinds, only: wp
  use contact_types, only: pair_t, contact_point_t, cell_t, status_open
  use contact_apexes, only: find_apex_from
  use convex_edges, only: pass_edge
  use facet_geometry, only: corners, project_on_facet, facet_frame, barycentric
  use master_facets, only: is_quadratic
  use slave_places, only: cell_position
  use smooth_normals, only: project_on_master, place_on_master
  use linear_fields, only: linear_field_t, fit_field, field_at, bounded_field_at
  implicit none
  private
  public :: fit_slip, fit_multipliers, place_apex, take_slip, multiplier_at

  !> Facets that a point may pass in an increment with its slip turned at each edge; further away
  !! the plane of its new facet serves.
  integer, parameter :: longest_path = 64

contains

  !> The elastic slip of the closed points of one slave facet, from apex to projection, as a field
  !! over it, in the frame of the facet; then come their slip path and their slip.
  pure subroutine fit_slip(pair, f, cells, points, x, field)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    type(cell_t), intent(in) :: cells(:) !! where its points are
    type(contact_point_t), intent(in) :: points(:) !! their last converged state
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    type(linear_field_t), intent(out) :: field !! the field
    real(wp) :: value(7, size(cells)), xi(2), gap, frame(3, 3)
    logical :: closed(size(cells))
    integer :: p

    frame = facet_frame(corners(x, pair%points%slave_facets(:, f)))
    closed = points%target > 0 .and. points%status > status_open
    do p = 1, size(cells)
      value(:, p) = 0.0_wp
      if (.not. closed(p)) cycle
      call project_on_master(pair, points(p)%target, x, cell_position(pair, cells(p), x), xi, gap)
      value(1:3, p) = matmul(way_between(pair, points(p)%target, x, points(p)%apex, xi), frame)
      value(4, p) = points(p)%path
      value(5:7, p) = matmul(points(p)%way, frame)
    end do
    call fit_closed(cells, closed, value, field)
  end subroutine fit_slip

  !> The way over a master facet from one of its places to another.
  pure function way_between(pair, target, x, from, to) result(way)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: from(2) !! (xi, eta)
    real(wp), intent(in) :: to(2) !! (xi, eta)
    real(wp) :: way(3), xi(2)

    if (is_quadratic(pair, target) .or. pair%smooth) then
      way = place_on_master(pair, target, x, to) - place_on_master(pair, target, x, from)
    else
      xi = to - from
      associate (nodes => pair%surface%facets(:, target))
        way = xi(1)*(x(:, nodes(1)) - x(:, nodes(3))) &
          + xi(2)*(x(:, nodes(2)) - x(:, nodes(3)))
      end associate
    end if
  end function way_between

  !> The multipliers of the points of one slave facet over their areas, as a field over it, in the
  !! frame of the facet.
  pure subroutine fit_multipliers(pair, f, cells, points, x, field)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    type(cell_t), intent(in) :: cells(:) !! where its points are
    type(contact_point_t), intent(in) :: points(:) !! their state
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    type(linear_field_t), intent(out) :: field !! the field
    real(wp) :: value(3, size(cells)), frame(3, 3)
    integer :: p

    frame = facet_frame(corners(x, pair%points%slave_facets(:, f)))
    do p = 1, size(cells)
      value(:, p) = 0.0_wp
      if (points(p)%target == 0) cycle
      value(:, p) = matmul(matmul(facet_frame(corners(x, pair%surface%facets(:, &
        points(p)%target))), points(p)%lambda/cells(p)%area), frame)
    end do
    call fit_closed(cells, points%target > 0, value, field)
  end subroutine fit_multipliers

  !> A field through the values of those points that count.
  pure subroutine fit_closed(cells, counts, value, field)
    type(cell_t), intent(in) :: cells(:) !! where the points are
    logical, intent(in) :: counts(:) !! (points) they count
    real(wp), intent(in) :: value(:, :) !! (values, points) their values
    type(linear_field_t), intent(out) :: field !! the field
    real(wp) :: xi(2, size(cells)), area(size(cells)), &
      counted(size(value, 1), size(cells))
    integer :: p, n

    n = 0
    do p = 1, size(cells)
      if (.not. counts(p)) cycle
      n = n + 1
      xi(:, n) = cells(p)%weight(1:2)
      area(n) = cells(p)%area
      counted(:, n) = value(:, p)
    end do
    call fit_field(xi(:, :n), area(:n), counted(:, :n), field)
  end subroutine fit_closed

  !> Multiplier of a new point in the frame of its target.
  pure function multiplier_at(pair, field, cell, target, x) result(lambda)
    type(pair_t), intent(in) :: pair !! the pair
    type(linear_field_t), intent(in) :: field !! multipliers over areas
    type(cell_t), intent(in) :: cell !! where the point is
    integer, intent(in) :: target !! its master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    real(wp) :: lambda(3)

    lambda = matmul(facet_frame(x(:, pair%points%slave_facets(:, cell%slave))), &
                    field_at(field, cell%weight(1:2)))
    lambda = cell%area*matmul(lambda, facet_frame(x(:, pair%surface%facets(:, target))))
  end function multiplier_at

  !> Slip path of a new point.
  pure real(wp) function path_at(field, cell) result(path)
    type(linear_field_t), intent(in) :: field !! elastic slip, slip path and slip
    type(cell_t), intent(in) :: cell !! where the point is
    real(wp) :: values(7)

    values = bounded_field_at(field, cell%weight(1:2), 0.0_wp)
    path = values(4)
  end function path_at

  !> Slip and slip path of a new point; the slip is never longer: slopes are carried on beyond the
  !! old points.
  pure subroutine take_slip(pair, field, cell, x, point)
    type(pair_t), intent(in) :: pair !! the pair
    type(linear_field_t), intent(in) :: field !! elastic slip, slip path and slip
    type(cell_t), intent(in) :: cell !! where the point is
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    type(contact_point_t), intent(inout) :: point !! gets path, way
    real(wp) :: values(7)

    values = bounded_field_at(field, cell%weight(1:2), 0.0_wp)
    point%path = values(4)
    point%way = matmul(facet_frame(corners(x, pair%points%slave_facets(:, cell%slave))), &
      values(5:7))
    if (norm2(point%way) > point%path) point%way = point%way*(point%path/norm2(point%way))
  end subroutine take_slip

  !> Start apex of a new point: its last converged projection less its elastic slip, as far as the
  !! law allows that there. If that lies on another facet than its target, it is turned about the
  !! edges in between.
  function place_apex(pair, field, cell, target, x) result(apex)
    type(pair_t), intent(in) :: pair !! the pair
    type(linear_field_t), intent(in) :: field !! elastic slip
    type(cell_t), intent(in) :: cell !! where the point is
    integer, intent(in) :: target !! its master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    real(wp) :: apex(2), slip(7), start(2)
    integer :: path(longest_path), n, k, status
    logical :: slips
    type(contact_point_t) :: point

    call find_path(pair, cell_position(pair, cell, x), target, x, path, n, apex)
    slip = bounded_field_at(field, cell%weight(1:2), 1.0_wp)
    slips = any(abs(slip(1:3)) > 0.0_wp)
    if (slips) apex = step_back(pair, path(n), x, apex, matmul(facet_frame(corners(x, &
      pair%points%slave_facets(:, cell%slave))), slip(1:3)))
    if (slips .and. .not. pair%augmented) then
      point%target = path(n)
      point%apex = apex
      point%path = path_at(field, cell)
      call find_apex_from(pair, 1, point, cell_position(pair, cell, x), x, apex, status)
    end if
    do k = n, 2, -1
      call pass_edge(pair, x, path(k), path(k - 1), apex, start)
      apex = start
    end do
  end function place_apex

  !> The place on a master facet from which a way leads to another one.
  pure function step_back(pair, facet, x, to, way) result(from)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: to(2) !! (xi, eta)
    real(wp), intent(in) :: way(3) !! the way [length]
    real(wp) :: from(2), gap, facet_corners(3, 3)

    if (is_quadratic(pair, facet) .or. pair%smooth) then
      call project_on_master(pair, facet, x, place_on_master(pair, facet, x, to) - way, from, gap)
    else
      facet_corners = corners(x, pair%surface%facets(:, facet))
      call project_on_facet(facet_corners, facet_corners(:, 3) + way, from, gap)
      from = to - from
    end if
  end function step_back

  !> The facets from a target to the one that a point projects on, across edges; the target alone if
  !! there is no such way.
  pure subroutine find_path(pair, y, target, x, path, n, xi)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(in) :: target !! where the path begins
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(out) :: path(longest_path) !! facets
    integer, intent(out) :: n !! how many
    real(wp), intent(out) :: xi(2) !! (xi, eta) of its projection on the last
    real(wp) :: gap
    integer :: corner, next

    path = target
    n = 1
    do
      call project_on_master(pair, path(n), x, y, xi, gap)
      if (all(barycentric(xi) >= 0.0_wp)) return
      corner = minloc(barycentric(xi), 1)
      next = pair%surface%neighbours(corner, path(n))
      if (n == longest_path .or. next == 0) exit
      if (pair%surface%concave(corner, path(n)) .or. any(path(:n) == next)) exit
      n = n + 1
      path(n) = next
    end do
    if (n < longest_path) return
    n = 1
    call project_on_master(pair, target, x, y, xi, gap)
  end subroutine find_path
end module cell_history

!> The cells of one slave facet: its intersections with the master facets (doc/theory,
!! "Segmentation"). In more than 400 lines, since what is cut, who has it and what is left belong
!! together.
module cell_cutting
  use kinds, only: wp
  use contact_types, only: pair_t, cell_t
  use facet_clipping, only: clip_outline, polygon_area, polygon_points, most_corners, cell_points
  use facet_geometry, only: project_points, facet_normal, plane_t, plane_of, &
    project_corners, corners_of => corners
  use contact_points, only: is_too_deep
  use contact_bodies, only: cell_through_body
  use contact_entries, only: master_way_t, measure_way, way_past, may_enter, has_entered, &
    was_held, held_reach
  use master_facets, only: is_quadratic, field_on_facet
  use slave_places, only: is_bent, place_of, project_into, share_of_area, slave_lift, &
    slave_positions
  use smooth_normals, only: project_on_master
  use facet_tree, only: facets_near
  use polygon_parts, only: lie_over, take_away, most_polygon_parts
  implicit none
  private
  public :: fresh_t, make_fresh, cut_facet, fit_in, slave_parts

  !> Parts of a slave facet of six nodes with multipliers at all of them.
  integer, parameter :: slave_parts = 4
  !> Cells below this share of their facet are dropped.
  real(wp), parameter :: least_area = 1.0e-14_wp
  !> Facets face each other if their normals have a smaller cosine.
  real(wp), parameter :: facing_cosine = -0.1_wp
  !> Of two master facets over each other the outer one holds the cell if it is farther out by this
  !! share of the search radius (the longest facet); else that of the lower number, as in the search
  !! (doc/theory, "Search tree"): where parts of a master meet, round-off must not choose.
  real(wp), parameter :: farther_out = 0.05_wp
  !> Most corners of the outline of a master facet: of six nodes, in turn.
  integer, parameter :: most_outline = 6

  !> The points of one slave facet while it is cut.
  type :: fresh_t
    integer :: n = 0 !! how many
    type(cell_t), allocatable :: cell(:) !! where they are
    integer, allocatable :: target(:) !! their master facets
    integer, allocatable :: near(:) !! master facets close to the facet
    type(master_way_t) :: way !! of the master since the last converged state
  end type fresh_t

  !> A part of a slave facet under one master facet.
  type :: piece_t
    integer :: target = 0 !! the master facet
    integer :: n = 0 !! corners of the polygon
    real(wp) :: polygon(2, most_corners) = 0.0_wp !! its corners
    real(wp) :: gap = 0.0_wp !! mean gap of its points [length]
  end type piece_t

  !> A slave facet, from where it looks at the master.
  type :: view_t
    integer :: f = 0 !! the slave facet
    real(wp) :: nodes(3, 6) = 0.0_wp !! where it is cut from, as in cut_facet [length]
    real(wp) :: before(3, 6) = 0.0_wp !! its nodes at the last converged state [length]
    type(plane_t) :: plane !! its plane
    real(wp) :: normal(3) = 0.0_wp !! its normal
  end type view_t

contains

  !> Room for the points of one slave facet, and how the master has moved.
  pure subroutine make_fresh(pair, x_old, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(out) :: fresh !! gets its arrays and way
    integer :: facets

    fresh%way = measure_way(pair, x_old, x)
    facets = size(pair%surface%facets, 2)
    allocate (fresh%near(facets), fresh%cell(cell_points*(facets + 1)), &
              fresh%target(cell_points*(facets + 1)))
  end subroutine make_fresh

  !> The points of one slave facet over the master at x.
  pure subroutine cut_facet(pair, f, nodes, x_old, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: nodes(3, 6) !! its corners, and the middles of its edges if it has
                                        !! them, or where the apexes put them [length]
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(inout) :: fresh !! gets n, cell, target
    type(view_t) :: view
    real(wp) :: center(3), reach, past, held
    type(piece_t), allocatable :: pieces(:)
    integer :: k, n, last, found

    view%f = f
    view%nodes = nodes
    view%before = slave_positions(pair, f, x_old)
    view%plane = plane_of(nodes(:, :3))
    view%normal = facet_normal(nodes(:, :3))
    center = sum(nodes(:, :3), 2)/3.0_wp
    last = merge(6, 3, is_bent(pair, f))
    reach = pair%search_radius + maxval(norm2(nodes(:, :last) - spread(center, 2, last), 1))
    past = maxval([(way_past(fresh%way, view%before(:, k), nodes(:, k)), k=1, last)])
    held = held_reach(pair, f, x_old, sum(view%before(:, :3), 2)/3.0_wp)
    if (may_enter(fresh%way, past) .or. held > reach) reach = max(reach, held) + past
    call facets_near(pair%surface%tree, center, reach, fresh%near, n)
    fresh%n = 0
    found = 0
    allocate (pieces(n))
    do k = 1, n
      call find_piece(pair, fresh%near(k), view, fresh%way, x_old, x, pieces(found + 1))
      if (pieces(found + 1)%n > 0) found = found + 1
    end do
    call add_pieces(pair, view, pieces(:found), x, fresh)
    if (fresh%n > 0) return
    fresh%n = 1
    fresh%target(1) = 0
    fresh%cell(1) = cell_t(slave=f)
  end subroutine cut_facet

  !> The part of a slave facet under one master facet, without corners if there is none.
  pure subroutine find_piece(pair, target, view, way, x_old, x, piece)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    type(view_t), intent(in) :: view !! of the slave facet
    type(master_way_t), intent(in) :: way !! of the master, from x_old to x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(piece_t), intent(inout) :: piece !! the part
    real(wp) :: outline(2, most_outline), points(2, cell_points)
    real(wp) :: place(2, cell_points), gaps(cell_points)
    integer :: k, n
    logical :: curved

    ! whichever costs less comes first
    piece%n = 0
    curved = is_bent(pair, view%f) .or. is_quadratic(pair, target)
    if (curved) curved = is_turned_away(pair, target, view%normal, x)
    if (curved) return
    call find_outline(pair, view%f, target, view%nodes, view%plane, x, outline, n)
    if (lies_beside(outline(:, :n))) return
    if (is_turned_away(pair, target, view%normal, x)) return
    call clip_outline(outline(:, :n), piece%polygon, n)
    if (n == 0) return
    if (abs(polygon_area(piece%polygon, n)) <= least_area) return
    call polygon_points(piece%polygon, n, points)
    call place_on_target(pair, target, x, places_in(pair, view%f, view%nodes, points), place, gaps)
    if (all(gaps > pair%search_radius .or. [(is_too_deep(pair, target, gaps(k)), k=1, &
      cell_points)])) then
      if (.not. is_below(pair, target, view, way, x_old, x, points)) return
    else if (cell_through_body(pair, x, view%f, target, gaps)) then
      if (.not. is_below(pair, target, view, way, x_old, x, points)) return
    end if
    piece%n = n
    piece%target = target
    piece%gap = sum(gaps)/real(cell_points, wp)
  end subroutine find_piece

  !> Adds the points of the parts of a slave facet. Where facets of the master that do not touch
  !! each other lie over each other, as its parts may at their seam, one of them has the cell.
  pure subroutine add_pieces(pair, view, pieces, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair
    type(view_t), intent(in) :: view !! of the slave facet
    type(piece_t), intent(in) :: pieces(:) !! its parts, one a master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(inout) :: fresh !! gets points
    real(wp) :: parts(2, most_corners, most_polygon_parts)
    integer :: sizes(most_polygon_parts), i, k, n

    do i = 1, size(pieces)
      n = 1
      parts(:, :, 1) = pieces(i)%polygon
      sizes(1) = pieces(i)%n
      do k = 1, size(pieces)
        if (k == i .or. n == 0) cycle
        if (.not. goes_before(pair, pieces(k), pieces(i))) cycle
        if (.not. lie_over(pieces(i)%polygon(:, :pieces(i)%n), pieces(k)%polygon(:, &
          :pieces(k)%n))) cycle
        if (are_adjacent(pair, pieces(i)%target, pieces(k)%target)) cycle
        call take_away(pieces(k)%polygon(:, :pieces(k)%n), parts, sizes, n)
      end do
      do k = 1, n
        call add_cell(pair, view, pieces(i)%target, parts(:, :, k), sizes(k), x, fresh)
      end do
    end do
  end subroutine add_pieces

  !> Which of two parts over each other has the cell; an order of all parts, so that what is taken
  !! from one is another's.
  pure logical function goes_before(pair, a, b) result(before)
    type(pair_t), intent(in) :: pair !! the pair
    type(piece_t), intent(in) :: a !! the one
    type(piece_t), intent(in) :: b !! the other
    real(wp) :: step
    integer :: level(2)

    step = farther_out*pair%search_radius
    level = nint([a%gap, b%gap]/step)
    before = level(1) < level(2) .or. (level(1) == level(2) .and. a%target < b%target)
  end function goes_before

  !> Two master facets share a node: they have the same side outside, and cover no place twice.
  pure logical function are_adjacent(pair, a, b) result(adjacent)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: a !! the one
    integer, intent(in) :: b !! the other
    integer :: k

    adjacent = any([(any(pair%surface%facets(:, a) == pair%surface%facets(k, b)), k=1, 3)])
  end function are_adjacent

  !> Adds the points of a cell, of each part of a slave facet that has some.
  pure subroutine add_cell(pair, view, target, polygon, n, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair
    type(view_t), intent(in) :: view !! of the slave facet
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: polygon(2, most_corners) !! the part of the slave facet
    integer, intent(in) :: n !! its corners
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(inout) :: fresh !! gets points
    real(wp) :: points(2, cell_points), inside(2, most_corners), area
    integer :: part, parts, corners

    parts = count_parts(pair, view%f)
    if (parts == 1) then
      call polygon_points(polygon, n, points)
      call add_points(pair, view, target, points, abs(polygon_area(polygon, n)), x, fresh)
      return
    end if
    do part = 1, parts
      call clip_outline(into_part(part, polygon(:, :n)), inside, corners)
      if (corners == 0) cycle
      area = abs(polygon_area(inside, corners))/real(parts, wp)
      if (area <= least_area) cycle
      call polygon_points(inside, corners, points)
      call add_points(pair, view, target, out_of_part(part, points), area, x, fresh)
    end do
  end subroutine add_cell

  !> Adds the points of a polygon.
  pure subroutine add_points(pair, view, target, points, area, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair
    type(view_t), intent(in) :: view !! of the slave facet
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: points(2, cell_points) !! (xi, eta) in the slave facet
    real(wp), intent(in) :: area !! of the polygon, over that of the unit triangle times two
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(inout) :: fresh !! gets points
    real(wp) :: place(2, cell_points), gaps(cell_points)
    integer :: k

    if (fresh%n + cell_points > size(fresh%cell)) call double_room(fresh)
    call place_on_target(pair, target, x, places_in(pair, view%f, view%nodes, points), place, gaps)
    do k = 1, cell_points
      associate (p => fresh%n + k)
        fresh%target(p) = target
        fresh%cell(p)%slave = view%f
        fresh%cell(p)%weight = [points(1, k), points(2, k), 1.0_wp - points(1, k) - points(2, k)]
        fresh%cell(p)%area = area*share_of_area(pair, view%f, points(:, k))/real(cell_points, wp)
        fresh%cell(p)%place = place(:, k)
      end associate
    end do
    fresh%n = fresh%n + cell_points
  end subroutine add_points

  !> Parts that a slave facet is cut in: multipliers at six nodes have hat functions on four.
  pure integer function count_parts(pair, f) result(parts)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet

    parts = 1
    if (pair%mortar .and. is_bent(pair, f)) parts = slave_parts
  end function count_parts

  !> Places of a slave facet in the (xi, eta) of one of its parts: those of mortar_functions.
  pure function into_part(part, places) result(inside)
    integer, intent(in) :: part !! 1 to slave_parts
    real(wp), intent(in) :: places(:, :) !! (2, places)
    real(wp) :: inside(2, size(places, 2))

    inside = 2.0_wp*places
    if (part < slave_parts .and. part < 3) inside(part, :) = inside(part, :) - 1.0_wp
    if (part < slave_parts) return
    inside(1, :) = 2.0_wp*(places(1, :) + places(2, :)) - 1.0_wp
    inside(2, :) = 1.0_wp - 2.0_wp*places(1, :)
  end function into_part

  !> And back.
  pure function out_of_part(part, inside) result(places)
    integer, intent(in) :: part !! 1 to slave_parts
    real(wp), intent(in) :: inside(:, :) !! (2, places)
    real(wp) :: places(2, size(inside, 2))

    places = 0.5_wp*inside
    if (part < 3) places(part, :) = places(part, :) + 0.5_wp
    if (part < slave_parts) return
    places(1, :) = 0.5_wp*(1.0_wp - inside(2, :))
    places(2, :) = 0.5_wp*(inside(1, :) + inside(2, :))
  end function out_of_part

  !> Twice the room for points.
  pure subroutine double_room(fresh)
    type(fresh_t), intent(inout) :: fresh !! its cell and target grow
    type(cell_t), allocatable :: cell(:)
    integer, allocatable :: target(:)

    allocate (cell(2*size(fresh%cell) + cell_points), target(2*size(fresh%cell) + cell_points))
    cell(:fresh%n) = fresh%cell(:fresh%n)
    target(:fresh%n) = fresh%target(:fresh%n)
    call move_alloc(cell, fresh%cell)
    call move_alloc(target, fresh%target)
  end subroutine double_room

  !> Where places of a slave facet are.
  pure function places_in(pair, f, nodes, points) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: nodes(3, 6) !! its nodes [length]
    real(wp), intent(in) :: points(2, cell_points) !! (xi, eta)
    real(wp) :: y(3, cell_points), normal(3)
    integer :: k

    normal = facet_normal(nodes(:, :3))
    do k = 1, cell_points
      y(:, k) = place_of(nodes, is_bent(pair, f), points(:, k)) + slave_lift(pair, f, points(:, &
        k))*normal
    end do
  end function places_in

  !> What is too deep below a master facet, or too far above it, is below it all the same: one of
  !! the points was in contact there, or has gone through the surface since.
  pure logical function is_below(pair, target, view, way, x_old, x, points) result(below)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    type(view_t), intent(in) :: view !! of the slave facet
    type(master_way_t), intent(in) :: way !! of the master, from x_old to x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: points(2, cell_points) !! (xi, eta) in the slave facet
    real(wp) :: y(3, cell_points), y_old(3, cell_points), place(2, cell_points), gaps(cell_points)
    integer :: k

    below = .false.
    y = places_in(pair, view%f, view%nodes, points)
    call place_on_target(pair, target, x, y, place, gaps)
    if (all(gaps > 0.0_wp)) return
    below = was_held(pair, view%f, target)
    if (below) return
    y_old = places_in(pair, view%f, view%before, points)
    do k = 1, cell_points
      if (gaps(k) > 0.0_wp) cycle
      below = has_entered(pair, way, target, x_old, x, y_old(:, k), y(:, k))
      if (below) return
    end do
  end function is_below

  !> A master facet does not face a slave facet.
  pure logical function is_turned_away(pair, target, normal, x) result(away)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: normal(3) !! of the slave facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]

    away = dot_product(normal, facet_normal(corners_of(x, pair%surface%facets(:, target)))) &
      > facing_cosine
  end function is_turned_away

  !> An outline lies behind one edge of the unit triangle.
  pure logical function lies_beside(outline) result(beside)
    real(wp), intent(in) :: outline(:, :) !! (2, corners)
    logical :: behind(3)
    integer :: k

    behind = .true.
    do k = 1, size(outline, 2)
      associate (xi => outline(:, k))
        if (xi(1) >= 0.0_wp) behind(1) = .false.
        if (xi(2) >= 0.0_wp) behind(2) = .false.
        if (1.0_wp - xi(1) - xi(2) >= 0.0_wp) behind(3) = .false.
      end associate
    end do
    beside = any(behind)
  end function lies_beside

  !> The outline of a master facet in the (xi, eta) of a slave facet, seen along its normal: the
  !! corners, and if one of the two facets is curved the middles of the edges between them.
  !! Neighbours share the outline of an edge, so that nothing is covered twice.
  pure subroutine find_outline(pair, f, target, slave, plane, x, outline, n)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: slave(3, 6) !! nodes of the slave facet [length]
    type(plane_t), intent(in) :: plane !! its plane
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(out) :: outline(2, most_outline) !! corners of the outline
    integer, intent(out) :: n !! how many
    real(wp) :: y(3, most_outline), gaps(most_outline)

    if (is_bent(pair, f) .or. is_quadratic(pair, target)) then
      n = most_outline
      y = outline_of(pair, target, x)
    else
      n = 3
      outline(:, :3) = project_corners(plane, corners_of(x, pair%surface%facets(:, target)))
      return
    end if
    if (is_bent(pair, f)) then
      call project_into(slave, n, y(:, :n), outline(:, :n))
    else
      call project_points(slave(:, :3), n, y(:, :n), outline(:, :n), gaps(:n))
    end if
  end subroutine find_outline

  !> Corners of a master facet and the middles of its edges, in turn.
  pure function outline_of(pair, target, x) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: y(3, most_outline)
    integer :: k
    real(wp), parameter :: half = 0.5_wp, none = 0.0_wp
    real(wp), parameter :: middles(2, 3) = reshape([half, half, none, half, half, none], [2, 3])

    y(:, 1::2) = corners_of(x, pair%surface%facets(:, target))
    if (is_quadratic(pair, target) .and. .not. pair%surface%round) then
      y(:, 2::2) = corners_of(x, pair%surface%middles(:, target))
      return
    end if
    do k = 1, 3
      y(:, 2*k) = field_on_facet(pair, target, x, x, middles(:, k))
    end do
  end function outline_of

  !> The projections of points on a master facet, and their distances.
  pure subroutine place_on_target(pair, target, x, y, place, gaps)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the master facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3, cell_points) !! the points [length]
    real(wp), intent(out) :: place(2, cell_points) !! (xi, eta)
    real(wp), intent(out) :: gaps(cell_points) !! positive outside [length]
    integer :: k

    if (is_quadratic(pair, target) .or. pair%smooth) then
      do k = 1, cell_points
        call project_on_master(pair, target, x, y(:, k), place(:, k), gaps(k))
      end do
    else
      call project_points(corners_of(x, pair%surface%facets(:, target)), cell_points, y, place, &
        gaps)
    end if
  end subroutine place_on_target

  !> Fewer points where there is no room for all of them: a third of the cells' areas and targets
  !! are kept by one point in place of three, and if that is too many as well the largest cells
  !! share the area of all.
  pure subroutine fit_in(room, fresh)
    integer, intent(in) :: room !! places left for this facet
    type(fresh_t), intent(inout) :: fresh !! n and cells may shrink
    integer :: k, p

    if (fresh%n <= room) return
    do k = 1, fresh%n/cell_points
      p = cell_points*(k - 1) + 1
      fresh%target(k) = fresh%target(p)
      fresh%cell(k) = fresh%cell(p)
      fresh%cell(k)%weight = (fresh%cell(p)%weight + fresh%cell(p + 1)%weight &
        + fresh%cell(p + 2)%weight)/real(cell_points, wp)
      fresh%cell(k)%place = (fresh%cell(p)%place + fresh%cell(p + 1)%place &
        + fresh%cell(p + 2)%place)/real(cell_points, wp)
      fresh%cell(k)%area = sum(fresh%cell(p:p + cell_points - 1)%area)
    end do
    fresh%n = fresh%n/cell_points
    if (fresh%n <= room) return
    fresh%cell(:room)%area = fresh%cell(:room)%area*sum(fresh%cell(:fresh%n)%area) &
      /sum(fresh%cell(:room)%area)
    fresh%n = room
  end subroutine fit_in
end module cell_cutting

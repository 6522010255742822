!> Segmentation: the points of a pair on the intersections of its slave and master facets
!! (doc/theory, "Segmentation").
!!
!! The points of a slave facet stand together, in the order of the facets; a facet without a master
!! under it keeps one point that is off. Places behind the last point are idle.
module contact_cells
  use kinds, only: wp
  use element_types, only: status_off, status_open, status_stick
  use contact_types, only: pair_t, contact_point_t, cell_t
  use contact_points, only: count_points
  use facet_clipping, only: clip_triangle, polygon_area, polygon_points, most_corners, cell_points
  use facet_geometry, only: project_on_facet, facet_normal, facet_size
  use cell_room, only: most_cells
  use facet_tree, only: build_tree, fit_tree, facets_near
  use cell_history, only: fit_slip, fit_multipliers, place_tip, multiplier_at
  use cell_motion, only: carry_tips, find_tips, have_stayed, lag_corners
  use linear_fields, only: linear_field_t
  implicit none
  private
  public :: prepare_cells, clear_cells, begin_cells, follow_cells, settle_cells

  !> Cells below this share of their facet are dropped.
  real(wp), parameter :: least_area = 1.0e-14_wp
  !> Facets face each other if their normals have a smaller cosine.
  real(wp), parameter :: facing = -0.1_wp
  !> The cells of a facet stay while the tips have moved by less than this on the master since they
  !! were made, in shape functions, and while the facet is covered to this share.
  real(wp), parameter :: unmoved = 1.0e-3_wp
  !> The same after a solve in which all of its closed points slip: they were expected to.
  real(wp), parameter :: slipped = 0.05_wp
  !> How often a facet is cut anew within an increment.
  integer, parameter :: most_moves = 4
  !> Room over the number of points at the start, and over the bound for any position.
  real(wp), parameter :: reserve = 1.6_wp
  real(wp), parameter :: spare = 1.3_wp

  !> The points of one slave facet while it is cut.
  type :: fresh_t
    integer :: n = 0 !! how many
    type(cell_t), allocatable :: cell(:) !! where they are
    integer, allocatable :: host(:) !! their master facets
    integer, allocatable :: near(:) !! master facets close to the facet
  end type fresh_t

contains

  !> Room for the points of a pair with three fixed points in each slave facet, whose penalty gives
  !! the density.
  subroutine prepare_cells(x, pair)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(pair_t), intent(inout) :: pair !! points given; gets cells, density, room for points
    integer :: f, points

    points = pair%facet_points
    pair%slave_area = [(sum(pair%area(points*(f - 1) + 1:points*f)), &
                        f=1, size(pair%slave_facets, 2))]
    if (allocated(pair%epsilon)) then
      if (size(pair%epsilon) > 0) pair%density = pair%epsilon(1)/pair%area(1)
    end if
    points = max(nint(reserve*real(points_at(pair, x), wp)), 6*size(pair%slave_facets, 2), &
      nint(spare*real(cell_points*most_cells(pair%slave_facets, pair%facets, x), wp)))
    deallocate (pair%point_nodes, pair%point_weights, pair%area)
    allocate (pair%cells(points), pair%old_cells(points))
    allocate (pair%point_nodes(3, points), pair%point_weights(3, points), pair%area(points))
    if (allocated(pair%epsilon)) deallocate (pair%epsilon)
    allocate (pair%epsilon(points), source=0.0_wp)
    do f = 1, size(pair%slave_facets, 2)
      pair%cells(f)%slave = f
    end do
    call show_cells(pair)
  end subroutine prepare_cells

  !> Number of points at the start.
  integer function points_at(pair, x) result(n)
    type(pair_t), intent(in) :: pair !! slave facets, areas, master facets
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(pair_t) :: trial
    type(fresh_t) :: fresh
    integer :: f

    n = 0
    trial%facets = pair%facets
    trial%slave_facets = pair%slave_facets
    trial%slave_area = pair%slave_area
    trial%search_radius = pair%search_radius
    if (trial%search_radius <= 0.0_wp) trial%search_radius = maxval([(facet_size(x(:, &
      pair%facets(:, f))), f=1, size(pair%facets, 2))])
    call build_tree(trial%tree, trial%facets, x)
    call make_fresh(size(pair%facets, 2), fresh)
    do f = 1, size(pair%slave_facets, 2)
      call cut_facet(trial, f, x(:, trial%slave_facets(:, f)), x, fresh)
      n = n + fresh%n
    end do
  end function points_at

  !> Room for the points of one slave facet.
  pure subroutine make_fresh(facets, fresh)
    integer, intent(in) :: facets !! number of master facets
    type(fresh_t), intent(out) :: fresh !! gets its arrays

    allocate (fresh%near(facets), fresh%cell(cell_points*(facets + 1)), &
              fresh%host(cell_points*(facets + 1)))
  end subroutine make_fresh

  !> Forgets all cells: each facet is cut anew.
  pure subroutine clear_cells(pair)
    type(pair_t), intent(inout) :: pair !! gets cell, old_cell, new, old

    pair%cells = cell_t()
    pair%old_cells = cell_t()
    pair%new = contact_point_t()
    pair%old = contact_point_t()
  end subroutine clear_cells

  !> Nodes, weights, areas and penalties of the present cells.
  pure subroutine show_cells(pair)
    type(pair_t), intent(inout) :: pair !! cell given
    integer :: p

    do p = 1, size(pair%cells)
      associate (cell => pair%cells(p))
        pair%point_nodes(:, p) = pair%slave_facets(:, max(1, cell%slave))
        pair%point_weights(:, p) = cell%weight
        pair%area(p) = cell%area
        pair%epsilon(p) = pair%density*cell%area
      end associate
    end do
  end subroutine show_cells

  !> Cells and points of the last converged state.
  pure subroutine begin_cells(pair)
    type(pair_t), intent(inout) :: pair !! old and old_cell become new and cell

    pair%new = pair%old
    pair%cells = pair%old_cells
    call show_cells(pair)
  end subroutine begin_cells

  !> Cuts those facets anew whose tips have moved over the master, or whose cover has changed. New
  !! points get their history from the old ones of their facet.
  subroutine follow_cells(pair, x_old, x, tolerance, changes)
    type(pair_t), intent(inout) :: pair !! cells and working points may change
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: tolerance !! 0 at the start of an increment, else after a solve
    integer, intent(inout) :: changes !! grows by the points of facets that are cut anew
    type(cell_t), allocatable :: cells(:)
    type(contact_point_t), allocatable :: points(:), moved(:)
    type(fresh_t) :: fresh
    integer :: f, n, first, last, room
    logical :: stays, at_start

    if (count_points(pair) == 0) return
    call fit_tree(pair%tree, pair%facets, x)
    cells = pair%cells
    points = pair%new
    at_start = tolerance <= 0.0_wp
    if (at_start) then
      call carry_tips(pair, cells, points, x_old, x, moved)
    else
      call find_tips(pair, points, x, moved)
    end if
    call make_fresh(size(pair%facets, 2), fresh)
    n = 0
    first = 1
    do f = 1, size(pair%slave_facets, 2)
      last = last_of(cells, first, f)
      call cut_facet(pair, f, lag_corners(pair, f, cells(first:last), moved(first:last), x), &
        x, fresh)
      stays = have_stayed(pair, f, cells(first:last), moved(first:last), x, &
                          fresh%cell(:fresh%n), fresh%host(:fresh%n), &
                          merge(unmoved, slipped, at_start .or. any(moved(first:last)%status &
                                                                    == status_stick)))
      if (.not. at_start .and. pair%moves(f) >= most_moves) stays = .true.
      room = count_points(pair) - n - (size(pair%slave_facets, 2) - f)
      stays = stays .and. last - first < room
      if (stays) then
        fresh%n = last - first + 1
        pair%cells(n + 1:n + fresh%n) = cells(first:last)
        pair%new(n + 1:n + fresh%n) = points(first:last)
      else
        if (fresh%n > room) pair%crowded = .true.
        call fit_in(room, fresh)
        pair%cells(n + 1:n + fresh%n) = fresh%cell(:fresh%n)
        call hand_on(pair, f, cells(first:last), points(first:last), fresh, x_old, n)
        if (.not. at_start) pair%moves(f) = pair%moves(f) + 1
        changes = changes + fresh%n
      end if
      n = n + fresh%n
      first = last + 1
    end do
    pair%cells(n + 1:) = cell_t()
    pair%new(n + 1:) = contact_point_t()
    call show_cells(pair)
  end subroutine follow_cells

  !> Last point of a facet whose first point would be `first`; one less if it has none.
  pure integer function last_of(cells, first, f) result(last)
    type(cell_t), intent(in) :: cells(:) !! all points
    integer, intent(in) :: first !! the first one that may belong to the facet
    integer, intent(in) :: f !! the facet

    last = first - 1
    do while (last < size(cells))
      if (cells(last + 1)%slave /= f) return
      last = last + 1
    end do
  end function last_of

  !> The points of one slave facet over the master at x.
  pure subroutine cut_facet(pair, f, corners, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: corners(3, 3) !! its corners, or where the tips put them [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(inout) :: fresh !! gets n, cell, host
    real(wp) :: center(3), reach
    integer :: k, n

    center = sum(corners, 2)/3.0_wp
    reach = pair%search_radius + maxval(norm2(corners - spread(center, 2, 3), 1))
    call facets_near(pair%tree, center, reach, fresh%near, n)
    fresh%n = 0
    do k = 1, n
      call add_cell(pair, f, fresh%near(k), corners, x(:, pair%facets(:, fresh%near(k))), fresh)
    end do
    if (fresh%n > 0) return
    fresh%n = 1
    fresh%host(1) = 0
    fresh%cell(1) = cell_t(slave=f)
  end subroutine cut_facet

  !> Adds the points of the part of a slave facet under one master facet, if there is one.
  pure subroutine add_cell(pair, f, host, slave, master, fresh)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer, intent(in) :: host !! the master facet
    real(wp), intent(in) :: slave(3, 3) !! corners of the slave facet [length]
    real(wp), intent(in) :: master(3, 3) !! corners of the master facet [length]
    type(fresh_t), intent(inout) :: fresh !! gets points
    real(wp) :: triangle(2, 3), polygon(2, most_corners), points(2, cell_points), area, gap
    real(wp) :: place(2, cell_points), gaps(cell_points), y(3)
    integer :: k, n

    if (dot_product(facet_normal(slave), facet_normal(master)) > facing) return
    do k = 1, 3
      call project_on_facet(slave, master(:, k), triangle(:, k), gap)
    end do
    call clip_triangle(triangle, polygon, n)
    if (n == 0) return
    area = abs(polygon_area(polygon, n))
    if (area <= least_area) return
    call polygon_points(polygon, n, points)
    do k = 1, cell_points
      y = slave(:, 3) + points(1, k)*(slave(:, 1) - slave(:, 3)) &
        + points(2, k)*(slave(:, 2) - slave(:, 3))
      call project_on_facet(master, y, place(:, k), gaps(k))
    end do
    if (all(abs(gaps) > pair%search_radius)) return
    do k = 1, cell_points
      associate (p => fresh%n + k)
        fresh%host(p) = host
        fresh%cell(p)%slave = f
        fresh%cell(p)%weight = [points(1, k), points(2, k), 1.0_wp - points(1, k) - points(2, k)]
        fresh%cell(p)%area = area*pair%slave_area(f)/real(cell_points, wp)
        fresh%cell(p)%place = place(:, k)
      end associate
    end do
    fresh%n = fresh%n + cell_points
  end subroutine add_cell

  !> Fewer points where there is no room for all of them: a third of the cells' areas and hosts are
  !! kept by one point in place of three, and if that is too many as well the largest cells share
  !! the area of all.
  pure subroutine fit_in(room, fresh)
    integer, intent(in) :: room !! places left for this facet
    type(fresh_t), intent(inout) :: fresh !! n and cells may shrink
    integer :: k, p

    if (fresh%n <= room) return
    do k = 1, fresh%n/cell_points
      p = cell_points*(k - 1) + 1
      fresh%host(k) = fresh%host(p)
      fresh%cell(k) = fresh%cell(p)
      fresh%cell(k)%weight = (fresh%cell(p)%weight + fresh%cell(p + 1)%weight &
        + fresh%cell(p + 2)%weight)/real(cell_points, wp)
      fresh%cell(k)%place = (fresh%cell(p)%place + fresh%cell(p + 1)%place &
        + fresh%cell(p + 2)%place)/real(cell_points, wp)
      fresh%cell(k)%area = real(cell_points, wp)*fresh%cell(p)%area
    end do
    fresh%n = fresh%n/cell_points
    if (fresh%n <= room) return
    fresh%cell(:room)%area = fresh%cell(:room)%area*sum(fresh%cell(:fresh%n)%area) &
      /sum(fresh%cell(:room)%area)
    fresh%n = room
  end subroutine fit_in

  !> History of the new points of a facet.
  pure subroutine hand_on(pair, f, cells, points, fresh, x_old, n)
    type(pair_t), intent(inout) :: pair !! gets working points n + 1 and on
    integer, intent(in) :: f !! the slave facet
    type(cell_t), intent(in) :: cells(:) !! its points before
    type(contact_point_t), intent(in) :: points(:) !! their working state
    type(fresh_t), intent(in) :: fresh !! its new points
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    integer, intent(in) :: n !! points of the facets before
    type(linear_field_t) :: slip, multiplier
    integer :: first, last, p
    real(wp) :: area

    first = findloc(pair%old_cells%slave, f, 1)
    if (first == 0) first = 1
    last = last_of(pair%old_cells, first, f)
    call fit_slip(pair, f, pair%old_cells(first:last), pair%old(first:last), x_old, slip)
    if (pair%augmented) call fit_multipliers(pair, f, cells, points, x_old, multiplier)
    area = sum(fresh%cell(:fresh%n)%area)
    do p = 1, fresh%n
      associate (point => pair%new(n + p), cell => fresh%cell(p), host => fresh%host(p))
        point = contact_point_t()
        point%dissipation = sum(points%dissipation)
        if (area > 0.0_wp) point%dissipation = point%dissipation*cell%area/area
        if (host == 0) cycle
        point%host = host
        point%status = status_open
        point%tip = place_tip(pair, slip, cell, host, x_old)
        if (pair%augmented) point%lambda = multiplier_at(pair, multiplier, cell, host, x_old)
      end associate
    end do
  end subroutine hand_on

  !> Makes the converged state the history; an open point's tip lies at its projection.
  pure subroutine settle_cells(pair, x)
    type(pair_t), intent(inout) :: pair !! new and cell are completed and become old and old_cell
    real(wp), intent(in) :: x(:, :) !! (3, nodes) converged positions [length]
    integer :: p
    real(wp) :: gap, y(3)

    do p = 1, size(pair%new)
      associate (point => pair%new(p))
        if (point%host == 0) point%status = status_off
        if (point%host == 0) point%lambda = 0.0_wp
        if (point%status > status_open .or. point%host == 0) cycle
        y = matmul(x(:, pair%point_nodes(:, p)), pair%point_weights(:, p))
        call project_on_facet(x(:, pair%facets(:, point%host)), y, point%tip, gap)
      end associate
    end do
    pair%old = pair%new
    pair%old_cells = pair%cells
  end subroutine settle_cells
end module contact_cells

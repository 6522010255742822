!> Segmentation: the points of a pair on the intersections of its slave and master facets
!! (doc/theory, "Segmentation").
!!
!! The points of a slave facet stand together, in the order of the facets; a facet without a master
!! under it keeps one point that is off. Places behind the last point are idle.
!! In more than 400 lines, since what is cut, kept and handed on is one list of points.
module contact_cells
  use kinds, only: wp
  use element_types, only: status_off, status_open, status_stick, status_slip
  use contact_types, only: pair_t, contact_point_t, cell_t
  use contact_points, only: count_points, first_cell, longest_facet
  use facet_clipping, only: cell_points
  use facet_geometry, only: corners, facet_normal, barycentric
  use cell_cutting, only: fresh_t, make_fresh, cut_facet, fit_in, slave_parts
  use cell_room, only: most_cells
  use facet_tree, only: build_tree, fit_tree
  use cell_history, only: fit_slip, fit_multipliers, place_apex, take_slip, multiplier_at
  use cell_motion, only: carry_apexes, find_apexes, have_stayed, lie_still, lag_nodes
  use contact_apexes, only: open_if_touching
  use linear_fields, only: linear_field_t
  use master_facets, only: is_plane
  use slave_places, only: slave_nodes, slave_positions, slave_weights, cell_position
  use smooth_normals, only: project_on_master
  implicit none
  private
  public :: prepare_cells, clear_cells, begin_cells, follow_cells, cut_touched, settle_cells, &
    forget_first_cells

  !> The cells of a facet stay while the apexes have moved by less than this on the master since
  !! they were made, in shape functions, and while the facet is covered to this share.
  real(wp), parameter :: unmoved = 1.0e-3_wp
  !> The same for points that slip where none sticks and all facets below are in one plane: which
  !! of them holds an apex changes neither its gap nor its normal.
  real(wp), parameter :: followed = 1.0e-2_wp
  !> Facets are in one plane if the cosines of their normals are within this of 1.
  real(wp), parameter :: one_plane = 1.0e-12_wp
  !> The same for points that slip, after a solve or beside points that stick: they were expected
  !! to, and what is handed on where both are in a facet is not what it was.
  real(wp), parameter :: slipped = 0.05_wp
  !> Cover of a facet that carries something, after a solve without friction: a boundary's force.
  real(wp), parameter :: covered = 1.0e-4_wp
  !> The same where points have just touched: there is nothing yet to be kept.
  real(wp), parameter :: exactly = 1.0e-9_wp
  !> What points of multipliers at nodes may have moved by over the master while their cells stay.
  real(wp), parameter :: at_nodes = 1.0e-3_wp
  !> When facets are cut: before an increment, when it is known where points have touched in it, and
  !! after a solve.
  integer, parameter :: cut_at_start = 1, cut_at_touch = 2, cut_after_solve = 3
  !> How often a facet is cut anew within an increment, and with multipliers at nodes, where no
  !! point has a history that a cut could blur: cells then are where the bodies are.
  integer, parameter :: most_moves = 4, most_of_nodes = 8
  !> Room over the number of points at the start, and over the bound for any position.
  real(wp), parameter :: reserve = 1.6_wp, spare = 1.3_wp
  !> The latter with multipliers at three nodes, whose facets slide before friction holds them:
  !! where they lay on the master's edge by edge they get slivers all around (8 on 4 cells: 2.1).
  real(wp), parameter :: spare_of_nodes = 2.6_wp
  !> Cells of a slave facet that there is room for at least, and of one that is cut in four: where
  !! many lie in few facets of the master, edge by edge, all get slivers (3 on 3: 3.2 and 7.9).
  integer, parameter :: least_cells = 4, least_of_parts = 10

contains

  !> Room for the points of a pair with three fixed points in each slave facet, whose penalty gives
  !! the density.
  subroutine prepare_cells(x, pair)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(pair_t), intent(inout) :: pair !! points given; gets cells, density, room for points
    integer :: f, points, parts, least
    real(wp) :: more

    points = pair%facet_points
    parts = 1
    more = merge(spare_of_nodes, spare, pair%mortar)
    if (pair%mortar .and. allocated(pair%points%slave_middles)) then
      parts = slave_parts
      more = spare
    end if
    least = cell_points*merge(least_cells, least_of_parts, parts == 1)
    pair%points%slave_area = [(sum(pair%points%area(points*(f - 1) + 1:points*f)), &
                        f=1, size(pair%points%slave_facets, 2))]
    if (allocated(pair%points%epsilon)) then
      if (size(pair%points%epsilon) > 0) pair%points%density = &
        pair%points%epsilon(1)/pair%points%area(1)
    end if
    points = max(nint(reserve*real(points_at(pair, x), wp)), &
      least*size(pair%points%slave_facets, 2), nint(more*real(parts*cell_points*most_cells( &
      pair%points%slave_facets, pair%surface%facets, x), wp)))
    deallocate (pair%points%point_nodes, pair%points%point_weights, pair%points%area)
    allocate (pair%history%cells(points), pair%history%old_cells(points))
    allocate (pair%points%point_nodes(pair%points%n_slaves, points), &
      pair%points%point_weights(pair%points%n_slaves, points), pair%points%area(points))
    if (allocated(pair%points%epsilon)) deallocate (pair%points%epsilon)
    allocate (pair%points%epsilon(points), source=0.0_wp)
    do f = 1, size(pair%points%slave_facets, 2)
      pair%history%cells(f)%slave = f
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
    trial%mortar = pair%mortar
    trial%surface = pair%surface
    trial%points = pair%points
    trial%search_radius = pair%search_radius
    if (trial%search_radius <= 0.0_wp) trial%search_radius = longest_facet(pair, x)
    call build_tree(trial%surface%tree, trial%surface%facets, x)
    call make_fresh(trial, x, x, fresh)
    do f = 1, size(pair%points%slave_facets, 2)
      call cut_facet(trial, f, slave_positions(trial, f, x), x, x, fresh)
      n = n + fresh%n
    end do
  end function points_at

  !> Forgets all cells: each facet is cut anew.
  pure subroutine clear_cells(pair)
    type(pair_t), intent(inout) :: pair !! gets cell, old_cell, new, old

    pair%history%cells = cell_t()
    pair%history%old_cells = cell_t()
    pair%history%new = contact_point_t()
    pair%history%old = contact_point_t()
    call forget_first_cells(pair)
  end subroutine clear_cells

  !> Nodes, weights, areas and penalties of the present cells.
  pure subroutine show_cells(pair)
    type(pair_t), intent(inout) :: pair !! cell given
    integer :: p, k
    logical :: bent

    bent = allocated(pair%points%slave_middles)
    do p = 1, size(pair%history%cells)
      associate (cell => pair%history%cells(p))
        if (bent) then
          pair%points%point_nodes(:, p) = slave_nodes(pair, max(1, cell%slave))
          pair%points%point_weights(:, p) = slave_weights(pair, max(1, cell%slave), cell%weight)
        else
          do k = 1, 3
            pair%points%point_nodes(k, p) = pair%points%slave_facets(k, max(1, cell%slave))
            pair%points%point_weights(k, p) = cell%weight(k)
          end do
        end if
        pair%points%area(p) = cell%area
        pair%points%epsilon(p) = pair%points%density*cell%area
      end associate
    end do
  end subroutine show_cells

  !> Cells and points of the last converged state.
  pure subroutine begin_cells(pair)
    type(pair_t), intent(inout) :: pair !! old and old_cell become new and cell

    pair%history%new = pair%history%old
    pair%history%cells = pair%history%old_cells
    pair%history%returned = .true.
    call show_cells(pair)
  end subroutine begin_cells

  !> An increment begins, or once more with another end: its first cells are not known.
  pure subroutine forget_first_cells(pair)
    type(pair_t), intent(inout) :: pair !! the pair

    pair%history%begun = .false.
  end subroutine forget_first_cells

  !> Cuts those facets anew whose apexes have moved over the master, or whose cover has changed. New
  !! points get their history from the old ones of their facet. The first cells of an increment do
  !! not depend on where it starts from: they are cut once. After coarse solves cells stay, and with
  !! them the points and the multipliers that these have got so far.
  subroutine follow_cells(pair, x_old, x, tolerance, changes)
    type(pair_t), intent(inout) :: pair !! cells and working points may change
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: tolerance !! 0 at the start of an increment and after coarse solves
    integer, intent(inout) :: changes !! grows by the points of facets that are cut anew
    type(contact_point_t), allocatable :: moved(:)

    if (count_points(pair) == 0) return
    if (tolerance <= 0.0_wp .and. pair%history%begun) then
      if (.not. pair%history%returned) return
      pair%history%cells = pair%history%first_cells
      pair%history%new = pair%history%first
      call show_cells(pair)
    else if (tolerance <= 0.0_wp) then
      call carry_apexes(pair, pair%history%cells, pair%history%new, x_old, x, moved)
      call renew_cells(pair, cut_at_start, moved, x_old, x, changes)
      pair%history%first_cells = pair%history%cells
      pair%history%first = pair%history%new
      pair%history%begun = .true.
    else
      call find_apexes(pair, pair%history%new, x, moved)
      call renew_cells(pair, cut_after_solve, moved, x_old, x, changes)
    end if
    pair%history%returned = .false.
  end subroutine follow_cells

  !> Cuts the facets that have just touched anew, where their points have met the surface: that is
  !! where those stick that will. They have no history yet, and lose nothing.
  subroutine cut_touched(pair, touched, x_old, x, changes)
    type(pair_t), intent(inout) :: pair !! start apexes of the touched points known
    logical, intent(in) :: touched(:) !! (points) they were open, and where they touch is known
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    integer, intent(inout) :: changes !! grows by the points of facets that are cut anew
    type(contact_point_t) :: moved(size(pair%history%new))

    moved = pair%history%new
    moved%status = merge(status_stick, status_open, touched .and. moved%target > 0)
    call renew_cells(pair, cut_at_touch, moved, x_old, x, changes)
  end subroutine cut_touched

  !> Cuts those facets anew whose apexes have moved too far from where their cells were made.
  subroutine renew_cells(pair, when, moved, x_old, x, changes)
    type(pair_t), intent(inout) :: pair !! cells and working points may change
    integer, intent(in) :: when !! at_start, at_touch or after_solve
    type(contact_point_t), intent(in) :: moved(:) !! (points) state and apexes at x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    integer, intent(inout) :: changes !! grows by the points of facets that are cut anew
    type(cell_t), allocatable :: cells(:)
    type(contact_point_t), allocatable :: points(:)
    type(fresh_t) :: fresh
    integer :: f, n, first, last, room
    logical :: stays

    call fit_tree(pair%surface%tree, pair%surface%facets, x)
    cells = pair%history%cells
    points = pair%history%new
    call make_fresh(pair, x_old, x, fresh)
    n = 0
    first = 1
    do f = 1, size(pair%points%slave_facets, 2)
      last = last_of(cells, first, f)
      room = count_points(pair) - n - (size(pair%points%slave_facets, 2) - f)
      call look_at_facet(pair, f, when, cells(first:last), moved(first:last), x_old, x, room, &
        fresh, stays)
      if (stays) then
        fresh%n = last - first + 1
        pair%history%cells(n + 1:n + fresh%n) = cells(first:last)
        pair%history%new(n + 1:n + fresh%n) = points(first:last)
      else
        if (fresh%n > room) pair%history%crowded = .true.
        call fit_in(room, fresh)
        pair%history%cells(n + 1:n + fresh%n) = fresh%cell(:fresh%n)
        call hand_on(pair, f, cells(first:last), points(first:last), fresh, x_old, n)
        if (when == cut_after_solve) then
          pair%history%moves(f) = pair%history%moves(f) + 1
          pair%history%left_cells(f)%cells = cells(first:last)
        end if
        changes = changes + fresh%n
      end if
      n = n + fresh%n
      first = last + 1
    end do
    pair%history%cells(n + 1:) = cell_t()
    pair%history%new(n + 1:) = contact_point_t()
    call show_cells(pair)
  end subroutine renew_cells

  !> Whether the cells of a facet stay. It is cut only where its points cannot tell. Multipliers at
  !! nodes have no history at points that a cut could blur: their cells are where the bodies are.
  subroutine look_at_facet(pair, f, when, cells, moved, x_old, x, room, fresh, stays)
    type(pair_t), intent(inout) :: pair !! counts cuts
    integer, intent(in) :: f !! the slave facet
    integer, intent(in) :: when !! at_start, at_touch or after_solve
    type(cell_t), intent(in) :: cells(:) !! its points
    type(contact_point_t), intent(in) :: moved(:) !! their state, with the apexes at x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    integer, intent(in) :: room !! places for its points
    type(fresh_t), intent(inout) :: fresh !! its points if it is cut anew
    logical, intent(out) :: stays !! they stay
    type(contact_point_t) :: seen(size(moved))
    real(wp) :: nodes(3, 6)

    seen = moved
    if (pair%mortar) seen%status = status_open
    stays = .false.
    if (size(cells) <= room) stays = lie_still(pair, f, cells, seen, x, allowed(moved%target))
    if (stays) return
    if (pair%mortar) then
      nodes = slave_positions(pair, f, x)
    else
      nodes = lag_nodes(pair, f, cells, moved, x)
    end if
    call cut_facet(pair, f, nodes, x_old, x, fresh)
    pair%history%cuts = pair%history%cuts + 1
    if (.not. pair%mortar) stays = have_stayed(pair, f, cells, moved, x, fresh%cell(:fresh%n), &
      fresh%target(:fresh%n), allowed([moved%target, fresh%target(:fresh%n)]))
    if (when == cut_after_solve .and. .not. stays) stays = &
      has_moved_enough(pair, f, x, cells, moved%target, fresh)
    stays = stays .and. size(cells) <= room

  contains

    !> How far points on these master facets may have moved, as in ways_allowed.
    pure function allowed(targets) result(limits)
      integer, intent(in) :: targets(:) !! master facets, 0 for none
      real(wp) :: limits(3)

      limits = at_nodes
      if (.not. pair%mortar) limits = ways_allowed(when, moved%status, has_slipped(pair, f), &
        merge(followed, unmoved, are_level(pair, x, targets)), all(pair%friction%mu <= 0.0_wp))
    end function allowed
  end subroutine look_at_facet

  !> A facet does not change its cells for ever: not often in an increment, and not back to those
  !! that it has left last, as long as they cover what the master does, and lie over their targets.
  pure logical function has_moved_enough(pair, f, x, present, target, fresh) result(enough)
    type(pair_t), intent(in) :: pair !! moves, left_cells
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(cell_t), intent(in) :: present(:) !! its points
    integer, intent(in) :: target(:) !! and their targets
    type(fresh_t), intent(in) :: fresh !! its points if it is cut anew
    integer :: p
    real(wp) :: same, xi(2), gap

    enough = abs(sum(present%area) - sum(fresh%cell(:fresh%n)%area)) <= slipped* &
      pair%points%slave_area(f)
    do p = 1, size(present)
      if (.not. enough) return
      if (target(p) == 0 .or. .not. pair%mortar) cycle
      call project_on_master(pair, target(p), x, cell_position(pair, present(p), x), xi, gap)
      enough = minval(barycentric(xi)) >= -slipped
    end do
    if (.not. enough) return
    enough = pair%history%moves(f) >= merge(most_of_nodes, most_moves, pair%mortar)
    if (enough .or. .not. allocated(pair%history%left_cells(f)%cells)) return
    same = merge(exactly, unmoved, pair%mortar)
    associate (cells => pair%history%left_cells(f)%cells)
      enough = size(cells) == fresh%n
      do p = 1, size(cells)
        if (.not. enough) exit
        enough = maxval(abs(fresh%cell(p)%weight - cells(p)%weight)) <= same
      end do
    end associate
  end function has_moved_enough

  !> How far the apexes of a facet may have moved while its cells stay, in shape functions: those
  !! that slip or are open, and those that stick; and by which share of it its cover may have
  !! changed.
  pure function ways_allowed(when, status, expected, least, forgets) result(limits)
    integer, intent(in) :: when !! at_start, at_touch or after_solve
    integer, intent(in) :: status(:) !! (points of the facet)
    logical, intent(in) :: expected !! to slip
    real(wp), intent(in) :: least !! for points that slip where none sticks
    logical, intent(in) :: forgets !! there is no friction, and no history that a cut could blur
    real(wp) :: limits(3)
    logical :: sticks

    sticks = any(status == status_stick)
    select case (when)
    case (cut_at_start)
      limits(:2) = [merge(slipped, least, sticks), unmoved]
    case (cut_at_touch)
      limits(:2) = merge(exactly, huge(exactly), sticks)
    case default
      limits(:2) = [merge(slipped, least, sticks .or. expected), unmoved]
    end select
    limits(3) = limits(merge(2, 1, sticks))
    if (when == cut_after_solve .and. forgets .and. any(status > status_open)) limits(3) = covered
  end function ways_allowed

  !> The facets of the master that hold points of a slave facet, before and after a cut, are in one
  !! plane.
  pure logical function are_level(pair, x, targets) result(level)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: targets(:) !! master facets, 0 for none
    real(wp) :: first(3), normal(3)
    integer :: k, last

    level = .true.
    first = 0.0_wp
    last = 0
    do k = 1, size(targets)
      if (targets(k) == 0 .or. targets(k) == last) cycle
      normal = facet_normal(corners(x, pair%surface%facets(:, targets(k))))
      if (last == 0) first = normal
      level = level .and. dot_product(first, normal) > 1.0_wp - one_plane
      if (level) level = is_plane(pair, x, targets(k), normal, one_plane)
      last = targets(k)
    end do
  end function are_level

  !> A point of the facet slipped at the last converged state.
  pure logical function has_slipped(pair, f)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer :: first

    first = max(1, first_cell(pair%history%old_cells, f))
    has_slipped = any(pair%history%old(first:last_of(pair%history%old_cells, first, &
      f))%status == status_slip)
  end function has_slipped

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

  !> History of the new points of a facet.
  subroutine hand_on(pair, f, cells, points, fresh, x_old, n)
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

    first = max(1, first_cell(pair%history%old_cells, f))
    last = last_of(pair%history%old_cells, first, f)
    ! multipliers at nodes stick without elastic slip
    if (.not. pair%mortar) call fit_slip(pair, f, pair%history%old_cells(first:last), &
      pair%history%old(first:last), x_old, slip)
    if (pair%augmented) call fit_multipliers(pair, f, cells, points, x_old, multiplier)
    area = sum(fresh%cell(:fresh%n)%area)
    do p = 1, fresh%n
      associate (point => pair%history%new(n + p), cell => fresh%cell(p), target => fresh%target(p))
        point = contact_point_t()
        point%dissipation = sum(points%dissipation)
        if (area > 0.0_wp) point%dissipation = point%dissipation*cell%area/area
        if (target == 0) cycle
        point%target = target
        point%status = status_open
        point%apex = place_apex(pair, slip, cell, target, x_old)
        call take_slip(pair, slip, cell, x_old, point)
        if (pair%augmented) point%lambda = multiplier_at(pair, multiplier, cell, target, x_old)
      end associate
    end do
  end subroutine hand_on

  !> Makes the converged state the history, as settle_points does.
  pure subroutine settle_cells(pair, x)
    type(pair_t), intent(inout) :: pair !! new and cell are completed and become old and old_cell
    real(wp), intent(in) :: x(:, :) !! (3, nodes) converged positions [length]
    integer :: p
    real(wp) :: gap, y(3)

    do p = 1, size(pair%history%new)
      associate (point => pair%history%new(p))
        if (point%target == 0) point%status = status_off
        if (point%target == 0) point%lambda = 0.0_wp
        if (point%target == 0) cycle
        y = cell_position(pair, pair%history%cells(p), x)
        call open_if_touching(pair, p, point, y, x)
        if (point%status > status_open) cycle
        call project_on_master(pair, point%target, x, y, point%apex, gap)
      end associate
    end do
    pair%history%old = pair%history%new
    pair%history%old_cells = pair%history%cells
    call forget_first_cells(pair)
  end subroutine settle_cells
end module contact_cells

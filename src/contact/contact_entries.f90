!> Entries: a place of the slave that is too deep below a facet has either lain there before, and is
!! behind the body, or this increment has led it through the surface (doc/theory, "Undetected
!! penetration", eq. (10.3)).
module contact_entries
  use kinds, only: wp
  use element_types, only: status_open
  use contact_types, only: pair_t
  use contact_points, only: depth_limit, is_too_deep, first_cell, count_points, point_position
  use surface_boundary, only: walk
  use smooth_normals, only: project_on_master
  use facet_geometry, only: corners, barycentric, facet_normal
  use facet_tree, only: facets_near, fit_tree
  implicit none
  private
  public :: master_way_t, measure_way, way_past, may_enter, entry_facet, has_entered, was_held, &
    held_reach, has_gone_through

  !> A place was at the surface if it was no deeper than this share of the depth limit.
  real(wp), parameter :: near_surface = 0.5_wp
  !> A way through the edge of a facet goes through the facet, as nearly as this [shape functions].
  real(wp), parameter :: at_edge = 1.0e-6_wp

  !> How the master of a pair has moved since the last converged state.
  type :: master_way_t
    real(wp) :: mean(3) = 0.0_wp !! mean way of the corners of its facets [length]
    real(wp) :: apart = 0.0_wp !! most that the way of one of them differs from that [length]
    real(wp) :: least = 0.0_wp !! smallest depth limit of a facet; 0 without a way [length]
  end type master_way_t

contains

  !> Measures the way of the master.
  pure type(master_way_t) function measure_way(pair, x_old, x) result(way)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    integer :: f, k

    associate (facets => pair%surface%facets)
      do f = 1, size(facets, 2)
        do k = 1, 3
          way%mean = way%mean + x(:, facets(k, f)) - x_old(:, facets(k, f))
        end do
      end do
      way%mean = way%mean/real(max(1, size(facets)), wp)
      do f = 1, size(facets, 2)
        do k = 1, 3
          way%apart = max(way%apart, norm2(x(:, facets(k, f)) - x_old(:, facets(k, f)) - way%mean))
        end do
      end do
    end associate
    way%least = pair%search_radius
    if (allocated(pair%surface%depth)) way%least = min(way%least, minval(pair%surface%depth))
  end function measure_way

  !> Most that a place has moved over the master.
  pure real(wp) function way_past(way, y_old, y) result(most)
    type(master_way_t), intent(in) :: way !! of the master
    real(wp), intent(in) :: y_old(3) !! the place at the last converged state [length]
    real(wp), intent(in) :: y(3) !! and now [length]

    most = norm2(y - y_old - way%mean) + way%apart
  end function way_past

  !> A way is long enough to lead from the surface to where a place is too deep.
  pure logical function may_enter(way, most) result(may)
    type(master_way_t), intent(in) :: way !! of the master
    real(wp), intent(in) :: most !! the way over it [length]

    may = most > (1.0_wp - near_surface)*way%least
  end function may_enter

  !> Where the way of a place leads through a facet, from outside to inside: its share until there,
  !! 0 if it begins at the facet, and 2 if it does not lead through it. To first order the facet
  !! moves evenly: gap and projection are linear in the share.
  pure subroutine cross_facet(pair, facet, x_old, x, y_old, y, share, gap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: y_old(3) !! the place at the last converged state [length]
    real(wp), intent(in) :: y(3) !! and now [length]
    real(wp), intent(out) :: share !! of the way
    real(wp), intent(out) :: gap !! now, positive outside [length]
    real(wp) :: xi_old(2), xi(2), gap_old, before

    share = 2.0_wp
    call project_on_master(pair, facet, x, y, xi, gap)
    if (gap >= 0.0_wp) return
    call project_on_master(pair, facet, x_old, y_old, xi_old, gap_old)
    if (gap_old < -near_surface*depth_limit(pair, facet)) return
    before = max(0.0_wp, gap_old)
    before = before/(before - gap)
    if (all(barycentric(xi_old + before*(xi - xi_old)) >= -at_edge)) share = before
  end subroutine cross_facet

  !> The facet through which the way of a place leads first, if it lies too deep below that now;
  !! else 0.
  pure integer function entry_facet(pair, way, x_old, x, y_old, y) result(facet)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    type(master_way_t), intent(in) :: way !! of the master
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: y_old(3) !! the place at the last converged state [length]
    real(wp), intent(in) :: y(3) !! and now [length]
    integer, allocatable :: near(:)
    real(wp) :: share, first, gap, depth
    integer :: n, k

    facet = 0
    if (.not. may_enter(way, way_past(way, y_old, y))) return
    allocate (near(size(pair%surface%facets, 2)))
    associate (half => 0.5_wp*(y - y_old - way%mean))
      call facets_near(pair%surface%tree, y - half, norm2(half) + way%apart, near, n)
    end associate
    first = 1.0_wp
    depth = 0.0_wp
    do k = 1, n
      call cross_facet(pair, near(k), x_old, x, y_old, y, share, gap)
      if (share > first .or. (share >= first .and. facet > 0)) cycle
      first = share
      facet = near(k)
      depth = gap
    end do
    if (facet == 0) return
    if (.not. is_too_deep(pair, facet, depth)) facet = 0
  end function entry_facet

  !> A place that is too deep below a facet has come there through the surface in this increment:
  !! through the facet, or through another one from where the place's projection leads to this one
  !! or one that has a corner in common with it.
  pure logical function has_entered(pair, way, facet, x_old, x, y_old, y) result(entered)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    type(master_way_t), intent(in) :: way !! of the master
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: y_old(3) !! the place at the last converged state [length]
    real(wp), intent(in) :: y(3) !! and now [length]
    real(wp) :: share, gap
    integer :: other

    entered = .false.
    if (.not. may_enter(way, way_past(way, y_old, y))) return
    call cross_facet(pair, facet, x_old, x, y_old, y, share, gap)
    entered = share <= 1.0_wp
    if (entered) return
    other = entry_facet(pair, way, x_old, x, y_old, y)
    if (other == 0) return
    call walk(pair, x, y, other)
    entered = meet(pair, facet, other)
  end function has_entered

  !> Two facets of the master have a corner in common.
  pure logical function meet(pair, a, b)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: a !! a facet
    integer, intent(in) :: b !! another
    integer :: k

    meet = .false.
    do k = 1, 3
      meet = meet .or. any(pair%surface%facets(:, a) == pair%surface%facets(k, b))
    end do
  end function meet

  !> A slave facet of a segmented pair was in contact with a facet at the last converged state, or
  !! with one that has a corner in common with it.
  pure logical function was_held(pair, f, facet) result(held)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer, intent(in) :: facet !! the master facet
    integer :: k

    associate (targets => closed_targets(pair, f))
      held = any([(meet(pair, facet, targets(k)), k=1, size(targets))])
    end associate
  end function was_held

  !> Farthest from a place that a facet lies with which a slave facet was in contact.
  pure real(wp) function held_reach(pair, f, x, y) result(reach)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: y(3) !! the place [length]
    integer :: k

    reach = 0.0_wp
    associate (targets => closed_targets(pair, f))
      do k = 1, size(targets)
        reach = max(reach, norm2(y - x(:, pair%surface%facets(1, targets(k)))))
      end do
    end associate
  end function held_reach

  !> Master facets with which a slave facet of a segmented pair was in contact at the last converged
  !! state, one for each closed point.
  pure function closed_targets(pair, f) result(targets)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer, allocatable :: targets(:)
    integer :: first, last

    targets = [integer ::]
    if (.not. allocated(pair%history%old_cells)) return
    first = first_cell(pair%history%old_cells, f)
    if (first == 0) return
    last = first
    do while (last < size(pair%history%old_cells))
      if (pair%history%old_cells(last + 1)%slave /= f) exit
      last = last + 1
    end do
    associate (points => pair%history%old(first:last))
      targets = pack(points%target, points%target > 0 .and. points%status > status_open)
    end associate
  end function closed_targets

  !> A place of the slave for which no facet counts has gone through the master in this increment.
  logical function has_gone_through(pair, x_old, x) result(through)
    type(pair_t), intent(inout) :: pair !! the pair, with its targets at x; its tree is fitted to x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(master_way_t) :: way
    integer :: p, n

    through = .false.
    if (all(pair%history%new%target > 0)) return
    call fit_tree(pair%surface%tree, pair%surface%facets, x)
    way = measure_way(pair, x_old, x)
    if (pair%segmented) then
      do p = 1, count(pair%history%cells%slave > 0)
        if (pair%history%new(p)%target > 0) cycle
        through = facet_is_through(pair, way, pair%history%cells(p)%slave, x_old, x)
        if (through) return
      end do
      return
    end if
    n = count_points(pair)/pair%points%slots
    do p = 1, n
      if (any(pair%history%new(p::n)%target > 0)) cycle
      through = is_through(pair, way, x_old, x, point_position(pair, p, x_old), &
        point_position(pair, p, x), normal_at(pair, p, x))
      if (through) return
    end do
  end function has_gone_through

  !> Which way the slave looks at a point; zero where that is not known.
  pure function normal_at(pair, p, x) result(normal)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point, of a first slot
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: normal(3)
    integer :: first, i

    normal = 0.0_wp
    if (pair%points%n_slaves > 1) then
      normal = facet_normal(corners(x, pair%points%point_nodes(:3, p)))
    else if (allocated(pair%points%ring)) then
      first = 1
      if (p > 1) first = pair%points%ring_end(p - 1) + 1
      do i = first, pair%points%ring_end(p)
        normal = normal + facet_normal(corners(x, pair%points%slave_facets(:, &
          pair%points%ring(i))))
      end do
    end if
  end function normal_at

  !> A corner or the middle of a slave facet has gone through the master.
  pure logical function facet_is_through(pair, way, f, x_old, x) result(through)
    type(pair_t), intent(in) :: pair !! a segmented pair, its tree fitted to x
    type(master_way_t), intent(in) :: way !! of the master
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: before(3, 4), now(3, 4)
    integer :: k

    before(:, :3) = corners(x_old, pair%points%slave_facets(:, f))
    now(:, :3) = corners(x, pair%points%slave_facets(:, f))
    before(:, 4) = sum(before(:, :3), 2)/3.0_wp
    now(:, 4) = sum(now(:, :3), 2)/3.0_wp
    do k = 1, 4
      through = is_through(pair, way, x_old, x, before(:, k), now(:, k), facet_normal(now(:, :3)))
      if (through) return
    end do
  end function facet_is_through

  !> A place has come from before a facet that it looks at to too deep below it: through the facet
  !! that is first on its way, or beside a facet and now below that.
  pure logical function is_through(pair, way, x_old, x, y_old, y, normal) result(through)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    type(master_way_t), intent(in) :: way !! of the master
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: y_old(3) !! the place at the last converged state [length]
    real(wp), intent(in) :: y(3) !! and now [length]
    real(wp), intent(in) :: normal(3) !! of the slave there, zero if it is not known
    integer, allocatable :: near(:)
    real(wp) :: most, gap, gap_old, xi(2), xi_old(2)
    integer :: n, k

    through = .false.
    most = way_past(way, y_old, y)
    if (.not. may_enter(way, most)) return
    k = entry_facet(pair, way, x_old, x, y_old, y)
    if (k > 0) through = looks_at(k)
    if (through) return
    allocate (near(size(pair%surface%facets, 2)))
    call facets_near(pair%surface%tree, y, most, near, n)
    do k = 1, n
      if (.not. looks_at(near(k))) cycle
      call project_on_master(pair, near(k), x, y, xi, gap)
      if (any(barycentric(xi) < 0.0_wp) .or. .not. is_too_deep(pair, near(k), gap)) cycle
      call project_on_master(pair, near(k), x_old, y_old, xi_old, gap_old)
      through = gap_old >= -near_surface*depth_limit(pair, near(k))
      if (through) return
    end do

  contains

    !> The place looks at a facet, as far as is known.
    pure logical function looks_at(facet)
      integer, intent(in) :: facet !! of the master

      looks_at = dot_product(normal, facet_normal(corners(x, pair%surface%facets(:, facet)))) &
        <= 0.0_wp
    end function looks_at
  end function is_through
end module contact_entries

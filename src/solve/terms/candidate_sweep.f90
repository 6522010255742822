!> What comes close to each other in a pair while its bodies go rigidly from place to place
!! (doc/theory, "Static condensation").
module candidate_sweep
  use kinds, only: wp
  use threads, only: worth_threads
  use contact_types, only: pair_t
  use contact_points, only: count_points, used_points, point_position
  use facet_geometry, only: corners, distance_to_facet, project_on_facet
  use facet_tree, only: facet_tree_t, build_tree, fit_tree, nearest_facet, facets_near
  implicit none
  private
  public :: sweep_pair

  !> Slave nodes further from the master than this many search radii do not count.
  real(wp), parameter :: reach_radii = 1.5_wp
  !> Most positions that are looked at between two corners of a load.
  integer, parameter :: most_positions = 200
  !> Where rigid bodies would press their points into the master by at most such a share of the
  !! search radius, contact is looked for within another one of where they go, at steps of half of
  !! it; elsewhere one ring of facets around them.
  real(wp), parameter :: little_depth = 0.125_wp, margin = 0.25_wp, fine_step = 0.5_wp
  !> Facets that may be so near to a point.
  integer, parameter :: most_facets_near = 64
  !> Multiplications and additions for a point at a position, at least.
  real(wp), parameter :: operations_of_place = 500.0_wp

  !> Nodes that have been marked.
  type :: marks_t
    logical, allocatable :: touched(:) !! (nodes) points that come close, and facets below them
    logical, allocatable :: near(:) !! (nodes) facets a little farther off; goes where points are
    !! too deep to tell
  end type marks_t

  !> A position: a share of the way to a corner of the loads.
  type :: position_t
    integer :: corner !! the corner, at least 2
    real(wp) :: share !! of the way from the one before
  end type position_t

contains

  !> Marks what comes close to each other in a pair while its bodies go rigidly from place to place.
  !! Threads take every so many positions each.
  subroutine sweep_pair(pair, reference, places, candidate, near)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: reference(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: places(:, :, :) !! (3, nodes, corners) where they go [length]
    logical, intent(inout) :: candidate(:) !! (nodes) marked: points and the facets below them
    logical, allocatable, intent(inout) :: near(:) !! (nodes) marked: facets a little farther off;
    !! goes where points would be too deep to tell
    type(position_t), allocatable :: positions(:)
    type(marks_t), allocatable :: marks(:)
    type(facet_tree_t) :: tree
    integer :: s, strips

    allocate (marks(1))
    marks(1)%touched = candidate
    call move_alloc(near, marks(1)%near)
    call build_tree(tree, pair%surface%facets, reference)
    call mark_pair(pair, tree, places(:, :, 1), marks(1))
    call list_positions(pair, places, pair%search_radius*merge(fine_step, 1.0_wp, &
      allocated(marks(1)%near)), positions)
    strips = worth_threads(operations_of_place*real(used_points(pair), wp)*real(size(positions), &
      wp))
    marks = [(marks(1), s=1, strips)]
    !$omp parallel do schedule(static, 1) default(none) &
    !$omp& shared(pair, tree, places, positions, marks, strips) if(strips > 1)
    do s = 1, strips
      call sweep_strip(pair, tree, places, positions(s::strips), marks(s))
    end do
    !$omp end parallel do
    do s = 1, strips
      candidate = candidate .or. marks(s)%touched
      if (.not. allocated(marks(s)%near)) cycle
      if (.not. allocated(near)) allocate (near(size(candidate)), source=.false.)
      near = near .or. marks(s)%near
    end do
    do s = 1, strips
      if (allocated(near) .and. .not. allocated(marks(s)%near)) deallocate (near)
    end do
  end subroutine sweep_pair

  !> Positions no farther apart than a step, between the corners of the loads and at them.
  pure subroutine list_positions(pair, places, step, positions)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: places(:, :, :) !! (3, nodes, corners) [length]
    real(wp), intent(in) :: step !! [length]
    type(position_t), allocatable, intent(out) :: positions(:) !! after the first corner
    real(wp) :: way
    integer :: c, part, parts

    allocate (positions(0))
    do c = 2, size(places, 3)
      way = longest_way(pair, places(:, :, c - 1), places(:, :, c))
      parts = ceiling(way/max(step, way/real(most_positions, wp), tiny(1.0_wp)))
      positions = [positions, [(position_t(c, real(part, wp)/real(parts, wp)), part=1, parts)]]
    end do
  end subroutine list_positions

  !> Marks what comes close at some positions.
  pure subroutine sweep_strip(pair, tree, places, positions, marks)
    type(pair_t), intent(in) :: pair !! the pair
    type(facet_tree_t), intent(in) :: tree !! its tree
    real(wp), intent(in) :: places(:, :, :) !! (3, nodes, corners) [length]
    type(position_t), intent(in) :: positions(:) !! these
    type(marks_t), intent(inout) :: marks !! gets more
    type(facet_tree_t) :: fitted
    real(wp) :: x(3, size(places, 2))
    integer :: k

    fitted = tree
    do k = 1, size(positions)
      associate (from => places(:, :, positions(k)%corner - 1), &
        to => places(:, :, positions(k)%corner))
        x = from + (to - from)*positions(k)%share
      end associate
      call mark_pair(pair, fitted, x, marks)
    end do
  end subroutine sweep_strip

  !> How far the nodes of a pair go, the one against the other.
  pure real(wp) function longest_way(pair, from, to) result(way)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: from(:, :), to(:, :) !! (3, nodes) positions [length]
    real(wp) :: drift(3)
    integer :: p, f, k

    way = 0.0_wp
    if (count_points(pair) == 0) return
    drift = point_position(pair, 1, to) - point_position(pair, 1, from)
    do p = 1, used_points(pair)
      way = max(way, norm2(point_position(pair, p, to) - point_position(pair, p, from) - drift))
    end do
    do f = 1, size(pair%surface%facets, 2)
      do k = 1, 3
        associate (node => pair%surface%facets(k, f))
          way = max(way, norm2(to(:, node) - from(:, node) - drift))
        end associate
      end do
    end do
  end function longest_way

  !> Marks slave nodes close to the master, and the facets below them.
  pure subroutine mark_pair(pair, tree, x, marks)
    type(pair_t), intent(in) :: pair !! the pair
    type(facet_tree_t), intent(inout) :: tree !! its tree; fitted to x
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(marks_t), intent(inout) :: marks !! gets more; near goes where a point is too deep
    real(wp) :: distance, y(3)
    integer :: p, facet

    call fit_tree(tree, pair%surface%facets, x)
    do p = 1, used_points(pair)
      y = point_position(pair, p, x)
      call nearest_facet(tree, pair%surface%facets, x, y, facet, distance, pair%surface%depth)
      if (facet == 0 .or. distance > reach_radii*pair%search_radius) cycle
      marks%touched(pair%points%point_nodes(:, p)) = .true.
      marks%touched(pair%surface%facets(:, facet)) = .true.
      if (allocated(marks%near)) call mark_near(pair, tree, x, y, facet, distance, marks%near)
    end do
  end subroutine mark_pair

  !> Marks the facets around a point that are hardly farther off than the nearest one.
  pure subroutine mark_near(pair, tree, x, y, nearest, distance, near)
    type(pair_t), intent(in) :: pair !! the pair
    type(facet_tree_t), intent(in) :: tree !! its tree, fitted to x
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(in) :: nearest !! its nearest facet
    real(wp), intent(in) :: distance !! how far that is off [length]
    logical, allocatable, intent(inout) :: near(:) !! (nodes) marked; goes where the point is too
    !! deep, or facets are many
    integer :: found(most_facets_near), n, i
    real(wp) :: xi(2), gap, farthest

    call project_on_facet(corners(x, pair%surface%facets(:, nearest)), y, xi, gap)
    farthest = distance + margin*pair%search_radius
    call facets_near(tree, y, farthest, found, n)
    if (gap < -little_depth*pair%search_radius .or. n == most_facets_near) then
      deallocate (near)
      return
    end if
    do i = 1, n
      associate (nodes => pair%surface%facets(:, found(i)))
        if (all(near(nodes))) cycle
        if (distance_to_facet(corners(x, nodes), y) <= farthest) near(nodes) = .true.
      end associate
    end do
  end subroutine mark_near
end module candidate_sweep

!> Target facets: which facet carries the apex of each contact point (doc/theory, "Target facet").
!!
!! A target is frozen while a system is solved. It changes between solves, by walking from facet to
!! facet across edges until the apex lies inside; the start apex is unfolded at each edge.
module contact_targets
  use kinds, only: wp
  use threads, only: pays_threads
  use element_types, only: status_off, status_open
  use contact_types, only: pair_t, contact_point_t, forget_moves
  use contact_points, only: count_points, point_position, is_first, longest_facet, is_too_deep
  use contact_parameters, only: first_raise, has_multipliers, has_field
  use smooth_normals, only: find_corners, renew_patches, project_on_master
  use contact_bodies, only: is_through_body
  use concave_edges, only: find_concave_edges, seek_second, is_taken, close_open_slots
  use convex_edges, only: find_convex_edges, convex_edge_t, look_at_convex_edges, pass_edge
  use surface_boundary, only: find_boundary, facet_across, walk, beyond_boundary, has_left, stays, &
    boundary_tolerance, on_edge, longest_walk
  use contact_apexes, only: apex_of, find_apex, touches, open_if_touching
  use contact_entries, only: master_way_t, measure_way, entry_facet
  use contact_cells, only: begin_cells, follow_cells, settle_cells, clear_cells
  use facet_tree, only: build_tree, fit_tree, nearest_facet
  use facet_geometry, only: unfold_vector, barycentric, corners, facet_size
  use master_facets, only: find_sharp_edges
  use mortar_types, only: mortar_t
  use mortar_functions, only: find_faces
  implicit none
  private
  public :: start_pair, begin_increment, follow_apexes, settle_points

  !> Changes of target of one point within one increment; more would be ping-pong.
  integer, parameter :: most_moves = 4
  !> A point that had no facet at the start and has used up its moves is let go if it is as far as
  !! this share of a facet beyond the boundary: else it might come and go for ever.
  real(wp), parameter :: far_beyond = 0.25_wp
  !> To look whether a point keeps its target takes as long as so many multiplications and
  !! additions.
  real(wp), parameter :: operations_of_point = 1200.0_wp

contains

  !> First targets and apexes, on the reference positions.
  subroutine start_pair(pair, x)
    type(pair_t), intent(inout) :: pair !! gets old, new, left, moves
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: p

    if (pair%smooth .and. .not. allocated(pair%surface%patch)) call find_corners(pair, x)
    if (allocated(pair%surface%middles) .and. .not. allocated(pair%surface%sharp)) &
      call find_sharp_edges(pair, x)
    call find_concave_edges(pair, x)
    call find_convex_edges(pair, x)
    call find_boundary(pair)
    call build_tree(pair%surface%tree, pair%surface%facets, x)
    if (.not. allocated(pair%history%old)) allocate (pair%history%old(count_points(pair)))
    if (.not. allocated(pair%history%new)) allocate (pair%history%new(count_points(pair)))
    pair%history%left = spread(0, 1, count_points(pair))
    pair%history%moves = pair%history%left
    if (pair%search_radius <= 0.0_wp) pair%search_radius = longest_facet(pair, x)
    if (pair%mortar) call find_faces(pair, x)
    pair%old_nodes = mortar_t()
    if (pair%segmented) then
      call start_cells(pair, x)
      return
    end if
    do p = 1, count_points(pair)/pair%points%slots
      call seek(pair, master_way_t(), x, x, p, pair%history%new(p))
    end do
    pair%history%old = pair%history%new
  end subroutine start_pair

  !> First cells of a segmented pair, on the reference positions.
  subroutine start_cells(pair, x)
    type(pair_t), intent(inout) :: pair !! gets cell, new, old
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: changes

    call clear_cells(pair)
    changes = 0
    call follow_cells(pair, x, x, 0.0_wp, changes)
    call settle_cells(pair, x)
  end subroutine start_cells

  !> Working points of an increment: what is lost at the last converged state is let go, what has
  !! come over the surface is picked up.
  subroutine begin_increment(pair, x_old)
    type(pair_t), intent(inout) :: pair !! new becomes the working state
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    integer :: p

    if (pair%smooth) call renew_patches(pair, x_old)
    pair%history%new = pair%history%old
    pair%history%start = pair%history%old
    pair%history%raise = first_raise(pair)
    call forget_moves(pair)
    if (pair%segmented) then
      call begin_cells(pair)
      return
    end if
    call close_open_slots(pair)
    if (any(pair%history%new%target == 0)) call fit_tree(pair%surface%tree, pair%surface%facets, &
      x_old)
    do p = 1, size(pair%history%new)
      associate (point => pair%history%new(p))
        if (point%target > 0) then
          if (has_left(pair, x_old, p, point%target)) call let_go(point)
        end if
        if (point%target > 0 .or. .not. is_first(pair, p)) cycle
        call seek(pair, master_way_t(), x_old, x_old, p, point)
        if (stays(pair, x_old, p, pair%history%old(p)%target, &
          point%target)) point = pair%history%old(p)
      end associate
    end do
  end subroutine begin_increment

  !> Lets the targets follow the apexes at the positions x, crossing an edge when an apex is further
  !! outside its facet than `tolerance` (less at a kinked edge). A new target counts as a change
  !! only where the point touches the old or the new facet. No point goes back to the target it has
  !! left last: on a convex edge or in a valley two facets may point at each other for ever.
  subroutine follow_apexes(pair, x_old, x, tolerance, changes)
    type(pair_t), intent(inout) :: pair !! new: targets and start apexes may change
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: tolerance !! in shape functions; 0 for the first choice of targets
    integer, intent(inout) :: changes !! grows by the number of points with a new target
    integer :: p
    type(master_way_t) :: way
    logical :: pays

    if (pair%segmented) then
      call follow_cells(pair, x_old, x, tolerance, changes)
      return
    end if
    if (any(pair%history%new%target == 0)) then
      call fit_tree(pair%surface%tree, pair%surface%facets, x)
      way = measure_way(pair, x_old, x)
    end if
    ! slots of one node look at each other
    pays = pays_threads(operations_of_point*real(size(pair%history%new), wp))
    pays = pays .and. pair%points%slots == 1
    !$omp parallel do if(pays) schedule(dynamic, 32) default(none) private(p) &
    !$omp& shared(pair, way, x_old, x, tolerance) reduction(+:changes)
    do p = 1, size(pair%history%new)
      call follow_point(pair, way, x_old, x, tolerance, p, changes)
    end do
    !$omp end parallel do
  end subroutine follow_apexes

  !> Lets the target of one point follow its apex.
  subroutine follow_point(pair, way, x_old, x, tolerance, p, changes)
    type(pair_t), intent(inout) :: pair !! new: target and start apex may change
    type(master_way_t), intent(in) :: way !! of the master, if some point has no target
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: tolerance !! as in follow_apexes
    integer, intent(in) :: p !! the point
    integer, intent(inout) :: changes !! grows by one if the target has changed
    type(contact_point_t) :: before
    integer :: target
    real(wp) :: zone
    logical :: touched, back

    back = .false.
    associate (point => pair%history%new(p))
      target = point%target
      touched = touches(pair, x, p, target)
      if (target == 0 .and. is_first(pair, p)) then
        call seek(pair, way, x_old, x, p, point)
      else if (target == 0) then
        call seek_second(pair, x_old, x, p, point)
      else if (pair%history%moves(p) < most_moves) then
        before = point
        call follow_apex(pair, x_old, x, tolerance, p, point)
        if (tolerance > 0.0_wp) call take_back(pair, x_old, x, tolerance, p, point, back)
        if (point%target == pair%history%left(p)) point = before
      end if
      if (target > 0 .and. tolerance > 0.0_wp .and. pair%history%start(p)%target == 0) then
        zone = 0.0_wp
        if (pair%history%moves(p) >= most_moves) zone = far_beyond*facet_size(corners(x, &
          pair%surface%facets(:, point%target)))
        if (beyond_boundary(pair, x, point_position(pair, p, x), point%target, zone)) &
          call let_go(point)
      end if
      if (point%target == target) return
      if (tolerance > 0.0_wp) then
        pair%history%left(p) = merge(0, target, back)
        pair%history%moves(p) = pair%history%moves(p) + 1
      end if
      if (touched .or. touches(pair, x, p, point%target)) changes = changes + 1
    end associate
  end subroutine follow_point

  !> Lets a point go that has passed the boundary: at the last converged state; and within an
  !! increment one that had no facet at its start, so that it does not matter where the iteration
  !! took it.
  pure subroutine let_go(point)
    type(contact_point_t), intent(inout) :: point !! its working state

    point%target = 0
    point%status = status_off
    point%lambda = 0.0_wp
  end subroutine let_go

  !> Walks with one apex.
  subroutine follow_apex(pair, x_old, x, tolerance, p, point)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: tolerance !! in shape functions
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(inout) :: point !! its working state
    integer :: step, next, before, start_target, k
    type(convex_edge_t) :: found

    start_target = point%target
    before = 0
    do step = 1, longest_walk
      found = look_at_convex_edges(pair, x, p, point%target)
      next = found%next
      if (next == 0) next = facet_across(pair, x, point%target, apex_of(pair, p, point, x), &
        tolerance, found%barred)
      if (next == 0 .or. next == before .or. (step > 1 .and. next == start_target)) exit
      before = point%target
      do k = 1, count(found%via > 0)
        call step_over(pair, x_old, found%via(k), point)
      end do
      call step_over(pair, x_old, next, point)
    end do
  end subroutine follow_apex

  !> Gives a point to the facet that holds its apex when it is followed from the last converged
  !! state. Below a convex kink either facet may hold its own apex: it must not matter with which of
  !! them the solve began. One that this increment has left already is not taken back. An apex on an
  !! edge of the facet that had it is still there.
  subroutine take_back(pair, x_old, x, tolerance, p, point, back)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(in) :: tolerance !! in shape functions
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(inout) :: point !! its working state
    logical, intent(out) :: back !! it has another target now
    type(contact_point_t) :: trial
    real(wp) :: apex(2)
    integer :: status

    back = .false.
    if (any(pair%history%start(p)%target == [0, point%target, pair%history%left(p)])) return
    trial = point
    trial%target = pair%history%start(p)%target
    trial%apex = pair%history%start(p)%apex
    call follow_apex(pair, x_old, x, tolerance, p, trial)
    if (any(trial%target == [point%target, pair%history%left(p)])) return
    if (has_multipliers(pair) .and. all(pair%surface%neighbours(:, point%target) /= &
      trial%target)) return
    call find_apex(pair, p, trial, x, apex, status)
    back = status > status_open .and. all(barycentric(apex) > merge(-on_edge, boundary_tolerance, &
      trial%target == pair%history%start(p)%target))
    if (.not. back) return
    if (has_multipliers(pair)) trial%lambda = unfold_vector(pair%surface%facets(:, point%target), &
      pair%surface%facets(:, trial%target), x_old, point%lambda)
    point = trial
  end subroutine take_back

  !> Hands a point on to a neighbour of its target, with its start apex and its multiplier.
  subroutine step_over(pair, x_old, next, point)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    integer, intent(in) :: next !! the neighbour
    type(contact_point_t), intent(inout) :: point !! its working state
    real(wp) :: start(2)

    call pass_edge(pair, x_old, point%target, next, point%apex, start)
    if (has_multipliers(pair)) point%lambda = unfold_vector(pair%surface%facets(:, point%target), &
      pair%surface%facets(:, next), x_old, point%lambda)
    point%target = next
    point%apex = start
  end subroutine step_over

  !> Looks for a facet under a point that has none; its start apex is the projection of its last
  !! converged position, so that the first touch has the right direction. What has come through a
  !! facet and is too deep below it now belongs to that.
  subroutine seek(pair, way, x_old, x, p, point)
    type(pair_t), intent(in) :: pair !! the pair
    type(master_way_t), intent(in) :: way !! of the master, from x_old to x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions at which to look [length]
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(inout) :: point !! gets target, apex, status
    integer :: facet
    real(wp) :: xi(2), gap, distance
    logical :: entered

    facet = entry_facet(pair, way, x_old, x, point_position(pair, p, x_old), &
      point_position(pair, p, x))
    entered = facet > 0
    if (.not. entered) call nearest_facet(pair%surface%tree, pair%surface%facets, x, &
      point_position(pair, p, x), facet, distance, pair%surface%depth)
    if (facet == 0) return
    if (is_taken(pair, x, p, facet)) return
    if (allocated(pair%surface%sharp) .and. .not. entered) call walk(pair, x, &
      point_position(pair, p, x), facet)
    call project_on_master(pair, facet, x, point_position(pair, p, x), xi, gap)
    if (is_too_deep(pair, facet, gap) .and. .not. entered) return
    if (is_through_body(pair, x, p, facet, gap) .and. .not. entered) return
    if (beyond_boundary(pair, x, point_position(pair, p, x), facet, 0.0_wp)) return
    point%target = facet
    point%status = status_open
    point%path = 0.0_wp
    point%way = 0.0_wp
    call project_on_master(pair, facet, x_old, point_position(pair, p, x_old), point%apex, gap)
  end subroutine seek

  !> Makes the converged state the history: apexes where the elements left them; an open point's
  !! apex at its projection. A point that only touches is open.
  subroutine settle_points(pair, x)
    type(pair_t), intent(inout) :: pair !! new is completed and copied to old
    real(wp), intent(in) :: x(:, :) !! (3, nodes) converged positions [length]
    integer :: p
    real(wp) :: gap

    if (pair%segmented) then
      call settle_cells(pair, x)
      return
    end if
    do p = 1, size(pair%history%new)
      associate (point => pair%history%new(p))
        call open_if_touching(pair, p, point, point_position(pair, p, x), x)
        if (point%status <= status_open .and. .not. has_field(pair)) point%lambda = 0.0_wp
        if (point%target == 0) then
          point%status = status_off
        else if (point%status == status_open) then
          call walk(pair, x, point_position(pair, p, x), point%target)
          call project_on_master(pair, point%target, x, point_position(pair, p, x), point%apex, gap)
        end if
      end associate
    end do
    pair%history%old = pair%history%new
  end subroutine settle_points
end module contact_targets

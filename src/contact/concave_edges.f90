!> Concave edges: where a surface rises steeply from itself, a slave node can touch two or three
!! facets at once, each with its own apex (doc/theory, "Concave feature edges").
!!
!! A pair whose master has concave edges holds three slots for each slave node: point (slot - 1)*n +
!! i is a slot of node i. The first follows the surface as ever, but no apex crosses a concave edge;
!! the others are used while the node is in contact with a further facet.
module concave_edges
  use kinds, only: wp
  use element_types, only: status_off, status_open
  use contact_types, only: pair_t, contact_point_t
  use contact_points, only: count_points, point_position, is_too_deep
  use smooth_normals, only: project_on_master
  use facet_geometry, only: corners, barycentric, facet_normal, is_concave, is_convex
  use facet_tree, only: facets_near
  implicit none
  private
  public :: find_concave_edges, seek_second, is_taken, close_open_slots, same_face

  !> Slots of a node on a surface with concave edges: two walls and a floor.
  integer, parameter :: slots_at_concave_edges = 3
  !> Facets whose normals have a larger cosine belong to the same face of a concave edge, or lie
  !! side by side.
  real(wp), parameter :: same_face = 0.9_wp
  !> A point enters a facet from outside if its last gap is above this share of the search radius.
  real(wp), parameter :: outside = -1.0e-9_wp
  !> Facets looked at around a point.
  integer, parameter :: most_facets = 100

contains

  !> Marks the concave edges of the master; if there are any, or if it is in parts, repeats the
  !! points for the further slots.
  subroutine find_concave_edges(pair, x)
    type(pair_t), intent(inout) :: pair !! gets concave, slots; points, area, epsilon repeated
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: f, k

    allocate (pair%surface%concave(3, size(pair%surface%facets, 2)), source=.false.)
    do f = 1, size(pair%surface%facets, 2)
      do k = 1, 3
        if (pair%surface%neighbours(k, f) == 0) cycle
        pair%surface%concave(k, f) = is_concave(pair%surface%facets(:, f), pair%surface%facets(:, &
          pair%surface%neighbours(k, f)), x)
        if (allocated(pair%surface%sharp)) pair%surface%concave(k, f) = pair%surface%concave(k, &
          f) .and. pair%surface%sharp(k, f)
      end do
    end do
    if (pair%segmented) return
    if (pair%points%slots > 1 .or. .not. (any(pair%surface%concave) .or. in_parts(pair))) return
    pair%points%slots = slots_at_concave_edges
    associate (nodes => pair%points%point_nodes, weights => pair%points%point_weights)
      pair%points%point_nodes &
        = reshape([nodes, nodes, nodes], shape(nodes)*[1, slots_at_concave_edges])
      pair%points%point_weights = reshape([weights, weights, weights], [pair%points%n_slaves, &
        count_points(pair)])
    end associate
    if (allocated(pair%points%area)) pair%points%area = [pair%points%area, pair%points%area, &
      pair%points%area]
    pair%points%epsilon = [pair%points%epsilon, pair%points%epsilon, pair%points%epsilon]
    if (allocated(pair%history%old)) deallocate (pair%history%old)
    if (allocated(pair%history%new)) deallocate (pair%history%new)
  end subroutine find_concave_edges

  !> The master is not one connected surface: its parts may form concave edges as well.
  pure logical function in_parts(pair)
    type(pair_t), intent(in) :: pair !! the pair
    logical :: reached(size(pair%surface%facets, 2))
    integer :: waiting(size(pair%surface%facets, 2)), n, done, f, k

    in_parts = .false.
    if (size(reached) == 0) return
    reached = .false.
    reached(1) = .true.
    waiting(1) = 1
    n = 1
    done = 0
    do while (done < n)
      done = done + 1
      do k = 1, 3
        f = pair%surface%neighbours(k, waiting(done))
        if (f == 0) cycle
        if (reached(f)) cycle
        reached(f) = .true.
        n = n + 1
        waiting(n) = f
      end do
    end do
    in_parts = n < size(reached)
  end function in_parts

  !> Looks for a further facet that a slave node has entered from outside since the last converged
  !! state; its other slots and what is parallel to them are left out.
  subroutine seek_second(pair, x_old, x, p, point)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    integer, intent(in) :: p !! the point, of a further slot
    type(contact_point_t), intent(inout) :: point !! gets target, apex, status
    integer :: found(most_facets), n, i
    real(wp) :: xi(2), gap, gap_old, apex(2), best

    best = -huge(1.0_wp)
    associate (y => point_position(pair, p, x), y_old => point_position(pair, p, x_old))
      call facets_near(pair%surface%tree, y, pair%search_radius, found, n)
      do i = 1, n
        associate (nodes => pair%surface%facets(:, found(i)))
          call project_on_master(pair, found(i), x, y, xi, gap)
          if (gap > 0.0_wp .or. is_too_deep(pair, found(i), gap) .or. gap <= best) cycle
          if (any(barycentric(xi) < 0.0_wp)) cycle
          call project_on_master(pair, found(i), x_old, y_old, apex, gap_old)
          if (gap_old < outside*pair%search_radius) cycle
          if (is_taken(pair, x, p, found(i))) cycle
          best = gap
          point%target = found(i)
          point%apex = apex
          point%status = status_open
        end associate
      end do
    end associate
  end subroutine seek_second

  !> Another slot of the same node holds this facet, one of the same face, or one behind a convex
  !! edge.
  pure logical function is_taken(pair, x, p, facet) result(taken)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: p !! the point
    integer, intent(in) :: facet !! the facet
    integer :: n, slot, other

    taken = .false.
    n = count_points(pair)/pair%points%slots
    do slot = 0, pair%points%slots - 1
      other = slot*n + mod(p - 1, n) + 1
      if (other == p) cycle
      if (pair%history%new(other)%target == 0) cycle
      associate (a => corners(x, pair%surface%facets(:, facet)), &
                 b => corners(x, pair%surface%facets(:, pair%history%new(other)%target)))
        taken = pair%history%new(other)%target == facet .or. is_convex(a, b) &
          .or. dot_product(facet_normal(a), facet_normal(b)) > same_face
      end associate
      if (taken) return
    end do
  end function is_taken

  !> At the start of an increment further slots that have opened are free again, and first slots
  !! that are open look for the closest facet anew, for concave edges may have stopped their walk.
  subroutine close_open_slots(pair)
    type(pair_t), intent(inout) :: pair !! new: targets of open points are taken away
    integer :: p

    if (pair%points%slots == 1) return
    do p = 1, size(pair%history%new)
      if (pair%history%new(p)%status > status_open) cycle
      pair%history%new(p)%target = 0
      pair%history%new(p)%status = status_off
      pair%history%new(p)%lambda = 0.0_wp
    end do
  end subroutine close_open_slots
end module concave_edges

!> Where the apexes of a segmented pair go, and whether its cells still fit (doc/theory,
!! "Segmentation").
module cell_motion
  use kinds, only: wp
  use contact_types, only: pair_t, contact_point_t, cell_t
  use element_types, only: status_open, status_stick
  use contact_apexes, only: find_apex
  use cell_history, only: fit_slip
  use linear_fields, only: linear_field_t, bounded_field_at
  use facet_geometry, only: facet_frame
  use slave_places, only: is_bent, slave_positions, cell_position
  use smooth_normals, only: project_on_master
  implicit none
  private
  public :: carry_apexes, find_apexes, have_stayed, lie_still, lag_nodes

  !> Points of cells that are cut anew are where they were, in shape functions.
  real(wp), parameter :: at_place = 1.0e-8_wp
  !> Elastic slip below this is none [shape functions].
  real(wp), parameter :: no_slip = 1.0e-12_wp
  !> A facet all of which is covered, but for such a share, need not be cut where its points have
  !! moved by less than so much of what is allowed: the cut could not change the cover by as much as
  !! that.
  real(wp), parameter :: all_covered = 1.0e-9_wp, well_within = 0.1_wp

contains

  !> Tips of closed points as they are expected: those that slip go with the projection, those that
  !! stick stay. A point without any elastic slip has not slipped yet.
  pure subroutine carry_apexes(pair, cells, points, x_old, x, moved)
    type(pair_t), intent(in) :: pair !! the pair
    type(cell_t), intent(in) :: cells(:) !! (points) where the points are
    type(contact_point_t), intent(in) :: points(:) !! (points) last converged state
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) expected positions [length]
    type(contact_point_t), allocatable, intent(out) :: moved(:) !! (points) state, apexes at x
    real(wp) :: before(2), xi(2), gap
    integer :: p

    moved = points
    do p = 1, size(points)
      if (points(p)%target == 0 .or. points(p)%status <= status_stick) cycle
      call project_on_master(pair, points(p)%target, x_old, cell_position(pair, cells(p), x_old), &
        before, gap)
      if (all(abs(before - points(p)%apex) <= no_slip)) then
        moved(p)%status = status_stick
        cycle
      end if
      call project_on_master(pair, points(p)%target, x, cell_position(pair, cells(p), x), xi, gap)
      moved(p)%apex = points(p)%apex + xi - before
    end do
  end subroutine carry_apexes

  !> Tips and status of all points at the positions x.
  subroutine find_apexes(pair, points, x, moved)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_point_t), intent(in) :: points(:) !! (points) working state with start apexes
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(contact_point_t), allocatable, intent(out) :: moved(:) !! (points) the state at x
    integer :: p

    moved = points
    do p = 1, size(points)
      if (points(p)%target == 0) cycle
      call find_apex(pair, p, points(p), x, moved(p)%apex, moved(p)%status)
    end do
  end subroutine find_apexes

  !> The points of a facet may stay: their apexes (the projections of open ones) have hardly moved
  !! over the master, and the master covers hardly more or less of the facet.
  pure logical function have_stayed(pair, f, cells, moved, x, fresh, target, limits) &
    result(stay)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    type(cell_t), intent(in) :: cells(:) !! its points
    type(contact_point_t), intent(in) :: moved(:) !! their state, with the apexes at x
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(cell_t), intent(in) :: fresh(:) !! its points if it is cut anew
    integer, intent(in) :: target(:) !! and their targets
    real(wp), intent(in) :: limits(3) !! for points that slip or are open, for those that stick
                                      !! [shape functions], and for the cover [share of the facet]

    stay = size(cells) > 0
    if (.not. stay) return
    if (would_stay(cells, moved, fresh, target, merge(limits(3), limits(:2), limits(3) &
      < minval(limits(:2))))) return
    stay = abs(sum(cells%area) - sum(fresh%area)) <= min(1.0_wp, limits(3))* &
      pair%points%slave_area(f) .and. (any(moved%target > 0) .eqv. any(target > 0))
    if (stay) stay = points_rest(pair, cells, moved, x, limits(:2))
  end function have_stayed

  !> The cells of a facet stay, as its points tell without a cut: all of it is covered, and they
  !! have moved so little over the master that its cover has not changed.
  pure logical function lie_still(pair, f, cells, moved, x, limits) result(stay)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    type(cell_t), intent(in) :: cells(:) !! its points
    type(contact_point_t), intent(in) :: moved(:) !! their state, with the apexes at x
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: limits(3) !! as in have_stayed

    stay = size(cells) > 0
    if (stay) stay = all(moved%target > 0) .and. abs(sum(cells%area) - pair%points%slave_area(f)) &
      <= all_covered*pair%points%slave_area(f)
    if (stay) stay = points_rest(pair, cells, moved, x, well_within*min(1.0_wp, limits(:2), &
      limits(3)))
  end function lie_still

  !> The points of cells have hardly moved over the master: their apexes, or where they are open
  !! their projections.
  pure logical function points_rest(pair, cells, moved, x, limits) result(rest)
    type(pair_t), intent(in) :: pair !! the pair
    type(cell_t), intent(in) :: cells(:) !! points
    type(contact_point_t), intent(in) :: moved(:) !! their state, with the apexes at x
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: limits(2) !! for points that slip or are open, and for those that stick
                                      !! [shape functions]
    real(wp) :: xi(2), gap
    integer :: p

    rest = .true.
    do p = 1, size(cells)
      if (.not. rest) return
      if (moved(p)%target == 0) cycle
      xi = moved(p)%apex
      if (moved(p)%status <= status_open) then
        call project_on_master(pair, moved(p)%target, x, cell_position(pair, cells(p), x), xi, gap)
      end if
      rest = maxval(abs(xi - cells(p)%place)) <= limits(merge(2, 1, moved(p)%status &
                                                               == status_stick))
    end do
  end function points_rest

  !> Cut anew, the cells would be the same: same facets below them, points where they are, as
  !! nearly as the limits say. (Tips may be further from where the cells were made than that: the
  !! elastic slip by which the slave is moved for the cut is a linear field, theirs is not.)
  pure logical function would_stay(cells, moved, fresh, target, limits) result(same)
    type(cell_t), intent(in) :: cells(:) !! points of a facet
    type(contact_point_t), intent(in) :: moved(:) !! their state
    type(cell_t), intent(in) :: fresh(:) !! its points if it is cut anew
    integer, intent(in) :: target(:) !! and their targets
    real(wp), intent(in) :: limits(2) !! for points that slip or are open, and for those that stick
                                      !! [shape functions]
    real(wp) :: limit
    integer :: p

    same = size(cells) == size(fresh)
    if (same) same = all(moved%target == target)
    do p = 1, size(cells)
      if (.not. same) return
      limit = max(at_place, limits(merge(2, 1, moved(p)%status == status_stick)))
      same = maxval(abs(fresh(p)%place - cells(p)%place)) <= limit .and. &
        maxval(abs(fresh(p)%weight - cells(p)%weight)) <= limit
    end do
  end function would_stay

  !> The nodes of a slave facet less the elastic slip there: where its apexes are integrated
  !! exactly.
  pure function lag_nodes(pair, f, cells, moved, x) result(nodes)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    type(cell_t), intent(in) :: cells(:) !! its points
    type(contact_point_t), intent(in) :: moved(:) !! their state, with the apexes at x
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: nodes(3, 6), frame(3, 3), lag(7)
    real(wp), parameter :: half = 0.5_wp, none = 0.0_wp, one = 1.0_wp
    real(wp), parameter :: xi(2, 6) = reshape([one, none, none, one, none, none, half, half, &
      none, half, half, none], [2, 6])
    type(linear_field_t) :: slip
    integer :: k

    nodes = slave_positions(pair, f, x)
    frame = facet_frame(nodes(:, :3))
    call fit_slip(pair, f, cells, moved, x, slip)
    do k = 1, merge(6, 3, is_bent(pair, f))
      lag = bounded_field_at(slip, xi(:, k), 1.0_wp)
      nodes(:, k) = nodes(:, k) - matmul(frame, lag(1:3))
    end do
  end function lag_nodes
end module cell_motion

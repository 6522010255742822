!> Points of other forms beside multipliers at nodes: each is a multiplier that gives way by
!! its penalty (doc/theory, "Mortar contact", eq. (7.22)).
module mortar_points
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_overlap, only: withheld_gap
  use contact_points, only: point_position
  use element_types, only: status_off, status_open, status_slip
  use smooth_normals, only: project_on_master
  use mortar_functions, only: frame_of
  use mortar_types, only: mortar_t
  use mortar_under, only: under_t, look_under
  use mortar_weights, only: weigh_nodes
  use mortar_history, only: take_history
  implicit none
  private
  public :: weigh_pair, keep_points

  !> Points that are farther from the master than this share of a facet are no unknowns: each round
  !! looks anew.
  real(wp), parameter :: far_away = 0.25_wp

contains

  !> Rows, frames and history of a pair with its bodies at x, and forces to begin with from its last
  !! iterate: of its multipliers, or of its points if it has another form.
  pure subroutine weigh_pair(pair, used, x, x_old, nodes)
    type(pair_t), intent(in) :: pair !! points, multipliers of the last iterate
    logical, intent(in) :: used(:) !! (points) that count
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    type(mortar_t), intent(out) :: nodes !! gets all but gaps and status

    if (pair%mortar) then
      call weigh_nodes(pair, used, x, nodes)
      call take_history(pair%old_nodes, pair%nodes, nodes)
    else
      call weigh_points(pair, used, x, nodes)
      call take_point_history(pair, x_old, nodes)
    end if
  end subroutine weigh_pair

  !> Rows and frames of the points of a pair with its bodies at x. Slip is what lies between a point
  !! and its apex; a point that was open has none yet.
  pure subroutine weigh_points(pair, used, x, nodes)
    type(pair_t), intent(in) :: pair !! points, targets and apexes
    logical, intent(in) :: used(:) !! (points) that count
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(mortar_t), intent(out) :: nodes !! gets all but forces and history
    type(under_t) :: under(size(used))
    logical :: near(size(used))
    integer :: p, i, e, most

    near = used
    do p = 1, size(used)
      if (.not. used(p)) cycle
      call look_under(pair, p, x, under(p))
      if (pair%points%cell > 0.0_wp) near(p) = under(p)%gap <= far_away*pair%points%cell
    end do
    nodes%n = count(near)
    most = nodes%n*(pair%points%n_slaves + 6)
    associate (n => nodes%n)
      allocate (nodes%node(n), nodes%face(n), nodes%weight(n), nodes%offset(n), &
        nodes%compliance(n), nodes%frame(3, 3, n), nodes%first(n + 1), nodes%column(most), &
        nodes%now(most), nodes%before(most))
    end associate
    allocate (nodes%owner(3, size(used)), source=0)
    allocate (nodes%share(3, size(used)), source=0.0_wp)
    i = 0
    e = 0
    nodes%first(1) = 1
    do p = 1, size(used)
      if (.not. near(p)) cycle
      i = i + 1
      nodes%owner(1, p) = i
      nodes%share(1, p) = 1.0_wp
      nodes%node(i) = pair%points%point_nodes(1, p)
      nodes%face(i) = p
      nodes%weight(i) = 0.0_wp
      if (allocated(pair%points%area)) nodes%weight(i) = pair%points%area(p)
      nodes%offset(i) = withheld_gap(pair, p)
      nodes%compliance(i) = 1.0_wp/pair%points%epsilon(p)
      nodes%frame(:, :, i) = frame_of(under(p)%normal, under(p)%axis)
      associate (m => pair%points%n_slaves, k => under(p)%n)
        nodes%column(e + 1:e + m) = pair%points%point_nodes(:, p)
        nodes%now(e + 1:e + m) = 1.0_wp
        if (m > 1) nodes%now(e + 1:e + m) = pair%points%point_weights(:, p)
        nodes%before(e + 1:e + m) = nodes%now(e + 1:e + m)
        nodes%column(e + m + 1:e + m + k) = under(p)%node(:k)
        nodes%now(e + m + 1:e + m + k) = -under(p)%now(:k)
        nodes%before(e + m + 1:e + m + k) = -under(p)%before(:k)
        e = e + m + k
      end associate
      nodes%first(i + 1) = e + 1
    end do
    nodes%column = nodes%column(:e)
    nodes%now = nodes%now(:e)
    nodes%before = nodes%before(:e)
  end subroutine weigh_points

  !> History of the points, and forces to begin with: those of the last iterate, or those that the
  !! penalty has at the last converged state.
  pure subroutine take_point_history(pair, x_old, nodes)
    type(pair_t), intent(in) :: pair !! points, and the rows of the last iterate
    real(wp), intent(in) :: x_old(:, :) !! (3, nodes) last converged positions [length]
    type(mortar_t), intent(inout) :: nodes !! weighed; gets forces and history
    real(wp) :: gap(3)
    integer :: i, j, e

    associate (n => nodes%n)
      allocate (nodes%force(3, n), nodes%way(3, n), nodes%gap(3, n), nodes%from(3, n), &
        source=0.0_wp)
      allocate (nodes%path(n), nodes%dissipation(n), nodes%criterion(n), source=0.0_wp)
      allocate (nodes%status(n), source=status_open)
      allocate (nodes%waits(n), nodes%new(n), source=.false.)
    end associate
    do i = 1, nodes%n
      associate (point => pair%history%new(nodes%face(i)))
        nodes%path(i) = point%path
        nodes%new(i) = point%status <= status_open
      end associate
      if (nodes%new(i)) nodes%from(1, i) = 1.0_wp
      j = 0
      if (allocated(pair%nodes%owner)) j = pair%nodes%owner(1, nodes%face(i))
      if (j > 0) then
        nodes%force(:, i) = pair%nodes%force(:, j)
        nodes%status(i) = pair%nodes%status(j)
      else if (.not. nodes%new(i)) then
        gap = 0.0_wp
        do e = nodes%first(i), nodes%first(i + 1) - 1
          gap = gap + nodes%before(e)*(x_old(:, nodes%column(e)) - x_old(:, nodes%node(i)))
        end do
        gap = gap + nodes%offset(i)*nodes%frame(:, 3, i)
        if (dot_product(gap, nodes%frame(:, 3, i)) < 0.0_wp) nodes%force(:, i) = &
          -gap/nodes%compliance(i)
      end if
    end do
  end subroutine take_point_history

  !> Hands what the rows have found to the points: status, way, work, and where apexes are now. They
  !! stay where points stick; else they lie an elastic slip behind.
  pure subroutine keep_points(pair, x)
    type(pair_t), intent(inout) :: pair !! rows, converged; history gets new
    real(wp), intent(in) :: x(:, :) !! (3, nodes) converged positions [length]
    real(wp) :: slip(3), gap
    integer :: p, i

    associate (nodes => pair%nodes)
      do p = 1, size(nodes%owner, 2)
        i = nodes%owner(1, p)
        associate (point => pair%history%new(p))
          point%status = status_off
          if (point%target == 0) cycle
          point%status = status_open
          if (i > 0) point%status = nodes%status(i)
          if (point%status <= status_open) then
            point%path = 0.0_wp
            point%way = 0.0_wp
            cycle
          end if
          slip = matmul(nodes%frame(:, 1:2, i), nodes%gap(1:2, i)) + nodes%compliance(i) &
            *tangential(nodes%force(:, i), nodes%frame(:, 3, i))
          if (point%status == status_slip) then
            point%path = point%path + norm2(slip)
            point%way = point%way + slip
            point%dissipation = point%dissipation - dot_product(nodes%force(:, i), slip)
          else if (.not. nodes%new(i)) then
            cycle
          end if
          call project_on_master(pair, point%target, x, point_position(pair, p, x) &
            + nodes%compliance(i)*tangential(nodes%force(:, i), nodes%frame(:, 3, i)), point%apex, &
            gap)
        end associate
      end do
    end associate
  end subroutine keep_points

  !> Part of a vector across a unit normal.
  pure function tangential(v, n)
    real(wp), intent(in) :: v(3), n(3) !! the vector, the normal
    real(wp) :: tangential(3)

    tangential = v - dot_product(v, n)*n
  end function tangential
end module mortar_points

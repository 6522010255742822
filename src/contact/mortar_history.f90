!> What multipliers remember from one state to the next, and what points show of them (doc/theory,
!! "Mortar contact", eq. (7.15)).
module mortar_history
  use kinds, only: wp
  use element_types, only: status_off, status_open, status_stick, status_slip
  use contact_types, only: pair_t
  use contact_cells, only: forget_first_cells
  use mortar_types, only: mortar_t, same_multiplier
  use slave_places, only: cell_position
  use smooth_normals, only: project_on_master
  implicit none
  private
  public :: take_history, take_forces, add_forces, show_points, settle_mortar

  !> A closed multiplier with less than this share of the largest force carries nothing that means
  !! anything: whether it is closed at all is chance, as with a node that supports hold.
  real(wp), parameter :: idle_share = 1.0e-12_wp

contains

  !> History of new multipliers from the last converged state, and forces to begin with from the
  !! last iterate.
  pure subroutine take_history(old, last, nodes)
    type(mortar_t), intent(in) :: old !! last converged state
    type(mortar_t), intent(in) :: last !! last iterate, maybe of other multipliers
    type(mortar_t), intent(inout) :: nodes !! weighed; gets forces and history
    integer :: i, j

    associate (n => nodes%n)
      allocate (nodes%force(3, n), nodes%way(3, n), nodes%gap(3, n), nodes%from(3, n), &
        source=0.0_wp)
      allocate (nodes%path(n), nodes%dissipation(n), nodes%criterion(n), source=0.0_wp)
      allocate (nodes%status(n), source=status_open)
      allocate (nodes%waits(n), source=.false.)
      allocate (nodes%new(n), source=.true.)
    end associate
    nodes%from(1, :) = 1.0_wp
    do i = 1, nodes%n
      j = same_multiplier(old, nodes%node(i), nodes%face(i))
      if (j > 0) then
        nodes%new(i) = old%status(j) <= status_open
        nodes%path(i) = old%path(j)
        nodes%way(:, i) = old%way(:, j)
        nodes%dissipation(i) = old%dissipation(j)
        nodes%force(:, i) = old%force(:, j)
        nodes%status(i) = old%status(j)
      end if
      j = same_multiplier(last, nodes%node(i), nodes%face(i))
      if (j > 0) nodes%force(:, i) = last%force(:, j)
    end do
    if (nodes%n == 0) return
    ! the work of multipliers that are no more is kept
    do j = 1, old%n
      if (same_multiplier(nodes, old%node(j), old%face(j)) > 0) cycle
      i = max(1, findloc(nodes%node, old%node(j), 1))
      nodes%dissipation(i) = nodes%dissipation(i) + old%dissipation(j)
    end do
  end subroutine take_history

  !> Forces, gaps and status of the multipliers from the solution along their frames.
  pure subroutine take_forces(force, gap, closed, slips, criterion, nodes)
    real(wp), intent(in) :: force(:) !! (3 n) along the frames [force]
    real(wp), intent(in) :: gap(:) !! (3 n) slip and gap [length]
    logical, intent(in) :: closed(:) !! (n)
    logical, intent(in) :: slips(:) !! (n)
    real(wp), intent(in) :: criterion(:) !! (n) [force]
    type(mortar_t), intent(inout) :: nodes !! gets them
    logical :: carries(nodes%n)
    integer :: i

    do i = 1, nodes%n
      nodes%force(:, i) = matmul(nodes%frame(:, :, i), force(3*i - 2:3*i))
    end do
    carries = closed .and. force(3::3) > idle_share*maxval([0.0_wp, abs(force)])
    ! what a penalty lets in is not slip or gap of the surfaces, but their depth and elastic slip
    nodes%gap = reshape(gap - reshape(spread(nodes%compliance, 1, 3), [3*nodes%n])*force, [3, &
      nodes%n])
    nodes%status = merge(merge(status_slip, status_stick, slips), status_open, carries)
    nodes%criterion = criterion
  end subroutine take_forces

  !> Adds the forces of the multipliers, as internal forces, to those of the nodes, eq. (7.13).
  pure subroutine add_forces(nodes, forces)
    type(mortar_t), intent(in) :: nodes !! weighed, with forces
    real(wp), intent(inout) :: forces(:, :) !! (3, nodes) of contact [force]
    integer :: i, e

    do i = 1, nodes%n
      do e = nodes%first(i), nodes%first(i + 1) - 1
        associate (at => forces(:, nodes%column(e)))
          at = at - nodes%now(e)*nodes%force(:, i)
        end associate
      end do
    end do
  end subroutine add_forces

  !> Points do what the nearest closed multiplier around them does.
  pure subroutine show_points(pair, status, slip)
    type(pair_t), intent(in) :: pair !! its multipliers, owners of the points
    integer, intent(inout) :: status(:) !! (points) gets theirs
    real(wp), intent(inout) :: slip(:, :) !! (3, points) gets theirs, in space [length]
    real(wp) :: most
    integer :: p, k

    do p = 1, size(status)
      if (status(p) == status_off) cycle
      most = -huge(1.0_wp)
      status(p) = status_open
      do k = 1, 3
        associate (i => pair%nodes%owner(k, p))
          if (i == 0) cycle
          if (pair%nodes%status(i) <= status_open .or. pair%nodes%share(k, p) <= most) cycle
          most = pair%nodes%share(k, p)
          status(p) = pair%nodes%status(i)
          slip(:, p) = matmul(pair%nodes%frame(:, 1:2, i), pair%nodes%gap(1:2, i))
        end associate
      end do
    end do
  end subroutine show_points

  !> Makes the converged state the history: what has slipped, and what friction has taken, and
  !! where apexes are: below their points, for multipliers stick without elastic slip.
  pure subroutine settle_mortar(pair, status, x)
    type(pair_t), intent(inout) :: pair !! multipliers and points become the old ones
    integer, intent(in) :: status(:) !! (points) of the contact elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) converged positions [length]
    integer :: p
    real(wp) :: gap

    call add_slip(pair%nodes)
    do p = 1, size(pair%history%new)
      associate (point => pair%history%new(p), own => pair%nodes%owner(:, p))
        point%status = status(p)
        point%path = 0.0_wp
        point%way = 0.0_wp
        point%dissipation = 0.0_wp
        if (point%target == 0) point%status = status_off
        if (all(own > 0)) then
          point%path = sum(pair%nodes%path(own))/3.0_wp
          point%way = sum(pair%nodes%way(:, own), 2)/3.0_wp
          point%dissipation = dot_product(pair%nodes%share(:, p), pair%nodes%dissipation(own))
        end if
        if (point%target > 0) call project_on_master(pair, point%target, x, cell_position(pair, &
          pair%history%cells(p), x), point%apex, gap)
      end associate
    end do
    pair%history%old = pair%history%new
    pair%history%old_cells = pair%history%cells
    pair%old_nodes = pair%nodes
    call forget_first_cells(pair)
  end subroutine settle_mortar

  !> Adds the slip of the increment to what multipliers remember (doc/theory, "Dissipation").
  pure subroutine add_slip(nodes)
    type(mortar_t), intent(inout) :: nodes !! converged
    real(wp) :: slip(3)
    integer :: i

    do i = 1, nodes%n
      if (nodes%status(i) <= status_open) then
        nodes%path(i) = 0.0_wp
        nodes%way(:, i) = 0.0_wp
        cycle
      end if
      if (nodes%status(i) /= status_slip) cycle
      slip = matmul(nodes%frame(:, 1:2, i), nodes%gap(1:2, i))
      nodes%path(i) = nodes%path(i) + norm2(slip)
      nodes%way(:, i) = nodes%way(:, i) + slip
      nodes%dissipation(i) = nodes%dissipation(i) - dot_product(nodes%force(:, i), slip)
    end do
  end subroutine add_slip
end module mortar_history

!> First touches of slave nodes with multipliers: their slip counts from where their way meets the
!! master (doc/theory, "Contact initiation").
module mortar_touch
  use kinds, only: wp
  use model_types, only: model_t
  use contact_types, only: pair_t
  use mortar_types, only: mortar_t, same_multiplier
  use mortar_points, only: weigh_pair
  use contact_types, only: forget_moves
  use element_types, only: status_open, routine_none
  use costs, only: cost_t, count_cost, cost_touch
  use first_touch, only: find_free_way
  use touch_path, only: way_before, closing_time
  use system_types, only: system_t
  implicit none
  private
  public :: find_touched, place_new

  !> A gap below this share of the width of a node's weight is none.
  real(wp), parameter :: touching = 1.0e-9_wp

contains

  !> After the pass without friction: whether nodes have touched that it waits for, and when the
  !! first of each body did.
  subroutine find_touched(model, system, costs, touched)
    type(model_t), intent(inout) :: model !! pairs with their multipliers; moves of cells count anew
    type(system_t), intent(inout) :: system !! touch gets ways and first touches
    type(cost_t), intent(inout) :: costs !! cost table
    logical, intent(out) :: touched !! some have
    real(wp), allocatable :: gap(:)
    integer :: k, i, body

    touched = .false.
    do k = 1, size(model%pairs)
      associate (nodes => model%pairs(k)%nodes)
        touched = touched .or. any(nodes%waits .and. nodes%status > status_open)
      end associate
    end do
    if (.not. touched) return
    call count_cost(costs, cost_touch, 1)
    system%touch%x_end = system%position%x_now
    call find_free_way(model, system%equation, system%touch, system%body, system%position)
    do k = 1, size(model%pairs)
      ! cells that facets have left without friction do not bind
      call forget_moves(model%pairs(k))
      system%touch%start(:, k) = merge(1.0_wp, 0.0_wp, system%touch%empty(:, k))
      associate (nodes => model%pairs(k)%nodes)
        gap = gaps_before(model%pairs(k), k, system, nodes)
        do i = 1, nodes%n
          if (.not. nodes%waits(i) .or. nodes%status(i) <= status_open) cycle
          body = system%body%node_body(nodes%node(i))
          if (.not. system%touch%empty(body, k)) cycle
          ! bodies count from 0: a name for this column would count them from 1
          associate (start => system%touch%start(body, k))
            start = min(start, touch_time(nodes, i, gap(i), system))
            if (system%body%floating(body)) start = 0.0_wp
          end associate
        end do
      end associate
    end do
  end subroutine find_touched

  !> When the free way of a node meets the master, as a share of the increment, by eq. (10.7).
  pure real(wp) function touch_time(nodes, i, gap, system) result(time)
    type(mortar_t), intent(in) :: nodes !! weighed multipliers
    integer, intent(in) :: i !! one of them
    real(wp), intent(in) :: gap !! its gap at the begin of the increment [length]
    type(system_t), intent(in) :: system !! positions

    time = closing_time(gap, gap_at(nodes, i, system%touch%x_free), touching*sqrt(nodes%weight(i)))
  end function touch_time

  !> Weighted gaps at the begin of the increment by the weights and normals of then: those of now
  !! have turned, and see a gap of second order where bodies touch. What was too far away for
  !! weights of then has those of now.
  pure function gaps_before(pair, k, system, nodes) result(gap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: k !! its number
    type(system_t), intent(in) :: system !! contact elements, positions
    type(mortar_t), intent(in) :: nodes !! weighed multipliers
    real(wp) :: gap(nodes%n)
    type(mortar_t) :: old
    integer :: i, j

    associate (x_old => system%position%x_old, first => system%place%first_point(k), &
      last => system%place%first_point(k + 1) - 1)
      call weigh_pair(pair, system%contact%routine(first:last) /= routine_none, x_old, x_old, old)
      do i = 1, nodes%n
        j = same_multiplier(old, nodes%node(i), nodes%face(i))
        if (j > 0) then
          gap(i) = gap_at(old, j, x_old)
        else
          gap(i) = gap_at(nodes, i, x_old)
        end if
      end do
    end associate
  end function gaps_before

  !> Weighted gap of a multiplier with the nodes at x.
  pure real(wp) function gap_at(nodes, i, x) result(gap)
    type(mortar_t), intent(in) :: nodes !! weighed multipliers
    integer, intent(in) :: i !! one of them
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: e

    gap = nodes%offset(i)
    do e = nodes%first(i), nodes%first(i + 1) - 1
      gap = gap + nodes%now(e)*dot_product(x(:, nodes%column(e)) - x(:, nodes%node(i)), &
        nodes%frame(:, 3, i))
    end do
  end function gap_at

  !> Nodes that were open have no place on the master from before: their slip is the way over what
  !! lies below them now, from where they touch by eqs. (10.5), (10.8).
  pure subroutine place_new(pair, system, k, waits, nodes)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! touches
    integer, intent(in) :: k !! number of the pair
    logical, intent(in) :: waits !! friction waits where they were open
    type(mortar_t), intent(inout) :: nodes !! weighed; gets from, waits
    real(wp), allocatable :: gap(:)
    real(wp) :: t, start, last
    integer :: i, body

    if (.not. waits .and. allocated(system%touch%x_end)) gap = gaps_before(pair, k, system, nodes)
    do i = 1, nodes%n
      if (.not. nodes%new(i)) cycle
      nodes%before(nodes%first(i):nodes%first(i + 1) - 1) = &
        nodes%now(nodes%first(i):nodes%first(i + 1) - 1)
      if (.not. (waits .or. allocated(system%touch%x_end))) cycle
      body = system%body%node_body(nodes%node(i))
      if (.not. system%touch%waits(body, k)) cycle
      nodes%waits(i) = waits
      if (waits) cycle
      t = way_before(system%touch, body, k, touch_time(nodes, i, gap(i), system))
      start = system%touch%start(body, k)
      last = 0.0_wp
      if (t > start) last = (t - start)/(1.0_wp - start)
      nodes%from(:, i) = [1.0_wp - min(t, start), min(t, start), 0.0_wp]*(1.0_wp - last) &
        + [0.0_wp, 0.0_wp, last]
    end do
  end subroutine place_new
end module mortar_touch

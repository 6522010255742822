!> First touch (doc/theory, "Contact initiation"): what counts as slip of a point that was open is
!! its way after it has met the surface. The increment is solved without friction at such points
!! first; that tells which of them touch, and with the free motion where the way of each meets the
!! surface. In more than 400 lines, since its stages share what an increment knows of touches.
module first_touch
  use kinds, only: wp
  use costs, only: cost_t, count_cost, cost_touch
  use element_types, only: status_open, status_stick, routine_none
  use element_lists, only: element_list_t
  use element_parameters, only: d03_mu
  use friction_return, only: has_friction
  use model_types, only: model_t
  use contact_types, only: pair_t, master_surface_t, contact_point_t, forget_moves
  use contact_points, only: count_points, first_cell, lay_behind, point_position
  use contact_cells, only: cut_touched
  use slave_places, only: cell_position
  use smooth_normals, only: project_on_master, bend
  use facet_geometry, only: corners, facet_frame, facet_size
  use predictor, only: carry_bodies
  use touch_path, only: touch_time, way_before, first_target, meet
  use touch_types, only: touch_none, touch_waits, touch_known, touch_t
  use system_types, only: system_t, state_t
  use system_parts, only: bodies_t, contact_places_t, positions_t
  implicit none
  private
  public :: begin_touch, begin_touch_again, withhold_friction, find_touches, place_touches, &
    keep_path, find_free_way

  !> A gap below this share of the facet's size is none.
  real(wp), parameter :: touching = 1.0e-9_wp

contains

  !> Chooses the points at which friction waits in the first pass of an increment.
  subroutine begin_touch(model, position, body, held, span, touch)
    type(model_t), intent(in) :: model !! pairs with their last converged state
    type(positions_t), intent(in) :: position !! positions of the nodes
    type(bodies_t), intent(in) :: body !! connected bodies
    logical, intent(in) :: held(0:) !! (0:bodies) supports and normals of contact hold it
    real(wp), intent(in) :: span !! length of the increment [time]
    type(touch_t), intent(inout) :: touch !! gets stage, waits, empty, start
    integer :: k

    touch%stage = touch_none
    touch%span = span
    if (allocated(touch%x_free)) deallocate (touch%x_free, touch%x_end)
    if (.not. any([(rubs(model%pairs(k)), k=1, size(model%pairs))])) return
    if (allocated(touch%waits)) deallocate (touch%waits, touch%empty, touch%start)
    associate (bodies => body%bodies, pairs => size(model%pairs))
      allocate (touch%waits(0:bodies, pairs), touch%empty(0:bodies, pairs), source=.false.)
      allocate (touch%start(0:bodies, pairs), source=0.0_wp)
    end associate
    do k = 1, size(model%pairs)
      if (rubs(model%pairs(k))) call look_at_pair(model%pairs(k), position, body, held, k, touch)
    end do
    if (any([(waits_somewhere(model%pairs(k), touch, body, k), k=1, size(model%pairs))])) &
      touch%stage = touch_waits
  end subroutine begin_touch

  !> A slave body of a pair waits for its first touch. Bodies without points in it have none: where
  !! there are no others a first pass without friction would be the second one.
  pure logical function waits_somewhere(pair, touch, body, k) result(waits)
    type(pair_t), intent(in) :: pair !! the pair
    type(touch_t), intent(in) :: touch !! waits
    type(bodies_t), intent(in) :: body !! connected bodies
    integer, intent(in) :: k !! number of the pair

    if (pair%segmented) then
      waits = any(touch%waits(body%node_body(pair%points%slave_facets(1, :)), k))
    else
      waits = any(touch%waits(body%node_body(pair%points%point_nodes(1, :)), k))
    end if
  end function waits_somewhere

  !> A pair with friction.
  pure logical function rubs(pair)
    type(pair_t), intent(in) :: pair !! the pair

    rubs = any(has_friction(pair%friction%mu))
  end function rubs

  !> A point was closed without a depth: it has carried no force, and not slipped.
  pure logical function barely(pair, position, p)
    type(pair_t), intent(in) :: pair !! the pair
    type(positions_t), intent(in) :: position !! positions of the nodes
    integer, intent(in) :: p !! the point, with a target
    real(wp) :: xi(2), gap, least, epsilon

    least = touching*facet_size(position%x_old(:, pair%surface%facets(:, &
      pair%history%old(p)%target)))
    if (pair%segmented) then
      epsilon = pair%points%density*pair%history%old_cells(p)%area
    else
      epsilon = pair%points%epsilon(p)
    end if
    barely = norm2(pair%history%old(p)%lambda) <= epsilon*least
    if (.not. barely) return
    call project_on_master(pair, pair%history%old(p)%target, position%x_old, &
      old_place(pair, position, p), xi, gap)
    barely = abs(gap) <= least
  end function barely

  !> Where a point was at the last converged state.
  pure function old_place(pair, position, p) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    type(positions_t), intent(in) :: position !! positions
    integer, intent(in) :: p !! the point
    real(wp) :: y(3)

    if (pair%segmented) then
      y = cell_position(pair, pair%history%old_cells(p), position%x_old)
    else
      y = point_position(pair, p, position%x_old)
    end if
  end function old_place

  !> Friction waits where a slave body touches nothing of the pair yet, or no more than that, or
  !! sticks to it somewhere. Where all closed points slip a new one slips at once; other bodies may
  !! need the friction of the new points.
  subroutine look_at_pair(pair, position, bodies, held, k, touch)
    type(pair_t), intent(in) :: pair !! the pair
    type(positions_t), intent(in) :: position !! positions of the nodes
    type(bodies_t), intent(in) :: bodies !! connected bodies
    logical, intent(in) :: held(0:) !! (0:bodies) bodies that need no friction
    integer, intent(in) :: k !! number of the pair
    type(touch_t), intent(inout) :: touch !! gets waits and empty
    integer :: p, body
    logical :: sticks(0:bodies%bodies), slides(0:bodies%bodies)

    sticks = .false.
    slides = .false.
    touch%empty(:, k) = .true.
    do p = 1, size(pair%history%old)
      if (pair%history%old(p)%status <= status_open) cycle
      body = old_body(pair, bodies, p)
      touch%empty(body, k) = .false.
      if (pair%history%old(p)%status == status_stick) sticks(body) = .true.
      if (.not. (sticks(body) .or. slides(body))) slides(body) = .not. barely(pair, position, p)
    end do
    touch%waits(:, k) = (sticks .or. .not. slides) .and. held &
      .and. all(held(bodies%node_body(pair%surface%facets(1, :))))
    if (any(bodies%floating) .and. any(touch%waits(:, k))) call mark_resting(pair, touch, bodies, &
      position, k)
  end subroutine look_at_pair

  !> A body that contact alone holds and that lies on its master already, without a force so far,
  !! has touched it: all its way comes after the touch.
  subroutine mark_resting(pair, touch, bodies, position, k)
    type(pair_t), intent(in) :: pair !! the pair
    type(touch_t), intent(inout) :: touch !! first touches of the increment
    type(bodies_t), intent(in) :: bodies !! connected bodies
    type(positions_t), intent(in) :: position !! positions of the nodes
    integer, intent(in) :: k !! number of the pair
    real(wp) :: xi(2), gap
    integer :: p, body

    do p = 1, size(pair%history%old)
      if (pair%history%old(p)%target == 0) cycle
      body = old_body(pair, bodies, p)
      associate (facet => pair%surface%facets(:, pair%history%old(p)%target))
        if (.not. (touch%waits(body, k) .and. touch%empty(body, k))) cycle
        if (.not. any(bodies%floating([body, bodies%node_body(facet(1))]))) cycle
        call project_on_master(pair, pair%history%old(p)%target, position%x_old, &
          old_place(pair, position, p), xi, gap)
        if (abs(gap) <= touching*facet_size(position%x_old(:, facet))) then
          touch%waits(body, k) = .false.
        end if
      end associate
    end do
  end subroutine mark_resting

  !> The slave body of a point of the last converged state.
  pure integer function old_body(pair, body, p) result(number)
    type(pair_t), intent(in) :: pair !! the pair
    type(bodies_t), intent(in) :: body !! bodies of the nodes
    integer, intent(in) :: p !! the point

    if (pair%segmented) then
      number = body%node_body(pair%points%slave_facets(1, max(1, pair%history%old_cells(p)%slave)))
    else
      number = body%node_body(pair%points%point_nodes(1, p))
    end if
  end function old_body

  !> Another try of the same increment. If the first pass has led nowhere, there is none: friction
  !! acts everywhere, and the apexes of open points stay where they were last.
  subroutine begin_touch_again(touch)
    type(touch_t), intent(inout) :: touch !! touch

    touch%stage = merge(touch_waits, touch_none, touch%stage == touch_known)
  end subroutine begin_touch_again

  !> Takes friction away from the elements at which it waits.
  subroutine withhold_friction(model, place, touch, body, contact)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    type(touch_t), intent(in) :: touch !! where friction waits
    type(bodies_t), intent(in) :: body !! bodies of the nodes
    type(element_list_t), intent(inout) :: contact !! contact elements made
    integer :: k, p, element

    if (touch%stage /= touch_waits) return
    do k = 1, size(model%pairs)
      if (.not. any(touch%waits(:, k))) cycle
      do p = 1, count_points(model%pairs(k))
        element = place%first_point(k) + p - 1
        if (contact%routine(element) == routine_none) cycle
        if (is_waiting(model%pairs(k), touch, body, k, p)) &
          contact%d(d03_mu:d03_mu + 1, element) = 0.0_wp
      end do
    end do
  end subroutine withhold_friction

  !> A working point was open at the last converged state, and its first touch counts.
  pure logical function is_waiting(pair, touch, body, k, p) result(waiting)
    type(pair_t), intent(in) :: pair !! the pair
    type(touch_t), intent(in) :: touch !! which bodies wait
    type(bodies_t), intent(in) :: body !! bodies of the nodes
    integer, intent(in) :: k !! number of the pair
    integer, intent(in) :: p !! the point

    waiting = .false.
    if (.not. touch%waits(body%node_body(pair%points%point_nodes(1, p)), k)) return
    if (pair%segmented) then
      waiting = was_open(pair, p)
    else
      waiting = pair%history%old(p)%status <= status_open
    end if
  end function is_waiting

  !> A point of a segmented pair was open: the closest point that its facet had then was.
  pure logical function was_open(pair, p) result(open)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp) :: distance, least
    integer :: q

    open = .true.
    least = huge(1.0_wp)
    do q = first_cell(pair%history%old_cells, pair%history%cells(p)%slave), &
      size(pair%history%old_cells)
      if (q == 0) return
      if (pair%history%old_cells(q)%slave /= pair%history%cells(p)%slave) return
      distance = norm2(pair%history%old_cells(q)%weight - pair%history%cells(p)%weight)
      if (distance >= least .or. lay_behind(pair, q)) cycle
      least = distance
      open = pair%history%old(q)%status <= status_open
    end do
  end function was_open

  !> After a pass that has converged: if points that friction waits for are closed, their ways are
  !! known now, and the increment is to be solved again with friction everywhere.
  subroutine find_touches(model, system, costs, touches)
    type(model_t), intent(inout) :: model !! pairs: start apexes of new points
    type(system_t), intent(inout) :: system !! converged; gets touch
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: touches !! points that have touched
    integer :: k, p

    touches = 0
    if (system%touch%stage /= touch_waits) return
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        if (system%contact%status(system%place%first_point(k) + p - 1) <= status_open) cycle
        if (is_waiting(model%pairs(k), system%touch, system%body, k, p)) touches = touches + 1
      end do
    end do
    if (touches == 0) return
    call count_cost(costs, cost_touch, 1)
    system%touch%x_end = system%position%x_now
    call find_free_way(model, system%equation, system%touch, system%body, system%position)
    do k = 1, size(model%pairs)
      if (any(system%touch%waits(:, k))) then
        if (model%pairs(k)%smooth) call find_shapes(model%pairs(k)%surface, system)
        if (allocated(model%pairs(k)%points%side%patch)) &
          call find_shapes(model%pairs(k)%points%side, system)
        system%touch%start(:, k) = start_of(model%pairs(k), system, k)
      end if
      ! targets that points have left without friction do not bind
      call forget_moves(model%pairs(k))
    end do
    system%touch%stage = touch_known
    call place_touches(model, system, .true.)
    call cut_where_touched(model, system)
  end subroutine find_touches

  !> Segmented pairs: the facets that touch are cut where they do, and their new points get their
  !! start apexes in turn.
  subroutine cut_where_touched(model, system)
    type(model_t), intent(inout) :: model !! pairs: cells, start apexes
    type(system_t), intent(in) :: system !! touch known
    integer :: k, p, changes

    changes = 0
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (.not. (pair%segmented .and. any(system%touch%waits(:, k)))) cycle
        call cut_touched(pair, [(is_waiting(pair, system%touch, system%body, k, p), p=1, &
          count_points(pair))], system%position%x_old, meeting_place(system, k), changes)
      end associate
    end do
    if (changes > 0) call place_touches(model, system, .false.)
  end subroutine cut_where_touched

  !> Where all nodes are when the first body of a pair touches.
  pure function meeting_place(system, k) result(x)
    type(system_t), intent(in) :: system !! touch known
    integer, intent(in) :: k !! the pair
    real(wp) :: x(3, size(system%position%x_old, 2))
    real(wp) :: share

    share = min(1.0_wp, minval(system%touch%start(:, k), system%touch%waits(:, k)))
    x = system%position%x_old + share*(system%touch%x_free - system%position%x_old)
  end function meeting_place

  !> Where all nodes would be if nothing touched: they go on as in the last increment, and differ
  !! from that as the bodies carried rigidly do.
  subroutine find_free_way(model, equation, touches, body, position)
    type(model_t), intent(in) :: model !! mesh
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(touch_t), intent(inout) :: touches !! first touches of the increment; gets x_free
    type(bodies_t), intent(in) :: body !! connected bodies
    type(positions_t), intent(in) :: position !! positions of the nodes
    real(wp), allocatable :: u(:, :), u_old(:, :)
    real(wp) :: ratio

    associate (touch => touches, x => model%mesh%x)
      touch%x_free = position%x_ahead
      if (allocated(position%x_alone)) touch%x_free = position%x_alone
      if (.not. allocated(touch%u_before) .or. touch%span_before <= 0.0_wp) return
      ratio = touch%span/touch%span_before
      u_old = position%x_old - x
      u = touch%u_before
      where (equation == 0) u = u_old
      call carry_bodies(x, equation, body%node_body, body%bodies, touch%u_before, u)
      touch%x_free = touch%x_free + ratio*(u_old - u)
    end associate
  end subroutine find_free_way

  !> Patches of smooth surfaces along the way.
  pure subroutine find_shapes(surface, system)
    type(master_surface_t), intent(inout) :: surface !! one side of a pair: gets patch_way
    type(system_t), intent(in) :: system !! positions, touch with its free way
    real(wp) :: present(size(surface%patch, 1), size(surface%patch, 2))

    present = surface%patch
    if (.not. allocated(surface%patch_way)) &
      allocate (surface%patch_way(size(present, 1), size(present, 2), 3))
    call bend(surface, system%position%x_old)
    surface%patch_way(:, :, 1) = surface%patch
    call bend(surface, system%touch%x_free)
    surface%patch_way(:, :, 2) = surface%patch
    call bend(surface, system%touch%x_end)
    surface%patch_way(:, :, 3) = surface%patch
    surface%patch = present
  end subroutine find_shapes

  !> When each slave body comes to its first touch, as a share of the increment.
  function start_of(pair, system, k) result(start)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! touch with its free way
    integer, intent(in) :: k !! number of the pair
    real(wp) :: start(0:system%body%bodies)
    integer :: p, body

    start = merge(1.0_wp, 0.0_wp, system%touch%empty(:, k))
    do p = 1, count_points(pair)
      if (system%contact%status(system%place%first_point(k) + p - 1) <= status_open) cycle
      if (.not. is_waiting(pair, system%touch, system%body, k, p)) cycle
      body = system%body%node_body(pair%points%point_nodes(1, p))
      if (.not. system%touch%empty(body, k)) cycle
      if (body > 0) then
        ! what nothing holds falls at once
        if (system%body%floating(body)) start(body) = 0.0_wp
      end if
      start(body) = min(start(body), touch_time(pair, system%touch, system%position%x_old, p))
    end do
  end function start_of

  !> Start apexes of the points that were open: where their ways meet the surface.
  subroutine place_touches(model, system, all_points)
    type(model_t), intent(inout) :: model !! pairs: apexes and targets of working points
    type(system_t), intent(in) :: system !! touch known
    logical, intent(in) :: all_points !! else only those of segmented pairs, which may be new
    integer :: k, p

    if (system%touch%stage /= touch_known) return
    do k = 1, size(model%pairs)
      if (.not. any(system%touch%waits(:, k))) cycle
      if (.not. (all_points .or. model%pairs(k)%segmented)) cycle
      do p = 1, count_points(model%pairs(k))
        if (model%pairs(k)%history%new(p)%target == 0) cycle
        if (is_waiting(model%pairs(k), system%touch, system%body, k, p)) &
          call place_touch(model%pairs(k), system, k, p)
      end do
    end do
  end subroutine place_touches

  !> Start apex of one point.
  subroutine place_touch(pair, system, k, p)
    type(pair_t), intent(inout) :: pair !! the pair: its working point
    type(system_t), intent(in) :: system !! touch known
    integer, intent(in) :: k !! number of the pair
    integer, intent(in) :: p !! the point
    type(contact_point_t) :: point
    real(wp) :: start, time, gap

    point = pair%history%new(p)
    start = system%touch%start(system%body%node_body(pair%points%point_nodes(1, p)), k)
    time = way_before(system%touch, system%body%node_body(pair%points%point_nodes(1, p)), k, &
      touch_time(pair, system%touch, system%position%x_old, p))
    point%target = first_target(pair, p)
    call meet(pair, system%touch, start, system%position%x_old, p, time, point, gap)
    associate (before => pair%surface%facets(:, pair%history%new(p)%target), &
      here => pair%surface%facets(:, point%target), x => system%position%x_old)
      if (point%target /= pair%history%new(p)%target) point%lambda = matmul(matmul(facet_frame( &
        corners(x, before)), point%lambda), facet_frame(corners(x, here)))
    end associate
    pair%history%new(p) = point
    pair%history%start(p) = point
  end subroutine place_touch

  !> The state before an increment that is accepted tells the next one how bodies move.
  subroutine keep_path(model, touch, state, time)
    type(model_t), intent(in) :: model !! pairs
    type(touch_t), intent(inout) :: touch !! touch
    type(state_t), intent(in) :: state !! the state before
    real(wp), intent(in) :: time !! end of the increment
    integer :: k

    if (.not. any([(rubs(model%pairs(k)), k=1, size(model%pairs))])) return
    touch%u_before = state%u
    touch%span_before = time - state%time
  end subroutine keep_path
end module first_touch

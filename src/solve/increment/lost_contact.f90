!> Whether Newton's iteration has found a spurious separated solution: under displacement control
!! the state in which nothing touches is an equilibrium, too (doc/theory, "Continuation").
module lost_contact
  use kinds, only: wp, pi
  use element_types, only: routine_none
  use model_types, only: model_t
  use contact_entries, only: has_gone_through
  use force_scales, only: force_scale
  use rigid_bodies, only: is_carried
  use body_measures, only: rigid_turns, has_small_strain, farthest_turn
  use monitors, only: monitor_t
  use newton_progress, only: newton_t, outcome_converged, outcome_through, outcome_turned, &
    outcome_thrown
  use system_types, only: form_t, system_t
  use system_parts, only: bodies_t, rigid_part_t
  implicit none
  private
  public :: has_thrown, find_turned, look_for_thrown, look_for_strays

  !> Contact forces on a body below this share of its loads, or of the forces of the increment if it
  !! has none, are none.
  real(wp), parameter :: no_force = 1.0e-6_wp
  !> A body that goes farther than this many times what it may touch does, and farther
  !! than this share of a facet, has not gone along.
  real(wp), parameter :: gone_along = 4.0_wp, off_share = 0.25_wp
  !> A body has been thrown, and does not roll, if this share of the turn that is too far for small
  !! strain was made in one increment.
  real(wp), parameter :: share_at_once = 0.5_wp

contains

  !> A body that contact alone holds has flown, and contact does nothing to it now. Each body is
  !! judged by itself and by what it may touch: forces and ways elsewhere say nothing of it.
  pure logical function has_thrown(model, system) result(thrown)
    type(model_t), intent(in) :: model !! pairs, reference positions
    type(system_t), intent(in) :: system !! converged; positions of the last state
    logical :: free(0:system%body%bodies)
    real(wp), dimension(0:system%body%bodies) :: way, others

    thrown = .false.
    if (.not. any(system%body%floating)) return
    call find_free(system, free)
    if (.not. any(free)) return
    call find_ways(model, system, way, others)
    call find_others(model, system%body, free, way, others)
    thrown = any(free .and. way > max(gone_along*others, off_share*system%scale%facet_size))
  end function has_thrown

  !> A body of small strain that supports do not hold has turned farther than a linear theory can
  !! mean, most of it in this increment; 0 if there is none. Its forces are no solution, whatever
  !! they balance: another start, or a shorter increment, may lead to one.
  subroutine find_turned(model, system, form, body, angle)
    type(model_t), intent(in) :: model !! reference positions
    type(system_t), intent(in) :: system !! converged; positions of the last state
    type(form_t), intent(in) :: form !! its kind answers
    integer, intent(out) :: body !! the body
    real(wp), intent(out) :: angle !! how far it has turned in all [degree]
    real(wp), dimension(3, system%body%bodies) :: turn, since
    logical :: small(0:system%body%bodies), known(size(system%body%node_body))
    integer :: b

    body = 0
    angle = 0.0_wp
    if (.not. any(system%body%floating)) return
    known = .true.
    if (associated(form%kind%placed_nodes)) call form%kind%placed_nodes(form, known)
    call rigid_turns(model%mesh%x, system%u, model%mesh%x + system%u - system%position%x_old, &
      system%body%node_body, known, turn, since)
    if (all(norm2(turn, 1) <= sin(farthest_turn))) return
    small = has_small_strain(system)
    do b = 1, system%body%bodies
      if (.not. (small(b) .and. system%body%floating(b))) cycle
      if (norm2(turn(:, b)) <= sin(farthest_turn)) cycle
      if (norm2(since(:, b)) <= share_at_once*sin(farthest_turn)) cycle
      body = b
      angle = asin(min(1.0_wp, norm2(turn(:, b))))*180.0_wp/pi
      return
    end do
  end subroutine find_turned

  !> There is such a body.
  logical function has_turned(model, system, form)
    type(model_t), intent(in) :: model !! reference positions
    type(system_t), intent(in) :: system !! converged; positions of the last state
    type(form_t), intent(in) :: form !! its kind answers
    real(wp) :: angle
    integer :: body

    call find_turned(model, system, form, body, angle)
    has_turned = body > 0
  end function has_turned

  !> Bodies that supports do not hold, and that contact does nothing to.
  pure subroutine find_free(system, free)
    type(system_t), intent(in) :: system !! contact forces, loads
    logical, intent(out) :: free(0:) !! (0:bodies)
    real(wp), dimension(0:system%body%bodies) :: force, load
    integer :: i

    force = 0.0_wp
    load = 0.0_wp
    do i = 1, size(system%body%node_body)
      associate (b => system%body%node_body(i))
        force(b) = max(force(b), norm2(system%contact_force(:, i)))
        load(b) = load(b) + norm2(system%loads%external(:, i))
      end associate
    end do
    where (load <= 0.0_wp) load = force_scale(system%scale)
    free(0) = .false.
    free(1:) = system%body%floating .and. force(1:) <= no_force*load(1:)
  end subroutine find_free

  !> How far each body has gone in this increment, by its nodes that are prescribed or that contact
  !! elements have, and how far its supports have.
  pure subroutine find_ways(model, system, way, given)
    type(model_t), intent(in) :: model !! reference positions
    type(system_t), intent(in) :: system !! converged; positions of the last state
    real(wp), intent(out) :: way(0:) !! (0:bodies) [length]
    real(wp), intent(out) :: given(0:) !! (0:bodies) prescribed ways [length]
    logical :: touches(size(system%body%node_body))
    real(wp) :: move(3)
    integer :: i, k

    touches = .false.
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      touches(system%contact%ix(:system%contact%nel(k), k)) = .true.
    end do
    way = 0.0_wp
    given = 0.0_wp
    do i = 1, size(touches)
      if (.not. (touches(i) .or. any(system%equation(:, i) == 0))) cycle
      associate (b => system%body%node_body(i))
        move = model%mesh%x(:, i) + system%u(:, i) - system%position%x_old(:, i)
        way(b) = max(way(b), norm2(move))
        if (.not. is_loose(system%tools, i)) given(b) = max(given(b), norm2(merge(move, 0.0_wp, &
          system%equation(:, i) == 0)))
      end associate
    end do
  end subroutine find_ways

  !> The node goes along with a rigid body that is free in all its motions: nothing prescribes it.
  pure logical function is_loose(tools, node) result(loose)
    type(rigid_part_t), intent(in) :: tools !! rigid bodies
    integer, intent(in) :: node !! the node

    loose = is_carried(tools, node)
    if (loose) loose = size(tools%rigid(tools%carried_by(node))%unknown) == 6
  end function is_loose

  !> How far what pairs join a floating body with has gone: neighbours, and across floating ones
  !! theirs. Bodies that nothing acts on may have flown themselves: what is prescribed of them
  !! counts alone.
  pure subroutine find_others(model, body, free, way, others)
    type(model_t), intent(in) :: model !! pairs
    type(bodies_t), intent(in) :: body !! bodies
    logical, intent(in) :: free(0:) !! (0:bodies) nothing acts on it
    real(wp), intent(in) :: way(0:) !! (0:bodies) of each [length]
    real(wp), intent(inout) :: others(0:) !! (0:bodies) in: prescribed ways; out: the farthest of
    !! these and of the ways of the others [length]
    real(wp) :: before(0:body%bodies)
    integer :: k

    before = -1.0_wp
    do while (any(others > before))
      before = others
      do k = 1, size(model%pairs)
        associate (slaves => model%pairs(k)%points%point_nodes(1, :), &
          masters => model%pairs(k)%surface%facets(1, :))
          call pass_on(body, free, way, masters, slaves, others)
          call pass_on(body, free, way, slaves, masters, others)
        end associate
      end do
    end do
  end subroutine find_others

  !> The farthest way at one side of a pair, told to the bodies at the other.
  pure subroutine pass_on(body, free, way, from, to, others)
    type(bodies_t), intent(in) :: body !! bodies
    logical, intent(in) :: free(0:) !! (0:bodies) nothing acts on it
    real(wp), intent(in) :: way(0:) !! (0:bodies) of each [length]
    integer, intent(in) :: from(:), to(:) !! nodes of the two sides
    real(wp), intent(inout) :: others(0:) !! (0:bodies) grows at bodies of `to` [length]
    real(wp) :: farthest
    integer :: i

    farthest = 0.0_wp
    do i = 1, size(from)
      associate (b => body%node_body(from(i)))
        if (.not. free(b)) farthest = max(farthest, way(b))
        if (b == 0) cycle
        if (body%floating(b)) farthest = max(farthest, others(b))
      end associate
    end do
    do i = 1, size(to)
      associate (b => body%node_body(to(i)))
        others(b) = max(others(b), farthest)
      end associate
    end do
  end subroutine pass_on

  !> Says it where what has converged has thrown bodies out of contact, or turned them farther than
  !! small strain can mean: the next start may lead elsewhere.
  subroutine look_for_thrown(model, system, form, progress, monitor, thrown)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! the last iterate
    type(form_t), intent(in) :: form !! its kind answers
    type(newton_t), intent(in) :: progress !! how it ended
    class(monitor_t), intent(inout) :: monitor !! hears of it
    logical, intent(out) :: thrown !! it has

    thrown = .false.
    if (progress%outcome /= outcome_converged) return
    thrown = has_thrown(model, system)
    if (thrown) then
      call monitor%detail('  bodies have separated from contact, which has no force left on '// &
        'them: not taken for the solution')
      return
    end if
    thrown = has_turned(model, system, form)
    if (thrown) call monitor%detail('  a body has rotated beyond the limit of small strain: '// &
      'not taken for the solution')
  end subroutine look_for_thrown

  !> What has converged with a slave that has gone through a master is no solution; nor where bodies
  !! have been thrown out of contact, or turned too far.
  subroutine look_for_strays(model, system, form, progress)
    type(model_t), intent(inout) :: model !! pairs with their targets; trees are fitted
    type(system_t), intent(in) :: system !! converged
    type(form_t), intent(in) :: form !! its kind answers
    type(newton_t), intent(inout) :: progress !! gets outcome
    integer :: k

    if (has_thrown(model, system)) progress%outcome = outcome_thrown
    if (has_turned(model, system, form)) progress%outcome = outcome_turned
    do k = 1, size(model%pairs)
      if (has_gone_through(model%pairs(k), system%position%x_old, model%mesh%x + system%u)) &
        progress%outcome = outcome_through
    end do
  end subroutine look_for_strays
end module lost_contact

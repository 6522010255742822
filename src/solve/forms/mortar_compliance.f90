!> What bodies and rigid motions do to multipliers: compliance and motions along their frames
!! (doc/theory, "Mortar contact", eq. (7.17)).
module mortar_compliance
  use kinds, only: wp
  use condensed_types, only: condensed_t, condensed_body_t
  use rigid_bodies, only: rigid_motion, loads_on_rigid
  use tree_compliance, only: apply_tree
  use mortar_unknowns, only: mortar_rows_t, mortar_system_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: add_body, find_motions

  !> Multipliers whose forces act at once: loops over their ways are long enough for the processor's
  !! vectors, and short enough for its caches.
  integer, parameter :: at_once = 16

contains

  !> What a body adds to the compliance: G = B C B_f^T, eq. (7.17).
  subroutine add_body(condensed, body, unknowns)
    type(condensed_t), intent(in) :: condensed !! live candidates
    type(condensed_body_t), intent(in) :: body !! its compliance
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets compliance
    real(wp) :: moved(3*at_once, body%n_live)
    integer :: own(3, size(unknowns%rows%column)), i, l, last
    logical :: touches(unknowns%n)

    associate (rows => unknowns%rows)
      own = own_candidates(condensed, body, rows%column)
      do i = 1, unknowns%n
        touches(i) = any(own(:, rows%first(i):rows%first(i + 1) - 1) > 0)
      end do
    end associate
    !$omp parallel do schedule(dynamic) default(none) shared(unknowns, body, own, touches) &
    !$omp& private(l, i, last, moved)
    do l = 1, unknowns%n, at_once
      last = min(l + at_once - 1, unknowns%n)
      moved(3*(last - l + 1) + 1:, :) = 0.0_wp
      if (.not. any(touches(l:last))) cycle
      do i = l, last
        call product_with(body, own, unknowns%rows, i, moved(3*(i - l) + 1:3*(i - l) + 3, :))
      end do
      do i = 1, unknowns%n
        if (touches(i)) call add_blocks(own, unknowns%rows, i, l, last, moved, &
          unknowns%compliance(3*i - 2:3*i, 3*l - 2:3*last))
      end do
    end do
    !$omp end parallel do
  end subroutine add_body

  !> Live candidates of a body at nodes, 0 for none.
  pure function own_candidates(condensed, body, node) result(own)
    type(condensed_t), intent(in) :: condensed !! live candidates
    type(condensed_body_t), intent(in) :: body !! one of its bodies
    integer, intent(in) :: node(:) !! (entries) nodes
    integer :: own(3, size(node)), e, k, i

    own = 0
    do e = 1, size(node)
      do k = 1, 3
        if (condensed%place(k, node(e)) == 0) cycle
        i = condensed%alive%live_place(condensed%place(k, node(e))) - body%first_live
        if (i >= 1 .and. i <= body%n_live) own(k, e) = i
      end do
    end do
  end function own_candidates

  !> What a body does where it is live under forces 1 along x, y and z of one multiplier.
  subroutine product_with(body, own, rows, l, moved)
    type(condensed_body_t), intent(in) :: body !! its compliance
    integer, intent(in) :: own(:, :) !! (3, entries) its live candidates, 0 for none
    type(mortar_rows_t), intent(in) :: rows !! rows of all multipliers
    integer, intent(in) :: l !! the multiplier
    real(wp), intent(out) :: moved(:, :) !! (force, n_live) [length/force]
    real(wp) :: force(size(moved, 2)), way(size(moved, 2))
    integer :: e, k

    do k = 1, 3
      way = 0.0_wp
      if (body%tree%used) then
        force = 0.0_wp
        do e = rows%first(l), rows%first(l + 1) - 1
          if (own(k, e) > 0) force(own(k, e)) = rows%now(e)
        end do
        if (any(abs(force) > 0.0_wp)) call apply_tree(body, body%gathered, force, way)
      else
        do e = rows%first(l), rows%first(l + 1) - 1
          if (own(k, e) > 0) way = way + rows%now(e) &
            *body%live(body%skipped + 1:body%skipped + size(way), own(k, e))
        end do
      end if
      moved(k, :) = way
    end do
  end subroutine product_with

  !> Adds the weighted ways of one multiplier by the forces of some others, along their frames.
  pure subroutine add_blocks(own, rows, i, l, last, moved, blocks)
    integer, intent(in) :: own(:, :) !! (3, entries) live candidates of the body, 0 for none
    type(mortar_rows_t), intent(in) :: rows !! rows of all multipliers
    integer, intent(in) :: i !! the one that moves
    integer, intent(in) :: l, last !! those whose forces act
    real(wp), intent(in) :: moved(3*at_once, *) !! (forces, n_live) ways of the body [length/force]
    real(wp), intent(inout) :: blocks(:, :) !! (frame of i, frames of those) of the compliance
    real(wp), dimension(3*at_once, 3) :: now, before, ways
    integer :: e, k, m

    now = 0.0_wp
    before = 0.0_wp
    do e = rows%first(i), rows%first(i + 1) - 1
      do k = 1, 3
        if (own(k, e) == 0) cycle
        now(:, k) = now(:, k) + rows%now(e)*moved(:, own(k, e))
        before(:, k) = before(:, k) + rows%before(e)*moved(:, own(k, e))
      end do
    end do
    associate (frame => rows%frame(:, :, i))
      do k = 1, 2
        ways(:, k) = before(:, 1)*frame(1, k) + before(:, 2)*frame(2, k) + before(:, 3)*frame(3, k)
      end do
      ways(:, 3) = now(:, 1)*frame(1, 3) + now(:, 2)*frame(2, 3) + now(:, 3)*frame(3, 3)
    end associate
    do m = 0, last - l
      do k = 1, 3
        associate (axis => rows%frame(:, k, l + m), block => blocks(:, 3*m + k))
          block = block + (ways(3*m + 1, :)*axis(1) + ways(3*m + 2, :)*axis(2) &
            + ways(3*m + 3, :)*axis(3))
        end associate
      end do
    end do
  end subroutine add_blocks

  !> What rigid motions do to the multipliers, work of the forces on these, and that of the loads.
  pure subroutine find_motions(system, form, unknowns)
    type(system_t), intent(in) :: system !! bodies, rigid bodies, loads
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets motion, push, load
    integer, allocatable :: mine(:)
    integer :: b, i

    associate (condensed => form%condensed, modes => form%condensed%rigid%modes &
      + system%tools%unknowns)
      unknowns%motion = reshape([real(wp) ::], [3*unknowns%n, modes], [0.0_wp])
      unknowns%push = unknowns%motion
      unknowns%load = spread(0.0_wp, 1, modes)
      if (modes == 0) return
      if (condensed%rigid%modes > 0) unknowns%load(:condensed%rigid%modes) = &
        matmul(condensed%outer%pushes, condensed%outer%factors)
      do b = 1, size(condensed%bodies)
        if (condensed%bodies(b)%n_live == 0 .or. condensed%bodies(b)%motions%n == 0) cycle
        associate (body => condensed%bodies(b), own => own_candidates(condensed, &
          condensed%bodies(b), unknowns%rows%column))
          ! those that have gone live since their compliance was gathered, too
          mine = condensed%alive%live(body%first_live + 1:body%first_live + body%n_live) &
            - body%first
          do i = 1, unknowns%n
            call add_motions(body, mine, own, i, unknowns)
          end do
        end associate
      end do
    end associate
    if (system%tools%unknowns > 0) call add_rigid(system, form, unknowns)
  end subroutine find_motions

  !> What rigid motions of a body do to a multiplier, and its force to them.
  pure subroutine add_motions(body, mine, own, i, unknowns)
    type(condensed_body_t), intent(in) :: body !! its motions
    integer, intent(in) :: mine(:) !! (n_live) its candidates that are live
    integer, intent(in) :: own(:, :) !! (3, entries) its live candidates, 0 for none
    integer, intent(in) :: i !! the multiplier
    type(mortar_system_t), intent(inout) :: unknowns !! gets motion, push
    real(wp) :: now(3, body%motions%n), before(3, body%motions%n)
    integer :: e, k

    now = 0.0_wp
    before = 0.0_wp
    associate (rows => unknowns%rows)
      do e = rows%first(i), rows%first(i + 1) - 1
        do k = 1, 3
          if (own(k, e) == 0) cycle
          now(k, :) = now(k, :) + rows%now(e)*body%modes(mine(own(k, e)), :)
          before(k, :) = before(k, :) + rows%before(e)*body%modes(mine(own(k, e)), :)
        end do
      end do
    end associate
    call put_motions(i, body%first_mode, now, before, unknowns)
  end subroutine add_motions

  !> Free motions of rigid bodies with a point, to first order about where they are; what acts on
  !! them but for contact (doc/theory, "Rigid bodies", eq. (9.7)).
  pure subroutine add_rigid(system, form, unknowns)
    type(system_t), intent(in) :: system !! rigid bodies, loads
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets motion, push, load
    real(wp), dimension(3, system%tools%unknowns) :: now, before, of_node
    integer :: i, e

    associate (rows => unknowns%rows, n => form%condensed%rigid%modes)
      unknowns%load(n + 1:) = loads_on_rigid(system)
      do i = 1, unknowns%n
        now = 0.0_wp
        before = 0.0_wp
        do e = rows%first(i), rows%first(i + 1) - 1
          if (system%tools%carried_by(rows%column(e)) == 0) cycle
          of_node = rigid_motion(system, rows%column(e))
          now = now + rows%now(e)*of_node
          before = before + rows%before(e)*of_node
        end do
        call put_motions(i, n, now, before, unknowns)
      end do
    end associate
  end subroutine add_rigid

  !> Motions of the places under a multiplier, now and for slip, along its frame.
  pure subroutine put_motions(i, n, now, before, unknowns)
    integer, intent(in) :: i !! the multiplier
    integer, intent(in) :: n !! motions before these
    real(wp), intent(in) :: now(:, :), before(:, :) !! (3, motions) in space
    type(mortar_system_t), intent(inout) :: unknowns !! adds to motion, push
    integer :: last

    last = n + size(now, 2)
    associate (frame => unknowns%rows%frame(:, :, i), &
      push => unknowns%push(3*i - 2:3*i, n + 1:last), &
      motion => unknowns%motion(3*i - 2:3*i, n + 1:last))
      push = push + matmul(transpose(frame), now)
      motion(1:2, :) = motion(1:2, :) + matmul(transpose(frame(:, 1:2)), before)
      motion(3, :) = motion(3, :) + matmul(frame(:, 3), now)
    end associate
  end subroutine put_motions
end module mortar_compliance

!> Mean rotations of condensed bodies, in which their older factors are applied (doc/theory,
!! "Nonlinear bulk", eq. (12.17)).
module body_turns
  use kinds, only: wp
  use element_types, only: routine_none, routine_finite
  use vectors, only: identity, determinant, dyad, invert
  use condensed_types, only: turns_not, turns_freely, condensed_t
  use system_types, only: system_t
  use system_parts, only: bodies_t
  implicit none
  private
  public :: start_turns, follow_turns, mark_turns, to_frames, from_frames, turn_elements, &
    mean_rotation

  !> Steps of the iteration for a rotation, which doubles its digits in each.
  integer, parameter :: most_turn_steps = 40

contains

  !> Which bodies' rotations are followed: those that are of finite strain all through, for a small
  !! strain does not turn; and about what axes supports let their nodes turn, for a support that
  !! holds a node in some directions must hold it in the same ones after the rotation.
  subroutine start_turns(system, condensed)
    type(system_t), intent(in) :: system !! bulk, equations
    type(condensed_t), intent(inout) :: condensed !! gets turns_about
    logical :: finite(system%body%bodies)
    integer :: k, b, axis

    finite = .true.
    do k = 1, system%bulk%n
      if (any(system%bulk%routine(k) == [routine_none, routine_finite])) cycle
      b = system%body%node_body(system%bulk%ix(1, k))
      if (b > 0) finite(b) = .false.
    end do
    do b = 1, system%body%bodies
      associate (body => condensed%bodies(b))
        body%turns_about = merge(turns_freely, turns_not, finite(b))
        body%turned_then = identity
        body%turn = identity
      end associate
    end do
    do k = 1, size(system%body%node_body)
      b = system%body%node_body(k)
      if (b == 0) cycle
      axis = held_axis(system%equation(:, k) == 0)
      associate (about => condensed%bodies(b)%turns_about)
        if (about == turns_not .or. axis == turns_freely) cycle
        if (about == turns_freely) about = axis
        if (about /= axis) about = turns_not
      end associate
    end do
  end subroutine start_turns

  !> The axis about which a node may turn with its supports: that of the one direction that is held,
  !! or that is not.
  pure integer function held_axis(held) result(axis)
    logical, intent(in) :: held(3) !! directions

    axis = turns_freely
    if (count(held) == 1) axis = findloc(held, .true., 1)
    if (count(held) == 2) axis = findloc(held, .false., 1)
  end function held_axis

  !> Rotations from the state of the factors to the iterate.
  subroutine follow_turns(x, system, condensed)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! u given
    type(condensed_t), intent(inout) :: condensed !! gets turn of its bodies
    real(wp) :: turned(3, 3, system%body%bodies)
    integer :: b

    call find_turns(x, system%u, condensed, system%body, turned)
    do b = 1, system%body%bodies
      associate (body => condensed%bodies(b))
        body%turn = matmul(turned(:, :, b), transpose(body%turned_then))
      end associate
    end do
  end subroutine follow_turns

  !> New factors belong to the rotations of a state.
  subroutine mark_turns(x, u, condensed, body)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(condensed_t), intent(inout) :: condensed !! gets turned_then of its bodies
    type(bodies_t), intent(in) :: body !! connected bodies
    real(wp) :: turned(3, 3, body%bodies)
    integer :: b

    call find_turns(x, u, condensed, body, turned)
    do b = 1, body%bodies
      condensed%bodies(b)%turned_then = turned(:, :, b)
    end do
  end subroutine mark_turns

  !> Mean rotations of the bodies at a state.
  subroutine find_turns(x, u, condensed, body, turned)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(condensed_t), intent(in) :: condensed !! where its bodies turn about
    type(bodies_t), intent(in) :: body !! connected bodies
    real(wp), intent(out) :: turned(:, :, :) !! (3, 3, bodies)
    real(wp) :: mean(3, body%bodies), moved(3, body%bodies), h(3, 3, body%bodies)
    integer :: i, b, nodes(body%bodies)

    mean = 0.0_wp
    moved = 0.0_wp
    h = 0.0_wp
    nodes = 0
    do i = 1, size(x, 2)
      b = body%node_body(i)
      if (b == 0) cycle
      nodes(b) = nodes(b) + 1
      mean(:, b) = mean(:, b) + x(:, i)
      moved(:, b) = moved(:, b) + x(:, i) + u(:, i)
    end do
    do b = 1, body%bodies
      mean(:, b) = mean(:, b)/real(max(1, nodes(b)), wp)
      moved(:, b) = moved(:, b)/real(max(1, nodes(b)), wp)
    end do
    do i = 1, size(x, 2)
      b = body%node_body(i)
      if (b == 0) cycle
      h(:, :, b) = h(:, :, b) + dyad(x(:, i) + u(:, i) - moved(:, b), x(:, i) - mean(:, b))
    end do
    do b = 1, body%bodies
      turned(:, :, b) = mean_rotation(h(:, :, b), condensed%bodies(b)%turns_about)
    end do
  end subroutine find_turns

  !> The rotation that is nearest to a mean deformation: its polar factor, or the angle about an
  !! axis.
  pure function mean_rotation(h, about) result(r)
    real(wp), intent(in) :: h(3, 3) !! sum of positions times reference positions, from their means
    integer, intent(in) :: about !! what rotations count (condensed_types)
    real(wp) :: r(3, 3), next(3, 3), inverse(3, 3), det, angle, change
    integer :: i, j, step

    r = identity
    if (about == turns_not .or. maxval(abs(h)) <= 0.0_wp) return
    if (about /= turns_freely) then
      i = mod(about, 3) + 1
      j = mod(i, 3) + 1
      angle = atan2(h(j, i) - h(i, j), h(i, i) + h(j, j))
      r(i, i) = cos(angle)
      r(j, j) = r(i, i)
      r(j, i) = sin(angle)
      r(i, j) = -r(j, i)
      return
    end if
    next = h/maxval(abs(h))
    do step = 1, most_turn_steps
      if (determinant(next) <= tiny(1.0_wp)) return
      call invert(next, inverse, det)
      change = maxval(abs(0.5_wp*(next + transpose(inverse)) - next))
      next = 0.5_wp*(next + transpose(inverse))
      if (change <= 4.0_wp*epsilon(1.0_wp)) exit
    end do
    r = next
  end function mean_rotation

  !> A nodal field in the frames in which the factors stand.
  pure subroutine to_frames(body, condensed, field)
    type(bodies_t), intent(in) :: body !! turn of its bodies
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(inout) :: field(:, :) !! (3, nodes)
    real(wp) :: turn(3, 3, size(condensed%bodies))
    integer :: b

    do b = 1, size(turn, 3)
      turn(:, :, b) = transpose(condensed%bodies(b)%turn)
    end do
    call turn_nodes(turn, body%node_body, field)
  end subroutine to_frames

  !> And back.
  pure subroutine from_frames(body, condensed, field)
    type(bodies_t), intent(in) :: body !! turn of its bodies
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(inout) :: field(:, :) !! (3, nodes)
    real(wp) :: turn(3, 3, size(condensed%bodies))
    integer :: b

    do b = 1, size(turn, 3)
      turn(:, :, b) = condensed%bodies(b)%turn
    end do
    call turn_nodes(turn, body%node_body, field)
  end subroutine from_frames

  !> A vector field turned with each body.
  pure subroutine turn_nodes(turn, node_body, field)
    real(wp), intent(in) :: turn(:, :, :) !! (3, 3, bodies)
    integer, intent(in) :: node_body(:) !! (nodes) body of each node, 0 for none
    real(wp), intent(inout) :: field(:, :) !! (3, nodes)
    real(wp) :: v(3)
    integer :: i, b

    do i = 1, size(field, 2)
      b = node_body(i)
      if (b == 0) cycle
      v = field(:, i)
      field(:, i) = turn(:, 1, b)*v(1) + turn(:, 2, b)*v(2) + turn(:, 3, b)*v(3)
    end do
  end subroutine turn_nodes

  !> Matrices of the contact elements in these frames.
  pure subroutine turn_elements(system, condensed)
    type(system_t), intent(in) :: system !! contact elements; s of the tangent of condensed
    type(condensed_t), intent(inout) :: condensed !! what the condensed form keeps
    integer :: k, a, c, b

    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      do a = 1, system%contact%nel(k)
        b = system%body%node_body(system%contact%ix(a, k))
        if (b == 0) cycle
        associate (turn => condensed%bodies(b)%turn, s => condensed%tangent%s(:, :, k))
          do c = 1, system%contact%nel(k)
            associate (block => s(3*a - 2:3*a, 3*c - 2:3*c))
              block = matmul(transpose(turn), block)
            end associate
          end do
          do c = 1, system%contact%nel(k)
            associate (block => s(3*c - 2:3*c, 3*a - 2:3*a))
              block = matmul(block, turn)
            end associate
          end do
        end associate
      end do
    end do
  end subroutine turn_elements
end module body_turns

!> What contact, bodies and rigid bodies with a point answer to displacements, by the tangent at
!! hand (doc/theory, "Condensed rigid bodies").
module contact_answer
  use kinds, only: wp
  use condensed_types, only: condensed_t
  use live_candidates, only: apply_compliance
  use condensed_motions, only: push_live
  use gcr, only: begin_gcr, take_known, add_image_of
  use contact_iteration, only: answer_by_blocks
  use contact_tangent, only: apply_rest
  use small_tangent, only: answer_leading
  use contact_sums, only: add_leading
  use condensed_border, only: add_points, factorise_points
  use system_types, only: system_t
  implicit none
  private
  public :: answer, answer_points, apply_compliance, most_vectors, inner_accuracy

  !> Iterations of GMRES with a new factor.
  integer, parameter :: most_vectors = 40
  !> Accuracy of the answers that multipliers and unknowns of rigid bodies ask for.
  real(wp), parameter :: inner_accuracy = 1.0e-8_wp

contains

  !> The answer of contact to a displacement b, with the unknowns of rigid bodies that belong to it.
  subroutine answer(condensed, b, push, floor, most, y, t, arrived)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor or blocks, points
    real(wp), intent(in) :: b(:) !! (live) displacement without the answer [length]
    real(wp), intent(in) :: push(:) !! (modes) of the answer, in the unit of displacements [length]
    real(wp), intent(in) :: floor !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations allowed
    real(wp), intent(out) :: y(:) !! (live) [force]
    real(wp), intent(out) :: t(:) !! (live) [length]
    logical, intent(out) :: arrived !! at the floor

    call answer_contact(condensed, b, push, floor, most, y, t, arrived)
    if (condensed%points%n > 0) call add_points(condensed, y, t)
  end subroutine answer

  !> What contact and the bodies answer to each unknown of rigid bodies: forces c of contact at the
  !! live candidates, which these do not know of.
  subroutine answer_points(system, condensed, most, arrived)
    type(system_t), intent(in) :: system !! tangent at hand
    type(condensed_t), intent(inout) :: condensed !! gets answers of points
    integer, intent(in) :: most !! iterations allowed
    logical, intent(out) :: arrived !! all answers are there
    real(wp), dimension(condensed%alive%n_live) :: c, b, y, t
    real(wp) :: push(condensed%rigid%modes)
    integer :: k
    logical :: found

    arrived = .true.
    associate (points => condensed%points)
      if (points%n == 0 .or. points%known) return
      points%force = points%columns
      points%way = points%columns
      points%motion = reshape([real(wp) ::], [condensed%rigid%modes, points%n], [0.0_wp])
      do k = 1, points%n
        if (all(abs(points%columns(:, k)) <= 0.0_wp)) cycle
        c = points%columns(:, k)
        b = 0.0_wp
        call apply_compliance(condensed, c, b)
        call push_live(condensed, c, push)
        call answer_contact(condensed, -b, -push, inner_accuracy*norm2(c), most, y, t, found)
        points%force(:, k) = c + y
        points%way(:, k) = t
        if (condensed%rigid%modes > 0) points%motion(:, k) = condensed%rigid%alpha_next
        arrived = arrived .and. found
      end do
      if (arrived) call factorise_points(system, condensed, arrived)
    end associate
  end subroutine answer_points

  !> The answer of contact to a displacement b, by the factor or by blocks.
  subroutine answer_contact(condensed, b, push, floor, most, y, t, arrived)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor or blocks
    real(wp), intent(in) :: b(:) !! (live) displacement without the answer [length]
    real(wp), intent(in) :: push(:) !! (modes) of the answer, in the unit of displacements [length]
    real(wp), intent(in) :: floor !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations allowed
    real(wp), intent(out) :: y(:) !! (live) [force]
    real(wp), intent(out) :: t(:) !! (live) [length]
    logical, intent(out) :: arrived !! at the floor

    if (condensed%tangent%parts%iterated) then
      call answer_by_blocks(condensed, b, push, floor, most, y, t, arrived)
    else
      call answer_by_factor(condensed, b, push, floor, most, y, t, arrived)
    end if
  end subroutine answer_contact

  !> The answer y = U z + q of contact to a displacement b, and t = b - C y + R a with rigid motions
  !! a so that y has the push that is asked for. The leading part is solved for, so that no force
  !! is a difference of displacements times a penalty; the rest, q = k' t, by GMRES.
  subroutine answer_by_factor(condensed, b, push, floor, most, y, t, arrived)
    type(condensed_t), intent(inout) :: condensed !! tangent with its factor; its vectors are used
    real(wp), intent(in) :: b(:) !! (live) displacement without the answer [length]
    real(wp), intent(in) :: push(:) !! (modes) of the answer, in the unit of displacements [length]
    real(wp), intent(in) :: floor !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations allowed, at most most_vectors
    real(wp), intent(out) :: y(:) !! (live) [force]
    real(wp), intent(out) :: t(:) !! (live) [length]
    logical, intent(out) :: arrived !! at the floor
    real(wp) :: rest(size(b)), moved(size(b)), way(2*size(b) + condensed%tangent%rank &
      + condensed%rigid%modes), pushed(condensed%rigid%modes)
    real(wp) :: z(condensed%tangent%rank + condensed%rigid%modes + 1), share(size(z))
    integer :: n
    logical :: goes_on

    n = size(b)
    associate (tangent => condensed%tangent, unknowns => size(z) - 1)
      call begin_gcr(n, size(way), most_vectors, tangent%course%known)
      call answer_leading(condensed, b, push, z, t)
      call apply_rest(tangent, t, rest)
      way = 0.0_wp
      call take_known(tangent%course%known, 1, rest, way)
      tangent%course%iterations = 0
      goes_on = .true.
      do while (norm2(rest) > floor .and. tangent%course%iterations < most .and. goes_on)
        tangent%course%iterations = tangent%course%iterations + 1
        y = 0.0_wp
        call apply_compliance(condensed, rest, y)
        call push_live(condensed, rest, pushed)
        call answer_leading(condensed, y, pushed, share, moved)
        call apply_rest(tangent, moved, y)
        call add_image_of([rest, moved, share(:unknowns)], rest + y, tangent%course%known, goes_on)
        if (goes_on) call take_known(tangent%course%known, tangent%course%known%n, rest, way)
      end do
      arrived = norm2(rest) <= floor
      y = way(:n)
      t = t - way(n + 1:2*n)
      z(:unknowns) = z(:unknowns) - way(2*n + 1:)
      call add_leading(tangent, z, y)
      condensed%rigid%alpha_next = z(tangent%rank + 1:unknowns)
    end associate
  end subroutine answer_by_factor
end module contact_answer

!> The answer of contact where the small matrix is large: GMRES on its rows, on the rest of the
!! element matrices and on the rigid motions at once, with overlapping blocks in place of the factor
!! (doc/theory, "Contact operator of low rank").
module contact_iteration
  use kinds, only: wp
  use condensed_types, only: condensed_t
  use live_candidates, only: apply_compliance
  use condensed_motions, only: push_live, add_live_motion
  use carried_motions, only: apply_nearly
  use contact_blocks, only: precondition
  use contact_sums, only: add_leading, take_shares
  use contact_tangent, only: apply_rest
  use gmres, only: gmres_t, begin_gmres, add_image, gmres_shares
  implicit none
  private
  public :: answer_by_blocks

  !> Vectors of GMRES, and how often it starts at most: anew from the true residual.
  integer, parameter :: contact_vectors = 60, most_starts = 4
  !> How many of these take products in single precision, and the share of the residual that they
  !! can find.
  integer, parameter :: most_near_solves = 2
  real(wp), parameter :: near_contact_share = 1.0e-5_wp
  !> Share of the residual that a coarse answer may leave.
  real(wp), parameter :: coarse = 0.01_wp
  !> Share of the forces, with those that are found, which any other answer may leave: a residual
  !! may be mostly the way of a body that has far to go, and many times as large as they are.
  real(wp), parameter :: of_forces = 1.0e-5_wp

contains

  !> The answer y = U z + q of contact to a displacement b, and t = b - C y + R a with rigid motions
  !! a so that y has the push that is asked for. t is formed with the forces found, so that the bulk
  !! is in balance however far the iteration goes.
  subroutine answer_by_blocks(condensed, b, push, floor, most, y, t, arrived)
    type(condensed_t), intent(inout) :: condensed !! tangent with its blocks
    real(wp), intent(in) :: b(:) !! (live) displacement without the answer [length]
    real(wp), intent(in) :: push(:) !! (modes) of the answer, in the unit of displacements [length]
    real(wp), intent(in) :: floor !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations allowed; 0 for a coarse answer
    real(wp), intent(out) :: y(:) !! (live) [force]
    real(wp), intent(out) :: t(:) !! (live) [length]
    logical, intent(out) :: arrived !! at the floor
    real(wp), allocatable :: x(:), r(:), weight(:)
    real(wp) :: goal, norm
    integer :: start, n, iterations

    n = condensed%tangent%rank + condensed%rigid%modes
    allocate (x(n + size(b)), source=0.0_wp)
    allocate (r(size(x)), weight(size(x)))
    call weigh(condensed, weight)
    goal = floor
    iterations = 0
    do start = 1, most_starts
      y = x(n + 1:)
      call add_leading(condensed%tangent, x(:n), y)
      call find_rest(condensed, b, push, x, y, .false., t, r)
      r = weight*r
      norm = norm2(r)
      if (start == 1 .and. most == 0) goal = coarse*norm
      if (start > 1 .and. most > 0 .and. condensed%active) goal = min(floor, of_forces*norm2( &
        condensed%bulk%force(condensed%alive%live) + y))
      arrived = norm <= goal
      if (arrived .or. start == most_starts .or. iterations > most) exit
      call correct(condensed, weight, 0.5_wp*goal, start <= most_near_solves, r, x, iterations)
      if (most == 0) iterations = 1
    end do
    condensed%tangent%course%iterations = iterations
    condensed%rigid%alpha_next = x(condensed%tangent%rank + 1:n)
  end subroutine answer_by_blocks

  !> From residuals to the forces they make.
  pure subroutine weigh(condensed, weight)
    type(condensed_t), intent(in) :: condensed !! tangent with its blocks
    real(wp), intent(out) :: weight(:) !! (rank+modes+live)
    integer :: b

    weight = 1.0_wp
    associate (n => condensed%tangent%rank)
      weight(:n) = condensed%tangent%parts%weight
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          weight(n + body%first_mode + 1:n + body%first_mode + body%motions%n) = &
            1.0_wp/body%softness
        end associate
      end do
    end associate
  end subroutine weigh

  !> What shares, rigid motions and the rest x leave of the equations, and the displacements that
  !! belong to them.
  subroutine find_rest(condensed, b, push, x, y, near, t, r)
    type(condensed_t), intent(in) :: condensed !! tangent, live compliances
    real(wp), intent(in) :: b(:) !! (live) displacement without the answer [length]
    real(wp), intent(in) :: push(:) !! (modes) asked for [length]
    real(wp), intent(in) :: x(:) !! (rank+modes+live) shares z, rigid motions, q
    real(wp), intent(in) :: y(:) !! (live) U z + q [force]
    logical, intent(in) :: near !! C' in single precision is enough
    real(wp), intent(out) :: t(:) !! (live) b - C y + R a [length]
    real(wp), intent(out) :: r(:) !! (rank+modes+live)

    associate (tangent => condensed%tangent, n => condensed%tangent%rank, &
      last => condensed%tangent%rank + condensed%rigid%modes)
      t = 0.0_wp
      if (near) then
        call apply_nearly(condensed, y, t)
      else if (maxval(abs(y)) > 0.0_wp) then
        call apply_compliance(condensed, y, t)
      end if
      t = b - t
      if (condensed%rigid%modes > 0) then
        call add_live_motion(condensed, x(n + 1:last), t)
        call push_live(condensed, y, r(n + 1:last))
        r(n + 1:last) = push - r(n + 1:last)
        r(n + 1:last) = r(n + 1:last) - matmul(condensed%rigid%hold, x(n + 1:last))
      end if
      call take_shares(tangent, t, r(:n))
      r(last + 1:) = 0.0_wp
      if (tangent%whole .or. tangent%resting > 0) call apply_rest(tangent, t, r(last + 1:), r(:n))
      r(:n) = r(:n) - x(:n)
      r(last + 1:) = r(last + 1:) - x(last + 1:)
    end associate
  end subroutine find_rest

  !> One course of GMRES from a residual, preconditioned on the right. The answers of the blocks are
  !! kept: in single precision, and large where a block is nearly singular, that to a sum is not the
  !! sum of them, and the residual would not be the one that GMRES has found.
  subroutine correct(condensed, weight, goal, near, r, x, iterations)
    type(condensed_t), intent(in) :: condensed !! tangent with its blocks
    real(wp), intent(in) :: weight(:) !! (rank+modes+live) from residuals to forces
    real(wp), intent(in) :: goal !! residual to arrive at [force]
    logical, intent(in) :: near !! by products in single precision, as far as these lead
    real(wp), intent(in) :: r(:) !! (rank+modes+live) weighted residual [force]
    real(wp), intent(inout) :: x(:) !! (rank+modes+live) is corrected
    integer, intent(inout) :: iterations !! counts on
    type(gmres_t) :: course
    real(wp) :: least, d(size(x)), image(size(x)), zero(condensed%alive%n_live)
    real(wp) :: y(condensed%alive%n_live), t(condensed%alive%n_live)
    real(wp), allocatable :: answers(:, :), share(:)
    integer :: n

    n = condensed%tangent%rank + condensed%rigid%modes
    allocate (answers(n, contact_vectors))
    zero = 0.0_wp
    least = goal
    if (near) least = max(goal, near_contact_share*norm2(r))
    call begin_gmres(r, contact_vectors, course)
    do
      d = course%base(:, course%n + 1)/weight
      call precondition(condensed, d(:n), image(:n), y)
      y = y + d(n + 1:)
      d(:n) = image(:n)
      answers(:, course%n + 1) = d(:n)
      call find_rest(condensed, zero, zero(:condensed%rigid%modes), d, y, near, t, image)
      call add_image(-weight*image, course)
      if (course%rest <= least .or. course%n == contact_vectors) exit
    end do
    iterations = iterations + course%n
    share = gmres_shares(course)
    x(:n) = x(:n) + matmul(answers(:, :course%n), share)
    x(n + 1:) = x(n + 1:) + matmul(course%base(n + 1:, :course%n), share)/weight(n + 1:)
  end subroutine correct
end module contact_iteration

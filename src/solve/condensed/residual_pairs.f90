!> What steps by near factors have made of the residual, so that the next ones need not find it
!! again (doc/theory, "A bulk that is not linear").
module residual_pairs
  use kinds, only: wp
  use condensed_types, only: residual_pairs_t
  implicit none
  private
  public :: forget_pairs, note_asked, split_right, add_shares, note_pair

  !> Pairs that are kept.
  integer, parameter :: most_pairs = 8
  !> A change of the residual of which the others explain all but this share tells nothing new.
  real(wp), parameter :: least_news = 1.0e-6_wp

contains

  !> Forgets all pairs: they belong to a tangent of contact.
  pure subroutine forget_pairs(pairs)
    type(residual_pairs_t), intent(inout) :: pairs !! emptied; their room stays

    pairs%n = 0
    pairs%asked = .false.
  end subroutine forget_pairs

  !> A direction answers a residual.
  pure subroutine note_asked(right, pairs)
    real(wp), intent(in) :: right(:) !! (equations) [force]
    type(residual_pairs_t), intent(inout) :: pairs !! gets asked_for

    pairs%asked_for = right
    pairs%asked = .true.
  end subroutine note_asked

  !> The part of a residual that no step so far accounts for, and the shares of the steps in the
  !! rest: r - Q Q^T r and Q^T r.
  subroutine split_right(right, pairs, rest)
    real(wp), intent(in) :: right(:) !! (equations) [force]
    type(residual_pairs_t), intent(inout) :: pairs !! gets share, asked_for
    real(wp), intent(out) :: rest(:) !! (equations) [force]
    integer :: j

    call note_asked(right, pairs)
    rest = right
    do j = 1, pairs%n
      pairs%share(j) = dot_product(pairs%image(:, j), rest)
      rest = rest - pairs%share(j)*pairs%image(:, j)
    end do
  end subroutine split_right

  !> Adds these shares of the steps to what the factors have made of the other part.
  pure subroutine add_shares(pairs, solution)
    type(residual_pairs_t), intent(in) :: pairs !! share
    real(wp), intent(inout) :: solution(:) !! (equations) [length]
    integer :: j

    do j = 1, pairs%n
      solution = solution + pairs%share(j)*pairs%step(:, j)
    end do
  end subroutine add_shares

  !> Takes a full step and what it has made of the residual that it was asked for.
  subroutine note_pair(step, right, pairs)
    real(wp), intent(in) :: step(:) !! (equations) [length]
    real(wp), intent(in) :: right(:) !! (equations) residual after it [force]
    type(residual_pairs_t), intent(inout) :: pairs !! one more
    real(wp) :: whole, share, length
    integer :: j, n

    if (.not. pairs%asked .or. pairs%n == most_pairs) return
    pairs%asked = .false.
    if (allocated(pairs%step)) then
      if (size(pairs%step, 1) /= size(step)) deallocate (pairs%step, pairs%image, pairs%share)
    end if
    if (.not. allocated(pairs%step)) allocate (pairs%step(size(step), most_pairs), &
      pairs%image(size(step), most_pairs), pairs%share(most_pairs))
    n = pairs%n + 1
    pairs%step(:, n) = step
    pairs%image(:, n) = pairs%asked_for - right
    whole = norm2(pairs%image(:, n))
    do j = 1, pairs%n
      share = dot_product(pairs%image(:, j), pairs%image(:, n))
      pairs%image(:, n) = pairs%image(:, n) - share*pairs%image(:, j)
      pairs%step(:, n) = pairs%step(:, n) - share*pairs%step(:, j)
    end do
    length = norm2(pairs%image(:, n))
    if (length <= least_news*whole) return
    pairs%image(:, n) = pairs%image(:, n)/length
    pairs%step(:, n) = pairs%step(:, n)/length
    pairs%n = n
  end subroutine note_pair
end module residual_pairs

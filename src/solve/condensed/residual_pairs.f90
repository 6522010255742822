!> What steps by near factors have made of the residual, so that the next ones need not find it
!! again (doc/theory, "Nonlinear bulk", eq. (12.18)).
module residual_pairs
  use kinds, only: wp
  use gcr, only: begin_gcr, forget_images, take_known, add_image_of
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

    call forget_images(pairs%known)
    pairs%asked = .false.
  end subroutine forget_pairs

  !> A direction answers a residual.
  pure subroutine note_asked(right, pairs)
    real(wp), intent(in) :: right(:) !! (equations) [force]
    type(residual_pairs_t), intent(inout) :: pairs !! gets asked_for

    pairs%asked_for = right
    pairs%asked = .true.
  end subroutine note_asked

  !> The part of a residual that no step so far accounts for, r - Q Q^T r, and what the steps answer
  !! to the rest.
  subroutine split_right(right, pairs, rest)
    real(wp), intent(in) :: right(:) !! (equations) [force]
    type(residual_pairs_t), intent(inout) :: pairs !! gets answer, asked_for
    real(wp), intent(out) :: rest(:) !! (equations) [force]

    call note_asked(right, pairs)
    rest = right
    pairs%answer = spread(0.0_wp, 1, size(right))
    call take_known(pairs%known, 1, rest, pairs%answer)
  end subroutine split_right

  !> Adds what the steps answer to what the factors have made of the other part.
  pure subroutine add_shares(pairs, solution)
    type(residual_pairs_t), intent(in) :: pairs !! answer
    real(wp), intent(inout) :: solution(:) !! (equations) [length]

    if (pairs%known%n > 0) solution = solution + pairs%answer
  end subroutine add_shares

  !> Takes a full step and what it has made of the residual that it was asked for.
  subroutine note_pair(step, right, pairs)
    real(wp), intent(in) :: step(:) !! (equations) [length]
    real(wp), intent(in) :: right(:) !! (equations) residual after it [force]
    type(residual_pairs_t), intent(inout) :: pairs !! one more
    logical :: new

    if (.not. pairs%asked .or. pairs%known%n == most_pairs) return
    pairs%asked = .false.
    call begin_gcr(size(step), size(step), most_pairs, pairs%known)
    pairs%known%least_new = least_news
    call add_image_of(step, pairs%asked_for - right, pairs%known, new)
  end subroutine note_pair
end module residual_pairs

!> What touches exactly (doc/theory, "Exact closure", eq. (10.4)): a gap that the coordinates do not
!! know is none, whatever sign round-off gives it. The one place that says how small that is.
module exact_touch
  use kinds, only: wp
  implicit none
  private
  public :: round_off

  !> A gap is known to so many units in the last place of the coordinates: a turn of the scene
  !! rounds those of a point and of three corners, what generates mid nodes some more.
  real(wp), parameter :: roundings = 64.0_wp

contains

  !> Gaps up to this between a point and a facet are round-off.
  pure real(wp) function round_off(x, y) result(gap)
    real(wp), intent(in) :: x(:, :) !! (3, corners) of the facet [length]
    real(wp), intent(in) :: y(3) !! the point [length]

    gap = roundings*epsilon(gap)*max(maxval(abs(x)), maxval(abs(y)))
  end function round_off
end module exact_touch

!> The smallest positive root of a cubic.
module cubic_roots
  use kinds, only: wp
  implicit none
  private
  public :: first_positive_root

  !> A leading coefficient below this share of the others is none.
  real(wp), parameter :: no_coefficient = 1.0e-14_wp

contains

  !> Smallest positive root of c(1) + c(2) x + c(3) x^2 + c(4) x^3, huge if there is none; 0 if it
  !! is not positive at 0.
  pure real(wp) function first_positive_root(c) result(root)
    real(wp), intent(in) :: c(4) !! coefficients
    real(wp) :: low, high, stops(2)
    integer :: i, n

    root = huge(1.0_wp)
    if (.not. c(1) > 0.0_wp) then
      root = 0.0_wp
      return
    end if
    ! between its extremes the cubic is monotone: a sign change there holds one root
    call extremes(c, stops, n)
    low = 0.0_wp
    do i = 1, n
      if (stops(i) <= low) cycle
      if (value(c, stops(i)) <= 0.0_wp) then
        root = bisect(c, low, stops(i))
        return
      end if
      low = stops(i)
    end do
    high = max(1.0_wp, 2.0_wp*low)
    do while (value(c, high) > 0.0_wp)
      if (high > 1.0e6_wp) return
      low = high
      high = 2.0_wp*high
    end do
    root = bisect(c, low, high)
  end function first_positive_root

  !> Value of the cubic.
  pure real(wp) function value(c, x)
    real(wp), intent(in) :: c(4) !! coefficients
    real(wp), intent(in) :: x !! where

    value = c(1) + x*(c(2) + x*(c(3) + x*c(4)))
  end function value

  !> Where the slope is zero, ascending.
  pure subroutine extremes(c, stops, n)
    real(wp), intent(in) :: c(4) !! coefficients
    real(wp), intent(out) :: stops(2) !! the places
    integer, intent(out) :: n !! how many there are
    real(wp) :: a, b, q

    a = 3.0_wp*c(4)
    b = 2.0_wp*c(3)
    stops = 0.0_wp
    n = 0
    if (abs(a) <= no_coefficient*(abs(b) + abs(c(2)))) then
      if (abs(b) > 0.0_wp) stops = -c(2)/b
      if (abs(b) > 0.0_wp) n = 1
    else if (b**2 - 4.0_wp*a*c(2) > 0.0_wp) then
      q = -0.5_wp*(b + sign(sqrt(b**2 - 4.0_wp*a*c(2)), b))
      stops = q/a
      if (abs(q) > 0.0_wp) stops(2) = c(2)/q
      stops = [minval(stops), maxval(stops)]
      n = 2
    end if
  end subroutine extremes

  !> The root between a positive and a negative value.
  pure real(wp) function bisect(c, from, to) result(x)
    real(wp), intent(in) :: c(4) !! coefficients
    real(wp), intent(in) :: from !! value > 0 there
    real(wp), intent(in) :: to !! value <= 0 there
    real(wp) :: low, high

    low = from
    high = to
    do while (high - low > 4.0_wp*epsilon(1.0_wp)*high)
      x = 0.5_wp*(low + high)
      if (value(c, x) > 0.0_wp) then
        low = x
      else
        high = x
      end if
    end do
    x = low
  end function bisect
end module cubic_roots

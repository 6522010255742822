!> Linear fields over a facet, fitted to values at points of it (doc/theory, "History on new
!! cells").
module linear_fields
  use kinds, only: wp
  implicit none
  private
  public :: linear_field_t, fit_field, field_at, bounded_field_at

  !> Points that lie closer to a line than this share of their extent give no slope.
  real(wp), parameter :: line_extent_ratio = 1.0e-6_wp

  !> Values that a field has at most: a way, a slip path and the slip.
  integer, parameter :: most_field_values = 7

  !> A field: its mean, its slopes, and the range of the values it was fitted to.
  type :: linear_field_t
    real(wp) :: center(2) = 0.0_wp !! (xi, eta) of the weighted mean of the points
    integer :: n = most_field_values !! values
    real(wp) :: mean(most_field_values) = 0.0_wp !! (n) weighted mean of the values
    real(wp) :: slope(most_field_values, 2) = 0.0_wp !! (n, 2) by xi and eta
    real(wp) :: low(most_field_values) = 0.0_wp !! (n) smallest value
    real(wp) :: high(most_field_values) = 0.0_wp !! (n) largest value
  end type linear_field_t

contains

  !> Least squares with weights; constant where the points do not tell a slope, zero without points.
  pure subroutine fit_field(xi, weight, value, field)
    real(wp), intent(in) :: xi(:, :) !! (2, points) where
    real(wp), intent(in) :: weight(:) !! (points) positive weights
    real(wp), intent(in) :: value(:, :) !! (values, points) values, at most most_values
    type(linear_field_t), intent(out) :: field !! the field
    real(wp) :: a(2, 2), det, from_center(2), right(size(value, 1), 2)
    integer :: p, n

    n = size(value, 1)
    field%n = n
    if (size(weight) == 0) return
    field%center = matmul(xi, weight)/sum(weight)
    field%mean(:n) = matmul(value, weight)/sum(weight)
    field%low(:n) = minval(value, 2)
    field%high(:n) = maxval(value, 2)
    a = 0.0_wp
    right = 0.0_wp
    do p = 1, size(weight)
      from_center = xi(:, p) - field%center
      a(:, 1) = a(:, 1) + weight(p)*from_center*from_center(1)
      a(:, 2) = a(:, 2) + weight(p)*from_center*from_center(2)
      right(:, 1) = right(:, 1) + weight(p)*(value(:, p) - field%mean(:n))*from_center(1)
      right(:, 2) = right(:, 2) + weight(p)*(value(:, p) - field%mean(:n))*from_center(2)
    end do
    det = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    if (det <= (line_extent_ratio*(a(1, 1) + a(2, 2)))**2) return
    field%slope(:n, 1) = (right(:, 1)*a(2, 2) - right(:, 2)*a(2, 1))/det
    field%slope(:n, 2) = (right(:, 2)*a(1, 1) - right(:, 1)*a(1, 2))/det
  end subroutine fit_field

  !> The field at a point.
  pure function field_at(field, xi) result(value)
    type(linear_field_t), intent(in) :: field !! the field
    real(wp), intent(in) :: xi(2) !! where
    real(wp) :: value(field%n)

    associate (n => field%n, y => xi - field%center)
      value = field%mean(:n) + (field%slope(:n, 1)*y(1) + field%slope(:n, 2)*y(2))
    end associate
  end function field_at

  !> The field at a point, no further outside the range of the values it was fitted to than this
  !! many times their range.
  pure function bounded_field_at(field, xi, beyond) result(value)
    type(linear_field_t), intent(in) :: field !! the field
    real(wp), intent(in) :: xi(2) !! where
    real(wp), intent(in) :: beyond !! times the range
    real(wp) :: value(field%n), range(field%n)

    associate (n => field%n)
      range = beyond*(field%high(:n) - field%low(:n))
      value = min(field%high(:n) + range, max(field%low(:n) - range, field_at(field, xi)))
    end associate
  end function bounded_field_at
end module linear_fields

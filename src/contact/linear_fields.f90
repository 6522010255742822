!> Linear fields over a facet, fitted to values at points of it (doc/theory, "Segmentation").
module linear_fields
  use kinds, only: wp
  implicit none
  private
  public :: linear_field_t, fit_field, field_at, bounded_field_at

  !> Points that lie closer to a line than this share of their extent give no slope.
  real(wp), parameter :: flat = 1.0e-6_wp

  !> A field: its mean, its slopes, and the range of the values it was fitted to.
  type :: linear_field_t
    real(wp) :: center(2) = 0.0_wp !! (xi, eta) of the weighted mean of the points
    real(wp), allocatable :: mean(:) !! (values) weighted mean of the values
    real(wp), allocatable :: slope(:, :) !! (values, 2) by xi and eta
    real(wp), allocatable :: low(:) !! (values) smallest value
    real(wp), allocatable :: high(:) !! (values) largest value
  end type linear_field_t

contains

  !> Least squares with weights; constant where the points do not tell a slope, zero without points.
  pure subroutine fit_field(xi, weight, value, field)
    real(wp), intent(in) :: xi(:, :) !! (2, points) where
    real(wp), intent(in) :: weight(:) !! (points) positive weights
    real(wp), intent(in) :: value(:, :) !! (values, points) values
    type(linear_field_t), intent(out) :: field !! the field
    real(wp) :: a(2, 2), det, from_center(2), right(size(value, 1), 2)
    integer :: p

    allocate (field%mean(size(value, 1)), field%low(size(value, 1)), field%high(size(value, 1)), &
              source=0.0_wp)
    allocate (field%slope(size(value, 1), 2), source=0.0_wp)
    if (size(weight) == 0) return
    field%center = matmul(xi, weight)/sum(weight)
    field%mean = matmul(value, weight)/sum(weight)
    field%low = minval(value, 2)
    field%high = maxval(value, 2)
    a = 0.0_wp
    right = 0.0_wp
    do p = 1, size(weight)
      from_center = xi(:, p) - field%center
      a(:, 1) = a(:, 1) + weight(p)*from_center*from_center(1)
      a(:, 2) = a(:, 2) + weight(p)*from_center*from_center(2)
      right(:, 1) = right(:, 1) + weight(p)*(value(:, p) - field%mean)*from_center(1)
      right(:, 2) = right(:, 2) + weight(p)*(value(:, p) - field%mean)*from_center(2)
    end do
    det = a(1, 1)*a(2, 2) - a(1, 2)*a(2, 1)
    if (det <= (flat*(a(1, 1) + a(2, 2)))**2) return
    field%slope(:, 1) = (right(:, 1)*a(2, 2) - right(:, 2)*a(2, 1))/det
    field%slope(:, 2) = (right(:, 2)*a(1, 1) - right(:, 1)*a(1, 2))/det
  end subroutine fit_field

  !> The field at a point.
  pure function field_at(field, xi) result(value)
    type(linear_field_t), intent(in) :: field !! the field
    real(wp), intent(in) :: xi(2) !! where
    real(wp) :: value(size(field%mean))

    value = field%mean + matmul(field%slope, xi - field%center)
  end function field_at

  !> The field at a point, no further outside the range of the values it was fitted to than this
  !! many times their range.
  pure function bounded_field_at(field, xi, beyond) result(value)
    type(linear_field_t), intent(in) :: field !! the field
    real(wp), intent(in) :: xi(2) !! where
    real(wp), intent(in) :: beyond !! times the range
    real(wp) :: value(size(field%mean)), range(size(field%mean))

    range = beyond*(field%high - field%low)
    value = min(field%high + range, max(field%low - range, field_at(field, xi)))
  end function bounded_field_at
end module linear_fields

!> Vectors in space.
module vectors
  use kinds, only: wp
  implicit none
  private
  public :: identity, cross, determinant, dyad, invert, sum_products, find_extent, length, &
    norm_of, largest_of, product_of

  !> The unit matrix.
  real(wp), parameter :: identity(3, 3) = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, &
    0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])

  !> Numbers between these can be squared.
  real(wp), parameter :: least = 1.0e-140_wp, largest = 1.0e140_wp
  !> Numbers of a long list that are dealt with beside each other.
  integer, parameter :: lanes = 8

contains

  !> Vector product a x b.
  pure function cross(a, b) result(c)
    real(wp), intent(in) :: a(3) !! first vector
    real(wp), intent(in) :: b(3) !! second vector
    real(wp) :: c(3)

    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Length of a short vector: norm2 divides by the largest of its numbers, which few of them need.
  pure real(wp) function length(a)
    real(wp), intent(in) :: a(:) !! the vector
    real(wp) :: most

    most = maxval(abs(a))
    if (most > least .and. most < largest) then
      length = sqrt(dot_product(a, a))
    else
      length = norm2(a)
    end if
  end function length

  !> Length of a long list of numbers: norm2 divides each by the largest so far.
  pure real(wp) function norm_of(a)
    real(wp), intent(in), contiguous :: a(:, :) !! the numbers

    real(wp) :: most

    most = largest_of(a)
    if (most <= 0.0_wp .or. (most > least .and. most < largest)) then
      norm_of = sqrt(sum_of_squares(size(a), a))
    else
      norm_of = norm2(a)
    end if
  end function norm_of

  !> Sum of the squares of some numbers.
  pure real(wp) function sum_of_squares(n, a) result(total)
    integer, intent(in) :: n !! how many
    real(wp), intent(in) :: a(n) !! the numbers
    real(wp) :: part(lanes)
    integer :: i, j

    part = 0.0_wp
    do i = 1, n - lanes + 1, lanes
      do j = 1, lanes
        part(j) = part(j) + a(i + j - 1)**2
      end do
    end do
    total = sum(part) + sum(a(n - mod(n, lanes) + 1:)**2)
  end function sum_of_squares

  !> Largest magnitude of a long list of numbers, 0 if there are none.
  pure real(wp) function largest_of(a)
    real(wp), intent(in), contiguous :: a(:, :) !! the numbers

    largest_of = largest_magnitude(size(a), a)
  end function largest_of

  !> The same.
  pure real(wp) function largest_magnitude(n, a) result(most)
    integer, intent(in) :: n !! how many
    real(wp), intent(in) :: a(n) !! the numbers
    real(wp) :: part(lanes), now(lanes)
    integer :: i, j

    part = 0.0_wp
    do i = 1, n - lanes + 1, lanes
      now = abs(a(i:i + lanes - 1))
      do j = 1, lanes
        part(j) = merge(now(j), part(j), now(j) > part(j))
      end do
    end do
    most = maxval(part)
    do i = n - mod(n, lanes) + 1, n
      most = max(most, abs(a(i)))
    end do
  end function largest_magnitude

  !> The least and the largest coordinates of some places.
  pure subroutine find_extent(x, low, high)
    real(wp), intent(in) :: x(:, :) !! (3, places)
    real(wp), intent(out) :: low(3) !! least ones
    real(wp), intent(out) :: high(3) !! largest ones
    integer :: i

    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do i = 1, size(x, 2)
      low = min(low, x(:, i))
      high = max(high, x(:, i))
    end do
  end subroutine find_extent

  !> A v; nothing is called for it, unlike matmul with parts of arrays.
  pure function product_of(a, v) result(w)
    real(wp), intent(in) :: a(3, 3) !! a matrix
    real(wp), intent(in) :: v(3) !! a vector
    real(wp) :: w(3)

    w = a(:, 1)*v(1) + a(:, 2)*v(2) + a(:, 3)*v(3)
  end function product_of

  !> Determinant of three columns.
  pure real(wp) function determinant(a)
    real(wp), intent(in) :: a(3, 3) !! the matrix

    determinant = dot_product(a(:, 1), cross(a(:, 2), a(:, 3)))
  end function determinant

  !> Dyadic product: the matrix a_i b_j.
  pure function dyad(a, b) result(m)
    real(wp), intent(in) :: a(:) !! (n) first vector
    real(wp), intent(in) :: b(:) !! (m) second vector
    real(wp) :: m(size(a), size(b))
    integer :: j

    do j = 1, size(b)
      m(:, j) = a*b(j)
    end do
  end function dyad

  !> The sum of the products a_n b_n^T of the columns of two matrices.
  pure function sum_products(a, b) result(c)
    real(wp), intent(in) :: a(:, :) !! (3, n)
    real(wp), intent(in) :: b(:, :) !! (3, n)
    real(wp) :: c(3, 3)
    integer :: n, j

    c = 0.0_wp
    do n = 1, size(a, 2)
      do j = 1, 3
        c(:, j) = c(:, j) + a(:, n)*b(j, n)
      end do
    end do
  end function sum_products

  !> Inverse and determinant of a matrix of three rows.
  pure subroutine invert(a, inverse, determinant)
    real(wp), intent(in) :: a(3, 3) !! the matrix, not singular
    real(wp), intent(out) :: inverse(3, 3) !! its inverse
    real(wp), intent(out) :: determinant !! its determinant

    inverse(1, :) = cross(a(:, 2), a(:, 3))
    inverse(2, :) = cross(a(:, 3), a(:, 1))
    inverse(3, :) = cross(a(:, 1), a(:, 2))
    determinant = dot_product(a(:, 1), inverse(1, :))
    inverse = inverse/determinant
  end subroutine invert
end module vectors

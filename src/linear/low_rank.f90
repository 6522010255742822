!> The leading part of an element matrix as a sum of few columns times rows.
module low_rank
  use kinds, only: wp
  implicit none
  private
  public :: peel, largest_weighed

contains

  !> S = U V^T + rest: elimination with full pivoting, each entry weighed with the compliance of
  !! its row and column, until no entry counts any more or no column is left to write to.
  pure subroutine peel(s, weight, tolerance, u, v, rank)
    real(wp), intent(in) :: s(:, :) !! (n, n) the matrix [force/length]
    real(wp), intent(in) :: weight(:) !! (n) root of the compliance [(length/force)^1/2]
    real(wp), intent(in) :: tolerance !! weighed entries below this do not count
    real(wp), intent(out) :: u(:, :), v(:, :) !! (n, most) columns and rows
    integer, intent(out) :: rank !! how many there are
    real(wp) :: rest(size(s, 1), size(s, 1)), largest(size(s, 1))
    integer :: j, row, column

    rest = s
    do j = 1, size(s, 1)
      largest(j) = largest_entry(size(s, 1), rest(:, j), weight, weight(j))
    end do
    rank = 0
    do while (rank < size(u, 2))
      column = maxloc(largest, 1)
      if (.not. largest(column) > tolerance) exit
      row = maxloc(abs(rest(:, column))*weight*weight(column), 1)
      rank = rank + 1
      u(:, rank) = rest(:, column)
      v(:, rank) = rest(row, :)/rest(row, column)
      do j = 1, size(s, 1)
        rest(:, j) = rest(:, j) - u(:, rank)*v(j, rank)
        largest(j) = largest_entry(size(s, 1), rest(:, j), weight, weight(j))
      end do
    end do
  end subroutine peel

  !> The largest entry of a column, weighed. By four, so that none waits for the one before.
  pure real(wp) function largest_entry(n, column, weight, its_weight) result(largest)
    integer, intent(in) :: n !! its rows
    real(wp), intent(in) :: column(n) !! the column [force/length]
    real(wp), intent(in) :: weight(n) !! root of the compliance of its rows [(length/force)^1/2]
    real(wp), intent(in) :: its_weight !! and of its own
    real(wp) :: four(4)
    integer :: i, k

    four = 0.0_wp
    do i = 1, n - 3, 4
      do k = 1, 4
        four(k) = max(four(k), abs(column(i + k - 1))*weight(i + k - 1)*its_weight)
      end do
    end do
    largest = maxval(four)
    do i = n - modulo(n, 4) + 1, n
      largest = max(largest, abs(column(i))*weight(i)*its_weight)
    end do
  end function largest_entry

  !> The largest entry of a matrix, weighed with the compliance of its row and column.
  pure real(wp) function largest_weighed(s, weight) result(largest)
    real(wp), intent(in) :: s(:, :) !! (n, n) the matrix [force/length]
    real(wp), intent(in) :: weight(:) !! (n) root of the compliance [(length/force)^1/2]

    largest = maxval(abs(s)*spread(weight, 1, size(weight))*spread(weight, 2, size(weight)))
  end function largest_weighed
end module low_rank

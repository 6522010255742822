!> A sparse matrix of 3 x 3 blocks on the graph of the nodes.
!!
!! Columns of blocks, rows ascending within a column; the graph is symmetric, the values need not
!! be.
module block_matrix
  use kinds, only: wp
  implicit none
  private
  public :: block_matrix_t, find_block, find_column, multiply, multiply_some, reached_by, &
    multiply_absolute, sum_absolute

  !> Blocks of one matrix.
  type :: block_matrix_t
    integer :: nodes = 0 !! number of nodes
    integer, allocatable :: ptr(:) !! (nodes+1) first block of each column
    integer, allocatable :: row(:) !! (blocks) node of the row
    real(wp), allocatable :: val(:, :, :) !! (3, 3, blocks) values [force/length]
  end type block_matrix_t

contains

  !> Place of block (row, column), 0 if the graph does not hold it.
  pure integer function find_block(matrix, row, column) result(place)
    type(block_matrix_t), intent(in) :: matrix !! the matrix
    integer, intent(in) :: row !! node of the row
    integer, intent(in) :: column !! node of the column
    integer :: low, high, middle

    place = 0
    low = matrix%ptr(column)
    high = matrix%ptr(column + 1) - 1
    do while (low <= high)
      middle = (low + high)/2
      if (matrix%row(middle) == row) then
        place = middle
        return
      else if (matrix%row(middle) < row) then
        low = middle + 1
      else
        high = middle - 1
      end if
    end do
  end function find_block

  !> Places of some blocks of a column.
  pure subroutine find_column(matrix, rows, column, place)
    type(block_matrix_t), intent(in) :: matrix !! the matrix
    integer, intent(in) :: rows(:) !! nodes of their rows
    integer, intent(in) :: column !! node of the column
    integer, intent(out) :: place(:) !! (rows) 0 where there is none
    integer :: a

    do a = 1, size(rows)
      place(a) = find_block(matrix, rows(a), column)
    end do
  end subroutine find_column

  !> y = A x, by block columns; those where x is zero are passed over.
  pure subroutine multiply(matrix, x, y)
    type(block_matrix_t), intent(in) :: matrix !! A
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(out) :: y(:, :) !! (3, nodes)
    integer :: j, k

    y = 0.0_wp
    do j = 1, matrix%nodes
      if (all(abs(x(:, j)) <= 0.0_wp)) cycle
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        associate (i => matrix%row(k))
          y(:, i) = y(:, i) + matrix%val(:, 1, k)*x(1, j) + matrix%val(:, 2, k)*x(2, j) &
            + matrix%val(:, 3, k)*x(3, j)
        end associate
      end do
    end do
  end subroutine multiply

  !> y = A x at some nodes alone, with a symmetric A: the columns of these nodes hold their rows.
  pure subroutine multiply_some(matrix, wanted, x, y)
    type(block_matrix_t), intent(in) :: matrix !! A, symmetric
    logical, intent(in) :: wanted(:) !! (nodes) where y is wanted
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(inout) :: y(:, :) !! (3, nodes) elsewhere it stays
    integer :: j, k
    real(wp) :: total(3)

    do j = 1, matrix%nodes
      if (.not. wanted(j)) cycle
      total = 0.0_wp
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        associate (i => matrix%row(k))
          total = total + (x(1, i)*matrix%val(1, :, k) + x(2, i)*matrix%val(2, :, k) &
            + x(3, i)*matrix%val(3, :, k))
        end associate
      end do
      y(:, j) = total
    end do
  end subroutine multiply_some

  !> The nodes where A x may not be zero.
  pure function reached_by(matrix, x) result(reached)
    type(block_matrix_t), intent(in) :: matrix !! A
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    logical :: reached(matrix%nodes)
    integer :: j

    reached = .false.
    do j = 1, matrix%nodes
      if (any(abs(x(:, j)) > 0.0_wp)) &
        reached(matrix%row(matrix%ptr(j):matrix%ptr(j + 1) - 1)) = .true.
    end do
  end function reached_by

  !> y = |A| |x|: the size of the terms that A x sums, for estimates of round-off.
  pure subroutine multiply_absolute(matrix, x, y)
    type(block_matrix_t), intent(in) :: matrix !! A
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    real(wp), intent(out) :: y(:, :) !! (3, nodes)
    real(wp) :: size_x(3)
    integer :: j, k

    y = 0.0_wp
    do j = 1, matrix%nodes
      size_x = abs(x(:, j))
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        associate (i => matrix%row(k))
          y(:, i) = y(:, i) + (abs(matrix%val(:, 1, k))*size_x(1) &
            + abs(matrix%val(:, 2, k))*size_x(2) + abs(matrix%val(:, 3, k))*size_x(3))
        end associate
      end do
    end do
  end subroutine multiply_absolute

  !> Sums of |A| along the rows of each node: they make |A| |x| of an x that hardly changes from
  !! node to node.
  pure subroutine sum_absolute(matrix, total)
    type(block_matrix_t), intent(in) :: matrix !! A
    real(wp), intent(out) :: total(:, :, :) !! (3, 3, nodes)
    integer :: j, k

    total = 0.0_wp
    do j = 1, matrix%nodes
      do k = matrix%ptr(j), matrix%ptr(j + 1) - 1
        associate (i => matrix%row(k))
          total(:, :, i) = total(:, :, i) + abs(matrix%val(:, :, k))
        end associate
      end do
    end do
  end subroutine sum_absolute
end module block_matrix

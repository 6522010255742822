!> A lower triangle as a factorisation takes it: as blocks of nodes with one equation each.
module lower_blocks
  use kinds, only: wp
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t
  use ordered_blocks, only: ordered_blocks_t
  implicit none
  private
  public :: lower_blocks_t, take_lower

  !> The matrix, and what it points to.
  type :: lower_blocks_t
    type(block_matrix_t) :: blocks !! (1, 1) of each block counts
    integer, allocatable :: node(:), direction(:) !! (n) of the equations
    type(ordered_blocks_t) :: matrix !! in the order of the triangle
  end type lower_blocks_t

contains

  !> Makes both triangles of a symmetric matrix from the lower one.
  subroutine take_lower(a, lower)
    type(csc_matrix_t), intent(in) :: a !! its lower triangle
    type(lower_blocks_t), intent(inout), target :: lower !! becomes the same
    integer :: n, i, j, k, next(a%n)

    n = int(a%n)
    lower%blocks%nodes = n
    lower%blocks%ptr = spread(0, 1, n + 1)
    do j = 1, n
      do k = int(a%ptr(j)) + 1, int(a%ptr(j + 1))
        i = int(a%row(k)) + 1
        lower%blocks%ptr(j + 1) = lower%blocks%ptr(j + 1) + 1
        if (i /= j) lower%blocks%ptr(i + 1) = lower%blocks%ptr(i + 1) + 1
      end do
    end do
    lower%blocks%ptr(1) = 1
    do j = 1, n
      lower%blocks%ptr(j + 1) = lower%blocks%ptr(j + 1) + lower%blocks%ptr(j)
    end do
    next = lower%blocks%ptr(:n)
    lower%blocks%row = spread(0, 1, lower%blocks%ptr(n + 1) - 1)
    lower%blocks%val = spread(spread(spread(0.0_wp, 1, 3), 2, 3), 3, size(lower%blocks%row))
    do j = 1, n
      do k = int(a%ptr(j)) + 1, int(a%ptr(j + 1))
        i = int(a%row(k)) + 1
        call add(j, i, a%val(k))
        if (i /= j) call add(i, j, a%val(k))
      end do
    end do
    lower%node = [(j, j=1, n)]
    lower%direction = spread(1, 1, n)
    lower%matrix%equation = reshape([(j, 0, 0, j=1, n)], [3, n])
    lower%matrix%doubled = spread(.false., 1, n)
    lower%matrix%blocks => lower%blocks
    lower%matrix%node => lower%node
    lower%matrix%direction => lower%direction

  contains

    !> One entry of a column.
    subroutine add(column, row, value)
      integer, intent(in) :: column, row !! where it stands
      real(wp), intent(in) :: value !! the entry

      lower%blocks%row(next(column)) = row
      lower%blocks%val(1, 1, next(column)) = value
      next(column) = next(column) + 1
    end subroutine add
  end subroutine take_lower
end module lower_blocks

!> The free rows and columns of a block matrix as SuiteSparse wants them: compressed columns,
!! 0-based, long integers, rows ascending.
module csc_matrix
  use kinds, only: wp, long
  use block_matrix, only: block_matrix_t
  implicit none
  private
  public :: csc_matrix_t, build_pattern, fill_values

  !> A square matrix in compressed columns.
  type :: csc_matrix_t
    integer(long) :: n = 0 !! order
    integer(long), allocatable :: ptr(:) !! (n+1) first entry of each column, 0-based
    integer(long), allocatable :: row(:) !! row of each entry, 0-based
    real(wp), allocatable :: val(:) !! values
    logical :: changed = .true. !! values differ from those that were factorised last
  end type csc_matrix_t

contains

  !> Pattern of the free degrees of freedom.
  subroutine build_pattern(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(out) :: matrix !! pattern; values undefined
    integer :: node, j, k, i
    integer(long) :: filled, column

    matrix%n = maxval(equation)
    allocate (matrix%ptr(matrix%n + 1))
    filled = 0
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        column = equation(j, node)
        matrix%ptr(column) = filled
        filled = filled + free_rows(blocks, equation, node)
      end do
    end do
    matrix%ptr(matrix%n + 1) = filled
    allocate (matrix%row(filled))
    allocate (matrix%val(filled), source=0.0_wp)
    filled = 0
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
          do i = 1, 3
            if (equation(i, blocks%row(k)) == 0) cycle
            filled = filled + 1
            matrix%row(filled) = equation(i, blocks%row(k)) - 1
          end do
        end do
      end do
    end do
  end subroutine build_pattern

  !> Number of free rows in the column blocks of a node.
  pure integer function free_rows(blocks, equation, node) result(n)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    integer, intent(in) :: node !! node of the column
    integer :: k

    n = 0
    do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
      n = n + count(equation(:, blocks%row(k)) > 0)
    end do
  end function free_rows

  !> Copies the values of the free rows and columns, in the order of the pattern, and notes whether
  !! any of them is new.
  pure subroutine fill_values(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(inout) :: matrix !! gets val
    integer :: node, j, k, i
    integer(long) :: filled

    filled = 0
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
          do i = 1, 3
            if (equation(i, blocks%row(k)) == 0) cycle
            filled = filled + 1
            if (abs(matrix%val(filled) - blocks%val(i, j, k)) > 0.0_wp) matrix%changed = .true.
            matrix%val(filled) = blocks%val(i, j, k)
          end do
        end do
      end do
    end do
  end subroutine fill_values
end module csc_matrix

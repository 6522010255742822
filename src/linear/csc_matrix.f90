!> The free rows and columns of a block matrix as SuiteSparse wants them: compressed columns,
!! 0-based, long integers, rows ascending (in a lower triangle in no order).
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
    logical :: lower = .false. !! the lower triangle alone; rows are in no order
    logical :: changed = .true. !! values differ from those that were factorised last
  end type csc_matrix_t

contains

  !> Pattern of the free degrees of freedom, or of the lower triangle of these.
  subroutine build_pattern(blocks, equation, matrix, lower)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(out) :: matrix !! pattern; values undefined
    logical, intent(in), optional :: lower !! the lower triangle alone, rows in no order
    integer :: node, j, k, i, first
    integer(long) :: filled, column

    if (present(lower)) matrix%lower = lower
    matrix%n = maxval(equation)
    allocate (matrix%ptr(matrix%n + 1))
    matrix%ptr(1) = 0
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        matrix%ptr(equation(j, node) + 1) = free_rows(blocks, equation, node, &
          first_row(matrix, equation(j, node)))
      end do
    end do
    do column = 1, matrix%n
      matrix%ptr(column + 1) = matrix%ptr(column + 1) + matrix%ptr(column)
    end do
    filled = matrix%ptr(matrix%n + 1)
    allocate (matrix%row(filled))
    allocate (matrix%val(filled), source=0.0_wp)
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        first = first_row(matrix, equation(j, node))
        filled = matrix%ptr(equation(j, node))
        do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
          do i = 1, 3
            if (equation(i, blocks%row(k)) < first) cycle
            filled = filled + 1
            matrix%row(filled) = equation(i, blocks%row(k)) - 1
          end do
        end do
      end do
    end do
  end subroutine build_pattern

  !> The first equation that counts in a column.
  pure integer function first_row(matrix, column) result(first)
    type(csc_matrix_t), intent(in) :: matrix !! all of it or the lower triangle
    integer, intent(in) :: column !! equation of the column

    first = merge(column, 1, matrix%lower)
  end function first_row

  !> Number of free rows in the column blocks of a node.
  pure integer function free_rows(blocks, equation, node, first) result(n)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    integer, intent(in) :: node !! node of the column
    integer, intent(in) :: first !! the first equation that counts
    integer :: k

    n = 0
    do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
      n = n + count(equation(:, blocks%row(k)) >= first)
    end do
  end function free_rows

  !> Copies the values of the free rows and columns, in the order of the pattern, and notes whether
  !! any of them is new.
  pure subroutine fill_values(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(inout) :: matrix !! gets val
    integer :: node, j, k, i, first
    integer(long) :: filled

    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        first = first_row(matrix, equation(j, node))
        filled = matrix%ptr(equation(j, node))
        do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
          do i = 1, 3
            if (equation(i, blocks%row(k)) < first) cycle
            filled = filled + 1
            if (abs(matrix%val(filled) - blocks%val(i, j, k)) > 0.0_wp) matrix%changed = .true.
            matrix%val(filled) = blocks%val(i, j, k)
          end do
        end do
      end do
    end do
  end subroutine fill_values
end module csc_matrix

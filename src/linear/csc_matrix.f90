!> The free rows and columns of a block matrix as SuiteSparse wants them: compressed columns,
!! 0-based, long integers, rows ascending (in a lower triangle in no order).
module csc_matrix
  use kinds, only: wp, long
  use block_matrix, only: block_matrix_t
  implicit none
  private
  public :: csc_matrix_t, build_pattern, build_lower, fill_values

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

  !> Pattern of the free degrees of freedom.
  subroutine build_pattern(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(out) :: matrix !! pattern; values 0

    call list_rows(blocks, equation, matrix)
  end subroutine build_pattern

  !> The lower triangle of the free degrees of freedom with its values, rows in no order.
  subroutine build_lower(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(out) :: matrix !! pattern and values

    matrix%lower = .true.
    call list_rows(blocks, equation, matrix)
    call fill_values(blocks, equation, matrix)
  end subroutine build_lower

  !> The rows of each column, in the order in which fill_values comes to them.
  pure subroutine list_rows(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(inout) :: matrix !! lower given; gets the pattern, values 0
    integer :: node, j, k, i, first
    integer(long) :: filled

    call count_entries(blocks, equation, matrix)
    filled = matrix%ptr(matrix%n + 1)
    allocate (matrix%row(filled))
    allocate (matrix%val(filled), source=0.0_wp)
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        first = merge(equation(j, node), 1, matrix%lower)
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
  end subroutine list_rows

  !> Order of the matrix, and where its columns begin.
  pure subroutine count_entries(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(inout) :: matrix !! lower given; gets n, ptr
    integer :: node, j, k, first, column
    integer(long) :: n

    matrix%n = maxval(equation)
    allocate (matrix%ptr(matrix%n + 1))
    matrix%ptr(1) = 0
    do node = 1, blocks%nodes
      do j = 1, 3
        column = equation(j, node)
        if (column == 0) cycle
        first = merge(column, 1, matrix%lower)
        n = 0
        do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
          n = n + count(equation(:, blocks%row(k)) >= first)
        end do
        matrix%ptr(column + 1) = n
      end do
    end do
    do n = 1, matrix%n
      matrix%ptr(n + 1) = matrix%ptr(n + 1) + matrix%ptr(n)
    end do
  end subroutine count_entries

  !> Copies the values of the free rows and columns, in the order of list_rows, and notes
  !! whether any of them is new.
  pure subroutine fill_values(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(inout) :: matrix !! gets val
    integer :: node, j, k, i, first
    integer(long) :: filled

    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        first = merge(equation(j, node), 1, matrix%lower)
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

!> The free rows and columns of a block matrix as SuiteSparse wants them: compressed columns,
!! 0-based, long integers, rows ascending (in a lower triangle in no order).
module csc_matrix
  use kinds, only: wp, long
  use block_matrix, only: block_matrix_t
  use lower_columns, only: lower_columns_t
  implicit none
  private
  public :: csc_matrix_t, build_pattern, build_lower, fill_values

  !> A square matrix in compressed columns. Its lower triangle can be factorised as it stands.
  type, extends(lower_columns_t) :: csc_matrix_t
    integer(long) :: n = 0 !! order
    integer(long), allocatable :: ptr(:) !! (n+1) first entry of each column, 0-based
    integer(long), allocatable :: row(:) !! row of each entry, 0-based
    real(wp), allocatable :: val(:) !! values
    logical :: lower = .false. !! the lower triangle alone; rows are in no order
    logical :: changed = .true. !! values differ from those that were factorised last
  contains
    procedure :: order
    procedure :: gather
    procedure :: multiply
    procedure :: largest
  end type csc_matrix_t

contains

  !> Pattern of the free degrees of freedom.
  subroutine build_pattern(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(out) :: matrix !! pattern; values 0
    integer :: node, j, k, i
    integer(long) :: filled

    call count_entries(blocks, equation, matrix)
    filled = matrix%ptr(matrix%n + 1)
    allocate (matrix%row(filled))
    allocate (matrix%val(filled), source=0.0_wp)
    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        filled = matrix%ptr(equation(j, node))
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

  !> The lower triangle of the free degrees of freedom with its values, rows in no order.
  subroutine build_lower(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(out) :: matrix !! pattern and values
    integer :: node, j, k, i, row, column
    integer(long) :: filled

    matrix%lower = .true.
    call count_entries(blocks, equation, matrix)
    allocate (matrix%row(matrix%ptr(matrix%n + 1)), matrix%val(matrix%ptr(matrix%n + 1)))
    do node = 1, blocks%nodes
      do j = 1, 3
        column = equation(j, node)
        if (column == 0) cycle
        filled = matrix%ptr(column)
        do k = blocks%ptr(node), blocks%ptr(node + 1) - 1
          do i = 1, 3
            row = equation(i, blocks%row(k))
            if (row < column) cycle
            filled = filled + 1
            matrix%row(filled) = row - 1
            matrix%val(filled) = blocks%val(i, j, k)
          end do
        end do
      end do
    end do
  end subroutine build_lower

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

  !> Copies the values of the free rows and columns, in the order of build_pattern, and notes
  !! whether any of them is new.
  pure subroutine fill_values(blocks, equation, matrix)
    type(block_matrix_t), intent(in) :: blocks !! matrix of all degrees of freedom
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(csc_matrix_t), intent(inout) :: matrix !! gets val
    integer :: node, j, k, i
    integer(long) :: filled

    do node = 1, blocks%nodes
      do j = 1, 3
        if (equation(j, node) == 0) cycle
        filled = matrix%ptr(equation(j, node))
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

  !> Order of the matrix.
  pure integer function order(a) result(n)
    class(csc_matrix_t), intent(in) :: a !! the matrix

    n = int(a%n)
  end function order

  !> Some columns of a lower triangle.
  subroutine gather(a, first, last, place, rows, panel)
    class(csc_matrix_t), intent(in) :: a !! the matrix
    integer, intent(in) :: first, last !! the columns
    integer, intent(in) :: place(:) !! (n) row of the panel that each row of them belongs to
    integer, intent(in) :: rows !! of the panel
    real(wp), intent(out) :: panel(rows, last - first + 1) !! values
    integer :: j
    integer(long) :: k

    panel = 0.0_wp
    do j = first, last
      do k = a%ptr(j) + 1, a%ptr(j + 1)
        panel(place(a%row(k) + 1), j - first + 1) = a%val(k)
      end do
    end do
  end subroutine gather

  !> y = A x for the lower triangle of a symmetric matrix.
  pure function multiply(a, x) result(y)
    class(csc_matrix_t), intent(in) :: a !! the matrix
    real(wp), intent(in) :: x(:) !! (n)
    real(wp) :: y(size(x))
    integer(long) :: j, k, row

    y = 0.0_wp
    do j = 1, a%n
      do k = a%ptr(j) + 1, a%ptr(j + 1)
        row = a%row(k) + 1
        y(row) = y(row) + a%val(k)*x(j)
        if (row /= j) y(j) = y(j) + a%val(k)*x(row)
      end do
    end do
  end function multiply

  !> The largest entry, without its sign.
  pure real(wp) function largest(a) result(most)
    class(csc_matrix_t), intent(in) :: a !! the matrix

    most = maxval(abs(a%val(:a%ptr(a%n + 1))))
  end function largest
end module csc_matrix

!> The matrix of a body as its factorisation takes it: columns from the blocks of all bodies, in the
!! order of elimination, without a copy of it (doc/theory, "Sparse factorisation").
module ordered_blocks
  use kinds, only: wp
  use block_matrix, only: block_matrix_t
  implicit none
  private
  public :: ordered_blocks_t, gather_columns, multiply_ordered, largest_entry

  !> Some equations of a symmetric block matrix.
  type :: ordered_blocks_t
    type(block_matrix_t), pointer :: blocks => null() !! matrix of all degrees of freedom
    integer, allocatable :: equation(:, :) !! (3, nodes) place in the order of elimination, or 0
    integer, pointer, contiguous :: node(:) => null(), direction(:) => null() !! (n) where each
    !! equation belongs
    logical, allocatable :: doubled(:) !! (n) its entry on the diagonal counts twice
  end type ordered_blocks_t

contains

  !> Some columns, from the diagonal on, with zeros where there are no entries.
  pure subroutine gather_columns(a, first, last, place, rows, panel)
    type(ordered_blocks_t), intent(in) :: a !! the matrix
    integer, intent(in) :: first, last !! the columns
    integer, intent(in) :: place(:) !! (n) row of the panel that each row of them belongs to
    integer, intent(in) :: rows !! of the panel
    real(wp), intent(out) :: panel(rows, last - first + 1) !! values
    integer :: j, k, i, row

    panel = 0.0_wp
    do j = first, last
      associate (node => a%node(j), direction => a%direction(j), column => panel(:, j - first + 1))
        do k = a%blocks%ptr(node), a%blocks%ptr(node + 1) - 1
          do i = 1, 3
            row = a%equation(i, a%blocks%row(k))
            if (row >= j) column(place(row)) = a%blocks%val(i, direction, k)
          end do
        end do
        if (a%doubled(j)) column(place(j)) = 2.0_wp*column(place(j))
      end associate
    end do
  end subroutine gather_columns

  !> y = A x; the columns hold the rows of a symmetric matrix.
  pure function multiply_ordered(a, x) result(y)
    type(ordered_blocks_t), intent(in) :: a !! the matrix
    real(wp), intent(in) :: x(:) !! (n)
    real(wp) :: y(size(x))
    integer :: j, k, i, row

    do j = 1, size(y)
      y(j) = 0.0_wp
      do k = a%blocks%ptr(a%node(j)), a%blocks%ptr(a%node(j) + 1) - 1
        do i = 1, 3
          row = a%equation(i, a%blocks%row(k))
          if (row == 0) cycle
          y(j) = y(j) + a%blocks%val(i, a%direction(j), k)*x(row)
          if (row == j .and. a%doubled(j)) y(j) = y(j) + a%blocks%val(i, a%direction(j), k)*x(j)
        end do
      end do
    end do
  end function multiply_ordered

  !> The largest entry, without its sign.
  pure real(wp) function largest_entry(a) result(most)
    type(ordered_blocks_t), intent(in) :: a !! the matrix
    integer :: j

    most = 0.0_wp
    do j = 1, size(a%node)
      most = max(most, maxval(abs(a%blocks%val(:, a%direction(j), &
        a%blocks%ptr(a%node(j)):a%blocks%ptr(a%node(j) + 1) - 1))))
    end do
    if (any(a%doubled)) most = 2.0_wp*most
  end function largest_entry
end module ordered_blocks

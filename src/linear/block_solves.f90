!> Solves with the LU factors of a dense matrix for a few right-hand sides: in blocks so small that
!! BLAS copies none of them first, which takes longer than the solve.
module block_solves
  use kinds, only: wp
  use lapack_interface, only: dgemm, dlaswp, dtrsm
  implicit none
  private
  public :: solve_block

  !> Rows of a diagonal block.
  integer, parameter :: width = 48

contains

  !> z = A^-1 z, as dgetrs does.
  subroutine solve_block(n, columns, rows_of_lu, lu, pivot, z)
    integer, intent(in) :: n !! order of the matrix
    integer, intent(in) :: columns !! right-hand sides
    integer, intent(in) :: rows_of_lu !! of the array
    real(wp), intent(in) :: lu(rows_of_lu, *) !! factors by dgetrf
    integer, intent(in) :: pivot(:) !! (n) its exchanges of rows
    real(wp), intent(inout) :: z(n, columns) !! in: right-hand sides; out: the solution
    integer :: first, rows, rest

    call dlaswp(columns, z, n, 1, n, pivot, 1)
    do first = 1, n, width
      rows = min(width, n - first + 1)
      call dtrsm('L', 'L', 'N', 'U', rows, columns, 1.0_wp, lu(first, first), rows_of_lu, &
        z(first, 1), n)
      rest = n - first - rows + 1
      if (rest > 0) call dgemm('N', 'N', rest, columns, rows, -1.0_wp, lu(first + rows, first), &
        rows_of_lu, z(first, 1), n, 1.0_wp, z(first + rows, 1), n)
    end do
    do first = (n - 1)/width*width + 1, 1, -width
      rows = min(width, n - first + 1)
      call dtrsm('L', 'U', 'N', 'N', rows, columns, 1.0_wp, lu(first, first), rows_of_lu, &
        z(first, 1), n)
      if (first > 1) call dgemm('N', 'N', first - 1, columns, rows, -1.0_wp, lu(1, first), &
        rows_of_lu, z(first, 1), n, 1.0_wp, z, n)
    end do
  end subroutine solve_block
end module block_solves

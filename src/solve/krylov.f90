!> The pieces of GMRES that its callers share.
module krylov
  use kinds, only: wp
  implicit none
  private
  public :: orthogonalise, rotate

contains

  !> Makes the last vector orthogonal to those before, and one long.
  pure subroutine orthogonalise(base, h)
    real(wp), intent(inout) :: base(:, :) !! (n, j+1) vectors
    real(wp), intent(out) :: h(:) !! (j+1) what was taken off, and the length of the rest
    integer :: i, last

    last = size(base, 2)
    do i = 1, last - 1
      h(i) = dot_product(base(:, i), base(:, last))
      base(:, last) = base(:, last) - h(i)*base(:, i)
    end do
    h(last) = norm2(base(:, last))
    if (h(last) > 0.0_wp) base(:, last) = base(:, last)/h(last)
  end subroutine orthogonalise

  !> Givens' rotations of the last column and of the right-hand side.
  pure subroutine rotate(j, h, g, cosine, sine)
    integer, intent(in) :: j !! the column
    real(wp), intent(inout) :: h(:, :) !! Hessenberg matrix; becomes triangular
    real(wp), intent(inout) :: g(:) !! right-hand side
    real(wp), intent(inout) :: cosine(:), sine(:) !! of the rotations
    real(wp) :: held
    integer :: i

    do i = 1, j - 1
      held = h(i, j)
      h(i, j) = cosine(i)*held + sine(i)*h(i + 1, j)
      h(i + 1, j) = cosine(i)*h(i + 1, j) - sine(i)*held
    end do
    held = hypot(h(j, j), h(j + 1, j))
    cosine(j) = 1.0_wp
    sine(j) = 0.0_wp
    if (held > 0.0_wp) then
      cosine(j) = h(j, j)/held
      sine(j) = h(j + 1, j)/held
    end if
    h(j, j) = held
    h(j + 1, j) = 0.0_wp
    g(j + 1) = -sine(j)*g(j)
    g(j) = cosine(j)*g(j)
  end subroutine rotate
end module krylov

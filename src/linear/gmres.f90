!> GMRES by hand: the caller applies the matrix to one vector after the other.
module gmres
  use kinds, only: wp
  implicit none
  private
  public :: gmres_t, begin_gmres, add_image, gmres_shares, gmres_solution

  !> Vectors so far and their least squares problem.
  type :: gmres_t
    integer :: n = 0 !! images so far
    real(wp) :: rest = 0.0_wp !! norm of the residual
    real(wp), allocatable :: base(:, :) !! (size of b, most+1) orthonormal; the matrix is to be
    !! applied to base(:, n+1) next
    real(wp), allocatable :: h(:, :) !! (most+1, most) triangular
    real(wp), allocatable :: g(:) !! (most+1) right-hand side
    real(wp), allocatable :: cosine(:), sine(:) !! (most) of the rotations
  end type gmres_t

contains

  !> Begins with x = 0. Room of an earlier course is used again where it fits.
  pure subroutine begin_gmres(b, most, iteration)
    real(wp), intent(in) :: b(:) !! right-hand side
    integer, intent(in) :: most !! images at most
    type(gmres_t), intent(inout) :: iteration !! begins

    if (allocated(iteration%base)) then
      if (any(shape(iteration%base) /= [size(b), most + 1])) deallocate (iteration%base, &
        iteration%h, iteration%g, iteration%cosine, iteration%sine)
    end if
    if (.not. allocated(iteration%base)) allocate (iteration%base(size(b), most + 1), &
      iteration%h(most + 1, most), iteration%g(most + 1), iteration%cosine(most), &
      iteration%sine(most))
    iteration%n = 0
    iteration%h = 0.0_wp
    iteration%g = 0.0_wp
    iteration%rest = norm2(b)
    iteration%g(1) = iteration%rest
    iteration%base(:, 1) = b
    if (iteration%rest > 0.0_wp) iteration%base(:, 1) = b/iteration%rest
  end subroutine begin_gmres

  !> Takes what the matrix makes of the last vector.
  pure subroutine add_image(image, iteration)
    real(wp), intent(in) :: image(:) !! A base(:, n+1)
    type(gmres_t), intent(inout) :: iteration !! one vector more
    integer :: j

    j = iteration%n + 1
    iteration%n = j
    iteration%base(:, j + 1) = image
    call orthogonalise(iteration%base(:, :j + 1), iteration%h(:j + 1, j))
    call rotate(j, iteration%h, iteration%g, iteration%cosine, iteration%sine)
    iteration%rest = abs(iteration%g(j + 1))
  end subroutine add_image

  !> Shares of the vectors in the x of the smallest residual so far.
  pure function gmres_shares(iteration) result(y)
    type(gmres_t), intent(in) :: iteration !! vectors so far
    real(wp) :: y(iteration%n)
    integer :: i, n

    n = iteration%n
    y = 0.0_wp
    if (n > 0) then
      if (abs(iteration%h(n, n)) <= 0.0_wp) n = n - 1
    end if
    do i = n, 1, -1
      y(i) = (iteration%g(i) - dot_product(iteration%h(i, i + 1:n), y(i + 1:n)))/iteration%h(i, i)
    end do
  end function gmres_shares

  !> The x of the smallest residual so far.
  pure subroutine gmres_solution(iteration, x)
    type(gmres_t), intent(in) :: iteration !! vectors so far
    real(wp), intent(out) :: x(:) !! the solution
    real(wp) :: y(iteration%n)
    integer :: i

    y = gmres_shares(iteration)
    x = 0.0_wp
    do i = iteration%n, 1, -1
      x = x + y(i)*iteration%base(:, i)
    end do
  end subroutine gmres_solution

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
end module gmres

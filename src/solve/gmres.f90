!> GMRES by hand: the caller applies the matrix to one vector after the other.
module gmres
  use kinds, only: wp
  use krylov, only: orthogonalise, rotate
  implicit none
  private
  public :: gmres_t, begin_gmres, add_image, gmres_solution

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

  !> Begins with x = 0.
  pure subroutine begin_gmres(b, most, iteration)
    real(wp), intent(in) :: b(:) !! right-hand side
    integer, intent(in) :: most !! images at most
    type(gmres_t), intent(out) :: iteration !! begins

    allocate (iteration%base(size(b), most + 1), iteration%h(most + 1, most), &
      iteration%g(most + 1), iteration%cosine(most), iteration%sine(most), source=0.0_wp)
    iteration%rest = norm2(b)
    iteration%g(1) = iteration%rest
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

  !> The x of the smallest residual so far.
  pure subroutine gmres_solution(iteration, x)
    type(gmres_t), intent(in) :: iteration !! vectors so far
    real(wp), intent(out) :: x(:) !! the solution
    real(wp) :: y(iteration%n)
    integer :: i, n

    n = iteration%n
    x = 0.0_wp
    if (n > 0) then
      if (abs(iteration%h(n, n)) <= 0.0_wp) n = n - 1
    end if
    do i = n, 1, -1
      y(i) = (iteration%g(i) - dot_product(iteration%h(i, i + 1:n), y(i + 1:n)))/iteration%h(i, i)
      x = x + y(i)*iteration%base(:, i)
    end do
  end subroutine gmres_solution
end module gmres

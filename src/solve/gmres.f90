!> GMRES by hand: the caller applies the matrix to one vector after the other.
module gmres
  use kinds, only: wp
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
    real(wp) :: held
    integer :: i, j

    j = iteration%n + 1
    iteration%n = j
    associate (base => iteration%base, h => iteration%h, g => iteration%g, &
               c => iteration%cosine, s => iteration%sine)
      base(:, j + 1) = image
      do i = 1, j
        h(i, j) = dot_product(base(:, i), base(:, j + 1))
        base(:, j + 1) = base(:, j + 1) - h(i, j)*base(:, i)
      end do
      held = norm2(base(:, j + 1))
      if (held > 0.0_wp) base(:, j + 1) = base(:, j + 1)/held
      do i = 1, j - 1
        h(i:i + 1, j) = [c(i)*h(i, j) + s(i)*h(i + 1, j), c(i)*h(i + 1, j) - s(i)*h(i, j)]
      end do
      c(j) = 1.0_wp
      s(j) = 0.0_wp
      if (hypot(h(j, j), held) > 0.0_wp) then
        c(j) = h(j, j)/hypot(h(j, j), held)
        s(j) = held/hypot(h(j, j), held)
      end if
      h(j, j) = hypot(h(j, j), held)
      g(j:j + 1) = [c(j)*g(j), -s(j)*g(j)]
      iteration%rest = abs(g(j + 1))
    end associate
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

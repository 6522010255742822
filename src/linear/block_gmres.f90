!> GMRES by hand for several right-hand sides of one matrix: each finds its x among the vectors of
!! all of them (doc/theory, "Derivatives along the path"). The caller applies the matrix.
module block_gmres
  use kinds, only: wp
  use lapack_interface, only: dgemm
  implicit none
  private
  public :: block_gmres_t, begin_block, add_images, block_shares

  !> Vectors so far and the least squares problems of all right-hand sides.
  type :: block_gmres_t
    integer :: m = 0 !! vectors so far
    integer :: n = 0 !! images so far; the matrix is to be applied to base(:, n+1:m) next
    real(wp), allocatable :: base(:, :) !! (size of b, most) orthonormal
    real(wp), allocatable :: h(:, :) !! (most, most) triangular
    real(wp), allocatable :: g(:, :) !! (most, right-hand sides) those in the vectors
    integer, allocatable :: last(:) !! (most) last row of each column of h before its rotations
    real(wp), allocatable :: cosine(:, :), sine(:, :) !! (right-hand sides, most) of these
    real(wp), allocatable :: rest(:) !! (right-hand sides) norms of the residuals
  end type block_gmres_t

  !> A vector is a combination of others if no more than this share of it is left beside them.
  real(wp), parameter :: dependent = 1.0e-15_wp

contains

  !> Begins with x = 0. Room of an earlier course is used again where it fits.
  subroutine begin_block(b, most, iteration)
    real(wp), intent(in) :: b(:, :) !! (size, right-hand sides)
    integer, intent(in) :: most !! vectors at most
    type(block_gmres_t), intent(inout) :: iteration !! begins
    integer :: j

    if (allocated(iteration%base)) then
      if (any(shape(iteration%base) /= [size(b, 1), most]) .or. &
        size(iteration%rest) /= size(b, 2)) deallocate (iteration%base, iteration%h, iteration%g, &
        iteration%last, iteration%cosine, iteration%sine, iteration%rest)
    end if
    if (.not. allocated(iteration%base)) allocate (iteration%base(size(b, 1), most), &
      iteration%h(most, most), iteration%g(most, size(b, 2)), iteration%last(most), &
      iteration%cosine(size(b, 2), most), iteration%sine(size(b, 2), most), &
      iteration%rest(size(b, 2)))
    iteration%m = 0
    iteration%n = 0
    iteration%h = 0.0_wp
    iteration%g = 0.0_wp
    do j = 1, size(b, 2)
      iteration%rest(j) = norm2(b(:, j))
      call append(b(:, j), iteration%rest(j), 0, iteration, iteration%g(:, j))
    end do
  end subroutine begin_block

  !> Takes what the matrix makes of the vectors base(:, n+1:m): all of them at once.
  subroutine add_images(images, iteration)
    real(wp), intent(in) :: images(:, :) !! A base(:, n+1:m)
    type(block_gmres_t), intent(inout) :: iteration !! more vectors
    real(wp) :: taken(iteration%m, size(images, 2)), left(size(images, 1), size(images, 2))
    integer :: i, k, old, turn

    old = iteration%m
    left = images
    associate (rows => size(images, 1), columns => size(images, 2))
      do turn = 1, 2
        call dgemm('T', 'N', old, columns, rows, 1.0_wp, iteration%base, rows, left, rows, &
          0.0_wp, taken, old)
        call dgemm('N', 'N', rows, columns, old, -1.0_wp, iteration%base, rows, taken, old, &
          1.0_wp, left, rows)
        do i = 1, columns
          iteration%h(:old, iteration%n + i) = iteration%h(:old, iteration%n + i) + taken(:, i)
        end do
      end do
      do i = 1, columns
        k = iteration%n + 1
        iteration%n = k
        call append(left(:, i), norm2(images(:, i)), old, iteration, iteration%h(:, k))
        iteration%last(k) = iteration%m
        call rotate(iteration, k)
      end do
    end associate
    do i = 1, size(iteration%rest)
      iteration%rest(i) = norm2(iteration%g(iteration%n + 1:iteration%m, i))
    end do
  end subroutine add_images

  !> Shares of the vectors in the x of the smallest residual of each right-hand side.
  pure function block_shares(iteration) result(y)
    type(block_gmres_t), intent(in) :: iteration !! vectors so far
    real(wp) :: y(iteration%n, size(iteration%rest))
    integer :: i, j

    y = 0.0_wp
    do j = 1, size(y, 2)
      do i = iteration%n, 1, -1
        if (abs(iteration%h(i, i)) <= 0.0_wp) cycle
        y(i, j) = (iteration%g(i, j) - dot_product(iteration%h(i, i + 1:iteration%n), &
          y(i + 1:, j)))/iteration%h(i, i)
      end do
    end do
  end function block_shares

  !> Makes a vector orthogonal to the last ones, twice, and adds what is left of it, one long.
  subroutine append(vector, length, old, iteration, shares)
    real(wp), intent(in) :: vector(:) !! the vector, orthogonal to the first ones
    real(wp), intent(in) :: length !! that it had at first
    integer, intent(in) :: old !! vectors that it is orthogonal to
    type(block_gmres_t), intent(inout) :: iteration !! gets it, if anything is left
    real(wp), intent(inout) :: shares(:) !! (most) of the vectors in it: grows by those of the last
    real(wp) :: left(size(vector)), share
    integer :: i, turn

    left = vector
    do turn = 1, 2
      do i = old + 1, iteration%m
        share = dot_product(iteration%base(:, i), left)
        left = left - share*iteration%base(:, i)
        shares(i) = shares(i) + share
      end do
    end do
    share = norm2(left)
    if (share <= dependent*length .or. iteration%m >= size(iteration%base, 2)) return
    iteration%m = iteration%m + 1
    iteration%base(:, iteration%m) = left/share
    shares(iteration%m) = share
  end subroutine append

  !> Givens' rotations of column k, whose rows end at last(k), and of the right-hand sides: from the
  !! last row up.
  subroutine rotate(iteration, k)
    type(block_gmres_t), intent(inout) :: iteration !! h becomes triangular
    integer, intent(in) :: k !! the column
    real(wp) :: length
    integer :: c, r, j

    associate (h => iteration%h, last => iteration%last, cosine => iteration%cosine, sine => &
      iteration%sine)
      do c = 1, k - 1
        do r = last(c), c + 1, -1
          call turn(cosine(r - c, c), sine(r - c, c), h(r - 1, k), h(r, k))
        end do
      end do
      do r = last(k), k + 1, -1
        length = hypot(h(r - 1, k), h(r, k))
        cosine(r - k, k) = 1.0_wp
        sine(r - k, k) = 0.0_wp
        if (length > 0.0_wp) then
          cosine(r - k, k) = h(r - 1, k)/length
          sine(r - k, k) = h(r, k)/length
        end if
        h(r - 1, k) = length
        h(r, k) = 0.0_wp
        do j = 1, size(iteration%rest)
          call turn(cosine(r - k, k), sine(r - k, k), iteration%g(r - 1, j), iteration%g(r, j))
        end do
      end do
    end associate
  end subroutine rotate

  !> A rotation of two numbers.
  pure subroutine turn(cosine, sine, a, b)
    real(wp), intent(in) :: cosine, sine !! of the angle
    real(wp), intent(inout) :: a, b !! the numbers
    real(wp) :: held

    held = cosine*a + sine*b
    b = cosine*b - sine*a
    a = held
  end subroutine turn
end module block_gmres

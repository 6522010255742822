!> GMRES by hand for several right-hand sides of one matrix: each finds its x among the directions
!! of all of them (doc/theory, "Sensitivities along the path"). The caller applies the matrix.
module block_gmres
  use kinds, only: wp
  use lapack_interface, only: dgemm, dgemv, ddot
  implicit none
  private
  public :: block_gmres_t, begin_block, add_images, block_shares, lengths

  !> Directions so far, their images, and what these leave of all right-hand sides.
  type :: block_gmres_t
    integer :: n = 0 !! directions whose images are known
    integer :: m = 0 !! directions; the matrix is to be applied to base(:, n+1:m) next
    real(wp), allocatable :: base(:, :) !! (size of b, most) directions
    real(wp), allocatable :: image(:, :) !! (size of b, most) orthonormal; A base = image h
    real(wp), allocatable :: h(:, :) !! (most, most) triangular
    real(wp), allocatable :: g(:, :) !! (most, right-hand sides) those in the images
    real(wp), allocatable :: left(:, :) !! (size of b, right-hand sides) residuals
    real(wp), allocatable :: rest(:) !! (right-hand sides) norms of the residuals
    real(wp), allocatable :: floor(:) !! (right-hand sides) norms that are small enough
  end type block_gmres_t

  !> An image is made orthogonal to the others once more if it has lost more than this of itself.
  real(wp), parameter :: short = 0.1_wp
  !> An image is a combination of others if no more than this share of it is left beside them.
  real(wp), parameter :: dependent_image = 1.0e-15_wp
  !> A residual of this share of its right-hand side is none.
  real(wp), parameter :: vanished_residual = 1.0e-16_wp
  !> A residual is one of the next directions if what it has beside the others, over its floor, is
  !! at least this share of the largest residual over its own. What has less can wait.
  real(wp), parameter :: pressing = 1.0e-6_wp
  !> Squares whose root is exact; others may have lost what they are made of.
  real(wp), parameter :: least_square = 1.0e-250_wp, largest_square = 1.0e250_wp

contains

  !> Begins with x = 0. Room of an earlier course is used again where it fits.
  subroutine begin_block(b, floor, most, iteration)
    real(wp), intent(in) :: b(:, :) !! (size, right-hand sides)
    real(wp), intent(in) :: floor(:) !! (right-hand sides) norms of residuals that are small enough
    integer, intent(in) :: most !! directions at most
    type(block_gmres_t), intent(inout) :: iteration !! begins

    if (allocated(iteration%base)) then
      if (any(shape(iteration%base) /= [size(b, 1), most]) .or. &
        size(iteration%rest) /= size(b, 2)) deallocate (iteration%base, iteration%image, &
        iteration%h, iteration%g)
    end if
    if (.not. allocated(iteration%base)) allocate (iteration%base(size(b, 1), most), &
      iteration%image(size(b, 1), most), iteration%h(most, most), iteration%g(most, size(b, 2)))
    iteration%n = 0
    iteration%left = b
    iteration%rest = lengths(b)
    iteration%floor = max(floor, vanished_residual*iteration%rest)
    call choose_directions(iteration)
  end subroutine begin_block

  !> The next directions: residuals above their floor, made orthogonal to each other, the largest
  !! first.
  subroutine choose_directions(iteration)
    type(block_gmres_t), intent(inout) :: iteration !! gets m, base
    real(wp) :: beside(size(iteration%left, 1), size(iteration%rest))
    real(wp) :: excess(size(iteration%rest)), largest, share(size(iteration%rest))
    integer :: j, i
    logical :: wanting(size(iteration%rest))

    associate (base => iteration%base, m => iteration%m, rows => size(beside, 1), sides => &
      size(beside, 2))
      m = iteration%n
      wanting = iteration%rest > iteration%floor
      beside = iteration%left
      excess = 0.0_wp
      where (wanting) excess = iteration%rest/iteration%floor
      largest = maxval(excess)
      do while (any(wanting) .and. m < size(base, 2))
        j = maxloc(excess, 1, wanting)
        if (m > iteration%n .and. excess(j) <= max(1.0_wp, pressing*largest)) exit
        m = m + 1
        base(:, m) = beside(:, j)/norm_of(beside(:, j))
        wanting(j) = .false.
        call dgemv('T', rows, sides, 1.0_wp, beside, rows, base(1, m), 1, 0.0_wp, share, 1)
        call dgemm('N', 'N', rows, sides, 1, -1.0_wp, base(1, m), rows, share, 1, 1.0_wp, beside, &
          rows)
        do i = 1, sides
          if (wanting(i)) excess(i) = norm_of(beside(:, i))/iteration%floor(i)
        end do
      end do
    end associate
  end subroutine choose_directions

  !> Takes what the matrix makes of the directions base(:, n+1:m): all of them at once.
  subroutine add_images(images, iteration)
    real(wp), intent(in) :: images(:, :) !! A base(:, n+1:m)
    type(block_gmres_t), intent(inout) :: iteration !! more directions
    real(wp) :: taken(iteration%n, size(images, 2)), left(size(images, 1), size(images, 2))
    real(wp) :: g(size(images, 2), size(iteration%rest))
    real(wp) :: long(size(images, 2))
    integer :: i, old, turn

    old = iteration%n
    left = images
    long = lengths(images)
    iteration%h(:iteration%m, old + 1:iteration%m) = 0.0_wp
    associate (rows => size(images, 1), columns => size(images, 2), sides => size(iteration%rest))
      do turn = 1, 2
        if (old == 0) exit
        call dgemm('T', 'N', old, columns, rows, 1.0_wp, iteration%image, rows, left, rows, &
          0.0_wp, taken, old)
        call dgemm('N', 'N', rows, columns, old, -1.0_wp, iteration%image, rows, taken, old, &
          1.0_wp, left, rows)
        iteration%h(:old, old + 1:old + columns) = iteration%h(:old, old + 1:old + columns) + taken
        if (all(lengths(left) >= short*long)) exit
      end do
      do i = 1, columns
        call append(left(:, i), long(i), old, iteration)
      end do
      call dgemm('T', 'N', columns, sides, rows, 1.0_wp, iteration%image(1, old + 1), rows, &
        iteration%left, rows, 0.0_wp, g, columns)
      call dgemm('N', 'N', rows, sides, columns, -1.0_wp, iteration%image(1, old + 1), rows, g, &
        columns, 1.0_wp, iteration%left, rows)
      iteration%g(old + 1:iteration%n, :) = g
    end associate
    iteration%rest = lengths(iteration%left)
    call choose_directions(iteration)
  end subroutine add_images

  !> Makes an image orthogonal to the last ones, twice, and adds what is left of it, one long. If
  !! nothing is, its direction is of no use.
  subroutine append(vector, length, old, iteration)
    real(wp), intent(in) :: vector(:) !! the image, orthogonal to the first ones
    real(wp), intent(in) :: length !! that it had at first
    integer, intent(in) :: old !! images that it is orthogonal to
    type(block_gmres_t), intent(inout) :: iteration !! gets it, if anything is left
    real(wp) :: left(size(vector)), share, shares(iteration%n - old)
    integer :: turn

    associate (n => iteration%n, h => iteration%h, rows => size(vector))
      left = vector
      do turn = 1, 2
        if (n == old) exit
        call dgemv('T', rows, n - old, 1.0_wp, iteration%image(1, old + 1), rows, left, 1, 0.0_wp, &
          shares, 1)
        call dgemv('N', rows, n - old, -1.0_wp, iteration%image(1, old + 1), rows, shares, 1, &
          1.0_wp, left, 1)
        h(old + 1:n, n + 1) = h(old + 1:n, n + 1) + shares
      end do
      share = norm_of(left)
      n = n + 1
      iteration%image(:, n) = 0.0_wp
      if (share <= dependent_image*length) return
      iteration%image(:, n) = left/share
      h(n, n) = share
    end associate
  end subroutine append

  !> Norms of the columns of a matrix: `norm2` scales each summand, and takes several times as long.
  function lengths(a) result(norms)
    real(wp), intent(in) :: a(:, :) !! the matrix
    real(wp) :: norms(size(a, 2))
    integer :: j

    do j = 1, size(a, 2)
      norms(j) = norm_of(a(:, j))
    end do
  end function lengths

  !> Norm of a vector.
  function norm_of(v) result(norm)
    real(wp), intent(in) :: v(:) !! the vector
    real(wp) :: norm

    norm = ddot(size(v), v, 1, v, 1)
    if (norm > least_square .and. norm < largest_square) then
      norm = sqrt(norm)
    else
      norm = norm2(v)
    end if
  end function norm_of

  !> Shares of the directions in the x of the smallest residual of each right-hand side.
  pure function block_shares(iteration) result(y)
    type(block_gmres_t), intent(in) :: iteration !! directions so far
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
end module block_gmres

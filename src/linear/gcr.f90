!> Least residuals by hand, and answers that are known already: the caller applies a matrix to one
!! direction after the other, with whatever else each of them leads to; those of earlier right-hand
!! sides serve the next one (generalised conjugate residuals; doc/theory, "Contact operator of low
!! rank").
module gcr
  use kinds, only: wp
  implicit none
  private
  public :: gcr_t, begin_gcr, forget_images, take_known, add_image_of

  !> An image of which a smaller share is new adds nothing but round-off.
  real(wp), parameter :: least_new = 1.0e-10_wp

  !> The directions so far.
  type :: gcr_t
    integer :: n = 0 !! directions so far
    real(wp), allocatable :: image(:, :) !! (size of b, most) of each, orthonormal
    real(wp), allocatable :: way(:, :) !! (values of a way, most) what leads to each image
  end type gcr_t

contains

  !> Makes room for directions. What is there serves on where it fits.
  pure subroutine begin_gcr(length, values, most, known)
    integer, intent(in) :: length !! of right-hand sides
    integer, intent(in) :: values !! of a way
    integer, intent(in) :: most !! directions that are kept
    type(gcr_t), intent(inout) :: known !! gets room

    if (allocated(known%image)) then
      if (all(shape(known%image) == [length, most]) .and. size(known%way, 1) == values) return
      deallocate (known%image, known%way)
    end if
    allocate (known%image(length, most), known%way(values, most))
    known%n = 0
  end subroutine begin_gcr

  !> The matrix is another one.
  elemental subroutine forget_images(known)
    type(gcr_t), intent(inout) :: known !! empty

    known%n = 0
  end subroutine forget_images

  !> Takes from a residual what the known directions take, from the first of them asked for on.
  pure subroutine take_known(known, first, residual, way)
    type(gcr_t), intent(in) :: known !! directions
    integer, intent(in) :: first !! of them
    real(wp), intent(inout) :: residual(:) !! becomes the least
    real(wp), intent(inout) :: way(:) !! the sum so far; gets theirs
    real(wp) :: share
    integer :: j

    do j = first, known%n
      share = dot_product(known%image(:, j), residual)
      residual = residual - share*known%image(:, j)
      way = way + share*known%way(:, j)
    end do
  end subroutine take_known

  !> One more direction with its image, which becomes orthogonal to the others. Where there is no
  !! room left, those before are forgotten.
  pure subroutine add_image_of(way, image, known, new)
    real(wp), intent(in) :: way(:) !! what leads to the image
    real(wp), intent(in) :: image(:) !! what the matrix makes of the direction
    type(gcr_t), intent(inout) :: known !! one more
    logical, intent(out) :: new !! the image was no sum of the others
    real(wp) :: share, length
    integer :: j

    if (known%n == size(known%image, 2)) known%n = 0
    associate (next => known%n + 1)
      known%image(:, next) = image
      known%way(:, next) = way
      length = norm2(image)
      do j = 1, known%n
        share = dot_product(known%image(:, j), known%image(:, next))
        known%image(:, next) = known%image(:, next) - share*known%image(:, j)
        known%way(:, next) = known%way(:, next) - share*known%way(:, j)
      end do
      share = norm2(known%image(:, next))
      new = share > least_new*length
      if (.not. new) return
      known%image(:, next) = known%image(:, next)/share
      known%way(:, next) = known%way(:, next)/share
    end associate
    known%n = known%n + 1
  end subroutine add_image_of
end module gcr

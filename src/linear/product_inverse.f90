!> The inverse of a symmetric positive definite matrix from its Cholesky factor: LAPACK's, or by
!! halves that two threads share (doc/theory, "Static condensation").
module product_inverse
  use kinds, only: wp
  use lapack_interface, only: dpotri, dsyrk, dtrsm
  implicit none
  private
  public :: invert_product, invert_by_halves

  !> Smaller ones are not shared.
  integer, parameter :: least_shared = 256

contains

  !> (L L^T)^-1 in place of L.
  subroutine invert_product(n, shared, a, info)
    integer, intent(in) :: n !! rows
    logical, intent(in) :: shared !! threads share the work
    real(wp), intent(inout) :: a(n, n) !! lower triangle; zero above
    integer, intent(out) :: info !! 0, or a pivot that is zero

    if (shared .and. n >= least_shared) then
      call invert_by_halves(n, n/2, a, info)
    else
      call dpotri('L', n, a, n, info)
    end if
  end subroutine invert_product

  !> The same with L = [A 0; B D]: with W = -D^-1 B A^-1 the blocks of the inverse are
  !! A^-T A^-1 + W^T W, D^-T W and D^-T D^-1. W^T D^-1 has its room above the diagonal.
  subroutine invert_by_halves(n, half, a, info)
    integer, intent(in) :: n !! rows
    integer, intent(in) :: half !! rows of A
    real(wp), intent(inout) :: a(n, n) !! as above
    integer, intent(out) :: info !! as above
    integer :: part, first, last, infos(2)

    do part = 1, 2
      first = merge(1, half/2 + 1, part == 1)
      last = merge(half/2, half, part == 1)
      !$omp task default(none) firstprivate(first, last) shared(n, half, a)
      call dtrsm('L', 'L', 'N', 'N', n - half, last - first + 1, -1.0_wp, a(half + 1, half + 1), &
        n, a(half + 1, first), n)
      !$omp end task
    end do
    !$omp taskwait
    do part = 1, 2
      first = merge(half, (n + half)/2, part == 1) + 1
      last = merge((n + half)/2, n, part == 1)
      !$omp task default(none) firstprivate(first, last) shared(n, half, a)
      call dtrsm('R', 'L', 'N', 'N', last - first + 1, half, 1.0_wp, a, n, a(first, 1), n)
      !$omp end task
    end do
    !$omp taskwait
    !$omp task default(none) shared(n, half, a)
    a(:half, half + 1:) = transpose(a(half + 1:, :half))
    call dtrsm('R', 'L', 'N', 'N', half, n - half, 1.0_wp, a(half + 1, half + 1), n, &
      a(1, half + 1), n)
    !$omp end task
    call dpotri('L', half, a, n, infos(1))
    !$omp taskwait
    !$omp task default(none) shared(n, half, a)
    call dsyrk('L', 'T', half, n - half, 1.0_wp, a(half + 1, 1), n, 1.0_wp, a, n)
    !$omp end task
    call dpotri('L', n - half, a(half + 1, half + 1), n, infos(2))
    !$omp taskwait
    a(half + 1:, :half) = transpose(a(:half, half + 1:))
    a(:half, half + 1:) = 0.0_wp
    info = maxval(infos)
  end subroutine invert_by_halves
end module product_inverse

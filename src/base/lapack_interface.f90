!> Prototypes of the LAPACK routines in use, and nothing else.
module lapack_interface
  use kinds, only: wp
  implicit none
  private
  public :: dgelss, dsyev

  interface
    !> Least squares of minimum norm by singular values.
    subroutine dgelss(m, n, nrhs, a, lda, b, ldb, s, rcond, rank, work, lwork, info)
      import :: wp
      implicit none
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      real(wp), intent(inout) :: a(lda, *), b(ldb, *)
      real(wp), intent(out) :: s(*), work(*)
      real(wp), intent(in) :: rcond
      integer, intent(out) :: rank, info
    end subroutine dgelss

    !> Eigenvalues and eigenvectors of a symmetric matrix.
    subroutine dsyev(jobz, uplo, n, a, lda, w, work, lwork, info)
      import :: wp
      implicit none
      character(1), intent(in) :: jobz, uplo
      integer, intent(in) :: n, lda, lwork
      real(wp), intent(inout) :: a(lda, *)
      real(wp), intent(out) :: w(*), work(*)
      integer, intent(out) :: info
    end subroutine dsyev
  end interface
end module lapack_interface

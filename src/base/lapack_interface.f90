!> Prototypes of the LAPACK and BLAS routines in use, and nothing else.
module lapack_interface
  use kinds, only: wp, sp
  implicit none
  private
  public :: dgelss, dgelsy, dgesvd, dsyev, dpotri, dgetrf, dgetrs, dsymv, dgemv, dtrsv, dgemm, &
    dsymm, dtrsm, ddot, dlaswp, saxpy, sgemv, ssymv, sgemm, sgetrf, sgetrs, &
    ssyrk, strsm, spotrf, dsyrk, dpotrf, dgeev

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

    !> The same by a factorisation with exchanged columns.
    subroutine dgelsy(m, n, nrhs, a, lda, b, ldb, jpvt, rcond, rank, work, lwork, info)
      import :: wp
      implicit none
      integer, intent(in) :: m, n, nrhs, lda, ldb, lwork
      real(wp), intent(inout) :: a(lda, *), b(ldb, *)
      integer, intent(inout) :: jpvt(*)
      real(wp), intent(out) :: work(*)
      real(wp), intent(in) :: rcond
      integer, intent(out) :: rank, info
    end subroutine dgelsy

    !> Singular values and vectors.
    subroutine dgesvd(jobu, jobvt, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info)
      import :: wp
      implicit none
      character, intent(in) :: jobu, jobvt
      integer, intent(in) :: m, n, lda, ldu, ldvt, lwork
      real(wp), intent(inout) :: a(lda, *), work(*)
      real(wp), intent(out) :: s(*), u(ldu, *), vt(ldvt, *)
      integer, intent(out) :: info
    end subroutine dgesvd

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

    !> Eigenvalues of a matrix that is not symmetric.
    subroutine dgeev(jobvl, jobvr, n, a, lda, wr, wi, vl, ldvl, vr, ldvr, work, lwork, info)
      import :: wp
      implicit none
      character, intent(in) :: jobvl, jobvr
      integer, intent(in) :: n, lda, ldvl, ldvr, lwork
      real(wp), intent(inout) :: a(lda, *)
      real(wp), intent(out) :: wr(*), wi(*), vl(ldvl, *), vr(ldvr, *), work(*)
      integer, intent(out) :: info
    end subroutine dgeev

    !> C = alpha A A^T + beta C, one triangle of it.
    subroutine dsyrk(uplo, trans, n, k, alpha, a, lda, beta, c, ldc)
      import :: wp
      implicit none
      character(1), intent(in) :: uplo, trans
      integer, intent(in) :: n, k, lda, ldc
      real(wp), intent(in) :: alpha, beta, a(lda, *)
      real(wp), intent(inout) :: c(ldc, *)
    end subroutine dsyrk

    !> Cholesky factor of a dense matrix.
    subroutine dpotrf(uplo, n, a, lda, info)
      import :: wp
      implicit none
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(wp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotrf

    !> Inverse of a symmetric positive definite matrix from its Cholesky factor.
    subroutine dpotri(uplo, n, a, lda, info)
      import :: wp
      implicit none
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(wp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine dpotri

    !> LU factor with partial pivoting.
    subroutine dgetrf(m, n, a, lda, ipiv, info)
      import :: wp
      implicit none
      integer, intent(in) :: m, n, lda
      real(wp), intent(inout) :: a(lda, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine dgetrf

    !> Solution with the factor of dgetrf.
    subroutine dgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: wp
      implicit none
      character(1), intent(in) :: trans
      integer, intent(in) :: n, nrhs, lda, ldb, ipiv(*)
      real(wp), intent(in) :: a(lda, *)
      real(wp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine dgetrs

    !> Exchanges of rows.
    subroutine dlaswp(n, a, lda, k1, k2, ipiv, incx)
      import :: wp
      implicit none
      integer, intent(in) :: n, lda, k1, k2, ipiv(*), incx
      real(wp), intent(inout) :: a(lda, *)
    end subroutine dlaswp

    !> Scalar product of two vectors.
    function ddot(n, x, incx, y, incy) result(product)
      import :: wp
      implicit none
      integer, intent(in) :: n, incx, incy
      real(wp), intent(in) :: x(*), y(*)
      real(wp) :: product
    end function ddot

    !> y = alpha A x + beta y for a symmetric matrix.
    subroutine dsymv(uplo, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: wp
      implicit none
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, lda, incx, incy
      real(wp), intent(in) :: alpha, beta, a(lda, *), x(*)
      real(wp), intent(inout) :: y(*)
    end subroutine dsymv

    !> y = alpha A x + beta y, or with A^T.
    subroutine dgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: wp
      implicit none
      character(1), intent(in) :: trans
      integer, intent(in) :: m, n, lda, incx, incy
      real(wp), intent(in) :: alpha, beta, a(lda, *), x(*)
      real(wp), intent(inout) :: y(*)
    end subroutine dgemv

    !> x = A^-1 x or A^-T x for a triangular matrix.
    subroutine dtrsv(uplo, trans, diag, n, a, lda, x, incx)
      import :: wp
      implicit none
      character(1), intent(in) :: uplo, trans, diag
      integer, intent(in) :: n, lda, incx
      real(wp), intent(in) :: a(lda, *)
      real(wp), intent(inout) :: x(*)
    end subroutine dtrsv

    !> The last two in single precision: y = alpha A x + beta y, or with A^T.
    subroutine sgemv(trans, m, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: sp
      implicit none
      character(1), intent(in) :: trans
      integer, intent(in) :: m, n, lda, incx, incy
      real(sp), intent(in) :: alpha, beta, a(lda, *), x(*)
      real(sp), intent(inout) :: y(*)
    end subroutine sgemv

    !> y = y + alpha x.
    subroutine saxpy(n, alpha, x, incx, y, incy)
      import :: sp
      implicit none
      integer, intent(in) :: n, incx, incy
      real(sp), intent(in) :: alpha, x(*)
      real(sp), intent(inout) :: y(*)
    end subroutine saxpy

    !> y = alpha A x + beta y for a symmetric matrix.
    subroutine ssymv(uplo, n, alpha, a, lda, x, incx, beta, y, incy)
      import :: sp
      implicit none
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, lda, incx, incy
      real(sp), intent(in) :: alpha, beta, a(lda, *), x(*)
      real(sp), intent(inout) :: y(*)
    end subroutine ssymv

    !> C = alpha A A^T + beta C, one triangle of it.
    subroutine ssyrk(uplo, trans, n, k, alpha, a, lda, beta, c, ldc)
      import :: sp
      implicit none
      character(1), intent(in) :: uplo, trans
      integer, intent(in) :: n, k, lda, ldc
      real(sp), intent(in) :: alpha, beta, a(lda, *)
      real(sp), intent(inout) :: c(ldc, *)
    end subroutine ssyrk

    !> B = alpha A^-1 B or alpha B A^-1 for a triangular matrix, or with A^T.
    subroutine strsm(side, uplo, trans, diag, m, n, alpha, a, lda, b, ldb)
      import :: sp
      implicit none
      character(1), intent(in) :: side, uplo, trans, diag
      integer, intent(in) :: m, n, lda, ldb
      real(sp), intent(in) :: alpha, a(lda, *)
      real(sp), intent(inout) :: b(ldb, *)
    end subroutine strsm

    !> Cholesky factor of a dense matrix.
    subroutine spotrf(uplo, n, a, lda, info)
      import :: sp
      implicit none
      character(1), intent(in) :: uplo
      integer, intent(in) :: n, lda
      real(sp), intent(inout) :: a(lda, *)
      integer, intent(out) :: info
    end subroutine spotrf

    !> LU factorisation with row exchanges.
    subroutine sgetrf(m, n, a, lda, ipiv, info)
      import :: sp
      implicit none
      integer, intent(in) :: m, n, lda
      real(sp), intent(inout) :: a(lda, *)
      integer, intent(out) :: ipiv(*), info
    end subroutine sgetrf

    !> Solution with these factors.
    subroutine sgetrs(trans, n, nrhs, a, lda, ipiv, b, ldb, info)
      import :: sp
      implicit none
      character(1), intent(in) :: trans
      integer, intent(in) :: n, nrhs, lda, ipiv(*), ldb
      real(sp), intent(in) :: a(lda, *)
      real(sp), intent(inout) :: b(ldb, *)
      integer, intent(out) :: info
    end subroutine sgetrs

    !> C = alpha A B + beta C, or with A^T or B^T.
    subroutine sgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: sp
      implicit none
      character(1), intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(sp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
      real(sp), intent(inout) :: c(ldc, *)
    end subroutine sgemm

    !> C = alpha A B + beta C, or with A^T or B^T.
    subroutine dgemm(transa, transb, m, n, k, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: wp
      implicit none
      character(1), intent(in) :: transa, transb
      integer, intent(in) :: m, n, k, lda, ldb, ldc
      real(wp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
      real(wp), intent(inout) :: c(ldc, *)
    end subroutine dgemm

    !> C = alpha A B + beta C for a symmetric matrix A.
    subroutine dsymm(side, uplo, m, n, alpha, a, lda, b, ldb, beta, c, ldc)
      import :: wp
      implicit none
      character(1), intent(in) :: side, uplo
      integer, intent(in) :: m, n, lda, ldb, ldc
      real(wp), intent(in) :: alpha, beta, a(lda, *), b(ldb, *)
      real(wp), intent(inout) :: c(ldc, *)
    end subroutine dsymm

    !> B = alpha A^-1 b or alpha A^-T b for a triangular matrix on the left.
    subroutine dtrsm(side, uplo, transa, diag, m, n, alpha, a, lda, b, ldb)
      import :: wp
      implicit none
      character(1), intent(in) :: side, uplo, transa, diag
      integer, intent(in) :: m, n, lda, ldb
      real(wp), intent(in) :: alpha, a(lda, *)
      real(wp), intent(inout) :: b(ldb, *)
    end subroutine dtrsm
  end interface
end module lapack_interface

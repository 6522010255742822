!> Prototypes of the UMFPACK routines in use (long integers), and nothing else.
module umfpack_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_long, c_double
  implicit none
  private
  public :: umfpack_dl_defaults, umfpack_dl_symbolic, umfpack_dl_numeric, umfpack_dl_solve, &
    umfpack_dl_free_symbolic, umfpack_dl_free_numeric, umfpack_dl_get_determinant

  interface
    !> Fills Control with the defaults.
    subroutine umfpack_dl_defaults(control) bind(c, name='umfpack_dl_defaults')
      import :: c_double
      implicit none
      real(c_double), intent(out) :: control(0:19)
    end subroutine umfpack_dl_defaults

    !> Symbolic analysis.
    integer(c_long) function umfpack_dl_symbolic(m, n, ap, ai, ax, symbolic, control, info) &
      bind(c, name='umfpack_dl_symbolic')
      import :: c_ptr, c_long, c_double
      implicit none
      integer(c_long), value :: m, n
      integer(c_long), intent(in) :: ap(*), ai(*)
      real(c_double), intent(in) :: ax(*)
      type(c_ptr), intent(out) :: symbolic
      real(c_double), intent(in) :: control(0:19)
      real(c_double), intent(inout) :: info(0:89)
    end function umfpack_dl_symbolic

    !> Numeric factorisation.
    integer(c_long) function umfpack_dl_numeric(ap, ai, ax, symbolic, numeric, control, info) &
      bind(c, name='umfpack_dl_numeric')
      import :: c_ptr, c_long, c_double
      implicit none
      integer(c_long), intent(in) :: ap(*), ai(*)
      real(c_double), intent(in) :: ax(*)
      type(c_ptr), value :: symbolic
      type(c_ptr), intent(out) :: numeric
      real(c_double), intent(in) :: control(0:19)
      real(c_double), intent(inout) :: info(0:89)
    end function umfpack_dl_numeric

    !> Solution of one system.
    integer(c_long) function umfpack_dl_solve(sys, ap, ai, ax, x, b, numeric, control, info) &
      bind(c, name='umfpack_dl_solve')
      import :: c_ptr, c_long, c_double
      implicit none
      integer(c_long), value :: sys
      integer(c_long), intent(in) :: ap(*), ai(*)
      real(c_double), intent(in) :: ax(*)
      real(c_double), intent(inout) :: x(*)
      real(c_double), intent(in) :: b(*)
      type(c_ptr), value :: numeric
      real(c_double), intent(in) :: control(0:19)
      real(c_double), intent(inout) :: info(0:89)
    end function umfpack_dl_solve

    !> Mantissa and exponent (of 10) of the determinant.
    integer(c_long) function umfpack_dl_get_determinant(mx, ex, numeric, info) &
      bind(c, name='umfpack_dl_get_determinant')
      import :: c_ptr, c_long, c_double
      implicit none
      real(c_double), intent(out) :: mx(*), ex(*)
      type(c_ptr), value :: numeric
      real(c_double), intent(inout) :: info(0:89)
    end function umfpack_dl_get_determinant

    !> Releases a symbolic analysis.
    subroutine umfpack_dl_free_symbolic(symbolic) bind(c, name='umfpack_dl_free_symbolic')
      import :: c_ptr
      implicit none
      type(c_ptr), intent(inout) :: symbolic
    end subroutine umfpack_dl_free_symbolic

    !> Releases a factor.
    subroutine umfpack_dl_free_numeric(numeric) bind(c, name='umfpack_dl_free_numeric')
      import :: c_ptr
      implicit none
      type(c_ptr), intent(inout) :: numeric
    end subroutine umfpack_dl_free_numeric
  end interface
end module umfpack_interface

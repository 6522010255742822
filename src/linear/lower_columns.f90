!> A symmetric matrix whose lower triangle a factorisation takes column by column, in the order of
!! elimination (doc/theory, "Linear systems").
module lower_columns
  use kinds, only: wp
  implicit none
  private
  public :: lower_columns_t

  !> What a factorisation wants to know of its matrix.
  type, abstract :: lower_columns_t
  contains
    procedure(order_of), deferred :: order
    procedure(gather_columns), deferred :: gather
    procedure(multiply_vector), deferred :: multiply
    procedure(largest_entry), deferred :: largest
  end type lower_columns_t

  abstract interface
    !> Order of the matrix.
    pure integer function order_of(a) result(n)
      import :: lower_columns_t
      implicit none
      class(lower_columns_t), intent(in) :: a !! the matrix
    end function order_of

    !> Some columns, from the diagonal on, with zeros where there are no entries.
    subroutine gather_columns(a, first, last, place, rows, panel)
      import :: lower_columns_t, wp
      implicit none
      class(lower_columns_t), intent(in) :: a !! the matrix
      integer, intent(in) :: first, last !! the columns
      integer, intent(in) :: place(:) !! (n) row of the panel that each row of them belongs to
      integer, intent(in) :: rows !! of the panel
      real(wp), intent(out) :: panel(rows, last - first + 1) !! values
    end subroutine gather_columns

    !> y = A x.
    pure function multiply_vector(a, x) result(y)
      import :: lower_columns_t, wp
      implicit none
      class(lower_columns_t), intent(in) :: a !! the matrix
      real(wp), intent(in) :: x(:) !! (n)
      real(wp) :: y(size(x))
    end function multiply_vector

    !> The largest entry, without its sign.
    pure real(wp) function largest_entry(a) result(most)
      import :: lower_columns_t, wp
      implicit none
      class(lower_columns_t), intent(in) :: a !! the matrix
    end function largest_entry
  end interface
end module lower_columns

!> Sparse matrices on the live candidates, by columns: one column more, and products.
module sparse_columns
  use kinds, only: wp
  use condensed_types, only: columns_t
  implicit none
  private
  public :: append, add_product, take_product

contains

  !> One column more.
  subroutine append(columns, j, row, value)
    type(columns_t), intent(inout) :: columns !! start(:j) given; gets the column
    integer, intent(in) :: j !! its number
    integer, intent(in) :: row(:) !! live candidates
    real(wp), intent(in) :: value(:) !! entries
    integer, allocatable :: rows(:)
    real(wp), allocatable :: values(:)
    integer :: last, room

    last = columns%start(j) + size(row) - 1
    room = 0
    if (allocated(columns%row)) room = size(columns%row)
    if (room < last) then
      allocate (rows(2*last), values(2*last))
      if (room > 0) rows(:room) = columns%row
      if (room > 0) values(:room) = columns%value
      call move_alloc(rows, columns%row)
      call move_alloc(values, columns%value)
    end if
    columns%row(columns%start(j):last) = row
    columns%value(columns%start(j):last) = value
    columns%start(j + 1) = last + 1
  end subroutine append

  !> Adds the columns times their shares to y.
  pure subroutine add_product(columns, share, y)
    type(columns_t), intent(in) :: columns !! the columns
    real(wp), intent(in) :: share(:) !! (columns) how much of each
    real(wp), intent(inout) :: y(:) !! (live)
    integer :: j, i

    do j = 1, columns%n
      do i = columns%start(j), columns%start(j + 1) - 1
        y(columns%row(i)) = y(columns%row(i)) + columns%value(i)*share(j)
      end do
    end do
  end subroutine add_product

  !> The columns' products with x.
  pure subroutine take_product(columns, x, share)
    type(columns_t), intent(in) :: columns !! the columns
    real(wp), intent(in) :: x(:) !! (live)
    real(wp), intent(out) :: share(:) !! (columns)
    integer :: j, i

    do j = 1, columns%n
      share(j) = 0.0_wp
      do i = columns%start(j), columns%start(j + 1) - 1
        share(j) = share(j) + columns%value(i)*x(columns%row(i))
      end do
    end do
  end subroutine take_product
end module sparse_columns

!> Sparse matrices on the live candidates, by columns: one column more, and products.
module sparse_columns
  use kinds, only: wp
  use condensed_types, only: columns_t
  implicit none
  private
  public :: append, number_new, add_product, take_product

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

  !> Numbers those live candidates of a list that have no number yet, in the order of the list.
  pure subroutine number_new(dofs, place, row, n)
    integer, intent(in) :: dofs(:) !! live candidates, 0 for none
    integer, intent(inout) :: place(:) !! (live) number of each, 0 for none
    integer, intent(inout) :: row(:) !! live candidate of each number
    integer, intent(inout) :: n !! numbers given
    integer :: i

    do i = 1, size(dofs)
      if (dofs(i) == 0) cycle
      if (place(dofs(i)) > 0) cycle
      n = n + 1
      place(dofs(i)) = n
      row(n) = dofs(i)
    end do
  end subroutine number_new

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

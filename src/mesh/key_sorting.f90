!> Sorting of integer keys in linear time, and what is made of sorted lists.
module key_sorting
  implicit none
  private
  public :: sort_columns, comes_before, ascending, in_order, unique_numbers

  !> So many columns with the same first key are sorted among each other.
  integer, parameter :: columns_of_one_key = 64

contains

  !> Order in which the columns of `keys` are lexicographically ascending; equal ones stay as they
  !! are. Few columns with the same first key are sorted among each other; where there are many, all
  !! are sorted by one row after the other, the last one first.
  pure subroutine sort_columns(keys, order)
    integer, intent(in) :: keys(:, :) !! (rows, columns) keys >= 0, row 1 most significant
    integer, allocatable, intent(out) :: order(:) !! (columns) column at each place
    integer, allocatable :: end_of(:)
    integer :: row, i, first

    order = [(i, i=1, size(keys, 2))]
    if (size(order) == 0) return
    allocate (end_of(0:maxval(keys) + 1))
    call distribute(keys, 1, end_of, order)
    if (max(end_of(0), maxval(end_of(1:) - end_of(:ubound(end_of, 1) - 1))) &
      > columns_of_one_key) then
      do row = size(keys, 1), 1, -1
        call distribute(keys, row, end_of, order)
      end do
    else
      first = 1
      do i = 0, ubound(end_of, 1)
        call insert_columns(keys, order(first:end_of(i)))
        first = end_of(i) + 1
      end do
    end if
  end subroutine sort_columns

  !> Sorts columns by one row, stably.
  pure subroutine distribute(keys, row, end_of, order)
    integer, intent(in) :: keys(:, :) !! (rows, columns)
    integer, intent(in) :: row !! the row
    integer, intent(out) :: end_of(0:) !! last place of each key
    integer, intent(inout) :: order(:) !! the columns
    integer :: sorted(size(order)), i, key

    end_of = 0
    do i = 1, size(order)
      key = keys(row, i) + 1
      end_of(key) = end_of(key) + 1
    end do
    do i = 1, ubound(end_of, 1)
      end_of(i) = end_of(i) + end_of(i - 1)
    end do
    do i = 1, size(order)
      key = keys(row, order(i))
      end_of(key) = end_of(key) + 1
      sorted(end_of(key)) = order(i)
    end do
    order = sorted
  end subroutine distribute

  !> Sorts a few columns by the rows behind the first.
  pure subroutine insert_columns(keys, order)
    integer, intent(in) :: keys(:, :) !! (rows, columns) all columns
    integer, intent(inout) :: order(:) !! the few
    integer :: i, k, column

    do i = 2, size(order)
      column = order(i)
      k = i - 1
      do while (k >= 1)
        if (.not. comes_before(keys(2:, column), keys(2:, order(k)))) exit
        order(k + 1) = order(k)
        k = k - 1
      end do
      order(k + 1) = column
    end do
  end subroutine insert_columns

  !> Lexicographic order of two columns.
  pure logical function comes_before(a, b)
    integer, intent(in) :: a(:) !! first column
    integer, intent(in) :: b(:) !! second column
    integer :: i

    comes_before = .false.
    do i = 1, size(a)
      if (a(i) == b(i)) cycle
      comes_before = a(i) < b(i)
      return
    end do
  end function comes_before

  !> Three numbers in ascending order.
  pure function ascending(a) result(b)
    integer, intent(in) :: a(3) !! any numbers
    integer :: b(3)

    b(1) = min(a(1), a(2), a(3))
    b(3) = max(a(1), a(2), a(3))
    b(2) = max(min(a(1), a(2)), min(max(a(1), a(2)), a(3)))
  end function ascending

  !> Some numbers in ascending order.
  pure function in_order(a) result(b)
    integer, intent(in) :: a(:) !! any numbers
    integer :: b(size(a)), i, least

    b = a
    do i = 1, size(a) - 1
      least = i - 1 + minloc(b(i:), dim=1)
      b([i, least]) = b([least, i])
    end do
  end function in_order

  !> The numbers 1 to size(mask) whose mask is set.
  pure function unique_numbers(mask) result(numbers)
    logical, intent(in) :: mask(:) !! which numbers to take
    integer, allocatable :: numbers(:)
    integer :: i, n

    allocate (numbers(count(mask)))
    n = 0
    do i = 1, size(mask)
      if (.not. mask(i)) cycle
      n = n + 1
      numbers(n) = i
    end do
  end function unique_numbers
end module key_sorting

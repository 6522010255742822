!> Sorting of integer keys in linear time, and what is made of sorted lists.
module key_sorting
  implicit none
  private
  public :: sort_columns, ascending, unique_numbers

contains

  !> Order in which the columns of `keys` are lexicographically ascending (stable radix sort).
  pure subroutine sort_columns(keys, order)
    integer, intent(in) :: keys(:, :) !! (rows, columns) keys >= 0, row 1 most significant
    integer, allocatable, intent(out) :: order(:) !! (columns) column at each place
    integer, allocatable :: start(:), sorted(:)
    integer :: n, top, row, i, key

    n = size(keys, 2)
    allocate (order(n), sorted(n))
    order = [(i, i=1, n)]
    if (n == 0) return
    top = maxval(keys)
    allocate (start(0:top + 1))
    do row = size(keys, 1), 1, -1
      start = 0
      do i = 1, n
        key = keys(row, i) + 1
        start(key) = start(key) + 1
      end do
      do i = 1, top + 1
        start(i) = start(i) + start(i - 1)
      end do
      do i = 1, n
        key = keys(row, order(i))
        start(key) = start(key) + 1
        sorted(start(key)) = order(i)
      end do
      order = sorted
    end do
  end subroutine sort_columns

  !> Three numbers in ascending order.
  pure function ascending(a) result(b)
    integer, intent(in) :: a(3) !! any numbers
    integer :: b(3)

    b(1) = min(a(1), a(2), a(3))
    b(3) = max(a(1), a(2), a(3))
    b(2) = max(min(a(1), a(2)), min(max(a(1), a(2)), a(3)))
  end function ascending

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

!> Sorting of integer keys in linear time, and what is made of sorted lists.
module key_sorting
  implicit none
  private
  public :: sort_columns, ascending, unique_numbers

  !> Columns with the same first key that are sorted by insertion, at most.
  integer, parameter :: most_alike = 64

contains

  !> Order in which the columns of `keys` are lexicographically ascending (stable): by the first row
  !! at once, and by the others among the few columns that share it.
  pure subroutine sort_columns(keys, order)
    integer, intent(in) :: keys(:, :) !! (rows, columns) keys >= 0, row 1 most significant
    integer, allocatable, intent(out) :: order(:) !! (columns) column at each place
    integer, allocatable :: start(:), sorted(:)
    integer :: n, row, i

    n = size(keys, 2)
    allocate (order(n))
    order = [(i, i=1, n)]
    if (n == 0) return
    allocate (start(0:maxval(keys) + 1), sorted(n))
    call count_keys(keys(1, :), start)
    if (maxval(start(1:) - start(:ubound(start, 1) - 1)) <= most_alike) then
      call sort_by_row(keys, 1, start, order, sorted)
      call sort_alike(keys, order)
      return
    end if
    do row = size(keys, 1), 1, -1
      call count_keys(keys(row, :), start)
      call sort_by_row(keys, row, start, order, sorted)
    end do
  end subroutine sort_columns

  !> How many keys are smaller than each.
  pure subroutine count_keys(keys, start)
    integer, intent(in) :: keys(:) !! the keys
    integer, intent(out) :: start(0:) !! (0:largest key + 1) keys below
    integer :: i

    start = 0
    do i = 1, size(keys)
      start(keys(i) + 1) = start(keys(i) + 1) + 1
    end do
    do i = 1, ubound(start, 1)
      start(i) = start(i) + start(i - 1)
    end do
  end subroutine count_keys

  !> Puts columns into the order of one row; those that are equal there keep theirs.
  pure subroutine sort_by_row(keys, row, start, order, sorted)
    integer, intent(in) :: keys(:, :) !! (rows, columns) keys
    integer, intent(in) :: row !! which row
    integer, intent(inout) :: start(0:) !! keys of the row below each; changed
    integer, intent(inout) :: order(:) !! column at each place
    integer, intent(out) :: sorted(:) !! work space
    integer :: i, key

    do i = 1, size(order)
      key = keys(row, order(i))
      start(key) = start(key) + 1
      sorted(start(key)) = order(i)
    end do
    order = sorted
  end subroutine sort_by_row

  !> Puts columns that are sorted by the first row into the order of the others, by insertion.
  pure subroutine sort_alike(keys, order)
    integer, intent(in) :: keys(:, :) !! (rows, columns) keys
    integer, intent(inout) :: order(:) !! column at each place
    integer :: i, j, column

    do i = 2, size(order)
      column = order(i)
      do j = i - 1, 1, -1
        if (.not. comes_before(keys(:, column), keys(:, order(j)))) exit
        order(j + 1) = order(j)
      end do
      order(j + 1) = column
    end do
  end subroutine sort_alike

  !> Lexicographic order of two columns.
  pure logical function comes_before(a, b) result(before)
    integer, intent(in) :: a(:) !! one
    integer, intent(in) :: b(:) !! the other
    integer :: row

    before = .false.
    do row = 1, size(a)
      if (a(row) == b(row)) cycle
      before = a(row) < b(row)
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

!> The order of the columns within a supernode. It is free: the rows of other supernodes that are
!! among them shall follow each other, so that what one supernode takes from another is put in its
!! place in long runs (doc/theory, "Sparse factorisation").
module row_runs
  use kinds, only: wp, long
  use supernodes, only: supernodes_t
  use waiting_supernodes, only: owners, columns_within
  implicit none
  private
  public :: gather_rows

  !> Lists of rows that order a supernode: so many of the largest.
  integer, parameter :: most_lists = 64

  !> Lists of rows that follow each other in one supernode and are columns of another.
  type :: row_lists_t
    integer, allocatable :: head(:) !! (supernodes) the last list of its columns, 0 for none
    integer, allocatable :: before(:) !! (lists) the list before it, 0 for none
    integer(long), allocatable :: first(:), last(:) !! (lists) where it lies in s
    real(wp), allocatable :: weight(:) !! (lists) entries of the product that it makes
  end type row_lists_t

contains

  !> Orders the columns within the supernodes of an analysis, and renumbers their rows.
  subroutine gather_rows(nodes, m, order)
    type(supernodes_t), intent(in) :: nodes !! analysed, without values; s changes
    integer, intent(in) :: m !! columns at the end that stay
    integer, intent(out) :: order(:) !! (n) the column that stood at each place before
    type(row_lists_t) :: lists
    integer :: k, i, first, last

    order = [(i, i=1, size(order))]
    call list_rows(nodes, size(order), lists)
    do k = 1, int(nodes%factor%nsuper)
      first = int(nodes%super(k)) + 1
      last = min(int(nodes%super(k + 1)), size(order) - m)
      if (last > first + 1) call order_columns(nodes, lists, k, first, order(first:last))
    end do
    call renumber_rows(nodes, order)
  end subroutine gather_rows

  !> Lists the rows of all supernodes by whose columns they are.
  pure subroutine list_rows(nodes, n, lists)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: n !! columns
    type(row_lists_t), intent(out) :: lists !! of their rows
    integer :: owner(n), d, k, many, pass
    integer(long) :: i, j

    owner = owners(nodes, n)
    allocate (lists%head(nodes%factor%nsuper), source=0)
    do pass = 1, 2
      many = 0
      do d = 1, int(nodes%factor%nsuper)
        i = nodes%pi(d) + nodes%super(d + 1) - nodes%super(d) + 1
        do while (i <= nodes%pi(d + 1))
          k = owner(nodes%s(i) + 1)
          j = i + columns_within(nodes, d, k, int(i - nodes%pi(d))) - 1
          many = many + 1
          if (pass == 2) then
            lists%before(many) = lists%head(k)
            lists%head(k) = many
            lists%first(many) = i
            lists%last(many) = j
            lists%weight(many) = real(j - i + 1, wp)*real(nodes%pi(d + 1) - i + 1, wp)
          end if
          i = j + 1
        end do
      end do
      if (pass == 1) allocate (lists%before(many), lists%first(many), lists%last(many), &
        lists%weight(many))
    end do
  end subroutine list_rows

  !> Orders the columns of a supernode: the largest list splits them into those that it has and
  !! those that it has not, the next one splits each part, and so on. Of a part those come first
  !! that continue what stands before them: rows of the list, or others.
  pure subroutine order_columns(nodes, lists, k, first, columns)
    type(supernodes_t), intent(in) :: nodes !! analysed
    type(row_lists_t), intent(inout) :: lists !! of all rows; weights of those in use go
    integer, intent(in) :: k !! the supernode
    integer, intent(in) :: first !! its first column
    integer, intent(inout) :: columns(:) !! in their order
    logical :: begins(size(columns)), listed(first:first + size(columns) - 1)
    integer :: list, most, time
    integer(long) :: i

    begins = .false.
    do time = 1, most_lists
      most = 0
      list = lists%head(k)
      do while (list > 0)
        if (lists%weight(list) > 0.0_wp) then
          if (most == 0) most = list
          if (lists%weight(list) > lists%weight(most)) most = list
        end if
        list = lists%before(list)
      end do
      if (most == 0) return
      lists%weight(most) = 0.0_wp
      listed = .false.
      do i = lists%first(most), lists%last(most)
        if (nodes%s(i) < ubound(listed, 1)) listed(nodes%s(i) + 1) = .true.
      end do
      call split_parts(listed(columns), begins, columns)
    end do
  end subroutine order_columns

  !> Splits the parts of some columns into those that are listed and those that are not.
  pure subroutine split_parts(listed, begins, columns)
    logical, intent(in) :: listed(:) !! (columns) whether each is
    logical, intent(inout) :: begins(:) !! (columns) a part begins here
    integer, intent(inout) :: columns(:) !! parts one after the other
    logical :: now(size(columns)), in_list
    integer :: old(size(columns)), i, j, same

    old = columns
    in_list = .false.
    i = 1
    do while (i <= size(columns))
      j = i
      do while (j < size(columns))
        if (begins(j + 1)) exit
        j = j + 1
      end do
      now(i:j) = listed(i:j) .eqv. in_list
      same = count(now(i:j))
      if (same < j - i + 1) then
        columns(i:i + same - 1) = pack(old(i:j), now(i:j))
        columns(i + same:j) = pack(old(i:j), .not. now(i:j))
        begins(i + same) = .true.
        in_list = .not. in_list
      end if
      i = j + 1
    end do
  end subroutine split_parts

  !> Gives the rows below each supernode the new numbers of their columns, in ascending order.
  subroutine renumber_rows(nodes, order)
    type(supernodes_t), intent(in) :: nodes !! analysed; s changes
    integer, intent(in) :: order(:) !! (n) the column that stood at each place before
    integer(long) :: ptr(size(order) + 1), next(nodes%factor%nsuper), i, j
    integer, allocatable :: who(:)
    integer :: d, k

    ptr = 0
    do d = 1, size(next)
      next(d) = nodes%pi(d) + nodes%super(d + 1) - nodes%super(d)
      do i = next(d) + 1, nodes%pi(d + 1)
        ptr(nodes%s(i) + 2) = ptr(nodes%s(i) + 2) + 1
      end do
    end do
    do k = 1, size(order)
      ptr(k + 1) = ptr(k + 1) + ptr(k)
    end do
    allocate (who(ptr(size(ptr))))
    do d = 1, size(next)
      do i = next(d) + 1, nodes%pi(d + 1)
        j = nodes%s(i) + 1
        ptr(j) = ptr(j) + 1
        who(ptr(j)) = d
      end do
    end do
    do k = 1, size(order)
      j = order(k)
      i = 1
      if (j > 1) i = ptr(j - 1) + 1
      do i = i, ptr(j)
        d = who(i)
        next(d) = next(d) + 1
        nodes%s(next(d)) = k - 1
      end do
    end do
  end subroutine renumber_rows
end module row_runs

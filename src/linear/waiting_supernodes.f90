!> The order in which a left-looking factorisation takes the supernodes of a factor of CHOLMOD's:
!! each waits for the next one that it is to be subtracted from (doc/theory, "Sparse
!! factorisation").
module waiting_supernodes
  use kinds, only: wp, long
  use supernodes, only: supernodes_t
  implicit none
  private
  public :: waiting_t, begin_waiting, find_givers, pass_givers, wait_for_next, owners, &
    columns_within, place_rows

  !> Supernodes that still have to be subtracted from others.
  type :: waiting_t
    integer, allocatable :: head(:) !! (supernodes) first one that waits for this one, 0 for none
    integer, allocatable :: next(:) !! (supernodes) the one that waits for the same after it
    integer, allocatable :: from(:) !! (supernodes) its first row that is not yet dealt with
    integer, allocatable :: owner(:) !! (n) supernode of each column
    integer :: givers = 0 !! those that are subtracted now
    integer, allocatable :: giver(:) !! (supernodes) the first of it are they
    integer, allocatable :: columns(:) !! (supernodes) columns that each of these is subtracted from
    real(wp) :: work = 0.0_wp !! products and sums of all of them
  end type waiting_t

contains

  !> No supernode waits for another one.
  subroutine begin_waiting(nodes, n, waiting)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: n !! columns
    type(waiting_t), intent(out) :: waiting !! empty lists

    associate (supers => int(nodes%factor%nsuper))
      allocate (waiting%head(supers), waiting%next(supers), waiting%from(supers), source=0)
      allocate (waiting%giver(supers), waiting%columns(supers))
    end associate
    waiting%owner = owners(nodes, n)
  end subroutine begin_waiting

  !> The supernode of each column.
  pure function owners(nodes, n) result(owner)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: n !! columns
    integer :: owner(n), k

    do k = 1, int(nodes%factor%nsuper)
      owner(nodes%super(k) + 1:nodes%super(k + 1)) = k
    end do
  end function owners

  !> The supernodes that wait for one.
  pure subroutine find_givers(nodes, k, waiting)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: k !! the supernode
    type(waiting_t), intent(inout) :: waiting !! lists given; gets givers
    integer :: d, n

    n = 0
    waiting%work = 0.0_wp
    d = waiting%head(k)
    do while (d > 0)
      n = n + 1
      waiting%giver(n) = d
      waiting%columns(n) = columns_within(nodes, d, k, waiting%from(d))
      waiting%work = waiting%work + real(waiting%columns(n), wp)*real(nodes%pi(d + 1) &
        - nodes%pi(d) - waiting%from(d) + 1, wp)*real(nodes%super(d + 1) - nodes%super(d), wp)
      d = waiting%next(d)
    end do
    waiting%givers = n
  end subroutine find_givers

  !> They have been subtracted, and wait for others.
  pure subroutine pass_givers(nodes, waiting)
    type(supernodes_t), intent(in) :: nodes !! analysed
    type(waiting_t), intent(inout) :: waiting !! givers given; they move on
    integer :: i

    do i = 1, waiting%givers
      associate (d => waiting%giver(i))
        waiting%from(d) = waiting%from(d) + waiting%columns(i)
        call wait_for_next(nodes, d, waiting)
      end associate
    end do
  end subroutine pass_givers

  !> Puts a supernode where it is to be subtracted next: with the owner of its next row.
  pure subroutine wait_for_next(nodes, d, waiting)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: d !! the supernode
    type(waiting_t), intent(inout) :: waiting !! from given; gets on to a list, or moves on
    integer :: k

    if (nodes%pi(d) + waiting%from(d) > nodes%pi(d + 1)) return
    k = waiting%owner(nodes%s(nodes%pi(d) + waiting%from(d)) + 1)
    waiting%next(d) = waiting%head(k)
    waiting%head(k) = d
  end subroutine wait_for_next

  !> How many rows of supernode d, from one on, are columns of supernode k.
  pure integer function columns_within(nodes, d, k, from) result(columns)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: d, k !! the supernodes
    integer, intent(in) :: from !! row of d that is one of them
    integer :: n

    n = int(nodes%pi(d + 1) - nodes%pi(d)) - from + 1
    columns = 1
    do while (columns < n)
      if (nodes%s(nodes%pi(d) + from + columns) >= nodes%super(k + 1)) exit
      columns = columns + 1
    end do
  end function columns_within

  !> Where each row of a supernode is in it.
  pure subroutine place_rows(nodes, k, place)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: k !! the supernode
    integer, intent(inout) :: place(:) !! (n) gets the places of its rows
    integer(long) :: i

    do i = 1, nodes%pi(k + 1) - nodes%pi(k)
      place(nodes%s(nodes%pi(k) + i) + 1) = int(i)
    end do
  end subroutine place_rows
end module waiting_supernodes

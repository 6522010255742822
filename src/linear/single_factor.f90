!> Cholesky factor of a lower triangle in single precision, in the supernodes of CHOLMOD's analysis:
!! left-looking (doc/theory, "Nonlinear bulk").
module single_factor
  use kinds, only: wp, sp, long
  use lapack_interface, only: sgemm, ssyrk, strsm, spotrf
  use ordered_blocks, only: ordered_blocks_t, gather_columns
  use supernodes, only: supernodes_t
  use waiting_supernodes, only: waiting_t, begin_waiting, find_givers, pass_givers, &
    wait_for_next, place_rows
  implicit none
  private
  public :: factorise_single

contains

  !> L of A = L L^T, as CHOLMOD stores it: rows of a supernode by its columns.
  subroutine factorise_single(nodes, a, half, definite)
    type(supernodes_t), intent(in) :: nodes !! analysed
    type(ordered_blocks_t), intent(in) :: a !! in the order of elimination
    real(sp), pointer, contiguous, intent(out) :: half(:) !! values; none if not definite
    logical, intent(out) :: definite !! no pivot was zero or negative
    type(waiting_t) :: waiting
    integer :: place(size(a%node)), k, i, w, rows, info
    real(sp), allocatable :: update(:)
    integer(long) :: first, last

    call begin_waiting(nodes, size(place), waiting)
    allocate (half(nodes%factor%xsize), update(max(1_long, int(nodes%factor%maxcsize, long))))
    place = 0
    definite = .true.
    do k = 1, int(nodes%factor%nsuper)
      w = int(nodes%super(k + 1) - nodes%super(k))
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      first = nodes%px(k) + 1
      last = nodes%px(k) + int(rows, long)*w
      call place_rows(nodes, k, place)
      call gather_single(a, int(nodes%super(k)) + 1, int(nodes%super(k + 1)), place, rows, &
        half(first:last))
      call find_givers(nodes, k, waiting)
      do i = 1, waiting%givers
        associate (d => waiting%giver(i))
          call subtract(nodes, d, k, place, waiting%from(d), waiting%columns(i), half, update)
        end associate
      end do
      call pass_givers(nodes, waiting)
      call spotrf('L', w, half(first:last), rows, info)
      definite = info == 0
      if (.not. definite) exit
      if (rows == w) cycle
      call strsm('R', 'L', 'T', 'N', rows - w, w, 1.0_sp, half(first:last), rows, &
        half(first + w:last), rows)
      waiting%from(k) = w + 1
      call wait_for_next(nodes, k, waiting)
    end do
    if (.not. definite) then
      deallocate (half)
      nullify (half)
    end if
  end subroutine factorise_single

  !> Some columns of the matrix in single precision.
  subroutine gather_single(a, first, last, place, rows, panel)
    type(ordered_blocks_t), intent(in) :: a !! in the order of elimination
    integer, intent(in) :: first, last !! the columns
    integer, intent(in) :: place(:) !! (n) places of their rows
    integer, intent(in) :: rows !! of the panel
    real(sp), intent(out) :: panel(rows, last - first + 1) !! values
    real(wp) :: double(rows, last - first + 1)

    call gather_columns(a, first, last, place, rows, double)
    panel = real(double, sp)
  end subroutine gather_single

  !> Subtracts from supernode k what supernode d has in its columns: the rows from `from` on, times
  !! those of them that are columns of k.
  subroutine subtract(nodes, d, k, place, from, columns, half, update)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: d, k !! the supernodes
    integer, intent(in) :: place(:) !! (n) places of the rows of k
    integer, intent(in) :: from !! first row of d that is not yet dealt with
    integer, intent(in) :: columns !! rows of it that are columns of k
    real(sp), intent(inout), contiguous :: half(:) !! values
    real(sp), intent(inout) :: update(:) !! room
    integer :: rows, w, n
    integer(long) :: first, last

    rows = int(nodes%pi(d + 1) - nodes%pi(d))
    w = int(nodes%super(d + 1) - nodes%super(d))
    n = rows - from + 1
    first = nodes%px(d) + from
    last = nodes%px(d) + int(rows, long)*w
    call ssyrk('L', 'N', columns, w, 1.0_sp, half(first:last), rows, 0.0_sp, update, n)
    if (n > columns) call sgemm('N', 'T', n - columns, columns, w, 1.0_sp, &
      half(first + columns:last), rows, half(first:last), rows, 0.0_sp, update(columns + 1:), n)
    call scatter(place(nodes%s(nodes%pi(d) + from:nodes%pi(d + 1)) + 1), columns, update, &
      int(nodes%pi(k + 1) - nodes%pi(k)), half(nodes%px(k) + 1:nodes%px(k + 1)))
  end subroutine subtract

  !> Subtracts the lower triangle of a product from the places where it belongs.
  pure subroutine scatter(to, columns, update, rows, panel)
    integer, intent(in) :: to(:) !! (n) place of each of its rows in the panel
    integer, intent(in) :: columns !! of the product: its first rows
    real(sp), intent(in) :: update(size(to), columns) !! the product
    integer, intent(in) :: rows !! of the panel
    real(sp), intent(inout) :: panel(rows, *) !! values of a supernode
    integer :: i, j

    do j = 1, columns
      do i = j, size(to)
        panel(to(i), to(j)) = panel(to(i), to(j)) - update(i, j)
      end do
    end do
  end subroutine scatter
end module single_factor

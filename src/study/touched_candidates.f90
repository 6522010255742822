!> Compliances times blocks of forces: on the candidates that closed elements touch, on all live
!! ones, and on all candidates (doc/theory, "Derivatives along the path").
module touched_candidates
  use kinds, only: wp
  use lapack_interface, only: dgemm, dsymm
  use condensed_types, only: condensed_t, condensed_body_t
  implicit none
  private
  public :: touched_t, gather_touched, add_product, subtract_leading, subtract_touched, &
    subtract_yield, subtract_yield_of_all

  !> Columns of a matrix that are multiplied at once, and rows times columns of both factors: for so
  !! small a product BLAS does not copy the matrix first, which took longer than the product.
  integer, parameter :: most_columns = 64, small_product = 900000
  !> Rows of a block of a symmetric matrix that stay in the cache for its second product.
  integer, parameter :: most_rows = 512
  !> Rows over those that are not needed, at least.
  integer, parameter :: most_idle = 10

  !> The live candidates that closed elements touch: forces of contact act there alone. Matrices of
  !! many right-hand sides are turned here: (columns, rows).
  type :: touched_t
    integer, allocatable :: rows(:) !! (n) candidates
    integer, allocatable :: live_rows(:) !! (n) the same as live candidates, 0 for none
    integer, allocatable :: place(:) !! (live) place in rows, 0 for none
    integer, allocatable :: first(:) !! (bodies+1) rows before each body
    type(part_t), allocatable :: bodies(:) !! their compliances
    real(wp), allocatable :: cu(:, :) !! (n, rank) C U [length]
  end type touched_t

  !> Compliance of one body.
  type :: part_t
    integer, allocatable :: order(:) !! (m) its candidates: the touched ones first
    real(wp), allocatable :: c(:, :) !! (touched, m) [length/force]; of its first part, which is
    !! symmetric, the lower triangle counts
  end type part_t

contains

  !> The live candidates of elements with a part in the tangent, and what belongs to these. What the
  !! last call has left serves again where it is the same.
  subroutine gather_touched(condensed, touched)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, compliances
    type(touched_t), intent(inout) :: touched !! all of it
    logical :: marked(condensed%alive%n_live)
    integer :: i, k

    marked = .false.
    associate (tangent => condensed%tangent, live => condensed%alive%live)
      if (tangent%whole) then
        marked = .true.
      else
        do k = 1, tangent%resting
          call mark(tangent%dofs(:, tangent%element(k)))
        end do
        do k = 1, tangent%rank
          call mark(tangent%dofs(:, tangent%owner(k)))
        end do
      end if
      if (.not. serves(touched, pack(live, marked), tangent%whole)) then
        touched%rows = pack(live, marked)
        call gather_bodies(condensed, touched)
      end if
      touched%live_rows = condensed%alive%live_place(touched%rows)
      touched%place = spread(0, 1, condensed%alive%n_live)
      do i = 1, size(touched%rows)
        if (touched%live_rows(i) > 0) touched%place(touched%live_rows(i)) = i
      end do
      if (.not. tangent%whole) call gather_columns(tangent%cu(:, :tangent%rank), touched)
    end associate

  contains

    !> Marks the candidates of an element.
    subroutine mark(dofs)
      integer, intent(in) :: dofs(:) !! live candidates, 0 for none

      marked(pack(dofs, dofs > 0)) = .true.
    end subroutine mark
  end subroutine gather_touched

  !> The rows of the last call hold what is wanted, and not many more; or exactly that.
  pure logical function serves(touched, wanted, exactly)
    type(touched_t), intent(in) :: touched !! rows, if there are any
    integer, intent(in) :: wanted(:) !! candidates, ascending
    logical, intent(in) :: exactly !! no others
    integer :: i, k

    serves = .false.
    if (.not. allocated(touched%rows)) return
    if (size(touched%rows) > merge(0, size(wanted)/most_idle, exactly) + size(wanted)) return
    k = 1
    do i = 1, size(touched%rows)
      if (k > size(wanted)) exit
      if (touched%rows(i) == wanted(k)) k = k + 1
    end do
    serves = k > size(wanted)
  end function serves

  !> C U of the rows; nothing at those that no live candidate has.
  subroutine gather_columns(cu, touched)
    real(wp), intent(in) :: cu(:, :) !! (live, rank) [length]
    type(touched_t), intent(inout) :: touched !! live_rows given; gets cu
    integer :: i, j

    if (allocated(touched%cu)) then
      if (any(shape(touched%cu) /= [size(touched%live_rows), size(cu, 2)])) deallocate (touched%cu)
    end if
    if (.not. allocated(touched%cu)) allocate (touched%cu(size(touched%live_rows), size(cu, 2)))
    do j = 1, size(cu, 2)
      do i = 1, size(touched%live_rows)
        touched%cu(i, j) = 0.0_wp
        if (touched%live_rows(i) > 0) touched%cu(i, j) = cu(touched%live_rows(i), j)
      end do
    end do
  end subroutine gather_columns

  !> y = y - C U z, block by block: few columns of C U at a time, which lie far apart.
  subroutine subtract_leading(touched, few, z, y)
    type(touched_t), intent(in) :: touched !! C U
    integer, intent(in) :: few !! columns
    real(wp), intent(in) :: z(:, :) !! (rank, columns)
    real(wp), intent(inout) :: y(few, *) !! (columns, rows) [length]
    real(wp) :: turned(few, size(z, 1))
    integer :: row, column, n

    n = size(touched%cu, 1)
    if (few == 0) return
    turned = transpose(z)
    do row = 1, n, most_rows
      do column = 1, size(z, 1), most_columns
        call dgemm('N', 'T', few, min(most_rows, n - row + 1), min(most_columns, size(z, 1) &
          - column + 1), -1.0_wp, turned(1, column), few, touched%cu(row, column), n, 1.0_wp, &
          y(1, row), few)
      end do
    end do
  end subroutine subtract_leading

  !> Compliances of all candidates and the touched ones, body by body.
  subroutine gather_bodies(condensed, touched)
    type(condensed_t), intent(in) :: condensed !! compliances, whose lower triangles count
    type(touched_t), intent(inout) :: touched !! rows given; gets first, bodies
    integer, allocatable :: place(:), at(:)
    integer :: b, i, j, k, first_row

    touched%first = spread(0, 1, size(condensed%bodies) + 1)
    if (.not. allocated(touched%bodies)) allocate (touched%bodies(size(condensed%bodies)))
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => touched%first(b), part => touched%bodies(b))
        touched%first(b + 1) = first + count(touched%rows > body%first .and. &
          touched%rows <= body%first + body%m)
        place = spread(0, 1, body%m)
        place(body%gathered(:body%n_live)) = [(i, i=1, body%n_live)]
        associate (mine => touched%rows(first + 1:touched%first(b + 1)) - body%first)
          part%order = touched_first(mine, body%m)
          if (allocated(part%c)) then
            if (size(part%c, 1) /= size(mine)) deallocate (part%c)
          end if
          if (.not. allocated(part%c)) allocate (part%c(size(mine), body%m))
          at = place(mine)
          do j = 1, body%m
            k = place(part%order(j))
            first_row = 1
            if (j <= size(mine)) first_row = j - mod(j - 1, most_columns)
            do i = first_row, size(mine)
              if (k > 0 .and. at(i) > 0) then
                part%c(i, j) = body%live(at(i), k)
              else
                part%c(i, j) = body%compliance(max(mine(i), part%order(j)), &
                  min(mine(i), part%order(j)))
              end if
            end do
          end do
        end associate
      end associate
    end do
  end subroutine gather_bodies

  !> The numbers 1 to m, some of them first.
  pure function touched_first(mine, m) result(order)
    integer, intent(in) :: mine(:) !! those that go first
    integer, intent(in) :: m !! how many
    integer :: order(m), i
    logical :: other(m)

    other = .true.
    other(mine) = .false.
    order(:size(mine)) = mine
    order(size(mine) + 1:) = pack([(i, i=1, m)], other)
  end function touched_first

  !> y = y + x C on the rows. C is symmetric: some columns of its lower triangle after the other
  !! serve for both sides, so that half of it is read.
  subroutine add_product(touched, x, y)
    type(touched_t), intent(in) :: touched !! rows, compliances
    real(wp), intent(in) :: x(:, :) !! (columns, rows) [force]
    real(wp), intent(inout) :: y(:, :) !! (columns, rows) [length]
    integer :: b

    do b = 1, size(touched%bodies)
      associate (first => touched%first(b) + 1, last => touched%first(b + 1))
        if (last >= first) call add_symmetric(size(x, 1), last - first + 1, x(:, first:last), &
          touched%bodies(b)%c, y(:, first:last))
      end associate
    end do
  end subroutine add_product

  !> The same for one body.
  subroutine add_symmetric(few, n, x, c, y)
    integer, intent(in) :: few !! rows of x
    integer, intent(in) :: n !! columns of x
    real(wp), intent(in) :: x(few, n) !! first factor
    real(wp), intent(in) :: c(n, *) !! symmetric on its first n columns
    real(wp), intent(inout) :: y(few, n) !! grows by the product
    integer :: first, width, row, rows, under

    if (few == 0) return
    do first = 1, n, most_columns
      width = min(most_columns, n - first + 1)
      do row = first, n, most_rows
        rows = min(most_rows, n - row + 1)
        call dgemm('N', 'N', few, width, rows, 1.0_wp, x(1, row), few, c(row, first), n, 1.0_wp, &
          y(1, first), few)
        under = max(row, first + width)
        rows = row + rows - under
        if (rows > 0) call dgemm('N', 'T', few, rows, width, 1.0_wp, x(1, first), few, &
          c(under, first), n, 1.0_wp, y(1, under), few)
      end do
    end do
  end subroutine add_symmetric

  !> u = u - C f on all candidates for forces on the rows.
  subroutine subtract_touched(bodies, touched, f, u)
    type(condensed_body_t), intent(in) :: bodies(:) !! where their candidates begin
    type(touched_t), intent(in) :: touched !! rows, compliances
    real(wp), intent(in) :: f(:, :) !! (columns, rows) [force]
    real(wp), intent(inout) :: u(:, :) !! (candidates, columns) [length]
    real(wp), allocatable :: change(:, :)
    integer :: b

    do b = 1, size(bodies)
      associate (first => touched%first(b) + 1, last => touched%first(b + 1), part => &
        touched%bodies(b))
        if (last < first) cycle
        allocate (change(size(f, 1), size(part%order)), source=0.0_wp)
        call add_symmetric(size(f, 1), last - first + 1, f(:, first:last), part%c, &
          change(:, :last - first + 1))
        call add_times(size(f, 1), last - first + 1, size(part%order) - (last - first + 1), &
          f(:, first:last), part%c(:, last - first + 2:), change(:, last - first + 2:))
        associate (all_of_it => bodies(b)%first + part%order)
          u(all_of_it, :) = u(all_of_it, :) - transpose(change)
        end associate
        deallocate (change)
      end associate
    end do
  end subroutine subtract_touched

  !> y = y + x C for an x of few rows, some columns of C after the other.
  subroutine add_times(few, rows, n, x, c, y)
    integer, intent(in) :: few !! rows of x
    integer, intent(in) :: rows !! of C
    integer, intent(in) :: n !! columns of C
    real(wp), intent(in) :: x(few, rows) !! first factor
    real(wp), intent(in) :: c(rows, n) !! second factor
    real(wp), intent(inout) :: y(few, n) !! grows by the product
    integer :: first, width

    if (rows == 0 .or. few == 0) return
    width = max(1, min(most_columns, small_product/few/rows))
    do first = 1, n, width
      call dgemm('N', 'N', few, min(width, n - first + 1), rows, 1.0_wp, x, few, c(1, first), &
        rows, 1.0_wp, y(1, first), few)
    end do
  end subroutine add_times

  !> y = y - C x on the live candidates.
  subroutine subtract_yield(bodies, x, y)
    type(condensed_body_t), intent(in) :: bodies(:) !! live compliances
    real(wp), intent(in) :: x(:, :) !! (live, columns) [force]
    real(wp), intent(inout) :: y(:, :) !! (live, columns) [length]
    real(wp), allocatable :: part(:, :), change(:, :)
    integer :: b

    do b = 1, size(bodies)
      associate (body => bodies(b))
        if (body%n_live == 0) cycle
        associate (first => body%first_live + 1, last => body%first_live + body%n_live)
          part = x(first:last, :)
          change = y(first:last, :)
          call dgemm('N', 'N', body%n_live, size(x, 2), body%n_live, -1.0_wp, body%live, &
            body%n_live, part, body%n_live, 1.0_wp, change, body%n_live)
          y(first:last, :) = change
        end associate
      end associate
    end do
  end subroutine subtract_yield

  !> u = u - C f on all candidates; only the lower triangles of the compliances count.
  subroutine subtract_yield_of_all(bodies, f, u)
    type(condensed_body_t), intent(in) :: bodies(:) !! compliances
    real(wp), intent(in) :: f(:, :) !! (candidates, columns) [force]
    real(wp), intent(inout) :: u(:, :) !! (candidates, columns) [length]
    real(wp), allocatable :: part(:, :), change(:, :)
    integer :: b

    do b = 1, size(bodies)
      associate (body => bodies(b))
        if (body%m == 0) cycle
        associate (first => body%first + 1, last => body%first + body%m)
          part = f(first:last, :)
          change = u(first:last, :)
          call dsymm('L', 'L', body%m, size(f, 2), -1.0_wp, body%compliance, body%m, part, &
            body%m, 1.0_wp, change, body%m)
          u(first:last, :) = change
        end associate
      end associate
    end do
  end subroutine subtract_yield_of_all
end module touched_candidates

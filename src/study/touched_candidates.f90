!> Compliances times blocks of forces: on the candidates that closed elements touch, on all live
!! ones, and on all candidates (doc/theory, "Sensitivities along the path").
module touched_candidates
  use kinds, only: wp
  use lapack_interface, only: dgemm, dgemv, dsymm, dsymv
  use condensed_types, only: condensed_t, condensed_body_t
  implicit none
  private
  public :: touched_t, gather_touched, add_product, subtract_leading, subtract_beside, &
    subtract_product, subtract_products

  !> Columns of a matrix that are multiplied at once, and rows times columns of both factors: for so
  !! small a product BLAS does not copy the matrix first, which took longer than the product.
  integer, parameter :: most_columns_at_once = 64, small_product = 900000
  !> Columns of a matrix that is read once for a few others, and their rows that stay in the cache
  !! for a second product: with twice as many columns side by side, each on a page of its own,
  !! reading them took up to four times as long.
  integer, parameter :: rows_of_strip = 32, most_touched_rows = 1024
  !> Rows over those that are not needed, at least.
  integer, parameter :: idle_rows = 10

  !> Compliance of the touched candidates of one body.
  type :: part_t
    integer :: m = 0 !! candidates of the body
    integer, allocatable :: rows(:) !! (n) these, as candidates of the body, ascending
    logical :: whole = .false. !! all of them: the body's own matrix serves
    real(wp), allocatable :: c(:, :) !! (n or more, n or more) else: the lower triangle and the
    !! diagonal blocks count [length/force]
  end type part_t

  !> The live candidates that closed elements touch: forces of contact act there alone. Matrices of
  !! many right-hand sides are turned here: (columns, rows).
  type :: touched_t
    integer, allocatable :: rows(:) !! (n) candidates
    integer, allocatable :: live_rows(:) !! (n) the same as live candidates, 0 for none
    integer, allocatable :: place(:) !! (live) place in rows, 0 for none
    integer, allocatable :: first(:) !! (bodies+1) rows before each body
    type(part_t), allocatable :: bodies(:) !! their compliances
  end type touched_t

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
      call gather_bodies(condensed%bodies, pack(live, marked), tangent%whole, touched)
      touched%live_rows = condensed%alive%live_place(touched%rows)
      touched%place = spread(0, 1, condensed%alive%n_live)
      do i = 1, size(touched%rows)
        if (touched%live_rows(i) > 0) touched%place(touched%live_rows(i)) = i
      end do
    end associate

  contains

    !> Marks the candidates of an element.
    subroutine mark(dofs)
      integer, intent(in) :: dofs(:) !! live candidates, 0 for none

      marked(pack(dofs, dofs > 0)) = .true.
    end subroutine mark
  end subroutine gather_touched

  !> The rows of the last call hold what is wanted, and not many more; or exactly that.
  pure logical function serves(rows, wanted, exactly)
    integer, allocatable, intent(in) :: rows(:) !! those of the last call, if there are any
    integer, intent(in) :: wanted(:) !! candidates, ascending
    logical, intent(in) :: exactly !! no others
    integer :: i, k

    serves = .false.
    if (.not. allocated(rows)) return
    if (size(rows) > merge(0, size(wanted)/idle_rows, exactly) + size(wanted)) return
    k = 1
    do i = 1, size(rows)
      if (k > size(wanted)) exit
      if (rows(i) == wanted(k)) k = k + 1
    end do
    serves = k > size(wanted)
  end function serves

  !> y = y - C U z; rows that no live candidate has stay.
  subroutine subtract_leading(touched, cu, z, y)
    type(touched_t), intent(in) :: touched !! rows
    real(wp), intent(in), contiguous :: cu(:, :) !! (live, rank or more) C U [length]
    real(wp), intent(in), contiguous :: z(:, :) !! (rank, columns)
    real(wp), intent(inout) :: y(:, :) !! (columns, rows) [length]
    real(wp) :: product(size(cu, 1), size(z, 2)), turned(size(z, 2), size(z, 1))
    integer :: i

    if (size(z) == 0) return
    turned = transpose(z)
    call multiply_few(size(cu, 1), size(z, 2), size(z, 1), cu, turned, product)
    do i = 1, size(touched%live_rows)
      if (touched%live_rows(i) > 0) y(:, i) = y(:, i) - product(touched%live_rows(i), :)
    end do
  end subroutine subtract_leading

  !> y = A x^T for an x of few rows: some columns of A after the other, down all of their rows.
  subroutine multiply_few(rows, few, n, a, x, y)
    integer, intent(in) :: rows !! of A
    integer, intent(in) :: few !! rows of x
    integer, intent(in) :: n !! columns of A
    real(wp), intent(in) :: a(rows, *) !! n columns of A, and others
    real(wp), intent(in) :: x(few, n) !! second factor
    real(wp), intent(inout) :: y(rows, few) !! gets the product
    integer :: row, height, first
    real(wp) :: before

    height = max(1, min(most_touched_rows, small_product/few/rows_of_strip))
    before = 0.0_wp
    do first = 1, n, rows_of_strip
      do row = 1, rows, height
        call dgemm('N', 'T', min(height, rows - row + 1), few, min(rows_of_strip, n - first + 1), &
          1.0_wp, a(row, first), rows, x(1, first), few, before, y(row, 1), rows)
      end do
      before = 1.0_wp
    end do
  end subroutine multiply_few

  !> The touched candidates body by body, and their compliances where those of the last call do not
  !! serve.
  subroutine gather_bodies(bodies, wanted, exactly, touched)
    type(condensed_body_t), intent(in) :: bodies(:) !! compliances
    integer, intent(in) :: wanted(:) !! candidates, ascending
    logical, intent(in) :: exactly !! no others
    type(touched_t), intent(inout) :: touched !! gets rows, first, bodies
    integer :: b, before

    if (.not. allocated(touched%bodies)) allocate (touched%bodies(size(bodies)))
    touched%first = spread(0, 1, size(bodies) + 1)
    touched%rows = [integer ::]
    before = 0
    do b = 1, size(bodies)
      associate (body => bodies(b), part => touched%bodies(b), n => count(wanted > bodies(b)%first &
        .and. wanted <= bodies(b)%first + bodies(b)%m))
        associate (mine => wanted(before + 1:before + n) - body%first)
          if (.not. (serves(part%rows, mine, exactly) .and. part%m == body%m)) then
            part%rows = mine
            part%m = body%m
            part%whole = body%mirrored .and. n == body%m
            if (.not. part%whole) call gather_part(body%compliance, part)
          end if
        end associate
        before = before + n
        touched%rows = [touched%rows, body%first + part%rows]
        touched%first(b + 1) = size(touched%rows)
      end associate
    end do
  end subroutine gather_bodies

  !> The lower triangle of the compliance of some candidates, and its diagonal blocks.
  subroutine gather_part(compliance, part)
    real(wp), intent(in) :: compliance(:, :) !! of the body; its lower triangle counts
    type(part_t), intent(inout) :: part !! rows given; gets c
    integer :: i, j

    associate (rows => part%rows, n => size(part%rows))
      if (allocated(part%c)) then
        if (size(part%c, 1) < n) deallocate (part%c)
      end if
      if (.not. allocated(part%c)) allocate (part%c(n + n/idle_rows, n + n/idle_rows))
      do j = 1, n
        do i = j, n
          part%c(i, j) = compliance(rows(i), rows(j))
        end do
        do i = j - mod(j - 1, most_columns_at_once), j - 1
          part%c(i, j) = part%c(j, i)
        end do
      end do
    end associate
  end subroutine gather_part

  !> y = y + x C on the rows. C is symmetric: some columns of its lower triangle after the other
  !! serve for both sides, so that half of it is read.
  subroutine add_product(bodies, touched, x, y)
    type(condensed_body_t), intent(in) :: bodies(:) !! compliances
    type(touched_t), intent(in) :: touched !! rows, compliances
    real(wp), intent(in) :: x(:, :) !! (columns, rows) [force]
    real(wp), intent(inout) :: y(:, :) !! (columns, rows) [length]
    integer :: b

    do b = 1, size(bodies)
      associate (first => touched%first(b) + 1, last => touched%first(b + 1), part => &
        touched%bodies(b))
        if (last < first) cycle
        if (part%whole) then
          call add_symmetric(size(x, 1), last - first + 1, x(:, first:last), bodies(b)%m, &
            bodies(b)%compliance, y(:, first:last))
        else
          call add_symmetric(size(x, 1), last - first + 1, x(:, first:last), size(part%c, 1), &
            part%c, y(:, first:last))
        end if
      end associate
    end do
  end subroutine add_product

  !> The same for one body. The products are made the other way round, (columns, rows), which BLAS
  !! does a third faster for so few of them.
  subroutine add_symmetric(few, n, x, rows_of_c, c, y)
    integer, intent(in) :: few !! rows of x
    integer, intent(in) :: n !! columns of x
    real(wp), intent(in) :: x(few, n) !! first factor
    integer, intent(in) :: rows_of_c !! of the array
    real(wp), intent(in) :: c(rows_of_c, *) !! symmetric on its first n columns
    real(wp), intent(inout) :: y(few, n) !! grows by the product
    real(wp), allocatable :: turned(:, :)
    integer :: first, width, row, rows, under

    if (few == 0) return
    if (few == 1) then
      call dsymv('L', n, 1.0_wp, c, rows_of_c, x, 1, 1.0_wp, y, 1)
      return
    end if
    allocate (turned(n, few), source=0.0_wp)
    do first = 1, n, rows_of_strip
      width = min(rows_of_strip, n - first + 1)
      do row = first, n, most_touched_rows
        rows = min(most_touched_rows, n - row + 1)
        call dgemm('T', 'T', width, few, rows, 1.0_wp, c(row, first), rows_of_c, x(1, row), few, &
          1.0_wp, turned(first, 1), n)
        under = max(row, first + width)
        rows = row + rows - under
        if (rows > 0) call dgemm('N', 'T', rows, few, width, 1.0_wp, c(under, first), rows_of_c, &
          x(1, first), few, 1.0_wp, turned(under, 1), n)
      end do
    end do
    y = y + transpose(turned)
  end subroutine add_symmetric

  !> u = u - C f at some candidates of a body, for forces at others.
  subroutine subtract_beside(body, rows, f, others, u)
    type(condensed_body_t), intent(in) :: body !! compliance
    integer, intent(in) :: rows(:) !! candidates of the body with forces, ascending
    real(wp), intent(in) :: f(:, :) !! (columns, rows) [force]
    integer, intent(in) :: others(:) !! candidates of the body, ascending
    real(wp), intent(inout) :: u(:, :) !! (columns, others) [length]
    real(wp) :: c(size(rows), most_columns_at_once), change(size(f, 1), most_columns_at_once)
    integer :: first, width

    do first = 1, size(others), most_columns_at_once
      width = min(most_columns_at_once, size(others) - first + 1)
      call gather_block(body%compliance, rows, others(first:first + width - 1), c)
      change = 0.0_wp
      call add_times(size(f, 1), size(rows), width, f, c, change)
      u(:, first:first + width - 1) = u(:, first:first + width - 1) - change(:, :width)
    end do
  end subroutine subtract_beside

  !> A block of a symmetric matrix whose lower triangle counts.
  subroutine gather_block(lower, rows, columns, c)
    real(wp), intent(in) :: lower(:, :) !! the matrix
    integer, intent(in) :: rows(:) !! rows of the block, ascending
    integer, intent(in) :: columns(:) !! its columns, ascending
    real(wp), intent(inout) :: c(:, :) !! (rows, columns or more) the block
    integer :: i, j, above, below

    above = count(rows < columns(1))
    below = count(rows < columns(size(columns)))
    ! what lies across the diagonal is read along the columns of the matrix
    do i = 1, above
      do j = 1, size(columns)
        c(i, j) = lower(columns(j), rows(i))
      end do
    end do
    do j = 1, size(columns)
      do i = above + 1, below
        c(i, j) = lower(max(rows(i), columns(j)), min(rows(i), columns(j)))
      end do
      do i = below + 1, size(rows)
        c(i, j) = lower(rows(i), columns(j))
      end do
    end do
  end subroutine gather_block

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
    if (few == 1) then
      call dgemv('T', rows, n, 1.0_wp, c, rows, x, 1, 1.0_wp, y, 1)
      return
    end if
    width = max(1, min(most_columns_at_once, small_product/few/rows))
    do first = 1, n, width
      call dgemm('N', 'N', few, min(width, n - first + 1), rows, 1.0_wp, x, few, c(1, first), &
        rows, 1.0_wp, y(1, first), few)
    end do
  end subroutine add_times

  !> y = y - C x on the live candidates.
  subroutine subtract_product(bodies, x, y)
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
          call subtract_part(size(body%live, 1), body%skipped, body%n_live, body%live, part, change)
          y(first:last, :) = change
        end associate
      end associate
    end do
  end subroutine subtract_product

  !> The same for one body.
  subroutine subtract_part(rows, skipped, n, c, x, y)
    integer, intent(in) :: rows !! of c
    integer, intent(in) :: skipped !! those before the live candidates
    integer, intent(in) :: n !! live candidates
    real(wp), intent(in) :: c(rows, n) !! their columns of the compliance [length/force]
    real(wp), contiguous, intent(in) :: x(:, :) !! (n, columns) [force]
    real(wp), contiguous, intent(inout) :: y(:, :) !! (n, columns) [length]

    call dgemm('N', 'N', n, size(x, 2), n, -1.0_wp, c(skipped + 1, 1), rows, x, n, 1.0_wp, y, n)
  end subroutine subtract_part

  !> u = u - C f on all candidates; only the lower triangles of the compliances count.
  subroutine subtract_products(bodies, f, u)
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
  end subroutine subtract_products
end module touched_candidates

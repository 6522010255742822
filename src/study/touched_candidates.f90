!> Compliances times blocks of forces: on the candidates that closed elements touch, on all live
!! ones, and on all candidates (doc/theory, "Derivatives along the path").
module touched_candidates
  use kinds, only: wp
  use lapack_interface, only: dgemm, dsymm
  use condensed_types, only: condensed_t, condensed_body_t
  implicit none
  private
  public :: touched_t, gather_touched, add_product, add_times, subtract_yield, &
    subtract_yield_of_all

  !> Columns of a matrix that are multiplied at once, and rows times columns of both factors: for so
  !! small a product BLAS does not copy the matrix first, which took longer than the product.
  integer, parameter :: most_columns = 64, small_product = 900000

  !> The live candidates that closed elements touch: forces of contact act there alone.
  type :: touched_t
    integer, allocatable :: rows(:) !! (n) live candidates
    integer, allocatable :: place(:) !! (live) place in rows, 0 for none
    integer, allocatable :: first(:) !! (bodies+1) rows before each body
    type(part_t), allocatable :: bodies(:) !! their compliances
    real(wp), allocatable :: cu(:, :) !! (rank, n) C U, turned
  end type touched_t

  !> Compliance of one body.
  type :: part_t
    real(wp), allocatable :: c(:, :) !! (rows, rows) [length/force]
  end type part_t

contains

  !> The live candidates of elements with a part in the tangent, and what belongs to these.
  subroutine gather_touched(condensed, touched)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, live compliances
    type(touched_t), intent(out) :: touched !! all of it
    logical :: marked(condensed%alive%n_live)
    integer :: k, i, j, b

    marked = .false.
    associate (tangent => condensed%tangent)
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
      touched%rows = pack([(i, i=1, condensed%alive%n_live)], marked)
      touched%place = spread(0, 1, condensed%alive%n_live)
      touched%place(touched%rows) = [(i, i=1, size(touched%rows))]
      if (.not. tangent%whole) touched%cu = &
        transpose(tangent%cu(touched%rows, :tangent%rank))
    end associate
    allocate (touched%first(size(condensed%bodies) + 1), source=0)
    allocate (touched%bodies(size(condensed%bodies)))
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => touched%first(b))
        touched%first(b + 1) = first + count(touched%rows > body%first_live .and. &
          touched%rows <= body%first_live + body%n_live)
        associate (mine => touched%rows(first + 1:touched%first(b + 1)) - body%first_live)
          allocate (touched%bodies(b)%c(size(mine), size(mine)))
          do j = 1, size(mine)
            touched%bodies(b)%c(:, j) = body%live(mine, mine(j))
          end do
        end associate
      end associate
    end do

  contains

    !> Marks the candidates of an element.
    subroutine mark(dofs)
      integer, intent(in) :: dofs(:) !! live candidates, 0 for none

      marked(pack(dofs, dofs > 0)) = .true.
    end subroutine mark
  end subroutine gather_touched

  !> y = y + factor C x on the rows.
  subroutine add_product(touched, factor, x, y)
    type(touched_t), intent(in) :: touched !! rows, compliances
    real(wp), intent(in) :: factor !! of the product
    real(wp), intent(in) :: x(:, :) !! (rows, columns) [force]
    real(wp), intent(inout) :: y(:, :) !! (rows, columns) [length]
    real(wp) :: turned(size(x, 2), size(x, 1)), change(size(x, 2), size(x, 1))
    integer :: b

    turned = factor*transpose(x)
    change = transpose(y)
    do b = 1, size(touched%bodies)
      associate (first => touched%first(b) + 1, last => touched%first(b + 1), &
        n => touched%first(b + 1) - touched%first(b))
        call add_times(size(x, 2), n, n, turned(:, first:last), touched%bodies(b)%c, &
          change(:, first:last))
      end associate
    end do
    y = transpose(change)
  end subroutine add_product

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

!> The tangent of contact as one dense matrix on the directions of the nodes it touches, where there
!! are more rows of contact than these; and what both forms of the small matrix share (doc/theory,
!! "Contact operator of low rank").
module whole_tangent
  use kinds, only: wp
  use threads, only: worth_threads
  use lapack_interface, only: dgemv
  use condensed_types, only: condensed_t, condensed_body_t, contact_tangent_t
  use condensed_motions, only: push_live, add_live_motion
  use contact_sums, only: take_held
  implicit none
  private
  public :: is_better_whole, form_whole, make_small, combine, take_columns

  !> Rows that a closed point gives, mostly.
  integer, parameter :: rows_of_closed_point = 3
  !> Rows that a product takes at once.
  integer, parameter :: rows_of_product = 64
  !> Largest entry times compliance with which forces may be differences of displacements.
  real(wp), parameter :: stiffest_whole = 1.0e4_wp

contains

  !> There are more rows of contact than degrees of freedom they touch, as where facets have many
  !! points; and the penalty is no stiffer than displacements can tell.
  pure logical function is_better_whole(condensed, tangent) result(whole)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(in) :: tangent !! element matrices
    integer :: i, e
    logical :: touched(condensed%alive%n_live)

    touched = .false.
    do e = 1, tangent%elements
      do i = 1, size(tangent%dofs, 1)
        associate (dof => tangent%dofs(i, tangent%element(e)))
          if (dof > 0) touched(dof) = .true.
        end associate
      end do
    end do
    whole = rows_of_closed_point*tangent%elements > count(touched)
    if (whole) whole = stiffest_contact(condensed, tangent) <= stiffest_whole
  end function is_better_whole

  !> Largest entry on the diagonals of the element matrices times compliance.
  pure real(wp) function stiffest_contact(condensed, tangent) result(stiffest)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(in) :: tangent !! element matrices
    integer :: b, i, e
    real(wp) :: softness(condensed%alive%n_live)

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live > 0) softness(body%first_live + 1:body%first_live + body%n_live) = &
          body%diagonal(body%gathered)
      end associate
    end do
    stiffest = 0.0_wp
    do e = 1, tangent%elements
      associate (k => tangent%element(e))
        do i = 1, size(tangent%dofs, 1)
          if (tangent%dofs(i, k) > 0) stiffest = max(stiffest, abs(tangent%s(i, i, k)) &
            *softness(tangent%dofs(i, k)))
        end do
      end associate
    end do
  end function stiffest_contact

  !> I + V^T C U with the columns U of the sum of the element matrices, bordered by the rigid
  !! motions.
  subroutine form_whole(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live compliances, motions
    type(contact_tangent_t), intent(inout) :: tangent !! columns given; gets small, pivot
    integer :: b, j, first, last

    call make_small(tangent%rank + tangent%modes, 1, tangent)
    first = 1
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        last = first - 1 + count(tangent%held(1, :tangent%rank) > body%first_live .and. &
          tangent%held(1, :tangent%rank) <= body%first_live + body%n_live)
      end associate
      if (last >= first) call form_rows(condensed%bodies(b), first, last, tangent)
      first = last + 1
    end do
    do j = 1, tangent%rank
      tangent%small(j, j) = tangent%small(j, j) + 1.0_wp
    end do
    if (tangent%modes > 0) call border_whole(condensed, tangent)
  end subroutine form_whole

  !> The rows of V^T C U that belong to a body.
  subroutine form_rows(body, first, last, tangent)
    type(condensed_body_t), intent(in) :: body !! live compliance
    integer, intent(in) :: first, last !! its columns of V
    type(contact_tangent_t), intent(inout) :: tangent !! columns given; gets rows of small
    real(wp), allocatable :: c(:, :)
    integer :: place(body%n_live), mine(body%n_live), held(first:last, 3), i, j, k, n
    real(wp) :: share(body%n_live), hold(first:last, 3)

    do j = first, last
      do k = 1, 3
        held(j, k) = tangent%held(merge(k, 1, tangent%held(k, j) > 0), j) - body%first_live &
          + body%skipped
        hold(j, k) = merge(tangent%hold(k, j), 0.0_wp, tangent%held(k, j) > 0)
      end do
    end do
    associate (touched => pack(tangent%sum%column, tangent%sum%column > body%first_live .and. &
      tangent%sum%column <= body%first_live + body%n_live) - body%first_live)
      allocate (c(last - first + 1, size(touched)))
      do i = 1, size(touched)
        place(touched(i)) = i
        associate (compliance => body%live(:, touched(i)))
          do j = first, last
            c(j - first + 1, i) = hold(j, 1)*compliance(held(j, 1)) &
              + hold(j, 2)*compliance(held(j, 2)) + hold(j, 3)*compliance(held(j, 3))
          end do
        end associate
      end do
    end associate
    do j = 1, tangent%rank
      n = 0
      do i = tangent%lead%start(j), tangent%lead%start(j + 1) - 1
        k = tangent%lead%row(i) - body%first_live
        if (k < 1 .or. k > body%n_live) cycle
        n = n + 1
        mine(n) = place(k)
        share(n) = tangent%lead%value(i)
      end do
      call combine(c, 0, mine(:n), share(:n), tangent%small(first:last, j))
    end do
  end subroutine form_rows

  !> The border of the whole form: -V^T R beside it, and below it R^T U in the unit of the
  !! compliance; what holds the motions stands there.
  subroutine border_whole(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    type(contact_tangent_t), intent(inout) :: tangent !! columns given; gets the border of small
    real(wp) :: moved(condensed%alive%n_live), force(condensed%alive%n_live), alpha(tangent%modes)
    integer :: j, n

    n = tangent%rank
    do j = 1, tangent%modes
      alpha = 0.0_wp
      alpha(j) = 1.0_wp
      moved = 0.0_wp
      call add_live_motion(condensed, alpha, moved)
      call take_held(tangent, -moved, tangent%small(:n, n + j))
    end do
    tangent%small(n + 1:n + tangent%modes, n + 1:n + tangent%modes) = condensed%rigid%hold
    do j = 1, n
      force = 0.0_wp
      associate (first => tangent%lead%start(j), last => tangent%lead%start(j + 1) - 1)
        force(tangent%lead%row(first:last)) = tangent%lead%value(first:last)
      end associate
      call push_live(condensed, force, tangent%small(n + 1:n + tangent%modes, j))
    end do
  end subroutine border_whole

  !> Room for the small matrix of an order, and for the columns C U.
  subroutine make_small(order, columns, tangent)
    integer, intent(in) :: order !! its order
    integer, intent(in) :: columns !! length of the columns
    type(contact_tangent_t), intent(inout) :: tangent !! gets cu, small, pivot
    integer :: room

    room = 0
    if (allocated(tangent%small)) then
      room = size(tangent%small, 1)
      if (size(tangent%cu, 1) /= columns) room = 0
    end if
    if (room >= max(1, order)) return
    if (allocated(tangent%small)) deallocate (tangent%small, tangent%cu, tangent%pivot)
    room = 1 + order
    if (.not. tangent%whole) room = room + tangent%rank/4
    allocate (tangent%small(room, room), tangent%cu(columns, room), tangent%pivot(room))
  end subroutine make_small

  !> Sum of some columns with shares, three at a time.
  pure subroutine combine(a, skipped, column, share, y)
    real(wp), intent(in), contiguous :: a(:, :) !! the columns
    integer, intent(in) :: skipped !! rows of theirs before those of the sum
    integer, intent(in) :: column(:) !! which of them
    real(wp), intent(in) :: share(:) !! how much of each
    real(wp), intent(out) :: y(:) !! the sum
    integer :: i

    associate (first => skipped + 1, last => skipped + size(y))
      if (size(column) < 3) then
        y = 0.0_wp
      else
        y = share(1)*a(first:last, column(1)) + share(2)*a(first:last, column(2)) &
          + share(3)*a(first:last, column(3))
      end if
      do i = 4, size(column) - 2, 3
        y = y + share(i)*a(first:last, column(i)) + share(i + 1)*a(first:last, column(i + 1)) &
          + share(i + 2)*a(first:last, column(i + 2))
      end do
      do i = size(column)/3*3 + 1, size(column)
        y = y + share(i)*a(first:last, column(i))
      end do
    end associate
  end subroutine combine

  !> t = t - C U z, some strips of rows at a time where there are threads: each row is added up as
  !! it is in one thread.
  subroutine take_columns(rows, columns, cu, z, t)
    integer, intent(in) :: rows, columns !! of C U
    real(wp), intent(in) :: cu(rows, *) !! C U, perhaps with room for more columns
    real(wp), intent(in) :: z(columns) !! shares of the columns
    real(wp), intent(inout) :: t(rows) !! [length]
    integer :: part, parts, first, n

    parts = worth_threads(real(rows, wp)*real(columns, wp))
    !$omp parallel do schedule(static) default(none) private(first, n) &
    !$omp& shared(rows, columns, cu, z, t, parts) if(parts > 1)
    do part = 1, parts
      first = 1 + rows/rows_of_product*(part - 1)/parts*rows_of_product
      n = merge(rows, rows/rows_of_product*part/parts*rows_of_product, part == parts) + 1 - first
      call dgemv('N', n, columns, -1.0_wp, cu(first, 1), rows, z, 1, 1.0_wp, t(first), 1)
    end do
    !$omp end parallel do
  end subroutine take_columns
end module whole_tangent

!> The tangent of contact as one dense matrix on the degrees of freedom in use, where there are more
!! rows of contact than these; and what both forms of the small matrix share (doc/theory,
!! "Condensed contact").
module whole_tangent
  use kinds, only: wp
  use condensed_types, only: condensed_t, contact_tangent_t
  use supports, only: grounding
  use system_types, only: system_t
  implicit none
  private
  public :: drag_bodies, is_better_whole, sum_elements, form_whole, make_small, combine

  !> Rows that a closed point gives, mostly.
  integer, parameter :: rows_of_point = 3
  !> Largest entry times compliance with which forces may be differences of displacements.
  real(wp), parameter :: stiffest_whole = 1.0e4_wp

contains

  !> How much the rigid motions of each body are held in the tangent alone: as the increment asks
  !! for, and where contact does not hold it.
  pure subroutine drag_bodies(system)
    type(system_t), intent(inout) :: system !! grounded, drag; compliance gathered
    integer :: b

    do b = 1, system%bodies
      associate (body => system%condensed%bodies(b))
        body%drag = system%drag
        if (system%grounded(b)) body%drag = body%drag &
          + grounding*real(size(body%node), wp)/body%softness
      end associate
    end do
  end subroutine drag_bodies

  !> There are more rows of contact than degrees of freedom they touch, as where facets have many
  !! points; and the penalty is no stiffer than displacements can tell.
  pure logical function is_better_whole(condensed, tangent) result(whole)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(in) :: tangent !! element matrices
    real(wp) :: stiffest
    integer :: b, i, e
    real(wp) :: softness(condensed%n_live)

    whole = rows_of_point*tangent%elements > condensed%n_live
    if (.not. whole) return
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        softness(body%first_live + 1:body%first_live + body%n_live) = &
          [(body%live(i, i), i=1, body%n_live)]
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
    whole = stiffest <= stiffest_whole
  end function is_better_whole

  !> The element matrices at hand, summed at the live candidates.
  subroutine sum_elements(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live candidates
    type(contact_tangent_t), intent(inout) :: tangent !! gets sum, rank
    integer :: e, i, j

    tangent%rank = condensed%n_live
    if (allocated(tangent%sum)) then
      if (size(tangent%sum, 1) /= tangent%rank) deallocate (tangent%sum)
    end if
    if (.not. allocated(tangent%sum)) allocate (tangent%sum(tangent%rank, tangent%rank))
    tangent%sum = 0.0_wp
    do e = 1, tangent%elements
      associate (s => tangent%s(:, :, tangent%element(e)), dofs => tangent%dofs(:, &
        tangent%element(e)))
        do j = 1, size(tangent%dofs, 1)
          if (dofs(j) == 0) cycle
          do i = 1, size(tangent%dofs, 1)
            if (dofs(i) > 0) tangent%sum(dofs(i), dofs(j)) = tangent%sum(dofs(i), dofs(j)) &
              + s(i, j)
          end do
        end do
      end associate
    end do
  end subroutine sum_elements

  !> I + C K with the sum K of the element matrices, bordered by the rigid motions.
  subroutine form_whole(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live compliances, motions
    type(contact_tangent_t), intent(inout) :: tangent !! sum given; gets small, pivot
    integer :: b, i, j, n

    n = tangent%rank
    call make_small(n + tangent%modes, 1, tangent)
    do j = 1, n
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_live, &
          last => condensed%bodies(b)%first_live + condensed%bodies(b)%n_live)
          associate (mine => pack([(i, i=1, body%n_live)], abs(tangent%sum(first + 1:last, j)) &
            > 0.0_wp))
            call combine(body%live, mine, tangent%sum(first + mine, j), &
              tangent%small(first + 1:last, j))
          end associate
        end associate
      end do
      tangent%small(j, j) = tangent%small(j, j) + 1.0_wp
    end do
    tangent%small(n + 1:n + tangent%modes, :n + tangent%modes) = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_live, &
        last => condensed%bodies(b)%first_live + condensed%bodies(b)%n_live)
        do j = 1, body%motions%n
          associate (row => n + body%first_mode + j)
            tangent%small(:n, row) = 0.0_wp
            tangent%small(first + 1:last, row) = -body%modes(body%gathered, j)
            tangent%small(row, :n) = body%softness*matmul(body%modes(body%gathered, j), &
              tangent%sum(first + 1:last, :))
            tangent%small(row, row) = body%softness*body%drag
          end associate
        end do
      end associate
    end do
  end subroutine form_whole

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
  pure subroutine combine(a, column, share, y)
    real(wp), intent(in), contiguous :: a(:, :) !! the columns
    integer, intent(in) :: column(:) !! which of them
    real(wp), intent(in) :: share(:) !! how much of each
    real(wp), intent(out) :: y(:) !! the sum
    integer :: i

    y = 0.0_wp
    do i = 1, size(column) - 2, 3
      y = y + share(i)*a(:, column(i)) + share(i + 1)*a(:, column(i + 1)) &
        + share(i + 2)*a(:, column(i + 2))
    end do
    do i = size(column)/3*3 + 1, size(column)
      y = y + share(i)*a(:, column(i))
    end do
  end subroutine combine
end module whole_tangent

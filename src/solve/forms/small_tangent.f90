!> The small matrix of contact in double precision, and its factor (doc/theory, "Contact operator of
!! low rank").
module small_tangent
  use kinds, only: wp
  use threads, only: pays_threads
  use lapack_interface, only: dgetrf
  use condensed_types, only: condensed_t, contact_tangent_t
  use live_candidates, only: own_part
  use whole_tangent, only: form_whole, make_small, combine
  implicit none
  private
  public :: form_double

  !> Columns of the matrix that are formed at a time.
  integer, parameter :: columns_formed = 8

contains

  !> The small matrix, of the whole form or of the other, and its factor.
  subroutine form_double(condensed, tangent, info)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! columns given; gets small, pivot
    integer, intent(out) :: info !! 0: there is a factor

    if (tangent%whole) then
      call form_whole(condensed, tangent)
    else
      call form_small(condensed, tangent)
    end if
    info = 0
    associate (n => tangent%rank + tangent%modes)
      if (n > 0) call dgetrf(n, n, tangent%small, size(tangent%small, 1), tangent%pivot, info)
    end associate
  end subroutine form_double

  !> C U and I + V^T C U.
  subroutine form_small(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! gets cu, small, pivot
    integer :: j
    logical :: pays

    call make_small(tangent%rank + tangent%modes, condensed%alive%n_live, tangent)
    pays = pays_threads(real(tangent%rank, wp)*size(tangent%dofs, 1)*condensed%alive%n_live)
    !$omp parallel do schedule(static) default(none) shared(condensed, tangent) if(pays)
    do j = 1, tangent%rank
      call add_columns(condensed, tangent%dofs(:, tangent%owner(j)), tangent%u(:, j), &
        tangent%cu(:, j))
    end do
    !$omp end parallel do
    if (tangent%modes > 0) call border_with_motions(condensed, tangent)
    pays = pays_threads(real(tangent%rank, wp)**2*size(tangent%dofs, 1))
    !$omp parallel do schedule(static) default(none) shared(tangent) if(pays)
    do j = 1, tangent%rank + tangent%modes, columns_formed
      call multiply_rows(tangent, j, min(columns_formed, tangent%rank + tangent%modes - j + 1))
    end do
    !$omp end parallel do
  end subroutine form_small

  !> The border of the small matrix: -R beside C U, and below them R^T U, which balances the forces
  !! on each rigid motion, in the unit of the compliance; a regularised body has springs there.
  subroutine border_with_motions(condensed, tangent)
    type(condensed_t), intent(in) :: condensed !! live candidates, motions
    type(contact_tangent_t), intent(inout) :: tangent !! u given; gets columns of cu, rows of small
    integer :: b, i, j, k

    associate (n => tangent%rank)
      tangent%cu(:, n + 1:n + tangent%modes) = 0.0_wp
      tangent%small(n + 1:n + tangent%modes, :n) = 0.0_wp
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = 1, body%motions%n
            do i = 1, body%n_live
              tangent%cu(body%first_live + i, n + body%first_mode + j) = &
                -body%modes(body%gathered(i), j)
            end do
          end do
        end associate
      end do
      do k = 1, n
        associate (dofs => tangent%dofs(:, tangent%owner(k)))
          do i = 1, size(tangent%dofs, 1)
            if (dofs(i) == 0) cycle
            tangent%small(n + 1:n + tangent%modes, k) = tangent%small(n + 1:n + tangent%modes, k) &
              - tangent%u(i, k)*tangent%cu(dofs(i), n + 1:n + tangent%modes)
          end do
        end associate
      end do
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = n + body%first_mode + 1, n + body%first_mode + body%motions%n
            tangent%small(j, :n) = body%softness*tangent%small(j, :n)
          end do
        end associate
      end do
      tangent%small(n + 1:n + tangent%modes, n + 1:n + tangent%modes) = condensed%rigid%hold
    end associate
  end subroutine border_with_motions

  !> Some columns of I + V^T C U. They are turned first, so that a degree of freedom of V finds all
  !! of them side by side.
  subroutine multiply_rows(tangent, first, columns)
    type(contact_tangent_t), intent(inout) :: tangent !! v and cu given; gets small
    integer, intent(in) :: first !! the first column
    integer, intent(in) :: columns !! how many, at most block
    real(wp) :: turned(columns_formed, size(tangent%cu, 1)), total(columns_formed)
    integer :: i, k

    turned = 0.0_wp
    turned(:columns, :) = transpose(tangent%cu(:, first:first + columns - 1))
    do k = 1, tangent%rank
      total = 0.0_wp
      associate (dofs => tangent%dofs(:, tangent%owner(k)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) total = total + tangent%v(i, k)*turned(:, dofs(i))
        end do
      end associate
      tangent%small(k, first:first + columns - 1) = total(:columns)
    end do
    do k = first, min(first + columns - 1, tangent%rank)
      tangent%small(k, k) = tangent%small(k, k) + 1.0_wp
    end do
  end subroutine multiply_rows

  !> y = C u for a u that few degrees of freedom have.
  subroutine add_columns(condensed, dofs, u, y)
    type(condensed_t), intent(in) :: condensed !! live compliances
    integer, intent(in) :: dofs(:) !! live candidates, 0 for none
    real(wp), intent(in) :: u(:) !! values
    real(wp), intent(out) :: y(:) !! (n_live) C u
    integer :: b, n, mine(size(dofs))
    real(wp) :: share(size(dofs))

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        call own_part(body, dofs, u, n, mine, share)
        call combine(body%live, body%skipped, mine(:n), share(:n), &
          y(body%first_live + 1:body%first_live + body%n_live))
      end associate
    end do
  end subroutine add_columns
end module small_tangent

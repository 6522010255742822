!> The small matrix of contact in double precision, its factor, and what that answers (doc/theory,
!! "Contact operator of low rank").
module small_tangent
  use kinds, only: wp
  use threads, only: pays_threads
  use lapack_interface, only: dgetrf, dgetrs
  use condensed_types, only: condensed_t, contact_tangent_t
  use live_candidates, only: own_part, apply_compliance
  use whole_tangent, only: form_whole, make_small, combine, take_columns
  use condensed_motions, only: add_live_motion
  use contact_sums, only: take_shares
  use sparse_columns, only: add_product
  implicit none
  private
  public :: form_double, answer_leading

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

  !> What a displacement d becomes when the leading part of contact answers it: the shares z of the
  !! columns, (I + V^T C U) z = V^T d, and t = d - C U z.
  subroutine answer_leading(condensed, d, push, z, t)
    type(condensed_t), intent(in) :: condensed !! tangent with its factor, live compliances
    real(wp), intent(in) :: d(:) !! (live) [length]
    real(wp), intent(in) :: push(:) !! (modes) what the forces shall do to the motions [length]
    real(wp), intent(out) :: z(:) !! (rank+modes) the force is U z, then the rigid motions
    real(wp), intent(out) :: t(:) !! (live) [length]
    real(wp) :: force(size(d))
    integer :: n, info

    associate (tangent => condensed%tangent)
      n = tangent%rank + tangent%modes
      t = d
      if (n == 0) return
      call take_shares(tangent, d, z(:tangent%rank))
      z(tangent%rank + 1:n) = push
      call dgetrs('N', n, 1, tangent%small, size(tangent%small, 1), tangent%pivot, z, n, info)
      if (tangent%whole) then
        force = 0.0_wp
        call add_product(tangent%lead, z(:tangent%rank), force)
        call apply_compliance(condensed, force, t)
        t = d - t
        if (tangent%modes > 0) call add_live_motion(condensed, z(tangent%rank + 1:n), t)
      else if (size(d) > 0) then
        call take_columns(size(d), n, tangent%cu, z, t)
      end if
    end associate
  end subroutine answer_leading
end module small_tangent

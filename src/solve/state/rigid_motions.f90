!> Rigid motions of bodies: what the supports of a body leave of them, and fixings that would stop
!! just these (doc/theory, "Condensed floating bodies").
module rigid_motions
  use kinds, only: wp
  use lapack_interface, only: dsyev
  implicit none
  private
  public :: rigid_row, motions_t, find_motions, mode_row, choose_fixings

  !> Eigenvalues of a body's support below this share of the largest belong to free motions.
  real(wp), parameter :: free_tolerance = 1.0e-12_wp

  !> The rigid motions that the supports of one body leave.
  type :: motions_t
    integer :: n = 0 !! how many, 0 to 6
    real(wp) :: center(3) = 0.0_wp !! where rotations turn about [length]
    real(wp) :: size = 1.0_wp !! extent of the body [length]
    real(wp) :: basis(6, 6) = 0.0_wp !! (6, n) translation and rotation times size, orthonormal
  end type motions_t

contains

  !> Component k of the displacement at y of the six unit motions.
  pure function rigid_row(k, y) result(row)
    integer, intent(in) :: k !! 1, 2 or 3
    real(wp), intent(in) :: y(3) !! position from the center, over the size
    real(wp) :: row(6)

    row = 0.0_wp
    row(k) = 1.0_wp
    select case (k)
    case (1)
      row(5:6) = [y(3), -y(2)]
    case (2)
      row(4) = -y(3)
      row(6) = y(1)
    case default
      row(4:5) = [y(2), -y(1)]
    end select
  end function rigid_row

  !> The motions of a body that no support resists: the null space of the supports' Gram matrix.
  subroutine find_motions(x, equation, node_body, body, motions)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    integer, intent(in) :: node_body(:) !! (nodes) body of each node
    integer, intent(in) :: body !! the body
    type(motions_t), intent(out) :: motions !! what is left
    real(wp) :: gram(6, 6), values(6), work(200), row(6), low(3), high(3)
    integer :: i, k, info
    logical :: free

    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do i = 1, size(node_body)
      if (node_body(i) /= body) cycle
      low = min(low, x(:, i))
      high = max(high, x(:, i))
    end do
    motions%center = 0.5_wp*(low + high)
    motions%size = max(0.5_wp*norm2(high - low), tiny(1.0_wp))
    gram = 0.0_wp
    free = .false.
    do i = 1, size(node_body)
      if (node_body(i) /= body) cycle
      do k = 1, 3
        if (equation(k, i) > 0) then
          free = .true.
          cycle
        end if
        row = rigid_row(k, (x(:, i) - motions%center)/motions%size)
        gram = gram + spread(row, 2, 6)*spread(row, 1, 6)
      end do
    end do
    if (.not. free) return
    call dsyev('V', 'U', 6, gram, 6, values, work, size(work), info)
    if (info /= 0) return
    motions%n = count(values <= free_tolerance*max(values(6), 1.0_wp))
    motions%basis = gram
  end subroutine find_motions

  !> Component k of the displacement that each motion gives a node.
  pure function mode_row(motions, k, x) result(row)
    type(motions_t), intent(in) :: motions !! of its body
    integer, intent(in) :: k !! 1, 2 or 3
    real(wp), intent(in) :: x(3) !! reference position of the node [length]
    real(wp) :: row(motions%n)

    row = matmul(rigid_row(k, (x - motions%center)/motions%size), motions%basis(:, :motions%n))
  end function mode_row

  !> As many free degrees of freedom as there are motions, that together stop all of them: the
  !! largest rows of R by elimination with orthogonal rows.
  subroutine choose_fixings(x, equation, node_body, body, motions, node, direction)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    integer, intent(in) :: node_body(:) !! (nodes) body of each node
    integer, intent(in) :: body !! the body
    type(motions_t), intent(in) :: motions !! what its supports leave
    integer, allocatable, intent(out) :: node(:), direction(:) !! (motions) the fixings
    real(wp) :: taken(motions%n, motions%n), row(motions%n), best(motions%n)
    integer :: fixing, i, k, j

    allocate (node(motions%n), direction(motions%n), source=0)
    do fixing = 1, motions%n
      best = 0.0_wp
      do i = 1, size(node_body)
        if (node_body(i) /= body) cycle
        do k = 1, 3
          if (equation(k, i) == 0) cycle
          row = mode_row(motions, k, x(:, i))
          do j = 1, fixing - 1
            row = row - dot_product(taken(:, j), row)*taken(:, j)
          end do
          if (norm2(row) <= norm2(best)) cycle
          best = row
          node(fixing) = i
          direction(fixing) = k
        end do
      end do
      taken(:, fixing) = best/norm2(best)
    end do
  end subroutine choose_fixings
end module rigid_motions

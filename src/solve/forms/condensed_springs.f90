!> What holds the rigid motions of condensed bodies in the tangent alone: damping that the increment
!! asks for, and soft springs where contact resists nothing (doc/theory, "Condensed floating
!! bodies").
module condensed_springs
  use kinds, only: wp
  use lapack_interface, only: dgesvd, dgelss
  use condensed_types, only: condensed_t
  use condensed_motions, only: add_live_motion, push_live
  use contact_sums, only: take_shares, add_leading
  use supports, only: soft_springs, unresisted
  use system_types, only: system_t
  implicit none
  private
  public :: hold_motions, stay_in_place

contains

  !> Stiffness against the rigid motions, in the unit of the compliance.
  subroutine hold_motions(system, condensed)
    type(system_t), intent(in) :: system !! columns of contact, regularised, damping
    type(condensed_t), intent(inout) :: condensed !! gets hold
    real(wp) :: stiffness(condensed%rigid%modes)
    integer :: b, j

    associate (n => condensed%rigid%modes)
      condensed%rigid%hold = reshape([real(wp) ::], [n, n], [0.0_wp])
      if (allocated(condensed%rigid%loose)) deallocate (condensed%rigid%loose)
      stiffness = 0.0_wp
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = body%first_mode + 1, body%first_mode + body%motions%n
            if (system%body%regularised(b)) stiffness(j) = soft_springs*real(size(body%node), wp)
          end do
        end associate
      end do
      if (any(stiffness > 0.0_wp)) call spring_motions(condensed, stiffness, condensed%rigid%hold, &
        condensed%rigid%loose)
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = body%first_mode + 1, body%first_mode + body%motions%n
            condensed%rigid%hold(j, j) = condensed%rigid%hold(j, j) + body%softness &
              *system%body%damping
          end do
        end associate
      end do
    end associate
  end subroutine hold_motions

  !> The soft springs where contact resists nothing: P G Q with the projectors P on motions
  !! that forces of contact do no work on and Q on motions that make no forces of contact. Bodies
  !! that are not regularised count, too: they may go along with one that is.
  subroutine spring_motions(condensed, stiffness, spring, loose)
    type(condensed_t), intent(in) :: condensed !! bodies, columns of contact
    real(wp), intent(in) :: stiffness(:) !! (n) G, 0 for bodies that are not regularised
    real(wp), intent(inout) :: spring(:, :) !! (n, n) 0; gets P G Q
    real(wp), allocatable, intent(out) :: loose(:, :) !! (n, any) orthonormal, Q is onto them
    real(wp), dimension(size(stiffness), size(stiffness)) :: a, p, q
    real(wp) :: s(size(stiffness)), work(10*size(stiffness) + 64)
    integer :: j, n, info, rank

    n = size(stiffness)
    call form_resistance(condensed, a)
    call dgesvd('A', 'A', n, n, a, n, s, p, n, q, n, work, size(work), info)
    rank = count(s > unresisted*s(1))
    if (info == 0) loose = transpose(q(rank + 1:, :))
    if (info /= 0 .or. rank == 0) then
      do j = 1, n
        spring(j, j) = stiffness(j)
      end do
      return
    end if
    associate (left => p(:, rank + 1:), right => transpose(q(rank + 1:, :)))
      spring = matmul(left, matmul(matmul(transpose(left), &
        spread(stiffness, 2, n - rank)*right), transpose(right)))
    end associate
  end subroutine spring_motions

  !> A direction without what motions that contact does not resist add to it but for their springs:
  !! by compliances, which stand still at the fixings, a body that is pressed would go aside. At the
  !! live candidates the least squares of the rest along these motions vanish.
  subroutine stay_in_place(condensed)
    type(condensed_t), intent(inout) :: condensed !! direction found; gets change, alpha_next
    real(wp), allocatable :: way(:, :), rest(:, :), least(:), work(:)
    integer :: j, n, live, rank, info

    if (.not. allocated(condensed%rigid%loose)) return
    if (condensed%alive%n_live == 0) return
    associate (loose => condensed%rigid%loose)
      n = size(loose, 2)
      live = condensed%alive%n_live
      allocate (way(live, n), rest(max(live, n), 1), source=0.0_wp)
      allocate (least(min(live, n)), work(10*n + 64 + live))
      do j = 1, n
        call add_live_motion(condensed, loose(:, j), way(:, j))
      end do
      rest(:live, 1) = matmul(way, matmul(condensed%rigid%alpha_next, loose)) - &
        condensed%alive%change
      call dgelss(live, n, 1, way, live, rest, size(rest, 1), least, unresisted, rank, work, &
        size(work), info)
      if (info /= 0) return
      associate (back => matmul(loose, rest(:n, 1)))
        condensed%rigid%alpha_next = condensed%rigid%alpha_next + back
        call add_live_motion(condensed, back, condensed%alive%change)
      end associate
    end associate
  end subroutine stay_in_place

  !> What the leading part of contact does against motions of the bodies: R^T U V^T R, times the
  !! compliance of the bodies.
  pure subroutine form_resistance(condensed, a)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies, columns of contact
    real(wp), intent(out) :: a(:, :) !! (n, n)
    real(wp), dimension(condensed%alive%n_live) :: way, force
    real(wp) :: only(size(a, 1)), share(condensed%tangent%rank)
    integer :: j

    do j = 1, size(a, 1)
      only = 0.0_wp
      only(j) = 1.0_wp
      way = 0.0_wp
      call add_live_motion(condensed, only, way)
      call take_shares(condensed%tangent, way, share)
      force = 0.0_wp
      call add_leading(condensed%tangent, share, force)
      call push_live(condensed, force, a(:, j))
    end do
  end subroutine form_resistance
end module condensed_springs

!> What holds the rigid motions of condensed bodies in the tangent alone: a drag that the increment
!! asks for, and grounding where contact resists nothing (doc/theory, "Bodies that contact holds").
module condensed_ground
  use kinds, only: wp
  use lapack_interface, only: dgesvd
  use condensed_types, only: condensed_t
  use condensed_motions, only: add_live_motion, push_live
  use contact_sums, only: take_shares, add_leading
  use supports, only: grounding
  use ground_release, only: unresisted
  use system_types, only: system_t
  implicit none
  private
  public :: hold_motions

contains

  !> Stiffness against the rigid motions, in the unit of the compliance.
  subroutine hold_motions(system)
    type(system_t), intent(inout) :: system !! columns of contact, grounded, drag; gets hold
    real(wp) :: ground(system%condensed%rigid%modes)
    integer :: b, j

    associate (condensed => system%condensed, n => system%condensed%rigid%modes)
      condensed%rigid%hold = reshape([real(wp) ::], [n, n], [0.0_wp])
      ground = 0.0_wp
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = body%first_mode + 1, body%first_mode + body%motions%n
            if (system%body%grounded(b)) ground(j) = grounding*real(size(body%node), wp)
          end do
        end associate
      end do
      if (any(ground > 0.0_wp)) call ground_motions(condensed, ground, condensed%rigid%hold)
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = body%first_mode + 1, body%first_mode + body%motions%n
            condensed%rigid%hold(j, j) = condensed%rigid%hold(j, j) + body%softness &
              *system%body%drag
          end do
        end associate
      end do
    end associate
  end subroutine hold_motions

  !> The springs of grounding where contact resists nothing: P G Q with the projectors P on motions
  !! that forces of contact do no work on and Q on motions that make no forces of contact. Bodies
  !! that are not grounded count, too: they may go along with one that is.
  subroutine ground_motions(condensed, ground, spring)
    type(condensed_t), intent(in) :: condensed !! bodies, columns of contact
    real(wp), intent(in) :: ground(:) !! (n) G, 0 for bodies that are not grounded
    real(wp), intent(inout) :: spring(:, :) !! (n, n) 0; gets P G Q
    real(wp), dimension(size(ground), size(ground)) :: a, p, q
    real(wp) :: s(size(ground)), work(10*size(ground) + 64)
    integer :: j, n, info, rank

    n = size(ground)
    call form_resistance(condensed, a)
    call dgesvd('A', 'A', n, n, a, n, s, p, n, q, n, work, size(work), info)
    rank = count(s > unresisted*s(1))
    if (info /= 0 .or. rank == 0) then
      do j = 1, n
        spring(j, j) = ground(j)
      end do
      return
    end if
    associate (left => p(:, rank + 1:), right => transpose(q(rank + 1:, :)))
      spring = matmul(left, matmul(matmul(transpose(left), &
        spread(ground, 2, n - rank)*right), transpose(right)))
    end associate
  end subroutine ground_motions

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
end module condensed_ground

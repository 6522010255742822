!> What holds the rigid motions of condensed bodies in the tangent alone: a drag that the increment
!! asks for, and grounding where contact resists nothing (doc/theory, "Bodies that contact holds").
module condensed_ground
  use kinds, only: wp
  use lapack_interface, only: dgesvd
  use condensed_types, only: condensed_t
  use supports, only: grounding
  use ground_release, only: unresisted
  use system_types, only: system_t
  implicit none
  private
  public :: hold_motions

contains

  !> Stiffness against the rigid motions, in the unit of the compliance.
  subroutine hold_motions(system)
    type(system_t), intent(inout) :: system !! element matrices, grounded, drag; gets hold
    real(wp), allocatable :: spring(:, :)
    integer, allocatable :: free(:)
    integer :: b, j

    associate (condensed => system%condensed, modes => system%condensed%rigid%modes)
      condensed%rigid%hold = reshape([real(wp) ::], [modes, modes], [0.0_wp])
      free = [integer ::]
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          do j = body%first_mode + 1, body%first_mode + body%motions%n
            condensed%rigid%hold(j, j) = body%softness*system%body%drag
            if (system%body%grounded(b)) free = [free, j]
          end do
        end associate
      end do
      if (size(free) == 0) return
      call ground_motions(condensed, free, spring)
      condensed%rigid%hold(free, free) = condensed%rigid%hold(free, free) + spring
    end associate
  end subroutine hold_motions

  !> The springs of grounding, times the compliance of their bodies, where contact resists nothing:
  !! P G Q with the projectors P on motions that forces of contact do no work on and Q on motions
  !! that make no forces of contact.
  subroutine ground_motions(condensed, free, spring)
    type(condensed_t), intent(in) :: condensed !! bodies, element matrices of contact
    integer, intent(in) :: free(:) !! (n) motions of grounded bodies
    real(wp), allocatable, intent(out) :: spring(:, :) !! (n, n)
    real(wp) :: a(size(free), size(free)), p(size(free), size(free)), q(size(free), size(free))
    real(wp) :: s(size(free)), work(10*size(free) + 64), softness(size(free)), stiffness(size(free))
    integer :: b, n, info, rank

    n = size(free)
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%motions%n == 0) cycle
        where (free > body%first_mode .and. free <= body%first_mode + body%motions%n)
          softness = body%softness
          stiffness = grounding*real(size(body%node), wp)/body%softness
        end where
      end associate
    end do
    call form_resistance(condensed, free, a)
    call dgesvd('A', 'A', n, n, a, n, s, p, n, q, n, work, size(work), info)
    rank = count(s > unresisted*s(1))
    if (info /= 0) rank = 0
    if (rank == 0) then
      spring = reshape([real(wp) ::], [n, n], [0.0_wp])
      do b = 1, n
        spring(b, b) = softness(b)*stiffness(b)
      end do
      return
    end if
    associate (left => p(:, rank + 1:), right => transpose(q(rank + 1:, :)))
      spring = spread(softness, 2, n)*matmul(left, matmul(matmul(transpose(left), &
        spread(stiffness, 2, n - rank)*right), transpose(right)))
    end associate
  end subroutine ground_motions

  !> What contact does against motions of the bodies: R^T k R.
  pure subroutine form_resistance(condensed, free, a)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies, element matrices of contact
    integer, intent(in) :: free(:) !! (n) motions
    real(wp), intent(out) :: a(:, :) !! (n, n) [force/length]
    real(wp) :: motion(condensed%alive%n_live, condensed%rigid%modes)
    real(wp) :: local(size(condensed%tangent%dofs, 1), size(free))
    integer :: b, i, e

    motion = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        do i = 1, merge(body%n_live, 0, body%motions%n > 0)
          motion(body%first_live + i, body%first_mode + 1:body%first_mode + body%motions%n) = &
            body%modes(body%gathered(i), :)
        end do
      end associate
    end do
    a = 0.0_wp
    associate (tangent => condensed%tangent)
      do e = 1, tangent%elements
        associate (dofs => tangent%dofs(:, tangent%element(e)))
          local = 0.0_wp
          do i = 1, size(dofs)
            if (dofs(i) > 0) local(i, :) = motion(dofs(i), free)
          end do
          a = a + matmul(transpose(local), matmul(tangent%s(:, :, tangent%element(e)), local))
        end associate
      end do
    end associate
  end subroutine form_resistance
end module condensed_ground

!> What the compliance of a body that contact alone holds owes to its pins: rigid motions, which are
!! unknowns by themselves (doc/theory, "Condensed contact").
module carried_motions
  use kinds, only: wp
  use lapack_interface, only: dgelss, dsymv
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: part_motions, add_carried, carry

contains

  !> What of the compliance is rigid motion of the bodies: C = C' + R X^T + X R^T, where C' neither
  !! feels forces that balance on the motions R nor moves along these. The springs that pin a
  !! body carry forces from one end of it to the other; with C' the blocks know nothing of them.
  subroutine part_motions(condensed, carried)
    type(condensed_t), intent(in) :: condensed !! live compliances, motions
    real(wp), allocatable, intent(out) :: carried(:, :) !! (live, 6) X
    real(wp) :: normal(6, 6), share(6, 6), values(6), work(200)
    real(wp), allocatable :: modes(:, :), moved(:, :)
    integer :: b, k, rank, info

    allocate (carried(condensed%alive%n_live, 6), source=0.0_wp)
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), n => condensed%bodies(b)%motions%n, &
        first => condensed%bodies(b)%first_live)
        if (n == 0 .or. body%n_live == 0) cycle
        modes = body%modes(body%gathered, :)
        normal(:n, :n) = matmul(transpose(modes), modes)
        share = 0.0_wp
        do k = 1, n
          share(k, k) = 1.0_wp
        end do
        call dgelss(n, n, n, normal, 6, share, 6, values, 1.0e-10_wp, rank, work, size(work), info)
        if (info /= 0 .or. rank < n) cycle
        modes = matmul(modes, share(:n, :n))
        allocate (moved(body%n_live, n))
        do k = 1, n
          call dsymv('L', body%n_live, 1.0_wp, body%live, body%n_live, modes(:, k), 1, 0.0_wp, &
            moved(:, k), 1)
        end do
        share(:n, :n) = matmul(transpose(modes), moved)
        carried(first + 1:first + body%n_live, :n) = moved &
          - 0.5_wp*matmul(body%modes(body%gathered, :), share(:n, :n))
        deallocate (moved)
      end associate
    end do
  end subroutine part_motions

  !> Adds X p for what is asked of the rigid motions.
  pure subroutine add_carried(condensed, carried, push, t)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    real(wp), intent(in) :: carried(:, :) !! (live, 6) X
    real(wp), intent(in) :: push(:) !! (modes) p [length]
    real(wp), intent(inout) :: t(:) !! (live) [length]
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), n => condensed%bodies(b)%motions%n)
        if (n == 0) cycle
        associate (mine => t(body%first_live + 1:body%first_live + body%n_live))
          mine = mine + matmul(carried(body%first_live + 1:body%first_live + body%n_live, :n), &
            push(body%first_mode + 1:body%first_mode + n)/body%softness)
        end associate
      end associate
    end do
  end subroutine add_carried

  !> Adds X^T y to rigid motions.
  pure subroutine carry(condensed, carried, y, alpha)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    real(wp), intent(in) :: carried(:, :) !! (live, 6) X
    real(wp), intent(in) :: y(:) !! (live) [force]
    real(wp), intent(inout) :: alpha(:) !! (modes) [length]
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), n => condensed%bodies(b)%motions%n)
        if (n == 0) cycle
        associate (mine => alpha(body%first_mode + 1:body%first_mode + n))
          mine = mine + matmul(y(body%first_live + 1:body%first_live + body%n_live), &
            carried(body%first_live + 1:body%first_live + body%n_live, :n))
        end associate
      end associate
    end do
  end subroutine carry
end module carried_motions

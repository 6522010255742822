!> What is kept of the multipliers while they come along with Newton's iteration (doc/theory,
!! "Simultaneous multiplier update").
module multiplier_types
  use kinds, only: wp
  implicit none
  private
  public :: multiplier_motion_t, shift_multipliers, settle_multipliers

  !> Multipliers of the contact points, and how forces depend on them at the present iterate.
  type :: multiplier_motion_t
    logical :: active = .false. !! they come along in this solve
    real(wp), allocatable :: scale(:) !! (n) shift over multiplier; 0 where a point has none
    real(wp), allocatable :: start(:, :) !! (3, n) before the step, in the targets' frames [force]
    real(wp), allocatable :: way(:, :) !! (3, n) change of a full step [force]
    real(wp), allocatable :: force(:, :) !! (3, n) contact forces, likewise [force]
    real(wp), allocatable :: by_place(:, :, :) !! (3, dofs of an element, n) df/du [force/length]
    real(wp), allocatable :: by_shift(:, :, :) !! (3, 3, n) df/dkappa [force/length]
    real(wp), allocatable :: of_nodes(:, :, :) !! (3, its dofs, n) dr/dkappa [force/length]
    real(wp) :: rest = 0.0_wp !! norm of what the multipliers lack at the present iterate [force]
    real(wp) :: before = 0.0_wp !! the same one iteration ago, 0 if there is none [force]
  end type multiplier_motion_t

contains

  !> Shifts of the points at a share of the way.
  pure subroutine shift_multipliers(motion, length, shift)
    type(multiplier_motion_t), intent(in) :: motion !! multipliers and their change
    real(wp), intent(in) :: length !! share of the way
    real(wp), intent(inout) :: shift(:, :) !! (3, n) of points with multipliers [length]
    integer :: k

    do k = 1, size(motion%scale)
      if (motion%scale(k) > 0.0_wp) shift(:, k) = motion%scale(k)*(motion%start(:, k) + &
        length*motion%way(:, k))
    end do
  end subroutine shift_multipliers

  !> Moves the multipliers by the step that has been taken.
  pure subroutine settle_multipliers(motion, length)
    type(multiplier_motion_t), intent(inout) :: motion !! motion
    real(wp), intent(in) :: length !! share of the way

    motion%start = motion%start + length*motion%way
    motion%way = 0.0_wp
  end subroutine settle_multipliers
end module multiplier_types

!> What is known of the first touches of an increment (doc/theory, "Contact initiation").
module touch_types
  use kinds, only: wp
  implicit none
  private
  public :: touch_t, touch_none, touch_waits, touch_known

  !> Friction acts everywhere; it waits at points that were open; they have met the surface.
  integer, parameter :: touch_none = 0
  integer, parameter :: touch_waits = 1
  integer, parameter :: touch_known = 2

  !> What an increment knows of first touches, and the state before the last one.
  type :: touch_t
    integer :: stage = touch_none !! one of the stages
    real(wp) :: span = 0.0_wp !! length of this increment [time]
    real(wp) :: span_before = 0.0_wp !! of the last one, 0 if it is not known [time]
    real(wp), allocatable :: u_before(:, :) !! (3, nodes) displacements at its start [length]
    logical, allocatable :: waits(:, :) !! (0:bodies, pairs) friction waits at open points
    logical, allocatable :: empty(:, :) !! (0:bodies, pairs) the body touched nothing of the pair
    real(wp), allocatable :: start(:, :) !! (0:bodies, pairs) first touch, share of the increment
    real(wp), allocatable :: x_free(:, :) !! (3, nodes) positions without a touch [length]
    real(wp), allocatable :: x_end(:, :) !! (3, nodes) without friction at new points [length]
  end type touch_t
end module touch_types

!> What derivatives along a run need of a state to go on from it (doc/theory, "Sensitivities along
!! the path").
module slope_state
  use kinds, only: wp
  implicit none
  private
  public :: kept_slopes_t

  !> Derivatives of a state, parameter after parameter.
  type :: kept_slopes_t
    integer :: mark(2) = 0 !! sum over the names of the parameters
    real(wp), allocatable :: tip(:, :) !! (2, points*parameters) of tips
    real(wp), allocatable :: place(:, :) !! (3, contact nodes*parameters) of displacements [length]
    real(wp), allocatable :: force(:, :) !! (3, contact nodes*parameters) of contact forces [force]
    integer, allocatable :: late(:) !! (contact nodes) 1, 2, 4 added up: directions in which the
    !! displacement lacks what contact does
  end type kept_slopes_t
end module slope_state

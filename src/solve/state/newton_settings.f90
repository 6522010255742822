!> What steers an increment's nonlinear solution: tolerances, limits, step lengths.
module newton_settings
  use kinds, only: wp
  use solution_settings, only: n_settings, settings_of_deck, tol_energy, tol_residual
  implicit none
  private
  public :: settings_t, search_t, tol_energy, tol_residual

  !> How far an iteration goes along its direction (line_search).
  type :: search_t
    real(wp) :: sufficient_decrease = 1.0e-4_wp !! a step is accepted if it lowers the residual by
    !! this share of its length,
    real(wp) :: sufficient_shortening = 0.25_wp !! or if it shortens the next simplified direction
    !! by this share of its length
    integer :: most_halvings = 8 !! the shortest step is 2 to the power of less this
    integer :: circling = 4 !! iterations in a row without progress after which the next direction
    !! does not count any more
    real(wp) :: flat = 0.1_wp !! where there is an energy, it is least along the direction where its
    !! slope is this share of that at the iterate,
    integer :: most_trials = 12 !! after so many trials at most,
    real(wp) :: least_part = 0.05_wp !! each of which leaves at least this share of the interval out
    !! on either side
  end type search_t

  !> When an increment counts as converged, and how far the nonlinear solution goes.
  type :: settings_t
    real(wp) :: asked(n_settings) = settings_of_deck%given !! what solution commands have set
    type(search_t) :: search !! step lengths
    logical :: inside_due = .true. !! displacements inside are asked for at the end time
    integer :: most_solves = 50 !! linear solves of one increment
    logical :: coarsely = .false. !! it is enough to know which points stick, slip and are open
    integer :: parts = 1 !! an interval between end times begins in so many, a power of 2
    integer :: most_passes = 8 !! changes of contact targets within one increment
    real(wp) :: first_energy = 0.0_wp !! the first iteration's counts as this one at least: where a
    !! start is better than usual [force length]
    real(wp) :: extrapolation = 1.0e-6_wp !! apex outside its facet at a flat edge, shape functions
  end type settings_t
end module newton_settings

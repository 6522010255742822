!> Rigid bodies with a point as the solution sees them.
module rigid_types
  use kinds, only: wp
  implicit none
  private
  public :: rigid_t, border_t

  !> One rigid body: where it is in the iterate, and its unknowns, numbered behind the free degrees
  !! of freedom of the nodes. Unknown rotations are spins times a length, so that all unknowns are
  !! lengths and all their residuals forces.
  type :: rigid_t
    integer, allocatable :: node(:) !! its nodes
    integer, allocatable :: unknown(:) !! numbers 1 to 6 of the free motions of its point
    integer :: first = 0 !! number of equations before its unknowns
    integer :: body = 0 !! connected body that holds its nodes
    real(wp) :: length = 1.0_wp !! its reach [length]
    real(wp) :: point(3) = 0.0_wp !! its point at rest [length]
    real(wp) :: given(3) = 0.0_wp !! prescribed translation at the end of the increment [length]
    real(wp) :: load(6) = 0.0_wp !! force and moment on the point there
    real(wp) :: move(3) = 0.0_wp !! free translation of the iterate [length]
    real(wp) :: turn(3, 3) = 0.0_wp !! free rotation of the iterate
    real(wp) :: old_move(3) = 0.0_wp, old_turn(3, 3) = 0.0_wp !! at the last converged state
    real(wp) :: ahead_move(3) = 0.0_wp, ahead_turn(3, 3) = 0.0_wp !! with predictor
    real(wp) :: trial_move(3) = 0.0_wp, trial_turn(3, 3) = 0.0_wp !! of a trial
    real(wp), allocatable :: reach(:, :) !! (3, nodes) of the nodes from the point at rest [length]
    real(wp), allocatable :: base(:, :) !! (3, nodes) displacements that are prescribed [length]
  end type rigid_t

  !> What the unknowns of rigid bodies add to the matrix of the nodes: K, columns, rows, corner.
  type :: border_t
    real(wp), allocatable :: columns(:, :) !! (equations, n) dr_node/dq by each of n unknowns
    real(wp), allocatable :: rows(:, :) !! (equations, n) dr_q/du, transposed
    real(wp), allocatable :: answers(:, :) !! (equations, n) K^-1 columns
    real(wp), allocatable :: corner(:, :) !! (n, n) dr_q/dq, then the factor of its Schur complement
    integer, allocatable :: pivot(:) !! (n) of that factor
  end type border_t
end module rigid_types

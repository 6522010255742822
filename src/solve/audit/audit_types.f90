!> What the audit of an output time knows: its checks, what it measures, and how each is judged.
!!
!! A limit is a constant of the module whose procedure `judge_...` sets the verdict: balance_audit;
!! shape_audit (body rotation, by `farthest_turn` of body_measures, and volume); field_audit
!! (strain, rotation); audit (work, penetration, elastic slip, edges); scene_audit (facets, locking,
!! adjustment, storage); penalty_audit; answers_audit. Balance, body rotation and volume alone can
!! fail: run_audit then ends the run with exit code 2.
module audit_types
  use kinds, only: wp
  implicit none
  private
  public :: audit_t, other_answers_t, check_names, n_checks
  public :: verdict_ok, verdict_warning, verdict_failed
  public :: check_balance, check_work, check_strain, check_rotation, check_turning, &
    check_volume, check_penetration, check_elastic_slip, check_facets, check_locking, &
    check_moved, check_room, check_edges, check_penalty, check_answers, most_lost

  !> Verdicts.
  integer, parameter :: verdict_ok = 0
  integer, parameter :: verdict_warning = 1
  integer, parameter :: verdict_failed = 2

  !> The checks, in the order of the table.
  integer, parameter :: check_balance = 1
  integer, parameter :: check_work = 2
  integer, parameter :: check_strain = 3
  integer, parameter :: check_rotation = 4
  integer, parameter :: check_turning = 5
  integer, parameter :: check_volume = 6
  integer, parameter :: check_penetration = 7
  integer, parameter :: check_elastic_slip = 8
  integer, parameter :: check_facets = 9
  integer, parameter :: check_locking = 10
  integer, parameter :: check_moved = 11
  integer, parameter :: check_room = 12
  integer, parameter :: check_edges = 13
  integer, parameter :: check_penalty = 14
  integer, parameter :: check_answers = 15
  integer, parameter :: n_checks = 15
  !> What of the work need not be found again, over the largest energy so far.
  real(wp), parameter :: most_lost = 0.2_wp
  character(13), parameter :: check_names(n_checks) = [character(13) :: 'balance', 'work', &
    'strain', 'rotation', 'body rotation', 'volume', 'penetration', 'elastic slip', 'facets', &
    'locking', 'adjustment', 'storage', 'edges', 'penalty', 'answers']

  !> What stays the same in a run.
  type :: audit_fixed_t
    real(wp), allocatable :: center(:, :) !! (3, bodies) mean of its nodes [length]
    real(wp), allocatable :: reach(:) !! (bodies) distance of its farthest node from there [length]
    real(wp), allocatable :: spread(:, :, :) !! (3, 3, bodies) sum of (y.y I - y y^T) over its nodes
    real(wp), allocatable :: volume(:) !! (bodies) of what small strain deforms [length^3]
    logical, allocatable :: moves(:) !! (bodies) it has free degrees of freedom
    real(wp) :: model_size = 0.0_wp !! diagonal of the box around all nodes [length]
    real(wp), allocatable :: facet(:) !! (pairs) size of a facet of the softer side [length]
    real(wp), allocatable :: ratio(:) !! (pairs) slave facets over master facets, 0 if unknown
  end type audit_fixed_t

  !> What is summed up from end time to end time.
  type :: audit_sum_t
    real(wp), allocatable :: u(:, :) !! (3, nodes) displacements of the last end time [length]
    real(wp), allocatable :: force(:, :) !! (3, nodes) loads and reactions there [force]
    logical :: whole = .true. !! these are known
    real(wp), allocatable :: value(:), factors(:) !! linear sums there, and factors of the loads
    real(wp) :: force_before = 0.0_wp !! norm of all forces there [force]
    real(wp) :: work = 0.0_wp !! of loads and supports, and what overlaps held [force length]
    real(wp) :: largest_energy = 0.0_wp !! largest work or energy so far [force length]
    logical :: work_known = .true. !! it has been summed up from the start
  end type audit_sum_t

  !> What is known of other answers beside that of an end time.
  type :: other_answers_t
    character(:), allocatable :: unknown !! why nothing is known; empty if something is
    real(wp) :: point_share = 0.0_wp !! largest friction of a point over what it bears alone
    integer :: point = 0 !! that point of its pair
    integer :: closed = 0 !! closed points, where their statuses have been looked at
    logical :: too_many = .false. !! they are too many for that
    integer :: sign = 0 !! of the tangent, 0 if it is not known
    real(wp) :: share = -1.0_wp !! friction over what the statuses bear; -1 if it is not known
    logical :: searched = .false. !! second starts have been made
    integer :: tried = 0 !! at so many points
    real(wp), allocatable :: others(:, :) !! (4, answers) that they have found: closed points, those
    !! that slip, sums of pressures and of friction forces [force]
  end type other_answers_t

  !> The audit of a run: what stays the same, what it sums up, and the last end time's results.
  type :: audit_t
    ! What stays the same
    real(wp), allocatable :: withheld(:) !! (pairs) SHRInk: share of the overlap at the last audit
    real(wp), allocatable :: shrink(:) !! (pairs) and the force that works on it [force length]
    ! What it sums up
    ! What it finds at an end time
    integer :: step = 0 !! the end time, 0 before the first
    real(wp) :: time = 0.0_wp !! its time
    real(wp) :: scale = 0.0_wp !! force scale [force]
    real(wp) :: allowed = 0.0_wp !! force that the worst body may lack [force]
    real(wp) :: asked = 0.0_wp !! the same without what round-off may make of it [force]
    real(wp), allocatable :: balance(:, :) !! (6, bodies) sum of forces and of moments
    real(wp) :: noise = 0.0_wp !! what round-off may make of it, allowed or not [force]
    real(wp) :: lacking = 0.0_wp !! largest of these over what is allowed
    integer :: component = 0 !! which one: 1 to 3 force, 4 to 6 moment
    real(wp) :: strain_energy = 0.0_wp !! of the bulk [force length]
    real(wp) :: penalty_energy = 0.0_wp !! of penalties [force length]
    real(wp) :: dissipation = 0.0_wp !! of friction [force length]
    logical :: depends_on_path = .false. !! there is friction
    logical :: fields_known = .false. !! strain and rotation have been measured at this end time
    real(wp) :: value(n_checks) = 0.0_wp !! what each check compares with its limit
    integer :: worst(n_checks) = 0 !! body, pair or element it is found at
    integer :: verdict(n_checks) = verdict_ok !! one of the verdicts
    integer :: before(n_checks) = -1 !! the same one end time before
    logical :: told(n_checks) = .false. !! the terminal has had this warning
    type(audit_fixed_t) :: fixed !! what stays the same
    type(audit_sum_t) :: sum !! what it sums up
    type(other_answers_t) :: answers !! beside that of the end time
    logical :: unstable = .false. !! a negative sign has been told of
  end type audit_t
end module audit_types

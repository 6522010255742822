!> Unsymmetric linear systems through UMFPACK: METIS ordering, symmetric strategy, long integers.
module umfpack_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_associated
  use kinds, only: wp, long
  use costs, only: cost_t, begin_cost, end_cost, cost_symbolic, cost_unsymmetric_factor, cost_solve
  use csc_matrix, only: csc_matrix_t
  use back_ends, only: back_end_t, solver_words_t, solver_done, solver_singular, &
    solver_out_of_memory, solver_failed
  use umfpack_interface, only: umfpack_dl_defaults, umfpack_dl_symbolic, umfpack_dl_numeric, &
    umfpack_dl_solve, umfpack_dl_free_symbolic, umfpack_dl_free_numeric, &
    umfpack_dl_get_determinant
  implicit none
  private
  public :: umfpack_t, umfpack_words

  type(solver_words_t), parameter :: umfpack_words = solver_words_t('UMFPack', &
    'factorises unsymmetric matrices', 'UMFPACK, an unsymmetric factor')

  ! Places in Control, and their values: umfpack.h
  integer, parameter :: control_strategy = 5, control_refinement = 7, control_ordering = 10
  real(wp), parameter :: strategy_symmetric = 3.0_wp, umfpack_metis = 3.0_wp
  ! Places in Info
  integer, parameter :: info_symmetric_entries = 36
  !> Peak of a factorisation over the values of the factor: work space, and their numbers.
  real(wp), parameter :: peak_share = 1.2_wp
  integer(long), parameter :: status_ok = 0, status_singular = 1, umfpack_memory = -1
  integer(long), parameter :: system_a = 0

  !> Handles and settings of one factorisation.
  type, extends(back_end_t) :: umfpack_t
    type(c_ptr) :: symbolic = c_null_ptr !! analysis of the pattern
    type(c_ptr) :: numeric = c_null_ptr !! factor
    real(wp) :: control(0:19) = 0.0_wp !! settings
    real(wp) :: info(0:89) = 0.0_wp !! what UMFPACK says of its last call
    real(wp) :: bytes = 0.0_wp !! memory of a factorisation, estimated [byte]
    logical :: ready = .false. !! settings are made
  contains
    procedure :: analyse
    procedure :: is_analysed
    procedure :: factor_bytes
    procedure :: factorise
    procedure :: solve
    procedure :: determinant_sign
    procedure :: forget_pattern
    procedure :: drop_factor
    procedure :: free
  end type umfpack_t

contains

  !> Sets METIS and the symmetric strategy, which the automatic choice misses on these matrices.
  subroutine prepare(solver)
    class(umfpack_t), intent(inout) :: solver !! settings

    call umfpack_dl_defaults(solver%control)
    solver%control(control_strategy) = strategy_symmetric
    solver%control(control_ordering) = umfpack_metis
    solver%control(control_refinement) = 0.0_wp
    solver%ready = .true.
  end subroutine prepare

  !> Drops the analysis: the pattern has changed.
  subroutine forget_pattern(solver)
    class(umfpack_t), intent(inout) :: solver !! handles

    if (c_associated(solver%symbolic)) call umfpack_dl_free_symbolic(solver%symbolic)
    solver%symbolic = c_null_ptr
  end subroutine forget_pattern

  !> Releases the factor and keeps the analysis.
  subroutine drop_factor(solver)
    class(umfpack_t), intent(inout) :: solver !! handles

    if (c_associated(solver%numeric)) call umfpack_dl_free_numeric(solver%numeric)
    solver%numeric = c_null_ptr
  end subroutine drop_factor

  !> The pattern has been analysed.
  logical function is_analysed(solver)
    class(umfpack_t), intent(in) :: solver !! handles

    is_analysed = c_associated(solver%symbolic)
  end function is_analysed

  !> Analyses the pattern.
  subroutine analyse(solver, a, costs, outcome)
    class(umfpack_t), intent(inout) :: solver !! handles; an older analysis is dropped
    type(csc_matrix_t), intent(in), target :: a !! matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer(long) :: status

    if (.not. solver%ready) call prepare(solver)
    call solver%forget_pattern()
    call begin_cost(costs, cost_symbolic)
    status = umfpack_dl_symbolic(a%n, a%n, a%ptr, a%row, a%val, solver%symbolic, &
      solver%control, solver%info)
    call end_cost(costs, cost_symbolic)
    outcome = outcome_of(status)
    if (outcome /= solver_done) return
    solver%bytes = peak_share*8.0_wp*solver%info(info_symmetric_entries)
  end subroutine analyse

  !> Memory that a factorisation will take as long as the pivots stay on the diagonal [byte];
  !! UMFPACK's own bound is four times as much.
  real(wp) function factor_bytes(solver) result(bytes)
    class(umfpack_t), intent(in) :: solver !! analysed

    bytes = solver%bytes
  end function factor_bytes

  !> Factorises; the analysis is kept as long as the pattern holds.
  subroutine factorise(solver, a, costs, outcome)
    class(umfpack_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in), target :: a !! matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer(long) :: status

    if (.not. solver%is_analysed()) then
      call solver%analyse(a, costs, outcome)
      if (outcome /= solver_done) return
    end if
    call solver%drop_factor()
    call begin_cost(costs, cost_unsymmetric_factor)
    status = umfpack_dl_numeric(a%ptr, a%row, a%val, solver%symbolic, solver%numeric, &
      solver%control, solver%info)
    call end_cost(costs, cost_unsymmetric_factor)
    outcome = outcome_of(status)
  end subroutine factorise

  !> x = A^-1 b with the last factor.
  subroutine solve(solver, a, b, x, costs, outcome)
    class(umfpack_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in), target :: a !! matrix
    real(wp), intent(in), target, contiguous :: b(:) !! (n) right-hand side
    real(wp), intent(inout), target, contiguous :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    integer(long) :: status

    call begin_cost(costs, cost_solve)
    status = umfpack_dl_solve(system_a, a%ptr, a%row, a%val, x, b, solver%numeric, &
      solver%control, solver%info)
    call end_cost(costs, cost_solve)
    outcome = outcome_of(status)
    if (outcome == solver_done .and. .not. all(abs(x) <= huge(1.0_wp))) outcome = solver_singular
  end subroutine solve

  !> Sign of the determinant of the last factor, 0 if there is none.
  integer function determinant_sign(solver) result(s)
    class(umfpack_t), intent(in) :: solver !! handles
    real(wp) :: mantissa(1), exponent(1), info(0:89)

    s = 0
    if (.not. c_associated(solver%numeric)) return
    info = 0.0_wp
    if (umfpack_dl_get_determinant(mantissa, exponent, solver%numeric, info) /= status_ok) return
    if (mantissa(1) > 0.0_wp) s = 1
    if (mantissa(1) < 0.0_wp) s = -1
  end function determinant_sign

  !> Outcome of a status of UMFPACK.
  pure integer function outcome_of(status) result(outcome)
    integer(long), intent(in) :: status !! what UMFPACK returned

    select case (status)
    case (status_ok)
      outcome = solver_done
    case (status_singular)
      outcome = solver_singular
    case (umfpack_memory)
      outcome = solver_out_of_memory
    case default
      outcome = solver_failed
    end select
  end function outcome_of

  !> Releases everything.
  subroutine free(solver)
    class(umfpack_t), intent(inout) :: solver !! handles

    call solver%forget_pattern()
    call solver%drop_factor()
  end subroutine free
end module umfpack_solver

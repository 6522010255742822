!> How far to go along the direction of an iteration.
module line_search
  use kinds, only: wp
  use elmlib, only: routine_none
  use umfpack_solver, only: solve, solver_done
  use residuals, only: form_trial, residual_norm
  use supports, only: closing_length, gap_of
  use system_types, only: system_t
  implicit none
  private
  public :: search_line, approach, find_kinks, shorten, search_t

  !> A step is accepted if it lowers the residual by this share of its length,
  real(wp), parameter :: sufficient_decrease = 1.0e-4_wp
  !> or if it shortens the next simplified direction by this share of its length.
  real(wp), parameter :: sufficient_shortening = 0.25_wp
  !> The shortest step is 2^-8.
  integer, parameter :: most_halvings = 8
  !> Kinks that are tried between two halvings.
  integer, parameter :: most_kinks = 2
  !> A kink is tried at this many times its length, so that the point is through.
  real(wp), parameter :: behind = 1.001_wp
  !> Lengths closer than this share are the same.
  real(wp), parameter :: apart = 0.02_wp

  !> How far the search has come.
  type :: search_t
    integer :: halvings = 0 !! halvings so far
    integer :: kinks = 0 !! kinks tried since the last one
  end type search_t

contains

  !> A step with grounded bodies goes to the next touch and no further.
  subroutine approach(system, x, start, length)
    type(system_t), intent(inout) :: system !! u is moved
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: start !! norm of the residual before the step
    real(wp), intent(out) :: length !! share of du

    length = closing_length(x, system)
    if (length < 1.0_wp) then
      call form_trial(system, x, length)
      call take_trial(system, length)
    else
      call search_line(system, x, start, .false., length)
    end if
  end subroutine approach

  !> Moves to the trial that has been formed.
  subroutine take_trial(system, length)
    type(system_t), intent(inout) :: system !! u and bulk_force are moved
    real(wp), intent(in) :: length !! share of du

    system%u = system%trial
    system%bulk_force = system%bulk_force + length*system%bulk_change
  end subroutine take_trial

  !> Backtracking on the residual norm or, where a stiff penalty makes that blind, on the length of
  !! the next direction with the same factor (Deuflhard's natural test); if no length passes, the
  !! one with the shortest next direction is taken. Tried are the halves of the step and, between
  !! them, lengths at which a contact point opens or closes (doc/theory, "Nonlinear solution").
  subroutine search_line(system, x, start, full, length)
    type(system_t), intent(inout) :: system !! u is moved to the accepted length
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: start !! norm of the residual before the step
    logical, intent(in) :: full !! take the full step whatever its residual
    real(wp), intent(out) :: length !! accepted share of du
    real(wp), allocatable :: kinks(:)
    real(wp) :: next, best, best_length, du
    type(search_t) :: search

    best = huge(1.0_wp)
    best_length = 1.0_wp
    length = 1.0_wp
    du = norm2(system%solution)
    do
      call form_trial(system, x, length)
      if (full .or. residual_norm(system) <= (1.0_wp - sufficient_decrease*length)*start) exit
      next = next_direction(system)
      if (next <= (1.0_wp - sufficient_shortening*length)*du) exit
      if (next < best) then
        best = next
        best_length = length
      end if
      if (.not. allocated(kinks)) call find_kinks(system, x, kinks)
      call shorten(kinks, search, length)
      if (search%halvings <= most_halvings) cycle
      length = best_length
      call form_trial(system, x, length)
      exit
    end do
    call take_trial(system, length)
  end subroutine search_line

  !> The next length to try: the largest kink before the next half, if not too many have been tried
  !! before it, else that half.
  pure subroutine shorten(kinks, search, length)
    real(wp), intent(in) :: kinks(:) !! lengths of kinks
    type(search_t), intent(inout) :: search !! counts on
    real(wp), intent(inout) :: length !! the length that did not pass; the next one
    real(wp) :: half, kink

    half = 0.5_wp**(search%halvings + 1)
    kink = maxval([0.0_wp, kinks], mask=[.true., kinks < (1.0_wp - apart)*length])
    if (search%kinks < most_kinks .and. kink > (1.0_wp + apart)*half) then
      search%kinks = search%kinks + 1
      length = kink
    else
      search%halvings = search%halvings + 1
      search%kinks = 0
      length = half
    end if
  end subroutine shorten

  !> Lengths just behind the points at which a contact point opens or closes. On a facet that keeps
  !! its normal the gap is linear along du, so they are exact there; elsewhere they are candidates
  !! like any other.
  subroutine find_kinks(system, x, kinks)
    type(system_t), intent(in) :: system !! u, du, contact elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), allocatable, intent(out) :: kinks(:) !! lengths
    real(wp) :: length(system%contact%n), now, later
    integer :: k

    length = -1.0_wp
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      now = gap_of(x, 0.0_wp, k, system)
      later = gap_of(x, 1.0_wp, k, system)
      if ((now > 0.0_wp) .neqv. (later > 0.0_wp)) length(k) = behind*now/(now - later)
    end do
    kinks = pack(length, length > 0.0_wp)
  end subroutine find_kinks

  !> Length of the direction that the present factor gives for the residual of the trial.
  real(wp) function next_direction(system) result(length)
    type(system_t), intent(inout) :: system !! factor and residual of the trial; next is used
    integer :: outcome

    call solve(system%umfpack, system%csc, system%right, system%next, system%costs, outcome)
    length = huge(1.0_wp)
    if (outcome == solver_done) length = norm2(system%next)
  end function next_direction
end module line_search

!> How far to go along the direction of an iteration.
module line_search
  use kinds, only: wp
  use back_ends, only: solver_done
  use rigid_bodies, only: take_rigid
  use residuals, only: form_trial, residual_norm, round_off_factor
  use supports, only: closing_length
  use live_values, only: take_condensed, take_live, direction_norm
  use condensed_direction, only: next_condensed_length
  use bulk_preconditioner, only: solve_roughly
  use system_types, only: system_t
  implicit none
  private
  public :: search_line, approach, next_energy, take_trial

  !> A step is accepted if it lowers the residual by this share of its length,
  real(wp), parameter :: sufficient_decrease = 1.0e-4_wp
  !> or if it shortens the next simplified direction by this share of its length.
  real(wp), parameter :: sufficient_shortening = 0.25_wp
  !> Residual over right-hand side that an iterative solver may leave of a next direction.
  real(wp), parameter :: rough = 1.0e-2_wp
  !> The shortest step is 2^-8.
  integer, parameter :: most_halvings = 8

contains

  !> A step with grounded bodies goes to the next touch and no further.
  subroutine approach(system, x, start, longest, length)
    type(system_t), intent(inout) :: system !! u is moved
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: start !! norm of the residual before the step
    real(wp), intent(in) :: longest !! share of du that it may go, at most 1
    real(wp), intent(out) :: length !! share of du

    length = closing_length(x, system)
    if (length < longest) then
      call form_trial(system, x, length)
      call take_trial(system, length)
    else
      call search_line(system, x, start, .false., .true., longest, length)
    end if
  end subroutine approach

  !> Moves to the trial that has been formed.
  subroutine take_trial(system, length)
    type(system_t), intent(inout) :: system !! u and bulk_force are moved
    real(wp), intent(in) :: length !! share of du

    if (system%condensed%active) then
      call take_live(system)
      call take_rigid(system)
      call take_condensed(system%condensed, length)
      return
    end if
    system%u = system%trial
    call take_rigid(system)
    system%inner%bulk_force = system%inner%bulk_force + length*system%inner%bulk_change
  end subroutine take_trial

  !> Backtracking on the residual norm or, where a stiff penalty makes that blind, on the length of
  !! the next direction with the same factor (Deuflhard's natural test); if no length passes, the
  !! one with the shortest next direction is taken. Without the natural test, which may go in
  !! circles, that is the one with the smallest residual. If no length passes from a residual that
  !! is round-off, the system stays where it is.
  subroutine search_line(system, x, start, full, natural, longest, length)
    type(system_t), intent(inout) :: system !! u is moved to the accepted length
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: start !! norm of the residual before the step
    logical, intent(in) :: full !! take the full step whatever its residual
    logical, intent(in) :: natural !! the length of the next direction counts as well
    real(wp), intent(in) :: longest !! share of du to begin with, at most 1
    real(wp), intent(out) :: length !! accepted share of du
    real(wp) :: next, best, best_length, du
    integer :: halving

    best = huge(1.0_wp)
    best_length = longest
    length = longest
    du = direction_norm(system)
    do halving = 0, most_halvings
      call form_trial(system, x, length)
      if (full .or. residual_norm(system) <= (1.0_wp - sufficient_decrease*length)*start) exit
      next = residual_norm(system)
      if (natural) next = next_direction(system, length)
      if (natural .and. next <= (1.0_wp - sufficient_shortening*length)*du) exit
      if (next < best) then
        best = next
        best_length = length
      end if
      length = 0.5_wp*length
    end do
    if (halving > most_halvings) then
      length = best_length
      if (start <= round_off_factor*system%scale%round_off) length = 0.0_wp
      call form_trial(system, x, length)
    end if
    call take_trial(system, length)
  end subroutine search_line

  !> Energy of the residual after a full step with the direction that the present factor gives.
  real(wp) function next_energy(system) result(energy)
    type(system_t), intent(inout) :: system !! factor and residual; next is used

    energy = next_direction(system, 1.0_wp)
    if (system%condensed%active) then
      energy = abs(dot_product(system%condensed%alive%right, system%condensed%alive%change))
    else if (energy < huge(1.0_wp)) then
      energy = abs(dot_product(system%right, system%next))
    end if
  end function next_energy

  !> Length of the direction that the present factor gives for the residual of the trial.
  real(wp) function next_direction(system, share) result(length)
    type(system_t), intent(inout) :: system !! factor and residual of the trial; next is used
    real(wp), intent(in) :: share !! the trial's share of du
    integer :: outcome

    if (system%condensed%active) then
      length = next_condensed_length(system, share)
      return
    end if
    system%whole%solver%accuracy = rough
    call solve_roughly(system, outcome)
    length = huge(1.0_wp)
    if (outcome == solver_done) length = norm2(system%next)
  end function next_direction
end module line_search

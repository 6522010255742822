!> Directions by the factors alone, where the bulk has hardly strained since they were made: one
!! pass each, and no tangent of the bulk (doc/theory, "Nonlinear bulk").
module near_steps
  use kinds, only: wp
  use costs, only: count_cost, cost_bulk_krylov
  use back_ends, only: solver_done
  use condensed_direction, only: is_worth_trying, most_allowed, most_stale
  use contact_tangent, only: factorise_tangent, form_rest
  use bulk_passes, only: begin_direction, solve_pass
  use system_types, only: form_t, system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: find_near_direction, find_near_again, judge_nearness, note_near_step

  !> Factors are near if a step by them leaves less than this share where there is no contact.
  real(wp), parameter :: near_factor_share = 0.1_wp
  !> Share of the residual that a step by new factors leaves.
  real(wp), parameter :: new_share = 1.0e-3_wp

contains

  !> The direction that the factors give by themselves: one pass, and no tangent of the bulk.
  subroutine find_near_direction(system, form, x, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution; near, if there is none
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    logical :: answered

    outcome = solver_done
    answered = .false.
    if (.not. (system%motion%active .or. any(system%body%floating))) then
      call begin_direction(system, form, x)
      if (is_worth_trying(system, form%condensed)) then
        form%condensed%tangent%fresh = .false.
        call form_rest(system%contact, form%condensed)
        call solve_pass(system, form, form%right, most_stale, form%solution, answered)
        if (.not. answered) call begin_direction(system, form, x)
      end if
      if (.not. answered) then
        call factorise_tangent(system, form, x, outcome)
        if (outcome /= solver_done) return
        call form_rest(system%contact, form%condensed)
        call solve_pass(system, form, form%right, most_allowed(form%condensed), form%solution, &
          answered)
      end if
      form%condensed%norm_before = norm2(form%right)
      call count_cost(form%costs, cost_bulk_krylov, 1)
    end if
    form%kind%near = answered
  end subroutine find_near_direction

  !> The same for the present residual, with the contact of the last one.
  subroutine find_near_again(system, form, answered)
    type(system_t), intent(in) :: system !! right given
    type(form_t), intent(inout) :: form !! gets solution
    logical, intent(out) :: answered !! there is one

    call solve_pass(system, form, form%right, most_allowed(form%condensed), form%solution, answered)
    call count_cost(form%costs, cost_bulk_krylov, 1)
  end subroutine find_near_again

  !> Whether the factors are near enough to go on with them alone: the step went its whole way, and
  !! left little at nodes that contact does not touch. After the step from the last state that is
  !! tried.
  subroutine judge_nearness(system, form, start, length)
    type(system_t), intent(in) :: system !! residual after a step; near may go
    type(form_t), intent(inout) :: form !! right given; gets condensed, its kind
    real(wp), intent(in) :: start !! norm of the residual before it [force]
    real(wp), intent(in) :: length !! share of its direction that it went
    real(wp) :: rest(size(form%right))
    integer :: i

    if (form%inner%linearised) form%kind%near = form%condensed%preconditions .and. &
      length >= 1.0_wp .and. form%inner%inverted == 0
    if (form%inner%linearised .or. .not. form%kind%near) return
    rest = form%right
    associate (condensed => form%condensed)
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          rest(system%equation(condensed%direction(c), condensed%node(c))) = 0.0_wp
        end associate
      end do
      form%kind%near = length >= 1.0_wp .and. norm2(rest) <= near_factor_share*start
      if (form%kind%near) call note_near_step(form%condensed, norm2(rest)/start)
    end associate
  end subroutine judge_nearness

  !> A full step by near factors has been taken. New factors would leave so little that fewer such
  !! passes lead as far: what is lost ages them out.
  subroutine note_near_step(condensed, left)
    type(condensed_t), intent(inout) :: condensed !! direction, residual after it; aging grows
    real(wp), intent(in) :: left !! share of the residual that the pass has left

    condensed%aging = condensed%aging + max(0.0_wp, 1.0_wp - &
      log(max(left, new_share))/log(new_share))
  end subroutine note_near_step
end module near_steps

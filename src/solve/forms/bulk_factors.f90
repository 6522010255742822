!> Factors of a bulk that is not linear: of its bodies at rest, or of a state on the way
!! (doc/theory, "Nonlinear bulk").
module bulk_factors
  use kinds, only: wp
  use costs, only: cost_t
  use back_ends, only: solver_done, solver_not_definite
  use condensation, only: body_work, halve_body
  use condensed_types, only: condensed_t
  use condensed_bodies, only: condense_all
  use bulk_term, only: form_solid_tangent
  use body_turns, only: start_turns, mark_turns
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: condense_bulk, condense_at, condense_at_rest, renew_factors

  !> Each tangent in a row that is not positive definite makes it four times as long until the next
  !! one is tried, up to so many doublings.
  integer, parameter :: most_doublings = 20

contains

  !> The first factors of a run: of the bodies at rest, or those that a saved state had.
  subroutine condense_bulk(system, form, outcome)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets the bodies of condensed
    integer, intent(out) :: outcome !! as in back_ends

    call start_turns(system, form%condensed)
    if (allocated(form%condensed%made_at)) then
      call condense_at(system, form, form%condensed%made_at, spread(.true., 1, &
        system%body%bodies), outcome)
      if (outcome /= solver_not_definite) return
    end if
    call condense_at_rest(system, form, spread(.true., 1, system%body%bodies), outcome)
  end subroutine condense_bulk

  !> Condenses undeformed bodies, whose stiffness is positive definite whatever the law. Those that
  !! are not wanted keep their factors, if they are at rest.
  subroutine condense_at_rest(system, form, wanted, outcome)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets the bodies of condensed
    logical, intent(in) :: wanted(:) !! (bodies) those to condense
    integer, intent(out) :: outcome !! as in back_ends
    logical :: deformed

    deformed = allocated(form%condensed%made_at)
    if (deformed) deallocate (form%condensed%made_at)
    call condense_at(system, form, 0.0_wp*system%u, wanted .or. deformed, outcome)
  end subroutine condense_at_rest

  !> Condenses the bodies as they are at a state; the tangent at hand is left alone, unless factors
  !! answer by themselves.
  subroutine condense_at(system, form, u, wanted, outcome)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets the bodies of condensed
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    logical, intent(in) :: wanted(:) !! (bodies) those to condense
    integer, intent(out) :: outcome !! as in back_ends
    real(wp), allocatable :: values(:, :, :)

    if (.not. form%condensed%exact) values = form%whole%bulk_matrix%val
    call form_solid_tangent(form%condensed%rigid%x, u, system, form)
    call condense_all(system, form, wanted, outcome)
    if (allocated(values)) call move_alloc(values, form%whole%bulk_matrix%val)
    call mark_turns(form%condensed%rigid%x, u, form%condensed, system%body)
    if (outcome == solver_done .and. .not. form%condensed%exact) call finish_factors( &
      form%condensed, form%costs)
  end subroutine condense_at

  !> New factors, of the bodies as they are now. That tangent need not be positive definite: if it
  !! is not, the bodies at rest serve on.
  subroutine renew_factors(system, form, outcome)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! gets the bodies of condensed
    integer, intent(out) :: outcome !! as in back_ends
    logical :: all_bodies(system%body%bodies), definite

    associate (condensed => form%condensed)
      condensed%made_at = system%u
      all_bodies = .true.
      call condense_at(system, form, condensed%made_at, all_bodies, outcome)
      definite = outcome /= solver_not_definite
      condensed%refusals = merge(0, condensed%refusals + 1, definite)
      if (.not. definite) call condense_at_rest(system, form, all_bodies, outcome)
      condensed%aging = 0.0_wp
      condensed%failed = outcome
      if (allocated(condensed%tangent%status)) deallocate (condensed%tangent%status)
    end associate
  end subroutine renew_factors

  !> The passes that would pay for new factors: a count, no clock. What passes have reduced with
  !! older factors goes.
  subroutine finish_factors(condensed, costs)
    type(condensed_t), intent(inout) :: condensed !! refusals given; gets aged, reduced goes
    type(cost_t), intent(inout) :: costs !! cost table
    integer :: b

    condensed%aged = 0.0_wp
    do b = 1, size(condensed%bodies)
      if (.not. allocated(condensed%bodies(b)%node)) cycle
      if (allocated(condensed%bodies(b)%reduced)) deallocate (condensed%bodies(b)%reduced)
      condensed%aged = max(condensed%aged, body_work(condensed%bodies(b)))
      call halve_body(condensed%bodies(b), costs)
    end do
    condensed%aged = condensed%aged*2.0_wp**min(most_doublings, 2*condensed%refusals)
  end subroutine finish_factors
end module bulk_factors

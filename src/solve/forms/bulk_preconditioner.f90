!> Newton's direction where the bulk is not linear and its bodies are condensed: GMRES on the true
!! tangent, with the bodies' older factors and today's contact, exactly, in its place (doc/theory,
!! "Nonlinear bulk", eq. (12.16)).
module bulk_preconditioner
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, count_cost, cost_solve, cost_bulk_krylov
  use block_matrix, only: multiply
  use back_ends, only: solver_done
  use gmres, only: gmres_t, begin_gmres, add_image, gmres_shares
  use bulk_term, only: form_bulk_tangent
  use equation_values, only: spread_values, gather_values
  use body_turns, only: to_frames, from_frames
  use bulk_factors, only: renew_factors
  use bulk_passes, only: begin_direction, solve_pass
  use near_steps, only: find_near_direction
  use condensed_direction, only: is_worth_trying, most_allowed, most_stale
  use contact_tangent, only: factorise_tangent, form_rest, apply_rest
  use contact_sums, only: add_leading, take_shares
  use system_types, only: form_t, system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: find_bulk_direction, solve_by_passes, solve_in_one_pass

  !> Vectors of GMRES.
  integer, parameter :: bulk_vectors = 30
  !> Passes of an iteration that new factors would want as well.
  integer, parameter :: unavoidable = 2
  !> Shares of the residual that a direction may leave at most, and of answers to further forces.
  real(wp), parameter :: coarsest_bulk = 0.01_wp, inner_accuracy = 1.0e-8_wp
  !> Order of convergence that Newton may be expected to have.
  real(wp), parameter :: newton_order = 1.5_wp
  !> A direction need not leave less than this share of what would have converged.
  real(wp), parameter :: well_below = 0.01_wp

contains

  !> The direction on all free degrees of freedom.
  subroutine find_bulk_direction(system, form, x, wanted, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: wanted !! residual that would have converged [force]
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    logical :: arrived, renewed
    real(wp) :: goal

    outcome = form%condensed%failed
    if (outcome /= solver_done) return
    if (.not. form%kind%near) call form_bulk_tangent(x, system, form)
    renewed = form%condensed%aging > form%condensed%aged .and. form%condensed%rigid%modes == 0
    if (renewed) call renew_factors(system, form, outcome)
    if (outcome /= solver_done) return
    if (form%kind%near) then
      call find_near_direction(system, form, x, outcome)
      if (outcome /= solver_done .or. form%kind%near) return
      call form_bulk_tangent(x, system, form)
    end if
    call begin_direction(system, form, x)
    goal = min(coarsest_bulk*norm2(form%right), max(wanted_share(form)*norm2(form%right), &
      well_below*max(wanted, system%scale%round_off)))
    arrived = .false.
    if (is_worth_trying(system, form%condensed)) then
      form%condensed%tangent%fresh = .false.
      call form_rest(system%contact, form%condensed)
      call iterate_bulk(system, form, goal, most_stale, arrived)
      if (.not. arrived) call begin_direction(system, form, x)
    end if
    if (.not. arrived) call iterate_anew(system, form, x, goal, arrived, outcome)
    if (outcome /= solver_done) return
    if (.not. (arrived .or. renewed .or. form%condensed%refusals > 0 .or. &
      form%condensed%rigid%modes > 0)) then
      call renew_factors(system, form, outcome)
      if (outcome /= solver_done) return
      call begin_direction(system, form, x)
      call iterate_anew(system, form, x, goal, arrived, outcome)
    end if
    form%condensed%norm_before = norm2(form%right)
  end subroutine find_bulk_direction

  !> GMRES with a new factor of contact; a single pass where bodies are regularised or damped: what
  !! holds them stands in the factor and not in the true tangent.
  subroutine iterate_anew(system, form, x, goal, arrived, outcome)
    type(system_t), intent(in) :: system !! element matrices, right
    type(form_t), intent(inout) :: form !! gets solution
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: goal !! residual to arrive at [force]
    logical, intent(out) :: arrived !! there
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    arrived = .false.
    call factorise_tangent(system, form, x, outcome)
    if (outcome /= solver_done) return
    call form_rest(system%contact, form%condensed)
    if (any(system%body%regularised) .or. system%body%damping > 0.0_wp) then
      call solve_pass(system, form, form%right, most_allowed(form%condensed), form%solution, &
        arrived)
    else
      call iterate_bulk(system, form, goal, most_allowed(form%condensed), arrived)
    end if
  end subroutine iterate_anew

  !> As many digits as Newton can use: a power of the share that the last iteration left.
  pure real(wp) function wanted_share(form) result(share)
    type(form_t), intent(in) :: form !! right given

    share = coarsest_bulk
    associate (before => form%condensed%norm_before)
      if (before > 0.0_wp) share = min(coarsest_bulk, (norm2(form%right)/before)**newton_order)
    end associate
  end function wanted_share

  !> GMRES for the direction; what it takes beyond a few passes ages the factors out.
  subroutine iterate_bulk(system, form, goal, most, arrived)
    type(system_t), intent(in) :: system !! right given
    type(form_t), intent(inout) :: form !! gets solution
    real(wp), intent(in) :: goal !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations of contact allowed within a pass
    logical, intent(out) :: arrived !! there
    integer :: passes

    call run_gmres(system, form, form%right, goal, most, form%solution, passes, arrived)
    form%condensed%aging = form%condensed%aging + real(max(0, passes - unavoidable), wp)
  end subroutine iterate_bulk

  !> Flexible GMRES: the pass is not quite the same for all vectors.
  subroutine run_gmres(system, form, right, goal, most, solution, passes, arrived)
    type(system_t), intent(in) :: system !! tangents of bulk and contact; left alone but for room
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    real(wp), intent(in) :: right(:) !! (equations) right-hand side [force]
    real(wp), intent(in) :: goal !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations of contact allowed within a pass
    real(wp), intent(out) :: solution(:) !! (equations) [length]
    integer, intent(out) :: passes !! how many
    logical, intent(out) :: arrived !! at the goal, contact as well
    type(gmres_t) :: course
    real(wp), allocatable :: moved(:, :), shares(:)
    real(wp) :: image(size(right))
    logical :: answered
    integer :: j

    allocate (moved(size(right), bulk_vectors))
    call begin_gmres(right, bulk_vectors, course)
    answered = .true.
    do while (course%rest > goal .and. course%n < bulk_vectors .and. answered)
      j = course%n + 1
      call solve_pass(system, form, course%base(:, j), most, moved(:, j), answered)
      call apply_tangent(system, form, moved(:, j), image)
      call add_image(image, course)
    end do
    arrived = course%rest <= goal
    passes = course%n
    shares = gmres_shares(course)
    solution = 0.0_wp
    do j = 1, passes
      solution = solution + shares(j)*moved(:, j)
    end do
    call count_cost(form%costs, cost_bulk_krylov, passes)
  end subroutine run_gmres

  !> Forces of the true tangent, of bulk and contact.
  subroutine apply_tangent(system, form, solution, force)
    type(system_t), intent(in) :: system !! bulk_matrix, tangent of contact; cost table
    type(form_t), intent(inout) :: form !! condensed, matrix
    real(wp), intent(in) :: solution(:) !! (equations) [length]
    real(wp), intent(out) :: force(:) !! (equations) [force]
    real(wp), dimension(3, size(system%equation, 2)) :: moved, bulk, contact
    real(wp), allocatable :: y(:)
    integer :: i

    call begin_cost(form%costs, cost_solve)
    call spread_values(system%equation, solution, moved)
    call multiply(form%whole%bulk_matrix, moved, bulk)
    associate (condensed => form%condensed)
      if (condensed%alive%n_live > 0 .and. condensed%tangent%elements > 0) then
        call to_frames(system%body, form%condensed, moved)
        contact = 0.0_wp
        y = contact_force(form%condensed, [(moved(condensed%direction(condensed%alive%live(i)), &
          condensed%node(condensed%alive%live(i))), i=1, condensed%alive%n_live)])
        do i = 1, condensed%alive%n_live
          contact(condensed%direction(condensed%alive%live(i)), &
            condensed%node(condensed%alive%live(i))) = y(i)
        end do
        call from_frames(system%body, form%condensed, contact)
        bulk = bulk + contact
      end if
    end associate
    call gather_values(system%equation, bulk, force)
    call end_cost(form%costs, cost_solve)
  end subroutine apply_tangent

  !> Forces of contact's tangent, its leading part and its rest.
  function contact_force(condensed, t) result(y)
    type(condensed_t), intent(in) :: condensed !! tangent of contact
    real(wp), intent(in) :: t(:) !! (live) displacements in the frames of the bodies [length]
    real(wp) :: y(size(t))
    real(wp) :: z(condensed%tangent%rank)

    associate (tangent => condensed%tangent)
      call apply_rest(tangent, t, y)
      call take_shares(tangent, t, z)
      call add_leading(tangent, z, y)
    end associate
  end function contact_force

  !> The tangent at hand once more, for another right-hand side.
  subroutine solve_by_passes(system, form, right, solution, left)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! tangent at hand; left alone but for room
    real(wp), intent(in) :: right(:) !! (equations) [force]
    real(wp), intent(inout) :: solution(:) !! (equations) [length]
    real(wp), intent(in), optional :: left !! share of the right-hand side that passes may leave
    real(wp) :: share
    integer :: passes
    logical :: arrived

    share = inner_accuracy
    if (present(left)) share = left
    call run_gmres(system, form, right, max(share*norm2(right), 1.0e-3_wp*system%scale%round_off), &
      most_allowed(form%condensed), solution, passes, arrived)
  end subroutine solve_by_passes

  !> The same where few digits do.
  subroutine solve_in_one_pass(system, form, right, solution)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! tangent at hand; left alone but for room
    real(wp), intent(in) :: right(:) !! (equations) [force]
    real(wp), intent(inout) :: solution(:) !! (equations) [length]
    logical :: answered

    call solve_pass(system, form, right, most_allowed(form%condensed), solution, answered)
  end subroutine solve_in_one_pass
end module bulk_preconditioner

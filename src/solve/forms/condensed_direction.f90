!> The Newton direction of the condensed form: (I + C k) du = d + C r with the element matrices k
!! (doc/theory, "Static condensation", eq. (12.4)).
module condensed_direction
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, count_cost, cost_solve, cost_krylov, cost_t
  use back_ends, only: solver_done, solver_singular
  use condensed_types, only: condensed_t
  use live_candidates, only: apply_compliance
  use condensed_motions, only: sum_forces, push_live, in_lengths
  use live_values, only: begin_trials
  use tree_compliance, only: has_trees
  use contact_answer, only: answer, answer_points, most_vectors, inner_accuracy
  use contact_tangent, only: form_element_matrices, factorise_tangent, form_rest
  use condensed_springs, only: stay_in_place
  use rigid_bodies, only: spread_rigid
  use system_types, only: form_t, system_t
  use element_lists, only: element_list_t
  implicit none
  private
  public :: find_condensed_direction, find_modified_direction, respond, next_condensed_length, &
    defect_energy
  public :: answer_force, push_direction, answer, is_worth_trying, most_allowed, most_stale

  !> Iterations of GMRES with an older factor.
  integer, parameter :: most_stale = 12
  !> The same with blocks, where the other way is a dense factor of many rows.
  integer, parameter :: most_of_blocks = 150
  !> A factor is worth trying again if no more elements than these have changed their status.
  !! Where points are many, one in so many may.
  integer, parameter :: most_changes = 3, changes_share = 20
  !> Blocks need not find more digits of a direction than a step with the same factor has, while one
  !! element in so many changes its status from iteration to iteration.
  integer, parameter :: share_settled = 200
  !> Accuracies of a direction; the coarsest where products are long, too.
  real(wp), parameter :: finest = 1.0e-10_wp, coarsest = 1.0e-4_wp, of_long = 1.0e-3_wp
  !> And of a step with the factor of an earlier iteration, which leaves a share of the residual
  !! anyway, unless multipliers go with it; where products are long the factor mostly does without
  !! any.
  real(wp), parameter :: of_modified = 1.0e-2_wp, of_factor = 0.1_wp
  !> A product with the compliances is long if it has this many entries of them for a closed
  !! element: it takes longer than the residual of one more step.
  real(wp), parameter :: long_product = 4000.0_wp

contains

  !> The direction: displacements of the live candidates and the change of their forces. Where
  !! blocks do not arrive and there is no dense matrix, it is what they have found: the bulk is in
  !! balance with it, and what is left stands in the next residual.
  subroutine find_condensed_direction(system, form, x, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution, du, force_change
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    real(wp), allocatable :: y(:)
    real(wp) :: floor
    logical :: arrived

    outcome = form%condensed%failed
    if (outcome /= solver_done) return
    call form_element_matrices(system, form, x)
    associate (condensed => form%condensed)
      allocate (y(condensed%alive%n_live))
      floor = max(wanted_accuracy(condensed, is_unsettled(system%contact, &
        form%condensed))*residual_size(condensed), 1.0e-3_wp*system%scale%round_off)
      arrived = .false.
      if (is_worth_trying(system, form%condensed)) then
        condensed%tangent%fresh = .false.
        call form_rest(system%contact, form%condensed)
        call answer_points(system, form%condensed, most_stale, arrived)
        if (arrived) call respond(system%equations, form, 1.0_wp, floor, most_stale, y, arrived)
        if (.not. (arrived .or. condensed%tangent%whole)) call form_element_matrices(system, form, &
          x)
      end if
      if (.not. arrived) then
        call factorise_tangent(system, form, x, outcome)
        if (outcome /= solver_done) return
        call form_rest(system%contact, form%condensed)
        call answer_points(system, form%condensed, most_allowed(condensed), arrived)
        if (.not. condensed%points%known .and. condensed%points%n > 0) outcome = solver_singular
        if (outcome /= solver_done) return
        call respond(system%equations, form, 1.0_wp, floor, most_allowed(condensed), y, arrived)
        if (.not. (arrived .or. has_trees(condensed)) .and. condensed%tangent%parts%iterated) &
          call answer_densely(system, form, x, floor, y, arrived, outcome)
        if (outcome /= solver_done) return
      end if
      condensed%norm_before = residual_size(condensed)
    end associate
    call stay_in_place(form%condensed)
    call take_answer(system, form, y)
    call begin_trials(system%u, form%trial)
  end subroutine find_condensed_direction

  !> The direction for the present residual with the tangent and factor of the last one.
  subroutine find_modified_direction(system, form, arrived)
    type(system_t), intent(in) :: system !! right given
    type(form_t), intent(inout) :: form !! gets solution, du, force_change
    logical, intent(out) :: arrived !! there is one
    real(wp) :: y(form%condensed%alive%n_live), floor, share

    associate (condensed => form%condensed)
      share = merge(of_factor, of_modified, has_long_products(condensed))
      if (system%motion%active) share = coarsest
      floor = max(share*residual_size(condensed), 1.0e-3_wp*system%scale%round_off)
      call respond(system%equations, form, 1.0_wp, floor, most_allowed(condensed), y, arrived)
      if (.not. arrived) return
      condensed%norm_before = residual_size(condensed)
    end associate
    call take_answer(system, form, y)
  end subroutine find_modified_direction

  !> The direction from the answer of contact.
  subroutine take_answer(system, form, y)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets solution, du, force_change
    real(wp), intent(in) :: y(:) !! (live) answer of contact [force]
    integer :: i

    associate (condensed => form%condensed)
      condensed%bulk%force_change = 0.0_wp
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          condensed%bulk%force_change(c) = y(i) - condensed%alive%right(i)
          form%du(condensed%direction(c), condensed%node(c)) = condensed%alive%change(i)
          form%solution(system%equation(condensed%direction(c), condensed%node(c))) = &
            condensed%alive%change(i)
        end associate
      end do
      if (condensed%rigid%modes > 0) then
        condensed%rigid%alpha_change = condensed%rigid%alpha_next
        call sum_forces(condensed, condensed%bulk%force_change, condensed%rigid%imbalance_change)
        condensed%rigid%imbalance_change = condensed%rigid%imbalance_change &
          + condensed%rigid%damping*condensed%rigid%alpha_change
      end if
      if (condensed%points%n == 0) return
      form%solution(system%equations + 1:) = condensed%points%change
      call spread_rigid(system, form%solution, form%du)
    end associate
  end subroutine take_answer

  !> Displacements that forces at the live candidates bring by themselves, with the present tangent.
  subroutine answer_force(condensed, costs, force, du)
    type(condensed_t), intent(inout) :: condensed !! tangent at hand
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp), intent(in) :: force(:) !! (live) [force]
    real(wp), intent(out) :: du(:) !! (live) [length]
    real(wp) :: push(condensed%rigid%modes), y(size(force)), b(size(force))
    logical :: arrived

    call begin_cost(costs, cost_solve)
    call push_live(condensed, force, push)
    b = 0.0_wp
    call apply_compliance(condensed, force, b)
    call answer(condensed, b, push, inner_accuracy*norm2(force), most_allowed(condensed), y, du, &
      arrived)
    call count_cost(costs, cost_krylov, condensed%tangent%course%iterations)
    call end_cost(costs, cost_solve)
  end subroutine answer_force

  !> The direction once more, now with forces at the live candidates that come beside the residual.
  subroutine push_direction(system, form, force)
    type(system_t), intent(in) :: system !! tangent at hand
    type(form_t), intent(inout) :: form !! gets solution, du, force_change
    real(wp), intent(in) :: force(:) !! (live) [force]
    real(wp) :: y(size(force)), floor
    logical :: arrived

    form%condensed%alive%right = form%condensed%alive%right + force
    floor = max(inner_accuracy*residual_size(form%condensed), 1.0e-3_wp*system%scale%round_off)
    call respond(system%equations, form, 1.0_wp, floor, most_allowed(form%condensed), y, arrived)
    call stay_in_place(form%condensed)
    call take_answer(system, form, y)
  end subroutine push_direction

  !> Iterations of GMRES with the factor or blocks at hand.
  pure integer function most_allowed(condensed) result(most)
    type(condensed_t), intent(in) :: condensed !! its tangent

    most = merge(most_of_blocks, most_vectors, condensed%tangent%parts%iterated)
  end function most_allowed

  !> The blocks have not led to an answer: the small matrix is formed and factorised as a whole,
  !! until other candidates are live.
  subroutine answer_densely(system, form, x, floor, y, arrived, outcome)
    type(system_t), intent(inout) :: system !! right given; gets change of condensed
    type(form_t), intent(inout) :: form !! its kind, right given; gets condensed
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: floor !! residual to arrive at [force]
    real(wp), intent(out) :: y(:) !! (live) answer of contact [force]
    logical, intent(out) :: arrived !! at the floor
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    form%condensed%tangent%parts%dense = .true.
    call form_element_matrices(system, form, x)
    call factorise_tangent(system, form, x, outcome)
    if (outcome /= solver_done) return
    call form_rest(system%contact, form%condensed)
    call respond(system%equations, form, 1.0_wp, floor, most_vectors, y, arrived)
  end subroutine answer_densely

  !> The factor at hand may serve once more: the live candidates are the same, and hardly any
  !! element has changed its status; none, where blocks are cheaply formed anew. Damping or
  !! soft springs in it would hold the bodies for as long as it serves.
  pure logical function is_worth_trying(system, condensed) result(worth)
    type(system_t), intent(in) :: system !! contact elements, condensed
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    integer :: most

    worth = allocated(condensed%tangent%status)
    if (.not. worth) return
    worth = system%body%damping <= 0.0_wp .and. .not. any(system%body%regularised)
    if (condensed%rigid%modes > 0) worth = worth .and. .not. any(abs(condensed%rigid%hold) > 0.0_wp)
    if (.not. worth) return
    associate (tangent => condensed%tangent)
      most = max(most_changes, tangent%elements/changes_share)
      if (tangent%parts%iterated) most = 0
      worth = count(tangent%status /= system%contact%status) <= most
    end associate
  end function is_worth_trying

  !> A product with the compliances takes longer than the residual of one more step; with blocks
  !! that is not asked.
  pure logical function has_long_products(condensed) result(long)
    type(condensed_t), intent(in) :: condensed !! live candidates, closed elements

    long = .not. condensed%tangent%parts%iterated .and. sum(real(condensed%bodies%n_live, wp)**2) &
      > long_product*real(condensed%tangent%elements, wp)
  end function has_long_products

  !> Many elements have changed their status since the tangent was factorised last, where blocks
  !! answer.
  pure logical function is_unsettled(contact, condensed) result(unsettled)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps

    associate (tangent => condensed%tangent)
      unsettled = tangent%parts%iterated .and. allocated(tangent%status)
      if (unsettled) unsettled = share_settled*count(tangent%status /= contact%status) &
        > tangent%elements
    end associate
  end function is_unsettled

  !> As many digits as Newton can use: a tenth of the square of the share that the last iteration
  !! left.
  pure real(wp) function wanted_accuracy(condensed, unsettled) result(accuracy)
    type(condensed_t), intent(in) :: condensed !! right given
    logical, intent(in) :: unsettled !! its contacts are not yet those of the solution

    accuracy = merge(of_modified, merge(of_long, coarsest, has_long_products(condensed)), unsettled)
    if (condensed%norm_before > 0.0_wp) accuracy = min(accuracy, max(finest, &
      0.1_wp*(residual_size(condensed)/condensed%norm_before)**2))
  end function wanted_accuracy

  !> Forces out of balance on candidates, bodies and their motions.
  pure real(wp) function residual_size(condensed) result(norm)
    type(condensed_t), intent(in) :: condensed !! right, defects, imbalance

    norm = hypot(norm2(condensed%alive%right), condensed%bulk%defect_norm)
    if (condensed%rigid%modes > 0) norm = hypot(norm, norm2(condensed%rigid%imbalance))
  end function residual_size

  !> change = b - C y for b = share d + C r with the answer y of contact.
  subroutine respond(equations, form, share, floor, most, y, arrived)
    integer, intent(in) :: equations !! free degrees of freedom
    type(form_t), intent(inout) :: form !! gets change of condensed
    real(wp), intent(in) :: share !! of the defect
    real(wp), intent(in) :: floor !! residual to arrive at [force]
    integer, intent(in) :: most !! iterations allowed
    real(wp), intent(out) :: y(:) !! (live) answer of contact [force]
    logical, intent(out) :: arrived !! at the floor
    real(wp), allocatable :: b(:)
    real(wp) :: push(form%condensed%rigid%modes)

    call begin_cost(form%costs, cost_solve)
    associate (condensed => form%condensed)
      if (condensed%points%n > 0) condensed%points%asked = form%right(equations + 1:)
      call push_live(condensed, condensed%alive%right, push)
      if (condensed%rigid%modes > 0) push = push - in_lengths(condensed, condensed%rigid%imbalance &
        + (1.0_wp - share)*condensed%rigid%imbalance_change)
      allocate (b(condensed%alive%n_live), source=0.0_wp)
      call product_with_residual(condensed, b)
      b = b + share*condensed%bulk%defect(condensed%alive%live)
      call answer(condensed, b, push, floor, most, y, condensed%alive%change, arrived)
    end associate
    call count_cost(form%costs, cost_krylov, form%condensed%tangent%course%iterations)
    call end_cost(form%costs, cost_solve)
  end subroutine respond

  !> C times the residual of the live candidates, unless it is that of the last time.
  subroutine product_with_residual(condensed, y)
    type(condensed_t), intent(inout) :: condensed !! live compliances, right; keeps the product
    real(wp), intent(inout) :: y(:) !! (n_live) gets the product [length]
    logical :: known

    associate (alive => condensed%alive)
      known = condensed%active .and. allocated(alive%pushed)
      if (known) known = size(alive%pushed) == size(alive%right)
      if (known) known = all(abs(alive%right - alive%pushed) <= 0.0_wp)
      if (known) then
        y = alive%product
      else
        call apply_compliance(condensed, alive%right, y)
        alive%pushed = alive%right
        alive%product = y
      end if
    end associate
  end subroutine product_with_residual

  !> Work of the change of the forces on the bulk's defect, which a start without equilibrium has.
  pure real(wp) function defect_energy(form) result(energy)
    type(form_t), intent(in) :: form !! direction found

    energy = abs(dot_product(form%condensed%bulk%force_change, form%condensed%bulk%defect))
    if (form%condensed%rigid%modes > 0) energy = energy + abs(dot_product( &
      form%condensed%rigid%alpha_change, form%condensed%rigid%imbalance))
  end function defect_energy

  !> Length of the direction that the leading part of the present tangent gives for the residual of
  !! a trial.
  real(wp) function next_condensed_length(system, form) result(next)
    type(system_t), intent(in) :: system !! right of the trial given
    type(form_t), intent(inout) :: form !! right given; gets condensed
    real(wp), allocatable :: y(:)
    logical :: arrived

    allocate (y(form%condensed%alive%n_live))
    call respond(system%equations, form, form%condensed%bulk%defect_share, huge(1.0_wp), 0, y, &
      arrived)
    next = norm2(form%condensed%alive%change)
    if (form%condensed%points%n > 0) next = hypot(next, norm2(form%condensed%points%change))
  end function next_condensed_length
end module condensed_direction

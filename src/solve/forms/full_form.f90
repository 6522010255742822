!> The full form: all free degrees of freedom in one sparse matrix (doc/theory, "Algorithms", eqs.
!! (2.5), (5.7)).
module full_form
  use kinds, only: wp
  use back_ends, only: solver_done, solver_singular
  use linear_solver, only: solver_name
  use bulk_products, only: multiply_bulk_absolute
  use bulk_term, only: form_bulk_force, form_bulk_trial, form_bulk_change
  use rigid_bodies, only: take_rigid, spread_rigid, rigid_values
  use rigid_border, only: factorise_bordered, solve_bordered
  use force_scales, only: needed_accuracy
  use equation_values, only: spread_values, gather_values, spread_direction
  use right_side, only: gather_right, damping_shares
  use full_tangent, only: form_tangent
  use contact_coupling, only: couple_full, couple_full_as_saved
  use system_types, only: form_t, form_kind_t, system_t
  use system_parts, only: rigid_part_t
  implicit none
  private
  public :: full_form_of_system, free_values

  !> Residual over right-hand side that an iterative solver may leave of a next direction, and of a
  !! step with the factor at hand.
  real(wp), parameter :: coarse_accuracy = 1.0e-2_wp, refined_accuracy = 1.0e-4_wp

contains

  !> The form.
  function full_form_of_system() result(form)
    type(form_kind_t) :: form

    form%couple => couple_full
    form%couple_as_saved => couple_full_as_saved
    form%find_bulk_force => find_bulk_force
    form%try_bulk_force => try_bulk_force
    form%gather => gather_right
    form%place_trial => place_trial
    form%take_trial => take_trial
    form%find_direction => find_direction
    form%repeat_direction => repeat_direction
    form%next_length => next_length
    form%next_energy => next_energy
    form%answer => answer
    form%push => push
    form%residual_norm => residual_norm
    form%largest_resultant => largest_resultant
    form%damping_norm => damping_norm
    form%direction_norm => direction_norm
    form%direction_work => direction_work
    form%sum_terms => sum_terms
    form%find_worst => find_worst
  end function full_form_of_system

  !> Internal force at u.
  subroutine find_bulk_force(system, form, x)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! gets bulk_force
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call form_bulk_force(x, system, form)
  end subroutine find_bulk_force

  !> Internal force at the trial.
  subroutine try_bulk_force(system, form, x)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! trial given; gets bulk_force
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call form_bulk_trial(x, system, form)
  end subroutine try_bulk_force

  !> The trial at u + length du.
  subroutine place_trial(system, form, length)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets trial
    real(wp), intent(in) :: length !! share of du

    form%trial = system%u + length*form%du
  end subroutine place_trial

  !> Moves to the trial.
  subroutine take_trial(form, length, u, tools)
    type(form_t), intent(inout) :: form !! bulk_change, trial
    real(wp), intent(in) :: length !! share of du
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies, which go with it

    u = form%trial
    call take_rigid(u, tools)
    form%inner%bulk_force = form%inner%bulk_force + length*form%bulk_change
  end subroutine take_trial

  !> Tangent, factor, direction. Bodies that tracks alone were thought to hold are regularised if
  !! there is none.
  subroutine find_direction(system, form, x, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution, du
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    call try_direction(system, form, x, outcome)
    if (outcome /= solver_singular .or. .not. system%body%settled) return
    system%body%settled = .false.
    call try_direction(system, form, x, outcome)
  end subroutine find_direction

  !> Tangent, factor, direction of the system as it is held.
  subroutine try_direction(system, form, x, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution, du
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    call form_tangent(system, form, x)
    form%whole%solver%accuracy = needed_accuracy(system, form%right, form%wish%share, &
      form%wish%wanted)
    call factorise_bordered(system, form, form%whole%symmetric .and. .not. form%wish%indefinite, &
      outcome)
    if (outcome == solver_done) call solve_bordered(system, form, form%right, form%solution, &
      outcome)
    if (outcome /= solver_done) return
    form%kind%name = solver_name(form%whole%solver)
    call spread_direction(system, form)
    call form_bulk_change(system, form)
  end subroutine try_direction

  !> The direction that the factor at hand gives for the present residual.
  subroutine repeat_direction(system, form, found)
    type(system_t), intent(in) :: system !! right given; gets solution, du, bulk_change
    type(form_t), intent(inout) :: form !! the linearised system in its form
    logical, intent(out) :: found !! there is one
    integer :: outcome

    form%whole%solver%accuracy = refined_accuracy
    call solve_bordered(system, form, form%right, form%solution, outcome)
    found = outcome == solver_done
    if (.not. found) return
    call spread_direction(system, form)
    call form_bulk_change(system, form)
  end subroutine repeat_direction

  !> Length of the direction that the present factor gives for the residual of the trial; without
  !! limit if there is none.
  real(wp) function next_length(system, form) result(length)
    type(system_t), intent(in) :: system !! factor and residual of the trial; next is used
    type(form_t), intent(inout) :: form !! right given; gets border, next, matrix
    integer :: outcome

    length = huge(1.0_wp)
    form%whole%solver%accuracy = coarse_accuracy
    call solve_bordered(system, form, form%right, form%next, outcome)
    if (outcome == solver_done) length = norm2(form%next)
  end function next_length

  !> Work of the residual on that direction.
  real(wp) function next_energy(system, form) result(energy)
    type(system_t), intent(in) :: system !! factor and residual; next is used
    type(form_t), intent(inout) :: form !! right given; gets border, next, matrix

    energy = next_length(system, form)
    if (energy < huge(1.0_wp)) energy = abs(dot_product(form%right, form%next))
  end function next_energy

  !> Displacements that forces bring by themselves; none if there is no answer.
  subroutine answer(system, form, force, du)
    type(system_t), intent(in) :: system !! tangent at hand; next is used
    type(form_t), intent(inout) :: form !! gets border, next, matrix
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(out) :: du(:, :) !! (3, nodes) [length]
    integer :: outcome

    du = 0.0_wp
    call solve_bordered(system, form, free_values(system, form%right, force), form%next, outcome)
    if (outcome /= solver_done) return
    call spread_values(system%equation, form%next, du)
    call spread_rigid(system, form%next, du)
  end subroutine answer

  !> The direction with forces beside the residual.
  subroutine push(system, form, force)
    type(system_t), intent(in) :: system !! tangent at hand; gets solution, du, bulk_change
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp) :: change(size(form%solution))
    integer :: outcome

    call solve_bordered(system, form, free_values(system, form%right, force), change, outcome)
    if (outcome /= solver_done) return
    form%solution = form%solution + change
    call spread_direction(system, form)
    call form_bulk_change(system, form)
  end subroutine push

  !> Values at the free degrees of freedom.
  pure function free_values(system, right, field) result(values)
    type(system_t), intent(in) :: system !! equations
    real(wp), intent(in) :: right(:) !! (equations+unknowns) right-hand side [force]
    real(wp), intent(in) :: field(:, :) !! (3, nodes)
    real(wp) :: values(size(right))

    call gather_values(system%equation, field, values)
    values(system%equations + 1:) = rigid_values(system, field)
  end function free_values

  !> All unknowns: free degrees of freedom, and those of rigid bodies.
  pure integer function unknowns(system)
    type(system_t), intent(in) :: system !! numbered

    unknowns = system%equations + system%tools%unknowns
  end function unknowns

  !> Norm of the residual.
  pure real(wp) function residual_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! its unknowns
    type(form_t), intent(in) :: form !! right given

    norm = norm2(form%right(:unknowns(system)))
  end function residual_norm

  !> The largest resultant of the residual on a body that contact alone holds: what is left of its
  !! weight, say, which is small at each of many nodes.
  pure real(wp) function largest_resultant(system, form) result(largest)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(in) :: form !! right given
    real(wp) :: total(3, system%body%bodies)
    integer :: i, k

    largest = 0.0_wp
    if (.not. any(system%body%floating)) return
    total = 0.0_wp
    do i = 1, size(system%equation, 2)
      associate (body => system%body%node_body(i))
        if (body == 0) cycle
        do k = 1, 3
          if (system%equation(k, i) > 0) total(k, body) = total(k, body) &
            + form%right(system%equation(k, i))
        end do
      end associate
    end do
    largest = maxval(norm2(total, 1), system%body%floating)
  end function largest_resultant

  !> Norm of the damping's force.
  pure real(wp) function damping_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! damping and its place
    type(form_t), intent(in) :: form !! it moves all nodes
    real(wp) :: share(system%body%bodies)
    integer :: i

    norm = 0.0_wp
    share = damping_shares(system%body)
    do i = 1, size(form%du, 2)
      if (system%body%node_body(i) == 0) cycle
      norm = hypot(norm, share(system%body%node_body(i))*norm2(pack(system%u(:, i) &
        - system%body%damped_from(:, i), system%equation(:, i) > 0)))
    end do
    norm = hypot(norm, system%body%damping*norm2(system%body%damped_way))
  end function damping_norm

  !> Norm of the direction.
  pure real(wp) function direction_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! its unknowns
    type(form_t), intent(in) :: form !! solution given

    norm = norm2(form%solution(:unknowns(system)))
  end function direction_norm

  !> Work of the residual on the direction.
  pure real(wp) function direction_work(system, form) result(work)
    type(system_t), intent(in) :: system !! its unknowns
    type(form_t), intent(in) :: form !! right and solution given

    work = dot_product(form%right(:unknowns(system)), form%solution(:unknowns(system)))
  end function direction_work

  !> Norm of the terms that the bulk's forces sum.
  subroutine sum_terms(system, form, terms)
    type(system_t), intent(in) :: system !! u given; trial is used
    type(form_t), intent(inout) :: form !! gets trial, matrix
    real(wp), intent(out) :: terms !! [force]

    call multiply_bulk_absolute(system%equation, form%whole, system%u, form%trial)
    where (system%equation == 0) form%trial = 0.0_wp
    terms = norm2(form%trial)
  end subroutine sum_terms

  !> The node and dof with the largest residual.
  pure subroutine find_worst(system, form, node, dof, value)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(in) :: form !! right given
    integer, intent(out) :: node, dof !! 0 if no dof is free
    real(wp), intent(out) :: value !! the residual there [force]
    integer :: place(2), largest

    node = 0
    dof = 0
    value = 0.0_wp
    if (system%equations == 0) return
    largest = maxloc(abs(form%right(:system%equations)), 1)
    value = form%right(largest)
    place = findloc(system%equation, largest)
    dof = place(1)
    node = place(2)
  end subroutine find_worst
end module full_form

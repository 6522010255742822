!> Residual and tangent of the whole system (doc/theory, "Algorithms", eqs. (2.1), (5.7)).
module residuals
  use kinds, only: wp, machine_epsilon
  use costs, only: begin_cost, end_cost, cost_residual, cost_contact_tangent
  use element_types, only: task_tangent, task_residual, status_open
  use elmlib, only: routine_none
  use elmt03, only: d03_epsilon
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t, fill_values
  use assembly, only: assemble
  use bulk_products, only: multiply_bulk_absolute
  use bulk_term, only: form_bulk_force, form_bulk_trial, form_bulk_tangent
  use supports, only: ground_bodies
  use right_side, only: gather_right, drag_shares
  use multiplier_types, only: shift_multipliers
  use live_values, only: try_live
  use rigid_bodies, only: try_rigid
  use rigid_border, only: form_border
  use system_types, only: system_t
  implicit none
  private
  public :: form_residual, form_trial, form_tangent, residual_norm, drag_norm, &
    largest_resultant, find_worst, estimate_round_off, round_off_factor

  !> Below this many times the estimate of its round-off the residual is converged as soon as an
  !! iteration does not halve it any more.
  real(wp), parameter :: round_off_factor = 8.0_wp

  !> Element matrices that differ by less from their transposes are symmetric to round-off; those
  !! of slip with friction differ by about mu.
  real(wp), parameter :: symmetry_tolerance = 1.0e-12_wp

contains

  !> Internal forces at u.
  subroutine form_residual(system, x)
    type(system_t), intent(inout) :: system !! u given; gets bulk_force, contact_force, right
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call begin_cost(system%costs, cost_residual)
    if (.not. (system%condensed%active .or. system%inner%known)) call form_bulk_force(x, system)
    system%inner%known = .false.
    call assemble(system%contact, task_residual, x, system%u, system%contact_force)
    call gather_right(system, 0.0_wp, .false.)
    call end_cost(system%costs, cost_residual)
  end subroutine form_residual

  !> The same at u + length du; where the bulk is linear only contact is evaluated.
  subroutine form_trial(system, x, length)
    type(system_t), intent(inout) :: system !! u, du, bulk_change given; gets trial, right
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: length !! share of du

    call begin_cost(system%costs, cost_residual)
    if (system%condensed%active) then
      call try_live(system, length)
    else
      system%trial = system%u + length*system%du
    end if
    call try_rigid(system, length)
    if (system%motion%active) call shift_multipliers(system%motion, length, system%contact%shift)
    call form_bulk_trial(x, system)
    call assemble(system%contact, task_residual, x, system%trial, system%contact_force)
    call gather_right(system, length, .true.)
    call end_cost(system%costs, cost_residual)
  end subroutine form_trial

  !> Tangent at u in csc, right-hand side, and whether the tangent is symmetric; bodies that nothing
  !! holds at present are grounded. Without contact the tangent is the bulk's, formed once.
  subroutine form_tangent(system, x)
    type(system_t), intent(inout) :: system !! gets matrix, csc, symmetric, right
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: k

    call form_bulk_tangent(x, system)
    if (system%contact%n == 0) then
      if (.not. (system%whole%symmetric .and. system%bulk%linear)) &
        call hand_values(system%whole%bulk_matrix, system%equation, system%whole%solver%by_nodes, &
        system%whole%csc)
      system%whole%symmetric = .not. allocated(system%loads%pressed)
      call form_border(system)
      return
    end if
    call begin_cost(system%costs, cost_contact_tangent)
    system%whole%matrix%val = 0.0_wp
    if (.not. system%whole%apart) then
      do k = 1, size(system%whole%bulk_place)
        system%whole%matrix%val(:, :, system%whole%bulk_place(k)) = &
          system%whole%bulk_matrix%val(:, :, k)
      end do
    end if
    call assemble(system%contact, task_tangent, x, system%u, system%contact_force, &
      system%whole%matrix)
    call gather_right(system, 0.0_wp, .false.)
    if (any(system%body%weak)) call ground_bodies(x, system)
    call form_border(system)
    call hand_values(system%whole%matrix, system%equation, system%whole%solver%by_nodes, &
      system%whole%csc)
    system%whole%symmetric = system%contact%asymmetry <= symmetry_tolerance .and. &
      .not. allocated(system%loads%pressed)
    call end_cost(system%costs, cost_contact_tangent)
  end subroutine form_tangent

  !> The values for the solver; one that takes them by nodes has them when it factorises.
  pure subroutine hand_values(blocks, equation, by_nodes, csc)
    type(block_matrix_t), intent(in) :: blocks !! tangent of all nodes
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    logical, intent(in) :: by_nodes !! the solver takes them by nodes
    type(csc_matrix_t), intent(inout) :: csc !! gets the values

    if (by_nodes) then
      csc%changed = .true.
    else
      call fill_values(blocks, equation, csc)
    end if
  end subroutine hand_values

  !> Norm of the residual on the free degrees of freedom.
  pure real(wp) function residual_norm(system) result(norm)
    type(system_t), intent(in) :: system !! right given

    if (system%condensed%active) then
      norm = hypot(norm2(system%condensed%alive%right), system%condensed%bulk%defect_share &
        *system%condensed%bulk%defect_norm)
      if (system%condensed%rigid%modes > 0) norm = hypot(norm, &
        norm2(system%condensed%rigid%imbalance &
        + (1.0_wp - system%condensed%bulk%defect_share)*system%condensed%rigid%imbalance_change))
      if (system%tools%border%n > 0) norm = hypot(norm, norm2(system%right(system%equations + 1:)))
    else
      norm = norm2(system%right)
    end if
  end function residual_norm

  !> The largest resultant of the residual on a body that contact alone holds: what is left of its
  !! weight, say, which is small at each of many nodes. The condensed form has it in its norm.
  pure real(wp) function largest_resultant(system) result(largest)
    type(system_t), intent(in) :: system !! right given
    real(wp) :: total(3, system%body%bodies)
    integer :: i, k

    largest = 0.0_wp
    if (system%condensed%active .or. .not. any(system%body%weak)) return
    total = 0.0_wp
    do i = 1, size(system%equation, 2)
      associate (body => system%body%node_body(i))
        if (body == 0) cycle
        do k = 1, 3
          if (system%equation(k, i) > 0) total(k, body) = total(k, body) &
            + system%right(system%equation(k, i))
        end do
      end associate
    end do
    largest = maxval(norm2(total, 1), system%body%weak)
  end function largest_resultant

  !> Norm of the drag's force, as far as the residual knows of it.
  pure real(wp) function drag_norm(system) result(norm)
    type(system_t), intent(in) :: system !! drag, euler
    real(wp) :: share(system%body%bodies)
    integer :: i

    norm = 0.0_wp
    if (system%condensed%active) then
      if (system%condensed%rigid%modes > 0) norm = norm2(system%condensed%rigid%drag* &
        (system%condensed%rigid%alpha - system%condensed%rigid%center))
      if (system%tools%border%n > 0) norm = hypot(norm, system%body%drag* &
        norm2(system%body%euler%gone))
      return
    end if
    share = drag_shares(system)
    do i = 1, size(system%equation, 2)
      if (system%body%node_body(i) == 0) cycle
      norm = hypot(norm, share(system%body%node_body(i))*norm2(pack(system%u(:, i) &
        - system%body%euler%u(:, i), system%equation(:, i) > 0)))
    end do
    norm = hypot(norm, system%body%drag*norm2(system%body%euler%gone))
  end function drag_norm

  !> The node and dof with the largest residual; of the condensed form the candidate.
  pure subroutine find_worst(system, node, dof, value)
    type(system_t), intent(in) :: system !! right given
    integer, intent(out) :: node !! the node, 0 if no dof is free
    integer, intent(out) :: dof !! its dof
    real(wp), intent(out) :: value !! the residual there [force]
    integer :: place(2), largest

    node = 0
    dof = 0
    value = 0.0_wp
    if (system%condensed%active) then
      if (system%condensed%alive%n_live == 0) return
      largest = maxloc(abs(system%condensed%alive%right(:system%condensed%alive%n_live)), 1)
      value = system%condensed%alive%right(largest)
      node = system%condensed%node(system%condensed%alive%live(largest))
      dof = system%condensed%direction(system%condensed%alive%live(largest))
    else if (system%equations > 0) then
      largest = maxloc(abs(system%right(:system%equations)), 1)
      value = system%right(largest)
      place = findloc(system%equation, largest)
      dof = place(1)
      node = place(2)
    end if
  end subroutine find_worst

  !> What round-off leaves of the residual at best: machine epsilon times the terms it sums. Open
  !! contact points of bodies that contact alone holds are left out: such a body may have come to
  !! rest without any load, and what is left there is then seen against no other force.
  subroutine estimate_round_off(system, x)
    type(system_t), intent(inout) :: system !! u given; gets round_off
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: terms, largest
    integer :: k, n, last

    if (system%condensed%active) then
      terms = hypot(norm2(system%condensed%bulk%force), carried_terms(system))
    else
      if (system%condensed%preconditions) then
        do k = 1, size(system%u, 2)
          system%trial(:, k) = matmul(system%inner%rows(:, :, k), abs(system%u(:, k)))
        end do
      else
        call multiply_bulk_absolute(system, system%u, system%trial)
      end if
      where (system%equation == 0) system%trial = 0.0_wp
      terms = norm2(system%trial)
    end if
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      if (system%contact%status(k) <= status_open .and. is_weak(system, k)) cycle
      largest = 0.0_wp
      last = system%contact%ix(system%contact%nel(k), k)
      do n = 1, system%contact%nel(k)
        associate (node => system%contact%ix(n, k))
          largest = max(largest, maxval(abs(x(:, node) - x(:, last)) + abs(system%u(:, node))))
        end associate
      end do
      terms = hypot(terms, system%contact%d(d03_epsilon, k)*largest)
    end do
    system%scale%round_off = machine_epsilon*terms
  end subroutine estimate_round_off

  !> Terms of the defects of bodies that their motions carry along: they are differences of
  !! displacements, and there need be no force beside which these are small; and their loads, which
  !! may be in balance by themselves.
  pure real(wp) function carried_terms(system) result(terms)
    type(system_t), intent(in) :: system !! u given
    real(wp) :: farthest, load
    integer :: i

    farthest = 0.0_wp
    load = 0.0_wp
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) == 0) cycle
      if (.not. system%body%weak(system%body%node_body(i))) cycle
      load = hypot(load, norm2(system%loads%external(:, i)))
      if (system%condensed%candidate(i)) farthest = max(farthest, maxval(abs(system%u(:, i))))
    end do
    terms = hypot(system%scale%stiffest*farthest, load)
  end function carried_terms

  !> A body of a contact element is not held by its supports alone.
  pure logical function is_weak(system, k)
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: k !! the element

    associate (nodes => system%contact%ix(1:system%contact%nel(k), k))
      is_weak = any(system%body%weak(system%body%node_body(nodes)))
    end associate
  end function is_weak
end module residuals

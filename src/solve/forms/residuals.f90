!> Residual of the whole system, whatever form its equations have (doc/theory, "Algorithms", eq.
!! (2.5)).
module residuals
  use kinds, only: wp, machine_epsilon
  use costs, only: begin_cost, end_cost, cost_residual, cost_search
  use element_types, only: status_open, routine_none
  use element_parameters, only: d03_epsilon
  use multiplier_types, only: shift_multipliers
  use rigid_bodies, only: try_rigid
  use model_types, only: model_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: form_residual, form_trial, follow_shape, residual_norm, round_off_of, &
    round_off_factor

  !> Below this many times the estimate of its round-off the residual is converged as soon as an
  !! iteration does not halve it any more.
  real(wp), parameter :: round_off_factor = 8.0_wp

contains

  !> Internal forces at u.
  subroutine form_residual(system, form, x)
    type(system_t), intent(inout) :: system !! u given; gets bulk_force, contact_force, right
    type(form_t), intent(inout) :: form !! its kind answers
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call begin_cost(form%costs, cost_residual)
    if (associated(form%kind%find_bulk_force) .and. .not. form%inner%known) &
      call form%kind%find_bulk_force(system, form, x)
    form%inner%known = .false.
    call system%terms%contact_forces(system%contact, x, system%u, system%contact_force)
    call form%kind%gather(system, form, 0.0_wp, .false.)
    call end_cost(form%costs, cost_residual)
  end subroutine form_residual

  !> The same at u + length du; where the bulk is linear only contact is evaluated.
  subroutine form_trial(system, form, x, length)
    type(system_t), intent(inout) :: system !! u, du, bulk_change given; gets trial, right
    type(form_t), intent(inout) :: form !! its kind, solution given; gets trial
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: length !! share of du

    call begin_cost(form%costs, cost_residual)
    call form%kind%place_trial(system, form, length)
    call try_rigid(system%tools, form%solution, length, form%trial)
    if (system%motion%active) call shift_multipliers(system%motion, length, system%contact%shift)
    if (associated(form%kind%try_bulk_force)) call form%kind%try_bulk_force(system, form, x)
    call system%terms%contact_forces(system%contact, x, form%trial, system%contact_force)
    call form%kind%gather(system, form, length, .true.)
    call end_cost(form%costs, cost_residual)
  end subroutine form_trial

  !> Smooth surfaces bend as the nodes of the iterate lie, and the residual with them.
  subroutine follow_shape(model, system, form)
    type(model_t), intent(inout) :: model !! pairs: patches
    type(system_t), intent(inout) :: system !! u and the bulk's force given; residual is formed
    type(form_t), intent(inout) :: form !! its kind answers

    if (.not. any(model%pairs%smooth)) return
    if (associated(form%kind%refresh)) call form%kind%refresh(form, system%u)
    system%position%x_now = model%mesh%x + system%u
    call begin_cost(form%costs, cost_search)
    call system%terms%bend_surfaces(model, system%place, system%u, system%contact)
    call end_cost(form%costs, cost_search)
    form%inner%known = .true.
    call form_residual(system, form, model%mesh%x)
  end subroutine follow_shape

  !> Norm of the residual in the unknowns of the form.
  pure real(wp) function residual_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(in) :: form !! right given

    norm = form%kind%residual_norm(system, form)
  end function residual_norm

  !> What round-off leaves of the residual at best: machine epsilon times the terms it sums. Open
  !! contact points of bodies that contact alone holds are left out: such a body may have come to
  !! rest without any load, and what is left there is then seen against no other force.
  real(wp) function round_off_of(system, form, x) result(norm)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! its kind answers; trial is used
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: terms, largest
    integer :: k, n, last

    call form%kind%sum_terms(system, form, terms)
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      if (system%contact%status(k) <= status_open .and. is_floating(system, k)) cycle
      largest = 0.0_wp
      last = system%contact%ix(system%contact%nel(k), k)
      do n = 1, system%contact%nel(k)
        associate (node => system%contact%ix(n, k))
          largest = max(largest, maxval(abs(x(:, node) - x(:, last)) + abs(system%u(:, node))))
        end associate
      end do
      terms = hypot(terms, system%contact%d(d03_epsilon, k)*largest)
    end do
    norm = machine_epsilon*terms
  end function round_off_of

  !> A body of a contact element is not held by its supports alone.
  pure logical function is_floating(system, k)
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: k !! the element

    associate (nodes => system%contact%ix(1:system%contact%nel(k), k))
      is_floating = any(system%body%floating(system%body%node_body(nodes)))
    end associate
  end function is_floating
end module residuals

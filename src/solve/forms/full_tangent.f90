!> Tangent of bulk and contact as one sparse matrix (doc/theory, "Algorithms", eq. (5.7)).
module full_tangent
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_contact_tangent
  use element_types, only: task_tangent
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t, fill_values
  use assembly, only: assemble
  use bulk_term, only: form_bulk_tangent
  use supports, only: regularise_bodies, unheld_bodies
  use right_side, only: gather_right
  use rigid_border, only: form_border
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: form_tangent

  !> Element matrices that differ by less from their transposes are symmetric to round-off; those
  !! of slip with friction differ by about mu.
  real(wp), parameter :: symmetry_tolerance = 1.0e-12_wp

contains

  !> Tangent at u in csc, right-hand side, and whether the tangent is symmetric; bodies that nothing
  !! holds at present are regularised. Without contact the tangent is the bulk's, formed once.
  subroutine form_tangent(system, form, x)
    type(system_t), intent(inout) :: system !! gets matrix, csc, symmetric, right
    type(form_t), intent(inout) :: form !! gets border, right, matrix
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: skew
    integer :: k

    call form_bulk_tangent(x, system, form)
    if (system%contact%n == 0) then
      if (.not. (form%whole%symmetric .and. system%bulk%linear)) &
        call hand_values(form%whole%bulk_matrix, system%equation, form%whole%solver%by_nodes, &
        form%whole%csc)
      form%whole%symmetric = .not. allocated(system%loads%pressed)
      call form_border(system, form)
      return
    end if
    call begin_cost(form%costs, cost_contact_tangent)
    form%whole%matrix%val = 0.0_wp
    if (.not. form%whole%apart) then
      do k = 1, size(form%whole%bulk_place)
        form%whole%matrix%val(:, :, form%whole%bulk_place(k)) = form%whole%bulk_matrix%val(:, :, k)
      end do
    end if
    call assemble(system%contact, task_tangent, x, system%u, system%contact_force, &
      form%whole%matrix, skew=skew)
    call gather_right(system, form, 0.0_wp, .false.)
    if (any(system%body%floating)) system%body%regularised = unheld_bodies(x, system, form)
    if (any(system%body%floating)) call regularise_bodies(system, form)
    call form_border(system, form)
    call hand_values(form%whole%matrix, system%equation, form%whole%solver%by_nodes, form%whole%csc)
    form%whole%symmetric = skew <= symmetry_tolerance .and. &
      .not. allocated(system%loads%pressed)
    call end_cost(form%costs, cost_contact_tangent)
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
end module full_tangent

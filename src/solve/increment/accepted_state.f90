!> What has converged becomes the state: displacements, reactions, history of contact.
module accepted_state
  use kinds, only: wp
  use linear_solver, only: rest_solver
  use model_types, only: model_t
  use contact_system, only: settle_contact
  use first_touch, only: keep_path
  use linear_sums, only: take_sums
  use bulk_assembly, only: remember_bulk
  use follower_pressure, only: take_pressure_force
  use springs, only: spring_reactions
  use rigid_bodies, only: keep_rigid
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: accept, complete_state

contains

  !> Takes the converged iterate as the new state.
  subroutine accept(model, system, form, state, time, known)
    type(model_t), intent(inout) :: model !! history is committed
    type(system_t), intent(inout) :: system !! converged
    type(form_t), intent(inout) :: form !! its kind given; gets condensed, matrix
    type(state_t), intent(inout) :: state !! becomes the new state
    real(wp), intent(in) :: time !! its time
    logical, intent(in), optional :: known !! the displacements inside are known
    logical :: inside_known

    inside_known = .false.
    if (present(known)) inside_known = known
    state%whole = .true.
    if (associated(form%kind%accept)) call form%kind%accept(model, system, form, inside_known, &
      state%whole)
    call keep_path(model, system%touch, state, time)
    state%u = system%u
    state%began = state%time
    state%time = time
    if (state%whole) then
      call take_reactions(model, system, state)
    else
      call take_sums(form%condensed)
    end if
    system%position%x_now = model%mesh%x + state%u
    call settle_contact(model, system%contact, system%costs, system%position, system%place)
    call remember_bulk(system%bulk, model%mesh%x, system%u)
    call rest_solver(form%whole%solver)
  end subroutine accept

  !> Forces of the supports, from those of the bulk.
  subroutine take_reactions(model, system, state)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! bulk_force given
    type(state_t), intent(inout) :: state !! gets reaction, rigid

    call take_pressure_force(model%mesh%x, system%u, system%loads, system%inner)
    where (system%equation == 0)
      state%reaction = system%inner%bulk_force + system%contact_force - system%loads%external
    else where
      state%reaction = 0.0_wp
    end where
    call spring_reactions(system, state)
    call keep_rigid(system%tools, state)
  end subroutine take_reactions

  !> Displacements inside and reactions of the state, where they have been spared.
  subroutine complete_state(model, system, form, state)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(inout) :: system !! as accepted
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! becomes whole

    if (state%whole) return
    call form%kind%recover(system, form)
    state%whole = .true.
    state%u = system%u
    call take_reactions(model, system, state)
  end subroutine complete_state
end module accepted_state

!> What has converged becomes the state: displacements, reactions, history of contact.
module accepted_state
  use kinds, only: wp
  use linear_solver, only: rest_solver
  use model_types, only: model_t
  use first_touch, only: keep_path
  use linear_sums, only: take_sums
  use bulk_assembly, only: remember_bulk
  use follower_pressure, only: take_pressure_force
  use springs, only: spring_reactions
  use rigid_bodies, only: keep_rigid
  use system_types, only: form_t, system_t, state_t
  use costs, only: count_cost, cost_cells
  use element_types, only: status_open
  use element_parameters, only: d03_epsilon
  use contact_points, only: count_points
  use contact_targets, only: settle_points
  use mortar_history, only: settle_mortar
  use mortar_points, only: keep_points
  use friction_laws, only: keeps_path
  use apex_ways, only: way_of_apex
  use system_parts, only: bulk_answer_t
  implicit none
  private
  public :: accept, complete_state

contains

  !> Takes the converged iterate as the new state.
  subroutine accept(model, system, form, state, time, inside_due, known)
    type(model_t), intent(inout) :: model !! history is committed
    type(system_t), intent(inout) :: system !! converged
    type(form_t), intent(inout) :: form !! its kind given; gets condensed, matrix
    type(state_t), intent(inout) :: state !! becomes the new state
    real(wp), intent(in) :: time !! its time
    logical, intent(in) :: inside_due !! displacements inside are asked for at it
    logical, intent(in), optional :: known !! they are known
    logical :: inside_known

    inside_known = .false.
    if (present(known)) inside_known = known
    state%whole = .true.
    if (associated(form%kind%accept)) call form%kind%accept(model, system, form, inside_due, &
      inside_known, state%whole)
    call keep_path(model, system%touch, state, time)
    state%u = system%u
    state%began = state%time
    state%time = time
    if (state%whole) then
      call take_pressure_force(model%mesh%x, system%u, system%loads, form%inner)
      call take_reactions(system, form%inner, state)
    else
      call take_sums(form%condensed)
    end if
    system%position%x_now = model%mesh%x + state%u
    call settle_contact(model, system)
    call count_cost(form%costs, cost_cells, sum(model%pairs%history%cuts))
    model%pairs%history%cuts = 0
    call remember_bulk(system%bulk, model%mesh%x, system%u)
    call rest_solver(form%whole%solver)
  end subroutine accept

  !> Forces of the supports, from those of the bulk.
  subroutine take_reactions(system, inner, state)
    type(system_t), intent(in) :: system !! loads, forces of contact
    type(bulk_answer_t), intent(in) :: inner !! bulk_force
    type(state_t), intent(inout) :: state !! gets reaction, rigid

    where (system%equation == 0)
      state%reaction = inner%bulk_force + system%contact_force - system%loads%external
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
    call take_pressure_force(model%mesh%x, system%u, system%loads, form%inner)
    call take_reactions(system, form%inner, state)
  end subroutine complete_state

  !> Hands status and apexes of the elements to the working points of the pairs, and what friction
  !! has dissipated (doc/theory, "Dissipation", eq. (4.9)).
  subroutine keep_status(model, system)
    type(model_t), intent(inout) :: model !! pairs: status of new
    type(system_t), intent(in) :: system !! contact elements, x_now
    real(wp) :: way(3)
    integer :: k, p, element

    do k = 1, size(model%pairs)
      if (allocated(model%pairs(k)%nodes%owner)) cycle
      do p = 1, count_points(model%pairs(k))
        element = system%place%first_point(k) + p - 1
        associate (contact => system%contact, point => model%pairs(k)%history%new(p))
          point%status = contact%status(element)
          point%path = 0.0_wp
          if (point%status <= status_open) then
            point%way = 0.0_wp
            cycle
          end if
          way = way_of_apex(contact, element, system%position%x_now)
          point%dissipation = point%dissipation + contact%d(d03_epsilon, element) &
            *dot_product(contact%slip(:, element), way)
          point%way = point%way + way
          point%apex = contact%h2(:, element)
          if (keeps_path(model%pairs(k)%law)) then
            point%path = contact%path2(element)
          else
            point%path = contact%path1(element) + norm2(way)
          end if
        end associate
      end do
    end do
  end subroutine keep_status

  !> Commits the history of an accepted increment.
  subroutine settle_contact(model, system)
    type(model_t), intent(inout) :: model !! pairs: new becomes old
    type(system_t), intent(in) :: system !! contact elements, x_now
    integer :: k

    call keep_status(model, system)
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k), x_now => system%position%x_now)
        if (pair%mortar) then
          call settle_mortar(pair, system%contact%status(system%place%first_point(k): &
            system%place%first_point(k + 1) - 1), x_now)
        else
          if (allocated(pair%nodes%owner)) call keep_points(pair, x_now)
          call settle_points(pair, x_now)
        end if
      end associate
    end do
  end subroutine settle_contact
end module accepted_state

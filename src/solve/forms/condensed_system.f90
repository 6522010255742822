!> The condensed form of a system: start and extension of the candidates, live candidates, forces
!! of the iterate, and the way back to all nodes (doc/theory, "Static condensation").
module condensed_system
  use kinds, only: wp
  use element_types, only: routine_none
  use loads, only: load_factors, conditions_at
  use model_types, only: model_t
  use contact_parameters, only: shifts_gap
  use block_matrix, only: multiply, multiply_some
  use back_ends, only: solver_done, solver_out_of_memory, solver_not_definite
  use condensed_types, only: condensed_t
  use condensed_bodies, only: condense_all, begin_influence, number_candidates, load_candidates, &
    free_condensed
  use compliance_products, only: find_equilibrium, fit_motions, spread_product
  use live_candidates, only: widen_live, number_live, forget_live
  use condensed_motions, only: find_imbalance, add_motion_inside, lost_digits
  use bulk_factors, only: condense_bulk, condense_at_rest
  use live_values, only: clear_values
  use candidates, only: foresee_candidates, dense_share, list_facets, add_ring, mark_touched
  use system_types, only: form_t, system_t, state_t
  use element_lists, only: element_list_t
  use system_parts, only: bodies_t, positions_t
  implicit none
  private
  public :: start_condensed, begin_condensed, place_starts, couple_condensed, restore_forces, &
    find_defects, renew_defects, refresh_candidates, place_candidates, recover_interior, &
    keep_forces, spread_forces

contains

  !> Condenses the system, or says why it cannot be.
  subroutine start_condensed(model, system, form, if_cheaper, why, share)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    logical, intent(in) :: if_cheaper !! not where sparse factors cost less, or no digits
    character(:), allocatable, intent(out) :: why !! why not; empty if it is done
    real(wp), intent(out) :: share !! what it costs over what sparse factors do, estimated
    integer :: outcome

    share = 0.0_wp
    why = ''
    if (system%equations == 0) why = 'there are no unknowns'
    if (len(why) > 0) return
    associate (condensed => form%condensed)
      if (.not. allocated(condensed%candidate)) then
        allocate (condensed%candidate(model%mesh%nodes), source=.false.)
        call foresee_candidates(model, system, condensed%candidate)
        where (.not. any(system%equation > 0, 1)) condensed%candidate = .false.
        share = dense_share(model, system, form%condensed)
        if (if_cheaper .and. share > 1.0_wp) then
          why = 'its dense systems would cost more than sparse factors'
          form%condensed = condensed_t()
          return
        end if
      end if
      call list_facets(model, condensed%facets)
      allocate (condensed%bodies(system%body%bodies), condensed%place(3, model%mesh%nodes))
      condensed%rigid%x = model%mesh%x
      condensed%exact = any(model%pairs%mortar)
      if (system%bulk%linear) then
        call begin_influence(model, system, form)
        call condense_all(system, form, spread(.true., 1, system%body%bodies), outcome, model)
      else
        call condense_bulk(system, form, outcome)
      end if
    end associate
    if (outcome /= solver_done) then
      why = 'its factorisation failed'
      if (outcome == solver_not_definite) why = 'the stiffness of a body is not positive definite'
      if (outcome == solver_out_of_memory) why = 'its factors need more memory than there is'
    else if (if_cheaper) then
      why = lost_digits(form%condensed)
    end if
    if (len(why) > 0) then
      call free_condensed(form%condensed)
      return
    end if
    call number_candidates(form%condensed)
    form%condensed%active = system%bulk%linear
    form%condensed%preconditions = .not. system%bulk%linear
  end subroutine start_condensed

  !> Displacements of the candidates without contact at `time`.
  subroutine begin_condensed(model, equation, form, state, time)
    type(model_t), intent(in) :: model !! loads
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment

    associate (condensed => form%condensed)
      condensed%outer%factors = load_factors(model, time)
      condensed%goes_on = condensed%goes_on .and. .not. any(shifts_gap(model%pairs))
      if (.not. condensed%goes_on) then
        if (allocated(condensed%tangent%status)) deallocate (condensed%tangent%status)
        call forget_live(condensed)
      end if
      call load_candidates(condensed)
      if (.not. allocated(condensed%outer%kept)) call find_forces(model, equation, form, state)
    end associate
  end subroutine begin_condensed

  !> Contact forces of a state that another solver has found: what balances the bulk.
  subroutine find_forces(model, equation, form, state)
    type(model_t), intent(in) :: model !! loads
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    type(state_t), intent(in) :: state !! last converged state
    real(wp) :: force(3, model%mesh%nodes), bulk(3, model%mesh%nodes)

    allocate (form%condensed%outer%kept(3, model%mesh%nodes), source=0.0_wp)
    if (all(abs(state%u) <= 0.0_wp)) return
    call multiply(form%whole%bulk_matrix, state%u, bulk)
    call conditions_at(model, state%time, force=force)
    where (equation > 0 .and. spread(form%condensed%candidate, 1, 3)) &
      form%condensed%outer%kept = force - bulk
  end subroutine find_forces

  !> Two starts at the candidates: where they were, and in equilibrium with the forces of the last
  !! state under the new loads. Other nodes are carried along, and so are bodies that contact holds:
  !! under the new loads those forces are no equilibrium of theirs.
  subroutine place_starts(form, body, position)
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    type(bodies_t), intent(in) :: body !! connected bodies
    type(positions_t), intent(inout) :: position !! left and carried given; both are completed
    real(wp) :: u(form%condensed%n)
    integer :: i

    associate (condensed => form%condensed)
      where (condensed%place == 0) position%left = position%carried
      call restore_forces(condensed)
      call find_equilibrium(condensed, u)
      do i = 1, condensed%n
        if (body%motions(body%node_body(condensed%node(i)))%n > 0) cycle
        position%carried(condensed%direction(i), condensed%node(i)) = u(i)
      end do
    end associate
  end subroutine place_starts

  !> A nodal field at the candidates.
  pure function candidate_values(condensed, u) result(values)
    type(condensed_t), intent(in) :: condensed !! its candidates
    real(wp), intent(in) :: u(:, :) !! (3, nodes)
    real(wp) :: values(condensed%n)
    integer :: i

    do i = 1, condensed%n
      values(i) = u(condensed%direction(i), condensed%node(i))
    end do
  end function candidate_values

  !> The forces of the last state.
  subroutine restore_forces(condensed)
    type(condensed_t), intent(inout) :: condensed !! gets force
    integer :: i

    do i = 1, condensed%n
      condensed%bulk%force(i) = condensed%outer%kept(condensed%direction(i), condensed%node(i))
    end do
  end subroutine restore_forces

  !> How far u is from equilibrium with the forces of the iterate.
  subroutine find_defects(system, form)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! gets defect
    real(wp) :: u(form%condensed%n)

    associate (condensed => form%condensed)
      call fit_motions(condensed, candidate_values(condensed, system%u))
      call find_equilibrium(condensed, u)
      condensed%bulk%defect = u - candidate_values(condensed, system%u)
      call find_imbalance(condensed)
      call measure_defects(condensed)
      condensed%norm_before = 0.0_wp
    end associate
  end subroutine find_defects

  !> The defects as they are, where they have been carried on from iteration to iteration: those of
  !! long directions, or under large forces, have lost digits.
  subroutine renew_defects(form, u)
    type(form_t), intent(inout) :: form !! forces given; gets defect, imbalance
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    real(wp) :: there(form%condensed%n)

    associate (condensed => form%condensed)
      call refresh_candidates(form, u)
      call find_equilibrium(condensed, there)
      condensed%bulk%defect = there - candidate_values(condensed, u)
      call find_imbalance(condensed)
      call measure_defects(condensed)
    end associate
  end subroutine renew_defects

  !> The forces that would hold the defects, each by itself. The compliance of a body with fixings
  !! is partly that of its fixings: there the least one counts for all.
  subroutine measure_defects(condensed)
    type(condensed_t), intent(inout) :: condensed !! gets defect_norm
    real(wp) :: least
    integer :: b, i

    condensed%bulk%defect_norm = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        least = huge(1.0_wp)
        if (body%motions%n > 0) least = minval(body%diagonal)
        do i = 1, body%m
          condensed%bulk%defect_norm = hypot(condensed%bulk%defect_norm, &
            condensed%bulk%defect(body%first + i)/min(least, body%diagonal(i)))
        end do
      end associate
    end do
  end subroutine measure_defects

  !> Moves the candidates that no iteration has moved to where the forces of the iterate put them.
  subroutine refresh_candidates(form, u)
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) of candidates that are not live [length]

    call place_candidates(form%condensed, form%condensed%alive%live_place == 0, u)
  end subroutine refresh_candidates

  !> Moves candidates to where the forces of the iterate, less its defects, put them.
  subroutine place_candidates(condensed, moves, u)
    type(condensed_t), intent(inout) :: condensed !! forces, defects
    logical, intent(in) :: moves(:) !! (n) they do
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp) :: there(condensed%n)
    integer :: i

    call find_equilibrium(condensed, there)
    do i = 1, condensed%n
      if (.not. moves(i)) cycle
      u(condensed%direction(i), condensed%node(i)) = there(i) - condensed%bulk%defect(i)
    end do
  end subroutine place_candidates

  !> Makes sure that every node of a contact element is a candidate, and numbers the live ones;
  !! their compliance is gathered when an iteration wants it.
  subroutine couple_condensed(system, form)
    type(system_t), intent(inout) :: system !! condensed follows the contact elements
    type(form_t), intent(inout) :: form !! the linearised system in its form
    logical, allocatable :: live(:)
    integer :: k, i, a, n

    call extend_candidates(system, form)
    form%condensed%norm_before = 0.0_wp
    associate (condensed => form%condensed, list => system%contact)
      allocate (live(condensed%n))
      live = abs(condensed%bulk%force) > 0.0_wp
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        do a = 1, list%nel(k)
          do i = 1, 3
            n = condensed%place(i, list%ix(a, k))
            if (n > 0) live(n) = .true.
          end do
        end do
      end do
      call widen_live(condensed, live)
      if (all(live .eqv. condensed%alive%live_place > 0) .and. &
        allocated(condensed%alive%right)) then
        call place_elements(system%contact, form)
        return
      end if
      form%du = 0.0_wp
      if (allocated(condensed%tangent%status)) deallocate (condensed%tangent%status)
      condensed%alive%live = pack([(i, i=1, condensed%n)], live)
      condensed%alive%n_live = size(condensed%alive%live)
      condensed%alive%live_place = 0
      condensed%alive%live_place(condensed%alive%live) = [(i, i=1, condensed%alive%n_live)]
      call number_live(condensed)
      call measure_defects(condensed)
      call place_elements(system%contact, form)
    end associate
  end subroutine couple_condensed

  !> Live candidates of the contact elements; the factor of their matrices cannot serve any more
  !! where these are others. With multipliers it serves no longer either: their last digits are
  !! those of the tangent.
  subroutine place_elements(contact, form)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(form_t), intent(inout) :: form !! gets dofs of the tangent
    integer, allocatable :: before(:, :)
    integer :: k, a, i, n

    associate (condensed => form%condensed, tangent => form%condensed%tangent, list => contact)
      tangent%parts%dense = .false.
      if (.not. allocated(tangent%dofs)) &
        allocate (tangent%dofs(3*size(list%ix, 1), list%n), source=-1)
      before = tangent%dofs
      tangent%dofs = 0
      if (condensed%active) call clear_values(form)
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        do a = 1, list%nel(k)
          do i = 1, 3
            n = condensed%place(i, list%ix(a, k))
            if (n > 0) tangent%dofs(3*(a - 1) + i, k) = condensed%alive%live_place(n)
          end do
        end do
      end do
      if (condensed%active .and. condensed%goes_on .and. all(before == tangent%dofs)) return
      if (allocated(tangent%status)) deallocate (tangent%status)
    end associate
  end subroutine place_elements

  !> Condenses anew the bodies of which contact has reached nodes that are not candidates.
  subroutine extend_candidates(system, form)
    type(system_t), intent(inout) :: system !! condensed may grow
    type(form_t), intent(inout) :: form !! gets condensed, matrix
    logical :: before(size(system%body%node_body)), wanted(system%body%bodies)
    real(wp), allocatable :: force(:, :), u(:)
    integer :: i, outcome

    associate (condensed => form%condensed)
      before = condensed%candidate
      call mark_touched(system, form%condensed)
      if (all(before .eqv. condensed%candidate)) return
      call add_ring(condensed%facets, condensed%candidate)
      call add_ring(condensed%facets, condensed%candidate)
      where (.not. any(system%equation > 0, 1)) condensed%candidate = .false.
      wanted = .false.
      do i = 1, size(before)
        if (before(i) .neqv. condensed%candidate(i)) wanted(system%body%node_body(i)) = .true.
      end do
      allocate (force(3, size(before)), source=0.0_wp)
      do i = 1, condensed%n
        force(condensed%direction(i), condensed%node(i)) = condensed%bulk%force(i)
      end do
      if (condensed%preconditions) then
        call condense_at_rest(system, form, wanted, outcome)
      else
        call condense_all(system, form, wanted, outcome)
      end if
      condensed%failed = outcome
      if (outcome /= solver_done) return
      call number_candidates(form%condensed)
      condensed%sums%known = .false.
      if (condensed%preconditions) return
      do i = 1, condensed%n
        condensed%bulk%force(i) = force(condensed%direction(i), condensed%node(i))
      end do
      call load_candidates(condensed)
      allocate (u(condensed%n))
      call find_equilibrium(condensed, u)
      call find_imbalance(condensed)
      do i = 1, condensed%n
        if (before(condensed%node(i))) then
          condensed%bulk%defect(i) = u(i) - system%u(condensed%direction(i), condensed%node(i))
        else
          system%u(condensed%direction(i), condensed%node(i)) = u(i)
        end if
      end do
    end associate
  end subroutine extend_candidates

  !> Displacements of all nodes from the forces of the iterate, and the forces of the bulk where
  !! supports want to know them.
  subroutine recover_interior(system, form)
    type(system_t), intent(inout) :: system !! u of candidates given; gets u, bulk_force
    type(form_t), intent(inout) :: form !! matrix given; gets condensed, du
    integer :: k

    associate (condensed => form%condensed)
      if (condensed%surface_only) call refresh_candidates(form, system%u)
      if (condensed%surface_only) return
      call spread_product(system, form, form%du)
      do k = 1, size(condensed%outer%factors)
        form%du = form%du + condensed%outer%factors(k)*condensed%outer%influence(:, :, k)
      end do
      call add_motion_inside(system, form%condensed, condensed%rigid%alpha, form%du)
      call refresh_candidates(form, system%u)
      where (system%equation > 0 .and. condensed%place == 0) system%u = form%du
      form%du = 0.0_wp
      call multiply_some(form%whole%bulk_matrix, any(system%equation == 0, 1), system%u, &
        form%inner%bulk_force)
    end associate
  end subroutine recover_interior

  !> Keeps the contact forces of the converged state.
  subroutine keep_forces(condensed)
    type(condensed_t), intent(inout) :: condensed !! force given; gets kept

    call spread_forces(condensed, condensed%outer%kept)
    if (allocated(condensed%outer%rubbed)) deallocate (condensed%outer%rubbed)
  end subroutine keep_forces

  !> The forces of the iterate as a nodal field.
  pure subroutine spread_forces(condensed, force)
    type(condensed_t), intent(in) :: condensed !! its candidates
    real(wp), intent(out) :: force(:, :) !! (3, nodes) [force]
    integer :: i

    force = 0.0_wp
    do i = 1, condensed%n
      force(condensed%direction(i), condensed%node(i)) = condensed%bulk%force(i)
    end do
  end subroutine spread_forces
end module condensed_system

!> The pattern of the coupled matrix: bulk and contact elements.
module contact_coupling
  use costs, only: begin_cost, end_cost, cost_pattern
  use element_types, only: routine_none, routine_mfec
  use model_types, only: model_t
  use contact_points, only: count_points, coupled_nodes
  use block_matrix, only: find_block
  use bulk_term, only: take_bulk_back
  use block_graph, only: build_graph, graph_holds, locate_elements
  use csc_matrix, only: csc_matrix_t, build_pattern
  use linear_solver, only: start_pattern
  use system_types, only: form_t, system_t
  use system_parts, only: whole_form_t
  implicit none
  private
  public :: couple_full, couple_full_as_saved

contains

  !> Makes sure that the pattern of the coupled matrix holds every contact element.
  subroutine couple_full(system, form)
    type(system_t), intent(inout) :: system !! matrix, csc and factor may start anew
    type(form_t), intent(inout) :: form !! gets matrix

    if (system%contact%n == 0) then
      form%whole%apart = stays_apart(system, form%whole)
      call fit_pattern(system, form)
      return
    end if
    if ((form%whole%apart .eqv. stays_apart(system, form%whole)) .and. &
      graph_holds(form%whole%matrix, system%contact)) then
      call fit_pattern(system, form)
    else
      call build_coupled(system, form)
      system%place%coupled_targets = system%place%targets
    end if
    call locate_elements(form%whole%matrix, system%contact)
  end subroutine couple_full

  !> The solver adds contact's share of the tangent to the bulk's: one that takes matrices by nodes,
  !! where nothing else changes the tangent (doc/theory, "Iterative solution in parallel").
  pure logical function stays_apart(system, whole) result(apart)
    type(system_t), intent(in) :: system !! the system
    type(whole_form_t), intent(in) :: whole !! matrix

    apart = whole%solver%by_nodes .and. system%bulk%linear .and. .not. any(system%body%floating) &
      .and. system%tools%unknowns == 0 .and. .not. allocated(system%loads%pressed)
  end function stays_apart

  !> Builds the pattern of the free equations if it is not there.
  subroutine fit_pattern(system, form)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets csc

    if (allocated(form%whole%csc%ptr) .neqv. form%whole%solver%by_nodes) return
    call begin_cost(form%costs, cost_pattern)
    call build_free(system, form)
    call end_cost(form%costs, cost_pattern)
  end subroutine fit_pattern

  !> Builds the pattern of the free equations anew; a solver that takes its matrix by nodes has
  !! none.
  subroutine build_free(system, form)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets csc

    associate (whole => form%whole)
      whole%csc = csc_matrix_t()
      whole%symmetric = .false.
      if (whole%solver%by_nodes) return
      if (system%contact%n > 0) then
        call build_pattern(whole%matrix, system%equation, whole%csc)
      else
        call build_pattern(whole%bulk_matrix, system%equation, whole%csc)
      end if
    end associate
  end subroutine build_free

  !> Builds the pattern of bulk and contact elements anew.
  subroutine build_coupled(system, form)
    type(system_t), intent(in) :: system !! contact elements
    type(form_t), intent(inout) :: form !! gets matrix, csc; the factor starts anew

    call begin_cost(form%costs, cost_pattern)
    form%whole%apart = stays_apart(system, form%whole)
    if (form%whole%apart) then
      if (allocated(form%whole%bulk_place)) deallocate (form%whole%bulk_place)
      call build_graph(form%whole%bulk_matrix%nodes, system%contact, form%whole%matrix)
    else
      call take_bulk_back(system%position%x_now - system%u, system, form)
      call build_graph(size(system%equation, 2), system%bulk, form%whole%matrix, &
        system%contact, system%volumes)
      call place_bulk(form%whole)
    end if
    call build_free(system, form)
    call start_pattern(form%whole%solver)
    call end_cost(form%costs, cost_pattern)
  end subroutine build_coupled

  !> Builds the pattern that a run had at a saved state, so that equations are eliminated in the
  !! same order and a restart gives the same numbers to the last digit.
  subroutine couple_full_as_saved(model, system, form, targets)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(inout) :: system !! gets contact, matrix, csc
    type(form_t), intent(inout) :: form !! gets matrix
    integer, intent(in) :: targets(:) !! (contact elements) facets when the pattern was built
    integer :: k, p, element

    if (system%contact%n == 0) return
    if (allocated(form%whole%matrix%ptr) .and. all(system%place%coupled_targets == targets)) return
    system%place%targets = targets
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        element = system%place%first_point(k) + p - 1
        system%contact%routine(element) = routine_none
        if (targets(element) == 0) cycle
        system%contact%routine(element) = routine_mfec
        associate (nodes => coupled_nodes(model%pairs(k), p, targets(element)))
          system%contact%nel(element) = size(nodes)
          system%contact%ix(:size(nodes), element) = nodes
        end associate
      end do
    end do
    call build_coupled(system, form)
    system%place%coupled_targets = targets
    call locate_elements(form%whole%matrix, system%contact)
  end subroutine couple_full_as_saved

  !> Where each block of the bulk's matrix stands in the coupled matrix.
  subroutine place_bulk(whole)
    type(whole_form_t), intent(inout) :: whole !! gets bulk_place
    integer :: j, k

    if (.not. allocated(whole%bulk_place)) then
      allocate (whole%bulk_place(size(whole%bulk_matrix%row)))
    end if
    do j = 1, whole%bulk_matrix%nodes
      do k = whole%bulk_matrix%ptr(j), whole%bulk_matrix%ptr(j + 1) - 1
        whole%bulk_place(k) = find_block(whole%matrix, whole%bulk_matrix%row(k), j)
      end do
    end do
  end subroutine place_bulk
end module contact_coupling

!> Builds the discrete system from a model: equations, element lists, the bulk's matrix.
module system_building
  use kinds, only: wp
  use element_lists, only: allocate_list, element_list_t
  use model_types, only: model_t
  use contact_points, only: count_points
  use bodies, only: find_bodies
  use facet_ratio, only: mean_facet
  use bulk_term, only: build_bulk
  use contact_overlap, only: measure_overlap
  use contact_targets, only: start_pair
  use follower_pressure, only: list_pressures
  use springs, only: start_springs
  use rigid_bodies, only: start_rigid
  use rigid_paths, only: count_rigid
  use supports, only: find_floating_bodies, floating_with_points
  use full_form, only: full_form_of_system
  use term_choice, only: terms_of_system
  use held_bodies, only: fix_held
  use system_types, only: form_t, system_t, state_t
  use cells, only: most_facet_nodes
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: build_system, outline_system, fill_system

contains

  !> Everything a run needs, at time 0.
  subroutine build_system(model, system, form, state)
    type(model_t), intent(inout) :: model !! pairs get their first targets
    type(system_t), intent(inout) :: system !! filled
    type(form_t), intent(inout) :: form !! filled; its costs go on counting
    type(state_t), intent(out) :: state !! at rest

    call outline_system(model, system, form, state)
    call fill_system(model, system, form)
  end subroutine build_system

  !> What needs the matrix of the bulk, after the outline.
  subroutine fill_system(model, system, form)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(inout) :: system !! its outline; filled
    type(form_t), intent(inout) :: form !! gets its kind, matrix

    form%kind = full_form_of_system()
    system%terms = terms_of_system()
    call list_contact(model, system%contact, system%place)
    system%scale%facet_size = mean_master(model)
    call build_bulk(model, system%u, system%loads, system%bulk, system%volumes, &
      system%scale%stiffest, form)
  end subroutine fill_system

  !> Bodies, equations, and the first targets of the contact points.
  subroutine outline_system(model, system, form, state)
    type(model_t), intent(inout) :: model !! pairs get their first targets
    type(system_t), intent(inout) :: system !! gets bodies, equations, vectors
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(out) :: state !! at rest
    integer, allocatable :: element_body(:)
    integer :: k

    call find_bodies(model%mesh, element_body, system%body%node_body, system%body%bodies)
    call number_equations(model%conditions%restrained, system%equation, system%equations)
    call fix_held(model, system%equation, system%body)
    if (allocated(system%body%fixed)) call number_equations(model%conditions%restrained .or. &
      system%body%fixed, system%equation, system%equations)
    call start_rigid(model, system%equations, system%body%node_body, system%tools)
    allocate (state%rigid(6, count_rigid(model)), source=0.0_wp)
    call start_springs(model, system%equation, system%loads)
    if (allocated(model%conditions%pressures)) then
      if (size(model%conditions%pressures) > 0) call list_pressures(model, system%loads)
    end if
    call find_floating_bodies(model%mesh%x, system%equation, system%loads, any( &
      model%pairs%mortar), system%body)
    system%body%floating = floating_with_points(model%mesh%x, system)
    call allocate_vectors(model%mesh%nodes, system, form, state)
    do k = 1, size(model%pairs)
      call start_pair(model%pairs(k), model%mesh%x)
      call measure_overlap(model%pairs(k), model%mesh%x)
    end do
  end subroutine outline_system

  !> Numbers the free degrees of freedom in the order of the nodes.
  subroutine number_equations(restrained, equation, equations)
    logical, intent(in) :: restrained(:, :) !! (3, nodes)
    integer, allocatable, intent(out) :: equation(:, :) !! (3, nodes) number, 0 where restrained
    integer, intent(out) :: equations !! how many
    integer :: node, i

    allocate (equation(3, size(restrained, 2)), source=0)
    equations = 0
    do node = 1, size(restrained, 2)
      do i = 1, 3
        if (restrained(i, node)) cycle
        equations = equations + 1
        equation(i, node) = equations
      end do
    end do
  end subroutine number_equations

  !> Mean size of the master facets of all pairs.
  pure real(wp) function mean_master(model) result(h)
    type(model_t), intent(in) :: model !! pairs
    integer :: k

    h = 0.0_wp
    do k = 1, size(model%pairs)
      h = h + mean_facet(model%pairs(k), model%mesh%x)
    end do
    h = h/real(max(1, size(model%pairs)), wp)
  end function mean_master

  !> Vectors of the solution.
  subroutine allocate_vectors(nodes, system, form, state)
    integer, intent(in) :: nodes !! number of nodes
    type(system_t), intent(inout) :: system !! gets its vectors
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! gets its vectors

    allocate (system%u(3, nodes), form%du(3, nodes), form%trial(3, nodes), &
      system%loads%external(3, nodes), form%inner%bulk_force(3, nodes), form%bulk_change(3, &
      nodes), system%contact_force(3, nodes), system%position%left(3, nodes), &
      system%position%carried(3, nodes), system%position%x_old(3, nodes), system%position%x_now(3, &
      nodes), system%position%x_ahead(3, nodes), source=0.0_wp)
    allocate (form%right(system%equations + system%tools%unknowns), source=0.0_wp)
    allocate (form%solution, form%next, source=form%right)
    allocate (state%u(3, nodes), state%reaction(3, nodes), source=0.0_wp)
  end subroutine allocate_vectors

  !> One contact element for each point; they stay idle until targets are chosen.
  subroutine list_contact(model, contact, place)
    type(model_t), intent(in) :: model !! the model
    type(element_list_t), intent(inout) :: contact !! gets contact elements that take no part
    type(contact_places_t), intent(inout) :: place !! gets first_point
    integer :: k, n, slaves, masters

    allocate (place%first_point(size(model%pairs) + 1))
    n = 0
    slaves = 1
    masters = 3
    do k = 1, size(model%pairs)
      slaves = max(slaves, model%pairs(k)%points%n_slaves)
      if (allocated(model%pairs(k)%surface%middles)) masters = most_facet_nodes
      place%first_point(k) = n + 1
      n = n + count_points(model%pairs(k))
    end do
    place%first_point(size(model%pairs) + 1) = n + 1
    call allocate_list(contact, n, slaves + masters)
    allocate (place%targets(n), place%coupled_targets(n), source=0)
    do k = 1, size(model%pairs)
      associate (first => place%first_point(k), last => place%first_point(k + 1) - 1)
        contact%slaves(first:last) = model%pairs(k)%points%n_slaves
        contact%nel(first:last) = model%pairs(k)%points%n_slaves + 3
      end associate
    end do
  end subroutine list_contact
end module system_building

!> The bulk as a term of the residual: its elements, and its forces and tangent at any state
!! (doc/theory, "Four-node tetrahedron", "Finite strain").
module bulk_term
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_bulk_tangent, cost_pattern
  use cells, only: nodes_of, tet4
  use solid_types, only: d_youngs_modulus, d_poissons_ratio, d_mean, d_own
  use bulk_laws, only: laws, point_law
  use bulk_memory, only: memory_shape
  use element_lists, only: allocate_bulk, bulk_list_t, volume_list_t
  use element_types, only: routine_t4, routine_small, routine_finite
  use model_types, only: model_t
  use block_matrix, only: block_matrix_t, sum_absolute
  use block_graph, only: build_graph, locate_elements
  use bulk_products, only: multiply_bulk
  use bulk_assembly, only: assemble_bulk, find_bulk_reach
  use nodal_dilatation, only: list_volumes, add_volume_forces, add_volume_tangent
  use follower_pressure, only: add_pressure_force, add_pressure_tangent
  use springs, only: add_springs, add_spring_forces
  use system_types, only: form_t, system_t
  use system_parts, only: bulk_answer_t, outer_t
  implicit none
  private
  public :: build_bulk, take_bulk_back, form_solid_tangent, start_bulk, return_bulk, &
    form_bulk_force, form_bulk_trial, form_bulk_tangent, form_bulk_change, bulk_step, jumps_little

  !> A step ends at this share of the way to where an element would be turned inside out.
  real(wp), parameter :: safe_share = 0.9_wp
  !> A jump is small if so many times its length would turn no element inside out.
  real(wp), parameter :: small_jump = 10.0_wp

contains

  !> Elements, graph and first tangent; nothing else is formed in a run whose bulk is linear.
  subroutine build_bulk(model, u, loads, bulk, volumes, stiffest, form)
    type(model_t), intent(in) :: model !! the problem
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(outer_t), intent(in) :: loads !! loads and springs
    type(bulk_list_t), intent(inout) :: bulk !! gets bulk elements
    type(volume_list_t), intent(inout) :: volumes !! gets volumes of nodes
    real(wp), intent(inout) :: stiffest !! gets the largest entry of the matrix [force/length]
    type(form_t), intent(inout) :: form !! gets bulk_matrix, bulk_force, rows

    call list_bulk(model, bulk)
    call list_volumes(model, volumes)
    call begin_cost(form%costs, cost_pattern)
    call build_graph(model%mesh%nodes, bulk, form%whole%bulk_matrix, third=volumes)
    if (.not. bulk%linear) call locate_elements(form%whole%bulk_matrix, bulk)
    call end_cost(form%costs, cost_pattern)
    form%inner%bulk_force = 0.0_wp
    call add_tangent_at(model%mesh%x, u, bulk, volumes, loads, form)
    if (.not. bulk%linear) then
      allocate (form%inner%rows(3, 3, model%mesh%nodes))
      call sum_absolute(form%whole%bulk_matrix, form%inner%rows)
    end if
    if (size(form%whole%bulk_matrix%val) > 0) stiffest = &
      maxval(abs(form%whole%bulk_matrix%val))
  end subroutine build_bulk

  !> Forms the values anew that have been given to a solver.
  subroutine take_bulk_back(x, system, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! bulk_matrix has values again
    type(form_t), intent(inout) :: form !! gets matrix

    if (.not. form%whole%given) return
    form%whole%given = .false.
    form%whole%restrained = block_matrix_t()
    allocate (form%whole%bulk_matrix%val(3, 3, size(form%whole%bulk_matrix%row)))
    call form_solid_tangent(x, system%u, system, form)
  end subroutine take_bulk_back

  !> Lists the elements; those of rigid materials take no part.
  subroutine list_bulk(model, bulk)
    type(model_t), intent(in) :: model !! the model
    type(bulk_list_t), intent(inout) :: bulk !! gets bulk
    integer :: k, m, most, nodes, shape(3)

    most = tet4%nodes
    do k = 1, model%mesh%elements
      most = max(most, nodes_of(model%mesh%ix(:, k)))
    end do
    call allocate_bulk(bulk, model%mesh%elements, size(model%materials), most)
    do m = 1, size(model%materials)
      associate (material => model%materials(m))
        bulk%d(d_youngs_modulus, m) = material%youngs_modulus
        bulk%d(d_poissons_ratio, m) = material%poissons_ratio
        bulk%law(m) = point_law(material%law)
        bulk%d(d_own:, m) = material%own
        bulk%d(d_mean, m) = merge(1.0_wp, 0.0_wp, material%mean)
        if (.not. material%nodal) cycle
        ! the same shear modulus without a volumetric part, which nodal_dilatation adds
        bulk%d(d_youngs_modulus, m) = material%youngs_modulus/(1.0_wp + material%poissons_ratio)
        bulk%d(d_poissons_ratio, m) = 0.0_wp
      end associate
    end do
    do k = 1, model%mesh%elements
      m = model%element_material(k)
      if (m == 0) cycle
      nodes = nodes_of(model%mesh%ix(:, k))
      bulk%set(k) = m
      bulk%nel(k) = nodes
      bulk%ix(:nodes, k) = model%mesh%ix(:nodes, k)
      if (model%materials(m)%rigid) cycle
      bulk%routine(k) = kinematics(nodes, laws(model%materials(m)%law)%linear)
      if (bulk%routine(k) == routine_finite) bulk%linear = .false.
    end do
    shape = memory_shape(model)
    if (shape(1) > 0) allocate (bulk%memory(shape(1), shape(2), shape(3)), source=0.0_wp)
  end subroutine list_bulk

  !> The element routine of a shape under a law.
  pure integer function kinematics(nodes, linear) result(routine)
    integer, intent(in) :: nodes !! nodes of the element
    logical, intent(in) :: linear !! the law is

    routine = routine_small
    if (nodes == tet4%nodes) routine = routine_t4
    if (.not. linear) routine = routine_finite
  end function kinematics

  !> Tangent and force at a state.
  subroutine form_tangent_at(x, u, bulk, volumes, loads, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(outer_t), intent(in) :: loads !! loads and springs
    type(form_t), intent(inout) :: form !! gets matrix, bulk_force

    form%whole%bulk_matrix%val = 0.0_wp
    form%inner%bulk_force = 0.0_wp
    call add_tangent_at(x, u, bulk, volumes, loads, form)
  end subroutine form_tangent_at

  !> Tangent and force at a state, added to what is there.
  subroutine add_tangent_at(x, u, bulk, volumes, loads, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(outer_t), intent(in) :: loads !! loads and springs
    type(form_t), intent(inout) :: form !! gets matrix, bulk_force

    call begin_cost(form%costs, cost_bulk_tangent)
    call assemble_bulk(bulk, x, u, form%inner%bulk_force, form%inner%bulk_energy, &
      form%inner%inverted, form%whole%bulk_matrix)
    if (form%inner%inverted == 0) then
      call add_volume_forces(x, u, bulk, volumes, form%inner)
      call add_volume_tangent(x, u, bulk, volumes, form%whole)
    end if
    call add_springs(loads, form%whole)
    call add_spring_forces(u, loads, form%inner)
    call add_pressure_tangent(x, u, loads, form%whole)
    call add_pressure_force(x, u, -1.0_wp, loads, form%inner%bulk_force)
    call end_cost(form%costs, cost_bulk_tangent)
  end subroutine add_tangent_at

  !> Tangent of elements, volumes and springs alone at a state, which is symmetric.
  subroutine form_solid_tangent(x, u, system, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets bulk_matrix
    real(wp) :: force(3, size(x, 2)), energy
    integer :: inverted

    call begin_cost(form%costs, cost_bulk_tangent)
    force = 0.0_wp
    form%whole%bulk_matrix%val = 0.0_wp
    call assemble_bulk(system%bulk, x, u, force, energy, inverted, form%whole%bulk_matrix)
    if (inverted == 0) call add_volume_tangent(x, u, system%bulk, system%volumes, form%whole)
    call add_springs(system%loads, form%whole)
    call end_cost(form%costs, cost_bulk_tangent)
  end subroutine form_solid_tangent

  !> Start of an increment. Factors that precede an iteration are near to begin with.
  subroutine start_bulk(u, bulk, form)
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the last state [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(form_t), intent(inout) :: form !! gets its kind, u_start, linearised

    if (bulk%linear) return
    form%inner%u_start = u
    form%inner%linearised = .false.
    form%kind%near = form%kind%inexact
  end subroutine start_bulk

  !> To the start of the increment, or back there: what is prescribed jumps, and may turn elements
  !! next to it inside out. So the bulk answers the jump by its tangent at the last state until a
  !! first step has been taken; where factors are near it answers as it is.
  subroutine return_bulk(x, bulk, volumes, loads, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(outer_t), intent(in) :: loads !! loads and springs
    type(form_t), intent(inout) :: form !! its kind given; gets matrix, bulk_start, linearised
    real(wp) :: u_start(3, size(x, 2))

    if (bulk%linear .or. form%inner%linearised .or. form%kind%near) return
    u_start = form%inner%u_start
    call form_tangent_at(x, u_start, bulk, volumes, loads, form)
    form%inner%bulk_start = form%inner%bulk_force
    form%inner%linearised = .true.
  end subroutine return_bulk

  !> The start that has been chosen strains the bulk little, so that it can answer as it is.
  logical function jumps_little(x, system, inner) result(little)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! u
    type(bulk_answer_t), intent(in) :: inner !! u_start
    real(wp) :: reach
    integer :: worst

    call find_bulk_reach(system%bulk, x, inner%u_start, small_jump*(system%u - inner%u_start), &
      reach, worst)
    little = reach >= huge(1.0_wp)
  end function jumps_little

  !> Internal force at u.
  subroutine form_bulk_force(x, system, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! u, bulk elements
    type(form_t), intent(inout) :: form !! gets bulk_force

    if (system%bulk%linear) then
      call multiply_bulk(system%equation, form%whole, system%u, form%inner%bulk_force)
    else if (form%inner%linearised) then
      call multiply_bulk(system%equation, form%whole, system%u - form%inner%u_start, &
        form%inner%bulk_force)
      form%inner%bulk_force = form%inner%bulk_force + form%inner%bulk_start
    else
      call form_force_at(x, system%u, system%bulk, system%volumes, system%loads, form%inner)
    end if
  end subroutine form_bulk_force

  !> Internal force at a trial; that of a linear bulk follows from bulk_change, unless nodes turn
  !! with rigid bodies.
  subroutine form_bulk_trial(x, system, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! bulk elements
    type(form_t), intent(inout) :: form !! trial given; gets bulk_force if it is not linear in the
    !! share of the step

    if (.not. system%bulk%linear) then
      call form_force_at(x, form%trial, system%bulk, system%volumes, system%loads, form%inner)
    else if (system%tools%unknowns > 0) then
      call multiply_bulk(system%equation, form%whole, form%trial, form%inner%bulk_force)
    end if
  end subroutine form_bulk_trial

  !> Internal force at a state.
  subroutine form_force_at(x, u, bulk, volumes, loads, inner)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(outer_t), intent(in) :: loads !! loads and springs
    type(bulk_answer_t), intent(inout) :: inner !! the bulk's answer; gets bulk_force, bulk_energy,
    !! inverted

    inner%bulk_force = 0.0_wp
    call assemble_bulk(bulk, x, u, inner%bulk_force, inner%bulk_energy, inner%inverted)
    if (inner%inverted == 0) call add_volume_forces(x, u, bulk, volumes, inner)
    call add_spring_forces(u, loads, inner)
    call add_pressure_force(x, u, -1.0_wp, loads, inner%bulk_force)
  end subroutine form_force_at

  !> Tangent at u; that of a linear bulk never changes.
  subroutine form_bulk_tangent(x, system, form)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! u, bulk elements
    type(form_t), intent(inout) :: form !! gets bulk_matrix, bulk_force

    if (system%bulk%linear .or. form%inner%linearised) return
    call form_tangent_at(x, system%u, system%bulk, system%volumes, system%loads, form)
  end subroutine form_bulk_tangent

  !> What a linear bulk answers to a direction.
  subroutine form_bulk_change(system, form)
    type(system_t), intent(in) :: system !! du given
    type(form_t), intent(inout) :: form !! gets bulk_change

    if (system%bulk%linear .and. system%tools%unknowns == 0) call multiply_bulk(system%equation, &
      form%whole, form%du, form%bulk_change)
  end subroutine form_bulk_change

  !> Share of the direction that no element is turned inside out by. The first step of an increment
  !! starts from the last state and is taken as a whole or not at all.
  subroutine bulk_step(x, bulk, u, inner, du, share)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(bulk_answer_t), intent(inout) :: inner !! the bulk's answer; gets inverted if the share is
    !! short
    real(wp), intent(in) :: du(:, :) !! (3, nodes) direction [length]
    real(wp), intent(out) :: share !! at most 1; 0: the first step cannot be taken
    real(wp) :: reach
    integer :: worst

    share = 1.0_wp
    if (bulk%linear) return
    inner%inverted = 0
    if (inner%linearised) then
      call find_bulk_reach(bulk, x, inner%u_start, u + du - inner%u_start, reach, worst)
      if (safe_share*reach < 1.0_wp) share = 0.0_wp
    else
      call find_bulk_reach(bulk, x, u, du, reach, worst)
      share = min(1.0_wp, safe_share*reach)
    end if
    if (share <= 0.0_wp .or. reach < huge(1.0_wp)) inner%inverted = worst
  end subroutine bulk_step
end module bulk_term

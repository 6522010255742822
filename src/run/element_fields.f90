!> Stresses and strains of the elements at an end time, a few elements at a time: of their states
!! only what is wanted is kept. Those of the nodes are recovered from them.
module element_fields
  use kinds, only: wp
  use solid_types, only: n_solid_state, n_sample, state_stress, state_strain, d_mean
  use element_types, only: routine_none
  use mesh_types, only: mesh_t
  use recovery, only: recovery_t, prepare_recovery, recover_at_nodes
  use system_types, only: system_t, state_t
  use element_lists, only: bulk_list_t
  use audit_types, only: audit_t
  use model_types, only: model_t
  use body_fields, only: fields_of_bodies, n_body_fields
  use results_file, only: fields_due
  use ranks, only: this_rank
  use bulk_assembly, only: recover_bulk, recover_points
  use nodal_dilatation, only: add_nodal_pressure
  use field_audit, only: audit_fields
  implicit none
  private
  public :: nodal_fields_t, recover_fields, find_element_fields, find_nodal_fields

  !> Elements at a time.
  integer, parameter :: portion = 4096

  !> Stress and strain at the nodes, and what they are made of.
  type :: nodal_fields_t
    real(wp), allocatable :: values(:, :) !! (6 or 12, nodes) stress and strain, if they are due
    real(wp), allocatable :: points(:, :) !! (6 or n_sample, samples) stress and strain
    real(wp), allocatable :: even(:, :) !! (2, elements) what is even in these, with MEAN
    type(recovery_t), allocatable :: way !! from samples to nodes, once it has been asked for
    type(recovery_t), allocatable :: even_way !! from elements to nodes, with MEAN on ten nodes
  end type nodal_fields_t

contains

  !> Fields of the elements where they are due, for the audit at the last end time, too.
  subroutine recover_fields(model, system, state, last, stress, strain, nodal, audit)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! elements
    type(state_t), intent(in) :: state !! the converged state
    logical, intent(in) :: last !! it is the last end time
    real(wp), allocatable, intent(inout) :: stress(:, :) !! (6, elements) if it is to be written
    real(wp), allocatable, intent(inout) :: strain(:, :) !! (6, elements) likewise
    type(nodal_fields_t), intent(inout) :: nodal !! at nodes, likewise
    type(audit_t), intent(inout) :: audit !! looks at them
    logical :: due(n_body_fields), wanted

    due = model%output%field .and. fields_of_bodies%of_elements .and. &
      fields_due(model%output, state%step)
    if (.not. (any(due) .or. last)) return
    if (allocated(stress)) deallocate (stress)
    if (allocated(strain)) deallocate (strain)
    if (allocated(nodal%values)) deallocate (nodal%values)
    if (this_rank() > 0) due = .false.
    if (any(due)) allocate (stress(6, system%bulk%n))
    if (any(due .and. fields_of_bodies%word == 'strain')) allocate (strain(6, system%bulk%n))
    wanted = any(due .and. fields_of_bodies%at_nodes)
    if (wanted) call make_way(model%mesh, system%bulk, nodal)
    if (wanted .and. allocated(nodal%even)) then
      call find_element_fields(system, model%mesh%x, state%u, stress, strain, audit, nodal)
    else
      call find_element_fields(system, model%mesh%x, state%u, stress, strain, audit)
    end if
    if (wanted) call fill_nodes(model%mesh, system%bulk, stress, strain, nodal)
  end subroutine recover_fields

  !> Stress at all nodes, for who wants it once.
  subroutine find_nodal_fields(mesh, system, u, nodal)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(system_t), intent(in) :: system !! elements
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(nodal_fields_t), intent(out) :: nodal !! gets them
    real(wp), allocatable :: stress(:, :), strain(:, :)

    allocate (stress(6, system%bulk%n))
    call make_way(mesh, system%bulk, nodal)
    if (allocated(nodal%even)) then
      call find_element_fields(system, mesh%x, u, stress, strain, nodal=nodal)
    else
      call find_element_fields(system, mesh%x, u, stress)
    end if
    call fill_nodes(mesh, system%bulk, stress, strain, nodal)
  end subroutine find_nodal_fields

  !> The way from elements to nodes, which does not change in a run.
  subroutine make_way(mesh, bulk, nodal)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(nodal_fields_t), intent(inout) :: nodal !! gets way, points

    if (allocated(nodal%way)) return
    allocate (nodal%way)
    call prepare_recovery(nodal%way, mesh, bulk, .false.)
    if (.not. any(bulk%nel > 4 .and. bulk%routine /= routine_none)) return
    allocate (nodal%points(n_sample, size(nodal%way%place, 2)))
    allocate (nodal%even(2, bulk%n), source=0.0_wp)
    if (.not. any(bulk%d(d_mean, :) > 0.0_wp)) return
    allocate (nodal%even_way)
    call prepare_recovery(nodal%even_way, mesh, bulk, .true.)
  end subroutine make_way

  !> Stress, and strain if that of the elements is there, at the nodes.
  subroutine fill_nodes(mesh, bulk, stress, strain, nodal)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    real(wp), allocatable, intent(in) :: stress(:, :) !! (6, elements)
    real(wp), allocatable, intent(in) :: strain(:, :) !! (6, elements) if it is wanted
    type(nodal_fields_t), intent(inout) :: nodal !! gets values
    real(wp) :: even(2, mesh%nodes)
    integer :: e, k, n

    n = merge(n_sample, 6, allocated(strain))
    allocate (nodal%values(n, mesh%nodes))
    if (.not. allocated(nodal%points)) allocate (nodal%points(n, size(nodal%way%place, 2)))
    do e = 1, bulk%n
      k = nodal%way%first(e)
      if (nodal%way%first(e + 1) /= k + 1) cycle
      nodal%points(:6, k) = stress(:, e)
      if (allocated(strain)) nodal%points(7:, k) = strain(:, e)
    end do
    call recover_at_nodes(nodal%way, mesh, nodal%points(:n, :), nodal%values)
    if (.not. allocated(nodal%even_way)) return
    call recover_at_nodes(nodal%even_way, mesh, nodal%even, even)
    do k = 1, 3
      nodal%values(k, :) = nodal%values(k, :) + even(1, :)
      if (n > 6) nodal%values(6 + k, :) = nodal%values(6 + k, :) + even(2, :)
    end do
  end subroutine fill_nodes
  !> What is asked for, of all elements; their strains and rotations to the audit.
  subroutine find_element_fields(system, x, u, stress, strain, audit, nodal)
    type(system_t), intent(in) :: system !! elements
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), allocatable, intent(inout), optional :: stress(:, :) !! (6, elements) if allocated
    real(wp), allocatable, intent(inout), optional :: strain(:, :) !! (6, elements) if allocated
    type(audit_t), intent(inout), optional :: audit !! gets values, worst, verdicts
    type(nodal_fields_t), intent(inout), optional :: nodal !! gets points, even of ten nodes
    real(wp) :: state(n_solid_state, min(portion, system%bulk%n))
    integer :: first, last

    do first = 1, system%bulk%n, portion
      last = min(first + portion - 1, system%bulk%n)
      associate (some => state(:, :last - first + 1))
        if (present(nodal)) then
          call recover_points(system%bulk, x, u, first, some, nodal%way%first, nodal%points, &
            nodal%even)
        else
          call recover_bulk(system%bulk, x, u, first, some)
        end if
        if (present(audit)) call audit_fields(system%bulk, first, some, audit)
        if (is_wanted(stress)) stress(:, first:last) = some(state_stress, :)
        if (is_wanted(strain)) strain(:, first:last) = some(state_strain, :)
      end associate
    end do
    if (is_wanted(stress)) call add_nodal_pressure(x, u, system, stress)
  end subroutine find_element_fields

  !> A field is there to be filled.
  pure logical function is_wanted(field)
    real(wp), allocatable, intent(in), optional :: field(:, :) !! (components, elements)

    is_wanted = .false.
    if (present(field)) is_wanted = allocated(field)
  end function is_wanted
end module element_fields

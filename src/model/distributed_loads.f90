!> Reads loads that are spread over volumes and surfaces: GRAVity, TRACtion, PRESsure. They become
!! dead nodal forces on the reference shape (doc/theory, "Loads"), but pressures on regions of
!! finite strain: these follow.
module distributed_loads
  use kinds, only: wp
  use text, only: to_text, in_quotes
  use deck_types, only: deck_t, record_t, location_t, item_number
  use records, only: item_count, item_integer, item_location, item_name, item_real
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_names, only: find_region, find_set, find_surface, in_region
  use node_queries, only: report_unknown_name, report_no_region
  use bulk_laws, only: laws
  use model_types, only: model_t, pressure_t
  use loads, only: add_values, has_load, join_load
  use cells, only: facet_of, most_facet_nodes
  use consistent_loads, only: cell_volumes, facet_loads
  implicit none
  private
  public :: read_distributed_loads, check_load_table

contains

  !> Adds them to the conditions, which have been read.
  subroutine read_distributed_loads(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! mesh, materials, tables read; its loads grow
    integer :: i, k

    allocate (model%conditions%pressures(0))
    do i = 1, size(deck%mesh)
      associate (set => deck%mesh(i))
        select case (set%command)
        case ('grav')
          if (item_count(set%head) > 1) call read_gravity(set%head, 1, diagnostics, model)
          do k = 1, set%count
            call read_gravity(set%records(k), 0, diagnostics, model)
          end do
        case ('trac', 'pres')
          do k = 1, set%count
            call read_surface_load(set%records(k), set%command == 'pres', diagnostics, model)
          end do
        end select
      end associate
    end do
  end subroutine read_distributed_loads

  !> The number behind a load must be 0 or that of a table.
  subroutine check_load_table(model, record, k, diagnostics, table, good)
    type(model_t), intent(in) :: model !! its tables
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: k !! item of the number, which may be missing
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer, intent(out) :: table !! the number, 0 if it is missing
    logical, intent(out) :: good !! there is such a table

    table = 0
    good = .true.
    if (item_count(record) < k) return
    if (record%items(k)%kind /= item_number) return
    table = item_integer(record, k)
    good = has_load(model%tables, table)
    if (.not. good) call report_error(diagnostics, item_location(record, k), &
      'proportional load '//to_text(table)//' has no table', 'define it with PROPortional '// &
      to_text(table)//', or write 0 for the sum of all tables')
  end subroutine check_load_table

  !> `gx gy gz [n] [IN region]` behind `before` other items.
  subroutine read_gravity(record, before, diagnostics, model)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: before !! items before the acceleration
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! its loads grow
    real(wp) :: g(3), force(3, model%mesh%nodes), mass
    logical :: chosen(model%mesh%elements), good
    integer :: table, e, k, n

    call check_load_table(model, record, before + 4, diagnostics, table, good)
    if (good) call choose_cells(record, diagnostics, model, chosen, good)
    if (good) call check_density(record%at, chosen, diagnostics, model, good)
    if (.not. good) return
    g = [(item_real(record, before + k), k=1, 3)]
    force = 0.0_wp
    mass = 0.0_wp
    do e = 1, model%mesh%elements
      if (.not. chosen(e)) cycle
      n = count(model%mesh%ix(:, e) > 0)
      associate (nodes => model%mesh%ix(:n, e))
        associate (share => model%materials(model%element_material(e))%density* &
          cell_volumes(model%mesh%x(:, nodes)))
          mass = mass + sum(share)
          do k = 1, n
            force(:, nodes(k)) = force(:, nodes(k)) + share(k)*g
          end do
        end associate
      end associate
    end do
    call take_forces(force, table, model)
    call report_note(diagnostics, record%at, 'gravity on a mass of '//to_text(mass, 6)// &
      ', force '//vector_text(sum(force, 2)))
  end subroutine read_gravity

  !> Cells of the region behind IN, else all.
  subroutine choose_cells(record, diagnostics, model, chosen, good)
    type(record_t), intent(in) :: record !! a record of GRAVity
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the mesh
    logical, intent(out) :: chosen(:) !! (elements)
    logical, intent(out) :: good !! there is such a region
    integer :: index, last

    last = item_count(record)
    good = .true.
    if (record%items(last)%kind == item_number) then
      chosen = model%element_material > 0
      return
    end if
    call find_region(model%mesh, item_name(record, last), index)
    good = index > 0
    if (good) then
      chosen = in_region(model%mesh, index) .and. model%element_material > 0
    else
      chosen = .false.
      call report_no_region(model%mesh, item_location(record, last), item_name(record, last), &
        diagnostics)
    end if
  end subroutine choose_cells

  !> Each material that is to have a weight must say its density: one error for each that does not.
  subroutine check_density(at, chosen, diagnostics, model, good)
    type(location_t), intent(in) :: at !! where GRAVity stands
    logical, intent(in) :: chosen(:) !! (elements) those with weight
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the materials
    logical, intent(out) :: good !! all have one
    integer :: m

    good = .true.
    do m = 1, size(model%materials)
      if (model%materials(m)%has_density) cycle
      if (.not. any(chosen .and. model%element_material == m)) cycle
      good = .false.
      call report_error(diagnostics, at, 'material '//to_text(model%materials(m)%number)// &
        ' has no density', 'write DENSity rho into MATErial '// &
        to_text(model%materials(m)%number)//' (0 for no weight), or name a region behind IN')
    end do
  end subroutine check_density

  !> `face tx ty tz [n]` of TRACtion or `face p [n]` of PRESsure.
  subroutine read_surface_load(record, pressure, diagnostics, model)
    type(record_t), intent(in) :: record !! the record
    logical, intent(in) :: pressure !! of PRESsure
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! its loads grow
    real(wp) :: t(3), force(3, model%mesh%nodes), area, areas(most_facet_nodes), &
      normals(3, most_facet_nodes)
    integer :: nodes(most_facet_nodes), table, surface, f, k, n
    logical :: good

    call check_load_table(model, record, merge(3, 5, pressure), diagnostics, table, good)
    call find_loaded_surface(model, record, diagnostics, surface)
    if (surface == 0 .or. .not. good) return
    if (pressure .and. is_finite(model, surface)) then
      model%conditions%pressures = [model%conditions%pressures, pressure_t(surface, table, &
        item_real(record, 2))]
      return
    end if
    t = [(item_real(record, 1 + k), k=1, 3)]
    force = 0.0_wp
    area = 0.0_wp
    associate (faces => model%mesh%surfaces(surface))
      do f = 1, size(faces%facets, 2)
        nodes = facet_of(model%mesh%ix(:, faces%elements(f)), faces%facets(:, f))
        n = count(nodes > 0)
        call facet_loads(model%mesh%x(:, nodes(:n)), areas(:n), normals(:, :n))
        area = area + sum(areas(:n))
        do k = 1, n
          if (pressure) force(:, nodes(k)) = force(:, nodes(k)) - t(1)*normals(:, k)
          if (.not. pressure) force(:, nodes(k)) = force(:, nodes(k)) + t*areas(k)
        end do
      end do
    end associate
    call take_forces(force, table, model)
    call report_note(diagnostics, record%at, trim(merge('pressure', 'traction', pressure))// &
      ' on an area of '//to_text(area, 6)//', force '//vector_text(sum(force, 2)))
  end subroutine read_surface_load

  !> The surface that the first item names; an error if it names none.
  subroutine find_loaded_surface(model, record, diagnostics, surface)
    type(model_t), intent(in) :: model !! the mesh
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer, intent(out) :: surface !! its index, 0 if there is none
    integer :: i

    call find_surface(model%mesh, item_name(record, 1), surface)
    if (surface > 0) then
      if (.not. model%mesh%surfaces(surface)%alone) return
      surface = 0
      call report_error(diagnostics, item_location(record, 1), item_name(record, 1)// &
        ' has no elements behind it that could take a load', 'load the point of its RIGId')
      return
    end if
    call find_region(model%mesh, item_name(record, 1), i)
    if (i == 0) call find_set(model%mesh, item_name(record, 1), i)
    if (i == 0) then
      call report_unknown_name(model%mesh, item_location(record, 1), item_name(record, 1), &
        diagnostics)
    else
      call report_error(diagnostics, item_location(record, 1), item_name(record, 1)// &
        ' is no surface: loads per area want facets', 'write SURFace name FROM '// &
        in_quotes(item_name(record, 1))//', and its name here')
    end if
  end subroutine find_loaded_surface

  !> Some element behind a surface has a law of finite strain.
  pure logical function is_finite(model, surface) result(yes)
    type(model_t), intent(in) :: model !! mesh and materials
    integer, intent(in) :: surface !! index of the surface
    integer :: f, m

    yes = .false.
    associate (elements => model%mesh%surfaces(surface)%elements)
      do f = 1, size(elements)
        m = model%element_material(elements(f))
        if (m == 0) cycle
        yes = yes .or. (laws(model%materials(m)%law)%finite .and. .not. model%materials(m)%rigid)
      end do
    end associate
  end function is_finite

  !> Adds nodal forces to the load of a table.
  subroutine take_forces(force, table, model)
    real(wp), intent(in) :: force(:, :) !! (3, nodes) factor 1 [force]
    integer, intent(in) :: table !! number of the table
    type(model_t), intent(inout) :: model !! its loads grow
    integer :: i, place

    call join_load(model%conditions%loads, table, place)
    do i = 1, size(force, 2)
      call add_values(model%conditions%loads(place)%force, i, force(:, i))
    end do
  end subroutine take_forces

  !> A vector for a note.
  function vector_text(v) result(t)
    real(wp), intent(in) :: v(3) !! the vector
    character(:), allocatable :: t
    real(wp) :: shown(3)
    integer :: k

    shown = v
    where (abs(v) <= 1.0e-12_wp*norm2(v)) shown = 0.0_wp
    t = to_text(shown(1), 6)
    do k = 2, 3
      t = t//' '//to_text(shown(k), 6)
    end do
  end function vector_text
end module distributed_loads

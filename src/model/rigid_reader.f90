!> Reads RIGId: rigid bodies with a point. What is prescribed becomes loads of their nodes, what is
!! free is left to the solution (doc/theory, "Rigid bodies").
module rigid_reader
  use kinds, only: wp, pi
  use text, only: to_text
  use vectors, only: cross
  use deck_types, only: deck_t, data_set_t, record_t
  use records, only: item_count, item_location, item_name, item_real, is_word
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use mesh_names, only: find_region, find_surface, region_nodes, surface_nodes, &
    in_region
  use node_queries, only: report_no_region
  use model_types, only: model_t, rigid_body_t, point_load_t
  use condition_draft, only: condition_draft_t
  use loads, only: add_values, join_load
  use distributed_loads, only: check_load_table
  use rotations_reader, only: add_turn, check_turned, largest_angle
  implicit none
  private
  public :: read_rigid

contains

  !> Reads all data sets; nodes of the bodies become restrained.
  subroutine read_rigid(deck, model, diagnostics, draft, bodies)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(in) :: model !! mesh, materials, tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! other conditions; gets restraints and loads
    type(rigid_body_t), allocatable, intent(out) :: bodies(:) !! the bodies
    integer :: owner(model%mesh%nodes), i, n

    allocate (bodies(count(deck%mesh%command == 'rigi')))
    owner = 0
    n = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'rigi') cycle
      n = n + 1
      associate (set => deck%mesh(i), body => bodies(n))
        allocate (body%motions(0), body%loads(0), body%nodes(0))
        body%at = item_location(set%head, 2)
        body%name = item_name(set%head, min(3, item_count(set%head)))
        call find_nodes(set, model, draft, diagnostics, body)
        if (size(body%nodes) == 0) cycle
        call check_owner(set, n, bodies, owner, diagnostics)
        call read_records(set, model, diagnostics, body)
        owner(body%nodes) = n
        call prescribe(model, owner, n, body, diagnostics, draft)
      end associate
    end do
    do i = 1, size(owner)
      if (owner(i) > 0) draft%restrained(:, i) = .true.
    end do
  end subroutine read_rigid

  !> Nodes and centroid of the region.
  subroutine find_nodes(set, model, draft, diagnostics, body)
    type(data_set_t), intent(in) :: set !! the data set
    type(model_t), intent(in) :: model !! mesh, materials
    type(condition_draft_t), intent(in) :: draft !! other conditions
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(rigid_body_t), intent(inout) :: body !! gets nodes, point
    integer, allocatable :: nodes(:)
    logical, allocatable :: mine(:)
    integer :: index, e

    call find_surface(model%mesh, item_name(set%head, 2), index)
    if (index > 0) then
      if (model%mesh%surfaces(index)%alone) then
        call find_surface_nodes(set, index, model, draft, diagnostics, body)
        return
      end if
    end if
    call find_region(model%mesh, item_name(set%head, 2), index)
    if (index == 0) then
      call report_no_region(model%mesh, item_location(set%head, 2), item_name(set%head, 2), &
        diagnostics)
      return
    end if
    call region_nodes(model%mesh, index, nodes)
    mine = in_region(model%mesh, index)
    do e = 1, model%mesh%elements
      if (.not. mine(e) .or. model%element_material(e) == 0) cycle
      associate (material => model%materials(model%element_material(e)))
        if (material%rigid) cycle
        call report_error(diagnostics, item_location(set%head, 2), 'element '//to_text(e)// &
          ' of '//item_name(set%head, 2)//' is of MATErial '//to_text(material%number)// &
          ', which deforms', 'give the region a material of its own with the word RIGId')
        return
      end associate
    end do
    body%point = centroid(model%mesh, mine)
    call take_nodes(set, nodes, draft, diagnostics, body)
  end subroutine find_nodes

  !> Nodes and centroid of a surface with nothing behind it.
  subroutine find_surface_nodes(set, index, model, draft, diagnostics, body)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: index !! of the surface
    type(model_t), intent(in) :: model !! mesh
    type(condition_draft_t), intent(in) :: draft !! other conditions
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(rigid_body_t), intent(inout) :: body !! gets nodes, point
    integer, allocatable :: nodes(:)
    real(wp) :: area, whole
    integer :: f

    call surface_nodes(model%mesh, index, nodes)
    whole = 0.0_wp
    body%point = 0.0_wp
    associate (facets => model%mesh%surfaces(index)%facets)
      do f = 1, size(facets, 2)
        associate (x => model%mesh%x(:, facets(:, f)))
          area = norm2(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1)))
          body%point = body%point + area*sum(x, 2)/3.0_wp
          whole = whole + area
        end associate
      end do
    end associate
    if (whole > 0.0_wp) body%point = body%point/whole
    call take_nodes(set, nodes, draft, diagnostics, body)
  end subroutine find_surface_nodes

  !> Gives a body its nodes, which must have no conditions of their own.
  subroutine take_nodes(set, nodes, draft, diagnostics, body)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: nodes(:) !! its nodes
    type(condition_draft_t), intent(in) :: draft !! other conditions
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(rigid_body_t), intent(inout) :: body !! gets nodes
    integer :: i

    do i = 1, size(nodes)
      if (.not. (any(draft%restrained(:, nodes(i))) .or. &
        any(draft%displacement_at(:, nodes(i))%line > 0))) cycle
      call report_error(diagnostics, item_location(set%head, 2), 'node '//to_text(nodes(i))// &
        ' of '//item_name(set%head, 2)//' has a BOUNdary, DISPlacement or ROTAtion of its own', &
        'a rigid body with a point moves by MOVE and TURN alone')
      return
    end do
    body%nodes = nodes
  end subroutine take_nodes

  !> Centroid of some cells.
  pure function centroid(mesh, chosen) result(middle)
    type(mesh_t), intent(in) :: mesh !! the mesh
    logical, intent(in) :: chosen(:) !! (elements)
    real(wp) :: middle(3), volume, whole
    integer :: e

    middle = 0.0_wp
    whole = 0.0_wp
    do e = 1, mesh%elements
      if (.not. chosen(e)) cycle
      associate (x => mesh%x(:, mesh%ix(1:4, e)))
        volume = abs(dot_product(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1)), x(:, 4) - x(:, 1)))
        middle = middle + 0.25_wp*volume*sum(x, 2)
        whole = whole + volume
      end associate
    end do
    middle = middle/whole
  end function centroid

  !> A node belongs to one rigid body, and names are unique.
  subroutine check_owner(set, n, bodies, owner, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: n !! number of the body
    type(rigid_body_t), intent(in) :: bodies(:) !! the bodies so far
    integer, intent(in) :: owner(:) !! (nodes) body of each node, 0 for none
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i

    i = findloc(owner(bodies(n)%nodes) > 0, .true., 1)
    if (i > 0) then
      call report_error(diagnostics, bodies(n)%at, 'node '//to_text(bodies(n)%nodes(i))//' of '// &
        item_name(set%head, 2)//' belongs to the rigid body '// &
        bodies(owner(bodies(n)%nodes(i)))%name//' already', &
        'make one region of both, or part them')
      return
    end if
    do i = 1, n - 1
      if (bodies(i)%name == bodies(n)%name) call report_error(diagnostics, &
        item_location(set%head, item_count(set%head)), 'there is a rigid body '// &
        bodies(n)%name//' already', 'give each one a name of its own behind its region')
    end do
  end subroutine check_owner

  !> POINt, MOVE, TURN, LOAD.
  subroutine read_records(set, model, diagnostics, body)
    type(data_set_t), intent(in) :: set !! the data set
    type(model_t), intent(in) :: model !! tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(rigid_body_t), intent(inout) :: body !! gets point, motions, loads, free
    logical :: open(3), moved, turned
    integer :: k, i

    open = .false.
    moved = .false.
    turned = .false.
    do k = 1, set%count
      associate (record => set%records(k), word => set%records(k)%items(1))
        if (is_word(word, 'point')) then
          body%point = [(item_real(record, 1 + i), i=1, 3)]
        else if (is_word(word, 'move')) then
          moved = .true.
          open = open .or. [(is_word(record%items(1 + i), 'free'), i=1, 3)]
          call add_record(record, 3, model, diagnostics, body%motions)
        else if (is_word(word, 'load')) then
          call add_record(record, 6, model, diagnostics, body%loads)
        else if (turned) then
          call report_error(diagnostics, record%at, 'a second TURN', &
            'write one; what goes to and fro is the business of its table')
        else
          turned = .true.
          if (is_word(record%items(2), 'free')) cycle
          body%free(4:6) = .false.
          call add_rotation(record, model, diagnostics, body%motions)
        end if
      end associate
    end do
    if (moved) body%free(1:3) = open
    do k = 1, size(body%motions)
      if (any(body%free .and. abs(body%motions(k)%value) > 0.0_wp)) call report_error( &
        diagnostics, body%at, 'one MOVE leaves a direction FREE in which another one moves', &
        'write FREE in that place of all of them, or a number')
    end do
  end subroutine read_records

  !> The numbers of a MOVE or LOAD and their table.
  subroutine add_record(record, n, model, diagnostics, list)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: n !! how many numbers
    type(model_t), intent(in) :: model !! tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(point_load_t), allocatable, intent(inout) :: list(:) !! grows
    type(point_load_t) :: new
    integer :: k
    logical :: good

    call check_load_table(model, record, n + 2, diagnostics, new%table, good)
    do k = 1, n
      if (.not. is_word(record%items(1 + k), 'free')) new%value(k) = item_real(record, 1 + k)
    end do
    list = [list, new]
  end subroutine add_record

  !> TURN a1 a2 a3 angle [n].
  subroutine add_rotation(record, model, diagnostics, list)
    type(record_t), intent(in) :: record !! the record
    type(model_t), intent(in) :: model !! tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(point_load_t), allocatable, intent(inout) :: list(:) !! grows
    type(point_load_t) :: new
    real(wp) :: axis(3)
    integer :: k
    logical :: good

    call check_load_table(model, record, 6, diagnostics, new%table, good)
    axis = [(item_real(record, 1 + k), k=1, 3)]
    if (norm2(axis) <= 0.0_wp) then
      call report_error(diagnostics, item_location(record, 2), 'an axis without direction', &
        'write the components of a vector along it, for instance 0 0 1; TURN 0 0 1 0 does not turn')
      return
    end if
    new%value(4:6) = item_real(record, 5)*pi/180.0_wp*axis/norm2(axis)
    list = [list, new]
  end subroutine add_rotation

  !> Prescribed motions as loads of the nodes: each translation with its table, and the two patterns
  !! of the rotation.
  subroutine prescribe(model, owner, n, body, diagnostics, draft)
    type(model_t), intent(in) :: model !! mesh, tables
    integer, intent(in) :: owner(:) !! (nodes) body of each node
    integer, intent(in) :: n !! number of the body
    type(rigid_body_t), intent(in) :: body !! the body
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! its loads grow
    real(wp) :: angle
    integer :: k, i, place

    do k = 1, size(body%motions)
      associate (motion => body%motions(k))
        if (any(abs(motion%value(1:3)) > 0.0_wp)) then
          call join_load(draft%added, motion%table, place)
          do i = 1, size(body%nodes)
            call add_values(draft%added(place)%displacement, body%nodes(i), motion%value(1:3))
          end do
        end if
        angle = norm2(motion%value(4:6))
        if (angle <= 0.0_wp) cycle
        call add_turn(model%mesh%x, body%nodes, body%point, motion%value(4:6)/angle, angle, &
          motion%table, draft%turns)
        call check_turned(body%at, model, n, owner, largest_angle(model, motion%table, angle), &
          diagnostics)
      end associate
    end do
  end subroutine prescribe
end module rigid_reader

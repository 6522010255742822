!> Conditions given by coordinates: on a plane (E forms) or at a point (C forms).
module located_conditions
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: data_set_t, record_t
  use records, only: item_location, item_integer, item_real
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_types, only: mesh_t
  use mesh_building, only: own_nodes, axis_tolerance, place_tolerance, miss_tolerance
  use node_sets, only: warn_of_misses
  use node_queries, only: nearest_node
  use condition_draft, only: condition_draft_t, set_values, record_values
  implicit none
  private
  public :: read_edge_conditions, read_point_conditions

contains

  !> Reads one EBOU, EDIS, EFOR or EPRO data set: direction, coordinate, values.
  subroutine read_edge_conditions(set, quantity, mesh, diagnostics, draft)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: quantity !! what it prescribes
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    integer :: i

    do i = 1, set%count
      call set_on_plane(set%records(i), quantity, mesh, diagnostics, draft)
    end do
  end subroutine read_edge_conditions

  !> Sets the values of one record at all nodes of its plane.
  subroutine set_on_plane(record, quantity, mesh, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: quantity !! what it prescribes
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    real(wp) :: coordinate, tolerance(mesh%nodes), beside(mesh%nodes)
    logical :: missed(mesh%nodes), taken(mesh%nodes)
    integer :: direction, node, found

    direction = item_integer(record, 1)
    coordinate = item_real(record, 2)
    tolerance = axis_tolerance(mesh, direction)
    beside = miss_tolerance(mesh)
    missed = .false.
    taken = .false.
    found = 0
    do node = 1, own_nodes(mesh)
      if (.not. mesh%defined(node)) cycle
      if (abs(mesh%x(direction, node) - coordinate) > tolerance(node)) then
        missed(node) = abs(mesh%x(direction, node) - coordinate) <= beside(node)
        cycle
      end if
      found = found + 1
      taken(node) = .true.
      call set_values(draft, quantity, node, record_values(record, 2), record, 2)
    end do
    if (found == 0) call report_empty_plane(record, direction, coordinate, mesh, diagnostics)
    if (found > 0) call warn_of_misses(mesh, 'the plane', record%at, taken, missed, &
      'name a set for it: SET name, PLANe i c tol, and BOUNdary, DISPlacement or FORCe name', &
      diagnostics)
  end subroutine set_on_plane

  !> No node lies on the plane: says where the nearest one is.
  subroutine report_empty_plane(record, direction, coordinate, mesh, diagnostics)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: direction !! axis normal to the plane
    real(wp), intent(in) :: coordinate !! its coordinate
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    real(wp) :: distance
    integer :: node, nearest

    nearest = 0
    distance = huge(distance)
    do node = 1, own_nodes(mesh)
      if (.not. mesh%defined(node)) cycle
      if (abs(mesh%x(direction, node) - coordinate) < distance) then
        distance = abs(mesh%x(direction, node) - coordinate)
        nearest = node
      end if
    end do
    if (nearest == 0) return
    call report_error(diagnostics, item_location(record, 2), 'no node has x'//to_text(direction)// &
      ' = '//to_text(coordinate, 10), 'the nearest coordinate is '// &
      to_text(mesh%x(direction, nearest), 10)//' (node '//to_text(nearest)//')')
  end subroutine report_empty_plane

  !> Reads one CBOU, CDIS, CFOR or CPRO data set: NODE x y z, values, for the node nearest to x.
  subroutine read_point_conditions(set, quantity, mesh, diagnostics, draft)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: quantity !! what it prescribes
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    real(wp) :: x(3), distance, tolerance(mesh%nodes)
    integer :: i, node

    tolerance = place_tolerance(mesh)
    do i = 1, set%count
      x = record_values(set%records(i), 1)
      node = nearest_node(mesh, x)
      if (node == 0) return
      distance = norm2(mesh%x(:, node) - x)
      if (distance > tolerance(node)) then
        call report_note(diagnostics, set%records(i)%at, 'node '//to_text(node)// &
          ' is taken: the nearest, '//to_text(distance)//' away')
      end if
      call set_values(draft, quantity, node, record_values(set%records(i), 4), &
        set%records(i), 4)
    end do
  end subroutine read_point_conditions
end module located_conditions

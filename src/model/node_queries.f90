!> Questions about nodes that several readers of the model ask, and how a bad answer is reported.
module node_queries
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: location_t, record_t
  use records, only: item_location, item_name
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use mesh_building, only: own_nodes
  use mesh_names, only: find_nodes, name_exists, name_hint, region_hint
  implicit none
  private
  public :: report_missing_node, nodes_of_item, report_unknown_name, report_no_region
  public :: nearest_node

contains

  !> Reports a node that does not exist.
  subroutine report_missing_node(mesh, at, node, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(location_t), intent(in) :: at !! where it is named
    integer, intent(in) :: node !! its number
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    call report_error(diagnostics, at, 'node '//to_text(node)//' does not exist', &
      'the mesh has '// &
      count_noun(count(mesh%defined(:own_nodes(mesh))), 'node')//', the highest number is '// &
      to_text(own_nodes(mesh)))
  end subroutine report_missing_node

  !> Reports a name that is no set, region or surface.
  subroutine report_unknown_name(mesh, at, name, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(location_t), intent(in) :: at !! where it stands
    character(*), intent(in) :: name !! the name
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (mesh%nameless) return
    call report_error(diagnostics, at, 'there is no set, region or surface '//name, &
      name_hint(mesh, name))
  end subroutine report_unknown_name

  !> Reports a name that is no region, but maybe something else.
  subroutine report_no_region(mesh, at, name, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(location_t), intent(in) :: at !! where it stands
    character(*), intent(in) :: name !! the name
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (name_exists(mesh, name)) then
      call report_error(diagnostics, at, name//' is no region', region_hint(mesh))
    else if (.not. mesh%nameless) then
      call report_error(diagnostics, at, 'there is no region '//name, region_hint(mesh))
    end if
  end subroutine report_no_region

  !> Nodes of the set, region or surface that item `i` names; none, and an error, if unknown.
  subroutine nodes_of_item(mesh, record, i, diagnostics, nodes)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! item of the name
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer, allocatable, intent(out) :: nodes(:) !! node numbers
    logical :: found

    call find_nodes(mesh, item_name(record, i), nodes, found)
    if (found) return
    call report_unknown_name(mesh, item_location(record, i), item_name(record, i), diagnostics)
    if (.not. allocated(nodes)) allocate (nodes(0))
  end subroutine nodes_of_item

  !> The node nearest to a point, the lowest number among equals; 0 without nodes.
  pure integer function nearest_node(mesh, x) result(nearest)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(in) :: x(3) !! the point
    real(wp) :: distance, least
    integer :: i

    nearest = 0
    least = huge(least)
    do i = 1, own_nodes(mesh)
      if (.not. mesh%defined(i)) cycle
      distance = norm2(mesh%x(:, i) - x)
      if (distance < least) then
        least = distance
        nearest = i
      end if
    end do
  end function nearest_node
end module node_queries

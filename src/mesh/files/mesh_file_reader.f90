!> MESH: nodes, elements, regions, surfaces and sets from a file of Gmsh, Abaqus or CalculiX; rigid
!! surfaces from one of triangles alone, which may be STL.
module mesh_file_reader
  use text, only: to_text, count_noun
  use errors, only: error_t
  use deck_types, only: deck_t
  use records, only: item_name, item_count
  use source, only: file_name
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_types, only: mesh_t
  use cells, only: mirrored
  use mesh_building, only: element_origin_t, reserve_nodes, reserve_elements, place_node, &
    place_element, set_roundings
  use near_places, only: roundings
  use mesh_formats, only: load_file
  use mesh_file_types, only: file_mesh_t
  use tool_surfaces, only: is_tool, place_tool, place_rigid
  use file_mesh_checks, only: file_place_t, check_file_mesh
  use file_surfaces, only: surface_draft_t
  use file_groups, only: place_groups
  use file_fields, only: place_fields
  use kinds, only: wp
  implicit none
  private
  public :: read_mesh_file

contains

  !> Obeys `MESH file [AS name]`. Nodes and elements get the numbers behind the highest so far, in
  !! the order of the file.
  subroutine read_mesh_file(deck, index, mesh, origin, drafts, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    integer, intent(in) :: index !! index of the command among the mesh commands
    type(mesh_t), intent(inout) :: mesh !! the mesh it adds to
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(surface_draft_t), allocatable, intent(inout) :: drafts(:) !! surfaces of mesh files
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(file_mesh_t) :: file
    type(file_place_t) :: place
    character(:), allocatable :: name
    integer :: i
    logical :: good

    associate (head => deck%mesh(index)%head)
      name = ''
      if (item_count(head) >= 4) name = item_name(head, 4)
      call load_file(item_name(head, 2), head%items(2)%at, file, place, diagnostics, good)
    end associate
    if (.not. good) return
    if (is_tool(file)) then
      call place_tool(name, place, file, mesh, diagnostics)
      return
    end if
    call check_file_mesh(place, file, diagnostics, good)
    if (good) call place_mesh(file, index, place, mesh, origin, diagnostics, good)
    if (.not. good) return
    do i = 1, size(file%remarks)
      call report_note(diagnostics, place%at, item_name(deck%mesh(index)%head, 2)//': '// &
        file%remarks(i)%s)
    end do
    call place_rigid(place, file, mesh, diagnostics)
    call place_groups(deck, name, place, file, mesh, drafts, diagnostics)
    call place_fields(place, file, mesh, diagnostics)
  end subroutine read_mesh_file

  !> Puts nodes and tetrahedra into the mesh and keeps their deck numbers.
  subroutine place_mesh(file, index, place, mesh, origin, diagnostics, good)
    type(file_mesh_t), intent(in) :: file !! what the file holds
    integer, intent(in) :: index !! index of the command among the mesh commands
    type(file_place_t), intent(inout) :: place !! what joins the mesh; gets the deck numbers
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(out) :: good !! there is room
    type(error_t), allocatable :: error
    real(wp), allocatable :: rounding(:, :)
    integer :: n, e, c, nodes, elements
    integer, allocatable :: nodes_of(:)
    real(wp) :: apart
    logical :: twice

    nodes = mesh%nodes
    elements = mesh%elements
    call reserve_nodes(mesh, nodes + count(place%node > 0), error)
    if (.not. allocated(error)) call reserve_elements(mesh, origin, elements + &
      count(place%element > 0), error)
    good = .not. allocated(error)
    if (.not. good) then
      call report_error(diagnostics, place%at, error%message, 'make the mesh coarser')
      return
    end if
    n = nodes
    rounding = roundings(file%x(:, :file%nodes))
    do c = 1, file%nodes
      if (place%node(c) < 1) cycle
      n = n + 1
      place%node(c) = n
      call place_node(mesh, n, file%x(:, c), apart)
      call set_roundings(mesh, n, rounding(:, c))
    end do
    e = elements
    do c = 1, file%cells
      if (place%element(c) < 1) cycle
      e = e + 1
      place%element(c) = e
      nodes_of = place%node(file%ix(:file%nel(c), c))
      if (mesh%mirrors) nodes_of = mirrored(nodes_of)
      call place_element(mesh, origin, e, nodes_of, 1, index, 0, twice)
    end do
    do c = 1, file%cells
      if (place%element(c) < 0) place%element(c) = place%element(-place%element(c))
    end do
    call report_note(diagnostics, place%at, file_name(diagnostics%source, place%file)// &
      ': '//count_noun(n - nodes, 'node')//', numbered from '//to_text(nodes + 1)//', and '// &
      count_noun(e - elements, 'element')//', numbered from '//to_text(elements + 1))
  end subroutine place_mesh
end module mesh_file_reader

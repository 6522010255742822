!> The mesh of a deck: nodes, elements, and the named parts of them.
module mesh_reader
  use errors, only: error_t
  use deck_types, only: deck_t
  use deck_losses, only: is_whole, lost_names
  use diagnostics, only: diagnostics_t, report_error, error_count
  use facets, only: facet_table_t
  use mesh_types, only: mesh_t
  use mesh_building, only: element_origin_t, start_mesh, finish_mesh
  use curved_checks, only: check_curved
  use edge_checks, only: check_edges
  use mesh_checks, only: check_elements, check_numbers
  use coordinates_reader, only: read_coordinates
  use elements_reader, only: read_elements
  use block_reader, only: read_block
  use transform_reader, only: read_transform
  use brick_cutting, only: check_bricks
  use tied_nodes, only: has_tie, join_nodes, kept_node, tie_names, note_gaps, refuse_halves
  use mesh_file_reader, only: read_mesh_file
  use file_surfaces, only: surface_draft_t
  use rigid_surfaces, only: is_exact, read_exact_surface
  use named_parts, only: gather_names, evaluate_parts
  implicit none
  private
  public :: read_mesh

contains

  !> Interprets COORdinates, ELEMents, BLOCk, MESH, TRANsform, TIE, SET and SURFace. A mesh that is
  !! not sound must not be computed with, but the names of its parts can be looked up.
  subroutine read_mesh(deck, diagnostics, mesh, exterior)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(out) :: mesh !! the mesh
    type(facet_table_t), intent(out) :: exterior !! its exterior facets, if it has surfaces
    type(element_origin_t) :: origin
    type(surface_draft_t), allocatable :: drafts(:)
    integer :: names, errors, i, n, parts, region, material
    logical :: complete
    type(error_t), allocatable :: error

    names = error_count(diagnostics)
    call start_mesh(mesh, origin, deck%control(1), deck%control(2))
    call gather_names(deck, diagnostics, mesh)
    mesh%nameless = lost_names(deck)
    errors = error_count(diagnostics)
    allocate (drafts(0))
    region = 0
    material = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command == 'coor') then
        call read_coordinates(deck%mesh(i), mesh, diagnostics)
      else if (deck%mesh(i)%command == 'elem') then
        call read_elements(deck%mesh(i), i, mesh, origin, diagnostics)
      else if (deck%mesh(i)%command == 'bloc') then
        region = region + 1
        call read_block(deck%mesh(i), i, region, material, mesh, origin, diagnostics)
      else if (deck%mesh(i)%command == 'mesh') then
        n = error_count(diagnostics)
        parts = size(mesh%sets) + size(mesh%regions) + size(mesh%surfaces)
        call read_mesh_file(deck, i, mesh, origin, drafts, diagnostics)
        mesh%nameless = mesh%nameless .or. error_count(diagnostics) > n .and. parts == &
          size(mesh%sets) + size(mesh%regions) + size(mesh%surfaces)
      else if (deck%mesh(i)%command == 'tran') then
        call read_transform(deck%mesh(i), mesh, diagnostics)
      end if
    end do
    do i = 1, size(deck%mesh)
      if (is_exact(deck%mesh(i))) call read_exact_surface(deck%mesh(i), mesh, diagnostics)
    end do
    call finish_mesh(mesh, origin, error)
    if (allocated(error)) then
      call report_error(diagnostics, deck%last, error%message, 'make the mesh smaller')
      return
    end if
    ! what was left out because of an error must not give rise to others
    complete = is_whole(deck, ['coor', 'elem', 'bloc', 'mesh', 'tran']) .and. &
      error_count(diagnostics) == errors + mesh%misplaced
    if (complete .and. errors == 0) call check_numbers(deck, origin, diagnostics, mesh)
    if (complete) call check_bricks(deck, origin, mesh, diagnostics)
    call check_elements(deck, origin, complete, diagnostics, mesh)
    mesh%filled = complete .and. error_count(diagnostics) == errors + mesh%misplaced .and. &
      mesh%elements > 0 .and. (is_whole(deck, ['tie ']) .or. .not. has_tie(deck))
    complete = complete .and. error_count(diagnostics) == errors
    if (complete) call check_curved(deck, origin, mesh, diagnostics)
    if (complete) call check_edges(deck, origin, mesh, diagnostics)
    complete = complete .and. error_count(diagnostics) == errors
    if (complete .and. has_tie(deck)) call tie(deck, drafts, diagnostics, mesh)
    mesh%filled = mesh%filled .and. (complete .or. .not. has_tie(deck)) .and. &
      error_count(diagnostics) == errors + mesh%misplaced
    complete = complete .and. error_count(diagnostics) == errors
    call evaluate_parts(deck, mesh%filled, diagnostics, mesh, drafts, exterior)
    mesh%sound = complete .and. is_whole(deck, ['set ', 'surf']) .and. &
      error_count(diagnostics) == names
  end subroutine read_mesh

  !> Joins nodes; the sides of contact pairs are those of the mesh before. What mesh files say of
  !! nodes then says it of those that are kept.
  subroutine tie(deck, drafts, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(surface_draft_t), intent(inout) :: drafts(:) !! surfaces of mesh files
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(mesh_t) :: named
    type(diagnostics_t) :: unheard
    type(facet_table_t) :: unused
    integer :: i

    named = mesh
    unheard = diagnostics
    call evaluate_parts(deck, .true., unheard, named, drafts, unused)
    call join_nodes(deck, named, diagnostics, mesh)
    call tie_names(mesh)
    do i = 1, size(drafts)
      if (allocated(drafts(i)%corners)) drafts(i)%corners = kept_node(mesh, drafts(i)%corners)
    end do
    call note_gaps(deck, diagnostics, mesh)
    call refuse_halves(deck, diagnostics, mesh)
  end subroutine tie
end module mesh_reader

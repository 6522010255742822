!> The mesh of a deck: nodes, elements, and the named parts of them.
module mesh_reader
  use errors, only: error_t
  use deck_types, only: deck_t
  use deck_losses, only: is_whole, lost_names
  use text, only: to_text, count_noun
  use cells, only: tet4, most_nodes
  use diagnostics, only: diagnostics_t, report_error, report_note, error_count
  use facets, only: facet_table_t, exterior_facets
  use key_sorting, only: sort_columns, ascending, unique_numbers
  use mesh_types, only: mesh_t, facet_field_t
  use mesh_building, only: element_origin_t, start_mesh, finish_mesh
  use curved_checks, only: check_curved
  use edge_checks, only: check_edges
  use mesh_checks, only: check_elements, check_numbers
  use coordinates_reader, only: read_coordinates
  use elements_reader, only: read_elements
  use block_reader, only: read_block
  use transform_reader, only: read_transform
  use brick_cutting, only: check_bricks
  use tied_nodes, only: has_tie, join_nodes, kept_node
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
    logical, allocatable :: mask(:)
    integer :: i

    named = mesh
    unheard = diagnostics
    call evaluate_parts(deck, .true., unheard, named, drafts, unused)
    call join_nodes(deck, named, diagnostics, mesh)
    do i = 1, size(mesh%sets)
      if (size(mesh%sets(i)%nodes) == 0) cycle
      allocate (mask(mesh%nodes), source=.false.)
      mask(kept_node(mesh, mesh%sets(i)%nodes)) = .true.
      mesh%sets(i)%nodes = unique_numbers(mask)
      deallocate (mask)
    end do
    do i = 1, size(drafts)
      if (allocated(drafts(i)%corners)) drafts(i)%corners = kept_node(mesh, drafts(i)%corners)
    end do
    do i = 1, size(mesh%fields)
      call tie_field(mesh, mesh%fields(i))
    end do
    call note_gaps(deck, diagnostics, mesh)
    call refuse_halves(deck, diagnostics, mesh)
  end subroutine tie

  !> Notes facets that lie between joined bodies and have no partner: the mesh gapes there.
  subroutine note_gaps(deck, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(in) :: mesh !! the mesh, tied
    type(facet_table_t) :: table
    logical :: joined(mesh%nodes)
    integer :: f, n

    joined = joined_nodes(mesh)
    call exterior_facets(mesh, table)
    n = 0
    do f = 1, table%count
      if (all(joined(table%corners(:, f)))) n = n + 1
    end do
    if (n == 0) return
    f = findloc(deck%mesh%command, 'tie ', dim=1)
    call report_note(diagnostics, deck%mesh(f)%head%at, to_text(n)//' facets all of whose '// &
      'corners TIE has joined have no partner: the bodies are cut along different diagonals '// &
      'there, and forces pass by their common nodes alone')
  end subroutine note_gaps

  !> Refuses facets of elements of ten nodes that TIE has joined to such of four: the nodes in the
  !! middle of their edges would hang there, and the joint would be far too soft.
  subroutine refuse_halves(deck, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(mesh_t), intent(in) :: mesh !! the mesh, tied
    integer, allocatable :: key(:, :), order(:)
    integer :: f, n, first

    if (all(mesh%ix(most_nodes, :mesh%elements) > 0) .or. &
      all(mesh%ix(most_nodes, :mesh%elements) == 0)) return
    call list_joined(mesh, key)
    call sort_columns(key(:3, :), order)
    n = 0
    first = 0
    do f = 2, size(order)
      associate (a => key(:, order(f - 1)), b => key(:, order(f)))
        if (any(a(:3) /= b(:3))) cycle
        if ((mesh%ix(most_nodes, a(4)) > 0) .eqv. (mesh%ix(most_nodes, b(4)) > 0)) cycle
        n = n + 1
        if (first == 0) first = merge(a(4), b(4), mesh%ix(most_nodes, a(4)) > 0)
      end associate
    end do
    if (n == 0) return
    f = findloc(deck%mesh%command, 'tie ', dim=1)
    call report_error(diagnostics, deck%mesh(f)%head%at, 'TIE joins '//count_noun(n, 'facet')// &
      ' of ten-node elements to facets of four-node ones, the first is of element '// &
      to_text(first), 'the nodes in the middle of its edges would hang there: give both bodies '// &
      'TET4 or TET10, or join them by a PAIR')
  end subroutine refuse_halves

  !> The facets all of whose corners TIE has joined to others.
  subroutine list_joined(mesh, key)
    type(mesh_t), intent(in) :: mesh !! the mesh, tied
    integer, allocatable, intent(out) :: key(:, :) !! (4, facets) corners, ascending, and element
    logical :: joined(mesh%nodes)
    integer :: pass, e, f, n

    joined = joined_nodes(mesh)
    do pass = 1, 2
      n = 0
      do e = 1, mesh%elements
        if (count(joined(mesh%ix(:4, e))) < 3) cycle
        do f = 1, 4
          associate (corners => mesh%ix(tet4%facet(:3, f), e))
            if (.not. all(joined(corners))) cycle
            n = n + 1
            if (pass == 2) key(:, n) = [ascending(corners), e]
          end associate
        end do
      end do
      if (pass == 1) allocate (key(4, n))
    end do
  end subroutine list_joined

  !> Nodes that TIE has joined others to.
  pure function joined_nodes(mesh) result(joined)
    type(mesh_t), intent(in) :: mesh !! the mesh, tied
    logical :: joined(mesh%nodes)
    integer :: n

    joined = .false.
    do n = 1, mesh%nodes
      if (mesh%tied(n) /= n) joined(mesh%tied(n)) = .true.
    end do
  end function joined_nodes

  !> Gives a field of facets the nodes that are kept, in order again.
  pure subroutine tie_field(mesh, field)
    type(mesh_t), intent(in) :: mesh !! knows the nodes that are kept
    type(facet_field_t), intent(inout) :: field !! the field
    integer, allocatable :: order(:)
    integer :: k

    do k = 1, size(field%keys, 2)
      field%keys(:, k) = ascending(kept_node(mesh, field%keys(:, k)))
    end do
    call sort_columns(field%keys, order)
    field%keys = field%keys(:, order)
    field%vectors = field%vectors(:, order)
    field%at = field%at(order)
  end subroutine tie_field
end module mesh_reader

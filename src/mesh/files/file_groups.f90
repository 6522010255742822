!> Groups of mesh files become regions, surfaces and node sets of the deck.
module file_groups
  use text, only: to_text
  use deck_types, only: deck_t, location_t, name_length
  use numbers, only: is_letter
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_types, only: mesh_t
  use cells, only: mirrored, facet_name
  use mesh_names, only: name_exists, find_region, find_surface, region_nodes, in_region
  use key_sorting, only: unique_numbers
  use part_lists, only: append_set, append_region, append_surface
  use mesh_file_types, only: file_mesh_t, file_group_t, group_nodes, group_cells, group_faces, &
    group_done
  use file_mesh_checks, only: file_place_t, place_in_file
  use file_materials, only: choose_materials
  use file_surfaces, only: surface_draft_t
  implicit none
  private
  public :: place_groups

contains

  !> Makes the named parts of a file, and the region of all its elements that AS names. A node set
  !! that repeats a region or surface of its name is that one.
  subroutine place_groups(deck, name, place, file, mesh, drafts, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: name !! the name AS gives, may be empty
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets regions, sets and surfaces without facets
    type(surface_draft_t), allocatable, intent(inout) :: drafts(:) !! gets the surfaces
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: g, pass, dimension(file%groups)

    do g = 1, file%groups
      dimension(g) = -1
      if (file%group(g)%kind == group_done) cycle
      dimension(g) = group_dimension(file, file%group(g))
      if (.not. usable(file%group(g), dimension(g), place, diagnostics)) dimension(g) = -1
    end do
    do pass = 1, 3
      do g = 1, file%groups
        associate (group => file%group(g))
          if (pass == 1 .and. dimension(g) == 3) then
            call place_region(group%name, place_in_file(diagnostics%source, place%file, group%at), &
              elements_of(group, place, mesh), mesh, diagnostics)
          else if (pass == 2 .and. dimension(g) == 2) then
            call place_surface(group, place, file, mesh, drafts, diagnostics)
          else if (pass == 3 .and. dimension(g) >= 0 .and. dimension(g) < 2) then
            call place_set(group, place, file, mesh, drafts, diagnostics)
          end if
        end associate
      end do
    end do
    if (name /= '' .and. .not. is_region(mesh, name, all_elements(place, mesh))) then
      call place_region(name, place%at, unique_numbers(all_elements(place, mesh)), mesh, &
        diagnostics)
    end if
    call choose_materials(deck, name, place, file, mesh, diagnostics)
  end subroutine place_groups

  !> What a group is to become: 3 a region, 2 a surface, less a node set.
  pure integer function group_dimension(file, group) result(dimension)
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(file_group_t), intent(in) :: group !! the group
    integer :: i

    dimension = 0
    if (group%kind == group_faces) dimension = 2
    if (group%kind /= group_cells) return
    do i = 1, group%count
      dimension = max(dimension, file%dimension(group%members(i)))
    end do
  end function group_dimension

  !> Whether a deck can use a group; the others are left out with a note.
  logical function usable(group, dimension, place, diagnostics)
    type(file_group_t), intent(in) :: group !! the group
    integer, intent(in) :: dimension !! what it is to become
    type(file_place_t), intent(in) :: place !! deck numbers
    type(diagnostics_t), intent(inout) :: diagnostics !! notes
    character(:), allocatable :: why

    if (group%count == 0) then
      why = 'has no members'
    else if (len(group%name) > name_length) then
      why = 'has a name of more than '//to_text(name_length)//' characters'
    else if (.not. is_letter(group%name(1:1)) .or. scan(group%name, '''"!&') > 0) then
      why = 'has no name that a deck can use (first a letter)'
    else if (dimension < 2 .and. group%kind == group_nodes) then
      if (all(place%node(group%members(:group%count)) == 0)) why = 'has no node of a tetrahedron'
    end if
    usable = .not. allocated(why)
    if (.not. usable) call report_note(diagnostics, place_in_file(diagnostics%source, place%file, &
      group%at), 'group '//group%name//' '//why//': left out')
  end function usable

  !> Deck numbers of the tetrahedra of a group, ascending.
  function elements_of(group, place, mesh) result(elements)
    type(file_group_t), intent(in) :: group !! the group
    type(file_place_t), intent(in) :: place !! deck numbers
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, allocatable :: elements(:)
    logical, allocatable :: chosen(:)
    integer :: i

    allocate (chosen(mesh%elements), source=.false.)
    do i = 1, group%count
      if (place%element(group%members(i)) > 0) chosen(place%element(group%members(i))) = .true.
    end do
    elements = unique_numbers(chosen)
  end function elements_of

  !> Which elements of the mesh come from this file.
  function all_elements(place, mesh) result(chosen)
    type(file_place_t), intent(in) :: place !! deck numbers
    type(mesh_t), intent(in) :: mesh !! the mesh
    logical, allocatable :: chosen(:)
    integer :: c

    allocate (chosen(mesh%elements), source=.false.)
    do c = 1, size(place%element)
      if (place%element(c) > 0) chosen(place%element(c)) = .true.
    end do
  end function all_elements

  !> Whether a region of this name has just these elements.
  logical function is_region(mesh, name, chosen)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! its name
    logical, intent(in) :: chosen(:) !! (elements) the elements
    integer :: region

    call find_region(mesh, name, region)
    is_region = region > 0
    if (is_region) is_region = all(in_region(mesh, region) .eqv. chosen)
  end function is_region

  !> Makes a region. Where elements are in another region already it keeps a list of its own.
  subroutine place_region(name, at, elements, mesh, diagnostics)
    character(*), intent(in) :: name !! its name
    type(location_t), intent(in) :: at !! where it is defined
    integer, intent(in) :: elements(:) !! its elements
    type(mesh_t), intent(inout) :: mesh !! gets the region
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer :: i, n

    if (taken(name, at, mesh, diagnostics)) return
    call append_region(mesh, name, at)
    n = size(mesh%regions)
    if (any(mesh%region(elements) /= 0)) mesh%regions(n)%elements = elements
    do i = 1, size(elements)
      if (mesh%region(elements(i)) == 0) mesh%region(elements(i)) = n
    end do
  end subroutine place_region

  !> Makes a surface of triangles and faces; its facets follow when the mesh is complete.
  subroutine place_surface(group, place, file, mesh, drafts, diagnostics)
    type(file_group_t), intent(in) :: group !! the group
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets the surface
    type(surface_draft_t), allocatable, intent(inout) :: drafts(:) !! gets its triangles
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(surface_draft_t) :: draft
    character(:), allocatable :: name
    type(location_t) :: at
    integer :: i, n, free, c
    integer, allocatable :: nodes(:)

    at = place_in_file(diagnostics%source, place%file, group%at)
    name = own_name(group, '_faces', at, file, mesh, diagnostics)
    if (taken(name, at, mesh, diagnostics)) return
    call append_surface(mesh, name, at)
    draft%surface = size(mesh%surfaces)
    draft%file = place%file
    allocate (draft%corners(3, group%count), draft%tag(group%count), draft%at(group%count), &
      draft%free(group%count), source=0)
    n = 0
    free = 0
    do i = 1, group%count
      c = group%members(i)
      if (file%dimension(c) == 3 .and. group%faces(i) == 0) then
        free = free + 1
        draft%free(free) = place%element(c)
        cycle
      end if
      n = n + 1
      draft%tag(n) = file%cell_tag(c)
      draft%at(n) = file%cell_at(c)
      if (file%dimension(c) < 2) cycle
      nodes = place%node(file%ix(:file%nel(c), c))
      ! faces are numbered by the order that the nodes have in the file
      if (place%turned(c)) nodes = mirrored(nodes)
      if (file%dimension(c) == 3) nodes = facet_name(nodes, group%faces(i))
      draft%corners(:, n) = nodes(:3)
    end do
    draft%corners = draft%corners(:, :n)
    draft%tag = draft%tag(:n)
    draft%at = draft%at(:n)
    draft%free = draft%free(:free)
    call append_draft(drafts, draft)
  end subroutine place_surface

  !> Makes a set of nodes, or of the nodes of lines and points.
  subroutine place_set(group, place, file, mesh, drafts, diagnostics)
    type(file_group_t), intent(in) :: group !! the group
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets the set
    type(surface_draft_t), intent(in) :: drafts(:) !! the surfaces
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, allocatable :: chosen(:)
    character(:), allocatable :: name
    type(location_t) :: at
    integer :: i, c

    allocate (chosen(mesh%nodes), source=.false.)
    do i = 1, group%count
      c = group%members(i)
      if (group%kind == group_nodes) then
        call mark_nodes(place%node(c:c), chosen)
      else
        call mark_nodes(place%node(file%ix(:file%nel(c), c)), chosen)
      end if
    end do
    at = place_in_file(diagnostics%source, place%file, group%at)
    if (repeats(group%name, unique_numbers(chosen), mesh, drafts)) return
    name = own_name(group, '_nodes', at, file, mesh, diagnostics)
    if (.not. any(chosen)) then
      call report_note(diagnostics, at, 'group '//group%name// &
        ' has no node of a tetrahedron: left out')
      return
    end if
    if (taken(name, at, mesh, diagnostics)) return
    call append_set(mesh, name, at, unique_numbers(chosen))
  end subroutine place_set

  !> The name of a group in the deck: its own, or with an ending where a group of another kind has
  !! it, for mesh files give names to elements, faces and nodes apart.
  function own_name(group, ending, at, file, mesh, diagnostics) result(name)
    type(file_group_t), intent(in) :: group !! a group of faces or nodes
    character(*), intent(in) :: ending !! says of what
    type(location_t), intent(in) :: at !! where it is defined
    type(file_mesh_t), intent(in) :: file !! its file
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! notes
    character(:), allocatable :: name
    integer :: g, others

    name = group%name
    others = 0
    do g = 1, file%groups
      if (file%group(g)%name == name) others = others + 1
    end do
    if (others < 2 .or. .not. name_exists(mesh, name)) return
    if (len(name) + len(ending) > name_length) return
    name = name//ending
    call report_note(diagnostics, at, 'the name '//group%name//' is that of another group: '// &
      'this one is called '//name)
  end function own_name

  !> Marks the nodes that have joined the mesh.
  pure subroutine mark_nodes(nodes, chosen)
    integer, intent(in) :: nodes(:) !! deck numbers, 0 for nodes that have been left out
    logical, intent(inout) :: chosen(:) !! (nodes) nodes of the set
    integer :: i

    do i = 1, size(nodes)
      if (nodes(i) > 0) chosen(nodes(i)) = .true.
    end do
  end subroutine mark_nodes

  !> Whether a region or surface of this name has just these nodes.
  logical function repeats(name, nodes, mesh, drafts)
    character(*), intent(in) :: name !! name of the set
    integer, intent(in) :: nodes(:) !! its nodes, ascending
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(surface_draft_t), intent(in) :: drafts(:) !! the surfaces
    integer, allocatable :: others(:)
    logical, allocatable :: chosen(:)
    integer :: region, surface, d

    repeats = .false.
    call find_region(mesh, name, region)
    call find_surface(mesh, name, surface)
    allocate (others(0))
    if (region > 0) call region_nodes(mesh, region, others)
    do d = 1, size(drafts)
      if (drafts(d)%surface /= surface .or. surface == 0) cycle
      allocate (chosen(mesh%nodes), source=.false.)
      call mark_nodes(reshape(drafts(d)%corners, [size(drafts(d)%corners)]), chosen)
      others = unique_numbers(chosen)
      deallocate (chosen)
    end do
    if (size(others) > 0 .and. size(others) == size(nodes)) repeats = all(others == nodes)
  end function repeats

  !> Whether a name is taken; that is an error.
  logical function taken(name, at, mesh, diagnostics)
    character(*), intent(in) :: name !! the name
    type(location_t), intent(in) :: at !! where it is defined
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors

    taken = name_exists(mesh, name)
    if (taken) call report_error(diagnostics, at, 'the name '//name//' is taken already', &
      'sets, regions and surfaces share one name space: rename it in the mesh file or the deck')
  end function taken

  !> Adds a surface to a list; there are few of them.
  subroutine append_draft(drafts, draft)
    type(surface_draft_t), allocatable, intent(inout) :: drafts(:) !! the list
    type(surface_draft_t), intent(in) :: draft !! the surface
    type(surface_draft_t), allocatable :: more(:)
    integer :: i, n

    n = size(drafts)
    allocate (more(n + 1))
    do i = 1, n
      more(i)%surface = drafts(i)%surface
      more(i)%file = drafts(i)%file
      call move_alloc(drafts(i)%corners, more(i)%corners)
      call move_alloc(drafts(i)%tag, more(i)%tag)
      call move_alloc(drafts(i)%at, more(i)%at)
      call move_alloc(drafts(i)%free, more(i)%free)
    end do
    more(n + 1) = draft
    call move_alloc(more, drafts)
  end subroutine append_draft
end module file_groups

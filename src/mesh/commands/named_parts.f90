!> Sets, regions and surfaces of a deck: their names, which needs which, and their evaluation.
!!
!! Names may be used before they are defined, so all names are gathered first; when the mesh is
!! complete each part is evaluated after those it refers to.
module named_parts
  use deck_types, only: deck_t, item_t
  use deck_losses, only: is_lost_name
  use records, only: item_name, item_count, is_word
  use diagnostics, only: diagnostics_t, report_error
  use text, only: to_text
  use mesh_types, only: mesh_t, node_set_t, region_t, surface_t
  use mesh_names, only: find_set, find_region, find_surface, name_exists, name_hint, region_hint
  use facets, only: facet_table_t, exterior_facets
  use node_sets, only: select_nodes
  use surfaces, only: select_facets
  use rigid_surfaces, only: is_exact
  use file_surfaces, only: surface_draft_t, settle_surfaces
  implicit none
  private
  public :: gather_names, evaluate_parts

  !> States of a part while parts are ordered.
  integer, parameter :: state_untouched = 0
  integer, parameter :: state_visiting = 1
  integer, parameter :: state_good = 2
  integer, parameter :: state_bad = 3

  !> A set or a surface of the deck.
  type :: part_t
    integer :: command = 0 !! index among the deck's mesh commands
    integer :: set = 0 !! index into mesh%sets, or 0
    integer :: surface = 0 !! index into mesh%surfaces, or 0
    integer :: state = state_untouched !! one of the states above
  end type part_t

  !> All sets and surfaces of a deck, and the order in which they can be evaluated.
  type :: part_list_t
    type(part_t), allocatable :: parts(:) !! in the order of the deck
    integer, allocatable :: order(:) !! the first `ordered` entries are parts to evaluate
    integer :: ordered = 0 !! number of parts ordered so far
  end type part_list_t

contains

  !> Enters the names of all sets, regions and surfaces into the mesh, without their contents.
  subroutine gather_names(deck, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! gets empty sets, regions and surfaces
    type(node_set_t), allocatable :: sets(:)
    type(region_t), allocatable :: regions(:)
    type(surface_t), allocatable :: surfaces(:)
    integer :: i, n(3)

    n = [command_count(deck, 'set'), command_count(deck, 'bloc'), command_count(deck, 'surf')]
    if (allocated(deck%losses)) n = n + size(deck%losses)
    allocate (sets(n(1)), regions(n(2)), surfaces(n(3)))
    do i = 1, n(1)
      sets(i)%name = ''
      allocate (sets(i)%nodes(0))
    end do
    do i = 1, n(2)
      regions(i)%name = ''
    end do
    do i = 1, n(3)
      surfaces(i)%name = ''
      allocate (surfaces(i)%facets(3, 0), surfaces(i)%elements(0))
    end do
    call move_alloc(sets, mesh%sets)
    call move_alloc(regions, mesh%regions)
    call move_alloc(surfaces, mesh%surfaces)
    call enter_names(deck, diagnostics, mesh)
    if (allocated(deck%losses)) call enter_lost_names(deck, mesh)
  end subroutine gather_names

  !> Names that data left out because of an error may have defined: they stand behind the others,
  !! for whatever may be looked for, and nothing is in them.
  subroutine enter_lost_names(deck, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(inout) :: mesh !! the mesh
    character(:), allocatable :: name
    integer :: i, n(3)

    n = [size(mesh%sets), size(mesh%regions), size(mesh%surfaces)] - size(deck%losses)
    do i = 1, size(deck%losses)
      name = deck%losses(i)%name
      if (name_exists(mesh, name)) cycle
      mesh%sets(n(1) + i)%name = name
      mesh%regions(n(2) + i)%name = name
      mesh%surfaces(n(3) + i)%name = name
    end do
  end subroutine enter_lost_names

  !> Number of data sets of one command.
  pure integer function command_count(deck, command) result(n)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: command !! its first four letters
    integer :: i

    n = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command == command) n = n + 1
    end do
  end function command_count

  !> Gives sets, regions and surfaces their names, each name once.
  subroutine enter_names(deck, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! the mesh
    character(:), allocatable :: name
    integer :: i, n(3)

    n = 0
    do i = 1, size(deck%mesh)
      associate (set => deck%mesh(i))
        if (all(set%command /= ['set ', 'bloc', 'surf'])) cycle
        name = ''
        if (item_count(set%head) >= 2) name = item_name(set%head, 2)
        if (name_exists(mesh, name)) then
          call report_error(diagnostics, set%head%items(2)%at, 'the name '//name// &
            ' is taken already', 'sets, regions and surfaces share one name space')
          name = ''
        end if
        if (set%command == 'set') then
          n(1) = n(1) + 1
          mesh%sets(n(1))%name = name
          mesh%sets(n(1))%at = set%head%at
        else if (set%command == 'bloc') then
          n(2) = n(2) + 1
          mesh%regions(n(2))%name = name
          mesh%regions(n(2))%at = set%head%at
        else
          n(3) = n(3) + 1
          mesh%surfaces(n(3))%name = name
          mesh%surfaces(n(3))%at = set%head%at
        end if
      end associate
    end do
  end subroutine enter_names

  !> Fills all sets and surfaces of a mesh that is complete. If it is not sound (`sound` false)
  !! only the names are checked.
  subroutine evaluate_parts(deck, sound, diagnostics, mesh, drafts, table)
    type(deck_t), intent(in) :: deck !! the deck
    logical, intent(in) :: sound !! nodes and elements are without error
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(surface_draft_t), intent(in) :: drafts(:) !! surfaces of mesh files
    type(facet_table_t), intent(out) :: table !! exterior facets, if there are surfaces
    type(part_list_t) :: list
    integer, allocatable :: nodes(:), facets(:, :), elements(:)
    integer :: i

    call list_parts(deck, list)
    do i = 1, size(list%parts)
      call visit(deck, mesh, i, diagnostics, list)
    end do
    if (.not. sound) return
    if (size(mesh%surfaces) > 0) call exterior_facets(mesh, table)
    if (table%crowded(1) > 0) call report_error(diagnostics, mesh%surfaces(1)%at, 'elements '// &
      to_text(table%crowded(1))//', '//to_text(table%crowded(2))//' and '// &
      to_text(table%crowded(3))//' share one facet', 'elements overlap; a facet belongs to '// &
      'one or two of them')
    if (table%crowded(1) > 0) return
    call settle_surfaces(drafts, table, diagnostics, mesh)
    do i = 1, list%ordered
      associate (part => list%parts(list%order(i)))
        if (part%set > 0) then
          call select_nodes(deck%mesh(part%command), mesh, diagnostics, nodes)
          call move_alloc(nodes, mesh%sets(part%set)%nodes)
        else if (.not. mesh%surfaces(part%surface)%alone) then
          call select_facets(deck%mesh(part%command), mesh, table, diagnostics, facets, elements)
          call move_alloc(facets, mesh%surfaces(part%surface)%facets)
          call move_alloc(elements, mesh%surfaces(part%surface)%elements)
        end if
      end associate
    end do
  end subroutine evaluate_parts

  !> Lists the sets and surfaces of a deck.
  subroutine list_parts(deck, list)
    type(deck_t), intent(in) :: deck !! the deck
    type(part_list_t), intent(out) :: list !! its sets and surfaces
    integer :: i, n, sets, surfaces

    n = command_count(deck, 'set') + command_count(deck, 'surf')
    allocate (list%parts(n))
    allocate (list%order(n), source=0)
    n = 0
    sets = 0
    surfaces = 0
    do i = 1, size(deck%mesh)
      if (all(deck%mesh(i)%command /= ['set ', 'surf'])) cycle
      n = n + 1
      list%parts(n)%command = i
      if (deck%mesh(i)%command == 'set') then
        sets = sets + 1
        list%parts(n)%set = sets
      else
        surfaces = surfaces + 1
        list%parts(n)%surface = surfaces
      end if
    end do
  end subroutine list_parts

  !> Orders a part behind all that it refers to; undefined and circular names are errors.
  recursive subroutine visit(deck, mesh, i, diagnostics, list)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: mesh !! the mesh, for its names
    integer, intent(in) :: i !! the part
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(part_list_t), intent(inout) :: list !! all parts
    integer :: k, first, command
    logical :: good

    if (list%parts(i)%state /= state_untouched) return
    list%parts(i)%state = state_visiting
    command = list%parts(i)%command
    ! a part whose records were refused is not evaluated, nor what depends on it
    good = deck%mesh(command)%complete
    associate (head => deck%mesh(command)%head)
      if (list%parts(i)%surface > 0 .and. item_count(head) >= 4 .and. &
        .not. is_exact(deck%mesh(command))) then
        call follow(deck, mesh, head%items(4), .false., diagnostics, list, good)
        if (item_count(head) >= 6) then
          call follow(deck, mesh, head%items(6), .true., diagnostics, list, good)
        end if
      end if
    end associate
    do k = 1, deck%mesh(command)%count
      if (list%parts(i)%set == 0) exit
      associate (record => deck%mesh(command)%records(k))
        first = 1
        if (is_word(record%items(1), 'or')) first = 2
        if (item_count(record) < first + 1) cycle
        if (is_word(record%items(first), 'insi')) then
          call follow(deck, mesh, record%items(first + 1), .false., diagnostics, list, good)
        end if
      end associate
    end do
    list%parts(i)%state = merge(state_good, state_bad, good)
    if (.not. good) return
    list%ordered = list%ordered + 1
    list%order(list%ordered) = i
  end subroutine visit

  !> Follows one name that a part refers to.
  recursive subroutine follow(deck, mesh, item, only_region, diagnostics, list, good)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: mesh !! the mesh, for its names
    type(item_t), intent(in) :: item !! the name, with its place in the deck
    logical, intent(in) :: only_region !! nothing but a region will do
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(part_list_t), intent(inout) :: list !! all parts
    logical, intent(inout) :: good !! stays true if the name can be evaluated
    integer :: set, surface, region, i

    if (is_lost_name(deck, item%text)) good = .false.
    call find_region(mesh, item%text, region)
    if (region > 0) return
    if (mesh%nameless .and. .not. name_exists(mesh, item%text)) then
      good = .false.
      return
    end if
    if (only_region) then
      call report_error(diagnostics, item%at, 'there is no region '//item%text, region_hint(mesh))
      good = .false.
      return
    end if
    call find_set(mesh, item%text, set)
    call find_surface(mesh, item%text, surface)
    if (set == 0 .and. surface == 0) then
      call report_error(diagnostics, item%at, 'there is no set, region or surface '//item%text, &
        name_hint(mesh, item%text))
      good = .false.
      return
    end if
    do i = 1, size(list%parts)
      if (set > 0 .and. list%parts(i)%set == set) exit
      if (set == 0 .and. list%parts(i)%surface == surface) exit
    end do
    if (i > size(list%parts)) return ! it comes from a mesh file and depends on nothing
    if (list%parts(i)%state == state_visiting) then
      call report_error(diagnostics, item%at, item%text//' is defined by itself', &
        'break the circle of names')
      good = .false.
      return
    end if
    call visit(deck, mesh, i, diagnostics, list)
    good = good .and. list%parts(i)%state == state_good
  end subroutine follow
end module named_parts

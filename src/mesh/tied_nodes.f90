!> TIE: joins nodes at the same place, but never the two sides of a contact pair.
module tied_nodes
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t, data_set_t
  use records, only: is_word, item_count, item_integer, item_real, item_name
  use diagnostics, only: diagnostics_t, report_error, report_note
  use near_places, only: grid_t, start_grid, sort_grid
  use bonded_faces, only: find_bonded, mark_sides
  use mesh_types, only: mesh_t
  use mesh_building, only: axis_tolerance, place_tolerance
  use mesh_names, only: find_nodes, name_hint
  use cells, only: shapes, kind_of, facet_name, has_middles
  use facets, only: facet_table_t, exterior_facets
  use key_sorting, only: sort_columns, ascending, unique_numbers
  implicit none
  private
  public :: has_tie, join_nodes, kept_node, tie_names, note_gaps, refuse_halves

  !> What one TIE joins: nodes of the first kind with nodes of the second.
  type :: choice_t
    logical, allocatable :: first(:) !! (nodes)
    logical, allocatable :: second(:) !! (nodes)
  end type choice_t

contains

  !> Whether the deck joins nodes.
  pure logical function has_tie(deck)
    type(deck_t), intent(in) :: deck !! the deck

    has_tie = any(deck%mesh%command == 'tie')
  end function has_tie

  !> The node that stands for another one.
  elemental integer function kept_node(mesh, n) result(kept)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: n !! any number

    kept = n
    if (.not. allocated(mesh%tied)) return
    if (n >= 1 .and. n <= size(mesh%tied)) kept = mesh%tied(n)
  end function kept_node

  !> Obeys all TIE commands: fills mesh%tied; elements and `mesh%defined` then know the lowest node
  !! of each place alone.
  subroutine join_nodes(deck, named, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: named !! the mesh before, its sets and surfaces evaluated
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! the mesh, complete
    logical, allocatable :: sides(:, :)
    integer, allocatable :: bonded(:, :)
    type(choice_t) :: choice
    integer :: i, n, joined, apart
    logical :: good

    allocate (mesh%tied(mesh%nodes))
    mesh%tied(:) = [(n, n=1, mesh%nodes)]
    allocate (mesh%to_tie(mesh%nodes), source=.false.)
    call mark_sides(deck, named, sides)
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'tie') cycle
      call choose_nodes(deck%mesh(i), named, diagnostics, choice, good)
      if (.not. good) cycle
      mesh%to_tie = mesh%to_tie .or. choice%first .or. choice%second
      call find_bonded(deck, named, choice%first .or. choice%second, bonded)
      call join_bonded(mesh, choice, bonded, sides, n)
      call join_chosen(mesh, choice, sides, joined, apart)
      joined = joined + n
      call report_note(diagnostics, deck%mesh(i)%head%at, 'TIE joins '// &
        count_noun(joined, 'node')//' to others at the same place'//pairs_text(apart))
    end do
    call rename_nodes(deck, diagnostics, mesh)
  end subroutine join_nodes

  !> How many nodes stay apart because of contact.
  function pairs_text(apart) result(t)
    integer, intent(in) :: apart !! their number
    character(:), allocatable :: t

    t = ''
    if (apart > 0) t = '; '//count_noun(apart, 'place')// &
      ' of the two sides of a contact pair stay apart'
  end function pairs_text

  !> The nodes that a TIE is about: all, NODE n1 n2, MATErial m1 m2, REGIon r1 r2, or ,,i,c.
  subroutine choose_nodes(set, mesh, diagnostics, choice, good)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(choice_t), intent(out) :: choice !! the nodes
    logical, intent(out) :: good !! what it names is there
    integer :: n

    good = .true.
    choice%first = mesh%used
    choice%second = mesh%used
    if (item_count(set%head) < 2) return
    associate (head => set%head)
      if (is_word(head%items(2), 'node')) then
        choice%first = choice%first .and. [(n >= item_integer(head, 3) .and. &
                                            n <= item_integer(head, 4), n=1, mesh%nodes)]
        choice%second = choice%first
      else if (is_word(head%items(2), 'material')) then
        call mark_material(mesh, item_integer(head, 3), choice%first)
        call mark_material(mesh, item_integer(head, 4), choice%second)
      else if (is_word(head%items(2), 'region')) then
        call mark_named(set, 3, mesh, diagnostics, choice%first, good)
        if (good) call mark_named(set, 4, mesh, diagnostics, choice%second, good)
      else
        choice%first = choice%first .and. abs(mesh%x(item_integer(head, 3), :) - &
          item_real(head, 4)) <= axis_tolerance(mesh, item_integer(head, 3))
        choice%second = choice%first
      end if
    end associate
  end subroutine choose_nodes

  !> Nodes of the elements of a material.
  pure subroutine mark_material(mesh, material, mask)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: material !! its number
    logical, intent(out) :: mask(:) !! (nodes)
    integer :: e

    mask = .false.
    do e = 1, mesh%elements
      if (mesh%material(e) /= material .or. mesh%ix(1, e) == 0) cycle
      mask(pack(mesh%ix(:, e), mesh%ix(:, e) > 0)) = .true.
    end do
  end subroutine mark_material

  !> Nodes of a region, set or surface that the head of a TIE names.
  subroutine mark_named(set, i, mesh, diagnostics, mask, good)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: i !! item of the name
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: mask(:) !! (nodes)
    logical, intent(out) :: good !! there is such a name
    integer, allocatable :: nodes(:)

    call find_nodes(mesh, item_name(set%head, i), nodes, good)
    mask = .false.
    if (good) mask(nodes) = .true.
    if (.not. good) call report_error(diagnostics, set%head%items(i)%at, 'there is no set, '// &
      'region or surface '//item_name(set%head, i), name_hint(mesh, item_name(set%head, i)))
  end subroutine mark_named

  !> Joins the chosen nodes that share a place. Nodes that do share one of the cells of at least one
  !! of eight grids, which are half a cell apart.
  subroutine join_chosen(mesh, choice, sides, joined, apart)
    type(mesh_t), intent(inout) :: mesh !! its list of tied nodes
    type(choice_t), intent(in) :: choice !! which nodes
    logical, intent(inout) :: sides(:, :) !! (2 pairs, nodes) sides that what is joined touches
    integer, intent(out) :: joined !! nodes that were joined to others
    integer, intent(out) :: apart !! places that contact keeps apart
    integer, allocatable :: nodes(:), keys(:, :), order(:)
    real(wp) :: tolerance(mesh%nodes)
    type(grid_t) :: grid
    integer :: number, i, j, n
    logical, allocatable :: held(:)

    joined = 0
    nodes = pack([(n, n=1, mesh%nodes)], choice%first .or. choice%second)
    allocate (keys(3, size(nodes)), held(mesh%nodes))
    held(:) = .false.
    tolerance = place_tolerance(mesh)
    grid = start_grid(mesh%x(:, nodes), maxval(tolerance(nodes)))
    do number = 0, 7
      call sort_grid(grid, number, mesh%x(:, nodes), keys, order)
      do i = 2, size(order)
        do j = i - 1, 1, -1
          if (any(keys(:, order(j)) /= keys(:, order(i)))) exit
          call join_pair(mesh, nodes(order(j)), nodes(order(i)), choice, max(tolerance( &
            nodes(order(j))), tolerance(nodes(order(i)))), sides, joined, held)
        end do
      end do
    end do
    apart = count(held)
  end subroutine join_chosen

  !> Joins nodes of facets that are bonded, whatever sides of pairs they are on.
  subroutine join_bonded(mesh, choice, bonded, sides, joined)
    type(mesh_t), intent(inout) :: mesh !! its list of tied nodes
    type(choice_t), intent(in) :: choice !! which nodes
    integer, intent(in) :: bonded(:, :) !! (2, n) nodes
    logical, intent(inout) :: sides(:, :) !! (2 pairs, nodes) sides they touch
    integer, intent(out) :: joined !! nodes that were joined to others
    integer :: i, low, high

    joined = 0
    do i = 1, size(bonded, 2)
      if (.not. (choice%first(bonded(1, i)) .and. choice%second(bonded(2, i)) .or. &
        choice%first(bonded(2, i)) .and. choice%second(bonded(1, i)))) cycle
      low = min(root_of(mesh%tied, bonded(1, i)), root_of(mesh%tied, bonded(2, i)))
      high = max(root_of(mesh%tied, bonded(1, i)), root_of(mesh%tied, bonded(2, i)))
      if (low == high) cycle
      mesh%tied(high) = low
      sides(:, low) = sides(:, low) .or. sides(:, high)
      joined = joined + 1
    end do
  end subroutine join_bonded

  !> Joins two nodes if they may be.
  subroutine join_pair(mesh, first, second, choice, tolerance, sides, joined, held)
    type(mesh_t), intent(inout) :: mesh !! its list of tied nodes
    integer, intent(in) :: first !! a node
    integer, intent(in) :: second !! another one
    type(choice_t), intent(in) :: choice !! which nodes may be joined
    real(wp), intent(in) :: tolerance !! farther apart they are two [length]
    logical, intent(inout) :: sides(:, :) !! (2 pairs, nodes) sides they touch
    integer, intent(inout) :: joined !! counted on
    logical, intent(inout) :: held(:) !! (nodes) kept apart by contact
    integer :: low, high, n

    if (.not. (choice%first(first) .and. choice%second(second) .or. &
      choice%first(second) .and. choice%second(first))) return
    if (norm2(mesh%x(:, first) - mesh%x(:, second)) > tolerance) return
    low = min(root_of(mesh%tied, first), root_of(mesh%tied, second))
    high = max(root_of(mesh%tied, first), root_of(mesh%tied, second))
    if (low == high) return
    n = size(sides, 1)
    if (any(sides(1:n:2, low) .and. sides(2:n:2, high)) .or. &
      any(sides(2:n:2, low) .and. sides(1:n:2, high))) then
      held(low) = .true.
      return
    end if
    mesh%tied(high) = low
    sides(:, low) = sides(:, low) .or. sides(:, high)
    joined = joined + 1
  end subroutine join_pair

  !> The node at the end of a chain of tied ones.
  pure integer function root_of(tied, n) result(root)
    integer, intent(in) :: tied(:) !! (nodes) next node of the chain
    integer, intent(in) :: n !! where it begins

    root = n
    do while (tied(root) /= root)
      root = tied(root)
    end do
  end function root_of

  !> Gives the elements the nodes that are kept.
  subroutine rename_nodes(deck, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer :: e, k, n, first

    do n = 1, mesh%nodes
      mesh%tied(n) = root_of(mesh%tied, n)
      if (mesh%tied(n) /= n) mesh%defined(n) = .false.
      if (mesh%tied(n) /= n) mesh%used(n) = .false.
    end do
    do e = 1, mesh%elements
      do k = 1, size(mesh%ix, 1)
        n = mesh%ix(k, e)
        if (n == 0) exit
        mesh%ix(k, e) = mesh%tied(n)
        if (.not. any(mesh%ix(:k - 1, e) == mesh%tied(n))) cycle
        first = findloc(deck%mesh%command, 'tie ', dim=1)
        call report_error(diagnostics, deck%mesh(first)%head%at, &
          'TIE joins two nodes of element '//to_text(e), &
          'it is smaller than what counts as one place: 1e-8 of the model, or more where its '// &
          'file has fewer digits')
        return
      end do
    end do
  end subroutine rename_nodes

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
    logical :: ten(mesh%elements)
    integer :: f, n, first

    ten = [(has_middles(mesh%ix(:, f)), f=1, mesh%elements)]
    if (all(ten) .or. .not. any(ten)) return
    call list_joined(mesh, key)
    call sort_columns(key(:3, :), order)
    n = 0
    first = 0
    do f = 2, size(order)
      associate (a => key(:, order(f - 1)), b => key(:, order(f)))
        if (any(a(:3) /= b(:3))) cycle
        if (ten(a(4)) .eqv. ten(b(4))) cycle
        n = n + 1
        if (first == 0) first = merge(a(4), b(4), ten(a(4)))
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
        do f = 1, shapes(kind_of(mesh%ix(:, e)))%facets
          associate (corners => facet_name(mesh%ix(:, e), f))
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

  !> Gives the sets and fields of facets of a mesh the nodes that are kept, in order again.
  subroutine tie_names(mesh)
    type(mesh_t), intent(inout) :: mesh !! knows these nodes
    logical, allocatable :: mask(:)
    integer, allocatable :: order(:)
    integer :: i, k

    do i = 1, size(mesh%sets)
      if (size(mesh%sets(i)%nodes) == 0) cycle
      allocate (mask(mesh%nodes), source=.false.)
      mask(kept_node(mesh, mesh%sets(i)%nodes)) = .true.
      mesh%sets(i)%nodes = unique_numbers(mask)
      deallocate (mask)
    end do
    do i = 1, size(mesh%fields)
      associate (field => mesh%fields(i))
        do k = 1, size(field%keys, 2)
          field%keys(:, k) = ascending(kept_node(mesh, field%keys(:, k)))
        end do
        call sort_columns(field%keys, order)
        field%keys = field%keys(:, order)
        field%vectors = field%vectors(:, order)
        field%at = field%at(order)
      end associate
    end do
  end subroutine tie_names
end module tied_nodes

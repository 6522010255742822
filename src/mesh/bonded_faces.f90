!> Faces on each other that are to be joined beside such as are in contact: the sides of contact
!! pairs before TIE, and where a joint and a pair share nodes (doc/theory, "Ties and self contact").
module bonded_faces
  use kinds, only: wp
  use deck_types, only: deck_t, record_t
  use records, only: is_word, item_name
  use key_sorting, only: sort_columns, ascending
  use near_places, only: join_places
  use cells, only: facet_of, most_facet_nodes
  use mesh_types, only: mesh_t
  use mesh_building, only: place_tolerance
  use mesh_names, only: find_nodes, find_surface
  use facets, only: facet_table_t, exterior_facets, find_facet
  implicit none
  private
  public :: find_bonded, mark_sides

contains

  !> The pairs of nodes at one place that belong to two facets on each other which no contact pair
  !! is about: where a joint ends and contact begins, its last nodes are on both sides of the pair,
  !! and without them the joint would end an element too early.
  subroutine find_bonded(deck, named, chosen, bonded)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: named !! the mesh before, its sets and surfaces evaluated
    logical, intent(in) :: chosen(:) !! (nodes) which may be joined
    integer, allocatable, intent(out) :: bonded(:, :) !! (2, n) nodes
    type(facet_table_t) :: table
    logical, allocatable :: on_side(:, :)
    integer, allocatable :: nodes(:), first(:), place(:), keys(:, :), order(:), pairs(:, :)
    real(wp) :: tolerance(named%nodes)
    integer :: n, f, i, k, one(most_facet_nodes), other(most_facet_nodes)

    allocate (bonded(2, 0))
    call exterior_facets(named, table)
    call mark_facets(deck, named, table, on_side)
    if (size(on_side, 1) == 0) return
    tolerance = place_tolerance(named)
    nodes = pack([(n, n=1, named%nodes)], chosen)
    if (size(nodes) == 0) return
    call join_places(named%x(:, nodes), maxval(tolerance(nodes)), first)
    allocate (place(named%nodes), source=0)
    place(nodes) = first
    allocate (keys(3, table%count), pairs(2, most_facet_nodes*table%count))
    do f = 1, table%count
      keys(:, f) = ascending(place(table%corners(:, f)))
      ! a facet with a corner that is not to be joined is on none
      if (keys(1, f) == 0) keys(:, f) = [0, 0, f]
    end do
    call sort_columns(keys, order)
    n = 0
    do i = 2, size(order)
      associate (a => order(i - 1), b => order(i))
        if (keys(1, a) == 0 .or. any(keys(:, a) /= keys(:, b))) cycle
        if (in_contact(on_side(:, a), on_side(:, b))) cycle
        one = facet_of(named%ix(:, table%elements(a)), table%corners(:, a))
        other = facet_of(named%ix(:, table%elements(b)), table%corners(:, b))
      end associate
      do k = 1, most_facet_nodes
        if (one(k) == 0) cycle
        f = findloc(place(pack(other, other > 0)), place(one(k)), dim=1)
        if (f == 0) cycle
        n = n + 1
        pairs(:, n) = [one(k), other(f)]
      end do
    end do
    bonded = pairs(:, :n)
  end subroutine find_bonded

  !> Two facets are the two sides of one contact pair.
  pure logical function in_contact(a, b)
    logical, intent(in) :: a(:) !! (2 pairs) sides that one is on: slave, master
    logical, intent(in) :: b(:) !! those of the other
    integer :: n

    n = size(a)
    in_contact = any(a(1:n:2) .and. b(2:n:2)) .or. any(a(2:n:2) .and. b(1:n:2))
  end function in_contact

  !> Facets of the slave side (odd rows) and of the master side (even rows) of each pair.
  subroutine mark_facets(deck, named, table, on_side)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: named !! the mesh, its sets and surfaces evaluated
    type(facet_table_t), intent(in) :: table !! its exterior facets
    logical, allocatable, intent(out) :: on_side(:, :) !! (2 pairs, facets)
    logical, allocatable :: sides(:, :)
    integer :: pass, i, k, side, n, f, index, place

    call mark_sides(deck, named, sides)
    allocate (on_side(size(sides, 1), table%count), source=.false.)
    n = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'cont') cycle
      do k = 1, deck%mesh(i)%count
        associate (record => deck%mesh(i)%records(k))
          if (.not. is_form(record)) cycle
          do side = 1, 2
            n = n + 1
            call find_surface(named, item_name(record, 1 + side), index)
            if (index == 0) then
              do f = 1, table%count
                on_side(n, f) = all(sides(n, table%corners(:, f)))
              end do
              cycle
            end if
            do pass = 1, size(named%surfaces(index)%facets, 2)
              place = find_facet(table, named%surfaces(index)%facets(:, pass))
              if (place > 0) on_side(n, place) = .true.
            end do
          end do
        end associate
      end do
    end do
  end subroutine mark_facets

  !> A record names the two sides of a pair.
  pure logical function is_form(record)
    type(record_t), intent(in) :: record !! of CONTact

    is_form = is_word(record%items(1), 'ntos') .or. is_word(record%items(1), 'gtos')
  end function is_form

  !> Nodes of the slave side (odd rows) and of the master side (even rows) of each pair.
  subroutine mark_sides(deck, named, sides)
    type(deck_t), intent(in) :: deck !! the deck
    type(mesh_t), intent(in) :: named !! the mesh, its sets and surfaces evaluated
    logical, allocatable, intent(out) :: sides(:, :) !! (2 pairs, nodes)
    integer, allocatable :: nodes(:)
    integer :: pass, i, k, side, n
    logical :: found

    do pass = 1, 2
      n = 0
      do i = 1, size(deck%mesh)
        if (deck%mesh(i)%command /= 'cont') cycle
        do k = 1, deck%mesh(i)%count
          associate (record => deck%mesh(i)%records(k))
            if (.not. is_form(record)) cycle
            do side = 1, 2
              if (pass == 1) cycle
              call find_nodes(named, item_name(record, 1 + side), nodes, found)
              if (found) sides(n + side, nodes) = .true.
            end do
            n = n + 2
          end associate
        end do
      end do
      if (pass == 1) allocate (sides(n, named%nodes), source=.false.)
    end do
  end subroutine mark_sides
end module bonded_faces

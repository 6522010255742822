!> Whether elements of ten nodes fit together: neighbours share the nodes in the middle of their
!! edges (doc/theory, "Ten-node tetrahedron").
module edge_checks
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: deck_t
  use diagnostics, only: diagnostics_t, report_error
  use cells, only: tet10, has_middles, most_nodes
  use key_sorting, only: sort_columns
  use mesh_types, only: mesh_t
  use mesh_building, only: element_origin_t
  implicit none
  private
  public :: check_edges

  !> Wrong edges that are reported one by one.
  integer, parameter :: most_errors = 5
  !> Middles of one edge that are nearer to each other than this share of it lie in one place.
  real(wp), parameter :: same_middle = 1.0e-6_wp
  !> What a list of edges has in its rows: their corners, the middle, the element.
  integer, parameter :: low = 1, high = 2, middle_node = 3, owner = 4

contains

  !> Refuses edges with two nodes in the middle, which may be one only in place (a slit), nodes in
  !! the middle of two edges, and nodes that are a middle here and a corner there.
  subroutine check_edges(deck, origin, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! gets errors
    integer, allocatable :: edge(:, :), by_corners(:), by_middle(:), corner_of(:)
    character(:), allocatable :: what
    integer :: i, wrong

    call list_edges(mesh, edge, corner_of)
    if (size(edge, 2) == 0) return
    call sort_columns(edge([low, high], :), by_corners)
    call sort_columns(edge([middle_node, low, high], :), by_middle)
    wrong = 0
    do i = 1, size(edge, 2)
      what = ''
      if (i > 1) what = two_middles(mesh, edge(:, by_corners(i - 1)), edge(:, by_corners(i)))
      call tell(edge(owner, by_corners(i)))
      what = ''
      if (i > 1) what = two_edges(edge(:, by_middle(i - 1)), edge(:, by_middle(i)))
      call tell(edge(owner, by_middle(i)))
      what = ''
      if (corner_of(edge(middle_node, i)) > 0) what = 'node '//to_text(edge(middle_node, i))// &
        ' is in the middle of an edge of element '//to_text(edge(owner, i))// &
        ' and a corner of element '//to_text(corner_of(edge(middle_node, i)))
      call tell(edge(owner, i))
    end do

  contains

    !> Reports what is wrong with an edge of an element.
    subroutine tell(e)
      integer, intent(in) :: e !! the element

      if (len(what) == 0) return
      wrong = wrong + 1
      if (wrong <= most_errors) call report_error(diagnostics, &
        deck%mesh(origin%set(e))%head%at, what, &
        'neighbours of ten nodes have the corners of an edge and its middle in common; bodies '// &
        'that touch have nodes of their own')
    end subroutine tell
  end subroutine check_edges

  !> The edges of all elements of ten nodes, and of which of these each node is a corner.
  pure subroutine list_edges(mesh, edge, corner_of)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, allocatable, intent(out) :: edge(:, :) !! (4, edges) rows as named above
    integer, allocatable, intent(out) :: corner_of(:) !! (nodes) an element, 0 for none
    integer :: e, m, n

    allocate (corner_of(mesh%nodes), source=0)
    allocate (edge(4, 6*count([(has_middles(mesh%ix(:, e)), e=1, mesh%elements)])))
    n = 0
    do e = 1, mesh%elements
      if (.not. has_middles(mesh%ix(:, e))) cycle
      corner_of(mesh%ix(:4, e)) = e
      do m = 5, most_nodes
        n = n + 1
        associate (ends => mesh%ix(tet10%ends(:, m), e))
          edge(:, n) = [minval(ends), maxval(ends), mesh%ix(m, e), e]
        end associate
      end do
    end do
  end subroutine list_edges

  !> What is wrong with two neighbours in a list ordered by corners; empty if nothing is.
  pure function two_middles(mesh, a, b) result(what)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: a(4), b(4) !! edges
    character(:), allocatable :: what

    what = ''
    if (any(a([low, high]) /= b([low, high])) .or. a(middle_node) == b(middle_node)) return
    if (norm2(mesh%x(:, a(middle_node)) - mesh%x(:, b(middle_node))) <= same_middle* &
      norm2(mesh%x(:, a(low)) - mesh%x(:, a(high)))) return
    what = 'elements '//to_text(a(owner))//' and '//to_text(b(owner))// &
      ' share the edge of nodes '//to_text(a(low))//' and '//to_text(a(high))// &
      ', but not the node in its middle: '//to_text(a(middle_node))//' and '// &
        to_text(b(middle_node))
  end function two_middles

  !> What is wrong with two neighbours in a list ordered by middles; empty if nothing is.
  pure function two_edges(a, b) result(what)
    integer, intent(in) :: a(4), b(4) !! edges
    character(:), allocatable :: what

    what = ''
    if (a(middle_node) /= b(middle_node) .or. all(a([low, high]) == b([low, high]))) return
    what = 'node '//to_text(a(middle_node))//' is in the middle of two edges: that of nodes '// &
      to_text(a(low))//' and '//to_text(a(high))//' of element '//to_text(a(owner))// &
      ', and that of nodes '//to_text(b(low))//' and '//to_text(b(high))//' of element '// &
      to_text(b(owner))
  end function two_edges
end module edge_checks

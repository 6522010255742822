!> The shapes that elements and facets can have: nodes, facets, and what others call them.
!!
!! Nodes stand in the order of FEAP, Abaqus and VTK: corners first, then the middles of the edges.
module cells
  implicit none
  private
  public :: shape_t, shape_of, nodes_of, has_middles, mirrored, facet_of, tet4, tet10, shapes, &
    most_nodes, most_facet_nodes

  !> Most nodes of a cell and of one of its facets.
  integer, parameter :: most_nodes = 10
  integer, parameter :: most_facet_nodes = 6

  !> One shape of a bulk element.
  type :: shape_t
    character(5) :: name = '' !! its keyword
    integer :: nodes = 0 !! number of nodes
    integer :: facet_nodes = 0 !! nodes of each of its four facets
    integer :: facet(most_facet_nodes, 4) = 0 !! nodes of the facets, seen from outside
    integer :: ends(2, 5:most_nodes) = 0 !! corners next to each node in the middle of an edge
    integer :: mirror(most_nodes) = 0 !! order of the nodes in a mirror
    integer :: vtk = 0 !! number of VTK
    integer :: gmsh = 0 !! number of Gmsh
    integer :: from_gmsh(most_nodes) = 0 !! places of its nodes in Gmsh's order
  end type shape_t

  integer, parameter :: facets_of_10(6, 4) = reshape([1, 3, 2, 7, 6, 5, 1, 2, 4, 5, 9, 8, &
    2, 3, 4, 6, 10, 9, 1, 4, 3, 8, 10, 7], [6, 4])
  integer, parameter :: facets_of_4(6, 4) = reshape([1, 3, 2, 0, 0, 0, 1, 2, 4, 0, 0, 0, &
    2, 3, 4, 0, 0, 0, 1, 4, 3, 0, 0, 0], [6, 4])
  integer, parameter :: edges(2, 5:10) = reshape([1, 2, 2, 3, 3, 1, 1, 4, 2, 4, 3, 4], [2, 6])

  !> Tetrahedra of four and of ten nodes.
  type(shape_t), parameter :: tet4 = shape_t('TET4 ', 4, 3, facets_of_4, &
    reshape([0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0], [2, 6]), [1, 2, 4, 3, 0, 0, 0, 0, 0, 0], 10, 4, &
    [1, 2, 3, 4, 0, 0, 0, 0, 0, 0])
  type(shape_t), parameter :: tet10 = shape_t('TET10', 10, 6, facets_of_10, edges, &
    [1, 2, 4, 3, 5, 9, 8, 7, 6, 10], 24, 11, [1, 2, 3, 4, 5, 6, 7, 8, 10, 9])
  type(shape_t), parameter :: shapes(2) = [tet4, tet10]

contains

  !> The shape of an element from its list of nodes, with zeros behind the last.
  pure type(shape_t) function shape_of(nodes) result(shape)
    integer, intent(in) :: nodes(:) !! node numbers

    shape = tet4
    if (size(nodes) < most_nodes) return
    if (nodes(most_nodes) > 0) shape = tet10
  end function shape_of

  !> How many nodes an element has, from its list with zeros behind the last.
  pure integer function nodes_of(nodes) result(n)
    integer, intent(in) :: nodes(:) !! node numbers

    n = tet4%nodes
    if (size(nodes) < most_nodes) return
    if (nodes(most_nodes) > 0) n = tet10%nodes
  end function nodes_of

  !> Whether an element has nodes in the middles of its edges, zeros behind the last.
  pure logical function has_middles(nodes)
    integer, intent(in) :: nodes(:) !! node numbers

    has_middles = nodes_of(nodes) == tet10%nodes
  end function has_middles

  !> The nodes of an element in the order that its mirror image has.
  pure function mirrored(nodes) result(turned)
    integer, intent(in) :: nodes(:) !! node numbers, zeros behind the last
    integer :: turned(size(nodes))
    type(shape_t) :: shape

    shape = shape_of(nodes)
    turned = nodes
    turned(:shape%nodes) = nodes(shape%mirror(:shape%nodes))
  end function mirrored

  !> All nodes of the facet of an element that has these corners: the corners in the order given,
  !! then the middles of the edges 12, 23, 31, if the element has some; zeros behind the last.
  pure function facet_of(nodes, corners) result(facet)
    integer, intent(in) :: nodes(:) !! nodes of the element, zeros behind the last
    integer, intent(in) :: corners(3) !! three of its corners
    integer :: facet(most_facet_nodes)
    type(shape_t) :: shape
    integer :: k, m, pair(2)

    shape = shape_of(nodes)
    facet = 0
    facet(1:3) = corners
    if (shape%facet_nodes < most_facet_nodes) return
    do k = 1, 3
      do m = 5, shape%nodes
        pair = nodes(shape%ends(:, m))
        if (all(pair == corners([k, mod(k, 3) + 1])) .or. &
          all(pair == corners([mod(k, 3) + 1, k]))) facet(3 + k) = nodes(m)
      end do
    end do
  end function facet_of
end module cells

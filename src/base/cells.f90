!> The shapes that cells and facets can have: nodes, facets, and what others call them.
!!
!! Nodes stand in the order of FEAP, Abaqus and VTK: corners first, then the middles of the edges;
!! facets in the order of Abaqus.
module cells
  implicit none
  private
  public :: shape_t, kind_of, nodes_of, corners_of, has_middles, mirrored, facet_name, &
    facet_of, tet4, tet10, brick, shapes, file_shapes, most_nodes, most_facet_nodes, &
    most_cell_facets

  !> Most nodes of a cell and of one of its facets, and most facets of an element.
  integer, parameter :: most_nodes = 10
  integer, parameter :: most_facet_nodes = 6
  integer, parameter :: most_cell_facets = 4

  !> One shape of a cell, or of a facet, line or point. What is zero or empty is not asked for.
  type :: shape_t
    character(5) :: name = '' !! its keyword
    integer :: dimension = 3 !! point 0, line 1, triangle 2, cell 3
    integer :: corners = 0 !! number of corners
    integer :: nodes = 0 !! number of nodes
    integer :: facets = 0 !! number of facets
    integer :: facet_nodes = 0 !! nodes of each of them
    integer :: facet(most_facet_nodes, 6) = 0 !! nodes of the facets, seen from outside
    integer :: ends(2, 5:most_nodes) = 0 !! corners next to each node in the middle of an edge
    integer :: pieces = 1 !! tetrahedra between its corners
    integer :: piece(4, 6) = 0 !! their corners
    integer :: mirror(most_nodes) = 0 !! order of the nodes in a mirror
    integer :: vtk = 0 !! number of VTK
    integer :: gmsh = 0 !! number of Gmsh
    integer :: from_gmsh(most_nodes) = 0 !! places of its nodes in Gmsh's order
    character(56) :: abaqus = '' !! types of Abaqus that are read as this one
  end type shape_t

  integer, parameter :: corners_1234(4, 6) = reshape([1, 2, 3, 4], [4, 6], pad=[0])

  !> Tetrahedra of four and of ten nodes.
  type(shape_t), parameter :: tet4 = shape_t(name='TET4', corners=4, nodes=4, facets=4, &
    facet_nodes=3, facet=reshape([1, 3, 2, 0, 0, 0, 1, 2, 4, 0, 0, 0, &
    2, 3, 4, 0, 0, 0, 1, 4, 3], [6, 6], pad=[0]), piece=corners_1234, &
    mirror=[1, 2, 4, 3, 0, 0, 0, 0, 0, 0], vtk=10, gmsh=4, &
    from_gmsh=[1, 2, 3, 4, 0, 0, 0, 0, 0, 0], abaqus='c3d4 c3d4h')
  type(shape_t), parameter :: tet10 = shape_t(name='TET10', corners=4, nodes=10, facets=4, &
    facet_nodes=6, facet=reshape([1, 3, 2, 7, 6, 5, 1, 2, 4, 5, 9, 8, &
    2, 3, 4, 6, 10, 9, 1, 4, 3, 8, 10, 7], [6, 6], pad=[0]), &
    ends=reshape([1, 2, 2, 3, 3, 1, 1, 4, 2, 4, 3, 4], [2, 6]), piece=corners_1234, &
    mirror=[1, 2, 4, 3, 5, 9, 8, 7, 6, 10], vtk=24, gmsh=11, &
    from_gmsh=[1, 2, 3, 4, 5, 6, 7, 8, 10, 9], &
    abaqus='c3d10 c3d10h c3d10m c3d10mh c3d10hs c3d10t')
  !> Those that elements have.
  type(shape_t), parameter :: shapes(2) = [tet4, tet10]

  !> Those of mesh files.
  type(shape_t), parameter :: file_shapes(8) = [shapes, &
    shape_t(dimension=2, nodes=3, gmsh=2, &
    abaqus='s3 s3r stri3 cps3 cpe3 cax3 m3d3 sfm3d3 r3d3 ds3'), &
    shape_t(dimension=2, nodes=6, gmsh=9, abaqus='s6 cps6 cpe6 cax6 m3d6 stri65 ds6'), &
    shape_t(dimension=2, nodes=4, abaqus='r3d4'), &
    shape_t(dimension=1, nodes=2, gmsh=1, &
    abaqus='t3d2 t2d2 b31 b31h b21 r2d2 rb3d2 dc1d2'), &
    shape_t(dimension=1, nodes=3, gmsh=8, abaqus='b32 b32h t3d3'), &
    shape_t(dimension=0, nodes=1, gmsh=15)]

  !> A cell of BLOCk or of ELEMents SPLIt: corners 1 to 4 of the lower face, 5 to 8 above them. Its
  !! tetrahedra all hold the diagonal 1-7 and cut each facet from its first corner to its third, so
  !! that neighbouring cells share the diagonals of their common faces.
  type(shape_t), parameter :: brick = shape_t(name='', corners=8, nodes=8, facets=6, &
    facet_nodes=4, facet=reshape([1, 4, 3, 2, 0, 0, 5, 6, 7, 8, 0, 0, 1, 2, 6, 5, 0, 0, &
    2, 3, 7, 6, 0, 0, 4, 8, 7, 3, 0, 0, 1, 5, 8, 4, 0, 0], [6, 6]), &
    pieces=6, piece=reshape([1, 2, 3, 7, 1, 3, 4, 7, 1, 4, 8, 7, &
    1, 8, 5, 7, 1, 5, 6, 7, 1, 6, 2, 7], [4, 6]))

contains

  !> Which of the shapes an element has, from its list of nodes with zeros behind the last.
  pure integer function kind_of(nodes) result(k)
    integer, intent(in) :: nodes(:) !! node numbers
    integer :: n

    n = nodes_of(nodes)
    do k = 1, size(shapes) - 1
      if (shapes(k)%nodes == n) return
    end do
  end function kind_of

  !> How many nodes an element has, from its list with zeros behind the last; as many as the least
  !! of all has if it is not there.
  pure integer function nodes_of(nodes) result(n)
    integer, intent(in) :: nodes(:) !! node numbers

    n = max(tet4%nodes, count(nodes /= 0))
  end function nodes_of

  !> The corners of an element.
  pure function corners_of(nodes) result(corners)
    integer, intent(in) :: nodes(:) !! node numbers, zeros behind the last
    integer, allocatable :: corners(:)

    corners = nodes(:shapes(kind_of(nodes))%corners)
  end function corners_of

  !> Whether an element has nodes in the middles of its edges, zeros behind the last.
  pure logical function has_middles(nodes)
    integer, intent(in) :: nodes(:) !! node numbers
    integer :: k

    k = kind_of(nodes)
    has_middles = shapes(k)%nodes > shapes(k)%corners
  end function has_middles

  !> The nodes of an element in the order that its mirror image has.
  pure function mirrored(nodes) result(turned)
    integer, intent(in) :: nodes(:) !! node numbers, zeros behind the last
    integer :: turned(size(nodes)), k

    turned = nodes
    k = kind_of(nodes)
    turned(:shapes(k)%nodes) = nodes(shapes(k)%mirror(:shapes(k)%nodes))
  end function mirrored

  !> The three corners that a facet of an element is known by, seen from outside.
  pure function facet_name(nodes, f) result(corners)
    integer, intent(in) :: nodes(:) !! nodes of the element, zeros behind the last
    integer, intent(in) :: f !! which facet
    integer :: corners(3)

    corners = nodes(shapes(kind_of(nodes))%facet(:3, f))
  end function facet_name

  !> All nodes of the facet of an element that has these corners: the corners in the order given,
  !! then the middles of the edges 12, 23, 31, if the element has some; zeros behind the last.
  pure function facet_of(nodes, corners) result(facet)
    integer, intent(in) :: nodes(:) !! nodes of the element, zeros behind the last
    integer, intent(in) :: corners(3) !! three of its corners
    integer :: facet(most_facet_nodes)
    integer :: k, i, m, pair(2)

    facet = 0
    facet(1:3) = corners
    k = kind_of(nodes)
    do i = 1, 3
      do m = shapes(k)%corners + 1, shapes(k)%nodes
        pair = nodes(shapes(k)%ends(:, m))
        if (all(pair == corners([i, mod(i, 3) + 1])) .or. &
          all(pair == corners([mod(i, 3) + 1, i]))) facet(3 + i) = nodes(m)
      end do
    end do
  end function facet_of
end module cells

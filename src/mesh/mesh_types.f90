!> What a mesh is: nodes, elements, and the named sets, regions and surfaces of them.
module mesh_types
  use kinds, only: wp
  use vectors, only: identity
  use deck_types, only: location_t
  implicit none
  private
  public :: mesh_t, node_set_t, region_t, surface_t, facet_field_t
  !> A named set of nodes.
  type :: node_set_t
    character(:), allocatable :: name !! its name
    type(location_t) :: at !! where the deck defines it
    integer, allocatable :: nodes(:) !! node numbers, ascending, no doubles
  end type node_set_t

  !> A named group of elements (a BLOCk, a physical volume of a mesh file).
  type :: region_t
    character(:), allocatable :: name !! its name; empty for a block without one
    type(location_t) :: at !! where the deck defines it
    integer, allocatable :: elements(:) !! its elements, if mesh%region does not tell them all
  end type region_t

  !> A named set of exterior facets.
  type :: surface_t
    character(:), allocatable :: name !! its name
    type(location_t) :: at !! where the deck defines it
    integer, allocatable :: facets(:, :) !! (3, n) corner nodes, counter-clockwise seen from outside
    integer, allocatable :: elements(:) !! (n) the element behind each facet, 0 for none
    logical :: alone = .false. !! nothing is behind it: rigid, and master only
    logical :: exact = .false. !! alone, and a plane, cylinder or sphere
    integer, allocatable :: inner(:, :) !! (3, n) what the corners are round about, if it is round
  end type surface_t

  !> Vectors of facets from a mesh file.
  type :: facet_field_t
    character(:), allocatable :: name !! its name in the file
    integer :: file = 0 !! number of the file in the source
    integer, allocatable :: keys(:, :) !! (3, n) corners ascending; columns lexicographic
    real(wp), allocatable :: vectors(:, :) !! (3, n) components
    integer, allocatable :: at(:) !! (n) character of the file where each stands
  end type facet_field_t

  !> The mesh as the deck describes it. Node and element numbers are the deck's own.
  type :: mesh_t
    logical :: sound = .false. !! nothing in it is wrong or missing: it can be computed with
    logical :: filled = .false. !! all nodes and elements are there, maybe not at their right places
    logical :: nameless = .false. !! names may be missing, for what defines them could not be read
    integer :: misplaced = 0 !! errors of nodes with two places and of elements
    integer :: nodes = 0 !! highest node number
    integer :: exact_nodes = 0 !! the last so many belong to exact surfaces
    integer :: elements = 0 !! highest element number
    real(wp), allocatable :: x(:, :) !! (3, nodes) reference coordinates
    real(wp), allocatable :: rounding(:, :) !! (3, nodes) what files have rounded it by [length]
    real(wp), allocatable :: spacing(:) !! (nodes) shortest edge of an element there [length]
    logical, allocatable :: defined(:) !! (nodes) the deck gave this node coordinates
    logical, allocatable :: used(:) !! (nodes) an element holds this node
    integer, allocatable :: ix(:, :) !! (most_nodes, elements) nodes; zeros behind the last
    integer, allocatable :: material(:) !! (elements) material number
    integer, allocatable :: region(:) !! (elements) index into regions, 0 for none
    type(region_t), allocatable :: regions(:) !! regions in the order of the deck
    type(node_set_t), allocatable :: sets(:) !! node sets in the order of the deck
    type(surface_t), allocatable :: surfaces(:) !! surfaces in the order of the deck
    type(facet_field_t), allocatable :: fields(:) !! vectors of facets, in the order of the deck
    real(wp) :: turn(3, 3) = identity !! TRANsform while the mesh is read
    logical :: mirrors = .false. !! it makes left-handed elements of right-handed ones
    real(wp) :: shift(3) = 0.0_wp !! x = turn x + shift [length]
    integer, allocatable :: tied(:) !! (nodes) the node that TIE keeps for each; none without TIE
    logical, allocatable :: to_tie(:) !! (nodes) some TIE is about it, of nodes that are kept
  end type mesh_t
end module mesh_types

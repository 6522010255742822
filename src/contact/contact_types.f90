!> What a contact pair is: what the deck asks for, and the points and facets built from it.
module contact_types
  use kinds, only: wp
  use deck_types, only: location_t
  use facet_tree, only: facet_tree_t
  use friction_laws, only: n_law_values
  use mortar_types, only: mortar_t
  use element_types, only: status_off, status_open, status_stick, status_slip
  implicit none
  private
  public :: pair_t, master_surface_t, pair_points_t, contact_point_t, cell_t, &
    point_history_t, forget_moves
  public :: form_node_to_surface, form_quadrature_to_surface
  public :: penalty_nodal, penalty_area, penalty_auto, penalty_own, own_factor
  public :: direction_vector, direction_circumferential, direction_radial, direction_field
  public :: status_open, status_stick, status_slip, status_off

  !> Forms of contact: NTOS and GTOS.
  integer, parameter :: form_node_to_surface = 1
  integer, parameter :: form_quadrature_to_surface = 2

  !> Ways to give the penalty: force per length and node; pressure per length; as a factor of E/h;
  !! and that of the layer that is pressed.
  integer, parameter :: penalty_nodal = 1
  integer, parameter :: penalty_area = 2
  integer, parameter :: penalty_auto = 3
  integer, parameter :: penalty_own = 4
  !> Penalty over the stiffness of the layer of elements that is pressed, where the deck leaves it
  !! to the program (doc/theory, "Penalty").
  real(wp), parameter :: own_factor = 20.0_wp

  !> Ways to give the principal friction axis.
  integer, parameter :: direction_vector = 1
  integer, parameter :: direction_circumferential = 2
  integer, parameter :: direction_radial = 3
  integer, parameter :: direction_field = 4

  !> History of one contact point (doc/theory, "Facet and gap"): kept at the last
  !! converged state and at the current one, swapped when an increment is accepted.
  type :: contact_point_t
    integer :: target = 0 !! facet of the pair that carries the apex, 0 for none
    integer :: status = status_off !! one of the status constants
    real(wp) :: apex(2) = 0.0_wp !! (xi, eta) of the apex in the target facet
    real(wp) :: lambda(3) = 0.0_wp !! multiplier in the frame of the target facet [force]
    real(wp) :: path = 0.0_wp !! way slipped since the touch [length]
    real(wp) :: way(3) = 0.0_wp !! the same with its directions: sum of the ways of the apex
    !! [length]
    real(wp) :: dissipation = 0.0_wp !! energy that friction has taken so far [force length]
  end type contact_point_t

  !> Where a point of a segmented pair is (doc/theory, "Segmentation").
  type :: cell_t
    integer :: slave = 0 !! slave facet, 0 while the point is not in use
    real(wp) :: weight(3) = 1.0_wp/3.0_wp !! where in it: shape functions of its corners alone
    real(wp) :: area = 0.0_wp !! reference area, 0 if the facet has no master under it
    real(wp) :: place(2) = 0.0_wp !! projection on the target when the cell was made
  end type cell_t

  !> The cells that a slave facet has left for others.
  type :: cut_t
    type(cell_t), allocatable :: cells(:) !! of the facet
  end type cut_t

  !> The friction of a pair, as the deck gives it.
  type :: pair_friction_t
    real(wp) :: mu(2) = 0.0_wp !! principal coefficients of friction; both 0 is frictionless
    integer :: direction = direction_vector !! one of the direction constants
    type(location_t) :: direction_at !! where the deck gives the direction
    real(wp) :: axis(3) = [1.0_wp, 0.0_wp, 0.0_wp] !! unit: the vector, or the axis of turning
    real(wp) :: point(3) = 0.0_wp !! a point on the axis of turning
    character(:), allocatable :: field !! DIREction FIELd: its name in the mesh file
    real(wp) :: angle = 0.0_wp !! turn about the facet normal [degree]
    logical :: convected = .false. !! DIREction MATErial: fixed in the reference facet
    integer :: slip_rule = 0 !! m of doc/theory: 0 collinear, 1 tensor, 2 associated
  end type pair_friction_t

  !> ADJUst: slave nodes next to the master are moved onto it.
  type :: pair_fit_t
    logical :: adjusted = .false. !! ADJUst: slave nodes next to the master are moved onto it
    real(wp) :: adjust = 0.0_wp !! its tolerance, 0: from the facet size [length]
    integer :: moved = 0 !! slave nodes that it has moved
    real(wp) :: farthest_way = 0.0_wp !! the longest way of one of them [length]
    integer :: farthest = 0 !! which one
  end type pair_fit_t

  !> The master surface of a pair; what its facets are does not change in a run.
  type :: master_surface_t
    integer, allocatable :: facets(:, :) !! (3, facets) master facets, outward side as in surface_t
    integer, allocatable :: middles(:, :) !! (3, facets) nodes on the edges 12, 23, 31, 0: none;
    !! only if some facet has six nodes; of a round surface, what the corners are round about
    logical :: exact = .false. !! a plane, cylinder or sphere, with facets that grow far away
    logical :: round = .false. !! its facets are parts of a sphere or cylinder
    integer, allocatable :: facet_elements(:) !! (facets) element behind each master facet
    integer, allocatable :: neighbours(:, :) !! (3, facets) facet facing corner k, 0: boundary
    real(wp), allocatable :: facet_axis(:, :) !! (3, facets) vectors of FIELd, if it is one
    real(wp), allocatable :: lay(:, :) !! (6, facets) c at corner 3, dc/dxi, dc/deta, if convected
    logical, allocatable :: concave(:, :) !! (3, facets) the edge facing corner k is concave
    logical, allocatable :: convex(:, :) !! (3, facets) the edge facing corner k is convex
    logical, allocatable :: sharp(:, :) !! (3, facets) if curved: the edge facing corner k is kept
    integer, allocatable :: corner(:, :) !! (3, facets) corners of one number share their normal
    logical, allocatable :: at_boundary(:) !! (corners) at a boundary or a sharp edge
    logical, allocatable :: at_end(:) !! (corners) the boundary turns there
    real(wp), allocatable :: patch(:, :) !! (n_patch_values, facets) patches, see smooth_patch
    real(wp), allocatable :: excess(:, :) !! (3, facets) if it overlaps: how much farther out the
    !! patch lies than the round edge facing corner k, times 4 in its middle, at the start [length]
    real(wp), allocatable :: patch_way(:, :, :) !! (n_patch_values, facets, 3) first touches: those
    !! at the start of the increment, at the end of the free way, and of the first pass
    type(facet_tree_t) :: tree !! boxes over the facets
    integer, allocatable :: body(:) !! (facets) body of each, if some slave belongs to one of these
    real(wp), allocatable :: depth(:) !! (facets) nearly the thickness of the body behind each; only
    !! if some is less than the search radius [length]
  end type master_surface_t

  !> SHRInk: an overlap at the start that is taken up step by step.
  type :: pair_shrink_t
    integer :: shrink = -1 !! SHRInk: number of its table, -1 without
    type(location_t) :: shrink_at !! where the deck gives it
    real(wp), allocatable :: overlap(:, :) !! SHRInk: (1, points), or (3, slave facets) at corners
    !! (6: and middles) if segmented: below the master at the start, negative for a gap [length]
    real(wp), allocatable :: excess(:) !! (points) if smooth, overlapping and not segmented: how
    !! much too far out patches lie there at the start [length]
    real(wp) :: withheld = 0.0_wp !! its share that is not taken up in this increment
  end type pair_shrink_t

  !> The contact points of a pair, and the slave facets they lie on.
  type :: pair_points_t
    integer :: n_slaves = 1 !! slave nodes that make a point: 1 a node, 3 or 6 a point of a facet
    integer, allocatable :: point_nodes(:, :) !! (n_slaves, points) slave nodes
    real(wp), allocatable :: point_weights(:, :) !! (n_slaves, points) M_b of x_S = sum M_b x_b
    real(wp), allocatable :: area(:) !! (points) reference area of a point, 0 without surface
    real(wp), allocatable :: epsilon(:) !! (points) penalty, force per length
    integer, allocatable :: body(:) !! (points; slave facets if segmented) body of each, if those of
    !! the master are known
    integer, allocatable :: slave_facets(:, :) !! (3, slave facets) corners, if segmented or NTOS
    logical, allocatable :: at_boundary(:) !! (slave nodes) if NTOS: at the slave's boundary
    integer, allocatable :: ring(:) !! if NTOS: slave facets around each slave node
    integer, allocatable :: ring_end(:) !! (slave nodes) where those of a node end
    real(wp), allocatable :: slave_area(:) !! (slave facets) if segmented: reference areas
    integer, allocatable :: slave_middles(:, :) !! (3, slave facets) if segmented: nodes on the
    !! edges 12, 23, 31, 0: none; only if some facet has six nodes
    real(wp), allocatable :: slave_shape(:, :, :) !! (3, 6, slave facets) if so: reference
    !! positions of all six
    real(wp) :: density = 0.0_wp !! if segmented: penalty over area [force/length^3]
    real(wp) :: relative = 0.0_wp !! largest epsilon over E/h A, 0 if unknown
    real(wp) :: cell = 0.0_wp !! this h, the mean cell size of the softer side [length]
    integer :: slots = 1 !! contacts that a point can hold at once; the points repeat
    type(master_surface_t) :: side !! GTOS with SMOOth: the slave's facets, bent as the master's
  end type pair_points_t

  !> What the contact points of a pair remember, and where the search has them.
  type :: point_history_t
    type(contact_point_t), allocatable :: old(:) !! (points) history at the last converged state
    type(contact_point_t), allocatable :: new(:) !! (points) history of the current iterate
    type(contact_point_t), allocatable :: start(:) !! (points) where the increment starts them
    logical :: crowded = .false. !! if segmented: cells have found no room for all their points
    logical :: crowd_told = .false. !! and the user has been told
    type(cell_t), allocatable :: old_cells(:) !! (points) if segmented: where `old` is
    type(cell_t), allocatable :: cells(:) !! (points) if segmented: where `new` is
    real(wp) :: raise = 1.0_wp !! with multipliers: factor on epsilon at present
    logical :: softened = .false. !! a stiff penalty that is solved for by multipliers
    integer, allocatable :: left(:) !! (points) target left last in this increment
    type(cut_t), allocatable :: left_cells(:) !! (slave facets) if segmented: cells left last in it
    integer, allocatable :: moves(:) !! (points) changes of target in this increment
    logical :: begun = .false. !! if segmented: the first cells of this increment are known
    type(cell_t), allocatable :: first_cells(:) !! (points) these
    type(contact_point_t), allocatable :: first(:) !! (points) `new` with them
    logical :: returned = .true. !! `new` is that of the last state, not yet of this increment
    integer :: cuts = 0 !! if segmented: facets cut to cells that are yet to be counted
  end type point_history_t

  !> One contact pair.
  type :: pair_t
    ! What the deck says
    integer :: number = 0 !! the deck's pair number
    character(:), allocatable :: name !! its name, or its number as text
    type(location_t) :: at !! where the deck defines it
    integer :: form = form_node_to_surface !! NTOS or GTOS
    integer :: facet_points = 3 !! GTOS: quadrature points of a slave facet
    logical :: segmented = .false. !! GTOS: points on the intersections of the facets
    character(:), allocatable :: slave !! name of the slave set or surface
    character(:), allocatable :: master !! name of the master surface
    type(location_t) :: slave_at !! where the deck names the slave
    type(location_t) :: master_at !! where the deck names the master
    integer :: penalty_kind = penalty_own !! one of the penalty constants
    real(wp) :: penalty = own_factor !! its value, or the factor on a stiffness
    real(wp) :: law(n_law_values) = 0.0_wp !! values of the laws that change the cone
    real(wp) :: search_radius = 0.0_wp !! 0: from the facet size
    logical :: smooth = .false. !! SMOOth: curved patches with continuous normals
    logical :: augmented = .false. !! AUGMent: multipliers take over from the penalty
    logical :: mortar = .false. !! MORTar: segmented, with multipliers at the slave nodes
    real(wp) :: augment_tolerance = 1.0e-6_wp !! see doc/theory, "Augmented Lagrangian"
    integer :: augment_most = 0 !! most updates of multipliers in an increment, 0: by the form

    ! What is built from it when the mesh is complete
    type(pair_friction_t) :: friction !! its friction
    type(pair_fit_t) :: fit !! ADJUst
    type(master_surface_t) :: surface !! its master surface
    type(pair_shrink_t) :: shrinking !! SHRInk
    type(pair_points_t) :: points !! its contact points
    type(point_history_t) :: history !! what they remember
    type(mortar_t) :: nodes !! MORTar: multipliers of the present iterate
    type(mortar_t) :: old_nodes !! the same of the last converged state
    integer, allocatable :: faces(:) !! (master facets) MORTar: face that each belongs to
    integer, allocatable :: carrier(:) !! (nodes) MORTar: slave node that has the multiplier of each
  end type pair_t

contains

  !> Points forget the targets that they have left in this increment, and may go back to them.
  pure subroutine forget_moves(pair)
    type(pair_t), intent(inout) :: pair !! gets left, moves, left_cells

    pair%history%left = 0
    pair%history%moves = 0
    if (.not. pair%segmented) return
    if (allocated(pair%history%left_cells)) deallocate (pair%history%left_cells)
    allocate (pair%history%left_cells(size(pair%points%slave_facets, 2)))
  end subroutine forget_moves
end module contact_types

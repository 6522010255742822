!> Facets of the master: their nodes, their surface, and which of them are quadratic.
module master_facets
  use kinds, only: wp
  use contact_types, only: pair_t
  use facet_geometry, only: corners, barycentric, facet_normal
  use element_types, only: routine_mfec, routine_smooth, routine_quadratic, routine_round
  use quadratic_facet, only: facet_shapes_t, facet_shapes, facet_weights, facet_of_routine
  use vectors, only: cross
  implicit none
  private
  public :: is_quadratic, is_plane, facet_kind, all_nodes, all_corners, facet_routine, &
    field_on_facet, find_sharp_edges, normal_at_edge

  !> Quadratic facets whose normals differ by more than this cosine tells do not go on smoothly.
  real(wp), parameter :: smooth_facet_cosine = 0.7_wp

contains

  !> A facet has six nodes.
  pure logical function is_quadratic(pair, facet)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet

    is_quadratic = .false.
    if (allocated(pair%surface%middles)) is_quadratic = pair%surface%middles(1, facet) > 0
  end function is_quadratic

  !> What a facet is: flat, bent or round.
  pure integer function facet_kind(pair, facet) result(kind)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet

    kind = facet_of_routine(facet_routine(pair, facet))
  end function facet_kind

  !> The nodes of a facet: its corners, then the middles of its edges if it has some.
  pure function all_nodes(pair, facet) result(nodes)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    integer, allocatable :: nodes(:)

    nodes = pair%surface%facets(:, facet)
    if (is_quadratic(pair, facet)) nodes = [nodes, pair%surface%middles(:, facet)]
  end function all_nodes

  !> Positions of the six nodes of a quadratic facet; x(:, nodes) as an argument would be copied to
  !! the heap.
  pure function all_corners(pair, facet, x) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: y(3, 6)

    y(:, :3) = corners(x, pair%surface%facets(:, facet))
    y(:, 4:) = corners(x, pair%surface%middles(:, facet))
  end function all_corners

  !> The contact element on a facet.
  pure integer function facet_routine(pair, facet) result(routine)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet

    routine = routine_mfec
    if (pair%smooth) routine = routine_smooth
    if (is_quadratic(pair, facet)) routine = merge(routine_round, routine_quadratic, &
      pair%surface%round)
  end function facet_routine

  !> A nodal field, positions or displacements, at a place of a facet.
  pure function field_on_facet(pair, facet, x, field, xi) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: field(:, :) !! (3, nodes) the field
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: y(3)

    if (is_quadratic(pair, facet)) then
      y = matmul(all_corners(pair, facet, field), facet_weights(xi, facet_kind(pair, facet), &
        all_corners(pair, facet, x)))
    else
      y = matmul(field(:, pair%surface%facets(:, facet)), barycentric(xi))
    end if
  end function field_on_facet

  !> A master facet is plane: the middles of its edges lie in the plane of its corners.
  pure logical function is_plane(pair, x, facet, normal, flat) result(plane)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: normal(3) !! of its corners
    real(wp), intent(in) :: flat !! most square of the angle of an edge [rad^2]
    real(wp) :: c(3, 3), m(3, 3)

    plane = .not. (pair%smooth .or. is_quadratic(pair, facet) .and. pair%surface%round)
    if (.not. (plane .and. is_quadratic(pair, facet))) return
    c = corners(x, pair%surface%facets(:, facet))
    m = corners(x, pair%surface%middles(:, facet)) - c
    plane = maxval(matmul(normal, m)**2) <= flat*maxval(sum(m*m, 1))
  end function is_plane

  !> Marks the edges of quadratic facets beyond which the surface does not go on smoothly.
  pure subroutine find_sharp_edges(pair, x)
    type(pair_t), intent(inout) :: pair !! facets, middles, neighbours given; gets sharp
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: f, k, across

    allocate (pair%surface%sharp(3, size(pair%surface%facets, 2)), source=.true.)
    do f = 1, size(pair%surface%facets, 2)
      do k = 1, 3
        across = pair%surface%neighbours(k, f)
        if (across == 0) cycle
        pair%surface%sharp(k, f) = dot_product(normal_at_edge(pair, x, f, across), &
          normal_at_edge(pair, x, across, f)) < smooth_facet_cosine
      end do
    end do
  end subroutine find_sharp_edges

  !> Unit normal in the middle of the edge that a facet shares with another.
  pure function normal_at_edge(pair, x, facet, across) result(normal)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: facet !! the facet
    integer, intent(in) :: across !! its neighbour
    real(wp) :: normal(3), l(3), t(3, 2)
    type(facet_shapes_t) :: s

    if (.not. is_quadratic(pair, facet)) then
      normal = facet_normal(corners(x, pair%surface%facets(:, facet)))
      return
    end if
    l = merge(0.0_wp, 0.5_wp, pair%surface%neighbours(:, facet) == across)
    s = facet_shapes(l(1:2), facet_kind(pair, facet), all_corners(pair, facet, x))
    t = matmul(all_corners(pair, facet, x), s%d)
    normal = cross(t(:, 1), t(:, 2))
    normal = normal/norm2(normal)
  end function normal_at_edge
end module master_facets

!> Sharp convex edges of a master, where the apex alone does not tell the facet (doc/theory,
!! "Convex feature edges").
!!
!! A point that is below both facets of a convex edge of 90 degrees projects into both of them,
!! however far it follows one. There the facet counts that it is closer to and that faces its slave
!! side.
module convex_edges
  use kinds, only: wp
  use vectors, only: cross
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_position
  use facet_geometry, only: corners, project_on_facet, barycentric, facet_normal, is_convex, &
    kink_sine, unfold
  use smooth_normals, only: carry_over
  implicit none
  private
  public :: find_convex_edges, find_rings, convex_edge_t, look_at_convex_edges, kink, pass_edge

  !> Most facets between one that touches a convex edge with a corner only and the convex edge.
  integer, parameter :: most_between = 4
  !> Steps of a walk on the far side of a convex edge.
  integer, parameter :: longest_far_walk = 100

  !> What the convex edges around a target say of a point.
  type :: convex_edge_t
    integer :: next = 0 !! the facet it belongs to, 0 if the apex may decide
    integer :: via(most_between) = 0 !! facets in between if `next` is no neighbour of the target
    logical :: barred(3) = .false. !! edges of the target that the apex must not cross
  end type convex_edge_t

  !> Share of a kink that patches leave of it at most.
  real(wp), parameter :: left_by_patches = 0.01_wp

contains

  !> Marks the convex edges of the master.
  subroutine find_convex_edges(pair, x)
    type(pair_t), intent(inout) :: pair !! gets convex
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: f, k

    if (allocated(pair%surface%convex)) deallocate (pair%surface%convex)
    if (pair%segmented) return
    allocate (pair%surface%convex(3, size(pair%surface%facets, 2)), source=.false.)
    do f = 1, size(pair%surface%facets, 2)
      do k = 1, 3
        if (pair%surface%neighbours(k, f) == 0) cycle
        pair%surface%convex(k, f) = is_convex(corners(x, pair%surface%facets(:, f)), &
          corners(x, pair%surface%facets(:, pair%surface%neighbours(k, f))))
      end do
    end do
    if (.not. any(pair%surface%convex)) deallocate (pair%surface%convex)
  end subroutine find_convex_edges

  !> The slave facets around the slave nodes, one node after the other.
  subroutine find_rings(pair)
    type(pair_t), intent(inout) :: pair !! slave_facets given; gets ring, ring_end
    integer :: place(0:maxval(pair%points%slave_facets)), f, k, p, n

    n = count_points(pair)/pair%points%slots
    if (n == 0) return
    place = 0
    do p = 1, n
      if (pair%points%point_nodes(1, p) < size(place)) place(pair%points%point_nodes(1, p)) = p
    end do
    pair%points%ring_end = spread(0, 1, n)
    do f = 1, size(pair%points%slave_facets, 2)
      do k = 1, 3
        p = place(pair%points%slave_facets(k, f))
        if (p > 0) pair%points%ring_end(p) = pair%points%ring_end(p) + 1
      end do
    end do
    do p = 2, n
      pair%points%ring_end(p) = pair%points%ring_end(p) + pair%points%ring_end(p - 1)
    end do
    pair%points%ring = spread(0, 1, pair%points%ring_end(n))
    do f = size(pair%points%slave_facets, 2), 1, -1
      do k = 1, 3
        p = place(pair%points%slave_facets(k, f))
        if (p == 0) cycle
        pair%points%ring(pair%points%ring_end(p)) = f
        pair%points%ring_end(p) = pair%points%ring_end(p) - 1
      end do
    end do
    pair%points%ring_end = [pair%points%ring_end(2:), size(pair%points%ring)]
  end subroutine find_rings

  !> Normal of the slave side at a point, not a unit vector; zero where there is no surface.
  pure function slave_normal(pair, p, x) result(n)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: n(3)
    integer :: i, first, node

    n = 0.0_wp
    if (pair%points%n_slaves > 1) then
      n = facet_normal(corners(x, pair%points%point_nodes(:3, p)))
    else if (allocated(pair%points%ring)) then
      node = mod(p - 1, size(pair%points%ring_end)) + 1
      first = 1
      if (node > 1) first = pair%points%ring_end(node - 1) + 1
      do i = first, pair%points%ring_end(node)
        associate (c => corners(x, pair%points%slave_facets(:, pair%points%ring(i))))
          n = n + cross(c(:, 1) - c(:, 3), c(:, 2) - c(:, 3))
        end associate
      end do
    end if
  end function slave_normal

  !> What the convex edges of a target, and of its neighbours, say of a point.
  pure function look_at_convex_edges(pair, x, p, target) result(found)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: p !! the point
    integer, intent(in) :: target !! its target
    type(convex_edge_t) :: found
    real(wp) :: y(3), n(3)
    integer :: k, j

    if (.not. allocated(pair%surface%convex)) return
    y = point_position(pair, p, x)
    n = slave_normal(pair, p, x)
    do k = 1, 3
      associate (across => pair%surface%neighbours(k, target))
        if (.not. pair%surface%convex(k, target)) cycle
        if (belongs(pair, x, y, n, target, across)) then
          found%next = across
          return
        end if
        found%barred(k) = belongs(pair, x, y, n, across, target)
      end associate
    end do
    do k = 1, 3
      do j = 0, 1
        call look_around(pair, x, y, n, target, [k, modulo(k + j, 3) + 1, modulo(k - j + 1, &
          3) + 1], found)
        if (found%next > 0) return
      end do
    end do
  end function look_at_convex_edges

  !> Looks for a convex edge around one corner of a target, over the edges that are none.
  pure subroutine look_around(pair, x, y, n, target, turn, found)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(in) :: n(3) !! normal of the slave side
    integer, intent(in) :: target !! the target of the point
    integer, intent(in) :: turn(3) !! corners of the target: facing the first edge, pivot, the third
    type(convex_edge_t), intent(inout) :: found !! gets next, via if the point belongs behind
    integer :: via(most_between), i, edge, facet, pivot, far, behind

    via = 0
    facet = target
    edge = turn(1)
    pivot = pair%surface%facets(turn(2), target)
    far = pair%surface%facets(turn(3), target)
    do i = 1, most_between
      if (pair%surface%convex(edge, facet) .or. pair%surface%concave(edge, facet)) return
      facet = pair%surface%neighbours(edge, facet)
      if (facet == 0) return
      via(i) = facet
      edge = findloc(pair%surface%facets(:, facet), far, 1)
      far = sum(pair%surface%facets(:, facet)) - pivot - far
      if (.not. pair%surface%convex(edge, facet)) cycle
      behind = pair%surface%neighbours(edge, facet)
      if (.not. belongs(pair, x, y, n, target, behind)) return
      if (.not. lies_behind(pair, x, y, behind)) return
      found%next = behind
      found%via = via
      return
    end do
  end subroutine look_around

  !> A point below facet a belongs to facet b behind a convex edge: it is less deep below b, and b
  !! faces the slave side better.
  pure logical function belongs(pair, x, y, n, a, b)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(in) :: n(3) !! normal of the slave side
    integer, intent(in) :: a !! a facet
    integer, intent(in) :: b !! another one
    real(wp) :: ca(3, 3), cb(3, 3), xi(2), gap_a, gap_b

    ca = corners(x, pair%surface%facets(:, a))
    cb = corners(x, pair%surface%facets(:, b))
    call project_on_facet(ca, y, xi, gap_a)
    call project_on_facet(cb, y, xi, gap_b)
    belongs = gap_a < 0.0_wp .and. gap_b > gap_a .and. &
      dot_product(n, facet_normal(cb)) < dot_product(n, facet_normal(ca))
  end function belongs

  !> The projection of a point lies on that side of a convex edge to which a facet belongs.
  pure logical function lies_behind(pair, x, y, behind)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(in) :: behind !! the facet
    real(wp) :: xi(2), gap, n(3)
    integer :: step, k, facet, next, before

    facet = behind
    before = 0
    do step = 1, longest_far_walk
      call project_on_facet(corners(x, pair%surface%facets(:, facet)), y, xi, gap)
      n = barycentric(xi)
      lies_behind = all(n >= 0.0_wp)
      k = minloc(n, 1, mask=.not. (pair%surface%convex(:, facet) &
        .or. pair%surface%concave(:, facet)))
      if (lies_behind .or. k == 0) return
      next = pair%surface%neighbours(k, facet)
      if (n(k) >= 0.0_wp .or. next == 0 .or. next == before) return
      before = facet
      facet = next
    end do
  end function lies_behind

  !> Two neighbouring facets are parts of one smooth surface.
  pure logical function is_smooth(pair, target, across)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! a facet
    integer, intent(in) :: across !! its neighbour

    is_smooth = .false.
    if (allocated(pair%surface%sharp)) is_smooth = any(pair%surface%neighbours(:, target) == &
      across .and. .not. pair%surface%sharp(:, target))
  end function is_smooth

  !> Hands a place on the target on to its neighbour across an edge: unfolded, or where the surface
  !! goes on smoothly as the nearest place there.
  pure subroutine pass_edge(pair, x, target, next, xi, start)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: target !! a facet
    integer, intent(in) :: next !! its neighbour
    real(wp), intent(in) :: xi(2) !! (xi, eta) in the target
    real(wp), intent(out) :: start(2) !! (xi, eta) in the neighbour

    if (is_smooth(pair, target, next)) then
      call carry_over(pair, x, target, next, xi, start)
    else
      call unfold(pair%surface%facets(:, target), pair%surface%facets(:, next), x, xi, start)
    end if
  end subroutine pass_edge

  !> Sine of the kink between two neighbouring facets, or what is left of it between their patches.
  pure real(wp) function kink(pair, x, target, across)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: target !! a facet
    integer, intent(in) :: across !! its neighbour

    kink = kink_sine(corners(x, pair%surface%facets(:, target)), corners(x, pair%surface%facets(:, &
      across)))
    if (is_smooth(pair, target, across)) kink = left_by_patches*kink
  end function kink
end module convex_edges

!> Derivatives of the start apexes of an increment: of the apexes that the last one has left,
!! carried to the targets of this one (doc/theory, "Derivatives of edge crossings").
module target_slopes
  use kinds, only: wp
  use vectors, only: cross
  use contact_types, only: pair_t
  use contact_points, only: point_position, point_field
  use facet_geometry, only: corners, barycentric, project_on_facet
  use unfolding, only: unfold_point, unfold_slope
  implicit none
  private
  public :: way_t, find_way, carry_slope, projection_slope

  !> Facets on a way between two targets, at most; and ways that are tried.
  integer, parameter :: longest_facet_way = 64, most_ways = 4000
  !> Tips that differ by less, in shape functions, are the same.
  real(wp), parameter :: same_apex = 1.0e-9_wp

  !> The facets that an apex has been unfolded over.
  type :: way_t
    integer :: n = 0 !! how many, the first and the last target included; 0 if none was found
    integer :: facet(longest_facet_way) = 0 !! (n) from target to target
  end type way_t

contains

  !> The way on which an apex has come from its old target to the new one: over neighbours, the
  !! shortest whose unfolding leads where the apex is. Where the surface is flat any way does.
  subroutine find_way(pair, x, from, apex_from, to, apex_to, way, exact)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions at which it was unfolded [length]
    integer, intent(in) :: from !! old target
    real(wp), intent(in) :: apex_from(2) !! apex in it
    integer, intent(in) :: to !! new target
    real(wp), intent(in) :: apex_to(2) !! apex in that
    type(way_t), intent(out) :: way !! the way; a shortest one if none leads to the apex
    logical, intent(out) :: exact !! it leads to the apex
    integer, parameter :: near = 2
    integer, allocatable :: distance(:)
    integer :: limit, tried

    exact = .false.
    call search(near)
    if (exact) return
    call measure_distances(pair, to, from, distance)
    if (distance(from) < 0 .or. distance(from) >= longest_facet_way) return
    do limit = distance(from), min(distance(from) + 3, longest_facet_way - 1)
      call search(limit)
      if (exact .or. tried >= most_ways) return
    end do

  contains

    !> Tries all ways of so many steps at most.
    subroutine search(steps)
      integer, intent(in) :: steps !! from facet to facet
      type(way_t) :: start

      tried = 0
      start%n = 1
      start%facet(1) = from
      call extend(barycentric(apex_from), start, steps)
    end subroutine search

    !> Goes on from the last facet of a way in all directions that can arrive within the limit.
    recursive subroutine extend(n, so_far, steps)
      real(wp), intent(in) :: n(3) !! shape functions in its last facet
      type(way_t), intent(in) :: so_far !! the way
      integer, intent(in) :: steps !! that are left
      type(way_t) :: longer
      real(wp) :: n_next(3)
      integer :: k, last, next
      logical :: found

      last = so_far%facet(so_far%n)
      if (last == to) then
        tried = tried + 1
        exact = leads_to(n, apex_to)
        if (exact .or. way%n == 0) way = so_far
        return
      end if
      do k = 1, 3
        next = pair%surface%neighbours(k, last)
        if (next == 0 .or. exact .or. tried >= most_ways) cycle
        if (any(so_far%facet(:so_far%n) == next) .or. leads_too_far(next, steps - 1)) cycle
        call unfold_point(pair%surface%facets(:, last), pair%surface%facets(:, next), x, n, &
          n_next, found)
        if (.not. found) cycle
        longer = so_far
        longer%n = so_far%n + 1
        longer%facet(longer%n) = next
        call extend(n_next, longer, steps - 1)
      end do
    end subroutine extend

    !> From a facet the new target is farther than the steps that are left.
    logical function leads_too_far(facet, steps)
      integer, intent(in) :: facet !! the facet
      integer, intent(in) :: steps !! left

      leads_too_far = steps < 0 .or. (steps == 0 .and. facet /= to)
      if (leads_too_far .or. .not. allocated(distance)) return
      leads_too_far = distance(facet) < 0 .or. distance(facet) > steps
    end function leads_too_far
  end subroutine find_way

  !> Shape functions are those of an apex.
  pure logical function leads_to(n, apex)
    real(wp), intent(in) :: n(3) !! shape functions
    real(wp), intent(in) :: apex(2) !! the apex

    leads_to = maxval(abs(n(1:2) - apex)) <= same_apex*(1.0_wp + maxval(abs(apex)))
  end function leads_to

  !> Steps over neighbours from each facet to one of them, as far as another one and a little more.
  subroutine measure_distances(pair, to, from, distance)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: to !! where to
    integer, intent(in) :: from !! a facet that shall be reached
    integer, allocatable, intent(out) :: distance(:) !! (facets) -1 where not reached
    integer :: queue(size(pair%surface%facets, 2)), head, tail, k, next

    allocate (distance(size(queue)), source=-1)
    distance(to) = 0
    queue(1) = to
    head = 1
    tail = 1
    do while (head <= tail)
      if (distance(from) >= 0) then
        if (distance(queue(head)) > distance(from) + 3) return
      end if
      do k = 1, 3
        next = pair%surface%neighbours(k, queue(head))
        if (next == 0) cycle
        if (distance(next) >= 0) cycle
        distance(next) = distance(queue(head)) + 1
        tail = tail + 1
        queue(tail) = next
      end do
      head = head + 1
    end do
  end subroutine measure_distances

  !> The derivative of an apex, carried along its way.
  subroutine carry_slope(pair, x, dx, way, apex, dtip)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions at which it was unfolded [length]
    real(wp), intent(in) :: dx(:, :) !! (3, nodes) their derivative [length]
    type(way_t), intent(in) :: way !! the facets
    real(wp), intent(in) :: apex(2) !! apex in the first one
    real(wp), intent(inout) :: dtip(2) !! its derivative; out: that in the last one
    real(wp) :: n(3), dn(3), n_next(3), dn_next(3)
    integer :: k
    logical :: found

    n = barycentric(apex)
    dn = [dtip, -sum(dtip)]
    do k = 1, way%n - 1
      associate (a => pair%surface%facets(:, way%facet(k)), b => pair%surface%facets(:, &
        way%facet(k + 1)))
        call unfold_slope(a, b, x, dx, n, dn, dn_next)
        call unfold_point(a, b, x, n, n_next, found)
      end associate
      n = n_next
      dn = dn_next
    end do
    dtip = dn(1:2)
  end subroutine carry_slope

  !> The derivative of the projection of a point on a facet.
  pure function projection_slope(pair, p, facet, x, dx) result(dxi)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: dx(:, :) !! (3, nodes) their derivative [length]
    real(wp) :: dxi(2)
    real(wp) :: c(3, 3), dc(3, 3), n(3), a1(3), a2(3), e(3), size_n, xi(2), gap, motion(3), de(3)
    real(wp) :: d1(3), d2(3)

    c = corners(x, pair%surface%facets(:, facet))
    dc = corners(dx, pair%surface%facets(:, facet))
    call project_on_facet(c, point_position(pair, p, x), xi, gap)
    a1 = c(:, 1) - c(:, 3)
    a2 = c(:, 2) - c(:, 3)
    e = cross(a1, a2)
    size_n = norm2(e)
    e = e/size_n
    d1 = cross(a2, e)/size_n
    d2 = cross(e, a1)/size_n
    n = barycentric(xi)
    motion = point_field(pair, p, dx) - matmul(dc, n)
    de = -d1*dot_product(e, dc(:, 1) - dc(:, 3)) - d2*dot_product(e, dc(:, 2) - dc(:, 3))
    motion = motion - gap*de
    dxi = [dot_product(d1, motion), dot_product(d2, motion)]
  end function projection_slope
end module target_slopes

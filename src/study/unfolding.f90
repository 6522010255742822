!> Unfolding of two facets about their common edge, and its derivatives (doc/theory, "Derivatives of
!! edge crossings", eq. (14.7)): by areas and the feet of the altitudes, linear in the point.
module unfolding
  use kinds, only: wp
  use vectors, only: cross
  use facet_geometry, only: corners
  implicit none
  private
  public :: unfold_point, unfold_slope

  !> One facet at the edge from P to Q.
  type :: side_t
    integer :: p = 0, q = 0, r = 0 !! its corners: both ends of the edge, the apex
    real(wp) :: twice = 0.0_wp !! twice its area [length^2]
    real(wp) :: foot = 0.0_wp !! foot of the altitude from the apex: 0 at P, 1 at Q
  end type side_t

contains

  !> Shape functions in facet b of a point of facet a.
  pure subroutine unfold_point(nodes_a, nodes_b, x, n_a, n_b, found)
    integer, intent(in) :: nodes_a(3) !! corner nodes of the facet that is left
    integer, intent(in) :: nodes_b(3) !! corner nodes of the facet that is entered
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: n_a(3) !! shape functions in a
    real(wp), intent(out) :: n_b(3) !! shape functions in b
    logical, intent(out) :: found !! the facets share an edge
    type(side_t) :: a, b

    n_b = 0.0_wp
    call find_edge(nodes_a, nodes_b, a, b, found)
    if (.not. found) return
    call measure(corners(x, nodes_a), a)
    call measure(corners(x, nodes_b), b)
    n_b(b%r) = -n_a(a%r)*a%twice/b%twice
    n_b(b%q) = n_a(a%q) + n_a(a%r)*a%foot - n_b(b%r)*b%foot
    n_b(b%p) = 1.0_wp - n_b(b%q) - n_b(b%r)
  end subroutine unfold_point

  !> Their change where the point and the corners move.
  pure subroutine unfold_slope(nodes_a, nodes_b, x, dx, n_a, dn_a, dn_b)
    integer, intent(in) :: nodes_a(3) !! corner nodes of the facet that is left
    integer, intent(in) :: nodes_b(3) !! corner nodes of the facet that is entered
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: dx(:, :) !! (3, nodes) their motion [length]
    real(wp), intent(in) :: n_a(3) !! shape functions in a
    real(wp), intent(in) :: dn_a(3) !! change of the shape functions in a
    real(wp), intent(out) :: dn_b(3) !! change of those in b
    type(side_t) :: a, b
    logical :: found
    real(wp) :: dtwice_a, dtwice_b, dfoot_a, dfoot_b, n_r

    dn_b = 0.0_wp
    call find_edge(nodes_a, nodes_b, a, b, found)
    if (.not. found) return
    call measure(corners(x, nodes_a), a)
    call measure(corners(x, nodes_b), b)
    call measure_slope(corners(x, nodes_a), corners(dx, nodes_a), a, dtwice_a, dfoot_a)
    call measure_slope(corners(x, nodes_b), corners(dx, nodes_b), b, dtwice_b, dfoot_b)
    n_r = -n_a(a%r)*a%twice/b%twice
    dn_b(b%r) = -dn_a(a%r)*a%twice/b%twice + n_r*(dtwice_a/a%twice - dtwice_b/b%twice)
    dn_b(b%q) = dn_a(a%q) + dn_a(a%r)*a%foot + n_a(a%r)*dfoot_a - dn_b(b%r)*b%foot - n_r*dfoot_b
    dn_b(b%p) = -dn_b(b%q) - dn_b(b%r)
  end subroutine unfold_slope

  !> The corners of two facets at their common edge.
  pure subroutine find_edge(nodes_a, nodes_b, a, b, found)
    integer, intent(in) :: nodes_a(3) !! corner nodes of one facet
    integer, intent(in) :: nodes_b(3) !! corner nodes of the other one
    type(side_t), intent(out) :: a !! its corners
    type(side_t), intent(out) :: b !! its corners
    logical, intent(out) :: found !! there is one
    integer :: k

    found = .false.
    do k = 1, 3
      if (all(nodes_b /= nodes_a(k))) then
        if (a%r > 0) return
        a%r = k
      end if
    end do
    if (a%r == 0) return
    a%p = mod(a%r, 3) + 1
    a%q = mod(a%r + 1, 3) + 1
    b%p = findloc(nodes_b, nodes_a(a%p), 1)
    b%q = findloc(nodes_b, nodes_a(a%q), 1)
    b%r = 6 - b%p - b%q
    found = .true.
  end subroutine find_edge

  !> Area and foot of the altitude.
  pure subroutine measure(x, side)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    type(side_t), intent(inout) :: side !! corners given; gets twice, foot
    real(wp) :: edge(3), rise(3)

    edge = x(:, side%q) - x(:, side%p)
    rise = x(:, side%r) - x(:, side%p)
    side%twice = norm2(cross(edge, rise))
    side%foot = dot_product(rise, edge)/dot_product(edge, edge)
  end subroutine measure

  !> Their change.
  pure subroutine measure_slope(x, dx, side, dtwice, dfoot)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    real(wp), intent(in) :: dx(3, 3) !! their motion [length]
    type(side_t), intent(in) :: side !! measured
    real(wp), intent(out) :: dtwice !! of twice the area
    real(wp), intent(out) :: dfoot !! of the foot
    real(wp) :: edge(3), rise(3), dedge(3), drise(3), n(3)

    edge = x(:, side%q) - x(:, side%p)
    rise = x(:, side%r) - x(:, side%p)
    dedge = dx(:, side%q) - dx(:, side%p)
    drise = dx(:, side%r) - dx(:, side%p)
    n = cross(edge, rise)
    dtwice = dot_product(n, cross(dedge, rise) + cross(edge, drise))/norm2(n)
    dfoot = (dot_product(drise, edge) + dot_product(rise, dedge) &
      - 2.0_wp*side%foot*dot_product(edge, dedge))/dot_product(edge, edge)
  end subroutine measure_slope
end module unfolding

!> Contact of a body with itself: a crack, a joint bonded in part, a fold. What lies behind a
!! facet may be the body itself (doc/theory, "Ties and self contact").
module contact_bodies
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use facet_geometry, only: corners, facet_area, facet_size, facet_normal
  implicit none
  private
  public :: is_through_body, cell_through_body

  !> Two cuts of one curved face differ by less than this share of a facet's altitude: their sag is
  !! h^2/8R, so that is 26 facets on a circle. The points of a facet are farther from its edges
  !! (0.06 for seven of them), so those beside an edge at which slave and master meet are deeper.
  real(wp), parameter :: two_cuts = 0.03_wp
  !> Facets look at each other if the cosine of their normals is smaller (135 degrees).
  real(wp), parameter :: opposite_cosine = -0.7_wp

contains

  !> A point lies behind a facet of its own body, deeper than two cuts of one face differ: what is
  !! between them is the body, at an edge where slave and master meet or in a thin part of it. A
  !! point that has been before the facet has found it by then.
  pure logical function is_through_body(pair, x, p, facet, gap) result(through)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: p !! the point
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: gap !! negative below it [length]
    real(wp) :: h
    integer :: point

    through = .false.
    if (.not. allocated(pair%surface%body) .or. gap >= 0.0_wp) return
    point = 1 + mod(p - 1, count_points(pair)/pair%points%slots)
    if (pair%surface%body(facet) /= pair%points%body(point)) return
    if (pair%points%n_slaves > 1) then
      h = altitude_of(corners(x, pair%points%point_nodes(1:3, point)))
    else
      h = sqrt(pair%points%area(point))
    end if
    through = gap < -two_cuts*h
  end function is_through_body

  !> The same for the part of a slave facet over a facet. It is cut anew where it has penetrated, by
  !! any depth, so what tells is that the facets do not look at each other: they meet at an edge.
  pure logical function cell_through_body(pair, x, slave, facet, gaps) result(through)
    type(pair_t), intent(in) :: pair !! a segmented pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: slave !! the slave facet
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: gaps(:) !! negative below it [length]

    through = .false.
    if (.not. allocated(pair%surface%body)) return
    if (pair%surface%body(facet) /= pair%points%body(slave) .or. all(gaps >= 0.0_wp)) return
    through = dot_product(facet_normal(corners(x, pair%points%slave_facets(:, slave))), &
      facet_normal(corners(x, pair%surface%facets(:, facet)))) > opposite_cosine
  end function cell_through_body

  !> The smallest altitude of a facet.
  pure real(wp) function altitude_of(x) result(h)
    real(wp), intent(in) :: x(3, 3) !! corners [length]

    h = 2.0_wp*facet_area(x)/facet_size(x)
  end function altitude_of
end module contact_bodies

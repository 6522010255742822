!> How far flat facets lie below the curved surface they stand for (doc/theory, "Initial gap
!! adjustment", eq. (6.17)).
module surface_sag
  use kinds, only: wp
  use facet_geometry, only: altitude, corners, facet_normal
  implicit none
  private
  public :: find_sags

  !> Facets whose normals have a smaller cosine (60 degrees) meet at an edge that is meant.
  real(wp), parameter :: edge_cosine = 0.5_wp

contains

  !> The sag of each facet: that of a chord over its altitude, kappa a^2/8, summed up over its
  !! edges, with the curvature kappa from the angle to the facet behind the edge.
  pure subroutine find_sags(facets, neighbours, x, sag)
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    integer, intent(in) :: neighbours(:, :) !! (3, facets) facet facing corner k, 0 at the boundary
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(out) :: sag(:) !! (facets) [length]
    real(wp) :: here, cosine
    integer :: f, k, other

    sag = 0.0_wp
    do f = 1, size(facets, 2)
      do k = 1, 3
        other = neighbours(k, f)
        if (other == 0) cycle
        cosine = dot_product(facet_normal(corners(x, facets(:, f))), &
          facet_normal(corners(x, facets(:, other))))
        if (cosine < edge_cosine) cycle
        here = altitude(corners(x, facets(:, f)), k)
        sag(f) = sag(f) + 0.125_wp*here**2*acos(min(1.0_wp, cosine)) &
          /distance(here, altitude(corners(x, facets(:, other)), facing(neighbours(:, other), f)))
      end do
    end do
  end subroutine find_sags

  !> Corner of a facet that faces the edge to facet f.
  pure integer function facing(neighbours, f) result(k)
    integer, intent(in) :: neighbours(3) !! facets facing its corners
    integer, intent(in) :: f !! the facet behind the edge

    k = max(1, findloc(neighbours, f, 1))
  end function facing

  !> Distance across an edge between the centers of the two facets.
  pure real(wp) function distance(a, b)
    real(wp), intent(in) :: a !! altitude of one facet over the edge [length]
    real(wp), intent(in) :: b !! altitude of the other [length]

    distance = (a + b)/3.0_wp
  end function distance
end module surface_sag

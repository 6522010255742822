!> Consistent nodal values of loads on facets and in cells: here, and nowhere else, the shape of a
!! facet or a cell counts (doc/theory, "Loads").
module consistent_loads
  use kinds, only: wp
  use vectors, only: cross
  implicit none
  private
  public :: facet_areas, cell_volumes

contains

  !> Integrals of the shape functions times the outward normal over a reference facet: a pressure p
  !! gives -p times these, a traction t gives t times their lengths.
  pure function facet_areas(x) result(areas)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) counter-clockwise seen from outside [length]
    real(wp) :: areas(3, size(x, 2))

    areas = spread(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))/6.0_wp, 2, size(x, 2))
  end function facet_areas

  !> Integrals of the shape functions over a reference cell: a load b per volume gives b times them.
  pure function cell_volumes(x) result(volumes)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) [length]
    real(wp) :: volumes(size(x, 2))

    volumes = dot_product(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1)), x(:, 4) - x(:, 1))/24.0_wp
  end function cell_volumes
end module consistent_loads

!> How coarse the slave of a pair is beside its master (doc/theory, "The audit").
module facet_ratio
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_points, only: used_points
  use facet_geometry, only: corners, facet_size, facet_area
  implicit none
  private
  public :: slave_over_master, mean_facet

contains

  !> Size of a slave facet over that of the master facets below it: the root of the ratio of their
  !! areas, its mean over the points that have a master below them weighted by their areas; 0 if no
  !! point has. A slave node stands for its tributary area, which is that of two facets.
  pure real(wp) function slave_over_master(pair, x) result(ratio)
    type(pair_t), intent(in) :: pair !! the pair with its first hosts
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: total, weighted, slave
    integer :: p

    total = 0.0_wp
    weighted = 0.0_wp
    do p = 1, used_points(pair)
      if (pair%old(p)%host == 0 .or. pair%area(p) <= 0.0_wp) cycle
      slave = 0.5_wp*pair%area(p)
      if (pair%n_slaves == 3) slave = facet_area(corners(x, pair%point_nodes(:, p)))
      total = total + pair%area(p)
      weighted = weighted + pair%area(p)*sqrt(slave/facet_area(corners(x, &
        pair%facets(:, pair%old(p)%host))))
    end do
    ratio = 0.0_wp
    if (total > 0.0_wp) ratio = weighted/total
  end function slave_over_master

  !> Mean of the longest edges of the master facets of a pair.
  pure real(wp) function mean_facet(pair, x) result(h)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: f

    h = 0.0_wp
    do f = 1, size(pair%facets, 2)
      h = h + facet_size(corners(x, pair%facets(:, f)))
    end do
    if (size(pair%facets, 2) > 0) h = h/real(size(pair%facets, 2), wp)
  end function mean_facet
end module facet_ratio

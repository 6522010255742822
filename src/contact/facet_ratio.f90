!> How coarse the slave of a pair is beside its master (doc/theory, "Contact resolution").
module facet_ratio
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_points, only: used_points, smallest_facet
  use facet_geometry, only: corners, facet_size, facet_area
  implicit none
  private
  public :: slave_over_master, mean_facet

contains

  !> Size of the slave facets over that of the master facets below them: the root of the ratio of
  !! their areas, in the mean over the slave's area; 0 if no point has a master below it, or the
  !! master is exact.
  pure real(wp) function slave_over_master(pair, x) result(ratio)
    type(pair_t), intent(in) :: pair !! the pair with its first hosts
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: sums(2)
    integer :: p, f, k
    integer, allocatable :: point(:)

    sums = 0.0_wp
    if (pair%points%n_slaves > 1) then
      do p = 1, used_points(pair)
        call compare(pair, x, pair%points%point_nodes(:3, p), pair%history%old(p)%host, sums)
      end do
    else if (allocated(pair%points%slave_facets)) then
      allocate (point(maxval(pair%points%slave_facets)), source=0)
      do p = 1, used_points(pair)
        if (pair%points%point_nodes(1, p) <= size(point)) point(pair%points%point_nodes(1, p)) = p
      end do
      do f = 1, size(pair%points%slave_facets, 2)
        do k = 1, 3
          p = point(pair%points%slave_facets(k, f))
          if (p > 0) call compare(pair, x, pair%points%slave_facets(:, f), &
            pair%history%old(p)%host, sums)
        end do
      end do
    end if
    ratio = 0.0_wp
    if (sums(1) > 0.0_wp) ratio = sums(2)/sums(1)
  end function slave_over_master

  !> Adds one slave facet over one of the master.
  pure subroutine compare(pair, x, nodes, host, sums)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(3) !! corners of the slave facet
    integer, intent(in) :: host !! facet of the master below it, 0 for none
    real(wp), intent(inout) :: sums(2) !! areas, and areas times ratios [length^2]
    real(wp) :: area

    if (host == 0 .or. pair%surface%exact) return
    area = facet_area(corners(x, nodes))
    if (area > 0.0_wp) sums = sums + area*[1.0_wp, &
      sqrt(area/facet_area(corners(x, pair%surface%facets(:, host))))]
  end subroutine compare

  !> Mean of the longest edges of the master facets of a pair; of an exact surface, whose facets
  !! grow far away, that of the smallest one.
  pure real(wp) function mean_facet(pair, x) result(h)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: f

    h = 0.0_wp
    do f = 1, size(pair%surface%facets, 2)
      h = h + facet_size(corners(x, pair%surface%facets(:, f)))
    end do
    if (size(pair%surface%facets, 2) > 0) h = h/real(size(pair%surface%facets, 2), wp)
    if (pair%surface%exact) h = smallest_facet(pair, x)
  end function mean_facet
end module facet_ratio

!> SHRInk: the overlap that a pair has at the start is taken up step by step (doc/theory,
!! "Initial overlap").
module contact_overlap
  use kinds, only: wp
  use contact_types, only: pair_t
  use contact_points, only: point_position
  use slave_places, only: slave_nodes, slave_weights
  use facet_tree, only: nearest_facet
  use smooth_normals, only: project_on_master
  implicit none
  private
  public :: measure_overlap, withheld_gap, overlap_of

contains

  !> Measures the overlap on the reference positions: at the points, or with SEGMent at the nodes
  !! of the slave facets.
  subroutine measure_overlap(pair, x)
    type(pair_t), intent(inout) :: pair !! with its first hosts and tree; gets overlap
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: xi(2), gap
    integer, allocatable :: nodes(:)
    integer :: p, k

    pair%shrinking%withheld = 0.0_wp
    if (pair%shrinking%shrink < 0) return
    if (allocated(pair%shrinking%overlap)) deallocate (pair%shrinking%overlap)
    if (pair%segmented) then
      allocate (pair%shrinking%overlap(pair%points%n_slaves, size(pair%points%slave_facets, 2)), &
        source=0.0_wp)
      do p = 1, size(pair%points%slave_facets, 2)
        nodes = slave_nodes(pair, p)
        do k = 1, size(nodes)
          pair%shrinking%overlap(k, p) = overlap_at(pair, x, x(:, nodes(k)))
        end do
      end do
      return
    end if
    allocate (pair%shrinking%overlap(1, size(pair%history%old)), source=0.0_wp)
    do p = 1, size(pair%history%old)
      if (pair%history%old(p)%host == 0) cycle
      call project_on_master(pair, pair%history%old(p)%host, x, point_position(pair, p, x), xi, gap)
      pair%shrinking%overlap(1, p) = -gap
    end do
  end subroutine measure_overlap

  !> How far a place lies below the nearest facet of the master; 0 if there is none near.
  real(wp) function overlap_at(pair, x, y) result(overlap)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: y(3) !! the place [length]
    real(wp) :: xi(2), gap, distance
    integer :: facet

    overlap = 0.0_wp
    call nearest_facet(pair%surface%tree, pair%surface%facets, x, y, facet, distance, &
      pair%surface%depth)
    if (facet == 0 .or. distance > pair%search_radius) return
    call project_on_master(pair, facet, x, y, xi, gap)
    overlap = -gap
  end function overlap_at

  !> Overlap of a point at the start, 0 where there was a gap.
  pure real(wp) function overlap_of(pair, p) result(overlap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point

    overlap = 0.0_wp
    if (.not. allocated(pair%shrinking%overlap)) return
    if (.not. pair%segmented) then
      overlap = max(0.0_wp, pair%shrinking%overlap(1, p))
    else if (pair%history%cells(p)%slave > 0) then
      overlap = max(0.0_wp, dot_product(pair%shrinking%overlap(:, pair%history%cells(p)%slave), &
        slave_weights(pair, pair%history%cells(p)%slave, pair%history%cells(p)%weight)))
    end if
  end function overlap_of

  !> What is added to the gap of a point: the share of its overlap that is not taken up yet.
  pure real(wp) function withheld_gap(pair, p) result(gap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point

    gap = 0.0_wp
    if (abs(pair%shrinking%withheld) > 0.0_wp) gap = pair%shrinking%withheld*overlap_of(pair, p)
  end function withheld_gap
end module contact_overlap

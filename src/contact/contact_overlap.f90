!> SHRInk: the overlap that a pair has at the start is taken up step by step (doc/theory, "Initial
!! overlap", eq. (6.18)).
module contact_overlap
  use kinds, only: wp
  use contact_types, only: pair_t, master_surface_t
  use contact_points, only: point_position, point_facet, corner_weights
  use slave_places, only: slave_nodes, slave_weights
  use facet_tree, only: nearest_facet
  use smooth_normals, only: project_on_master, measure_excess
  use facet_geometry, only: barycentric
  implicit none
  private
  public :: measure_overlap, withheld_gap, overlap_of

  !> Gaps above minus this share of the search radius are no overlap, as in contact_gaps.
  real(wp), parameter :: touching = 1.0e-9_wp

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
    call correct_smooth(pair, x)
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
      if (allocated(pair%shrinking%excess)) pair%shrinking%overlap(1, p) = -gap &
        - pair%shrinking%excess(p)
    end do
  end subroutine measure_overlap

  !> Smooth surfaces that overlap at the start are taken for round: what their patches are off is
  !! no less than the overlap of a fit may be. So the way to it, with SHRInk or not, has one end.
  subroutine correct_smooth(pair, x)
    type(pair_t), intent(inout) :: pair !! with its first hosts; gets excess of surface and side
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: xi(2), gap, excess(size(pair%history%old))
    logical :: overlaps
    integer :: p

    if (allocated(pair%shrinking%excess)) deallocate (pair%shrinking%excess)
    if (.not. pair%smooth) return
    call measure_excess(pair%surface, x)
    if (allocated(pair%points%side%patch)) call measure_excess(pair%points%side, x)
    overlaps = pair%shrinking%shrink >= 0
    excess = 0.0_wp
    do p = 1, size(excess)
      associate (host => pair%history%old(p)%host)
        if (host == 0) cycle
        call project_on_master(pair, host, x, point_position(pair, p, x), xi, gap)
        excess(p) = excess_at(pair, p, host, xi)
        overlaps = overlaps .or. gap + excess(p) < -touching*pair%search_radius
      end associate
    end do
    if (overlaps .and. pair%segmented) return
    deallocate (pair%surface%excess)
    if (allocated(pair%points%side%excess)) deallocate (pair%points%side%excess)
    if (overlaps) pair%shrinking%excess = excess
  end subroutine correct_smooth

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
    overlap = -gap - excess_of(pair%surface, facet, barycentric(xi))
  end function overlap_at

  !> What the patches of both sides at a point lie too far out.
  pure real(wp) function excess_at(pair, p, host, xi) result(excess)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: host !! its master facet
    real(wp), intent(in) :: xi(2) !! (xi, eta) in it

    excess = 0.0_wp
    if (host == 0) return
    excess = excess_of(pair%surface, host, barycentric(xi))
    if (.not. allocated(pair%points%side%excess) .or. point_facet(pair, p) == 0) return
    excess = excess + excess_of(pair%points%side, point_facet(pair, p), corner_weights(pair, p))
  end function excess_at

  !> The same of one surface at a place of a facet.
  pure real(wp) function excess_of(surface, f, place) result(excess)
    type(master_surface_t), intent(in) :: surface !! the surface
    integer, intent(in) :: f !! the facet
    real(wp), intent(in) :: place(3) !! shape functions of its corners
    real(wp) :: n(3)

    excess = 0.0_wp
    if (.not. allocated(surface%excess)) return
    n = max(0.0_wp, place)
    excess = dot_product(surface%excess(:, f), [n(2)*n(3), n(3)*n(1), n(1)*n(2)])
  end function excess_of

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

  !> What is added to the gap of a point: the share of its overlap that is not taken up yet, and how
  !! far its smooth surfaces lie too far out.
  pure real(wp) function withheld_gap(pair, p) result(gap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point

    gap = 0.0_wp
    if (abs(pair%shrinking%withheld) > 0.0_wp) gap = pair%shrinking%withheld*overlap_of(pair, p)
    if (allocated(pair%shrinking%excess)) gap = gap + pair%shrinking%excess(p)
    if (allocated(pair%surface%excess)) gap = gap + excess_at(pair, p, &
      pair%history%new(p)%host, pair%history%new(p)%tip)
  end function withheld_gap
end module contact_overlap

!> The cells of one slave facet: its intersections with the master facets (doc/theory,
!! "Segmentation").
module cell_cutting
  use kinds, only: wp
  use contact_types, only: pair_t, cell_t
  use facet_clipping, only: clip_triangle, polygon_area, polygon_points, most_corners, cell_points
  use facet_geometry, only: project_points, facet_normal, corners_of => corners
  use facet_tree, only: facets_near
  implicit none
  private
  public :: fresh_t, make_fresh, cut_facet, fit_in

  !> Cells below this share of their facet are dropped.
  real(wp), parameter :: least_area = 1.0e-14_wp
  !> Facets face each other if their normals have a smaller cosine.
  real(wp), parameter :: facing = -0.1_wp

  !> The points of one slave facet while it is cut.
  type :: fresh_t
    integer :: n = 0 !! how many
    type(cell_t), allocatable :: cell(:) !! where they are
    integer, allocatable :: host(:) !! their master facets
    integer, allocatable :: near(:) !! master facets close to the facet
  end type fresh_t

contains

  !> Room for the points of one slave facet.
  pure subroutine make_fresh(facets, fresh)
    integer, intent(in) :: facets !! number of master facets
    type(fresh_t), intent(out) :: fresh !! gets its arrays

    allocate (fresh%near(facets), fresh%cell(cell_points*(facets + 1)), &
              fresh%host(cell_points*(facets + 1)))
  end subroutine make_fresh

  !> The points of one slave facet over the master at x.
  pure subroutine cut_facet(pair, f, corners, x, fresh)
    type(pair_t), intent(in) :: pair !! the pair, its tree fitted to x
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: corners(3, 3) !! its corners, or where the tips put them [length]
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(fresh_t), intent(inout) :: fresh !! gets n, cell, host
    real(wp) :: center(3), normal(3), reach
    integer :: k, n

    normal = facet_normal(corners)
    center = sum(corners, 2)/3.0_wp
    reach = pair%search_radius + maxval(norm2(corners - spread(center, 2, 3), 1))
    call facets_near(pair%surface%tree, center, reach, fresh%near, n)
    fresh%n = 0
    do k = 1, n
      associate (host => fresh%near(k))
        call add_cell(pair, f, host, corners, normal, corners_of(x, pair%surface%facets(:, &
          host)), fresh)
      end associate
    end do
    if (fresh%n > 0) return
    fresh%n = 1
    fresh%host(1) = 0
    fresh%cell(1) = cell_t(slave=f)
  end subroutine cut_facet

  !> Adds the points of the part of a slave facet under one master facet, if there is one.
  pure subroutine add_cell(pair, f, host, slave, normal, master, fresh)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! the slave facet
    integer, intent(in) :: host !! the master facet
    real(wp), intent(in) :: slave(3, 3) !! corners of the slave facet [length]
    real(wp), intent(in) :: normal(3) !! its normal
    real(wp), intent(in) :: master(3, 3) !! corners of the master facet [length]
    type(fresh_t), intent(inout) :: fresh !! gets points
    real(wp) :: triangle(2, 3), polygon(2, most_corners), points(2, cell_points), area
    real(wp) :: place(2, cell_points), gaps(cell_points), y(3, cell_points)
    integer :: k, n

    if (dot_product(normal, facet_normal(master)) > facing) return
    call project_points(slave, 3, master, triangle, gaps)
    if (any(maxval(triangle, 2) < 0.0_wp) .or. all(1.0_wp - triangle(1, :) - triangle(2, :) &
      < 0.0_wp)) return
    call clip_triangle(triangle, polygon, n)
    if (n == 0) return
    area = abs(polygon_area(polygon, n))
    if (area <= least_area) return
    call polygon_points(polygon, n, points)
    do k = 1, cell_points
      y(:, k) = slave(:, 3) + points(1, k)*(slave(:, 1) - slave(:, 3)) &
        + points(2, k)*(slave(:, 2) - slave(:, 3))
    end do
    call project_points(master, cell_points, y, place, gaps)
    if (all(abs(gaps) > pair%search_radius)) return
    do k = 1, cell_points
      associate (p => fresh%n + k)
        fresh%host(p) = host
        fresh%cell(p)%slave = f
        fresh%cell(p)%weight = [points(1, k), points(2, k), 1.0_wp - points(1, k) - points(2, k)]
        fresh%cell(p)%area = area*pair%points%slave_area(f)/real(cell_points, wp)
        fresh%cell(p)%place = place(:, k)
      end associate
    end do
    fresh%n = fresh%n + cell_points
  end subroutine add_cell

  !> Fewer points where there is no room for all of them: a third of the cells' areas and hosts are
  !! kept by one point in place of three, and if that is too many as well the largest cells share
  !! the area of all.
  pure subroutine fit_in(room, fresh)
    integer, intent(in) :: room !! places left for this facet
    type(fresh_t), intent(inout) :: fresh !! n and cells may shrink
    integer :: k, p

    if (fresh%n <= room) return
    do k = 1, fresh%n/cell_points
      p = cell_points*(k - 1) + 1
      fresh%host(k) = fresh%host(p)
      fresh%cell(k) = fresh%cell(p)
      fresh%cell(k)%weight = (fresh%cell(p)%weight + fresh%cell(p + 1)%weight &
        + fresh%cell(p + 2)%weight)/real(cell_points, wp)
      fresh%cell(k)%place = (fresh%cell(p)%place + fresh%cell(p + 1)%place &
        + fresh%cell(p + 2)%place)/real(cell_points, wp)
      fresh%cell(k)%area = real(cell_points, wp)*fresh%cell(p)%area
    end do
    fresh%n = fresh%n/cell_points
    if (fresh%n <= room) return
    fresh%cell(:room)%area = fresh%cell(:room)%area*sum(fresh%cell(:fresh%n)%area) &
      /sum(fresh%cell(:room)%area)
    fresh%n = room
  end subroutine fit_in
end module cell_cutting

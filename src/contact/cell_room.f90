!> How many cells two surfaces can make at most, wherever one lies on the other (doc/theory,
!! "History on new cells", eq. (6.6), room).
module cell_room
  use kinds, only: wp, pi
  use facet_geometry, only: corners, distance_to_facet
  use facet_tree, only: facet_tree_t, build_tree, facets_near
  implicit none
  private
  public :: most_cells

  !> Sizes of facets whose ratio is smaller stand in one class.
  real(wp), parameter :: class_ratio = 1.2_wp
  !> Places that are looked at, for each class: these many evenly spread, and as many small facets.
  integer, parameter :: places_of_class = 60

contains

  !> Most cells of two surfaces: the smaller of two bounds. Either each facet of one meets as many
  !! of the other as a disc of its mean width does at the densest place there; or the other way
  !! round, and each facet of the first may hang over the boundary besides.
  integer function most_cells(slave, master, x) result(n)
    integer, intent(in) :: slave(:, :) !! (3, facets) corners of the slave facets
    integer, intent(in) :: master(:, :) !! (3, facets) corners of the master facets
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: cells

    n = 0
    if (size(slave, 2) == 0 .or. size(master, 2) == 0) return
    cells = min(cells_over(slave, master, x), cells_over(master, slave, x) &
      + real(size(slave, 2), wp))
    n = nint(min(cells, 0.01_wp*real(huge(n), wp)))
  end function most_cells

  !> Each facet above at the densest place below: sum over the facets above.
  real(wp) function cells_over(above, below, x) result(cells)
    integer, intent(in) :: above(:, :) !! (3, facets) corners
    integer, intent(in) :: below(:, :) !! (3, facets) corners
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(facet_tree_t) :: tree
    real(wp) :: width(size(above, 2)), largest
    logical :: in_class(size(above, 2)), left(size(above, 2))
    integer, allocatable :: spots(:)
    integer :: f

    call build_tree(tree, below, x)
    call choose_spots(below, x, spots)
    do f = 1, size(above, 2)
      width(f) = radius(x, above(:, f))
    end do
    left = .true.
    cells = 0.0_wp
    do while (any(left))
      largest = maxval(width, left)
      in_class = left .and. width >= largest/class_ratio
      left = left .and. .not. in_class
      cells = cells + real(count(in_class), wp)*real(most_near(tree, below, x, spots, largest), wp)
    end do
  end function cells_over

  !> Most facets within a distance of one of the spots.
  integer function most_near(tree, facets, x, spots, reach) result(most)
    type(facet_tree_t), intent(in) :: tree !! of the facets
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: spots(:) !! facets whose centres are the spots
    real(wp), intent(in) :: reach !! the distance [length]
    integer :: near(size(facets, 2)), s, k, n, found
    real(wp) :: center(3)

    most = 1
    do s = 1, size(spots)
      center = sum(x(:, facets(:, spots(s))), 2)/3.0_wp
      call facets_near(tree, center, reach, near, n)
      if (n <= most) cycle
      found = 0
      do k = 1, n
        if (distance_to_facet(corners(x, facets(:, near(k))), center) <= reach) found = found + 1
      end do
      most = max(most, found)
    end do
  end function most_near

  !> Facets at whose centres it may be densest: some spread evenly, and the smallest ones.
  pure subroutine choose_spots(facets, x, spots)
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, allocatable, intent(out) :: spots(:) !! numbers of facets
    real(wp) :: width(size(facets, 2))
    logical :: taken(size(facets, 2))
    integer :: f, k

    taken = .false.
    do k = 1, min(places_of_class, size(taken))
      f = 1 + nint(real(k - 1, wp)*real(size(taken) - 1, wp)/real(places_of_class, wp))
      taken(f) = .true.
    end do
    do f = 1, size(taken)
      width(f) = radius(x, facets(:, f))
    end do
    do k = 1, min(places_of_class, count(.not. taken))
      taken(minloc(merge(huge(1.0_wp), width, taken), 1)) = .true.
    end do
    spots = pack([(f, f=1, size(taken))], taken)
  end subroutine choose_spots

  !> Radius of the disc of a triangle's mean width: its circumference over 2 pi.
  pure real(wp) function radius(x, facet)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: facet(3) !! corner nodes

    radius = (norm2(x(:, facet(2)) - x(:, facet(1))) + norm2(x(:, facet(3)) - x(:, facet(2))) &
      + norm2(x(:, facet(1)) - x(:, facet(3))))/(2.0_wp*pi)
  end function radius
end module cell_room

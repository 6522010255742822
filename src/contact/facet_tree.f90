!> A tree of bounding boxes over the facets of a surface, to find the facet closest to a point.
!!
!! Built once by halving along the longest side, n log n; when the surface has moved, the boxes are
!! fitted anew, n. A query visits about log n boxes.
!!
!! That of a master is in its pair, `surface%tree`: contact_targets builds it, fits it and looks for
!! points without a facet, after each solve with frozen targets, not in each iteration.
module facet_tree
  use kinds, only: wp
  use exact_touch, only: round_off
  use facet_geometry, only: corners, distance_to_facet, project_on_facet
  implicit none
  private
  public :: facet_tree_t, build_tree, fit_tree, nearest_facet, facets_near

  !> Facets in a leaf.
  integer, parameter :: leaf_size = 4
  !> Distances that differ by less than this share are the same.
  real(wp), parameter :: same_distance = 1.0e-10_wp
  !> Boxes that wait while the tree is walked; halving keeps it balanced.
  integer, parameter :: most_waiting_boxes = 64

  !> The tree. Children of box b are first(b) and first(b) + 1; a leaf holds
  !! order(first(b) : first(b) + n(b) - 1).
  type :: facet_tree_t
    integer :: boxes = 0 !! number of boxes
    integer, allocatable :: order(:) !! (facets) facets in the order of the leaves
    integer, allocatable :: first(:) !! (boxes) first child, or first place in order
    integer, allocatable :: n(:) !! (boxes) facets of a leaf, 0 for an inner box
    real(wp), allocatable :: low(:, :) !! (3, boxes) lower corner [length]
    real(wp), allocatable :: high(:, :) !! (3, boxes) upper corner [length]
  end type facet_tree_t

contains

  !> Builds the tree of a surface.
  subroutine build_tree(tree, facets, x)
    type(facet_tree_t), intent(out) :: tree !! the tree
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), allocatable :: center(:, :)
    integer :: f, n, b, middle, last(4*size(facets, 2) + 8)

    n = size(facets, 2)
    allocate (tree%order(n), tree%first(4*n + 8), tree%n(4*n + 8), center(3, n))
    do f = 1, n
      tree%order(f) = f
      center(:, f) = (x(:, facets(1, f)) + x(:, facets(2, f)) + x(:, facets(3, f)))/3.0_wp
    end do
    tree%boxes = min(1, n)
    tree%first(1) = 1
    last(1) = n
    b = 1
    do while (b <= tree%boxes)
      associate (from => tree%first(b), to => last(b))
        tree%n(b) = to - from + 1
        if (tree%n(b) > leaf_size) then
          middle = (from + to)/2
          call halve(tree%order(from:to), center, middle - from + 1)
          tree%first(tree%boxes + 1) = from
          last(tree%boxes + 1) = middle
          tree%first(tree%boxes + 2) = middle + 1
          last(tree%boxes + 2) = to
          tree%first(b) = tree%boxes + 1
          tree%n(b) = 0
          tree%boxes = tree%boxes + 2
        end if
      end associate
      b = b + 1
    end do
    allocate (tree%low(3, tree%boxes), tree%high(3, tree%boxes))
    call fit_tree(tree, facets, x)
  end subroutine build_tree

  !> Reorders facets so that the `half` lowest along the longest side come first (quickselect).
  pure subroutine halve(order, center, half)
    integer, intent(inout) :: order(:) !! facets
    real(wp), intent(in) :: center(:, :) !! (3, facets) centers [length]
    integer, intent(in) :: half !! how many come first
    integer :: axis, low, high, i, j, swap
    real(wp) :: pivot

    axis = maxloc(maxval(center(:, order), 2) - minval(center(:, order), 2), 1)
    low = 1
    high = size(order)
    do while (low < high)
      pivot = center(axis, order((low + high)/2))
      i = low
      j = high
      do while (i <= j)
        do while (center(axis, order(i)) < pivot)
          i = i + 1
        end do
        do while (center(axis, order(j)) > pivot)
          j = j - 1
        end do
        if (i > j) exit
        swap = order(i)
        order(i) = order(j)
        order(j) = swap
        i = i + 1
        j = j - 1
      end do
      if (half <= j) then
        high = j
      else if (half >= i) then
        low = i
      else
        exit
      end if
    end do
  end subroutine halve

  !> Fits the boxes to new positions, from the leaves up.
  pure subroutine fit_tree(tree, facets, x)
    type(facet_tree_t), intent(inout) :: tree !! the tree
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: b, k, i

    do b = tree%boxes, 1, -1
      associate (low => tree%low(:, b), high => tree%high(:, b), first => tree%first(b))
        if (tree%n(b) == 0) then
          low = min(tree%low(:, first), tree%low(:, first + 1))
          high = max(tree%high(:, first), tree%high(:, first + 1))
        else
          low = huge(1.0_wp)
          high = -huge(1.0_wp)
          do k = first, first + tree%n(b) - 1
            do i = 1, 3
              low = min(low, x(:, facets(i, tree%order(k))))
              high = max(high, x(:, facets(i, tree%order(k))))
            end do
          end do
        end if
      end associate
    end do
  end subroutine fit_tree

  !> The facet closest to a point. Of facets at the same distance, which meet at an edge or corner,
  !! the one whose plane is furthest below the point, for the others may point away from it; then
  !! the one with the lowest number. Distances that differ by round-off are the same.
  pure subroutine nearest_facet(tree, facets, x, y, facet, distance, depth)
    type(facet_tree_t), intent(in) :: tree !! the tree, fitted to x
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    integer, intent(out) :: facet !! the closest facet, 0 without facets
    real(wp), intent(out) :: distance !! its distance [length]
    real(wp), intent(in), optional :: depth(:) !! (facets) what is deeper is not below it
    integer :: waiting(most_waiting_boxes), n, b, k
    real(wp) :: d, xi(2), gap, highest, same

    facet = 0
    highest = -huge(1.0_wp)
    distance = 0.1_wp*huge(1.0_wp)
    if (tree%boxes == 0) return
    waiting(1) = 1
    n = 1
    do while (n > 0)
      b = waiting(n)
      n = n - 1
      same = same_distance*distance + round_off(x(:, facets(:, max(1, facet))), y)
      if (box_distance(tree, b, y) > distance + same) cycle
      if (tree%n(b) == 0) then
        ! the closer child is looked at first
        k = merge(0, 1, box_distance(tree, tree%first(b), y) > &
          box_distance(tree, tree%first(b) + 1, y))
        waiting(n + 1) = tree%first(b) + k
        waiting(n + 2) = tree%first(b) + 1 - k
        n = n + 2
      else
        do k = tree%first(b), tree%first(b) + tree%n(b) - 1
          d = distance_to_facet(corners(x, facets(:, tree%order(k))), y)
          same = same_distance*distance + round_off(corners(x, facets(:, tree%order(k))), y)
          if (d > distance + same) cycle
          call project_on_facet(corners(x, facets(:, tree%order(k))), y, xi, gap)
          if (present(depth)) then
            if (gap < -depth(tree%order(k))) cycle
          end if
          if (d >= distance - same) then
            if (gap < highest - same) cycle
            if (gap <= highest + same .and. tree%order(k) > facet) cycle
          end if
          distance = d
          highest = gap
          facet = tree%order(k)
        end do
      end if
    end do
  end subroutine nearest_facet

  !> The facets whose boxes lie within a distance of a point.
  pure subroutine facets_near(tree, y, reach, found, n)
    type(facet_tree_t), intent(in) :: tree !! the tree
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(in) :: reach !! the distance [length]
    integer, intent(inout) :: found(:) !! facets; as many as there is room for
    integer, intent(out) :: n !! how many
    integer :: waiting(most_waiting_boxes), w, b, k

    n = 0
    if (tree%boxes == 0) return
    waiting(1) = 1
    w = 1
    do while (w > 0)
      b = waiting(w)
      w = w - 1
      if (box_distance(tree, b, y) > reach) cycle
      if (tree%n(b) == 0) then
        waiting(w + 1) = tree%first(b) + 1
        waiting(w + 2) = tree%first(b)
        w = w + 2
      else
        do k = tree%first(b), tree%first(b) + tree%n(b) - 1
          if (n == size(found)) return
          n = n + 1
          found(n) = tree%order(k)
        end do
      end if
    end do
  end subroutine facets_near

  !> Distance from a point to a box, 0 inside.
  pure real(wp) function box_distance(tree, b, y) result(d)
    type(facet_tree_t), intent(in) :: tree !! the tree
    integer, intent(in) :: b !! the box
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp) :: away(3)
    integer :: i

    do i = 1, 3
      away(i) = max(0.0_wp, tree%low(i, b) - y(i), y(i) - tree%high(i, b))
    end do
    d = norm2(away)
  end function box_distance
end module facet_tree

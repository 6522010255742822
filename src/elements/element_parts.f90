!> Elements shared among threads: the nodes are parted across the longest way of the mesh, and each
!! thread adds up what reaches its own nodes, in the order of the elements. So sums are those of one
!! thread, and only elements between two parts are computed twice (doc/theory, "Sparse
!! factorisation").
module element_parts
  use kinds, only: wp
  use element_lists, only: node_list_t
  use element_types, only: routine_none
  implicit none
  private
  public :: part_nodes, elements_of_part

  !> Places along the way that are told from each other.
  integer, parameter :: places_along = 1024

contains

  !> Parts of the nodes, about as many in each.
  pure subroutine part_nodes(x, parts, part)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: parts !! how many
    integer, intent(out) :: part(:) !! (nodes) 1 to parts
    integer :: place(size(part)), count_at(places_along), part_at(places_along), i, way, before
    real(wp) :: low(3), high(3)

    part = 1
    if (parts == 1 .or. size(part) == 0) return
    low = minval(x, 2)
    high = maxval(x, 2)
    way = maxloc(high - low, 1)
    if (high(way) <= low(way)) return
    count_at = 0
    do i = 1, size(part)
      place(i) = min(places_along, 1 + int(real(places_along, wp)*(x(way, i) &
        - low(way))/(high(way) &
        - low(way))))
      count_at(place(i)) = count_at(place(i)) + 1
    end do
    before = 0
    do i = 1, places_along
      part_at(i) = min(parts, 1 + int(real(parts, wp)*(real(before, wp) &
        + 0.5_wp*real(count_at(i), wp))/real(size(part), wp)))
      before = before + count_at(i)
    end do
    part = part_at(place)
  end subroutine part_nodes

  !> The elements that take part and reach a node of a part, ascending.
  pure subroutine elements_of_part(list, part, mine, which)
    class(node_list_t), intent(in) :: list !! elements
    integer, intent(in) :: part(:) !! (nodes) their parts
    integer, intent(in) :: mine !! the part
    integer, allocatable, intent(out) :: which(:) !! their numbers
    integer :: found(list%n), k, n

    n = 0
    do k = 1, list%n
      if (list%routine(k) == routine_none) cycle
      if (all(part(list%ix(:list%nel(k), k)) /= mine)) cycle
      n = n + 1
      found(n) = k
    end do
    which = found(:n)
  end subroutine elements_of_part
end module element_parts

!> The order of corners of a surface that nothing stands behind: neighbours must run along their
!! common edge in opposite directions (doc/theory, "Orientation of tool surfaces").
module facet_orders
  use key_sorting, only: sort_columns
  use facets, only: facet_neighbours
  implicit none
  private
  public :: facet_parts_t, agree_orders

  !> The parts of a surface that hang together by edges of two facets.
  type :: facet_parts_t
    integer :: count = 0 !! number of parts
    integer, allocatable :: of(:) !! (facets) part of each
    logical, allocatable :: turned(:) !! (facets) its corners are not in the order they had
    logical, allocatable :: closed(:) !! (parts) it has no boundary
    integer, allocatable :: clash(:, :) !! (2, n) facets that cannot agree: the part has one side
  end type facet_parts_t

contains

  !> Turns facets so that neighbours agree, in each part with the one that comes first.
  subroutine agree_orders(facets, parts)
    integer, intent(inout) :: facets(:, :) !! (3, n) corner nodes
    type(facet_parts_t), intent(out) :: parts !! what hangs together, and what was turned
    integer, allocatable :: neighbours(:, :), first(:, :)
    integer :: waiting(size(facets, 2)), f, g, k, seed, n, non_manifold

    call facet_neighbours(facets, neighbours, non_manifold)
    allocate (parts%of(size(facets, 2)), source=0)
    allocate (parts%turned(size(facets, 2)), source=.false.)
    first = facets
    do seed = 1, size(facets, 2)
      if (parts%of(seed) > 0) cycle
      parts%count = parts%count + 1
      parts%of(seed) = parts%count
      waiting(1) = seed
      n = 1
      do while (n > 0)
        f = waiting(n)
        n = n - 1
        do k = 1, 3
          g = neighbours(k, f)
          if (g == 0) cycle
          if (parts%of(g) > 0) cycle
          parts%of(g) = parts%count
          parts%turned(g) = parts%turned(f) .eqv. agree(first(:, f), first(:, g), k)
          n = n + 1
          waiting(n) = g
        end do
      end do
    end do
    do f = 1, size(facets, 2)
      if (parts%turned(f)) facets(:, f) = first([2, 1, 3], f)
    end do
    call find_clashes(first, neighbours, parts)
    call find_closed(facets, parts)
  end subroutine agree_orders

  !> The common edge of two facets has opposite directions in them.
  pure logical function agree(f, g, k)
    integer, intent(in) :: f(3) !! corners of one facet
    integer, intent(in) :: g(3) !! corners of its neighbour
    integer, intent(in) :: k !! the corner of f that faces the edge
    integer :: i

    agree = .false.
    do i = 1, 3
      agree = agree .or. g(i) == f(mod(k + 1, 3) + 1) .and. g(mod(i, 3) + 1) == f(mod(k, 3) + 1)
    end do
  end function agree

  !> Neighbours that disagree when all others agree: the part is one-sided, like Moebius' strip.
  subroutine find_clashes(first, neighbours, parts)
    integer, intent(in) :: first(:, :) !! (3, facets) corners in the order they had
    integer, intent(in) :: neighbours(:, :) !! (3, facets) facet facing corner k, 0: boundary
    type(facet_parts_t), intent(inout) :: parts !! gets clash
    integer :: pass, f, g, k, n

    do pass = 1, 2
      n = 0
      do f = 1, size(first, 2)
        do k = 1, 3
          g = neighbours(k, f)
          if (g <= f) cycle
          if (agree(first(:, f), first(:, g), k) .eqv. &
            (parts%turned(f) .eqv. parts%turned(g))) cycle
          n = n + 1
          if (pass == 2) parts%clash(:, n) = [f, g]
        end do
      end do
      if (pass == 1) allocate (parts%clash(2, n))
    end do
  end subroutine find_clashes

  !> A part is closed if each of its edges belongs to an even number of its facets.
  subroutine find_closed(facets, parts)
    integer, intent(in) :: facets(:, :) !! (3, n) corner nodes
    type(facet_parts_t), intent(inout) :: parts !! gets closed
    integer, allocatable :: edges(:, :), order(:)
    integer :: f, k, i, n, a, b

    allocate (edges(3, 3*size(facets, 2)), parts%closed(parts%count))
    do f = 1, size(facets, 2)
      do k = 1, 3
        a = facets(k, f)
        b = facets(mod(k, 3) + 1, f)
        edges(:, 3*(f - 1) + k) = [parts%of(f), min(a, b), max(a, b)]
      end do
    end do
    call sort_columns(edges, order)
    parts%closed = .true.
    n = 0
    do i = 1, size(order)
      n = n + 1
      if (i < size(order)) then
        if (all(edges(:, order(i)) == edges(:, order(i + 1)))) cycle
      end if
      if (mod(n, 2) == 1) parts%closed(edges(1, order(i))) = .false.
      n = 0
    end do
  end subroutine find_closed
end module facet_orders

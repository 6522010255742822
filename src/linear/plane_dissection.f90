!> Nested dissection of a mesh whose nodes lie in planes: a box of cells, graded or not (doc/theory,
!! "Static condensation", eq. (12.3)).
!!
!! Planes of nodes, straight or diagonal, part such a mesh. Each cut is the one of least work: a
!! separator is as dear as what lies around its part of the mesh is large, which METIS does not
!! know.
module plane_dissection
  use kinds, only: wp
  use block_matrix, only: block_matrix_t
  use lapack_interface, only: dlasrt
  implicit none
  private
  public :: dissect_planes

  !> Numbers of planes.
  integer, parameter :: short = selected_int_kind(4)
  !> Directions across which is cut: steps along the axes, in planes.
  integer, parameter :: ways = 9
  integer, parameter :: steps(3, ways) = reshape([1, 0, 0, 0, 1, 0, 0, 0, 1, 1, -1, 0, 1, 0, -1, &
    0, 1, -1, 1, 1, 0, 1, 0, 1, 0, 1, 1], [3, ways])
  !> Parts of so few nodes are not cut.
  integer, parameter :: few_nodes = 20
  !> A node is in so few places where planes of three directions meet, and there are at most so many
  !! planes.
  integer, parameter :: most_places = 8, most_planes = 16000
  !> Planes are apart by such a share of the mesh.
  real(wp), parameter :: apart = 1.0e-6_wp
  !> Neither side of a cut has less than this share of both.
  real(wp), parameter :: least_side = 0.1_wp
  !> The separator of a part of n nodes is taken to have so many n^(2/3).
  real(wp), parameter :: usual_separator = 0.85_wp

  !> Part of a node that has no equations.
  integer, parameter :: elsewhere = -huge(1)

  !> What the search for cuts works on. A width is a multiple of eight: the maximum of that many
  !! numbers is one instruction.
  type :: parts_t
    integer(short), allocatable :: plane(:, :) !! (16, nodes) plane of each node in each direction
    integer(short), allocatable :: reach(:, :) !! (16, nodes) highest plane of it and its neighbours
    !! in the part
    integer(short), allocatable :: low(:, :), high(:, :) !! (16, border) lowest and highest plane
    !! of the part next to each node of its border
    integer, allocatable :: part(:) !! (nodes) part or border that a node was in last: k or -k
    integer, allocatable :: place(:) !! (nodes) its place on that border
    integer, allocatable :: order(:) !! (inner) the nodes, part after part
    real(wp), allocatable :: work(:, :) !! (3, 0:inner) coefficients of usual_work
    integer :: parts = 0 !! parts that have been looked at
    integer :: border = 0 !! nodes of the border of the present one
  end type parts_t

contains

  !> Puts nodes of a graph into the order of their elimination, if they lie in planes.
  subroutine dissect_planes(blocks, x, later, inner, found)
    type(block_matrix_t), intent(in) :: blocks !! the graph
    real(wp), intent(in) :: x(:, :) !! (3, nodes) coordinates [length]
    integer, intent(in) :: later(:) !! nodes that are eliminated later
    integer, intent(inout) :: inner(:) !! the nodes; get their order
    logical, intent(out) :: found !! they lie in planes
    type(parts_t) :: parts

    call number_planes(x, [inner, later], parts%plane, found)
    if (.not. found) return
    allocate (parts%reach(16, blocks%nodes), parts%low(16, size(inner) + size(later)), &
      parts%high(16, size(inner) + size(later)), parts%place(blocks%nodes), &
      parts%work(3, 0:size(inner)))
    parts%part = spread(elsewhere, 1, blocks%nodes)
    parts%part(inner) = 0
    parts%part(later) = 0
    parts%order = inner
    call foresee_work(parts%work)
    call cut(blocks, parts, 1, size(inner))
    inner = parts%order
  end subroutine dissect_planes

  !> Numbers the planes of all directions, if nodes lie in planes.
  subroutine number_planes(x, nodes, plane, found)
    real(wp), intent(in) :: x(:, :) !! (3, all nodes) coordinates [length]
    integer, intent(in) :: nodes(:) !! the nodes
    integer(short), allocatable, intent(out) :: plane(:, :) !! (16, all nodes) plane of each of them
    !! in each direction
    logical, intent(out) :: found !! they do
    integer :: axis, i, planes(3), along(3, size(nodes))
    real(wp) :: wide

    found = .false.
    if (size(nodes) == 0) return
    wide = maxval(maxval(x(:, nodes), 2) - minval(x(:, nodes), 2))
    do axis = 1, 3
      call number_axis(x(axis, nodes), apart*wide, along(axis, :), planes(axis))
    end do
    found = product(real(planes, wp)) <= real(most_places, wp)*real(size(nodes), wp) .and. &
      all(planes <= most_planes)
    if (.not. found) return
    allocate (plane(16, size(x, 2)))
    do i = 1, size(nodes)
      plane(:ways, nodes(i)) = int(matmul(along(:, i), steps), short)
      plane(ways + 1:, nodes(i)) = 0
    end do
  end subroutine number_planes

  !> Numbers the planes across one axis.
  subroutine number_axis(x, near, plane, planes)
    real(wp), intent(in) :: x(:) !! (nodes) coordinates [length]
    real(wp), intent(in) :: near !! nodes in one plane are as near as this to the next [length]
    integer, intent(out) :: plane(:) !! (nodes) the plane of each
    integer, intent(out) :: planes !! how many there are
    real(wp) :: level(size(x))
    integer :: i, low, high, info

    level = x
    call dlasrt('I', size(level), level, info)
    planes = 1
    do i = 2, size(level)
      if (level(i) - level(planes) <= near) cycle
      planes = planes + 1
      level(planes) = level(i)
    end do
    do i = 1, size(x)
      low = 1
      high = planes
      do while (low < high)
        plane(i) = (low + high + 1)/2
        if (level(plane(i)) <= x(i)) then
          low = plane(i)
        else
          high = plane(i) - 1
        end if
      end do
      plane(i) = low
    end do
  end subroutine number_axis

  !> Work of eliminating a part of n nodes with a border of b nodes, which halves of it share evenly
  !! with their separator: its coefficients of 1, b and b^2.
  pure subroutine foresee_work(work)
    real(wp), intent(out) :: work(:, 0:) !! (3, nodes)
    real(wp) :: s
    integer :: n

    work = 0.0_wp
    do n = few_nodes/2, ubound(work, 2)
      s = usual_separator*real(n, wp)**(2.0_wp/3.0_wp)
      associate (half => work(:, max(0, int(0.5_wp*(real(n, wp) - s)))))
        work(1, n) = s**3/3.0_wp + 2.0_wp*(half(1) + half(2)*s + half(3)*s**2)
        work(2, n) = s**2 + half(2) + 2.0_wp*half(3)*s
        work(3, n) = s + 0.5_wp*half(3)
      end associate
    end do
  end subroutine foresee_work

  !> Cuts a part of the nodes, and both sides of it again: the separator comes after them.
  recursive subroutine cut(blocks, parts, first, last)
    type(block_matrix_t), intent(in) :: blocks !! the graph
    type(parts_t), intent(inout) :: parts !! order gets that of the part
    integer, intent(in) :: first, last !! places of the part
    integer :: way, plane, below, above

    if (last - first < few_nodes) return
    call look_around(blocks, parts, first, last)
    call choose_cut(parts, first, last, way, plane)
    if (way == 0) return
    call divide(parts, first, last, way, plane, below, above)
    call cut(blocks, parts, first, first + below - 1)
    call cut(blocks, parts, first + below, first + below + above - 1)
  end subroutine cut

  !> How far the nodes of a part reach, and where its border is next to it.
  subroutine look_around(blocks, parts, first, last)
    type(block_matrix_t), intent(in) :: blocks !! the graph
    type(parts_t), intent(inout) :: parts !! order given; gets reach, low, high, border
    integer, intent(in) :: first, last !! places of the part
    integer :: at, i, j, k

    parts%parts = parts%parts + 1
    parts%border = 0
    parts%part(parts%order(first:last)) = parts%parts
    do at = first, last
      i = parts%order(at)
      parts%reach(:, i) = parts%plane(:, i)
      do k = blocks%ptr(i), blocks%ptr(i + 1) - 1
        j = blocks%row(k)
        if (parts%part(j) == parts%parts) then
          parts%reach(:, i) = max(parts%reach(:, i), parts%plane(:, j))
        else if (parts%part(j) == -parts%parts) then
          associate (low => parts%low(:, parts%place(j)), high => parts%high(:, parts%place(j)))
            low = min(low, parts%plane(:, i))
            high = max(high, parts%plane(:, i))
          end associate
        else if (parts%part(j) /= elsewhere) then
          parts%border = parts%border + 1
          parts%part(j) = -parts%parts
          parts%place(j) = parts%border
          parts%low(:, parts%border) = parts%plane(:, i)
          parts%high(:, parts%border) = parts%plane(:, i)
        end if
      end do
    end do
  end subroutine look_around

  !> The cut of least work: nodes up to a plane are below it, those of them that reach beyond it are
  !! the separator.
  subroutine choose_cut(parts, first, last, way, plane)
    type(parts_t), intent(in) :: parts !! the part has been looked at
    integer, intent(in) :: first, last !! its places
    integer, intent(out) :: way, plane !! direction, 0 if there is none, and last plane below
    real(wp) :: work, least
    integer :: d, p

    way = 0
    plane = 0
    least = huge(1.0_wp)
    do d = 1, ways
      call try_way(parts, first, last, d, p, work)
      if (work >= least) cycle
      least = work
      way = d
      plane = p
    end do
  end subroutine choose_cut

  !> The cut of least work in one direction.
  subroutine try_way(parts, first, last, d, plane, least)
    type(parts_t), intent(in) :: parts !! the part has been looked at
    integer, intent(in) :: first, last !! its places
    integer, intent(in) :: d !! the direction
    integer, intent(out) :: plane !! last plane below
    real(wp), intent(out) :: least !! its work, huge if there is none
    integer :: low, high, p, upto, below, above, separator, sides(2)
    integer, allocatable :: nodes(:), inside(:), lows(:), highs(:)
    real(wp) :: work

    associate (at => parts%order(first:last))
      low = minval(int(parts%plane(d, at)))
      high = maxval(int(parts%plane(d, at)))
      nodes = counts(parts%plane(d, at), low, high)
      inside = counts(parts%reach(d, at), low, high)
    end associate
    lows = counts(parts%low(d, :parts%border), low, high)
    highs = counts(parts%high(d, :parts%border), low, high)
    least = huge(1.0_wp)
    plane = low
    upto = 0
    below = 0
    sides = [0, parts%border]
    do p = low, high
      upto = upto + nodes(p - low + 1)
      below = below + inside(p - low + 1)
      sides = sides + [lows(p - low + 1), -highs(p - low + 1)]
      above = last - first + 1 - upto
      separator = upto - below
      if (real(min(below, above), wp) <= least_side*real(below + above, wp)) cycle
      work = own_work(separator, parts%border) &
        + usual_work(parts%work(:, below), sides(1) + separator) &
        + usual_work(parts%work(:, above), sides(2) + separator)
      if (work >= least) cycle
      least = work
      plane = p
    end do
  end subroutine try_way

  !> How many of the numbers from low to high there are of each.
  pure function counts(numbers, low, high)
    integer(short), intent(in) :: numbers(:) !! the numbers
    integer, intent(in) :: low, high !! lowest and highest of them
    integer :: counts(high - low + 1)
    integer :: i

    counts = 0
    do i = 1, size(numbers)
      associate (n => counts(numbers(i) - low + 1))
        n = n + 1
      end associate
    end do
  end function counts

  !> Work of eliminating the nodes of a separator with what lies around its part.
  pure real(wp) function own_work(separator, border) result(work)
    integer, intent(in) :: separator, border !! nodes
    real(wp) :: s, b

    s = real(separator, wp)
    b = real(border, wp)
    work = s*(s**2/3.0_wp + s*b + b**2)
  end function own_work

  !> Work that a part is expected to take.
  pure real(wp) function usual_work(work, border)
    real(wp), intent(in) :: work(3) !! its coefficients
    integer, intent(in) :: border !! nodes around it
    real(wp) :: b

    b = real(border, wp)
    usual_work = work(1) + b*(work(2) + b*work(3))
  end function usual_work

  !> Sorts the nodes of a part: those below the cut, those above it, the separator.
  subroutine divide(parts, first, last, way, plane, below, above)
    type(parts_t), intent(inout) :: parts !! the part has been looked at; gets its order
    integer, intent(in) :: first, last !! its places
    integer, intent(in) :: way, plane !! the cut
    integer, intent(out) :: below, above !! nodes on both sides
    integer :: nodes(last - first + 1)
    logical, dimension(last - first + 1) :: is_below, is_above

    nodes = parts%order(first:last)
    is_above = parts%plane(way, nodes) > plane
    is_below = parts%reach(way, nodes) <= plane
    below = count(is_below)
    above = count(is_above)
    parts%order(first:last) = [pack(nodes, is_below), pack(nodes, is_above), &
      pack(nodes, .not. (is_below .or. is_above))]
  end subroutine divide
end module plane_dissection

!> Functions of multipliers on a slave facet, and the faces of a master (doc/theory, "Mortar
!! contact", eq. (7.14)).
module mortar_functions
  use kinds, only: wp
  use vectors, only: cross
  use contact_types, only: pair_t
  use cell_cutting, only: slave_parts
  use master_facets, only: normal_at_edge
  implicit none
  private
  public :: find_faces, hat_functions, dual_functions, frame_of, corners_of_parts

  !> Nodes of a facet of six that are the corners of its four parts.
  integer, parameter :: corners_of_parts(3, slave_parts) = reshape([1, 4, 6, 4, 2, 5, 6, 5, 3, 4, &
    5, 6], [3, slave_parts])

  !> Facets of the master whose normals have a smaller cosine belong to two faces: a multiplier that
  !! is continuous over such an edge cannot carry a traction that jumps.
  real(wp), parameter :: one_face = 0.9_wp
  !> A cover whose points leave a matrix of a larger condition is a sliver: there constants alone
  !! are reproduced.
  real(wp), parameter :: worst_condition = 1.0e10_wp
  !> A mean of axes that is shorter than this has no direction.
  real(wp), parameter :: shortest_axis = 1.0e-6_wp

contains

  !> The faces of the master: facets that hang together over edges without a kink.
  pure subroutine find_faces(pair, x)
    type(pair_t), intent(inout) :: pair !! facets and neighbours given; gets faces
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: queue(size(pair%surface%facets, 2)), f, k, next, first, last, faces

    pair%faces = spread(0, 1, size(queue))
    faces = 0
    do f = 1, size(queue)
      if (pair%faces(f) > 0) cycle
      faces = faces + 1
      queue(1) = f
      pair%faces(f) = faces
      first = 1
      last = 1
      do while (first <= last)
        do k = 1, 3
          next = pair%surface%neighbours(k, queue(first))
          if (next == 0) cycle
          if (pair%faces(next) > 0 .or. .not. goes_on(pair, x, queue(first), k)) cycle
          last = last + 1
          queue(last) = next
          pair%faces(next) = faces
        end do
        first = first + 1
      end do
    end do
  end subroutine find_faces

  !> The surface goes on over an edge of a facet without a kink.
  pure logical function goes_on(pair, x, facet, edge)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: facet !! the facet
    integer, intent(in) :: edge !! the edge that faces this corner

    associate (across => pair%surface%neighbours(edge, facet))
      goes_on = dot_product(normal_at_edge(pair, x, facet, across), &
        normal_at_edge(pair, x, across, facet)) > one_face
    end associate
  end function goes_on

  !> Hat functions of a place of a slave facet: its corners', or with six nodes those of the part
  !! that holds it.
  pure subroutine hat_functions(bent, place, corner, hat, part)
    logical, intent(in) :: bent !! six nodes
    real(wp), intent(in) :: place(3) !! shape functions of the corners alone
    integer, intent(out) :: corner(3) !! nodes of the facet, 1 to 6, that they belong to
    real(wp), intent(out) :: hat(3) !! values there
    integer, intent(out) :: part !! of the facet, 1 to slave_parts

    part = 1
    corner = [1, 2, 3]
    hat = place
    if (.not. bent) return
    part = maxloc(place, 1)
    if (place(part) < 0.5_wp) part = slave_parts
    corner = corners_of_parts(:, part)
    hat = 2.0_wp*place
    select case (part)
    case (1)
      hat(1) = hat(1) - 1.0_wp
    case (2)
      hat = [hat(1), hat(2) - 1.0_wp, hat(3)]
    case (3)
      hat = [hat(1), hat(2), hat(3) - 1.0_wp]
    case default
      hat = 1.0_wp - hat([3, 1, 2])
    end select
  end subroutine hat_functions

  !> Dual functions at the points of a cover: those that are orthogonal to the hat functions of the
  !! other nodes, psi = D M^-1 N (doc/theory, "Mortar contact", eq. (7.14)).
  pure subroutine dual_functions(hat, area, psi)
    real(wp), intent(in) :: hat(:, :) !! (3, points) hat functions
    real(wp), intent(in) :: area(:) !! (points) weights of the points [length^2]
    real(wp), intent(out) :: psi(:, :) !! (3, points) dual functions
    real(wp) :: m(3, 3), inverse(3, 3), d(3), det
    integer :: q, i

    m = 0.0_wp
    d = 0.0_wp
    do q = 1, size(area)
      do i = 1, 3
        m(:, i) = m(:, i) + area(q)*hat(:, q)*hat(i, q)
      end do
      d = d + area(q)*hat(:, q)
    end do
    psi = hat
    do i = 1, 3
      inverse(i, :) = cross(m(:, mod(i, 3) + 1), m(:, mod(i + 1, 3) + 1))
    end do
    det = dot_product(inverse(1, :), m(:, 1))
    if (.not. norm2(m)*norm2(inverse) < worst_condition*det) return
    do i = 1, 3
      psi(i, :) = d(i)/det*matmul(inverse(i, :), hat)
    end do
  end subroutine dual_functions

  !> Axes p1, p2 = n x p1 and n, from sums of axes and normals.
  pure function frame_of(normal, axis) result(frame)
    real(wp), intent(in) :: normal(3) !! sum of normals
    real(wp), intent(in) :: axis(3) !! sum of axes
    real(wp) :: frame(3, 3), p(3)
    integer :: k

    frame(:, 3) = normal/norm2(normal)
    p = axis - dot_product(axis, frame(:, 3))*frame(:, 3)
    if (norm2(p) <= shortest_axis*norm2(axis)) then
      k = minloc(abs(frame(:, 3)), 1)
      p = -frame(k, 3)*frame(:, 3)
      p(k) = p(k) + 1.0_wp
    end if
    frame(:, 1) = p/norm2(p)
    frame(:, 2) = cross(frame(:, 3), frame(:, 1))
  end function frame_of
end module mortar_functions

!> Smooth surfaces: normals at the corners of their facets, and the curved patches that these give
!! (doc/theory, "Surface smoothing", eq. (6.7)). In more than 400 lines, since all is made of the
!! same normals.
module smooth_normals
  use kinds, only: wp, pi
  use vectors, only: cross
  use contact_types, only: pair_t, master_surface_t
  use facet_geometry, only: corners, facet_normal, project_on_facet
  use smooth_patch, only: patch_t, patch_point_t, n_patch_values, patch_from_values, &
    patch_values, project_on_patch, patch_at, patch_frame, dual_frame
  use master_facets, only: is_quadratic, facet_kind, all_corners, field_on_facet
  use quadratic_facet, only: project_on_quadratic
  implicit none
  private
  public :: find_corners, renew_patches, bend, measure_excess, project_on_master, &
    carry_over, place_on_master

  !> Facets whose normals have a smaller cosine meet in a sharp edge: 30 degrees and round-off.
  real(wp), parameter :: sharp_cosine = 0.866024_wp
  !> Where the facets of a corner at the boundary fill less than this angle, the boundary turns.
  real(wp), parameter :: end_angle = 0.75_wp*pi
  !> Most by which the normal at a boundary is tilted.
  real(wp), parameter :: most_tilt = 0.3_wp
  !> Directions in which the edges around a corner say less than this share are left alone.
  real(wp), parameter :: least_share = 0.05_wp

contains

  !> Makes the patches of the master, and of the slave if it is bent.
  subroutine find_corners(pair, x)
    type(pair_t), intent(inout) :: pair !! gets the patches of its surface and side
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call find_edges(pair%surface, x)
    if (allocated(pair%points%side%facets)) call find_edges(pair%points%side, x)
    call renew_patches(pair, x)
  end subroutine find_corners

  !> Sharp edges of a surface, and the corners of its facets that share a normal: those that are
  !! around one node without a sharp edge between them.
  subroutine find_edges(surface, x)
    type(master_surface_t), intent(inout) :: surface !! gets sharp, corner, at_*, patch
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer :: f, k, n, facets
    logical :: ends

    facets = size(surface%facets, 2)
    surface%sharp = spread([.true., .true., .true.], 2, facets)
    do f = 1, facets
      do k = 1, 3
        if (surface%neighbours(k, f) == 0) cycle
        surface%sharp(k, f) = dot_product(facet_normal(corners(x, surface%facets(:, f))), &
          facet_normal(corners(x, surface%facets(:, surface%neighbours(k, f))))) < sharp_cosine
      end do
    end do
    surface%corner = spread([0, 0, 0], 2, facets)
    allocate (surface%at_boundary(3*facets), source=.false.)
    n = 0
    do f = 1, facets
      do k = 1, 3
        if (surface%corner(k, f) > 0) cycle
        n = n + 1
        surface%corner(k, f) = n
        call mark_fan(surface, k, f, 1, ends)
        if (ends) call mark_fan(surface, k, f, 2, ends)
        surface%at_boundary(n) = ends
      end do
    end do
    surface%at_boundary = surface%at_boundary(1:n)
    surface%at_end = surface%at_boundary .and. angles_at(surface, x) < end_angle
    allocate (surface%patch(n_patch_values, facets), source=0.0_wp)
  end subroutine find_edges

  !> Gives the corners around a node the number of one of them, in one direction.
  pure subroutine mark_fan(surface, corner, facet, direction, ends)
    type(master_surface_t), intent(inout) :: surface !! gets corner
    integer, intent(in) :: corner !! where to start
    integer, intent(in) :: facet !! where to start
    integer, intent(in) :: direction !! the next edge faces this corner after the fan's; 1 or 2
    logical, intent(out) :: ends !! the fan ends at a boundary or a sharp edge
    integer :: f, k, edge, node

    f = facet
    k = corner
    node = surface%facets(k, f)
    do
      edge = mod(k + direction - 1, 3) + 1
      ends = surface%sharp(edge, f)
      if (ends) return
      f = surface%neighbours(edge, f)
      k = corner_of(surface%facets(:, f), node)
      if (surface%corner(k, f) > 0) return
      surface%corner(k, f) = surface%corner(corner, facet)
    end do
  end subroutine mark_fan

  !> Which corner of a facet a node is.
  pure integer function corner_of(nodes, node) result(k)
    integer, intent(in) :: nodes(3) !! corners
    integer, intent(in) :: node !! one of them

    do k = 1, 2
      if (nodes(k) == node) return
    end do
    k = 3
  end function corner_of

  !> The patches of all facets at the positions x + u, of the slave as well if it is bent. They are
  !! measured from a node of the surface: round-off is then that of its size, however far away from
  !! the origin it lies.
  pure subroutine renew_patches(pair, x, u)
    type(pair_t), intent(inout) :: pair !! gets the patches of its surface and side
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in), optional :: u(:, :) !! (3, nodes) displacements since [length]
    real(wp) :: y(3, size(x, 2))
    integer :: i

    associate (origin => x(:, pair%surface%facets(1, 1)))
      do i = 1, size(x, 2)
        y(:, i) = x(:, i) - origin
      end do
    end associate
    if (present(u)) y = y + u
    call bend(pair%surface, y)
    if (allocated(pair%points%side%facets)) call bend(pair%points%side, y)
  end subroutine renew_patches

  !> The patches of the facets of one surface.
  pure subroutine bend(surface, x)
    type(master_surface_t), intent(inout) :: surface !! gets patch
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: normal(3, size(surface%at_boundary))
    integer :: f

    call average_normals(surface, x, normal)
    if (any(surface%at_boundary)) call tilt_at_boundary(surface, x, normal)
    do f = 1, size(surface%facets, 2)
      surface%patch(:, f) = patch_values(patch_of(corners(x, surface%facets(:, f)), &
        normal(:, surface%corner(:, f))))
    end do
  end subroutine bend

  !> How much farther out than a round surface the patches lie (doc/theory, "Initial overlap", eq.
  !! (6.19)): an arc whose normals at the ends are 2 theta apart rises by 2 cos(theta)/(1 +
  !! cos(theta)) of what a parabola with these normals does, and by theta^2/20 of that more in the
  !! mean.
  pure subroutine measure_excess(surface, x)
    type(master_surface_t), intent(inout) :: surface !! with its patches at x; gets excess
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: normal(3, size(surface%at_boundary)), theta
    type(patch_t) :: patch
    integer :: f, k

    call average_normals(surface, x, normal)
    if (any(surface%at_boundary)) call tilt_at_boundary(surface, x, normal)
    surface%excess = 0.0_wp*surface%facets
    do f = 1, size(surface%facets, 2)
      patch = patch_from_values(surface%patch(:, f))
      associate (n => normal(:, surface%corner(:, f)))
        do k = 1, 3
          theta = 0.5_wp*acos(max(-1.0_wp, min(1.0_wp, dot_product(n(:, mod(k, 3) + 1), &
            n(:, mod(k + 1, 3) + 1)))))
          surface%excess(k, f) = -patch%edge(3, k)*(1.0_wp - 2.0_wp*cos(theta)/(1.0_wp &
            + cos(theta))*(1.0_wp + theta**2/20.0_wp))
        end do
      end associate
    end do
  end subroutine measure_excess

  !> Angle of one corner of a facet.
  pure real(wp) function angle_at(y, k) result(angle)
    real(wp), intent(in) :: y(3, 3) !! corners [length]
    integer, intent(in) :: k !! which corner
    real(wp) :: a(3), b(3)

    a = y(:, mod(k, 3) + 1) - y(:, k)
    b = y(:, mod(k + 1, 3) + 1) - y(:, k)
    angle = atan2(norm2(cross(a, b)), dot_product(a, b))
  end function angle_at

  !> Sum of the angles that the facets have at each corner.
  pure function angles_at(surface, x) result(angles)
    type(master_surface_t), intent(in) :: surface !! the surface
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: angles(size(surface%at_boundary))
    integer :: f, k

    angles = 0.0_wp
    do f = 1, size(surface%facets, 2)
      do k = 1, 3
        associate (angle => angles(surface%corner(k, f)))
          angle = angle + angle_at(x(:, surface%facets(:, f)), k)
        end associate
      end do
    end do
  end function angles_at

  !> Normals at the corners: those of the facets around, weighted with the angles there.
  pure subroutine average_normals(surface, x, normal)
    type(master_surface_t), intent(in) :: surface !! the surface
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(out) :: normal(:, :) !! (3, corners) unit normals
    real(wp) :: y(3, 3), n(3)
    integer :: f, k

    normal = 0.0_wp
    do f = 1, size(surface%facets, 2)
      y = corners(x, surface%facets(:, f))
      n = facet_normal(y)
      do k = 1, 3
        associate (m => normal(:, surface%corner(k, f)))
          m = m + angle_at(y, k)*n
        end associate
      end do
    end do
    do k = 1, size(normal, 2)
      normal(:, k) = normal(:, k)/norm2(normal(:, k))
    end do
  end subroutine average_normals

  !> Tilts the normals at a boundary, where facets lie on one side only, so that the edges that come
  !! from within end with the curvature that they begin with.
  pure subroutine tilt_at_boundary(surface, x, normal)
    type(master_surface_t), intent(in) :: surface !! the surface
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(inout) :: normal(:, :) !! (3, corners) unit normals
    real(wp) :: a(3, size(normal, 2)), b(2, size(normal, 2)), tilt(3)
    integer :: f, k, first, last

    a = 0.0_wp
    b = 0.0_wp
    do f = 1, size(surface%facets, 2)
      do k = 1, 3
        first = mod(k, 3) + 1
        last = mod(k + 1, 3) + 1
        call want_curvature(surface, x, normal, f, first, last, a, b)
        call want_curvature(surface, x, normal, f, last, first, a, b)
      end do
    end do
    do k = 1, size(normal, 2)
      if (.not. surface%at_boundary(k)) cycle
      tilt = matmul(tangents(normal(:, k)), solve_symmetric(a(:, k), b(:, k)))
      if (norm2(tilt) > most_tilt) tilt = tilt*(most_tilt/norm2(tilt))
      normal(:, k) = normal(:, k) + tilt/sqrt(1.0_wp - dot_product(tilt, tilt))
      normal(:, k) = normal(:, k)/norm2(normal(:, k))
    end do
  end subroutine tilt_at_boundary

  !> Adds what an edge with the unit vector d wants of the tilt t of the normal at its end on the
  !! boundary: d . (n + t) = -d . n of the other end. That end lies within; where the boundary
  !! turns, it may also lie on the boundary: along the boundary normals are right.
  pure subroutine want_curvature(surface, x, normal, f, here, there, a, b)
    type(master_surface_t), intent(in) :: surface !! the surface
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: normal(:, :) !! (3, corners) unit normals
    integer, intent(in) :: f !! a facet
    integer, intent(in) :: here !! end of the edge whose normal is tilted, if it is at the boundary
    integer, intent(in) :: there !! the other end
    real(wp), intent(inout) :: a(:, :) !! (3, corners) normal equations: 11, 22, 12
    real(wp), intent(inout) :: b(:, :) !! (2, corners) their right-hand sides
    real(wp) :: way(3), w(2)
    integer :: i, j

    i = surface%corner(here, f)
    j = surface%corner(there, f)
    if (.not. surface%at_boundary(i)) return
    if (surface%at_end(j) .or. (surface%at_boundary(j) .and. &
      .not. surface%at_end(i))) return
    way = x(:, surface%facets(there, f)) - x(:, surface%facets(here, f))
    way = way/norm2(way)
    w = matmul(way, tangents(normal(:, i)))
    a(:, i) = a(:, i) + [w(1)*w(1), w(2)*w(2), w(1)*w(2)]
    b(:, i) = b(:, i) - dot_product(way, normal(:, i) + normal(:, j))*w
  end subroutine want_curvature

  !> Two unit vectors across a unit vector.
  pure function tangents(n) result(e)
    real(wp), intent(in) :: n(3) !! unit vector
    real(wp) :: e(3, 2)

    e(:, 1) = 0.0_wp
    e(minloc(abs(n), 1), 1) = 1.0_wp
    e(:, 1) = cross(n, e(:, 1))
    e(:, 1) = e(:, 1)/norm2(e(:, 1))
    e(:, 2) = cross(n, e(:, 1))
  end function tangents

  !> Least squares: the shortest solution of [a1 a3; a3 a2] t = b, without the directions of
  !! which the matrix says nothing.
  pure function solve_symmetric(a, b) result(t)
    real(wp), intent(in) :: a(3) !! 11, 22, 12
    real(wp), intent(in) :: b(2) !! right-hand side
    real(wp) :: t(2)
    real(wp) :: angle, v(2, 2), lambda(2)
    integer :: i

    t = 0.0_wp
    if (.not. a(1) + a(2) > 0.0_wp) return
    angle = 0.5_wp*atan2(2.0_wp*a(3), a(1) - a(2))
    v(:, 1) = [cos(angle), sin(angle)]
    v(:, 2) = [-v(2, 1), v(1, 1)]
    do i = 1, 2
      lambda(i) = a(1)*v(1, i)**2 + a(2)*v(2, i)**2 + 2.0_wp*a(3)*v(1, i)*v(2, i)
      if (lambda(i) > least_share*(a(1) + a(2))) t = t + v(:, i)*dot_product(v(:, i), b)/lambda(i)
    end do
  end function solve_symmetric

  !> The patch of one facet: each edge becomes a parabola that is, as well as it can be, normal to
  !! the normals at its ends.
  pure function patch_of(x, normal) result(patch)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    real(wp), intent(in) :: normal(3, 3) !! unit normals there
    type(patch_t) :: patch
    real(wp) :: dual(3, 3), way(3), mean(3), along(2), size_c
    integer :: k, i, j

    dual = dual_frame(patch_frame(x))
    patch%normal = matmul(transpose(dual), normal)
    do k = 1, 3
      i = mod(k, 3) + 1
      j = mod(k + 1, 3) + 1
      way = x(:, j) - x(:, i)
      mean = normal(:, i) + normal(:, j)
      mean = mean - way*(dot_product(way, mean)/dot_product(way, way))
      mean = mean/norm2(mean)
      along = [dot_product(mean, normal(:, i)), dot_product(mean, normal(:, j))]
      size_c = (along(1)*dot_product(way, normal(:, i)) - along(2)*dot_product(way, &
        normal(:, j)))/sum(along**2)
      patch%edge(:, k) = size_c*matmul(mean, dual)
    end do
  end function patch_of

  !> Projection of a point on a facet of the master, be it flat, quadratic or a patch, and its
  !! signed distance.
  pure subroutine project_on_master(pair, facet, x, y, xi, gap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(out) :: xi(2) !! (xi, eta) of its projection
    real(wp), intent(out) :: gap !! distance, positive outside [length]

    if (is_quadratic(pair, facet)) then
      call project_on_quadratic(all_corners(pair, facet, x), facet_kind(pair, facet), y, xi, gap)
    else if (pair%smooth) then
      call project_on_patch(corners(x, pair%surface%facets(:, facet)), &
        patch_from_values(pair%surface%patch(:, facet)), y, xi, gap)
    else
      call project_on_facet(corners(x, pair%surface%facets(:, facet)), y, xi, gap)
    end if
  end subroutine project_on_master

  !> Where a point of one patch lies on the neighbouring one.
  pure subroutine carry_over(pair, x, from, to, xi_from, xi_to)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: from !! facet that is left
    integer, intent(in) :: to !! facet that is entered
    real(wp), intent(in) :: xi_from(2) !! (xi, eta) on the patch that is left
    real(wp), intent(out) :: xi_to(2) !! (xi, eta) on the other
    real(wp) :: gap

    call project_on_master(pair, to, x, place_on_master(pair, from, x, xi_from), xi_to, gap)
  end subroutine carry_over

  !> A place on a facet of the master, be it flat, quadratic or a patch.
  pure function place_on_master(pair, facet, x, xi) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: y(3)
    type(patch_point_t) :: point

    if (is_quadratic(pair, facet) .or. .not. pair%smooth) then
      y = field_on_facet(pair, facet, x, x, xi)
    else
      associate (nodes => pair%surface%facets(:, facet))
        point = patch_at(patch_from_values(pair%surface%patch(:, facet)), xi)
        y = x(:, nodes(3)) + matmul(patch_frame(x(:, nodes)), point%x)
      end associate
    end if
  end function place_on_master
end module smooth_normals

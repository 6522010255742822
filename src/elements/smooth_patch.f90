!> A curved patch over a triangular facet, with a normal at each point (doc/theory, "Surface
!! smoothing", eq. (6.8)).
!!
!! All vectors are given by their components along the facet's own a1, a2 and e (unit normal):
!! these are constants while a system is solved, so that the patch is carried, turned and
!! stretched with its facet.
module smooth_patch
  use kinds, only: wp
  use vectors, only: cross, dyad
  implicit none
  private
  public :: patch_t, patch_point_t, flat_patch, patch_from_values, patch_values, n_patch_values
  public :: patch_at, project_in_patch, project_on_patch, patch_frame, dual_frame, frame_change, &
    normal_curvature

  !> The patch has its full curvature up to this far outside its triangle, in shape functions;
  !! from there on it goes straight.
  real(wp), parameter :: margin = 0.25_wp
  !> A step of the projection below this is its last: the error of the next is its square.
  real(wp), parameter :: last_step = 1.0e-9_wp
  !> Determinants below this (1 for a flat patch) are too near to the centre of curvature.
  real(wp), parameter :: least_determinant = 0.05_wp
  !> Steps of the projection; it needs 2 to 5.
  integer, parameter :: most_steps = 30
  !> Numbers that describe a patch.
  integer, parameter :: n_patch_values = 18

  !> A patch, in components along a1, a2, e.
  type :: patch_t
    real(wp) :: edge(3, 3) = 0.0_wp !! (component, k) curvature c_k of the edge facing corner k
    real(wp) :: normal(3, 3) = 0.0_wp !! (component, a) normal at corner a
  end type patch_t

  !> A point of a patch, in components along a1, a2, e; the origin is corner 3.
  type :: patch_point_t
    real(wp) :: x(3) = 0.0_wp !! position
    real(wp) :: dx(3, 2) = 0.0_wp !! its derivatives by xi and eta
    real(wp) :: n(3) = 0.0_wp !! normal, not of unit length
    real(wp) :: dn(3, 2) = 0.0_wp !! its derivatives by xi and eta
  end type patch_point_t

contains

  !> The patch that is the facet itself.
  pure function flat_patch() result(patch)
    type(patch_t) :: patch

    patch%edge = 0.0_wp
    patch%normal = 0.0_wp
    patch%normal(3, :) = 1.0_wp
  end function flat_patch

  !> A patch from a row of numbers.
  pure function patch_from_values(v) result(patch)
    real(wp), intent(in) :: v(n_patch_values) !! as patch_values gives them
    type(patch_t) :: patch

    patch%edge = reshape(v(1:9), [3, 3])
    patch%normal = reshape(v(10:18), [3, 3])
  end function patch_from_values

  !> The row of numbers that describes a patch.
  pure function patch_values(patch) result(v)
    type(patch_t), intent(in) :: patch !! the patch
    real(wp) :: v(n_patch_values)

    v(1:9) = reshape(patch%edge, [9])
    v(10:18) = reshape(patch%normal, [9])
  end function patch_values

  !> a1, a2 and the unit normal e of a facet, as columns.
  pure function patch_frame(x) result(frame)
    real(wp), intent(in) :: x(3, 3) !! corners, counter-clockwise seen from outside [length]
    real(wp) :: frame(3, 3)

    frame(:, 1) = x(:, 1) - x(:, 3)
    frame(:, 2) = x(:, 2) - x(:, 3)
    frame(:, 3) = cross(frame(:, 1), frame(:, 2))
    frame(:, 3) = frame(:, 3)/norm2(frame(:, 3))
  end function patch_frame

  !> Its dual a^1, a^2, e as columns: the transpose takes a vector to its components.
  pure function dual_frame(frame) result(dual)
    real(wp), intent(in) :: frame(3, 3) !! a1, a2, e
    real(wp) :: dual(3, 3)
    real(wp) :: size_n

    size_n = dot_product(cross(frame(:, 1), frame(:, 2)), frame(:, 3))
    dual(:, 1) = cross(frame(:, 2), frame(:, 3))/size_n
    dual(:, 2) = cross(frame(:, 3), frame(:, 1))/size_n
    dual(:, 3) = frame(:, 3)
  end function dual_frame

  !> Derivative of w1 a1 + w2 a2 + w3 e with fixed components by the positions of the corners.
  pure function frame_change(frame, dual, w) result(a)
    real(wp), intent(in) :: frame(3, 3) !! a1, a2, e
    real(wp), intent(in) :: dual(3, 3) !! a^1, a^2, e
    real(wp), intent(in) :: w(3) !! components
    real(wp) :: a(3, 9)
    integer :: k

    a(:, 1:3) = -w(3)*dyad(dual(:, 1), frame(:, 3))
    a(:, 4:6) = -w(3)*dyad(dual(:, 2), frame(:, 3))
    do k = 1, 3
      a(k, k) = a(k, k) + w(1)
      a(k, 3 + k) = a(k, 3 + k) + w(2)
    end do
    a(:, 7:9) = -a(:, 1:3) - a(:, 4:6)
  end function frame_change

  !> Derivative of (de/dx)^T g with g fixed by the positions of the corners: second derivative of
  !! the facet's unit normal.
  pure function normal_curvature(frame, dual, g) result(k)
    real(wp), intent(in) :: frame(3, 3) !! a1, a2, e
    real(wp), intent(in) :: dual(3, 3) !! a^1, a^2, e
    real(wp), intent(in) :: g(3) !! any vector
    real(wp) :: k(9, 9)
    real(wp) :: de(3, 9), change(9), row(3, 9), along(2)
    integer :: i, j, m

    de = frame_change(frame, dual, [0.0_wp, 0.0_wp, 1.0_wp])
    along = matmul(g, dual(:, 1:2))
    k = 0.0_wp
    do i = 1, 2
      ! g . d(a^i) = -(g . a^j) (a^i . da_j) - (g . e) (a^i . de)
      change = -dot_product(g, frame(:, 3))*matmul(dual(:, i), de)
      do j = 1, 2
        change(3*j - 2:3*j) = change(3*j - 2:3*j) - along(j)*dual(:, i)
        change(7:9) = change(7:9) + along(j)*dual(:, i)
      end do
      row = -dyad(frame(:, 3), change) - along(i)*de
      do m = 1, 3
        k(3*i - 3 + m, :) = row(m, :)
        k(6 + m, :) = k(6 + m, :) - row(m, :)
      end do
    end do
  end function normal_curvature

  !> Position and normal at (xi, eta), with their derivatives.
  pure function patch_at(patch, xi) result(point)
    type(patch_t), intent(in) :: patch !! the patch
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    type(patch_point_t) :: point
    real(wp) :: n(3), c(3), dn(3, 2), dc(3, 2), q, dq(2)
    integer :: k, i, j

    n = [xi(1), xi(2), 1.0_wp - xi(1) - xi(2)]
    dn(:, 1) = [1.0_wp, 0.0_wp, -1.0_wp]
    dn(:, 2) = [0.0_wp, 1.0_wp, -1.0_wp]
    call restrain(n, dn, c, dc)
    point%x = [xi(1), xi(2), 0.0_wp]
    point%dx = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp], [3, 2])
    do k = 1, 3
      i = mod(k, 3) + 1
      j = mod(k + 1, 3) + 1
      q = c(j)*n(i) + c(i)*n(j) - c(i)*c(j)
      dq = c(j)*dn(i, :) + c(i)*dn(j, :) + dc(j, :)*(n(i) - c(i)) + dc(i, :)*(n(j) - c(j))
      point%x = point%x - q*patch%edge(:, k)
      point%dx(:, 1) = point%dx(:, 1) - dq(1)*patch%edge(:, k)
      point%dx(:, 2) = point%dx(:, 2) - dq(2)*patch%edge(:, k)
    end do
    point%n = matmul(patch%normal, c)
    point%dn = matmul(patch%normal, dc)
  end function patch_at

  !> Shape functions c at the point where the way from the centroid to n leaves the margin; n
  !! itself within it.
  pure subroutine restrain(n, dn, c, dc)
    real(wp), intent(in) :: n(3) !! shape functions
    real(wp), intent(in) :: dn(3, 2) !! their derivatives
    real(wp), intent(out) :: c(3) !! restrained ones
    real(wp), intent(out) :: dc(3, 2) !! their derivatives
    real(wp), parameter :: third = 1.0_wp/3.0_wp
    real(wp) :: share, way
    integer :: m, j

    c = n
    dc = dn
    m = minloc(n, 1)
    if (n(m) >= -margin) return
    way = third - n(m)
    share = (third + margin)/way
    c = third + share*(n - third)
    do j = 1, 2
      dc(:, j) = share*(dn(:, j) + (n - third)/way*dn(m, j))
    end do
  end subroutine restrain

  !> Projection along the normals of the patch: y = x(xi) + gamma n(xi), by Newton's method from
  !! the projection on the facet's plane. All in components.
  pure subroutine project_in_patch(patch, y, xi, gamma, found)
    type(patch_t), intent(in) :: patch !! the patch
    real(wp), intent(in) :: y(3) !! the point
    real(wp), intent(out) :: xi(2) !! (xi, eta) of its projection
    real(wp), intent(out) :: gamma !! distance over the length of n
    logical, intent(out) :: found !! the iteration has converged
    type(patch_point_t) :: point
    real(wp) :: t1(3), t2(3), residual(3), det, step(2), n_t2(3), t1_n(3)
    integer :: i

    xi = y(1:2)
    gamma = y(3)
    found = .false.
    do i = 1, most_steps
      point = patch_at(patch, xi)
      t1 = point%dx(:, 1) + gamma*point%dn(:, 1)
      t2 = point%dx(:, 2) + gamma*point%dn(:, 2)
      residual = y - point%x - gamma*point%n
      t1_n = cross(point%n, t1)
      n_t2 = cross(t2, point%n)
      det = dot_product(t1, n_t2)
      if (.not. det >= least_determinant) return
      step = [dot_product(n_t2, residual), dot_product(t1_n, residual)]/det
      xi = xi + step
      gamma = gamma + dot_product(cross(t1, t2), residual)/det
      if (maxval(abs(step)) > last_step) cycle
      found = .true.
      return
    end do
  end subroutine project_in_patch

  !> Projection of a point on a patch and its signed distance; on the facet's plane where the
  !! patch gives no answer.
  pure subroutine project_on_patch(x, patch, y, xi, gap)
    real(wp), intent(in) :: x(3, 3) !! corners [length]
    type(patch_t), intent(in) :: patch !! the patch
    real(wp), intent(in) :: y(3) !! the point [length]
    real(wp), intent(out) :: xi(2) !! (xi, eta) of its projection
    real(wp), intent(out) :: gap !! distance, positive outside [length]
    type(patch_point_t) :: point
    real(wp) :: frame(3, 3), z(3)
    logical :: found

    frame = patch_frame(x)
    z = matmul(y - x(:, 3), dual_frame(frame))
    call project_in_patch(patch, z, xi, gap, found)
    if (found) then
      point = patch_at(patch, xi)
      gap = gap*norm2(matmul(frame, point%n))
    else
      xi = z(1:2)
      gap = z(3)
    end if
  end subroutine project_on_patch
end module smooth_patch

!> Finite rotations: the exponential map from a rotation vector to its matrix, and back
!! (doc/theory, "Rigid bodies", eq. (9.6)).
module rotations
  use kinds, only: wp, pi
  use vectors, only: identity
  implicit none
  private
  public :: spin, rotation_matrix, rotation_vector

contains

  !> The matrix that takes a vector v to the product a x v.
  pure function spin(a) result(m)
    real(wp), intent(in) :: a(3) !! a vector
    real(wp) :: m(3, 3)

    m = reshape([0.0_wp, a(3), -a(2), -a(3), 0.0_wp, a(1), a(2), -a(1), 0.0_wp], [3, 3])
  end function spin

  !> The rotation about a vector by its length: I + sin(t)/t [v] + (1 - cos(t))/t^2 [v]^2.
  pure function rotation_matrix(v) result(r)
    real(wp), intent(in) :: v(3) !! rotation vector [radian]
    real(wp) :: r(3, 3), w(3, 3), t, half

    t = norm2(v)
    w = spin(v)
    r = identity
    if (t <= 0.0_wp) return
    half = sin(0.5_wp*t)/t
    r = r + sin(t)/t*w + 2.0_wp*half**2*matmul(w, w)
  end function rotation_matrix

  !> The vector of a rotation; of those that differ by whole turns the one next to `near`.
  pure function rotation_vector(r, near) result(v)
    real(wp), intent(in) :: r(3, 3) !! rotation
    real(wp), intent(in) :: near(3) !! rotation vector [radian]
    real(wp) :: v(3), q(0:3), axis(3), angle

    q = quaternion(r)
    angle = 2.0_wp*atan2(norm2(q(1:3)), q(0))
    axis = 0.0_wp
    if (norm2(q(1:3)) > 0.0_wp) then
      axis = q(1:3)/norm2(q(1:3))
    else if (norm2(near) > 0.0_wp) then
      axis = near/norm2(near)
    end if
    v = (angle + 2.0_wp*pi*anint((dot_product(near, axis) - angle)/(2.0_wp*pi)))*axis
  end function rotation_vector

  !> Unit quaternion of a rotation, from its largest component (Spurrier).
  pure function quaternion(r) result(q)
    real(wp), intent(in) :: r(3, 3) !! rotation
    real(wp) :: q(0:3), m(0:3, 0:3), trace
    integer :: i

    ! 4 q q^T
    trace = r(1, 1) + r(2, 2) + r(3, 3)
    m(1:3, 1:3) = r + transpose(r)
    do i = 1, 3
      m(i, i) = 1.0_wp + 2.0_wp*r(i, i) - trace
    end do
    m(0, :) = [1.0_wp + trace, r(3, 2) - r(2, 3), r(1, 3) - r(3, 1), r(2, 1) - r(1, 2)]
    m(1:3, 0) = m(0, 1:3)
    i = maxloc([(m(i, i), i=0, 3)], 1) - 1
    q = m(:, i)/norm2(m(:, i))
  end function quaternion
end module rotations

!> Vectors in space.
module vectors
  use kinds, only: wp
  implicit none
  private
  public :: cross, dyad

contains

  !> Vector product a x b.
  pure function cross(a, b) result(c)
    real(wp), intent(in) :: a(3) !! first vector
    real(wp), intent(in) :: b(3) !! second vector
    real(wp) :: c(3)

    c = [a(2)*b(3) - a(3)*b(2), a(3)*b(1) - a(1)*b(3), a(1)*b(2) - a(2)*b(1)]
  end function cross

  !> Dyadic product: the matrix a_i b_j.
  pure function dyad(a, b) result(m)
    real(wp), intent(in) :: a(:) !! (n) first vector
    real(wp), intent(in) :: b(:) !! (m) second vector
    real(wp) :: m(size(a), size(b))
    integer :: j

    do j = 1, size(b)
      m(:, j) = a*b(j)
    end do
  end function dyad
end module vectors

!> The slave point of a contact element: one node, or the weighted sum of a few (doc/theory,
!! "Weighted slave points").
module slave_points
  use kinds, only: wp
  use element_types, only: element_t, max_dofs
  implicit none
  private
  public :: positions, spread_point, spread_rows

contains

  !> Positions of S, 1, 2, 3 seen from 3, so that the distance to the origin costs no digits.
  pure function positions(e) result(x)
    type(element_t), intent(in) :: e !! local data
    real(wp) :: x(3, 4)
    integer :: b, k, last

    last = e%slaves + 3
    if (e%slaves == 1) then
      x(:, 1) = (e%xl(:, 1) - e%xl(:, last)) + (e%ul(:, 1) - e%ul(:, last))
    else
      x(:, 1) = 0.0_wp
      do b = 1, e%slaves
        x(:, 1) = x(:, 1) + e%weight(b)*((e%xl(:, b) - e%xl(:, last)) &
          + (e%ul(:, b) - e%ul(:, last)))
      end do
    end if
    do k = 1, 3
      associate (node => e%slaves + k)
        x(:, k + 1) = (e%xl(:, node) - e%xl(:, last)) + (e%ul(:, node) - e%ul(:, last))
      end associate
    end do
  end function positions

  !> From the point S to its nodes: r_b = M_b r_S, and likewise rows and columns of s
  !! (doc/theory, "Weighted slave points").
  pure subroutine spread_point(with_matrix, e)
    logical, intent(in) :: with_matrix !! s is spread, too
    type(element_t), intent(inout) :: e !! r and s of S, 1, 2, 3 become those of all nodes
    real(wp) :: r(12), s(12, 12), rows(max_dofs, 12)
    integer :: b, j, n

    n = 3*e%slaves
    r = e%r(1:12)
    do b = 1, e%slaves
      e%r(3*b - 2:3*b) = e%weight(b)*r(1:3)
    end do
    e%r(n + 1:n + 9) = r(4:12)
    if (.not. with_matrix) return
    s = e%s(1:12, 1:12)
    do j = 1, 12
      do b = 1, e%slaves
        rows(3*b - 2:3*b, j) = e%weight(b)*s(1:3, j)
      end do
      rows(n + 1:n + 9, j) = s(4:12, j)
    end do
    do b = 1, e%slaves
      e%s(1:n + 9, 3*b - 2:3*b) = e%weight(b)*rows(1:n + 9, 1:3)
    end do
    e%s(1:n + 9, n + 1:n + 9) = rows(1:n + 9, 4:12)
  end subroutine spread_point
  !> Rows of s that belong to the displacements of S, 1, 2, 3: to those of all nodes.
  pure subroutine spread_rows(last, e)
    integer, intent(in) :: last !! the first rows of s, up to this one
    type(element_t), intent(inout) :: e !! s is spread
    real(wp) :: rows(last, 12)
    integer :: b, n

    n = 3*e%slaves
    rows = e%s(1:last, 1:12)
    do b = 1, e%slaves
      e%s(1:last, 3*b - 2:3*b) = e%weight(b)*rows(:, 1:3)
    end do
    e%s(1:last, n + 1:n + 9) = rows(:, 4:12)
  end subroutine spread_rows
end module slave_points

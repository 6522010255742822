!> The slave point of a contact element: one node, or the weighted sum of a few (doc/theory,
!! "Weighted slave points").
module slave_points
  use kinds, only: wp
  use element_types, only: element_t, task_tangent, task_stick_tangent, task_residual, &
    task_shift_tangent, task_stick_shift_tangent
  implicit none
  private
  public :: positions, spread_element

contains

  !> Positions of S and of the nodes of the facet seen from its corner 3, so that the distance to
  !! the origin costs no digits.
  pure function positions(e, masters) result(x)
    type(element_t), intent(in) :: e !! local data
    integer, intent(in) :: masters !! nodes of the facet
    real(wp) :: x(3, 1 + masters)
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
    do k = 1, masters
      associate (node => e%slaves + k)
        x(:, k + 1) = (e%xl(:, node) - e%xl(:, last)) + (e%ul(:, node) - e%ul(:, last))
      end associate
    end do
  end function positions

  !> What a task has made of S and the nodes of the facet, for all nodes of the element.
  pure subroutine spread_element(task, e)
    integer, intent(in) :: task !! the task
    type(element_t), intent(inout) :: e !! r and s are spread

    if (e%slaves == 1) return
    select case (task)
    case (task_tangent, task_stick_tangent, task_residual)
      call spread_point(task /= task_residual, 3 + 3*(e%nel - e%slaves), e)
    case (task_shift_tangent, task_stick_shift_tangent)
      call spread_rows(6, 3 + 3*(e%nel - e%slaves), e)
    case default
      ! There is nothing to spread.
    end select
  end subroutine spread_element

  !> From the point S to its nodes: r_b = M_b r_S, and likewise rows and columns of s
  !! (doc/theory, "Weighted slave points").
  pure subroutine spread_point(with_matrix, m, e)
    logical, intent(in) :: with_matrix !! s is spread, too
    integer, intent(in) :: m !! degrees of freedom of S and the facet
    type(element_t), intent(inout) :: e !! their r and s become those of all nodes
    real(wp) :: r(m), s(m, m), rows(3*e%nel, m)
    integer :: b, j, n, last

    n = 3*e%slaves
    last = n + m - 3
    r = e%r(1:m)
    do b = 1, e%slaves
      e%r(3*b - 2:3*b) = e%weight(b)*r(1:3)
    end do
    e%r(n + 1:last) = r(4:m)
    if (.not. with_matrix) return
    s = e%s(1:m, 1:m)
    do j = 1, m
      do b = 1, e%slaves
        rows(3*b - 2:3*b, j) = e%weight(b)*s(1:3, j)
      end do
      rows(n + 1:last, j) = s(4:m, j)
    end do
    do b = 1, e%slaves
      e%s(1:last, 3*b - 2:3*b) = e%weight(b)*rows(1:last, 1:3)
    end do
    e%s(1:last, n + 1:last) = rows(1:last, 4:m)
  end subroutine spread_point

  !> Rows of s that belong to the displacements of S and the facet: to those of all nodes.
  pure subroutine spread_rows(n_rows, m, e)
    integer, intent(in) :: n_rows !! the first rows of s, up to this one
    integer, intent(in) :: m !! degrees of freedom of S and the facet
    type(element_t), intent(inout) :: e !! s is spread
    real(wp) :: rows(n_rows, m)
    integer :: b, n

    n = 3*e%slaves
    rows = e%s(1:n_rows, 1:m)
    do b = 1, e%slaves
      e%s(1:n_rows, 3*b - 2:3*b) = e%weight(b)*rows(:, 1:3)
    end do
    e%s(1:n_rows, n + 1:n + m - 3) = rows(:, 4:m)
  end subroutine spread_rows
end module slave_points

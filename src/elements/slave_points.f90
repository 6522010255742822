!> The slave point of a contact element: one node, or the weighted sum of a few, that may stand over
!! the facet of the first three (doc/theory, "Slave points and weights", "Surface smoothing", eqs.
!! (6.1), (6.9)).
module slave_points
  use kinds, only: wp
  use element_types, only: element_t, task_tangent, task_stick_tangent, task_residual, &
    task_shift_tangent, task_stick_shift_tangent
  use smooth_patch, only: patch_frame, dual_frame, frame_change, normal_curvature
  implicit none
  private
  public :: positions, spread_element, lift_forces

contains

  !> Positions of S and of the nodes of the facet seen from its corner 3, so that the distance to
  !! the origin costs no digits.
  pure function positions(e, masters) result(x)
    type(element_t), intent(in) :: e !! local data
    integer, intent(in) :: masters !! nodes of the facet
    real(wp) :: x(3, 1 + masters), frame(3, 3)
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
      if (is_lifted(e)) then
        frame = slave_frame(e)
        x(:, 1) = x(:, 1) + e%lift*frame(:, 3)
      end if
    end if
    do k = 1, masters
      associate (node => e%slaves + k)
        x(:, k + 1) = (e%xl(:, node) - e%xl(:, last)) + (e%ul(:, node) - e%ul(:, last))
      end associate
    end do
  end function positions

  !> The slave point stands over its facet.
  pure logical function is_lifted(e)
    type(element_t), intent(in) :: e !! local data

    is_lifted = abs(e%lift) > 0.0_wp
  end function is_lifted

  !> a1, a2 and the unit normal of the slave facet at the current positions.
  pure function slave_frame(e) result(frame)
    type(element_t), intent(in) :: e !! local data
    real(wp) :: frame(3, 3)

    frame = patch_frame((e%xl(:, 1:3) - spread(e%xl(:, 3), 2, 3)) &
      + (e%ul(:, 1:3) - spread(e%ul(:, 3), 2, 3)))
  end function slave_frame

  !> Forces at the corners of a slave facet that do the work of a force on a point's height over it:
  !! a couple.
  pure function lift_forces(frame, lift, force) result(r)
    real(wp), intent(in) :: frame(3, 3) !! a1, a2, e of the facet
    real(wp), intent(in) :: lift !! the height [length]
    real(wp), intent(in) :: force(3) !! on the point
    real(wp) :: r(9)

    r = matmul(force, frame_change(frame, dual_frame(frame), [0.0_wp, 0.0_wp, lift]))
  end function lift_forces

  !> What the displacements of the slave nodes do to S: M_b I, and the turn of what it stands on.
  pure function point_operator(e) result(a)
    type(element_t), intent(in) :: e !! local data
    real(wp) :: a(3, 3*e%slaves)
    real(wp) :: frame(3, 3)
    integer :: b, k

    frame = slave_frame(e)
    a = 0.0_wp
    a(:, 1:9) = frame_change(frame, dual_frame(frame), [0.0_wp, 0.0_wp, e%lift])
    do b = 1, e%slaves
      do k = 1, 3
        a(k, 3*b - 3 + k) = a(k, 3*b - 3 + k) + e%weight(b)
      end do
    end do
  end function point_operator

  !> What a task has made of S and the nodes of the facet, for all nodes of the element.
  pure subroutine spread_element(task, e)
    integer, intent(in) :: task !! the task
    type(element_t), intent(inout) :: e !! r and s are spread

    if (e%slaves == 1) return
    select case (task)
    case (task_tangent, task_stick_tangent, task_residual)
      if (is_lifted(e)) then
        call spread_lifted(task /= task_residual, 3 + 3*(e%nel - e%slaves), e)
      else
        call spread_point(task /= task_residual, 3 + 3*(e%nel - e%slaves), e)
      end if
    case (task_shift_tangent, task_stick_shift_tangent)
      call spread_rows(6, 3 + 3*(e%nel - e%slaves), e)
    case default
      ! There is nothing to spread.
    end select
  end subroutine spread_element

  !> From the point S to its nodes: r_b = M_b r_S, and likewise rows and columns of s
  !! (doc/theory, "Slave points and weights").
  pure subroutine spread_point(with_matrix, m, e)
    logical, intent(in) :: with_matrix !! s is spread, too
    integer, intent(in) :: m !! degrees of freedom of S and the facet
    type(element_t), intent(inout) :: e !! their r and s become those of all nodes
    integer :: b, j, k, n

    n = 3*e%slaves - 3
    call spread_column(e%slaves, e%weight, m, e%r)
    if (.not. with_matrix) return
    ! from the last column on: none is written before it has been read
    do j = m, 1, -1
      call spread_column(e%slaves, e%weight, m, e%s(:, j))
      if (j > 3) e%s(1:n + m, n + j) = e%s(1:n + m, j)
    end do
    do b = e%slaves, 1, -1
      do k = 1, 3
        e%s(1:n + m, 3*b - 3 + k) = e%weight(b)*e%s(1:n + m, k)
      end do
    end do
  end subroutine spread_point

  !> From S to its nodes within a vector, from the last entry on.
  pure subroutine spread_column(slaves, weight, m, v)
    integer, intent(in) :: slaves !! nodes of S
    real(wp), intent(in) :: weight(:) !! (slaves) what each weighs
    integer, intent(in) :: m !! degrees of freedom of S and the facet
    real(wp), intent(inout) :: v(:) !! in: of S and the facet; out: of all nodes
    real(wp) :: point(3)
    integer :: b, i

    point = v(1:3)
    do i = m, 4, -1
      v(3*slaves - 3 + i) = v(i)
    end do
    do b = 1, slaves
      do i = 1, 3
        v(3*b - 3 + i) = weight(b)*point(i)
      end do
    end do
  end subroutine spread_column

  !> The same for a point that stands over its facet: r_S goes through what the nodes do to it, and
  !! its couple turns with the facet.
  pure subroutine spread_lifted(with_matrix, m, e)
    logical, intent(in) :: with_matrix !! s is spread, too
    integer, intent(in) :: m !! degrees of freedom of S and the facet
    type(element_t), intent(inout) :: e !! their r and s become those of all nodes
    real(wp) :: r(m), s(m, m), rows(3*e%nel, m), a(3, 3*e%slaves), frame(3, 3)
    integer :: n, last

    n = 3*e%slaves
    last = n + m - 3
    a = point_operator(e)
    r = e%r(1:m)
    e%r(1:n) = matmul(r(1:3), a)
    e%r(n + 1:last) = r(4:m)
    if (.not. with_matrix) return
    s = e%s(1:m, 1:m)
    rows(1:n, :) = matmul(transpose(a), s(1:3, :))
    rows(n + 1:last, :) = s(4:m, :)
    e%s(1:last, 1:n) = matmul(rows(1:last, 1:3), a)
    e%s(1:last, n + 1:last) = rows(1:last, 4:m)
    frame = slave_frame(e)
    e%s(1:9, 1:9) = e%s(1:9, 1:9) + e%lift*normal_curvature(frame, dual_frame(frame), r(1:3))
  end subroutine spread_lifted

  !> Rows of s that belong to the displacements of S and the facet: to those of all nodes.
  pure subroutine spread_rows(n_rows, m, e)
    integer, intent(in) :: n_rows !! the first rows of s, up to this one
    integer, intent(in) :: m !! degrees of freedom of S and the facet
    type(element_t), intent(inout) :: e !! s is spread
    real(wp) :: rows(n_rows, m)
    integer :: b, n

    n = 3*e%slaves
    rows = e%s(1:n_rows, 1:m)
    if (is_lifted(e)) then
      e%s(1:n_rows, 1:n) = matmul(rows(:, 1:3), point_operator(e))
    else
      do b = 1, e%slaves
        e%s(1:n_rows, 3*b - 2:3*b) = e%weight(b)*rows(:, 1:3)
      end do
    end if
    e%s(1:n_rows, n + 1:n + m - 3) = rows(:, 4:m)
  end subroutine spread_rows
end module slave_points

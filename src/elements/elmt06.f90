!> Element 6: the moving friction elliptical cone of element 3 on a facet of six nodes, the true
!! quadratic surface with its normal at the projection (doc/theory, "Six-node facets", eq. (6.14)).
!!
!! Nodes: those of the slave point, then the six of the facet, corners first. History, shift and
!! task_stress are as those of element 3, its parameters d as well. Where the projection has no
!! answer the flat facet of the corners stands in. Round facets are facets of six nodes with other
!! shape functions (doc/theory, "Exact tools").
module elmt06
  use kinds, only: wp
  use vectors, only: cross, dyad
  use element_types, only: element_t, make_room, task_tangent, task_stick_tangent, task_residual, &
    task_stress, task_shift_tangent, task_stick_shift_tangent, status_open
  use slave_points, only: spread_element
  use contact_cone, only: report_point
  use element_parameters, only: d03_epsilon, axis_convected, axis_circumferential, axis_radial
  use quadratic_facet, only: facet_shapes_t, facet_shapes, facet_flat
  use patch_cone, only: shift_derivative, hold_apex, ways_of_apex, frame_of, mapped_ways
  use facet_cone, only: facet_cone_t, place_on_facet, place_axes, along_facet
  implicit none
  private
  public :: elmt06_quadratic

  !> Degrees of freedom of S and the six nodes.
  integer, parameter :: n_dofs = 21
contains

  !> Does one task for one element.
  pure subroutine elmt06_quadratic(task, shape, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    integer, intent(in) :: shape !! facet_bent or facet_round
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(inout) :: e !! local data
    type(facet_cone_t) :: c
    logical :: found, stays

    call make_room(task, e)
    c%shape = shape
    call place_on_facet(d, e, c, found)
    if (.not. found) then
      c%shape = facet_flat
      call place_on_facet(d, e, c, found)
    end if
    call hold_apex(task, c, e, stays)
    select case (task)
    case (task_tangent, task_stick_tangent)
      call residual(d(d03_epsilon), c, e)
      call tangent(d(d03_epsilon), c, stays, e)
    case (task_residual)
      call residual(d(d03_epsilon), c, e)
    case (task_stress)
      call place_axes(d, c)
      call report_point(d, c%contact_cone_t, c%n, e)
    case (task_shift_tangent, task_stick_shift_tangent)
      call shift_tangent(d(d03_epsilon), c, stays, e)
    case default
      ! The other tasks need no more than the cone.
    end select
    call spread_element(task, e)
  end subroutine elmt06_quadratic

  !> r = eps B^T g', with B at the new apex.
  pure subroutine residual(epsilon, c, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(facet_cone_t), intent(in) :: c !! cone at its new apex
    type(element_t), intent(inout) :: e !! gets r
    type(facet_shapes_t) :: s
    integer :: a

    s = facet_shapes(c%apex, c%shape, c%x)
    e%r(1:3) = epsilon*c%g_new
    do a = 1, 6
      e%r(3*a + 1:3*a + 3) = -s%n(a)*epsilon*c%g_new
    end do
  end subroutine residual

  !> Consistent tangent; zero for an open point.
  pure subroutine tangent(epsilon, c, stays, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(facet_cone_t), intent(in) :: c !! cone at its new apex
    logical, intent(in) :: stays !! the apex stays where it is
    type(element_t), intent(inout) :: e !! gets s
    type(facet_shapes_t) :: s
    real(wp) :: b(3, n_dofs), dg(3, n_dofs), dtip(2, n_dofs)
    integer :: j

    e%s(1:n_dofs, 1:n_dofs) = 0.0_wp
    if (e%status == status_open) return
    s = facet_shapes(c%apex, c%shape, c%x)
    b = nodal(1.0_wp, -s%n)
    dg = b
    if (c%shifted) dg = b + shift_way(c)
    if (.not. stays) then
      call apex_derivative(c, e%h1, dg, dtip)
      dg = dg - matmul(matmul(c%x, s%d), dtip)
    end if
    e%s(1:n_dofs, 1:n_dofs) = epsilon*matmul(transpose(b), dg)
    if (stays) return
    do j = 1, 2
      e%s(1:n_dofs, 1:n_dofs) = e%s(1:n_dofs, 1:n_dofs) + epsilon*dyad(matmul(c%g_new, &
        nodal(0.0_wp, -s%d(:, j))), dtip(j, :))
    end do
  end subroutine tangent

  !> The matrix (s I, n_1 I, .., n_6 I) of S and the six nodes.
  pure function nodal(s, n) result(b)
    real(wp), intent(in) :: s !! factor of S
    real(wp), intent(in) :: n(6) !! factors of the nodes
    real(wp) :: b(3, n_dofs)
    integer :: a, k

    b = 0.0_wp
    do k = 1, 3
      b(k, k) = s
      do a = 1, 6
        b(k, 3*a + k) = n(a)
      end do
    end do
  end function nodal

  !> Derivative of shift and offset: the one turns with the corners of the facet, the other with
  !! the normal.
  pure function shift_way(c) result(dk)
    type(facet_cone_t), intent(in) :: c !! facet, shift and offset
    real(wp) :: dk(3, n_dofs)
    real(wp) :: dn(3, n_dofs), dgn(n_dofs), dxi(2, n_dofs)

    dk = 0.0_wp
    dk(:, 1:12) = shift_derivative(c%cone_t)
    if (abs(c%offset) <= 0.0_wp) return
    call projection_derivative(c, dn, dgn, dxi)
    dk = dk + c%offset*dn
  end function shift_way

  !> Derivative of the new apex by the displacements, in slip.
  pure subroutine apex_derivative(c, apex_old, dg, dtip)
    type(facet_cone_t), intent(in) :: c !! cone at its new apex
    real(wp), intent(in) :: apex_old(2) !! (xi, eta) of the old apex
    real(wp), intent(in) :: dg(3, n_dofs) !! derivative of the gap to an apex that stays
    real(wp), intent(out) :: dtip(2, n_dofs) !! the derivative
    type(facet_shapes_t) :: old
    real(wp) :: dn(3, n_dofs), dgn(n_dofs), dk(3, n_dofs), dxi(2, n_dofs)

    call projection_derivative(c, dn, dgn, dxi)
    dk = 0.0_wp
    if (c%shifted) dk = shift_way(c)
    old = facet_shapes(apex_old, c%shape, c%x)
    dtip = along_facet(c, ways_of_apex(c, dn, dgn, axis_turn(c, dn, dxi), &
      nodal(1.0_wp, -old%n), dk, dg))
  end subroutine apex_derivative

  !> Derivatives of the unit normal at the projection, of the normal gap, and of the projection.
  pure subroutine projection_derivative(c, dn, dgn, dxi)
    type(facet_cone_t), intent(in) :: c !! the cone
    real(wp), intent(out) :: dn(3, n_dofs) !! of the unit normal
    real(wp), intent(out) :: dgn(n_dofs) !! of the normal gap
    real(wp), intent(out) :: dxi(2, n_dofs) !! of (xi, eta)
    type(facet_shapes_t) :: s
    real(wp) :: b(3, n_dofs), right(2, n_dofs), dual(3, 2), metric(2, 2)
    integer :: i

    s = facet_shapes(c%xi, c%shape, c%x)
    b = nodal(1.0_wp, -s%n)
    right = matmul(transpose(c%at%t), b)
    do i = 1, 2
      right(i, :) = right(i, :) + c%at%gap*matmul(c%n, nodal(0.0_wp, s%d(:, i)))
    end do
    dxi = matmul(c%at%inverse, right)
    dgn = matmul(c%n, b)
    metric = matmul(transpose(c%at%t), c%at%t)
    dual = matmul(c%at%t, reshape([metric(2, 2), -metric(2, 1), -metric(1, 2), metric(1, 1)], &
      [2, 2]))/(metric(1, 1)*metric(2, 2) - metric(1, 2)*metric(2, 1))
    dn = 0.0_wp
    do i = 1, 2
      dn = dn - dyad(dual(:, i), matmul(c%n, tangent_way(c, i, dxi)))
    end do
  end subroutine projection_derivative

  !> Derivative of a tangent at the projection.
  pure function tangent_way(c, i, dxi) result(dt)
    type(facet_cone_t), intent(in) :: c !! the cone
    integer, intent(in) :: i !! 1 or 2
    real(wp), intent(in) :: dxi(2, n_dofs) !! derivative of the projection
    real(wp) :: dt(3, n_dofs)
    type(facet_shapes_t) :: s

    s = facet_shapes(c%xi, c%shape, c%x)
    ! second derivatives stand as 11, 22, 12
    dt = nodal(0.0_wp, s%d(:, i)) + dyad(c%at%bent(:, merge(1, 3, i == 1)), dxi(1, :)) &
      + dyad(c%at%bent(:, merge(3, 2, i == 1)), dxi(2, :))
  end function tangent_way

  !> Turn of the friction axes in the tangent plane: (q . dv - (n . v) q . dn)/|Pv|.
  pure function axis_turn(c, dn, dxi) result(w)
    type(facet_cone_t), intent(in) :: c !! the cone
    real(wp), intent(in) :: dn(3, n_dofs) !! derivative of the unit normal
    real(wp), intent(in) :: dxi(2, n_dofs) !! derivative of the projection
    real(wp) :: w(n_dofs)

    w = -dot_product(c%n, c%v)*matmul(c%q, dn)
    select case (c%kind)
    case (axis_convected)
      w = w + matmul(matmul(matmul(c%q, c%at%t), c%slope), dxi) + matmul(c%q, c%share(1) &
        *tangent_way(c, 1, dxi) + c%share(2)*tangent_way(c, 2, dxi))
    case (axis_circumferential)
      w(1:3) = w(1:3) + cross(c%q, c%axis)
    case (axis_radial)
      w(1:3) = w(1:3) + c%q - dot_product(c%q, c%axis)*c%axis
    case default
      ! A vector that is fixed in space does not turn when nodes move.
    end select
    w = w/c%size_p
  end function axis_turn

  !> The force in the frame of the facet, its derivatives by displacements and shift, and that of
  !! the nodal forces by the shift (doc/theory, "Simultaneous multiplier update").
  pure subroutine shift_tangent(epsilon, c, stays, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(facet_cone_t), intent(in) :: c !! cone at its new apex
    logical, intent(in) :: stays !! the apex stays where it is
    type(element_t), intent(inout) :: e !! gets s, stress
    type(facet_cone_t) :: carried
    type(facet_shapes_t) :: s
    real(wp) :: frame(3, 3), b(3, n_dofs), dg(3, n_dofs), dtip(2, n_dofs), mapped(3, 3)
    real(wp) :: turn(2, 3)
    integer :: j

    e%s(1:9, 1:n_dofs) = 0.0_wp
    e%stress(1:3) = 0.0_wp
    if (e%status == status_open) return
    frame = frame_of(c)
    mapped = frame
    turn = 0.0_wp
    s = facet_shapes(c%apex, c%shape, c%x)
    b = nodal(1.0_wp, -s%n)
    dg = b
    if (c%shifted) dg = b + shift_way(c)
    if (.not. stays) then
      call apex_derivative(c, e%h1, dg, dtip)
      dg = dg - matmul(matmul(c%x, s%d), dtip)
      turn = along_facet(c, mapped_ways(c, frame))
      mapped = frame - matmul(matmul(c%x, s%d), turn)
    end if
    carried = c
    carried%kappa = matmul(c%g_new, frame)
    carried%offset = 0.0_wp
    carried%t = frame(:, 1:2)
    carried%k = matmul(carried%t, carried%kappa(1:2))
    e%stress(1:3) = epsilon*carried%kappa
    e%s(1:3, 1:n_dofs) = epsilon*matmul(transpose(frame), dg - shift_way(carried))
    e%s(7:9, 1:3) = epsilon*matmul(transpose(frame), mapped)
    e%s(4:6, 1:n_dofs) = matmul(transpose(mapped), b)
    do j = 1, 2
      e%s(4:6, 1:n_dofs) = e%s(4:6, 1:n_dofs) + dyad(turn(j, :), matmul(c%g_new, nodal(0.0_wp, &
        -s%d(:, j))))
    end do
    e%s(4:6, 1:n_dofs) = epsilon*e%s(4:6, 1:n_dofs)
  end subroutine shift_tangent
end module elmt06

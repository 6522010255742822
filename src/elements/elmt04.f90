!> Element 4: the moving friction elliptical cone of element 3 on a curved patch with continuous
!! normals (doc/theory, "Surface smoothing", eqs. (6.11), (6.12)).
!!
!! Nodes, history, shift and task_stress are as those of element 3; its parameters come first in d,
!! then the patch. The gap vector g = x_S - x_m(apex) begins on the patch, and x_m carries the
!! forces to the facet's nodes, so that force and moment balance exactly.
module elmt04
  use kinds, only: wp
  use vectors, only: cross, dyad
  use element_types, only: element_t, make_room, task_tangent, task_stick_tangent, task_residual, &
    task_stress, task_shift_tangent, task_stick_shift_tangent, status_open
  use slave_points, only: spread_element
  use contact_cone, only: report_point
  use element_parameters, only: d03_epsilon, d04_patch, n_parameters, axis_convected, &
    axis_circumferential, axis_radial
  use smooth_patch, only: patch_point_t, patch_at, patch_from_values, flat_patch, &
    normal_curvature
  use patch_cone, only: cone_t, place_cone, principal_axes, frame_operator, shift_derivative, &
    hold_apex, solve_ways, ways_of_apex, frame_of, mapped_ways
  implicit none
  private
  public :: elmt04_smooth

contains

  !> Does one task for one element.
  pure subroutine elmt04_smooth(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(inout) :: e !! local data
    type(cone_t) :: c
    logical :: found, stays

    c%patch = patch_from_values(d(d04_patch:n_parameters))
    call make_room(task, e)
    call place_cone(d, e, c, found)
    if (.not. found) then
      c%patch = flat_patch()
      call place_cone(d, e, c, found)
    end if
    call hold_apex(task, c, e, stays)
    select case (task)
    case (task_tangent, task_stick_tangent)
      call residual(d(d03_epsilon), c, e)
      call tangent(d(d03_epsilon), c, .not. stays, e)
    case (task_residual)
      call residual(d(d03_epsilon), c, e)
    case (task_stress)
      call principal_axes(d, c)
      call report_point(d, c%contact_cone_t, c%n, e)
    case (task_shift_tangent, task_stick_shift_tangent)
      call shift_tangent(d(d03_epsilon), c, .not. stays, e)
    case default
      ! The other tasks need no more than the cone.
    end select
    call spread_element(task, e)
  end subroutine elmt04_smooth

  !> r = eps B^T g', with B at the new apex.
  pure subroutine residual(epsilon, c, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! cone at its new apex
    type(element_t), intent(inout) :: e !! gets r
    type(patch_point_t) :: point

    point = patch_at(c%patch, c%apex)
    e%r(4:12) = -facet_force(c, point%x, epsilon*c%g_new)
    e%r(1:3) = epsilon*c%g_new
    e%r(10:12) = e%r(10:12) - epsilon*c%g_new
  end subroutine residual

  !> Forces at corners 1, 2, 3 that do the work of the force f on w1 a1 + w2 a2 + w3 e, seen from
  !! corner 3.
  pure function facet_force(c, w, f) result(r)
    type(cone_t), intent(in) :: c !! facet
    real(wp), intent(in) :: w(3) !! components
    real(wp), intent(in) :: f(3) !! the force
    real(wp) :: r(9)

    r(1:3) = w(1)*f - w(3)*dot_product(f, c%dual(:, 1))*c%f(:, 3)
    r(4:6) = w(2)*f - w(3)*dot_product(f, c%dual(:, 2))*c%f(:, 3)
    r(7:9) = -r(1:3) - r(4:6)
  end function facet_force

  !> Consistent tangent; zero for an open point.
  pure subroutine tangent(epsilon, c, slides, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! cone at its new apex
    logical, intent(in) :: slides !! the apex moves
    type(element_t), intent(inout) :: e !! gets s
    type(patch_point_t) :: point
    real(wp) :: b(3, 12), dg(3, 12), dtip(2, 12), k(12, 12)
    integer :: j

    e%s(1:12, 1:12) = 0.0_wp
    if (e%status == status_open) return
    point = patch_at(c%patch, c%apex)
    b = gap_operator(c, point%x)
    dg = b
    if (c%shifted) dg = b + shift_way(c)
    k = 0.0_wp
    k(4:12, 4:12) = -point%x(3)*normal_curvature(c%f, c%dual, c%g_new)
    if (slides) then
      call apex_derivative(c, e%h1, dg, point, dtip)
      dg = dg - matmul(matmul(c%f, point%dx), dtip)
      do j = 1, 2
        k(4:12, :) = k(4:12, :) - dyad(facet_force(c, point%dx(:, j), c%g_new), dtip(j, :))
      end do
    end if
    e%s(1:12, 1:12) = epsilon*(matmul(transpose(b), dg) + k)
  end subroutine tangent

  !> Derivative of shift and offset: the one turns with the facet, the other with the normal.
  pure function shift_way(c) result(dk)
    type(cone_t), intent(in) :: c !! facet, shift and offset
    real(wp) :: dk(3, 12)
    real(wp) :: dn(3, 12), dgn(12), dxi(2, 12)

    dk = shift_derivative(c)
    if (abs(c%offset) <= 0.0_wp) return
    call projection_derivative(c, dn, dgn, dxi)
    dk = dk + c%offset*dn
  end function shift_way

  !> Derivative of the new apex by the displacements, in slip.
  pure subroutine apex_derivative(c, apex_old, dg, point, dtip)
    type(cone_t), intent(in) :: c !! cone at its new apex
    real(wp), intent(in) :: apex_old(2) !! (xi, eta) of the old apex
    real(wp), intent(in) :: dg(3, 12) !! derivative of the gap to an apex that stays
    type(patch_point_t), intent(in) :: point !! the patch at the new apex
    real(wp), intent(out) :: dtip(2, 12) !! the derivative
    type(patch_point_t) :: old
    real(wp) :: dn(3, 12), dgn(12), dk(3, 12), dxi(2, 12)

    call projection_derivative(c, dn, dgn, dxi)
    dk = 0.0_wp
    if (c%shifted) dk = shift_derivative(c) + c%offset*dn
    old = patch_at(c%patch, apex_old)
    dtip = along_patch(c, point, ways_of_apex(c, dn, dgn, axis_turn(c, dn, dxi), &
      gap_operator(c, old%x), dk, dg))
  end subroutine apex_derivative

  !> Ways of the apex in (xi, eta) whose components along the axes of friction are given.
  pure function along_patch(c, point, way) result(dtip)
    type(cone_t), intent(in) :: c !! cone at its new apex
    type(patch_point_t), intent(in) :: point !! the patch there
    real(wp), intent(in) :: way(:, :) !! (2, any) along p1 and p2
    real(wp) :: dtip(2, size(way, 2))

    dtip = solve_ways(matmul(transpose(c%p), matmul(c%f, point%dx)), way)
  end function along_patch

  !> The force in the frame of the facet, its derivatives by displacements and shift, and that of
  !! the nodal forces by the shift (doc/theory, "Simultaneous multiplier update").
  pure subroutine shift_tangent(epsilon, c, slides, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! cone at its new apex
    logical, intent(in) :: slides !! the apex moves
    type(element_t), intent(inout) :: e !! gets s, stress
    type(cone_t) :: carried
    type(patch_point_t) :: point
    real(wp) :: frame(3, 3), b(3, 12), dg(3, 12), dtip(2, 12), mapped(3, 3), turn(2, 3)
    integer :: j

    e%s(1:9, 1:12) = 0.0_wp
    e%stress(1:3) = 0.0_wp
    if (e%status == status_open) return
    frame = frame_of(c)
    mapped = frame
    turn = 0.0_wp
    point = patch_at(c%patch, c%apex)
    b = gap_operator(c, point%x)
    dg = b
    if (c%shifted) dg = b + shift_way(c)
    if (slides) then
      call apex_derivative(c, e%h1, dg, point, dtip)
      dg = dg - matmul(matmul(c%f, point%dx), dtip)
      turn = along_patch(c, point, mapped_ways(c, frame))
      mapped = frame - matmul(matmul(c%f, point%dx), turn)
    end if
    carried = c
    carried%kappa = matmul(c%g_new, frame)
    carried%t = frame(:, 1:2)
    carried%k = matmul(carried%t, carried%kappa(1:2))
    e%stress(1:3) = epsilon*carried%kappa
    e%s(1:3, 1:12) = epsilon*matmul(transpose(frame), dg - shift_derivative(carried))
    e%s(7:9, 1:3) = epsilon*matmul(transpose(frame), mapped)
    e%s(4:6, 1:12) = matmul(transpose(mapped), b)
    do j = 1, 2
      e%s(4:6, 4:12) = e%s(4:6, 4:12) - dyad(turn(j, :), facet_force(c, point%dx(:, j), c%g_new))
    end do
    e%s(4:6, 1:12) = epsilon*e%s(4:6, 1:12)
  end subroutine shift_tangent

  !> Derivatives of the unit normal at the projection, of the normal gap, and of the projection.
  pure subroutine projection_derivative(c, dn, dgn, dxi)
    type(cone_t), intent(in) :: c !! the cone
    real(wp), intent(out) :: dn(3, 12) !! of the unit normal
    real(wp), intent(out) :: dgn(12) !! of the normal gap
    real(wp), intent(out) :: dxi(2, 12) !! of (xi, eta)
    real(wp) :: t(3, 2), b(3, 12), right(3, 12), det, d1(3), d2(3)

    b = gap_operator(c, c%below%x)
    dn = frame_operator(c, c%below%n)
    t = c%below%dx + c%gamma*c%below%dn
    det = dot_product(t(:, 1), cross(t(:, 2), c%below%n))
    d1 = matmul(c%dual, cross(t(:, 2), c%below%n))/det
    d2 = matmul(c%dual, cross(c%below%n, t(:, 1)))/det
    right = b - c%gamma*dn
    dxi(1, :) = matmul(d1, right)
    dxi(2, :) = matmul(d2, right)
    dgn = matmul(c%n, b - matmul(matmul(c%f, c%below%dx), dxi))
    dn = (dn + matmul(matmul(c%f, c%below%dn), dxi))/c%size_n
    dn = dn - dyad(c%n, matmul(c%n, dn))
  end subroutine projection_derivative

  !> Turn of the friction axes in the tangent plane: (q . dv - (n . v) q . dn)/|Pv|.
  pure function axis_turn(c, dn, dxi) result(w)
    type(cone_t), intent(in) :: c !! the cone
    real(wp), intent(in) :: dn(3, 12) !! derivative of the unit normal
    real(wp), intent(in) :: dxi(2, 12) !! derivative of the projection
    real(wp) :: w(12)

    w = -dot_product(c%n, c%v)*matmul(c%q, dn)
    select case (c%kind)
    case (axis_convected)
      w = w + matmul(c%q, frame_operator(c, [c%share(1), c%share(2), 0.0_wp])) &
        + matmul(matmul(matmul(c%q, c%f(:, 1:2)), c%slope), dxi)
    case (axis_circumferential)
      w(1:3) = w(1:3) + cross(c%q, c%axis)
    case (axis_radial)
      w(1:3) = w(1:3) + c%q - dot_product(c%q, c%axis)*c%axis
    case default
      ! A vector that is fixed in space does not turn when nodes move.
    end select
    w = w/c%size_p
  end function axis_turn

  !> Derivative of the gap to a point of the facet's frame with fixed components.
  pure function gap_operator(c, w) result(b)
    type(cone_t), intent(in) :: c !! facet
    real(wp), intent(in) :: w(3) !! components
    real(wp) :: b(3, 12)
    integer :: k

    b = -frame_operator(c, w)
    do k = 1, 3
      b(k, k) = 1.0_wp
      b(k, 9 + k) = b(k, 9 + k) - 1.0_wp
    end do
  end function gap_operator
end module elmt04

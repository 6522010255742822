!> Element 3: the moving friction elliptical cone (MFEC), one slave point S against a facet.
!!
!! Nodes: those of S (one, or the three of a slave facet with weights), then the facet's 1, 2, 3
!! (counter-clockwise seen from outside). One gap vector, one penalty (doc/theory, "Facet and gap",
!! eqs. (3.1), (3.2), (3.3), (3.4), (3.8)): g = x_S - x_m(apex), f = eps g, r_S = f, r_a =
!! -N_a(apex) f, with shape functions at the apex, so that force and moment balance exactly.
!! History h1, h2: (xi, eta) of the apex at the last converged and at the current state.
!!
!! e%shift is kappa = lambda/eps of a multiplier (doc/theory, "Augmented Lagrangian", eqs. (7.2),
!! (7.3), (7.4)): g + kappa takes the place of g in the law, with components along t1 = a1/|a1|, t2
!! = e x t1 and e.
!!
!! task_stress gives stress = [f (3), g_N, elastic slip, criterion, p1 (3), e (3), |f_N|, |f_T|].
module elmt03
  use kinds, only: wp
  use vectors, only: cross, dyad, length
  use element_types, only: element_t, make_room, task_tangent, task_stick_tangent, task_residual, &
    task_stress, task_shift_tangent, task_stick_shift_tangent, status_open, status_stick, &
    status_slip
  use slave_points, only: positions, spread_element
  use friction_axes, only: axes_t, find_axes, turn_of_axes
  use element_parameters, only: d03_epsilon
  use contact_cone, only: gap_operator, contact_cone_t, leave_open, map_friction, report_point
  implicit none
  private
  public :: elmt03_mfec

  !> The facet and the gap at the current positions.
  type, extends(contact_cone_t) :: cone_t
    real(wp) :: a1(3) !! x1 - x3
    real(wp) :: a2(3) !! x2 - x3
    real(wp) :: e(3) !! outward unit normal
    real(wp) :: d1(3) !! dual vector a^1
    real(wp) :: d2(3) !! dual vector a^2
    type(axes_t) :: axes !! principal axes of friction, and how they turn
  end type cone_t

contains

  !> Does one task for one element.
  pure subroutine elmt03_mfec(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(inout) :: e !! local data
    type(cone_t) :: c
    real(wp) :: x(3, 4)

    call make_room(task, e)
    x = positions(e, 3)
    call facet_and_gap(x, e%h1, c)
    c%slave = x(:, 1) + (e%xl(:, e%slaves + 3) + e%ul(:, e%slaves + 3))
    call add_shift(e%shift + [0.0_wp, 0.0_wp, e%offset], c)
    if (c%h_n <= 0.0_wp) then
      call principal_axes(d, c)
      call move_cone(d, c, e)
    else
      call leave_open(c%contact_cone_t, e)
    end if
    select case (task)
    case (task_tangent)
      call residual(d(d03_epsilon), c, e)
      call tangent(d, c, e)
    case (task_stick_tangent)
      c%g_new = c%g
      c%apex = e%h1
      call residual(d(d03_epsilon), c, e)
      call stick_tangent(d(d03_epsilon), c, e)
    case (task_residual)
      call residual(d(d03_epsilon), c, e)
    case (task_stress)
      call principal_axes(d, c)
      call report_point(d, c%contact_cone_t, c%e, e)
    case (task_shift_tangent)
      call shift_tangent(d(d03_epsilon), c, e%status == status_slip, e)
    case (task_stick_shift_tangent)
      c%g_new = c%g
      c%apex = e%h1
      call shift_tangent(d(d03_epsilon), c, .false., e)
    case default
      ! The other tasks need no more than the cone.
    end select
    call spread_element(task, e)
  end subroutine elmt03_mfec

  !> Facet, normal gap, projection and the gap vector to the old apex.
  pure subroutine facet_and_gap(x, apex, c)
    real(wp), intent(in) :: x(3, 4) !! current positions of S, 1, 2, 3 from 3 [length]
    real(wp), intent(in) :: apex(2) !! (xi, eta) of the old apex
    type(cone_t), intent(out) :: c !! facet and gap
    real(wp) :: n(3), size_n, y(3)

    c%a1 = x(:, 2) - x(:, 4)
    c%a2 = x(:, 3) - x(:, 4)
    n = cross(c%a1, c%a2)
    size_n = length(n)
    c%e = n/size_n
    c%d1 = cross(c%a2, c%e)/size_n
    c%d2 = cross(c%e, c%a1)/size_n
    y = x(:, 1) - x(:, 4)
    c%g_n = dot_product(y, c%e)
    c%xi = [dot_product(c%d1, y), dot_product(c%d2, y)]
    c%g = y - apex(1)*c%a1 - apex(2)*c%a2
  end subroutine facet_and_gap

  !> The gap vector with the shift, which turns with the facet.
  pure subroutine add_shift(kappa, c)
    real(wp), intent(in) :: kappa(3) !! along t1, t2 and e [length]
    type(cone_t), intent(inout) :: c !! facet and gap

    c%kappa = kappa
    c%k = 0.0_wp
    c%h_n = c%g_n + kappa(3)
    c%shifted = any(abs(kappa) > 0.0_wp)
    if (.not. c%shifted) return
    c%t(:, 1) = c%a1/norm2(c%a1)
    c%t(:, 2) = cross(c%e, c%t(:, 1))
    c%k = kappa(1)*c%t(:, 1) + kappa(2)*c%t(:, 2)
    c%g = c%g + c%k + kappa(3)*c%e
  end subroutine add_shift

  !> Principal axes p1, p2 = e x p1 and how they turn with the facet.
  pure subroutine principal_axes(d, c)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(cone_t), intent(inout) :: c !! facet and gap; gets p and axes

    call find_axes(d, c%a1, c%a2, c%e, c%xi, c%slave, c%axes)
    c%p = c%axes%p
  end subroutine principal_axes

  !> Stick or slip: the mapped gap and the new apex.
  pure subroutine move_cone(d, c, e)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(cone_t), intent(inout) :: c !! facet and gap; gets back, g_new, apex
    type(element_t), intent(inout) :: e !! gets status, h2, slip
    real(wp) :: s(2), s_new(3)

    s = [dot_product(c%p(:, 1), c%g), dot_product(c%p(:, 2), c%g)]
    call map_friction(d, s, c%contact_cone_t, e)
    if (c%back%slip) then
      e%status = status_slip
      s_new = c%back%s(1)*c%p(:, 1) + c%back%s(2)*c%p(:, 2)
      c%g_new = c%h_n*c%e + s_new
      s_new = s_new - c%k
      c%apex = c%xi - [dot_product(c%d1, s_new), dot_product(c%d2, s_new)]
    else
      e%status = status_stick
      c%g_new = c%g
      c%apex = e%h1
    end if
    e%h2 = c%apex
    e%slip = c%g_new - c%h_n*c%e
  end subroutine move_cone

  !> r_S = eps g, r_a = -N_a(apex) eps g.
  pure subroutine residual(epsilon, c, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! cone at its new apex
    type(element_t), intent(inout) :: e !! gets r
    real(wp) :: f(3)

    f = epsilon*c%g_new
    e%r(1:3) = f
    e%r(4:6) = -c%apex(1)*f
    e%r(7:9) = -c%apex(2)*f
    e%r(10:12) = -(1.0_wp - c%apex(1) - c%apex(2))*f
  end subroutine residual

  !> Consistent tangent: symmetric in stick, unsymmetric in slip.
  pure subroutine tangent(d, c, e)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(cone_t), intent(in) :: c !! cone at its new apex
    type(element_t), intent(inout) :: e !! gets s
    real(wp) :: b(3, 12), dg(3, 12), g(3, 12), apex(2), ways(3)
    integer :: j

    if (e%status /= status_slip) then
      call stick_tangent(d(d03_epsilon), c, e)
      return
    end if
    b = gap_operator(c%apex)
    g = gap_derivative(c, e%h1)
    dg = g
    if (c%shifted) dg = dg - shift_derivative(c)
    b = b - dg
    ! B^T is I and shares of I, three rows each, and how the apex moves changes the shares
    ways = [-c%apex(1), -c%apex(2), -(1.0_wp - c%apex(1) - c%apex(2))]
    do j = 1, 12
      apex = [dot_product(c%d1, b(:, j)), dot_product(c%d2, b(:, j))]
      e%s(1:3, j) = d(d03_epsilon)*g(:, j)
      e%s(4:6, j) = d(d03_epsilon)*(ways(1)*g(:, j) - c%g_new*apex(1))
      e%s(7:9, j) = d(d03_epsilon)*(ways(2)*g(:, j) - c%g_new*apex(2))
      e%s(10:12, j) = d(d03_epsilon)*(ways(3)*g(:, j) + c%g_new*apex(1) + c%g_new*apex(2))
    end do
  end subroutine tangent

  !> K = eps B^T (B + dkappa/du) at the old apex; zero for an open point.
  pure subroutine stick_tangent(epsilon, c, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! facet and shift
    type(element_t), intent(inout) :: e !! gets s
    real(wp) :: b(3, 12), b_transposed(12, 3)

    if (e%status == status_open) then
      e%s(1:12, 1:12) = 0.0_wp
      return
    end if
    b = gap_operator(e%h1)
    b_transposed = transpose(b)
    if (c%shifted) then
      e%s(1:12, 1:12) = epsilon*matmul(b_transposed, b + shift_derivative(c))
    else
      e%s(1:12, 1:12) = epsilon*matmul(b_transposed, b)
    end if
  end subroutine stick_tangent

  !> The force in the frame of the facet, its derivatives by displacements and shift, and that of
  !! the nodal forces by the shift (doc/theory, "Simultaneous multiplier update", eq. (7.7)).
  pure subroutine shift_tangent(epsilon, c, slides, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! cone at its new apex
    logical, intent(in) :: slides !! the apex moves
    type(element_t), intent(inout) :: e !! gets s, stress
    type(cone_t) :: carried
    real(wp) :: frame(3, 3), dg(3, 12), mapped(3, 3), b(3, 12), rest(3, 3), dtip(2, 3)
    integer :: k

    e%s(1:9, 1:12) = 0.0_wp
    e%stress(1:3) = 0.0_wp
    if (e%status == status_open) return
    frame(:, 1) = c%a1/norm2(c%a1)
    frame(:, 2) = cross(c%e, frame(:, 1))
    frame(:, 3) = c%e
    mapped = frame
    if (slides) then
      dg = gap_derivative(c, e%h1)
      mapped = matmul(mapped_change(c), frame)
    else
      dg = gap_operator(e%h1)
      if (c%shifted) dg = dg + shift_derivative(c)
    end if
    carried = c
    carried%kappa = matmul(c%g_new, frame)
    carried%t = frame(:, 1:2)
    carried%k = matmul(carried%t, carried%kappa(1:2))
    e%stress(1:3) = epsilon*carried%kappa
    e%s(1:3, 1:12) = epsilon*matmul(transpose(frame), dg - shift_derivative(carried))
    e%s(7:9, 1:3) = epsilon*matmul(transpose(frame), mapped)
    b = gap_operator(c%apex)
    e%s(4:6, 1:12) = matmul(transpose(mapped), b)
    rest = frame - mapped
    dtip(1, :) = matmul(c%d1, rest)
    dtip(2, :) = matmul(c%d2, rest)
    do k = 1, 3
      e%s(4:6, 3 + k) = e%s(4:6, 3 + k) - c%g_new(k)*dtip(1, :)
      e%s(4:6, 6 + k) = e%s(4:6, 6 + k) - c%g_new(k)*dtip(2, :)
      e%s(4:6, 9 + k) = e%s(4:6, 9 + k) + c%g_new(k)*(dtip(1, :) + dtip(2, :))
    end do
    e%s(4:6, 1:12) = epsilon*e%s(4:6, 1:12)
  end subroutine shift_tangent

  !> Derivative of the mapped gap by the gap, in slip.
  pure function mapped_change(c) result(change)
    type(cone_t), intent(in) :: c !! cone at its new apex
    real(wp) :: change(3, 3)

    change = dyad(c%e - matmul(c%p, c%back%r), c%e) &
      + matmul(c%p, matmul(c%back%m, transpose(c%p)))
  end function mapped_change

  !> dg/du of the mapped gap in slip: G of doc/theory, "Slip", eqs. (5.1), (5.2), (5.3).
  pure function gap_derivative(c, apex_old) result(dg)
    type(cone_t), intent(in) :: c !! cone at its new apex
    real(wp), intent(in) :: apex_old(2) !! (xi, eta) of the old apex
    real(wp) :: dg(3, 12)
    real(wp) :: b_old(3, 12), dgn(12), de(3, 12), w(12), dp1(3, 12), dp2(3, 12)
    real(wp) :: ds(2, 12), ds_new(2, 12)

    b_old = gap_operator(apex_old)
    if (c%shifted) b_old = b_old + shift_derivative(c)
    dgn = matmul(c%e, gap_operator(c%xi))
    de = normal_derivative(c)
    w = turn_of_axes(c%axes, de)
    if (c%axes%varies) w = w + matmul(c%axes%place_share(1)*c%d1 + c%axes%place_share(2)*c%d2, &
      gap_operator(c%xi) - c%g_n*de)
    dp1 = dyad(c%p(:, 2), w) - dyad(c%e, matmul(c%p(:, 1), de))
    dp2 = -dyad(c%p(:, 1), w) - dyad(c%e, matmul(c%p(:, 2), de))
    ds(1, :) = matmul(c%p(:, 1), b_old) + matmul(c%g, dp1)
    ds(2, :) = matmul(c%p(:, 2), b_old) + matmul(c%g, dp2)
    ds_new = matmul(c%back%m, ds) - dyad(c%back%r, dgn)
    dg = dyad(c%e, dgn) + c%h_n*de + dyad(c%p(:, 1), ds_new(1, :)) &
      + dyad(c%p(:, 2), ds_new(2, :)) + c%back%s(1)*dp1 + c%back%s(2)*dp2
  end function gap_derivative

  !> dkappa/du: t1, t2 and e turn with the facet as a convected axis along a1 does.
  pure function shift_derivative(c) result(dk)
    type(cone_t), intent(in) :: c !! facet and shift
    real(wp) :: dk(3, 12)
    real(wp) :: de(3, 12), w(12)

    de = normal_derivative(c)
    w = 0.0_wp
    w(4:6) = c%t(:, 2)/norm2(c%a1)
    w(10:12) = -w(4:6)
    dk = dyad(c%kappa(1)*c%t(:, 2) - c%kappa(2)*c%t(:, 1), w) - dyad(c%e, matmul(c%k, de)) &
      + c%kappa(3)*de
  end function shift_derivative

  !> de/du = -a^1 (x) [0, e, 0, -e] - a^2 (x) [0, 0, e, -e].
  pure function normal_derivative(c) result(de)
    type(cone_t), intent(in) :: c !! facet
    real(wp) :: de(3, 12)

    de(:, 1:3) = 0.0_wp
    de(:, 4:6) = -dyad(c%d1, c%e)
    de(:, 7:9) = -dyad(c%d2, c%e)
    de(:, 10:12) = -de(:, 4:6) - de(:, 7:9)
  end function normal_derivative
end module elmt03

!> The friction cone on a curved patch: projection, gap, stick or slip, new apex (doc/theory,
!! "Surface smoothing", eq. (6.10)). Element 4 makes forces and tangent of it.
module patch_cone
  use kinds, only: wp
  use vectors, only: cross, dyad
  use element_types, only: element_t, task_stick_tangent, task_stick_shift_tangent, status_open, &
    status_stick, status_slip
  use slave_points, only: positions
  use contact_cone, only: contact_cone_t, leave_open, map_friction
  use friction_axes, only: direction_in_space
  use element_parameters, only: d03_axis_kind, d03_axis, d03_turn, d03_place, axis_convected
  use smooth_patch, only: patch_t, patch_point_t, patch_at, project_in_patch, patch_frame, &
    dual_frame, frame_change
  implicit none
  private
  public :: cone_t, place_cone, place_shift, principal_axes, frame_operator, shift_derivative, &
    map_trial, hold_apex, solve_ways, ways_of_apex, frame_of, mapped_ways

  !> Projected vectors shorter than this share of the vector count as normal to the patch.
  real(wp), parameter :: shortest_projection = 1.0e-8_wp
  !> A step of the new apex below this is its last; and the most steps.
  real(wp), parameter :: last_step = 1.0e-9_wp
  integer, parameter :: most_steps = 30
  !> The new apex is not looked for where the patch is steeper than this against the projection.
  real(wp), parameter :: least_determinant = 0.05_wp

  !> The facet, the patch and the gap at the current positions.
  type, extends(contact_cone_t) :: cone_t
    type(patch_t) :: patch !! the patch
    real(wp) :: f(3, 3) !! a1, a2, e
    real(wp) :: dual(3, 3) !! a^1, a^2, e
    real(wp) :: y(3) !! components of the slave node's position
    real(wp) :: gamma !! its distance in units of the normal
    type(patch_point_t) :: below !! the patch at the projection
    real(wp) :: size_n !! length of the normal there
    real(wp) :: n(3) !! unit normal there
    real(wp) :: offset !! what is added to the normal gap, along it [length]
    integer :: kind !! which kind of axis
    real(wp) :: axis(3) !! axis about which the direction of friction turns
    real(wp) :: v(3) !! vector that is projected to get the direction
    real(wp) :: share(2) !! convected: v = share(1) a1 + share(2) a2
    real(wp) :: slope(2, 2) !! convected: derivative of share by the projection's (xi, eta)
    real(wp) :: size_p !! length of the projected vector
    real(wp) :: q(3) !! n x (projected vector), before it is turned
  end type cone_t

contains

  !> Projection, gap, and stick or slip; `found` is false where the patch gives no answer.
  pure subroutine place_cone(d, e, c, found)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(inout) :: e !! gets status, h2, slip
    type(cone_t), intent(inout) :: c !! patch given; gets all else
    logical, intent(out) :: found !! the patch has an answer
    real(wp) :: x(3, 4)

    x = positions(e, 3)
    c%f = patch_frame(x(:, 2:4))
    c%dual = dual_frame(c%f)
    c%y = matmul(x(:, 1), c%dual)
    c%slave = x(:, 1) + (e%xl(:, e%slaves + 3) + e%ul(:, e%slaves + 3))
    call project_in_patch(c%patch, c%y, c%xi, c%gamma, found)
    if (.not. found) return
    c%below = patch_at(c%patch, c%xi)
    c%n = matmul(c%f, c%below%n)
    c%size_n = norm2(c%n)
    c%n = c%n/c%size_n
    c%g_n = c%gamma*c%size_n
    call place_shift(e%shift, e%offset, c)
    c%g = gap_to(c, e%h1)
    if (c%h_n <= 0.0_wp) then
      call principal_axes(d, c)
      call map_trial(d, c, e)
      if (c%back%slip) call find_apex(c, found)
      e%h2 = c%apex
    else
      call leave_open(c%contact_cone_t, e)
    end if
  end subroutine place_cone

  !> The shift of the gap: as that of element 3, it turns with the facet. What is added to the
  !! normal gap lies along the normal at the projection (doc/theory, "Initial overlap", eq. (6.18)).
  pure subroutine place_shift(kappa, offset, c)
    real(wp), intent(in) :: kappa(3) !! along t1, t2 and e of the facet [length]
    real(wp), intent(in) :: offset !! of the normal gap [length]
    type(cone_t), intent(inout) :: c !! gets shifted, kappa, offset, t, k, h_n

    c%kappa = kappa
    c%offset = offset
    c%t = 0.0_wp
    c%k = 0.0_wp
    c%h_n = c%g_n
    c%shifted = any(abs([kappa, offset]) > 0.0_wp)
    if (.not. c%shifted) return
    c%t(:, 1) = c%f(:, 1)/norm2(c%f(:, 1))
    c%t(:, 2) = cross(c%f(:, 3), c%t(:, 1))
    c%k = kappa(1)*c%t(:, 1) + kappa(2)*c%t(:, 2) + kappa(3)*c%f(:, 3) + offset*c%n
    c%h_n = c%g_n + dot_product(c%n, c%k)
  end subroutine place_shift

  !> x_S - x_m at a point of the patch, with the shift.
  pure function gap_to(c, xi) result(g)
    type(cone_t), intent(in) :: c !! facet and patch
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: g(3)
    type(patch_point_t) :: point

    point = patch_at(c%patch, xi)
    g = matmul(c%f, c%y - point%x) + c%k
  end function gap_to

  !> Principal axes p1, p2 = n x p1.
  pure subroutine principal_axes(d, c)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(cone_t), intent(inout) :: c !! gets all of the axes
    real(wp) :: p(3), turn(2)

    c%kind = nint(d(d03_axis_kind))
    c%axis = d(d03_axis:d03_axis + 2)
    c%share = 0.0_wp
    c%slope = 0.0_wp
    turn = [1.0_wp, 0.0_wp]
    if (c%kind == axis_convected) then
      c%slope = reshape(d(d03_place:d03_place + 3), [2, 2])
      c%share = d(d03_axis:d03_axis + 1) + matmul(c%slope, c%xi)
      c%v = matmul(c%f(:, 1:2), c%share)
    else
      c%v = direction_in_space(d, c%slave)
      turn = d(d03_turn:d03_turn + 1)
    end if
    p = c%v - dot_product(c%n, c%v)*c%n
    c%size_p = norm2(p)
    if (.not. c%size_p > shortest_projection*norm2(c%v)) then
      c%kind = axis_convected
      turn = [1.0_wp, 0.0_wp]
      c%share = [1.0_wp, 0.0_wp]
      c%slope = 0.0_wp
      c%v = c%f(:, 1)
      p = c%v - dot_product(c%n, c%v)*c%n
      c%size_p = norm2(p)
    end if
    p = p/c%size_p
    c%q = cross(c%n, p)
    c%p(:, 1) = turn(1)*p + turn(2)*c%q
    c%p(:, 2) = cross(c%n, c%p(:, 1))
  end subroutine principal_axes

  !> The point of the patch from which the gap has the tangential part s' (Newton's method).
  pure subroutine find_apex(c, found)
    type(cone_t), intent(inout) :: c !! gets apex, g_new
    logical, intent(out) :: found !! there is one
    type(patch_point_t) :: point
    real(wp) :: missing(2), m(2, 2), det, det_flat, step(2)
    integer :: i

    m = matmul(transpose(c%p), c%f(:, 1:2))
    det_flat = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
    c%apex = c%xi
    found = .false.
    do i = 1, most_steps
      point = patch_at(c%patch, c%apex)
      missing = matmul(matmul(c%f, c%y - point%x) + c%k, c%p) - c%back%s
      m = matmul(transpose(c%p), matmul(c%f, point%dx))
      det = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
      if (.not. det > least_determinant*abs(det_flat)) exit
      step = reshape(solve_ways(m, reshape(missing, [2, 1])), [2])
      c%apex = c%apex + step
      if (maxval(abs(step)) > last_step) cycle
      found = .true.
      exit
    end do
    c%g_new = gap_to(c, c%apex)
  end subroutine find_apex

  !> Derivative of w1 a1 + w2 a2 + w3 e with fixed components.
  pure function frame_operator(c, w) result(a)
    type(cone_t), intent(in) :: c !! facet
    real(wp), intent(in) :: w(3) !! components
    real(wp) :: a(3, 12)

    a(:, 1:3) = 0.0_wp
    a(:, 4:12) = frame_change(c%f, c%dual, w)
  end function frame_operator

  !> Derivative of the shift, which turns with the facet.
  pure function shift_derivative(c) result(dk)
    type(cone_t), intent(in) :: c !! facet and shift
    real(wp) :: dk(3, 12)
    real(wp) :: de(3, 12), w(12)

    de = frame_operator(c, [0.0_wp, 0.0_wp, 1.0_wp])
    w = 0.0_wp
    w(4:6) = c%t(:, 2)/norm2(c%f(:, 1))
    w(10:12) = -w(4:6)
    dk = dyad(c%kappa(1)*c%t(:, 2) - c%kappa(2)*c%t(:, 1), w) + c%kappa(3)*de &
      - dyad(c%f(:, 3), matmul(matmul(c%t, c%kappa(1:2)), de))
  end function shift_derivative

  !> Stick or slip: the trial mapped onto the cone. Where it slips the new apex is still to be
  !! found.
  pure subroutine map_trial(d, c, e)
    real(wp), intent(in) :: d(:) !! parameters, the first as those of element 3
    class(cone_t), intent(inout) :: c !! gap and axes; gets back, and g_new, apex in stick
    type(element_t), intent(inout) :: e !! gets status, slip

    call map_friction(d, matmul(c%g, c%p), c%contact_cone_t, e)
    e%status = status_slip
    e%slip = matmul(c%p, c%back%s)
    if (c%back%slip) return
    e%status = status_stick
    c%g_new = c%g
    c%apex = e%h1
  end subroutine map_trial

  !> Whether the apex stays where it is in a task; told to stick, a closed point keeps its old apex.
  pure subroutine hold_apex(task, c, e, stays)
    integer, intent(in) :: task !! one of the tasks of element_types
    class(cone_t), intent(inout) :: c !! may get g_new, apex
    type(element_t), intent(in) :: e !! status, old apex
    logical, intent(out) :: stays !! it does

    stays = task == task_stick_tangent .or. task == task_stick_shift_tangent
    if (stays .and. e%status /= status_open) then
      c%g_new = c%g
      c%apex = e%h1
    end if
    stays = stays .or. e%status /= status_slip
  end subroutine hold_apex

  !> Ways of the apex in (xi, eta) with given components along the axes of friction.
  pure function solve_ways(m, way) result(dtip)
    real(wp), intent(in) :: m(2, 2) !! p_i . t_j at the apex [length]
    real(wp), intent(in) :: way(:, :) !! (2, any) along p1 and p2
    real(wp) :: dtip(2, size(way, 2))

    dtip(1, :) = m(2, 2)*way(1, :) - m(1, 2)*way(2, :)
    dtip(2, :) = m(1, 1)*way(2, :) - m(2, 1)*way(1, :)
    dtip = dtip/(m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1))
  end function solve_ways

  !> Components along p1 and p2 of what the new apex has to follow, in slip: p_i.dg + g'.dp_i -
  !! ds'_i with ds' = M ds - r dh_n (doc/theory, "Slip").
  pure function ways_of_apex(c, dn, dgn, w, dg_old, dk, dg) result(way)
    class(cone_t), intent(in) :: c !! cone at its new apex
    real(wp), intent(in) :: dn(:, :) !! (3, dofs) derivative of the unit normal
    real(wp), intent(in) :: dgn(:) !! (dofs) of the normal gap
    real(wp), intent(in) :: w(:) !! (dofs) turn of the axes
    real(wp), intent(in) :: dg_old(:, :) !! (3, dofs) of the gap to the old apex, without the shift
    real(wp), intent(in) :: dk(:, :) !! (3, dofs) of the shift
    real(wp), intent(in) :: dg(:, :) !! (3, dofs) of the gap to the new apex if that stays
    real(wp) :: way(2, size(w))
    real(wp) :: dp1(3, size(w)), dp2(3, size(w)), ds(2, size(w)), dhn(size(w))

    dhn = dgn
    if (c%shifted) dhn = dhn + matmul(c%n, dk) + matmul(c%k, dn)
    dp1 = dyad(c%p(:, 2), w) - dyad(c%n, matmul(c%p(:, 1), dn))
    dp2 = -dyad(c%p(:, 1), w) - dyad(c%n, matmul(c%p(:, 2), dn))
    ds = matmul(transpose(c%p), dg_old + dk)
    ds(1, :) = ds(1, :) + matmul(c%g, dp1)
    ds(2, :) = ds(2, :) + matmul(c%g, dp2)
    way = matmul(transpose(c%p), dg) - matmul(c%back%m, ds) + dyad(c%back%r, dhn)
    way(1, :) = way(1, :) + matmul(c%g_new, dp1)
    way(2, :) = way(2, :) + matmul(c%g_new, dp2)
  end function ways_of_apex

  !> t1, t2, e of the facet: the frame that multipliers are given in.
  pure function frame_of(c) result(frame)
    class(cone_t), intent(in) :: c !! facet
    real(wp) :: frame(3, 3)

    frame(:, 1) = c%f(:, 1)/norm2(c%f(:, 1))
    frame(:, 2) = cross(c%f(:, 3), frame(:, 1))
    frame(:, 3) = c%f(:, 3)
  end function frame_of

  !> What the mapped gap does when the trial one moves along the frame of the facet, before the apex
  !! has followed.
  pure function mapped_ways(c, frame) result(way)
    class(cone_t), intent(in) :: c !! cone at its new apex
    real(wp), intent(in) :: frame(3, 3) !! t1, t2, e
    real(wp) :: way(2, 3)

    way = matmul(transpose(c%p), frame)
    way = way - matmul(c%back%m, way) + dyad(c%back%r, matmul(c%n, frame))
  end function mapped_ways
end module patch_cone

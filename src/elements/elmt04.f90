!> Element 4: the moving friction elliptical cone of element 3 on a curved patch with continuous
!! normals (doc/theory, "Smooth surfaces").
!!
!! Nodes, history, shift and task_stress as those of element 3; the parameters are those of element 3,
!! then the patch. The gap vector g = x_S - x_m(tip) begins on the patch, and x_m carries the
!! forces to the facet's nodes, so that force and moment balance exactly.
module elmt04
  use kinds, only: wp
  use vectors, only: cross, dyad
  use element_types, only: element_t, task_tangent, task_stick_tangent, task_residual, &
    task_stress, status_open, status_stick, status_slip
  use slave_points, only: positions, spread_point
  use friction_return, only: return_map, return_t, has_friction
  use friction_axes, only: direction_in_space, d03_epsilon, d03_mu, d03_rule, d03_axis_kind, &
    d03_axis, d03_turn, d03_place, d03_size, axis_convected, axis_circumferential, axis_radial
  use smooth_patch, only: patch_t, patch_point_t, patch_at, patch_from_values, n_patch_values, &
    flat_patch, project_in_patch, patch_frame, dual_frame
  implicit none
  private
  public :: elmt04_smooth, d04_patch, d04_size

  integer, parameter :: d04_patch = d03_size + 1 !! place of the patch in d
  integer, parameter :: d04_size = d03_size + n_patch_values !! length of d

  !> Projected vectors shorter than this share of the vector count as normal to the patch.
  real(wp), parameter :: shortest_projection = 1.0e-8_wp
  !> A step of the new tip below this is its last; and the most steps.
  real(wp), parameter :: last_step = 1.0e-9_wp
  integer, parameter :: most_steps = 30
  !> The new tip is not looked for where the patch is steeper than this against the projection.
  real(wp), parameter :: least_determinant = 0.05_wp

  !> The facet, the patch and the gap at the current positions.
  type :: cone_t
    type(patch_t) :: patch !! the patch
    real(wp) :: f(3, 3) !! a1, a2, e
    real(wp) :: dual(3, 3) !! a^1, a^2, e
    real(wp) :: y(3) !! components of the slave node's position
    real(wp) :: xi(2) !! projection of the slave node
    real(wp) :: gamma !! its distance in units of the normal
    type(patch_point_t) :: below !! the patch at the projection
    real(wp) :: size_n !! length of the normal there
    real(wp) :: n(3) !! unit normal there
    real(wp) :: g_n !! normal gap [length]
    real(wp) :: g(3) !! gap to the old tip, with the shift [length]
    logical :: shifted !! there is a shift
    real(wp) :: kappa(3) !! the shift along t1, t2 and e of the facet [length]
    real(wp) :: t(3, 2) !! t1, t2 of the facet; set if shifted
    real(wp) :: k(3) !! the shift [length]
    real(wp) :: h_n !! g_N and the shift along the normal, what the pressure is made of [length]
    real(wp) :: p(3, 2) !! principal axes of friction
    real(wp) :: slave(3) !! position of the slave point [length]
    integer :: kind !! which kind of axis
    real(wp) :: axis(3) !! axis about which the direction of friction turns
    real(wp) :: v(3) !! vector that is projected to get the direction
    real(wp) :: share(2) !! convected: v = share(1) a1 + share(2) a2
    real(wp) :: slope(2, 2) !! convected: derivative of share by the projection's (xi, eta)
    real(wp) :: size_p !! length of the projected vector
    real(wp) :: q(3) !! n x (projected vector), before it is turned
    type(return_t) :: back !! state mapped onto the cone
    real(wp) :: g_new(3) !! gap to the new tip, with the shift [length]
    real(wp) :: tip(2) !! new tip
  end type cone_t

contains

  !> Does one task for one element.
  pure subroutine elmt04_smooth(task, d, e)
    integer, intent(in) :: task !! one of the tasks of element_types
    real(wp), intent(in) :: d(:) !! (d04_size) parameters
    type(element_t), intent(inout) :: e !! local data
    type(cone_t) :: c
    logical :: found

    c%patch = patch_from_values(d(d04_patch:d04_size))
    call place_cone(d, e, c, found)
    if (.not. found) then
      c%patch = flat_patch()
      call place_cone(d, e, c, found)
    end if
    select case (task)
    case (task_tangent)
      call residual(d(d03_epsilon), c, e)
      call tangent(d(d03_epsilon), c, e%status == status_slip, e)
    case (task_stick_tangent)
      if (e%status /= status_open) then
        c%g_new = c%g
        c%tip = e%h1
      end if
      call residual(d(d03_epsilon), c, e)
      call tangent(d(d03_epsilon), c, .false., e)
    case (task_residual)
      call residual(d(d03_epsilon), c, e)
    case (task_stress)
      call principal_axes(d, c)
      call report(d, c, e)
    case default
      ! The other tasks need no more than the cone.
    end select
    if (e%slaves > 1 .and. task /= task_stress) call spread_point(task /= task_residual, e)
  end subroutine elmt04_smooth

  !> Projection, gap, and stick or slip; `found` is false where the patch gives no answer.
  pure subroutine place_cone(d, e, c, found)
    real(wp), intent(in) :: d(:) !! (d04_size) parameters
    type(element_t), intent(inout) :: e !! gets status, h2, slip
    type(cone_t), intent(inout) :: c !! patch given; gets all else
    logical, intent(out) :: found !! the patch has an answer
    real(wp) :: x(3, 4)

    x = positions(e)
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
    call place_shift(e%shift, c)
    c%g = gap_to(c, e%h1)
    if (c%h_n <= 0.0_wp) then
      call principal_axes(d, c)
      call move_cone(d, c, e, found)
    else
      call leave_open(c, e)
    end if
  end subroutine place_cone

  !> The shift of the gap: as that of element 3, it turns with the facet.
  pure subroutine place_shift(kappa, c)
    real(wp), intent(in) :: kappa(3) !! along t1, t2 and e of the facet [length]
    type(cone_t), intent(inout) :: c !! gets shifted, kappa, t, k, h_n

    c%kappa = kappa
    c%t = 0.0_wp
    c%k = 0.0_wp
    c%h_n = c%g_n
    c%shifted = any(abs(kappa) > 0.0_wp)
    if (.not. c%shifted) return
    c%t(:, 1) = c%f(:, 1)/norm2(c%f(:, 1))
    c%t(:, 2) = cross(c%f(:, 3), c%t(:, 1))
    c%k = kappa(1)*c%t(:, 1) + kappa(2)*c%t(:, 2) + kappa(3)*c%f(:, 3)
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
    real(wp), intent(in) :: d(:) !! (d04_size) parameters
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

  !> Stick or slip: the mapped gap and the new tip.
  pure subroutine move_cone(d, c, e, found)
    real(wp), intent(in) :: d(:) !! (d04_size) parameters
    type(cone_t), intent(inout) :: c !! facet and gap; gets back, g_new, tip
    type(element_t), intent(inout) :: e !! gets status, h2, slip
    logical, intent(out) :: found !! the new tip lies on the patch

    found = .true.
    call return_map(matmul(c%g, c%p), -c%h_n, d(d03_mu:d03_mu + 1), nint(d(d03_rule)), c%back)
    if (c%back%slip) then
      e%status = status_slip
      call find_tip(c, found)
    else
      e%status = status_stick
      c%g_new = c%g
      c%tip = e%h1
    end if
    e%h2 = c%tip
    e%slip = matmul(c%p, c%back%s)
  end subroutine move_cone

  !> The point of the patch from which the gap has the tangential part s' (Newton's method).
  pure subroutine find_tip(c, found)
    type(cone_t), intent(inout) :: c !! gets tip, g_new
    logical, intent(out) :: found !! there is one
    type(patch_point_t) :: point
    real(wp) :: missing(2), m(2, 2), det, det_flat, step(2)
    integer :: i

    m = matmul(transpose(c%p), c%f(:, 1:2))
    det_flat = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
    c%tip = c%xi
    found = .false.
    do i = 1, most_steps
      point = patch_at(c%patch, c%tip)
      missing = matmul(matmul(c%f, c%y - point%x) + c%k, c%p) - c%back%s
      m = matmul(transpose(c%p), matmul(c%f, point%dx))
      det = m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1)
      if (.not. det > least_determinant*abs(det_flat)) exit
      step = [m(2, 2)*missing(1) - m(1, 2)*missing(2), m(1, 1)*missing(2) - m(2, 1)*missing(1)]/det
      c%tip = c%tip + step
      if (maxval(abs(step)) > last_step) cycle
      found = .true.
      exit
    end do
    c%g_new = gap_to(c, c%tip)
  end subroutine find_tip

  !> No contact: no force; the tip is the projection.
  pure subroutine leave_open(c, e)
    type(cone_t), intent(inout) :: c !! facet and gap; gets g_new, tip
    type(element_t), intent(inout) :: e !! gets status, h2, slip

    e%status = status_open
    c%g_new = 0.0_wp
    c%tip = c%xi
    e%h2 = c%tip
    e%slip = 0.0_wp
  end subroutine leave_open

  !> r = eps B^T g', with B at the new tip.
  pure subroutine residual(epsilon, c, e)
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    type(cone_t), intent(in) :: c !! cone at its new tip
    type(element_t), intent(inout) :: e !! gets r
    type(patch_point_t) :: point

    point = patch_at(c%patch, c%tip)
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
    type(cone_t), intent(in) :: c !! cone at its new tip
    logical, intent(in) :: slides !! the tip moves
    type(element_t), intent(inout) :: e !! gets s
    type(patch_point_t) :: point
    real(wp) :: b(3, 12), dg(3, 12), dtip(2, 12), k(12, 12)
    integer :: j

    e%s(1:12, 1:12) = 0.0_wp
    if (e%status == status_open) return
    point = patch_at(c%patch, c%tip)
    b = gap_operator(c, point%x)
    dg = b
    if (c%shifted) dg = b + shift_derivative(c)
    k = -point%x(3)*normal_curvature(c, c%g_new)
    if (slides) then
      call tip_derivative(c, e%h1, dg, point, dtip)
      dg = dg - matmul(matmul(c%f, point%dx), dtip)
      do j = 1, 2
        k(4:12, :) = k(4:12, :) - dyad(facet_force(c, point%dx(:, j), c%g_new), dtip(j, :))
      end do
    end if
    e%s(1:12, 1:12) = epsilon*(matmul(transpose(b), dg) + k)
  end subroutine tangent

  !> Derivative of the new tip by the displacements, in slip.
  pure subroutine tip_derivative(c, tip_old, dg, point, dtip)
    type(cone_t), intent(in) :: c !! cone at its new tip
    real(wp), intent(in) :: tip_old(2) !! (xi, eta) of the old tip
    real(wp), intent(in) :: dg(3, 12) !! derivative of the gap to a tip that stays
    type(patch_point_t), intent(in) :: point !! the patch at the new tip
    real(wp), intent(out) :: dtip(2, 12) !! the derivative
    type(patch_point_t) :: old
    real(wp) :: dn(3, 12), dhn(12), dp1(3, 12), dp2(3, 12), w(12), ds(2, 12), right(2, 12)
    real(wp) :: dk(3, 12), dxi(2, 12), m(2, 2)

    call projection_derivative(c, dn, dhn, dxi)
    dk = 0.0_wp
    if (c%shifted) then
      dk = shift_derivative(c)
      dhn = dhn + matmul(c%n, dk) + matmul(c%k, dn)
    end if
    w = axis_turn(c, dn, dxi)
    dp1 = dyad(c%p(:, 2), w) - dyad(c%n, matmul(c%p(:, 1), dn))
    dp2 = -dyad(c%p(:, 1), w) - dyad(c%n, matmul(c%p(:, 2), dn))
    old = patch_at(c%patch, tip_old)
    ds = matmul(transpose(c%p), gap_operator(c, old%x) + dk)
    ds(1, :) = ds(1, :) + matmul(c%g, dp1)
    ds(2, :) = ds(2, :) + matmul(c%g, dp2)
    right = matmul(transpose(c%p), dg) - matmul(c%back%m, ds) + dyad(c%back%r, dhn)
    right(1, :) = right(1, :) + matmul(c%g_new, dp1)
    right(2, :) = right(2, :) + matmul(c%g_new, dp2)
    m = matmul(transpose(c%p), matmul(c%f, point%dx))
    dtip(1, :) = m(2, 2)*right(1, :) - m(1, 2)*right(2, :)
    dtip(2, :) = m(1, 1)*right(2, :) - m(2, 1)*right(1, :)
    dtip = dtip/(m(1, 1)*m(2, 2) - m(1, 2)*m(2, 1))
  end subroutine tip_derivative

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

  !> Derivative of w1 a1 + w2 a2 + w3 e with fixed components.
  pure function frame_operator(c, w) result(a)
    type(cone_t), intent(in) :: c !! facet
    real(wp), intent(in) :: w(3) !! components
    real(wp) :: a(3, 12)
    integer :: k

    a(:, 1:3) = 0.0_wp
    a(:, 4:6) = -w(3)*dyad(c%dual(:, 1), c%f(:, 3))
    a(:, 7:9) = -w(3)*dyad(c%dual(:, 2), c%f(:, 3))
    do k = 1, 3
      a(k, 3 + k) = a(k, 3 + k) + w(1)
      a(k, 6 + k) = a(k, 6 + k) + w(2)
    end do
    a(:, 10:12) = -a(:, 4:6) - a(:, 7:9)
  end function frame_operator

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

  !> Derivative of (de/du)^T g with g fixed: second derivative of the facet's unit normal.
  pure function normal_curvature(c, g) result(k)
    type(cone_t), intent(in) :: c !! facet
    real(wp), intent(in) :: g(3) !! any vector
    real(wp) :: k(12, 12)
    real(wp) :: de(3, 12), change(12), row(3, 12), along(2)
    integer :: i, j, m

    de = frame_operator(c, [0.0_wp, 0.0_wp, 1.0_wp])
    along = matmul(g, c%dual(:, 1:2))
    k = 0.0_wp
    do i = 1, 2
      ! g . d(a^i) = -(g . a^j) (a^i . da_j) - (g . e) (a^i . de)
      change = -dot_product(g, c%f(:, 3))*matmul(c%dual(:, i), de)
      do j = 1, 2
        change(3*j + 1:3*j + 3) = change(3*j + 1:3*j + 3) - along(j)*c%dual(:, i)
        change(10:12) = change(10:12) + along(j)*c%dual(:, i)
      end do
      row = -dyad(c%f(:, 3), change) - along(i)*de
      do m = 1, 3
        k(3*i + m, :) = row(m, :)
        k(9 + m, :) = k(9 + m, :) - row(m, :)
      end do
    end do
  end function normal_curvature

  !> The state of the point, as element 3 reports it, with the normal at the projection.
  pure subroutine report(d, c, e)
    real(wp), intent(in) :: d(:) !! (d04_size) parameters
    type(cone_t), intent(in) :: c !! cone at its new tip
    type(element_t), intent(inout) :: e !! gets stress
    real(wp) :: mu(2), ratio(2)

    mu = d(d03_mu:d03_mu + 1)
    e%stress = 0.0_wp
    e%stress(4) = c%g_n
    e%stress(7:9) = c%p(:, 1)
    e%stress(10:12) = c%n
    if (e%status == status_open) return
    ratio = 0.0_wp
    where (has_friction(mu)) ratio = c%back%s/mu
    e%stress(1:3) = d(d03_epsilon)*c%g_new
    e%stress(5) = norm2(c%back%s)
    e%stress(6) = norm2(ratio) - abs(c%h_n)
    e%stress(13:14) = d(d03_epsilon)*[abs(c%h_n), e%stress(5)]
    if (c%shifted) e%stress(5) = norm2(matmul(c%back%s - matmul(c%k, c%p), transpose(c%p)))
  end subroutine report
end module elmt04

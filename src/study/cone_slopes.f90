!> Derivatives of one contact element by what is not a position: old apex, coefficients of friction,
!! slip rule, lay, shift; and of its stick, slip and gap criteria (doc/theory, "Derivatives of the
!! contact element").
!!
!! All is taken at one state of elmt03, whose tasks give forces and tangents. Lengths, as there:
!! the penalty is divided out, and comes in where forces are made of these.
module cone_slopes
  use kinds, only: wp
  use vectors, only: cross, dyad
  use element_types, only: element_t, status_open, status_stick, status_slip
  use slave_points, only: positions
  use friction_axes, only: axes_t, find_axes, turn_of_axes
  use element_parameters, only: d03_mu, d03_rule, d03_axis_kind, axis_convected
  use friction_return, only: return_map, return_t, has_friction, slope_of_cone
  use contact_cone, only: gap_operator
  implicit none
  private
  public :: cone_slopes_t, find_slopes, cause_apex, cause_mu, cause_rule, cause_angle, &
    cause_shift, causes, slope_by_causes, slope_by_motion, force_slope, turn_of_vector

  integer, parameter :: cause_apex = 1 !! old apex (2)
  integer, parameter :: cause_mu = 3 !! mu1, mu2
  integer, parameter :: cause_rule = 5 !! m of the slip rule, as a real number
  integer, parameter :: cause_angle = 6 !! turn of the lay [radian]
  integer, parameter :: cause_shift = 7 !! shift along t1, t2 and e (3) [length]
  integer, parameter :: causes = 9 !! how many there are

  !> A point of the element and all its slopes.
  type :: cone_slopes_t
    integer :: status = status_open !! open, stick or slip
    real(wp) :: g(3) = 0.0_wp !! gap to the new apex, with the shift [length]
    real(wp) :: apex(2) = 0.0_wp !! new apex
    real(wp) :: rho = 0.0_wp !! depth that friction knows [length]
    real(wp) :: over = 0.0_wp !! trial slip over its cone: |s|_A - rho [length]
    real(wp) :: dg(3, causes) = 0.0_wp !! of g
    real(wp) :: dtip(2, causes) = 0.0_wp !! of apex
    real(wp) :: dover(causes) = 0.0_wp !! of over
    real(wp) :: drho(causes) = 0.0_wp !! of rho
    real(wp) :: dg_x(3, 12) = 0.0_wp !! of g, by S, 1, 2, 3
    real(wp) :: dapex_x(2, 12) = 0.0_wp !! of apex [1/length]
    real(wp) :: dover_x(12) = 0.0_wp !! of over
    real(wp) :: drho_x(12) = 0.0_wp !! of rho
  end type cone_slopes_t

  !> What the derivatives share.
  type :: facet_t
    real(wp) :: a(3, 2) !! base vectors a1, a2
    real(wp) :: dual(3, 2) !! dual vectors
    real(wp) :: e(3) !! outward unit normal
    real(wp) :: xi(2) !! projection of S
    real(wp) :: gap !! normal gap [length]
    real(wp) :: g(3) !! gap to the old apex, with the shift [length]
    real(wp) :: t(3, 3) !! frame of the shift: t1, t2, e
    real(wp) :: k(3) !! tangential part of the shift [length]
    real(wp) :: s(2) !! trial components [length]
    type(axes_t) :: axes !! principal axes
    type(return_t) :: back !! mapped state
    real(wp) :: de(3, 12) !! of e
    real(wp) :: dgap(12) !! of gap
    real(wp) :: dk(3, 12) !! of the shift
    real(wp) :: ds(2, 12) !! of s
    real(wp) :: dp(3, 12, 2) !! of p1, p2
  end type facet_t

contains

  !> All slopes of one element at its state.
  pure subroutine find_slopes(d, e, slopes)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(in) :: e !! local data: positions, h1, shift
    type(cone_slopes_t), intent(out) :: slopes !! state and slopes
    type(facet_t) :: f

    call look_at_facet(d, e, f)
    slopes%rho = -(f%gap + e%shift(3))
    slopes%drho(cause_shift + 2) = -1.0_wp
    slopes%drho_x = -f%dgap
    if (slopes%rho < 0.0_wp) then
      slopes%apex = f%xi
      slopes%dapex_x = matmul(transpose(f%dual), gap_operator(f%xi) - dyad(f%e, f%dgap) &
        - f%gap*f%de)
      return
    end if
    call return_map(f%s, slopes%rho, d(d03_mu:d03_mu + 1), nint(d(d03_rule)), f%back)
    if (f%back%slip) then
      slopes%status = status_slip
      call slide(d, e, f, slopes)
    else
      slopes%status = status_stick
      slopes%g = f%g
      slopes%apex = e%h1
      slopes%dg(:, cause_apex:cause_apex + 1) = -f%a
      slopes%dg(:, cause_shift:) = f%t
      slopes%dtip(1, cause_apex) = 1.0_wp
      slopes%dtip(2, cause_apex + 1) = 1.0_wp
      slopes%dg_x = gap_operator(e%h1) + f%dk
    end if
    call compare_with_cone(d(d03_mu:d03_mu + 1), f, slopes)
  end subroutine find_slopes

  !> Facet, gap, axes, trial state, and how they move with the nodes.
  pure subroutine look_at_facet(d, e, f)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(in) :: e !! local data
    type(facet_t), intent(out) :: f !! all of it
    real(wp) :: x(3, 4), n(3), size_n, y(3), w(12)

    x = positions(e, 3)
    f%a(:, 1) = x(:, 2) - x(:, 4)
    f%a(:, 2) = x(:, 3) - x(:, 4)
    n = cross(f%a(:, 1), f%a(:, 2))
    size_n = norm2(n)
    f%e = n/size_n
    f%dual(:, 1) = cross(f%a(:, 2), f%e)/size_n
    f%dual(:, 2) = cross(f%e, f%a(:, 1))/size_n
    y = x(:, 1) - x(:, 4)
    f%gap = dot_product(y, f%e)
    f%xi = matmul(y, f%dual)
    f%t(:, 1) = f%a(:, 1)/norm2(f%a(:, 1))
    f%t(:, 2) = cross(f%e, f%t(:, 1))
    f%t(:, 3) = f%e
    f%k = matmul(f%t(:, 1:2), e%shift(1:2))
    f%g = y - matmul(f%a, e%h1) + f%k + e%shift(3)*f%e
    call find_axes(d, f%a(:, 1), f%a(:, 2), f%e, f%xi, x(:, 1) + (e%xl(:, e%slaves + 3) &
      + e%ul(:, e%slaves + 3)), f%axes)
    f%s = matmul(f%g, f%axes%p)
    f%de(:, 1:3) = 0.0_wp
    f%de(:, 4:6) = -dyad(f%dual(:, 1), f%e)
    f%de(:, 7:9) = -dyad(f%dual(:, 2), f%e)
    f%de(:, 10:12) = -f%de(:, 4:6) - f%de(:, 7:9)
    f%dgap = matmul(f%e, gap_operator(f%xi))
    f%dk = turn_with_frame(f%t, norm2(f%a(:, 1)), f%de, e%shift)
    w = turn_of_axes(f%axes, f%de)
    if (f%axes%varies) w = w + matmul(matmul(f%dual, f%axes%place_share), gap_operator(f%xi) &
      - f%gap*f%de)
    f%dp(:, :, 1) = dyad(f%axes%p(:, 2), w) - dyad(f%e, matmul(f%axes%p(:, 1), f%de))
    f%dp(:, :, 2) = -dyad(f%axes%p(:, 1), w) - dyad(f%e, matmul(f%axes%p(:, 2), f%de))
    f%ds(1, :) = matmul(f%axes%p(:, 1), gap_operator(e%h1) + f%dk) + matmul(f%g, f%dp(:, :, 1))
    f%ds(2, :) = matmul(f%axes%p(:, 2), gap_operator(e%h1) + f%dk) + matmul(f%g, f%dp(:, :, 2))
  end subroutine look_at_facet

  !> How a vector turns with the frame of a facet, t1 along a1.
  pure function turn_with_frame(t, length, de, c) result(dv)
    real(wp), intent(in) :: t(3, 3) !! frame: t1, t2, e
    real(wp), intent(in) :: length !! of a1 [length]
    real(wp), intent(in) :: de(3, 12) !! of e
    real(wp), intent(in) :: c(3) !! components of the vector
    real(wp) :: dv(3, 12)
    real(wp) :: w(12)

    w = 0.0_wp
    w(4:6) = t(:, 2)/length
    w(10:12) = -w(4:6)
    dv = dyad(c(1)*t(:, 2) - c(2)*t(:, 1), w) - dyad(t(:, 3), matmul(matmul(t(:, 1:2), c(1:2)), &
      de)) + c(3)*de
  end function turn_with_frame

  !> The frame of the facet of an element, and how a vector turns with it.
  pure subroutine turn_of_vector(e, v, frame, dv)
    type(element_t), intent(in) :: e !! local data
    real(wp), intent(in) :: v(3) !! the vector
    real(wp), intent(out) :: frame(3, 3) !! t1, t2, e
    real(wp), intent(out) :: dv(3, 12) !! its motion with S, 1, 2, 3 [1/length, times that of v]
    real(wp) :: x(3, 4), a(3, 2), n(3), size_n, de(3, 12)

    x = positions(e, 3)
    a(:, 1) = x(:, 2) - x(:, 4)
    a(:, 2) = x(:, 3) - x(:, 4)
    n = cross(a(:, 1), a(:, 2))
    size_n = norm2(n)
    frame(:, 3) = n/size_n
    frame(:, 1) = a(:, 1)/norm2(a(:, 1))
    frame(:, 2) = cross(frame(:, 3), frame(:, 1))
    de(:, 1:3) = 0.0_wp
    de(:, 4:6) = -dyad(cross(a(:, 2), frame(:, 3)), frame(:, 3))/size_n
    de(:, 7:9) = -dyad(cross(frame(:, 3), a(:, 1)), frame(:, 3))/size_n
    de(:, 10:12) = -de(:, 4:6) - de(:, 7:9)
    dv = turn_with_frame(frame, norm2(a(:, 1)), de, matmul(v, frame))
  end subroutine turn_of_vector

  !> Slip: g' = -rho e + P s', and the apex A (x_S - x_3 - s' + k).
  pure subroutine slide(d, e, f, slopes)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(in) :: e !! local data
    type(facet_t), intent(in) :: f !! facet, mapped state
    type(cone_slopes_t), intent(inout) :: slopes !! gets g, apex and their slopes
    real(wp) :: ds_new(2, 12), s_mu(2, 2), s_rule(2), turn

    associate (p => f%axes%p, m => f%back%m, s_new => f%back%s)
      slopes%g = matmul(p, s_new) - slopes%rho*f%e
      slopes%apex = f%xi - matmul(matmul(p, s_new) - f%k, f%dual)
      call slope_of_cone(f%s, slopes%rho, d(d03_mu:d03_mu + 1), nint(d(d03_rule)), f%back, s_mu, &
        s_rule)
      turn = turn_by_angle(d, e, f)
      slopes%dg(:, cause_apex:cause_apex + 1) = -matmul(p, matmul(m, matmul(transpose(p), f%a)))
      slopes%dg(:, cause_mu:cause_mu + 1) = matmul(p, s_mu)
      slopes%dg(:, cause_rule) = matmul(p, s_rule)
      slopes%dg(:, cause_angle) = turn*(matmul(p, matmul(m, [f%s(2), -f%s(1)])) &
        + s_new(1)*p(:, 2) - s_new(2)*p(:, 1))
      slopes%dg(:, cause_shift:cause_shift + 1) = matmul(p, matmul(m, matmul(transpose(p), &
        f%t(:, 1:2))))
      slopes%dg(:, cause_shift + 2) = f%e - matmul(p, f%back%r)
      slopes%dtip = -matmul(transpose(f%dual), slopes%dg)
      slopes%dtip(:, cause_shift:) = slopes%dtip(:, cause_shift:) + matmul(transpose(f%dual), f%t)
      ds_new = matmul(m, f%ds) - dyad(f%back%r, f%dgap)
      slopes%dg_x = dyad(f%e, f%dgap) - slopes%rho*f%de + matmul(p, ds_new) &
        + s_new(1)*f%dp(:, :, 1) + s_new(2)*f%dp(:, :, 2)
    end associate
    slopes%dapex_x = matmul(transpose(f%dual), gap_operator(slopes%apex) - slopes%dg_x + f%dk)
  end subroutine slide

  !> How far the axes turn for a unit of the lay's angle: an axis that is carried with the facet was
  !! turned in the reference facet, p = c1 a1 + c2 a2.
  pure real(wp) function turn_by_angle(d, e, f) result(turn)
    real(wp), intent(in) :: d(:) !! (n_parameters) parameters
    type(element_t), intent(in) :: e !! local data
    type(facet_t), intent(in) :: f !! facet, axes
    real(wp) :: a(3, 2), n(3), c(2), turned(3), dual(3, 2), size_n

    turn = 1.0_wp
    if (nint(d(d03_axis_kind)) /= axis_convected) return
    associate (last => e%slaves + 3)
      a(:, 1) = e%xl(:, last - 2) - e%xl(:, last)
      a(:, 2) = e%xl(:, last - 1) - e%xl(:, last)
    end associate
    n = cross(a(:, 1), a(:, 2))
    size_n = norm2(n)
    n = n/size_n
    dual(:, 1) = cross(a(:, 2), n)/size_n
    dual(:, 2) = cross(n, a(:, 1))/size_n
    c = matmul(f%axes%p(:, 1), f%dual)
    turned = cross(n, matmul(a, c))
    turn = dot_product(f%axes%p(:, 2), matmul(f%a, matmul(turned, dual)))
  end function turn_by_angle

  !> How far the trial state is outside the cone, and what changes that.
  pure subroutine compare_with_cone(mu, f, slopes)
    real(wp), intent(in) :: mu(2) !! principal coefficients
    type(facet_t), intent(in) :: f !! trial state
    type(cone_slopes_t), intent(inout) :: slopes !! gets over and its slopes
    real(wp) :: size_s, v(2)

    if (.not. all(has_friction(mu))) return
    size_s = norm2(f%s/mu)
    slopes%over = size_s - slopes%rho
    slopes%dover = -slopes%drho
    slopes%dover_x = -slopes%drho_x
    if (size_s <= 0.0_wp) return
    v = f%s/mu**2/size_s
    associate (p => f%axes%p)
      slopes%dover(cause_apex:cause_apex + 1) = -matmul(v, matmul(transpose(p), f%a))
      slopes%dover(cause_mu:cause_mu + 1) = -v*f%s/mu
      slopes%dover(cause_angle) = v(1)*f%s(2) - v(2)*f%s(1)
      slopes%dover(cause_shift:cause_shift + 1) = matmul(v, matmul(transpose(p), f%t(:, 1:2)))
    end associate
    slopes%dover_x = slopes%dover_x + matmul(v, f%ds)
  end subroutine compare_with_cone

  !> Change of g (3) and of the apex (2) for a change of the causes.
  pure function slope_by_causes(slopes, by) result(change)
    type(cone_slopes_t), intent(in) :: slopes !! of the element
    real(wp), intent(in) :: by(causes) !! change of the causes
    real(wp) :: change(5)

    change(1:3) = matmul(slopes%dg, by)
    change(4:5) = matmul(slopes%dtip, by)
  end function slope_by_causes

  !> Change of g (3) and of the apex (2) for a motion of S, 1, 2, 3.
  pure function slope_by_motion(slopes, dx) result(change)
    type(cone_slopes_t), intent(in) :: slopes !! of the element
    real(wp), intent(in) :: dx(12) !! motion [length]
    real(wp) :: change(5)

    change(1:3) = matmul(slopes%dg_x, dx)
    change(4:5) = matmul(slopes%dapex_x, dx)
  end function slope_by_motion

  !> Change of the nodal forces of S, 1, 2, 3 for a change of g, of the apex and of the penalty:
  !! r_S = f, r_a = -N_a(apex) f.
  pure function force_slope(slopes, epsilon, depsilon, change) result(dr)
    type(cone_slopes_t), intent(in) :: slopes !! of the element
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    real(wp), intent(in) :: depsilon !! its change
    real(wp), intent(in) :: change(5) !! of g and of the apex
    real(wp) :: dr(12)
    real(wp) :: f(3), df(3)

    if (slopes%status == status_open) then
      dr = 0.0_wp
      return
    end if
    f = epsilon*slopes%g
    df = epsilon*change(1:3) + depsilon*slopes%g
    associate (apex => slopes%apex, dtip => change(4:5))
      dr(1:3) = df
      dr(4:6) = -apex(1)*df - dtip(1)*f
      dr(7:9) = -apex(2)*df - dtip(2)*f
      dr(10:12) = -(1.0_wp - apex(1) - apex(2))*df + (dtip(1) + dtip(2))*f
    end associate
  end function force_slope
end module cone_slopes

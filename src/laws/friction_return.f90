!> Return map of the elliptical Coulomb law: the only place where stick or slip is decided.
!!
!! The law, the three slip rules and the derivatives: doc/theory, "Strong form", eq. (2.3), "Return
!! map", eqs. (4.1), (4.2), (4.3). All quantities are lengths (penalty divided out): trial
!! components s along the principal axes, rho = -g_N.
module friction_return
  use kinds, only: wp
  use vectors, only: length
  implicit none
  private
  public :: return_map, return_t, has_friction, slope_of_cone

  !> Coefficients up to this are no friction: dividing by them would overflow.
  real(wp), parameter :: no_friction = 1.0e-30_wp
  !> Below this ratio of the cone's radius to the trial slip the cone is a point.
  real(wp), parameter :: point_cone = 1.0e-100_wp
  !> Relative change of the multiplier at which its iteration ends.
  real(wp), parameter :: multiplier_tolerance = 4.0_wp*epsilon(1.0_wp)
  !> The iteration is monotone and superlinear; this bound is never reached.
  integer, parameter :: max_iterations = 100

  !> What the return map gives.
  type :: return_t
    logical :: slip = .false. !! the trial state lies outside the cone
    real(wp) :: s(2) = 0.0_wp !! s', the components carried by friction [length]
    real(wp) :: m(2, 2) = 0.0_wp !! ds'/ds
    real(wp) :: r(2) = 0.0_wp !! ds'/drho
    real(wp) :: mu(2) = 0.0_wp !! coefficients of the cone; of friction_point
    real(wp) :: depth = 0.0_wp !! depth of the cone; of friction_point [length]
    real(wp) :: path = 0.0_wp !! slip path of the point; of friction_point [length]
  end type return_t

contains

  !> Maps the trial components back onto the cone, whose section at this depth is the ellipse of eq.
  !! (4.1).
  pure subroutine return_map(s, rho, mu, rule, back)
    real(wp), intent(in) :: s(2) !! trial components along the principal axes [length]
    real(wp), intent(in) :: rho !! -g_N, not negative [length]
    real(wp), intent(in) :: mu(2) !! principal coefficients, not negative
    integer, intent(in) :: rule !! slip rule m: 0, 1 or 2
    type(return_t), intent(out) :: back !! the mapped state and its derivatives

    if (all(has_friction(mu))) then
      if (length(s/mu) <= rho) then
        call stick(s, back)
      else
        call slip(s, rho, mu, rule, back)
      end if
    else
      call axis_without_friction(s, rho, mu, back)
    end if
  end subroutine return_map

  !> An axis with this coefficient carries friction at all.
  elemental logical function has_friction(mu)
    real(wp), intent(in) :: mu !! principal coefficient

    has_friction = mu > no_friction
  end function has_friction

  !> Inside the cone nothing is mapped.
  pure subroutine stick(s, back)
    real(wp), intent(in) :: s(2) !! trial components [length]
    type(return_t), intent(out) :: back !! the mapped state

    back%s = s
    back%m(1, 1) = 1.0_wp
    back%m(2, 2) = 1.0_wp
  end subroutine stick

  !> An axis with coefficient zero carries nothing; the other is one-dimensional friction. The
  !! trial state is always mapped, so the point slips even where the other axis holds.
  pure subroutine axis_without_friction(s, rho, mu, back)
    real(wp), intent(in) :: s(2) !! trial components [length]
    real(wp), intent(in) :: rho !! -g_N [length]
    real(wp), intent(in) :: mu(2) !! principal coefficients, at least one is zero
    type(return_t), intent(out) :: back !! the mapped state
    integer :: i

    back%slip = .true.
    do i = 1, 2
      if (.not. has_friction(mu(i))) cycle
      if (abs(s(i)) > mu(i)*rho) then
        back%r(i) = sign(mu(i), s(i))
        back%s(i) = back%r(i)*rho
      else
        back%s(i) = s(i)
        back%m(i, i) = 1.0_wp
      end if
    end do
  end subroutine axis_without_friction

  !> s'_i = s_i/(1 + gamma kappa_i) on the cone, kappa_i = (mu_min/mu_i)^m: `back%s = x*s` is eq.
  !! (4.2), and the line behind it takes round-off back to the ellipse.
  !!
  !! M and r are those of eq. (4.3) with q and nu taken per unit of rho, whose powers cancel.
  pure subroutine slip(s, rho, mu, rule, back)
    real(wp), intent(in) :: s(2) !! trial components [length]
    real(wp), intent(in) :: rho !! -g_N [length]
    real(wp), intent(in) :: mu(2) !! principal coefficients, positive
    integer, intent(in) :: rule !! slip rule m
    type(return_t), intent(out) :: back !! the mapped state
    real(wp) :: kappa(2), x(2), q(2), nu(2), gamma, nu_x_q
    integer :: j

    back%slip = .true.
    kappa = 1.0_wp
    if (rule /= 0) kappa = (minval(mu)/mu)**rule
    if (rho <= point_cone*length(s)) then
      back%r = s/kappa
      back%r = back%r/length(back%r/mu)
      back%s = rho*back%r
      return
    end if
    gamma = multiplier(s/(mu*rho), kappa, rule)
    x = 1.0_wp/(1.0_wp + gamma*kappa)
    back%s = x*s
    back%s = back%s*(rho/length(back%s/mu))
    q = kappa*back%s/rho
    nu = back%s/rho/mu**2
    nu_x_q = sum(nu*x*q)
    back%r = x*q/nu_x_q
    do j = 1, 2
      back%m(:, j) = -x*q*(nu(j)*x(j))/nu_x_q
      back%m(j, j) = back%m(j, j) + x(j)
    end do
  end subroutine slip

  !> The gamma for which |sigma_i/(1 + gamma kappa_i)| = 1. Newton on the reciprocal of the norm,
  !! which is concave and increasing: from 0 it climbs to the root without overshooting.
  pure real(wp) function multiplier(sigma, kappa, rule) result(gamma)
    real(wp), intent(in) :: sigma(2) !! trial point over the cone's half axes
    real(wp), intent(in) :: kappa(2) !! (mu_min/mu_i)^m
    integer, intent(in) :: rule !! slip rule m
    real(wp) :: y(2), norm, slope, step
    integer :: i

    gamma = length(sigma) - 1.0_wp
    if (rule == 0) return
    gamma = 0.0_wp
    do i = 1, max_iterations
      y = sigma/(1.0_wp + gamma*kappa)
      norm = length(y)
      slope = sum((y/norm)**2*kappa/(1.0_wp + gamma*kappa))
      step = (norm - 1.0_wp)/slope
      gamma = gamma + step
      if (abs(step) <= multiplier_tolerance*gamma) exit
    end do
  end function multiplier

  !> Slopes of the mapped components by mu1, mu2 and by the rule m (doc/theory, "Derivatives of the
  !! contact element", eq. (14.6): Q and Q_m).
  pure subroutine slope_of_cone(s, rho, mu, rule, back, by_mu, by_rule)
    real(wp), intent(in) :: s(2) !! trial components [length]
    real(wp), intent(in) :: rho !! depth [length]
    real(wp), intent(in) :: mu(2) !! principal coefficients
    integer, intent(in) :: rule !! slip rule m
    type(return_t), intent(in) :: back !! mapped state, slipping
    real(wp), intent(out) :: by_mu(2, 2) !! ds'_i/dmu_j [length]
    real(wp), intent(out) :: by_rule(2) !! ds'/dm [length]
    real(wp) :: kappa(2), x(2), xq(2), nu(2), gamma, nu_xq
    integer :: i, j

    by_mu = 0.0_wp
    by_rule = 0.0_wp
    if (.not. all(has_friction(mu))) then
      do i = 1, 2
        if (has_friction(mu(i)) .and. abs(s(i)) > mu(i)*rho) by_mu(i, i) = sign(rho, s(i))
      end do
      return
    end if
    if (all(abs(back%s) <= 0.0_wp)) return
    kappa = (minval(mu)/mu)**rule
    i = maxloc(abs(back%s)/mu, 1)
    gamma = (s(i)/back%s(i) - 1.0_wp)/kappa(i)
    x = 1.0_wp/(1.0_wp + gamma*kappa)
    xq = x*kappa*back%s
    nu = back%s/mu**2
    nu_xq = sum(nu*xq)
    do j = 1, 2
      by_mu(:, j) = -xq*nu(j)*(real(rule, wp)*gamma*xq(j) - back%s(j))/(mu(j)*nu_xq)
      by_mu(j, j) = by_mu(j, j) + real(rule, wp)*gamma*xq(j)/mu(j)
    end do
    associate (l => log(mu/minval(mu)))
      by_rule = gamma*(l*xq - xq*sum(nu*l*xq)/nu_xq)
    end associate
  end subroutine slope_of_cone
end module friction_return

!> The laws of friction: what the deck can say of each, and the one point where they act.
!!
!! The cone (FRICtion, SLIP) is that of friction_return; the laws here change its coefficients and
!! its radius, in the order of the table. A new law is one file, and one line in each place here
!! that names another (doc/theory, "Decay and cap", eqs. (4.7), (4.8)).
module friction_laws
  use kinds, only: wp
  use law_types, only: friction_law_t, law_state_t, cone_state_t
  use friction_return, only: return_t, return_map, slope_of_cone
  use law_decay, only: decay_law, decay_cone
  use law_cap, only: cap_law, cap_cone
  implicit none
  private
  public :: cone_laws, first_value, n_law_values, law_signature, law_summary, acts, any_acts, &
    keeps_path, hold_path, friction_point, friction_words, slip_path

  !> What may follow FRICtion.
  character(*), parameter :: friction_words = 'NONE | COULomb z:mu | ELLIptic z:mu1 z:mu2'

  !> The laws, in the order in which they act.
  integer, parameter :: decay = 1, cap = 2
  type(friction_law_t), parameter :: cone_laws(2) = [decay_law, cap_law]
  !> Where the values of each begin among those of all, and how many these are.
  integer, parameter :: first_value(3) = [1, 1 + decay_law%count, &
    1 + decay_law%count + cap_law%count]
  integer, parameter :: n_law_values = first_value(3) - 1

  !> What points remember if a law asks for it.
  type(law_state_t), parameter :: slip_path = law_state_t('slip_path', 'length', &
    'path that the point has slipped since its closure')

  !> Relative change of the slip path at which its iteration ends; steps that it never needs.
  real(wp), parameter :: path_tolerance = 4.0_wp*epsilon(1.0_wp)
  integer, parameter :: most_law_steps = 200

contains

  !> What follows the keyword of a law in the deck.
  pure function law_signature(law) result(t)
    type(friction_law_t), intent(in) :: law !! the law
    character(:), allocatable :: t
    integer :: i

    t = ''
    do i = 1, law%count
      t = t//' '//law%parameters(i)%check//':'//trim(law%parameters(i)%name)
    end do
    t = t(2:)
  end function law_signature

  !> What a law is, with the units of its parameters.
  pure function law_summary(law) result(t)
    type(friction_law_t), intent(in) :: law !! the law
    character(:), allocatable :: t
    integer :: i

    t = trim(law%summary)//':'
    do i = 1, law%count
      t = t//' '//trim(law%parameters(i)%name)//' ['//trim(law%parameters(i)%unit)//']'
    end do
  end function law_summary

  !> A pair has asked for a law: one of its values is not 0.
  pure logical function acts(k, values)
    integer, intent(in) :: k !! number of the law
    real(wp), intent(in) :: values(:) !! (n_law_values) values of the pair

    acts = any(values(first_value(k):first_value(k + 1) - 1) > 0.0_wp)
  end function acts

  !> A pair has asked for some law.
  pure logical function any_acts(values)
    real(wp), intent(in) :: values(:) !! (n_law_values) values of the pair

    any_acts = any(values(:n_law_values) > 0.0_wp)
  end function any_acts

  !> A law of the pair asks for the slip path of its points.
  pure logical function keeps_path(values)
    real(wp), intent(in) :: values(:) !! (n_law_values) values of the pair
    integer :: k

    keeps_path = .false.
    do k = 1, size(cone_laws)
      if (cone_laws(k)%keeps_path .and. acts(k, values)) keeps_path = .true.
    end do
  end function keeps_path

  !> Laws that keep the coefficients which a point has after a path, however far it slips on.
  pure subroutine hold_path(path, values, mu)
    real(wp), intent(in) :: path !! its slip path [length]
    real(wp), intent(inout) :: values(:) !! (n_law_values) of the laws
    real(wp), intent(inout) :: mu(2) !! in: static coefficients, out: those after the path
    type(cone_state_t) :: cone

    if (.not. acts(decay, values)) return
    cone%mu = mu
    cone%path = path
    call decay_cone(values(first_value(decay):first_value(decay + 1) - 1), cone)
    mu = cone%mu
    ! what decays over an endless way does not
    values(first_value(decay) + 2) = huge(1.0_wp)
  end subroutine hold_path

  !> Maps the trial components of a point onto its cone. Where coefficients go with the slip path,
  !! that is the one at the end, path = start%path + |s - s'|.
  pure subroutine friction_point(values, start, rule, s, rho, back)
    real(wp), intent(in) :: values(:) !! (n_law_values) of the laws
    type(cone_state_t), intent(in) :: start !! penalty, area, static mu, path at the start
    integer, intent(in) :: rule !! slip rule m
    real(wp), intent(in) :: s(2) !! trial components along the principal axes [length]
    real(wp), intent(in) :: rho !! penetration -g_N, not negative [length]
    type(return_t), intent(out) :: back !! the mapped state and its derivatives
    type(cone_state_t) :: cone

    if (.not. any_acts(values)) then
      call return_map(s, rho, start%mu, rule, back)
      back%mu = start%mu
      back%depth = rho
      return
    end if
    cone = cone_at(values, start, rho, start%path)
    call return_map(s, cone%depth, cone%mu, rule, back)
    if (back%slip .and. keeps_path(values)) then
      call slip_to_end(values, start, rule, s, rho, cone, back)
    else
      back%r = back%r*cone%depth_rho
    end if
    back%mu = cone%mu
    back%depth = cone%depth
    back%path = cone%path
  end subroutine friction_point

  !> The cone after a slip path.
  pure function cone_at(values, start, rho, path) result(cone)
    real(wp), intent(in) :: values(:) !! (n_law_values) of the laws
    type(cone_state_t), intent(in) :: start !! penalty, area, static mu
    real(wp), intent(in) :: rho !! penetration [length]
    real(wp), intent(in) :: path !! the slip path [length]
    type(cone_state_t) :: cone
    integer :: k

    cone = start
    cone%depth = rho
    cone%path = path
    do k = 1, size(cone_laws)
      if (.not. acts(k, values)) cycle
      associate (own => values(first_value(k):first_value(k + 1) - 1))
        if (k == decay) call decay_cone(own, cone)
        if (k == cap) call cap_cone(own, cone)
      end associate
    end do
  end function cone_at

  !> Slip with a path that counts: the root of path - start%path - |s - s'(path)|, by Newton's
  !! method with a bracket; then the derivatives with the path that follows.
  pure subroutine slip_to_end(values, start, rule, s, rho, cone, back)
    real(wp), intent(in) :: values(:) !! (n_law_values) of the laws
    type(cone_state_t), intent(in) :: start !! the point at the start
    integer, intent(in) :: rule !! slip rule m
    real(wp), intent(in) :: s(2) !! trial components [length]
    real(wp), intent(in) :: rho !! penetration [length]
    type(cone_state_t), intent(inout) :: cone !! in: at the start's path, out: at the end's
    type(return_t), intent(inout) :: back !! in: mapped on that cone, out: at the end
    real(wp) :: low, high, way(2), change(2), over, slope, path, row(2)
    integer :: i

    low = start%path
    high = start%path + norm2(s)
    do i = 1, most_law_steps
      call follow_path(s, rule, cone, back, way, change)
      over = cone%path - start%path - norm2(s - back%s)
      slope = 1.0_wp + dot_product(way, change)
      if (over < 0.0_wp) low = cone%path
      if (over >= 0.0_wp) high = cone%path
      path = 0.5_wp*(low + high)
      if (slope > 0.0_wp) then
        if (cone%path - over/slope >= low .and. cone%path - over/slope <= high) path = cone%path &
          - over/slope
      end if
      if (abs(path - cone%path) <= path_tolerance*max(path, norm2(s))) exit
      cone = cone_at(values, start, rho, path)
      call return_map(s, cone%depth, cone%mu, rule, back)
    end do
    back%r = back%r*cone%depth_rho
    if (slope <= 0.0_wp) return
    row = (way - matmul(way, back%m))/slope
    back%m = back%m + spread(change, 2, 2)*spread(row, 1, 2)
    back%r = back%r - change*dot_product(way, back%r)/slope
  end subroutine slip_to_end

  !> The direction of slip, and how the mapped components go with the path.
  pure subroutine follow_path(s, rule, cone, back, way, change)
    real(wp), intent(in) :: s(2) !! trial components [length]
    integer, intent(in) :: rule !! slip rule m
    type(cone_state_t), intent(in) :: cone !! cone at a path
    type(return_t), intent(in) :: back !! components mapped on it
    real(wp), intent(out) :: way(2) !! unit vector of s - s', 0 if there is no slip
    real(wp), intent(out) :: change(2) !! ds'/dpath
    real(wp) :: by_mu(2, 2), by_rule(2)

    way = s - back%s
    if (norm2(way) > 0.0_wp) way = way/norm2(way)
    call slope_of_cone(s, cone%depth, cone%mu, rule, back, by_mu, by_rule)
    change = matmul(by_mu, cone%mu_path) + back%r*cone%depth_path
  end subroutine follow_path
end module friction_laws

!> What the contact elements have in common: the friction cone at its new apex, what becomes of an
!! open point, and how the state of a point is reported (doc/theory, "Facet and gap").
module contact_cone
  use kinds, only: wp
  use element_types, only: element_t, status_open
  use element_parameters, only: d03_epsilon, d03_mu, d03_rule, d03_law, d03_area
  use law_types, only: cone_state_t
  use friction_laws, only: friction_point
  use friction_return, only: return_t, has_friction
  implicit none
  private
  public :: contact_cone_t, leave_open, map_friction, report_point, gap_operator

  !> The gap of a point and the cone that its force lies in.
  type :: contact_cone_t
    real(wp) :: slave(3) !! current position of the slave point [length]
    real(wp) :: xi(2) !! (xi, eta) of its projection
    real(wp) :: g_n !! normal gap [length]
    real(wp) :: g(3) !! gap to the old apex, with the shift [length]
    logical :: shifted !! there is a shift, or an offset
    real(wp) :: kappa(3) !! the shift along t1, t2 and e of the facet [length]
    real(wp) :: t(3, 2) !! t1, t2 of the facet; set if shifted
    real(wp) :: k(3) !! the shift, or its tangential part, in global axes [length]
    real(wp) :: h_n !! normal gap with the shift, what the pressure is made of [length]
    real(wp) :: p(3, 2) !! principal axes of friction
    type(return_t) :: back !! state mapped onto the cone
    real(wp) :: g_new(3) !! gap to the new apex, with the shift [length]
    real(wp) :: apex(2) !! new apex
  end type contact_cone_t

contains

  !> No contact: no force; the apex is the projection.
  pure subroutine leave_open(c, e)
    type(contact_cone_t), intent(inout) :: c !! gap; gets g_new, apex
    type(element_t), intent(inout) :: e !! gets status, h2, slip

    e%status = status_open
    c%g_new = 0.0_wp
    c%apex = c%xi
    e%h2 = c%apex
    e%slip = 0.0_wp
    e%path2 = 0.0_wp
  end subroutine leave_open

  !> A closed point: its trial components mapped onto the cone of its laws.
  pure subroutine map_friction(d, s, c, e)
    real(wp), intent(in) :: d(:) !! parameters, the first as those of element 3
    real(wp), intent(in) :: s(2) !! trial components along the principal axes [length]
    class(contact_cone_t), intent(inout) :: c !! gap; gets back
    type(element_t), intent(inout) :: e !! gets path2

    call friction_point(d(d03_law:d03_area - 1), cone_state_t(epsilon=d(d03_epsilon), &
      area=d(d03_area), path=e%path1, mu=d(d03_mu:d03_mu + 1)), nint(d(d03_rule)), s, -c%h_n, &
      c%back)
    e%path2 = c%back%path
  end subroutine map_friction

  !> The state of the point: stress = [f (3), g_N, elastic slip, criterion, p1 (3), normal (3),
  !! |f_N|, |f_T|].
  pure subroutine report_point(d, c, normal, e)
    real(wp), intent(in) :: d(:) !! parameters, the first as those of element 3
    type(contact_cone_t), intent(in) :: c !! cone at its new apex
    real(wp), intent(in) :: normal(3) !! outward unit normal at the projection
    type(element_t), intent(inout) :: e !! gets stress
    real(wp) :: ratio(2)

    e%stress = 0.0_wp
    e%stress(4) = c%g_n + e%offset
    e%stress(7:9) = c%p(:, 1)
    e%stress(10:12) = normal
    if (e%status == status_open) return
    ratio = 0.0_wp
    where (has_friction(c%back%mu)) ratio = c%back%s/c%back%mu
    e%stress(1:3) = d(d03_epsilon)*c%g_new
    e%stress(5) = norm2(c%back%s)
    e%stress(6) = norm2(ratio) - c%back%depth
    e%stress(13:14) = d(d03_epsilon)*[abs(c%h_n), e%stress(5)]
    if (c%shifted) e%stress(5) = norm2(c%back%s - matmul(c%k, c%p))
  end subroutine report_point

  !> B = [I, -N1 I, -N2 I, -N3 I] at a point of the facet.
  pure function gap_operator(xi) result(b)
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: b(3, 12)
    integer :: k

    b = 0.0_wp
    do k = 1, 3
      b(k, k) = 1.0_wp
      b(k, 3 + k) = -xi(1)
      b(k, 6 + k) = -xi(2)
      b(k, 9 + k) = -(1.0_wp - xi(1) - xi(2))
    end do
  end function gap_operator
end module contact_cone

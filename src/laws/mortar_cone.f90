!> The cone of a multiplier: its projection, and the derivative of that (doc/theory, "Mortar
!! contact", eq. (7.16)).
module mortar_cone
  use kinds, only: wp
  use law_types, only: cone_state_t
  use friction_laws, only: friction_point, n_law_values
  use friction_return, only: return_t
  implicit none
  private
  public :: cone_of_node_t, project_on_cone

  !> The cone of one multiplier.
  type :: cone_of_node_t
    real(wp) :: mu(2) = 0.0_wp !! principal coefficients
    real(wp) :: law(n_law_values) = 0.0_wp !! values of the laws that change the cone
    integer :: rule = 0 !! slip rule m
    real(wp) :: area = 0.0_wp !! weight of the multiplier [length^2]
    real(wp) :: path = 0.0_wp !! way slipped at the last converged state [length]
    real(wp) :: scale(2) = 1.0_wp !! forces over slip and over gap, r_t and r_n [force/length]
  end type cone_of_node_t

contains

  !> Pi(y) and its derivative. Laws know lengths: forces are handed to them over r_t, the penalty
  !! of the point.
  pure subroutine project_on_cone(cone, y, force, slope, slips, criterion)
    type(cone_of_node_t), intent(in) :: cone !! the cone
    real(wp), intent(in) :: y(3) !! trial force along p1, p2 and the normal [force]
    real(wp), intent(out) :: force(3) !! Pi [force]
    real(wp), intent(out) :: slope(3, 3) !! dPi/dy
    logical, intent(out) :: slips !! the trial force lies outside the cone
    real(wp), intent(out) :: criterion !! of Pi: how far outside its cone it lies [force]
    type(return_t) :: back
    type(cone_state_t) :: start

    force = 0.0_wp
    slope = 0.0_wp
    slips = .false.
    criterion = 0.0_wp
    if (y(3) < 0.0_wp) return
    start%epsilon = cone%scale(1)
    start%area = cone%area
    start%path = cone%path
    start%mu = cone%mu
    call friction_point(cone%law, start, cone%rule, y(1:2)/cone%scale(1), y(3)/cone%scale(1), back)
    force = [cone%scale(1)*back%s, y(3)]
    slope(1:2, 1:2) = back%m
    slope(1:2, 3) = back%r
    slope(3, 3) = 1.0_wp
    slips = back%slip
    if (all(back%mu > 0.0_wp)) criterion = cone%scale(1)*(norm2(back%s/back%mu) - back%depth)
  end subroutine project_on_cone
end module mortar_cone

!> CAP: the shear traction has a bound (doc/theory, "Decay and cap", eq. (4.6)).
!!
!! The pressure that counts for friction is at most tau/max(mu1, mu2): the cone becomes a cylinder.
module law_cap
  use kinds, only: wp
  use law_types, only: friction_law_t, law_parameter_t, cone_state_t
  implicit none
  private
  public :: cap_law, cap_cone

  type(friction_law_t), parameter :: cap_law = friction_law_t('CAP', 'largest shear traction', 1, &
    [law_parameter_t('tau', 'force/length^2', 'q'), law_parameter_t(), law_parameter_t()], &
    keeps_path=.false., needs_area=.true.)

contains

  !> Bounds the depth of the cone.
  pure subroutine cap_cone(values, cone)
    real(wp), intent(in) :: values(:) !! tau
    type(cone_state_t), intent(inout) :: cone !! its depth may get smaller
    real(wp) :: bound
    integer :: k

    k = maxloc(cone%mu, 1)
    if (cone%depth*cone%mu(k)*cone%epsilon <= values(1)*cone%area) return
    bound = values(1)*cone%area/(cone%epsilon*cone%mu(k))
    cone%depth = bound
    cone%depth_rho = 0.0_wp
    cone%depth_path = -bound*cone%mu_path(k)/cone%mu(k)
  end subroutine cap_cone
end module law_cap

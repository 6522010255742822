!> DECAy: static coefficients give way to kinetic ones as a point slips (doc/theory, "Decay and
!! cap", eq. (4.5)).
!!
!! mu = mk + (mu_static - mk) exp(-path/length), with the path at the end of the increment.
module law_decay
  use kinds, only: wp
  use law_types, only: friction_law_t, law_parameter_t, cone_state_t
  use friction_return, only: has_friction
  implicit none
  private
  public :: decay_law, decay_cone

  type(friction_law_t), parameter :: decay_law = friction_law_t('DECAy', 'kinetic coefficients', &
    3, [law_parameter_t('mk1', '1', 'z'), law_parameter_t('mk2', '1', 'z'), &
        law_parameter_t('length', 'length', 'q')], keeps_path=.true., needs_area=.false.)

contains

  !> The coefficients after the path that the point has slipped; an axis without a static one
  !! keeps none.
  pure subroutine decay_cone(values, cone)
    real(wp), intent(in) :: values(:) !! mk1, mk2, length
    type(cone_state_t), intent(inout) :: cone !! mu: in: static, out: at its path
    real(wp) :: rest(2)

    rest = 0.0_wp
    where (has_friction(cone%mu)) rest = (cone%mu - values(1:2))*exp(-cone%path/values(3))
    where (has_friction(cone%mu)) cone%mu = values(1:2) + rest
    cone%mu_path = -rest/values(3)
  end subroutine decay_cone
end module law_decay

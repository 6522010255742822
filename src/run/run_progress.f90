!> Where a run stands between two solution commands.
module run_progress
  use kinds, only: wp
  use newton_settings, only: settings_t
  use newton, only: newton_t
  use augmentation, only: augmentation_t
  use batch_position, only: position_t
  use saved_states, only: saved_states_t
  implicit none
  private
  public :: run_state_t

  !> Where a run stands between two commands.
  type :: run_state_t
    real(wp) :: increment = 0.0_wp !! DT
    type(position_t) :: position !! end times so far
    type(saved_states_t) :: states !! where SAVE and REST keep theirs
    type(settings_t) :: settings !! TOL
    type(newton_t) :: progress !! of the pending increment
    type(augmentation_t) :: augmentation !! its multipliers
    logical :: pending = .false. !! TANG has begun an increment that is not accepted yet
    logical :: converged = .false. !! it has converged
    logical :: started = .false. !! its first solve has been prepared
    real(wp) :: pending_time = 0.0_wp !! its end time
    logical :: goes_on = .false. !! the batch has end times: what is solved at time 0 is none
  end type run_state_t
end module run_progress

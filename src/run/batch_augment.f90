!> AUGMent: one update of the multipliers of a pending increment.
module batch_augment
  use model_types, only: model_t
  use system_types, only: form_t, system_t
  use contact_system, only: load_contact
  use augmentation, only: check_gaps, update_multipliers
  use point_status, only: hold_sticking
  use residuals, only: form_residual
  use batch_position, only: is_passing
  use run_progress, only: run_state_t
  use run_monitor, only: run_monitor_t
  implicit none
  private
  public :: run_augment

contains

  !> Makes the present contact forces the multipliers; the increment has then to be solved again.
  !! Where it has converged and its gaps are closed, all stays as it is.
  subroutine run_augment(run, model, system, form, monitor)
    type(run_state_t), intent(inout) :: run !! the pending increment
    type(model_t), intent(inout) :: model !! pairs: multipliers
    type(system_t), intent(inout) :: system !! contact elements
    type(form_t), intent(inout) :: form !! its kind answers
    type(run_monitor_t), intent(inout) :: monitor !! hears of it

    if (.not. (run%pending .and. run%started) .or. is_passing(run%position)) return
    call check_gaps(model, system, run%augmentation, monitor)
    if (run%converged .and. run%augmentation%closed) return
    call hold_sticking(system%contact)
    call update_multipliers(model, system, run%augmentation, monitor)
    call load_contact(model, system)
    call form%kind%couple(system, form)
    call form_residual(system, form, model%mesh%x)
    run%progress%updated = .true.
    run%converged = .false.
  end subroutine run_augment
end module batch_augment

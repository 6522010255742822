!> Which form the equations of a system have.
module form_choice
  use full_form, only: full_form_of_system
  use reused_form, only: reused_form_of_system
  use condensed_form, only: condensed_form_of_system
  use condensed_bodies, only: free_condensed
  use system_types, only: form_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: take_form, take_full_form

contains

  !> The form that the factors at hand are for.
  subroutine take_form(form, condensed)
    type(form_t), allocatable, intent(inout) :: form !! filled
    type(condensed_t), intent(in) :: condensed !! which of its uses is on

    if (condensed%active) then
      form = condensed_form_of_system()
    else if (condensed%preconditions) then
      form = reused_form_of_system()
    else
      form = full_form_of_system()
    end if
  end subroutine take_form

  !> The full form; factors of condensed bodies are forgotten.
  subroutine take_full_form(form, condensed)
    type(form_t), allocatable, intent(inout) :: form !! filled
    type(condensed_t), intent(inout) :: condensed !! is not in use

    call free_condensed(condensed)
    form = full_form_of_system()
  end subroutine take_full_form
end module form_choice

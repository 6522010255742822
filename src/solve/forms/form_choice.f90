!> Which form the equations of a system have.
module form_choice
  use full_form, only: full_form_of_system
  use reused_form, only: reused_form_of_system
  use condensed_form, only: condensed_form_of_system
  use condensed_bodies, only: free_condensed
  use system_types, only: form_t
  implicit none
  private
  public :: take_form, take_full_form

contains

  !> The form that the factors at hand are for.
  subroutine take_form(form)
    type(form_t), intent(inout) :: form !! condensed says which of its uses is on; gets its kind

    if (form%condensed%active) then
      form%kind = condensed_form_of_system()
    else if (form%condensed%preconditions) then
      form%kind = reused_form_of_system()
    else
      form%kind = full_form_of_system()
    end if
  end subroutine take_form

  !> The full form; factors of condensed bodies are forgotten.
  subroutine take_full_form(form)
    type(form_t), intent(inout) :: form !! gets its kind

    call free_condensed(form%condensed)
    form%kind = full_form_of_system()
  end subroutine take_full_form
end module form_choice

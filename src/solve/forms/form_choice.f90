!> Which form the equations of a system have.
module form_choice
  use full_form, only: full_form_of_system
  use reused_form, only: reused_form_of_system
  use condensed_form, only: condensed_form_of_system
  use condensed_bodies, only: free_condensed
  use system_types, only: system_t
  implicit none
  private
  public :: take_form, take_full_form

contains

  !> The form that the factors at hand are for.
  subroutine take_form(system)
    type(system_t), intent(inout) :: system !! gets form

    if (system%condensed%active) then
      system%form = condensed_form_of_system()
    else if (system%condensed%preconditions) then
      system%form = reused_form_of_system()
    else
      system%form = full_form_of_system()
    end if
  end subroutine take_form

  !> The full form; factors of condensed bodies are forgotten.
  subroutine take_full_form(system)
    type(system_t), intent(inout) :: system !! gets form

    call free_condensed(system)
    system%form = full_form_of_system()
  end subroutine take_full_form
end module form_choice

!> The element library: the number of an element routine leads to the routine.
!!
!! A new element is one file, its number in element_types and one line here.
module elmlib
  use kinds, only: wp
  use element_types, only: element_t, routine_t4, routine_small, routine_mfec, routine_smooth, &
    routine_finite, routine_quadratic, routine_round
  use solid_types, only: solid_t
  use elmt01, only: elmt01_t4
  use elmt02, only: elmt02_small
  use elmt03, only: elmt03_mfec
  use elmt04, only: elmt04_smooth
  use elmt05, only: elmt05_finite
  use elmt06, only: elmt06_quadratic
  use quadratic_facet, only: facet_of_routine
  implicit none
  private
  public :: element_routine, solid_routine

contains

  !> Calls the routine of a contact element.
  pure subroutine element_routine(number, task, d, e)
    integer, intent(in) :: number !! which routine
    integer, intent(in) :: task !! what it is to do (element_types)
    real(wp), intent(in) :: d(:) !! its parameters
    type(element_t), intent(inout) :: e !! local data

    select case (number)
    case (routine_mfec)
      call elmt03_mfec(task, d, e)
    case (routine_smooth)
      call elmt04_smooth(task, d, e)
    case (routine_quadratic, routine_round)
      call elmt06_quadratic(task, facet_of_routine(number), d, e)
    case default
      ! routine_none: a contact element that is switched off adds nothing.
    end select
  end subroutine element_routine

  !> Calls the routine of a bulk element.
  pure subroutine solid_routine(number, task, d, e)
    integer, intent(in) :: number !! which routine
    integer, intent(in) :: task !! what it is to do (element_types)
    real(wp), intent(in) :: d(:) !! its parameters (solid_types)
    type(solid_t), intent(inout) :: e !! local data

    select case (number)
    case (routine_t4)
      call elmt01_t4(task, d, e)
    case (routine_small)
      call elmt02_small(task, d, e)
    case (routine_finite)
      call elmt05_finite(task, d, e)
    case default
      ! routine_none: an element of a rigid region.
    end select
  end subroutine solid_routine
end module elmlib

!> What Newton's method asks of elements, surfaces and multipliers.
module term_choice
  use assembly, only: contact_forces
  use bulk_term, only: bulk_step
  use multiplier_motion, only: add_multipliers, multipliers_fit
  use surface_shapes, only: bend_surfaces
  use system_types, only: terms_t
  implicit none
  private
  public :: terms_of_system

contains

  !> The procedures that know the elements.
  function terms_of_system() result(terms)
    type(terms_t) :: terms

    terms%contact_forces => contact_forces
    terms%step_share => bulk_step
    terms%bend_surfaces => bend_surfaces
    terms%add_multipliers => add_multipliers
    terms%multipliers_fit => multipliers_fit
  end function terms_of_system
end module term_choice

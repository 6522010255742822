!> What an increment knows of points whose friction softens.
module softening_state
  use kinds, only: wp
  implicit none
  private
  public :: softening_t

  !> Of one pair. Its places are its points, or its slave facets if it is segmented.
  type :: softening_t
    logical, allocatable :: follows(:) !! (places) coefficients follow the slip
    real(wp), allocatable :: ahead(:) !! (places) else: those after so much slip [length]
    integer :: passes = 0 !! how often `ahead` has grown
  end type softening_t
end module softening_state

!> Bodies that contact alone holds and that lean on each other (doc/theory, "Floating bodies").
module piles
  use system_types, only: system_t
  implicit none
  private
  public :: is_pile

  !> So many bodies that contact alone holds make a pile.
  integer, parameter :: many_bodies = 3

contains

  !> Bodies that contact alone holds lean on each other: their multipliers rest first, as these lead
  !! each other astray far from the solution, and their increments take many solves.
  pure logical function is_pile(system) result(pile)
    type(system_t), intent(in) :: system !! bodies

    pile = count(system%body%weak) >= many_bodies
  end function is_pile
end module piles

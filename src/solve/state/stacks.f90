!> Bodies that contact alone holds and that lean on each other (doc/theory, "Floating bodies").
module stacks
  use system_parts, only: bodies_t
  implicit none
  private
  public :: is_stack

  !> So many bodies that contact alone holds make a stack.
  integer, parameter :: many_bodies = 3

contains

  !> Bodies that contact alone holds lean on each other: their multipliers rest first, as these lead
  !! each other astray far from the solution, and their increments take many solves.
  pure logical function is_stack(body) result(stack)
    type(bodies_t), intent(in) :: body !! bodies

    stack = count(body%floating) >= many_bodies
  end function is_stack
end module stacks

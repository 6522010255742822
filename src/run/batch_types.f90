!> What the solution commands of a deck are once they have been checked.
module batch_types
  use kinds, only: wp
  use deck_types, only: location_t
  implicit none
  private
  public :: batch_command_t

  !> One solution command: `command,option,v1,v2,v3`.
  type :: batch_command_t
    character(4) :: command = '' !! first four letters, lower case
    character(4) :: option = '' !! first four letters, lower case; blank for none
    character(:), allocatable :: text !! the option as written
    real(wp) :: v(3) = 0.0_wp !! its values, 0 where not given
    type(location_t) :: at !! where it stands
    logical :: solves = .false. !! TANG, SOLV: one Newton iteration
    integer :: partner = 0 !! LOOP: index of its NEXT; NEXT: index of its LOOP
  end type batch_command_t
end module batch_types

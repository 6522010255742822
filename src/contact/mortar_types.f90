!> Multipliers at the slave nodes of a pair: what they are weighed with, and what they remember
!! (doc/theory, "Mortar contact").
module mortar_types
  use kinds, only: wp
  use element_types, only: status_open
  implicit none
  private
  public :: mortar_t, same_multiplier, turned_way

  !> The multipliers of a pair, one for each slave node and face of the master over it.
  type :: mortar_t
    integer :: n = 0 !! how many
    integer, allocatable :: node(:) !! (n) slave node
    integer, allocatable :: face(:) !! (n) face of the master
    real(wp), allocatable :: weight(:) !! (n) W [length^2]
    real(wp), allocatable :: offset(:) !! (n) what is added to the normal gap [length]
    real(wp), allocatable :: frame(:, :, :) !! (3, 3, n) p1, p2 and the normal
    integer, allocatable :: first(:) !! (n+1) where the row of each begins
    integer, allocatable :: column(:) !! nodes of the rows
    real(wp), allocatable :: now(:) !! weights S and -P there
    real(wp), allocatable :: before(:) !! the same at the places of the last converged state
    real(wp), allocatable :: from(:, :) !! (3, n) slip counts from this mean of places: of the last
    !! converged state, of the free way, and of the pass without friction
    logical, allocatable :: waits(:) !! (n) no friction yet: it was open at the last converged state
    integer, allocatable :: owner(:, :) !! (3, points) multipliers that act at each point, 0: none
    real(wp), allocatable :: share(:, :) !! (3, points) share of their forces
    real(wp), allocatable :: force(:, :) !! (3, n) z, in space [force]
    integer, allocatable :: status(:) !! (n) as of a contact point
    real(wp), allocatable :: gap(:, :) !! (3, n) weighted gap and slip, along the frame [length]
    real(wp), allocatable :: criterion(:) !! (n) distance from the cone [force]
    real(wp), allocatable :: path(:) !! (n) way slipped since the touch [length]
    real(wp), allocatable :: way(:, :) !! (3, n) the same with its directions [length]
    real(wp), allocatable :: dissipation(:) !! (n) work of friction so far [force length]
  end type mortar_t

contains

  !> The place of a multiplier among those of another state, 0 if it was none of them.
  pure integer function same_multiplier(old, node, face) result(i)
    type(mortar_t), intent(in) :: old !! the other state
    integer, intent(in) :: node !! slave node
    integer, intent(in) :: face !! face of the master

    do i = 1, old%n
      if (old%node(i) == node .and. old%face(i) == face) return
    end do
    i = 0
  end function same_multiplier

  !> What was left between a closed multiplier and its mean place on the master, turned with its
  !! frame, eq. (7.15).
  pure function turned_way(old, nodes, i, way) result(turned)
    type(mortar_t), intent(in) :: old !! last converged state
    type(mortar_t), intent(in) :: nodes !! multipliers as they are
    integer, intent(in) :: i !! one of them
    real(wp), intent(in) :: way(3) !! as it was [length]
    real(wp) :: turned(3)
    integer :: j

    turned = way
    j = same_multiplier(old, nodes%node(i), nodes%face(i))
    if (j == 0) return
    if (old%status(j) > status_open) turned = matmul(nodes%frame(:, :, i), matmul(way, &
      old%frame(:, :, j)))
  end function turned_way
end module mortar_types

!> Multipliers at the slave nodes of a pair: what they are weighed with, and what they remember
!! (doc/theory, "Mortar contact").
module mortar_types
  use kinds, only: wp
  use vectors, only: cross
  use element_types, only: status_open
  implicit none
  private
  public :: mortar_t, multiplier_t, same_multiplier, kept_multipliers, multipliers_of, turned_way

  !> The multipliers of a pair, one for each slave node and face of the master over it.
  type :: mortar_t
    integer :: n = 0 !! how many
    integer, allocatable :: node(:) !! (n) slave node
    integer, allocatable :: face(:) !! (n) face of the master
    real(wp), allocatable :: weight(:) !! (n) W [length^2]
    real(wp), allocatable :: offset(:) !! (n) what is added to the normal gap [length]
    real(wp), allocatable :: compliance(:) !! (n) of a penalty, 0 without [length/force]
    real(wp), allocatable :: frame(:, :, :) !! (3, 3, n) p1, p2 and the normal
    integer, allocatable :: first(:) !! (n+1) where the row of each begins
    integer, allocatable :: column(:) !! nodes of the rows
    real(wp), allocatable :: now(:) !! weights S and -P there
    real(wp), allocatable :: before(:) !! the same at the places of the last converged state
    real(wp), allocatable :: from(:, :) !! (3, n) slip counts from this mean of places: of the last
    !! converged state, of the free way, and of the pass without friction
    logical, allocatable :: new(:) !! (n) open at the last converged state
    logical, allocatable :: waits(:) !! (n) these: no friction yet
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

  !> What of a multiplier outlives its increment.
  type :: multiplier_t
    integer :: node = 0 !! slave node, 0: there is none
    integer :: face = 0 !! face of the master
    integer :: status = 0 !! as of a contact point
    real(wp) :: axis(3) = 0.0_wp !! p1 of its frame
    real(wp) :: normal(3) = 0.0_wp !! n of its frame
    real(wp) :: force(3) = 0.0_wp !! z, in space [force]
    real(wp) :: path = 0.0_wp !! way slipped since the touch [length]
    real(wp) :: way(3) = 0.0_wp !! the same with its directions [length]
    real(wp) :: dissipation = 0.0_wp !! work of friction so far [force length]
  end type multiplier_t

contains

  !> The multipliers of a converged state as a list of fixed length. A facet with multipliers has
  !! cells of three points at least, so that there is room for all in as many places as points.
  pure function kept_multipliers(nodes, places) result(list)
    type(mortar_t), intent(in) :: nodes !! converged; none yet before the first state
    integer, intent(in) :: places !! length of the list
    type(multiplier_t) :: list(places)
    integer :: i

    do i = 1, nodes%n
      list(i) = multiplier_t(nodes%node(i), nodes%face(i), nodes%status(i), nodes%frame(:, 1, i), &
        nodes%frame(:, 3, i), nodes%force(:, i), nodes%path(i), nodes%way(:, i), &
        nodes%dissipation(i))
    end do
  end function kept_multipliers

  !> The other way round: multipliers without weights.
  pure function multipliers_of(list) result(nodes)
    type(multiplier_t), intent(in) :: list(:) !! multipliers, then places without one
    type(mortar_t) :: nodes
    integer :: i

    nodes%n = count(list%node > 0)
    nodes%node = list(:nodes%n)%node
    nodes%face = list(:nodes%n)%face
    nodes%status = list(:nodes%n)%status
    nodes%path = list(:nodes%n)%path
    nodes%dissipation = list(:nodes%n)%dissipation
    allocate (nodes%force(3, nodes%n), nodes%way(3, nodes%n), nodes%frame(3, 3, nodes%n))
    do i = 1, nodes%n
      nodes%force(:, i) = list(i)%force
      nodes%way(:, i) = list(i)%way
      nodes%frame(:, 1, i) = list(i)%axis
      nodes%frame(:, 2, i) = cross(list(i)%normal, list(i)%axis)
      nodes%frame(:, 3, i) = list(i)%normal
    end do
  end function multipliers_of

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

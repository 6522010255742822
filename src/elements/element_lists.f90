!> A list of elements: what the assembly loop runs over, bulk and contact alike.
module element_lists
  use kinds, only: wp
  use element_types, only: max_nodes, n_element_history
  use elmlib, only: n_parameters, routine_none
  implicit none
  private
  public :: element_list_t, allocate_list

  !> Elements with their routine, nodes, parameters and history.
  type :: element_list_t
    integer :: n = 0 !! number of elements
    integer, allocatable :: routine(:) !! (n) number in elmlib, routine_none to skip
    integer, allocatable :: nel(:) !! (n) nodes of the element
    integer, allocatable :: ix(:, :) !! (max_nodes, n) node numbers
    integer, allocatable :: set(:) !! (n) column of d
    real(wp), allocatable :: d(:, :) !! (n_parameters, sets) parameters
    real(wp), allocatable :: h1(:, :) !! (n_element_history, n) history, last converged
    real(wp), allocatable :: h2(:, :) !! (n_element_history, n) history, current
    real(wp), allocatable :: shift(:, :) !! (3, n) shift of the gap of contact elements [length]
    integer, allocatable :: status(:) !! (n) status of contact elements
    real(wp), allocatable :: slip(:, :) !! (3, n) tangential gap of contact elements [length]
    real(wp), allocatable :: slip_before(:, :) !! (3, n) the same one iteration before [length]
    logical, allocatable :: hold(:) !! (n) contact elements that stick in the next tangent
    integer, allocatable :: block(:, :, :) !! (max_nodes, max_nodes, n) places in a block matrix
  end type element_list_t

contains

  !> Allocates a list of n elements that take no part.
  pure subroutine allocate_list(list, n, sets)
    type(element_list_t), intent(out) :: list !! the list
    integer, intent(in) :: n !! number of elements
    integer, intent(in) :: sets !! number of parameter sets

    list%n = n
    allocate (list%routine(n), list%nel(n), list%set(n), list%status(n), source=0)
    list%routine = routine_none
    allocate (list%ix(max_nodes, n), source=0)
    allocate (list%d(n_parameters, sets), source=0.0_wp)
    allocate (list%h1(n_element_history, n), list%h2(n_element_history, n), source=0.0_wp)
    allocate (list%shift(3, n), list%slip(3, n), list%slip_before(3, n), source=0.0_wp)
    allocate (list%hold(n), source=.false.)
    allocate (list%block(max_nodes, max_nodes, n), source=0)
  end subroutine allocate_list
end module element_lists

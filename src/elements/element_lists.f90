!> A list of elements: what the assembly loop runs over, bulk and contact alike.
module element_lists
  use kinds, only: wp
  use element_types, only: max_slaves, n_element_history
  use elmlib, only: n_parameters, routine_none
  implicit none
  private
  public :: element_list_t, allocate_list, slave_point, master_nodes, side_nodes

  !> Elements with their routine, nodes, parameters and history.
  type :: element_list_t
    integer :: n = 0 !! number of elements
    integer, allocatable :: routine(:) !! (n) number in elmlib, routine_none to skip
    integer, allocatable :: nel(:) !! (n) nodes of the element
    integer, allocatable :: slaves(:) !! (n) of a contact element: its first nodes, the slaves
    integer, allocatable :: ix(:, :) !! (most nodes, n) node numbers
    real(wp), allocatable :: weight(:, :) !! (max_slaves, n) of the slaves, in lists that have it
    integer, allocatable :: set(:) !! (n) column of d
    real(wp), allocatable :: d(:, :) !! (n_parameters, sets) parameters
    real(wp), allocatable :: h1(:, :) !! (n_element_history, n) history, last converged
    real(wp), allocatable :: h2(:, :) !! (n_element_history, n) history, current
    real(wp), allocatable :: shift(:, :) !! (3, n) shift of the gap of contact elements [length]
    integer, allocatable :: status(:) !! (n) status of contact elements
    real(wp), allocatable :: slip(:, :) !! (3, n) tangential gap of contact elements [length]
    real(wp), allocatable :: slip_before(:, :) !! (3, n) the same one iteration before [length]
    logical, allocatable :: hold(:) !! (n) contact elements that stick in the next tangent
    logical, allocatable :: slide(:) !! (n) those that slip in it if they are on their cone
    real(wp), allocatable :: keep(:) !! (n) shift that makes open ones closed in it, or 0 [length]
    real(wp) :: asymmetry = 0.0_wp !! largest |s - s^T|/|s| of the last tangents
    integer, allocatable :: block(:, :, :) !! (most nodes, most nodes, n) places in a block matrix
  end type element_list_t

  !> Nodes of the elements of a list where nothing else is said.
  integer, parameter :: usual_nodes = 4

contains

  !> Allocates a list of n elements that take no part.
  pure subroutine allocate_list(list, n, sets, nodes)
    type(element_list_t), intent(out) :: list !! the list
    integer, intent(in) :: n !! number of elements
    integer, intent(in) :: sets !! number of parameter sets
    integer, intent(in), optional :: nodes !! most nodes of an element, else 4
    integer :: most

    most = usual_nodes
    if (present(nodes)) most = nodes
    list%n = n
    allocate (list%routine(n), list%nel(n), list%set(n), list%status(n), source=0)
    list%routine = routine_none
    allocate (list%slaves(n), source=1)
    allocate (list%ix(most, n), source=0)
    if (most > usual_nodes) allocate (list%weight(max_slaves, n), source=0.0_wp)
    allocate (list%d(n_parameters, sets), source=0.0_wp)
    allocate (list%h1(n_element_history, n), list%h2(n_element_history, n), source=0.0_wp)
    allocate (list%shift(3, n), list%slip(3, n), list%slip_before(3, n), source=0.0_wp)
    allocate (list%hold(n), list%slide(n), source=.false.)
    allocate (list%keep(n), source=0.0_wp)
    allocate (list%block(most, most, n), source=0)
  end subroutine allocate_list

  !> The slave point of a contact element: x_S = sum M_b x_b.
  pure function slave_point(list, k, x) result(y)
    type(element_list_t), intent(in) :: list !! contact elements
    integer, intent(in) :: k !! the element
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions, or any field [length]
    real(wp) :: y(3)
    integer :: b

    if (list%slaves(k) == 1) then
      y = x(:, list%ix(1, k))
      return
    end if
    y = 0.0_wp
    do b = 1, list%slaves(k)
      y = y + list%weight(b, k)*x(:, list%ix(b, k))
    end do
  end function slave_point

  !> The corners of the master facet of a contact element.
  pure function master_nodes(list, k) result(nodes)
    type(element_list_t), intent(in) :: list !! contact elements
    integer, intent(in) :: k !! the element
    integer :: nodes(3)

    nodes = list%ix(list%slaves(k) + 1:list%slaves(k) + 3, k)
  end function master_nodes

  !> One node of the slave side of a contact element and one of its master side: they tell the
  !! bodies that it joins.
  pure function side_nodes(list, k) result(nodes)
    type(element_list_t), intent(in) :: list !! contact elements
    integer, intent(in) :: k !! the element
    integer :: nodes(2)

    nodes = list%ix([1, list%slaves(k) + 1], k)
  end function side_nodes
end module element_lists

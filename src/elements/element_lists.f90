!> Lists of elements: what the assembly loops run over.
module element_lists
  use kinds, only: wp
  use threads, only: worth_threads
  use element_types, only: max_slaves, n_element_history, routine_none
  use law_types, only: point_law_t
  use solid_types, only: n_solid_parameters
  use element_parameters, only: n_parameters
  implicit none
  private
  public :: node_list_t, bulk_list_t, volume_list_t, element_list_t, allocate_bulk, &
    allocate_list, slave_point, master_nodes, side_nodes, batch_size, threads_of

  !> Elements that are computed together before they are added up, in their order whatever the
  !! number of threads: so few that they stay in the processor's first store.
  integer, parameter :: small_batch = 16
  !> The same with several threads, which are called together for each batch.
  integer, parameter :: large_batch = 1024
  !> An element takes as long as so many multiplications and additions, at least.
  real(wp), parameter :: of_element = 1200.0_wp

  !> Elements with their routine and nodes: what the graph of a matrix asks for.
  type :: node_list_t
    integer :: n = 0 !! number of elements
    integer, allocatable :: routine(:) !! (n) number in elmlib, routine_none to skip
    integer, allocatable :: nel(:) !! (n) nodes of the element
    integer, allocatable :: ix(:, :) !! (most nodes, n) node numbers
    integer, allocatable :: block(:, :, :) !! (most nodes, most nodes, n) places in a block matrix
  end type node_list_t

  !> Bulk elements.
  type, extends(node_list_t) :: bulk_list_t
    logical :: linear = .true. !! forces are the tangent times displacements, and it never changes
    integer, allocatable :: set(:) !! (n) column of d
    real(wp), allocatable :: d(:, :) !! (n_solid_parameters, sets) parameters
    type(point_law_t), allocatable :: law(:) !! (sets) their laws
    real(wp), allocatable :: memory(:, :, :) !! (n_state, points, n) what the points of the elements
    !! remember of the last converged state, if some law asks for it
  end type bulk_list_t

  !> Volumes of nodes (nodal_dilatation), one for each node and material; as elements they have the
  !! nodes of all elements around.
  type, extends(node_list_t) :: volume_list_t
    integer, allocatable :: set(:) !! (n) index of the material
    real(wp), allocatable :: size(:) !! (n) reference volume [length^3]
    integer, allocatable :: corner(:, :) !! (4, elements) volumes at its nodes, 0 without
    integer, allocatable :: place(:, :, :) !! (4, 4, elements) places of its nodes in those of each
    real(wp), allocatable :: lambda(:) !! (materials) Lame's first constant [force/length^2]
    logical, allocatable :: finite(:) !! (materials) strain is finite
  end type volume_list_t

  !> Contact elements, each with parameters and history of its own.
  type, extends(node_list_t) :: element_list_t
    integer, allocatable :: slaves(:) !! (n) its first nodes, the slaves
    real(wp), allocatable :: weight(:, :) !! (most slaves, n) of the slaves, in lists that have it
    real(wp), allocatable :: lift(:) !! (n) height of S over its slave facet, likewise [length]
    real(wp), allocatable :: d(:, :) !! (n_parameters, n) parameters
    real(wp), allocatable :: h1(:, :) !! (n_element_history, n) history, last converged
    real(wp), allocatable :: h2(:, :) !! (n_element_history, n) history, current
    real(wp), allocatable :: path1(:) !! (n) slip path, last converged [length]
    real(wp), allocatable :: path2(:) !! (n) the same, current [length]
    real(wp), allocatable :: shift(:, :) !! (3, n) shift of the gap [length]
    real(wp), allocatable :: offset(:) !! (n) what is added to the normal gap [length]
    integer, allocatable :: status(:) !! (n) status
    real(wp), allocatable :: slip(:, :) !! (3, n) tangential gap [length]
    real(wp), allocatable :: slip_before(:, :) !! (3, n) the same one iteration before [length]
    logical, allocatable :: hold(:) !! (n) elements that stick in the next tangent
    logical, allocatable :: slide(:) !! (n) those that slip in it if they are on their cone
    real(wp), allocatable :: keep(:) !! (n) shift to the gap that is expected in it [length]
    integer, allocatable :: reached(:) !! nodes that the last forces act at, if that is known
  end type element_list_t

contains

  !> Elements of a list that are computed together.
  integer function batch_size(n) result(batch)
    integer, intent(in) :: n !! elements of the list

    batch = small_batch
    if (threads_of(n) > 1) batch = large_batch
    batch = min(batch, max(1, n))
  end function batch_size

  !> Threads that the elements of a list are worth.
  integer function threads_of(n) result(threads)
    integer, intent(in) :: n !! elements of the list

    threads = worth_threads(of_element*real(n, wp))
  end function threads_of

  !> Allocates what all lists have, for n elements that take no part.
  pure subroutine allocate_nodes(list, n, most)
    class(node_list_t), intent(inout) :: list !! the list
    integer, intent(in) :: n !! number of elements
    integer, intent(in) :: most !! most nodes of an element

    list%n = n
    allocate (list%routine(n), source=routine_none)
    allocate (list%nel(n), source=0)
    allocate (list%ix(most, n), source=0)
  end subroutine allocate_nodes

  !> Allocates a list of n bulk elements that take no part.
  pure subroutine allocate_bulk(list, n, sets, most)
    type(bulk_list_t), intent(out) :: list !! the list
    integer, intent(in) :: n !! number of elements
    integer, intent(in) :: sets !! number of parameter sets
    integer, intent(in) :: most !! most nodes of an element

    call allocate_nodes(list, n, most)
    allocate (list%set(n), source=0)
    allocate (list%d(n_solid_parameters, sets), source=0.0_wp)
    allocate (list%law(sets))
  end subroutine allocate_bulk

  !> Allocates a list of n contact elements that take no part.
  pure subroutine allocate_list(list, n, most)
    type(element_list_t), intent(out) :: list !! the list
    integer, intent(in) :: n !! number of elements
    integer, intent(in) :: most !! most nodes of an element

    call allocate_nodes(list, n, most)
    allocate (list%status(n), source=0)
    allocate (list%slaves(n), source=1)
    if (most > 4) allocate (list%weight(min(max_slaves, most - 3), n), source=0.0_wp)
    if (most > 4) allocate (list%lift(n), source=0.0_wp)
    allocate (list%d(n_parameters, n), source=0.0_wp)
    allocate (list%h1(n_element_history, n), list%h2(n_element_history, n), source=0.0_wp)
    allocate (list%path1(n), list%path2(n), source=0.0_wp)
    allocate (list%shift(3, n), list%slip(3, n), list%slip_before(3, n), source=0.0_wp)
    allocate (list%hold(n), list%slide(n), source=.false.)
    allocate (list%keep(n), list%offset(n), source=0.0_wp)
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

!> A mesh while it is being read: arrays that grow, and where each element comes from.
module mesh_building
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck, exit_resources
  use text, only: to_text
  use cells, only: most_nodes, shapes, kind_of
  use mesh_types, only: mesh_t
  implicit none
  private
  public :: element_origin_t, start_mesh, drop_rows, reserve_nodes, reserve_elements, &
    place_node, place_element, finish_mesh, model_size, model_box, axis_tolerance, &
    place_tolerance, miss_tolerance, set_roundings
  public :: own_nodes, most_mesh_nodes, max_elements, max_coordinate

  !> Most nodes and elements; what goes beyond is taken for a slip of the pen.
  integer, parameter :: most_mesh_nodes = 10000000
  integer, parameter :: max_elements = 40000000
  !> Largest coordinate: its cube is still a number.
  real(wp), parameter :: max_coordinate = 1.0e100_wp
  !> Coordinates that differ by less than this part of their size are the same.
  real(wp), parameter :: coordinate_digits = 1.0e-10_wp
  !> Nodes closer to a plane, or to each other, than this part of the model's size are on it.
  real(wp), parameter :: default_tolerance = 1.0e-8_wp
  !> Nodes closer than this part of the shortest edge to what is chosen lie just beside it: no mesh
  !! has a layer of elements so thin beside elements so long.
  real(wp), parameter :: thin_layer_ratio = 0.01_wp

  !> The record of the deck that each element comes from, for error messages.
  type :: element_origin_t
    integer, allocatable :: set(:) !! (elements) index into the deck's mesh commands
    integer, allocatable :: record(:) !! (elements) index into the records of that command
  end type element_origin_t

contains

  !> An empty mesh with room for the counts of the control record.
  subroutine start_mesh(mesh, origin, nodes, elements)
    type(mesh_t), intent(out) :: mesh !! the mesh
    type(element_origin_t), intent(out) :: origin !! where its elements come from
    integer, intent(in) :: nodes !! expected number of nodes, may be 0
    integer, intent(in) :: elements !! expected number of elements, may be 0
    integer :: n, m

    n = max(8, min(nodes, 100000))
    m = max(8, min(elements, 100000))
    allocate (mesh%x(3, n), mesh%rounding(3, n), source=0.0_wp)
    allocate (mesh%defined(n), source=.false.)
    allocate (mesh%ix(most_nodes, m), source=0)
    allocate (mesh%material(m), mesh%region(m), origin%set(m), origin%record(m), source=0)
    allocate (mesh%regions(0), mesh%sets(0), mesh%surfaces(0), mesh%fields(0))
  end subroutine start_mesh

  !> Makes room for node numbers up to `n`.
  subroutine reserve_nodes(mesh, n, error)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer, intent(in) :: n !! highest node number
    type(error_t), allocatable, intent(out) :: error !! too many, or no memory
    integer :: room, status

    if (n > most_mesh_nodes) then
      call raise(error, exit_deck, 'node '//to_text(n)//' is beyond the largest node number, '// &
        to_text(most_mesh_nodes))
      return
    end if
    mesh%nodes = max(mesh%nodes, n)
    if (n <= size(mesh%defined)) return
    room = min(most_mesh_nodes, max(n, 2*size(mesh%defined)))
    call resize_nodes(mesh, room, status)
    if (status /= 0) call raise(error, exit_resources, 'no memory for '//to_text(n)//' nodes')
  end subroutine reserve_nodes

  !> Makes room for element numbers up to `n`.
  subroutine reserve_elements(mesh, origin, n, error)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    integer, intent(in) :: n !! highest element number
    type(error_t), allocatable, intent(out) :: error !! too many, or no memory
    integer :: room, status

    if (n > max_elements) then
      call raise(error, exit_deck, 'element '//to_text(n)// &
        ' is beyond the largest element number, '//to_text(max_elements))
      return
    end if
    mesh%elements = max(mesh%elements, n)
    if (n <= size(mesh%material)) return
    room = min(max_elements, max(n, 2*size(mesh%material)))
    call resize_elements(mesh, origin, room, status)
    if (status /= 0) call raise(error, exit_resources, 'no memory for '//to_text(n)//' elements')
  end subroutine reserve_elements

  !> Gives a node its coordinates, turned and moved by TRANsform, unless it has some already.
  subroutine place_node(mesh, n, x, apart)
    type(mesh_t), intent(inout) :: mesh !! the mesh, with room for the node
    integer, intent(in) :: n !! node number
    real(wp), intent(in) :: x(3) !! coordinates [length]
    real(wp), intent(out) :: apart !! distance to other coordinates given before [length], or 0
    real(wp) :: y(3)

    apart = 0.0_wp
    y = matmul(mesh%turn, x) + mesh%shift
    if (mesh%defined(n)) then
      apart = norm2(y - mesh%x(:, n))
      if (apart <= coordinate_digits*max(maxval(abs(y)), maxval(abs(mesh%x(:, n))))) apart = 0.0_wp
    else
      mesh%x(:, n) = y
      mesh%defined(n) = .true.
    end if
  end subroutine place_node

  !> Keeps what a file has rounded the coordinates of a node by, turned like these by TRANsform.
  subroutine set_roundings(mesh, n, rounding)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer, intent(in) :: n !! node number
    real(wp), intent(in) :: rounding(3) !! [length]

    mesh%rounding(:, n) = matmul(abs(mesh%turn), rounding)
  end subroutine set_roundings

  !> Gives an element its nodes, unless it has some already.
  subroutine place_element(mesh, origin, n, nodes, material, set, record, twice)
    type(mesh_t), intent(inout) :: mesh !! the mesh, with room for the element
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    integer, intent(in) :: n !! element number
    integer, intent(in) :: nodes(:) !! its nodes
    integer, intent(in) :: material !! its material number
    integer, intent(in) :: set !! index of the command it comes from
    integer, intent(in) :: record !! index of the record it comes from
    logical, intent(out) :: twice !! the element is there already and was left alone

    twice = origin%set(n) /= 0
    if (twice) return
    mesh%ix(:size(nodes), n) = nodes
    mesh%material(n) = material
    origin%set(n) = set
    origin%record(n) = record
  end subroutine place_element

  !> Cuts the arrays to the numbers that are there and finds the nodes that elements hold.
  subroutine finish_mesh(mesh, origin, error)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(error_t), allocatable, intent(out) :: error !! no memory
    integer :: e, k, n, status

    call resize_nodes(mesh, mesh%nodes, status)
    if (status == 0) call resize_elements(mesh, origin, mesh%elements, status)
    if (status == 0) allocate (mesh%used(mesh%nodes), stat=status)
    if (status /= 0) then
      call raise(error, exit_resources, 'no memory for the mesh')
      return
    end if
    mesh%used(:) = .false.
    do e = 1, mesh%elements
      do k = 1, most_nodes
        n = mesh%ix(k, e)
        if (n >= 1 .and. n <= mesh%nodes) mesh%used(n) = .true.
      end do
    end do
    call limit_roundings(mesh)
  end subroutine finish_mesh

  !> Measures the shortest edge at each node; what files have rounded a node by is less than a small
  !! part of that, or the elements would not have their shapes.
  pure subroutine limit_roundings(mesh)
    type(mesh_t), intent(inout) :: mesh !! the mesh; gets spacing
    real(wp) :: edge
    integer :: e, i, k, a, b, shape

    allocate (mesh%spacing(mesh%nodes), source=huge(1.0_wp))
    do e = 1, mesh%elements
      do k = 2, shapes(kind_of(mesh%ix(:, e)))%corners
        b = mesh%ix(k, e)
        do i = 1, k - 1
          a = mesh%ix(i, e)
          if (min(a, b) < 1 .or. max(a, b) > mesh%nodes .or. a == b) cycle
          edge = norm2(mesh%x(:, a) - mesh%x(:, b))
          mesh%spacing(a) = min(mesh%spacing(a), edge)
          mesh%spacing(b) = min(mesh%spacing(b), edge)
        end do
      end do
    end do
    do e = 1, mesh%elements
      shape = kind_of(mesh%ix(:, e))
      do k = shapes(shape)%corners + 1, shapes(shape)%nodes
        a = mesh%ix(k, e)
        b = mesh%ix(1, e)
        if (min(a, b) < 1 .or. max(a, b) > mesh%nodes) cycle
        mesh%spacing(a) = min(mesh%spacing(a), mesh%spacing(b))
      end do
    end do
    do a = 1, mesh%nodes
      mesh%rounding(:, a) = min(mesh%rounding(:, a), thin_layer_ratio*mesh%spacing(a))
    end do
  end subroutine limit_roundings

  !> How far from a coordinate a node may be and still have it [length].
  pure function axis_tolerance(mesh, direction) result(tolerance)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: direction !! 1, 2, 3
    real(wp) :: tolerance(mesh%nodes)

    tolerance = default_tolerance*model_size(mesh)
    if (allocated(mesh%rounding)) tolerance = max(tolerance, mesh%rounding(direction, :mesh%nodes))
  end function axis_tolerance

  !> How far apart nodes may be and still be at one place [length].
  pure function place_tolerance(mesh) result(tolerance)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp) :: tolerance(mesh%nodes)

    tolerance = default_tolerance*model_size(mesh)
    if (allocated(mesh%rounding)) tolerance &
      = max(tolerance, norm2(mesh%rounding(:, :mesh%nodes), 1))
  end function place_tolerance

  !> A node so near to what a choice takes was meant, maybe, and is worth a warning [length].
  pure function miss_tolerance(mesh) result(tolerance)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp) :: tolerance(mesh%nodes)

    tolerance = 0.0_wp
    if (allocated(mesh%spacing)) then
      where (mesh%spacing(:mesh%nodes) < huge(1.0_wp)) tolerance &
        = thin_layer_ratio*mesh%spacing(:mesh%nodes)
    end if
  end function miss_tolerance

  !> Diagonal of the box around the model [length].
  pure real(wp) function model_size(mesh) result(length)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp) :: low(3), high(3)

    call model_box(mesh, low, high)
    length = 0.0_wp
    if (all(low <= high)) length = norm2(high - low)
  end function model_size

  !> The highest number of a node that the deck or its mesh files give. Those behind it belong to
  !! exact surfaces and are met by their name alone: no number, plane, box or point means them.
  pure integer function own_nodes(mesh)
    type(mesh_t), intent(in) :: mesh !! the mesh

    own_nodes = mesh%nodes - mesh%exact_nodes
  end function own_nodes

  !> The box around all nodes but those of exact surfaces, which go on beyond the model. Without a
  !! node its low corner is above its high one.
  pure subroutine model_box(mesh, low, high)
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp), intent(out) :: low(3) !! [length]
    real(wp), intent(out) :: high(3) !! [length]
    integer :: n

    low = huge(1.0_wp)
    high = -huge(1.0_wp)
    do n = 1, own_nodes(mesh)
      if (.not. mesh%defined(n)) cycle
      low = min(low, mesh%x(:, n))
      high = max(high, mesh%x(:, n))
    end do
  end subroutine model_box

  !> Gives the node arrays another length; what is new is empty.
  subroutine resize_nodes(mesh, room, status)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer, intent(in) :: room !! new length
    integer, intent(out) :: status !! 0, or no memory
    real(wp), allocatable :: x(:, :), rounding(:, :)
    logical, allocatable :: defined(:)
    integer :: n

    n = min(room, size(mesh%defined))
    allocate (x(3, room), stat=status)
    if (status /= 0) return
    allocate (defined(room), rounding(3, room), stat=status)
    if (status /= 0) return
    x(:, :n) = mesh%x(:, :n)
    x(:, n + 1:) = 0.0_wp
    rounding(:, :n) = mesh%rounding(:, :n)
    rounding(:, n + 1:) = 0.0_wp
    defined(:n) = mesh%defined(:n)
    defined(n + 1:) = .false.
    call move_alloc(x, mesh%x)
    call move_alloc(rounding, mesh%rounding)
    call move_alloc(defined, mesh%defined)
  end subroutine resize_nodes

  !> Gives the element arrays another length; what is new is empty.
  subroutine resize_elements(mesh, origin, room, status)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    integer, intent(in) :: room !! new length
    integer, intent(out) :: status !! 0, or no memory
    integer, allocatable :: ix(:, :)
    integer :: n

    n = min(room, size(mesh%material))
    allocate (ix(most_nodes, room), stat=status)
    if (status /= 0) return
    ix(:, :n) = mesh%ix(:, :n)
    ix(:, n + 1:) = 0
    call move_alloc(ix, mesh%ix)
    call resize_numbers(mesh%material, room, status)
    if (status == 0) call resize_numbers(mesh%region, room, status)
    if (status == 0) call resize_numbers(origin%set, room, status)
    if (status == 0) call resize_numbers(origin%record, room, status)
  end subroutine resize_elements

  !> Gives back the room for nodes that no element has. To be called when all that reads the mesh is
  !! done.
  subroutine drop_rows(mesh)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer, allocatable :: ix(:, :)
    integer :: rows

    do rows = size(mesh%ix, 1), minval(shapes%nodes) + 1, -1
      if (any(mesh%ix(rows, :) > 0)) exit
    end do
    if (rows == size(mesh%ix, 1)) return
    ix = mesh%ix(:rows, :)
    call move_alloc(ix, mesh%ix)
  end subroutine drop_rows

  !> Gives a list of numbers another length; what is new is 0.
  subroutine resize_numbers(list, room, status)
    integer, allocatable, intent(inout) :: list(:) !! the list
    integer, intent(in) :: room !! new length
    integer, intent(out) :: status !! 0, or no memory
    integer, allocatable :: other(:)
    integer :: n

    n = min(room, size(list))
    allocate (other(room), stat=status)
    if (status /= 0) return
    other(:n) = list(:n)
    other(n + 1:) = 0
    call move_alloc(other, list)
  end subroutine resize_numbers
end module mesh_building

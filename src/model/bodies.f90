!> Connected bodies of a mesh: which elements hang together through shared nodes.
module bodies
  use mesh_types, only: mesh_t
  use mesh_names, only: surface_nodes
  implicit none
  private
  public :: find_bodies

contains

  !> Numbers the connected components of the elements from 1, in the order of their first element;
  !! surfaces with nothing behind them come last.
  pure subroutine find_bodies(mesh, element_body, node_body, n)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, allocatable, intent(out) :: element_body(:) !! (elements) body, 0 for an unused number
    integer, allocatable, intent(out) :: node_body(:) !! (nodes) body, 0 for a node without element
    integer, intent(out) :: n !! number of bodies
    integer, allocatable :: parent(:)
    integer, allocatable :: body_of_root(:)
    integer :: e, root

    call join_elements(mesh, parent)
    if (allocated(mesh%surfaces)) call join_surfaces(mesh, parent)
    allocate (element_body(mesh%elements), source=0)
    allocate (body_of_root(mesh%nodes), source=0)
    n = 0
    do e = 1, mesh%elements
      if (mesh%ix(1, e) == 0) cycle
      call find_root(parent, mesh%ix(1, e), root)
      if (body_of_root(root) == 0) then
        n = n + 1
        body_of_root(root) = n
      end if
      element_body(e) = body_of_root(root)
    end do
    if (allocated(mesh%surfaces)) call number_surfaces(mesh, parent, body_of_root, n)
    call number_nodes(parent, body_of_root, node_body)
  end subroutine find_bodies

  !> Numbers the surfaces with nothing behind them, behind the elements.
  pure subroutine number_surfaces(mesh, parent, body_of_root, n)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(inout) :: parent(:) !! (nodes) next node towards the root
    integer, intent(inout) :: body_of_root(:) !! (nodes) body of a root, 0 for none
    integer, intent(inout) :: n !! number of bodies
    integer :: k, root

    do k = 1, size(mesh%surfaces)
      if (.not. mesh%surfaces(k)%alone .or. size(mesh%surfaces(k)%facets) == 0) cycle
      call find_root(parent, mesh%surfaces(k)%facets(1, 1), root)
      if (body_of_root(root) > 0) cycle
      n = n + 1
      body_of_root(root) = n
    end do
  end subroutine number_surfaces

  !> Joins the nodes of each surface with nothing behind it: it is a rigid body.
  pure subroutine join_surfaces(mesh, parent)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(inout) :: parent(:) !! (nodes) next node towards the root
    integer, allocatable :: nodes(:)
    integer :: k, i, first, other

    do k = 1, size(mesh%surfaces)
      if (.not. mesh%surfaces(k)%alone) cycle
      call surface_nodes(mesh, k, nodes)
      do i = 2, size(nodes)
        call find_root(parent, nodes(1), first)
        call find_root(parent, nodes(i), other)
        parent(max(first, other)) = min(first, other)
      end do
    end do
  end subroutine join_surfaces

  !> Joins the nodes of each element into one tree.
  pure subroutine join_elements(mesh, parent)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, allocatable, intent(out) :: parent(:) !! (nodes) next node towards the root
    integer :: e, k, i, first, other

    allocate (parent(mesh%nodes))
    parent = [(i, i=1, mesh%nodes)]
    do e = 1, mesh%elements
      if (mesh%ix(1, e) == 0) cycle
      do k = 2, size(mesh%ix, 1)
        if (mesh%ix(k, e) == 0) exit
        call find_root(parent, mesh%ix(1, e), first)
        call find_root(parent, mesh%ix(k, e), other)
        parent(max(first, other)) = min(first, other)
      end do
    end do
  end subroutine join_elements

  !> Follows the tree to its root and halves the path on the way.
  pure subroutine find_root(parent, node, root)
    integer, intent(inout) :: parent(:) !! (nodes) next node towards the root
    integer, intent(in) :: node !! where to start
    integer, intent(out) :: root !! the root

    root = node
    do while (parent(root) /= root)
      parent(root) = parent(parent(root))
      root = parent(root)
    end do
  end subroutine find_root

  !> Body of each node.
  pure subroutine number_nodes(parent, body_of_root, node_body)
    integer, intent(inout) :: parent(:) !! (nodes) next node towards the root
    integer, intent(in) :: body_of_root(:) !! (nodes) body of a root
    integer, allocatable, intent(out) :: node_body(:) !! (nodes) body of each node
    integer :: i, root

    allocate (node_body(size(parent)))
    do i = 1, size(parent)
      call find_root(parent, i, root)
      node_body(i) = body_of_root(root)
    end do
  end subroutine number_nodes
end module bodies

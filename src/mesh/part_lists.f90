!> Lists of sets, regions and surfaces that grow.
module part_lists
  use deck_types, only: location_t
  use mesh_types, only: mesh_t, node_set_t, region_t, surface_t
  implicit none
  private
  public :: append_set, append_region, append_surface

contains

  !> Adds a node set.
  subroutine append_set(mesh, name, at, nodes)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    character(*), intent(in) :: name !! name of the set
    type(location_t), intent(in) :: at !! where it is defined
    integer, intent(in) :: nodes(:) !! its nodes, ascending, no doubles
    type(node_set_t), allocatable :: more(:)
    integer :: i, n

    n = size(mesh%sets)
    allocate (more(n + 1))
    do i = 1, n
      call move_alloc(mesh%sets(i)%name, more(i)%name)
      call move_alloc(mesh%sets(i)%nodes, more(i)%nodes)
      more(i)%at = mesh%sets(i)%at
    end do
    more(n + 1)%name = name
    more(n + 1)%at = at
    more(n + 1)%nodes = nodes
    call move_alloc(more, mesh%sets)
  end subroutine append_set

  !> Adds a region.
  subroutine append_region(mesh, name, at)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    character(*), intent(in) :: name !! name of the region
    type(location_t), intent(in) :: at !! where it is defined
    type(region_t), allocatable :: more(:)
    integer :: i, n

    n = size(mesh%regions)
    allocate (more(n + 1))
    do i = 1, n
      call move_alloc(mesh%regions(i)%name, more(i)%name)
      call move_alloc(mesh%regions(i)%elements, more(i)%elements)
      more(i)%at = mesh%regions(i)%at
    end do
    more(n + 1)%name = name
    more(n + 1)%at = at
    call move_alloc(more, mesh%regions)
  end subroutine append_region

  !> Adds a surface without facets.
  subroutine append_surface(mesh, name, at)
    type(mesh_t), intent(inout) :: mesh !! the mesh
    character(*), intent(in) :: name !! name of the surface
    type(location_t), intent(in) :: at !! where it is defined
    type(surface_t), allocatable :: more(:)
    integer :: i, n

    n = size(mesh%surfaces)
    allocate (more(n + 1))
    do i = 1, n
      call move_alloc(mesh%surfaces(i)%name, more(i)%name)
      call move_alloc(mesh%surfaces(i)%facets, more(i)%facets)
      call move_alloc(mesh%surfaces(i)%elements, more(i)%elements)
      call move_alloc(mesh%surfaces(i)%inner, more(i)%inner)
      more(i)%alone = mesh%surfaces(i)%alone
      more(i)%exact = mesh%surfaces(i)%exact
      more(i)%at = mesh%surfaces(i)%at
    end do
    more(n + 1)%name = name
    more(n + 1)%at = at
    allocate (more(n + 1)%facets(3, 0), more(n + 1)%elements(0))
    call move_alloc(more, mesh%surfaces)
  end subroutine append_surface
end module part_lists

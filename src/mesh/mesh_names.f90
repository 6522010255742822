!> Looking up sets, regions and surfaces by name.
module mesh_names
  use text, only: edit_distance, in_quotes
  use cells, only: facet_of, most_facet_nodes
  use mesh_types, only: mesh_t
  use key_sorting, only: unique_numbers
  implicit none
  private
  public :: find_nodes, find_set, find_region, find_surface, nearest_name, name_hint, name_exists, &
    region_hint, region_nodes, surface_nodes, in_region

  !> Names that a remedy lists.
  integer, parameter :: most_listed = 8

contains

  !> Nodes of the set, region or surface of this name.
  subroutine find_nodes(mesh, name, nodes, found)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name to look for
    integer, allocatable, intent(out) :: nodes(:) !! its nodes, ascending, no doubles
    logical, intent(out) :: found !! there is such a name
    integer :: index

    found = .true.
    call find_set(mesh, name, index)
    if (index > 0) then
      nodes = mesh%sets(index)%nodes
      return
    end if
    call find_region(mesh, name, index)
    if (index > 0) then
      call region_nodes(mesh, index, nodes)
      return
    end if
    call find_surface(mesh, name, index)
    found = index > 0
    allocate (nodes(0))
    if (found) call surface_nodes(mesh, index, nodes)
  end subroutine find_nodes

  !> Nodes of the facets of a surface, those within them included.
  pure subroutine surface_nodes(mesh, index, nodes)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: index !! index of the surface
    integer, allocatable, intent(out) :: nodes(:) !! its nodes, ascending, no doubles
    logical :: mask(mesh%nodes)
    integer :: k, facet(most_facet_nodes)

    mask = .false.
    associate (surface => mesh%surfaces(index))
      do k = 1, size(surface%facets, 2)
        facet = 0
        facet(:3) = surface%facets(:, k)
        if (allocated(surface%inner)) facet(4:6) = surface%inner(:, k)
        if (surface%elements(k) > 0) facet = facet_of(mesh%ix(:, surface%elements(k)), &
          surface%facets(:, k))
        mask(pack(facet, facet > 0)) = .true.
      end do
    end associate
    nodes = unique_numbers(mask)
  end subroutine surface_nodes

  !> Nodes of the elements of a region.
  subroutine region_nodes(mesh, index, nodes)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: index !! index of the region
    integer, allocatable, intent(out) :: nodes(:) !! its nodes, ascending, no doubles
    logical, allocatable :: mask(:), chosen(:)
    integer :: e, k, n

    allocate (mask(mesh%nodes), source=.false.)
    chosen = in_region(mesh, index)
    do e = 1, mesh%elements
      if (.not. chosen(e)) cycle
      do k = 1, size(mesh%ix, 1)
        n = mesh%ix(k, e)
        if (n >= 1 .and. n <= mesh%nodes) mask(n) = .true.
      end do
    end do
    nodes = unique_numbers(mask)
  end subroutine region_nodes

  !> Which elements belong to a region. Regions of a mesh file may overlap; mesh%region then knows
  !! only the first region of an element.
  pure function in_region(mesh, index) result(chosen)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: index !! index of the region
    logical, allocatable :: chosen(:)

    allocate (chosen(mesh%elements))
    if (allocated(mesh%regions(index)%elements)) then
      chosen = .false.
      chosen(mesh%regions(index)%elements) = .true.
    else
      chosen = mesh%region(:mesh%elements) == index
    end if
  end function in_region

  !> Index of a node set, 0 if there is none of this name.
  pure subroutine find_set(mesh, name, index)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name to look for
    integer, intent(out) :: index !! index into mesh%sets
    integer :: i

    index = 0
    do i = 1, size(mesh%sets)
      if (mesh%sets(i)%name == name .and. name /= '') index = i
    end do
  end subroutine find_set

  !> Index of a region, 0 if there is none of this name.
  pure subroutine find_region(mesh, name, index)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name to look for
    integer, intent(out) :: index !! index into mesh%regions
    integer :: i

    index = 0
    do i = 1, size(mesh%regions)
      if (mesh%regions(i)%name == name .and. name /= '') index = i
    end do
  end subroutine find_region

  !> Index of a surface, 0 if there is none of this name.
  pure subroutine find_surface(mesh, name, index)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name to look for
    integer, intent(out) :: index !! index into mesh%surfaces
    integer :: i

    index = 0
    do i = 1, size(mesh%surfaces)
      if (mesh%surfaces(i)%name == name .and. name /= '') index = i
    end do
  end subroutine find_surface

  !> True if a set, region or surface has this name.
  pure logical function name_exists(mesh, name) result(exists)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name to look for
    integer :: i, j, k

    call find_set(mesh, name, i)
    call find_region(mesh, name, j)
    call find_surface(mesh, name, k)
    exists = max(i, j, k) > 0
  end function name_exists

  !> The name of a set, region or surface that is most like the given one; empty if there is no
  !! name at all.
  pure function nearest_name(mesh, name) result(nearest)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name to look for
    character(:), allocatable :: nearest
    integer :: i, least

    nearest = ''
    least = huge(1)
    do i = 1, size(mesh%sets)
      call take_if_nearer(mesh%sets(i)%name, name, least, nearest)
    end do
    do i = 1, size(mesh%surfaces)
      call take_if_nearer(mesh%surfaces(i)%name, name, least, nearest)
    end do
    do i = 1, size(mesh%regions)
      call take_if_nearer(mesh%regions(i)%name, name, least, nearest)
    end do
  end function nearest_name

  !> Keeps the candidate that is nearest so far.
  pure subroutine take_if_nearer(candidate, name, least, nearest)
    character(*), intent(in) :: candidate !! a name of the mesh
    character(*), intent(in) :: name !! the name to look for
    integer, intent(inout) :: least !! smallest distance so far
    character(:), allocatable, intent(inout) :: nearest !! name at that distance
    integer :: distance

    if (candidate == '') return
    distance = edit_distance(candidate, name)
    if (distance >= least) return
    least = distance
    nearest = candidate
  end subroutine take_if_nearer

  !> The remedy for a name that does not exist.
  pure function name_hint(mesh, name) result(hint)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! the name to look for
    character(:), allocatable :: hint

    hint = nearest_name(mesh, name)
    if (hint == '') then
      hint = 'the deck defines no set, region or surface; see SET, BLOCk and SURFace'
    else if (edit_distance(hint, name) > max(2, len(name)/2)) then
      hint = list_names(mesh)
    else
      hint = 'the nearest name is '//in_quotes(hint)
    end if
  end function name_hint

  !> The first names that there are.
  pure function list_names(mesh) result(t)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(:), allocatable :: t
    integer :: i, n

    t = 'the names are'
    n = 0
    do i = 1, size(mesh%sets)
      call list_one(mesh%sets(i)%name, n, t)
    end do
    do i = 1, size(mesh%surfaces)
      call list_one(mesh%surfaces(i)%name, n, t)
    end do
    do i = 1, size(mesh%regions)
      call list_one(mesh%regions(i)%name, n, t)
    end do
    if (n > most_listed) t = t//' ...'
  end function list_names

  !> Adds a name to a list unless it is long enough.
  pure subroutine list_one(name, n, t)
    character(*), intent(in) :: name !! may be empty
    integer, intent(inout) :: n !! names so far
    character(:), allocatable, intent(inout) :: t !! the list

    if (name == '') return
    n = n + 1
    if (n <= most_listed) t = t//' '//in_quotes(name)
  end subroutine list_one

  !> The remedy for a region that does not exist: the names of those that do.
  pure function region_hint(mesh) result(hint)
    type(mesh_t), intent(in) :: mesh !! the mesh, for its names
    character(:), allocatable :: hint
    integer :: i, n

    hint = 'the regions are'
    n = 0
    do i = 1, size(mesh%regions)
      call list_one(mesh%regions(i)%name, n, hint)
    end do
    if (n > most_listed) hint = hint//' ...'
    if (n == 0) hint = 'give a BLOCk or a MESH a name: it becomes a region'
  end function region_hint
end module mesh_names

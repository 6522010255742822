!> Physical groups of Gmsh files: their names, and which cells belong to them.
module gmsh_groups
  use text, only: to_text
  use cells, only: shapes, file_shapes
  use mesh_file_types, only: file_mesh_t, add_group, add_member, add_remark, group_cells
  implicit none
  private
  public :: physical_t, add_physical, add_membership, gather_groups, gmsh_shape, from_gmsh
  public :: gmsh_readable

  !> What of Gmsh can be read.
  character(*), parameter :: gmsh_readable = 'this version reads tetrahedra of 4 and 10 nodes, '// &
    'and triangles, lines and points on them'

  !> A name of a physical group.
  type :: physical_name_t
    integer :: dimension = 0 !! 0 to 3
    integer :: tag = 0 !! its number
    integer :: at = 1 !! character of the file where it stands
    character(:), allocatable :: name !! its name
  end type physical_name_t

  !> Names of physical groups, and in version 4 which entity belongs to which of them.
  type :: physical_t
    integer :: count = 0 !! names
    type(physical_name_t), allocatable :: names(:) !! may be larger than count
    integer :: memberships = 0 !! entities in groups
    integer, allocatable :: members(:, :) !! (3, memberships) dimension, entity, group
    integer :: blocks = 0 !! blocks of elements
    integer, allocatable :: block(:, :) !! (2, blocks) dimension and entity of each
  end type physical_t

contains

  !> Adds a name.
  subroutine add_physical(physical, dimension, tag, name, at)
    type(physical_t), intent(inout) :: physical !! the names
    integer, intent(in) :: dimension !! 0 to 3
    integer, intent(in) :: tag !! number of the group
    character(*), intent(in) :: name !! its name
    integer, intent(in) :: at !! character of the file where it stands
    type(physical_name_t), allocatable :: more(:)
    integer :: i

    if (.not. allocated(physical%names)) allocate (physical%names(8))
    if (physical%count == size(physical%names)) then
      allocate (more(2*physical%count))
      do i = 1, physical%count
        more(i)%dimension = physical%names(i)%dimension
        more(i)%tag = physical%names(i)%tag
        more(i)%at = physical%names(i)%at
        call move_alloc(physical%names(i)%name, more(i)%name)
      end do
      call move_alloc(more, physical%names)
    end if
    physical%count = physical%count + 1
    associate (new => physical%names(physical%count))
      new%dimension = dimension
      new%tag = tag
      new%at = at
      new%name = name
    end associate
  end subroutine add_physical

  !> Notes that an entity belongs to a physical group.
  subroutine add_membership(physical, dimension, entity, tag)
    type(physical_t), intent(inout) :: physical !! the groups
    integer, intent(in) :: dimension !! 0 to 3
    integer, intent(in) :: entity !! number of the entity
    integer, intent(in) :: tag !! number of the group
    integer, allocatable :: more(:, :)

    if (.not. allocated(physical%members)) allocate (physical%members(3, 32))
    if (physical%memberships == size(physical%members, 2)) then
      allocate (more(3, 2*physical%memberships), source=0)
      more(:, :physical%memberships) = physical%members
      call move_alloc(more, physical%members)
    end if
    physical%memberships = physical%memberships + 1
    physical%members(:, physical%memberships) = [dimension, entity, tag]
  end subroutine add_membership

  !> Makes groups of the cells. The mark of a cell is its physical group in version 2 and its block
  !! in version 4.
  subroutine gather_groups(physical, version, file)
    type(physical_t), intent(in) :: physical !! names and who belongs to them
    integer, intent(in) :: version !! 4 or 2
    type(file_mesh_t), intent(inout) :: file !! its cells are complete
    logical, allocatable :: chosen(:)
    integer :: i, b, c

    do i = 1, physical%count
      associate (name => physical%names(i))
        call add_group(file, name%name, group_cells, name%at)
        if (version == 4) then
          allocate (chosen(physical%blocks))
          do b = 1, physical%blocks
            chosen(b) = belongs(physical, physical%block(:, b), name%dimension, name%tag)
          end do
        end if
        do c = 1, file%cells
          if (version == 4) then
            if (.not. chosen(file%mark(c))) cycle
          else
            if (file%mark(c) /= name%tag .or. file%dimension(c) /= name%dimension) cycle
          end if
          call add_member(file%group(file%groups), c, 0)
        end do
        if (allocated(chosen)) deallocate (chosen)
      end associate
    end do
    if (version == 4) call remark_nameless(physical, file)
  end subroutine gather_groups

  !> Whether an entity belongs to a group.
  pure logical function belongs(physical, entity, dimension, tag)
    type(physical_t), intent(in) :: physical !! who belongs to what
    integer, intent(in) :: entity(2) !! dimension and number of the entity
    integer, intent(in) :: dimension !! that of the group
    integer, intent(in) :: tag !! number of the group
    integer :: m

    belongs = .false.
    if (entity(1) /= dimension) return
    do m = 1, physical%memberships
      if (all(physical%members(:, m) == [entity, tag])) belongs = .true.
    end do
  end function belongs

  !> Says which physical groups have no name: a deck cannot refer to them.
  subroutine remark_nameless(physical, file)
    type(physical_t), intent(in) :: physical !! names and who belongs to them
    type(file_mesh_t), intent(inout) :: file !! takes the remarks
    integer :: m, n

    n = physical%count
    do m = 1, physical%memberships
      associate (member => physical%members(:, m))
        if (n > 0) then
          if (any(physical%names(:n)%dimension == member(1) .and. &
            physical%names(:n)%tag == member(3))) cycle
        end if
        call add_remark(file, 'physical group '//to_text(member(3))//' of dimension '// &
          to_text(member(1))//' has no name and is left out')
      end associate
    end do
  end subroutine remark_nameless

  !> Nodes and dimension of an element type that can be read, else 0 nodes and what it is called.
  pure subroutine gmsh_shape(kind, nodes, dimension, name)
    integer, intent(in) :: kind !! Gmsh's number of the type
    integer, intent(out) :: nodes !! all its nodes, or 0
    integer, intent(out) :: dimension !! 0 point, 1 line, 2 triangle, 3 cell
    character(:), allocatable, intent(out) :: name !! what it is called
    integer :: k

    nodes = 0
    dimension = 0
    do k = 1, size(file_shapes)
      if (kind < 1 .or. file_shapes(k)%gmsh /= kind) cycle
      nodes = file_shapes(k)%nodes
      dimension = file_shapes(k)%dimension
      return
    end do
    select case (kind)
    case (3)
      name = 'quadrangles'
    case (5)
      name = 'hexahedra'
    case (6)
      name = 'prisms'
    case (7)
      name = 'pyramids'
    case default
      name = 'elements of Gmsh''s type '//to_text(kind)
    end select
  end subroutine gmsh_shape

  !> The nodes of an element in the order of mfec.
  pure function from_gmsh(nodes) result(ours)
    integer, intent(in) :: nodes(:) !! as Gmsh has them
    integer :: ours(size(nodes)), k

    ours = nodes
    k = findloc(shapes%nodes, size(nodes), dim=1)
    if (k > 0) ours = nodes(shapes(k)%from_gmsh(:size(nodes)))
  end function from_gmsh
end module gmsh_groups

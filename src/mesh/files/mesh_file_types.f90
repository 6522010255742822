!> What a mesh file holds, in the numbers of that file, before it joins the mesh of the deck.
module mesh_file_types
  use kinds, only: wp
  use text, only: string_t, lower
  use cells, only: most_nodes
  implicit none
  private
  public :: file_mesh_t, file_group_t, file_field_t, add_node, add_cell, add_group, add_member, &
    add_field, add_vector, add_remark, find_group, start_file_mesh
  public :: group_nodes, group_cells, group_faces, group_done, rigid_cell

  !> Characters of a short line of a file, and room for nodes and cells at least.
  integer, parameter :: short_line = 24, least_room = 64

  !> What the members of a group are.
  integer, parameter :: group_nodes = 1 !! places in the list of nodes
  integer, parameter :: group_cells = 2 !! places in the list of cells
  integer, parameter :: group_faces = 3 !! places in the list of cells, with a face of each

  integer, parameter :: group_done = 0 !! it is a surface of the deck already
  !> Mark of a triangle or quadrilateral that is rigid and needs no tetrahedron behind it.
  integer, parameter :: rigid_cell = -1

  !> A named group of nodes, cells or faces.
  type :: file_group_t
    character(:), allocatable :: name !! its name as written
    character(:), allocatable :: material !! name of its material in the file, or not allocated
    integer :: kind = group_nodes !! one of the kinds above
    integer :: at = 1 !! character of the file where it is defined
    integer :: scope = 0 !! instance of an Abaqus file that its name belongs to, 0 for none
    integer :: count = 0 !! members
    integer, allocatable :: members(:) !! its members (may be larger than count)
    integer, allocatable :: faces(:) !! facet of each, 0 for all free ones; else 0
  end type file_group_t

  !> Vectors of cells under a name.
  type :: file_field_t
    character(:), allocatable :: name !! its name as written
    integer :: at = 1 !! character of the file where it begins
    integer :: count = 0 !! cells with a vector
    integer, allocatable :: tag(:) !! the file's number of each cell (may be larger than count)
    real(wp), allocatable :: vector(:, :) !! (3, count) components
    integer, allocatable :: vector_at(:) !! character of the file where each stands
  end type file_field_t

  !> Nodes, cells (points, lines, triangles, tetrahedra) and groups of a mesh file.
  type :: file_mesh_t
    logical :: merges = .false. !! the format repeats a cell that is in several groups (MSH 2.2)
    integer :: nodes = 0 !! number of nodes
    integer, allocatable :: node_tag(:) !! the file's number of each node
    real(wp), allocatable :: x(:, :) !! (3, nodes) coordinates [length]
    integer, allocatable :: node_at(:) !! character of the file where each stands
    integer :: cells = 0 !! number of cells
    integer, allocatable :: cell_tag(:) !! the file's number of each cell
    integer, allocatable :: dimension(:) !! of each cell: point 0, line 1, triangle 2, tetrahedron 3
    integer, allocatable :: nel(:) !! nodes of each cell
    integer, allocatable :: ix(:, :) !! (most_nodes, cells) their numbers in the file, zeros behind
    integer, allocatable :: mark(:) !! what tells the reader the groups of each cell
    integer, allocatable :: cell_at(:) !! character of the file where each stands
    integer :: groups = 0 !! number of groups
    type(file_group_t), allocatable :: group(:) !! groups in the order of the file
    type(file_field_t), allocatable :: field(:) !! vectors of cells, in the order of the file
    type(string_t), allocatable :: remarks(:) !! what was passed over
  end type file_mesh_t

contains

  !> An empty file, with room for what so much text may hold; more is made where it is too little.
  pure subroutine start_file_mesh(letters, file)
    integer, intent(in) :: letters !! of the file
    type(file_mesh_t), intent(out) :: file !! nothing in it
    integer :: room

    room = max(least_room, letters/short_line)
    allocate (file%node_tag(room), file%node_at(room), file%x(3, room))
    allocate (file%cell_tag(room), file%dimension(room), file%nel(room), file%mark(room), &
      file%cell_at(room), file%ix(most_nodes, room))
    allocate (file%group(8), file%field(0), file%remarks(0))
  end subroutine start_file_mesh

  !> Adds a node.
  subroutine add_node(file, tag, x, at)
    type(file_mesh_t), intent(inout) :: file !! the file
    integer, intent(in) :: tag !! its number
    real(wp), intent(in) :: x(3) !! coordinates [length]
    integer, intent(in) :: at !! character of the file where it stands
    real(wp), allocatable :: more(:, :)

    if (file%nodes == size(file%node_tag)) then
      call grow(file%node_tag)
      call grow(file%node_at)
      allocate (more(3, size(file%node_tag)))
      more(:, :file%nodes) = file%x(:, :file%nodes)
      call move_alloc(more, file%x)
    end if
    file%nodes = file%nodes + 1
    file%node_tag(file%nodes) = tag
    file%x(:, file%nodes) = x
    file%node_at(file%nodes) = at
  end subroutine add_node

  !> Adds a cell.
  subroutine add_cell(file, tag, nodes, dimension, mark, at)
    type(file_mesh_t), intent(inout) :: file !! the file
    integer, intent(in) :: tag !! its number
    integer, intent(in) :: nodes(:) !! node numbers of the file, corners first
    integer, intent(in) :: dimension !! 0 to 3
    integer, intent(in) :: mark !! what tells the reader its groups
    integer, intent(in) :: at !! character of the file where it stands
    integer, allocatable :: more(:, :)

    if (file%cells == size(file%cell_tag)) then
      call grow(file%cell_tag)
      call grow(file%dimension)
      call grow(file%nel)
      call grow(file%mark)
      call grow(file%cell_at)
      allocate (more(most_nodes, size(file%cell_tag)))
      more(:, :file%cells) = file%ix
      call move_alloc(more, file%ix)
    end if
    file%cells = file%cells + 1
    file%cell_tag(file%cells) = tag
    file%dimension(file%cells) = dimension
    file%nel(file%cells) = size(nodes)
    file%ix(:size(nodes), file%cells) = nodes
    file%ix(size(nodes) + 1:, file%cells) = 0
    file%mark(file%cells) = mark
    file%cell_at(file%cells) = at
  end subroutine add_cell

  !> Adds an empty group.
  subroutine add_group(file, name, kind, at, scope)
    type(file_mesh_t), intent(inout) :: file !! the file
    character(*), intent(in) :: name !! its name
    integer, intent(in) :: kind !! what its members are
    integer, intent(in) :: at !! character of the file where it is defined
    integer, intent(in), optional :: scope !! instance that its name belongs to
    type(file_group_t), allocatable :: more(:)
    integer :: i

    if (file%groups == size(file%group)) then
      allocate (more(2*file%groups))
      do i = 1, file%groups
        call move_group(file%group(i), more(i))
      end do
      call move_alloc(more, file%group)
    end if
    file%groups = file%groups + 1
    associate (group => file%group(file%groups))
      group%name = name
      group%kind = kind
      group%at = at
      if (present(scope)) group%scope = scope
      allocate (group%members(16), group%faces(16), source=0)
    end associate
  end subroutine add_group

  !> Hands a group over without copying its members.
  subroutine move_group(from, to)
    type(file_group_t), intent(inout) :: from !! left empty
    type(file_group_t), intent(inout) :: to !! filled

    call move_alloc(from%name, to%name)
    call move_alloc(from%material, to%material)
    call move_alloc(from%members, to%members)
    call move_alloc(from%faces, to%faces)
    to%kind = from%kind
    to%at = from%at
    to%scope = from%scope
    to%count = from%count
  end subroutine move_group

  !> Adds a member to a group.
  subroutine add_member(group, member, face)
    type(file_group_t), intent(inout) :: group !! the group
    integer, intent(in) :: member !! place in the list of nodes or cells
    integer, intent(in) :: face !! its face, or 0

    if (group%count == size(group%members)) then
      call grow(group%members)
      call grow(group%faces)
    end if
    group%count = group%count + 1
    group%members(group%count) = member
    group%faces(group%count) = face
  end subroutine add_member

  !> Adds an empty field; there are few of them.
  subroutine add_field(file, name, at)
    type(file_mesh_t), intent(inout) :: file !! the file
    character(*), intent(in) :: name !! its name
    integer, intent(in) :: at !! character of the file where it begins
    type(file_field_t), allocatable :: more(:)
    integer :: i, n

    n = size(file%field)
    allocate (more(n + 1))
    do i = 1, n
      call move_alloc(file%field(i)%name, more(i)%name)
      call move_alloc(file%field(i)%tag, more(i)%tag)
      call move_alloc(file%field(i)%vector, more(i)%vector)
      call move_alloc(file%field(i)%vector_at, more(i)%vector_at)
      more(i)%at = file%field(i)%at
      more(i)%count = file%field(i)%count
    end do
    more(n + 1)%name = name
    more(n + 1)%at = at
    allocate (more(n + 1)%tag(64), more(n + 1)%vector_at(64), source=0)
    allocate (more(n + 1)%vector(3, 64), source=0.0_wp)
    call move_alloc(more, file%field)
  end subroutine add_field

  !> Adds the vector of a cell to a field.
  subroutine add_vector(field, tag, vector, at)
    type(file_field_t), intent(inout) :: field !! the field
    integer, intent(in) :: tag !! number of the cell
    real(wp), intent(in) :: vector(3) !! components
    integer, intent(in) :: at !! character of the file where it stands
    real(wp), allocatable :: more(:, :)

    if (field%count == size(field%tag)) then
      call grow(field%tag)
      call grow(field%vector_at)
      allocate (more(3, size(field%tag)), source=0.0_wp)
      more(:, :field%count) = field%vector
      call move_alloc(more, field%vector)
    end if
    field%count = field%count + 1
    field%tag(field%count) = tag
    field%vector(:, field%count) = vector
    field%vector_at(field%count) = at
  end subroutine add_vector

  !> Adds a remark; there are few of them.
  subroutine add_remark(file, remark)
    type(file_mesh_t), intent(inout) :: file !! the file
    character(*), intent(in) :: remark !! what was passed over
    type(string_t), allocatable :: more(:)
    integer :: i

    do i = 1, size(file%remarks)
      if (file%remarks(i)%s == remark) return
    end do
    allocate (more(size(file%remarks) + 1))
    do i = 1, size(file%remarks)
      call move_alloc(file%remarks(i)%s, more(i)%s)
    end do
    more(size(more))%s = remark
    call move_alloc(more, file%remarks)
  end subroutine add_remark

  !> Group of a kind by its name in either case, 0 if there is none.
  pure integer function find_group(file, name, kind, scope) result(g)
    type(file_mesh_t), intent(in) :: file !! the file
    character(*), intent(in) :: name !! its name
    integer, intent(in) :: kind !! what its members are
    integer, intent(in), optional :: scope !! instance that its name belongs to, else none
    integer :: within

    within = 0
    if (present(scope)) within = scope
    do g = 1, file%groups
      if (file%group(g)%scope /= within) cycle
      if (file%group(g)%kind /= kind .or. len(file%group(g)%name) /= len(name)) cycle
      if (lower(file%group(g)%name) == lower(name)) return
    end do
    g = 0
  end function find_group

  !> Doubles the length of a list; what is new is undefined.
  subroutine grow(list)
    integer, allocatable, intent(inout) :: list(:) !! the list
    integer, allocatable :: more(:)
    integer :: n

    n = size(list)
    allocate (more(2*n))
    more(:n) = list
    call move_alloc(more, list)
  end subroutine grow
end module mesh_file_types

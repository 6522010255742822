!> The sections of Gmsh MSH 4.1 files, text and binary alike.
module gmsh4_sections
  use kinds, only: wp
  use text, only: to_text
  use file_cursor, only: cursor_t, fail, read_number, read_size, read_real, find_item
  use cells, only: most_nodes
  use mesh_file_types, only: file_mesh_t, add_node, add_cell
  use gmsh_groups, only: from_gmsh, physical_t, add_membership, gmsh_shape, gmsh_readable
  implicit none
  private
  public :: read_entities4, read_nodes4, read_elements4

contains

  !> $Entities: points, curves, surfaces and volumes with their physical groups.
  subroutine read_entities4(text, physical, cursor)
    character(*), intent(in) :: text !! the file
    type(physical_t), intent(inout) :: physical !! who belongs to which group
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: count(0:3), dimension, i

    do i = 0, 3
      call read_size(text, cursor, count(i), 'the number of entities')
    end do
    do dimension = 0, 3
      do i = 1, count(dimension)
        if (cursor%failed) exit
        call read_entity(text, dimension, physical, cursor)
      end do
    end do
  end subroutine read_entities4

  !> One entity: number, place or box, physical groups, and from curves on what bounds it.
  subroutine read_entity(text, dimension, physical, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: dimension !! 0 to 3
    type(physical_t), intent(inout) :: physical !! who belongs to which group
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the entity
    integer :: entity, n, i, tag
    real(wp) :: unused

    call read_number(text, cursor, entity, 'the number of an entity')
    do i = 1, merge(3, 6, dimension == 0)
      call read_real(text, cursor, unused, 'a bound of an entity')
    end do
    call read_size(text, cursor, n, 'the number of physical groups of an entity')
    do i = 1, n
      if (cursor%failed) exit
      call read_number(text, cursor, tag, 'a physical group of an entity')
      ! a negative number says that the entity is reversed in the group
      if (.not. cursor%failed) call add_membership(physical, dimension, entity, &
        merge(-tag, tag, tag < 0 .and. tag > -huge(tag)))
    end do
    if (dimension == 0) return
    call read_size(text, cursor, n, 'the number of boundaries of an entity')
    do i = 1, n
      if (cursor%failed) exit
      call read_number(text, cursor, tag, 'a boundary of an entity')
    end do
  end subroutine read_entity

  !> Counts at the head of a section: blocks, items, lowest and highest tag.
  subroutine read_counts(text, cursor, blocks, items)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the counts
    integer, intent(out) :: blocks !! number of blocks
    integer, intent(out) :: items !! number of nodes or elements
    integer :: unused

    call read_size(text, cursor, blocks, 'the number of blocks')
    call read_size(text, cursor, items, 'the number of items')
    call read_size(text, cursor, unused, 'the lowest tag')
    call read_size(text, cursor, unused, 'the highest tag')
  end subroutine read_counts

  !> $Nodes: blocks of tags, then coordinates.
  subroutine read_nodes4(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! takes the nodes
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: blocks, items, b, dimension, entity, parametric, n

    call read_counts(text, cursor, blocks, items)
    b = 0
    do while (b < blocks .and. .not. cursor%failed)
      b = b + 1
      call read_number(text, cursor, dimension, 'the dimension of a block of nodes')
      call read_number(text, cursor, entity, 'the entity of a block of nodes')
      call read_number(text, cursor, parametric, 'whether nodes are parametric')
      call read_size(text, cursor, n, 'the number of nodes of a block')
      if (dimension < 0 .or. dimension > 3) call fail(cursor, &
        merge(cursor%head, cursor%at, cursor%binary), 'a block of nodes of dimension '// &
        to_text(dimension), 'it is 0 to 3')
      call read_node_block(text, n, merge(dimension, 0, parametric /= 0), file, cursor)
    end do
    if (.not. cursor%failed .and. file%nodes /= items) call fail(cursor, cursor%head, &
      'the section announces '//to_text(items)//' nodes, but its blocks hold '// &
      to_text(file%nodes), 'is the file damaged? write it again')
  end subroutine read_nodes4

  !> The tags and the coordinates of one block.
  subroutine read_node_block(text, n, parameters, file, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: n !! nodes of the block
    integer, intent(in) :: parameters !! numbers behind the coordinates of each
    type(file_mesh_t), intent(inout) :: file !! takes the nodes
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the block
    integer :: first, i, k, tag
    real(wp) :: unused

    first = file%nodes
    do i = 1, n
      if (cursor%failed) exit
      call read_size(text, cursor, tag, 'the tag of a node')
      if (tag < 1) call fail(cursor, merge(cursor%head, cursor%at, cursor%binary), &
        'a node with tag 0', 'tags start at 1')
      if (.not. cursor%failed) call add_node(file, tag, [0.0_wp, 0.0_wp, 0.0_wp], cursor%at)
    end do
    do i = 1, n
      if (cursor%failed) exit
      call find_item(text, cursor, file%node_at(first + i))
      do k = 1, 3
        call read_real(text, cursor, file%x(k, first + i), 'a coordinate of a node')
      end do
      do k = 1, parameters
        call read_real(text, cursor, unused, 'a parameter of a node')
      end do
    end do
  end subroutine read_node_block

  !> $Elements: blocks of one entity and one type.
  subroutine read_elements4(text, file, physical, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! takes the cells
    type(physical_t), intent(inout) :: physical !! takes the blocks
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: blocks, items, dimension, entity, kind, n, nodes, own, b, at
    integer, allocatable :: block(:, :)
    character(:), allocatable :: name

    call read_counts(text, cursor, blocks, items)
    allocate (block(2, 64), source=0)
    b = 0
    do while (b < blocks .and. .not. cursor%failed)
      b = b + 1
      call find_item(text, cursor, at)
      call read_number(text, cursor, dimension, 'the dimension of a block of elements')
      call read_number(text, cursor, entity, 'the entity of a block of elements')
      call read_number(text, cursor, kind, 'the type of a block of elements')
      call read_size(text, cursor, n, 'the number of elements of a block')
      if (cursor%failed) exit
      call gmsh_shape(kind, nodes, own, name)
      if (nodes == 0) call fail(cursor, at, name//' in entity '//to_text(entity)// &
        ' of dimension '//to_text(dimension), gmsh_readable)
      call keep_block(b, [dimension, entity], block)
      call read_element_block(text, n, [nodes, own, b], file, cursor)
    end do
    physical%blocks = b
    call move_alloc(block, physical%block)
    if (.not. cursor%failed .and. file%cells /= items) call fail(cursor, cursor%head, &
      'the section announces '//to_text(items)//' elements, but its blocks hold '// &
      to_text(file%cells), 'is the file damaged? write it again')
  end subroutine read_elements4

  !> Keeps dimension and entity of a block in a list that grows.
  subroutine keep_block(b, entity, block)
    integer, intent(in) :: b !! number of the block
    integer, intent(in) :: entity(2) !! dimension and number
    integer, allocatable, intent(inout) :: block(:, :) !! the list
    integer, allocatable :: more(:, :)

    if (b > size(block, 2)) then
      allocate (more(2, 2*size(block, 2)), source=0)
      more(:, :b - 1) = block
      call move_alloc(more, block)
    end if
    block(:, b) = entity
  end subroutine keep_block

  !> The elements of one block.
  subroutine read_element_block(text, n, shape, file, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: n !! elements of the block
    integer, intent(in) :: shape(3) !! nodes of each, its dimension, number of the block
    type(file_mesh_t), intent(inout) :: file !! takes the cells
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the block
    integer :: i, k, tag, nodes(most_nodes), at

    do i = 1, n
      if (cursor%failed) exit
      call find_item(text, cursor, at)
      call read_size(text, cursor, tag, 'the tag of an element')
      if (tag < 1) call fail(cursor, at, 'an element with tag 0', 'tags start at 1')
      do k = 1, shape(1)
        call read_size(text, cursor, nodes(k), 'a node of an element')
      end do
      if (.not. cursor%failed) call add_cell(file, tag, from_gmsh(nodes(:shape(1))), shape(2), &
        shape(3), at)
    end do
  end subroutine read_element_block
end module gmsh4_sections

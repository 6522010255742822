!> The sections of Gmsh MSH 2.2 files.
module gmsh2_sections
  use kinds, only: wp
  use text, only: to_text
  use file_cursor, only: cursor_t, fail, read_number, read_real, read_line, find_item
  use cells, only: most_nodes
  use mesh_file_types, only: file_mesh_t, add_node, add_cell
  use gmsh_groups, only: from_gmsh, gmsh_shape, gmsh_readable
  implicit none
  private
  public :: read_nodes2, read_elements2

contains

  !> The number of items; a line of text even in a binary file.
  subroutine read_item_count(text, cursor, n)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the line
    integer, intent(out) :: n !! the number
    logical :: binary, found
    integer :: first, last

    binary = cursor%binary
    cursor%binary = .false.
    call read_number(text, cursor, n, 'the number of items')
    if (n < 0) call fail(cursor, cursor%head, 'a negative number of items', 'write the file again')
    if (binary) call read_line(text, cursor, first, last, found)
    cursor%binary = binary
  end subroutine read_item_count

  !> $Nodes: tag and coordinates of each.
  subroutine read_nodes2(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! takes the nodes
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: n, i, k, tag, at
    real(wp) :: x(3)

    call read_item_count(text, cursor, n)
    do i = 1, n
      if (cursor%failed) exit
      call find_item(text, cursor, at)
      call read_number(text, cursor, tag, 'the tag of a node')
      if (tag < 1) call fail(cursor, at, 'a node with tag '//to_text(tag), 'tags start at 1')
      do k = 1, 3
        call read_real(text, cursor, x(k), 'a coordinate of a node')
      end do
      if (.not. cursor%failed) call add_node(file, tag, x, at)
    end do
  end subroutine read_nodes2

  !> $Elements: tag, type, its tags (the first is the physical group) and nodes of each; in a
  !! binary file the type and the number of tags stand before blocks of elements.
  subroutine read_elements2(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(inout) :: file !! takes the cells
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: n, i, left, tag, kind, tags, at

    call read_item_count(text, cursor, n)
    left = 0
    kind = 0
    tags = 0
    do i = 1, n
      if (cursor%failed) exit
      call find_item(text, cursor, at)
      if (cursor%binary .and. left == 0) then
        call read_number(text, cursor, kind, 'the type of elements')
        call read_number(text, cursor, left, 'the number of elements of a block')
        call read_number(text, cursor, tags, 'the number of tags')
        if (left < 1) call fail(cursor, at, 'a block of '//to_text(left)//' elements', &
          'is the file damaged? write it again')
      end if
      call read_number(text, cursor, tag, 'the tag of an element')
      if (tag < 1) call fail(cursor, at, 'an element with tag '//to_text(tag), 'tags start at 1')
      if (.not. cursor%binary) then
        call read_number(text, cursor, kind, 'the type of an element')
        call read_number(text, cursor, tags, 'the number of tags of an element')
      end if
      call read_element(text, tag, kind, tags, at, file, cursor)
      left = left - 1
    end do
  end subroutine read_elements2

  !> Tags and nodes of one element.
  subroutine read_element(text, tag, kind, tags, at, file, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: tag !! its number
    integer, intent(in) :: kind !! Gmsh's number of its type
    integer, intent(in) :: tags !! how many tags it has
    integer, intent(in) :: at !! character of the file where it stands
    type(file_mesh_t), intent(inout) :: file !! takes the cell
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the element
    integer :: n, dimension, i, number, group, nodes(most_nodes)
    character(:), allocatable :: name

    if (cursor%failed) return
    call gmsh_shape(kind, n, dimension, name)
    if (n == 0) call fail(cursor, at, 'element '//to_text(tag)//' is one of the '//name, &
      gmsh_readable)
    if (tags < 0) call fail(cursor, at, 'element '//to_text(tag)//' has '//to_text(tags)//' tags', &
      'is the file damaged? write it again')
    group = 0
    do i = 1, tags
      if (cursor%failed) exit
      call read_number(text, cursor, number, 'a tag of an element')
      if (i == 1 .and. number > -huge(number)) group = abs(number)
    end do
    do i = 1, n
      call read_number(text, cursor, nodes(i), 'a node of an element')
    end do
    if (.not. cursor%failed) call add_cell(file, tag, from_gmsh(nodes(:n)), dimension, group, at)
  end subroutine read_element
end module gmsh2_sections

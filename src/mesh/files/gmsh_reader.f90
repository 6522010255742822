!> Reads Gmsh MSH files, versions 4.1 and 2.2, text and binary: what both have in common.
module gmsh_reader
  use text, only: to_text
  use file_cursor, only: cursor_t, start_cursor, fail, read_line, read_number, skip_blanks
  use mesh_file_types, only: file_mesh_t, start_file_mesh
  use gmsh_groups, only: physical_t, add_physical, gather_groups
  use gmsh4_sections, only: read_entities4, read_nodes4, read_elements4
  use gmsh_data, only: read_element_data
  use gmsh2_sections, only: read_nodes2, read_elements2
  implicit none
  private
  public :: read_gmsh, is_gmsh

contains

  !> Whether a file begins as an MSH file does.
  pure logical function is_gmsh(text)
    character(*), intent(in) :: text !! the file
    type(cursor_t) :: cursor

    call start_cursor(text, cursor)
    call skip_blanks(text, cursor)
    is_gmsh = .false.
    if (cursor%at > cursor%last) return
    is_gmsh = text(cursor%at:cursor%at) == '$'
  end function is_gmsh

  !> Reads a whole file; the cursor says what is wrong with it, if anything is.
  subroutine read_gmsh(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(out) :: file !! what it holds
    type(cursor_t), intent(out) :: cursor !! failed if it cannot be read
    type(physical_t) :: physical
    integer :: version, first, last
    logical :: found, nodes, elements

    call start_file_mesh(len(text), file)
    call start_cursor(text, cursor)
    nodes = .false.
    elements = .false.
    version = 0
    do
      call read_line(text, cursor, first, last, found)
      if (.not. found) exit
      if (last < first) cycle
      cursor%head = first
      if (text(first:last) == '$Nodes') call note_section(nodes, cursor)
      if (text(first:last) == '$Elements') call note_section(elements, cursor)
      call read_section(text, text(first:last), version, file, physical, cursor)
    end do
    if (.not. (nodes .and. elements)) call fail(cursor, max(1, cursor%last), 'the file has no '// &
      'section '//trim(merge('$Elements', '$Nodes   ', nodes)), 'is the file complete? '// &
      'write it again')
    if (cursor%failed) return
    file%merges = version == 2
    call gather_groups(physical, version, file)
  end subroutine read_gmsh

  !> A section comes once.
  subroutine note_section(there, cursor)
    logical, intent(inout) :: there !! it has been there before; then true
    type(cursor_t), intent(inout) :: cursor !! takes the fault

    if (there) call fail(cursor, cursor%head, 'this section comes a second time', &
      'a mesh file holds one mesh')
    there = .true.
  end subroutine note_section

  !> Reads one section, or passes over it.
  subroutine read_section(text, name, version, file, physical, cursor)
    character(*), intent(in) :: text !! the file
    character(*), intent(in) :: name !! the line that begins the section
    integer, intent(inout) :: version !! 4 or 2, 0 as long as it is not known
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(physical_t), intent(inout) :: physical !! names of groups and who belongs to them
    type(cursor_t), intent(inout) :: cursor !! the place, behind that line

    if (cursor%failed) return
    if (version == 0 .and. name /= '$MeshFormat' .and. name /= '$Comments') call fail(cursor, &
      cursor%head, 'an MSH file begins with $MeshFormat', 'write the mesh with gmsh -format msh41')
    select case (name)
    case ('$MeshFormat')
      call read_format(text, version, cursor)
    case ('$PhysicalNames')
      call read_names(text, physical, cursor)
    case ('$Entities')
      if (version == 4) call read_entities4(text, physical, cursor)
      if (version == 2) call pass_over(text, name, cursor)
    case ('$Nodes')
      if (version == 4) call read_nodes4(text, file, cursor)
      if (version == 2) call read_nodes2(text, file, cursor)
    case ('$Elements')
      if (version == 4) call read_elements4(text, file, physical, cursor)
      if (version == 2) call read_elements2(text, file, cursor)
    case ('$ElementData')
      call read_element_data(text, file, cursor)
    case ('$PartitionedEntities')
      call fail(cursor, cursor%head, 'a partitioned mesh', 'write it without partitions')
    case default
      if (name(1:1) /= '$') then
        call fail(cursor, cursor%head, 'a section is expected, a line that begins with $', &
          'does the section before it hold more than its first line says?')
      else
        call pass_over(text, name, cursor)
        return
      end if
    end select
    call end_section(text, name, cursor)
  end subroutine read_section

  !> $MeshFormat: version, 0 or 1 for binary, bytes of a real number.
  subroutine read_format(text, version, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(inout) :: version !! 4 or 2
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: first, last, blank, kind, bytes, one
    logical :: found

    call read_line(text, cursor, first, last, found)
    if (.not. found) call fail(cursor, cursor%last, 'the file ends in $MeshFormat', &
      'is the file complete? write it again')
    if (cursor%failed) return
    blank = index(text(first:last)//' ', ' ') + first - 2
    select case (text(first:blank))
    case ('4.1')
      version = 4
    case ('2', '2.0', '2.1', '2.2')
      version = 2
    case default
      call fail(cursor, first, 'MSH version '//text(first:min(blank, first + 20))// &
        ' cannot be read', 'versions 4.1 and 2.2 can: gmsh FILE -save -format msh41 -o NEW')
    end select
    cursor%at = min(blank + 1, cursor%last + 1)
    call read_number(text, cursor, kind, 'the file type 0 or 1')
    call read_number(text, cursor, bytes, 'the data size')
    if (kind /= 0 .and. kind /= 1) call fail(cursor, first, 'file type '//to_text(kind), &
      'it is 0 for text and 1 for binary')
    if (bytes /= 8) call fail(cursor, first, 'data size '//to_text(bytes), &
      'this program reads files with numbers of 8 bytes')
    if (cursor%failed .or. kind == 0) return
    call read_line(text, cursor, first, last, found)
    cursor%binary = .true.
    call read_number(text, cursor, one, 'the number 1')
    if (one == 16777216) cursor%swapped = .true.
    if (one /= 1 .and. .not. cursor%swapped) call fail(cursor, cursor%head, &
      'the bytes of this file are in an order this program does not know', 'write it as text')
  end subroutine read_format

  !> $PhysicalNames: a count, then dimension, number and name in quotes; text even in binary files.
  subroutine read_names(text, physical, cursor)
    character(*), intent(in) :: text !! the file
    type(physical_t), intent(inout) :: physical !! takes the names
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: n, i, first, last, dimension, tag, opening, closing
    logical :: found, binary

    binary = cursor%binary
    cursor%binary = .false.
    call read_number(text, cursor, n, 'the number of names')
    do i = 1, n
      if (cursor%failed) exit
      call read_number(text, cursor, dimension, 'the dimension of a group')
      call read_number(text, cursor, tag, 'the number of a group')
      call skip_blanks(text, cursor)
      call read_line(text, cursor, first, last, found)
      if (cursor%failed) exit
      opening = 0
      closing = 0
      if (first <= last) opening = index(text(first:last), '"')
      if (first <= last) closing = index(text(first:last), '"', back=.true.)
      if (opening /= 1 .or. closing < 3) then
        call fail(cursor, min(first, cursor%last), 'the name of group '//to_text(tag)// &
          ' is expected, in double quotes', 'is the file damaged? write it again')
        exit
      end if
      if (dimension < 0 .or. dimension > 3) call fail(cursor, first, 'a group of dimension '// &
        to_text(dimension), 'it is 0 to 3')
      call add_physical(physical, dimension, tag, text(first + 1:first + closing - 2), first)
    end do
    cursor%binary = binary
  end subroutine read_names

  !> The line that ends a section.
  subroutine end_section(text, name, cursor)
    character(*), intent(in) :: text !! the file
    character(*), intent(in) :: name !! the line that began it
    type(cursor_t), intent(inout) :: cursor !! the place; then behind that line
    integer :: first, last
    logical :: found

    if (cursor%failed) return
    call skip_blanks(text, cursor)
    call read_line(text, cursor, first, last, found)
    if (found) then
      if (text(first:last) == '$End'//name(2:)) return
    end if
    call fail(cursor, min(first, cursor%last), '$End'//name(2:)//' is expected here', &
      'does the section hold more or less than its first line says?')
  end subroutine end_section

  !> Passes over a section that this program has no use for.
  subroutine pass_over(text, name, cursor)
    character(*), intent(in) :: text !! the file
    character(*), intent(in) :: name !! the line that began it
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the section
    integer :: length

    if (cursor%failed) return
    length = index(text(cursor%at:), '$End'//name(2:))
    if (length == 0) then
      call fail(cursor, cursor%head, 'this section has no end', '$End'//name(2:)//' ends it')
      return
    end if
    cursor%at = cursor%at + length - 1 + len(name) + 3
  end subroutine pass_over
end module gmsh_reader

!> Reads the mesh of an Abaqus or CalculiX input file: nodes, elements, sets and surfaces.
module abaqus_reader
  use kinds, only: wp
  use text, only: to_text, upper
  use file_cursor, only: cursor_t, start_cursor, fail, number_of, real_of
  use cells, only: most_nodes
  use mesh_file_types, only: file_mesh_t, start_file_mesh, add_node, add_cell, add_group, &
    add_member, add_remark, find_group, group_nodes, group_cells
  use abaqus_cards, only: card_t, next_card, next_data, next_item, card_parameter, has_parameter, &
    abaqus_shape
  use abaqus_sets, only: requests_t, read_set, read_surface, read_section, fill_groups
  implicit none
  private
  public :: read_abaqus

contains

  !> Reads a whole file; the cursor says what is wrong with it, if anything is.
  subroutine read_abaqus(text, file, cursor)
    character(*), intent(in) :: text !! the file
    type(file_mesh_t), intent(out) :: file !! what it holds
    type(cursor_t), intent(out) :: cursor !! failed if it cannot be read
    type(requests_t) :: requests
    type(card_t) :: card
    logical :: found
    integer :: parts

    call start_file_mesh(file)
    call start_cursor(text, cursor)
    parts = 0
    do
      call next_card(text, cursor, card, found)
      if (.not. found) exit
      if (card%name == 'part') parts = parts + 1
      if (parts > 1) call fail(cursor, card%at, 'a second *PART', 'write one part, or '// &
        'the input file without parts and assemblies')
      call obey_card(text, card, file, requests, cursor)
      if (cursor%failed) return
    end do
    if (file%nodes == 0) call fail(cursor, max(1, cursor%last), 'the file has no *NODE', &
      'is it a mesh? Gmsh''s files begin with $MeshFormat')
    if (.not. cursor%failed) call fill_groups(text, requests, file, cursor)
  end subroutine read_abaqus

  !> Reads what belongs to the mesh and passes over the rest.
  subroutine obey_card(text, card, file, requests, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(requests_t), intent(inout) :: requests !! members of groups by number and name
    type(cursor_t), intent(inout) :: cursor !! the place

    if (has_parameter(card, 'input')) call fail(cursor, card%at, '*'//upper(card%name)// &
      ' with INPUT=', 'put the data into this file')
    select case (card%name)
    case ('node')
      call read_nodes(text, card, file, cursor)
    case ('element')
      call read_elements(text, card, file, cursor)
    case ('nset', 'elset')
      call read_set(text, card, file, requests, cursor)
    case ('surface')
      call read_surface(text, card, file, requests, cursor)
    case ('solid section')
      call read_section(card, requests)
    case ('ngen', 'nfill', 'ncopy', 'nmap', 'elgen', 'elcopy', 'system', 'include', 'submodel')
      call fail(cursor, card%at, '*'//upper(card%name)//' is not available in this version', &
        'write nodes and elements one by one')
    case ('instance')
      call refuse_placement(text, cursor)
    case ('heading', 'part', 'end part', 'assembly', 'end assembly', 'end instance', 'preprint', &
      'restart', 'node print', 'node file', 'el file', 'el print', 'output')
    case default
      call add_remark(file, '*'//upper(card%name)//' is passed over: only the mesh is read')
    end select
  end subroutine obey_card

  !> An instance must stand where its part does.
  subroutine refuse_placement(text, cursor)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place
    integer :: first, last
    logical :: found

    call next_data(text, cursor, first, last, found)
    if (found) call fail(cursor, first, 'an *INSTANCE that is moved or turned', &
      'write the input file without parts and assemblies')
  end subroutine refuse_placement

  !> *NODE: number and coordinates; missing coordinates are 0.
  subroutine read_nodes(text, card, file, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the nodes
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: group, start, end, at, first, last, tag, k
    real(wp) :: x(3)
    logical :: found

    if (has_parameter(card, 'system')) call fail(cursor, card%at, '*NODE with SYSTEM=', &
      'give rectangular coordinates')
    group = wanted_group(card, 'nset', group_nodes, file)
    do while (.not. cursor%failed)
      call next_data(text, cursor, start, end, found)
      if (.not. found) return
      at = start
      call next_item(text, at, end, first, last, found)
      call number_of(text, first, last, cursor, tag, 'the number of a node')
      if (tag < 1) call fail(cursor, first, 'a node with number '//to_text(tag), &
        'node numbers start at 1')
      x = 0.0_wp
      do k = 1, 3
        call next_item(text, at, end, first, last, found)
        if (.not. found) exit
        if (last < first) cycle
        call real_of(text, first, last, cursor, x(k), 'a coordinate of a node')
      end do
      if (cursor%failed) return
      call add_node(file, tag, x, start)
      if (group > 0) call add_member(file%group(group), file%nodes, 0)
    end do
  end subroutine read_nodes

  !> *ELEMENT: number and nodes, which may go on in further lines.
  subroutine read_elements(text, card, file, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the cells
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: nodes, corners, group, start, end, at, first, last, n, numbers(0:most_nodes)
    logical :: found

    call abaqus_shape(card_parameter(card, 'type'), nodes, corners)
    if (corners == 0) then
      call refuse_type(card_parameter(card, 'type'), card%at, cursor)
      return
    end if
    group = wanted_group(card, 'elset', group_cells, file)
    n = 0
    do while (.not. cursor%failed)
      call next_data(text, cursor, start, end, found)
      if (.not. found) exit
      at = start
      do while (.not. cursor%failed)
        call next_item(text, at, end, first, last, found)
        if (.not. found) exit
        if (n > nodes) call fail(cursor, first, 'element '//to_text(numbers(0))// &
          ' has more than '//to_text(nodes)//' nodes', 'do type and data of *ELEMENT agree?')
        if (cursor%failed) return
        call number_of(text, first, last, cursor, numbers(n), 'the number of an element or node')
        if (numbers(n) < 1) call fail(cursor, first, 'number '//to_text(numbers(n)), &
          'numbers start at 1')
        n = n + 1
      end do
      if (n <= nodes .or. cursor%failed) cycle
      call add_cell(file, numbers(0), numbers(1:nodes), corners, 0, start)
      if (group > 0) call add_member(file%group(group), file%cells, 0)
      n = 0
    end do
    if (n > 0) call fail(cursor, min(cursor%at, cursor%last), 'the last element of '// &
      'this *ELEMENT has not all of its '//to_text(nodes)//' nodes', &
      'is the file complete? write it again')
  end subroutine read_elements

  !> Reports an element type that cannot be read.
  subroutine refuse_type(name, at, cursor)
    character(*), intent(in) :: name !! TYPE= of the card
    integer, intent(in) :: at !! character of the file where it stands
    type(cursor_t), intent(inout) :: cursor !! takes the fault

    if (name == '') then
      call fail(cursor, at, '*ELEMENT without TYPE=', 'TYPE=C3D4 is the tetrahedron of 4 nodes')
    else
      call fail(cursor, at, 'elements of type '//name//' cannot be read', 'this version reads '// &
        'tetrahedra (C3D4, C3D10), and triangles (S3, S6, ...) and lines (T3D2, B31, ...) on them')
    end if
  end subroutine refuse_type

  !> The group that a card puts its items into, made if it is new; 0 if it names none.
  integer function wanted_group(card, parameter, kind, file) result(group)
    type(card_t), intent(in) :: card !! the card
    character(*), intent(in) :: parameter !! nset or elset
    integer, intent(in) :: kind !! what its members are
    type(file_mesh_t), intent(inout) :: file !! the groups
    character(:), allocatable :: name

    name = card_parameter(card, parameter)
    group = 0
    if (name == '') return
    group = find_group(file, name, kind)
    if (group > 0) return
    call add_group(file, name, kind, card%at)
    group = file%groups
  end function wanted_group
end module abaqus_reader

!> Reads the mesh of an Abaqus or CalculiX input file: nodes, elements, sets and surfaces.
module abaqus_reader
  use kinds, only: wp
  use text, only: to_text, upper, lower
  use file_cursor, only: cursor_t, start_cursor, fail, number_of, real_of
  use cells, only: most_nodes
  use mesh_file_types, only: file_mesh_t, start_file_mesh, add_node, add_cell, add_group, &
    add_member, add_remark, group_nodes, group_cells, rigid_cell
  use abaqus_cards, only: card_t, next_card, next_data, next_item, card_parameter, has_parameter, &
    abaqus_shape
  use abaqus_assembly, only: assembly_t, find_parts, find_part, open_instance, moved, take_number
  use abaqus_sets, only: requests_t, read_set, read_surface, read_section, open_group
  use abaqus_groups, only: fill_groups
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
    type(assembly_t) :: assembly
    type(card_t) :: card
    logical :: found

    call start_file_mesh(len(text), file)
    call start_cursor(text, cursor)
    call find_parts(text, cursor, assembly)
    do
      call next_card(text, cursor, card, found)
      if (.not. found) exit
      select case (card%name)
      case ('part')
        call pass_part(card, assembly, cursor)
      case ('instance')
        call read_instance(text, card, file, requests, assembly, cursor)
      case ('end instance')
        assembly%current = 0
      case default
        call obey_card(text, card, file, requests, assembly, cursor)
      end select
      if (cursor%failed) return
    end do
    if (file%nodes == 0) call fail(cursor, max(1, cursor%last), 'the file has no *NODE', &
      'is it a mesh? Files of Gmsh (they begin with $MeshFormat), Abaqus, CalculiX and STL are '// &
      'read; gmsh and meshio turn others into these')
    if (.not. cursor%failed) call fill_groups(text, requests, assembly, file, cursor)
  end subroutine read_abaqus

  !> *PART: its body is read for each of its instances; without any it is read where it stands.
  subroutine pass_part(card, assembly, cursor)
    type(card_t), intent(in) :: card !! the card
    type(assembly_t), intent(in) :: assembly !! parts
    type(cursor_t), intent(inout) :: cursor !! the place; behind the part if it has instances
    integer :: p

    if (assembly%instances == 0 .and. assembly%parts > 1) call fail(cursor, card%at, &
      'several *PART and no *INSTANCE', 'an *ASSEMBLY says which parts there are, and where')
    if (assembly%instances == 0) return
    do p = 1, assembly%parts
      if (assembly%part(p)%first /= cursor%at) cycle
      if (assembly%part(p)%last == huge(1)) call fail(cursor, card%at, '*PART without *END PART', &
        'is the file complete? write it again')
      if (.not. cursor%failed) cursor%at = assembly%part(p)%last + 1
    end do
  end subroutine pass_part

  !> *INSTANCE: the cards of its part, moved and with numbers of their own; what follows up to
  !! *END INSTANCE belongs to it as well.
  subroutine read_instance(text, card, file, requests, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(requests_t), intent(inout) :: requests !! members of groups by number and name
    type(assembly_t), intent(inout) :: assembly !! parts and instances
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data of the card
    type(cursor_t) :: part
    type(card_t) :: inner
    integer :: p, cells
    logical :: found

    p = find_part(assembly, card_parameter(card, 'part'))
    if (p == 0) call fail(cursor, card%at, 'there is no *PART '//card_parameter(card, 'part'), &
      'is it misspelt? parts stand in the file, before the *ASSEMBLY')
    if (.not. cursor%failed) call open_instance(text, card, assembly, cursor)
    if (cursor%failed) return
    cells = file%cells
    part = cursor
    part%at = assembly%part(p)%first
    part%last = min(assembly%part(p)%last, cursor%last)
    do
      call next_card(text, part, inner, found)
      if (.not. found) exit
      call obey_card(text, inner, file, requests, assembly, part)
    end do
    if (part%failed) call fail(cursor, part%fault, part%what, part%remedy)
    if (assembly%instances > 1) call name_instance(card, cells, file)
  end subroutine read_instance

  !> The elements of an instance get its name.
  subroutine name_instance(card, before, file)
    type(card_t), intent(in) :: card !! *INSTANCE
    integer, intent(in) :: before !! cells that the file had before
    type(file_mesh_t), intent(inout) :: file !! gets the group
    integer :: c
    logical :: rigid

    rigid = all(file%mark(before + 1:file%cells) == rigid_cell)
    call add_group(file, card_parameter(card, 'name'), group_cells, card%at)
    do c = before + 1, file%cells
      if (file%dimension(c) == 3 .or. rigid .and. file%mark(c) == rigid_cell) &
        call add_member(file%group(file%groups), c, 0)
    end do
  end subroutine name_instance

  !> Reads what belongs to the mesh and passes over the rest.
  subroutine obey_card(text, card, file, requests, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(requests_t), intent(inout) :: requests !! members of groups by number and name
    type(assembly_t), intent(inout) :: assembly !! parts and instances
    type(cursor_t), intent(inout) :: cursor !! the place

    select case (card%name)
    case ('node')
      call read_nodes(text, card, file, assembly, cursor)
    case ('element')
      call read_elements(text, card, file, assembly, cursor)
    case ('nset', 'elset')
      call read_set(text, card, file, requests, assembly, cursor)
    case ('surface')
      call read_surface(text, card, file, requests, assembly, cursor)
    case ('solid section')
      call read_section(card, assembly%current, requests)
    case ('ngen', 'nfill', 'ncopy', 'nmap', 'elgen', 'elcopy', 'system', 'submodel')
      call fail(cursor, card%at, '*'//upper(card%name)//' is not available in this version', &
        'write nodes and elements one by one')
    case ('heading', 'end part', 'assembly', 'end assembly', 'preprint', 'include', 'restart', &
       'node print', 'node file', 'el file', 'el print', 'output')
    case default
      call add_remark(file, '*'//upper(card%name)//' is passed over: only the mesh is read')
    end select
  end subroutine obey_card

  !> *NODE: number and coordinates; missing coordinates are 0.
  subroutine read_nodes(text, card, file, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the nodes
    type(assembly_t), intent(inout) :: assembly !! numbers of the instance
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: group, start, end, at, first, last, tag, number, k
    real(wp) :: x(3)
    logical :: found

    if (has_parameter(card, 'system')) call fail(cursor, card%at, '*NODE with SYSTEM=', &
      'give rectangular coordinates')
    group = wanted_group(card, 'nset', group_nodes, assembly%current, file)
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
      call take_number(assembly, 1, tag, start, cursor, number)
      call add_node(file, number, moved(assembly%scope(assembly%current), x), start)
      if (group > 0) call add_member(file%group(group), file%nodes, 0)
    end do
  end subroutine read_nodes

  !> *ELEMENT: number and nodes, which may go on in further lines.
  subroutine read_elements(text, card, file, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the cells
    type(assembly_t), intent(inout) :: assembly !! numbers of the instance
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    integer :: nodes, dimension, group, start, end, at, first, last, n, numbers(0:most_nodes), tag
    integer :: mark
    logical :: found

    call abaqus_shape(card_parameter(card, 'type'), nodes, dimension)
    if (nodes == 0) then
      call refuse_type(card_parameter(card, 'type'), card%at, cursor)
      return
    end if
    group = wanted_group(card, 'elset', group_cells, assembly%current, file)
    mark = 0
    if (index(lower(card_parameter(card, 'type')), 'r3d') == 1) mark = rigid_cell
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
      call take_number(assembly, 2, numbers(0), start, cursor, tag)
      call add_cell(file, tag, numbers(1:nodes) + assembly%scope(assembly%current)%shift(1), &
        dimension, mark, start)
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
        'tetrahedra (C3D4, C3D10), triangles (S3, S6, ...) and '// &
        'lines (T3D2, B31, ...) on them, and rigid R3D3 and R3D4')
    end if
  end subroutine refuse_type

  !> The group that a card puts its items into, made if it is new; 0 if it names none.
  integer function wanted_group(card, parameter, kind, scope, file) result(group)
    type(card_t), intent(in) :: card !! the card
    character(*), intent(in) :: parameter !! nset or elset
    integer, intent(in) :: kind !! what its members are
    integer, intent(in) :: scope !! instance that it belongs to
    type(file_mesh_t), intent(inout) :: file !! the groups
    character(:), allocatable :: name

    name = card_parameter(card, parameter)
    group = 0
    if (name /= '') call open_group(name, kind, card%at, scope, file, group)
  end function wanted_group
end module abaqus_reader

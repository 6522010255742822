!> *NSET, *ELSET, *SURFACE and *SOLID SECTION of Abaqus and CalculiX input files.
!!
!! Sets may list what the file defines only later, and each other by name. So the reader keeps
!! requests and fills the groups when it has seen the whole file.
module abaqus_sets
  use text, only: to_text, upper, lower
  use numbers, only: is_digit
  use file_cursor, only: cursor_t, fail, number_of
  use mesh_file_types, only: file_mesh_t, add_group, add_member, find_group, group_nodes, &
    group_cells, group_faces
  use abaqus_cards, only: card_t, next_data, next_item, card_parameter, has_parameter
  use tag_table, only: tag_table_t, build_table, find_tag
  implicit none
  private
  public :: requests_t, read_set, read_surface, read_section, fill_groups

  !> Something that belongs to a group: a range of numbers, or all members of another group.
  type :: request_t
    integer :: group = 0 !! the group that it joins
    integer :: first = 0 !! first number of the range
    integer :: last = 0 !! last number of the range
    integer :: step = 1 !! increment of the range
    integer :: face = 0 !! the face, or 0
    integer :: name_at = 0 !! first character of the other group's name, 0 for a range
    integer :: name_end = 0 !! last character of that name
    integer :: at = 1 !! character of the file where it stands
    character(:), allocatable :: name !! name of an element set whose nodes are wanted
  end type request_t

  !> What is to be filled in when the file has been read.
  type :: requests_t
    integer :: count = 0 !! requests
    type(request_t), allocatable :: list(:) !! may be larger than count
    integer :: sections = 0 !! sections
    type(card_t), allocatable :: section(:) !! cards of the sections
  end type requests_t

contains

  !> *NSET and *ELSET: numbers, names of other sets, or with GENERATE first, last, increment.
  subroutine read_set(text, card, file, requests, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the group
    type(requests_t), intent(inout) :: requests !! takes its members
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    type(request_t) :: request
    integer :: kind, start, end
    logical :: found
    character(:), allocatable :: name

    kind = merge(group_nodes, group_cells, card%name == 'nset')
    name = card_parameter(card, card%name)
    if (name == '') call fail(cursor, card%at, '*'//upper(card%name)//' without a name', &
      'write *'//upper(card%name)//', '//upper(card%name)//'=name')
    if (cursor%failed) return
    call open_group(name, kind, card%at, file, request%group)
    if (kind == group_nodes .and. card_parameter(card, 'elset') /= '') then
      request%name = card_parameter(card, 'elset')
      request%at = card%at
      call add_request(requests, request)
      return
    end if
    do while (.not. cursor%failed)
      call next_data(text, cursor, start, end, found)
      if (.not. found) exit
      if (has_parameter(card, 'generate')) then
        call read_range(text, start, end, request, requests, cursor)
      else
        call read_members(text, start, end, request, requests, cursor)
      end if
    end do
  end subroutine read_set

  !> The group of this name and kind, made if it is new.
  subroutine open_group(name, kind, at, file, group)
    character(*), intent(in) :: name !! its name
    integer, intent(in) :: kind !! what its members are
    integer, intent(in) :: at !! character of the file where the card stands
    type(file_mesh_t), intent(inout) :: file !! the groups
    integer, intent(out) :: group !! its number

    group = find_group(file, name, kind)
    if (group > 0) return
    call add_group(file, name, kind, at)
    group = file%groups
  end subroutine open_group

  !> One line of GENERATE.
  subroutine read_range(text, start, end, request, requests, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: start !! first character of the line
    integer, intent(in) :: end !! last character of the line
    type(request_t), intent(inout) :: request !! knows the group
    type(requests_t), intent(inout) :: requests !! takes the range
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: at, k, first, last, numbers(3)
    logical :: found

    numbers = [0, -1, 1]
    at = start
    do k = 1, 3
      call next_item(text, at, end, first, last, found)
      if (found .and. last >= first) call number_of(text, first, last, cursor, numbers(k), &
        'first, last or increment of a range')
    end do
    if (cursor%failed) return
    if (numbers(1) < 1 .or. numbers(2) < numbers(1) .or. numbers(3) < 1) then
      call fail(cursor, start, 'a range from '//to_text(numbers(1))//' to '// &
        to_text(numbers(2))//' by '//to_text(numbers(3)), 'GENERATE takes first, last, increment')
      return
    end if
    request%first = numbers(1)
    request%last = numbers(2)
    request%step = numbers(3)
    request%name_at = 0
    request%at = start
    call add_request(requests, request)
  end subroutine read_range

  !> One line of numbers and names.
  subroutine read_members(text, start, end, request, requests, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: start !! first character of the line
    integer, intent(in) :: end !! last character of the line
    type(request_t), intent(inout) :: request !! knows the group
    type(requests_t), intent(inout) :: requests !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: at, first, last
    logical :: found

    at = start
    do while (.not. cursor%failed)
      call next_item(text, at, end, first, last, found)
      if (.not. found) return
      if (last < first) cycle
      call read_member(text, first, last, request, cursor)
      call add_request(requests, request)
    end do
  end subroutine read_members

  !> A number or a name.
  subroutine read_member(text, first, last, request, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: first !! first character
    integer, intent(in) :: last !! last character
    type(request_t), intent(inout) :: request !! takes it
    type(cursor_t), intent(inout) :: cursor !! takes the fault

    request%at = first
    request%name_at = 0
    if (is_digit(text(first:first)) .or. scan(text(first:first), '+-') > 0) then
      call number_of(text, first, last, cursor, request%first, 'a number or the name of a set')
      request%last = request%first
      request%step = 1
      return
    end if
    request%name_at = first
    request%name_end = last
    if (text(first:first) /= '"' .or. last < first + 2) return
    if (text(last:last) /= '"') return
    request%name_at = first + 1
    request%name_end = last - 1
  end subroutine read_member

  !> *SURFACE: faces S1 to S4 of elements or element sets, sets of triangles, or nodes.
  subroutine read_surface(text, card, file, requests, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the group
    type(requests_t), intent(inout) :: requests !! takes its members
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    type(request_t) :: request
    integer :: start, end, at, first, last, kind
    logical :: found

    select case (lower(card_parameter(card, 'type')))
    case ('', 'element', 's')
      kind = group_faces
    case ('node', 'n')
      kind = group_nodes
    case default
      call fail(cursor, card%at, '*SURFACE of type '//card_parameter(card, 'type'), &
        'this version reads TYPE=ELEMENT and TYPE=NODE')
    end select
    if (card_parameter(card, 'name') == '') call fail(cursor, card%at, &
      '*SURFACE without a name', 'write *SURFACE, NAME=name')
    if (cursor%failed) return
    call open_group(card_parameter(card, 'name'), kind, card%at, file, request%group)
    do while (.not. cursor%failed)
      call next_data(text, cursor, start, end, found)
      if (.not. found) exit
      at = start
      call next_item(text, at, end, first, last, found)
      if (last < first) cycle
      call read_member(text, first, last, request, cursor)
      call next_item(text, at, end, first, last, found)
      request%face = 0
      if (kind == group_faces .and. first <= last) then
        request%face = face_number(text(first:last))
        if (request%face < 0) call fail(cursor, first, 'face '//text(first:min(last, first + 20)), &
          'a tetrahedron has the faces S1 to S4')
      end if
      if (.not. cursor%failed) call add_request(requests, request)
    end do
  end subroutine read_surface

  !> Number of a face, 0 for the sides of a triangle, -1 for what is none.
  pure integer function face_number(name) result(face)
    character(*), intent(in) :: name !! as written

    select case (lower(name))
    case ('s1', 's2', 's3', 's4')
      face = iachar(name(2:2)) - iachar('0')
    case ('spos', 'sneg', 'sp', 'sn')
      face = 0
    case default
      face = -1
    end select
  end function face_number

  !> *SOLID SECTION: keeps the name of the material of an element set.
  subroutine read_section(card, requests)
    type(card_t), intent(in) :: card !! the card
    type(requests_t), intent(inout) :: requests !! takes it
    type(card_t), allocatable :: more(:)

    allocate (more(requests%sections + 1))
    if (requests%sections > 0) more(:requests%sections) = requests%section
    more(requests%sections + 1) = card
    call move_alloc(more, requests%section)
    requests%sections = requests%sections + 1
  end subroutine read_section

  !> Adds a request to a list that grows by doubling.
  subroutine add_request(requests, request)
    type(requests_t), intent(inout) :: requests !! the list
    type(request_t), intent(in) :: request !! the request
    type(request_t), allocatable :: more(:)

    if (.not. allocated(requests%list)) allocate (requests%list(64))
    if (requests%count == size(requests%list)) then
      allocate (more(2*requests%count))
      more(:requests%count) = requests%list
      call move_alloc(more, requests%list)
    end if
    requests%count = requests%count + 1
    requests%list(requests%count) = request
  end subroutine add_request

  !> Fills the groups, element sets first, then node sets, then surfaces. A set that names another
  !! one takes what that has got so far in the file.
  subroutine fill_groups(text, requests, file, cursor)
    character(*), intent(in) :: text !! the file
    type(requests_t), intent(in) :: requests !! members by number and name
    type(file_mesh_t), intent(inout) :: file !! takes them
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    type(tag_table_t) :: nodes, cells
    integer, parameter :: order(3) = [group_cells, group_nodes, group_faces]
    integer :: i, pass, g

    call build_table(file%node_tag(:file%nodes), nodes)
    call build_table(file%cell_tag(:file%cells), cells)
    do pass = 1, 3
      do i = 1, requests%count
        if (cursor%failed) return
        if (file%group(requests%list(i)%group)%kind /= order(pass)) cycle
        if (order(pass) == group_nodes) then
          call fill_nodes(text, requests%list(i), nodes, file, cursor)
        else
          call fill_cells(text, requests%list(i), cells, file, cursor)
        end if
      end do
    end do
    do i = 1, requests%sections
      associate (card => requests%section(i))
        g = find_group(file, card_parameter(card, 'elset'), group_cells)
        if (g > 0) file%group(g)%material = card_parameter(card, 'material')
      end associate
    end do
  end subroutine fill_groups

  !> Obeys one request for nodes.
  subroutine fill_nodes(text, request, nodes, file, cursor)
    character(*), intent(in) :: text !! the file
    type(request_t), intent(in) :: request !! the request
    type(tag_table_t), intent(in) :: nodes !! places of the node numbers
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: other, i, k, place, tag, end

    place = 0
    associate (group => file%group(request%group))
      if (allocated(request%name)) then
        other = find_group(file, request%name, group_cells)
        if (other == 0) call fail(cursor, request%at, 'there is no *ELSET '//request%name, &
          'is it misspelt?')
        if (cursor%failed) return
        do i = 1, file%group(other)%count
          associate (cell => file%group(other)%members(i))
            do k = 1, file%size(cell)
              place = find_tag(nodes, file%corners(k, cell))
              if (place > 0) call add_member(group, place, 0)
            end do
            do k = 1, count(file%middles(:, cell) /= 0)
              place = find_tag(nodes, file%middles(k, cell))
              if (place > 0) call add_member(group, place, 0)
            end do
          end associate
        end do
      else if (request%name_at > 0) then
        call join_group(text, request, group_nodes, file, cursor)
      else
        end = min(request%last, maxval(file%node_tag(:file%nodes)))
        if (request%first == request%last) end = request%last
        do tag = request%first, end, request%step
          place = find_tag(nodes, tag)
          if (place > 0) call add_member(group, place, 0)
        end do
        if (place == 0 .and. request%first == request%last) call fail(cursor, request%at, &
          'there is no node '//to_text(request%first), 'a set takes nodes of this file')
      end if
    end associate
  end subroutine fill_nodes

  !> Obeys one request for elements or their faces.
  subroutine fill_cells(text, request, cells, file, cursor)
    character(*), intent(in) :: text !! the file
    type(request_t), intent(in) :: request !! the request
    type(tag_table_t), intent(in) :: cells !! places of the element numbers
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: place, tag, end

    if (request%name_at > 0) then
      call join_group(text, request, group_cells, file, cursor)
      return
    end if
    end = request%last
    if (request%first < request%last .and. file%cells > 0) end = min(end, &
      maxval(file%cell_tag(:file%cells)))
    place = 0
    do tag = request%first, end, request%step
      place = find_tag(cells, tag)
      if (place > 0) call add_member(file%group(request%group), place, request%face)
    end do
    if (place == 0 .and. request%first == request%last) call fail(cursor, request%at, &
      'there is no element '//to_text(request%first), 'a set takes elements of this file')
  end subroutine fill_cells

  !> Adds the members that another group has.
  subroutine join_group(text, request, kind, file, cursor)
    character(*), intent(in) :: text !! the file
    type(request_t), intent(in) :: request !! names the other group
    integer, intent(in) :: kind !! what the members of that group are
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: other, i

    associate (name => text(request%name_at:request%name_end))
      other = find_group(file, name, kind)
      if (other > 0) then
        ! what comes later in the file is not there yet
        if (file%group(other)%at > request%at .and. &
          file%group(request%group)%kind == kind) other = 0
      end if
      if (other == 0 .or. other == request%group) then
        call fail(cursor, request%at, 'there is no *'// &
          trim(merge('NSET ', 'ELSET', kind == group_nodes))//' '//name//' before this', &
          'is it misspelt?')
        return
      end if
    end associate
    do i = 1, file%group(other)%count
      call add_member(file%group(request%group), file%group(other)%members(i), request%face)
    end do
  end subroutine join_group
end module abaqus_sets

!> *NSET, *ELSET, *SURFACE and *SOLID SECTION of Abaqus and CalculiX input files.
!!
!! Sets may list what the file defines only later, and each other by name. So the reader keeps
!! requests; `abaqus_groups` fills the groups when the whole file has been seen.
module abaqus_sets
  use text, only: to_text, upper, lower
  use numbers, only: is_digit
  use cells, only: most_cell_facets
  use file_cursor, only: cursor_t, fail, number_of
  use mesh_file_types, only: file_mesh_t, add_group, find_group, group_nodes, group_cells, &
    group_faces
  use abaqus_assembly, only: assembly_t, find_instance
  use abaqus_cards, only: card_t, next_data, next_item, card_parameter, has_parameter
  implicit none
  private
  public :: request_t, requests_t, read_set, read_surface, read_section, open_group

  !> Something that belongs to a group: a range of numbers, or all members of another group.
  type :: request_t
    integer :: group = 0 !! the group that it joins
    integer :: first = 0 !! first number of the range
    integer :: last = 0 !! last number of the range
    integer :: step = 1 !! increment of the range
    integer :: face = 0 !! the face, or 0
    integer :: items = 1 !! numbers are those of nodes (1) or elements (2)
    integer :: scope = 0 !! instance that numbers and names belong to, 0 for none
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
    integer, allocatable :: section_scope(:) !! instance of each
  end type requests_t

contains

  !> *NSET and *ELSET: numbers, names of other sets, or with GENERATE first, last, increment.
  subroutine read_set(text, card, file, requests, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the group
    type(requests_t), intent(inout) :: requests !! takes its members
    type(assembly_t), intent(in) :: assembly !! the instance that is read
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    type(request_t) :: request
    integer :: kind, start, end
    logical :: found
    character(:), allocatable :: name

    kind = merge(group_nodes, group_cells, card%name == 'nset')
    request%items = merge(1, 2, kind == group_nodes)
    name = card_parameter(card, card%name)
    if (name == '') call fail(cursor, card%at, '*'//upper(card%name)//' without a name', &
      'write *'//upper(card%name)//', '//upper(card%name)//'=name')
    if (cursor%failed) return
    call open_group(name, kind, card%at, assembly%current, file, request%group)
    call take_scope(card, assembly, request, cursor)
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
        call read_range(text, start, end, request, requests, assembly, cursor)
      else
        call read_members(text, start, end, request, requests, assembly, cursor)
      end if
    end do
  end subroutine read_set

  !> The instance that the numbers of a set belong to.
  subroutine take_scope(card, assembly, request, cursor)
    type(card_t), intent(in) :: card !! the card
    type(assembly_t), intent(in) :: assembly !! the instance that is read
    type(request_t), intent(inout) :: request !! gets scope
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    character(:), allocatable :: name

    request%scope = assembly%current
    name = card_parameter(card, 'instance')
    if (name == '') return
    request%scope = find_instance(assembly, name)
    if (request%scope == 0) call fail(cursor, card%at, 'there is no *INSTANCE '//name// &
      ' before this', 'is it misspelt?')
  end subroutine take_scope

  !> The group of this name and kind, made if it is new.
  subroutine open_group(name, kind, at, scope, file, group)
    character(*), intent(in) :: name !! its name
    integer, intent(in) :: kind !! what its members are
    integer, intent(in) :: at !! character of the file where the card stands
    integer, intent(in) :: scope !! instance that it belongs to
    type(file_mesh_t), intent(inout) :: file !! the groups
    integer, intent(out) :: group !! its number

    group = find_group(file, name, kind, scope)
    if (group > 0) return
    call add_group(file, name, kind, at, scope)
    group = file%groups
  end subroutine open_group

  !> One line of GENERATE.
  subroutine read_range(text, start, end, request, requests, assembly, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: start !! first character of the line
    integer, intent(in) :: end !! last character of the line
    type(request_t), intent(inout) :: request !! knows the group
    type(requests_t), intent(inout) :: requests !! takes the range
    type(assembly_t), intent(in) :: assembly !! shifts of numbers
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
    call shift_numbers(assembly, request, cursor)
    call add_request(requests, request)
  end subroutine read_range

  !> One line of numbers and names.
  subroutine read_members(text, start, end, request, requests, assembly, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: start !! first character of the line
    integer, intent(in) :: end !! last character of the line
    type(request_t), intent(inout) :: request !! knows the group
    type(requests_t), intent(inout) :: requests !! takes the members
    type(assembly_t), intent(in) :: assembly !! shifts of numbers
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: at, first, last
    logical :: found

    at = start
    do while (.not. cursor%failed)
      call next_item(text, at, end, first, last, found)
      if (.not. found) return
      if (last < first) cycle
      call read_member(text, first, last, request, assembly, cursor)
      call add_request(requests, request)
    end do
  end subroutine read_members

  !> A number or a name.
  subroutine read_member(text, first, last, request, assembly, cursor)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: first !! first character
    integer, intent(in) :: last !! last character
    type(request_t), intent(inout) :: request !! takes it; knows kind and scope
    type(assembly_t), intent(in) :: assembly !! shifts of numbers
    type(cursor_t), intent(inout) :: cursor !! takes the fault

    request%at = first
    request%name_at = 0
    if (is_digit(text(first:first)) .or. scan(text(first:first), '+-') > 0) then
      call number_of(text, first, last, cursor, request%first, 'a number or the name of a set')
      request%last = request%first
      request%step = 1
      call shift_numbers(assembly, request, cursor)
      return
    end if
    request%name_at = first
    request%name_end = last
    if (text(first:first) /= '"' .or. last < first + 2) return
    if (text(last:last) /= '"') return
    request%name_at = first + 1
    request%name_end = last - 1
  end subroutine read_member

  !> Numbers of a scope become those of the whole file.
  subroutine shift_numbers(assembly, request, cursor)
    type(assembly_t), intent(in) :: assembly !! shifts of numbers
    type(request_t), intent(inout) :: request !! its range is shifted
    type(cursor_t), intent(inout) :: cursor !! takes the fault

    if (cursor%failed) return
    if (request%scope == 0 .and. assembly%opened == 1 .and. &
      assembly%scope(0)%top(request%items) == 0) request%scope = 1
    associate (scope => assembly%scope(request%scope))
      if (scope%top(request%items) == 0 .and. request%scope == 0 .and. assembly%opened > 1) call &
        fail(cursor, request%at, 'a number in a set of an assembly that has none of its own', &
        'write INSTANCE=name on its card')
      request%first = min(request%first, huge(1) - scope%shift(request%items)) &
        + scope%shift(request%items)
      request%last = min(request%last, huge(1) - scope%shift(request%items)) &
        + scope%shift(request%items)
    end associate
  end subroutine shift_numbers

  !> *SURFACE: faces S1 to S4 of elements or element sets, sets of triangles, or nodes.
  subroutine read_surface(text, card, file, requests, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(file_mesh_t), intent(inout) :: file !! takes the group
    type(requests_t), intent(inout) :: requests !! takes its members
    type(assembly_t), intent(in) :: assembly !! the instance that is read
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
    request%items = merge(1, 2, kind == group_nodes)
    call open_group(card_parameter(card, 'name'), kind, card%at, assembly%current, file, &
      request%group)
    call take_scope(card, assembly, request, cursor)
    do while (.not. cursor%failed)
      call next_data(text, cursor, start, end, found)
      if (.not. found) exit
      at = start
      call next_item(text, at, end, first, last, found)
      if (last < first) cycle
      call read_member(text, first, last, request, assembly, cursor)
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
    case ('s1', 's2', 's3', 's4', 's5', 's6')
      face = iachar(name(2:2)) - iachar('0')
      if (face > most_cell_facets) face = -1
    case ('spos', 'sneg', 'sp', 'sn')
      face = 0
    case default
      face = -1
    end select
  end function face_number

  !> *SOLID SECTION: keeps the name of the material of an element set.
  subroutine read_section(card, scope, requests)
    type(card_t), intent(in) :: card !! the card
    integer, intent(in) :: scope !! instance that it belongs to
    type(requests_t), intent(inout) :: requests !! takes it
    type(card_t), allocatable :: more(:)

    allocate (more(requests%sections + 1))
    if (requests%sections > 0) more(:requests%sections) = requests%section
    more(requests%sections + 1) = card
    call move_alloc(more, requests%section)
    requests%sections = requests%sections + 1
    if (.not. allocated(requests%section_scope)) allocate (requests%section_scope(0))
    requests%section_scope = [requests%section_scope, scope]
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
end module abaqus_sets

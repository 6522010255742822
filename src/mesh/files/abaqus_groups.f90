!> Fills the groups of Abaqus and CalculiX input files, and names them.
module abaqus_groups
  use text, only: to_text
  use file_cursor, only: cursor_t, fail
  use mesh_file_types, only: file_mesh_t, add_member, find_group, group_nodes, group_cells, &
    group_faces
  use abaqus_assembly, only: assembly_t, find_instance
  use abaqus_cards, only: card_parameter
  use abaqus_sets, only: request_t, requests_t
  use tag_table, only: tag_table_t, build_table, find_tag
  implicit none
  private
  public :: fill_groups

contains

  !> Fills the groups, element sets first, then node sets, then surfaces. A set that names another
  !! one takes what that has got so far in the file.
  subroutine fill_groups(text, requests, assembly, file, cursor)
    character(*), intent(in) :: text !! the file
    type(requests_t), intent(in) :: requests !! members by number and name
    type(assembly_t), intent(in) :: assembly !! instances
    type(file_mesh_t), intent(inout) :: file !! takes them
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    type(tag_table_t) :: nodes, cells
    integer, parameter :: group_order(3) = [group_cells, group_nodes, group_faces]
    integer :: i, pass, g

    call build_table(file%node_tag(:file%nodes), nodes)
    call build_table(file%cell_tag(:file%cells), cells)
    do pass = 1, 3
      do i = 1, requests%count
        if (cursor%failed) return
        if (file%group(requests%list(i)%group)%kind /= group_order(pass)) cycle
        if (group_order(pass) == group_nodes) then
          call fill_nodes(text, requests%list(i), nodes, assembly, file, cursor)
        else
          call fill_cells(text, requests%list(i), cells, assembly, file, cursor)
        end if
      end do
    end do
    do i = 1, requests%sections
      associate (card => requests%section(i))
        g = find_in_scope(file, card_parameter(card, 'elset'), group_cells, &
          requests%section_scope(i), assembly)
        if (g > 0) file%group(g)%material = card_parameter(card, 'material')
      end associate
    end do
    call name_groups(assembly, file)
  end subroutine fill_groups

  !> A group as a scope sees it: its own ones; the assembly also those of an instance, as
  !! instance.name, or by the name alone if there is one instance.
  integer function find_in_scope(file, name, kind, scope, assembly) result(g)
    type(file_mesh_t), intent(in) :: file !! the groups
    character(*), intent(in) :: name !! the name, in either case
    integer, intent(in) :: kind !! what its members are
    integer, intent(in) :: scope !! who asks
    type(assembly_t), intent(in) :: assembly !! instances
    integer :: dot, instance

    g = find_group(file, name, kind, scope)
    if (g > 0 .or. scope > 0 .or. assembly%instances == 0) return
    dot = index(name, '.')
    if (dot > 1) then
      instance = find_instance(assembly, name(:dot - 1))
      if (instance > 0) g = find_group(file, name(dot + 1:), kind, instance)
    end if
    if (g == 0 .and. assembly%instances == 1) g = find_group(file, name, kind, 1)
  end function find_in_scope

  !> Names of the deck: with that of the instance before it if the file has several, or if the
  !! assembly has a group of that name, too.
  subroutine name_groups(assembly, file)
    type(assembly_t), intent(in) :: assembly !! instances
    type(file_mesh_t), intent(inout) :: file !! its groups get their names
    logical :: longer(file%groups)
    integer :: g

    do g = 1, file%groups
      associate (group => file%group(g))
        longer(g) = group%scope > 0 .and. assembly%instances > 1
        if (group%scope > 0 .and. .not. longer(g)) longer(g) = any([ &
          find_group(file, group%name, group_nodes), find_group(file, group%name, group_cells), &
          find_group(file, group%name, group_faces)] > 0)
      end associate
    end do
    do g = 1, file%groups
      if (longer(g)) file%group(g)%name = assembly%scope(file%group(g)%scope)%name//'.'// &
        file%group(g)%name
      file%group(g)%scope = 0
    end do
  end subroutine name_groups

  !> Obeys one request for nodes.
  subroutine fill_nodes(text, request, nodes, assembly, file, cursor)
    character(*), intent(in) :: text !! the file
    type(request_t), intent(in) :: request !! the request
    type(tag_table_t), intent(in) :: nodes !! places of the node numbers
    type(assembly_t), intent(in) :: assembly !! instances
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: other, i, k, place

    associate (group => file%group(request%group))
      if (allocated(request%name)) then
        other = find_in_scope(file, request%name, group_cells, request%scope, assembly)
        if (other == 0) call fail(cursor, request%at, 'there is no *ELSET '//request%name, &
          'is it misspelt?')
        if (cursor%failed) return
        do i = 1, file%group(other)%count
          associate (cell => file%group(other)%members(i))
            do k = 1, file%nel(cell)
              place = find_tag(nodes, file%ix(k, cell))
              if (place > 0) call add_member(group, place, 0)
            end do
          end associate
        end do
      else if (request%name_at > 0) then
        call join_group(text, request, group_nodes, assembly, file, cursor)
      else
        call add_numbers(request, nodes, assembly, file, cursor)
      end if
    end associate
  end subroutine fill_nodes

  !> Obeys one request for elements or their faces.
  subroutine fill_cells(text, request, cells, assembly, file, cursor)
    character(*), intent(in) :: text !! the file
    type(request_t), intent(in) :: request !! the request
    type(tag_table_t), intent(in) :: cells !! places of the element numbers
    type(assembly_t), intent(in) :: assembly !! instances
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault

    if (request%name_at > 0) then
      call join_group(text, request, group_cells, assembly, file, cursor)
    else
      call add_numbers(request, cells, assembly, file, cursor)
    end if
  end subroutine fill_cells

  !> Adds the members that a request gives by number; each of them must be in the file.
  subroutine add_numbers(request, places, assembly, file, cursor)
    type(request_t), intent(in) :: request !! first to last number
    type(tag_table_t), intent(in) :: places !! places of the numbers
    type(assembly_t), intent(in) :: assembly !! highest numbers
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: place, tag, end, missing(2)

    missing = 0
    end = request%last
    if (request%first < end) end = min(end, assembly%scope(request%scope)%top(request%items))
    do tag = request%first, end, request%step
      place = find_tag(places, tag)
      if (place > 0) call add_member(file%group(request%group), place, request%face)
      if (place > 0 .and. missing(1) > 0) exit
      if (place > 0) cycle
      if (missing(1) == 0) missing(1) = tag
      missing(2) = tag
    end do
    ! beyond the highest number there is none
    if (tag > end .and. tag <= request%last) then
      if (missing(1) == 0) missing(1) = tag
      missing(2) = request%last - mod(request%last - request%first, request%step)
    end if
    if (missing(1) > 0) call refuse_numbers(request, missing, assembly, cursor)
  end subroutine add_numbers

  !> Reports the first nodes or elements of a request that the file does not have.
  subroutine refuse_numbers(request, missing, assembly, cursor)
    type(request_t), intent(in) :: request !! first to last number
    integer, intent(in) :: missing(2) !! the first and the last of them
    type(assembly_t), intent(in) :: assembly !! instances
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    character(7), parameter :: names(2) = [character(7) :: 'node', 'element']
    character(:), allocatable :: what, range, remedy

    what = trim(names(request%items))
    associate (shift => assembly%scope(request%scope)%shift(request%items))
      range = 'there is no '//what//' '//to_text(missing(1) - shift)
      if (missing(2) > missing(1)) range = 'there are no '//what//'s '// &
        to_text(missing(1) - shift)//' to '//to_text(missing(2) - shift)
      if (request%step > 1 .and. missing(2) > missing(1)) range = range//' by '// &
        to_text(request%step)
    end associate
    if (request%scope > 0 .and. assembly%instances > 1) range = range//' in '// &
      assembly%scope(request%scope)%name
    remedy = 'a set takes '//what//'s of this file'
    if (request%last > request%first) remedy = remedy//': end the range before a gap of the '// &
      'numbers, and go on in another line'
    call fail(cursor, request%at, range, remedy)
  end subroutine refuse_numbers

  !> Adds the members that another group has.
  subroutine join_group(text, request, kind, assembly, file, cursor)
    character(*), intent(in) :: text !! the file
    type(request_t), intent(in) :: request !! names the other group
    integer, intent(in) :: kind !! what the members of that group are
    type(assembly_t), intent(in) :: assembly !! instances
    type(file_mesh_t), intent(inout) :: file !! takes the members
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer :: other, i

    associate (name => text(request%name_at:request%name_end))
      other = find_in_scope(file, name, kind, request%scope, assembly)
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
end module abaqus_groups

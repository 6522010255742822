!> Parts, instances and the assembly of an Abaqus input file. A part is read anew for each of its
!! instances, with numbers behind those of the file so far; so everything behind the reader sees one
!! mesh.
module abaqus_assembly
  use kinds, only: wp, pi
  use vectors, only: cross
  use text, only: lower
  use file_cursor, only: cursor_t, fail, real_of
  use abaqus_cards, only: card_t, next_card, next_data, next_item, card_parameter
  implicit none
  private
  public :: assembly_t, scope_t, go_to_star, find_parts, find_part, find_instance, &
    open_instance, moved, take_number

  !> The largest number of a node or element of the whole file.
  integer, parameter :: highest = 1073741823

  !> What stands between *PART and *END PART.
  type :: part_t
    character(:), allocatable :: name !! its name
    integer :: first = 1 !! first character behind its card
    integer :: last = 0 !! last character before its end
  end type part_t

  !> Where numbers and names count: an instance, or the assembly and files without one.
  type :: scope_t
    character(:), allocatable :: name !! of the instance; empty for the assembly
    integer :: shift(2) = 0 !! added to its node and element numbers
    integer :: top(2) = 0 !! highest of them with it, 0 before the first
    real(wp) :: way(3) = 0.0_wp !! translation, before the rotation [length]
    real(wp) :: center(3) = 0.0_wp !! a point of the axis of rotation [length]
    real(wp) :: axis(3) = 0.0_wp !! unit vector along the axis, 0 for none
    real(wp) :: angle = 0.0_wp !! rotation about it [radian]
  end type scope_t

  !> All of them.
  type :: assembly_t
    integer :: parts = 0 !! number of parts
    type(part_t), allocatable :: part(:) !! (more than parts) in the order of the file
    integer :: instances = 0 !! number of instances in the file
    type(scope_t), allocatable :: scope(:) !! (0:instances) scope 0 is the assembly
    integer :: opened = 0 !! instances read so far
    integer :: current = 0 !! scope that is being read
    integer :: top(2) = 0 !! highest node and element number so far
  end type assembly_t

contains

  !> Finds the parts and counts the instances; cards begin a line.
  subroutine find_parts(text, start, assembly)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(in) :: start !! its beginning
    type(assembly_t), intent(out) :: assembly !! parts and scopes
    type(cursor_t) :: cursor
    type(card_t) :: card
    logical :: found

    allocate (assembly%part(4))
    cursor = start
    do
      call next_card(text, cursor, card, found)
      if (.not. found) exit
      if (card%name == 'part') call open_part(card, cursor%at, assembly)
      if (card%name == 'end part' .and. assembly%parts > 0) &
        assembly%part(assembly%parts)%last = card%at - 1
      if (card%name == 'instance') assembly%instances = assembly%instances + 1
      call go_to_star(text, cursor)
    end do
    allocate (assembly%scope(0:assembly%instances))
    assembly%scope(0)%name = ''
  end subroutine find_parts

  !> Goes to the next line that begins with a star, fast.
  pure subroutine go_to_star(text, cursor)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the beginning of a line; then of that line
    integer :: start, next

    next = cursor%at
    do while (next <= cursor%last)
      if (text(next:next) /= '*') then
        next = next + 1
        cycle
      end if
      start = next
      next = next + 1
      do while (start > cursor%at)
        if (scan(text(start - 1:start - 1), ' '//achar(9)) == 0) exit
        start = start - 1
      end do
      if (start == cursor%at) return
      if (scan(text(start - 1:start - 1), achar(10)//achar(13)) == 0) cycle
      cursor%at = start
      return
    end do
    cursor%at = cursor%last + 1
  end subroutine go_to_star

  !> A part begins.
  subroutine open_part(card, first, assembly)
    type(card_t), intent(in) :: card !! *PART
    integer, intent(in) :: first !! first character behind it
    type(assembly_t), intent(inout) :: assembly !! gets it
    type(part_t), allocatable :: more(:)
    integer :: i

    if (assembly%parts == size(assembly%part)) then
      allocate (more(2*assembly%parts))
      do i = 1, assembly%parts
        more(i) = assembly%part(i)
      end do
      call move_alloc(more, assembly%part)
    end if
    assembly%parts = assembly%parts + 1
    assembly%part(assembly%parts)%name = card_parameter(card, 'name')
    assembly%part(assembly%parts)%first = first
    assembly%part(assembly%parts)%last = huge(1)
  end subroutine open_part

  !> Number of a part, 0 if there is none of this name.
  pure integer function find_part(assembly, name) result(p)
    type(assembly_t), intent(in) :: assembly !! parts
    character(*), intent(in) :: name !! the name, in either case

    do p = 1, assembly%parts
      if (lower(assembly%part(p)%name) == lower(name)) return
    end do
    p = 0
  end function find_part

  !> Number of an instance that has been read, 0 if there is none of this name.
  pure integer function find_instance(assembly, name) result(s)
    type(assembly_t), intent(in) :: assembly !! scopes
    character(*), intent(in) :: name !! the name, in either case

    do s = 1, assembly%opened
      if (lower(assembly%scope(s)%name) == lower(name)) return
    end do
    s = 0
  end function find_instance

  !> *INSTANCE: its name, translation and rotation; it becomes the scope that is read.
  subroutine open_instance(text, card, assembly, cursor)
    character(*), intent(in) :: text !! the file
    type(card_t), intent(in) :: card !! the card
    type(assembly_t), intent(inout) :: assembly !! gets the scope
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the data
    character(:), allocatable :: name
    real(wp) :: turn(7)
    logical :: found

    name = card_parameter(card, 'name')
    if (name == '') call fail(cursor, card%at, '*INSTANCE without a name', &
      'write *INSTANCE, NAME=name, PART=part')
    if (find_instance(assembly, name) > 0) call fail(cursor, card%at, &
      'a second *INSTANCE '//name, 'give each instance a name of its own')
    if (assembly%current > 0) call fail(cursor, card%at, '*INSTANCE within an instance', &
      'write *END INSTANCE before it')
    if (cursor%failed) return
    assembly%opened = assembly%opened + 1
    assembly%current = assembly%opened
    associate (scope => assembly%scope(assembly%current))
      scope%name = name
      scope%shift = assembly%top
      call read_reals(text, cursor, scope%way, found)
      if (.not. found) return
      call read_reals(text, cursor, turn, found)
      if (.not. found .or. cursor%failed) return
      scope%center = turn(1:3)
      scope%axis = turn(4:6) - turn(1:3)
      if (norm2(scope%axis) <= 0.0_wp) then
        call fail(cursor, card%at, 'the axis of *INSTANCE '//name//' has no length', &
          'its second line has two points of the axis and an angle')
        return
      end if
      scope%axis = scope%axis/norm2(scope%axis)
      scope%angle = turn(7)*pi/180.0_wp
    end associate
  end subroutine open_instance

  !> Numbers of a data line; those that are not there are 0.
  subroutine read_reals(text, cursor, values, found)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the line
    real(wp), intent(out) :: values(:) !! the numbers
    logical, intent(out) :: found !! there is such a line
    integer :: start, end, at, first, last, k
    logical :: more

    values = 0.0_wp
    call next_data(text, cursor, start, end, found)
    if (.not. found) return
    at = start
    do k = 1, size(values)
      call next_item(text, at, end, first, last, more)
      if (.not. more) exit
      if (last >= first) call real_of(text, first, last, cursor, values(k), &
        'a number of an *INSTANCE')
    end do
  end subroutine read_reals

  !> Where a node of a part stands in an instance.
  pure function moved(scope, x) result(y)
    type(scope_t), intent(in) :: scope !! the instance
    real(wp), intent(in) :: x(3) !! in the part [length]
    real(wp) :: y(3)
    real(wp) :: arm(3), along(3)

    y = x + scope%way
    if (norm2(scope%axis) <= 0.0_wp) return
    arm = y - scope%center
    along = dot_product(arm, scope%axis)*scope%axis
    y = scope%center + along + cos(scope%angle)*(arm - along) &
      + sin(scope%angle)*cross(scope%axis, arm)
  end function moved

  !> A node (kind 1) or element (kind 2) is defined: its number in the whole file.
  subroutine take_number(assembly, kind, number, at, cursor, shifted)
    type(assembly_t), intent(inout) :: assembly !! highest numbers
    integer, intent(in) :: kind !! 1 node, 2 element
    integer, intent(in) :: number !! as written
    integer, intent(in) :: at !! character of the file where it stands
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer, intent(out) :: shifted !! number in the whole file

    shifted = number
    associate (scope => assembly%scope(assembly%current))
      if (assembly%current == 0 .and. scope%top(kind) == 0) scope%shift(kind) = assembly%top(kind)
      if (assembly%opened == 0) scope%shift(kind) = 0
      if (number > highest - scope%shift(kind)) then
        if (assembly%instances == 0) then
          scope%top(kind) = number
          return
        end if
        call fail(cursor, at, 'the numbers of all instances together are too large', &
          'number the nodes and elements of each part from 1')
        return
      end if
      shifted = number + scope%shift(kind)
      if (assembly%current == 0 .and. assembly%top(kind) > scope%top(kind) .and. &
        scope%top(kind) > 0 .and. shifted > scope%top(kind)) call fail(cursor, at, &
        'nodes or elements of the assembly before and behind an *INSTANCE', &
        'write them behind the last *END INSTANCE')
      scope%top(kind) = max(scope%top(kind), shifted)
      assembly%top(kind) = max(assembly%top(kind), shifted)
    end associate
  end subroutine take_number
end module abaqus_assembly

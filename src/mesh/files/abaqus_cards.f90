!> Cards and data lines of Abaqus and CalculiX input files, as text.
module abaqus_cards
  use text, only: lower
  use cells, only: file_shapes
  use file_cursor, only: cursor_t, read_line
  implicit none
  private
  public :: card_t, next_card, next_data, next_item, card_parameter, has_parameter, abaqus_shape

  !> A card: a line that begins with *, with the lines that a comma at its end joins to it.
  type :: card_t
    character(:), allocatable :: name !! its keyword, lower case, single blanks
    character(:), allocatable :: parameters !! what follows the first comma, as written
    integer :: at = 1 !! character of the file where it stands
  end type card_t

contains

  !> Goes to the next card; what stands before it is passed over.
  subroutine next_card(text, cursor, card, found)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the card
    type(card_t), intent(out) :: card !! the card
    logical, intent(out) :: found !! false at the end of the file
    character(:), allocatable :: line
    integer :: first, last, comma

    do
      call read_line(text, cursor, first, last, found)
      if (.not. found) return
      if (last < first) cycle
      if (text(first:first) /= '*') cycle
      if (text(first:min(last, first + 1)) /= '**') exit
    end do
    card%at = first
    cursor%head = first
    line = text(first + 1:last)
    do while (text(last:last) == ',')
      call read_line(text, cursor, first, last, found)
      if (.not. found .or. last < first) exit
      line = line//text(first:last)
    end do
    found = .true.
    comma = index(line//',', ',')
    card%name = lower(squeezed(line(:comma - 1)))
    card%parameters = line(min(comma + 1, len(line) + 1):)
  end subroutine next_card

  !> Takes the next data line of a card; comment lines are passed over.
  subroutine next_data(text, cursor, first, last, found)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the line
    integer, intent(out) :: first !! its first character
    integer, intent(out) :: last !! its last character
    logical, intent(out) :: found !! false before the next card and at the end of the file
    integer :: start

    do
      start = cursor%at
      call read_line(text, cursor, first, last, found)
      if (.not. found) return
      if (last < first) cycle
      if (text(first:first) /= '*') return
      if (text(first:min(last, first + 1)) == '**') cycle
      found = .false.
      cursor%at = start
      return
    end do
  end subroutine next_data

  !> Takes the next item of a line: what stands up to the next comma, without blanks around it.
  pure subroutine next_item(text, at, end, first, last, found)
    character(*), intent(in) :: text !! the file
    integer, intent(inout) :: at !! where to go on; then behind the comma
    integer, intent(in) :: end !! last character of the line
    integer, intent(out) :: first !! first character of the item
    integer, intent(out) :: last !! its last character; before the first if it is empty
    logical, intent(out) :: found !! false at the end of the line

    first = at
    last = at - 1
    found = at <= end
    if (.not. found) return
    do while (last < end)
      if (text(last + 1:last + 1) == ',') exit
      last = last + 1
    end do
    at = last + 2
    do while (first <= last)
      if (.not. is_space(text(first:first))) exit
      first = first + 1
    end do
    do while (last >= first)
      if (.not. is_space(text(last:last))) exit
      last = last - 1
    end do
  end subroutine next_item

  !> Blank or tab.
  pure logical function is_space(c)
    character(1), intent(in) :: c !! any character

    is_space = iachar(c) == iachar(' ') .or. iachar(c) == 9
  end function is_space

  !> Value of a parameter of a card, without quotes; empty if it is not there or has none.
  pure function card_parameter(card, name) result(value)
    type(card_t), intent(in) :: card !! the card
    character(*), intent(in) :: name !! its name, lower case
    character(:), allocatable :: value
    integer :: at, first, last, equals
    logical :: found

    value = ''
    at = 1
    do
      call next_item(card%parameters, at, len(card%parameters), first, last, found)
      if (.not. found) return
      equals = index(card%parameters(first:last), '=') + first - 1
      if (equals < first) cycle
      if (lower(squeezed(card%parameters(first:equals - 1))) /= name) cycle
      value = trim(adjustl(card%parameters(equals + 1:last)))
      if (len(value) < 2) return
      if (value(1:1) == '"' .and. value(len(value):) == '"') value = value(2:len(value) - 1)
      return
    end do
  end function card_parameter

  !> Whether a card has a parameter, with or without a value.
  pure logical function has_parameter(card, name) result(has)
    type(card_t), intent(in) :: card !! the card
    character(*), intent(in) :: name !! its name, lower case
    integer :: at, first, last, equals

    at = 1
    do
      call next_item(card%parameters, at, len(card%parameters), first, last, has)
      if (.not. has) return
      equals = index(card%parameters(first:last)//'=', '=') + first - 1
      if (lower(squeezed(card%parameters(first:equals - 1))) == name) return
    end do
  end function has_parameter

  !> A text without blanks at its ends and with single ones inside.
  pure function squeezed(text) result(t)
    character(*), intent(in) :: text !! any text
    character(:), allocatable :: t
    integer :: i, n

    allocate (character(len(text)) :: t)
    n = 0
    do i = 1, len(text)
      if (text(i:i) == ' ' .or. text(i:i) == achar(9)) then
        if (n == 0) cycle
        if (t(n:n) == ' ') cycle
        n = n + 1
        t(n:n) = ' '
      else
        n = n + 1
        t(n:n) = text(i:i)
      end if
    end do
    if (n > 0) then
      if (t(n:n) == ' ') n = n - 1
    end if
    t = t(:n)
  end function squeezed

  !> Nodes and dimension of an element type that can be read.
  pure subroutine abaqus_shape(name, nodes, dimension)
    character(*), intent(in) :: name !! TYPE= of the card, any case
    integer, intent(out) :: nodes !! 0 if it cannot be read
    integer, intent(out) :: dimension !! 1 line, 2 triangle, 3 cell
    integer :: k

    do k = 1, size(file_shapes)
      nodes = file_shapes(k)%nodes
      dimension = file_shapes(k)%dimension
      if (name /= '' .and. index(' '//file_shapes(k)%abaqus, ' '//lower(name)//' ') > 0) return
    end do
    nodes = 0
  end subroutine abaqus_shape
end module abaqus_cards

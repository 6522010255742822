!> Reads a mesh file piece by piece: lines, and numbers as text or as bytes.
!!
!! The first fault is kept in the cursor and every later request does nothing, so that a reader has
!! to look at `failed` once a loop only.
module file_cursor
  use, intrinsic :: iso_fortran_env, only: int32, int64, real64
  use kinds, only: wp
  use numbers, only: scan_number
  use mesh_building, only: max_coordinate
  implicit none
  private
  public :: cursor_t, start_cursor, fail, read_line, read_number, read_size, read_real, &
    skip_blanks, find_item, number_of, real_of

  !> Most characters of the file that a message shows.
  integer, parameter :: most_characters = 24

  !> A place in a file, and what was wrong there.
  type :: cursor_t
    integer :: at = 1 !! next character
    integer :: last = 0 !! last character of the file
    logical :: binary = .false. !! numbers are bytes, not text
    logical :: swapped = .false. !! the bytes of a number are in the other order
    integer :: head = 1 !! where the section or card at hand begins
    logical :: failed = .false. !! something was wrong
    integer :: fault = 1 !! the character where it was
    character(:), allocatable :: what !! what was wrong
    character(:), allocatable :: remedy !! what would be right
  end type cursor_t

contains

  !> Goes to the start of a file.
  pure subroutine start_cursor(text, cursor)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(out) :: cursor !! its start

    cursor%last = len(text)
    if (len(text) < 3) return
    if (text(:3) == char(239)//char(187)//char(191)) cursor%at = 4 ! mark of UTF-8
  end subroutine start_cursor

  !> Notes a fault, unless there is one already.
  pure subroutine fail(cursor, at, what, remedy)
    type(cursor_t), intent(inout) :: cursor !! the place
    integer, intent(in) :: at !! the character where it is wrong
    character(*), intent(in) :: what !! what is wrong
    character(*), intent(in) :: remedy !! what would be right

    if (cursor%failed) return
    cursor%failed = .true.
    cursor%fault = at
    cursor%what = what
    cursor%remedy = remedy
  end subroutine fail

  !> Takes the rest of the line, without blanks around it and without its end.
  pure subroutine read_line(text, cursor, first, last, found)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the line
    integer, intent(out) :: first !! its first character
    integer, intent(out) :: last !! its last character; before the first if it is blank
    logical, intent(out) :: found !! false at the end of the file or behind a fault

    first = cursor%at
    last = first - 1
    found = cursor%at <= cursor%last .and. .not. cursor%failed
    if (.not. found) return
    do while (last < cursor%last)
      if (text(last + 1:last + 1) == achar(10) .or. text(last + 1:last + 1) == achar(13)) exit
      last = last + 1
    end do
    if (last == cursor%last) then
      cursor%at = cursor%last + 1
    else
      cursor%at = last + 2
      if (text(last + 1:last + 1) == achar(13) .and. last + 2 <= cursor%last) then
        if (text(last + 2:last + 2) == achar(10)) cursor%at = last + 3
      end if
    end if
    do while (last >= first)
      if (.not. is_blank(text(last:last))) exit
      last = last - 1
    end do
    do while (first <= last)
      if (.not. is_blank(text(first:first))) exit
      first = first + 1
    end do
  end subroutine read_line

  !> Goes to the next character that is neither blank nor the end of a line.
  pure subroutine skip_blanks(text, cursor)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place

    do while (cursor%at <= cursor%last)
      if (.not. is_blank(text(cursor%at:cursor%at))) return
      cursor%at = cursor%at + 1
    end do
  end subroutine skip_blanks

  !> Goes to the next item of a section, and says where messages about it point to: in a binary file
  !! to the head of the section.
  pure subroutine find_item(text, cursor, at)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place
    integer, intent(out) :: at !! character of the file

    if (.not. cursor%binary) call skip_blanks(text, cursor)
    at = merge(cursor%head, cursor%at, cursor%binary)
  end subroutine find_item

  !> Blank, tab, carriage return or line feed.
  pure logical function is_blank(c)
    character(1), intent(in) :: c !! any character

    is_blank = iachar(c) == iachar(' ') .or. (iachar(c) >= 9 .and. iachar(c) <= 13)
  end function is_blank

  !> Reads an integer; as bytes it has four.
  subroutine read_number(text, cursor, value, label)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the number
    integer, intent(out) :: value !! the number, 0 behind a fault
    character(*), intent(in) :: label !! what it is, for messages
    integer :: last

    value = 0
    if (cursor%failed) return
    if (cursor%binary) then
      call check_room(cursor, 4, label)
      if (cursor%failed) return
      value = transfer(bytes(text(cursor%at:cursor%at + 3), cursor%swapped), 0_int32)
      cursor%at = cursor%at + 4
    else
      call next_word(text, cursor, last, label)
      if (cursor%failed) return
      call number_of(text, cursor%at, last, cursor, value, label)
      cursor%at = last + 1
    end if
  end subroutine read_number

  !> Reads a count or a tag, not negative; as bytes it has eight.
  subroutine read_size(text, cursor, value, label)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the number
    integer, intent(out) :: value !! the number, 0 behind a fault
    character(*), intent(in) :: label !! what it is, for messages
    integer(int64) :: long
    integer :: start

    value = 0
    if (cursor%failed) return
    start = cursor%at
    if (cursor%binary) then
      call check_room(cursor, 8, label)
      if (cursor%failed) return
      long = transfer(bytes(text(cursor%at:cursor%at + 7), cursor%swapped), 0_int64)
      cursor%at = cursor%at + 8
    else
      call skip_blanks(text, cursor)
      start = cursor%at
      call read_number(text, cursor, value, label)
      long = value
    end if
    if (cursor%failed) return
    if (long < 0 .or. long > huge(value)) then
      value = 0
      call fail(cursor, start, label//' is negative or beyond 2147483647', &
        'is the file damaged? write it again')
      return
    end if
    value = int(long)
  end subroutine read_size

  !> Reads a coordinate or another real number.
  subroutine read_real(text, cursor, value, label)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then behind the number
    real(wp), intent(out) :: value !! the number, 0 behind a fault
    character(*), intent(in) :: label !! what it is, for messages
    integer(int64) :: bits
    integer :: last

    value = 0.0_wp
    if (cursor%failed) return
    if (cursor%binary) then
      call check_room(cursor, 8, label)
      if (cursor%failed) return
      bits = transfer(bytes(text(cursor%at:cursor%at + 7), cursor%swapped), 0_int64)
      if (ibits(bits, 52, 11) == 2047_int64) then
        call fail(cursor, cursor%head, label//' is not a number', 'write the file again')
        return
      end if
      value = real(transfer(bits, 0.0_real64), wp)
      cursor%at = cursor%at + 8
      if (abs(value) > max_coordinate) call too_large(cursor, cursor%head, label)
    else
      call next_word(text, cursor, last, label)
      if (cursor%failed) return
      call real_of(text, cursor%at, last, cursor, value, label)
      cursor%at = last + 1
    end if
  end subroutine read_real

  !> Finds the word at hand: up to the next blank.
  subroutine next_word(text, cursor, last, label)
    character(*), intent(in) :: text !! the file
    type(cursor_t), intent(inout) :: cursor !! the place; then the first character of the word
    integer, intent(out) :: last !! its last character
    character(*), intent(in) :: label !! what is expected, for messages

    call skip_blanks(text, cursor)
    last = cursor%at
    if (cursor%at > cursor%last) then
      call fail(cursor, cursor%last, 'the file ends where '//label//' is expected', &
        'is the file complete? write it again')
      return
    end if
    do while (last < cursor%last)
      if (is_blank(text(last + 1:last + 1))) exit
      last = last + 1
    end do
  end subroutine next_word

  !> An integer that is written in the characters first to last.
  subroutine number_of(text, first, last, cursor, value, label)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: first !! first character
    integer, intent(in) :: last !! last character
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer, intent(out) :: value !! the number, 0 behind a fault
    character(*), intent(in) :: label !! what it is, for messages
    integer(int64) :: long
    integer :: i, start, digit

    value = 0
    start = first
    if (first <= last) then
      if (text(first:first) == '+' .or. text(first:first) == '-') start = first + 1
    end if
    long = 0
    do i = start, last
      digit = iachar(text(i:i)) - iachar('0')
      if (digit < 0 .or. digit > 9 .or. long > huge(value)) exit
      long = 10*long + digit
    end do
    if (i <= last .or. start > last .or. long > huge(value)) then
      call fail(cursor, first, label//' is expected, an integer, where '''// &
        text(first:min(last, first + most_characters - 1))//''' stands', &
        'is the file complete and '// &
        'of the format it says?')
      return
    end if
    value = int(long)
    if (text(first:first) == '-') value = -value
  end subroutine number_of

  !> A real number that is written in the characters first to last.
  subroutine real_of(text, first, last, cursor, value, label)
    character(*), intent(in) :: text !! the file
    integer, intent(in) :: first !! first character
    integer, intent(in) :: last !! last character
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    real(wp), intent(out) :: value !! the number, 0 behind a fault
    character(*), intent(in) :: label !! what it is, for messages
    character(:), allocatable :: problem
    integer :: i

    value = 0.0_wp
    i = first
    if (first <= last) then
      if (scan(text(first:first), '+-') > 0) i = first + 1
      call scan_number(text(:last), i, value, problem)
    end if
    if (first > last .or. allocated(problem) .or. i <= last) then
      value = 0.0_wp
      call fail(cursor, first, label//' is expected, a number, where '''// &
        text(first:min(last, first + most_characters - 1))//''' stands', &
        'is the file complete and '// &
        'of the format it says?')
      return
    end if
    if (text(first:first) == '-') value = -value
    if (abs(value) > max_coordinate) call too_large(cursor, first, label)
  end subroutine real_of

  !> Reports a number that is absurdly large.
  subroutine too_large(cursor, at, label)
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    integer, intent(in) :: at !! where it stands
    character(*), intent(in) :: label !! what it is

    call fail(cursor, at, label//' is absurdly large', 'numbers lie between -1e100 and 1e100')
  end subroutine too_large

  !> Checks that a binary number is there.
  subroutine check_room(cursor, n, label)
    type(cursor_t), intent(inout) :: cursor !! the place
    integer, intent(in) :: n !! bytes it has
    character(*), intent(in) :: label !! what it is

    if (cursor%at > cursor%last - n + 1) call fail(cursor, cursor%head, 'the file ends where '// &
      label//' of this section is expected', 'is the file complete? write it again')
  end subroutine check_room

  !> The bytes of a number in the order of this machine.
  pure function bytes(raw, swapped) result(b)
    character(*), intent(in) :: raw !! as in the file
    logical, intent(in) :: swapped !! whether they are in the other order
    character(len(raw)) :: b
    integer :: i

    b = raw
    if (.not. swapped) return
    do i = 1, len(raw)
      b(i:i) = raw(len(raw) + 1 - i:len(raw) + 1 - i)
    end do
  end function bytes
end module file_cursor

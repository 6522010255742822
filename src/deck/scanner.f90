!> Splits the lines of a deck into items.
module scanner
  implicit none
  private
  public :: span_t, scan_t, scan_line, start_scan, first_item

  !> Where an item stands in the text of its file.
  type :: span_t
    integer :: first = 1 !! its first character
    integer :: last = 0 !! its last character; before first if the item is empty
    integer :: line = 0 !! number of its line
    integer :: column = 0 !! column in its line (of the quote if there is one)
    logical :: quoted = .false. !! whether it stands in quotes
  end type span_t

  !> The items of a record while its lines are scanned.
  type :: scan_t
    type(span_t), allocatable :: spans(:) !! items (may be larger than count)
    integer :: count = 0 !! number of items
    logical :: equals = .false. !! whether = follows the first item
    logical :: comma = .false. !! whether a comma is the last thing read
    logical :: continued = .false. !! whether & joins the next line
    logical :: comment = .false. !! whether the last line has a comment
    integer :: fault = 0 !! character at which the line is at fault, 0 if at none
    character(:), allocatable :: what !! what is wrong there
    character(:), allocatable :: remedy !! what would be right
  end type scan_t

  character(*), parameter :: blanks = ' '//achar(9)
  !> Blanks that only look like one (U+00A0, U+202F, U+2007, U+2009, U+3000): text that
  !! was copied from a page has them.
  character(*), parameter :: odd_blanks(5) = [character(3) :: char(194)//char(160), &
    char(226)//char(128)//char(175), char(226)//char(128)//char(135), &
    char(226)//char(128)//char(137), char(227)//char(128)//char(128)]

contains

  !> Forgets the last record.
  subroutine start_scan(scan)
    type(scan_t), intent(inout) :: scan !! made ready for a new record

    if (.not. allocated(scan%spans)) allocate (scan%spans(32))
    scan%count = 0
    scan%equals = .false.
    scan%comma = .false.
    scan%continued = .false.
    scan%fault = 0
  end subroutine start_scan

  !> Adds the items of one line to the record.
  subroutine scan_line(text, first, last, line, scan)
    character(*), intent(in) :: text !! text of the whole file
    integer, intent(in) :: first !! first character of the line
    integer, intent(in) :: last !! last character of the line
    integer, intent(in) :: line !! its number
    type(scan_t), intent(inout) :: scan !! the record
    integer :: i, start

    scan%continued = .false.
    scan%comment = .false.
    i = first
    do while (i <= last)
      start = i
      select case (text(i:i))
      case (' ', achar(9))
        i = i + 1
      case (',')
        if (scan%comma .or. scan%count == 0) call add_span(scan, i, i - 1, line, i - first + 1)
        scan%comma = .true.
        i = i + 1
      case ('=')
        if (scan%count == 1) scan%equals = .true.
        i = i + 1
      case ('!')
        scan%comment = .true.
        return
      case ('&')
        call check_continuation(text, i, last, scan)
        return
      case ('''', '"')
        call scan_quoted(text, i, last, scan)
        if (scan%fault > 0) return
        call add_span(scan, start + 1, i - 2, line, start - first + 1)
        scan%spans(scan%count)%quoted = .true.
        scan%comma = .false.
      case default
        call scan_item(text, i, last)
        call look_for_odd_blank(text, start, i - 1, scan)
        if (scan%fault > 0) return
        call add_span(scan, start, i - 1, line, start - first + 1)
        scan%comma = .false.
      end select
    end do
  end subroutine scan_line

  !> Adds one item.
  subroutine add_span(scan, first, last, line, column)
    type(scan_t), intent(inout) :: scan !! the record
    integer, intent(in) :: first !! first character of the item
    integer, intent(in) :: last !! its last character
    integer, intent(in) :: line !! number of its line
    integer, intent(in) :: column !! its column
    type(span_t), allocatable :: more(:)

    if (scan%count == size(scan%spans)) then
      allocate (more(2*scan%count))
      more(:scan%count) = scan%spans
      call move_alloc(more, scan%spans)
    end if
    scan%count = scan%count + 1
    scan%spans(scan%count) = span_t(first, last, line, column, .false.)
  end subroutine add_span

  !> Goes to the end of an item; separators inside parentheses belong to it, blanks never do.
  pure subroutine scan_item(text, i, last)
    character(*), intent(in) :: text !! text of the whole file
    integer, intent(inout) :: i !! first character of the item; then the one behind it
    integer, intent(in) :: last !! last character of the line
    integer :: depth

    depth = 0
    do while (i <= last)
      select case (text(i:i))
      case (' ', achar(9), '!', '&')
        return
      case (',', '=')
        if (depth == 0) return
      case ('(')
        depth = depth + 1
      case (')')
        depth = max(depth - 1, 0)
      case default
        continue
      end select
      i = i + 1
    end do
  end subroutine scan_item

  !> A blank that does not part items although it looks as if it did is a fault.
  pure subroutine look_for_odd_blank(text, first, last, scan)
    character(*), intent(in) :: text !! text of the whole file
    integer, intent(in) :: first !! first character of the item
    integer, intent(in) :: last !! its last character
    type(scan_t), intent(inout) :: scan !! the record; its fault is set if there is one
    integer :: k, at

    do k = 1, size(odd_blanks)
      at = index(text(first:last), trim(odd_blanks(k)))
      if (at == 0) cycle
      scan%fault = first + at - 1
      scan%what = 'a blank that is none: a character that only looks like one'
      scan%remedy = 'write a plain blank here; text copied from a page or a letter has others'
      return
    end do
  end subroutine look_for_odd_blank

  !> Goes behind the closing quote.
  subroutine scan_quoted(text, i, last, scan)
    character(*), intent(in) :: text !! text of the whole file
    integer, intent(inout) :: i !! the opening quote; then the character behind the closing one
    integer, intent(in) :: last !! last character of the line
    type(scan_t), intent(inout) :: scan !! the record; its fault is set if a quote is missing
    integer :: length

    length = index(text(i + 1:last), text(i:i)) - 1
    if (length < 0) then
      scan%fault = i
      scan%what = 'a quote that is not closed'
      scan%remedy = 'names in quotes end on the same line: '//text(i:i)//'name'//text(i:i)
    else
      i = i + length + 2
    end if
  end subroutine scan_quoted

  !> Checks that & is the last item of its line.
  subroutine check_continuation(text, i, last, scan)
    character(*), intent(in) :: text !! text of the whole file
    integer, intent(in) :: i !! place of the &
    integer, intent(in) :: last !! last character of the line
    type(scan_t), intent(inout) :: scan !! the record
    integer :: next

    scan%continued = .true.
    next = verify(text(i + 1:last), blanks)
    if (next == 0) return
    if (text(i + next:i + next) == '!') return
    scan%fault = i
    scan%what = '& in the middle of a line'
    scan%remedy = '& joins the next line: it is the last item of its line'
  end subroutine check_continuation

  !> First item of a line, empty if there is none; for lines that are taken raw.
  pure subroutine first_item(text, first, last)
    character(*), intent(in) :: text !! the line
    integer, intent(out) :: first !! first character of the item
    integer, intent(out) :: last !! last character of the item

    first = verify(text, blanks//',')
    last = first - 1
    if (first == 0) return
    if (text(first:first) == '!') return
    last = first
    call scan_item(text, last, len(text))
    last = max(last - 1, first)
  end subroutine first_item
end module scanner

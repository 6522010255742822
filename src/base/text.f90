!> Small helpers for character data: case, numbers as text, distance between words.
module text
  use kinds, only: wp
  implicit none
  private
  public :: lower, upper, to_text, range_text, edit_distance, string_t, count_noun, in_quotes, &
    append_string

  !> Room of a list of strings at its first one.
  integer, parameter :: first_strings = 16

  !> A character string of its own length, for arrays of strings.
  type :: string_t
    character(:), allocatable :: s !! the string
  end type string_t

  !> A number as text without blanks around it.
  interface to_text
    module procedure integer_to_text
    module procedure real_to_text
  end interface to_text

contains

  !> `s` in lower case (ASCII letters only).
  pure function lower(s) result(t)
    character(*), intent(in) :: s !! any text
    character(len(s)) :: t
    integer :: i, code

    do i = 1, len(s)
      code = iachar(s(i:i))
      if (code >= iachar('A') .and. code <= iachar('Z')) code = code + 32
      t(i:i) = achar(code)
    end do
  end function lower

  !> `s` in upper case (ASCII letters only).
  pure function upper(s) result(t)
    character(*), intent(in) :: s !! any text
    character(len(s)) :: t
    integer :: i, code

    do i = 1, len(s)
      code = iachar(s(i:i))
      if (code >= iachar('a') .and. code <= iachar('z')) code = code - 32
      t(i:i) = achar(code)
    end do
  end function upper

  !> An integer as text.
  pure function integer_to_text(value) result(t)
    integer, intent(in) :: value !! the number
    character(:), allocatable :: t
    character(32) :: buffer

    write (buffer, '(i0)') value
    t = trim(buffer)
  end function integer_to_text

  !> A real as text: `digits` significant digits (6 unless given), no superfluous zeros; without an
  !! exponent from 1e-4 to 1e6.
  pure function real_to_text(value, digits) result(t)
    real(wp), intent(in) :: value !! the number
    integer, intent(in), optional :: digits !! significant digits
    character(:), allocatable :: t
    character(48) :: buffer
    character(16) :: form
    integer :: n, power

    n = 6
    if (present(digits)) n = digits
    power = 0
    if (abs(value) > 0.0_wp .and. abs(value) <= huge(value)) power = floor(log10(abs(value)))
    if (power >= -4 .and. power < 6) then
      write (form, '(a,i0,a)') '(f40.', max(0, n - 1 - power), ')'
    else
      write (form, '(a,i0,a)') '(es40.', n - 1, 'e3)'
    end if
    write (buffer, form) value
    t = without_zeros(trim(adjustl(buffer)))
    if (t(1:1) == '.') t = '0'//t
    if (len(t) > 1) then
      if (t(1:2) == '-.') t = '-0'//t(2:)
    end if
  end function real_to_text

  !> Drops zeros at the end of the mantissa, the point if nothing follows it, and zeros and plus
  !! sign of the exponent.
  pure function without_zeros(t) result(s)
    character(*), intent(in) :: t !! a real number as written by an F or ES format
    character(:), allocatable :: s
    integer :: e, last, exponent

    e = scan(t, 'E')
    if (e == 0) e = len(t) + 1
    last = e - 1
    if (index(t(:last), '.') > 0) then
      do while (last > 1 .and. t(last:last) == '0')
        last = last - 1
      end do
      if (t(last:last) == '.') last = last - 1
    end if
    s = t(:last)
    if (e > len(t)) return
    read (t(e + 1:), *) exponent
    s = s//'E'//integer_to_text(exponent)
  end function without_zeros

  !> Numbers as `least to largest`, or as one number where they are equal.
  pure function range_text(values) result(t)
    real(wp), intent(in) :: values(:) !! the numbers, one at least
    character(:), allocatable :: t

    character(:), allocatable :: last

    t = to_text(minval(values))
    last = to_text(maxval(values))
    if (last /= t) t = t//' to '//last
  end function range_text

  !> Number of insertions, deletions and replacements that turn `a` into `b` (Levenshtein).
  pure integer function edit_distance(a, b) result(d)
    character(*), intent(in) :: a !! first word
    character(*), intent(in) :: b !! second word
    integer :: row(0:len(b)), diagonal, above, i, j

    row = [(j, j=0, len(b))]
    do i = 1, len(a)
      diagonal = row(0)
      row(0) = i
      do j = 1, len(b)
        above = row(j)
        row(j) = min(above + 1, row(j - 1) + 1, diagonal + merge(0, 1, a(i:i) == b(j:j)))
        diagonal = above
      end do
    end do
    d = row(len(b))
  end function edit_distance

  !> "1 node", "2 nodes".
  pure function count_noun(n, noun) result(t)
    integer, intent(in) :: n !! how many
    character(*), intent(in) :: noun !! singular form; the plural adds an s
    character(:), allocatable :: t

    t = integer_to_text(n)//' '//noun
    if (n /= 1) t = t//'s'
  end function count_noun

  !> A name as a deck has to write it: in quotes if it has blanks.
  pure function in_quotes(name) result(t)
    character(*), intent(in) :: name !! of a set, region, surface, label
    character(:), allocatable :: t

    t = name
    if (scan(name, ' ,=!') > 0) t = ''''//name//''''
  end function in_quotes

  !> Adds a string behind the first n of a list, which gets twice its room when it is full.
  pure subroutine append_string(list, n, s)
    type(string_t), allocatable, intent(inout) :: list(:) !! strings, and room for more
    integer, intent(inout) :: n !! strings in it; one more after
    character(*), intent(in) :: s !! the string
    type(string_t), allocatable :: longer(:)
    integer :: i

    if (.not. allocated(list)) allocate (list(first_strings))
    if (n == size(list)) then
      allocate (longer(2*max(n, 1)))
      do i = 1, n
        call move_alloc(list(i)%s, longer(i)%s)
      end do
      call move_alloc(longer, list)
    end if
    n = n + 1
    list(n)%s = s
  end subroutine append_string
end module text

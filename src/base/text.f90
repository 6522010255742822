!> Small helpers for character data: case, numbers as text, distance between words.
module text
  use kinds, only: wp
  implicit none
  private
  public :: lower, upper, to_text, edit_distance, string_t, count_noun

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

  !> A real as text: `digits` significant digits (6 unless given), no superfluous zeros.
  pure function real_to_text(value, digits) result(t)
    real(wp), intent(in) :: value !! the number
    integer, intent(in), optional :: digits !! significant digits
    character(:), allocatable :: t
    character(40) :: buffer
    character(16) :: form
    integer :: n

    n = 6
    if (present(digits)) n = digits
    write (form, '(a,i0,a,i0,a)') '(g', n + 9, '.', n, ')'
    write (buffer, form) value
    t = trim(adjustl(buffer))
    t = without_zeros(t)
  end function real_to_text

  !> Drops zeros at the end of the mantissa, and the point if nothing follows it.
  pure function without_zeros(t) result(s)
    character(*), intent(in) :: t !! a real number as written by a G format
    character(:), allocatable :: s
    integer :: e, last

    e = scan(t, 'eEdD')
    if (e == 0) e = len(t) + 1
    last = e - 1
    if (index(t(:last), '.') > 0) then
      do while (last > 1 .and. t(last:last) == '0')
        last = last - 1
      end do
      if (t(last:last) == '.') last = last - 1
    end if
    s = t(:last)//t(e:)
  end function without_zeros

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
end module text

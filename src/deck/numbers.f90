!> Reads decimal numbers without ever raising a floating point exception.
module numbers
  use, intrinsic :: iso_fortran_env, only: int64
  use kinds, only: wp
  implicit none
  private
  public :: scan_number, is_digit, is_letter, is_name_character

  !> Powers of ten that are exact in double precision.
  real(wp), parameter :: power_of_ten(0:22) = [1e0_wp, 1e1_wp, 1e2_wp, 1e3_wp, 1e4_wp, 1e5_wp, &
    1e6_wp, 1e7_wp, 1e8_wp, 1e9_wp, 1e10_wp, 1e11_wp, 1e12_wp, 1e13_wp, 1e14_wp, 1e15_wp, &
    1e16_wp, 1e17_wp, 1e18_wp, 1e19_wp, 1e20_wp, 1e21_wp, 1e22_wp]

  !> Digits and exponent of a number: value = mantissa 10^exponent.
  type :: decimal_t
    integer(int64) :: mantissa = 0_int64 !! its first digits
    integer :: digits = 0 !! significant digits in the mantissa
    integer :: exponent = 0 !! power of ten
    logical :: found = .false. !! whether there was a digit at all
  end type decimal_t

contains

  !> Reads digits, point and exponent (e or d) at `i` and leaves `i` behind them.
  subroutine scan_number(text, i, value, problem)
    character(*), intent(in) :: text !! holds the number
    integer, intent(inout) :: i !! its first character; then the first one behind it
    real(wp), intent(out) :: value !! the number
    character(:), allocatable, intent(out) :: problem !! allocated if it is none
    type(decimal_t) :: number
    integer :: start

    value = 0.0_wp
    start = i
    call scan_mantissa(text, i, number)
    if (.not. number%found) then
      problem = 'a number without digits'
      return
    end if
    call scan_exponent(text, i, number, problem)
    if (allocated(problem) .or. number%mantissa == 0) return
    if (number%digits + number%exponent > 308) then
      problem = 'a number too large'
    else if (number%digits + number%exponent < -320) then
      value = 0.0_wp
    else if (number%digits <= 15 .and. abs(number%exponent) <= 22) then
      value = real(number%mantissa, wp)
      if (number%exponent >= 0) value = value*power_of_ten(number%exponent)
      if (number%exponent < 0) value = value/power_of_ten(-number%exponent)
    else
      call read_slowly(text(start:i - 1), value, problem)
    end if
  end subroutine scan_number

  !> Reads digits and at most one point.
  subroutine scan_mantissa(text, i, number)
    character(*), intent(in) :: text !! holds the number
    integer, intent(inout) :: i !! current character
    type(decimal_t), intent(inout) :: number !! digits so far
    logical :: point

    point = .false.
    do while (i <= len(text))
      if (text(i:i) == '.') then
        if (point) exit
        point = .true.
      else if (is_digit(text(i:i))) then
        number%found = .true.
        if (number%digits < 18) then
          number%mantissa = 10_int64*number%mantissa + iachar(text(i:i)) - iachar('0')
          if (number%mantissa > 0) number%digits = number%digits + 1
          if (point) number%exponent = number%exponent - 1
        else
          if (.not. point) number%exponent = number%exponent + 1
        end if
      else
        exit
      end if
      i = i + 1
    end do
  end subroutine scan_mantissa

  !> Reads an exponent, if there is one.
  subroutine scan_exponent(text, i, number, problem)
    character(*), intent(in) :: text !! holds the number
    integer, intent(inout) :: i !! current character
    type(decimal_t), intent(inout) :: number !! its exponent is completed
    character(:), allocatable, intent(inout) :: problem !! allocated if no digit follows
    integer :: exponent, first
    logical :: negative

    if (i > len(text)) return
    if (scan(text(i:i), 'eEdD') == 0) return
    i = i + 1
    negative = .false.
    if (i <= len(text)) then
      negative = text(i:i) == '-'
      if (scan(text(i:i), '+-') > 0) i = i + 1
    end if
    exponent = 0
    first = i
    do while (i <= len(text))
      if (.not. is_digit(text(i:i))) exit
      exponent = min(10*exponent + iachar(text(i:i)) - iachar('0'), 100000)
      i = i + 1
    end do
    if (i == first) problem = 'an exponent without digits'
    number%exponent = number%exponent + merge(-exponent, exponent, negative)
  end subroutine scan_exponent

  !> Leaves a long number, known not to overflow, to the run-time library.
  subroutine read_slowly(text, value, problem)
    character(*), intent(in) :: text !! the number and nothing else
    real(wp), intent(out) :: value !! its value
    character(:), allocatable, intent(inout) :: problem !! allocated if it cannot be read
    integer :: status

    read (text, *, iostat=status) value
    if (status == 0) return
    value = 0.0_wp
    problem = 'a number that does not parse'
  end subroutine read_slowly

  !> Whether a character is a decimal digit.
  pure logical function is_digit(c)
    character(1), intent(in) :: c !! any character

    is_digit = c >= '0' .and. c <= '9'
  end function is_digit

  !> Whether a character is a letter (ASCII).
  pure logical function is_letter(c)
    character(1), intent(in) :: c !! any character

    is_letter = (c >= 'a' .and. c <= 'z') .or. (c >= 'A' .and. c <= 'Z')
  end function is_letter

  !> Whether a character may stand in the name of a parameter.
  pure logical function is_name_character(c)
    character(1), intent(in) :: c !! any character

    is_name_character = is_letter(c) .or. is_digit(c) .or. c == '_'
  end function is_name_character
end module numbers

!> JSON, one object a line, on standard output: what --json prints (doc/manual, "Output for
!! programs"). The items of an object are a text `,"name":value,"name":value`.
module json_lines
  use, intrinsic :: iso_fortran_env, only: output_unit, int64
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use kinds, only: wp
  use text, only: to_text
  implicit none
  private
  public :: item, list_item, object, print_record

  !> Digits that a real is told with.
  integer, parameter :: digits = 12

  !> One item: text, integer, real (null where it is no number).
  interface item
    module procedure text_item
    module procedure integer_item
    module procedure long_item
    module procedure real_item
  end interface item

contains

  !> A text.
  pure function text_item(name, value) result(t)
    character(*), intent(in) :: name !! of the item
    character(*), intent(in) :: value !! any text
    character(:), allocatable :: t

    t = ',"'//name//'":"'//escaped(value)//'"'
  end function text_item

  !> A whole number.
  pure function integer_item(name, value) result(t)
    character(*), intent(in) :: name !! of the item
    integer, intent(in) :: value !! the number
    character(:), allocatable :: t

    t = ',"'//name//'":'//to_text(value)
  end function integer_item

  !> A large whole number.
  pure function long_item(name, value) result(t)
    character(*), intent(in) :: name !! of the item
    integer(int64), intent(in) :: value !! the number
    character(:), allocatable :: t
    character(20) :: number

    write (number, '(i0)') value
    t = ',"'//name//'":'//trim(number)
  end function long_item

  !> A real number; JSON has no infinity.
  pure function real_item(name, value) result(t)
    character(*), intent(in) :: name !! of the item
    real(wp), intent(in) :: value !! the number
    character(:), allocatable :: t

    t = ',"'//name//'":null'
    if (ieee_is_finite(value)) t = ',"'//name//'":'//to_text(value, digits)
  end function real_item

  !> A list.
  pure function list_item(name, elements) result(t)
    character(*), intent(in) :: name !! of the item
    character(*), intent(in) :: elements !! each with a comma before it
    character(:), allocatable :: t

    t = ',"'//name//'":['//elements(min(2, len(elements) + 1):)//']'
  end function list_item

  !> An object of items, with a comma before it.
  pure function object(items) result(t)
    character(*), intent(in) :: items !! each with a comma before it
    character(:), allocatable :: t

    t = ',{'//items(min(2, len(items) + 1):)//'}'
  end function object

  !> A text as JSON wants it between quotes.
  pure function escaped(value) result(t)
    character(*), intent(in) :: value !! any text
    character(:), allocatable :: t
    character(6) :: code
    integer :: i

    t = ''
    do i = 1, len(value)
      if (value(i:i) == '"' .or. value(i:i) == achar(92)) then
        t = t//achar(92)//value(i:i)
      else if (value(i:i) == new_line('a')) then
        t = t//achar(92)//'n'
      else if (iachar(value(i:i)) < 32 .or. iachar(value(i:i)) == 127) then
        write (code, '(2a,z4.4)') achar(92), 'u', iachar(value(i:i))
        t = t//code
      else
        t = t//value(i:i)
      end if
    end do
  end function escaped

  !> Prints an object as a line; when nobody reads any more it is lost.
  subroutine print_record(event, items)
    character(*), intent(in) :: event !! what the record tells of
    character(*), intent(in) :: items !! its items
    character(:), allocatable :: line
    integer :: status

    line = object(item('event', event)//items)
    write (output_unit, '(a)', iostat=status) line(2:)
    if (status == 0) flush (output_unit, iostat=status)
    if (status /= 0) return
  end subroutine print_record
end module json_lines

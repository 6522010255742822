!> Finds parameters by name, however many there are: a tree over a list of them.
module parameter_tree
  use, intrinsic :: iso_fortran_env, only: int64
  use deck_types, only: parameter_t
  implicit none
  private
  public :: find_parameter, link_parameter

contains

  !> Index of a parameter, 0 if there is none of that name (names differ by case).
  pure integer function find_parameter(parameters, name) result(number)
    type(parameter_t), intent(in) :: parameters(:) !! the parameters there are, all linked
    character(*), intent(in) :: name !! its name
    integer :: key

    key = key_of(name)
    number = min(1, size(parameters))
    do while (number > 0)
      if (parameters(number)%key == key) then
        if (len(parameters(number)%name) == len(name)) then
          if (parameters(number)%name == name) return
        end if
      end if
      number = parameters(number)%below(merge(1, 2, key < parameters(number)%key))
    end do
  end function find_parameter

  !> Gives the last of some parameters its place in the tree that find_parameter searches.
  pure subroutine link_parameter(parameters)
    type(parameter_t), intent(inout) :: parameters(:) !! all but the last are linked
    integer :: last, above, side

    last = size(parameters)
    parameters(last)%key = key_of(parameters(last)%name)
    parameters(last)%below = 0
    if (last == 1) return
    above = 1
    do
      side = merge(1, 2, parameters(last)%key < parameters(above)%key)
      if (parameters(above)%below(side) == 0) exit
      above = parameters(above)%below(side)
    end do
    parameters(above)%below(side) = last
  end subroutine link_parameter

  !> A number that scatters names, so that the tree of those in order does not become a list.
  pure integer function key_of(name) result(key)
    character(*), intent(in) :: name !! any name
    integer(int64) :: sum
    integer :: i

    sum = 1_int64
    do i = 1, len(name)
      sum = mod((sum + iachar(name(i:i)))*48271_int64, 2147483647_int64)
    end do
    key = int(sum)
  end function key_of
end module parameter_tree

!> Lists of strings that grow.
module string_lists
  use text, only: string_t
  implicit none
  private
  public :: append_string

  !> Room of a list at its first string.
  integer, parameter :: first_strings = 16

contains

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
end module string_lists

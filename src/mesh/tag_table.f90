!> Finds the place of a number in a list: a hash table of the tags that mesh files give.
module tag_table
  use, intrinsic :: iso_fortran_env, only: int64
  implicit none
  private
  public :: tag_table_t, build_table, find_tag

  !> Spreads neighbouring tags over the table (Knuth's multiplier for 32 bits).
  integer(int64), parameter :: multiplier = 2654435761_int64

  !> Tags and where they stand; a tag is at least 1.
  type :: tag_table_t
    integer(int64) :: mask = 0_int64 !! size of the table, a power of two, minus 1
    integer, allocatable :: tags(:) !! (0:mask) 0 where there is none
    integer, allocatable :: places(:) !! (0:mask) place of the tag in the list
  end type tag_table_t

contains

  !> Enters a list of tags; of a tag that occurs twice the first place counts.
  subroutine build_table(tags, table)
    integer, intent(in) :: tags(:) !! tags, at least 1
    type(tag_table_t), intent(out) :: table !! the table
    integer(int64) :: room, slot
    integer :: i

    room = 16_int64
    do while (room < 2_int64*size(tags, kind=int64))
      room = 2_int64*room
    end do
    table%mask = room - 1_int64
    allocate (table%tags(0:table%mask), table%places(0:table%mask), source=0)
    do i = 1, size(tags)
      slot = slot_of(table, tags(i))
      if (table%tags(slot) /= 0) cycle
      table%tags(slot) = tags(i)
      table%places(slot) = i
    end do
  end subroutine build_table

  !> Place of a tag in the list, 0 if it is not there.
  pure integer function find_tag(table, tag) result(place)
    type(tag_table_t), intent(in) :: table !! the table
    integer, intent(in) :: tag !! any number

    place = 0
    if (tag > 0) place = table%places(slot_of(table, tag))
  end function find_tag

  !> Slot that holds a tag, or the free one where it belongs.
  pure integer(int64) function slot_of(table, tag) result(slot)
    type(tag_table_t), intent(in) :: table !! the table, never full
    integer, intent(in) :: tag !! the tag

    slot = iand(shiftr(int(tag, int64)*multiplier, 8), table%mask)
    do while (table%tags(slot) /= 0)
      if (table%tags(slot) == tag) return
      slot = iand(slot + 1_int64, table%mask)
    end do
  end function slot_of
end module tag_table

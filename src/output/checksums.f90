!> Sums over what a state holds, by which a reader knows that nothing of it has changed.
module checksums
  use, intrinsic :: iso_fortran_env, only: int32, int64
  implicit none
  private
  public :: block_sum

  !> Words that are added before the sums are taken modulo: none of them runs over.
  integer, parameter :: stretch = 16384
  !> The sums are taken modulo this prime (the largest below 2**31).
  integer(int64), parameter :: prime = 2147483647_int64
  !> Sets the name of a block apart from its words.
  integer(int64), parameter :: spread = 48271_int64

contains

  !> Sum over the words of a named block, of values and places (Fletcher); 0 where all are 0, so
  !! that a block of zeros and none are the same. Sums of several blocks are joined by exclusive or.
  pure integer(int64) function block_sum(name, words) result(sum)
    character(*), intent(in) :: name !! name of the block
    integer(int32), intent(in) :: words(:) !! its bytes, four each
    integer(int64) :: values, places, mark
    integer :: first, i

    values = 0_int64
    places = 0_int64
    do first = 1, size(words), stretch
      do i = first, min(first + stretch - 1, size(words))
        values = values + iand(int(words(i), int64), int(z'FFFFFFFF', int64))
        places = places + values
      end do
      values = mod(values, prime)
      places = mod(places, prime)
    end do
    sum = 0_int64
    if (values == 0_int64 .and. places == 0_int64) return
    mark = 1_int64
    do i = 1, len(name)
      mark = mod(spread*(mark + iachar(name(i:i))), prime)
    end do
    sum = ior(shiftl(mod(spread*(values + mark), prime), 31), mod(spread*(places + mark), prime))
  end function block_sum
end module checksums

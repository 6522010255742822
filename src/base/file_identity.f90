!> Which file a path leads to, behind all links, and of what kind it is. Two paths lead to one file
!! where device and inode are the same, whatever they are called.
module file_identity
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_null_char
  use libc, only: c_statx, statx_t, read_errno
  implicit none
  private
  public :: file_identity_t, identify, are_one, obstacle_of
  public :: kind_none, kind_file, kind_pipe

  ! Kinds; those that cannot be read as text have no name outside.
  integer, parameter :: kind_none = 0 !! there is nothing of that name
  integer, parameter :: kind_closed = 1 !! a folder above it is closed to the user
  integer, parameter :: kind_circle = 2 !! its links lead in a circle
  integer, parameter :: kind_file = 3 !! a regular file
  integer, parameter :: kind_pipe = 4
  integer, parameter :: kind_folder = 5
  integer, parameter :: kind_device = 6
  integer, parameter :: kind_other = 7 !! sockets for the most part

  !> What is behind a path.
  type :: file_identity_t
    integer :: kind = kind_none !! one of the constants above
    integer(c_long) :: size = 0 !! bytes of a regular file
    integer(c_int) :: device(2) = 0 !! where it is
    integer(c_long) :: inode = 0 !! its number there
  end type file_identity_t

contains

  !> Asks the system what a path leads to.
  function identify(path) result(file)
    character(*), intent(in) :: path !! any path
    type(file_identity_t) :: file
    integer(c_int), parameter :: from_here = -100_c_int, basic = int(z'7FF', c_int), &
      no_permission = 13_c_int, too_many_links = 40_c_int
    type(statx_t) :: found
    integer(c_int) :: number

    if (c_statx(from_here, trim(path)//c_null_char, 0_c_int, basic, found) == 0_c_int) then
      file%kind = kind_of(ibits(int(found%mode), 12, 4))
      file%size = found%size
      file%device = found%device
      file%inode = found%inode
    else
      call read_errno(number)
      if (number == no_permission) file%kind = kind_closed
      if (number == too_many_links) file%kind = kind_circle
    end if
  end function identify

  !> The kind as the upper four bits of a mode have it (sys/stat.h).
  pure integer function kind_of(bits) result(kind)
    integer, intent(in) :: bits !! of the mode

    select case (bits)
    case (1)
      kind = kind_pipe
    case (2, 6)
      kind = kind_device
    case (4)
      kind = kind_folder
    case (8)
      kind = kind_file
    case default
      kind = kind_other
    end select
  end function kind_of

  !> Two paths lead to one file.
  pure logical function are_one(a, b)
    type(file_identity_t), intent(in) :: a, b !! what is behind them

    are_one = a%kind >= kind_file .and. a%kind == b%kind .and. a%inode == b%inode .and. &
      all(a%device == b%device)
  end function are_one

  !> Why something is no regular file, as words of a message; empty for one, and for nothing.
  pure function obstacle_of(file) result(t)
    type(file_identity_t), intent(in) :: file !! what is behind a path
    character(:), allocatable :: t

    select case (file%kind)
    case (kind_closed)
      t = 'a folder above it is closed to you'
    case (kind_circle)
      t = 'its links lead in a circle'
    case (kind_pipe)
      t = 'it is a pipe'
    case (kind_folder)
      t = 'it is a folder'
    case (kind_device)
      t = 'it is a device'
    case (kind_other)
      t = 'it is no regular file'
    case default
      t = ''
    end select
  end function obstacle_of
end module file_identity

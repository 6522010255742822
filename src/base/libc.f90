!> Prototypes of the few C library calls that Fortran has no word for, and nothing else.
!!
!! Text output goes through C streams because gfortran 12 loses the error when a buffer cannot be
!! written (disk full): neither write nor flush nor close report it.
module libc
  use, intrinsic :: iso_c_binding, only: c_char, c_int, c_long, c_ptr, c_short, &
    c_size_t, c_f_pointer
  implicit none
  private
  public :: c_fopen, c_fwrite, c_fflush, c_fclose, c_mkdir, c_rename, c_realpath, path_limit
  public :: c_fread, c_statx, statx_t
  public :: c_fileno, c_posix_fallocate, c_truncate, c_pread, c_pwrite, c_flock, &
    read_errno, c_memcpy, c_getrusage, rusage_t

  !> Longest path that C's realpath writes.
  integer, parameter :: path_limit = 4096

  !> Linux's struct rusage with words of 64 bits.
  type, bind(c) :: rusage_t
    integer(c_long) :: user(2) = 0 !! processor time of the program [s, 1E-6 s]
    integer(c_long) :: system(2) = 0 !! that of the system for it [s, 1E-6 s]
    integer(c_long) :: memory(12) = 0 !! memory, pages, blocks, messages, signals
    integer(c_long) :: given_up = 0 !! how often it has slept
    integer(c_long) :: taken_away = 0 !! how often others took its processor
  end type rusage_t

  !> Linux's struct statx, which is the same on all its machines.
  type, bind(c) :: statx_t
    integer(c_int) :: head(4) = 0 !! what is filled in, size of a block, attributes
    integer(c_int) :: owners(3) = 0 !! links, user, group
    integer(c_short) :: mode = 0 !! kind and permissions
    integer(c_short) :: spare = 0 !! not used
    integer(c_long) :: inode = 0 !! number of the file on its device
    integer(c_long) :: size = 0 !! bytes
    integer(c_long) :: blocks(10) = 0 !! blocks, attributes, times
    integer(c_int) :: is_device(2) = 0 !! numbers of the device that it is
    integer(c_int) :: device(2) = 0 !! numbers of the device that it is on
    integer(c_long) :: rest(14) = 0 !! mount, spare
  end type statx_t

  interface
    !> What a path leads to, behind its links; 0 is success.
    function c_statx(folder, path, flags, mask, found) result(status) bind(c, name='statx')
      import :: c_char, c_int, statx_t
      implicit none
      integer(c_int), value :: folder !! -100: a relative path starts in the working directory
      character(kind=c_char), intent(in) :: path(*) !! file name, closed by a null character
      integer(c_int), value :: flags !! 0: links are followed
      integer(c_int), value :: mask !! what is asked for, as linux/stat.h has it
      type(statx_t), intent(out) :: found !! the answer
      integer(c_int) :: status
    end function c_statx

    !> Reads items from a stream; returns how many there were.
    function c_fread(buffer, size, count, stream) result(taken) bind(c, name='fread')
      import :: c_char, c_ptr, c_size_t
      implicit none
      character(kind=c_char), intent(out) :: buffer(*) !! where they go
      integer(c_size_t), value :: size !! bytes of an item
      integer(c_size_t), value :: count !! items that there is room for
      type(c_ptr), value :: stream !! open stream
      integer(c_size_t) :: taken
    end function c_fread

    !> Opens a stream; a null pointer says that it failed.
    function c_fopen(path, mode) result(stream) bind(c, name='fopen')
      import :: c_char, c_ptr
      implicit none
      character(kind=c_char), intent(in) :: path(*) !! file name, closed by a null character
      character(kind=c_char), intent(in) :: mode(*) !! 'w' and a null character
      type(c_ptr) :: stream
    end function c_fopen

    !> Writes items to a stream; returns how many were taken.
    function c_fwrite(buffer, size, count, stream) result(written) bind(c, name='fwrite')
      import :: c_char, c_ptr, c_size_t
      implicit none
      character(kind=c_char), intent(in) :: buffer(*) !! what to write
      integer(c_size_t), value :: size !! bytes of an item
      integer(c_size_t), value :: count !! items
      type(c_ptr), value :: stream !! open stream
      integer(c_size_t) :: written
    end function c_fwrite

    !> Hands the buffer to the system; 0 is success.
    function c_fflush(stream) result(status) bind(c, name='fflush')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: stream !! open stream
      integer(c_int) :: status
    end function c_fflush

    !> Closes a stream; 0 is success.
    function c_fclose(stream) result(status) bind(c, name='fclose')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: stream !! open stream
      integer(c_int) :: status
    end function c_fclose

    !> Copies bytes; returns the place they went to.
    function c_memcpy(to, from, bytes) result(place) bind(c, name='memcpy')
      import :: c_ptr, c_size_t
      implicit none
      type(c_ptr), value :: to !! first byte that is written
      type(c_ptr), value :: from !! first byte that is read; the two do not overlap
      integer(c_size_t), value :: bytes !! how many
      type(c_ptr) :: place
    end function c_memcpy

    !> What was spent; 0 is success.
    function c_getrusage(who, spent) result(status) bind(c, name='getrusage')
      import :: c_int, rusage_t
      implicit none
      integer(c_int), value :: who !! 1: the thread that calls
      type(rusage_t), intent(out) :: spent !! since its beginning
      integer(c_int) :: status
    end function c_getrusage

    !> Makes a folder; 0 is success.
    function c_mkdir(path, mode) result(status) bind(c, name='mkdir')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: path(*) !! folder, closed by a null character
      integer(c_int), value :: mode !! permission bits
      integer(c_int) :: status
    end function c_mkdir

    !> Number of the file behind a stream.
    function c_fileno(stream) result(number) bind(c, name='fileno')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: stream !! open stream
      integer(c_int) :: number
    end function c_fileno

    !> Makes sure that there is room on the disk for a part of a file; 0 is success.
    function c_posix_fallocate(number, offset, length) result(status) &
      bind(c, name='posix_fallocate')
      import :: c_int, c_long
      implicit none
      integer(c_int), value :: number !! the file
      integer(c_long), value :: offset !! where the part begins
      integer(c_long), value :: length !! its bytes
      integer(c_int) :: status
    end function c_posix_fallocate

    !> Reads bytes from a place in a file; returns how many it has read.
    function c_pread(number, bytes, count, offset) result(taken) bind(c, name='pread')
      import :: c_char, c_int, c_long, c_size_t
      implicit none
      integer(c_int), value :: number !! the file
      integer(c_size_t), value :: count !! how many
      character(kind=c_char), intent(out) :: bytes(count) !! where they go
      integer(c_long), value :: offset !! where they stand
      integer(c_long) :: taken
    end function c_pread

    !> Writes bytes to a place in a file; returns how many it has written.
    function c_pwrite(number, bytes, count, offset) result(written) bind(c, name='pwrite')
      import :: c_char, c_int, c_long, c_size_t
      implicit none
      integer(c_int), value :: number !! the file
      character(kind=c_char), intent(in) :: bytes(*) !! what to write
      integer(c_size_t), value :: count !! how many
      integer(c_long), value :: offset !! where to
      integer(c_long) :: written
    end function c_pwrite

    !> Where glibc keeps the number of the last error.
    function c_errno_location() result(place) bind(c, name='__errno_location')
      import :: c_ptr
      implicit none
      type(c_ptr) :: place
    end function c_errno_location

    !> Locks a file that is open; 0 is success.
    function c_flock(number, operation) result(status) bind(c, name='flock')
      import :: c_int
      implicit none
      integer(c_int), value :: number !! the file
      integer(c_int), value :: operation !! 6: for this process alone, without waiting
      integer(c_int) :: status
    end function c_flock

    !> Cuts a file off; 0 is success.
    function c_truncate(path, length) result(status) bind(c, name='truncate')
      import :: c_char, c_int, c_long
      implicit none
      character(kind=c_char), intent(in) :: path(*) !! file name, closed by a null character
      integer(c_long), value :: length !! bytes that stay
      integer(c_int) :: status
    end function c_truncate

    !> Renames a file over the one that has the new name; 0 is success.
    function c_rename(old, new) result(status) bind(c, name='rename')
      import :: c_char, c_int
      implicit none
      character(kind=c_char), intent(in) :: old(*) !! file name, closed by a null character
      character(kind=c_char), intent(in) :: new(*) !! new name, closed by a null character
      integer(c_int) :: status
    end function c_rename

    !> The path without links and dots; a null pointer if there is no such file.
    function c_realpath(path, resolved) result(address) bind(c, name='realpath')
      import :: c_char, c_ptr, path_limit
      implicit none
      character(kind=c_char), intent(in) :: path(*) !! path, closed by a null character
      character(kind=c_char), intent(inout) :: resolved(path_limit) !! gets it, null-terminated
      type(c_ptr) :: address
    end function c_realpath
  end interface

contains

  !> The number of the last error of the C library.
  subroutine read_errno(number)
    integer(c_int), intent(out) :: number !! as errno.h has them
    integer(c_int), pointer :: place

    call c_f_pointer(c_errno_location(), place)
    number = place
  end subroutine read_errno
end module libc

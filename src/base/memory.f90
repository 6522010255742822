!> The memory of the process: what it has used at most, and what it may still take.
module memory
  use, intrinsic :: iso_c_binding, only: c_int, c_long
  use kinds, only: wp
  use text, only: to_text
  implicit none
  private
  public :: peak_memory, memory_left, address_limited, memory_text

  !> C's struct rlimit: the limit that holds, and the highest that may be set.
  type, bind(c) :: limit_t
    integer(c_long) :: now !! the limit; below 0 for none
    integer(c_long) :: highest !! the highest
  end type limit_t

  !> RLIMIT_AS of Linux: the size of the address space.
  integer(c_int), parameter :: address_space = 9_c_int

  real(wp), parameter :: kilobyte = 1024.0_wp

  interface
    !> C's getrlimit: 0 when it has answered.
    integer(c_int) function c_getrlimit(resource, limit) bind(c, name='getrlimit')
      import :: c_int, limit_t
      implicit none
      integer(c_int), value :: resource !! which limit
      type(limit_t), intent(out) :: limit !! its values
    end function c_getrlimit
  end interface

contains

  !> The most memory that the process has used so far [byte]; 0 where the system does not say.
  real(wp) function peak_memory() result(bytes)
    bytes = max(0.0_wp, entry_of('/proc/self/status', 'VmHWM:'))
  end function peak_memory

  !> The memory that the process may still take [byte]: what is free, within the limit of its
  !! address space and that of its group; the largest number where the system does not say.
  real(wp) function memory_left() result(bytes)
    type(limit_t) :: limit
    integer(c_int) :: status
    real(wp) :: size_now, share, used

    bytes = entry_of('/proc/meminfo', 'MemAvailable:')
    if (bytes < 0.0_wp) bytes = huge(1.0_wp)
    size_now = entry_of('/proc/self/status', 'VmSize:')
    status = c_getrlimit(address_space, limit)
    if (size_now >= 0.0_wp .and. status == 0_c_int) then
      if (limit%now > 0_c_long) bytes = min(bytes, max(0.0_wp, real(limit%now, wp) - size_now))
    end if
    share = number_in('/sys/fs/cgroup/memory.max')
    used = number_in('/sys/fs/cgroup/memory.current')
    if (share > 0.0_wp .and. used >= 0.0_wp) bytes = min(bytes, max(0.0_wp, share - used))
  end function memory_left

  !> Somebody has limited the address space of the process (ulimit -v).
  logical function address_limited()
    type(limit_t) :: limit

    address_limited = c_getrlimit(address_space, limit) == 0_c_int
    if (address_limited) address_limited = limit%now > 0_c_long
  end function address_limited

  !> A size in words: 12 MB, 3.4 GB.
  pure function memory_text(bytes) result(t)
    real(wp), intent(in) :: bytes !! the size [byte]
    character(:), allocatable :: t

    if (bytes < 1.0e9_wp) then
      t = to_text(ceiling(1.0e-6_wp*bytes))//' MB'
    else
      t = to_text(1.0e-9_wp*bytes, 3)//' GB'
    end if
  end function memory_text

  !> The entry of a file with lines `name: number kB` [byte]; -1 if there is none.
  real(wp) function entry_of(path, name) result(bytes)
    character(*), intent(in) :: path !! the file
    character(*), intent(in) :: name !! the entry with its colon
    character(200) :: line
    integer :: unit, status

    bytes = -1.0_wp
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    if (status /= 0) return
    do
      read (unit, '(a)', iostat=status) line
      if (status /= 0) exit
      if (index(line, name) /= 1) cycle
      read (line(len(name) + 1:), *, iostat=status) bytes
      if (status == 0) bytes = kilobyte*bytes
      exit
    end do
    close (unit)
  end function entry_of

  !> The number that a file holds; -1 if there is none.
  real(wp) function number_in(path) result(number)
    character(*), intent(in) :: path !! the file
    character(40) :: line
    integer :: unit, status

    number = -1.0_wp
    open (newunit=unit, file=path, action='read', status='old', iostat=status)
    if (status /= 0) return
    read (unit, '(a)', iostat=status) line
    if (status == 0 .and. verify(trim(line), '0123456789') == 0 .and. len_trim(line) > 0) then
      read (line, *, iostat=status) number
      if (status /= 0) number = -1.0_wp
    end if
    close (unit)
  end function number_in
end module memory

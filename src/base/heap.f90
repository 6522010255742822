!> The heap of the process: what becomes of freed memory, and the size of its pages. glibc's malloc
!! serves Fortran, SuiteSparse and HDF5 alike.
module heap
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr, c_size_t, c_intptr_t, c_associated
  use kinds, only: wp
  use memory, only: memory_left, address_limited
  implicit none
  private
  public :: keep_memory, return_memory

  ! Options of glibc's mallopt (malloc.h)
  integer(c_int), parameter :: trim_threshold = -1_c_int
  integer(c_int), parameter :: top_pad = -2_c_int
  integer(c_int), parameter :: mmap_threshold = -3_c_int
  integer(c_int), parameter :: mmap_max = -4_c_int
  integer(c_int), parameter :: arena_max = -8_c_int
  !> Blocks up to this size come from the heap, and so much of it is kept when it is free [bytes].
  integer(c_int), parameter :: kept_bytes = 1073741824_c_int
  !> The heap grows by this much at a time [bytes], by less where little is left.
  integer(c_int), parameter :: growth_bytes = 67108864_c_int
  !> And by this share of what is left at most.
  real(wp), parameter :: growth_share = 0.03_wp
  !> Blocks of more than this size go back to the system when they are free, where memory is what a
  !! run is short of [bytes].
  integer(c_int), parameter :: returned_bytes = 262144_c_int
  !> So many of them at most, as glibc has it.
  integer(c_int), parameter :: most_returned = 65536_c_int
  !> Large pages are asked for on so much of the heap [bytes], and on this share of what is left at
  !! most; less than kept_bytes, so that it stays when it is free.
  integer(c_int), parameter :: wide_bytes = 1000000000_c_int
  real(wp), parameter :: wide_share = 0.25_wp
  !> A page of the system at least [bytes].
  integer(c_intptr_t), parameter :: page_bytes = 65536_c_intptr_t
  !> MADV_HUGEPAGE of Linux's madvise.
  integer(c_int), parameter :: huge_pages = 14_c_int

  interface
    !> glibc's mallopt: 1 when the option was taken.
    integer(c_int) function c_mallopt(option, value) bind(c, name='mallopt')
      import :: c_int
      implicit none
      integer(c_int), value :: option !! which option
      integer(c_int), value :: value !! its value
    end function c_mallopt

    !> C's malloc; a null pointer says that there is no memory.
    function c_malloc(bytes) result(block) bind(c, name='malloc')
      import :: c_ptr, c_size_t
      implicit none
      integer(c_size_t), value :: bytes !! how many
      type(c_ptr) :: block
    end function c_malloc

    !> C's free.
    subroutine c_free(block) bind(c, name='free')
      import :: c_ptr
      implicit none
      type(c_ptr), value :: block !! of malloc
    end subroutine c_free

    !> Linux's madvise: 0 when the advice was taken.
    integer(c_int) function c_madvise(first, bytes, advice) bind(c, name='madvise')
      import :: c_int, c_size_t, c_intptr_t
      implicit none
      integer(c_intptr_t), value :: first !! address where a page begins
      integer(c_size_t), value :: bytes !! from there on
      integer(c_int), value :: advice !! which
    end function c_madvise
  end interface

contains

  !> Keeps freed memory for the next factorisation instead of giving it back to the system, which
  !! costs a quarter of the time of a run with many large factors. All threads share one heap: one
  !! of their own would have small pages, and would not serve the others.
  subroutine keep_memory()
    integer(c_int) :: taken, growth

    growth = int(min(real(growth_bytes, wp), growth_share*memory_left()), c_int)
    taken = c_mallopt(arena_max, 1_c_int)
    taken = c_mallopt(mmap_threshold, kept_bytes)
    if (taken == 1_c_int) taken = c_mallopt(trim_threshold, kept_bytes)
    if (taken == 1_c_int) taken = c_mallopt(top_pad, growth)
    if (address_limited()) return
    if (taken == 1_c_int) call widen_pages()
  end subroutine keep_memory

  !> Asks for large pages on the first part of the heap: the system then clears and maps 2 MB at a
  !! time, which saves a tenth of the time of a run that is mostly one factorisation. What nobody
  !! writes to costs no memory. Nothing happens where the system has no such pages.
  subroutine widen_pages()
    type(c_ptr) :: block
    integer(c_intptr_t) :: first, bytes
    integer(c_int) :: ignored

    bytes = int(min(real(wide_bytes, wp), wide_share*memory_left()), c_intptr_t)
    block = c_malloc(int(bytes, c_size_t))
    if (.not. c_associated(block)) return
    first = transfer(block, first)
    first = first + modulo(-first, page_bytes)
    bytes = bytes - 2*page_bytes
    if (bytes > 0) ignored = c_madvise(first, int(bytes, c_size_t), huge_pages)
    call c_free(block)
  end subroutine widen_pages

  !> Gives freed memory back to the system, from now on. Open MPI forbids it where it starts.
  subroutine return_memory()
    integer(c_int) :: taken

    taken = c_mallopt(mmap_threshold, returned_bytes)
    if (taken == 1_c_int) taken = c_mallopt(trim_threshold, returned_bytes)
    if (taken == 1_c_int) taken = c_mallopt(top_pad, 0_c_int)
    if (taken == 1_c_int) taken = c_mallopt(mmap_max, most_returned)
  end subroutine return_memory
end module heap

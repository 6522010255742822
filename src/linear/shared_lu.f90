!> LU factors of a dense matrix in single precision that threads share (doc/theory, "Linear
!! systems").
module shared_lu
  use, intrinsic :: iso_c_binding, only: c_int
  use kinds, only: sp
  use omp_lib, only: omp_get_thread_num, omp_get_num_threads
  use threads, only: count_threads
  use libc, only: c_sched_yield
  use lapack_interface, only: sgetrf, slaswp, strsm, sgemm
  implicit none
  private
  public :: factorise_dense

  !> Smaller ones are LAPACK's alone.
  integer, parameter :: least_shared = 256
  !> Columns of a block.
  integer, parameter :: width = 48
  !> Looks at what another thread has done, before the processor is offered to others.
  integer, parameter :: patience = 2000

contains

  !> P A = L U, as LAPACK's SGETRF stores it.
  subroutine factorise_dense(n, a, stored, pivot, info)
    integer, intent(in) :: n !! rows
    integer, intent(in) :: stored !! rows that they are stored with
    real(sp), intent(inout) :: a(stored, *) !! in: A; out: L and U
    integer, intent(out) :: pivot(*) !! (n) row that each was changed with
    integer, intent(out) :: info !! 0, or a pivot that is zero
    integer :: ready, team

    team = count_threads()
    if (n < least_shared .or. team == 1) then
      call sgetrf(n, n, a, stored, pivot, info)
      return
    end if
    ready = 0
    info = 0
    !$omp parallel default(none) shared(n, stored, a, pivot, info, ready)
    call factorise_own(n, a, stored, pivot, info, ready, omp_get_thread_num(), &
      omp_get_num_threads())
    !$omp end parallel
  end subroutine factorise_dense

  !> What one thread does: it owns every so many blocks of columns, brings them up to date with each
  !! block that is ready, and makes its own ready as soon as that has been done. So the next block
  !! is factorised while others are brought up to date.
  subroutine factorise_own(n, a, stored, pivot, info, ready, thread, team)
    integer, intent(in) :: n, stored !! as above
    real(sp), intent(inout) :: a(stored, *) !! as above
    integer, intent(inout) :: pivot(*) !! as above
    integer, intent(inout) :: info !! as above
    integer, intent(inout) :: ready !! blocks that are
    integer, intent(in) :: thread !! from 0
    integer, intent(in) :: team !! how many threads
    integer :: blocks, k, j, first, last, columns, next

    blocks = (n + width - 1)/width
    if (thread == 0) call factorise_block(n, a, stored, 1, pivot, info, ready)
    do k = 1, blocks - 1
      call wait_for(k, ready)
      first = (k - 1)*width + 1
      next = k*width + 1
      do j = k + 1, blocks
        if (mod(j - 1, team) /= thread) cycle
        last = (j - 1)*width
        columns = min(width, n - last)
        call slaswp(columns, a(1, last + 1), stored, first, next - 1, pivot, 1)
        call strsm('L', 'L', 'N', 'U', width, columns, 1.0_sp, a(first, first), stored, &
          a(first, last + 1), stored)
        call sgemm('N', 'N', n - next + 1, columns, width, -1.0_sp, a(next, first), stored, &
          a(first, last + 1), stored, 1.0_sp, a(next, last + 1), stored)
        if (j == k + 1) call factorise_block(n, a, stored, j, pivot, info, ready)
      end do
    end do
    call wait_for(blocks, ready)
    do j = 1, blocks - 1
      if (mod(j - 1, team) == thread) call slaswp(width, a(1, (j - 1)*width + 1), stored, &
        j*width + 1, n, pivot, 1)
    end do
  end subroutine factorise_own

  !> Factorises a block from its diagonal on, once it is up to date.
  subroutine factorise_block(n, a, stored, block, pivot, info, ready)
    integer, intent(in) :: n, stored !! as above
    real(sp), intent(inout) :: a(stored, *) !! as above
    integer, intent(in) :: block !! its number
    integer, intent(inout) :: pivot(*) !! gets those of its columns
    integer, intent(inout) :: info !! gets its first pivot that is zero, if there was none
    integer, intent(inout) :: ready !! gets block
    integer :: before, columns, zero

    before = (block - 1)*width
    columns = min(width, n - before)
    call sgetrf(n - before, columns, a(before + 1, before + 1), stored, pivot(before + 1), zero)
    pivot(before + 1:before + columns) = pivot(before + 1:before + columns) + before
    if (zero /= 0 .and. info == 0) info = before + zero
    !$omp atomic write seq_cst
    ready = block
  end subroutine factorise_block

  !> Waits until a block is ready.
  subroutine wait_for(block, ready)
    integer, intent(in) :: block !! its number
    integer, intent(inout) :: ready !! blocks that are; another thread counts
    integer :: now, looks
    integer(c_int) :: ignored

    looks = 0
    do
      !$omp atomic read seq_cst
      now = ready
      if (now >= block) exit
      looks = looks + 1
      if (looks > patience) ignored = c_sched_yield()
    end do
  end subroutine wait_for
end module shared_lu

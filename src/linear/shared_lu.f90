!> LU factors of a dense matrix in single precision that threads share (doc/theory, "Sparse
!! factorisation").
module shared_lu
  use, intrinsic :: iso_c_binding, only: c_int
  use kinds, only: sp, wp
  use threads, only: count_threads, pays_threads
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

  !> How far the threads are.
  type :: progress_t
    integer, allocatable :: steps(:) !! (blocks) blocks that each is up to date with, its own number
    !! once it is factorised
    integer :: taken = 0 !! tasks that threads have taken
    integer :: turned = 0 !! blocks whose rows they have taken to exchange in the end
  end type progress_t

contains

  !> P A = L U, as LAPACK's SGETRF stores it.
  subroutine factorise_dense(n, a, stored, pivot, info)
    integer, intent(in) :: n !! rows
    integer, intent(in) :: stored !! rows that they are stored with
    real(sp), intent(inout) :: a(stored, *) !! in: A; out: L and U
    integer, intent(out) :: pivot(*) !! (n) row that each was changed with
    integer, intent(out) :: info !! 0, or a pivot that is zero
    type(progress_t) :: progress
    integer :: team
    logical :: pays

    team = count_threads()
    if (n < least_shared .or. team == 1) then
      call sgetrf(n, n, a, stored, pivot, info)
      return
    end if
    allocate (progress%steps((n + width - 1)/width), source=0)
    info = 0
    call factorise_block(n, a, stored, 1, pivot, info)
    progress%steps(1) = 1
    pays = pays_threads(2.0_wp/3.0_wp*real(n, wp)**3)
    !$omp parallel if(pays) default(none) shared(n, stored, a, pivot, info, progress)
    call take_tasks(n, a, stored, pivot, info, progress)
    !$omp end parallel
  end subroutine factorise_dense

  !> What a thread does: it takes the next task as long as there is one. So nobody waits for a
  !! thread that the system has not called yet. A task brings a block of columns up to date with one
  !! before it, those with the first block first, and if that is the last one before it factorises
  !! it: the next block is made while others are brought up to date.
  subroutine take_tasks(n, a, stored, pivot, info, progress)
    integer, intent(in) :: n, stored !! as above
    real(sp), intent(inout) :: a(stored, *) !! as above
    integer, intent(inout) :: pivot(*) !! as above
    integer, intent(inout) :: info !! as above
    type(progress_t), intent(inout) :: progress !! of all threads
    integer :: blocks, with, block, task

    blocks = size(progress%steps)
    with = 1
    block = 1
    do
      call take_next(progress%taken, task)
      call advance(blocks, task, with, block)
      if (with >= blocks) exit
      call wait_for(with, progress%steps(with))
      call wait_for(with - 1, progress%steps(block))
      call update_block(n, a, stored, with, block, pivot)
      if (block == with + 1) call factorise_block(n, a, stored, block, pivot, info)
      !$omp atomic write seq_cst
      progress%steps(block) = merge(block, with, block == with + 1)
    end do
    call wait_for(blocks, progress%steps(blocks))
    do
      call take_next(progress%turned, block)
      if (block >= blocks) exit
      call slaswp(width, a(1, (block - 1)*width + 1), stored, block*width + 1, n, pivot, 1)
    end do
  end subroutine take_tasks

  !> The next number that no thread has taken.
  subroutine take_next(taken, number)
    integer, intent(inout) :: taken !! how many have been taken
    integer, intent(out) :: number !! the number, from 1

    !$omp atomic capture
    taken = taken + 1
    number = taken
    !$omp end atomic
  end subroutine take_next

  !> The block of a task and the one that it is brought up to date with. Tasks of a thread ascend.
  pure subroutine advance(blocks, task, with, block)
    integer, intent(in) :: blocks !! how many
    integer, intent(in) :: task !! its number
    integer, intent(inout) :: with !! in: that of a task before, or 1; blocks where there is no task
    integer, intent(out) :: block !! the block
    integer :: before

    ! with block k there are blocks - k tasks
    before = (with - 1)*blocks - (with*(with - 1))/2
    do while (with < blocks .and. task > before + blocks - with)
      before = before + blocks - with
      with = with + 1
    end do
    block = with + task - before
  end subroutine advance

  !> Brings a block up to date with one before it: exchanges, U and what is below.
  subroutine update_block(n, a, stored, with, block, pivot)
    integer, intent(in) :: n, stored !! as above
    real(sp), intent(inout) :: a(stored, *) !! as above
    integer, intent(in) :: with !! the one before
    integer, intent(in) :: block !! the block
    integer, intent(in) :: pivot(*) !! as above
    integer :: first, next, place, columns

    first = (with - 1)*width + 1
    next = with*width + 1
    place = (block - 1)*width + 1
    columns = min(width, n - place + 1)
    call slaswp(columns, a(1, place), stored, first, next - 1, pivot, 1)
    call strsm('L', 'L', 'N', 'U', width, columns, 1.0_sp, a(first, first), stored, &
      a(first, place), stored)
    call sgemm('N', 'N', n - next + 1, columns, width, -1.0_sp, a(next, first), stored, &
      a(first, place), stored, 1.0_sp, a(next, place), stored)
  end subroutine update_block

  !> Factorises a block from its diagonal on, once it is up to date.
  subroutine factorise_block(n, a, stored, block, pivot, info)
    integer, intent(in) :: n, stored !! as above
    real(sp), intent(inout) :: a(stored, *) !! as above
    integer, intent(in) :: block !! its number
    integer, intent(inout) :: pivot(*) !! gets those of its columns
    integer, intent(inout) :: info !! gets its first pivot that is zero, if there was none
    integer :: before, columns, zero

    before = (block - 1)*width
    columns = min(width, n - before)
    call sgetrf(n - before, columns, a(before + 1, before + 1), stored, pivot(before + 1), zero)
    pivot(before + 1:before + columns) = pivot(before + 1:before + columns) + before
    if (zero /= 0 .and. info == 0) info = before + zero
  end subroutine factorise_block

  !> Waits until a block is far enough.
  subroutine wait_for(wanted, steps)
    integer, intent(in) :: wanted !! steps that it must have made
    integer, intent(inout) :: steps !! those that it has; another thread counts
    integer :: now, looks
    integer(c_int) :: ignored

    looks = 0
    do
      !$omp atomic read seq_cst
      now = steps
      if (now >= wanted) exit
      looks = looks + 1
      if (looks > patience) ignored = c_sched_yield()
    end do
  end subroutine wait_for
end module shared_lu

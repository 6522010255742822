!> The threads of the program.
module threads
  use kinds, only: wp
  use omp_lib, only: omp_set_num_threads, omp_set_max_active_levels, omp_get_max_threads, &
    omp_get_num_procs
  implicit none
  private
  public :: set_threads, count_threads, count_cores, pays_threads

  !> Multiplications and additions that take a few times as long as a thread takes to wake up.
  real(wp), parameter :: long_work = 5.0e5_wp

contains

  !> Sets how many threads the parallel loops have. CHOLMOD asks for four in each of its loops,
  !! whatever is set: with one thread there shall be no parallel loop at all.
  subroutine set_threads(n)
    integer, intent(in) :: n !! number of threads

    call omp_set_num_threads(n)
    call omp_set_max_active_levels(merge(1, 0, n > 1))
  end subroutine set_threads

  !> Threads of the parallel loops.
  integer function count_threads() result(n)
    n = omp_get_max_threads()
  end function count_threads

  !> A piece of work is worth waking other threads for, and there are some.
  logical function pays_threads(operations)
    real(wp), intent(in) :: operations !! multiplications and additions

    pays_threads = operations > long_work
    if (pays_threads) pays_threads = count_threads() > 1
  end function pays_threads

  !> Cores that the process may use.
  integer function count_cores() result(n)
    n = omp_get_num_procs()
  end function count_cores
end module threads

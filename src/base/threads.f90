!> The threads of the program.
module threads
  use omp_lib, only: omp_set_num_threads, omp_set_max_active_levels, omp_get_max_threads, &
    omp_get_num_procs
  implicit none
  private
  public :: set_threads, count_threads, count_cores

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

  !> Cores that the process may use.
  integer function count_cores() result(n)
    n = omp_get_num_procs()
  end function count_cores
end module threads

!> The threads of the program.
module threads
  use, intrinsic :: iso_c_binding, only: c_int, c_ptr, c_funptr, c_f_procpointer
  use kinds, only: wp
  use omp_lib, only: omp_set_num_threads, omp_set_max_active_levels, omp_get_max_threads, &
    omp_get_max_active_levels, omp_get_num_procs
  implicit none
  private
  public :: set_threads, count_threads, count_cores, worth_threads, pays_threads

  !> Multiplications and additions that take a few times as long as a thread takes to wake up.
  real(wp), parameter :: long_work = 5.0e5_wp

  abstract interface
    !> What the compiler makes of a parallel region.
    subroutine region_i(data) bind(c)
      import :: c_ptr
      implicit none
      type(c_ptr), value :: data !! the variables of its surroundings
    end subroutine region_i
  end interface

  interface
    !> libgomp: calls other threads into a region.
    subroutine gomp_parallel_start(region, data, wanted) bind(c, name='GOMP_parallel_start')
      import :: c_int, c_ptr, c_funptr
      implicit none
      type(c_funptr), value :: region !! the region
      type(c_ptr), value :: data !! the variables of its surroundings
      integer(c_int), value :: wanted !! threads, 0 for as many as are set
    end subroutine gomp_parallel_start

    !> libgomp: waits for the other threads of a region.
    subroutine gomp_parallel_end() bind(c, name='GOMP_parallel_end')
      implicit none
    end subroutine gomp_parallel_end
  end interface

contains

  !> Sets how many threads the parallel loops have. CHOLMOD asks for four in each of its loops,
  !! whatever is set: with one thread there shall be no parallel loop at all.
  subroutine set_threads(n)
    integer, intent(in) :: n !! number of threads

    call omp_set_num_threads(n)
    call omp_set_max_active_levels(merge(1, 0, n > 1))
  end subroutine set_threads

  !> Called where a parallel region begins, of ours or of CHOLMOD, in place of libgomp's procedure.
  !! That one makes a team of one thread where there is one alone, and dissolves it by a call of the
  !! system: tens of thousands of times while a large matrix is factorised.
  subroutine run_region(region, data, wanted) bind(c, name='GOMP_parallel')
    type(c_funptr), value :: region !! the region
    type(c_ptr), value :: data !! the variables of its surroundings
    integer(c_int), value :: wanted !! threads, 0 for as many as are set; more arguments follow
    procedure(region_i), pointer :: run

    call c_f_procpointer(region, run)
    if (omp_get_max_active_levels() == 0) then
      call run(data)
    else
      call gomp_parallel_start(region, data, wanted)
      call run(data)
      call gomp_parallel_end()
    end if
  end subroutine run_region

  !> Threads of the parallel loops.
  integer function count_threads() result(n)
    n = omp_get_max_threads()
  end function count_threads

  !> Threads that a piece of work is worth: all of them, or one.
  integer function worth_threads(operations) result(n)
    real(wp), intent(in) :: operations !! multiplications and additions

    n = 1
    if (operations > long_work) n = count_threads()
  end function worth_threads

  !> A piece of work is worth waking other threads for, and there are some.
  logical function pays_threads(operations)
    real(wp), intent(in) :: operations !! multiplications and additions

    pays_threads = worth_threads(operations) > 1
  end function pays_threads

  !> Cores that the process may use.
  integer function count_cores() result(n)
    n = omp_get_num_procs()
  end function count_cores
end module threads

!> The threads of the program.
module threads
  use, intrinsic :: iso_c_binding, only: c_int, c_long, c_ptr, c_funptr, c_f_procpointer
  use kinds, only: wp
  use libc, only: c_getrusage, rusage_t
  use omp_lib, only: omp_set_num_threads, omp_set_max_active_levels, omp_get_max_threads, &
    omp_get_max_active_levels, omp_get_num_procs
  implicit none
  private
  public :: set_threads, count_threads, count_cores, worth_threads, pays_threads, &
    notice_others

  !> Multiplications and additions that take a few times as long as a thread takes to wake up.
  real(wp), parameter :: long_work = 1.0e6_wp
  !> The same where others want the processors: a thread that is called waits until one of them has
  !! had its turn, some milliseconds.
  real(wp), parameter :: long_among_others = 2.0e8_wp
  !> Others want the processors where they take that of a thread so often [1/s of its time].
  real(wp), parameter :: often = 150.0_wp
  !> A look takes at least so much of the thread's time [s].
  real(wp), parameter :: look = 0.02_wp

  !> What the last look at the machine has shown; it lasts until the next one.
  type :: look_t
    logical :: others = .false. !! others want the processors
    real(wp) :: seconds = 0.0_wp !! processor time of the thread until then [s]
    integer(c_long) :: taken_away = 0 !! how often others had taken its processor until then
  end type look_t

  type(look_t) :: seen

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

  !> Looks whether others want the processors, between one piece of work and the next. No result
  !! depends on it: what `worth_threads` parts has the same digits in one piece.
  subroutine notice_others()
    integer(c_int), parameter :: this_thread = 1
    type(rusage_t) :: spent
    real(wp) :: seconds

    if (count_threads() == 1) return
    if (c_getrusage(this_thread, spent) /= 0) return
    seconds = real(spent%user(1) + spent%system(1), wp) &
      + 1.0e-6_wp*real(spent%user(2) + spent%system(2), wp)
    if (seconds - seen%seconds < look) return
    seen = look_t(real(spent%taken_away - seen%taken_away, wp) > often*(seconds - seen%seconds), &
      seconds, spent%taken_away)
  end subroutine notice_others

  !> Threads that a piece of work is worth: all of them, or one.
  integer function worth_threads(operations) result(n)
    real(wp), intent(in) :: operations !! multiplications and additions

    n = 1
    if (operations > merge(long_among_others, long_work, seen%others)) n = count_threads()
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

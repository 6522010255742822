!> How a run on several processes begins, agrees and ends: MPI and PETSc are started and stopped.
!!
!! Every process reads the deck, assembles and decides for itself, by the same bytes; PETSc's
!! vectors come to all of them. So they can differ in nothing but what the system does to one.
module parallel
  use, intrinsic :: iso_c_binding, only: c_int, c_double, c_ptr, c_funloc, c_null_char, &
    c_null_ptr, c_f_pointer
  use kinds, only: wp
  use costs, only: wall_seconds
  use signals, only: last_words
  use heap, only: return_memory
  use errors, only: error_t, raise, exit_deck, exit_resources
  use text, only: to_text
  use ranks, only: count_ranks, this_rank
  use petsc_interface, only: petsc_comm_world, mpi_comm_size, mpi_comm_dup, mpi_ibarrier, &
    mpi_test, mpi_abort, vec_create, vec_set_sizes, vec_set_type, vec_get_array, &
    vec_restore_array, vec_max, vec_destroy, petsc_options_set, petsc_initialize, &
    petsc_finalize, petsc_push_error_handler, petsc_return_error
  use petsc_faults, only: note
  use petsc_options, only: set_options
  implicit none
  private
  public :: start_parallel, any_rank, end_parallel

  !> Seconds that a process that has failed waits for the others.
  real(wp), parameter :: seconds_for_others = 0.25_wp

  !> What all processes meet on at their end; what they send each other before must not get into it.
  type(c_ptr) :: meeting = c_null_ptr

contains

  !> Starts MPI and PETSc. Signals stay ours, and errors come back to who has called. Memory is what
  !! runs with PETSc are short of: what is freed goes back to the system.
  subroutine start_parallel(error)
    type(error_t), allocatable, intent(out) :: error !! it cannot be started
    integer(c_int) :: fault, n

    fault = 0_c_int
    call note(fault, petsc_options_set(c_null_ptr, '-no_signal_handler'//c_null_char, &
      'true'//c_null_char))
    call note(fault, petsc_options_set(c_null_ptr, '-skip_petscrc'//c_null_char, &
      'true'//c_null_char))
    call note(fault, petsc_initialize())
    call return_memory()
    if (fault == 0_c_int) call note(fault, petsc_push_error_handler(c_funloc(petsc_return_error), &
      c_null_ptr))
    if (fault == 0_c_int) call set_options(fault)
    n = 1_c_int
    if (fault == 0_c_int) call note(fault, mpi_comm_size(petsc_comm_world, n))
    if (fault /= 0_c_int) then
      call raise(error, exit_resources, 'error: PETSc cannot be started (error '// &
        to_text(int(fault))//')'//new_line('a')//'  look at the installation of PETSc and MPI')
    else if (int(n) /= count_ranks()) then
      call raise(error, exit_deck, 'command line: error: MPI has '//to_text(int(n))// &
        ' processes, and mpirun tells of '//to_text(count_ranks())//new_line('a')// &
        '  start the program by the mpirun of the MPI it was built with')
    end if
    if (fault == 0_c_int) fault = mpi_comm_dup(petsc_comm_world, meeting)
  end subroutine start_parallel

  !> Something is so on one of the processes: all of them ask, and all get the same answer.
  logical function any_rank(here)
    logical, intent(in) :: here !! it is so on this one
    type(c_ptr) :: x, array
    real(c_double), pointer :: value(:)
    real(c_double) :: largest
    integer(c_int) :: fault

    any_rank = here
    if (count_ranks() == 1) return
    fault = 0_c_int
    call note(fault, vec_create(petsc_comm_world, x))
    if (fault /= 0_c_int) return
    call note(fault, vec_set_sizes(x, 1_c_int, int(count_ranks(), c_int)))
    call note(fault, vec_set_type(x, 'standard'//c_null_char))
    call note(fault, vec_get_array(x, array))
    if (fault /= 0_c_int) return
    call c_f_pointer(array, value, [1])
    value = merge(1.0_c_double, 0.0_c_double, here)
    call note(fault, vec_restore_array(x, array))
    call note(fault, vec_max(x, c_null_ptr, largest))
    call note(fault, vec_destroy(x))
    any_rank = largest > 0.5_c_double
  end function any_rank

  !> Ends PETSc and MPI when all processes have come to their end. One that has failed does not wait
  !! for long: the others may be waiting for what it will never send, so it ends all of them.
  subroutine end_parallel(error)
    type(error_t), allocatable, intent(in) :: error !! what this process has failed of
    real(wp) :: begin
    type(c_ptr) :: request
    integer(c_int) :: arrived, ignored

    begin = wall_seconds()
    arrived = 0_c_int
    ignored = mpi_ibarrier(meeting, request)
    do while (arrived == 0_c_int)
      ignored = mpi_test(request, arrived, c_null_ptr)
      if (wall_seconds() - begin > seconds_for_others .and. allocated(error)) exit
    end do
    if (arrived /= 0_c_int) then
      ignored = petsc_finalize()
    else
      if (this_rank() > 0) call last_words(error%message//new_line('a')//'  this was process '// &
        to_text(this_rank())//' of '//to_text(count_ranks())//'; the others end with it')
      ignored = mpi_abort(petsc_comm_world, int(error%code, c_int))
    end if
  end subroutine end_parallel
end module parallel

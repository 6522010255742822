!> How a run on several processes begins and ends: MPI and PETSc are started and stopped.
module parallel
  use, intrinsic :: iso_c_binding, only: c_int, c_funloc, c_null_char, c_null_ptr
  use errors, only: error_t, raise, exit_deck, exit_resources
  use text, only: to_text
  use ranks, only: count_ranks
  use petsc_interface, only: petsc_comm_world, mpi_comm_size, petsc_options_set, &
    petsc_initialize, petsc_finalize, petsc_push_error_handler, petsc_return_error
  use petsc_matrices, only: note
  use petsc_preconditioner, only: set_options
  implicit none
  private
  public :: start_parallel, end_parallel

contains

  !> Starts MPI and PETSc. Signals stay ours, and errors come back to who has called.
  subroutine start_parallel(error)
    type(error_t), allocatable, intent(out) :: error !! it cannot be started
    integer(c_int) :: fault, n

    fault = 0_c_int
    call note(fault, petsc_options_set(c_null_ptr, '-no_signal_handler'//c_null_char, &
      'true'//c_null_char))
    call note(fault, petsc_options_set(c_null_ptr, '-skip_petscrc'//c_null_char, &
      'true'//c_null_char))
    call note(fault, petsc_initialize())
    if (fault == 0_c_int) call note(fault, petsc_push_error_handler(c_funloc(petsc_return_error), &
      c_null_ptr))
    if (fault == 0_c_int) call set_options(count_ranks(), fault)
    n = 1_c_int
    if (fault == 0_c_int) call note(fault, mpi_comm_size(petsc_comm_world, n))
    if (fault /= 0_c_int) then
      call raise(error, exit_resources, 'error: PETSc cannot be started (error '// &
        to_text(int(fault))//')'//new_line('a')//'  look at the installation of PETSc and MPI')
    else if (count_ranks() > 1) then
      call raise(error, exit_deck, 'command line: error: this version of mfec-petsc works on '// &
        'one rank, and mpirun has started '//to_text(count_ranks())//new_line('a')// &
        '  run it without mpirun')
    else if (int(n) /= count_ranks()) then
      call raise(error, exit_deck, 'command line: error: MPI has '//to_text(int(n))// &
        ' processes, and mpirun tells of '//to_text(count_ranks())//new_line('a')// &
        '  start the program by the mpirun of the MPI it was built with')
    end if
  end subroutine start_parallel

  !> Ends PETSc and MPI.
  subroutine end_parallel()
    integer(c_int) :: ignored

    ignored = petsc_finalize()
  end subroutine end_parallel
end module parallel

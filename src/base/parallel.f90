!> How a run on several processes begins, agrees and ends: this program works on one.
module parallel
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use heap, only: keep_memory
  use ranks, only: count_ranks
  implicit none
  private
  public :: start_parallel, any_rank, end_parallel

contains

  !> More than one process would write the same files. One that factorises keeps what it frees.
  subroutine start_parallel(error)
    type(error_t), allocatable, intent(out) :: error !! there are more

    call keep_memory()
    if (count_ranks() > 1) call raise(error, exit_deck, 'command line: error: mpirun has '// &
      'started '//to_text(count_ranks())//' of this program, which works alone'//new_line('a')// &
      '  build ./mfec-petsc by make PETSC=1 and start that, or run without mpirun')
  end subroutine start_parallel

  !> Something is so on one of the processes.
  logical function any_rank(here)
    logical, intent(in) :: here !! it is so on this one

    any_rank = here
  end function any_rank

  !> Nobody is to be waited for.
  subroutine end_parallel(error)
    type(error_t), allocatable, intent(in) :: error !! what this process has failed of

    if (allocated(error)) return
  end subroutine end_parallel
end module parallel

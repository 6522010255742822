!> How a run on several processes begins and ends: this program works on one.
module parallel
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use ranks, only: count_ranks
  implicit none
  private
  public :: start_parallel, end_parallel

contains

  !> More than one process would write the same files.
  subroutine start_parallel(error)
    type(error_t), allocatable, intent(out) :: error !! there are more

    if (count_ranks() > 1) call raise(error, exit_deck, 'command line: error: mpirun has '// &
      'started '//to_text(count_ranks())//' of this program, which works alone'//new_line('a')// &
      '  build ./mfec-petsc by make PETSC=1 and start that, or run without mpirun')
  end subroutine start_parallel

  !> Nothing has been begun.
  subroutine end_parallel()
  end subroutine end_parallel
end module parallel

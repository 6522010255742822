!> The processes that mpirun has started for one run, as it tells them: how many there are, and
!! which one this is.
module ranks
  implicit none
  private
  public :: count_ranks, this_rank

  !> Where Open MPI and the launchers of MPICH and Intel say it.
  character(20), parameter :: sizes(2) = [character(20) :: 'OMPI_COMM_WORLD_SIZE', 'PMI_SIZE']
  character(20), parameter :: numbers(2) = [character(20) :: 'OMPI_COMM_WORLD_RANK', 'PMI_RANK']

contains

  !> Processes of this run, 1 without mpirun.
  integer function count_ranks() result(n)
    n = max(1, number_in(sizes))
  end function count_ranks

  !> Number of this process, from 0.
  integer function this_rank() result(n)
    n = max(0, number_in(numbers))
  end function this_rank

  !> The number in the first of some variables of the environment that has one, else -1.
  integer function number_in(names) result(n)
    character(*), intent(in) :: names(:) !! the variables
    character(20) :: value
    integer :: k, status

    do k = 1, size(names)
      call get_environment_variable(trim(names(k)), value, status=status)
      if (status /= 0) cycle
      read (value, *, iostat=status) n
      if (status == 0) return
    end do
    n = -1
  end function number_in
end module ranks

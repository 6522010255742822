!> What a variant reports to: its solves and cuts are counted.
module study_monitor
  use kinds, only: wp
  use monitors, only: monitor_t, iteration_t
  implicit none
  private
  public :: study_monitor_t

  !> Counts, and says nothing.
  type, extends(monitor_t) :: study_monitor_t
    integer :: solves = 0 !! linear solves
    integer :: cuts = 0 !! of increments
    real(wp) :: first_energy = 0.0_wp !! of the first iterations of the increments since it was
    !! set to zero, the largest [force length]
  contains
    procedure :: iteration => count_iteration !! one more
    procedure :: event => hear_nothing !! nothing
    procedure :: warning => hear_nothing !! nothing
    procedure :: cut => count_cut !! one more
  end type study_monitor_t

contains

  !> Counts an iteration.
  subroutine count_iteration(self, report)
    class(study_monitor_t), intent(inout) :: self !! the receiver
    type(iteration_t), intent(in) :: report !! the iteration

    self%solves = self%solves + 1
    if (report%number == 1) self%first_energy = max(self%first_energy, report%energy)
  end subroutine count_iteration

  !> Lines are those of the run before.
  subroutine hear_nothing(self, text)
    class(study_monitor_t), intent(inout) :: self !! the receiver
    character(*), intent(in) :: text !! one line

    associate (unused => self, nobody => text)
    end associate
  end subroutine hear_nothing

  !> Counts a cut.
  subroutine count_cut(self, time, old_size, new_size, reason)
    class(study_monitor_t), intent(inout) :: self !! the receiver
    real(wp), intent(in) :: time !! time of the last converged increment
    real(wp), intent(in) :: old_size !! increment that failed
    real(wp), intent(in) :: new_size !! increment tried next
    character(*), intent(in) :: reason !! why it failed

    if (new_size < old_size .and. time >= 0.0_wp .and. len(reason) >= 0) self%cuts = self%cuts + 1
  end subroutine count_cut
end module study_monitor

!> What the solution procedures tell the outside while they work: the log, the progress line.
module monitors
  use kinds, only: wp
  use model_types, only: model_t
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: monitor_t, iteration_t

  !> One Newton iteration.
  type :: iteration_t
    real(wp) :: time = 0.0_wp !! time of the increment
    integer :: number = 0 !! linear solves so far in this increment
    real(wp) :: residual = 0.0_wp !! norm of the residual on free dofs [force]
    real(wp) :: relative = 0.0_wp !! the same over the norm of all nodal forces
    real(wp) :: energy = 0.0_wp !! |R.du|
    real(wp) :: step_length = 0.0_wp !! line search
    integer :: active = 0 !! closed contact points
    integer :: stick = 0 !! of them sticking
    integer :: slip = 0 !! of them slipping
    integer :: worst_node = 0 !! node with the largest residual, 0 if no dof is free
    integer :: worst_dof = 0 !! its dof
    real(wp) :: worst = 0.0_wp !! the residual there [force]
    character(8) :: solver = '' !! back end
    real(wp) :: seconds = 0.0_wp !! wall clock of this iteration [s]
  end type iteration_t

  !> Receives reports; the run layer extends it.
  type, abstract :: monitor_t
    logical, allocatable :: told(:) !! (bodies) a motion that nothing resists has been told of
  contains
    procedure(report_iteration), deferred :: iteration !! after each iteration
    procedure(report_event), deferred :: event !! anything else worth a line in the log
    procedure :: detail => pass_detail !! the same, of an iteration: left out of a brief log
    procedure(report_event), deferred :: warning !! what the user should look at
    procedure(report_cut), deferred :: cut !! an increment has been cut
    procedure :: accepted => pass_accepted !! an increment has been accepted
  end type monitor_t

  abstract interface
    !> Takes the report of one iteration.
    subroutine report_iteration(self, report)
      import :: monitor_t, iteration_t
      implicit none
      class(monitor_t), intent(inout) :: self !! the receiver
      type(iteration_t), intent(in) :: report !! the iteration
    end subroutine report_iteration

    !> Takes one line of text.
    subroutine report_event(self, text)
      import :: monitor_t
      implicit none
      class(monitor_t), intent(inout) :: self !! the receiver
      character(*), intent(in) :: text !! one line
    end subroutine report_event

    !> Takes the report of a cut.
    subroutine report_cut(self, time, old_size, new_size, reason)
      import :: monitor_t, wp
      implicit none
      class(monitor_t), intent(inout) :: self !! the receiver
      real(wp), intent(in) :: time !! time of the last converged increment
      real(wp), intent(in) :: old_size !! increment that failed
      real(wp), intent(in) :: new_size !! increment tried next
      character(*), intent(in) :: reason !! why it failed
    end subroutine report_cut
  end interface

contains

  !> A detail is an event where nobody tells them apart.
  subroutine pass_detail(self, text)
    class(monitor_t), intent(inout) :: self !! the receiver
    character(*), intent(in) :: text !! one line

    call self%event(text)
  end subroutine pass_detail

  !> Nothing more is done with an increment where nobody wants it.
  subroutine pass_accepted(self, model, system, form, state)
    class(monitor_t), intent(inout) :: self !! the receiver
    type(model_t), intent(in) :: model !! with its new history
    type(system_t), intent(inout) :: system !! as it was solved
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(in) :: state !! the new state

    associate (unused => self, nobody => model, asks => system, in => form, for => state)
    end associate
  end subroutine pass_accepted
end module monitors

!> All that a run works on, in one piece for the commands behind BATCh.
module run_context
  use model_types, only: model_t
  use system_types, only: system_t, form_t, state_t
  use audit_types, only: audit_t
  use run_files, only: run_files_t
  use run_monitor, only: run_monitor_t
  use terminal, only: terminal_t
  use sensitivity_types, only: sensitivity_t
  use sensitivity_table, only: sensitivity_table_t
  implicit none
  private
  public :: context_t

  !> The problem, how it is solved, and where the results go.
  type :: context_t
    type(model_t) :: model !! the problem
    type(system_t) :: system !! the discrete system and its current iterate
    type(form_t) :: form !! how its equations are held
    type(state_t) :: state !! the converged state
    type(audit_t) :: audit !! what each end time is held against
    type(run_files_t) :: files !! log, tables and results
    type(run_monitor_t) :: monitor !! what the solution reports to: log and terminal
    type(terminal_t) :: terminal !! standard output
    type(sensitivity_t) :: sensitivity !! derivatives along the run, if they are asked for
    type(sensitivity_table_t) :: derivatives !! .sen, with these only
    integer :: parts = 1 !! increments of an interval between end times, --increments
    logical, allocatable :: touched(:) !! (pairs) some point was in contact at an end time
  end type context_t
end module run_context

!> The group /audit of a results file: one entry for each end time.
module results_audit
  use errors, only: error_t
  use audit_types, only: audit_t, check_names, n_checks
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_data, only: make_series, make_text_series, write_block, at_end, stored_real, &
    stored_integer
  implicit none
  private
  public :: create_audit_part, append_audit

  !> Columns of /audit/sums.
  character(16), parameter :: sum_names(7) = [character(16) :: 'force_scale', 'force_allowed', &
    'work', 'strain_energy', 'penalty_energy', 'dissipation', 'largest_energy']

contains

  !> Makes the empty data sets, and writes the names of their columns.
  subroutine create_audit_part(file, bodies, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: bodies !! number of bodies
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_group(file, '/audit', error)
    call make_text_series(file, '/audit/checks', len(check_names), 'names of the checks', error)
    call write_block(file, '/audit/checks', check_names, at_end, error)
    call make_text_series(file, '/audit/sum_names', len(sum_names), 'names of the sums', error)
    call write_block(file, '/audit/sum_names', sum_names, at_end, error)
    call make_series(file, '/audit/step', stored_integer, [integer ::], 1, '1', &
      'number of the output time', error)
    call make_series(file, '/audit/time', stored_real, [integer ::], 1, 'time', 'its time', error)
    call make_series(file, '/audit/verdict', stored_integer, [n_checks], 1, '1', &
      'verdict of each check: 0 ok, 1 warning, 2 failed', error)
    call make_series(file, '/audit/value', stored_real, [n_checks], 1, '1', &
      'what each check compares with its limit; -1 if it has not been measured', error)
    call make_series(file, '/audit/sums', stored_real, [size(sum_names)], 1, &
      'force, force length', 'force scale, and energies since the start', error)
    call make_series(file, '/audit/balance', stored_real, [6, bodies], 1, 'force, force length', &
      'sum of the forces on each body, and of their moments about its center', error)
  end subroutine create_audit_part

  !> Writes the audit of one end time.
  subroutine append_audit(file, audit, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(audit_t), intent(in) :: audit !! the end time
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_block(file, '/audit/step', [audit%step], at_end, error)
    call write_block(file, '/audit/time', [audit%time], at_end, error)
    call write_block(file, '/audit/verdict', audit%verdict, at_end, error)
    call write_block(file, '/audit/value', audit%value, at_end, error)
    call write_block(file, '/audit/sums', [audit%scale, audit%allowed, audit%sum%work, &
      audit%strain_energy, audit%penalty_energy, audit%dissipation, audit%sum%largest_energy], &
      at_end, error)
    if (size(audit%balance) == 0) return
    call write_block(file, '/audit/balance', reshape(audit%balance, [size(audit%balance)]), &
      at_end, error)
  end subroutine append_audit
end module results_audit

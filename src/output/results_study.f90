!> What a results file has of derivatives along a run (/history/sen) and of its variants (/study).
module results_study
  use kinds, only: wp
  use errors, only: error_t
  use deck_types, only: name_length
  use result_types, only: origin_t, derivative_rows_t, variant_row_t, parameter_length
  use table_columns, only: derivative_columns
  use hdf5_io, only: hdf5_file_t, make_group
  use hdf5_data, only: make_series, make_text_series, write_block, at_end, stored_real, &
    stored_integer
  implicit none
  private
  public :: create_derivatives_part, append_derivatives, create_study_part, begin_study_part, &
    append_variant

  !> Group of the table of derivatives.
  character(*), parameter :: derivatives = '/history/sen/'

contains

  !> Makes the empty columns of the table of derivatives.
  subroutine create_derivatives_part(file, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    call make_group(file, '/history/sen', error)
    call make_series(file, derivatives//'step', stored_integer, [integer ::], 1, '1', &
      'number of the output time', error)
    call make_series(file, derivatives//'time', stored_real, [integer ::], 1, 'time', 'its time', &
      error)
    call make_text_series(file, derivatives//'quantity', parameter_length, &
      'name of the set or pair', error)
    call make_text_series(file, derivatives//'parameter', parameter_length, &
      'name of the parameter', error)
    call make_series(file, derivatives//'kinks', stored_integer, [integer ::], 1, '1', &
      'contact points between two states', error)
    do i = 1, size(derivative_columns)
      call make_series(file, derivatives//trim(derivative_columns(i)%name), stored_real, &
        [integer ::], 1, trim(derivative_columns(i)%unit), 'as in the .sen table', error)
    end do
  end subroutine create_derivatives_part

  !> Writes the derivatives at one end time.
  subroutine append_derivatives(file, step, time, rows, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: step !! number of the end time
    real(wp), intent(in) :: time !! its time
    type(derivative_rows_t), intent(in) :: rows !! the derivatives
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i, n

    n = size(rows%kinks)
    call write_block(file, derivatives//'step', spread(step, 1, n), at_end, error)
    call write_block(file, derivatives//'time', spread(time, 1, n), at_end, error)
    call write_block(file, derivatives//'quantity', rows%quantity, at_end, error)
    call write_block(file, derivatives//'parameter', rows%parameter, at_end, error)
    call write_block(file, derivatives//'kinks', rows%kinks, at_end, error)
    do i = 1, size(derivative_columns)
      call write_block(file, derivatives//trim(derivative_columns(i)%name), rows%values(i, :), &
        at_end, error)
    end do
  end subroutine append_derivatives

  !> Makes the empty data sets of a study.
  subroutine create_study_part(file, origin, sets, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(origin_t), intent(in) :: origin !! how many end times and parameters
    integer, intent(in) :: sets !! sets of the reactions
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call make_group(file, '/study', error)
    call make_text_series(file, '/study/parameters', name_length, 'what the study varies', error)
    call make_text_series(file, '/study/sets', name_length, 'sets of the reactions', error)
    call make_series(file, '/study/variant', stored_integer, [integer ::], 1, '1', &
      'number of the variant', error)
    call make_series(file, '/study/values', stored_real, [origin%varied], 1, 'parameter', &
      'its values, one a parameter', error)
    call make_series(file, '/study/exit', stored_integer, [integer ::], 1, '1', 'its exit code', &
      error)
    call make_series(file, '/study/last', stored_integer, [integer ::], 1, '1', &
      'its last output time', error)
    call make_series(file, '/study/rea', stored_real, [3, max(1, sets), max(1, origin%end_times)], &
      1, 'force', &
      'reactions of each variant, output time and set; zero up to FROM and behind its last '// &
      'output time', error)
  end subroutine create_study_part

  !> Writes what all variants of a study have in common.
  subroutine begin_study_part(file, parameters, sets, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(name_length), intent(in) :: parameters(:) !! what is varied
    character(name_length), intent(in) :: sets(:) !! sets of the reactions
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_block(file, '/study/parameters', parameters, at_end, error)
    call write_block(file, '/study/sets', sets, at_end, error)
  end subroutine begin_study_part

  !> Writes what one variant has come to.
  subroutine append_variant(file, row, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(variant_row_t), intent(in) :: row !! the variant
    type(error_t), allocatable, intent(inout) :: error !! file trouble

    call write_block(file, '/study/variant', [row%number], at_end, error)
    call write_block(file, '/study/values', row%values, at_end, error)
    call write_block(file, '/study/exit', [row%code], at_end, error)
    call write_block(file, '/study/last', [row%step], at_end, error)
    call write_block(file, '/study/rea', reshape(row%reactions, [size(row%reactions)]), at_end, &
      error)
  end subroutine append_variant
end module results_study

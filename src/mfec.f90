!> The program: command line, deck, run, exit code.
program mfec
  use, intrinsic :: iso_fortran_env, only: output_unit
  use errors, only: error_t, raise, exit_done, exit_deck, exit_resources
  use signals, only: catch_signals, last_words
  use command_line, only: options_t, read_command_line
  use session, only: run_session
  use ranks, only: this_rank
  use parallel, only: start_parallel, end_parallel
  use keyword_help, only: help_text, has_help
  use libraries, only: version_text
  use json_report, only: tell_end
  use process, only: end_process, catch_lack_of_memory, open_standard_files, wait_passively, &
    start_again
  use blas_info, only: rest_blas_threads
  use blas_kernels, only: choose_kernels
  implicit none
  type(options_t) :: options
  type(error_t), allocatable :: error
  integer :: status
  logical :: again

  call open_standard_files()
  call catch_lack_of_memory()
  call catch_signals()
  call read_command_line(options, error)
  if (.not. allocated(error)) then
    if (options%version) then
      write (output_unit, '(a)', iostat=status) version_text()
      if (status /= 0) call end_process(exit_resources)
    else if (options%help) then
      if (has_help(options%topic)) then
        write (output_unit, '(a)', iostat=status) help_text(options%topic)
        if (status /= 0) call end_process(exit_resources)
      else
        call raise(error, exit_deck, 'command line: error: '//help_text(options%topic))
      end if
    else
      again = .false.
      if (options%threads > 1) call wait_passively(again)
      call choose_kernels(again)
      if (again) call start_again()
      call rest_blas_threads()
      call start_parallel(error)
      if (.not. allocated(error)) then
        call run_session(options, error)
        if (this_rank() == 0 .and. allocated(error)) call last_words(error%message)
        if (this_rank() == 0 .and. options%json) call tell_end(error)
        call end_parallel(error)
        if (allocated(error)) call end_process(error%code, error%at_once)
      end if
    end if
  end if
  if (allocated(error)) then
    if (this_rank() == 0) call last_words(error%message)
    if (this_rank() == 0 .and. options%json) call tell_end(error)
    call end_process(error%code, error%at_once)
  end if
  call end_process(exit_done)
end program mfec

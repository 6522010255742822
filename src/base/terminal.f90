!> What the user sees while the program runs: plain lines, and on a terminal one live line.
!!
!! The live line is rewritten in place and never longer than the terminal is wide; where standard
!! output is no terminal only the plain lines appear. When nobody reads any more, it is quiet.
!! For programs (--json) a line is a record; --verbose lets every line stay, those of the log too.
module terminal
  use, intrinsic :: iso_c_binding, only: c_int
  use, intrinsic :: iso_fortran_env, only: output_unit, error_unit
  use json_lines, only: item, print_record
  implicit none
  private
  public :: terminal_t, open_terminal, print_line, print_warning, print_detail, show_progress, &
    close_terminal

  integer, parameter :: default_width = 80
  character(*), parameter :: carriage_return = achar(13)

  !> Where the lines go and what stands in the live one.
  type :: terminal_t
    integer :: unit = output_unit !! Fortran unit
    logical :: quiet = .false. !! print nothing
    logical :: warns = .false. !! where it is quiet, warnings go to standard error
    logical :: live = .false. !! the unit is a terminal
    logical :: json = .false. !! records in place of lines
    logical :: verbose = .false. !! lines of the log appear here as well, and progress stays
    integer :: width = default_width !! columns of the terminal
    integer :: shown = 0 !! length of the live line, 0 if there is none
  end type terminal_t

  interface
    !> C's isatty: 1 when the file descriptor is a terminal.
    function c_isatty(descriptor) bind(c, name='isatty') result(yes)
      import :: c_int
      implicit none
      integer(c_int), value :: descriptor !! file descriptor
      integer(c_int) :: yes
    end function c_isatty
  end interface

contains

  !> Standard output, live if it is a terminal.
  type(terminal_t) function open_terminal(quiet, warns) result(term)
    logical, intent(in) :: quiet !! print nothing
    logical, intent(in) :: warns !! but warnings, to standard error
    character(16) :: columns
    integer :: status, width

    term%quiet = quiet
    term%warns = quiet .and. warns
    term%live = c_isatty(1_c_int) == 1_c_int .and. .not. quiet
    call get_environment_variable('COLUMNS', columns, status=status)
    if (status /= 0) return
    read (columns, *, iostat=status) width
    if (status == 0 .and. width > 10) term%width = width
  end function open_terminal

  !> A line that stays.
  subroutine print_line(term, text)
    type(terminal_t), intent(inout) :: term !! the terminal
    character(*), intent(in) :: text !! the line
    integer :: status

    if (term%json) call print_record('line', item('text', text))
    if (term%quiet .or. term%json) return
    call close_terminal(term)
    write (term%unit, '(a)', iostat=status) text
    if (status == 0) flush (term%unit, iostat=status)
    if (status /= 0) term%quiet = .true.
  end subroutine print_line

  !> A warning: a line that stays, on standard error where nothing else is printed.
  subroutine print_warning(term, text)
    type(terminal_t), intent(inout) :: term !! the terminal
    character(*), intent(in) :: text !! the line
    integer :: status

    if (term%json) then
      call print_record('warning', item('text', text))
      return
    else if (.not. term%warns) then
      call print_line(term, text)
      return
    end if
    write (error_unit, '(a)', iostat=status) text
    term%warns = status == 0
  end subroutine print_warning

  !> A line of the log, for those who want all or read by a program.
  subroutine print_detail(term, text)
    type(terminal_t), intent(inout) :: term !! the terminal
    character(*), intent(in) :: text !! the line

    if (term%json) then
      call print_record('log', item('text', text))
    else if (term%verbose) then
      call print_line(term, text)
    end if
  end subroutine print_detail

  !> Rewrites the live line; does nothing in batch.
  subroutine show_progress(term, text)
    type(terminal_t), intent(inout) :: term !! the terminal
    character(*), intent(in) :: text !! the new line
    integer :: length, status

    if (term%verbose) call print_line(term, text)
    if (.not. term%live .or. term%verbose) return
    length = min(len_trim(text), term%width - 1)
    write (term%unit, '(4a)', advance='no', iostat=status) carriage_return, text(:length), &
      repeat(' ', max(0, term%shown - length)), carriage_return
    if (status == 0) flush (term%unit, iostat=status)
    term%live = status == 0
    term%shown = length
  end subroutine show_progress

  !> Wipes the live line, so that what follows starts on a clean one.
  subroutine close_terminal(term)
    type(terminal_t), intent(inout) :: term !! the terminal
    integer :: status

    if (term%shown == 0) return
    write (term%unit, '(3a)', advance='no', iostat=status) carriage_return, &
      repeat(' ', term%shown), carriage_return
    if (status == 0) flush (term%unit, iostat=status)
    term%live = status == 0
    term%shown = 0
  end subroutine close_terminal
end module terminal

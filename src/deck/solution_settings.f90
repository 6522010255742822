!> What solution commands set for the iterations that follow them, each declared once. The keyword
!! table, what interprets the commands and `settings_t` take it from here; whoever has use for a
!! value asks `settings_t%asked`.
module solution_settings
  use kinds, only: wp
  use text, only: lower
  implicit none
  private
  public :: tol_energy, tol_residual, n_settings, settings_of_deck, setting_commands, &
    setting_signature, take_setting

  !> A command that does nothing else.
  type :: setting_command_t
    character(8) :: keyword = '' !! the letters that count as capitals
    character(40) :: summary = '' !! what it sets
    character(80) :: help(2) = '' !! the lines of --help behind that
  end type setting_command_t

  type(setting_command_t), parameter :: setting_commands(*) = [ &
    setting_command_t('TOL', 'tolerance of the iterations', [character(80) :: &
    'TOL,,v: relative energy (default 1e-16). TOL,RESI,v: norm of the residual', &
    'against the norm of all nodal forces, reactions included.'])]

  !> What one of them sets: `command,option,value`.
  type :: setting_t
    character(8) :: command = '' !! its keyword
    character(8) :: option = '' !! its word; none: what the command sets by itself
    character(1) :: check = '' !! kind of the value, as signatures have it
    real(wp) :: given = 0.0_wp !! value without the command
  end type setting_t

  !> Tolerances of |R.du| over that of the first iteration, and of the residual over the forces
  !! (0: the energy decides).
  integer, parameter :: tol_energy = 1, tol_residual = 2
  type(setting_t), parameter :: settings_of_deck(*) = [ &
    setting_t('TOL', '', 'q', 1.0e-16_wp), &
    setting_t('TOL', 'RESIdual', 'q', 0.0_wp)]
  integer, parameter :: n_settings = size(settings_of_deck)

contains

  !> What may follow a command.
  pure function setting_signature(command) result(t)
    character(*), intent(in) :: command !! as the table has it
    character(:), allocatable :: t
    integer :: k

    t = ''
    do k = 1, n_settings
      if (settings_of_deck(k)%command /= command) cycle
      if (len(t) > 0) t = t//' | '
      if (settings_of_deck(k)%option == '') t = t//'-'
      t = t//trim(settings_of_deck(k)%option)//' '//settings_of_deck(k)%check//':v'
    end do
  end function setting_signature

  !> Sets the value that a command is there for.
  pure subroutine take_setting(command, option, value, values, taken)
    character(4), intent(in) :: command !! lower case
    character(4), intent(in) :: option !! the same of its word, blank for none
    real(wp), intent(in) :: value !! what it says
    real(wp), intent(inout) :: values(n_settings) !! of all settings
    logical, intent(out) :: taken !! it is such a command
    integer :: k

    taken = .false.
    do k = 1, n_settings
      if (command /= lower(settings_of_deck(k)%command(:4)) .or. &
        option /= lower(settings_of_deck(k)%option(:4))) cycle
      values(k) = value
      taken = .true.
    end do
  end subroutine take_setting
end module solution_settings

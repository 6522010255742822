!> What solution commands set for the iterations that follow them, each declared once. The keyword
!! table, what interprets the commands and `settings_t` take it from here; whoever has use for a
!! value asks `settings_t%asked`.
module solution_settings
  use kinds, only: wp
  use text, only: lower
  implicit none
  private
  public :: tol_energy, tol_residual, n_settings, settings_of_deck, setting_signature, take_setting

  !> One of them: `command,option,value`. Those of one command stand together.
  type :: setting_t
    character(8) :: command = '' !! the letters that count as capitals
    character(8) :: option = '' !! its word; none: what the command sets by itself
    character(1) :: check = '' !! kind of the value, as signatures have it
    real(wp) :: given = 0.0_wp !! value without the command
    character(40) :: summary = '' !! what the command sets, with the first of its settings
    character(80) :: help = '' !! its line of --help
  end type setting_t

  !> Tolerances of |R.du| over that of the first iteration, and of the residual over the forces
  !! (0: the energy decides).
  integer, parameter :: tol_energy = 1, tol_residual = 2
  type(setting_t), parameter :: settings_of_deck(*) = [ &
    setting_t('TOL', '', 'q', 1.0e-16_wp, 'tolerance of the iterations', &
    'TOL,,v: relative energy (default 1e-16). TOL,RESI,v: norm of the residual'), &
    setting_t('TOL', 'RESIdual', 'q', 0.0_wp, '', &
    'against the norm of all nodal forces, reactions included.')]
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

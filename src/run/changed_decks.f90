!> What the command line changes in a deck (another mesh, stiffer penalties), and what the log says
!! of it.
module changed_decks
  use kinds, only: wp
  use text, only: to_text
  use errors, only: error_t, raise, exit_deck
  use deck_types, only: deck_t
  use diagnostics, only: diagnostics_t
  use other_mesh, only: take_mesh
  use command_line, only: options_t
  implicit none
  private
  public :: change_deck, refuse_changes, settings_text

contains

  !> Obeys --mesh and --penalty-factor; --increments is the business of the run.
  subroutine change_deck(options, deck, diagnostics)
    type(options_t), intent(in) :: options !! the command line
    type(deck_t), intent(inout) :: deck !! the deck as read
    type(diagnostics_t), intent(inout) :: diagnostics !! errors

    if (len(options%mesh) > 0) call take_mesh(options%mesh, deck, diagnostics)
    deck%penalty_factor = options%penalty_factor
  end subroutine change_deck

  !> Derivatives and variants read the deck anew, and would not know of what the command line
  !! changes.
  subroutine refuse_changes(options, error)
    type(options_t), intent(in) :: options !! the command line
    type(error_t), allocatable, intent(out) :: error !! it changes what they read

    if (len(changes_text(options)) == 0) return
    call raise(error, exit_deck, 'command line: error: --mesh, --increments or '// &
      '--penalty-factor with derivatives or a study'//new_line('a')// &
      '  write MESH, STEP and PENAlty in the deck')
  end subroutine refuse_changes

  !> The options that change a deck, as written; empty for none.
  function changes_text(options) result(t)
    type(options_t), intent(in) :: options !! the command line
    character(:), allocatable :: t

    t = ''
    if (len(options%mesh) > 0) t = t//' --mesh '//options%mesh
    if (options%increments > 1) t = t//' --increments '//to_text(options%increments)
    if (abs(options%penalty_factor - 1.0_wp) > 0.0_wp) t = t//' --penalty-factor '// &
      to_text(options%penalty_factor)
  end function changes_text

  !> Deck and --set, for the log and the results.
  function settings_text(options) result(t)
    type(options_t), intent(in) :: options !! the command line
    character(:), allocatable :: t
    integer :: k

    t = options%deck
    if (len(options%restart) > 0) t = t//' --restart '//options%restart
    if (options%step > 0) t = t//' --step '//to_text(options%step)
    t = t//changes_text(options)
    do k = 1, size(options%overrides)
      t = t//' --set '//options%overrides(k)%name//'='//options%overrides(k)%value
    end do
  end function settings_text
end module changed_decks

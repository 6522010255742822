!> What a deck lacks because of errors: nobody knows what would have stood there, so what is missing
!! because of one error must not be reported as another.
module deck_losses
  use deck_types, only: deck_t
  implicit none
  private
  public :: is_whole, is_lost, is_lost_name, lost_names

contains

  !> True if no data of these mesh commands were left out because of an error.
  pure logical function is_whole(deck, commands) result(whole)
    type(deck_t), intent(in) :: deck !! the deck
    character(4), intent(in) :: commands(:) !! first four letters of each
    integer :: i

    whole = .true.
    do i = 1, size(deck%mesh)
      if (any(deck%mesh(i)%command == commands)) whole = whole .and. deck%mesh(i)%complete
    end do
    do i = 1, size(commands)
      if (is_lost(deck, commands(i))) whole = .false.
    end do
  end function is_whole

  !> True if a data set of this command may have been left out with its head: nobody knows what it
  !! was called or numbered.
  pure logical function is_lost(deck, command) result(lost)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: command !! its first four letters

    lost = .false.
    if (allocated(deck%losses)) lost = any(deck%losses%command == '' .or. &
      deck%losses%command == '?' .or. deck%losses%command == command)
  end function is_lost

  !> True if data that were left out may have defined this name.
  pure logical function is_lost_name(deck, name) result(lost)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: name !! of a set, region or surface
    integer :: i

    lost = .false.
    if (.not. allocated(deck%losses)) return
    do i = 1, size(deck%losses)
      lost = lost .or. (len(name) > 0 .and. deck%losses(i)%name == name)
    end do
  end function is_lost_name

  !> True if data that were left out may have defined any name.
  pure logical function lost_names(deck) result(lost)
    type(deck_t), intent(in) :: deck !! the deck

    lost = .false.
    if (allocated(deck%losses)) lost = any(deck%losses%command == '?')
  end function lost_names
end module deck_losses

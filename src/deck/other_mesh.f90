!> --mesh FILE: a mesh file in place of all that a deck says of nodes and elements.
module other_mesh
  use deck_types, only: deck_t, data_set_t, record_t, item_word, item_quoted, item_number
  use records, only: is_word
  use diagnostics, only: diagnostics_t, report_error
  implicit none
  private
  public :: take_mesh

  !> Commands that make nodes and elements.
  character(4), parameter :: replaced(6) = ['bloc', 'coor', 'elem', 'mesh', 'tran', 'tie ']

contains

  !> Puts one MESH in the place of the deck's mesh commands. Sets, surfaces and all that names them
  !! stay, and are evaluated on the new mesh; a path is relative to the working directory.
  subroutine take_mesh(path, deck, diagnostics)
    character(*), intent(in) :: path !! the file
    type(deck_t), intent(inout) :: deck !! the deck as read
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(data_set_t), allocatable :: sets(:)
    logical, allocatable :: stays(:)
    integer :: i, n

    allocate (stays(size(deck%mesh)))
    do i = 1, size(deck%mesh)
      stays(i) = .not. any(deck%mesh(i)%command == replaced)
    end do
    allocate (sets(1 + count(stays)))
    call name_file(path, sets(1))
    n = 1
    do i = 1, size(stays)
      if (.not. stays(i)) cycle
      n = n + 1
      sets(n) = deck%mesh(i)
      call refuse_numbers(sets(n), diagnostics)
    end do
    call move_alloc(sets, deck%mesh)
    ! The counts of the control record are those of the mesh that is gone.
    deck%control([1, 2, 6]) = 0
  end subroutine take_mesh

  !> What means nodes by their numbers would mean others: each first such record is an error.
  subroutine refuse_numbers(set, diagnostics)
    type(data_set_t), intent(in) :: set !! a command that stays
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer :: k

    do k = 1, set%count
      if (.not. is_numbered(set%command, set%records(k))) cycle
      call report_error(diagnostics, set%records(k)%at, &
        'node numbers, which mean nothing on the mesh of --mesh', &
        'name the nodes by a SET with PLANe, BOX or INSIde, or by their '// &
        'coordinates: CBOUndary, CDISplacement, CFORce')
      return
    end do
  end subroutine refuse_numbers

  !> A record that means nodes by their numbers.
  pure logical function is_numbered(command, record) result(numbered)
    character(4), intent(in) :: command !! whose it is
    type(record_t), intent(in) :: record !! a data record

    numbered = .false.
    select case (command)
    case ('boun', 'disp', 'forc', 'fpro')
      numbered = record%items(1)%kind == item_number
    case ('set ', 'surf')
      numbered = is_word(record%items(1), 'nodes') .or. is_word(record%items(1), 'facets')
    case ('outp')
      numbered = is_word(record%items(1), 'history')
    end select
  end function is_numbered

  !> `MESH file`, from the command line.
  subroutine name_file(path, set)
    character(*), intent(in) :: path !! the file
    type(data_set_t), intent(out) :: set !! the command

    set%command = 'mesh'
    allocate (set%records(0), set%head%items(2))
    set%head%items(1)%kind = item_word
    set%head%items(1)%text = 'MESH'
    set%head%items(2)%kind = item_quoted
    set%head%items(2)%text = path
  end subroutine name_file
end module other_mesh

!> *INCLUDE, and INPUT= on cards of the mesh, in Abaqus and CalculiX input files: the files are put
!! together as one text that knows where each of its pieces comes from.
module abaqus_includes
  use text, only: to_text
  use source, only: source_t, add_file, add_text, beside
  use file_cursor, only: cursor_t, start_cursor, fail
  use abaqus_cards, only: card_t, next_card, card_parameter, has_parameter
  use abaqus_assembly, only: go_to_star
  implicit none
  private
  public :: join_includes

  !> Files may include each other so deep.
  integer, parameter :: deepest_include = 9
  !> Cards whose data may stand in a file of their own.
  character(7), parameter :: takers(5) = [character(7) :: 'node', 'element', 'nset', 'elset', &
    'surface']

  !> Pieces of files, in the order in which they are read.
  type :: pieces_t
    integer :: count = 0 !! pieces
    integer, allocatable :: file(:) !! number of the file of each
    integer, allocatable :: first(:) !! its first character there
    integer, allocatable :: last(:) !! its last character there
  end type pieces_t

contains

  !> Puts a file and those it includes together; without any it stays as it is.
  subroutine join_includes(source, file, cursor)
    type(source_t), intent(inout) :: source !! all files; gets the included ones and the whole
    integer, intent(inout) :: file !! number of the file, then of the whole
    type(cursor_t), intent(out) :: cursor !! failed if something is wrong, in that `file`
    type(pieces_t) :: pieces
    character(:), allocatable :: text
    integer, allocatable :: start(:)
    integer :: i, n

    allocate (pieces%file(0), pieces%first(0), pieces%last(0))
    call collect(source, file, 1, pieces, cursor)
    if (cursor%failed .or. pieces%count == 1) return
    allocate (start(pieces%count))
    n = 0
    do i = 1, pieces%count
      start(i) = n + 1
      n = n + pieces%last(i) - pieces%first(i) + 2
    end do
    allocate (character(n) :: text)
    do i = 1, pieces%count
      associate (from => source%files(pieces%file(i))%text, length => pieces%last(i) &
                 - pieces%first(i) + 1)
        text(start(i):start(i) + length - 1) = from(pieces%first(i):pieces%last(i))
        text(start(i) + length:start(i) + length) = achar(10)
      end associate
    end do
    call add_text(source, source%files(file)%name, text)
    file = source%count
    source%files(file)%piece_start = start
    source%files(file)%piece_file = pieces%file
    source%files(file)%piece_at = pieces%first
  end subroutine join_includes

  !> Adds the pieces of one file. After a fault `file` is the one that has it.
  recursive subroutine collect(source, file, depth, pieces, cursor)
    type(source_t), intent(inout) :: source !! gets the included files
    integer, intent(inout) :: file !! number of the file
    integer, intent(in) :: depth !! how deep it is included
    type(pieces_t), intent(inout) :: pieces !! gets the pieces
    type(cursor_t), intent(out) :: cursor !! takes the fault
    type(card_t) :: card
    integer :: first, inner
    logical :: found

    call start_cursor(source%files(file)%text, cursor)
    first = cursor%at
    do
      call go_to_star(source%files(file)%text, cursor)
      call next_card(source%files(file)%text, cursor, card, found)
      if (.not. found) exit
      if (.not. has_parameter(card, 'input')) cycle
      if (card%name == 'include') then
        call add_piece(pieces, file, first, card%at - 1)
      else if (any(takers == card%name)) then
        call add_piece(pieces, file, first, cursor%at - 1)
      else
        cycle
      end if
      first = cursor%at
      call open_file(source, file, card, depth, inner, cursor)
      if (cursor%failed) return
      call collect(source, inner, depth + 1, pieces, cursor)
      if (cursor%failed) then
        file = inner
        return
      end if
      call start_cursor(source%files(file)%text, cursor)
      cursor%at = first
    end do
    call add_piece(pieces, file, first, cursor%last)
  end subroutine collect

  !> Opens an included file, relative to the one that names it.
  subroutine open_file(source, file, card, depth, inner, cursor)
    type(source_t), intent(inout) :: source !! gets the file
    integer, intent(in) :: file !! number of the file that names it
    type(card_t), intent(in) :: card !! the card that names it
    integer, intent(in) :: depth !! how deep that file is included
    integer, intent(out) :: inner !! number of the included file
    type(cursor_t), intent(inout) :: cursor !! takes the fault
    character(:), allocatable :: path, problem

    inner = 0
    path = card_parameter(card, 'input')
    if (path == '') call fail(cursor, card%at, 'INPUT= without a file', 'write INPUT=file')
    if (depth >= deepest_include) call fail(cursor, card%at, &
      'files include each other more than '// &
      to_text(deepest_include)//' deep', 'does one include itself?')
    if (cursor%failed) return
    path = beside(source, file, path)
    call add_file(source, path, problem)
    if (allocated(problem)) call fail(cursor, card%at, 'cannot read '''//path//''': '//problem, &
      'the path is relative to the file that names it')
    inner = source%count
  end subroutine open_file

  !> Adds a piece.
  subroutine add_piece(pieces, file, first, last)
    type(pieces_t), intent(inout) :: pieces !! the pieces
    integer, intent(in) :: file !! number of its file
    integer, intent(in) :: first !! its first character
    integer, intent(in) :: last !! its last character

    pieces%count = pieces%count + 1
    pieces%file = [pieces%file, file]
    pieces%first = [pieces%first, first]
    pieces%last = [pieces%last, last]
  end subroutine add_piece
end module abaqus_includes

!> Files that are taken for a deck, and are none: meshes, results, decks of other programs.
module foreign_decks
  use text, only: lower
  use numbers, only: is_letter
  use source, only: source_t
  implicit none
  private
  public :: foreign_deck, has_batch

contains

  !> What a file is, and what to do with it, if it is a mesh, a deck or a result of another program;
  !! empty if it may be a deck.
  pure function foreign_deck(text, path) result(t)
    character(*), intent(in) :: text !! the file
    character(*), intent(in) :: path !! its name
    character(:), allocatable :: t
    character(*), parameter :: own = '  a deck of mfec begins with MFEC * * title'
    integer, parameter :: deck_head = 4096
    integer :: first

    t = ''
    first = verify(text(:min(len(text), deck_head)), ' '//achar(9)//achar(10)//achar(13))
    if (first == 0) return
    if (index(text(first:min(len(text), first + 3)), char(137)//'HDF') == 1) then
      t = 'it is an HDF5 file, results perhaps'//new_line('a')// &
        '  to go on from them: mfec deck.inp --restart '//path
    else if (index(text(first:min(len(text), deck_head)), achar(0)) > 0) then
      t = 'it is binary'//new_line('a')//own//'; MESH file in it reads a mesh'
    else if (index(text(first:min(len(text), first + 10)), '$MeshFormat') == 1) then
      t = 'it is a mesh of Gmsh'//new_line('a')//own//'; MESH '//path//' in it reads the mesh'
    else if (begins_card(text(first:min(len(text), first + 1)))) then
      t = 'it is written for Abaqus or CalculiX'//new_line('a')//own//'; MESH '//path// &
        ' in it reads nodes, elements and sets, and materials, supports, contact and steps are '// &
        'written anew (doc/tutorials.md, "Coming from CalculiX")'
    end if
  end function foreign_deck

  !> A card or a comment of Abaqus.
  pure logical function begins_card(t)
    character(*), intent(in) :: t !! the first two characters of a file

    begins_card = .false.
    if (len(t) < 2) return
    begins_card = t(1:1) == '*' .and. (t(2:2) == '*' .or. is_letter(t(2:2)))
  end function begins_card

  !> A line of some file begins with BATCh or MACRo.
  pure logical function has_batch(source) result(yes)
    type(source_t), intent(in) :: source !! the files read so far
    character(4) :: word
    integer :: file, i, first

    yes = .false.
    do file = 1, source%count
      associate (f => source%files(file))
        do i = 1, f%lines
          first = f%first(i) - 1 + verify(f%text(f%first(i):f%last(i)), ' '//achar(9))
          if (first < f%first(i)) cycle
          word = lower(f%text(first:min(first + 3, f%last(i))))
          yes = yes .or. word == 'batc' .or. word == 'macr'
        end do
      end associate
    end do
  end function has_batch
end module foreign_decks

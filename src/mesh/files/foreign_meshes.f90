!> Mesh files of other programs, known by how they begin whatever they are called, and what makes
!! files of them that can be read.
module foreign_meshes
  use text, only: lower
  implicit none
  private
  public :: describe_foreign

  !> So much of a file is looked at.
  integer, parameter :: mesh_head = 20000

contains

  !> What a file is, if it is one of another program, and how to turn it into one of Gmsh; `what` is
  !! empty if it is none of these.
  pure subroutine describe_foreign(path, text, what, remedy)
    character(*), intent(in) :: path !! path of the file
    character(*), intent(in) :: text !! what it holds
    character(:), allocatable, intent(out) :: what !! what it is
    character(:), allocatable, intent(out) :: remedy !! what to do
    character(:), allocatable :: t

    t = lower(text(:min(len(text), mesh_head)))
    what = ''
    remedy = ''
    if (len(t) == 0) return
    if (index(t, '$meshformat') > 0) return
    t = t(max(1, verify(t, ' '//achar(9)//achar(10)//achar(13))):)
    call describe_mesh(t, what)
    if (len(what) > 0) then
      remedy = 'let Gmsh write it anew: gmsh '//path//' -save -format msh41 -o '//renamed(path)
      return
    end if
    if (index(t, 'iso-10303-21') == 1 .or. index(t, 'cascade topology') > 0) then
      what = 'is geometry without a mesh'
    else if (begins_line(t, 'setfactory(') .or. begins_line(t, 'point(')) then
      what = 'is a script of Gmsh, no mesh'
    end if
    if (len(what) > 0) then
      remedy = 'let Gmsh mesh it: gmsh '//path//' -3 -format msh41 -o '//renamed(path)
      return
    end if
    call describe_other(t, what)
    if (len(what) > 0) remedy = 'turn it into a file of Gmsh: meshio convert '//path//' '// &
      renamed(path)//' (pip install meshio), or write it as one of Abaqus'
  end subroutine describe_foreign

  !> The meshes that Gmsh reads.
  pure subroutine describe_mesh(t, what)
    character(*), intent(in) :: t !! how the file begins, in lower case
    character(:), allocatable, intent(inout) :: what !! what it is

    if (index(t, char(137)//'hdf') == 1 .and. index(t, 'ens_maa') > 0) then
      what = 'is a MED file (Salome, Code_Aster)'
    else if (index(t, '# vtk datafile') == 1) then
      what = 'is a VTK file'
    else if (index(t, 'meshversionformatted') > 0) then
      what = 'is a mesh of Medit'
    else if (is_universal(t)) then
      what = 'is a universal file (UNV)'
    else if (begins_line(t, 'grid') .or. begins_line(t, 'begin bulk')) then
      what = 'is a deck of Nastran'
    end if
  end subroutine describe_mesh

  !> Meshes that others read.
  pure subroutine describe_other(t, what)
    character(*), intent(in) :: t !! how the file begins, in lower case
    character(:), allocatable, intent(inout) :: what !! what it is

    if (index(t, char(137)//'hdf') == 1) then
      what = 'is an HDF5 file, no mesh that can be read here'
    else if (index(t, '<vtkfile') > 0 .or. index(t, '<xdmf') > 0) then
      what = 'is a mesh of XML (VTK, XDMF)'
    else if (index(t, 'cdf') == 1) then
      what = 'is a netCDF file (Exodus)'
    else if (begins_line(t, 'nblock') .or. begins_line(t, '/prep7')) then
      what = 'is a deck of ANSYS'
    else if (index(t, 'mesh3d') == 1) then
      what = 'is a mesh of Netgen'
    else if (index(t, '*keyword') == 1) then
      what = 'is a deck of LS-DYNA'
    end if
  end subroutine describe_other

  !> Universal files are made of blocks between lines of -1, with the number of what they hold on
  !! the second line.
  pure logical function is_universal(t) result(yes)
    character(*), intent(in) :: t !! how the file begins, without blanks before
    integer :: last, first

    yes = .false.
    if (index(t, '-1') /= 1) return
    last = scan(t, achar(10)//achar(13))
    if (last < 3) return
    if (verify(t(3:last), ' '//achar(10)//achar(13)) > 0) return
    first = last + verify(t(last + 1:), ' '//achar(10)//achar(13))
    last = first + scan(t(first:), achar(10)//achar(13)) - 2
    if (last < first) return
    yes = verify(trim(t(first:last)), '0123456789') == 0
  end function is_universal

  !> A line begins with a word.
  pure logical function begins_line(t, word) result(yes)
    character(*), intent(in) :: t !! how the file begins
    character(*), intent(in) :: word !! the word

    yes = index(t, word) == 1 .or. index(t, achar(10)//word) > 0
  end function begins_line

  !> The path with Gmsh's ending.
  pure function renamed(path) result(t)
    character(*), intent(in) :: path !! path of a file
    character(:), allocatable :: t
    integer :: dot

    dot = index(path, '.', back=.true.)
    if (dot <= index(path, '/', back=.true.) + 1) dot = len(path) + 1
    t = path(:dot - 1)//'.msh'
    if (t == path) t = path(:dot - 1)//'_gmsh.msh'
  end function renamed
end module foreign_meshes

!> Reads a mesh file in whatever format it has.
module mesh_formats
  use deck_types, only: location_t
  use foreign_meshes, only: describe_foreign
  use source, only: add_file, beside
  use diagnostics, only: diagnostics_t, report_error
  use file_cursor, only: cursor_t
  use mesh_file_types, only: file_mesh_t
  use stl_reader, only: is_stl, read_stl
  use gmsh_reader, only: read_gmsh, is_gmsh
  use abaqus_includes, only: join_includes
  use abaqus_reader, only: read_abaqus
  use file_mesh_checks, only: file_place_t, place_in_file
  implicit none
  private
  public :: load_file

contains

  !> Opens a file, relative to the one that names it, and reads it.
  subroutine load_file(path, at, file, place, diagnostics, good)
    character(*), intent(in) :: path !! as the deck has it
    type(location_t), intent(in) :: at !! where the deck has it
    type(file_mesh_t), intent(out) :: file !! what the file holds
    type(file_place_t), intent(out) :: place !! number of the file
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(out) :: good !! it could be read
    type(cursor_t) :: cursor
    character(:), allocatable :: problem, remedy, full
    logical :: is_abaqus

    full = beside(diagnostics%source, at%file, path)
    call add_file(diagnostics%source, full, problem)
    is_abaqus = .false.
    good = .not. allocated(problem)
    if (.not. good) then
      call report_error(diagnostics, at, 'cannot read the mesh '''//full//''': '//problem, &
        'the path is relative to the file that names it')
      return
    end if
    place%file = diagnostics%source%count
    place%at = at
    associate (text => diagnostics%source%files(place%file)%text)
      call describe_foreign(full, text, problem, remedy)
      if (len(problem) > 0) then
        call report_error(diagnostics, at, 'the file '//full//' '//problem, remedy)
        good = .false.
        return
      end if
      if (is_stl(full, text)) then
        call read_stl(text, file, cursor)
      else if (is_gmsh(text)) then
        call read_gmsh(text, file, cursor)
      else
        is_abaqus = .true.
      end if
    end associate
    if (is_abaqus) then
      call join_includes(diagnostics%source, place%file, cursor)
      if (.not. cursor%failed) call read_abaqus(diagnostics%source%files(place%file)%text, file, &
        cursor)
    end if
    good = .not. cursor%failed
    if (.not. good) call report_error(diagnostics, place_in_file(diagnostics%source, place%file, &
      cursor%fault), cursor%what, cursor%remedy)
  end subroutine load_file
end module mesh_formats

!> The mesh of a deck: nodes, elements, and the named parts of them.
module mesh_reader
  use errors, only: error_t
  use deck_types, only: deck_t
  use diagnostics, only: diagnostics_t, report_error, error_count
  use mesh_types, only: mesh_t
  use mesh_building, only: element_origin_t, start_mesh, finish_mesh
  use curved_checks, only: check_curved
  use mesh_checks, only: check_elements, check_numbers
  use coordinates_reader, only: read_coordinates
  use elements_reader, only: read_elements
  use block_reader, only: read_block
  use mesh_file_reader, only: read_mesh_file
  use file_surfaces, only: surface_draft_t
  use named_parts, only: gather_names, evaluate_parts
  implicit none
  private
  public :: read_mesh

contains

  !> Interprets COORdinates, ELEMents, BLOCk, MESH, SET and SURFace. A mesh that is not sound must
  !! not be computed with, but the names of its parts can be looked up.
  subroutine read_mesh(deck, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(out) :: mesh !! the mesh
    type(element_origin_t) :: origin
    type(surface_draft_t), allocatable :: drafts(:)
    integer :: names, errors, i, region, material
    logical :: complete
    type(error_t), allocatable :: error

    names = error_count(diagnostics)
    call start_mesh(mesh, origin, deck%control(1), deck%control(2))
    call gather_names(deck, diagnostics, mesh)
    errors = error_count(diagnostics)
    allocate (drafts(0))
    region = 0
    material = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command == 'coor') then
        call read_coordinates(deck%mesh(i), mesh, diagnostics)
      else if (deck%mesh(i)%command == 'elem') then
        call read_elements(deck%mesh(i), i, mesh, origin, diagnostics)
      else if (deck%mesh(i)%command == 'bloc') then
        region = region + 1
        call read_block(deck%mesh(i), i, region, material, mesh, origin, diagnostics)
      else if (deck%mesh(i)%command == 'mesh') then
        call read_mesh_file(deck, i, mesh, origin, drafts, diagnostics)
      end if
    end do
    call finish_mesh(mesh, origin, error)
    if (allocated(error)) then
      call report_error(diagnostics, deck%last, error%message, 'make the mesh smaller')
      return
    end if
    ! what was left out because of an error must not give rise to others
    complete = all_read(deck, ['coor', 'elem', 'bloc', 'mesh']) .and. &
      error_count(diagnostics) == errors
    if (complete .and. errors == 0) call check_numbers(deck, origin, diagnostics, mesh)
    call check_elements(deck, origin, complete, diagnostics, mesh)
    complete = complete .and. error_count(diagnostics) == errors
    if (complete) call check_curved(deck, origin, mesh, diagnostics)
    complete = complete .and. error_count(diagnostics) == errors
    call evaluate_parts(deck, complete, diagnostics, mesh, drafts)
    mesh%sound = complete .and. all_read(deck, ['set ', 'surf']) .and. &
      error_count(diagnostics) == names
  end subroutine read_mesh

  !> True if no record of these commands was left out because of an error.
  pure logical function all_read(deck, commands)
    type(deck_t), intent(in) :: deck !! the deck
    character(4), intent(in) :: commands(:) !! first four letters of each
    integer :: i

    all_read = .true.
    do i = 1, size(deck%mesh)
      if (all(deck%mesh(i)%command /= commands)) cycle
      all_read = all_read .and. deck%mesh(i)%complete
    end do
  end function all_read
end module mesh_reader

!> Surfaces of mesh files: their triangles become exterior facets once the mesh is complete.
module file_surfaces
  use text, only: to_text
  use deck_types, only: location_t
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use facets, only: facet_table_t, find_facet
  use key_sorting, only: unique_numbers
  use file_mesh_checks, only: place_in_file
  implicit none
  private
  public :: surface_draft_t, settle_surfaces

  !> Triangles of one surface that are reported one by one.
  integer, parameter :: most_errors = 5

  !> A surface before the exterior facets are known.
  type :: surface_draft_t
    integer :: surface = 0 !! index into mesh%surfaces
    integer :: file = 0 !! number of the file in the source
    integer, allocatable :: corners(:, :) !! (3, n) nodes of the deck
    integer, allocatable :: tag(:) !! (n) number of each triangle or tetrahedron in its file
    integer, allocatable :: at(:) !! (n) character of the file where that stands
    integer, allocatable :: free(:) !! elements all of whose exterior facets belong to it
  end type surface_draft_t

contains

  !> Fills the surfaces that come from mesh files; a triangle that is no exterior facet is an error.
  subroutine settle_surfaces(drafts, table, diagnostics, mesh)
    type(surface_draft_t), intent(in) :: drafts(:) !! the surfaces
    type(facet_table_t), intent(in) :: table !! exterior facets of the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(mesh_t), intent(inout) :: mesh !! its surfaces are filled
    logical, allocatable :: chosen(:), free(:)
    integer, allocatable :: places(:)
    integer :: d, f

    allocate (chosen(table%count))
    do d = 1, size(drafts)
      chosen = .false.
      call choose_triangles(drafts(d), table, mesh, diagnostics, chosen)
      if (size(drafts(d)%free) > 0) then
        allocate (free(mesh%elements), source=.false.)
        free(drafts(d)%free) = .true.
        do f = 1, table%count
          if (free(table%elements(f))) chosen(f) = .true.
        end do
        deallocate (free)
      end if
      places = unique_numbers(chosen)
      mesh%surfaces(drafts(d)%surface)%facets = table%corners(:, places)
      mesh%surfaces(drafts(d)%surface)%elements = table%elements(places)
      if (size(places) == 0 .and. size(drafts(d)%at) == 0) call report_error(diagnostics, &
        mesh%surfaces(drafts(d)%surface)%at, 'surface '// &
        mesh%surfaces(drafts(d)%surface)%name//' has no exterior facet', &
        'its elements lie inside the body')
    end do
  end subroutine settle_surfaces

  !> Marks the exterior facets that the triangles of a surface are.
  subroutine choose_triangles(draft, table, mesh, diagnostics, chosen)
    type(surface_draft_t), intent(in) :: draft !! the surface
    type(facet_table_t), intent(in) :: table !! exterior facets of the mesh
    type(mesh_t), intent(in) :: mesh !! knows the name
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(inout) :: chosen(:) !! (facets) facets chosen so far
    integer :: i, place, wrong
    type(location_t) :: at

    wrong = 0
    associate (name => mesh%surfaces(draft%surface)%name)
      do i = 1, size(draft%tag)
        place = 0
        if (all(draft%corners(:, i) > 0)) place = find_facet(table, draft%corners(:, i))
        if (place > 0) then
          chosen(place) = .true.
          cycle
        end if
        wrong = wrong + 1
        at = place_in_file(diagnostics%source, draft%file, draft%at(i))
        if (wrong <= most_errors) call report_error(diagnostics, at, 'element '// &
          to_text(draft%tag(i))//' of surface '//name//' is no exterior face of the tetrahedra', &
          'a surface lies on the skin of a body, its triangles on faces of tetrahedra')
      end do
      if (wrong > most_errors) call report_error(diagnostics, mesh%surfaces(draft%surface)%at, &
        to_text(wrong)//' of '//to_text(size(draft%tag))//' triangles of surface '//name// &
        ' are no exterior faces', 'see the first of them')
    end associate
  end subroutine choose_triangles
end module file_surfaces

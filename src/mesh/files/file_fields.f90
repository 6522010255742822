!> Vectors of mesh files that belong to facets: a lay on a surface.
module file_fields
  use text, only: to_text
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t, facet_field_t
  use facets, only: find_key
  use key_sorting, only: sort_columns, ascending
  use tag_table, only: tag_table_t, build_table, find_tag
  use mesh_file_types, only: file_mesh_t, file_field_t
  use file_mesh_checks, only: file_place_t, place_in_file
  implicit none
  private
  public :: place_fields, find_vector

contains

  !> Gives the mesh the vectors of a file's triangles, by the corners of these; those of other cells
  !! are passed over, an element that the file does not have is an error.
  subroutine place_fields(place, file, mesh, diagnostics)
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets the fields
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(facet_field_t), allocatable :: more(:)
    type(tag_table_t) :: table
    integer :: i, n

    if (size(file%field) == 0) return
    n = size(mesh%fields)
    allocate (more(n + size(file%field)))
    do i = 1, n
      call move_alloc(mesh%fields(i)%name, more(i)%name)
      call move_alloc(mesh%fields(i)%keys, more(i)%keys)
      call move_alloc(mesh%fields(i)%vectors, more(i)%vectors)
      call move_alloc(mesh%fields(i)%at, more(i)%at)
      more(i)%file = mesh%fields(i)%file
    end do
    call build_table(file%cell_tag(:file%cells), table)
    do i = 1, size(file%field)
      call place_field(file%field(i), table, place, file, diagnostics, more(n + i))
    end do
    call move_alloc(more, mesh%fields)
  end subroutine place_fields

  !> One field: the triangles with all their nodes in the mesh, ordered by corners; of two vectors
  !! for the same triangle the later one counts.
  subroutine place_field(from, table, place, file, diagnostics, field)
    type(file_field_t), intent(in) :: from !! as the file has it
    type(tag_table_t), intent(in) :: table !! finds its cells
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(facet_field_t), intent(inout) :: field !! the field
    integer, allocatable :: keys(:, :), vector(:), order(:)
    integer :: i, c, n

    allocate (keys(3, from%count), vector(from%count), source=0)
    n = 0
    do i = 1, from%count
      c = find_tag(table, from%tag(i))
      if (c == 0) then
        call report_error(diagnostics, place_in_file(diagnostics%source, place%file, &
          from%vector_at(i)), 'element data for element '//to_text(from%tag(i))//', which the '// &
          'file does not have', 'is the file complete? write it again')
        exit
      end if
      if (file%dimension(c) /= 2) cycle
      if (any(place%node(file%ix(:3, c)) == 0)) cycle
      n = n + 1
      keys(:, n) = ascending(place%node(file%ix(:3, c)))
      vector(n) = i
    end do
    call sort_columns(keys(:, :n), order)
    call keep_last(keys, order, n)
    field%name = from%name
    field%file = place%file
    field%keys = keys(:, order(:n))
    field%vectors = from%vector(:, vector(order(:n)))
    field%at = from%vector_at(vector(order(:n)))
  end subroutine place_field

  !> Of columns that are equal keeps the last one.
  pure subroutine keep_last(keys, order, n)
    integer, intent(in) :: keys(:, :) !! (3, n) the columns
    integer, intent(inout) :: order(:) !! (n) their order; the first `n` are kept
    integer, intent(inout) :: n !! number of columns
    integer :: i, kept

    kept = 0
    do i = 1, n
      if (kept > 0) then
        if (all(keys(:, order(i)) == keys(:, order(kept)))) kept = kept - 1
      end if
      kept = kept + 1
      order(kept) = order(i)
    end do
    n = kept
  end subroutine keep_last

  !> The vector of a facet in the last field of a name that has one.
  pure subroutine find_vector(mesh, name, corners, field, place)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: name !! name of the field
    integer, intent(in) :: corners(3) !! of the facet, in any order
    integer, intent(out) :: field !! which field, 0 if there is none of this name
    integer, intent(out) :: place !! which of its vectors, 0 if none is the facet's
    integer :: i

    field = 0
    place = 0
    do i = size(mesh%fields), 1, -1
      if (mesh%fields(i)%name /= name .or. len(mesh%fields(i)%name) /= len(name)) cycle
      field = i
      place = find_key(mesh%fields(i)%keys, corners)
      if (place > 0) return
    end do
  end subroutine find_vector
end module file_fields

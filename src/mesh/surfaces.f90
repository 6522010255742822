!> SURFace: exterior facets chosen by a node set or listed by their corners.
module surfaces
  use text, only: to_text, count_noun
  use deck_types, only: data_set_t, record_t
  use records, only: item_integer, item_name, item_count, is_word
  use diagnostics, only: diagnostics_t, report_error, report_note
  use tied_nodes, only: kept_node
  use mesh_types, only: mesh_t
  use mesh_names, only: find_nodes, find_region, in_region
  use key_sorting, only: unique_numbers
  use facets, only: facet_table_t, find_facet
  implicit none
  private
  public :: select_facets

contains

  !> Facets a SURFace data set chooses: `FROM set [IN region]` in its head, FACEts records.
  subroutine select_facets(set, mesh, table, diagnostics, facets, elements)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(in) :: mesh !! the complete mesh; names it refers to are evaluated
    type(facet_table_t), intent(in) :: table !! exterior facets of the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer, allocatable, intent(out) :: facets(:, :) !! (3, n) corners, seen from outside
    integer, allocatable, intent(out) :: elements(:) !! (n) elements behind
    logical, allocatable :: chosen(:)
    integer, allocatable :: places(:)
    integer :: i, doubles
    logical :: failed

    allocate (chosen(table%count), source=.false.)
    failed = .false.
    if (item_count(set%head) >= 4) call choose_from_set(set%head, mesh, table, diagnostics, &
      chosen, failed)
    doubles = 0
    do i = 1, set%count
      call choose_listed(set%records(i), mesh, table, diagnostics, chosen, doubles, failed)
    end do
    if (doubles > 0) call report_note(diagnostics, set%head%at, 'surface '// &
      item_name(set%head, 2)//': '//count_noun(doubles, 'facet')//' given twice, counted once')
    if (.not. any(chosen) .and. .not. failed) call report_error(diagnostics, set%head%at, &
      'surface '//item_name(set%head, 2)//' has no facet', &
      'say SURFace name FROM set, or list facets: FACEts n1 n2 n3')
    places = unique_numbers(chosen)
    facets = table%corners(:, places)
    elements = table%elements(places)
  end subroutine select_facets

  !> Exterior facets whose corners all lie in a set (and whose element lies in a region).
  subroutine choose_from_set(head, mesh, table, diagnostics, chosen, failed)
    type(record_t), intent(in) :: head !! `SURFace name FROM set [IN region]`
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(facet_table_t), intent(in) :: table !! exterior facets
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(inout) :: chosen(:) !! (facets) facets chosen so far
    logical, intent(inout) :: failed !! an error has been reported
    integer, allocatable :: nodes(:)
    logical, allocatable :: mask(:), chosen_elements(:)
    integer :: f, region, n
    logical :: found
    character(:), allocatable :: hint

    call find_nodes(mesh, item_name(head, 4), nodes, found)
    region = 0
    if (item_count(head) >= 6) call find_region(mesh, item_name(head, 6), region)
    if (region > 0) chosen_elements = in_region(mesh, region)
    allocate (mask(mesh%nodes), source=.false.)
    mask(nodes) = .true.
    n = 0
    do f = 1, table%count
      if (.not. all(mask(table%corners(:, f)))) cycle
      if (region > 0) then
        if (.not. chosen_elements(table%elements(f))) cycle
      end if
      chosen(f) = .true.
      n = n + 1
    end do
    failed = n == 0
    ! a set that is empty has been reported already
    if (.not. failed .or. size(nodes) == 0) return
    hint = 'check the set; facets between two elements are not exterior'
    if (region > 0) hint = 'check set and region: the element behind a facet must be in the region'
    call report_error(diagnostics, head%items(4)%at, 'no exterior facet has its three corners '// &
      'in '//item_name(head, 4)//' ('//count_noun(size(nodes), 'node')//')', hint)
  end subroutine choose_from_set

  !> `FACEts n1 n2 n3`: an exterior facet by its corners, in any order.
  subroutine choose_listed(record, mesh, table, diagnostics, chosen, doubles, failed)
    type(record_t), intent(in) :: record !! the record
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(facet_table_t), intent(in) :: table !! exterior facets
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(inout) :: chosen(:) !! (facets) facets chosen so far
    integer, intent(inout) :: doubles !! number of facets chosen twice
    logical, intent(inout) :: failed !! an error has been reported
    integer :: corners(3), k, first, place, elements

    first = 1
    if (is_word(record%items(1), 'face')) first = 2
    do k = 1, 3
      corners(k) = kept_node(mesh, item_integer(record, first + k - 1))
    end do
    place = find_facet(table, corners)
    if (place > 0) then
      if (chosen(place)) doubles = doubles + 1
      chosen(place) = .true.
      return
    end if
    failed = .true.
    elements = 0
    if (all(corners /= cshift(corners, 1))) elements = elements_with(mesh, corners)
    if (elements > 1) then
      call report_error(diagnostics, record%at, 'facet'//facet_text(corners)// &
        ' lies between two elements', 'a surface is made of exterior facets')
    else
      call report_error(diagnostics, record%at, 'facet'//facet_text(corners)// &
        ' is no face of an element', 'give the three corner nodes of an exterior facet')
    end if
  end subroutine choose_listed

  !> Corner numbers as text.
  pure function facet_text(corners) result(t)
    integer, intent(in) :: corners(3) !! node numbers
    character(:), allocatable :: t

    t = ' '//to_text(corners(1))//' '//to_text(corners(2))//' '//to_text(corners(3))
  end function facet_text

  !> Number of elements that hold three nodes.
  pure integer function elements_with(mesh, corners) result(n)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: corners(3) !! node numbers
    integer :: e, k

    n = 0
    do e = 1, mesh%elements
      if (all([(any(mesh%ix(:4, e) == corners(k)), k=1, 3)])) n = n + 1
    end do
  end function elements_with
end module surfaces

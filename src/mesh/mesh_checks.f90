!> Checks of nodes and elements when the mesh is complete.
module mesh_checks
  use text, only: to_text, count_noun
  use deck_types, only: deck_t, location_t
  use records, only: item_integer, item_count
  use diagnostics, only: diagnostics_t, report_error, report_note
  use cells, only: nodes_of, mirrored, tet4
  use mesh_types, only: mesh_t
  use brick_cutting, only: is_split
  use mesh_building, only: element_origin_t, own_nodes
  use cell_geometry, only: cell_orientation, no_volume, left_handed
  implicit none
  private
  public :: check_elements, check_numbers

  !> Wrong elements of one data set that are reported one by one.
  integer, parameter :: most_wrong_elements = 10

contains

  !> Checks all elements that ELEMents data sets define, and turns left-handed tetrahedra round.
  !! Those of blocks have been checked where they were made. If records were left out because of
  !! errors (`complete` false), nobody knows which nodes are missing.
  subroutine check_elements(deck, origin, complete, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    logical, intent(in) :: complete !! all records of the deck could be used
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer, allocatable :: wrong(:), turned(:), first(:)
    integer :: e, s, i, k
    logical :: good, left

    allocate (wrong(size(deck%mesh)), turned(size(deck%mesh)), first(size(deck%mesh)), source=0)
    do e = 1, mesh%elements
      s = origin%set(e)
      if (s == 0) cycle
      if (deck%mesh(s)%command /= 'elem') cycle
      if (.not. complete) then
        if (any([(node_missing(mesh, mesh%ix(k, e)), k=1, nodes_of(mesh%ix(:, e)))])) cycle
      end if
      call check_element(deck, origin, e, wrong(s) < most_wrong_elements, diagnostics, mesh, &
        good, left)
      if (.not. good) wrong(s) = wrong(s) + 1
      if (.not. left) cycle
      mesh%ix(:, e) = mirrored(mesh%ix(:, e))
      turned(s) = turned(s) + 1
      if (turned(s) == 1) first(s) = e
    end do
    do i = 1, size(deck%mesh)
      if (wrong(i) > most_wrong_elements) call report_error(diagnostics, deck%mesh(i)%head%at, &
        'as '// &
        'many as '//count_noun(wrong(i), 'element')//' of this data set are wrong', &
        'see the first of them')
      if (turned(i) == 1) call report_note(diagnostics, deck%mesh(i)%head%at, &
        'a left-handed tetrahedron reordered: element '//to_text(first(i)))
      if (turned(i) > 1) call report_note(diagnostics, deck%mesh(i)%head%at, &
        to_text(turned(i))//' left-handed tetrahedra reordered, the first is element '// &
        to_text(first(i)))
    end do
  end subroutine check_elements

  !> Checks one element: its nodes exist, are different, and its corners span a volume.
  subroutine check_element(deck, origin, e, report, diagnostics, mesh, good, left)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    integer, intent(in) :: e !! element number
    logical, intent(in) :: report !! report what is wrong
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(inout) :: mesh !! the mesh
    logical, intent(out) :: good !! nothing is wrong
    logical, intent(out) :: left !! it is left-handed
    character(:), allocatable :: what, remedy
    integer :: k, n, j, orientation

    left = .false.
    what = ''
    remedy = ''
    do k = 1, nodes_of(mesh%ix(:, e))
      n = mesh%ix(k, e)
      if (node_missing(mesh, n)) then
        what = 'element '//to_text(e)//' has node '//to_text(n)//', which does not exist'
        remedy = 'the highest node number is '//to_text(mesh%nodes)
        exit
      else if (any(mesh%ix(:k - 1, e) == n)) then
        what = 'element '//to_text(e)//' has node '//to_text(n)//' twice'
        remedy = 'the nodes of a tetrahedron are different'
        exit
      end if
    end do
    good = what == ''
    if (good) then
      orientation = cell_orientation(mesh%x, mesh%ix(:, e))
      left = orientation == left_handed
      good = orientation /= no_volume
      k = 0
      what = 'element '//to_text(e)//' is flat'
      remedy = 'its four corners lie in one plane; check their coordinates and order'
    end if
    ! an element without its nodes is left out, so that what follows can be looked at
    if (.not. good .and. k > 0) mesh%ix(:, e) = 0
    if (good .or. .not. report) return
    j = 3 + k
    if (k == 0) j = 1
    mesh%misplaced = mesh%misplaced + 1
    call report_error(diagnostics, element_location(deck, origin, e, j), what, remedy)
  end subroutine check_element

  !> True if the deck gives no such node.
  pure logical function node_missing(mesh, n) result(missing)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: n !! node number

    missing = n < 1 .or. n > mesh%nodes
    if (.not. missing) missing = .not. mesh%defined(n)
  end function node_missing

  !> Where the deck defines an element: its own item if it has a record, else the record that
  !! made it.
  type(location_t) function element_location(deck, origin, e, item) result(at)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    integer, intent(in) :: e !! element number
    integer, intent(in) :: item !! item of its record

    associate (record => deck%mesh(origin%set(e))%records(origin%record(e)))
      at = record%at
      if (item_integer(record, 1) == e .and. item <= item_count(record)) at = record%items(item)%at
    end associate
  end function element_location

  !> Checks that there are elements, that no number is left out, and that the control record says
  !! the same.
  subroutine check_numbers(deck, origin, diagnostics, mesh)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer :: e, i, materials, most

    if (mesh%elements == 0 .and. any(deck%mesh%command == 'mesh')) then
      call report_error(diagnostics, deck%last, 'the mesh has no elements', 'triangles alone '// &
        '(STL) are a rigid tool: a body wants tetrahedra, from BLOCk or a MESH; Gmsh fills a '// &
        'closed surface with them (doc/tutorials/step-2.md)')
    else if (mesh%elements == 0) then
      call report_error(diagnostics, deck%last, 'the mesh has no elements', &
        'define some with BLOCk or with COORdinates and ELEMents')
    end if
    if (mesh%nodes/100 > 10 + count(mesh%defined)) call report_error( &
      diagnostics, deck%last, 'the highest node number is '//to_text(mesh%nodes)// &
      ', but there are only '//count_noun(count(mesh%defined), 'node'), &
      'number the nodes from 1 without large gaps')
    do e = 1, mesh%elements
      if (origin%set(e) /= 0) cycle
      call report_error(diagnostics, deck%last, 'element '//to_text(e)//' is missing', &
        'number the elements from 1 to '//to_text(mesh%elements)//' without gaps')
      exit
    end do
    materials = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'mate') cycle
      materials = max(materials, item_integer(deck%mesh(i)%head, 2))
    end do
    call check_control(deck, 1, 'numnp', own_nodes(mesh), &
      'the highest node number is', diagnostics)
    if (.not. any([(is_split(deck%mesh(i)), i=1, size(deck%mesh))])) call check_control(deck, 2, &
      'numel', mesh%elements, 'the highest element number is', diagnostics)
    if (all(deck%mesh%complete)) call check_control(deck, 3, 'nummat', materials, &
      'the highest material number is', diagnostics)
    most = tet4%nodes
    do e = 1, mesh%elements
      most = max(most, nodes_of(mesh%ix(:, e)))
    end do
    if (deck%control(6) > most) return
    call check_control(deck, 6, 'nen', most, 'the most nodes of an element are', diagnostics)
  end subroutine check_numbers

  !> Compares one number of the control record with what was found.
  subroutine check_control(deck, place, name, found, text, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    integer, intent(in) :: place !! place in the control record
    character(*), intent(in) :: name !! FEAP's name of the number
    integer, intent(in) :: found !! what was found
    character(*), intent(in) :: text !! what that is
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(location_t) :: at

    if (deck%control(place) == 0 .or. deck%control(place) == found) return
    at = deck%control_record%at
    if (place <= item_count(deck%control_record)) at = deck%control_record%items(place)%at
    call report_error(diagnostics, at, name//' = '//to_text(deck%control(place))//', but '//text// &
      ' '//to_text(found), 'correct it, or give 0 to have it counted')
  end subroutine check_control
end module mesh_checks

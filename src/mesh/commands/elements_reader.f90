!> ELEMents: numbered elements, with FEAP's generation of the numbers between two records; bricks
!! behind SPLIt.
module elements_reader
  use text, only: to_text
  use errors, only: error_t, raise, exit_deck
  use deck_types, only: data_set_t, record_t
  use records, only: item_integer, item_count
  use diagnostics, only: diagnostics_t, report_error
  use cells, only: brick, shapes, most_nodes
  use mesh_types, only: mesh_t
  use brick_cutting, only: is_split
  use mesh_building, only: element_origin_t, reserve_elements, place_element, most_mesh_nodes
  implicit none
  private
  public :: read_elements

  !> Longest gap that is filled between two records, and longest jump beyond the highest element:
  !! more is taken for a slip of the pen.
  integer, parameter :: longest_gap = 100000
  integer, parameter :: longest_jump = 1000000

  !> What one record says: `element increment material n1 n2 n3 n4 [n5 .. n10]`.
  type :: element_record_t
    integer :: number = 0 !! element number, 0 if the record cannot be used
    integer :: increment = 1 !! step of the node numbers for elements generated behind this one
    integer :: material = 0 !! material number
    integer :: nodes(most_nodes) = 0 !! its nodes, zeros behind the last
    integer :: pieces = 1 !! tetrahedra it is cut into
  end type element_record_t

contains

  !> Reads one ELEMents data set. Numbers left out between two records are generated from the
  !! earlier one: its nodes plus its increment, its material.
  subroutine read_elements(set, index, mesh, origin, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: index !! its index among the mesh commands
    type(mesh_t), intent(inout) :: mesh !! the mesh it adds to
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(element_record_t) :: now, before
    integer :: i

    do i = 1, set%count
      call interpret_record(set%records(i), is_split(set), diagnostics, now)
      if (now%number > 0) call check_sequence(set%records(i), before, diagnostics, now)
      if (now%number > 0) call make_room(set%records(i), mesh, origin, diagnostics, now)
      if (now%number > 0) then
        if (before%number > 0) call generate(set%records(i), index, i, before, now%number, mesh, &
          origin, diagnostics)
        call put_element(set%records(i), index, i, now, mesh, origin, diagnostics)
      end if
      before = now
    end do
  end subroutine read_elements

  !> Takes a record apart.
  subroutine interpret_record(record, split, diagnostics, now)
    type(record_t), intent(in) :: record !! the record
    logical, intent(in) :: split !! it is a brick that is to be cut
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(element_record_t), intent(out) :: now !! what it says; number 0 if it cannot be used
    integer :: number, k, extra

    number = item_integer(record, 1)
    now%increment = item_integer(record, 2)
    if (now%increment == 0) now%increment = 1
    now%material = item_integer(record, 3)
    extra = 0
    do k = 4, item_count(record)
      if (item_integer(record, k) == 0) cycle
      extra = k
      if (k <= 3 + most_nodes) now%nodes(k - 3) = item_integer(record, k)
    end do
    if (number < 1) then
      call report_error(diagnostics, record%items(1)%at, 'element number '//to_text(number), &
        'element numbers start at 1; a blank line ends the data set')
    else if (split) then
      call check_brick(record, extra - 3, diagnostics, now)
    else if (all(shapes%nodes /= brick%nodes) .and. extra - 3 == brick%nodes .and. &
      all(now%nodes(:brick%nodes) > 0)) then
      call report_error(diagnostics, record%items(extra)%at, 'element '//to_text(number)// &
        ' has 8 nodes: a brick', 'elements are tetrahedra; ELEMents SPLIt cuts a brick into six')
    else if (all(extra - 3 /= shapes%nodes) .or. any(now%nodes(:min(extra - 3, most_nodes)) == 0)) &
      then
      call report_error(diagnostics, record%items(max(extra, 1))%at, 'element '//to_text(number)// &
        ' has neither 4 nor 10 nodes', 'a tetrahedron has four corners, and ten nodes with '// &
        'those in the middle of its edges; zeros may follow')
    else if (now%material < 1) then
      call report_error(diagnostics, record%items(min(3, item_count(record)))%at, &
        'material number '//to_text(now%material), &
        'a record reads: element increment material n1 n2 n3 n4')
    else
      now%number = number
    end if
    if (split .and. number > 0 .and. now%pieces > 1) now%number = number
  end subroutine interpret_record

  !> A record of ELEMents SPLIt has the eight nodes of a brick.
  subroutine check_brick(record, nodes, diagnostics, now)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: nodes !! nodes it gives
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(element_record_t), intent(inout) :: now !! what it says; pieces 1 if it cannot be used

    if (nodes /= brick%nodes .or. any(now%nodes(:brick%nodes) == 0)) then
      call report_error(diagnostics, record%items(item_count(record))%at, 'brick '// &
        to_text(item_integer(record, 1))//' does not have 8 nodes', &
        'behind ELEMents SPLIt each record gives a brick: corners 1 to 4 of the lower face, '// &
        '5 to 8 above them')
    else if (now%material < 1) then
      call report_error(diagnostics, record%items(3)%at, 'material number '// &
        to_text(now%material), 'a record reads: element increment material n1 ... n8')
    else
      now%pieces = brick%pieces
    end if
  end subroutine check_brick

  !> Element numbers of one data set ascend.
  subroutine check_sequence(record, before, diagnostics, now)
    type(record_t), intent(in) :: record !! the record
    type(element_record_t), intent(in) :: before !! the record before it
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(element_record_t), intent(inout) :: now !! what it says; number 0 if it cannot be used

    if (before%number > 0 .and. now%number - before%number > longest_gap) then
      call report_error(diagnostics, record%items(1)%at, 'element '//to_text(now%number)// &
        ' leaves out '//to_text(now%number - before%number - 1)//' elements behind element '// &
        to_text(before%number), 'at most '//to_text(longest_gap)//' are generated')
    else if (now%number > before%number) then
      return
    else if (now%number == before%number) then
      call report_error(diagnostics, record%items(1)%at, 'element '//to_text(now%number)// &
        ' is defined twice', 'give each element once')
    else
      call report_error(diagnostics, record%items(1)%at, 'element '//to_text(now%number)// &
        ' comes after element '//to_text(before%number), 'order the records by element '// &
        'number, or begin a new ELEMents data set')
    end if
    now%number = 0
  end subroutine check_sequence

  !> Makes room for the element.
  subroutine make_room(record, mesh, origin, diagnostics, now)
    type(record_t), intent(in) :: record !! the record
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(element_record_t), intent(inout) :: now !! what it says; number 0 if it cannot be used
    type(error_t), allocatable :: error

    if (now%number - longest_jump > mesh%elements .or. now%number > most_mesh_nodes) then
      call raise(error, exit_deck, 'element '//to_text(now%number)// &
        ' is far beyond the highest so far, '//to_text(mesh%elements))
    else
      call reserve_elements(mesh, origin, now%pieces*now%number, error)
    end if
    if (.not. allocated(error)) return
    call report_error(diagnostics, record%items(1)%at, error%message, &
      'number the elements from 1 without gaps')
    now%number = 0
  end subroutine make_room

  !> Makes the elements between two records.
  subroutine generate(record, index, i, before, next, mesh, origin, diagnostics)
    type(record_t), intent(in) :: record !! the later record
    integer, intent(in) :: index !! index of the command
    integer, intent(in) :: i !! index of the later record
    type(element_record_t), intent(in) :: before !! the earlier record
    integer, intent(in) :: next !! element number of the later record
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(element_record_t) :: made
    integer :: room

    room = most_mesh_nodes - maxval(before%nodes)
    if (before%increment < 0) room = minval(before%nodes, before%nodes > 0) - 1
    made = before
    do while (made%number < next - 1)
      if (room < abs(made%increment)) then
        call report_error(diagnostics, record%items(1)%at, 'the elements generated between '// &
          to_text(before%number)//' and '//to_text(next)//' run out of nodes at element '// &
          to_text(made%number + 1), 'give a record for each element, or the right increment '// &
          'of node numbers as second item of the earlier record')
        return
      end if
      room = room - abs(made%increment)
      made%number = made%number + 1
      where (made%nodes > 0) made%nodes = made%nodes + made%increment
      call put_element(record, index, i, made, mesh, origin, diagnostics)
    end do
  end subroutine generate

  !> Puts one element into the mesh.
  subroutine put_element(record, index, i, element, mesh, origin, diagnostics)
    type(record_t), intent(in) :: record !! the record it comes from
    integer, intent(in) :: index !! index of the command
    integer, intent(in) :: i !! index of the record
    type(element_record_t), intent(in) :: element !! the element
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical :: twice
    integer :: e, t

    if (element%pieces == 1) then
      call place_element(mesh, origin, element%number, element%nodes, element%material, index, i, &
        twice)
    else
      e = brick%pieces*(element%number - 1)
      do t = 1, brick%pieces
        call place_element(mesh, origin, e + t, element%nodes(brick%piece(:, t)), &
          element%material, index, i, twice)
        if (twice) exit
      end do
    end if
    if (twice) call report_error(diagnostics, record%items(1)%at, 'element '// &
      to_text(element%number)//' is defined twice', &
      'give each element once; elements of a BLOCk and generated ones count too')
  end subroutine put_element
end module elements_reader

!> SET: nodes chosen by planes, boxes, regions and lists.
module node_sets
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: data_set_t, record_t, location_t
  use records, only: item_integer, item_real, item_name, item_count, is_word
  use diagnostics, only: diagnostics_t, report_error, report_warning
  use mesh_types, only: mesh_t
  use mesh_building, only: own_nodes, axis_tolerance, miss_tolerance
  use tied_nodes, only: kept_node
  use mesh_names, only: find_nodes
  use key_sorting, only: unique_numbers
  implicit none
  private
  public :: select_nodes, node_exists, warn_of_misses

  !> Nodes that a warning names.
  integer, parameter :: most_named = 5

contains

  !> Nodes a SET data set chooses: records narrow the choice, OR starts an alternative.
  subroutine select_nodes(set, mesh, diagnostics, nodes)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(in) :: mesh !! the complete mesh; names it refers to are evaluated
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer, allocatable, intent(out) :: nodes(:) !! node numbers, ascending
    logical, allocatable :: chosen(:), alternative(:), near(:), nearly(:)
    integer :: i, first
    logical :: empty, failed

    allocate (chosen(mesh%nodes), source=.false.)
    alternative = mesh%defined
    near = chosen
    nearly = alternative
    empty = .true.
    failed = .false.
    do i = 1, set%count
      first = 1
      if (is_word(set%records(i)%items(1), 'or')) then
        if (.not. empty) chosen = chosen .or. alternative
        if (.not. empty) near = near .or. nearly
        alternative = mesh%defined
        nearly = alternative
        empty = .true.
        first = 2
      end if
      if (item_count(set%records(i)) < first) cycle
      empty = .false.
      call narrow(set%records(i), first, mesh, diagnostics, alternative, nearly, failed)
    end do
    if (.not. empty) chosen = chosen .or. alternative
    if (.not. empty) near = near .or. nearly
    nodes = unique_numbers(chosen)
    if (size(nodes) == 0 .and. .not. failed) call report_empty(set, mesh, diagnostics)
    if (size(nodes) > 0 .and. .not. failed) call warn_of_misses(mesh, 'set '// &
      item_name(set%head, 2), set%head%at, chosen, near .and. .not. chosen, &
      'give PLANe a tolerance behind its coordinate, or widen the BOX', diagnostics)
  end subroutine select_nodes

  !> Warns of nodes just beside what is chosen: their coordinates may have been rounded. Such as
  !! hang together with none of those chosen belong to another body, which has a gap to this one.
  subroutine warn_of_misses(mesh, what, at, chosen, missed, remedy, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: what !! what chooses nodes
    type(location_t), intent(in) :: at !! where it stands
    logical, intent(in) :: chosen(:) !! (nodes) what it takes
    logical, intent(in) :: missed(:) !! (nodes) just beside it
    character(*), intent(in) :: remedy !! how to choose them
    type(diagnostics_t), intent(inout) :: diagnostics !! gets the warning
    integer, allocatable :: nodes(:)
    character(:), allocatable :: t
    integer :: i

    if (.not. any(missed)) return
    nodes = unique_numbers(joined_to(mesh, chosen, missed))
    if (size(nodes) == 0) return
    t = ''
    do i = 1, min(most_named, size(nodes))
      t = t//' '//to_text(nodes(i))
    end do
    if (size(nodes) > most_named) t = t//' ...'
    call report_warning(diagnostics, at, what//' leaves out '//count_noun(size(nodes), 'node')// &
      ' just beside it, less than a hundredth of an element away:'//t//'; if they are meant, '// &
      remedy)
  end subroutine warn_of_misses

  !> Those of some nodes that hang together with others by edges between them.
  pure function joined_to(mesh, others, some) result(joined)
    type(mesh_t), intent(in) :: mesh !! the mesh
    logical, intent(in) :: others(:) !! (nodes)
    logical, intent(in) :: some(:) !! (nodes)
    logical :: joined(size(some)), changed
    integer :: e, n

    joined = .false.
    do
      changed = .false.
      do e = 1, mesh%elements
        if (mesh%ix(1, e) == 0) cycle
        associate (nodes => mesh%ix(:count(mesh%ix(:, e) > 0), e))
          if (.not. any(some(nodes) .and. .not. joined(nodes))) cycle
          if (.not. any(others(nodes) .or. joined(nodes))) cycle
          do n = 1, size(nodes)
            changed = changed .or. some(nodes(n)) .and. .not. joined(nodes(n))
            joined(nodes(n)) = joined(nodes(n)) .or. some(nodes(n))
          end do
        end associate
      end do
      if (.not. changed) return
    end do
  end function joined_to

  !> Narrows the choice by one record.
  subroutine narrow(record, first, mesh, diagnostics, chosen, near, failed)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! its first item (behind OR)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(inout) :: chosen(:) !! (nodes) nodes chosen so far
    logical, intent(inout) :: near(:) !! (nodes) these, and such as lie just beside them
    logical, intent(inout) :: failed !! an error has been reported
    integer, allocatable :: nodes(:)
    logical, allocatable :: mask(:)
    logical :: found

    if (is_word(record%items(first), 'plan')) then
      call narrow_by_plane(record, first, mesh, diagnostics, chosen, near, failed)
    else if (is_word(record%items(first), 'box')) then
      call narrow_by_box(record, first, mesh, diagnostics, chosen, near, failed)
    else if (is_word(record%items(first), 'insi')) then
      call find_nodes(mesh, item_name(record, first + 1), nodes, found)
      allocate (mask(mesh%nodes), source=.false.)
      mask(nodes) = .true.
      chosen = chosen .and. mask
      near = near .and. mask
      failed = failed .or. size(nodes) == 0
    else if (is_word(record%items(first), 'node')) then
      call narrow_by_list(record, first, mesh, diagnostics, chosen, failed)
      ! a list says what it means
      near = near .and. chosen
    end if
  end subroutine narrow

  !> `PLANe dir coordinate [tol]`.
  subroutine narrow_by_plane(record, first, mesh, diagnostics, chosen, near, failed)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! place of the word PLANe
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(inout) :: chosen(:) !! (nodes) nodes chosen so far
    logical, intent(inout) :: near(:) !! (nodes) these, and such as lie just beside them
    logical, intent(inout) :: failed !! an error has been reported
    real(wp) :: tolerance(mesh%nodes)
    integer :: direction

    direction = item_integer(record, first + 1)
    if (direction < 1 .or. direction > 3) then
      call report_error(diagnostics, record%items(min(first + 1, item_count(record)))%at, &
        'direction '//to_text(direction)//' does not exist', 'directions are 1, 2 and 3')
      failed = .true.
      return
    end if
    tolerance = plane_tolerance(record, first, mesh)
    if (any(tolerance < 0.0_wp)) then
      call report_error(diagnostics, record%items(first + 3)%at, 'a tolerance below 0', &
        'leave it out for 1e-8 of the model size')
      failed = .true.
      return
    end if
    call keep_between(mesh, direction, item_real(record, first + 2), item_real(record, first + 2), &
      tolerance, chosen)
    if (item_count(record) < first + 3) tolerance = max(tolerance, miss_tolerance(mesh))
    call keep_between(mesh, direction, item_real(record, first + 2), item_real(record, first + 2), &
      tolerance, near)
  end subroutine narrow_by_plane

  !> Keeps the nodes between two bounds of a coordinate, each with its tolerance.
  pure subroutine keep_between(mesh, direction, low, high, tolerance, chosen)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: direction !! 1, 2, 3
    real(wp), intent(in) :: low !! lower bound [length]
    real(wp), intent(in) :: high !! upper bound [length]
    real(wp), intent(in) :: tolerance(:) !! (nodes) [length]
    logical, intent(inout) :: chosen(:) !! (nodes) nodes chosen so far

    ! coordinates are below 1e100, but the deck's number may be anything
    chosen = chosen .and. mesh%x(direction, :) <= high + tolerance
    chosen = chosen .and. mesh%x(direction, :) >= low - tolerance
    chosen(own_nodes(mesh) + 1:) = .false.
  end subroutine keep_between

  !> Tolerance of a PLANe record [length].
  function plane_tolerance(record, first, mesh) result(tolerance)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! place of the word PLANe
    type(mesh_t), intent(in) :: mesh !! the mesh
    real(wp) :: tolerance(mesh%nodes)

    if (item_count(record) >= first + 3) then
      tolerance = min(item_real(record, first + 3), 1.0e100_wp)
    else
      tolerance = axis_tolerance(mesh, item_integer(record, first + 1))
    end if
  end function plane_tolerance

  !> `BOX x1 x2 y1 y2 z1 z2`.
  subroutine narrow_by_box(record, first, mesh, diagnostics, chosen, near, failed)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! place of the word BOX
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(inout) :: chosen(:) !! (nodes) nodes chosen so far
    logical, intent(inout) :: near(:) !! (nodes) these, and such as lie just beside them
    logical, intent(inout) :: failed !! an error has been reported
    real(wp) :: low, high, tolerance(mesh%nodes)
    integer :: k

    do k = 1, 3
      low = item_real(record, first + 2*k - 1)
      high = item_real(record, first + 2*k)
      if (low > high) then
        call report_error(diagnostics, record%items(first + 2*k - 1)%at, 'the box ends before '// &
          'it begins: x'//to_text(k)//' from '//to_text(low)//' to '//to_text(high), &
          'say BOX x1 x2 y1 y2 z1 z2, lower bounds first')
        failed = .true.
        return
      end if
      tolerance = axis_tolerance(mesh, k)
      call keep_between(mesh, k, low, high, tolerance, chosen)
      call keep_between(mesh, k, low, huge(1.0_wp), bound_tolerance(mesh, k, low, tolerance), near)
      call keep_between(mesh, k, -huge(1.0_wp), high, bound_tolerance(mesh, k, high, tolerance), &
        near)
    end do
  end subroutine narrow_by_box

  !> What lies just beside the bound of a box was meant, maybe, where the bound is one of nodes.
  pure function bound_tolerance(mesh, direction, bound, tolerance) result(wider)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: direction !! 1, 2, 3
    real(wp), intent(in) :: bound !! of the box [length]
    real(wp), intent(in) :: tolerance(:) !! (nodes) [length]
    real(wp) :: wider(size(tolerance))

    wider = tolerance
    if (any(mesh%defined .and. abs(mesh%x(direction, :) - bound) <= tolerance)) &
      wider = max(tolerance, miss_tolerance(mesh))
  end function bound_tolerance

  !> `NODEs a b c TO d ...`. Listed nodes and the ends of a range exist; between them gaps may be.
  subroutine narrow_by_list(record, first, mesh, diagnostics, chosen, failed)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! place of the word NODEs
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(inout) :: chosen(:) !! (nodes) nodes chosen so far
    logical, intent(inout) :: failed !! an error has been reported
    logical, allocatable :: mask(:)
    integer :: i, k, n, last
    logical :: range

    allocate (mask(mesh%nodes), source=.false.)
    last = 0
    range = .false.
    do i = first + 1, item_count(record)
      if (is_word(record%items(i), 'to')) then
        range = .true.
        if (last == 0) exit
        cycle
      end if
      n = item_integer(record, i)
      if (.not. node_exists(mesh, kept_node(mesh, n))) then
        call report_error(diagnostics, record%items(i)%at, 'node '//to_text(n)// &
          ' does not exist', 'the highest node number is '//to_text(own_nodes(mesh)))
        failed = .true.
        return
      end if
      if (range .and. n < last) exit
      if (range) then
        do k = last, n
          if (node_exists(mesh, kept_node(mesh, k))) mask(kept_node(mesh, k)) = .true.
        end do
      end if
      mask(kept_node(mesh, n)) = .true.
      range = .false.
      last = n
    end do
    if (range) then
      call report_error(diagnostics, record%at, 'a range of nodes that does not ascend', &
        'say NODEs a TO b with a below b')
      failed = .true.
    end if
    chosen = chosen .and. mask
  end subroutine narrow_by_list

  !> Whether the deck gives this node coordinates.
  pure logical function node_exists(mesh, n) result(exists)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: n !! node number

    exists = n >= 1 .and. n <= own_nodes(mesh)
    if (exists) exists = mesh%defined(n)
  end function node_exists

  !> Says that a set is empty, and how near the nearest node is to the first plane that misses all.
  subroutine report_empty(set, mesh, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: i, first, direction, node
    real(wp) :: coordinate

    do i = 1, set%count
      first = 1
      if (is_word(set%records(i)%items(1), 'or')) first = 2
      if (item_count(set%records(i)) < first) cycle
      if (.not. is_word(set%records(i)%items(first), 'plan')) cycle
      direction = item_integer(set%records(i), first + 1)
      coordinate = item_real(set%records(i), first + 2)
      if (.not. any(mesh%defined)) cycle
      node = minloc(abs(mesh%x(direction, :) - coordinate), dim=1, mask=mesh%defined)
      if (any(mesh%defined .and. abs(mesh%x(direction, :) - coordinate) <= &
        plane_tolerance(set%records(i), first, mesh))) cycle
      call report_error(diagnostics, set%records(i)%at, 'set '//item_name(set%head, 2)// &
        ' is empty: no node has x'//to_text(direction)//' = '//to_text(coordinate), &
        'the nearest is node '//to_text(node)//' at '//to_text(mesh%x(direction, node), 12))
      return
    end do
    call report_error(diagnostics, set%head%at, 'set '//item_name(set%head, 2)//' is empty', &
      'records narrow the choice (logical and); OR starts an alternative')
  end subroutine report_empty
end module node_sets

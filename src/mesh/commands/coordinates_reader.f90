!> COORdinates: numbered nodes, with FEAP's generation between two records.
module coordinates_reader
  use kinds, only: wp
  use text, only: to_text
  use errors, only: error_t
  use deck_types, only: data_set_t, record_t, location_t
  use records, only: item_integer, item_real
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_types, only: mesh_t
  use mesh_building, only: reserve_nodes, place_node, max_coordinate, set_roundings
  use near_places, only: roundings
  implicit none
  private
  public :: read_coordinates, report_second_place

contains

  !> Reads one COORdinates data set: `node increment x1 x2 x3`. If the previous record had an
  !! increment, the nodes between the two records are put on the straight line between them.
  subroutine read_coordinates(set, mesh, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    type(mesh_t), intent(inout) :: mesh !! the mesh it adds to
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: i, node, previous, increment
    real(wp) :: x(3), x_previous(3), written(3, set%count)
    logical :: good

    previous = 0
    increment = 0
    x_previous = 0.0_wp
    do i = 1, set%count
      call read_node(set%records(i), mesh, diagnostics, node, x, good)
      if (good .and. previous > 0 .and. increment /= 0) call fill_line(set%records(i)%at, &
        previous, node, abs(increment), x_previous, x, mesh, diagnostics)
      if (good) call put_node(set%records(i)%items(1)%at, node, x, mesh, diagnostics)
      written(:, i) = merge(x, 0.0_wp, good)
      previous = merge(node, 0, good)
      increment = item_integer(set%records(i), 2)
      x_previous = x
    end do
    call keep_roundings(set, roundings(written), mesh)
  end subroutine read_coordinates

  !> Keeps what the coordinates of a data set are rounded by; generated nodes lie between others,
  !! and are off by no more than these.
  subroutine keep_roundings(set, rounding, mesh)
    type(data_set_t), intent(in) :: set !! the data set
    real(wp), intent(in) :: rounding(:, :) !! (3, records) [length]
    type(mesh_t), intent(inout) :: mesh !! the mesh
    integer :: i, n, node, previous, step

    previous = 0
    do i = 1, set%count
      node = item_integer(set%records(i), 1)
      if (node < 1 .or. node > mesh%nodes) exit
      if (previous > 0) then
        step = item_integer(set%records(i - 1), 2)
        if (step /= 0) then
          step = sign(min(abs(step), abs(node - previous) + 1), node - previous)
          do n = previous + step, node - sign(1, step), step
            call set_roundings(mesh, n, max(rounding(:, i - 1), rounding(:, i)))
          end do
        end if
      end if
      call set_roundings(mesh, node, rounding(:, i))
      previous = node
    end do
  end subroutine keep_roundings

  !> Reads one record and makes room for its node.
  subroutine read_node(record, mesh, diagnostics, node, x, good)
    type(record_t), intent(in) :: record !! the record
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer, intent(out) :: node !! its node number
    real(wp), intent(out) :: x(3) !! its coordinates [length]
    logical, intent(out) :: good !! the record can be used
    type(error_t), allocatable :: error
    integer :: k

    node = item_integer(record, 1)
    good = .false.
    x = 0.0_wp
    do k = 1, 3
      x(k) = item_real(record, 2 + k)
      if (abs(x(k)) <= max_coordinate) cycle
      call report_error(diagnostics, record%items(2 + k)%at, 'coordinate '//to_text(k)// &
        ' of node '//to_text(node)//' is absurdly large', &
        'coordinates lie between -1e100 and 1e100')
      return
    end do
    if (node < 1) then
      call report_error(diagnostics, record%items(1)%at, 'node number '//to_text(node), &
        'node numbers start at 1; a blank line ends the data set')
      return
    end if
    call reserve_nodes(mesh, node, error)
    good = .not. allocated(error)
    if (.not. good) call report_error(diagnostics, record%items(1)%at, error%message, &
      'number the nodes from 1 without large gaps')
  end subroutine read_node

  !> Puts the nodes `first + increment, first + 2 increment, ...` before `last` on the line.
  subroutine fill_line(at, first, last, increment, x_first, x_last, mesh, diagnostics)
    type(location_t), intent(in) :: at !! the record of the last node
    integer, intent(in) :: first !! node where the line begins
    integer, intent(in) :: last !! node where the line ends
    integer, intent(in) :: increment !! step of the node numbers, > 0
    real(wp), intent(in) :: x_first(3) !! coordinates of the first node [length]
    real(wp), intent(in) :: x_last(3) !! coordinates of the last node [length]
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: steps, i, way
    real(wp) :: s

    way = sign(min(increment, abs(last - first) + 1), last - first)
    if (first == last) return
    steps = (abs(last - first) - 1)/abs(way) + 1
    if (steps*abs(way) /= abs(last - first)) call report_note(diagnostics, at, 'nodes '// &
      to_text(first)//' to '//to_text(last)//' are no whole number of steps of '// &
      to_text(increment)//' apart: as in FEAP the nodes between divide the line in '// &
      to_text(steps)//' parts')
    do i = 1, steps - 1
      s = real(i, wp)/real(steps, wp)
      call put_node(at, first + i*way, (1.0_wp - s)*x_first + s*x_last, mesh, diagnostics)
    end do
  end subroutine fill_line

  !> Gives a node its coordinates; other ones than before are an error.
  subroutine put_node(at, node, x, mesh, diagnostics)
    type(location_t), intent(in) :: at !! where the deck says so
    integer, intent(in) :: node !! node number
    real(wp), intent(in) :: x(3) !! coordinates [length]
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    real(wp) :: apart

    call place_node(mesh, node, x, apart)
    if (apart <= 0.0_wp) return
    mesh%misplaced = mesh%misplaced + 1
    call report_second_place(at, node, apart, diagnostics)
  end subroutine put_node

  !> Says that a node has been given two places.
  subroutine report_second_place(at, node, apart, diagnostics)
    type(location_t), intent(in) :: at !! where the deck gives the second place
    integer, intent(in) :: node !! node number
    real(wp), intent(in) :: apart !! distance to the first place [length]
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes

    call report_error(diagnostics, at, 'node '//to_text(node)// &
      ' has other coordinates already, '//to_text(apart)//' away', &
      'give each node its coordinates once; generated nodes count too')
  end subroutine report_second_place
end module coordinates_reader

!> Reads ROTAtion: nodes that turn about an axis by any angle. The displacement of a node at r from
!! the axis is sin(angle) a x r + (1 - cos(angle)) a x (a x r): two loads, whose factors are these
!! functions of the table's (doc/theory, "Loads", eq. (9.4)).
module rotations_reader
  use kinds, only: wp, pi
  use text, only: to_text
  use vectors, only: cross
  use deck_types, only: deck_t, record_t, location_t
  use records, only: item_location, item_name, item_real
  use diagnostics, only: diagnostics_t, report_error
  use node_queries, only: nodes_of_item
  use bulk_laws, only: laws
  use model_types, only: model_t, load_t, form_sine, form_versine
  use loads, only: add_values, corner_times, join_load, load_factor
  use distributed_loads, only: check_load_table
  implicit none
  private
  public :: read_rotations, add_turn, check_turned, largest_angle

  !> Largest angle by which a part of a body of small strain may turn [degree].
  real(wp), parameter :: most_angle = 1.0_wp

contains

  !> Restrains the nodes and lists the loads; mesh, materials and tables have been read.
  subroutine read_rotations(deck, model, diagnostics, restrained, loads)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(in) :: model !! mesh, materials, tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical, intent(inout) :: restrained(:, :) !! (3, nodes) becomes true for nodes that turn
    type(load_t), allocatable, intent(inout) :: loads(:) !! grows
    integer :: turned(model%mesh%nodes), i, k, n

    turned = 0
    n = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'rota') cycle
      do k = 1, deck%mesh(i)%count
        n = n + 1
        call read_rotation(deck%mesh(i)%records(k), n, model, diagnostics, turned, loads)
      end do
    end do
    if (n == 0) return
    do i = 1, model%mesh%nodes
      if (turned(i) > 0) restrained(:, i) = .true.
    end do
  end subroutine read_rotations

  !> `set x y z ax ay az angle [n]`.
  subroutine read_rotation(record, number, model, diagnostics, turned, loads)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: number !! which record of ROTAtion it is
    type(model_t), intent(in) :: model !! mesh, materials, tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer, intent(inout) :: turned(:) !! (nodes) record that turns them, 0 for none
    type(load_t), allocatable, intent(inout) :: loads(:) !! gets two loads
    integer, allocatable :: nodes(:)
    real(wp) :: point(3), axis(3), angle
    integer :: table, k, i
    logical :: good

    call nodes_of_item(model%mesh, record, 1, diagnostics, nodes)
    call check_load_table(model, record, 9, diagnostics, table, good)
    point = [(item_real(record, 1 + k), k=1, 3)]
    axis = [(item_real(record, 4 + k), k=1, 3)]
    angle = item_real(record, 8)*pi/180.0_wp
    if (norm2(axis) <= 0.0_wp) then
      call report_error(diagnostics, item_location(record, 5), 'an axis without direction', &
        'write the components of a vector along it, for instance 0 0 1')
      return
    end if
    if (size(nodes) == 0 .or. .not. good) return
    i = findloc(turned(nodes) > 0, .true., 1)
    if (i > 0) then
      call report_error(diagnostics, item_location(record, 1), 'node '//to_text(nodes(i))// &
        ' of '//item_name(record, 1)//' is turned by another record as well', &
        'turn it once; what goes to and fro is the business of the table')
      return
    end if
    turned(nodes) = number
    call check_turned(item_location(record, 8), model, number, turned, &
      largest_angle(model, table, angle), diagnostics)
    call add_turn(model%mesh%x, nodes, point, axis/norm2(axis), angle, table, loads)
  end subroutine read_rotation

  !> The largest angle of a run.
  real(wp) function largest_angle(model, table, angle) result(largest)
    type(model_t), intent(in) :: model !! tables
    integer, intent(in) :: table !! number of a table
    real(wp), intent(in) :: angle !! where it is 1
    real(wp), allocatable :: times(:)
    integer :: i

    call corner_times(model%tables, times)
    largest = maxval([(abs(angle*load_factor(model%tables, table, times(i))), i=1, size(times))])
  end function largest_angle

  !> A body of small strain of which a part turns must not turn far: its stress would be false.
  subroutine check_turned(at, model, number, turned, angle, diagnostics)
    type(location_t), intent(in) :: at !! what turns it
    type(model_t), intent(in) :: model !! mesh and materials
    integer, intent(in) :: number !! which record or rigid body it is
    integer, intent(in) :: turned(:) !! (nodes) record that turns them
    real(wp), intent(in) :: angle !! the largest
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: e, m, n, count_turned

    if (angle <= most_angle*pi/180.0_wp*(1.0_wp + 1.0e-9_wp)) return
    do e = 1, model%mesh%elements
      m = model%element_material(e)
      if (m == 0) cycle
      if (model%materials(m)%rigid .or. laws(model%materials(m)%law)%finite) cycle
      n = count(model%mesh%ix(:, e) > 0)
      count_turned = count(turned(model%mesh%ix(:n, e)) == number)
      if (count_turned == 0 .or. count_turned == n) cycle
      call report_error(diagnostics, at, 'a part of an elastic body '// &
        'turns by '//to_text(angle*180.0_wp/pi, 6)//' degrees: in small strain its stress '// &
        'would be false', 'turn all nodes of the region (RIGId), at most 1 degree, or take a '// &
        'law of finite strain')
      return
    end do
  end subroutine check_turned

  !> The two patterns of a rotation.
  subroutine add_turn(x, nodes, point, axis, angle, table, loads)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(:) !! those that turn
    real(wp), intent(in) :: point(3) !! on the axis [length]
    real(wp), intent(in) :: axis(3) !! unit vector
    real(wp), intent(in) :: angle !! where the table is 1
    integer, intent(in) :: table !! number of the table
    type(load_t), allocatable, intent(inout) :: loads(:) !! grows
    real(wp) :: across(3)
    integer :: i, sine, versine

    call join_load(loads, table, sine, form_sine, angle)
    call join_load(loads, table, versine, form_versine, angle)
    do i = 1, size(nodes)
      across = cross(axis, x(:, nodes(i)) - point)
      call add_values(loads(sine)%displacement, nodes(i), across)
      call add_values(loads(versine)%displacement, nodes(i), cross(axis, across))
    end do
  end subroutine add_turn
end module rotations_reader

!> Loads: the factor of a table at a time, and what all loads prescribe then (doc/theory, "Loads",
!! eq. (9.1)).
module loads
  use kinds, only: wp
  use model_types, only: model_t, load_t, load_table_t, nodal_values_t, form_sine, form_versine
  implicit none
  private
  public :: load_factor, load_factors, corner_times, turned_angles, has_load, conditions_at, &
    add_displacement, add_force, add_values, append_values, join_load, list_loads

  !> Parts into which a table that is a function of time is divided.
  integer, parameter :: function_parts = 16

contains

  !> Prescribed displacements and applied forces at `time`, all loads added up.
  pure subroutine conditions_at(model, time, displacement, force)
    type(model_t), intent(in) :: model !! loads and their tables
    real(wp), intent(in) :: time !! the time
    real(wp), intent(out), optional :: displacement(:, :) !! (3, nodes) 0 where none is [length]
    real(wp), intent(out), optional :: force(:, :) !! (3, nodes) also where restrained [force]
    real(wp) :: factors(size(model%conditions%loads))
    integer :: k

    factors = load_factors(model, time)
    if (present(displacement)) displacement = 0.0_wp
    if (present(force)) force = 0.0_wp
    do k = 1, size(factors)
      associate (load => model%conditions%loads(k))
        if (present(displacement)) call add_displacement(load, factors(k), displacement)
        if (present(force)) call add_force(load, factors(k), force)
      end associate
    end do
  end subroutine conditions_at

  !> Factors of all loads at `time`.
  pure function load_factors(model, time) result(factors)
    type(model_t), intent(in) :: model !! loads and their tables
    real(wp), intent(in) :: time !! the time
    real(wp) :: factors(size(model%conditions%loads))
    integer :: k

    do k = 1, size(factors)
      associate (load => model%conditions%loads(k))
        factors(k) = load_factor(model%tables, load%table, time)
        if (load%form == form_sine) factors(k) = sin(load%angle*factors(k))
        ! one less the cosine, without cancellation
        if (load%form == form_versine) factors(k) = 2.0_wp*sin(0.5_wp*load%angle*factors(k))**2
      end associate
    end do
  end function load_factors

  !> Angles of the rotations at `time`, 0 for other loads.
  pure function turned_angles(model, time) result(angles)
    type(model_t), intent(in) :: model !! loads and their tables
    real(wp), intent(in) :: time !! the time
    real(wp) :: angles(size(model%conditions%loads))
    integer :: k

    angles = [(model%conditions%loads(k)%angle*load_factor(model%tables, &
      model%conditions%loads(k)%table, time), k=1, size(angles))]
  end function turned_angles

  !> Times at which tables have their corners; functions are divided.
  pure subroutine corner_times(tables, times)
    type(load_table_t), intent(in) :: tables(:) !! the proportional loads
    real(wp), allocatable, intent(out) :: times(:) !! ascending, at least one
    real(wp), allocatable :: all_times(:)
    real(wp) :: latest
    integer :: i, k

    allocate (all_times(1), source=0.0_wp)
    do i = 1, size(tables)
      associate (t => tables(i)%t)
        if (tables(i)%function_form) then
          all_times = [all_times, [(t(1) + (t(2) - t(1))*real(k, wp)/real(function_parts, wp), &
            k=0, function_parts)]]
        else
          all_times = [all_times, t]
        end if
      end associate
    end do
    allocate (times(0))
    latest = minval(all_times) - 1.0_wp
    do while (any(all_times > latest))
      latest = minval(all_times, all_times > latest)
      times = [times, latest]
    end do
  end subroutine corner_times

  !> Adds what a load prescribes.
  pure subroutine add_displacement(load, factor, u)
    type(load_t), intent(in) :: load !! the load
    real(wp), intent(in) :: factor !! its factor
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]

    call scatter(load%displacement, factor, u)
  end subroutine add_displacement

  !> Adds the forces of a load.
  pure subroutine add_force(load, factor, force)
    type(load_t), intent(in) :: load !! the load
    real(wp), intent(in) :: factor !! its factor
    real(wp), intent(inout) :: force(:, :) !! (3, nodes) forces [force]

    call scatter(load%force, factor, force)
  end subroutine add_force

  !> Adds values at their places.
  pure subroutine scatter(values, factor, field)
    type(nodal_values_t), intent(in) :: values !! the values
    real(wp), intent(in) :: factor !! times this
    real(wp), intent(inout) :: field(:, :) !! (3, nodes)
    integer :: j

    do j = 1, values%n
      associate (there => field(values%dof(j), values%node(j)))
        there = there + factor*values%value(j)
      end associate
    end do
  end subroutine scatter

  !> Adds the values of a node to a pattern; zeros are left out.
  pure subroutine add_values(values, node, value)
    type(nodal_values_t), intent(inout) :: values !! gets them
    integer, intent(in) :: node !! the node
    real(wp), intent(in) :: value(3) !! one for each of its degrees of freedom
    integer :: k

    if (.not. allocated(values%value)) allocate (values%node(8), values%dof(8), values%value(8))
    if (values%n + 3 > size(values%value)) call double_room(values)
    do k = 1, 3
      if (abs(value(k)) <= 0.0_wp) cycle
      values%n = values%n + 1
      values%node(values%n) = node
      values%dof(values%n) = k
      values%value(values%n) = value(k)
    end do
  end subroutine add_values

  !> Twice the room.
  pure subroutine double_room(values)
    type(nodal_values_t), intent(inout) :: values !! grows
    type(nodal_values_t) :: more
    integer :: n

    n = values%n
    allocate (more%node(2*n + 8), more%dof(2*n + 8), more%value(2*n + 8))
    more%node(:n) = values%node(:n)
    more%dof(:n) = values%dof(:n)
    more%value(:n) = values%value(:n)
    call move_alloc(more%node, values%node)
    call move_alloc(more%dof, values%dof)
    call move_alloc(more%value, values%value)
  end subroutine double_room

  !> Place of the load with this factor, which is added to the list if there is none.
  pure subroutine join_load(loads, table, place, form, angle)
    type(load_t), allocatable, intent(inout) :: loads(:) !! the list
    integer, intent(in) :: table !! number of a table
    integer, intent(out) :: place !! where it is
    integer, intent(in), optional :: form !! of a rotation
    real(wp), intent(in), optional :: angle !! of a rotation
    type(load_t), allocatable :: more(:)
    type(load_t) :: wanted

    wanted%table = table
    if (present(form)) wanted%form = form
    if (present(angle)) wanted%angle = angle
    do place = 1, size(loads)
      if (loads(place)%table /= table .or. loads(place)%form /= wanted%form) cycle
      if (abs(loads(place)%angle - wanted%angle) <= 0.0_wp) return
    end do
    allocate (more(place))
    more(:place - 1) = loads
    more(place) = wanted
    call move_alloc(more, loads)
  end subroutine join_load

  !> Factor of load `number` at `time`: number 0 is the sum of all tables, 1 if there is none.
  pure real(wp) function load_factor(tables, number, time) result(factor)
    type(load_table_t), intent(in) :: tables(:) !! the proportional loads
    integer, intent(in) :: number !! load number of a degree of freedom
    real(wp), intent(in) :: time !! time
    integer :: i

    factor = 0.0_wp
    if (number == 0 .and. size(tables) == 0) factor = 1.0_wp
    do i = 1, size(tables)
      if (number == 0 .or. tables(i)%number == number) then
        factor = factor + table_factor(tables(i), time)
      end if
    end do
  end function load_factor

  !> Loads from displacements, forces and tables of all degrees of freedom: one for each table, in
  !! the order in which nodes ask for them.
  pure subroutine list_loads(displacement, force, table, loads)
    real(wp), intent(in) :: displacement(:, :) !! (3, nodes) prescribed [length]
    real(wp), intent(in) :: force(:, :) !! (3, nodes) applied [force]
    integer, intent(in) :: table(:, :) !! (3, nodes) numbers of tables
    type(load_t), allocatable, intent(out) :: loads(:) !! the list
    integer :: i, k, place

    allocate (loads(0))
    do i = 1, size(table, 2)
      do k = 1, 3
        if (abs(displacement(k, i)) <= 0.0_wp .and. abs(force(k, i)) <= 0.0_wp) cycle
        call join_load(loads, table(k, i), place)
        call add_values(loads(place)%displacement, i, along(k, displacement(k, i)))
        call add_values(loads(place)%force, i, along(k, force(k, i)))
      end do
    end do
  end subroutine list_loads

  !> Appends one pattern to another.
  pure subroutine append_values(more, values)
    type(nodal_values_t), intent(in) :: more !! what to append
    type(nodal_values_t), intent(inout) :: values !! grows
    integer :: j

    do j = 1, more%n
      call add_values(values, more%node(j), along(more%dof(j), more%value(j)))
    end do
  end subroutine append_values

  !> A vector along axis k.
  pure function along(k, value) result(v)
    integer, intent(in) :: k !! 1, 2 or 3
    real(wp), intent(in) :: value !! its component
    real(wp) :: v(3)

    v = 0.0_wp
    v(k) = value
  end function along

  !> Whether a load number may be used: 0, or the number of a table.
  pure logical function has_load(tables, number)
    type(load_table_t), intent(in) :: tables(:) !! the proportional loads
    integer, intent(in) :: number !! load number

    has_load = number == 0
    if (.not. has_load) has_load = any(tables%number == number)
  end function has_load

  !> Factor of one table at `time`.
  pure real(wp) function table_factor(table, time) result(factor)
    type(load_table_t), intent(in) :: table !! one proportional load
    real(wp), intent(in) :: time !! time

    if (table%function_form) then
      factor = function_factor(table, time)
    else
      factor = interpolated_factor(table%t, table%p, time)
    end if
  end function table_factor

  !> Piecewise linear between the points, constant outside.
  pure real(wp) function interpolated_factor(t, p, time) result(factor)
    real(wp), intent(in) :: t(:) !! (points) ascending times
    real(wp), intent(in) :: p(:) !! (points) factors
    real(wp), intent(in) :: time !! time
    integer :: low, high, middle

    if (time <= t(1)) then
      factor = p(1)
      return
    end if
    if (time >= t(size(t))) then
      factor = p(size(p))
      return
    end if
    low = 1
    high = size(t)
    do while (high - low > 1)
      middle = (low + high)/2
      if (t(middle) <= time) then
        low = middle
      else
        high = middle
      end if
    end do
    factor = p(low) + (p(high) - p(low))*((time - t(low))/(t(high) - t(low)))
  end function interpolated_factor

  !> FEAP's type 1: a0 + a1 s + a2 sin(a3 s + a4)^k with s = t - tmin, inside tmin..tmax, else 0.
  pure real(wp) function function_factor(table, time) result(factor)
    type(load_table_t), intent(in) :: table !! t = tmin, tmax; p = a0 .. a4, k
    real(wp), intent(in) :: time !! time
    real(wp) :: s, margin

    factor = 0.0_wp
    ! A time is a sum of increments: its round-off must not switch the load off at tmax.
    margin = 1.0e-10_wp*max(abs(time), abs(table%t(1)))
    if (time < table%t(1) - margin .or. time > table%t(2) + margin) return
    s = time - table%t(1)
    associate (a => table%p)
      factor = a(1) + a(2)*s + a(3)*sin(a(4)*s + a(5))**nint(a(6))
    end associate
  end function function_factor
end module loads

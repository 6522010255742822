!> Sums over supports and loads that are linear in the contact forces: what the rows of an end time
!! and its audit ask for where no displacements inside are (doc/theory, "Condensed contact").
!!
!! Forces of the sets of reactions (3 each), forces and moments of the supports on each body (6),
!! work of the reactions on what each load prescribes, work of each load's forces, turns of each
!! body (3).
module linear_sums
  use kinds, only: wp
  use vectors, only: cross
  use lapack_interface, only: dsymm, dgemv
  use loads, only: add_displacement, add_force
  use mesh_names, only: find_nodes
  use model_types, only: model_t
  use block_matrix, only: multiply
  use half_solves, only: reduce_columns
  use body_audit, only: measure_bodies
  use system_types, only: system_t, state_t
  implicit none
  private
  public :: can_do_without, form_sums, take_sums, mapped_sums, direct_works, body_rows, &
    reaction_rows, load_rows, turn_rows

  !> More sums than this are not worth it.
  integer, parameter :: most_sums = 300
  !> Sums of a body whose pulls go through its factor together.
  integer, parameter :: most_together = 16
  !> End times from which on sums pay, and sums for each further one: an end time saves a pass
  !! through the factors, `most_together` sums cost about four.
  integer, parameter :: least_spared = 4, sums_of_pass = 4

  !> Pulls of sums on a body.
  type :: pulls_t
    integer :: n = 0 !! how many
    integer, allocatable :: row(:) !! (most) the sum of each
    real(wp), allocatable :: right(:, :) !! (equations, most) the pulls
  end type pulls_t

contains

  !> Force and moment of the supports on a body.
  pure function body_rows(model, body) result(rows)
    type(model_t), intent(in) :: model !! output request
    integer, intent(in) :: body !! the body
    integer :: rows(2)

    rows = 3*size(model%output%reactions) + [6*body - 5, 6*body]
  end function body_rows

  !> Works of the reactions on what a unit of each load prescribes.
  pure function reaction_rows(model, system) result(rows)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer :: rows(2)

    rows = 3*size(model%output%reactions) + 6*system%body%bodies + [1, size(model%conditions%loads)]
  end function reaction_rows

  !> Works of the forces of a unit of each load.
  pure function load_rows(model, system) result(rows)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer :: rows(2)

    rows = reaction_rows(model, system) + size(model%conditions%loads)
  end function load_rows

  !> Turns of a body: the sum of (x - center) x u over its nodes.
  pure function turn_rows(model, system, body) result(rows)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer, intent(in) :: body !! the body
    integer :: rows(2), before(2)

    before = load_rows(model, system)
    rows = before(2) + [3*body - 2, 3*body]
  end function turn_rows

  !> How many sums there are.
  pure integer function count_sums(model, system) result(n)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer :: rows(2)

    rows = turn_rows(model, system, system%body%bodies)
    n = rows(2)
  end function count_sums

  !> Rows and audit of an increment that has converged can do without displacements inside, and
  !! enough end times of the run do for the sums to pay. That depends on deck and state alone, so
  !! that a restart gives the same rows.
  logical function can_do_without(model, system) result(can)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! converged
    integer :: n

    can = system%spared > 0 .and. system%condensed%active
    if (.not. can) return
    can = .not. system%condensed%surface_only .and. system%condensed%rigid%modes == 0 .and. &
      .not. any(system%body%weak) .and. system%tools%border%n == 0 .and. &
      .not. (allocated(system%loads%pressed) .or. allocated(system%loads%spring))
    if (can) can = .not. any(system%equation == 0 .and. abs(system%contact_force) > 0.0_wp)
    n = count_sums(model, system)
    can = can .and. n <= most_sums .and. system%spared >= least_spared + n/sums_of_pass
  end function can_do_without

  !> What contact forces and loads do to each sum.
  subroutine form_sums(model, system)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(inout) :: system !! factors; gets sums of condensed
    real(wp) :: unit(3, model%mesh%nodes), pull(3, model%mesh%nodes), force(3, model%mesh%nodes)
    real(wp), allocatable :: by_load(:, :), by_force(:, :), reach(:), inertia(:, :, :)
    logical, allocatable :: moves(:)
    type(pulls_t) :: pulls(size(system%condensed%bodies))
    integer :: row, k, n, last(2), b

    call measure_bodies(model%mesh%x, system, system%condensed%sums%center, reach, inertia, moves)
    n = count_sums(model, system)
    last = reaction_rows(model, system)
    associate (influence => system%condensed%outer%influence)
      allocate (by_load(n, size(influence, 3)))
      allocate (by_force(system%condensed%n, n), source=0.0_wp)
      do row = 1, n
        call find_unit(model, system, row, unit)
        pull = unit
        if (row <= last(2)) call multiply(system%whole%bulk_matrix, unit, pull)
        do k = 1, size(influence, 3)
          by_load(row, k) = sum(pull*influence(:, :, k))
          if (row > last(2)) cycle
          force = 0.0_wp
          call add_force(model%conditions%loads(k), 1.0_wp, force)
          by_load(row, k) = by_load(row, k) - sum(unit*force)
        end do
        do b = 1, size(pulls)
          call take_pull(system, b, row, pull, pulls(b), by_force)
        end do
      end do
      do b = 1, size(pulls)
        call find_shares(system, b, pulls(b), by_force)
      end do
    end associate
    associate (sums => system%condensed%sums)
      call move_alloc(by_load, sums%by_load)
      call move_alloc(by_force, sums%by_force)
      sums%value = spread(0.0_wp, 1, n)
      sums%known = .true.
    end associate
  end subroutine form_sums

  !> What a sum multiplies each reaction with, or each displacement.
  subroutine find_unit(model, system, row, unit)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! equations, bodies
    integer, intent(in) :: row !! the sum
    real(wp), intent(out) :: unit(:, :) !! (3, nodes)
    integer :: sets, bodies, loads, k

    sets = 3*size(model%output%reactions)
    bodies = system%body%bodies
    loads = size(model%conditions%loads)
    unit = 0.0_wp
    k = row
    if (k <= sets) then
      call add_set(model, (k + 2)/3, 1 + mod(k - 1, 3), unit)
    else if (k <= sets + 6*bodies) then
      k = k - sets - 1
      call add_motion_of(model, system, 1 + k/6, 1 + mod(k, 6), unit)
    else if (k <= sets + 6*bodies + loads) then
      call add_displacement(model%conditions%loads(k - sets - 6*bodies), 1.0_wp, unit)
    else if (k <= sets + 6*bodies + 2*loads) then
      call add_force(model%conditions%loads(k - sets - 6*bodies - loads), 1.0_wp, unit)
      return
    else
      k = k - sets - 6*bodies - 2*loads - 1
      call add_motion_of(model, system, 1 + k/3, 4 + mod(k, 3), unit)
      return
    end if
    where (system%equation > 0) unit = 0.0_wp
  end subroutine find_unit

  !> The nodes of a set of reactions in a direction.
  subroutine add_set(model, set, direction, unit)
    type(model_t), intent(in) :: model !! mesh, output request
    integer, intent(in) :: set !! its number in the request
    integer, intent(in) :: direction !! 1, 2 or 3
    real(wp), intent(inout) :: unit(:, :) !! (3, nodes)
    integer, allocatable :: nodes(:)
    integer :: i
    logical :: found

    call find_nodes(model%mesh, model%output%reactions(set)%s, nodes, found)
    do i = 1, size(nodes)
      unit(direction, nodes(i)) = unit(direction, nodes(i)) + 1.0_wp
    end do
  end subroutine add_set

  !> A rigid motion of a body: along an axis, or about one through its center.
  subroutine add_motion_of(model, system, body, motion, unit)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! bodies
    integer, intent(in) :: body !! the body
    integer, intent(in) :: motion !! 1 to 3 along, 4 to 6 about
    real(wp), intent(inout) :: unit(:, :) !! (3, nodes)
    real(wp) :: axis(3)
    integer :: i

    axis = 0.0_wp
    axis(1 + mod(motion - 1, 3)) = 1.0_wp
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) /= body) cycle
      if (motion <= 3) then
        unit(:, i) = axis
      else
        unit(:, i) = cross(axis, model%mesh%x(:, i) - &
          system%condensed%sums%center(:, body))
      end if
    end do
  end subroutine add_motion_of

  !> Keeps the pull of a sum on a body, if there is one, until there are enough of them.
  subroutine take_pull(system, b, row, pull, pulls, by_force)
    type(system_t), intent(inout) :: system !! bodies of condensed; cost table
    integer, intent(in) :: b !! the body
    integer, intent(in) :: row !! the sum
    real(wp), intent(in) :: pull(:, :) !! (3, nodes) force [as the sum over a length]
    type(pulls_t), intent(inout) :: pulls !! those of the body
    real(wp), intent(inout) :: by_force(:, :) !! (n, sums) gets the shares of those that are due
    integer :: i

    associate (body => system%condensed%bodies(b))
      if (body%m == 0) return
      if (.not. allocated(pulls%right)) allocate (pulls%right(size(body%node), most_together), &
        pulls%row(most_together))
      associate (right => pulls%right(:, pulls%n + 1))
        do i = 1, size(right)
          right(i) = pull(body%direction(i), body%node(i))
        end do
        if (all(abs(right) <= 0.0_wp)) return
      end associate
      pulls%n = pulls%n + 1
      pulls%row(pulls%n) = row
      if (pulls%n == most_together) call find_shares(system, b, pulls, by_force)
    end associate
  end subroutine take_pull

  !> What a unit of force at each candidate of a body does to the sums whose pulls are kept: the
  !! work of a pull on what it moves.
  subroutine find_shares(system, b, pulls, by_force)
    type(system_t), intent(inout) :: system !! bodies of condensed; cost table
    integer, intent(in) :: b !! the body
    type(pulls_t), intent(inout) :: pulls !! those of the body; they go
    real(wp), intent(inout) :: by_force(:, :) !! (n, sums) gets the shares
    real(wp), allocatable :: share(:, :)

    if (pulls%n == 0) return
    associate (body => system%condensed%bodies(b), rows => pulls%row(:pulls%n), &
      last => size(pulls%right, 1))
      call reduce_columns(body%solver, body%m, last, pulls%n, pulls%right, system%costs)
      allocate (share(body%m, pulls%n))
      call dsymm('L', 'L', body%m, pulls%n, -1.0_wp, body%compliance, body%m, &
        pulls%right(last - body%m + 1:, :pulls%n), body%m, 0.0_wp, share, body%m)
      by_force(body%first + 1:body%first + body%m, rows) = share
    end associate
    pulls%n = 0
  end subroutine find_shares

  !> The sums of a converged state from its contact forces.
  subroutine take_sums(system)
    type(system_t), intent(inout) :: system !! gets the values of sums

    call mapped_sums(system, system%condensed%sums%value)
  end subroutine take_sums

  !> The same, handed out.
  subroutine mapped_sums(system, value)
    type(system_t), intent(in) :: system !! forces of contact, factors of the loads
    real(wp), intent(out) :: value(:) !! (sums)

    associate (sums => system%condensed%sums, condensed => system%condensed)
      value = matmul(sums%by_load, condensed%outer%factors)
      if (condensed%n > 0) call dgemv('T', condensed%n, size(value), 1.0_wp, sums%by_force, &
        condensed%n, condensed%bulk%force, 1, 1.0_wp, value, 1)
    end associate
  end subroutine mapped_sums

  !> Works of loads and reactions from displacements inside and reactions, each added up.
  subroutine direct_works(model, system, state, value)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! equations, bodies
    type(state_t), intent(in) :: state !! converged, displacements inside known
    real(wp), intent(inout) :: value(:) !! (sums) gets the works
    real(wp) :: unit(3, model%mesh%nodes)
    integer :: row, r(2), l(2)

    r = reaction_rows(model, system)
    l = load_rows(model, system)
    do row = r(1), l(2)
      call find_unit(model, system, row, unit)
      if (row <= r(2)) then
        value(row) = sum(unit*state%reaction)
      else
        value(row) = sum(unit*state%u)
      end if
    end do
  end subroutine direct_works
end module linear_sums

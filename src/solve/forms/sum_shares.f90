!> What contact forces at the candidates of a body, and loads, do to sums over supports and loads
!! (doc/theory, "Static condensation"). The sums are those of `sum_rows`.
module sum_shares
  use kinds, only: wp
  use vectors, only: cross
  use costs, only: cost_t
  use lapack_interface, only: dgemm, dsymm
  use loads, only: add_displacement, add_force
  use mesh_names, only: find_nodes
  use model_types, only: model_t
  use block_matrix, only: multiply_some, reached_by
  use half_solves, only: reduce_columns, solve_columns
  use body_measures, only: measure_bodies
  use body_volumes, only: add_volume_gradient
  use sum_rows, only: body_rows, reaction_rows, turn_rows, swelling_row, count_sums
  use condensed_types, only: body_sums_t, condensed_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: sums_pay, begin_shares, form_shares, find_unit

  !> More sums than this are not worth it.
  integer, parameter :: most_sums = 300
  !> Sums of a body whose pulls go through its factor together.
  integer, parameter :: most_together = 16
  !> End times from which on sums pay, and sums for each further one: an end time saves a pass
  !! through the factors, `most_together` sums cost about four.
  integer, parameter :: least_spared = 4, sums_of_pass = 4

  !> Pulls are multiples of each other if no entry is off by more than this share of the largest.
  real(wp), parameter :: same_pull = 1.0e-14_wp

  !> Pulls of sums on a body.
  type :: pulls_t
    integer :: n = 0 !! how many
    logical :: shared = .false. !! threads share the work
    integer, allocatable :: row(:) !! (most) the sum of each
    real(wp), allocatable :: right(:, :) !! (equations, most) the pulls
    integer :: at(most_together) = 0 !! the largest entry of each
    integer :: twins = 0 !! sums whose pulls are multiples of one of them
    integer :: twin(most_together) = 0 !! these sums
    integer :: of(most_together) = 0 !! the sum whose multiple each is
    real(wp) :: times(most_together) = 0.0_wp !! by how much
  end type pulls_t

contains

  !> Enough end times of the run can do without displacements inside for sums to pay. That depends
  !! on deck and bodies alone, so that a restart gives the same rows.
  logical function sums_pay(model, system) result(pay)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! supports, bodies
    integer :: n

    pay = system%spared >= least_spared
    if (.not. pay) return
    n = count_sums(model, system)
    pay = system%spared >= least_spared + n/sums_of_pass .and. n <= most_sums .and. .not. &
      any(system%body%motions%n > 0 .or. system%body%floating) .and. system%tools%unknowns == 0 &
      .and. .not. (allocated(system%loads%pressed) .or. allocated(system%loads%spring))
  end function sums_pay

  !> Nothing is known yet of any body.
  subroutine begin_shares(model, system, condensed)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! bodies
    type(condensed_t), intent(inout) :: condensed !! gets center and bodies of sums
    real(wp), allocatable :: reach(:), inertia(:, :, :)
    logical, allocatable :: moves(:)

    associate (sums => condensed%sums)
      if (allocated(sums%bodies)) return
      call measure_bodies(model%mesh%x, system, sums%center, reach, inertia, moves)
      allocate (sums%bodies(system%body%bodies))
    end associate
  end subroutine begin_shares

  !> What contact forces on a body and loads do to each sum through that body.
  subroutine form_shares(model, system, form, b, shared, costs)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! factor, compliance, influence
    type(form_t), intent(inout) :: form !! gets the shares
    integer, intent(in) :: b !! the body
    logical, intent(in) :: shared !! threads share the work
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp), dimension(3, model%mesh%nodes) :: unit, pull
    logical :: own(model%mesh%nodes), has_some
    type(pulls_t) :: pulls
    integer :: row, k, last(2)

    pulls%shared = shared
    own = system%body%node_body == b
    last = reaction_rows(model, system%body)
    associate (influence => form%condensed%outer%influence, shares => form%condensed%sums%bodies(b))
      allocate (shares%by_load(count_sums(model, system), size(influence, 3)), &
        shares%by_force(form%condensed%bodies(b)%m, count_sums(model, system)), source=0.0_wp)
      pull = 0.0_wp
      do row = 1, size(shares%by_load, 1)
        if (all(owner_of(model, system, row) /= [0, b])) cycle
        call find_unit(model, system, form%condensed, row, unit)
        call keep_own(own, unit, has_some)
        if (.not. has_some) cycle
        if (row <= last(2)) then
          call multiply_some(form%whole%bulk_matrix, own .and. &
            reached_by(form%whole%bulk_matrix, unit), unit, pull)
        else
          pull = unit
        end if
        do k = 1, size(influence, 3)
          shares%by_load(row, k) = work_of(own, pull, influence(:, :, k))
        end do
        call take_pull(form%condensed, b, row, pull, pulls, shares, costs)
        pull = 0.0_wp
      end do
      call find_shares(form%condensed, b, pulls, shares, costs)
    end associate
  end subroutine form_shares

  !> What a sum multiplies the nodes of a body with; zero elsewhere.
  pure subroutine keep_own(own, unit, has_some)
    logical, intent(in) :: own(:) !! (nodes) of the body
    real(wp), intent(inout) :: unit(:, :) !! (3, nodes) what it multiplies
    logical, intent(out) :: has_some !! it is not zero everywhere
    integer :: i

    has_some = .false.
    do i = 1, size(own)
      if (own(i)) then
        if (.not. has_some) has_some = any(abs(unit(:, i)) > 0.0_wp)
      else
        unit(:, i) = 0.0_wp
      end if
    end do
  end subroutine keep_own

  !> Work of forces on displacements at the nodes of a body.
  pure real(wp) function work_of(own, force, u) result(work)
    logical, intent(in) :: own(:) !! (nodes) of the body
    real(wp), intent(in) :: force(:, :), u(:, :) !! (3, nodes)
    integer :: i

    work = 0.0_wp
    do i = 1, size(own)
      if (own(i)) work = work + dot_product(force(:, i), u(:, i))
    end do
  end function work_of

  !> The body whose motion a sum is about, 0 if it is about none in particular.
  pure integer function owner_of(model, system, row) result(owner)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! bodies
    integer, intent(in) :: row !! the sum
    integer :: first(2), last(2)

    owner = 0
    first = body_rows(model, 1)
    last = body_rows(model, system%body%bodies)
    if (row >= first(1) .and. row <= last(2)) owner = 1 + (row - first(1))/6
    first = turn_rows(model, system, 1)
    if (row >= first(1)) owner = 1 + (row - first(1))/3
    if (row >= swelling_row(model, system, 1)) owner = row - swelling_row(model, system, 1) + 1
  end function owner_of

  !> Keeps the pull of a sum on a body, if there is one, until there are enough of them.
  subroutine take_pull(condensed, b, row, pull, pulls, shares, costs)
    type(condensed_t), intent(in) :: condensed !! bodies of condensed
    integer, intent(in) :: b !! the body
    integer, intent(in) :: row !! the sum
    real(wp), intent(in) :: pull(:, :) !! (3, nodes) force [as the sum over a length]
    type(pulls_t), intent(inout) :: pulls !! those of the body
    type(body_sums_t), intent(inout) :: shares !! gets the shares of those that are due
    type(cost_t), intent(inout) :: costs !! cost table
    integer :: i
    logical :: has_twin

    associate (body => condensed%bodies(b))
      if (body%m == 0) return
      if (.not. allocated(pulls%right)) allocate (pulls%right(size(body%node), most_together), &
        pulls%row(most_together))
      associate (right => pulls%right(:, pulls%n + 1))
        do i = 1, size(right)
          right(i) = pull(body%direction(i), body%node(i))
        end do
        if (all(abs(right) <= 0.0_wp)) return
        call find_twin(right, row, pulls, has_twin)
        if (has_twin) return
        pulls%at(pulls%n + 1) = maxloc(abs(right), 1)
      end associate
      pulls%n = pulls%n + 1
      pulls%row(pulls%n) = row
      if (pulls%n == most_together) call find_shares(condensed, b, pulls, shares, costs)
    end associate
  end subroutine take_pull

  !> A pull that is a multiple of one that is kept needs no answer of its own: the supports of a
  !! body may be one set of reactions, and move as a whole.
  pure subroutine find_twin(right, row, pulls, found)
    real(wp), intent(in) :: right(:) !! (equations) the pull
    integer, intent(in) :: row !! the sum
    type(pulls_t), intent(inout) :: pulls !! those that are kept; gets a twin
    logical, intent(out) :: found !! it has one
    real(wp) :: times
    integer :: k

    found = .false.
    if (pulls%twins == most_together) return
    do k = 1, pulls%n
      associate (other => pulls%right(:, k))
        times = right(pulls%at(k))/other(pulls%at(k))
        if (all(abs(right - times*other) <= same_pull*abs(times*other(pulls%at(k))))) exit
      end associate
    end do
    found = k <= pulls%n
    if (.not. found) return
    pulls%twins = pulls%twins + 1
    pulls%twin(pulls%twins) = row
    pulls%of(pulls%twins) = pulls%row(k)
    pulls%times(pulls%twins) = times
  end subroutine find_twin

  !> What a unit of force at each candidate of a body does to the sums whose pulls are kept: the
  !! work of a pull on what it moves.
  subroutine find_shares(condensed, b, pulls, shares, costs)
    type(condensed_t), intent(in) :: condensed !! bodies of condensed
    integer, intent(in) :: b !! the body
    type(pulls_t), intent(inout) :: pulls !! those of the body; they go
    type(body_sums_t), intent(inout) :: shares !! gets the shares
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp), allocatable :: share(:, :)
    integer :: k

    if (pulls%n == 0) return
    associate (body => condensed%bodies(b), last => size(pulls%right, 1))
      allocate (share(body%m, pulls%n))
      if (body%tree%used) then
        call solve_columns(body%solver, pulls%right(:, :pulls%n), costs)
        share = -pulls%right(body%equation, :pulls%n)
      else
        call reduce_columns(body%solver, body%m, last, pulls%n, pulls%shared, pulls%right, costs)
        call take_moves(body%m, pulls%n, body%compliance, pulls%right(last - body%m + 1:, &
          :pulls%n), pulls%shared, share)
      end if
      shares%by_force(:, pulls%row(:pulls%n)) = share
    end associate
    do k = 1, pulls%twins
      shares%by_force(:, pulls%twin(k)) = pulls%times(k)*shares%by_force(:, pulls%of(k))
    end do
    pulls%twins = 0
    pulls%n = 0
  end subroutine find_shares

  !> y = -C x, the upper rows and the lower ones by two threads if they share the work.
  subroutine take_moves(n, columns, c, x, shared, y)
    integer, intent(in) :: n, columns !! rows and columns of x
    real(wp), intent(in) :: c(n, n) !! a symmetric matrix; its lower triangle counts
    real(wp), intent(in) :: x(n, columns) !! several vectors
    logical, intent(in) :: shared !! threads share the work
    real(wp), intent(out) :: y(n, columns) !! the products
    integer :: half

    if (.not. shared) then
      call dsymm('L', 'L', n, columns, -1.0_wp, c, n, x, n, 0.0_wp, y, n)
      return
    end if
    half = n/2
    !$omp task default(none) shared(n, columns, half, c, x, y)
    call dsymm('L', 'L', half, columns, -1.0_wp, c, n, x, n, 0.0_wp, y, n)
    call dgemm('T', 'N', half, columns, n - half, -1.0_wp, c(half + 1, 1), n, x(half + 1, 1), n, &
      1.0_wp, y, n)
    !$omp end task
    call dsymm('L', 'L', n - half, columns, -1.0_wp, c(half + 1, half + 1), n, x(half + 1, 1), n, &
      0.0_wp, y(half + 1, 1), n)
    call dgemm('N', 'N', n - half, columns, half, -1.0_wp, c(half + 1, 1), n, x, n, 1.0_wp, &
      y(half + 1, 1), n)
    !$omp taskwait
  end subroutine take_moves

  !> What a sum multiplies each reaction with, or each displacement.
  subroutine find_unit(model, system, condensed, row, unit)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! equations, bodies
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
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
      call add_motion_of(model, system, condensed, 1 + k/6, 1 + mod(k, 6), unit)
    else if (k <= sets + 6*bodies + loads) then
      call add_displacement(model%conditions%loads(k - sets - 6*bodies), 1.0_wp, unit)
    else if (k <= sets + 6*bodies + 2*loads) then
      call add_force(model%conditions%loads(k - sets - 6*bodies - loads), 1.0_wp, unit)
      return
    else if (k >= swelling_row(model, system, 1)) then
      call add_volume_gradient(model%mesh%x, system, k - swelling_row(model, system, 1) + 1, unit)
      return
    else
      k = k - sets - 6*bodies - 2*loads - 1
      call add_motion_of(model, system, condensed, 1 + k/3, 4 + mod(k, 3), unit)
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
  subroutine add_motion_of(model, system, condensed, body, motion, unit)
    type(model_t), intent(in) :: model !! mesh
    type(system_t), intent(in) :: system !! bodies
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
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
        unit(:, i) = cross(axis, model%mesh%x(:, i) - condensed%sums%center(:, body))
      end if
    end do
  end subroutine add_motion_of
end module sum_shares

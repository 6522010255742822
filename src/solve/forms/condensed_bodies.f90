!> The bodies of a condensed system: all of them condensed, numbered and loaded (doc/theory, "Static
!! condensation").
module condensed_bodies
  use kinds, only: wp
  use memory, only: memory_left
  use threads, only: count_threads
  use costs, only: cost_t, add_costs
  use loads, only: add_displacement, add_force
  use model_types, only: model_t
  use ordered_blocks, only: ordered_blocks_t
  use block_matrix, only: multiply
  use back_ends, only: solver_done, solver_out_of_memory
  use cholmod_solver, only: factor_work
  use condensed_types, only: condensed_t, body_sums_t
  use condensed_motions, only: fix_body, find_ways, push_bodies, place_modes
  use condensation, only: prepare_body, factorise_body, form_compliance, solve_body, shrink_body, &
    take_shift_out, drop_live, free_body, is_worth_sharing, needed_bytes
  use sum_shares, only: sums_pay, begin_shares, form_shares
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: condense_all, foresee_body, begin_influence, number_candidates, load_candidates, &
    free_condensed

  !> A factor that takes more is changed to single precision though no other body follows [byte].
  real(wp), parameter :: bytes_for_single = 1.0e9_wp
  !> Threads begin to share the largest factor at this part of the share that is foreseen: what is
  !! shared too early costs little, a thread that waits all of its time.
  real(wp), parameter :: early = 0.7_wp

contains

  !> Condenses the bodies that are marked, one after the other: what a body needs its factor for is
  !! done before the next one has its own. Several threads take one body each.
  subroutine condense_all(system, form, wanted, outcome, model)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets the bodies of condensed
    logical, intent(in) :: wanted(:) !! (bodies) those to condense
    integer, intent(out) :: outcome !! as in back_ends
    type(model_t), intent(in), optional :: model !! the influence of its loads is wanted
    integer :: b, k, outcomes(system%body%bodies), order(system%body%bodies), failures, failed, &
      threads
    type(ordered_blocks_t) :: matrices(system%body%bodies)
    type(cost_t) :: own(system%body%bodies)
    logical :: ready(system%body%bodies), little
    real(wp) :: promised, needed
    real(wp) :: shared_from(system%body%bodies)

    threads = count_threads()
    outcomes = solver_done
    ready = .false.
    promised = 0.0_wp
    failures = 0
    little = .false.
    if (present(model)) little = asks_little(model, system)
    if (little) call begin_shares(model, system, form%condensed)
    call sort_bodies(system, order, shared_from)
    !$omp parallel do schedule(dynamic, 1) default(none) private(b, needed, failed) &
    !$omp& shared(system, form, wanted, order, ready, matrices, little, own, outcomes, promised, &
    !$omp& model, shared_from, failures, threads) &
    !$omp& if(threads > 1)
    do k = 1, size(order)
      b = order(k)
      needed = 0.0_wp
      !$omp atomic read
      failed = failures
      if (wanted(b) .and. failed == 0) call begin_body(system, form, b, matrices(b), promised, &
        needed, ready(b), own(b), outcomes(b))
      if (ready(b)) call finish_body(system, form, b, matrices(b), little, k <= size(order) - &
        threads, shared_from(b), own(b), outcomes(b), model)
      if (outcomes(b) /= solver_done) then
        !$omp atomic
        failures = failures + 1
      end if
      !$omp atomic
      promised = promised - needed
    end do
    !$omp end parallel do
    do b = 1, system%body%bodies
      call add_costs(form%costs, own(b))
    end do
    outcome = maxval(outcomes)
  end subroutine condense_all

  !> Numbers and orders the equations of a body, analyses its matrix, and looks whether the factor
  !! fits into the memory.
  subroutine begin_body(system, form, b, matrix, promised, needed, ready, costs, outcome)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets a body of condensed
    integer, intent(in) :: b !! the body
    type(ordered_blocks_t), intent(inout) :: matrix !! gets its columns
    real(wp), intent(inout) :: promised !! memory of all factors that are being made [byte]
    real(wp), intent(out) :: needed !! of this one [byte]
    logical, intent(out) :: ready !! there is something to factorise
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    integer :: equation(3, size(system%body%node_body)), queue(size(system%body%node_body)), i
    real(wp) :: in_all

    outcome = solver_done
    needed = 0.0_wp
    if (allocated(form%condensed%sums%bodies)) form%condensed%sums%bodies(b) = body_sums_t()
    call number_equations(system, b, equation)
    ready = any(equation /= 0)
    if (.not. ready) return
    call fix_body(system, form%condensed, b)
    queue = 0
    do i = 1, size(queue)
      if (form%condensed%candidate(i) .and. any(equation(:, i) > 0)) queue(i) = maxval(queue) + 1
    end do
    call prepare_body(form%whole%bulk_matrix, equation, queue, &
      form%condensed%bodies(b), may_be_tree(system, b), matrix, costs, outcome)
    if (outcome == solver_done .and. is_shifted(form%condensed)) &
      matrix%doubled(form%condensed%bodies(b)%equation) = .true.
    if (outcome == solver_done) needed = needed_bytes(form%condensed%bodies(b))
    !$omp atomic capture
    promised = promised + needed
    in_all = promised
    !$omp end atomic
    if (outcome == solver_done) then
      if (in_all > memory_left()) outcome = solver_out_of_memory
    end if
    ready = outcome == solver_done
  end subroutine begin_body

  !> What a body will cost, by the analysis of its matrix, which goes again.
  subroutine foresee_body(system, form, b, needed, work, entries, m)
    type(system_t), intent(in) :: system !! bodies and candidates of condensed
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    integer, intent(in) :: b !! the body
    real(wp), intent(out) :: needed !! memory of factor and compliance [byte]
    real(wp), intent(out) :: work !! products and sums of the factor and of the compliance
    real(wp), intent(out) :: entries !! of the factor
    integer, intent(out) :: m !! rows of a dense compliance; 0 where the factor stands in for it
    type(ordered_blocks_t) :: matrix
    type(cost_t) :: costs
    real(wp) :: promised
    logical :: ready
    integer :: outcome

    work = 0.0_wp
    entries = 0.0_wp
    m = 0
    promised = 0.0_wp
    call begin_body(system, form, b, matrix, promised, needed, ready, costs, outcome)
    associate (body => form%condensed%bodies(b))
      if (needed > 0.0_wp) call factor_work(body%solver, work, entries)
      if (needed > 0.0_wp .and. .not. body%tree%used) m = body%m
      work = work + 2.0_wp/3.0_wp*real(m, wp)**3
      call free_body(body)
    end associate
  end subroutine foresee_body

  !> Products with the compliance of a body are all that is asked of it: its bulk is linear,
  !! supports hold it, and neither a study nor derivatives ask for more.
  pure logical function may_be_tree(system, b) result(may)
    type(system_t), intent(in) :: system !! what is asked for
    integer, intent(in) :: b !! the body

    may = system%bulk%linear .and. system%body%motions(b)%n == 0 .and. .not. &
      (system%whole_factors .or. system%slopes_due)
  end function may_be_tree

  !> The bodies in the order of their nodes, the one with the most first: what it gives back when it
  !! is done serves the others. Once these are done as well, threads have nothing else to do than
  !! to share it. Work goes with the square of the nodes; it is foreseen from these alone, so that
  !! the same products are formed in each run.
  subroutine sort_bodies(system, order, shared_from)
    type(system_t), intent(in) :: system !! bodies
    integer, intent(out) :: order(:) !! (bodies) their numbers
    real(wp), intent(out) :: shared_from(:) !! (bodies) share of each factor from where on threads
    !! share it, 1 for never
    integer :: nodes(system%body%bodies), b, k, threads

    nodes = 0
    do k = 1, size(system%body%node_body)
      b = system%body%node_body(k)
      if (b > 0) nodes(b) = nodes(b) + 1
    end do
    shared_from = 1.0_wp
    threads = count_threads()
    if (threads > 1 .and. size(nodes) > 0) then
      associate (squares => real(nodes, wp)**2, largest => maxloc(nodes, 1))
        shared_from(largest) = min(1.0_wp, early*(sum(squares) - squares(largest)) &
          /(real(threads - 1, wp)*max(1.0_wp, squares(largest))))
      end associate
    end if
    do k = 1, size(order)
      order(k) = maxloc(nodes, 1)
      nodes(order(k)) = -1
    end do
  end subroutine sort_bodies

  !> Numbers the free degrees of freedom of a body.
  pure subroutine number_equations(system, b, equation)
    type(system_t), intent(in) :: system !! equations, bodies
    integer, intent(in) :: b !! the body
    integer, intent(out) :: equation(:, :) !! (3, nodes) 0 elsewhere
    integer :: i, k, n

    equation = 0
    n = 0
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) /= b) cycle
      do k = 1, 3
        if (system%equation(k, i) == 0) cycle
        n = n + 1
        equation(k, i) = n
      end do
    end do
  end subroutine number_equations

  !> Factor, influence of the loads and compliance of a body.
  subroutine finish_body(system, form, b, matrix, little, gives, shared_from, costs, outcome, model)
    type(system_t), intent(in) :: system !! its body of condensed is prepared
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    integer, intent(in) :: b !! the body
    type(ordered_blocks_t), intent(inout) :: matrix !! its matrix; goes
    logical, intent(in) :: little !! displacements inside will seldom be asked for
    logical, intent(in) :: gives !! what its factor gives back serves others
    real(wp), intent(in) :: shared_from !! share of its factor from where on threads share it
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    type(model_t), intent(in), optional :: model !! the influence of its loads is wanted
    real(wp) :: from
    logical :: large

    from = merge(shared_from, 1.0_wp, is_worth_sharing(form%condensed%bodies(b)))
    call factorise_body(form%whole%bulk_matrix, matrix, form%condensed%bodies(b), &
      .not. (system%bulk%linear .or. form%condensed%exact), costs, outcome, from)
    if (outcome == solver_done .and. present(model)) call find_influence(model, system, form, b, &
      costs, outcome)
    if (outcome == solver_done) call form_compliance(form%condensed%rigid%x, &
      form%condensed%bodies(b), costs, outcome, from)
    if (outcome == solver_done .and. is_shifted(form%condensed)) call take_shift_out( &
      form%whole%bulk_matrix, form%condensed%bodies(b), outcome)
    if (outcome == solver_done .and. little) then
      call form_shares(model, system, form, b, from < 1.0_wp, costs)
      large = needed_bytes(form%condensed%bodies(b)) > bytes_for_single
      if ((gives .or. large) .and. .not. form%condensed%bodies(b)%tree%used) &
        call shrink_body(form%condensed%bodies(b), max(1.0_wp, system%scale%stiffest))
    end if
  end subroutine finish_body

  !> A tangent that must answer by itself was not positive definite: springs on the candidates make
  !! it so, and are taken out of the compliance.
  pure logical function is_shifted(condensed) result(shifted)
    type(condensed_t), intent(in) :: condensed !! refusals

    shifted = condensed%exact .and. condensed%refusals > 0
  end function is_shifted

  !> Displacements inside will seldom be asked for: sums do at most end times, as they do not where
  !! contact may press on a support.
  logical function asks_little(model, system) result(little)
    type(model_t), intent(in) :: model !! output request, pairs
    type(system_t), intent(in) :: system !! bodies, equations
    logical :: meets(size(system%body%node_body))
    integer :: k

    little = system%bulk%linear .and. .not. system%whole_factors
    if (little) little = sums_pay(model, system)
    if (.not. little) return
    meets = .false.
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (allocated(pair%points%point_nodes)) meets(reshape(pair%points%point_nodes, &
          [size(pair%points%point_nodes)])) = .true.
        if (allocated(pair%points%slave_facets)) meets(reshape(pair%points%slave_facets, &
          [size(pair%points%slave_facets)])) = .true.
        meets(reshape(pair%surface%facets, [size(pair%surface%facets)])) = .true.
      end associate
    end do
    little = .not. any(meets .and. any(system%equation == 0, 1))
  end function asks_little

  !> Prescribed displacements for a unit of each proportional load, and what its forces do to the
  !! rigid motions.
  subroutine begin_influence(model, system, form)
    type(model_t), intent(in) :: model !! conditions
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets influence and pushes of condensed
    real(wp), allocatable :: force(:, :)
    integer :: k

    allocate (force(3, model%mesh%nodes))
    associate (condensed => form%condensed, loads => model%conditions%loads)
      allocate (condensed%outer%pushes(sum(system%body%motions%n), size(loads)), source=0.0_wp)
      allocate (condensed%outer%influence(3, model%mesh%nodes, size(loads)), source=0.0_wp)
      condensed%rigid%spring = reshape([real(wp) ::], [sum(system%body%motions%n), &
        sum(system%body%motions%n)], [0.0_wp])
      do k = 1, size(loads)
        call add_displacement(loads(k), 1.0_wp, condensed%outer%influence(:, :, k))
        force = 0.0_wp
        call add_force(loads(k), 1.0_wp, force)
        where (system%equation == 0) force = 0.0_wp
        call push_bodies(system%body, form%condensed, force, condensed%outer%pushes(:, k))
      end do
    end associate
  end subroutine begin_influence

  !> Displacements of a body for a unit of each proportional load, no contact. Other bodies may be
  !! at it at the same time.
  subroutine find_influence(model, system, form, b, costs, outcome)
    type(model_t), intent(in) :: model !! conditions
    type(system_t), intent(in) :: system !! factor of the body
    type(form_t), intent(inout) :: form !! gets its part of influence
    integer, intent(in) :: b !! the body
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    real(wp), allocatable :: force(:, :, :), u(:, :), internal(:, :)
    integer :: k

    associate (condensed => form%condensed, loads => model%conditions%loads)
      allocate (force(3, model%mesh%nodes, size(loads)), source=0.0_wp)
      allocate (u(3, model%mesh%nodes), internal(3, model%mesh%nodes))
      do k = 1, size(loads)
        u = 0.0_wp
        call add_displacement(loads(k), 1.0_wp, u)
        where (system%equation > 0) u = 0.0_wp
        call add_force(loads(k), 1.0_wp, force(:, :, k))
        call multiply(form%whole%bulk_matrix, u, internal)
        force(:, :, k) = force(:, :, k) - internal
      end do
      call solve_body(condensed%bodies(b), force, condensed%outer%influence, costs, outcome)
      if (outcome == solver_done .and. condensed%exact .and. allocated(system%loads%spring)) &
        call find_ways(form, b, sum(system%body%motions(:b - 1)%n), force, costs, outcome)
    end associate
  end subroutine find_influence

  !> Numbers the candidates body after body; forces and defects start at zero.
  subroutine number_candidates(condensed)
    type(condensed_t), intent(inout) :: condensed !! bodies of condensed given
    integer :: b, j, n

    condensed%place = 0
    n = 0
    do b = 1, size(condensed%bodies)
      condensed%bodies(b)%first = n
      n = n + condensed%bodies(b)%m
    end do
    condensed%n = n
    condensed%alive%n_live = 0
    condensed%alive%live = [integer ::]
    condensed%node = spread(0, 1, n)
    condensed%direction = condensed%node
    condensed%alive%live_place = condensed%node
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        body%n_live = 0
        call drop_live(body)
        do j = 1, body%m
          n = body%first + j
          condensed%node(n) = body%node(body%equation(j))
          condensed%direction(n) = body%direction(body%equation(j))
          condensed%place(condensed%direction(n), condensed%node(n)) = n
        end do
      end associate
    end do
    if (allocated(condensed%bulk%product_of)) deallocate (condensed%bulk%product_of)
    condensed%outer%loaded = spread(0.0_wp, 1, condensed%n)
    condensed%bulk%force = condensed%outer%loaded
    condensed%bulk%force_change = condensed%outer%loaded
    condensed%bulk%defect = condensed%outer%loaded
    call place_modes(condensed)
  end subroutine number_candidates

  !> Displacements of the candidates without contact.
  subroutine load_candidates(condensed)
    type(condensed_t), intent(inout) :: condensed !! factors given; gets loaded
    integer :: i

    do i = 1, condensed%n
      condensed%outer%loaded(i) = dot_product(condensed%outer%factors, &
        condensed%outer%influence(condensed%direction(i), condensed%node(i), :))
    end do
  end subroutine load_candidates

  !> Releases all factors.
  subroutine free_condensed(condensed)
    type(condensed_t), intent(inout) :: condensed !! condensed is emptied
    integer :: b

    if (.not. allocated(condensed%bodies)) return
    do b = 1, size(condensed%bodies)
      call free_body(condensed%bodies(b))
    end do
    condensed = condensed_t()
  end subroutine free_condensed
end module condensed_bodies

!> The condensed form of a system: start and extension of the candidates, live candidates, forces
!! of the iterate, and the way back to all nodes (doc/theory, "Condensed contact").
module condensed_system
  use kinds, only: wp
  use elmlib, only: routine_none
  use lapack_interface, only: dsymv
  use loads, only: load_factor
  use model_types, only: model_t
  use block_matrix, only: multiply
  use umfpack_solver, only: solver_done, solver_out_of_memory
  use cholmod_solver, only: solver_not_definite
  use condensed_types, only: condensed_t
  use condensation, only: condense_body, solve_body, free_body
  use candidates, only: load_patterns, foresee_candidates, add_ring
  use system_types, only: system_t, state_t
  implicit none
  private
  public :: start_condensed, begin_condensed, place_starts, couple_condensed, restore_forces, &
    find_defects, refresh_candidates, gather_condensed, take_condensed, recover_interior, &
    apply_compliance, keep_forces, free_condensed

contains

  !> Condenses the system, or says why it cannot be.
  subroutine start_condensed(model, system, why)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(inout) :: system !! gets condensed
    character(:), allocatable, intent(out) :: why !! why not; empty if it is done
    integer :: outcome

    why = ''
    if (system%equations == 0) why = 'there are no unknowns'
    if (any(system%weak)) why = 'a body is held by contact alone'
    if (len(why) > 0) return
    associate (condensed => system%condensed)
      call load_patterns(model, condensed%patterns)
      if (.not. allocated(condensed%candidate)) then
        allocate (condensed%candidate(model%mesh%nodes), source=.false.)
        call foresee_candidates(model, system, condensed%patterns, condensed%candidate)
        where (.not. any(system%equation > 0, 1)) condensed%candidate = .false.
      end if
      call list_facets(model, condensed%facets)
      if (.not. allocated(condensed%kept)) condensed%kept = system%contact_force
      allocate (condensed%bodies(system%bodies), condensed%place(3, model%mesh%nodes))
      call condense_all(system, spread(.true., 1, system%bodies), outcome)
      if (outcome == solver_done) call find_influence(model, system, outcome)
    end associate
    if (outcome /= solver_done) then
      why = 'its factorisation failed'
      if (outcome == solver_not_definite) why = 'the stiffness of a body is not positive definite'
      if (outcome == solver_out_of_memory) why = 'its factors need more memory than there is'
      call free_condensed(system)
      return
    end if
    call number_candidates(system)
    system%condensed%active = .true.
  end subroutine start_condensed

  !> Condenses the bodies that are marked.
  subroutine condense_all(system, wanted, outcome)
    type(system_t), intent(inout) :: system !! gets the bodies of condensed
    logical, intent(in) :: wanted(:) !! (bodies) those to condense
    integer, intent(out) :: outcome !! as in cholmod_solver
    integer, allocatable :: equation(:, :)
    integer :: b, i, k, n

    outcome = solver_done
    allocate (equation(3, size(system%node_body)))
    do b = 1, system%bodies
      if (.not. wanted(b)) cycle
      equation = 0
      n = 0
      do i = 1, size(system%node_body)
        if (system%node_body(i) /= b) cycle
        do k = 1, 3
          if (system%equation(k, i) == 0) cycle
          n = n + 1
          equation(k, i) = n
        end do
      end do
      if (n == 0) cycle
      call condense_body(system%bulk_matrix, equation, system%condensed%candidate, &
        system%condensed%bodies(b), system%costs, outcome)
      if (outcome /= solver_done) return
    end do
  end subroutine condense_all

  !> Displacements for a unit of each proportional load, no contact.
  subroutine find_influence(model, system, outcome)
    type(model_t), intent(in) :: model !! conditions
    type(system_t), intent(inout) :: system !! bodies of condensed given; gets influence
    integer, intent(out) :: outcome !! as in cholmod_solver
    real(wp), allocatable :: force(:, :)
    integer :: k

    outcome = solver_done
    allocate (force(3, model%mesh%nodes))
    associate (condensed => system%condensed, conditions => model%conditions)
      allocate (condensed%influence(3, model%mesh%nodes, size(condensed%patterns)), source=0.0_wp)
      do k = 1, size(condensed%patterns)
        associate (u => condensed%influence(:, :, k), mine => conditions%load == &
          condensed%patterns(k))
          where (system%equation == 0 .and. mine) u = conditions%displacement
          call multiply(system%bulk_matrix, u, force)
          force = -force
          where (system%equation > 0 .and. mine) force = force + conditions%force
          call solve_all(system, force, u, outcome)
        end associate
        if (outcome /= solver_done) return
      end do
    end associate
  end subroutine find_influence

  !> Displacements of the free degrees of freedom under forces.
  subroutine solve_all(system, force, u, outcome)
    type(system_t), intent(inout) :: system !! bodies of condensed
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) [length]
    integer, intent(out) :: outcome !! as in cholmod_solver
    integer :: b

    outcome = solver_done
    do b = 1, system%bodies
      if (.not. allocated(system%condensed%bodies(b)%node)) cycle
      call solve_body(system%condensed%bodies(b), force, u, system%costs, outcome)
      if (outcome /= solver_done) return
    end do
  end subroutine solve_all

  !> Numbers the candidates body after body; forces and defects start at zero.
  subroutine number_candidates(system)
    type(system_t), intent(inout) :: system !! bodies of condensed given
    integer :: b, j, n

    associate (condensed => system%condensed)
      condensed%place = 0
      n = 0
      do b = 1, size(condensed%bodies)
        condensed%bodies(b)%first = n
        n = n + condensed%bodies(b)%m
      end do
      condensed%n = n
      condensed%n_live = 0
      condensed%live = [integer ::]
      condensed%node = spread(0, 1, n)
      condensed%direction = condensed%node
      condensed%live_place = condensed%node
      do b = 1, size(condensed%bodies)
        associate (body => condensed%bodies(b))
          body%n_live = 0
          do j = 1, body%m
            n = body%first + j
            condensed%node(n) = body%node(body%equation(j))
            condensed%direction(n) = body%direction(body%equation(j))
            condensed%place(condensed%direction(n), condensed%node(n)) = n
          end do
        end associate
      end do
      condensed%loaded = spread(0.0_wp, 1, condensed%n)
      condensed%force = condensed%loaded
      condensed%force_change = condensed%loaded
      condensed%defect = condensed%loaded
    end associate
  end subroutine number_candidates

  !> Displacements of the candidates without contact at `time`.
  subroutine begin_condensed(model, system, state, time)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(inout) :: system !! gets loaded
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    integer :: i

    associate (condensed => system%condensed)
      condensed%factors = [(load_factor(model%loads, condensed%patterns(i), time), i=1, &
        size(condensed%patterns))]
      condensed%reactions = norm2(state%reaction)
      call load_candidates(condensed)
    end associate
  end subroutine begin_condensed

  !> Displacements of the candidates without contact.
  subroutine load_candidates(condensed)
    type(condensed_t), intent(inout) :: condensed !! factors given; gets loaded
    integer :: i

    do i = 1, condensed%n
      condensed%loaded(i) = dot_product(condensed%factors, &
        condensed%influence(condensed%direction(i), condensed%node(i), :))
    end do
  end subroutine load_candidates

  !> Displacements of all candidates in equilibrium with the forces of the iterate.
  function equilibrium(condensed) result(u)
    type(condensed_t), intent(in) :: condensed !! loaded and force given
    real(wp), allocatable :: u(:)
    integer :: b, j

    u = condensed%loaded
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        do j = 1, body%m
          if (abs(condensed%force(body%first + j)) <= 0.0_wp) cycle
          u(body%first + 1:body%first + body%m) = u(body%first + 1:body%first + body%m) &
            - condensed%force(body%first + j)*body%compliance(:, j)
        end do
      end associate
    end do
  end function equilibrium

  !> Two starts at the candidates: where they were, and in equilibrium with the forces of the last
  !! state under the new loads. Other nodes are carried along.
  subroutine place_starts(system)
    type(system_t), intent(inout) :: system !! left and carried given; both are completed
    real(wp), allocatable :: u(:)
    integer :: i

    where (system%condensed%place == 0) system%left = system%carried
    call restore_forces(system%condensed)
    u = equilibrium(system%condensed)
    do i = 1, system%condensed%n
      system%carried(system%condensed%direction(i), system%condensed%node(i)) = u(i)
    end do
  end subroutine place_starts

  !> The forces of the last state.
  subroutine restore_forces(condensed)
    type(condensed_t), intent(inout) :: condensed !! gets force
    integer :: i

    do i = 1, condensed%n
      condensed%force(i) = condensed%kept(condensed%direction(i), condensed%node(i))
    end do
  end subroutine restore_forces

  !> How far u is from equilibrium with the forces of the iterate.
  subroutine find_defects(system)
    type(system_t), intent(inout) :: system !! u given; gets defect
    real(wp), allocatable :: u(:)
    integer :: i

    associate (condensed => system%condensed)
      u = equilibrium(condensed)
      do i = 1, condensed%n
        condensed%defect(i) = u(i) - system%u(condensed%direction(i), condensed%node(i))
      end do
      call measure_defects(condensed)
      condensed%norm_before = 0.0_wp
    end associate
  end subroutine find_defects

  !> The forces that would hold the defects of the live candidates, each by itself.
  subroutine measure_defects(condensed)
    type(condensed_t), intent(inout) :: condensed !! gets defect_norm
    integer :: b, i

    condensed%defect_norm = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        do i = 1, body%m
          if (condensed%live_place(body%first + i) == 0) cycle
          condensed%defect_norm = hypot(condensed%defect_norm, &
            condensed%defect(body%first + i)/body%compliance(i, i))
        end do
      end associate
    end do
  end subroutine measure_defects

  !> All facets of all pairs.
  subroutine list_facets(model, facets)
    type(model_t), intent(in) :: model !! pairs
    integer, allocatable, intent(out) :: facets(:, :) !! (3, facets) corner nodes
    integer :: k, n

    n = 0
    do k = 1, size(model%pairs)
      n = n + size(model%pairs(k)%facets, 2)
    end do
    allocate (facets(3, n))
    n = 0
    do k = 1, size(model%pairs)
      facets(:, n + 1:n + size(model%pairs(k)%facets, 2)) = model%pairs(k)%facets
      n = n + size(model%pairs(k)%facets, 2)
    end do
  end subroutine list_facets

  !> Moves the candidates that no iteration has moved to where the forces of the iterate put them.
  subroutine refresh_candidates(system)
    type(system_t), intent(inout) :: system !! u of candidates that are not live
    real(wp), allocatable :: u(:)
    integer :: i

    associate (condensed => system%condensed)
      u = equilibrium(condensed)
      do i = 1, condensed%n
        if (condensed%live_place(i) > 0) cycle
        system%u(condensed%direction(i), condensed%node(i)) = u(i) - condensed%defect(i)
      end do
    end associate
  end subroutine refresh_candidates

  !> Makes sure that every node of a contact element is a candidate, and gathers the compliance of
  !! the live ones.
  subroutine couple_condensed(system)
    type(system_t), intent(inout) :: system !! condensed follows the contact elements
    logical, allocatable :: live(:)
    integer :: k, i, a, n

    call extend_candidates(system)
    associate (condensed => system%condensed, list => system%contact)
      live = abs(condensed%force) > 0.0_wp
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        do a = 1, list%nel(k)
          do i = 1, 3
            n = condensed%place(i, list%ix(a, k))
            if (n > 0) live(n) = .true.
          end do
        end do
      end do
      if (all(live .eqv. condensed%live_place > 0) .and. allocated(condensed%right)) return
      system%du = 0.0_wp
      condensed%live = pack([(i, i=1, condensed%n)], live)
      condensed%n_live = size(condensed%live)
      condensed%live_place = 0
      condensed%live_place(condensed%live) = [(i, i=1, condensed%n_live)]
      call gather_compliance(condensed)
      call measure_defects(condensed)
    end associate
  end subroutine couple_condensed

  !> Compliance of the live candidates of each body.
  subroutine gather_compliance(condensed)
    type(condensed_t), intent(inout) :: condensed !! live given
    integer, allocatable :: mine(:)
    integer :: b, j, first

    first = 0
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        mine = pack(condensed%live, condensed%live > body%first .and. &
          condensed%live <= body%first + body%m) - body%first
        body%first_live = first
        body%n_live = size(mine)
        first = first + body%n_live
        if (allocated(body%live)) deallocate (body%live)
        allocate (body%live(body%n_live, body%n_live))
        do j = 1, body%n_live
          body%live(:, j) = body%compliance(mine, mine(j))
        end do
      end associate
    end do
    condensed%right = spread(0.0_wp, 1, condensed%n_live)
    condensed%change = condensed%right
  end subroutine gather_compliance

  !> Condenses anew the bodies of which contact has reached nodes that are not candidates.
  subroutine extend_candidates(system)
    type(system_t), intent(inout) :: system !! condensed may grow
    logical, allocatable :: wanted(:), before(:)
    real(wp), allocatable :: force(:, :), u(:)
    integer :: k, a, i, outcome

    associate (condensed => system%condensed, list => system%contact)
      before = condensed%candidate
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        do a = 1, list%nel(k)
          if (any(system%equation(:, list%ix(a, k)) > 0)) condensed%candidate(list%ix(a, k)) = &
            .true.
        end do
      end do
      if (all(before .eqv. condensed%candidate)) return
      call add_ring(condensed%facets, condensed%candidate)
      call add_ring(condensed%facets, condensed%candidate)
      where (.not. any(system%equation > 0, 1)) condensed%candidate = .false.
      wanted = spread(.false., 1, system%bodies)
      do i = 1, size(before)
        if (before(i) .neqv. condensed%candidate(i)) wanted(system%node_body(i)) = .true.
      end do
      allocate (force(3, size(before)), source=0.0_wp)
      do i = 1, condensed%n
        force(condensed%direction(i), condensed%node(i)) = condensed%force(i)
      end do
      call condense_all(system, wanted, outcome)
      condensed%failed = outcome
      if (outcome /= solver_done) return
      call number_candidates(system)
      do i = 1, condensed%n
        condensed%force(i) = force(condensed%direction(i), condensed%node(i))
      end do
      call load_candidates(condensed)
      u = equilibrium(condensed)
      do i = 1, condensed%n
        if (before(condensed%node(i))) then
          condensed%defect(i) = u(i) - system%u(condensed%direction(i), condensed%node(i))
        else
          system%u(condensed%direction(i), condensed%node(i)) = u(i)
        end if
      end do
    end associate
  end subroutine extend_candidates

  !> Residual of the live candidates: what the bulk bears less what the elements give.
  subroutine gather_condensed(system, length)
    type(system_t), intent(inout) :: system !! contact_force given; gets right
    real(wp), intent(in) :: length !! share of the direction
    integer :: i

    system%right = 0.0_wp
    associate (condensed => system%condensed)
      condensed%defect_share = 1.0_wp - length
      do i = 1, condensed%n_live
        associate (c => condensed%live(i))
          condensed%right(i) = condensed%force(c) + length*condensed%force_change(c) &
            - system%contact_force(condensed%direction(c), condensed%node(c))
          system%right(system%equation(condensed%direction(c), condensed%node(c))) = &
            condensed%right(i)
        end associate
      end do
    end associate
  end subroutine gather_condensed

  !> Moves forces and defects along the direction.
  subroutine take_condensed(condensed, length)
    type(condensed_t), intent(inout) :: condensed !! force and defect are moved
    real(wp), intent(in) :: length !! share of the direction

    condensed%force = condensed%force + length*condensed%force_change
    condensed%defect = (1.0_wp - length)*condensed%defect
    condensed%defect_norm = (1.0_wp - length)*condensed%defect_norm
    condensed%defect_share = 1.0_wp
  end subroutine take_condensed

  !> y = C x on the live candidates.
  subroutine apply_compliance(condensed, x, y)
    type(condensed_t), intent(in) :: condensed !! live compliances
    real(wp), intent(in) :: x(:) !! (n_live) [force]
    real(wp), intent(inout) :: y(:) !! (n_live) [length]
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live == 0) cycle
        call dsymv('L', body%n_live, 1.0_wp, body%live, body%n_live, x(body%first_live + 1:), 1, &
          0.0_wp, y(body%first_live + 1:), 1)
      end associate
    end do
  end subroutine apply_compliance

  !> Displacements of all nodes and the forces of the bulk from the forces of the iterate.
  subroutine recover_interior(system)
    type(system_t), intent(inout) :: system !! u of candidates given; gets u, bulk_force
    integer :: i, k, outcome

    associate (condensed => system%condensed)
      system%trial = 0.0_wp
      do i = 1, condensed%n
        system%trial(condensed%direction(i), condensed%node(i)) = -condensed%force(i)
      end do
      system%du = 0.0_wp
      call solve_all(system, system%trial, system%du, outcome)
      do k = 1, size(condensed%patterns)
        system%du = system%du + condensed%factors(k)*condensed%influence(:, :, k)
      end do
      call refresh_candidates(system)
      where (system%equation > 0 .and. condensed%place == 0) system%u = system%du
      system%du = 0.0_wp
      call multiply(system%bulk_matrix, system%u, system%bulk_force)
    end associate
  end subroutine recover_interior

  !> Keeps the contact forces of the converged state.
  subroutine keep_forces(condensed)
    type(condensed_t), intent(inout) :: condensed !! force given; gets kept
    integer :: i

    condensed%kept = 0.0_wp
    do i = 1, condensed%n
      condensed%kept(condensed%direction(i), condensed%node(i)) = condensed%force(i)
    end do
  end subroutine keep_forces

  !> Releases all factors.
  subroutine free_condensed(system)
    type(system_t), intent(inout) :: system !! condensed is emptied
    integer :: b

    if (.not. allocated(system%condensed%bodies)) return
    do b = 1, size(system%condensed%bodies)
      call free_body(system%condensed%bodies(b))
    end do
    system%condensed = condensed_t()
  end subroutine free_condensed
end module condensed_system

!> The start of a pile of bodies under its first load: Newton's method on a coarse model of it finds
!! which joints carry, open and slip (doc/theory, "Start").
module coarse_start
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_coarse
  use element_types, only: element_t, task_residual, status_open
  use elmlib, only: routine_none
  use model_types, only: model_t
  use assembly, only: assemble, element_tangent
  use bulk_products, only: multiply_bulk
  use lapack_interface, only: dgetrf, dgetrs
  use coarse_model, only: coarse_model_t, build_coarse, project_field, project_element, &
    add_force, expand_motions, n_motions
  use increment_start, only: start_here
  use expected_status, only: forget_expected, turned_back, most_single
  use grown_start, only: is_pile
  use monitors, only: monitor_t
  use system_types, only: system_t
  use text, only: to_text
  implicit none
  private
  public :: start_coarsely

  !> Motions of all bodies at most, and their share of the equations: the model's systems are dense,
  !! and are to cost little beside those of the whole.
  integer, parameter :: most_motions = 1200
  real(wp), parameter :: most_share = 0.25_wp
  !> Iterations of the coarse model at most.
  integer, parameter :: most_iterations = 12
  !> It has settled once an iteration changes less than this share of the closed points.
  real(wp), parameter :: settled_share = 0.01_wp
  !> What is not in balance in the end, over that at first: a model that leaves more is of no use.
  real(wp), parameter :: useful = 0.5_wp
  !> The shortest step of a direction is a quarter; shorter ones are looked at.
  real(wp), parameter :: shortest = 0.25_wp
  integer, parameter :: most_halvings = 5

contains

  !> Moves the start to where the coarse model is in balance, or nearly so, if that is of use.
  subroutine start_coarsely(model, system, monitor, found)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! start chosen; u may become a better one
    class(monitor_t), intent(inout) :: monitor !! hears of it
    logical, intent(out) :: found !! u is a better one
    type(coarse_model_t) :: coarse
    real(wp) :: before(3, size(system%u, 2)), norm
    integer :: iterations

    found = .false.
    if (.not. wants_coarse(model, system)) return
    call begin_cost(system%costs, cost_coarse)
    before = system%u
    call build_coarse(model%mesh%x, system, coarse)
    call iterate_coarsely(coarse, model%mesh%x, system, iterations, found)
    system%contact%hold = .false.
    system%contact%slide = .false.
    if (.not. found) then
      system%u = before
      call start_here(model, system, norm)
    end if
    call end_cost(system%costs, cost_coarse)
    if (found) call monitor%detail('  a coarse model of the bodies gives the start: '// &
      to_text(iterations)//' iterations')
  end subroutine start_coarsely

  !> A pile of linear bodies, not too many, that have not pressed each other yet. What they did
  !! before is a better start than what a coarse model makes of it; and in the condensed form an
  !! iteration costs less.
  pure logical function wants_coarse(model, system) result(wants)
    type(model_t), intent(in) :: model !! pairs: last converged points
    type(system_t), intent(in) :: system !! bodies, loads
    integer :: k

    wants = is_pile(system) .and. system%bulk%linear .and. system%tools%border%n == 0 .and. &
      .not. (allocated(system%loads%pressed) .or. system%condensed%active)
    wants = wants .and. real(n_motions*system%body%bodies, wp) <= min(real(most_motions, wp), &
      most_share*real(system%equations, wp))
    do k = 1, size(model%pairs)
      if (wants) wants = all(model%pairs(k)%history%old%status <= status_open)
    end do
  end function wants_coarse

  !> Newton's method on the motions of the bodies, with friction from where they were.
  subroutine iterate_coarsely(coarse, x, system, iterations, found)
    type(coarse_model_t), intent(in) :: coarse !! the motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(inout) :: system !! u is moved; contact elements loaded
    integer, intent(out) :: iterations !! how many
    logical, intent(out) :: found !! it has come to something
    real(wp) :: load(coarse%n), right(coarse%n), way(coarse%n), du(3, size(x, 2)), first
    integer :: before(system%contact%n), changed
    logical :: solved

    call multiply_bulk(system, system%u, du)
    call project_field(coarse, system%loads%external - du, load)
    found = .false.
    first = 0.0_wp
    system%contact%slip_before = 0.0_wp
    do iterations = 1, most_iterations
      system%contact%hold = turned_back(system%contact, 0.0_wp)
      if (iterations >= most_single) system%contact%slide = .true.
      before = system%contact%status
      call find_way(coarse, x, system, load, right, way, solved)
      if (.not. solved) return
      call expand_motions(coarse, way, du)
      if (maxval(abs(du)) > system%scale%facet_size) return
      if (iterations == 1) first = norm2(right)
      call take_step(coarse, x, du, way, right, load, system)
      changed = count(before /= system%contact%status)
      if (iterations > 1 .and. real(changed, wp) <= settled_share* &
        real(count(system%contact%status > status_open), wp)) exit
    end do
    iterations = min(iterations, most_iterations)
    found = norm2(right) <= useful*first
  end subroutine iterate_coarsely

  !> The direction of an iteration.
  subroutine find_way(coarse, x, system, load, right, way, solved)
    type(coarse_model_t), intent(in) :: coarse !! the motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(inout) :: system !! contact elements at u
    real(wp), intent(in) :: load(:) !! (n) loads less what the bulk bears at u [force]
    real(wp), intent(out) :: right(:) !! (n) what is not in balance [force]
    real(wp), intent(out) :: way(:) !! (n) [length]
    logical, intent(out) :: solved !! nothing moves freely
    real(wp) :: a(coarse%n, coarse%n)
    type(element_t) :: e
    integer :: pivot(coarse%n), info, i, k

    right = load
    a = coarse%bulk
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      call element_tangent(system%contact, k, x, system%u, e)
      if (e%status <= status_open) cycle
      associate (nodes => system%contact%ix(1:e%nel, k))
        do i = 1, e%nel
          call add_force(coarse, nodes(i), -e%r(3*i - 2:3*i), right)
        end do
        call project_element(coarse, nodes, e%s, a)
      end associate
    end do
    call forget_expected(system%contact)
    system%contact%slip_before = system%contact%slip
    do i = 1, coarse%n
      ! a motion that is prescribed at all nodes
      if (abs(a(i, i)) <= 0.0_wp) a(i, i) = 1.0_wp
    end do
    way = right
    call dgetrf(coarse%n, coarse%n, a, coarse%n, pivot, info)
    solved = info == 0
    if (solved) call dgetrs('N', coarse%n, 1, a, coarse%n, pivot, way, coarse%n, info)
  end subroutine find_way

  !> Goes along a direction as far as the residual falls.
  subroutine take_step(coarse, x, du, way, right, load, system)
    type(coarse_model_t), intent(in) :: coarse !! the motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: du(:, :) !! (3, nodes) the direction [length]
    real(wp), intent(in) :: way(:) !! (n) the same [length]
    real(wp), intent(inout) :: right(:) !! (n) what is not in balance; in the end there [force]
    real(wp), intent(inout) :: load(:) !! (n) loads less what the bulk bears; moves on [force]
    type(system_t), intent(inout) :: system !! u is moved
    real(wp) :: change(size(load)), now(size(load)), length, best, best_length
    integer :: halving

    change = -matmul(coarse%bulk, way)
    best = huge(1.0_wp)
    best_length = shortest
    length = 1.0_wp
    do halving = 0, most_halvings
      call find_right(coarse, x, system%u + length*du, load + length*change, system, now)
      if (norm2(now) < best) best_length = max(length, shortest)
      best = min(best, norm2(now))
      if (best < norm2(right)) exit
      length = 0.5_wp*length
    end do
    if (length < best_length .or. best >= norm2(right)) call find_right(coarse, x, &
      system%u + best_length*du, load + best_length*change, system, now)
    system%u = system%u + best_length*du
    load = load + best_length*change
    right = now
  end subroutine take_step

  !> What is not in balance at a place.
  subroutine find_right(coarse, x, u, load, system, right)
    type(coarse_model_t), intent(in) :: coarse !! the motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: load(:) !! (n) loads less what the bulk bears there [force]
    type(system_t), intent(inout) :: system !! contact elements
    real(wp), intent(out) :: right(:) !! (n) [force]

    call assemble(system%contact, task_residual, x, u, system%contact_force)
    call project_field(coarse, system%contact_force, right)
    right = load - right
  end subroutine find_right
end module coarse_start

!> The damping on bodies that contact alone holds, where Newton's method has failed without it:
!! steps of implicit Euler of floating bodies (doc/theory, "Continuation", eq. (11.9)).
module pseudo_time
  use kinds, only: wp
  use residuals, only: form_residual, residual_norm, round_off_factor
  use system_types, only: form_t, system_t
  use system_parts, only: bodies_t, rigid_part_t
  implicit none
  private
  public :: begin_pseudo_time, settle_pseudo_step, count_way, let_free, pseudo_patience

  !> With damping an increment has this many times the solves, passes and updates of multipliers.
  integer, parameter :: pseudo_patience = 6

  !> An Euler step is solved for when this share of the damping's force is left.
  real(wp), parameter :: solved = 0.1_wp
  !> Iterations in which it has to be, and what the damping becomes after 1, 2, ... of them.
  integer, parameter :: most_damped_iterations = 8
  real(wp), parameter :: growth(most_damped_iterations) = [0.1_wp, 0.2_wp, 0.3_wp, 0.5_wp, 0.7_wp, &
    1.0_wp, 1.5_wp, 2.0_wp]
  !> What it becomes where a step cannot be solved for, and how much it may grow in all.
  real(wp), parameter :: failed_growth = 10.0_wp, most_damping_growth = 1.0e6_wp
  !> A step whose residual exceeds that after its first iteration by this factor is given up;
  !! damping that was too small by less than this factor is not tried soon again, by which it is
  !! forgotten.
  real(wp), parameter :: getting_worse = 3.0_wp, safety = 3.0_wp, forgetting = 0.8_wp
  !> Share of a facet that a body goes in a step at most.
  real(wp), parameter :: longest_way = 0.5_wp
  !> A body that so many steps on end, each at its longest, have not brought nearer to rest, by this
  !! share of what moves it, glides for ever.
  integer, parameter :: most_steady = 30
  real(wp), parameter :: steady = 1.0e-3_wp
  !> Damping of this share of the bulk's stiffness holds what nothing else does.
  real(wp), parameter :: least_damping = 1.0e-10_wp

contains

  !> The damping at the start of a solve: the first one, unless the last solve was left while a body
  !! was on its way.
  subroutine begin_pseudo_time(u, tools, bulk_force, body, form)
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(in) :: tools !! rigid bodies, as they are there
    real(wp), intent(in) :: bulk_force(:, :) !! (3, nodes) of the iterate [force]
    type(bodies_t), intent(inout) :: body !! gets damping, the place it is measured from
    type(form_t), intent(inout) :: form !! its kind answers

    if (.not. body%step_done) then
      body%damping = body%first_damping
      body%pseudo_step%too_small = 0.0_wp
      body%pseudo_step%at_rest = huge(1.0_wp)
      body%pseudo_step%steady = 0
    end if
    body%step_done = .false.
    if (body%damping > 0.0_wp) call note_center(u, tools, bulk_force, body, form)
  end subroutine begin_pseudo_time

  !> Judges the Euler step after each of its iterations: goes on with it, takes it, or gives it up.
  subroutine settle_pseudo_step(system, form, x, halved, rests, hopeless)
    type(system_t), intent(inout) :: system !! residual formed; gets damping, and its place
    type(form_t), intent(inout) :: form !! its kind answers
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(inout) :: halved !! of a step that is over: it has halved what is out of balance
    logical, intent(out) :: rests !! no step is under way: the residual knows of no damping
    logical, intent(out) :: hopeless !! no damping is large enough, or the body glides for ever
    real(wp) :: norm
    logical :: taken

    hopeless = .false.
    taken = .false.
    rests = system%body%damping <= 0.0_wp .or. system%body%pseudo_step%iterations == 0
    if (rests) return
    norm = residual_norm(system, form)
    associate (pseudo_step => system%body%pseudo_step)
      if (pseudo_step%iterations == 1) pseudo_step%first = norm
      rests = norm <= max(solved*form%kind%damping_norm(system, form), &
        round_off_factor*system%scale%round_off) .and. &
        way_of(system) <= longest_way*system%scale%facet_size
      taken = rests
      if (rests) then
        system%body%step_done = .true.
        pseudo_step%too_small = forgetting*pseudo_step%too_small
        system%body%damping = max(growth(pseudo_step%iterations)*system%body%damping, &
          pseudo_step%too_small, least_damping*system%scale%stiffest)
        call note_center(system%u, system%tools, system%inner%bulk_force, system%body, form)
      else if (is_lost(system, norm)) then
        pseudo_step%too_small = safety*system%body%damping
        system%body%damping = failed_growth*system%body%damping
        hopeless = system%body%damping > most_damping_growth*system%body%first_damping
        call return_to_center(system%body, form, system%u, system%tools, system%inner%bulk_force)
        rests = .true.
      end if
    end associate
    if (.not. rests) return
    call form_residual(system, form, x)
    norm = residual_norm(system, form)
    associate (pseudo_step => system%body%pseudo_step)
      halved = norm <= 0.5_wp*pseudo_step%at_rest
      if (taken) pseudo_step%steady = merge(pseudo_step%steady + 1, 0, &
        abs(norm - pseudo_step%at_rest) <= steady*norm)
      hopeless = hopeless .or. pseudo_step%steady >= most_steady
      pseudo_step%at_rest = norm
    end associate
  end subroutine settle_pseudo_step

  !> The step takes too long, goes too far or leads away from its goal.
  pure logical function is_lost(system, norm) result(lost)
    type(system_t), intent(in) :: system !! pseudo_step, u
    real(wp), intent(in) :: norm !! of the residual

    associate (pseudo_step => system%body%pseudo_step)
      lost = pseudo_step%iterations == most_damped_iterations .or. &
        way_of(system) > longest_way*system%scale%facet_size .or. &
        (pseudo_step%iterations > 1 .and. norm > getting_worse*pseudo_step%first)
    end associate
  end function is_lost

  !> Counts an iteration of the step that is under way.
  subroutine count_way(equations, body, solution, length)
    integer, intent(in) :: equations !! free degrees of freedom
    type(bodies_t), intent(inout) :: body !! connected bodies; gets pseudo_step
    real(wp), intent(in) :: solution(:) !! (equations+unknowns) solution [length]
    real(wp), intent(in) :: length !! share of the direction that was gone

    associate (pseudo_step => body%pseudo_step)
      pseudo_step%iterations = pseudo_step%iterations + 1
      pseudo_step%gone = pseudo_step%gone + length*solution(equations + 1:)
    end associate
  end subroutine count_way

  !> The undamped residual is that of the iterate: the damping is measured from here.
  subroutine note_center(u, tools, bulk_force, body, form)
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(in) :: tools !! rigid bodies, as they are there
    real(wp), intent(in) :: bulk_force(:, :) !! (3, nodes) of the iterate [force]
    type(bodies_t), intent(inout) :: body !! gets pseudo_step
    type(form_t), intent(inout) :: form !! its kind answers
    integer :: b, n

    n = 0
    if (allocated(tools%rigid)) n = size(tools%rigid)
    associate (pseudo_step => body%pseudo_step)
      pseudo_step%iterations = 0
      pseudo_step%u = u
      pseudo_step%gone = spread(0.0_wp, 1, tools%unknowns)
      pseudo_step%pose = reshape([real(wp) :: (tools%rigid(b)%move, tools%rigid(b)%turn, b=1, n)], &
        [3, 4, n])
      pseudo_step%bulk_force = bulk_force
    end associate
    if (associated(form%kind%note_center)) call form%kind%note_center(form, body%damping)
  end subroutine note_center

  !> Back to where the step began.
  subroutine return_to_center(body, form, u, tools, bulk_force)
    type(bodies_t), intent(inout) :: body !! pseudo_step given
    type(form_t), intent(inout) :: form !! its kind answers
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) gets displacements from there [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies: where they were
    real(wp), intent(inout) :: bulk_force(:, :) !! (3, nodes) likewise [force]
    integer :: b

    associate (pseudo_step => body%pseudo_step)
      pseudo_step%iterations = 0
      u = pseudo_step%u
      pseudo_step%gone = 0.0_wp
      do b = 1, size(pseudo_step%pose, 3)
        tools%rigid(b)%move = pseudo_step%pose(:, 1, b)
        tools%rigid(b)%turn = pseudo_step%pose(:, 2:, b)
      end do
      bulk_force = pseudo_step%bulk_force
    end associate
    if (associated(form%kind%return_to_center)) call form%kind%return_to_center(form, &
      body%damping)
  end subroutine return_to_center

  !> No damping any more.
  subroutine let_free(body, form)
    type(bodies_t), intent(inout) :: body !! damping is forgotten
    type(form_t), intent(inout) :: form !! its kind answers

    body%damping = 0.0_wp
    body%first_damping = 0.0_wp
    body%step_done = .false.
    body%pseudo_step%iterations = 0
    if (associated(form%kind%forget_damping)) call form%kind%forget_damping(form)
  end subroutine let_free

  !> The farthest way of a node of a floating body since the step began.
  pure real(wp) function way_of(system) result(way)
    type(system_t), intent(in) :: system !! u, pseudo_step

    way = farthest(system%body, system%u - system%body%pseudo_step%u)
  end function way_of

  !> The largest component of a displacement of floating bodies.
  pure real(wp) function farthest(body, move) result(most)
    type(bodies_t), intent(in) :: body !! bodies
    real(wp), intent(in) :: move(:, :) !! (3, nodes) [length]
    integer :: i

    most = 0.0_wp
    do i = 1, size(move, 2)
      if (body%node_body(i) == 0) cycle
      if (body%floating(body%node_body(i))) most = max(most, maxval(abs(move(:, i))))
    end do
  end function farthest
end module pseudo_time

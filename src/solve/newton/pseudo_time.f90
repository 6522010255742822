!> The damping on bodies that contact alone holds, where Newton's method has failed without it:
!! steps of implicit Euler of floating bodies (doc/theory, "Continuation", eq. (11.9)). The system
!! knows the damping and where it is measured from, and no more of the steps.
module pseudo_time
  use kinds, only: wp
  use condensed_types, only: center_t
  use residuals, only: form_residual, residual_norm, round_off_factor
  use system_types, only: form_t, system_t
  use system_parts, only: bodies_t, rigid_part_t
  implicit none
  private
  public :: pseudo_time_t, begin_pseudo_time, settle_pseudo_step, count_way, let_free, &
    pseudo_patience

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

  !> Steps of pseudo-time within one solve: where the one under way began, how they have gone.
  type :: pseudo_time_t
    real(wp) :: first_damping = 0.0_wp !! damping at the start of a solve, 0: none [force/length]
    logical :: step_done = .false. !! a solve was left while a body with damping was on its way
    integer :: iterations = 0 !! Newton's iterations of the step so far, 0: at rest
    real(wp) :: first = 0.0_wp !! residual after the first of them [force]
    real(wp) :: at_rest = 0.0_wp !! residual norm after the last step, without the damping [force]
    integer :: steady = 0 !! steps on end after which it was the same
    real(wp) :: too_small = 0.0_wp !! damping that has been, or nearly so [force/length]
    type(center_t) :: center !! what the form returns to: where the step began
    real(wp), allocatable :: bulk_force(:, :) !! (3, nodes) there [force]
    real(wp), allocatable :: pose(:, :, :) !! (3, 4, rigid bodies) move and turn there
  end type pseudo_time_t

contains

  !> The damping at the start of a solve: the first one, unless the last solve was left while a body
  !! was on its way.
  subroutine begin_pseudo_time(pseudo_time, u, tools, body, form)
    type(pseudo_time_t), intent(inout) :: pseudo_time !! first_damping given
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(in) :: tools !! rigid bodies, as they are there
    type(bodies_t), intent(inout) :: body !! gets damping, the place it is measured from
    type(form_t), intent(inout) :: form !! its kind answers

    if (.not. pseudo_time%step_done) then
      body%damping = pseudo_time%first_damping
      pseudo_time%too_small = 0.0_wp
      pseudo_time%at_rest = huge(1.0_wp)
      pseudo_time%steady = 0
    end if
    pseudo_time%step_done = .false.
    if (body%damping > 0.0_wp) call note_center(pseudo_time, u, tools, body, form)
  end subroutine begin_pseudo_time

  !> Judges the Euler step after each of its iterations: goes on with it, takes it, or gives it up.
  subroutine settle_pseudo_step(pseudo_time, system, form, x, halved, rests, hopeless)
    type(pseudo_time_t), intent(inout) :: pseudo_time !! the step, and those before
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
    rests = system%body%damping <= 0.0_wp .or. pseudo_time%iterations == 0
    if (rests) return
    norm = residual_norm(system, form)
    if (pseudo_time%iterations == 1) pseudo_time%first = norm
    rests = norm <= max(solved*form%kind%damping_norm(system, form), &
      round_off_factor*system%scale%round_off) .and. &
      way_of(system) <= longest_way*system%scale%facet_size
    taken = rests
    if (rests) then
      pseudo_time%step_done = .true.
      pseudo_time%too_small = forgetting*pseudo_time%too_small
      system%body%damping = max(growth(pseudo_time%iterations)*system%body%damping, &
        pseudo_time%too_small, least_damping*system%scale%stiffest)
      call note_center(pseudo_time, system%u, system%tools, system%body, form)
    else if (is_lost(pseudo_time, system, norm)) then
      pseudo_time%too_small = safety*system%body%damping
      system%body%damping = failed_growth*system%body%damping
      hopeless = system%body%damping > most_damping_growth*pseudo_time%first_damping
      call return_to_center(pseudo_time, system%body, form, system%u, system%tools)
      rests = .true.
    end if
    if (.not. rests) return
    call form_residual(system, form, x)
    norm = residual_norm(system, form)
    halved = norm <= 0.5_wp*pseudo_time%at_rest
    if (taken) pseudo_time%steady = merge(pseudo_time%steady + 1, 0, &
      abs(norm - pseudo_time%at_rest) <= steady*norm)
    hopeless = hopeless .or. pseudo_time%steady >= most_steady
    pseudo_time%at_rest = norm
  end subroutine settle_pseudo_step

  !> The step takes too long, goes too far or leads away from its goal.
  pure logical function is_lost(pseudo_time, system, norm) result(lost)
    type(pseudo_time_t), intent(in) :: pseudo_time !! its iterations
    type(system_t), intent(in) :: system !! u
    real(wp), intent(in) :: norm !! of the residual

    lost = pseudo_time%iterations == most_damped_iterations .or. &
      way_of(system) > longest_way*system%scale%facet_size .or. &
      (pseudo_time%iterations > 1 .and. norm > getting_worse*pseudo_time%first)
  end function is_lost

  !> Counts an iteration of the step that is under way.
  subroutine count_way(pseudo_time, equations, body, solution, length)
    type(pseudo_time_t), intent(inout) :: pseudo_time !! gets iterations
    integer, intent(in) :: equations !! free degrees of freedom
    type(bodies_t), intent(inout) :: body !! gets damped_way
    real(wp), intent(in) :: solution(:) !! (equations+unknowns) solution [length]
    real(wp), intent(in) :: length !! share of the direction that was gone

    pseudo_time%iterations = pseudo_time%iterations + 1
    body%damped_way = body%damped_way + length*solution(equations + 1:)
  end subroutine count_way

  !> The undamped residual is that of the iterate: the damping is measured from here.
  subroutine note_center(pseudo_time, u, tools, body, form)
    type(pseudo_time_t), intent(inout) :: pseudo_time !! gets what returns there
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(in) :: tools !! rigid bodies, as they are there
    type(bodies_t), intent(inout) :: body !! damping given; gets damped_from, damped_way
    type(form_t), intent(inout) :: form !! bulk_force given; its kind answers
    integer :: b, n

    n = 0
    if (allocated(tools%rigid)) n = size(tools%rigid)
    pseudo_time%iterations = 0
    body%damped_from = u
    body%damped_way = spread(0.0_wp, 1, tools%unknowns)
    pseudo_time%pose = reshape([real(wp) :: (tools%rigid(b)%move, tools%rigid(b)%turn, b=1, n)], &
      [3, 4, n])
    pseudo_time%bulk_force = form%inner%bulk_force
    if (associated(form%kind%note_center)) call form%kind%note_center(form, &
      body%damping, pseudo_time%center)
  end subroutine note_center

  !> Back to where the step began.
  subroutine return_to_center(pseudo_time, body, form, u, tools)
    type(pseudo_time_t), intent(inout) :: pseudo_time !! the step, which is over
    type(bodies_t), intent(inout) :: body !! damped_from given
    type(form_t), intent(inout) :: form !! gets bulk_force from there; its kind answers
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) gets displacements from there [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies: where they were
    integer :: b

    pseudo_time%iterations = 0
    u = body%damped_from
    body%damped_way = 0.0_wp
    do b = 1, size(pseudo_time%pose, 3)
      tools%rigid(b)%move = pseudo_time%pose(:, 1, b)
      tools%rigid(b)%turn = pseudo_time%pose(:, 2:, b)
    end do
    form%inner%bulk_force = pseudo_time%bulk_force
    if (associated(form%kind%return_to_center)) call form%kind%return_to_center(form, &
      body%damping, pseudo_time%center)
  end subroutine return_to_center

  !> No damping any more.
  subroutine let_free(pseudo_time, body, form)
    type(pseudo_time_t), intent(inout) :: pseudo_time !! its end
    type(bodies_t), intent(inout) :: body !! damping is forgotten
    type(form_t), intent(inout) :: form !! its kind answers

    body%damping = 0.0_wp
    pseudo_time%first_damping = 0.0_wp
    pseudo_time%step_done = .false.
    pseudo_time%iterations = 0
    if (associated(form%kind%forget_damping)) call form%kind%forget_damping(form)
  end subroutine let_free

  !> The farthest way of a node of a floating body since the step began.
  pure real(wp) function way_of(system) result(way)
    type(system_t), intent(in) :: system !! u, damped_from

    way = farthest(system%body, system%u - system%body%damped_from)
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

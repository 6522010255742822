!> The drag on bodies that contact alone holds, where Newton's method has failed without it: steps
!! of implicit Euler of bodies in honey (doc/theory, "Continuation", eq. (11.9)).
module drag
  use kinds, only: wp
  use residuals, only: form_residual, residual_norm, drag_norm, round_off_factor
  use condensed_motions, only: set_center
  use system_types, only: system_t
  implicit none
  private
  public :: begin_drag, settle_drag, count_way, let_free, drag_patience

  !> With a drag an increment has this many times the solves, passes and updates of multipliers.
  integer, parameter :: drag_patience = 6

  !> An Euler step is solved for when this share of the drag's force is left.
  real(wp), parameter :: solved = 0.1_wp
  !> Iterations in which it has to be, and what the drag becomes after 1, 2, ... of them.
  integer, parameter :: most_iterations = 8
  real(wp), parameter :: growth(most_iterations) = [0.1_wp, 0.2_wp, 0.3_wp, 0.5_wp, 0.7_wp, &
    1.0_wp, 1.5_wp, 2.0_wp]
  !> What it becomes where a step cannot be solved for, and how much it may grow in all.
  real(wp), parameter :: failed_growth = 10.0_wp, most_growth = 1.0e6_wp
  !> A step whose residual exceeds that after its first iteration by this factor is given up; a drag
  !! that was too small by less than this factor is not tried soon again, by which it is forgotten.
  real(wp), parameter :: getting_worse = 3.0_wp, safety = 3.0_wp, forgetting = 0.8_wp
  !> Share of a facet that a body goes in a step at most.
  real(wp), parameter :: longest_way = 0.5_wp
  !> A body that so many steps on end, each at its longest, have not brought nearer to rest, by this
  !! share of what moves it, glides for ever.
  integer, parameter :: most_steady = 30
  real(wp), parameter :: steady = 1.0e-3_wp
  !> A drag of this share of the bulk's stiffness holds what nothing else does.
  real(wp), parameter :: least_drag = 1.0e-10_wp

contains

  !> The drag at the start of a solve: the first one, unless the last solve was left while a body
  !! was on its way.
  subroutine begin_drag(system)
    type(system_t), intent(inout) :: system !! gets drag, the place it is measured from

    if (.not. system%body%adrift) then
      system%body%drag = system%body%first_drag
      system%body%euler%too_small = 0.0_wp
      system%body%euler%at_rest = huge(1.0_wp)
      system%body%euler%steady = 0
    end if
    system%body%adrift = .false.
    if (system%body%drag > 0.0_wp) call note_center(system)
  end subroutine begin_drag

  !> Judges the Euler step after each of its iterations: goes on with it, takes it, or gives it up.
  subroutine settle_drag(system, x, halved, rests, hopeless)
    type(system_t), intent(inout) :: system !! residual formed; gets drag, and its place
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(inout) :: halved !! of a step that is over: it has halved what is out of balance
    logical, intent(out) :: rests !! no step is under way: the residual knows of no drag
    logical, intent(out) :: hopeless !! no drag is large enough, or the body glides for ever
    real(wp) :: norm
    logical :: taken

    hopeless = .false.
    taken = .false.
    rests = system%body%drag <= 0.0_wp .or. system%body%euler%iterations == 0
    if (rests) return
    norm = residual_norm(system)
    associate (euler => system%body%euler)
      if (euler%iterations == 1) euler%first = norm
      rests = norm <= max(solved*drag_norm(system), round_off_factor*system%scale%round_off) .and. &
        way_of(system) <= longest_way*system%scale%facet_size
      taken = rests
      if (rests) then
        system%body%adrift = .true.
        euler%too_small = forgetting*euler%too_small
        system%body%drag = max(growth(euler%iterations)*system%body%drag, euler%too_small, &
          least_drag*system%scale%stiffest)
        call note_center(system)
      else if (is_lost(system, norm)) then
        euler%too_small = safety*system%body%drag
        system%body%drag = failed_growth*system%body%drag
        hopeless = system%body%drag > most_growth*system%body%first_drag
        call return_to_center(system)
        rests = .true.
      end if
    end associate
    if (.not. rests) return
    call form_residual(system, x)
    norm = residual_norm(system)
    associate (euler => system%body%euler)
      halved = norm <= 0.5_wp*euler%at_rest
      if (taken) euler%steady = merge(euler%steady + 1, 0, &
        abs(norm - euler%at_rest) <= steady*norm)
      hopeless = hopeless .or. euler%steady >= most_steady
      euler%at_rest = norm
    end associate
  end subroutine settle_drag

  !> The step takes too long, goes too far or leads away from its goal.
  pure logical function is_lost(system, norm) result(lost)
    type(system_t), intent(in) :: system !! euler, u
    real(wp), intent(in) :: norm !! of the residual

    associate (euler => system%body%euler)
      lost = euler%iterations == most_iterations .or. &
        way_of(system) > longest_way*system%scale%facet_size .or. &
        (euler%iterations > 1 .and. norm > getting_worse*euler%first)
    end associate
  end function is_lost

  !> Counts an iteration of the step that is under way.
  subroutine count_way(system, length)
    type(system_t), intent(inout) :: system !! solution given; gets euler
    real(wp), intent(in) :: length !! share of the direction that was gone

    associate (euler => system%body%euler)
      euler%iterations = euler%iterations + 1
      euler%gone = euler%gone + length*system%solution(system%equations + 1:)
    end associate
  end subroutine count_way

  !> The undamped residual is that of the iterate: the drag is measured from here.
  subroutine note_center(system)
    type(system_t), intent(inout) :: system !! iterate given; gets euler

    associate (euler => system%body%euler)
      euler%iterations = 0
      euler%u = system%u
      euler%gone = spread(0.0_wp, 1, system%tools%border%n)
      if (allocated(system%tools%rigid)) euler%rigid = system%tools%rigid
      euler%bulk_force = system%inner%bulk_force
    end associate
    if (.not. system%condensed%active) return
    call set_center(system%condensed, system%body%drag)
    system%body%euler%bulk = system%condensed%bulk
    system%body%euler%carried = system%condensed%rigid
  end subroutine note_center

  !> Back to where the step began.
  subroutine return_to_center(system)
    type(system_t), intent(inout) :: system !! gets the iterate of euler

    associate (euler => system%body%euler)
      euler%iterations = 0
      system%u = euler%u
      euler%gone = 0.0_wp
      if (allocated(system%tools%rigid)) system%tools%rigid = euler%rigid
      system%inner%bulk_force = euler%bulk_force
      if (.not. system%condensed%active) return
      system%condensed%bulk = euler%bulk
      system%condensed%rigid = euler%carried
      system%condensed%rigid%drag = system%body%drag
    end associate
  end subroutine return_to_center

  !> No drag any more.
  subroutine let_free(system)
    type(system_t), intent(inout) :: system !! drag is forgotten

    system%body%drag = 0.0_wp
    system%body%first_drag = 0.0_wp
    system%body%adrift = .false.
    system%body%euler%iterations = 0
    if (system%condensed%active) call set_center(system%condensed, 0.0_wp)
  end subroutine let_free

  !> The farthest way of a node of a dragged body since the step began.
  pure real(wp) function way_of(system) result(way)
    type(system_t), intent(in) :: system !! u, euler

    way = farthest(system, system%u - system%body%euler%u)
  end function way_of

  !> The largest component of a displacement of dragged bodies.
  pure real(wp) function farthest(system, move) result(most)
    type(system_t), intent(in) :: system !! bodies
    real(wp), intent(in) :: move(:, :) !! (3, nodes) [length]
    integer :: i

    most = 0.0_wp
    do i = 1, size(move, 2)
      if (system%body%node_body(i) == 0) cycle
      if (system%body%weak(system%body%node_body(i))) most = max(most, maxval(abs(move(:, i))))
    end do
  end function farthest
end module drag

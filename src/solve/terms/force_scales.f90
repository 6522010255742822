!> What an increment is measured against: forces that its iterates cannot enlarge, and how far a
!! body can go (doc/theory, "Convergence criteria", eq. (11.6)).
module force_scales
  use kinds, only: wp
  use vectors, only: find_extent, norm_of, largest_of
  use system_types, only: form_t, system_t, state_t
  use system_parts, only: scales_t
  use rigid_bodies, only: rigid_loads
  implicit none
  private
  public :: scales_of, least_forces, force_scale, in_bounds, longest_step, &
    needed_accuracy, least_meaning

  !> No node goes farther in a run than this many times the size of the model, beyond what is
  !! prescribed.
  real(wp), parameter :: farthest_reference = 2.0_wp
  !> An iterative solver may leave this share of what counts as converged, and of what Newton
  !! itself leaves,
  real(wp), parameter :: share_of_goal = 0.1_wp
  !> and shares of the right-hand side within these bounds.
  real(wp), parameter :: finest = 1.0e-10_wp, coarsest = 1.0e-4_wp
  !> Without contact one solve may be all that it takes; a body that hardly anything holds goes far
  !! for a small force.
  real(wp), parameter :: finest_alone = 1.0e-15_wp, finest_loose = 1.0e-14_wp
  !> Round-off beyond this share of the forces is no balance; strains below this are none.
  real(wp), parameter :: most_round_off = 1.0e-4_wp, no_strain = 1.0e-12_wp

contains

  !> Scales of an increment: the loads at its end, the forces of the last state, and the bounds.
  pure function scales_of(x, state, system) result(scale)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(state_t), intent(in) :: state !! last converged state
    type(system_t), intent(in) :: system !! u (prescribed), external, scales that stay
    type(scales_t) :: scale
    real(wp) :: low(3), high(3), prescribed
    integer :: i, k

    scale = system%scale
    scale%given_forces = max(norm_of(state%reaction), &
      hypot(norm_of(system%loads%external), rigid_loads(system%tools)))
    scale%seen_forces = 0.0_wp
    call find_extent(x, low, high)
    prescribed = 0.0_wp
    do i = 1, size(system%equation, 2)
      do k = 1, 3
        if (system%equation(k, i) == 0) prescribed = max(prescribed, abs(system%u(k, i)))
      end do
    end do
    scale%bound = farthest_reference*norm2(high - low) + largest_of(state%u) + prescribed
    scale%stroke = largest_of(system%u - state%u)
  end function scales_of

  !> Residual over right-hand side that an iterative solver may leave of a direction: as many
  !! digits as Newton can use, a tenth of the square of the share that the last iteration left.
  pure real(wp) function needed_accuracy(system, right, share, converged) result(accuracy)
    type(system_t), intent(in) :: system !! the problem
    real(wp), intent(in) :: right(:) !! (equations+unknowns) right-hand side [force]
    real(wp), intent(in) :: share !! residual over that of the iteration before; 0 if there is none
    real(wp), intent(in) :: converged !! residual over forces that counts as converged
    real(wp) :: norm

    norm = norm2(right)
    if (system%contact%n == 0) then
      accuracy = finest_alone
      return
    end if
    accuracy = merge(finest_loose, finest, any(system%body%floating))
    if (norm > 0.0_wp .and. accuracy >= finest) accuracy = min(coarsest, max(finest, &
      share_of_goal*converged*force_scale(system%scale)/norm, &
      merge(share_of_goal*share**2, coarsest, share > 0.0_wp)))
  end function needed_accuracy

  !> Takes the forces of an iterate for what they are in this increment, if none before were
  !! smaller. So a runaway cannot make its own residual look small.
  pure real(wp) function least_forces(system, form) result(least)
    type(system_t), intent(in) :: system !! residual formed
    type(form_t), intent(in) :: form !! its kind answers
    real(wp) :: forces

    forces = internal_forces(system, form)
    least = system%scale%seen_forces
    if (forces <= 0.0_wp) return
    if (least <= 0.0_wp) least = forces
    least = min(least, forces)
  end function least_forces

  !> Norm of the nodal forces of supports and contact at the iterate.
  pure real(wp) function internal_forces(system, form) result(norm)
    type(system_t), intent(in) :: system !! forces given
    type(form_t), intent(in) :: form !! its kind answers
    integer :: i, k

    norm = norm_of(system%contact_force)
    if (.not. form%kind%knows_inside) return
    do i = 1, size(system%equation, 2)
      do k = 1, 3
        if (system%equation(k, i) > 0) cycle
        norm = hypot(norm, form%inner%bulk_force(k, i) + system%contact_force(k, i) &
          - system%loads%external(k, i))
      end do
    end do
  end function internal_forces

  !> The forces that a residual is compared with.
  pure real(wp) function force_scale(scale) result(force)
    type(scales_t), intent(in) :: scale !! its scales

    force = max(scale%given_forces, scale%seen_forces)
  end function force_scale

  !> Residuals above this are no round-off that can be taken for balance: it would be a share of the
  !! forces themselves, unless these are none.
  pure real(wp) function least_meaning(system) result(norm)
    type(system_t), intent(in) :: system !! its force scale, its stiffness

    norm = max(most_round_off*force_scale(system%scale), &
      no_strain*system%scale%stiffest*system%scale%bound)
  end function least_meaning

  !> The share of a direction that a body can go in one iteration: its own size and what is
  !! prescribed in the increment, or the size of a facet where soft springs alone hold it.
  pure real(wp) function longest_step(system, du) result(share)
    type(system_t), intent(in) :: system !! the problem
    real(wp), intent(in) :: du(:, :) !! (3, nodes) direction [length]
    real(wp) :: way
    integer :: i

    share = 1.0_wp
    if (is_proportional(system)) return
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) == 0) cycle
      associate (body => system%body%node_body(i))
        way = system%body%motions(body)%size + system%scale%stroke
        if (system%body%regularised(body)) way = min(way, system%scale%facet_size)
        if (maxval(abs(du(:, i)))*share > way) share = way/maxval(abs(du(:, i)))
      end associate
    end do
  end function longest_step

  !> No node has gone farther than a body can.
  pure logical function in_bounds(system) result(inside)
    type(system_t), intent(in) :: system !! u and its bound

    inside = is_proportional(system)
    if (.not. inside) inside = all(abs(system%u) <= system%scale%bound)
  end function in_bounds

  !> The answer is in proportion to the loads, however far that goes: a linear bulk that supports
  !! hold, no contact, no rigid body that is free to turn.
  pure logical function is_proportional(system) result(yes)
    type(system_t), intent(in) :: system !! elements, bodies

    yes = system%bulk%linear .and. system%contact%n == 0 .and. system%tools%unknowns == 0 .and. &
      system%body%damping <= 0.0_wp
    if (yes .and. allocated(system%body%regularised)) yes = .not. any(system%body%regularised)
    if (yes .and. allocated(system%body%floating)) yes = .not. any(system%body%floating)
  end function is_proportional
end module force_scales

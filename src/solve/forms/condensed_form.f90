!> The condensed form: a linear bulk by its compliance at the nodes that contact may touch, contact
!! forces as the unknowns (doc/theory, "Static condensation", eqs. (12.3), (12.4)). Displacements
!! inside are found at the end.
module condensed_form
  use kinds, only: wp
  use model_types, only: model_t
  use rigid_bodies, only: take_rigid
  use touch_types, only: touch_waits
  use live_values, only: gather_condensed, take_condensed, try_live, take_live, &
    live_direction_norm, live_direction_work
  use right_side, only: gather_points
  use condensed_motions, only: set_center
  use condensed_system, only: begin_condensed, place_starts, couple_condensed, restore_forces, &
    find_defects, renew_defects, refresh_candidates, recover_interior, keep_forces
  use condensed_direction, only: find_condensed_direction, find_modified_direction, &
    next_condensed_length, defect_energy, answer_force, push_direction
  use foretold_forces, only: expect_without_friction, note_touching, take_rubbed
  use linear_sums, only: can_do_without, form_sums
  use system_types, only: form_t, form_kind_t, system_t, state_t
  use system_parts, only: bodies_t, rigid_part_t
  use condensed_types, only: condensed_t, center_t
  implicit none
  private
  public :: condensed_form_of_system

contains

  !> The form.
  function condensed_form_of_system() result(form)
    type(form_kind_t) :: form

    form%name = 'REDUCED'
    form%knows_inside = .false.
    form%has_energy = .false.
    form%iterates_cheaply = .true.
    form%begin => begin
    form%place_starts => place_starts
    form%restart => restart
    form%foresee => foresee
    form%start_rubbing => start_rubbing
    form%couple => couple_condensed
    form%gather => gather
    form%place_trial => try_live
    form%take_trial => take_trial
    form%note_moved => find_defects
    form%renew => renew_defects
    form%find_direction => find_condensed_direction
    form%repeat_direction => find_modified_direction
    form%repeats_by_iteration => repeats_by_iteration
    form%repeats_if_promising => has_blocks
    form%next_length => next_condensed_length
    form%next_energy => next_energy
    form%answer => answer
    form%push => push
    form%residual_norm => residual_norm
    form%damping_norm => damping_norm
    form%direction_norm => live_direction_norm
    form%direction_work => live_direction_work
    form%defect_energy => defect_energy
    form%sum_terms => sum_terms
    form%find_worst => find_worst
    form%floating_resultant => floating_resultant
    form%placed_nodes => placed_nodes
    form%refresh => refresh_candidates
    form%recover => recover_interior
    form%accept => accept
    form%note_center => note_center
    form%return_to_center => return_to_center
    form%forget_damping => forget_damping
  end function condensed_form_of_system

  !> Displacements of the candidates without contact, and the forces that are foretold.
  subroutine begin(model, system, form, state, time, foretold)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! equations, first touches
    type(form_t), intent(inout) :: form !! matrix given; gets condensed
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    logical, intent(out) :: foretold !! there are such forces

    call begin_condensed(model, system%equation, form, state, time)
    if (system%touch%stage == touch_waits) call expect_without_friction(form%condensed%outer)
    foretold = form%condensed%outer%foretold
  end subroutine begin

  !> The start, with the forces of the last state: what displacements lack.
  subroutine restart(system, form)
    type(system_t), intent(inout) :: system !! u given
    type(form_t), intent(inout) :: form !! the linearised system in its form

    call restore_forces(form%condensed)
    call couple_condensed(system, form)
    system%place%coupled = .true.
    call find_defects(system, form)
  end subroutine restart

  !> The defects of a start cost next to nothing.
  subroutine foresee(system, form, known, norm)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! gets force, defect
    logical, intent(out) :: known !! they are
    real(wp), intent(out) :: norm !! of the forces that would hold them [force]

    call restore_forces(form%condensed)
    call find_defects(system, form)
    known = .true.
    norm = form%condensed%bulk%defect_norm
  end subroutine foresee

  !> Where forces with the friction of first touches are foretold, the increment goes on from there.
  subroutine start_rubbing(form, body, u, taken)
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    type(bodies_t), intent(in) :: body !! connected bodies
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]
    logical, intent(out) :: taken !! they are

    call note_touching(form%condensed)
    call take_rubbed(form%condensed, any(body%floating), u, taken)
  end subroutine start_rubbing

  !> Residual of the live candidates and of rigid bodies with a point.
  subroutine gather(system, form, length, tried)
    type(system_t), intent(in) :: system !! forces given
    type(form_t), intent(inout) :: form !! gets right
    real(wp), intent(in) :: length !! share of the direction
    logical, intent(in) :: tried !! forces are those of the trial

    call gather_condensed(system, form, length)
    call gather_points(system, form, length, tried, system%loads%external - system%contact_force)
  end subroutine gather

  !> Moves to the trial.
  subroutine take_trial(form, length, u, tools)
    type(form_t), intent(inout) :: form !! trial given; forces and defects are moved
    real(wp), intent(in) :: length !! share of du
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies, which go with it

    call take_live(u, form)
    call take_rigid(u, tools)
    call take_condensed(form%condensed, length)
  end subroutine take_trial

  !> A direction with the factor at hand is no substitution, and costs about what a tangent does;
  !! with the blocks of groups of points it costs far less.
  pure logical function repeats_by_iteration(form) result(iterated)
    type(form_t), intent(in) :: form !! its solver

    iterated = has_blocks(form) .and. .not. form%condensed%tangent%parts%grouped
  end function repeats_by_iteration

  !> Blocks stand in for the small matrix of contact.
  pure logical function has_blocks(form)
    type(form_t), intent(in) :: form !! its solver

    has_blocks = form%condensed%tangent%parts%iterated
  end function has_blocks

  !> Work of the residual on the direction that the factor gives for it.
  real(wp) function next_energy(system, form) result(energy)
    type(system_t), intent(in) :: system !! residual given
    type(form_t), intent(inout) :: form !! right given; gets condensed

    energy = next_condensed_length(system, form)
    energy = dot_product(form%condensed%alive%right, form%condensed%alive%change)
    if (form%condensed%points%n > 0) energy = energy + dot_product( &
      form%right(system%equations + 1:), form%condensed%points%change)
    energy = abs(energy)
  end function next_energy

  !> Displacements of the live candidates that forces there bring by themselves.
  subroutine answer(system, form, force, du)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! tangent at hand
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(out) :: du(:, :) !! (3, nodes) [length]
    real(wp) :: change(form%condensed%alive%n_live)
    integer :: i

    associate (unused => system)
    end associate
    du = 0.0_wp
    call answer_force(form%condensed, form%costs, live_forces(form%condensed, force), change)
    associate (condensed => form%condensed)
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          du(condensed%direction(c), condensed%node(c)) = change(i)
        end associate
      end do
    end associate
  end subroutine answer

  !> The direction with forces beside the residual.
  subroutine push(system, form, force)
    type(system_t), intent(in) :: system !! tangent at hand
    type(form_t), intent(inout) :: form !! gets solution, du, force_change
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]

    call push_direction(system, form, live_forces(form%condensed, force))
  end subroutine push

  !> Values at the live candidates.
  pure function live_forces(condensed, field) result(values)
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(in) :: field(:, :) !! (3, nodes)
    real(wp) :: values(condensed%alive%n_live)
    integer :: i

    do i = 1, condensed%alive%n_live
      values(i) = field(condensed%direction(condensed%alive%live(i)), &
        condensed%node(condensed%alive%live(i)))
    end do
  end function live_forces

  !> Norm of the residual: live candidates, defects, rigid motions, rigid bodies with a point.
  pure real(wp) function residual_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(in) :: form !! right given

    associate (condensed => form%condensed)
      norm = hypot(norm2(condensed%alive%right), condensed%bulk%defect_share &
        *condensed%bulk%defect_norm)
      if (condensed%rigid%modes > 0) norm = hypot(norm, norm2(condensed%rigid%imbalance &
        + (1.0_wp - condensed%bulk%defect_share)*condensed%rigid%imbalance_change))
      if (system%tools%unknowns > 0) norm = hypot(norm, norm2(form%right(system%equations + 1:)))
    end associate
  end function residual_norm

  !> Norm of the damping's force, as far as the residual knows of it.
  pure real(wp) function damping_norm(system, form) result(norm)
    type(system_t), intent(in) :: system !! damping and its place
    type(form_t), intent(in) :: form !! what the condensed form keeps

    norm = 0.0_wp
    associate (rigid => form%condensed%rigid)
      if (rigid%modes > 0) norm = norm2(rigid%damping*(rigid%alpha - rigid%center))
    end associate
    if (system%tools%unknowns > 0) norm = hypot(norm, system%body%damping* &
      norm2(system%body%damped_way))
  end function damping_norm

  !> Norm of the terms that the residual sums: contact forces, and those of bodies that move.
  subroutine sum_terms(system, form, terms)
    type(system_t), intent(in) :: system !! u given
    type(form_t), intent(inout) :: form !! what the condensed form keeps
    real(wp), intent(out) :: terms !! [force]

    terms = hypot(norm2(form%condensed%bulk%force), carried_terms(system, form%condensed))
  end subroutine sum_terms

  !> Terms of the defects of bodies that their motions carry along: they are differences of
  !! displacements, and there need be no force beside which these are small; and their loads, which
  !! may be in balance by themselves.
  pure real(wp) function carried_terms(system, condensed) result(terms)
    type(system_t), intent(in) :: system !! u given
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp) :: farthest, load
    integer :: i

    farthest = 0.0_wp
    load = 0.0_wp
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) == 0) cycle
      if (.not. system%body%floating(system%body%node_body(i))) cycle
      load = hypot(load, norm2(system%loads%external(:, i)))
      if (condensed%candidate(i)) farthest = max(farthest, maxval(abs(system%u(:, i))))
    end do
    terms = hypot(system%scale%stiffest*farthest, load)
  end function carried_terms

  !> The live candidate with the largest residual.
  pure subroutine find_worst(system, form, node, dof, value)
    type(system_t), intent(in) :: system !! its equations
    type(form_t), intent(in) :: form !! right given
    integer, intent(out) :: node, dof !! 0 if there is none
    real(wp), intent(out) :: value !! the residual there [force]
    integer :: largest

    node = 0
    dof = 0
    value = 0.0_wp
    associate (condensed => form%condensed)
      if (min(system%equations, condensed%alive%n_live) == 0) return
      largest = maxloc(abs(condensed%alive%right(:condensed%alive%n_live)), 1)
      value = condensed%alive%right(largest)
      node = condensed%node(condensed%alive%live(largest))
      dof = condensed%direction(condensed%alive%live(largest))
    end associate
  end subroutine find_worst

  !> Resultant of the residual on a floating body, which it has as such.
  pure function floating_resultant(system, form, body) result(force)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(in) :: form !! right given
    integer, intent(in) :: body !! the body
    real(wp) :: force(6)

    associate (motions => system%body%motions(body), &
      first => form%condensed%bodies(body)%first_mode)
      force = -matmul(motions%basis(:, :motions%n), &
        form%condensed%rigid%imbalance(first + 1:first + motions%n))
    end associate
  end function floating_resultant

  !> The candidates are where the iterate has them.
  pure subroutine placed_nodes(form, placed)
    type(form_t), intent(in) :: form !! the iterate
    logical, intent(out) :: placed(:) !! (nodes)

    placed = form%condensed%candidate(:size(placed))
  end subroutine placed_nodes

  !> Displacements inside, unless sums over supports and loads stand in for them.
  subroutine accept(model, system, form, inside_due, known, whole)
    type(model_t), intent(in) :: model !! output requests
    type(system_t), intent(inout) :: system !! converged
    type(form_t), intent(inout) :: form !! matrix given; gets condensed, du
    logical, intent(in) :: inside_due !! displacements inside are asked for
    logical, intent(in) :: known !! they are known
    logical, intent(out) :: whole !! they are those of the state

    whole = .true.
    if (can_do_without(model, system, form%condensed)) then
      whole = inside_due
      if (.not. form%condensed%sums%known) call form_sums(model, system, form)
    end if
    if (whole .and. .not. known) call recover_interior(system, form)
    if (.not. whole) call refresh_candidates(form, system%u)
    call keep_forces(form%condensed)
  end subroutine accept

  !> A step of pseudo-time begins here.
  subroutine note_center(form, damping, center)
    type(form_t), intent(inout) :: form !! gets where damping is measured from
    real(wp), intent(in) :: damping !! against rigid motions [force/length]
    type(center_t), intent(inout) :: center !! gets forces, defects, motions

    call set_center(form%condensed, damping)
    center%bulk = form%condensed%bulk
    center%rigid = form%condensed%rigid
  end subroutine note_center

  !> Back to where the step began.
  subroutine return_to_center(form, damping, center)
    type(form_t), intent(inout) :: form !! gets forces, defects, motions
    real(wp), intent(in) :: damping !! against rigid motions [force/length]
    type(center_t), intent(inout) :: center !! those there

    form%condensed%bulk = center%bulk
    form%condensed%rigid = center%rigid
    form%condensed%rigid%damping = damping
  end subroutine return_to_center

  !> There is no damping any more.
  subroutine forget_damping(form)
    type(form_t), intent(inout) :: form !! its damping

    call set_center(form%condensed, 0.0_wp)
  end subroutine forget_damping
end module condensed_form

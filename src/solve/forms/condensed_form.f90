!> The condensed form: a linear bulk by its compliance at the nodes that contact may touch, contact
!! forces as the unknowns (doc/theory, "Static condensation", eqs. (12.3), (12.4)). Displacements
!! inside are found at the end.
module condensed_form
  use kinds, only: wp
  use model_types, only: model_t
  use rigid_bodies, only: take_rigid
  use touch_path, only: touch_waits
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
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: condensed_form_of_system

contains

  !> The form.
  function condensed_form_of_system() result(form)
    type(form_t) :: form

    form%name = 'REDUCED'
    form%knows_inside = .false.
    form%has_energy = .false.
    form%iterates_cheaply = .true.
    form%begin => begin
    form%restart => restart
    form%foresee => foresee
    form%start_rubbing => start_rubbing
    form%couple => couple_condensed
    form%gather => gather
    form%place_trial => try_live
    form%take_trial => take_trial
    form%note_drop => find_defects
    form%renew => renew
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

  !> Displacements of the candidates without contact; with the forces of the last state, or with
  !! those that are foretold.
  subroutine begin(model, system, state, time, foretold)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(inout) :: system !! position%carried may be moved
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    logical, intent(out) :: foretold !! carried is in balance with forces that are foretold

    call begin_condensed(model, system, state, time)
    if (system%touch%stage == touch_waits) call expect_without_friction(system%condensed%outer)
    call place_starts(system)
    foretold = system%condensed%outer%foretold
  end subroutine begin

  !> The start, with the forces of the last state: what displacements lack.
  subroutine restart(system)
    type(system_t), intent(inout) :: system !! u given

    call restore_forces(system%condensed)
    call couple_condensed(system)
    system%place%coupled = .true.
    call find_defects(system)
  end subroutine restart

  !> The defects of a start cost next to nothing.
  subroutine foresee(system, known, norm)
    type(system_t), intent(inout) :: system !! u given; gets force, defect
    logical, intent(out) :: known !! they are
    real(wp), intent(out) :: norm !! of the forces that would hold them [force]

    call restore_forces(system%condensed)
    call find_defects(system)
    known = .true.
    norm = system%condensed%bulk%defect_norm
  end subroutine foresee

  !> Where forces with the friction of first touches are foretold, the increment goes on from there.
  subroutine start_rubbing(system, taken)
    type(system_t), intent(inout) :: system !! gets u, force, defect
    logical, intent(out) :: taken !! they are

    call note_touching(system%condensed)
    call take_rubbed(system, taken)
  end subroutine start_rubbing

  !> Residual of the live candidates and of rigid bodies with a point.
  subroutine gather(system, length, tried)
    type(system_t), intent(inout) :: system !! forces given; gets right
    real(wp), intent(in) :: length !! share of the direction
    logical, intent(in) :: tried !! forces are those of the trial

    call gather_condensed(system, length)
    call gather_points(system, length, tried, system%loads%external - system%contact_force)
  end subroutine gather

  !> Moves to the trial.
  subroutine take_trial(system, length)
    type(system_t), intent(inout) :: system !! u, forces and defects are moved
    real(wp), intent(in) :: length !! share of du

    call take_live(system)
    call take_rigid(system%u, system%tools)
    call take_condensed(system%condensed, length)
  end subroutine take_trial

  !> Directions of bodies that hardly anything holds are long and lose digits, and with them the
  !! defects that are carried on.
  subroutine renew(system, taken)
    type(system_t), intent(inout) :: system !! gets defect
    logical, intent(out) :: taken !! there is such a body

    taken = any(system%body%floating)
    if (taken) call renew_defects(system)
  end subroutine renew

  !> A direction with the factor at hand is no substitution, and costs about what a tangent does;
  !! with the blocks of groups of points it costs far less.
  pure logical function repeats_by_iteration(system) result(iterated)
    type(system_t), intent(in) :: system !! its solver

    iterated = has_blocks(system) .and. .not. system%condensed%tangent%parts%grouped
  end function repeats_by_iteration

  !> Blocks stand in for the small matrix of contact.
  pure logical function has_blocks(system)
    type(system_t), intent(in) :: system !! its solver

    has_blocks = system%condensed%tangent%parts%iterated
  end function has_blocks

  !> Work of the residual on the direction that the factor gives for it.
  real(wp) function next_energy(system) result(energy)
    type(system_t), intent(inout) :: system !! residual given

    energy = next_condensed_length(system)
    energy = dot_product(system%condensed%alive%right, system%condensed%alive%change)
    if (system%condensed%points%n > 0) energy = energy + dot_product( &
      system%right(system%equations + 1:), system%condensed%points%change)
    energy = abs(energy)
  end function next_energy

  !> Displacements of the live candidates that forces there bring by themselves.
  subroutine answer(system, force, du)
    type(system_t), intent(inout) :: system !! tangent at hand
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(out) :: du(:, :) !! (3, nodes) [length]
    real(wp) :: change(system%condensed%alive%n_live)
    integer :: i

    du = 0.0_wp
    call answer_force(system%condensed, system%costs, live_forces(system, force), change)
    associate (condensed => system%condensed)
      do i = 1, condensed%alive%n_live
        associate (c => condensed%alive%live(i))
          du(condensed%direction(c), condensed%node(c)) = change(i)
        end associate
      end do
    end associate
  end subroutine answer

  !> The direction with forces beside the residual.
  subroutine push(system, force)
    type(system_t), intent(inout) :: system !! tangent at hand; gets solution, du, force_change
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]

    call push_direction(system, live_forces(system, force))
  end subroutine push

  !> Values at the live candidates.
  pure function live_forces(system, field) result(values)
    type(system_t), intent(in) :: system !! condensed
    real(wp), intent(in) :: field(:, :) !! (3, nodes)
    real(wp) :: values(system%condensed%alive%n_live)
    integer :: i

    associate (condensed => system%condensed)
      do i = 1, condensed%alive%n_live
        values(i) = field(condensed%direction(condensed%alive%live(i)), &
          condensed%node(condensed%alive%live(i)))
      end do
    end associate
  end function live_forces

  !> Norm of the residual: live candidates, defects, rigid motions, rigid bodies with a point.
  pure real(wp) function residual_norm(system) result(norm)
    type(system_t), intent(in) :: system !! right given

    associate (condensed => system%condensed)
      norm = hypot(norm2(condensed%alive%right), condensed%bulk%defect_share &
        *condensed%bulk%defect_norm)
      if (condensed%rigid%modes > 0) norm = hypot(norm, norm2(condensed%rigid%imbalance &
        + (1.0_wp - condensed%bulk%defect_share)*condensed%rigid%imbalance_change))
      if (system%tools%unknowns > 0) norm = hypot(norm, norm2(system%right(system%equations + 1:)))
    end associate
  end function residual_norm

  !> Norm of the damping's force, as far as the residual knows of it.
  pure real(wp) function damping_norm(system) result(norm)
    type(system_t), intent(in) :: system !! damping, pseudo_step

    norm = 0.0_wp
    associate (rigid => system%condensed%rigid)
      if (rigid%modes > 0) norm = norm2(rigid%damping*(rigid%alpha - rigid%center))
    end associate
    if (system%tools%unknowns > 0) norm = hypot(norm, system%body%damping* &
      norm2(system%body%pseudo_step%gone))
  end function damping_norm

  !> Norm of the terms that the residual sums: contact forces, and those of bodies that move.
  subroutine sum_terms(system, terms)
    type(system_t), intent(inout) :: system !! u given
    real(wp), intent(out) :: terms !! [force]

    terms = hypot(norm2(system%condensed%bulk%force), carried_terms(system))
  end subroutine sum_terms

  !> Terms of the defects of bodies that their motions carry along: they are differences of
  !! displacements, and there need be no force beside which these are small; and their loads, which
  !! may be in balance by themselves.
  pure real(wp) function carried_terms(system) result(terms)
    type(system_t), intent(in) :: system !! u given
    real(wp) :: farthest, load
    integer :: i

    farthest = 0.0_wp
    load = 0.0_wp
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) == 0) cycle
      if (.not. system%body%floating(system%body%node_body(i))) cycle
      load = hypot(load, norm2(system%loads%external(:, i)))
      if (system%condensed%candidate(i)) farthest = max(farthest, maxval(abs(system%u(:, i))))
    end do
    terms = hypot(system%scale%stiffest*farthest, load)
  end function carried_terms

  !> The live candidate with the largest residual.
  pure subroutine find_worst(system, node, dof, value)
    type(system_t), intent(in) :: system !! right given
    integer, intent(out) :: node, dof !! 0 if there is none
    real(wp), intent(out) :: value !! the residual there [force]
    integer :: largest

    node = 0
    dof = 0
    value = 0.0_wp
    associate (condensed => system%condensed)
      if (condensed%alive%n_live == 0) return
      largest = maxloc(abs(condensed%alive%right(:condensed%alive%n_live)), 1)
      value = condensed%alive%right(largest)
      node = condensed%node(condensed%alive%live(largest))
      dof = condensed%direction(condensed%alive%live(largest))
    end associate
  end subroutine find_worst

  !> Resultant of the residual on a floating body, which it has as such.
  pure function floating_resultant(system, body) result(force)
    type(system_t), intent(in) :: system !! right given
    integer, intent(in) :: body !! the body
    real(wp) :: force(6)

    associate (motions => system%body%motions(body), &
      first => system%condensed%bodies(body)%first_mode)
      force = -matmul(motions%basis(:, :motions%n), &
        system%condensed%rigid%imbalance(first + 1:first + motions%n))
    end associate
  end function floating_resultant

  !> The candidates are where the iterate has them.
  pure subroutine placed_nodes(system, placed)
    type(system_t), intent(in) :: system !! the iterate
    logical, intent(out) :: placed(:) !! (nodes)

    placed = system%condensed%candidate(:size(placed))
  end subroutine placed_nodes

  !> Displacements inside, unless sums over supports and loads stand in for them.
  subroutine accept(model, system, known, whole)
    type(model_t), intent(in) :: model !! output requests
    type(system_t), intent(inout) :: system !! converged
    logical, intent(in) :: known !! the displacements inside are known
    logical, intent(out) :: whole !! they are those of the state

    whole = .true.
    if (can_do_without(model, system)) then
      whole = system%inside_due
      if (.not. system%condensed%sums%known) call form_sums(model, system)
    end if
    if (whole .and. .not. known) call recover_interior(system)
    if (.not. whole) call refresh_candidates(system)
    call keep_forces(system%condensed)
  end subroutine accept

  !> A step of pseudo-time begins here.
  subroutine note_center(system)
    type(system_t), intent(inout) :: system !! gets pseudo_step

    call set_center(system%condensed, system%body%damping)
    system%body%pseudo_step%bulk = system%condensed%bulk
    system%body%pseudo_step%carried = system%condensed%rigid
  end subroutine note_center

  !> Back to where the step began.
  subroutine return_to_center(system)
    type(system_t), intent(inout) :: system !! pseudo_step given; gets forces, defects, motions

    system%condensed%bulk = system%body%pseudo_step%bulk
    system%condensed%rigid = system%body%pseudo_step%carried
    system%condensed%rigid%damping = system%body%damping
  end subroutine return_to_center

  !> There is no damping any more.
  subroutine forget_damping(system)
    type(system_t), intent(inout) :: system !! its damping

    call set_center(system%condensed, 0.0_wp)
  end subroutine forget_damping
end module condensed_form

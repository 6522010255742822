!> The audit of an end time: whether each body is in balance, and how far the state lies within what
!! small strain, penalty and mesh can bear (doc/theory, "Audit and error").
module audit
  use kinds, only: wp
  use element_types, only: status_open
  use contact_overlap, only: overlap_of
  use model_types, only: model_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use rigid_report, only: rigid_imbalance
  use balance_audit, only: judge_balance
  use held_bodies, only: supports_of
  use body_measures, only: find_balance, lever_ends
  use shape_audit, only: judge_turns, judge_volumes
  use audit_sums, only: take_values, compare_balance, add_supports, add_work, energy_by_sums
  use scene_audit, only: judge_room
  use edge_audit, only: deepest_edge
  use penalty_audit, only: held_energy, judge_penalty
  use answers_audit, only: judge_answers
  use audit_types, only: audit_t, verdict_ok, verdict_warning, check_work, check_strain, &
    check_rotation, check_penetration, check_elastic_slip, check_edges, most_lost
  implicit none
  private
  public :: audit_state

  !> Beyond this share of a facet penetration and elastic slip are worth a warning.
  real(wp), parameter :: most_way = 0.05_wp
  !> And depth of edges and nodes between points: facets of two meshes of one circle, 15 degrees
  !! each, overlap by 0.07 of a facet without any force.
  real(wp), parameter :: most_edge = 0.1_wp

contains

  !> Audits the bodies and the contact points of an end time.
  subroutine audit_state(model, system, form, state, settings, point_state, last, audit)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! forces as accepted
    type(form_t), intent(in) :: form !! its kind, matrix
    type(state_t), intent(in) :: state !! the converged state
    type(settings_t), intent(in) :: settings !! tolerances asked for
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    logical, intent(in) :: last !! it is the last end time: the work of the whole run is judged
    type(audit_t), intent(inout) :: audit !! gets its results
    real(wp), allocatable :: value(:)
    integer :: b

    audit%before = audit%verdict
    if (audit%step == 0) audit%before = -1
    audit%step = state%step
    audit%time = state%time
    call take_values(model, system, form%condensed, state, value)
    if (.not. state%whole) then
      call find_balance(model%mesh%x, system, audit%fixed%center, audit%balance)
      call add_supports(model, value, audit%balance)
    else if (system%bulk%linear) then
      call find_balance(model%mesh%x, system, audit%fixed%center, audit%balance, &
        supports_of(system%body, state%reaction))
      if (size(value) > 0) call compare_balance(model, system, value, audit)
    else
      call find_balance(lever_ends(model%mesh%x, state%u, system), system, audit%fixed%center, &
        audit%balance, supports_of(system%body, state%reaction))
    end if
    if (system%tools%unknowns > 0) then
      do b = 1, system%body%bodies
        audit%balance(:, b) = audit%balance(:, b) + rigid_imbalance(model, system, state, b)
      end do
    end if
    call judge_balance(model, system, form, state, settings, audit)
    call find_energies(model, system, form, state, point_state, last, value, audit)
    call judge_turns(model, system, state, value, audit)
    call judge_volumes(model, system, state, value, audit)
    call judge_contact(model, system, point_state, audit)
    call judge_penalty(model, system, state, point_state, audit)
    call judge_room(model, audit)
    call judge_edges(model, model%mesh%x(:, :size(state%u, 2)) + state%u, audit)
    call judge_answers(model, system, form, state, point_state, last, .false., audit)
    audit%value([check_strain, check_rotation]) = 0.0_wp
    audit%verdict([check_strain, check_rotation]) = verdict_ok
    audit%fields_known = .false.
  end subroutine audit_state

  !> Work of loads and supports by the trapezoidal rule between end times, and where it has gone.
  !! The strain energy of a linear bulk is half the work of all forces on it.
  subroutine find_energies(model, system, form, state, point_state, last, value, audit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! forces as accepted
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    logical, intent(in) :: last !! it is the last end time
    real(wp), intent(in) :: value(:) !! (sums), if there are any
    type(audit_t), intent(inout) :: audit !! gets energies; u and force are moved on
    real(wp) :: f(3), stored, largest
    integer :: i, k
    logical :: by_sums

    audit%strain_energy = 0.0_wp
    by_sums = .not. (state%whole .and. audit%sum%whole)
    if (by_sums) call add_work(model, system, form%condensed, value, audit)
    if (.not. state%whole) audit%strain_energy = energy_by_sums(model, system, form%condensed, &
      state, value)
    do i = 1, merge(size(state%u, 2), 0, state%whole)
      f = system%loads%external(:, i) + state%reaction(:, i)
      if (.not. by_sums) audit%sum%work = audit%sum%work + 0.5_wp*dot_product( &
        f + audit%sum%force(:, i), state%u(:, i) - audit%sum%u(:, i))
      if (system%bulk%linear) audit%strain_energy = audit%strain_energy &
        + 0.5_wp*dot_product(state%u(:, i), f - system%contact_force(:, i))
      audit%sum%u(:, i) = state%u(:, i)
      audit%sum%force(:, i) = f
    end do
    audit%sum%whole = state%whole
    audit%sum%value = value
    if (size(value) > 0) audit%sum%factors = form%condensed%outer%factors
    if (.not. system%bulk%linear) audit%strain_energy = form%inner%bulk_energy
    call add_contact_energies(model, system, point_state, audit)
    audit%dissipation = 0.0_wp
    do k = 1, size(model%pairs)
      audit%dissipation = audit%dissipation + sum(model%pairs(k)%history%old%dissipation)
    end do
    stored = audit%strain_energy + audit%penalty_energy + audit%dissipation
    if (.not. audit%sum%work_known) audit%sum%work = stored
    audit%sum%work_known = .true.
    largest = max(audit%sum%largest_energy, abs(audit%sum%work), abs(stored))
    audit%sum%largest_energy = largest
    audit%value(check_work) = 0.0_wp
    if (largest > 0.0_wp) audit%value(check_work) = abs(audit%sum%work - stored)/largest
    audit%depends_on_path = has_friction(model)
    audit%verdict(check_work) = merge(verdict_warning, verdict_ok, &
      last .and. audit%value(check_work) > most_lost .and. audit%depends_on_path)
  end subroutine find_energies

  !> Energy that penalties hold, and the work that is done while SHRInk takes up overlaps.
  subroutine add_contact_energies(model, system, point_state, audit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(audit_t), intent(inout) :: audit !! gets penalty_energy; work grows
    real(wp) :: force
    integer :: k, p, e

    audit%penalty_energy = 0.0_wp
    do k = 1, size(model%pairs)
      force = 0.0_wp
      do e = system%place%first_point(k), system%place%first_point(k + 1) - 1
        if (system%contact%status(e) <= status_open) cycle
        p = e - system%place%first_point(k) + 1
        force = force + point_state(13, e)*overlap_of(model%pairs(k), p)
        if (model%pairs(k)%mortar) cycle
        audit%penalty_energy = audit%penalty_energy + held_energy(point_state(:, e))
      end do
      if (model%pairs(k)%shrinking%shrink < 0) cycle
      audit%sum%work = audit%sum%work + 0.5_wp*(audit%shrink(k) + force)*(audit%withheld(k) &
        - model%pairs(k)%shrinking%withheld)
      audit%shrink(k) = force
      audit%withheld(k) = model%pairs(k)%shrinking%withheld
    end do
  end subroutine add_contact_energies

  !> Some pair has friction: what happens depends on the path.
  pure logical function has_friction(model)
    type(model_t), intent(in) :: model !! pairs
    integer :: k

    has_friction = .false.
    do k = 1, size(model%pairs)
      has_friction = has_friction .or. any(model%pairs(k)%friction%mu > 0.0_wp)
    end do
  end function has_friction

  !> Penetration and elastic slip over the size of a facet.
  subroutine judge_contact(model, system, point_state, audit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(audit_t), intent(inout) :: audit !! gets values, worst, verdicts
    integer, parameter :: penalty_checks(2) = [check_penetration, check_elastic_slip]
    real(wp) :: way(2)
    integer :: k, e, i

    audit%value(penalty_checks) = 0.0_wp
    audit%worst(penalty_checks) = 0
    do k = 1, size(model%pairs)
      way = 0.0_wp
      if (model%pairs(k)%mortar) then
        associate (nodes => model%pairs(k)%nodes)
          way(1) = maxval([0.0_wp, pack(-nodes%gap(3, :), nodes%status > status_open)])
        end associate
      end if
      do e = system%place%first_point(k), system%place%first_point(k + 1) - 1
        if (system%contact%status(e) <= status_open .or. model%pairs(k)%mortar) cycle
        way = max(way, [-point_state(4, e), point_state(5, e)])
      end do
      do i = 1, 2
        if (way(i) <= audit%value(penalty_checks(i))*audit%fixed%facet(k)) cycle
        audit%value(penalty_checks(i)) = way(i)/audit%fixed%facet(k)
        audit%worst(penalty_checks(i)) = k
      end do
    end do
    audit%verdict(penalty_checks) &
      = merge(verdict_warning, verdict_ok, audit%value(penalty_checks) > most_way)
  end subroutine judge_contact

  !> Depth of edges and nodes between the points of slave facets, over the size of a facet.
  subroutine judge_edges(model, x, audit)
    type(model_t), intent(in) :: model !! pairs, settled
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(audit_t), intent(inout) :: audit !! gets value, worst, verdict
    real(wp) :: depth
    integer :: k

    audit%value(check_edges) = 0.0_wp
    audit%worst(check_edges) = 0
    do k = 1, size(model%pairs)
      call deepest_edge(model%pairs(k), x, depth)
      if (depth <= audit%value(check_edges)*audit%fixed%facet(k)) cycle
      audit%value(check_edges) = depth/audit%fixed%facet(k)
      audit%worst(check_edges) = k
    end do
    audit%verdict(check_edges) = merge(verdict_warning, verdict_ok, audit%value(check_edges) &
      > most_edge)
  end subroutine judge_edges
end module audit

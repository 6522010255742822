!> What of an audit can be said before the first solve: facets, locking, moved nodes, and room for
!! points (doc/theory, "Model").
module scene_audit
  use kinds, only: wp
  use model_types, only: model_t
  use contact_types, only: pair_t
  use audit_types, only: audit_t, verdict_ok, verdict_warning, check_facets, check_locking, &
    check_moved, check_room
  use contact_points, only: used_points, point_position
  use smooth_normals, only: project_on_master
  use facet_ratio, only: slave_over_master, mean_facet
  use mesh_building, only: model_size
  use follower_pressure, only: add_pressure_force, set_pressures
  use loads, only: conditions_at
  use system_parts, only: outer_t
  use system_types, only: system_t, state_t
  use body_measures, only: measure_bodies
  use body_volumes, only: find_volumes
  implicit none
  private
  public :: begin_audit, judge_room

  !> Slave facets over master facets beyond which a slave is coarse: nodes that stand alone, and
  !! points of facets.
  real(wp), parameter :: coarse_nodes = 1.5_wp
  real(wp), parameter :: coarse_points = 2.5_wp
  !> Poisson's ratio beyond which linear tetrahedra lock.
  real(wp), parameter :: locking_ratio = 0.45_wp
  !> Way of a node that ADJUst has moved, over a facet.
  real(wp), parameter :: most_moved = 0.01_wp

contains

  !> Judges the checks that do not depend on the solution.
  pure subroutine judge_scene(model, audit)
    type(model_t), intent(in) :: model !! the problem
    type(audit_t), intent(inout) :: audit !! begun; gets values, worst, verdicts
    integer, parameter :: scene_checks(3) = [check_facets, check_locking, check_moved]
    real(wp) :: moved
    integer :: k

    audit%value(scene_checks) = 0.0_wp
    audit%worst(scene_checks) = 0
    audit%verdict(scene_checks) = verdict_ok
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (excess(pair, audit%fixed%ratio(k)) > audit%value(check_facets)) then
          audit%value(check_facets) = excess(pair, audit%fixed%ratio(k))
          audit%worst(check_facets) = k
        end if
        moved = pair%fit%farthest_way/audit%fixed%facet(k)
        if (moved > audit%value(check_moved)) audit%worst(check_moved) = k
        audit%value(check_moved) = max(audit%value(check_moved), moved)
      end associate
    end do
    call judge_locking(model, audit)
    where (audit%value(scene_checks) > [1.0_wp + 1.0e-6_wp, locking_ratio, most_moved]) &
      audit%verdict(scene_checks) = verdict_warning
  end subroutine judge_scene

  !> Judges whether segmented pairs have had room for their points.
  pure subroutine judge_room(model, audit)
    type(model_t), intent(in) :: model !! the problem
    type(audit_t), intent(inout) :: audit !! gets value, worst, verdict of the room
    integer :: k

    audit%worst(check_room) = 0
    audit%value(check_room) = 0.0_wp
    audit%verdict(check_room) = verdict_ok
    do k = 1, size(model%pairs)
      if (.not. model%pairs(k)%history%crowded) cycle
      if (audit%worst(check_room) == 0) audit%worst(check_room) = k
      audit%value(check_room) = audit%value(check_room) + 1.0_wp
      audit%verdict(check_room) = verdict_warning
    end do
  end subroutine judge_room

  !> Ratio of the facets of a pair over the largest that its form bears; segments bear any.
  pure real(wp) function excess(pair, ratio)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: ratio !! slave facets over master facets, 0 if unknown

    excess = ratio/merge(coarse_nodes, coarse_points, pair%points%n_slaves == 1)
    if (pair%segmented) excess = 0.0_wp
  end function excess

  !> Largest Poisson's ratio of elements that deform.
  pure subroutine judge_locking(model, audit)
    type(model_t), intent(in) :: model !! materials
    type(audit_t), intent(inout) :: audit !! gets value and worst, a material
    logical :: used(size(model%materials))
    integer :: e, m

    used = .false.
    do e = 1, size(model%element_material)
      if (model%element_material(e) > 0) used(model%element_material(e)) = .true.
    end do
    do m = 1, size(model%materials)
      if (.not. used(m) .or. model%materials(m)%rigid) cycle
      if (model%materials(m)%mean) cycle
      if (audit%worst(check_locking) > 0 .and. model%materials(m)%poissons_ratio <= &
        audit%value(check_locking)) cycle
      audit%value(check_locking) = model%materials(m)%poissons_ratio
      audit%worst(check_locking) = m
    end do
  end subroutine judge_locking

  !> What stays the same in a run, and what the first end time is compared with.
  subroutine begin_audit(model, system, state, audit)
    type(model_t), intent(in) :: model !! the problem, its pairs with their first targets
    type(system_t), intent(in) :: system !! just built
    type(state_t), intent(in) :: state !! at rest, or the state restarted from
    type(audit_t), intent(out) :: audit !! ready for the first end time
    type(outer_t) :: loads
    integer :: k

    call measure_bodies(model%mesh%x, system, audit%fixed%center, audit%fixed%reach, &
      audit%fixed%spread, audit%fixed%moves)
    allocate (audit%fixed%volume(system%body%bodies))
    call find_volumes(model%mesh%x, system, audit%fixed%volume)
    audit%fixed%model_size = model_size(model%mesh)
    allocate (audit%fixed%facet(size(model%pairs)), audit%fixed%ratio(size(model%pairs)), &
      source=0.0_wp)
    allocate (audit%balance(6, system%body%bodies), source=0.0_wp)
    allocate (audit%withheld(size(model%pairs)), source=1.0_wp)
    allocate (audit%shrink(size(model%pairs)), source=0.0_wp)
    do k = 1, size(model%pairs)
      audit%fixed%facet(k) = model%pairs(k)%points%cell
      if (audit%fixed%facet(k) <= 0.0_wp) audit%fixed%facet(k) = mean_facet(model%pairs(k), &
        model%mesh%x)
      audit%fixed%ratio(k) = slave_over_master(model%pairs(k), model%mesh%x)
      if (state%step == 0) audit%sum%work = audit%sum%work + overlap_energy(model, k)
    end do
    audit%sum%u = state%u
    audit%sum%force = state%reaction
    if (state%step > 0) then
      loads = system%loads
      call conditions_at(model, state%time, force=loads%external)
      call set_pressures(model, state%time, loads)
      audit%sum%force = audit%sum%force + loads%external
      call add_pressure_force(model%mesh%x, state%u, 1.0_wp, loads, audit%sum%force)
      audit%sum%work_known = .false.
    end if
    audit%sum%force_before = norm2(audit%sum%force)
    audit%told(check_room) = .true.
    call judge_scene(model, audit)
  end subroutine begin_audit

  !> Energy that the penalty of a pair holds in what overlaps at the start.
  real(wp) function overlap_energy(model, k) result(energy)
    type(model_t), intent(in) :: model !! pairs with their first targets
    integer, intent(in) :: k !! the pair
    real(wp) :: xi(2), gap
    integer :: p

    energy = 0.0_wp
    associate (pair => model%pairs(k), x => model%mesh%x)
      if (pair%augmented .or. pair%shrinking%shrink >= 0) return
      do p = 1, used_points(pair)
        if (pair%history%old(p)%target == 0) cycle
        call project_on_master(pair, pair%history%old(p)%target, x, point_position(pair, p, x), &
          xi, gap)
        if (gap < 0.0_wp) energy = energy + 0.5_wp*pair%points%epsilon(p)*gap**2
      end do
    end associate
  end function overlap_energy
end module scene_audit

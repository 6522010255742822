!> What of an audit can be said before the first solve: facets, locking, moved nodes, and room for
!! points (doc/theory, "Model").
module scene_audit
  use kinds, only: wp
  use model_types, only: model_t
  use contact_types, only: pair_t
  use audit_types, only: audit_t, verdict_ok, verdict_warning, check_facets, check_locking, &
    check_moved, check_room
  implicit none
  private
  public :: judge_scene, judge_room

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
end module scene_audit

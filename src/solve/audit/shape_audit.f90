!> Bodies that have turned or swollen farther than a linear theory can mean
!! (doc/theory, "Strain and rotation").
module shape_audit
  use kinds, only: wp, pi
  use model_types, only: model_t
  use sum_rows, only: turn_rows, swelling_row
  use body_measures, only: find_turns, angle_of, has_finite_strain, farthest_turn
  use body_volumes, only: find_volumes, find_part_turns
  use field_audit, only: most_rotation
  use audit_types, only: audit_t, verdict_ok, verdict_warning, verdict_failed, check_turning, &
    check_volume
  use system_types, only: system_t, state_t
  implicit none
  private
  public :: judge_turns, judge_volumes, most_swelling

  !> A volume that changes by more than this share is none that a linear theory knows of.
  real(wp), parameter :: most_swelling = 0.1_wp

contains

  !> Bodies that turn as wholes, although small strain takes their turning for strain.
  subroutine judge_turns(model, system, state, value, audit)
    type(model_t), intent(in) :: model !! the mesh
    type(system_t), intent(in) :: system !! bodies of the nodes
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: value(:) !! (sums), if there are any
    type(audit_t), intent(inout) :: audit !! gets value, worst, verdict of the turning
    real(wp) :: angle(system%body%bodies)
    logical :: judged(system%body%bodies)
    integer :: b, rows(2)

    if (state%whole) then
      call find_turns(model%mesh%x, state%u, system%body%node_body, audit%fixed%center, &
        audit%fixed%spread, angle)
      call find_mixed_turns(model, system, state, angle)
    else
      do b = 1, size(angle)
        rows = turn_rows(model, system, b)
        angle(b) = angle_of(value(rows(1):rows(2)), audit%fixed%spread(:, :, b))
      end do
    end if
    audit%value(check_turning) = 0.0_wp
    audit%worst(check_turning) = 0
    audit%verdict(check_turning) = verdict_ok
    judged = audit%fixed%moves .and. abs(audit%fixed%volume) > 0.0_wp
    if (.not. any(judged)) return
    audit%worst(check_turning) = maxloc(angle, 1, judged)
    audit%value(check_turning) = angle(audit%worst(check_turning))
    if (audit%value(check_turning) > most_rotation) audit%verdict(check_turning) = verdict_warning
    if (audit%value(check_turning) > farthest_turn*180.0_wp/pi) audit%verdict(check_turning) &
      = verdict_failed
  end subroutine judge_turns

  !> Of a body that has elements of finite strain, too, the others turn by themselves.
  subroutine find_mixed_turns(model, system, state, angle)
    type(model_t), intent(in) :: model !! the mesh
    type(system_t), intent(in) :: system !! elements, bodies
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(inout) :: angle(:) !! (bodies) those of such bodies change [degree]
    logical :: finite(0:size(angle))
    real(wp) :: turn(3, size(angle))

    finite = has_finite_strain(system)
    if (.not. any(finite(1:))) return
    call find_part_turns(model%mesh%x, state%u, system, turn)
    where (finite(1:)) angle = asin(min(1.0_wp, norm2(turn, 1)))*180.0_wp/pi
  end subroutine find_mixed_turns

  !> Volumes of what small strain deforms, against those of the reference. Without displacements
  !! inside the change is that of the linear sums.
  subroutine judge_volumes(model, system, state, value, audit)
    type(model_t), intent(in) :: model !! the mesh
    type(system_t), intent(in) :: system !! elements, bodies
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: value(:) !! (sums), if there are any
    type(audit_t), intent(inout) :: audit !! gets value, worst, verdict of the volume
    real(wp), dimension(system%body%bodies) :: change
    logical :: judged(system%body%bodies)

    judged = abs(audit%fixed%volume) > 0.0_wp
    audit%value(check_volume) = 0.0_wp
    audit%worst(check_volume) = 0
    audit%verdict(check_volume) = verdict_ok
    if (.not. any(judged)) return
    if (state%whole) then
      call find_volumes(model%mesh%x + state%u, system, change)
      change = change - audit%fixed%volume
    else
      change = value(swelling_row(model, system, 1):swelling_row(model, system, size(change)))
    end if
    where (judged) change = change/audit%fixed%volume
    audit%worst(check_volume) = maxloc(abs(change), 1, judged)
    audit%value(check_volume) = change(audit%worst(check_volume))
    if (abs(audit%value(check_volume)) > most_swelling) audit%verdict(check_volume) = verdict_failed
  end subroutine judge_volumes
end module shape_audit

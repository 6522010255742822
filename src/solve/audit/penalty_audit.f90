!> What penalties take of forces and approaches, from the energy that they hold (doc/theory,
!! "Penalty error", eq. (13.3)).
module penalty_audit
  use kinds, only: wp
  use element_types, only: status_open
  use model_types, only: model_t
  use system_types, only: system_t, state_t
  use audit_types, only: audit_t, verdict_ok, verdict_warning, check_penalty
  implicit none
  private
  public :: held_energy, judge_penalty

  !> Beyond this share a warning: forces are looked for to a percent.
  real(wp), parameter :: penalty_share = 0.01_wp
  !> Energies below this share of the largest one so far are round-off: they are sums of works that
  !! cancel, and what forces of 1e-6 of the largest do is nobody's result.
  real(wp), parameter :: least_energy = 1.0e-12_wp

contains

  !> The share of penalties in the energy that is stored, and the pair that holds most of theirs.
  subroutine judge_penalty(model, system, state, point_state, audit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements, springs
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(audit_t), intent(inout) :: audit !! energies given; gets value, worst, verdict
    real(wp) :: energy(size(model%pairs)), stored
    integer :: k

    audit%value(check_penalty) = 0.0_wp
    audit%worst(check_penalty) = 0
    audit%verdict(check_penalty) = verdict_ok
    energy = [(energy_of_pair(model, system, k, point_state), k=1, size(model%pairs))]
    stored = sum(energy) + max(audit%strain_energy, 0.0_wp)
    if (allocated(system%loads%spring)) stored = stored + 0.5_wp*sum(system%loads%spring*state%u**2)
    if (sum(energy) <= 0.0_wp .or. stored <= least_energy*audit%sum%largest_energy) return
    audit%value(check_penalty) = sum(energy)/stored
    audit%worst(check_penalty) = maxloc(energy, 1)
    if (audit%value(check_penalty) > penalty_share) audit%verdict(check_penalty) = verdict_warning
  end subroutine judge_penalty

  !> Energy of the penalties of a pair at closed points whose nodes are not all prescribed or those
  !! of rigid bodies: elsewhere no element deforms, and a penalty is what the deck says. Of AUGMent
  !! it is the work of normal forces in gaps: these are on both sides of zero, and the work of
  !! multipliers adds up to nothing.
  real(wp) function energy_of_pair(model, system, k, point_state) result(energy)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: k !! the pair
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    integer :: e

    energy = 0.0_wp
    if (model%pairs(k)%mortar) return
    do e = system%place%first_point(k), system%place%first_point(k + 1) - 1
      if (system%contact%status(e) <= status_open) cycle
      if (all(system%equation(:, system%contact%ix(1:system%contact%nel(e), e)) == 0)) cycle
      if (model%pairs(k)%augmented) then
        energy = energy - 0.5_wp*point_state(13, e)*point_state(4, e)
      else
        energy = energy + held_energy(point_state(:, e))
      end if
    end do
    energy = max(energy, 0.0_wp)
  end function energy_of_pair

  !> Energy that the penalty holds at a closed point.
  pure real(wp) function held_energy(point_state) result(energy)
    real(wp), intent(in) :: point_state(:) !! (n_element_stress) of its contact element

    energy = 0.5_wp*norm2(point_state(1:3))*hypot(point_state(4), point_state(5))
  end function held_energy
end module penalty_audit

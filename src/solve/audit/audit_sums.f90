!> The audit of an end time without displacements inside: balance, work and energy from the linear
!! sums of the condensed form (doc/theory, "Energy", eq. (13.2)).
module audit_sums
  use kinds, only: wp
  use model_types, only: model_t
  use linear_sums, only: mapped_sums, direct_works
  use sum_rows, only: body_rows, reaction_rows, load_rows
  use body_measures, only: find_balance
  use audit_types, only: audit_t
  use system_types, only: system_t, state_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: take_values, compare_balance, add_supports, add_work, energy_by_sums

contains

  !> Linear sums of an end time, from its contact forces; the works from displacements inside where
  !! these are known. Nothing where no end time does without displacements inside.
  subroutine take_values(model, system, condensed, state, value)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! sums of the condensed form
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    type(state_t), intent(in) :: state !! the converged state
    real(wp), allocatable, intent(out) :: value(:) !! (sums)

    associate (sums => condensed%sums)
      if (.not. sums%known) then
        allocate (value(0))
      else if (.not. state%whole) then
        value = sums%value
      else
        allocate (value(size(sums%value)))
        call mapped_sums(condensed, value)
        call direct_works(model, system, condensed, state, value)
      end if
    end associate
  end subroutine take_values

  !> Displacements inside are known, and so is what the end times before have made of the forces of
  !! contact alone: of both balances the worse one counts, number by number.
  subroutine compare_balance(model, system, value, audit)
    type(model_t), intent(in) :: model !! mesh, output request
    type(system_t), intent(in) :: system !! forces as accepted
    real(wp), intent(in) :: value(:) !! (sums) from the forces of contact
    type(audit_t), intent(inout) :: audit !! balance given
    real(wp) :: other(6, system%body%bodies)

    if (any(system%equation == 0 .and. abs(system%contact_force) > 0.0_wp)) return
    call find_balance(model%mesh%x, system, audit%fixed%center, other)
    call add_supports(model, value, other)
    where (abs(other) > abs(audit%balance)) audit%balance = other
  end subroutine compare_balance

  !> Adds what supports do to each body.
  pure subroutine add_supports(model, value, balance)
    type(model_t), intent(in) :: model !! output request
    real(wp), intent(in) :: value(:) !! (sums)
    real(wp), intent(inout) :: balance(:, :) !! (6, bodies) sum of forces and of moments
    integer :: b, rows(2)

    do b = 1, size(balance, 2)
      rows = body_rows(model, b)
      balance(:, b) = balance(:, b) + value(rows(1):rows(2))
    end do
  end subroutine add_supports

  !> Work of loads and supports since the last end time, from what they do on each load's motion.
  pure subroutine add_work(model, system, condensed, value, audit)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! factors of the loads
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(in) :: value(:) !! (sums)
    type(audit_t), intent(inout) :: audit !! sums of the last end time; work grows
    integer :: r(2), l(2)

    if (.not. allocated(audit%sum%factors)) return
    r = reaction_rows(model, system%body)
    l = load_rows(model, system)
    associate (before => audit%sum%value, factors => condensed%outer%factors, &
      factors_before => audit%sum%factors)
      audit%sum%work = audit%sum%work + 0.5_wp*dot_product(value(r(1):r(2)) + before(r(1):r(2)), &
        factors - factors_before) + 0.5_wp*dot_product(factors + factors_before, &
        value(l(1):l(2)) - before(l(1):l(2)))
    end associate
  end subroutine add_work

  !> Strain energy: half the work of all forces on the bulk.
  pure real(wp) function energy_by_sums(model, system, condensed, state, value) result(energy)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! factors of the loads, forces of contact
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    type(state_t), intent(in) :: state !! displacements where contact acts
    real(wp), intent(in) :: value(:) !! (sums)
    integer :: r(2), l(2), i

    r = reaction_rows(model, system%body)
    l = load_rows(model, system)
    energy = 0.5_wp*dot_product(condensed%outer%factors, value(r(1):r(2)) + value(l(1):l(2)))
    do i = 1, size(state%u, 2)
      if (condensed%candidate(i)) energy = energy &
        - 0.5_wp*dot_product(state%u(:, i), system%contact_force(:, i))
    end do
  end function energy_by_sums
end module audit_sums

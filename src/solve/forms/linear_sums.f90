!> Sums over supports and loads that are linear in the contact forces: what the rows of an end time
!! and its audit ask for where no displacements inside are (doc/theory, "Static condensation", eq.
!! (12.6)).
module linear_sums
  use kinds, only: wp
  use lapack_interface, only: dgemv
  use loads, only: add_force
  use model_types, only: model_t
  use sum_shares, only: sums_pay, begin_shares, form_shares, find_unit
  use sum_rows, only: count_sums, reaction_rows, load_rows
  use system_types, only: form_t, system_t, state_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: can_do_without, form_sums, take_sums, mapped_sums, direct_works

contains

  !> Rows and audit of an increment that has converged can do without displacements inside, and
  !! enough end times of the run do for the sums to pay.
  logical function can_do_without(model, system, condensed) result(can)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! converged
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    integer :: i

    can = condensed%active .and. .not. condensed%surface_only
    if (can) can = sums_pay(model, system)
    if (.not. can) return
    if (allocated(system%contact%reached)) then
      can = .not. any([(presses_on_support(system, system%contact%reached(i)), i=1, &
        size(system%contact%reached))])
    else
      can = .not. any([(presses_on_support(system, i), i=1, size(system%equation, 2))])
    end if
  end function can_do_without

  !> A contact force acts on a support of a node.
  pure logical function presses_on_support(system, node) result(presses)
    type(system_t), intent(in) :: system !! equations, contact forces
    integer, intent(in) :: node !! the node

    presses = any(system%equation(:, node) == 0 .and. abs(system%contact_force(:, node)) > 0.0_wp)
  end function presses_on_support

  !> What contact forces and loads do to each sum.
  subroutine form_sums(model, system, form)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! factors
    type(form_t), intent(inout) :: form !! gets sums of condensed
    real(wp) :: unit(3, model%mesh%nodes), force(3, model%mesh%nodes)
    integer :: row, k, last(2), b

    call begin_shares(model, system, form%condensed)
    last = reaction_rows(model, system%body)
    associate (sums => form%condensed%sums, loads => model%conditions%loads)
      sums%by_load = spread(spread(0.0_wp, 1, count_sums(model, system)), 2, size(loads))
      do k = 1, size(loads)
        force = 0.0_wp
        call add_force(loads(k), 1.0_wp, force)
        if (all(abs(force) <= 0.0_wp)) cycle
        do row = 1, last(2)
          call find_unit(model, system, form%condensed, row, unit)
          sums%by_load(row, k) = -sum(unit*force)
        end do
      end do
      do b = 1, size(sums%bodies)
        if (.not. allocated(sums%bodies(b)%by_load)) call form_shares(model, system, form, b, &
          .false., form%costs)
        sums%by_load = sums%by_load + sums%bodies(b)%by_load
      end do
      sums%value = spread(0.0_wp, 1, size(sums%by_load, 1))
      sums%known = .true.
    end associate
  end subroutine form_sums

  !> The sums of a converged state from its contact forces.
  subroutine take_sums(condensed)
    type(condensed_t), intent(inout) :: condensed !! gets the values of sums

    call mapped_sums(condensed, condensed%sums%value)
  end subroutine take_sums

  !> The same, handed out.
  subroutine mapped_sums(condensed, value)
    type(condensed_t), intent(in) :: condensed !! forces of contact, factors of the loads
    real(wp), intent(out) :: value(:) !! (sums)
    integer :: b

    associate (sums => condensed%sums)
      value = matmul(sums%by_load, condensed%outer%factors)
      do b = 1, size(sums%bodies)
        associate (body => condensed%bodies(b))
          if (body%m > 0) call dgemv('T', body%m, size(value), 1.0_wp, sums%bodies(b)%by_force, &
            body%m, condensed%bulk%force(body%first + 1:body%first + body%m), 1, 1.0_wp, value, 1)
        end associate
      end do
    end associate
  end subroutine mapped_sums

  !> Works of loads and reactions from displacements inside and reactions, each added up.
  subroutine direct_works(model, system, condensed, state, value)
    type(model_t), intent(in) :: model !! output request, loads
    type(system_t), intent(in) :: system !! equations, bodies
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    type(state_t), intent(in) :: state !! converged, displacements inside known
    real(wp), intent(inout) :: value(:) !! (sums) gets the works
    real(wp) :: unit(3, model%mesh%nodes)
    integer :: row, r(2), l(2)

    r = reaction_rows(model, system%body)
    l = load_rows(model, system)
    do row = r(1), l(2)
      call find_unit(model, system, condensed, row, unit)
      if (row <= r(2)) then
        value(row) = sum(unit*state%reaction)
      else
        value(row) = sum(unit*state%u)
      end if
    end do
  end subroutine direct_works
end module linear_sums

!> One system for many variants of a problem: set back to the start, with other loads, and the
!! reactions of its supports (doc/theory, "Variants of a run").
module variant_system
  use kinds, only: wp
  use element_types, only: status_off, routine_none
  use model_types, only: model_t
  use loads, only: conditions_at
  use contact_overlap, only: measure_overlap
  use contact_targets, only: start_pair
  use condensed_bodies, only: begin_influence
  use touch_types, only: touch_t
  use multiplier_types, only: multiplier_motion_t
  use sensitivity_start, only: load_bodies
  use lever_sums, only: levers_t, sum_by_levers
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: set_back, change_influence, reactions_by_levers, same_loads

contains

  !> The state before the first increment, and contact points at their first targets.
  subroutine set_back(model, system, form, state)
    type(model_t), intent(inout) :: model !! pairs get their first targets
    type(system_t), intent(inout) :: system !! factors stay, all else is at rest
    type(form_t), intent(inout) :: form !! gets condensed, du, right
    type(state_t), intent(inout) :: state !! at rest
    integer :: k

    do k = 1, size(model%pairs)
      call start_pair(model%pairs(k), model%mesh%x)
      call measure_overlap(model%pairs(k), model%mesh%x)
    end do
    state%time = 0.0_wp
    state%step = 0
    state%u = 0.0_wp
    state%reaction = 0.0_wp
    state%rigid = 0.0_wp
    system%u = 0.0_wp
    form%du = 0.0_wp
    system%contact_force = 0.0_wp
    form%inner%bulk_force = 0.0_wp
    if (allocated(system%bulk%memory)) system%bulk%memory = 0.0_wp
    form%right = 0.0_wp
    system%place%targets = 0
    associate (list => system%contact)
      list%routine = routine_none
      list%status = status_off
      list%h1 = 0.0_wp
      list%h2 = 0.0_wp
      list%shift = 0.0_wp
      list%offset = 0.0_wp
      list%slip = 0.0_wp
      list%slip_before = 0.0_wp
      list%hold = .false.
      list%slide = .false.
      list%keep = 0.0_wp
    end associate
    system%touch = touch_t()
    system%motion = multiplier_motion_t()
    associate (condensed => form%condensed)
      if (allocated(condensed%outer%kept)) deallocate (condensed%outer%kept)
      if (allocated(condensed%rigid%alpha)) condensed%rigid%alpha = 0.0_wp
    end associate
  end subroutine set_back

  !> Two problems have the same loads, whatever their tables say.
  pure logical function same_loads(a, b) result(same)
    type(model_t), intent(in) :: a !! one problem
    type(model_t), intent(in) :: b !! the other one
    integer :: k

    associate (x => a%conditions%loads, y => b%conditions%loads)
      same = size(x) == size(y)
      do k = 1, size(x)
        if (.not. same) return
        same = x(k)%table == y(k)%table .and. x(k)%displacement%n == y(k)%displacement%n .and. &
          x(k)%force%n == y(k)%force%n
        if (.not. same) return
        if (x(k)%displacement%n > 0) same = all(abs(x(k)%displacement%value( &
          :x(k)%displacement%n) - y(k)%displacement%value(:x(k)%displacement%n)) <= 0.0_wp)
        if (same .and. x(k)%force%n > 0) same = all(abs(x(k)%force%value(:x(k)%force%n) &
          - y(k)%force%value(:x(k)%force%n)) <= 0.0_wp)
      end do
    end associate
  end function same_loads

  !> Displacements for a unit of each load, anew: one substitution a body and load.
  subroutine change_influence(model, system, form)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! condensed gets influence, pushes
    type(form_t), intent(inout) :: form !! matrix given; gets condensed

    associate (condensed => form%condensed)
      deallocate (condensed%outer%influence, condensed%outer%pushes)
      call begin_influence(model, system, form)
      call load_bodies(system, form, model%conditions%loads, condensed%outer%influence)
    end associate
  end subroutine change_influence

  !> Resultants of sets of supports from contact forces, loads and prescribed values alone.
  subroutine reactions_by_levers(model, system, time, levers, reaction)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! contact forces
    real(wp), intent(in) :: time !! end of the increment
    type(levers_t), intent(in) :: levers !! of the sets
    real(wp), intent(out) :: reaction(:, :) !! (3, sets) [force]
    real(wp) :: given(3, size(levers%u, 2)), force(3, size(levers%u, 2))

    call conditions_at(model, time, displacement=given, force=force)
    force = system%contact_force - force
    call sum_by_levers(system%equation, levers, force, given, reaction)
  end subroutine reactions_by_levers
end module variant_system

!> Where an increment starts from: bodies carried along or left where they were, targets and
!! residual there.
!!
!! `prepare_start` places the two starts, `left` and `carried` of `system%position`; `choose_start`
!! takes one. A further predictor moves `carried` in the former, as `carry_bodies` does, or is tried
!! before the choice in the latter, as `start_carried`.
module increment_start
  use kinds, only: wp
  use rigid_bodies, only: return_rigid, forget_carrying
  use model_types, only: model_t
  use contact_cells, only: forget_first_cells
  use contact_parameters, only: shifts_gap
  use contact_system, only: restart_points, move_targets, load_contact
  use first_touch, only: begin_touch, begin_touch_again
  use touch_bodies, only: find_held
  use softening, only: begin_softening
  use expected_status, only: expect_status
  use point_status, only: forget_expected
  use predictor, only: carry_bodies, turn_bodies, leave_bodies, take_along
  use contact_carrying, only: carry_with_contact
  use force_scales, only: scales_of
  use bulk_term, only: start_bulk, return_bulk
  use residuals, only: form_residual, residual_norm
  use monitors, only: monitor_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: prepare_start, choose_start, start_here, start_again, start_rubbing

  !> Bodies that contact carries along start there if the residual is not more than so many times
  !! what it is without.
  real(wp), parameter :: most_energy_growth = 20.0_wp

contains

  !> The start that was not chosen at first, after the first has led nowhere.
  subroutine start_again(model, system, form, carried, monitor)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left and carried given; u becomes the start
    type(form_t), intent(inout) :: form !! its kind given; gets matrix
    logical, intent(in) :: carried !! start from the bodies carried along
    class(monitor_t), intent(inout) :: monitor !! hears of it
    real(wp) :: norm

    call begin_touch_again(system%touch)
    call begin_softening(model, system%softening)
    if (associated(form%kind%begin_anew)) call form%kind%begin_anew(form)
    if (carried) then
      call take_along(system%u, system%position, system%tools)
      call monitor%detail('  no convergence: once more with the predictor')
    else
      call leave_bodies(system%u, system%position, system%tools)
      call monitor%detail('  no convergence: once more without the predictor')
    end if
    call start_here(model, system, form, norm)
    call forget_expected(system%contact)
  end subroutine start_again

  !> Scales, first touches and the two starts of an increment: where the bodies were, and carried
  !! along.
  subroutine prepare_start(model, system, form, state, time, foretold)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! u given; gets left, carried, x_ahead
    type(form_t), intent(inout) :: form !! gets its kind
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    logical, intent(out) :: foretold !! carried is in balance with forces that are foretold
    logical :: held(0:system%body%bodies)
    integer :: k

    do k = 1, size(model%pairs)
      call forget_first_cells(model%pairs(k))
    end do
    system%scale = scales_of(model%mesh%x, state, system)
    call find_held(model, system, held)
    call begin_touch(model, system%position, system%body, held, time - state%time, system%touch)
    call begin_softening(model, system%softening)
    call start_bulk(state%u, system%bulk, form)
    system%position%left = system%u
    system%position%carried = system%u
    if (system%bulk%linear) then
      call carry_bodies(model%mesh%x, system%equation, system%body%node_body, &
        system%body%bodies, state%u, system%position%carried)
    else
      call turn_bodies(model%mesh%x, system%equation, system%body%node_body, &
        system%body%bodies, state%u, system%position%carried)
    end if
    system%position%x_ahead = model%mesh%x + system%position%carried
    foretold = .false.
    if (associated(form%kind%begin)) call form%kind%begin(model, system, form, state, time, &
      foretold)
    if (associated(form%kind%place_starts)) call form%kind%place_starts(form, system%body, &
      system%position)
  end subroutine prepare_start

  !> Starts from the bodies carried along rigidly, or from where they were, whichever leaves the
  !! smaller residual; chooses the targets there. Forces that are foretold carry the bodies well.
  subroutine choose_start(model, system, form, state, time, monitor)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! u becomes the start
    type(form_t), intent(inout) :: form !! gets its kind, matrix
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    class(monitor_t), intent(inout) :: monitor !! hears of the choice
    real(wp) :: norm
    logical :: taken, doubtful

    call prepare_start(model, system, form, state, time, taken)
    if (taken) then
      call take_along(system%u, system%position, system%tools)
      call start_here(model, system, form, norm)
      return
    end if
    call start_carried(model, system, form, state, taken)
    if (taken) return
    call take_better(model, system, form, monitor)
    if (.not. associated(form%kind%doubt_start)) return
    call form%kind%doubt_start(system, form, model%mesh%x, doubtful)
    if (doubtful) call take_better(model, system, form, monitor)
  end subroutine choose_start

  !> Starts from where bodies that contact holds roll and glide to with what they touch, if that
  !! leaves not much more than where they were: penalties make much of small ways along normals.
  subroutine start_carried(model, system, form, state, taken)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left, carried given; u may become the start
    type(form_t), intent(inout) :: form !! its kind given; gets matrix
    type(state_t), intent(in) :: state !! last converged state
    logical, intent(out) :: taken !! it has
    real(wp), allocatable :: alone(:, :)
    real(wp) :: norm, norm_left

    if (allocated(system%position%x_alone)) deallocate (system%position%x_alone)
    taken = .false.
    if (.not. any(system%body%floating)) return
    alone = system%position%carried
    call carry_with_contact(model, system, state, taken)
    if (.not. taken) return
    system%position%x_alone = system%position%x_ahead
    system%position%x_ahead = model%mesh%x + system%position%carried
    call leave_bodies(system%u, system%position, system%tools)
    call start_here(model, system, form, norm_left)
    call take_along(system%u, system%position, system%tools)
    call start_here(model, system, form, norm)
    taken = norm <= most_energy_growth*norm_left
    if (taken) return
    system%position%carried = alone
    call move_alloc(system%position%x_alone, system%position%x_ahead)
    call forget_carrying(system%tools)
  end subroutine start_carried

  !> Of the starts with and without the predictor the one that leaves the smaller residual. In the
  !! condensed form the defects of the latter, which cost next to nothing, often tell that it leaves
  !! more; not with bodies that contact holds, whose defects depend on how they move.
  subroutine take_better(model, system, form, monitor)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! left, carried given; u becomes the start
    type(form_t), intent(inout) :: form !! its kind given; gets matrix
    class(monitor_t), intent(inout) :: monitor !! hears of the choice
    real(wp) :: norm_left, norm_carried, least_left
    logical :: moved, carried_first

    moved = any(abs(system%position%carried - system%position%left) > 0.0_wp)
    carried_first = moved .and. .not. any(system%body%floating) .and. associated(form%kind%foresee)
    norm_carried = huge(1.0_wp)
    if (carried_first) then
      call leave_bodies(system%u, system%position, system%tools)
      call form%kind%foresee(system, form, carried_first, least_left)
    end if
    if (carried_first) then
      call take_along(system%u, system%position, system%tools)
      call start_here(model, system, form, norm_carried)
      if (norm_carried <= least_left) return
    end if
    call leave_bodies(system%u, system%position, system%tools)
    call start_here(model, system, form, norm_left)
    if (.not. moved) return
    if (.not. (carried_first .and. norm_left < norm_carried)) then
      call take_along(system%u, system%position, system%tools)
      call start_here(model, system, form, norm_carried)
      if (norm_carried <= norm_left) return
      call leave_bodies(system%u, system%position, system%tools)
      call start_here(model, system, form, norm_left)
    end if
    call monitor%detail('  rigid body predictor rejected: it does not lower the residual')
  end subroutine take_better

  !> Friction begins to act at points that have touched first: where forces with it are foretold,
  !! the increment goes on from there.
  subroutine start_rubbing(model, system, form, settings)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! u may be moved
    type(form_t), intent(inout) :: form !! its kind answers
    type(settings_t), intent(in) :: settings !! how far an apex may lie outside its target
    integer :: changes
    logical :: taken

    if (.not. associated(form%kind%start_rubbing)) return
    call form%kind%start_rubbing(form, system%body, system%u, taken)
    if (.not. taken) return
    if (associated(form%kind%note_moved)) call form%kind%note_moved(system, form)
    system%position%x_now = model%mesh%x + system%u
    call move_targets(model, system, form%costs, settings%extrapolation, changes)
  end subroutine start_rubbing

  !> Target facets and residual at the present u. A solve that follows needs not form them again,
  !! unless multipliers or damping are still to come.
  subroutine start_here(model, system, form, norm)
    type(model_t), intent(inout) :: model !! pairs: working points
    type(system_t), intent(inout) :: system !! u given; residual formed
    type(form_t), intent(inout) :: form !! its kind given; gets matrix
    real(wp), intent(out) :: norm !! norm of the residual there
    integer :: changes

    call return_rigid(system%u, system%tools)
    call return_bulk(model%mesh%x, system%bulk, system%volumes, system%loads, form)
    system%position%x_now = model%mesh%x + system%u
    if (size(model%pairs) > 0) then
      call restart_points(model, form%costs, system%position)
      call move_targets(model, system, form%costs, 0.0_wp, changes)
      call load_contact(model, system)
    end if
    system%place%coupled = .false.
    if (associated(form%kind%restart)) call form%kind%restart(system, form)
    call expect_status(model, system%place, system%position, system%body, system%contact)
    call form_residual(system, form, model%mesh%x)
    norm = residual_norm(system, form)
    system%place%begun = .not. (any(system%body%floating) .or. any(shifts_gap(model%pairs)))
  end subroutine start_here
end module increment_start

!> Whether a state that was read is in balance: its numbers may be those of a run one by one, and
!! yet not belong together (doc/manual, "Going on from a state").
module restored_balance
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use contact_parameters, only: first_raise
  use contact_system, only: load_contact
  use force_scales, only: force_scale
  use increment_conditions, only: take_overlaps, begin_at
  use model_types, only: model_t
  use mortar_types, only: mortar_t
  use mortar_history, only: add_forces
  use mortar_points, only: weigh_pair
  use element_types, only: routine_none
  use element_lists, only: element_list_t
  use residuals, only: form_residual, residual_norm, round_off_of
  use result_types, only: saved_state_t
  use scene_marks, only: mark_scene, mark_time
  use smooth_normals, only: renew_patches
  use full_form, only: full_form_of_system
  use system_types, only: form_t, form_kind_t, system_t, state_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: check_time, check_balance, residual_share_of

  !> What balance may lack over the force scale, where the run left less, with multipliers and
  !! without. Those of MORTar act with weights that have settled to 1e-6.
  real(wp), parameter :: least_balance = 1.0e-7_wp
  real(wp), parameter :: least_augmented = 1.0e-5_wp
  !> The same over what the run left, or over round-off, and at most.
  real(wp), parameter :: over_left = 100.0_wp
  real(wp), parameter :: most = 1.0e-2_wp

contains

  !> Refuses a state whose time is not the one that it was written with.
  subroutine check_time(path, saved, error)
    character(*), intent(in) :: path !! the file it was read from
    type(saved_state_t), intent(in) :: saved !! the state
    type(error_t), allocatable, intent(out) :: error !! another time

    if (all(saved%scene == 0) .or. all(saved%scene(3:4) == mark_time(saved%time))) return
    call refuse(path, saved, 'it was not written at its time '//to_text(saved%time), error)
  end subroutine check_time

  !> Refuses a state that is not in balance with the loads, supports, materials and pairs that it
  !! was written with. Where the deck has others now, nothing can be said.
  subroutine check_balance(path, model, system, form, state, saved, error)
    character(*), intent(in) :: path !! the file it was read from
    type(model_t), intent(inout) :: model !! pairs with the points of the state
    type(system_t), intent(inout) :: system !! residual and contact elements are overwritten
    type(form_t), intent(inout) :: form !! gets its kind
    type(state_t), intent(in) :: state !! the state, taken
    type(saved_state_t), intent(in) :: saved !! the same as read
    type(error_t), allocatable, intent(out) :: error !! it is not in balance
    real(wp) :: share, support
    type(form_kind_t) :: own
    integer :: k

    if (any(saved%scene(1:2) /= mark_scene(model, system, saved%time))) return
    own = form%kind
    form%kind = full_form_of_system()
    call form_state(model, system, form, state)
    share = least_balance
    do k = 1, size(model%pairs)
      if (model%pairs(k)%mortar) share = max(share, least_augmented)
      if (.not. model%pairs(k)%augmented) cycle
      share = max(share, least_augmented, over_left*model%pairs(k)%augment_tolerance)
    end do
    share = max(share, min(most, over_left*saved%residual))
    share = share*computed_forces(system, form) + over_left*system%scale%round_off
    support = norm2(merge(state%reaction - form%inner%bulk_force - system%contact_force &
      + system%loads%external, 0.0_wp, system%equation == 0))
    if (residual_norm(system, form) > share) then
      call refuse(path, saved, 'its residual is '//to_text(residual_norm(system, form), 3)// &
        ', where forces are '//to_text(computed_forces(system, form), 3), error)
    else if (support > share) then
      call refuse(path, saved, 'its reactions differ by '//to_text(support, 3)// &
        ' from the forces of its displacements, '//to_text(computed_forces(system, form), 3), error)
    end if
    form%kind = own
  end subroutine check_balance

  !> The residual at a state as it stands.
  subroutine form_state(model, system, form, state)
    type(model_t), intent(inout) :: model !! pairs: working points, patches
    type(system_t), intent(inout) :: system !! gets residual, forces, round_off
    type(form_t), intent(inout) :: form !! its kind answers
    type(state_t), intent(in) :: state !! the state
    integer :: k

    call take_overlaps(model, state%time)
    call begin_at(model, state, state%time, system%equation, system%u, system%loads, system%tools)
    system%u = state%u
    system%position%x_now = model%mesh%x + state%u
    do k = 1, size(model%pairs)
      if (model%pairs(k)%smooth) call renew_patches(model%pairs(k), model%mesh%x, state%u)
      model%pairs(k)%history%raise = 1.0_wp
      if (model%pairs(k)%history%softened) model%pairs(k)%history%raise = &
        first_raise(model%pairs(k))
    end do
    call load_contact(model, system)
    call form_residual(system, form, model%mesh%x)
    if (any(model%pairs%mortar)) then
      call weigh_multipliers(model, system%place, system%contact, system%position%x_now, &
        system%contact_force)
      call form%kind%gather(system, form, 0.0_wp, .false.)
    end if
    system%scale%round_off = round_off_of(system, form, model%mesh%x)
  end subroutine form_state

  !> With MORTar: the forces of multipliers and of other points, weighed at the state, in the place
  !! of those of the contact elements.
  subroutine weigh_multipliers(model, place, contact, x_now, force)
    type(model_t), intent(in) :: model !! pairs with the multipliers of the state
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    type(element_list_t), intent(in) :: contact !! contact elements: which take part
    real(wp), intent(in) :: x_now(:, :) !! (3, nodes) positions at the state [length]
    real(wp), intent(out) :: force(:, :) !! (3, nodes) internal force of contact [force]
    type(mortar_t) :: nodes
    integer :: k

    force = 0.0_wp
    do k = 1, size(model%pairs)
      associate (first => place%first_point(k), last => place%first_point(k + 1) - 1)
        call weigh_pair(model%pairs(k), contact%routine(first:last) /= routine_none, x_now, x_now, &
          nodes)
        call add_forces(nodes, force)
      end associate
    end do
  end subroutine weigh_multipliers

  !> Norm of loads, contact forces and forces of the supports as they follow from displacements.
  pure real(wp) function computed_forces(system, form) result(norm)
    type(system_t), intent(in) :: system !! residual formed
    type(form_t), intent(in) :: form !! forces of the bulk

    norm = norm2([norm2(system%loads%external), norm2(system%contact_force), norm2(merge( &
      form%inner%bulk_force + system%contact_force, 0.0_wp, system%equation == 0))])
  end function computed_forces

  !> What the residual of an accepted state was, over the force scale.
  pure real(wp) function residual_share_of(system, form) result(share)
    type(system_t), intent(in) :: system !! as accepted
    type(form_t), intent(in) :: form !! its kind answers

    share = 0.0_wp
    if (force_scale(system%scale) > 0.0_wp) share = residual_norm(system, &
      form)/force_scale(system%scale)
  end function residual_share_of

  !> Says that a state cannot be taken, and why.
  subroutine refuse(path, saved, why, error)
    character(*), intent(in) :: path !! the file it was read from
    type(saved_state_t), intent(in) :: saved !! the state
    character(*), intent(in) :: why !! what is wrong
    type(error_t), allocatable, intent(out) :: error !! the message

    call raise(error, exit_deck, 'error: the state of step '//to_text(saved%step)//' in '//path// &
      ' is not in balance with this deck, with which it was written: '//why//new_line('a')// &
      '  something has changed the file; restart from an earlier --step')
  end subroutine refuse
end module restored_balance

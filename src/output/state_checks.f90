!> Holds a state that was read against what a state can be: a sum over it says only that it is the
!! one that was written.
module state_checks
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use contact_types, only: pair_t, contact_point_t, status_off, status_open, status_slip
  use contact_points, only: count_points
  use model_types, only: model_t
  use result_types, only: saved_state_t, pair_history_t
  implicit none
  private
  public :: check_state

  !> An apex lies in its target, or beside it by this share of it at most: at a boundary.
  real(wp), parameter :: beside_target = 0.5_wp

contains

  !> Refuses a state that no run can have written, with its reason.
  subroutine check_state(path, model, state, error)
    character(*), intent(in) :: path !! the file it was read from
    type(model_t), intent(in) :: model !! the problem
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! what is wrong with it
    character(:), allocatable :: why
    integer :: k

    why = ''
    if (.not. all(ieee_is_finite([state%time, state%increment]))) then
      why = 'its time or increment is not a number'
    else if (state%time <= 0.0_wp .or. state%increment <= 0.0_wp) then
      why = 'its time '//to_text(state%time)//' or its increment '//to_text(state%increment)// &
        ' is not positive'
    else if (.not. all(ieee_is_finite(state%displacement))) then
      why = 'a displacement is not a number'
    else if (.not. all(ieee_is_finite(state%reaction))) then
      why = 'a reaction is not a number'
    else if (.not. all(ieee_is_finite([state%residual]))) then
      why = 'its residual is not a number'
    else if (allocated(state%candidate)) then
      if (any(state%candidate < 0 .or. state%candidate > 1)) then
        why = 'the nodes held for contact are not marked by 0 and 1'
      else if (.not. all(ieee_is_finite(state%contact_force))) then
        why = 'a contact force is not a number'
      end if
    end if
    if (len(why) == 0 .and. allocated(state%displacement_before)) then
      if (.not. all(ieee_is_finite([state%span_before, state%displacement_before]))) then
        why = 'the state before it holds what is not a number'
      end if
    end if
    if (len(why) == 0 .and. allocated(state%factor_displacement)) then
      if (.not. all(ieee_is_finite([state%factor_aging, state%factor_displacement]))) &
        why = 'that of its factors holds what is not a number'
    end if
    if (len(why) == 0 .and. allocated(state%slopes%apex)) then
      if (.not. all(ieee_is_finite([state%slopes%apex, state%slopes%place, &
        state%slopes%force]))) why = 'a derivative is not a number'
    end if
    do k = 1, size(model%pairs)
      if (len(why) == 0) call check_pair(model%pairs(k), state%pairs(k), why)
    end do
    if (len(why) > 0) call raise(error, exit_deck, 'error: the state of step '// &
      to_text(state%step)//' in '//path//' cannot be one of a run: '//why//new_line('a')// &
      '  something has changed the file; restart from an earlier --step')
  end subroutine check_state

  !> Looks at the points of one pair.
  subroutine check_pair(pair, history, why)
    type(pair_t), intent(in) :: pair !! the pair
    type(pair_history_t), intent(in) :: history !! its history
    character(:), allocatable, intent(inout) :: why !! what is wrong, if anything is
    integer :: p

    do p = 1, count_points(pair)
      if (len(why) == 0) why = fault_of(history%points(p), size(pair%surface%facets, 2))
      if (len(why) == 0 .and. allocated(history%cells)) then
        associate (cell => history%cells(p))
          if (.not. all(ieee_is_finite([cell%weight, cell%area, cell%place]))) then
            why = 'its cell holds what is not a number'
          else if (cell%area < 0.0_wp) then
            why = 'its area is negative'
          end if
        end associate
      end if
      if (len(why) == 0 .and. allocated(history%multipliers)) why = fault_of_multiplier(history, p)
      if (len(why) == 0) cycle
      why = 'point '//to_text(p)//' of pair '//pair%name//': '//why
      return
    end do
  end subroutine check_pair

  !> What is wrong with one point; empty if nothing is.
  function fault_of(point, facets) result(why)
    type(contact_point_t), intent(in) :: point !! the point
    integer, intent(in) :: facets !! facets of its pair
    character(:), allocatable :: why
    real(wp) :: least

    why = ''
    if (point%status < status_off .or. point%status > status_slip) then
      why = 'its status is '//to_text(point%status)
    else if (point%target < 0 .or. point%target > facets) then
      why = 'its facet is '//to_text(point%target)
    else if (point%status > status_open .and. point%target == 0) then
      why = 'it is closed and has no facet'
    else if (.not. all(ieee_is_finite([point%apex, point%lambda, point%way, &
      point%dissipation, point%path]))) then
      why = 'its history holds what is not a number'
    else if (point%status > status_open) then
      least = min(point%apex(1), point%apex(2), 1.0_wp - point%apex(1) - point%apex(2))
      if (least < -beside_target) why = 'its apex ('//to_text(point%apex(1))//', '// &
        to_text(point%apex(2))//') lies outside of its facet'
    end if
  end function fault_of

  !> The same of a multiplier.
  function fault_of_multiplier(history, p) result(why)
    type(pair_history_t), intent(in) :: history !! of a pair with MORTar
    integer, intent(in) :: p !! its place
    character(:), allocatable :: why

    why = ''
    associate (one => history%multipliers(p))
      if (one%node < 0 .or. (one%node > 0 .and. one%face < 1)) then
        why = 'its multiplier belongs to no node'
      else if (one%status < status_open .or. one%status > status_slip) then
        why = 'the status of its multiplier is '//to_text(one%status)
      else if (.not. all(ieee_is_finite([one%axis, one%normal, one%force, one%path, one%way, &
        one%dissipation]))) then
        why = 'its multiplier holds what is not a number'
      end if
    end associate
  end function fault_of_multiplier
end module state_checks

!> Parameters d of the contact element of one point of a pair.
module contact_parameters
  use kinds, only: wp, pi
  use elmlib, only: n_parameters, routine_mfec, routine_smooth
  use elmt03, only: d03_epsilon, d03_mu, d03_rule, d03_axis_kind, d03_axis, d03_turn, &
    axis_convected, axis_space_fixed
  use elmt04, only: d04_patch, d04_size
  use contact_types, only: pair_t
  implicit none
  private
  public :: point_parameters, pair_routine

contains

  !> The contact element of a pair.
  pure integer function pair_routine(pair) result(routine)
    type(pair_t), intent(in) :: pair !! the pair

    routine = routine_mfec
    if (pair%smooth) routine = routine_smooth
  end function pair_routine

  !> The d of elmt03 or elmt04 for one point on one facet.
  pure function point_parameters(pair, p, facet) result(d)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: facet !! its host
    real(wp) :: d(n_parameters)

    d(d04_patch:d04_size) = 0.0_wp
    if (pair%smooth) d(d04_patch:d04_size) = pair%patch(:, facet)
    d(d03_epsilon) = pair%epsilon(p)
    d(d03_mu:d03_mu + 1) = pair%mu
    d(d03_rule) = real(pair%slip_rule, wp)
    d(d03_turn:d03_turn + 1) = [cos(pair%angle*pi/180.0_wp), sin(pair%angle*pi/180.0_wp)]
    if (pair%convected .and. allocated(pair%lay)) then
      d(d03_axis_kind) = real(axis_convected, wp)
      d(d03_axis:d03_axis + 2) = [pair%lay(:, facet), 0.0_wp]
    else
      d(d03_axis_kind) = real(axis_space_fixed, wp)
      d(d03_axis:d03_axis + 2) = pair%axis
    end if
  end function point_parameters
end module contact_parameters

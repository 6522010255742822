!> Parameters d of the contact element of one point of a pair.
module contact_parameters
  use kinds, only: wp, pi
  use element_parameters, only: n_parameters, d03_epsilon, d03_mu, d03_law, d03_area, d03_rule, &
    d03_axis_kind, d03_axis, d03_turn, d03_place, axis_convected, axis_space_fixed, &
    axis_circumferential, axis_radial, d04_patch
  use friction_laws, only: any_acts
  use contact_types, only: pair_t, contact_point_t, penalty_own, direction_circumferential, &
    direction_radial, direction_field
  implicit none
  private
  public :: point_parameters, point_shift, first_raise, raise_along, is_stiff, &
    is_round_off, has_multipliers, shifts_gap, has_field, field_penalty, most_updates, &
    stiffest_plain

  !> The first solve of an increment with multipliers has a penalty of at most this times E/h: with
  !! a stiffer one Newton's method is less sure.
  real(wp), parameter :: stiffest_start = 10.0_wp
  !> Pairs whose multipliers are a field have a penalty of this times E/h, whatever the deck says
  !! (doc/theory, "Multiplier fields").
  real(wp), parameter :: field_penalty = 100.0_wp
  !> Updates of the multipliers in an increment unless the deck says how many, with nodes and with
  !! a field.
  integer, parameter :: most_updates_of_nodes = 25
  integer, parameter :: most_updates_of_field = 50
  !> Above this times E/h a penalty makes Newton's method slow and costs digits of the gap that it
  !! multiplies: the force comes from a softer one and a multiplier.
  real(wp), parameter :: stiffest_plain = 100.0_wp
  !> Above this times E/h, without multipliers, the round-off of positions makes forces as large as
  !! those of the stresses, and a residual of that size means nothing any more.
  real(wp), parameter :: stiffest_exact = 1.0e11_wp

contains

  !> The d of elmt03 or elmt04 for one point on one facet.
  pure function point_parameters(pair, p, facet) result(d)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: facet !! its target
    real(wp) :: d(n_parameters)

    d = 0.0_wp
    if (pair%smooth) d(d04_patch:n_parameters) = pair%surface%patch(:, facet)
    d(d03_epsilon) = pair%history%raise*pair%points%epsilon(p)
    d(d03_mu:d03_mu + 1) = pair%friction%mu
    d(d03_law:d03_area - 1) = pair%law
    if (any_acts(pair%law)) d(d03_area) = pair%points%area(p)
    d(d03_rule) = real(pair%friction%slip_rule, wp)
    d(d03_turn:d03_turn + 1) = [cos(pair%friction%angle*pi/180.0_wp), &
      sin(pair%friction%angle*pi/180.0_wp)]
    if (pair%friction%convected .and. allocated(pair%surface%lay)) then
      d(d03_axis_kind) = real(axis_convected, wp)
      d(d03_axis:d03_axis + 1) = pair%surface%lay(1:2, facet)
      d(d03_place:d03_place + 3) = pair%surface%lay(3:6, facet)
      return
    end if
    d(d03_axis:d03_axis + 2) = pair%friction%axis
    d(d03_place:d03_place + 2) = pair%friction%point
    select case (pair%friction%direction)
    case (direction_circumferential)
      d(d03_axis_kind) = real(axis_circumferential, wp)
    case (direction_radial)
      d(d03_axis_kind) = real(axis_radial, wp)
    case (direction_field)
      d(d03_axis_kind) = real(axis_space_fixed, wp)
      d(d03_axis:d03_axis + 2) = pair%surface%facet_axis(:, facet)
    case default
      d(d03_axis_kind) = real(axis_space_fixed, wp)
    end select
  end function point_parameters

  !> The shift of the gap that the multiplier of a point stands for (doc/theory, "Augmented
  !! Lagrangian").
  pure function point_shift(pair, p, point) result(kappa)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(in) :: point !! its state
    real(wp) :: kappa(3)

    kappa = 0.0_wp
    if (pair%augmented) kappa = point%lambda/(pair%history%raise*pair%points%epsilon(p))
    if (pair%history%softened) kappa = point%lambda*(1.0_wp - &
      pair%history%raise)/(pair%history%raise*pair%points%epsilon(p))
  end function point_shift

  !> Factor on the penalty for the first solve of an increment.
  pure real(wp) function first_raise(pair) result(raise)
    type(pair_t), intent(in) :: pair !! the pair

    raise = 1.0_wp
    if (.not. shifts_gap(pair)) return
    if (pair%points%relative > stiffest_start) raise = stiffest_start/pair%points%relative
  end function first_raise

  !> The same where multipliers come along: that of a field, and at nodes one that is not too soft.
  pure real(wp) function raise_along(pair) result(raise)
    type(pair_t), intent(in) :: pair !! the pair

    raise = pair%history%raise
    if (has_field(pair)) raise = 1.0_wp
    if (pair%augmented .and. pair%points%relative > 0.0_wp) raise = max(raise, &
      stiffest_start/pair%points%relative)
  end function raise_along

  !> The penalty is so stiff that it is solved for by multipliers (doc/theory, "Stiff penalties",
  !! eq. (7.12)). Points of facets would be more than their nodes can follow, but that AUTO's own
  !! penalty is never far above the limit; those of cells move.
  elemental logical function is_stiff(pair)
    type(pair_t), intent(in) :: pair !! the pair

    is_stiff = .not. (pair%augmented .or. pair%segmented) .and. pair%shrinking%shrink < 0 .and. &
      pair%points%relative > stiffest_plain .and. (pair%points%n_slaves == 1 .or. &
      pair%penalty_kind == penalty_own)
  end function is_stiff

  !> Without help by multipliers the penalty would make forces of nothing but round-off.
  elemental logical function is_round_off(pair)
    type(pair_t), intent(in) :: pair !! the pair

    is_round_off = .not. pair%augmented .and. pair%points%relative > stiffest_exact
  end function is_round_off

  !> Forces of the pair come partly from multipliers in this increment.
  elemental logical function shifts_gap(pair)
    type(pair_t), intent(in) :: pair !! the pair

    shifts_gap = pair%augmented .or. pair%history%softened
  end function shifts_gap

  !> The multipliers of the pair are a field on its slave facets (doc/theory, "Multiplier fields").
  elemental logical function has_field(pair)
    type(pair_t), intent(in) :: pair !! the pair

    has_field = pair%augmented .and. pair%points%n_slaves > 1
  end function has_field

  !> Most updates of the multipliers in an increment.
  elemental integer function most_updates(pair) result(most)
    type(pair_t), intent(in) :: pair !! the pair

    most = most_updates_of_nodes
    if (has_field(pair)) most = most_updates_of_field
    if (pair%augment_most > 0) most = pair%augment_most
  end function most_updates

  !> The points of the pair carry multipliers from one increment to the next.
  elemental logical function has_multipliers(pair)
    type(pair_t), intent(in) :: pair !! the pair

    has_multipliers = pair%augmented .or. is_stiff(pair)
  end function has_multipliers
end module contact_parameters

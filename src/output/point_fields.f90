!> What a results file holds of each contact point: values, declaration and place of each field.
module point_fields
  use, intrinsic :: iso_c_binding, only: c_loc, c_null_ptr, c_ptr
  use kinds, only: wp
  use friction_laws, only: slip_path
  use contact_types, only: pair_t
  use result_fields, only: field_t, over_points, over_near, over_closed
  use hdf5_data, only: stored_real, stored_integer
  implicit none
  private
  public :: point_fields_t, contact_fields, address_of, is_written, has_offset, has_lift

  !> The contact points of one pair at one time.
  type :: point_fields_t
    integer, allocatable :: target(:) !! (points) facet of the pair that holds the apex, 0 for none
    integer, allocatable :: status(:) !! (points) one of the status constants
    real(wp), allocatable :: traction(:, :) !! (3, points) contact force on the slave [force]
    real(wp), allocatable :: gap(:) !! (points) normal gap g_N [length]
    real(wp), allocatable :: apex(:, :) !! (2, points) (xi, eta) of the apex in the target facet
    real(wp), allocatable :: lay(:, :) !! (3, points) unit principal axis of mu1 in the facet
    real(wp), allocatable :: lay_traction(:, :) !! (3, points) along p1, p2 and the normal [force]
    real(wp), allocatable :: elastic_slip(:) !! (points) tangential part of the gap [length]
    real(wp), allocatable :: path(:) !! (points) way slipped since the touch [length]
    real(wp), allocatable :: way(:, :) !! (3, points) the same with its directions [length]
    real(wp), allocatable :: dissipation(:) !! (points) work of friction so far [force length]
    real(wp), allocatable :: normal_force(:) !! (points) magnitude of its normal part [force]
    real(wp), allocatable :: normal(:, :) !! (3, points) outward unit normal of the master
    real(wp), allocatable :: slip(:, :) !! (3, points) displacement against the master [length]
    real(wp), allocatable :: area(:) !! (points) weight in means: reference area, 1 for nodes
    real(wp), allocatable :: cell(:) !! (points) if segmented: reference area
    integer, allocatable :: facet(:) !! (points) slave facet, 0 for a node, -1 not in use
    integer, allocatable :: node(:, :) !! (3 or 6, points) if segmented: nodes of the slave facet
    real(wp), allocatable :: weight(:, :) !! (3 or 6, points) if segmented: their weights
    real(wp), allocatable :: place(:, :) !! (2, points) if segmented: (xi, eta) when they were made
    real(wp), allocatable :: start(:, :) !! (2, closed) apex in its target at the increment's start
    real(wp), allocatable :: offset(:) !! (near) if there may be one: added to the gap [length]
    real(wp), allocatable :: lift(:) !! (near) if smooth: height over the slave facet [length]
    real(wp), allocatable :: multiplier(:, :) !! (3, points) with AUGMent: force without gap [force]
    real(wp), allocatable :: patch(:, :) !! (n_patch_values, targets) if smooth: patches
    integer, allocatable :: touch_node(:) !! (nodes of closed points) if points have touched first
    real(wp), allocatable :: touch(:, :) !! (4, these) displacement without friction at new points
    !! [length], first touch of the body as a share of the increment, -1 where none is foreseen
  end type point_fields_t

  !> When a field is there.
  integer, parameter :: part_always = 0 !! always
  integer, parameter :: part_offset = 1 !! with `SHRInk`, or `SMOOth` surfaces that overlap
  integer, parameter :: part_lift = 2 !! `GTOS` with `SMOOth`
  integer, parameter :: part_point_multiplier = 3 !! with `AUGMent`
  integer, parameter :: part_place = 4 !! with `SEGMent` and `MORTar`

  !> What is written of each point at each end time.
  type(field_t), parameter :: contact_fields(*) = [ &
    field_t('host', stored_integer, 1, over_points, '1', &
    'master facet that holds the apex, from 1, 0 for none', part_always), &
    field_t('status', stored_integer, 1, over_points, '1', '-1 off, 0 open, 1 stick, 2 slip', &
    part_always), &
    field_t('traction', stored_real, 3, over_points, 'force', &
    'contact traction times tributary area: the force on the slave point', part_always), &
    field_t('gap', stored_real, 1, over_points, 'length', 'normal gap g_N, negative in contact', &
    part_always), &
    field_t('tip', stored_real, 2, over_points, '1', &
    '(xi, eta) of the apex of the friction cone in its facet', part_always), &
    field_t('lay', stored_real, 3, over_points, '1', &
    'unit principal axis of mu1 in the current facet', part_always), &
    field_t('lay_traction', stored_real, 3, over_points, 'force', &
    'traction along the axis of mu1, across it, and along the outward normal', part_always), &
    field_t('elastic_slip', stored_real, 1, over_points, 'length', &
    'length of the tangential part of the gap vector', part_always), &
    field_t('dissipation', stored_real, 1, over_points, 'force length', &
    'work that friction has taken up to now', part_always), &
    field_t(slip_path%name, stored_real, 1, over_points, slip_path%unit, slip_path%description, &
    part_always), &
    field_t('frictional_slip', stored_real, 3, over_points, 'length', &
    'this path with its directions: sum of the slip over the master', part_always), &
    field_t('start_tip', stored_real, 2, over_closed, '1', &
    'apex that the last increment began with, in the facet of host', part_always), &
    field_t('offset', stored_real, 1, over_near, 'length', &
    'part of the gap that is not between the surfaces: what is withheld of an overlap', &
    part_offset), &
    field_t('lift', stored_real, 1, over_near, 'length', &
    'height of the point over its flat slave facet', part_lift), &
    field_t('multiplier', stored_real, 3, over_points, 'force', &
    'force on the master without a gap, along a1, e x a1 and e of the facet', &
    part_point_multiplier), &
    field_t('place', stored_real, 2, over_points, '1', &
    '(xi, eta) of the point in its facet when its cell was made', part_place)]

contains

  !> Whether a field is written of a pair.
  pure logical function is_written(field, pair) result(written)
    type(field_t), intent(in) :: field !! one of contact_fields
    type(pair_t), intent(in) :: pair !! the pair

    select case (field%part)
    case (part_offset)
      written = has_offset(pair)
    case (part_lift)
      written = has_lift(pair)
    case (part_point_multiplier)
      written = pair%augmented
    case (part_place)
      written = pair%segmented
    case default
      written = .true.
    end select
  end function is_written

  !> Whether the gap of a pair may hold what is not between its surfaces.
  pure logical function has_offset(pair)
    type(pair_t), intent(in) :: pair !! the pair

    has_offset = pair%shrinking%shrink >= 0 .or. allocated(pair%shrinking%excess) .or. &
      allocated(pair%surface%excess)
  end function has_offset

  !> Whether points of a pair stand over their slave facets.
  pure logical function has_lift(pair)
    type(pair_t), intent(in) :: pair !! the pair

    has_lift = pair%smooth .and. pair%points%n_slaves > 1
  end function has_lift

  !> Where the numbers of a field are: one run of them; null if they are not there.
  function address_of(points, name) result(address)
    type(point_fields_t), pointer, intent(in) :: points !! the points of a pair
    character(*), intent(in) :: name !! the field
    type(c_ptr) :: address

    address = c_null_ptr
    select case (name)
    case ('host')
      address = c_loc(points%target)
    case ('status')
      address = c_loc(points%status)
    case ('traction')
      address = c_loc(points%traction)
    case ('gap')
      address = c_loc(points%gap)
    case ('tip')
      address = c_loc(points%apex)
    case ('lay')
      address = c_loc(points%lay)
    case ('lay_traction')
      address = c_loc(points%lay_traction)
    case ('elastic_slip')
      address = c_loc(points%elastic_slip)
    case ('dissipation')
      address = c_loc(points%dissipation)
    case (slip_path%name)
      if (allocated(points%path)) address = c_loc(points%path)
    case ('frictional_slip')
      if (allocated(points%way)) address = c_loc(points%way)
    case ('start_tip')
      if (allocated(points%start)) address = c_loc(points%start)
    case ('offset')
      if (allocated(points%offset)) address = c_loc(points%offset)
    case ('lift')
      if (allocated(points%lift)) address = c_loc(points%lift)
    case ('multiplier')
      if (allocated(points%multiplier)) address = c_loc(points%multiplier)
    case ('place')
      if (allocated(points%place)) address = c_loc(points%place)
    end select
  end function address_of
end module point_fields

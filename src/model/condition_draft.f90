!> Conditions while the deck is being read, with the places that set them.
module condition_draft
  use kinds, only: wp
  use deck_types, only: location_t, record_t
  use model_types, only: conditions_t
  use records, only: item_location, item_real
  implicit none
  private
  public :: condition_draft_t, start_draft, set_values, record_values
  public :: quantity_restraint, quantity_displacement, quantity_force, quantity_load

  !> What a data set prescribes.
  integer, parameter :: quantity_restraint = 1 !! BOUN EBOU CBOU
  integer, parameter :: quantity_displacement = 2 !! DISP EDIS CDIS
  integer, parameter :: quantity_force = 3 !! FORC EFOR CFOR
  integer, parameter :: quantity_load = 4 !! FPRO EPRO CPRO

  !> Conditions and, for later checks, the items that prescribe displacements.
  type :: condition_draft_t
    type(conditions_t) :: conditions !! what has been read so far
    type(location_t), allocatable :: displacement_at(:, :) !! (3, nodes) item of the value
  end type condition_draft_t

contains

  !> A draft without any condition.
  subroutine start_draft(nodes, draft)
    integer, intent(in) :: nodes !! number of nodes
    type(condition_draft_t), intent(out) :: draft !! the empty draft

    allocate (draft%conditions%restrained(3, nodes), source=.false.)
    allocate (draft%conditions%displacement(3, nodes), source=0.0_wp)
    allocate (draft%conditions%force(3, nodes), source=0.0_wp)
    allocate (draft%conditions%load(3, nodes), source=0)
    allocate (draft%displacement_at(3, nodes))
  end subroutine start_draft

  !> The three values of a record behind `before` other items, 0 where there is none.
  pure function record_values(record, before) result(values)
    type(record_t), intent(in) :: record !! a data record
    integer, intent(in) :: before !! number of items before the values
    real(wp) :: values(3)
    integer :: k

    do k = 1, 3
      values(k) = item_real(record, before + k)
    end do
  end function record_values

  !> Sets the values of one node: restraint codes add, for the others the last one wins.
  subroutine set_values(draft, quantity, node, values, record, before)
    type(condition_draft_t), intent(inout) :: draft !! the draft
    integer, intent(in) :: quantity !! one of the quantities above
    integer, intent(in) :: node !! an existing node
    real(wp), intent(in) :: values(3) !! one value per degree of freedom
    type(record_t), intent(in) :: record !! the record that sets them
    integer, intent(in) :: before !! number of items before its values
    integer :: k

    select case (quantity)
    case (quantity_restraint)
      where (abs(values) > 0.0_wp) draft%conditions%restrained(:, node) = .true.
    case (quantity_force)
      draft%conditions%force(:, node) = values
    case (quantity_load)
      draft%conditions%load(:, node) = nint(values)
    case default
      draft%conditions%displacement(:, node) = values
      do k = 1, 3
        draft%displacement_at(k, node) = item_location(record, before + k)
      end do
    end select
  end subroutine set_values
end module condition_draft

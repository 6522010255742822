!> Conditions while the deck is being read, with the places that set them.
module condition_draft
  use kinds, only: wp
  use deck_types, only: location_t, record_t
  use model_types, only: conditions_t, load_t
  use loads, only: add_values, append_values, join_load, list_loads
  use records, only: item_count, item_integer, item_location, item_real
  implicit none
  private
  public :: condition_draft_t, start_draft, set_values, record_values, record_table, finish_draft
  public :: quantity_restraint, quantity_displacement, quantity_force, quantity_load

  !> What a data set prescribes.
  integer, parameter :: quantity_restraint = 1 !! BOUN EBOU CBOU
  integer, parameter :: quantity_displacement = 2 !! DISP EDIS CDIS
  integer, parameter :: quantity_force = 3 !! FORC EFOR CFOR
  integer, parameter :: quantity_load = 4 !! FPRO EPRO CPRO

  !> Of a record that does not name a table: its values take the place of those before.
  integer, parameter :: no_table = -1

  !> Conditions and, for later checks, the items that prescribe displacements.
  type :: condition_draft_t
    logical, allocatable :: restrained(:, :) !! (3, nodes) displacement is prescribed
    real(wp), allocatable :: displacement(:, :) !! (3, nodes) of records without a table [length]
    real(wp), allocatable :: force(:, :) !! (3, nodes) likewise [force]
    integer, allocatable :: table(:, :) !! (3, nodes) their tables, 0 for the sum of all
    type(load_t), allocatable :: added(:) !! loads of records with a table
    type(load_t), allocatable :: turns(:) !! rotations
    type(location_t), allocatable :: displacement_at(:, :) !! (3, nodes) item of the value
  end type condition_draft_t

contains

  !> A draft without any condition.
  subroutine start_draft(nodes, draft)
    integer, intent(in) :: nodes !! number of nodes
    type(condition_draft_t), intent(out) :: draft !! the empty draft

    allocate (draft%restrained(3, nodes), source=.false.)
    allocate (draft%displacement(3, nodes), draft%force(3, nodes), source=0.0_wp)
    allocate (draft%table(3, nodes), source=0)
    allocate (draft%displacement_at(3, nodes), draft%added(0), draft%turns(0))
  end subroutine start_draft

  !> The conditions of a draft: one load for each table, in the order in which nodes ask for them.
  pure subroutine finish_draft(draft, conditions)
    type(condition_draft_t), intent(in) :: draft !! all records read
    type(conditions_t), intent(out) :: conditions !! the conditions
    integer :: i, place

    conditions%restrained = draft%restrained
    call list_loads(draft%displacement, draft%force, draft%table, conditions%loads)
    do i = 1, size(draft%added)
      call join_load(conditions%loads, draft%added(i)%table, place)
      call append_values(draft%added(i)%displacement, conditions%loads(place)%displacement)
      call append_values(draft%added(i)%force, conditions%loads(place)%force)
    end do
    conditions%loads = [conditions%loads, draft%turns]
  end subroutine finish_draft

  !> The table that a record names behind its three values, or no_table.
  pure integer function record_table(record, before) result(table)
    type(record_t), intent(in) :: record !! a data record of forces or displacements
    integer, intent(in) :: before !! number of items before the values

    table = no_table
    if (item_count(record) > before + 3) table = item_integer(record, before + 4)
  end function record_table

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

  !> Sets the values of one node: restraint codes add, values with a table add, for the others the
  !! last one wins.
  subroutine set_values(draft, quantity, node, values, record, before)
    type(condition_draft_t), intent(inout) :: draft !! the draft
    integer, intent(in) :: quantity !! one of the quantities above
    integer, intent(in) :: node !! an existing node
    real(wp), intent(in) :: values(3) !! one value per degree of freedom
    type(record_t), intent(in) :: record !! the record that sets them
    integer, intent(in) :: before !! number of items before its values
    integer :: k, table, place

    table = no_table
    if (any(quantity == [quantity_force, quantity_displacement])) &
      table = record_table(record, before)
    if (table /= no_table) call join_load(draft%added, table, place)
    select case (quantity)
    case (quantity_restraint)
      where (abs(values) > 0.0_wp) draft%restrained(:, node) = .true.
    case (quantity_force)
      if (table == no_table) draft%force(:, node) = values
      if (table /= no_table) call add_values(draft%added(place)%force, node, values)
    case (quantity_load)
      draft%table(:, node) = nint(values)
    case default
      if (table == no_table) draft%displacement(:, node) = values
      if (table /= no_table) call add_values(draft%added(place)%displacement, node, values)
      do k = 1, 3
        if (table == no_table .or. abs(values(k)) > 0.0_wp) &
          draft%displacement_at(k, node) = item_location(record, before + k)
      end do
    end select
  end subroutine set_values
end module condition_draft

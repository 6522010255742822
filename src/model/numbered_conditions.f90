!> Conditions given by node numbers, with FEAP's generation, or by a name in place of the number.
module numbered_conditions
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: data_set_t, record_t, item_word, item_quoted
  use records, only: item_location, item_integer, item_name
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use mesh_names, only: find_surface
  use tied_nodes, only: kept_node
  use node_sets, only: node_exists
  use node_queries, only: report_missing_node, nodes_of_item
  use condition_draft, only: condition_draft_t, set_values, record_values, record_table, &
    quantity_restraint, quantity_force, quantity_load
  implicit none
  private
  public :: read_numbered_conditions

  !> The record that a generation starts from.
  type :: generation_t
    integer :: node = 0 !! its node, 0 when there is nothing to start from
    integer :: increment = 0 !! its increment, 0 for no generation
    real(wp) :: values(3) = 0.0_wp !! its values
    integer :: table = 0 !! the table it names
  end type generation_t

contains

  !> Reads one BOUN, DISP, FORC or FPRO data set.
  subroutine read_numbered_conditions(set, quantity, mesh, diagnostics, draft)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: quantity !! what it prescribes
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    type(generation_t) :: previous
    integer :: i, kind

    do i = 1, set%count
      if (.not. allocated(set%records(i)%items)) cycle
      kind = set%records(i)%items(1)%kind
      if (kind == item_word .or. kind == item_quoted) then
        call set_named(set%records(i), quantity, mesh, diagnostics, draft)
        previous = generation_t()
      else
        call set_numbered(set%records(i), quantity, mesh, diagnostics, draft, previous)
      end if
    end do
  end subroutine read_numbered_conditions

  !> A record that begins with the name of a set, region or surface.
  subroutine set_named(record, quantity, mesh, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: quantity !! what it prescribes
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    integer, allocatable :: nodes(:)
    integer :: i

    call nodes_of_item(mesh, record, 1, diagnostics, nodes)
    if (quantity == quantity_force .and. .not. bears_forces(mesh, record)) then
      call report_error(diagnostics, item_location(record, 1), item_name(record, 1)// &
        ' is exact and has no nodes that a force could act on', 'write RIGId '// &
        item_name(record, 1)//', and LOAD f1 f2 f3 in it')
      return
    end if
    do i = 1, size(nodes)
      call set_values(draft, quantity, nodes(i), record_values(record, 1), record, 1)
    end do
  end subroutine set_named

  !> Forces may act on the nodes that a name means: they are those of a mesh.
  logical function bears_forces(mesh, record) result(bears)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(record_t), intent(in) :: record !! begins with the name
    integer :: surface

    call find_surface(mesh, item_name(record, 1), surface)
    bears = surface == 0
    if (.not. bears) bears = .not. mesh%surfaces(surface)%exact
  end function bears_forces

  !> A record that begins with a node number and an increment.
  subroutine set_numbered(record, quantity, mesh, diagnostics, draft, previous)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: quantity !! what it prescribes
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    type(generation_t), intent(inout) :: previous !! where the generation starts; this record then
    type(generation_t) :: this

    this%node = item_integer(record, 1)
    if (.not. node_exists(mesh, kept_node(mesh, this%node))) then
      call report_missing_node(mesh, item_location(record, 1), this%node, diagnostics)
      previous = generation_t()
      return
    end if
    this%increment = item_integer(record, 2)
    this%values = record_values(record, 2)
    this%table = record_table(record, 2)
    if (quantity == quantity_restraint .and. previous%node > 0) then
      where (previous%values < 0.0_wp .and. abs(this%values) <= 0.0_wp) this%values = -1.0_wp
    end if
    call set_values(draft, quantity, kept_node(mesh, this%node), this%values, record, 2)
    call generate(record, quantity, mesh, previous, this, diagnostics, draft)
    previous = this
  end subroutine set_numbered

  !> Nodes between two records: first + increment, first + 2 increment, ... before the second.
  !!
  !! Forces and displacements are interpolated, load numbers copied from the first record, and of
  !! restraint codes only the negative ones are passed on.
  subroutine generate(record, quantity, mesh, first, last, diagnostics, draft)
    type(record_t), intent(in) :: record !! the second record
    integer, intent(in) :: quantity !! what is prescribed
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(generation_t), intent(in) :: first !! the first record
    type(generation_t), intent(in) :: last !! the second record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(condition_draft_t), intent(inout) :: draft !! receives the values
    integer :: steps, step, i, node

    if (first%node == 0 .or. first%increment == 0) return
    if (abs(first%increment) >= abs(last%node - first%node)) return
    if (first%table /= last%table) then
      call report_error(diagnostics, item_location(record, 6), 'nodes are generated between '// &
        'records that differ in their table', 'write the same table behind both records')
      return
    end if
    step = sign(first%increment, last%node - first%node)
    steps = (abs(last%node - first%node) + abs(step) - 1)/abs(step)
    do i = 1, steps - 1
      node = first%node + i*step
      if (.not. node_exists(mesh, kept_node(mesh, node))) then
        call report_error(diagnostics, item_location(record, 1), 'node '//to_text(node)// &
          ', generated between '//to_text(first%node)//' and '//to_text(last%node)// &
          ', does not exist', 'change the increment of the record before')
        return
      end if
      call set_values(draft, quantity, kept_node(mesh, node), generated_values(quantity, first, &
        last, real(i, wp)/real(steps, wp)), record, 2)
    end do
  end subroutine generate

  !> Values of a generated node, a fraction of the way from the first record to the second.
  pure function generated_values(quantity, first, last, fraction) result(values)
    integer, intent(in) :: quantity !! what is prescribed
    type(generation_t), intent(in) :: first !! the first record
    type(generation_t), intent(in) :: last !! the second record
    real(wp), intent(in) :: fraction !! 0 at the first, 1 at the second
    real(wp) :: values(3)

    select case (quantity)
    case (quantity_restraint)
      values = min(first%values, 0.0_wp)
    case (quantity_load)
      values = first%values
    case default
      values = first%values + (last%values - first%values)*fraction
    end select
  end function generated_values
end module numbered_conditions

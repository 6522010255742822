!> Reads supports, prescribed displacements, forces and load numbers, and checks them together.
module conditions_reader
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t, data_set_t, record_t, location_t, item_t, item_number, item_empty
  use records, only: item_count, item_name
  use diagnostics, only: diagnostics_t, report_error, report_note
  use deck_losses, only: is_whole
  use mesh_names, only: surface_nodes, find_nodes
  use model_types, only: model_t, rigid_body_t
  use loads, only: has_load
  use condition_draft, only: condition_draft_t, start_draft, finish_draft, &
    quantity_restraint, &
    quantity_displacement, quantity_force, quantity_load
  use numbered_conditions, only: read_numbered_conditions
  use rotations_reader, only: read_rotations
  use rigid_reader, only: read_rigid
  use located_conditions, only: read_edge_conditions, read_point_conditions
  implicit none
  private
  public :: read_conditions

  !> A prescribed displacement on a degree of freedom without support, gathered by its item.
  type :: loose_t
    type(location_t) :: at !! the item
    integer :: node = 0 !! first node it concerns
    integer :: dof = 0 !! degree of freedom
    integer :: count = 0 !! number of nodes it concerns
  end type loose_t

  !> Most items that are gathered: as many as one report shows.
  integer, parameter :: max_loose = 20

contains

  !> Fills model%conditions; mesh, materials and loads have been read.
  subroutine read_conditions(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the conditions
    type(condition_draft_t) :: draft
    type(rigid_body_t), allocatable :: rigid(:)
    integer :: i, quantity

    call start_draft(model%mesh%nodes, draft)
    do i = 1, size(deck%mesh)
      quantity = quantity_of(deck%mesh(i)%command)
      if (quantity == 0) cycle
      associate (set => deck%mesh(i))
        call check_tables(set, quantity, model, diagnostics)
        select case (set%command(1:1))
        case ('e')
          call read_edge_conditions(set, quantity, model%mesh, diagnostics, draft)
        case ('c')
          call read_point_conditions(set, quantity, model%mesh, diagnostics, draft)
        case default
          call read_numbered_conditions(set, quantity, model%mesh, diagnostics, draft)
        end select
      end associate
    end do
    call read_rotations(deck, model, diagnostics, draft%restrained, draft%turns)
    call read_rigid(deck, model, diagnostics, draft, rigid)
    call restrain_rigid_nodes(model, draft)
    call restrain_loose_nodes(deck, model, diagnostics, draft)
    if (knows_supports(deck, model)) call check_displacements(draft, diagnostics)
    call finish_draft(draft, model%conditions)
    call move_alloc(rigid, model%conditions%rigid)
  end subroutine read_conditions

  !> What a command prescribes, 0 if it is none of these.
  pure integer function quantity_of(command) result(quantity)
    character(4), intent(in) :: command !! first four letters, lower case

    select case (command)
    case ('boun', 'ebou', 'cbou')
      quantity = quantity_restraint
    case ('disp', 'edis', 'cdis')
      quantity = quantity_displacement
    case ('forc', 'efor', 'cfor')
      quantity = quantity_force
    case ('fpro', 'epro', 'cpro')
      quantity = quantity_load
    case default
      quantity = 0
    end select
  end function quantity_of

  !> Each number of a table must be 0 or have one.
  subroutine check_tables(set, quantity, model, diagnostics)
    type(data_set_t), intent(in) :: set !! a data set of conditions
    integer, intent(in) :: quantity !! what it prescribes
    type(model_t), intent(in) :: model !! has the tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i, k, n, before
    logical :: good

    do i = 1, set%count
      n = item_count(set%records(i))
      before = items_before(set, i)
      select case (quantity)
      case (quantity_restraint)
        if (set%command /= 'boun' .or. n < before + 3) cycle
        if (any(set%records(i)%items(before + 1:before + 3)%value > 1.5_wp)) &
          call report_note(diagnostics, set%records(i)%at, 'a code for each direction: any but '// &
          '0 restrains it, and 0 leaves it free; they are no range of directions')
      case (quantity_load)
        do k = max(1, n - 2), n
          call check_table(set%records(i)%items(k), model, diagnostics, good)
          if (.not. good) exit
        end do
      case (quantity_force, quantity_displacement)
        if (is_range(set%records(i), before)) call report_note(diagnostics, set%records(i)%at, &
          'three values, along x1, x2 and x3: the first two are no range of directions')
        do k = before + 4, n
          call check_table(set%records(i)%items(k), model, diagnostics, good)
        end do
      end select
    end do
  end subroutine check_tables

  !> Two equal directions and a value that is none, as Abaqus prescribes one displacement.
  pure logical function is_range(record, before) result(range)
    type(record_t), intent(in) :: record !! a record of displacements or forces
    integer, intent(in) :: before !! items before its three values

    range = item_count(record) == before + 3
    if (.not. range) return
    associate (v => record%items(before + 1:before + 3)%value)
      range = any(nint(v(1)) == [1, 2, 3]) .and. all(abs(v(1:2) - nint(v(1))) <= 0.0_wp) .and. &
        abs(v(3) - nint(v(3))) > 0.0_wp
    end associate
  end function is_range

  !> Items of a record before its three values.
  pure integer function items_before(set, i) result(before)
    type(data_set_t), intent(in) :: set !! a data set of conditions
    integer, intent(in) :: i !! number of the record

    before = 2
    if (set%command(1:1) == 'c') then
      before = 4
    else if (item_count(set%records(i)) > 0) then
      if (set%records(i)%items(1)%kind /= item_number) before = 1
    end if
  end function items_before

  !> A number must be 0 or that of a table.
  subroutine check_table(item, model, diagnostics, good)
    type(item_t), intent(in) :: item !! the number
    type(model_t), intent(in) :: model !! has the tables
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical, intent(out) :: good !! it is right

    good = item%kind /= item_number
    if (.not. good) good = has_load(model%tables, nint(item%value))
    if (good) return
    call report_error(diagnostics, item%at, 'proportional load '//to_text(nint(item%value))// &
      ' has no table', 'define it with PROPortional '//to_text(nint(item%value))// &
      ', or write 0 for the sum of all tables')
  end subroutine check_table

  !> Nodes of rigid materials have no degrees of freedom of their own.
  subroutine restrain_rigid_nodes(model, draft)
    type(model_t), intent(in) :: model !! mesh and materials
    type(condition_draft_t), intent(inout) :: draft !! the conditions
    integer :: e, k, m

    do e = 1, model%mesh%elements
      m = model%element_material(e)
      if (m == 0) cycle
      if (.not. model%materials(m)%rigid) cycle
      do k = 1, size(model%mesh%ix, 1)
        if (model%mesh%ix(k, e) == 0) exit
        draft%restrained(:, model%mesh%ix(k, e)) = .true.
      end do
    end do
  end subroutine restrain_rigid_nodes

  !> Nodes without element are restrained, as in FEAP; those of surfaces with nothing behind them
  !! are meant to be.
  subroutine restrain_loose_nodes(deck, model, diagnostics, draft)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(in) :: model !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! takes the note
    type(condition_draft_t), intent(inout) :: draft !! the conditions
    logical :: meant(model%mesh%nodes)
    integer, allocatable :: nodes(:)
    integer :: i, first, n

    meant = .false.
    do i = 1, size(model%mesh%surfaces)
      if (.not. model%mesh%surfaces(i)%alone) cycle
      call surface_nodes(model%mesh, i, nodes)
      meant(nodes) = .true.
    end do
    first = 0
    n = 0
    do i = 1, model%mesh%nodes
      if (model%mesh%used(i)) cycle
      draft%restrained(:, i) = .true.
      if (meant(i) .or. .not. model%mesh%defined(i)) cycle
      if (first == 0) first = i
      n = n + 1
    end do
    if (n == 0) return
    call report_note(diagnostics, deck%last, count_noun(n, 'node')// &
      ' without element, restrained in all directions; the first is '//to_text(first))
  end subroutine restrain_loose_nodes

  !> True if no support is missing because of an error: each record could be used, and the nodes
  !! that it names are there.
  logical function knows_supports(deck, model) result(known)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(in) :: model !! the mesh
    integer, allocatable :: nodes(:)
    integer :: i, k
    logical :: found

    known = is_whole(deck, ['boun', 'ebou', 'cbou', 'rota', 'rigi'])
    do i = 1, size(deck%mesh)
      associate (set => deck%mesh(i))
        if (set%command == 'mate') known = known .and. .not. set%unknown
        if (all(set%command /= ['boun', 'rota'])) cycle
        do k = 1, set%count
          if (any(set%records(k)%items(1)%kind == [item_number, item_empty])) cycle
          call find_nodes(model%mesh, item_name(set%records(k), 1), nodes, found)
          known = known .and. found .and. size(nodes) > 0
        end do
      end associate
    end do
  end function knows_supports

  !> A displacement other than zero needs a support: one error for each item that lacks it.
  subroutine check_displacements(draft, diagnostics)
    type(condition_draft_t), intent(in) :: draft !! the conditions
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(loose_t) :: loose(max_loose)
    logical :: moved(3, size(draft%displacement_at, 2))
    integer :: i, k, n

    moved = abs(draft%displacement) > 0.0_wp
    do i = 1, size(draft%added)
      associate (values => draft%added(i)%displacement)
        do k = 1, values%n
          moved(values%dof(k), values%node(k)) = .true.
        end do
      end associate
    end do
    n = 0
    do i = 1, size(draft%displacement_at, 2)
      do k = 1, 3
        if (draft%restrained(k, i)) cycle
        if (.not. moved(k, i)) cycle
        call gather_loose(draft%displacement_at(k, i), i, k, loose, n)
      end do
    end do
    do i = 1, n
      call report_error(diagnostics, loose(i)%at, 'a displacement is prescribed for degree of '// &
        'freedom '//to_text(loose(i)%dof)//' of node '//to_text(loose(i)%node)// &
        others(loose(i)%count - 1)//', which is not restrained', &
        'restrain it with BOUNdary (code 1), or prescribe 0')
    end do
  end subroutine check_displacements

  !> Adds one degree of freedom to the list, under the item that prescribes it.
  pure subroutine gather_loose(at, node, dof, loose, n)
    type(location_t), intent(in) :: at !! the item
    integer, intent(in) :: node !! node
    integer, intent(in) :: dof !! degree of freedom
    type(loose_t), intent(inout) :: loose(:) !! the list
    integer, intent(inout) :: n !! its length
    integer :: i

    do i = 1, n
      if (loose(i)%at%file /= at%file .or. loose(i)%at%line /= at%line) cycle
      if (loose(i)%at%column /= at%column .or. loose(i)%dof /= dof) cycle
      loose(i)%count = loose(i)%count + 1
      return
    end do
    if (n == size(loose)) return
    n = n + 1
    loose(n)%at = at
    loose(n)%node = node
    loose(n)%dof = dof
    loose(n)%count = 1
  end subroutine gather_loose

  !> " and 3 other nodes", or nothing.
  pure function others(n) result(words)
    integer, intent(in) :: n !! how many
    character(:), allocatable :: words

    words = ''
    if (n > 0) words = ' and of '//count_noun(n, 'other node')
  end function others
end module conditions_reader

!> Reads what holds bodies beside restraints: the HOLD data sets, regions whose rigid motions that
!! nothing resists are held, and SPRIng, springs to ground.
module held_reader
  use kinds, only: wp
  use deck_types, only: deck_t, record_t
  use records, only: item_location, item_name, item_real
  use diagnostics, only: diagnostics_t, report_error
  use mesh_names, only: find_region, region_nodes
  use node_queries, only: report_no_region, nodes_of_item
  use model_types, only: model_t
  implicit none
  private
  public :: read_held

contains

  !> Reads all data sets.
  subroutine read_held(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! mesh read; gets held and springs
    integer :: i, k

    allocate (model%held(model%mesh%nodes), source=.false.)
    do i = 1, size(deck%mesh)
      do k = 1, deck%mesh(i)%count
        select case (deck%mesh(i)%command)
        case ('hold')
          call hold_region(deck%mesh(i)%records(k), diagnostics, model)
        case ('spri')
          call add_spring(deck%mesh(i)%records(k), diagnostics, model)
        end select
      end do
    end do
  end subroutine read_held

  !> Marks the nodes of a region.
  subroutine hold_region(record, diagnostics, model)
    type(record_t), intent(in) :: record !! a record of HOLD
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! gets held
    integer, allocatable :: nodes(:)
    integer :: index

    call find_region(model%mesh, item_name(record, 1), index)
    if (index == 0) then
      call report_no_region(model%mesh, item_location(record, 1), item_name(record, 1), &
        diagnostics)
      return
    end if
    call region_nodes(model%mesh, index, nodes)
    model%held(nodes) = .true.
  end subroutine hold_region

  !> Springs on each node of a set; those of several records add.
  subroutine add_spring(record, diagnostics, model)
    type(record_t), intent(in) :: record !! `set k1 k2 k3`
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! gets springs
    integer, allocatable :: nodes(:)
    real(wp) :: stiffness(3)
    integer :: i, k

    call nodes_of_item(model%mesh, record, 1, diagnostics, nodes)
    stiffness = [(item_real(record, 1 + k), k=1, 3)]
    if (size(nodes) == 0 .or. all(stiffness <= 0.0_wp)) return
    call check_sprung(record, nodes, model, diagnostics)
    associate (conditions => model%conditions)
      if (.not. allocated(conditions%spring)) &
        allocate (conditions%spring(3, model%mesh%nodes), source=0.0_wp)
      do i = 1, size(nodes)
        conditions%spring(:, nodes(i)) = conditions%spring(:, nodes(i)) + stiffness
      end do
    end associate
  end subroutine add_spring

  !> A rigid body with a point has no springs: on its nodes, which follow it, they would do nothing.
  subroutine check_sprung(record, nodes, model, diagnostics)
    type(record_t), intent(in) :: record !! `set k1 k2 k3`
    integer, intent(in) :: nodes(:) !! of the set
    type(model_t), intent(in) :: model !! rigid bodies
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical :: sprung(model%mesh%nodes)
    integer :: b

    sprung = .false.
    sprung(nodes) = .true.
    if (.not. allocated(model%conditions%rigid)) return
    do b = 1, size(model%conditions%rigid)
      associate (body => model%conditions%rigid(b))
        if (.not. any(sprung(body%nodes))) cycle
        call report_error(diagnostics, item_location(record, 1), 'nodes of '// &
          item_name(record, 1)//' belong to the rigid body '//body%name// &
          ', which takes no springs', &
          'put them on an elastic body that touches it, or prescribe its MOVE and LOAD')
      end associate
    end do
  end subroutine check_sprung
end module held_reader

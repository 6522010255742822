!> Reads the HOLD data sets: regions whose rigid motions that nothing resists are held.
module held_reader
  use deck_types, only: deck_t
  use records, only: item_location, item_name
  use diagnostics, only: diagnostics_t
  use mesh_names, only: find_region, region_nodes
  use node_queries, only: report_unknown_name
  use model_types, only: model_t
  implicit none
  private
  public :: read_held

contains

  !> Marks the nodes of the regions.
  subroutine read_held(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! mesh read; gets held
    integer, allocatable :: nodes(:)
    integer :: i, k, index

    allocate (model%held(model%mesh%nodes), source=.false.)
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'hold') cycle
      do k = 1, deck%mesh(i)%count
        associate (record => deck%mesh(i)%records(k))
          call find_region(model%mesh, item_name(record, 1), index)
          if (index == 0) then
            call report_unknown_name(model%mesh, item_location(record, 1), item_name(record, 1), &
              diagnostics)
            cycle
          end if
        end associate
        call region_nodes(model%mesh, index, nodes)
        model%held(nodes) = .true.
      end do
    end do
  end subroutine read_held
end module held_reader

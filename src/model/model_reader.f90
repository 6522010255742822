!> Turns a checked deck into the problem: mesh, materials, loads, conditions, contact, output.
module model_reader
  use deck_types, only: deck_t
  use deck_losses, only: is_whole
  use diagnostics, only: diagnostics_t, error_count
  use mesh_reader, only: read_mesh
  use tied_nodes, only: has_tie
  use model_types, only: model_t
  use materials_reader, only: read_materials, assign_materials
  use loads_reader, only: read_loads, add_lost_tables
  use conditions_reader, only: read_conditions
  use distributed_loads, only: read_distributed_loads
  use held_reader, only: read_held
  use contact_reader, only: read_pairs, pair_draft_t
  use facets, only: facet_table_t, exterior_facets
  use tie_checks, only: check_ties
  use behind_checks, only: check_behind
  use load_uses, only: warn_of_unused_loads
  use pair_builder, only: build_pairs
  use multiplier_carriers, only: find_carriers
  use output_reader, only: read_output
  use name_checks, only: check_names
  implicit none
  private
  public :: read_model, read_rest

contains

  !> Reads everything and reports all that is wrong; the model is complete if nothing is.
  subroutine read_model(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(out) :: model !! the problem
    type(facet_table_t) :: exterior

    model%title = deck%title
    call read_mesh(deck, diagnostics, model%mesh, exterior)
    call read_rest(deck, diagnostics, model, exterior)
  end subroutine read_model

  !> All but the mesh, which is there. After errors the rest is read all the same, where nodes and
  !! elements are there; what may be wrong only because of what is missing is not reported.
  subroutine read_rest(deck, diagnostics, model, exterior)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! the problem, with its mesh
    type(facet_table_t), intent(in) :: exterior !! its exterior facets, if at hand
    type(pair_draft_t), allocatable :: drafts(:)
    logical :: sound

    sound = error_count(diagnostics) == 0
    call read_loads(deck, diagnostics, model)
    call read_pairs(deck, diagnostics, drafts)
    call read_materials(deck, diagnostics, model)
    if (.not. sound) call add_lost_tables(deck, model)
    if (.not. (sound .or. model%mesh%filled)) then
      call check_names(deck, model%mesh, diagnostics)
      return
    end if
    call assign_materials(deck, diagnostics, model)
    call read_conditions(deck, diagnostics, model)
    call read_distributed_loads(deck, diagnostics, model)
    call read_held(deck, diagnostics, model)
    call build_pairs(drafts, is_whole(deck, ['mate', 'glob']), diagnostics, model, exterior)
    call read_output(deck, diagnostics, model)
    if (error_count(diagnostics) == 0) call find_carriers(model, diagnostics)
    if (error_count(diagnostics) == 0) call look_at_scene(deck, exterior, model, diagnostics)
  end subroutine read_rest

  !> Looks at a scene without errors for what cannot be meant: faces that a TIE has not joined,
  !! slaves that start behind their masters, loads that nothing uses.
  subroutine look_at_scene(deck, known, model, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(facet_table_t), intent(in) :: known !! exterior facets, if at hand
    type(model_t), intent(in) :: model !! mesh and pairs
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(facet_table_t) :: exterior
    integer :: k

    call warn_of_unused_loads(deck, model, diagnostics)
    if (size(model%pairs) == 0 .and. .not. has_tie(deck)) return
    exterior = known
    if (.not. allocated(known%corners)) call exterior_facets(model%mesh, exterior)
    if (has_tie(deck)) call check_ties(deck, exterior, model, diagnostics)
    do k = 1, size(model%pairs)
      call check_behind(model%mesh, exterior, model%pairs(k), diagnostics)
    end do
  end subroutine look_at_scene
end module model_reader

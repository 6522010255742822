!> Reads the OUTPut data sets: what is written, and how often.
module output_reader
  use text, only: string_t, to_text
  use hints, only: word_list_t, add_candidate, did_you_mean
  use deck_types, only: deck_t, record_t
  use body_fields, only: fields_of_bodies, n_body_fields
  use deck_losses, only: is_lost
  use records, only: item_location, item_count, item_integer, item_name, is_word
  use diagnostics, only: diagnostics_t, report_error
  use tied_nodes, only: kept_node
  use model_types, only: model_t, history_request_t, output_request_t, state_all, state_last, &
    state_none, last_states
  use node_sets, only: node_exists
  use node_queries, only: report_missing_node, report_unknown_name
  use mesh_names, only: find_nodes
  implicit none
  private
  public :: read_output

contains

  !> Fills model%output; mesh and conditions have been read.
  subroutine read_output(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the request
    integer :: i, k
    logical :: reactions_given

    allocate (model%output%reactions(0), model%output%history(0), model%output%points(0))
    reactions_given = .false.
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'outp') cycle
      do k = 1, deck%mesh(i)%count
        associate (record => deck%mesh(i)%records(k))
          ! a pair may have been left out because of an error
          if (is_word(record%items(1), 'points') .and. .not. knows_pairs(deck)) cycle
          call read_request(record, diagnostics, model, reactions_given)
        end associate
      end do
    end do
    if (.not. reactions_given) call request_restrained_sets(model)
  end subroutine read_output

  !> True if no pair was left out because of an error.
  pure logical function knows_pairs(deck) result(known)
    type(deck_t), intent(in) :: deck !! the deck
    integer :: i

    known = .not. (is_lost(deck, 'cont') .or. is_lost(deck, 'pair'))
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command == 'cont') known = known .and. .not. deck%mesh(i)%unknown
    end do
  end function knows_pairs

  !> Reads one record.
  subroutine read_request(record, diagnostics, model, reactions_given)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the request
    logical, intent(inout) :: reactions_given !! becomes true with REACtions

    if (is_word(record%items(1), 'reactions')) then
      reactions_given = .true.
      call read_reactions(record, diagnostics, model)
    else if (is_word(record%items(1), 'fields')) then
      call read_fields(record, model%output)
    else if (is_word(record%items(1), 'tables')) then
      model%output%all_tables = .true.
    else if (is_word(record%items(1), 'every')) then
      model%output%every = item_integer(record, 2)
    else if (is_word(record%items(1), 'state')) then
      call read_state(record, model%output)
    else if (is_word(record%items(1), 'points')) then
      call read_points(record, diagnostics, model)
    else if (is_word(record%items(1), 'history')) then
      call read_history(record, diagnostics, model)
    end if
  end subroutine read_request

  !> REACtions set set ...
  subroutine read_reactions(record, diagnostics, model)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the names
    integer, allocatable :: nodes(:)
    logical :: found
    integer :: i

    do i = 2, item_count(record)
      call find_nodes(model%mesh, item_name(record, i), nodes, found)
      if (.not. found) then
        call report_unknown_name(model%mesh, item_location(record, i), item_name(record, i), &
          diagnostics)
      else if (is_requested(model%output, item_name(record, i))) then
        call report_error(diagnostics, item_location(record, i), 'reactions of '''// &
          item_name(record, i)//''' are asked for twice', 'name each set once')
      else
        call add_reactions(model%output, item_name(record, i))
      end if
    end do
  end subroutine read_reactions

  !> Whether a set's reactions are on the list.
  pure logical function is_requested(output, name)
    type(output_request_t), intent(in) :: output !! the request
    character(*), intent(in) :: name !! name of the set
    integer :: i

    is_requested = .false.
    do i = 1, size(output%reactions)
      if (output%reactions(i)%s == name) is_requested = .true.
    end do
  end function is_requested

  !> Adds one set to the list.
  pure subroutine add_reactions(output, name)
    type(output_request_t), intent(inout) :: output !! the request
    character(*), intent(in) :: name !! name of the set
    type(string_t), allocatable :: longer(:)
    integer :: n

    n = size(output%reactions)
    allocate (longer(n + 1))
    longer(:n) = output%reactions
    longer(n + 1)%s = name
    call move_alloc(longer, output%reactions)
  end subroutine add_reactions

  !> FIELds word word ..., or NONE: only what is named is written.
  pure subroutine read_fields(record, output)
    type(record_t), intent(in) :: record !! the record
    type(output_request_t), intent(inout) :: output !! receives the choice
    integer :: i, k

    output%field = .false.
    output%contact = .false.
    do i = 2, item_count(record)
      if (is_word(record%items(i), 'contact')) output%contact = .true.
      do k = 1, n_body_fields
        if (is_word(record%items(i), trim(fields_of_bodies(k)%word))) output%field(k) = .true.
      end do
    end do
  end subroutine read_fields

  !> STATe ALL, LAST n or NONE.
  pure subroutine read_state(record, output)
    type(record_t), intent(in) :: record !! the record
    type(output_request_t), intent(inout) :: output !! receives the choice

    if (is_word(record%items(2), 'all')) output%state = state_all
    if (is_word(record%items(2), 'last')) then
      output%state = state_last
      output%kept_states = last_states
      if (item_count(record) > 2) output%kept_states = item_integer(record, 3)
    end if
    if (is_word(record%items(2), 'none')) output%state = state_none
  end subroutine read_state

  !> HISTory NODE n dof.
  subroutine read_history(record, diagnostics, model)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the request
    type(history_request_t) :: request

    request%node = kept_node(model%mesh, item_integer(record, 3))
    request%dof = item_integer(record, 4)
    if (.not. node_exists(model%mesh, request%node)) then
      call report_missing_node(model%mesh, item_location(record, 3), request%node, diagnostics)
    else
      model%output%history = [model%output%history, request]
    end if
  end subroutine read_history

  !> POINts pair pair ...: by name or number.
  subroutine read_points(record, diagnostics, model)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the pairs
    type(word_list_t) :: names
    integer :: i, k, found

    do i = 2, item_count(record)
      found = 0
      do k = 1, size(model%pairs)
        call add_candidate(names, model%pairs(k)%name)
        if (item_name(record, i) == model%pairs(k)%name .or. &
          item_name(record, i) == to_text(model%pairs(k)%number)) found = k
      end do
      if (found == 0) then
        call report_error(diagnostics, item_location(record, i), 'there is no pair '''// &
          item_name(record, i)//'''', did_you_mean(names, item_name(record, i), &
          'a pair is named in CONTact: PAIR number name'))
      else if (any(model%output%points == found)) then
        call report_error(diagnostics, item_location(record, i), 'points of '''// &
          item_name(record, i)//''' are asked for twice', 'name each pair once')
      else
        model%output%points = [model%output%points, found]
      end if
    end do
  end subroutine read_points

  !> Without REACtions: every set with a restrained degree of freedom, in the order of the deck.
  subroutine request_restrained_sets(model)
    type(model_t), intent(inout) :: model !! mesh, conditions and request
    integer :: i

    do i = 1, size(model%mesh%sets)
      associate (set => model%mesh%sets(i))
        if (any(model%conditions%restrained(:, set%nodes))) then
          call add_reactions(model%output, set%name)
        end if
      end associate
    end do
  end subroutine request_restrained_sets
end module output_reader

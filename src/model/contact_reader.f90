!> Reads the contact pairs: CONTact with its PAIR records. In more than 400 lines, since each word
!! of a pair has its reading and its check.
module contact_reader
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t, record_t, location_t
  use friction_laws, only: cone_laws, first_value, acts
  use friction_return, only: has_friction
  use records, only: item_location, item_count, item_integer, item_real, item_name, is_word
  use diagnostics, only: diagnostics_t, report_error, report_note
  use contact_types, only: pair_t, penalty_nodal, penalty_area, penalty_auto, penalty_own, &
    own_factor, direction_vector, direction_circumferential, direction_radial, &
    direction_field, form_node_to_surface, form_quadrature_to_surface
  use facet_quadrature, only: has_rule, list_rules
  implicit none
  private
  public :: read_pairs, pair_draft_t

  !> A pair while the deck is being read.
  type :: pair_draft_t
    type(pair_t) :: pair !! what the deck says so far
    logical :: has_form = .false. !! NTOS or GTOS has been given
    logical :: has_direction = .false. !! DIREction has been given
    type(location_t) :: law_at(size(cone_laws)) !! where the deck gives each law
    type(location_t) :: penalty_at, augment_at, smooth_at !! and these words, line 0: not at all
    logical :: complete = .true. !! all records of its data set could be used
  end type pair_draft_t

contains

  !> Reads all pairs of the deck, in its order.
  subroutine read_pairs(deck, diagnostics, drafts)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_draft_t), allocatable, intent(out) :: drafts(:) !! the pairs
    integer :: i, k, n
    logical :: no_pair

    allocate (drafts(count_pairs(deck)))
    n = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'cont') cycle
      no_pair = .true.
      do k = 1, deck%mesh(i)%count
        associate (record => deck%mesh(i)%records(k))
          if (is_word(record%items(1), 'pair')) then
            call start_pair(record, deck%mesh(i)%complete, drafts, n)
            no_pair = .false.
          else if (no_pair) then
            if (k == 1 .and. deck%mesh(i)%complete) call report_error(diagnostics, record%at, &
              'no PAIR is open here', 'write PAIR and its number first')
          else
            call read_word(record, diagnostics, drafts(n))
          end if
        end associate
      end do
    end do
    do i = 1, n
      drafts(i)%pair%penalty = deck%penalty_factor*drafts(i)%pair%penalty
      call check_pair(drafts, i, diagnostics)
    end do
  end subroutine read_pairs

  !> How many PAIR records the deck has.
  pure integer function count_pairs(deck) result(n)
    type(deck_t), intent(in) :: deck !! the deck
    integer :: i, k

    n = 0
    do i = 1, size(deck%mesh)
      associate (set => deck%mesh(i))
        if (set%command /= 'cont') cycle
        do k = 1, set%count
          if (is_word(set%records(k)%items(1), 'pair')) n = n + 1
        end do
      end associate
    end do
  end function count_pairs

  !> PAIR n [name].
  subroutine start_pair(record, complete, drafts, n)
    type(record_t), intent(in) :: record !! the record
    logical, intent(in) :: complete !! all records of its data set could be used
    type(pair_draft_t), intent(inout) :: drafts(:) !! the pairs
    integer, intent(inout) :: n !! how many have been started

    n = n + 1
    drafts(n)%complete = complete
    associate (pair => drafts(n)%pair)
      pair%at = record%at
      pair%number = item_integer(record, 2)
      if (item_count(record) > 2) then
        pair%name = item_name(record, 3)
      else
        pair%name = to_text(pair%number)
      end if
      pair%slave = ''
      pair%master = ''
    end associate
  end subroutine start_pair

  !> One record of a pair.
  subroutine read_word(record, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_draft_t), intent(inout) :: draft !! the pair

    associate (word => record%items(1))
      if (any([is_word(word, 'ntos'), is_word(word, 'gtos'), is_word(word, &
        'mortar')])) then
        call read_form(record, diagnostics, draft)
      else if (is_word(word, 'penalty')) then
        call read_penalty(record, draft%pair)
        draft%penalty_at = record%at
      else if (is_word(word, 'friction')) then
        call read_friction(record, draft)
      else if (is_word(word, 'direction')) then
        call read_direction(record, diagnostics, draft)
      else if (is_word(word, 'slip')) then
        if (is_word(record%items(2), 'collinear')) draft%pair%friction%slip_rule = 0
        if (is_word(record%items(2), 'tensor')) draft%pair%friction%slip_rule = 1
        if (is_word(record%items(2), 'associated')) draft%pair%friction%slip_rule = 2
      else if (is_word(word, 'smooth')) then
        draft%pair%smooth = .true.
        draft%smooth_at = record%at
      else if (is_word(word, 'augment')) then
        draft%pair%augmented = .true.
        draft%augment_at = record%at
        if (item_count(record) > 1) draft%pair%augment_tolerance = item_real(record, 2)
        if (item_count(record) > 2) draft%pair%augment_most = item_integer(record, 3)
      else if (is_word(word, 'shrink')) then
        draft%pair%shrinking%shrink = item_integer(record, 2)
        draft%pair%shrinking%shrink_at = item_location(record, 2)
      else if (is_word(word, 'search')) then
        draft%pair%search_radius = item_real(record, 2)
      else if (is_word(word, 'adjust')) then
        draft%pair%fit%adjusted = .true.
        if (item_count(record) > 1) draft%pair%fit%adjust = item_real(record, 2)
      else
        call read_law(record, draft)
      end if
    end associate
  end subroutine read_word

  !> NTOS slave master, or GTOS slave master [points or SEGMent].
  subroutine read_form(record, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_draft_t), intent(inout) :: draft !! the pair

    if (draft%has_form) then
      if (draft%complete) call report_error(diagnostics, record%at, &
        'the pair has its surfaces already', 'start another PAIR, or delete one of the two records')
      return
    end if
    draft%has_form = .true.
    draft%pair%form = form_node_to_surface
    draft%pair%slave = item_name(record, 2)
    draft%pair%master = item_name(record, 3)
    draft%pair%slave_at = item_location(record, 2)
    draft%pair%master_at = item_location(record, 3)
    if (is_word(record%items(1), 'ntos')) return
    draft%pair%form = form_quadrature_to_surface
    draft%pair%mortar = is_word(record%items(1), 'mortar')
    draft%pair%segmented = draft%pair%mortar
    if (item_count(record) < 4) return
    draft%pair%segmented = is_word(record%items(4), 'segment')
    if (draft%pair%segmented) return
    draft%pair%facet_points = item_integer(record, 4)
    if (has_rule(draft%pair%facet_points)) return
    call report_error(diagnostics, item_location(record, 4), 'there is no rule with '// &
      count_noun(draft%pair%facet_points, 'point')//' in a facet', 'write '//list_rules())
    draft%pair%facet_points = 3
  end subroutine read_form

  !> PENAlty value, PENAlty AREA value or PENAlty AUTO [factor].
  pure subroutine read_penalty(record, pair)
    type(record_t), intent(in) :: record !! the record
    type(pair_t), intent(inout) :: pair !! the pair
    integer :: i

    i = 3
    if (is_word(record%items(2), 'auto')) then
      pair%penalty_kind = merge(penalty_auto, penalty_own, item_count(record) > 2)
    else if (is_word(record%items(2), 'area')) then
      pair%penalty_kind = penalty_area
    else
      pair%penalty_kind = penalty_nodal
      i = 2
    end if
    pair%penalty = own_factor
    if (item_count(record) >= i) pair%penalty = item_real(record, i)
  end subroutine read_penalty

  !> FRICtion NONE, COULomb mu or ELLIptic mu1 mu2.
  pure subroutine read_friction(record, draft)
    type(record_t), intent(in) :: record !! the record
    type(pair_draft_t), intent(inout) :: draft !! the pair

    associate (pair => draft%pair)
      pair%friction%mu = 0.0_wp
      if (is_word(record%items(2), 'coulomb')) then
        pair%friction%mu = item_real(record, 3)
      else if (is_word(record%items(2), 'elliptic')) then
        pair%friction%mu = [item_real(record, 3), item_real(record, 4)]
      end if
      if (.not. draft%has_direction) pair%friction%direction_at = record%at
    end associate
  end subroutine read_friction

  !> A law that changes the cone, with its parameters.
  pure subroutine read_law(record, draft)
    type(record_t), intent(in) :: record !! the record
    type(pair_draft_t), intent(inout) :: draft !! the pair
    integer :: i, k

    do k = 1, size(cone_laws)
      if (.not. is_word(record%items(1), trim(cone_laws(k)%keyword))) cycle
      draft%pair%law(first_value(k):first_value(k + 1) - 1) = &
        [(item_real(record, i + 1), i=1, cone_laws(k)%count)]
      draft%law_at(k) = record%at
    end do
  end subroutine read_law

  !> DIREction [MATErial] [ANGLe phi], then a vector, CIRCumferential or RADIal with point and axis,
  !! or FIELd and its name.
  subroutine read_direction(record, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_draft_t), intent(inout) :: draft !! the pair
    integer :: i

    draft%has_direction = .true.
    associate (pair => draft%pair)
      pair%friction%direction_at = record%at
      pair%friction%direction = direction_vector
      pair%friction%angle = 0.0_wp
      i = 2
      pair%friction%convected = is_word(record%items(i), 'material')
      if (pair%friction%convected) i = i + 1
      if (word_at(record, i, 'angle')) then
        pair%friction%angle = item_real(record, i + 1)
        i = i + 2
      end if
      if (word_at(record, i, 'circumferential')) pair%friction%direction = direction_circumferential
      if (word_at(record, i, 'radial')) pair%friction%direction = direction_radial
      if (word_at(record, i, 'field')) pair%friction%direction = direction_field
      if (item_count(record) <= i) return
      pair%friction%direction_at = item_location(record, i)
      select case (pair%friction%direction)
      case (direction_field)
        pair%friction%field = item_name(record, i + 1)
        pair%friction%direction_at = item_location(record, i + 1)
      case (direction_vector)
        call read_axis(record, i, diagnostics, draft)
      case default
        if (item_count(record) < i + 6) return
        pair%friction%point = [item_real(record, i + 1), item_real(record, i + 2), &
          item_real(record, i + 3)]
        call read_axis(record, i + 4, diagnostics, draft)
      end select
    end associate
  end subroutine read_direction

  !> Whether a record has a certain word at a place.
  pure logical function word_at(record, i, word)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! the place, maybe behind its last item
    character(*), intent(in) :: word !! the word

    word_at = .false.
    if (i <= item_count(record)) word_at = is_word(record%items(i), word)
  end function word_at

  !> The vector of a direction or of its axis, made a unit vector.
  subroutine read_axis(record, i, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! its first component
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_draft_t), intent(inout) :: draft !! the pair

    if (item_count(record) < i + 2) return
    associate (pair => draft%pair)
      pair%friction%axis = [item_real(record, i), item_real(record, i + 1), item_real(record, &
        i + 2)]
      if (all(abs(pair%friction%axis) <= 0.0_wp)) then
        call report_error(diagnostics, item_location(record, i), 'the direction has no length', &
          'write a vector other than 0 0 0')
        pair%friction%axis = [1.0_wp, 0.0_wp, 0.0_wp]
        pair%friction%direction = direction_vector
        draft%has_direction = .false.
      else
        pair%friction%axis = pair%friction%axis/maxval(abs(pair%friction%axis))
        pair%friction%axis = pair%friction%axis/norm2(pair%friction%axis)
      end if
    end associate
  end subroutine read_axis

  !> A pair needs its surfaces, a number of its own and a name of its own.
  subroutine check_pair(drafts, i, diagnostics)
    type(pair_draft_t), intent(in) :: drafts(:) !! the pairs
    integer, intent(in) :: i !! the pair to check
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: k

    associate (pair => drafts(i)%pair)
      if (pair%mortar) then
        call check_words(drafts(i), diagnostics)
      else if (pair%segmented) then
        call check_segmented(pair, diagnostics)
      end if
      call check_laws(drafts(i), diagnostics)
      if (drafts(i)%complete .and. .not. drafts(i)%has_form) then
        call report_error(diagnostics, pair%at, 'pair '//pair%name//' has no surfaces', &
          'write MORTar slave master (no penalty), GTOS slave master (where much slides or '// &
          'strains), or NTOS slave master (nodes)')
      end if
      if (pair%smooth .and. pair%fit%adjusted) then
        call report_error(diagnostics, pair%at, 'pair '//pair%name//' has SMOOth and ADJUst', &
          'delete one of them: ADJUst moves nodes onto the flat facets')
      end if
      call note_twin(drafts, i, diagnostics)
      do k = 1, i - 1
        if (drafts(k)%pair%number == pair%number) then
          call report_error(diagnostics, pair%at, 'pair '//to_text(pair%number)// &
            ' is defined twice', 'give the second one another number')
          exit
        else if (drafts(k)%pair%name == pair%name) then
          call report_error(diagnostics, pair%at, 'two pairs are called '''//pair%name//'''', &
            'give the second one another name')
          exit
        end if
      end do
    end associate
  end subroutine check_pair

  !> Two pairs of the same slave and master both press: worth a note.
  subroutine note_twin(drafts, i, diagnostics)
    type(pair_draft_t), intent(in) :: drafts(:) !! the pairs
    integer, intent(in) :: i !! the pair that may repeat an earlier one
    type(diagnostics_t), intent(inout) :: diagnostics !! gets a note
    integer :: k

    associate (pair => drafts(i)%pair)
      do k = 1, i - 1
        if (.not. (drafts(i)%has_form .and. drafts(k)%has_form)) cycle
        if (drafts(k)%pair%slave /= pair%slave .or. drafts(k)%pair%master /= pair%master) cycle
        call report_note(diagnostics, pair%slave_at, 'pair '//pair%name// &
          ' has the slave and the master of pair '//drafts(k)%pair%name// &
          ': both act, with the sum of their penalties and of their friction')
        return
      end do
    end associate
  end subroutine note_twin

  !> Laws need friction that they change, and some an area.
  subroutine check_laws(draft, diagnostics)
    type(pair_draft_t), intent(in) :: draft !! a pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: k

    if (.not. draft%complete) return
    associate (pair => draft%pair)
      do k = 1, size(cone_laws)
        if (.not. acts(k, pair%law)) cycle
        if (.not. all(has_friction(pair%friction%mu))) call report_error(diagnostics, &
          draft%law_at(k), &
          trim(cone_laws(k)%keyword)//' needs two coefficients of friction that are not 0', &
          'write FRICtion COULomb mu or FRICtion ELLIptic mu1 mu2')
        if (cone_laws(k)%needs_area .and. pair%penalty_kind == penalty_nodal .and. &
          pair%form == form_node_to_surface) call report_error(diagnostics, draft%law_at(k), &
          trim(cone_laws(k)%keyword)//' needs points with an area', &
          'write GTOS in place of NTOS, or PENAlty AREA, or PENAlty AUTO')
      end do
    end associate
  end subroutine check_laws

  !> What multipliers at nodes have no use for, or do not know yet.
  subroutine check_words(draft, diagnostics)
    type(pair_draft_t), intent(in) :: draft !! a pair with MORTar
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (draft%penalty_at%line > 0) call report_error(diagnostics, draft%penalty_at, &
      'MORTar has no penalty: its forces are unknowns', 'delete PENAlty')
    if (draft%augment_at%line > 0) call report_error(diagnostics, draft%augment_at, &
      'MORTar needs no AUGMent: its forces are multipliers', 'delete AUGMent')
    if (draft%smooth_at%line > 0) call report_error(diagnostics, draft%smooth_at, &
      'MORTar does not know SMOOth in this version', 'delete SMOOth, or write GTOS')
  end subroutine check_words

  !> What segmentation cannot do.
  subroutine check_segmented(pair, diagnostics)
    type(pair_t), intent(in) :: pair !! a segmented pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (pair%penalty_kind == penalty_nodal) call report_error(diagnostics, pair%at, 'pair '// &
      pair%name//' has SEGMent and a penalty per point, whose points come and go', &
      'write PENAlty AREA and a pressure per length, or PENAlty AUTO')
  end subroutine check_segmented
end module contact_reader

!> Reads the contact pairs: CONTact with its PAIR records.
module contact_reader
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: deck_t, record_t
  use records, only: item_location, item_count, item_integer, item_real, item_name, is_word
  use diagnostics, only: diagnostics_t, report_error
  use contact_types, only: pair_t, penalty_nodal, penalty_area, penalty_auto, direction_vector, &
    form_node_to_surface
  implicit none
  private
  public :: read_pairs, pair_draft_t

  !> A pair while the deck is being read.
  type :: pair_draft_t
    type(pair_t) :: pair !! what the deck says so far
    logical :: has_form = .false. !! NTOS has been given
    logical :: has_direction = .false. !! DIREction has been given
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
            if (deck%mesh(i)%complete) call report_error(diagnostics, record%at, &
              'no PAIR is open here', 'write PAIR and its number first')
            exit
          else
            call read_word(record, diagnostics, drafts(n))
          end if
        end associate
      end do
    end do
    do i = 1, n
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
      if (is_word(word, 'ntos')) then
        call read_form(record, diagnostics, draft)
      else if (is_word(word, 'penalty')) then
        call read_penalty(record, draft%pair)
      else if (is_word(word, 'friction')) then
        call read_friction(record, draft)
      else if (is_word(word, 'direction')) then
        call read_direction(record, diagnostics, draft)
      else if (is_word(word, 'slip')) then
        if (is_word(record%items(2), 'collinear')) draft%pair%slip_rule = 0
        if (is_word(record%items(2), 'tensor')) draft%pair%slip_rule = 1
        if (is_word(record%items(2), 'associated')) draft%pair%slip_rule = 2
      else if (is_word(word, 'smooth')) then
        draft%pair%smooth = .true.
      else if (is_word(word, 'search')) then
        draft%pair%search_radius = item_real(record, 2)
      end if
    end associate
  end subroutine read_word

  !> NTOS slave master.
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
  end subroutine read_form

  !> PENAlty value, PENAlty AREA value or PENAlty AUTO [factor].
  pure subroutine read_penalty(record, pair)
    type(record_t), intent(in) :: record !! the record
    type(pair_t), intent(inout) :: pair !! the pair
    integer :: i

    i = 3
    if (is_word(record%items(2), 'auto')) then
      pair%penalty_kind = penalty_auto
    else if (is_word(record%items(2), 'area')) then
      pair%penalty_kind = penalty_area
    else
      pair%penalty_kind = penalty_nodal
      i = 2
    end if
    pair%penalty = 10.0_wp
    if (item_count(record) >= i) pair%penalty = item_real(record, i)
  end subroutine read_penalty

  !> FRICtion NONE, COULomb mu or ELLIptic mu1 mu2.
  pure subroutine read_friction(record, draft)
    type(record_t), intent(in) :: record !! the record
    type(pair_draft_t), intent(inout) :: draft !! the pair

    associate (pair => draft%pair)
      pair%mu = 0.0_wp
      if (is_word(record%items(2), 'coulomb')) then
        pair%mu = item_real(record, 3)
      else if (is_word(record%items(2), 'elliptic')) then
        pair%mu = [item_real(record, 3), item_real(record, 4)]
      end if
      if (.not. draft%has_direction) pair%direction_at = record%at
    end associate
  end subroutine read_friction

  !> DIREction [MATErial] [ANGLe phi] vx vy vz.
  subroutine read_direction(record, diagnostics, draft)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_draft_t), intent(inout) :: draft !! the pair
    integer :: i

    draft%has_direction = .true.
    associate (pair => draft%pair)
      pair%direction_at = record%at
      pair%direction = direction_vector
      i = 2
      pair%convected = is_word(record%items(i), 'material')
      if (pair%convected) i = i + 1
      pair%angle = 0.0_wp
      if (i <= item_count(record)) then
        if (is_word(record%items(i), 'angle')) then
          pair%angle = item_real(record, i + 1)
          i = i + 2
        end if
      end if
      if (item_count(record) < i + 2) return
      pair%direction_at = item_location(record, i)
      pair%axis = [item_real(record, i), item_real(record, i + 1), item_real(record, i + 2)]
      if (all(abs(pair%axis) <= 0.0_wp)) then
        call report_error(diagnostics, item_location(record, i), 'the direction has no length', &
          'write a vector other than 0 0 0')
        pair%axis = [1.0_wp, 0.0_wp, 0.0_wp]
        draft%has_direction = .false.
      else
        pair%axis = pair%axis/maxval(abs(pair%axis))
        pair%axis = pair%axis/norm2(pair%axis)
      end if
    end associate
  end subroutine read_direction

  !> A pair needs its surfaces, a number of its own and a name of its own.
  subroutine check_pair(drafts, i, diagnostics)
    type(pair_draft_t), intent(in) :: drafts(:) !! the pairs
    integer, intent(in) :: i !! the pair to check
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: k

    associate (pair => drafts(i)%pair)
      if (drafts(i)%complete .and. .not. drafts(i)%has_form) then
        call report_error(diagnostics, pair%at, 'pair '//pair%name//' has no surfaces', &
          'write NTOS slave master')
      end if
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
end module contact_reader

!> Records of other programs in the mesh section: one error for all of a kind.
module foreign_records
  use deck_types, only: record_t, item_word
  use records, only: item_count, is_word, four_letters
  use numbers, only: is_digit, is_letter
  use diagnostics, only: diagnostics_t, report_error
  use reading, only: reading_t, skip_data, lose
  implicit none
  private
  public :: is_feap_contact, pass_contact, pass_foreign_line

contains

  !> Whether a record belongs to a contact input as FEAP has it, with numbers for surfaces and
  !! materials of contact. It goes on to its END, or to BATCh.
  logical function is_feap_contact(reading, record) result(yes)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record

    yes = reading%feap_contact .and. .not. any([is_word(record%items(1), 'end'), &
      is_word(record%items(1), 'batch'), is_word(record%items(1), 'macro')])
    if (reading%feap_contact .or. .not. reading%contact .or. item_count(record) < 2) return
    if (.not. any([is_word(record%items(1), 'surface'), is_word(record%items(1), 'ntos'), &
      is_word(record%items(1), 'gtos')])) return
    yes = record%items(2)%kind == item_word .and. is_digit(record%items(2)%text(1:1))
  end function is_feap_contact

  !> Passes over FEAP's contact input: one error for all of it.
  subroutine pass_contact(reading, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! one of its records
    type(diagnostics_t), intent(inout) :: diagnostics !! gets the error at the first
    character(*), parameter :: line = new_line('a')//'  '

    if (reading%feap_contact) return
    reading%feap_contact = .true.
    call report_error(diagnostics, record%at, 'contact is not written as in FEAP', &
      'surfaces have names and lie where the mesh has its skin, and a pair has all the rest:'// &
      line//'  SET upper'//line//'    PLANe 3 1'//line//'  SURFace slave FROM upper IN block'// &
      line//'  SURFace master'//line//'    FACEts 1 5 7'//line//'  CONTact'//line// &
      '    PAIR 1'//line//'    NTOS slave master'//line//'    PENAlty 1e5'//line// &
      '    FRICtion COULomb 0.1'//line//'no SOLM, TOLE, DETA and no MATErial (AUGMent for '// &
      'multipliers); see doc/tutorials.md, "Coming from FEAP"')
    call skip_data(reading)
    call lose(reading, '?')
  end subroutine pass_contact

  !> Passes over a comment as others write it, and over a card of Abaqus or CalculiX with its data;
  !! the first of each kind is an error.
  subroutine pass_foreign_line(reading, record, diagnostics, foreign)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! a record
    type(diagnostics_t), intent(inout) :: diagnostics !! gets the errors
    logical, intent(out) :: foreign !! it is one of these

    foreign = is_comment(record)
    if (foreign) then
      if (.not. reading%told_comment) call report_error(diagnostics, record%at, &
        'a comment that begins with '''//record%items(1)%text//'''', 'comments begin with !')
      reading%told_comment = .true.
      return
    end if
    foreign = is_card(record)
    if (.not. foreign) return
    if (.not. reading%told_card) call report_error(diagnostics, record%at, &
      ''''//record%items(1)%text//''' is a card of Abaqus or CalculiX', 'commands here are '// &
      'others, without a star: doc/tutorials.md, "Coming from CalculiX", has a table of both; '// &
      'MESH file reads their meshes')
    reading%told_card = .true.
    call skip_data(reading)
    call lose(reading, '?')
  end subroutine pass_foreign_line

  !> A line that is a comment elsewhere.
  logical function is_comment(record) result(yes)
    type(record_t), intent(in) :: record !! a record

    yes = record%items(1)%kind == item_word
    if (.not. yes) return
    associate (text => record%items(1)%text)
      yes = scan(text(1:1), '#%$') > 0 .or. index(text, '//') == 1 .or. index(text, '**') == 1
    end associate
  end function is_comment

  !> A card of Abaqus: a star and a word, but FEAP's offsets (`*NODe 100`, `*ELEment=100`).
  logical function is_card(record) result(yes)
    type(record_t), intent(in) :: record !! a record

    yes = record%items(1)%kind == item_word .and. len(record%items(1)%text) > 1
    if (yes) yes = record%items(1)%text(1:1) == '*' .and. is_letter(record%items(1)%text(2:2))
    if (.not. yes .or. item_count(record) /= 2) return
    if (any(four_letters(record%items(1)%text) == ['*nod', '*ele'])) &
      yes = .not. is_digit(record%items(2)%text(1:min(1, len(record%items(2)%text))))
  end function is_card
end module foreign_records

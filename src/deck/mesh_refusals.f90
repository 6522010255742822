!> What is said of records of the mesh section that cannot be what they seem to be.
module mesh_refusals
  use deck_types, only: record_t, item_t, item_word
  use records, only: item_count, four_letters
  use numbers, only: is_letter
  use hints, only: word_list_t, nearest_word, did_you_mean
  use keyword_types, only: keyword_t, find_keyword, find_word, list_keywords, list_words, &
    takes_names, fits_data, table_mesh, table_batch
  use diagnostics, only: diagnostics_t, report_error, report_note
  use reading, only: reading_t, skip_data, lose
  implicit none
  private
  public :: pass_foreign, is_misspelt_command, own_words_text, report_stray, refuse

  !> Words of FEAP without whose data the mesh is another one.
  character(4), parameter :: moves_nodes(13) = ['pola', 'cyli', 'sphe', 'shif', 'read', 'cons', &
    'loop', 'next', '*nod', '*ele', 'blen', 'snod', 'side']

contains

  !> Obeys a word of FEAP: passed over with a note, or refused with what to write instead.
  subroutine pass_foreign(reading, command, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(keyword_t), intent(in) :: command !! the word
    type(record_t), intent(in) :: record !! its record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes

    if (command%ignored) then
      call report_note(diagnostics, record%at, trim(command%name)//' is ignored')
      reading%skipping = .true.
    else
      call report_error(diagnostics, record%at, trim(command%name)// &
                        ' of FEAP is not available in this program', trim(command%summary))
      if (any(command%key == moves_nodes)) call lose(reading, '')
      call skip_data(reading)
    end if
  end subroutine pass_foreign

  !> Whether a name that stands alone, where a set takes names, looks like a command.
  logical function is_misspelt_command(reading, record) result(misspelt)
    type(reading_t), intent(in) :: reading !! holds the table
    type(record_t), intent(in) :: record !! the record
    type(word_list_t) :: commands

    misspelt = .false.
    if (item_count(record) > 1 .or. record%items(1)%kind /= item_word) return
    if (reading%open > 0) then
      ! where a name alone is a whole record, as in HOLD, it is one
      if (fits_data(reading%table%commands(reading%open), 1)) return
    end if
    if (len(record%items(1)%text) < 4 .or. .not. is_letter(record%items(1)%text(1:1))) return
    call list_keywords(reading%table, table_mesh, commands)
    misspelt = len(nearest_word(commands, record%items(1)%text)) > 0
  end function is_misspelt_command

  !> Says which records a command takes.
  function own_words_text(reading, command) result(t)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(keyword_t), intent(in) :: command !! the command
    character(:), allocatable :: t
    integer :: i

    if (reading%in_parameters) then
      t = 'write name = expression'
    else if (size(command%words) == 0) then
      t = trim(command%name)//' takes no data records'
    else
      t = 'its records begin with one of'
      do i = 1, size(command%words)
        if (command%words(i)%available) t = t//' '//trim(command%words(i)%name)
      end do
    end if
  end function own_words_text

  !> Reports a data record where no data set is open.
  subroutine report_stray(reading, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors

    if (reading%closed > 0) then
      call report_error(diagnostics, record%at, 'data after the blank line that ended '// &
                        trim(reading%table%commands(reading%closed)%name), &
                        'remove the blank line, or repeat '// &
                        trim(reading%table%commands(reading%closed)%name)//' below it')
      call lose(reading, reading%table%commands(reading%closed)%key)
    else
      call lose(reading, '')
      call report_error(diagnostics, record%at, 'a data record without a command', &
                        'begin with the command it belongs to')
    end if
  end subroutine report_stray

  !> Whether a record that begins with an unknown word continues a set that a blank line has ended,
  !! with a name.
  logical function is_stray_name(reading, record, commands) result(stray)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record
    type(word_list_t), intent(in) :: commands !! all commands

    stray = .false.
    if (reading%open > 0 .or. reading%closed == 0) return
    associate (command => reading%table%commands(reading%closed))
      if (.not. may_continue(reading, record)) return
      ! a name and as many numbers as its records have, however like a command the name is
      stray = fits_data(command, item_count(record)) .and. &
        scan(record%items(2)%text(:1), '0123456789.+-(') > 0
      if (stray) return
    end associate
    stray = len(nearest_word(commands, record%items(1)%text)) == 0
  end function is_stray_name

  !> Whether a record may be one of a set that a blank line has ended: it begins with a name.
  logical function may_continue(reading, record)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record

    may_continue = .false.
    if (reading%open > 0 .or. reading%closed == 0 .or. item_count(record) < 2) return
    may_continue = takes_names(reading%table%commands(reading%closed))
  end function may_continue

  !> Whether a record begins with an own word of the set that a blank line has ended: own words go
  !! before commands.
  logical function continues_closed(reading, record)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record

    continues_closed = .false.
    if (reading%open > 0 .or. reading%closed == 0) return
    continues_closed = find_word(reading%table%commands(reading%closed), record%items(1)) > 0
  end function continues_closed

  !> Whether a record begins with a solution command, and not with a mesh command of the same four
  !! letters that is misspelt behind them.
  logical function is_solution_command(reading, record)
    type(reading_t), intent(in) :: reading !! holds the table
    type(record_t), intent(in) :: record !! the record

    is_solution_command = find_keyword(reading%table, table_batch, record%items(1)) > 0 .and. &
      find_keyword(reading%table, table_mesh, record%items(1)) == 0
  end function is_solution_command

  !> PARAmeter, as if it stood where a record begins.
  pure function parameter_word(record) result(item)
    type(record_t), intent(in) :: record !! the record
    type(item_t) :: item

    item = record%items(1)
    item%text = 'PARAmeter'
  end function parameter_word

  !> Reports a record that begins with an unknown word.
  subroutine refuse(reading, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(word_list_t) :: commands, words
    character(:), allocatable :: remedy, word

    if (reading%passing) then
      if (.not. is_misspelt_command(reading, record)) return
    end if
    word = record%items(1)%text
    call list_keywords(reading%table, table_mesh, commands)
    if (reading%in_parameters) then
      remedy = 'write '//word//' = expression'
      if (item_count(record) == 1) remedy = did_you_mean(commands, word, remedy)
      call report_error(diagnostics, record%at, '''='' is missing after '''//word//'''', remedy)
      return
    end if
    if (reading%open == 0 .and. reading%lines%equals) then
      call report_error(diagnostics, record%at, 'a parameter outside of PARAmeter: '''//word// &
        '''', 'write PARAmeter on a line before the first one, and a blank line behind the last')
      reading%open = find_keyword(reading%table, table_mesh, parameter_word(record))
      reading%in_parameters = .true.
      reading%keep = .false.
      return
    end if
    if (continues_closed(reading, record)) then
      if (.not. reading%skipping) call report_stray(reading, record, diagnostics)
      reading%skipping = .true.
      return
    end if
    if (is_solution_command(reading, record)) then
      call report_error(diagnostics, record%at, ''''//word//''' is a solution command', &
                        'solution commands stand between BATCh and END')
      reading%solution = .true.
      call skip_data(reading)
      return
    end if
    if (reading%open > 0) then
      call list_words(reading%table%commands(reading%open), words)
      remedy = nearest_word(words, word)
      if (len(remedy) > 0 .or. (words%count > 0 .and. len(nearest_word(commands, word)) == 0)) then
        call report_error(diagnostics, record%at, 'unknown word '''//word//''' in '// &
          trim(reading%table%commands(reading%open)%name), did_you_mean(words, word, &
          own_words_text(reading, reading%table%commands(reading%open))))
        reading%set%complete = .false.
        reading%set%unknown = .true.
        ! numbers below are data of this word
        reading%skipping = .not. reading%table%commands(reading%open)%has_data
        return
      end if
    end if
    if (is_stray_name(reading, record, commands)) then
      if (.not. reading%skipping) call report_stray(reading, record, diagnostics)
      reading%skipping = .true.
      return
    end if
    remedy = did_you_mean(commands, word, '--help lists the commands')
    if (may_continue(reading, record)) remedy = remedy//' (or remove the blank line that ended '// &
      trim(reading%table%commands(reading%closed)%name)//')'
    call report_error(diagnostics, record%at, 'unknown keyword '''//word//'''', remedy)
    call lose(reading, four_letters(nearest_word(commands, word)), record)
    if (may_continue(reading, record)) call lose(reading, &
      reading%table%commands(reading%closed)%key)
    call skip_data(reading)
  end subroutine refuse
end module mesh_refusals

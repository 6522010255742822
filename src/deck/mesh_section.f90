!> Reads the mesh commands with their data.
module mesh_section
  use deck_types, only: record_t, item_t, item_word, item_quoted
  use records, only: item_count, is_word
  use numbers, only: is_letter
  use foreign_records, only: is_feap_contact, pass_contact, pass_foreign_line
  use parameter_tree, only: find_parameter
  use keyword_types, only: keyword_t, find_keyword, find_word, takes_names, fits_data, table_mesh
  use diagnostics, only: diagnostics_t, report_error
  use command_tails, only: drop_tail
  use reading, only: reading_t, append_record, move_record, close_set, skip_data, lose
  use mesh_refusals, only: pass_foreign, is_misspelt_command, own_words_text, report_stray, refuse
  use matching, only: match_t, match_record
  use deck_parameters, only: define_parameter, guess_parameter
  use parameter_names, only: take_bare_names, report_hidden
  implicit none
  private
  public :: read_mesh_record, read_blank_line

  !> What the first item of a record makes of it.
  integer, parameter :: starts_command = 1
  integer, parameter :: starts_word = 2
  integer, parameter :: starts_data = 3
  integer, parameter :: starts_nothing = 4

contains

  !> Obeys a record of the mesh section.
  subroutine read_mesh_record(reading, record, diagnostics, command)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    character(4), intent(out) :: command !! the command it starts, empty if none
    integer :: kind, number
    logical :: hidden, foreign

    command = ''
    if (is_feap_contact(reading, record)) then
      call pass_contact(reading, record, diagnostics)
      return
    end if
    call pass_foreign_line(reading, record, diagnostics, foreign)
    if (foreign) return
    if (reading%in_parameters .and. reading%lines%equals) then
      call define_parameter(reading, record, diagnostics)
      return
    end if
    call classify(reading, record, kind, number)
    select case (kind)
    case (starts_command)
      if (reading%open > 0) then
        call report_hidden(reading%table%commands(reading%open), reading%table%commands(number), &
          record, reading%parameters(:reading%n_parameters), diagnostics, hidden)
        if (hidden) return
      end if
      command = reading%table%commands(number)%key
      call start_command(reading, number, record, diagnostics)
    case (starts_word)
      call take_word(reading, number, record, diagnostics)
    case (starts_data)
      call take_data(reading, record, diagnostics)
    case default
      call refuse(reading, record, diagnostics)
      if (reading%in_parameters) call guess_parameter(reading, record)
    end select
  end subroutine read_mesh_record

  !> Finds out by its first item what a record is.
  subroutine classify(reading, record, kind, number)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record
    integer, intent(out) :: kind !! one of the constants above
    integer, intent(out) :: number !! index of the command or own word
    type(item_t) :: item
    logical :: names

    item = record%items(1)
    kind = starts_data
    number = 0
    if (item%kind /= item_word) return
    if (.not. is_letter(item%text(1:1)) .and. item%text(1:1) /= '*') return
    names = .false.
    if (reading%open > 0) then
      number = find_word(reading%table%commands(reading%open), item)
      kind = starts_word
      if (number > 0) then
        if (.not. is_rigid_body(record)) return
      end if
      names = takes_names(reading%table%commands(reading%open))
    end if
    kind = starts_data
    if (scan(item%text(2:), '+*/^()') > 0) return
    if (.not. names .and. index(item%text, '-') > 0) return
    kind = starts_command
    number = find_keyword(reading%table, table_mesh, item, spelt=names)
    if (number > 0) then
      if (.not. may_be_data(reading, record, number)) return
      number = 0
    end if
    kind = starts_data
    if (names .or. item%text(1:1) == '*') return
    if (find_parameter(reading%parameters(:reading%n_parameters), item%text) == 0) then
      kind = starts_nothing
    end if
  end subroutine classify

  !> RIGId with a name is the command, whatever set is open: alone it is a word of MATErial.
  logical function is_rigid_body(record) result(rigid)
    type(record_t), intent(in) :: record !! begins with an own word of the open set

    rigid = is_word(record%items(1), 'rigid') .and. item_count(record) > 1
    if (rigid) rigid = any(record%items(2)%kind == [item_word, item_quoted])
  end function is_rigid_body

  !> Whether a word of FEAP is a name or a parameter here: it must not take words away from decks
  !! that know nothing of it.
  logical function may_be_data(reading, record, number) result(data)
    type(reading_t), intent(in) :: reading !! where reading stands
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: number !! index of the command that its first item names

    data = .false.
    if (reading%open == 0 .or. .not. reading%table%commands(number)%foreign) return
    associate (command => reading%table%commands(reading%open))
      data = fits_data(command, item_count(record)) .and. takes_names(command)
    end associate
    data = data .or. find_parameter(reading%parameters(:reading%n_parameters), &
                                    record%items(1)%text) > 0
  end function may_be_data

  !> Closes the open set and starts another.
  subroutine start_command(reading, number, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    integer, intent(in) :: number !! index of the command
    type(record_t), intent(inout) :: record !! its record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical :: good

    call close_set(reading)
    reading%closed = 0
    reading%skipping = .false.
    reading%passing = .false.
    associate (command => reading%table%commands(number))
      if (.not. command%available) then
        call report_error(diagnostics, record%at, trim(command%name)// &
                          ' is not available in this version', &
                          '--help lists the commands and says which are')
        call skip_data(reading)
        return
      end if
      if (command%foreign) then
        call pass_foreign(reading, command, record, diagnostics)
        return
      end if
      call match_head(reading, command, record, diagnostics, good)
      reading%open = number
      reading%set%complete = good
      reading%keep = good
      if (.not. good) reading%keep = is_head(reading, command, record)
      if (.not. reading%keep) call lose(reading, command%key, record)
      select case (command%key)
      case ('para')
        reading%in_parameters = .true.
        reading%keep = .false.
      case ('end', 'batc', 'macr', 'stop')
        reading%open = 0
      case ('pair')
        call continue_contact(reading, record, diagnostics, good)
      case default
        if (command%key == 'cont') reading%contact = .true.
        reading%set%command = command%key
        call move_record(record, reading%set%head)
      end select
    end associate
  end subroutine start_command

  !> Makes a PAIR after a blank line the first record of another CONTact set.
  subroutine continue_contact(reading, record, diagnostics, good)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record of PAIR
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(in) :: good !! whether the record is right

    if (.not. reading%contact) call report_error(diagnostics, record%at, &
      'PAIR without CONTact', 'begin with CONTact')
    reading%contact = .true.
    reading%open = find_keyword_by_key(reading, 'cont')
    reading%set%command = 'cont'
    reading%set%head = record
    reading%keep = .true.
    reading%set%complete = good
    record%word = find_word(reading%table%commands(reading%open), record%items(1))
    if (good) call append_record(reading%set, record)
    if (.not. good) call lose(reading, 'pair')
  end subroutine continue_contact

  !> Index of a mesh command, known to exist.
  pure integer function find_keyword_by_key(reading, key) result(number)
    type(reading_t), intent(in) :: reading !! holds the table
    character(4), intent(in) :: key !! its first four letters

    do number = 1, reading%table%count
      if (reading%table%commands(number)%table /= table_mesh) cycle
      if (reading%table%commands(number)%key == key) return
    end do
  end function find_keyword_by_key

  !> Checks what follows a command in its own record.
  subroutine match_head(reading, command, record, diagnostics, good)
    type(reading_t), intent(in) :: reading !! holds the parameters
    type(keyword_t), intent(in) :: command !! the command
    type(record_t), intent(inout) :: record !! its record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether there was no error
    type(match_t) :: match

    call drop_tail(record, command, diagnostics, good)
    if (.not. good) return
    match%first = 2
    match%name = command%name
    match%head = command%name
    if (size(command%words) > 0) match%tail = '; '//own_words_text(reading, command)
    call match_record(record, command%head, match, reading%parameters(:reading%n_parameters), &
                      diagnostics, good)
  end subroutine match_head

  !> What is left of a refused record would do: its set is kept as one that is not complete, so that
  !! others that name what it defines are not refused for that, too.
  logical function is_head(reading, command, record) result(good)
    type(reading_t), intent(in) :: reading !! holds the parameters
    type(keyword_t), intent(in) :: command !! the command
    type(record_t), intent(inout) :: record !! its record, cut off where it was wrong
    type(diagnostics_t) :: unheard

    call match_head(reading, command, record, unheard, good)
  end function is_head

  !> Obeys a blank line: it ends the open set.
  subroutine read_blank_line(reading)
    type(reading_t), intent(inout) :: reading !! where reading stands

    reading%passing = .false.
    if (reading%open == 0) return
    associate (command => reading%table%commands(reading%open))
      if (command%has_data .or. size(command%words) > 0) reading%closed = reading%open
    end associate
    call close_set(reading)
  end subroutine read_blank_line

  !> Takes a record that begins with an own word of the open set.
  subroutine take_word(reading, number, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    integer, intent(in) :: number !! index of the own word
    type(record_t), intent(inout) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(match_t) :: match
    logical :: good

    reading%skipping = .false.
    associate (command => reading%table%commands(reading%open))
      associate (word => command%words(number))
        good = word%available
        if (good) then
          match%first = 2
          match%name = trim(command%name)//' '//word%name
          match%head = word%name
          call match_record(record, word%signature, match, &
                            reading%parameters(:reading%n_parameters), diagnostics, good)
        else
          call report_error(diagnostics, record%at, trim(word%name)//' of '// &
                            trim(command%name)//' is not available in this version', &
                            '--help '//trim(command%name)//' shows what is')
          ! numbers below are data of this word
          reading%skipping = .not. command%has_data
        end if
      end associate
    end associate
    record%word = number
    if (.not. good .and. is_word(record%items(1), 'pair')) call lose(reading, 'pair')
    call keep_record(reading, record, good)
  end subroutine take_word

  !> Takes a record that begins with a number or a name.
  subroutine take_data(reading, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(match_t) :: match
    logical :: good

    if (reading%skipping) return
    if (reading%open == 0) then
      call report_stray(reading, record, diagnostics)
      reading%skipping = .true.
      return
    end if
    associate (command => reading%table%commands(reading%open))
      if (.not. command%has_data) then
        call report_error(diagnostics, record%at, 'a record of '//trim(command%name)// &
                          ' that begins with '''//record%items(1)%text//'''', &
                          own_words_text(reading, command))
        reading%set%complete = .false.
        if (size(command%words) == 0) call skip_data(reading)
        return
      end if
      if (is_misspelt_command(reading, record)) then
        call refuse(reading, record, diagnostics)
        return
      end if
      call take_bare_names(command, record)
      match%first = 1
      match%name = command%name
      if (any(command%key == ['boun', 'ebou', 'cbou'])) match%tail = &
        '; a code for each direction: 1 restrains it, 0 leaves it free'
      call match_record(record, command%data, match, &
                        reading%parameters(:reading%n_parameters), diagnostics, good)
    end associate
    call keep_record(reading, record, good)
  end subroutine take_data

  !> Keeps a good record.
  subroutine keep_record(reading, record, good)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record
    logical, intent(in) :: good !! whether there was no error in it

    if (good) then
      call append_record(reading%set, record)
    else
      reading%set%complete = .false.
    end if
  end subroutine keep_record
end module mesh_section

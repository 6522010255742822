!> Reads the solution commands, and the tables that follow their END.
module batch_section
  use text, only: to_text, lower
  use deck_types, only: record_t, data_set_t, item_word
  use records, only: item_count
  use hints, only: word_list_t, did_you_mean
  use keyword_types, only: keyword_t, find_keyword, list_keywords, table_mesh, table_batch
  use diagnostics, only: diagnostics_t, report_error, report_note
  use command_tails, only: drop_tail, drop_empty_fields
  use reading, only: reading_t, append_set, append_record, move_record
  use matching, only: match_t, match_record
  use item_checks, only: evaluate_item
  use numbers, only: is_letter
  implicit none
  private
  public :: read_batch_record, read_table_record, check_loops

contains

  !> Obeys a record between BATCh and its END.
  subroutine read_batch_record(reading, record, diagnostics, command)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    character(4), intent(out) :: command !! the command, empty if it is none
    type(data_set_t) :: set
    type(match_t) :: match
    logical :: good
    integer :: number

    command = ''
    number = find_keyword(reading%table, table_batch, record%items(1))
    if (number == 0) then
      call refuse(reading, record, diagnostics)
      return
    end if
    associate (keyword => reading%table%commands(number))
      command = keyword%key
      if (.not. keyword%available) then
        call report_error(diagnostics, record%at, 'the solution command '//trim(keyword%name)// &
                          ' is not available in this version', &
                          '--help lists the commands and says which are')
        return
      end if
      if (keyword%foreign) then
        command = ''
        call pass_foreign(keyword, record, diagnostics)
        return
      end if
      call drop_empty_fields(record)
      call drop_tail(record, keyword, diagnostics, good)
      if (.not. good) return
      match%first = 2
      match%name = keyword%name
      match%head = keyword%name
      match%fields = .true.
      call match_record(record, keyword%head, match, &
                        reading%parameters(:reading%n_parameters), diagnostics, good)
    end associate
    if (.not. good .and. command /= 'loop' .and. command /= 'next') return
    if (command == 'end' .or. command == 'stop') return
    set%command = command
    call move_record(record, set%head)
    call append_set(reading%batch, set)
  end subroutine read_batch_record

  !> Obeys a word of FEAP: passed over with a note, or refused with what to write instead.
  subroutine pass_foreign(keyword, record, diagnostics)
    type(keyword_t), intent(in) :: keyword !! the word
    type(record_t), intent(in) :: record !! its record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes

    if (keyword%ignored) then
      call report_note(diagnostics, record%at, trim(keyword%name)//' is ignored')
    else
      call report_error(diagnostics, record%at, 'the solution command '//trim(keyword%name)// &
                        ' of FEAP is not available in this program', trim(keyword%summary))
    end if
  end subroutine pass_foreign

  !> Reports a record that begins with no solution command.
  subroutine refuse(reading, record, diagnostics)
    type(reading_t), intent(in) :: reading !! holds the table
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(word_list_t) :: list
    logical :: is_number

    associate (item => record%items(1))
      is_number = item%kind /= item_word
      if (.not. is_number) is_number = .not. is_letter(item%text(1:1))
      if (is_number) then
        call report_error(diagnostics, record%at, 'a record of BATCh that begins with '''// &
                          item%text//'''', 'solution commands begin with a keyword; tables '// &
                          'follow the END of BATCh')
      else if (find_keyword(reading%table, table_mesh, item) > 0) then
        call report_error(diagnostics, record%at, ''''//item%text//''' is a mesh command', &
                          'mesh commands stand before BATCh')
      else
        call list_keywords(reading%table, table_batch, list)
        call report_error(diagnostics, record%at, 'unknown solution command '''//item%text// &
                          '''', did_you_mean(list, item%text, '--help lists the commands'))
      end if
    end associate
  end subroutine refuse

  !> Takes a record of numbers behind the END of BATCh.
  subroutine read_table_record(reading, record, group, tables, diagnostics)
    type(reading_t), intent(inout) :: reading !! where reading stands
    type(record_t), intent(inout) :: record !! the record
    integer, intent(in) :: group !! number of its block
    type(data_set_t), intent(inout) :: tables !! the records so far
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical :: good, sound
    integer :: i

    if (reading%passing) return
    if (.not. any_table(reading)) then
      call report_error(diagnostics, record%at, 'a record behind the END of BATCh', &
                        'only the tables of PROP,,n and STOP stand here')
      reading%passing = .true.
      return
    end if
    good = .true.
    do i = 1, item_count(record)
      call evaluate_item(record%items(i), reading%parameters(:reading%n_parameters), &
                         diagnostics, sound)
      good = good .and. sound
      if (.not. good) exit
    end do
    record%group = group
    if (good) call append_record(tables, record)
  end subroutine read_table_record

  !> Whether BATCh asks for a table.
  pure logical function any_table(reading)
    type(reading_t), intent(in) :: reading !! holds the solution commands

    any_table = reading%batch%count > 0
    if (any_table) any_table = any(reading%batch%sets(:reading%batch%count)%command == 'prop')
  end function any_table

  !> Checks that LOOP and NEXT match, and that no NEXT names a loop around the one that it ends.
  subroutine check_loops(reading, diagnostics)
    type(reading_t), intent(in) :: reading !! holds the solution commands
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer, allocatable :: starts(:)
    integer :: i, depth

    allocate (starts(reading%batch%count))
    depth = 0
    do i = 1, reading%batch%count
      associate (set => reading%batch%sets(i))
        if (set%command == 'loop') then
          depth = depth + 1
          starts(depth) = i
        else if (set%command == 'next') then
          if (depth == 0) call report_error(diagnostics, set%head%at, 'NEXT without LOOP', &
                                            'write LOOP,,n before it')
          call check_name(reading, starts(:depth), set%head, diagnostics)
          depth = max(depth - 1, 0)
        end if
      end associate
    end do
    do i = 1, depth
      call report_error(diagnostics, reading%batch%sets(starts(i))%head%at, 'LOOP without NEXT', &
                        'write NEXT behind it')
    end do
  end subroutine check_loops

  !> Reports a NEXT with the name of a loop that is not the innermost: loops would cross.
  subroutine check_name(reading, starts, next, diagnostics)
    type(reading_t), intent(in) :: reading !! holds the solution commands
    integer, intent(in) :: starts(:) !! the commands LOOP that are open, the innermost last
    type(record_t), intent(in) :: next !! the record of NEXT
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    character(:), allocatable :: name, inner
    integer :: k, depth

    depth = size(starts)
    name = loop_name(next)
    if (len(name) == 0 .or. depth < 2) return
    inner = loop_name(reading%batch%sets(starts(depth))%head)
    if (lower(inner) == lower(name)) return
    do k = 1, depth - 1
      if (lower(loop_name(reading%batch%sets(starts(k))%head)) == lower(name)) exit
    end do
    if (k == depth) return
    call report_error(diagnostics, next%items(2)%at, 'NEXT '//name//' crosses the LOOP'// &
      trim(' '//inner)//' of line '//to_text(reading%batch%sets(starts(depth))%head%at%line)// &
      ', which is still open', 'a loop ends within the one around it: write NEXT'// &
      trim(' '//inner)//' before NEXT '//name)
  end subroutine check_name

  !> Name that a record of LOOP or NEXT gives its loop, empty for none.
  function loop_name(record) result(name)
    type(record_t), intent(in) :: record !! its record
    character(:), allocatable :: name

    name = ''
    if (item_count(record) < 2) return
    if (record%items(2)%kind == item_word) name = record%items(2)%text
  end function loop_name
end module batch_section

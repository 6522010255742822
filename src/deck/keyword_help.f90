!> The text of --help and --help KEYWORD, from the keyword table.
module keyword_help
  use linear_solver, only: solver_list
  use deck_types, only: item_t, item_word
  use signatures, only: syntax_text, signature_t
  use hints, only: word_list_t, did_you_mean
  use keyword_types, only: keyword_table_t, keyword_t, find_keyword, find_word, &
    own_word_t, list_keywords, table_mesh, table_batch
  use keywords, only: keyword_table
  implicit none
  private
  public :: help_text, has_help

contains

  !> Help on the program (empty keyword) or on one command.
  function help_text(keyword) result(t)
    character(*), intent(in) :: keyword !! a command or an own word; empty for all
    character(:), allocatable :: t
    type(keyword_table_t) :: table
    type(word_list_t) :: list
    type(item_t) :: item
    integer :: i, mesh, batch

    call keyword_table(table)
    if (len_trim(keyword) == 0) then
      t = usage()//summaries(table, table_mesh, 'Mesh commands:')// &
        summaries(table, table_batch, 'Solution commands (after BATCh):')// &
        foreign_words(table)
      return
    end if
    item%kind = item_word
    item%text = trim(adjustl(keyword))
    mesh = find_keyword(table, table_mesh, item)
    batch = find_keyword(table, table_batch, item)
    t = ''
    if (mesh > 0) t = t//command_help(table%commands(mesh))
    if (batch > 0) t = t//command_help(table%commands(batch))
    do i = 1, table%count
      if (i == mesh .or. i == batch .or. find_word(table%commands(i), item) == 0) cycle
      t = t//word_help(table%commands(i), find_word(table%commands(i), item))
    end do
    if (len(t) > 0) return
    call list_keywords(table, table_mesh, list)
    call list_keywords(table, table_batch, list)
    t = 'There is no command '''//item%text//''': '// &
      did_you_mean(list, item%text, '--help lists the commands')//new_line('a')
  end function help_text

  !> There is help on a keyword: it is empty, a command or an own word.
  logical function has_help(keyword)
    character(*), intent(in) :: keyword !! a word
    type(keyword_table_t) :: table
    type(item_t) :: item
    integer :: i

    has_help = len_trim(keyword) == 0
    if (has_help) return
    call keyword_table(table)
    item%kind = item_word
    item%text = trim(adjustl(keyword))
    has_help = find_keyword(table, table_mesh, item) + find_keyword(table, table_batch, item) > 0
    do i = 1, table%count
      has_help = has_help .or. find_word(table%commands(i), item) > 0
    end do
  end function has_help

  !> How the program is called.
  function usage() result(t)
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')

    t = 'mfec: quasi-static frictional contact of elastic bodies with anisotropic'//nl// &
      '(elliptical) Coulomb friction. One text file is the input; the output are tables'//nl// &
      'and files for ParaView. Read on: doc/manual.md, decks in inputs.'//nl//nl// &
      'Usage: mfec deck.inp [options]'//nl// &
      '  --set name=value   overrides a PARAmeter of the deck (any number of times)'//nl// &
      '  --out DIR          writes the results to DIR'//nl// &
      '  --check            reads, meshes and reports without solving; writes deck.check.*'//nl// &
      '  --solver S         '//solver_list(', ', ' or ')//'; goes before SOLVer'//nl// &
      '  --threads N        threads for elements, contact points and large factors (1)'//nl// &
      '  --restart FILE     goes on from the last state in a results file (.vtkhdf)'//nl// &
      '  --step K           goes on from its output time K instead'//nl// &
      '  --sens NAME,NAME   derivatives of the reactions by these, as SENSitivity'//nl// &
      '  --vary NAME=VALUES many variants of the run, as STUDy: a,b,c or from:to:step'//nl// &
      '  --mesh FILE        a mesh file in place of the nodes and elements of the deck'//nl// &
      '  --increments N     halves each interval of output times: 1, 2, 4, ... increments'//nl// &
      '  --penalty-factor F times the PENAlty of each pair'//nl// &
      '  --log LEVEL        brief (no iterations), normal, or full (worst node, all audits)'//nl// &
      '  --quiet            no progress'//nl// &
      '  -v, --verbose      iterations and the lines of the log, too'//nl// &
      '  --json             progress, audit, errors for a program: one JSON object a line'//nl// &
      '  --version          version, commit and libraries'//nl// &
      '  -h, --help [WORD]  this list, or help on a command or a word of its records'//nl
  end function usage

  !> One line for each command of a table.
  function summaries(table, which, title) result(t)
    type(keyword_table_t), intent(in) :: table !! the table
    integer, intent(in) :: which !! mesh or solution commands
    character(*), intent(in) :: title !! heading
    character(:), allocatable :: t
    integer :: i

    t = new_line('a')//title//new_line('a')
    do i = 1, table%count
      associate (command => table%commands(i))
        if (command%table /= which .or. command%foreign) cycle
        t = t//'  '//command%name//trim(command%summary)// &
          unavailable(command%available)//new_line('a')
      end associate
    end do
  end function summaries

  !> The words of FEAP that are passed over, or refused with what to write instead.
  function foreign_words(table) result(t)
    type(keyword_table_t), intent(in) :: table !! the table
    character(:), allocatable :: t, ignored, refused
    integer :: i

    ignored = ''
    refused = ''
    do i = 1, table%count
      associate (command => table%commands(i))
        if (.not. command%foreign) cycle
        if (command%ignored) then
          ignored = with_word(ignored, trim(command%name))
        else
          refused = with_word(refused, trim(command%name))
        end if
      end associate
    end do
    t = new_line('a')//'Words of FEAP that are ignored with a note:'//ignored//new_line('a')// &
      new_line('a')//'Words of FEAP that are refused (--help WORD says what to write instead):'// &
      refused//new_line('a')
  end function foreign_words

  !> A list with one more word, unless it has it, in lines of 80.
  function with_word(list, word) result(t)
    character(*), intent(in) :: list !! words parted by blanks and line ends
    character(*), intent(in) :: word !! the word
    character(:), allocatable :: t
    integer :: line

    t = list
    if (index(t//' ', ' '//word//' ') + index(t, ' '//word//new_line('a')) > 0) return
    line = len(t) - index(t, new_line('a'), back=.true.)
    if (len(t) == 0 .or. line + len(word) > 78) t = t//new_line('a')//' '
    t = t//' '//word
  end function with_word

  !> A remark on what this version cannot do.
  function unavailable(available) result(t)
    logical, intent(in) :: available !! whether it can
    character(:), allocatable :: t

    t = ''
    if (.not. available) t = ' (not available in this version)'
  end function unavailable

  !> All about one command.
  function command_help(command) result(t)
    type(keyword_t), intent(in) :: command !! the command
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')
    integer :: i

    t = trim(command%name)//': '//trim(command%summary)//unavailable(command%available)//nl//nl
    if (command%foreign) return
    t = t//syntax_lines(command%head, trim(command%name), '  ', command%table == table_batch)
    if (command%has_data) t = t//syntax_lines(command%data, '', '    ', .false.)
    do i = 1, size(command%words)
      t = t//word_lines(command%words(i))
    end do
    t = t//nl
    do i = 1, size(command%help)
      t = t//trim(command%help(i))//nl
    end do
    if (size(command%help) > 0) t = t//nl
  end function command_help

  !> What a word that is a command as well means among the records of another command.
  function word_help(command, number) result(t)
    type(keyword_t), intent(in) :: command !! the other command
    integer, intent(in) :: number !! which of its own words
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')

    t = trim(command%words(number)%name)//' as a record of '//trim(command%name)// &
      ' (more with --help '//trim(command%name)//'):'//nl//nl//word_lines(command%words(number))//nl
  end function word_help

  !> The ways to write a record that begins with an own word, and what it means.
  function word_lines(word) result(t)
    type(own_word_t), intent(in) :: word !! the word
    character(:), allocatable :: t

    t = syntax_lines(word%signature, trim(word%name), '    ', .false.)// &
      '      '//trim(word%summary)//unavailable(word%available)//new_line('a')
  end function word_lines

  !> The ways to write a record, one a line; those that are not available say so.
  function syntax_lines(signature, head, indent, fields) result(t)
    type(signature_t), intent(in) :: signature !! what the record takes
    character(*), intent(in) :: head !! what it begins with
    character(*), intent(in) :: indent !! blanks at the start of a line
    logical, intent(in) :: fields !! whether fields are parted by commas
    character(:), allocatable :: t
    type(signature_t) :: one
    integer :: i

    t = ''
    allocate (one%alternatives(1))
    do i = 1, size(signature%alternatives)
      one%alternatives(1)%tokens = signature%alternatives(i)%tokens
      t = t//indent//syntax_text(one, head, fields)// &
        unavailable(all(one%alternatives(1)%tokens%available))//new_line('a')
    end do
  end function syntax_lines
end module keyword_help

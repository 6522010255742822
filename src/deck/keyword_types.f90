!> What the keyword table is made of, and how it is filled and searched.
module keyword_types
  use text, only: lower
  use deck_types, only: item_t
  use records, only: is_word, four_letters
  use signatures, only: signature_t, compile_signature, token_t, kind_name
  use hints, only: word_list_t, add_candidate
  implicit none
  private
  public :: own_word_t, keyword_t, keyword_table_t, add_command, add_word, add_data, explain, &
    add_ignored, add_refused, fits_data, find_keyword, find_word, list_keywords, list_words, &
    takes_names
  public :: table_mesh, table_batch

  !> The two tables of commands.
  integer, parameter :: table_mesh = 1
  integer, parameter :: table_batch = 2

  !> Room in the table.
  integer, parameter :: most_commands = 200

  !> A word that only one data set knows, at the start of its records.
  type :: own_word_t
    character(16) :: name = '' !! in full, the letters that count as capitals
    character(4) :: key = '' !! first four letters, lower case
    type(signature_t), allocatable :: signature !! what follows it
    logical :: available = .true. !! false if this version cannot do it
    character(80) :: summary = '' !! what it means
  end type own_word_t

  !> A command.
  type :: keyword_t
    character(16) :: name = '' !! in full, the letters that count as capitals
    character(4) :: key = '' !! first four letters, lower case
    integer :: table = table_mesh !! mesh or solution command
    logical :: available = .true. !! false if this version cannot do it
    logical :: foreign = .false. !! FEAP's: passed over, or refused with its summary as advice
    logical :: ignored = .false. !! passed over
    type(signature_t), allocatable :: head !! what follows the keyword itself
    logical :: has_data = .false. !! whether records without an own word belong to it
    type(signature_t), allocatable :: data !! such a record
    type(own_word_t), allocatable :: words(:) !! its own words
    character(320) :: summary = '' !! one line
    character(96), allocatable :: help(:) !! more lines
  end type keyword_t

  !> All commands.
  type :: keyword_table_t
    type(keyword_t) :: commands(most_commands) !! the first count of them are used
    integer :: count = 0 !! number of commands
  end type keyword_table_t

contains

  !> Adds a command; own words, data records and help that are added next belong to it.
  subroutine add_command(table, which, name, head, summary, available)
    type(keyword_table_t), intent(inout) :: table !! the table
    integer, intent(in) :: which !! table_mesh or table_batch
    character(*), intent(in) :: name !! in full, the letters that count as capitals
    character(*), intent(in) :: head !! signature of what follows the keyword
    character(*), intent(in) :: summary !! what the command is for, one line
    logical, intent(in), optional :: available !! false if this version cannot do it

    table%count = table%count + 1
    associate (command => table%commands(table%count))
      command%table = which
      command%name = name
      command%key = four_letters(name)
      command%head = compile_signature(head)
      command%summary = summary
      allocate (command%help(0))
      allocate (command%words(0))
      if (present(available)) command%available = available
    end associate
  end subroutine add_command

  !> Says that records without an own word belong to the last command.
  subroutine add_data(table, signature)
    type(keyword_table_t), intent(inout) :: table !! the table
    character(*), intent(in) :: signature !! signature of these records

    table%commands(table%count)%has_data = .true.
    table%commands(table%count)%data = compile_signature(signature)
  end subroutine add_data

  !> Adds words of FEAP that are passed over with a note.
  subroutine add_ignored(table, which, names)
    type(keyword_table_t), intent(inout) :: table !! the table
    integer, intent(in) :: which !! table_mesh or table_batch
    character(*), intent(in) :: names !! in full, parted by blanks
    integer :: first, length

    first = 1
    do while (first <= len_trim(names))
      length = index(names(first:)//' ', ' ') - 1
      call add_command(table, which, names(first:first + length - 1), '', &
                       'of FEAP: ignored with a note')
      table%commands(table%count)%foreign = .true.
      table%commands(table%count)%ignored = .true.
      first = first + length + 1
    end do
  end subroutine add_ignored

  !> Adds a word of FEAP that would change the answer.
  subroutine add_refused(table, which, name, instead)
    type(keyword_table_t), intent(inout) :: table !! the table
    integer, intent(in) :: which !! table_mesh or table_batch
    character(*), intent(in) :: name !! in full, the letters that count as capitals
    character(*), intent(in) :: instead !! what to write instead

    call add_command(table, which, name, '', instead)
    table%commands(table%count)%foreign = .true.
  end subroutine add_refused

  !> Adds an own word to the last command.
  subroutine add_word(table, name, signature, summary, available)
    type(keyword_table_t), intent(inout) :: table !! the table
    character(*), intent(in) :: name !! in full, the letters that count as capitals
    character(*), intent(in) :: signature !! signature of what follows it
    character(*), intent(in) :: summary !! what it means, one line
    logical, intent(in), optional :: available !! false if this version cannot do it
    type(own_word_t), allocatable :: more(:)
    integer :: n

    n = size(table%commands(table%count)%words)
    allocate (more(n + 1))
    more(:n) = table%commands(table%count)%words
    more(n + 1)%name = name
    more(n + 1)%key = four_letters(name)
    more(n + 1)%signature = compile_signature(signature)
    more(n + 1)%summary = summary
    if (present(available)) more(n + 1)%available = available
    call move_alloc(more, table%commands(table%count)%words)
  end subroutine add_word

  !> Adds a line of help to the last command.
  subroutine explain(table, line)
    type(keyword_table_t), intent(inout) :: table !! the table
    character(*), intent(in) :: line !! at most 96 characters

    character(96), allocatable :: more(:)
    integer :: n

    n = size(table%commands(table%count)%help)
    allocate (more(n + 1))
    more(:n) = table%commands(table%count)%help
    more(n + 1) = line
    call move_alloc(more, table%commands(table%count)%help)
  end subroutine explain

  !> Index of the command an item names, 0 if it names none. Where names may stand it must be spelt
  !! on as in full: `forc` and `force` are FORCe, `force_top` is not.
  pure integer function find_keyword(table, which, item, spelt) result(number)
    type(keyword_table_t), intent(in) :: table !! the table
    integer, intent(in) :: which !! table_mesh or table_batch
    type(item_t), intent(in) :: item !! the item
    logical, intent(in), optional :: spelt !! its letters behind the fourth count, too

    do number = 1, table%count
      if (table%commands(number)%table /= which) cycle
      if (is_word(item, table%commands(number)%key)) exit
    end do
    if (number > table%count) number = 0
    if (number == 0 .or. .not. present(spelt)) return
    if (.not. spelt) return
    associate (name => table%commands(number)%name)
      if (lower(item%text) /= lower(name(:min(len(name), len(item%text))))) number = 0
    end associate
  end function find_keyword

  !> Index of the own word an item names, 0 if it names none.
  pure integer function find_word(command, item) result(number)
    type(keyword_t), intent(in) :: command !! the command
    type(item_t), intent(in) :: item !! the item

    do number = 1, size(command%words)
      if (is_word(item, command%words(number)%key)) return
    end do
    number = 0
  end function find_word

  !> Adds the commands of one table to a list of candidates.
  subroutine list_keywords(table, which, list)
    type(keyword_table_t), intent(in) :: table !! the table
    integer, intent(in) :: which !! table_mesh or table_batch
    type(word_list_t), intent(inout) :: list !! the list
    integer :: i

    do i = 1, table%count
      if (table%commands(i)%table /= which .or. table%commands(i)%foreign) cycle
      call add_candidate(list, trim(table%commands(i)%name))
    end do
  end subroutine list_keywords

  !> Adds the own words of a command to a list of candidates.
  subroutine list_words(command, list)
    type(keyword_t), intent(in) :: command !! the command
    type(word_list_t), intent(inout) :: list !! the list
    integer :: i

    do i = 1, size(command%words)
      call add_candidate(list, trim(command%words(i)%name))
    end do
  end subroutine list_words

  !> Whether a data record of a command may have so many items.
  pure logical function fits_data(command, n) result(fits)
    type(keyword_t), intent(in) :: command !! the command
    integer, intent(in) :: n !! items of the record
    integer :: i

    fits = .false.
    if (.not. command%has_data) return
    do i = 1, size(command%data%alternatives)
      associate (tokens => command%data%alternatives(i)%tokens)
        fits = fits .or. n >= count(.not. tokens%optional) .and. &
          (n <= size(tokens) .or. any(tokens%repeated))
      end associate
    end do
  end function fits_data

  !> Whether records of a command may begin with a name.
  pure logical function takes_names(command)
    type(keyword_t), intent(in) :: command !! the command
    type(token_t) :: first
    integer :: i

    takes_names = .false.
    if (.not. command%has_data) return
    do i = 1, size(command%data%alternatives)
      if (size(command%data%alternatives(i)%tokens) == 0) cycle
      first = command%data%alternatives(i)%tokens(1)
      if (first%kind == kind_name) takes_names = .true.
    end do
  end function takes_names
end module keyword_types

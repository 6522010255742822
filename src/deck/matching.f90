!> Checks a record against its signature and evaluates its numbers.
module matching
  use deck_types, only: record_t, item_t, parameter_t, item_empty, item_number, item_word, &
    item_quoted
  use records, only: is_word, item_count, item_location
  use signatures, only: token_t, signature_t, syntax_text, token_name, kind_name, kind_file_name, &
    kind_any, kind_node_list, kind_choice, kind_keyword, kind_nothing
  use hints, only: word_list_t, add_candidate, is_listed, did_you_mean
  use source, only: source_line
  use missing_words, only: with_word, is_value, decimal_comma, counts
  use numbers, only: is_letter
  use expressions, only: problem_t
  use parameter_tree, only: find_parameter
  use diagnostics, only: diagnostics_t, report_error
  use item_checks, only: set_value, report_problem, check_value, check_name, check_choice
  implicit none
  private
  public :: match_t, match_record

  !> Ways to accept an item, the better the greater.
  integer, parameter :: accept_not = 0
  integer, parameter :: accept_number = 1
  integer, parameter :: accept_name = 2
  integer, parameter :: accept_keyword = 3

  !> Most alternatives of a signature.
  integer, parameter :: most_alternatives = 16

  !> What a record is checked against.
  type :: match_t
    integer :: first = 1 !! first item that the signature is about
    character(40) :: name = '' !! command or own word, for messages
    character(40) :: head = '' !! what such a record begins with, for the syntax
    character(200) :: tail = '' !! what follows the record, for messages
    logical :: fields = .false. !! whether fields count by position (solution commands)
  end type match_t

contains

  !> Checks and evaluates a record; every error is reported. The record is cut off before an item
  !! that cannot stand where it does.
  subroutine match_record(record, signature, match, parameters, diagnostics, good)
    type(record_t), intent(inout) :: record !! the record; its numbers are evaluated, and it may
    !! become shorter
    type(signature_t), intent(in) :: signature !! what it takes
    type(match_t), intent(in) :: match !! which record this is
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether there was no error
    logical :: alive(most_alternatives), alive_before(most_alternatives), sound
    integer :: accepted(most_alternatives), i, j, k, n
    type(word_list_t) :: words
    type(problem_t), allocatable :: problem

    n = size(signature%alternatives)
    alive = .false.
    alive(:n) = .true.
    if (starts_with_parameter(record, match, parameters)) call keep_fitting(record, signature, &
      match, alive(:n))
    good = .true.
    do k = match%first, item_count(record)
      do i = 1, n
        accepted(i) = accept_not
        if (.not. alive(i)) cycle
        associate (tokens => signature%alternatives(i)%tokens)
          j = token_number(tokens, k - match%first + 1)
          if (j > 0) accepted(i) = acceptance(tokens(j), record%items(k))
        end associate
      end do
      if (all(accepted(:n) == accept_not)) then
        ! what number of items a record has tells no more once it cannot be right
        if (k == match%first) alive(:n) = .true.
        call report_item(record, k, signature, alive(:n), match, parameters, diagnostics)
        record%items = record%items(:k - 1)
        good = .false.
        return
      end if
      alive_before = alive
      alive(:n) = alive(:n) .and. accepted(:n) == maxval(accepted(:n))
      i = findloc(alive(:n), .true., dim=1)
      j = token_number(signature%alternatives(i)%tokens, k - match%first + 1)
      call take_item(record, k, signature%alternatives(i)%tokens(j), match, parameters, &
                     diagnostics, problem, sound)
      if (allocated(problem)) then
        call list_expected_words(signature, alive_before(:n), k - match%first + 1, words)
        if (index(problem%remedy, 'define') == 1 .and. words%count == 0 .and. &
          counts(signature%alternatives(i)%tokens(j))) problem%remedy = 'a number stands here: '// &
          expectation(signature, alive(:n), match)//'; a parameter is defined before, in a '// &
          'PARAmeter data set'
        call report_problem(record%items(k), problem, parameters, words, diagnostics)
      end if
      good = good .and. sound
      if (.not. sound .and. record%items(k)%kind /= item_number) then
        record%items = record%items(:k - 1)
        return
      end if
    end do
    call check_complete(record, signature, alive(:n), match, diagnostics, good)
  end subroutine match_record

  !> The first item is a word that could be a name, and a parameter has this name, too.
  logical function starts_with_parameter(record, match, parameters) result(yes)
    type(record_t), intent(in) :: record !! the record
    type(match_t), intent(in) :: match !! which record this is
    type(parameter_t), intent(in) :: parameters(:) !! parameters there are

    yes = .false.
    if (item_count(record) < match%first) return
    if (record%items(match%first)%kind /= item_word) return
    yes = find_parameter(parameters, record%items(match%first)%text) > 0
  end function starts_with_parameter

  !> Leaves only the ways that take as many items as there are; all of them if none does.
  pure subroutine keep_fitting(record, signature, match, alive)
    type(record_t), intent(in) :: record !! the record
    type(signature_t), intent(in) :: signature !! what it takes
    type(match_t), intent(in) :: match !! which record this is
    logical, intent(inout) :: alive(:) !! ways that are possible
    logical :: fits(size(alive))
    integer :: i, n

    n = item_count(record) - match%first + 1
    do i = 1, size(alive)
      associate (tokens => signature%alternatives(i)%tokens)
        fits(i) = n >= count(.not. tokens%optional)
        if (n > size(tokens)) fits(i) = fits(i) .and. any(tokens%repeated)
      end associate
    end do
    if (any(fits)) alive = alive .and. fits
  end subroutine keep_fitting

  !> Number of the token of the k-th item in one alternative; 0 where nothing may stand.
  pure integer function token_number(tokens, k) result(number)
    type(token_t), intent(in) :: tokens(:) !! one way to write a record
    integer, intent(in) :: k !! number of the item in the signature

    number = 0
    if (k <= size(tokens)) then
      number = k
    else if (size(tokens) > 0) then
      if (tokens(size(tokens))%repeated) number = size(tokens)
    end if
  end function token_number

  !> How well an item fits a token.
  pure integer function acceptance(token, item)
    type(token_t), intent(in) :: token !! what may stand here
    type(item_t), intent(in) :: item !! what stands here

    acceptance = accept_not
    select case (token%kind)
    case (kind_keyword)
      if (is_word(item, token%key)) acceptance = accept_keyword
    case (kind_nothing)
      if (item%kind == item_empty) acceptance = accept_keyword
    case (kind_choice)
      if (item%kind == item_word) acceptance = accept_name
    case (kind_name)
      if (item%kind == item_quoted) acceptance = accept_name
      if (item%kind == item_word) then
        if (is_letter(item%text(1:1)) .and. scan(item%text, '+*/^()') == 0) then
          acceptance = accept_name
        end if
      end if
    case (kind_file_name, kind_any)
      if (item%kind /= item_empty) acceptance = accept_name
    case default
      if (item%kind /= item_quoted) acceptance = accept_number
    end select
  end function acceptance

  !> Evaluates or checks an item that its token accepts. An expression without a value is left to
  !! the caller, who knows what else could stand there.
  subroutine take_item(record, k, token, match, parameters, diagnostics, problem, good)
    type(record_t), intent(inout) :: record !! the record
    integer, intent(in) :: k !! number of the item
    type(token_t), intent(in) :: token !! what stands here
    type(match_t), intent(in) :: match !! which record this is
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(problem_t), allocatable, intent(out) :: problem !! why the expression has no value
    logical, intent(out) :: good !! whether there was no error

    good = .true.
    if (.not. token%available) then
      call report_unavailable(record, k, token, match, diagnostics)
      good = .false.
      return
    end if
    select case (token%kind)
    case (kind_keyword, kind_nothing, kind_any)
      continue
    case (kind_choice)
      call check_choice(record%items(k), token, diagnostics, good)
    case (kind_name)
      call check_name(record%items(k), diagnostics, good)
    case (kind_file_name)
      good = len(record%items(k)%text) > 0
      if (.not. good) call report_error(diagnostics, record%items(k)%at, 'an empty file name', &
                                        'name a file')
    case default
      if (token%kind == kind_node_list) then
        if (is_word(record%items(k), 'to')) then
          call check_range_word(record, k, match, diagnostics, good)
          return
        end if
      end if
      call set_value(record%items(k), parameters, problem)
      good = .not. allocated(problem)
      if (good) call check_value(record%items(k), token, diagnostics, good)
    end select
  end subroutine take_item

  !> Keywords that could stand as the k-th item.
  subroutine list_expected_words(signature, alive, k, words)
    type(signature_t), intent(in) :: signature !! what the record takes
    logical, intent(in) :: alive(:) !! ways still possible
    integer, intent(in) :: k !! number of the item in the signature
    type(word_list_t), intent(out) :: words !! the keywords
    integer :: i, j

    do i = 1, size(alive)
      if (.not. alive(i)) cycle
      associate (tokens => signature%alternatives(i)%tokens)
        j = token_number(tokens, k)
        if (j == 0) cycle
        if (tokens(j)%kind /= kind_keyword) cycle
        if (.not. is_listed(words, trim(tokens(j)%label))) then
          call add_candidate(words, trim(tokens(j)%label))
        end if
      end associate
    end do
  end subroutine list_expected_words

  !> Checks that TO stands between two numbers.
  subroutine check_range_word(record, k, match, diagnostics, good)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: k !! number of the item TO
    type(match_t), intent(in) :: match !! which record this is
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether it does

    good = k > match%first .and. k < item_count(record)
    if (good) good = record%items(k - 1)%kind == item_number &
                     .and. .not. is_word(record%items(k + 1), 'to')
    if (good .and. k - 2 >= match%first) good = .not. is_word(record%items(k - 2), 'to')
    if (.not. good) call report_error(diagnostics, record%items(k)%at, &
      'TO without a number on either side', 'write a range as 20 TO 40')
  end subroutine check_range_word

  !> Says that an item asks for something this version cannot do.
  subroutine report_unavailable(record, k, token, match, diagnostics)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: k !! number of the item
    type(token_t), intent(in) :: token !! what stands here
    type(match_t), intent(in) :: match !! which record this is
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    character(:), allocatable :: what

    what = trim(token%label)
    if (token%kind /= kind_keyword) what = 'the item '//what
    call report_error(diagnostics, record%items(k)%at, what//' of '//trim(match%name)// &
                      ' is not available in this version', &
                      '--help '//match%name(:index(match%name, ' '))//'shows what is')
  end subroutine report_unavailable

  !> Says that an item cannot stand where it does.
  subroutine report_item(record, k, signature, alive, match, parameters, diagnostics)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: k !! number of the item
    type(signature_t), intent(in) :: signature !! what the record takes
    logical, intent(in) :: alive(:) !! ways still possible before this item
    type(match_t), intent(in) :: match !! which record this is
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(word_list_t) :: words
    character(:), allocatable :: wanted
    logical :: room, option
    integer :: i, j

    room = .false.
    option = .false.
    do i = 1, size(alive)
      if (.not. alive(i)) cycle
      j = token_number(signature%alternatives(i)%tokens, k - match%first + 1)
      if (j == 0) cycle
      room = .true.
      option = option .or. signature%alternatives(i)%tokens(j)%kind == kind_nothing
    end do
    associate (item => record%items(k))
      call list_expected_words(signature, alive, k - match%first + 1, words)
      if (option .and. is_value(item, parameters)) then
        call report_error(diagnostics, item%at, 'a number in the option field', &
                          'an empty option is two commas: '//with_empty_option(record))
      else if (.not. room) then
        call report_error(diagnostics, item%at, 'too many items: '''//item%text//'''', &
                          expectation(signature, alive, match)//trim(match%tail)// &
                          decimal_comma(record, k, source_line(diagnostics%source, &
                          item%at%file, item%at%line))//parameter_advice(record, parameters))
      else if (item%kind == item_empty) then
        call report_error(diagnostics, item%at, 'an empty field', &
                          expectation(signature, alive, match))
      else
        wanted = expectation(signature, alive, match)
        if (is_value(item, parameters)) wanted = with_word(record, match%first, match%head, k, &
          signature, alive, wanted)
        call report_error(diagnostics, item%at, ''''//item%text//''' cannot stand here', &
                          did_you_mean(words, item%text, wanted))
      end if
    end associate
  end subroutine report_item

  !> Advice for a record that begins with the name of a parameter; empty if it does not.
  function parameter_advice(record, parameters) result(t)
    type(record_t), intent(in) :: record !! the record
    type(parameter_t), intent(in) :: parameters(:) !! parameters there are
    character(:), allocatable :: t

    t = ''
    if (record%items(1)%kind /= item_word) return
    if (find_parameter(parameters, record%items(1)%text) > 0) then
      t = '; a parameter at the start of a record is written ('//record%items(1)%text//')'
    end if
  end function parameter_advice

  !> A solution command as it would be right: the option empty, the rest behind it.
  function with_empty_option(record) result(t)
    type(record_t), intent(in) :: record !! the record as written
    character(:), allocatable :: t
    integer :: i

    t = record%items(1)%text//','
    do i = 2, item_count(record)
      t = t//','//record%items(i)%text
    end do
  end function with_empty_option

  !> Reports a record that ends too early.
  subroutine check_complete(record, signature, alive, match, diagnostics, good)
    type(record_t), intent(in) :: record !! the record
    type(signature_t), intent(in) :: signature !! what it takes
    logical, intent(in) :: alive(:) !! ways still possible
    type(match_t), intent(in) :: match !! which record this is
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(inout) :: good !! false if it ends too early
    character(:), allocatable :: missing
    integer :: i, k

    missing = ''
    k = item_count(record) - match%first + 2
    do i = 1, size(alive)
      if (.not. alive(i)) cycle
      associate (tokens => signature%alternatives(i)%tokens)
        if (k > size(tokens)) return
        if (tokens(k)%optional) return
        if (len(missing) == 0) missing = token_name(tokens(k))
        if (tokens(k)%kind == kind_nothing) missing = token_name(tokens(min(k + 1, size(tokens))))
      end associate
    end do
    good = .false.
    call report_error(diagnostics, item_location(record, item_count(record) + 1), &
                      'too few items: '//missing//' is missing', &
                      expectation(signature, alive, match)//trim(match%tail))
  end subroutine check_complete

  !> What a record that begins as this one does should look like.
  function expectation(signature, alive, match) result(t)
    type(signature_t), intent(in) :: signature !! what it takes
    logical, intent(in) :: alive(:) !! ways that its items have left open
    type(match_t), intent(in) :: match !! which record this is
    character(:), allocatable :: t
    type(signature_t) :: open
    integer :: i, n

    n = 0
    allocate (open%alternatives(count(alive)))
    do i = 1, size(alive)
      if (.not. alive(i)) cycle
      n = n + 1
      open%alternatives(n)%tokens = signature%alternatives(i)%tokens
    end do
    if (takes_nothing(open)) then
      t = trim(match%name)//' takes no further items'
      return
    end if
    t = trim(match%name)//' takes: '//syntax_text(open, trim(match%head), match%fields)
    if (n < size(alive)) t = t//'; other ways: --help '//match%name(:index(match%name, ' ') - 1)
  end function expectation

  !> A word or command that stands alone.
  pure logical function takes_nothing(signature)
    type(signature_t), intent(in) :: signature !! what may follow it
    integer :: i

    takes_nothing = .true.
    do i = 1, size(signature%alternatives)
      if (size(signature%alternatives(i)%tokens) > 0) takes_nothing = .false.
    end do
  end function takes_nothing
end module matching

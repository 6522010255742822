!> Evaluates single items and checks that they are of the kind that is wanted.
module item_checks
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: item_t, location_t, parameter_t, name_length, item_empty, item_number, &
    item_quoted
  use records, only: is_word
  use signatures, only: token_t, kind_positive, kind_count, kind_integer, kind_axis, &
    kind_positive_real, kind_not_negative, kind_node_list, kind_exact
  use hints, only: word_list_t, add_candidate, did_you_mean
  use numbers, only: is_letter
  use expressions, only: problem_t, evaluate
  use diagnostics, only: diagnostics_t, report_error
  implicit none
  private
  public :: evaluate_item, set_value, report_problem, check_value, check_name, check_choice

  !> Numbers beyond this one are slips: squares and products of two have to be numbers as well.
  real(wp), parameter :: max_number = 1.0e100_wp

contains

  !> Turns an item into a number and reports what is wrong with it.
  subroutine evaluate_item(item, parameters, diagnostics, good)
    type(item_t), intent(inout) :: item !! the item
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether it has a value
    type(problem_t), allocatable :: problem
    type(word_list_t) :: no_words

    call set_value(item, parameters, problem)
    good = .not. allocated(problem)
    if (.not. good) call report_problem(item, problem, parameters, no_words, diagnostics)
  end subroutine evaluate_item

  !> Turns an item into a number.
  subroutine set_value(item, parameters, problem)
    type(item_t), intent(inout) :: item !! the item
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(problem_t), allocatable, intent(out) :: problem !! allocated if it has no value

    if (item%kind == item_empty) return
    call evaluate(item%text, parameters, item%value, problem)
    if (.not. allocated(problem)) item%kind = item_number
  end subroutine set_value

  !> Reports an item that has no value.
  subroutine report_problem(item, problem, parameters, words, diagnostics)
    type(item_t), intent(in) :: item !! the item
    type(problem_t), intent(in) :: problem !! what is wrong with it
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(word_list_t), intent(inout) :: words !! keywords that might stand here instead
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(location_t) :: at
    character(:), allocatable :: remedy
    integer :: i

    at = item%at
    at%column = at%column + problem%position - 1
    if (item%kind == item_quoted) at%column = at%column + 1
    remedy = problem%remedy
    if (problem%undefined .and. words%count > 0) then
      remedy = 'a number is expected here, or one of: '//joined(words)
      do i = 1, size(parameters)
        call add_candidate(words, parameters(i)%name)
      end do
      remedy = did_you_mean(words, item%text, remedy)
    end if
    call report_error(diagnostics, at, problem%what, remedy)
  end subroutine report_problem

  !> Words in one line.
  function joined(words) result(t)
    type(word_list_t), intent(in) :: words !! the words
    character(:), allocatable :: t
    integer :: i

    t = ''
    do i = 1, min(words%count, 12)
      if (i > 1) t = t//', '
      t = t//words%words(i)%s
    end do
  end function joined

  !> Checks that a number is of the kind its token wants.
  subroutine check_value(item, token, diagnostics, good)
    type(item_t), intent(inout) :: item !! an evaluated item; integers are rounded
    type(token_t), intent(in) :: token !! what stands here
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether the value is right
    character(:), allocatable :: wanted

    wanted = ''
    select case (token%kind)
    case (kind_positive)
      if (.not. is_integer(item, 1, huge(1))) wanted = 'an integer greater than 0'
    case (kind_count)
      if (.not. is_integer(item, 0, huge(1))) wanted = 'an integer not less than 0'
    case (kind_integer)
      if (.not. is_integer(item, -huge(1), huge(1))) wanted = 'an integer'
    case (kind_node_list)
      if (.not. is_integer(item, 1, huge(1))) wanted = 'an integer greater than 0 or TO'
    case (kind_axis)
      if (.not. is_integer(item, 1, 3)) wanted = '1, 2 or 3'
    case (kind_exact)
      if (.not. is_integer(item, token%exact, token%exact)) wanted = to_text(token%exact)// &
        ' (nothing else is available in this version)'
    case (kind_positive_real)
      if (item%value <= 0.0_wp) wanted = 'a number greater than 0'
    case (kind_not_negative)
      if (item%value < 0.0_wp) wanted = 'a number not less than 0'
    case default
      continue
    end select
    good = len(wanted) == 0
    if (index(wanted, 'an integer') == 1 .and. abs(item%value) > real(huge(1), wp)) wanted = &
      'an integer of at most '//to_text(huge(1))
    if (.not. good) then
      call report_error(diagnostics, item%at, &
        trim(token%label)//' = '//to_text(item%value)//' is out of its range', &
        trim(token%label)//' is '//wanted)
    else if (abs(item%value) > max_number) then
      good = .false.
      call report_error(diagnostics, item%at, trim(token%label)//' = '//to_text(item%value)// &
        ' is absurdly large', 'numbers lie between -1e100 and 1e100: look at units, parameters '// &
        'and --set')
    end if
  end subroutine check_value

  !> Whether a number is an integer within bounds; it is rounded if it is one up to round-off.
  logical function is_integer(item, lowest, highest)
    type(item_t), intent(inout) :: item !! an evaluated item
    integer, intent(in) :: lowest !! least value allowed
    integer, intent(in) :: highest !! greatest value allowed

    is_integer = abs(item%value) <= real(huge(1), wp)
    if (.not. is_integer) return
    is_integer = abs(item%value - anint(item%value)) <= 1e-9_wp*max(1.0_wp, abs(item%value))
    if (.not. is_integer) return
    item%value = anint(item%value)
    is_integer = nint(item%value) >= lowest .and. nint(item%value) <= highest
  end function is_integer

  !> Checks that a name is one.
  subroutine check_name(item, diagnostics, good)
    type(item_t), intent(in) :: item !! the item
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether it can be a name

    good = .false.
    if (len(item%text) > name_length) then
      call report_error(diagnostics, item%at, 'a name of '//to_text(len(item%text))// &
                        ' characters', 'names have up to '//to_text(name_length)//' characters')
    else if (len(item%text) == 0) then
      call report_error(diagnostics, item%at, 'an empty name', 'a name begins with a letter')
    else if (.not. is_letter(item%text(1:1))) then
      call report_error(diagnostics, item%at, ''''//item%text//''' is no name', &
                        'a name begins with a letter')
    else
      good = .true.
    end if
  end subroutine check_name

  !> Checks that a word is among those a label lists.
  subroutine check_choice(item, token, diagnostics, good)
    type(item_t), intent(in) :: item !! the item
    type(token_t), intent(in) :: token !! lists the words
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether it is one of them
    type(word_list_t) :: words
    character(64) :: rest
    integer :: comma

    rest = token%label
    good = .false.
    do while (len_trim(rest) > 0)
      comma = index(trim(rest)//',', ',')
      if (is_word(item, rest(:comma - 1))) good = .true.
      call add_candidate(words, rest(:comma - 1))
      rest = rest(comma + 1:)
    end do
    if (.not. good) call report_error(diagnostics, item%at, 'unknown word '''//item%text//'''', &
      did_you_mean(words, item%text, 'one of: '//joined(words)))
  end subroutine check_choice
end module item_checks

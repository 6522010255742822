!> Parameters: their definitions in the deck and on the command line.
module deck_parameters
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: record_t, parameter_t, location_t, item_word, name_length
  use records, only: item_count, item_location
  use safe_math, only: is_reserved
  use numbers, only: is_letter, is_name_character
  use hints, only: word_list_t, add_candidate, did_you_mean
  use expressions, only: evaluate, problem_t
  use parameter_tree, only: find_parameter, link_parameter
  use diagnostics, only: diagnostics_t, report_error
  use reading, only: reading_t
  use item_checks, only: evaluate_item
  implicit none
  private
  public :: define_parameter, guess_parameter, check_overrides

contains

  !> Obeys a record `name = expression`.
  subroutine define_parameter(reading, record, diagnostics)
    type(reading_t), intent(inout) :: reading !! parameters and overrides
    type(record_t), intent(inout) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical :: good

    call remove_parentheses(record)
    call check_definition(record, diagnostics, good)
    if (.not. good) then
      if (record%items(1)%kind == item_word) call set_parameter(reading, record%items(1)%text, &
                                                                1.0_wp)
      return
    end if
    call evaluate_item(record%items(2), reading%parameters(:reading%n_parameters), diagnostics, &
                       good)
    ! a parameter without a value gets 1, so that one error does not become many
    if (.not. good) record%items(2)%value = 1.0_wp
    call apply_overrides(reading, record%items(1)%text, record%items(2)%value, diagnostics)
    call set_parameter(reading, record%items(1)%text, record%items(2)%value)
  end subroutine define_parameter

  !> A parameter whose definition has been refused gets a value all the same, so that one error
  !! does not become many.
  subroutine guess_parameter(reading, record)
    type(reading_t), intent(inout) :: reading !! parameters
    type(record_t), intent(in) :: record !! the definition

    if (record%items(1)%kind /= item_word) return
    if (.not. is_parameter_name(record%items(1)%text) .or. is_reserved(record%items(1)%text)) return
    call set_parameter(reading, record%items(1)%text, 1.0_wp)
  end subroutine guess_parameter

  !> A name like that of a command stands in parentheses where it begins a record: here, too.
  subroutine remove_parentheses(record)
    type(record_t), intent(inout) :: record !! name and value
    character(:), allocatable :: name
    integer :: last

    name = record%items(1)%text
    last = len(name)
    if (record%items(1)%kind /= item_word .or. last < 3) return
    if (name(1:1) /= '(' .or. name(last:last) /= ')') return
    if (is_parameter_name(name(2:last - 1))) record%items(1)%text = name(2:last - 1)
  end subroutine remove_parentheses

  !> Checks the form of a definition.
  subroutine check_definition(record, diagnostics, good)
    type(record_t), intent(in) :: record !! name and value
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: good !! whether it is a definition

    good = .false.
    associate (name => record%items(1)%text, at => record%items(1)%at)
      if (record%items(1)%kind /= item_word .or. .not. is_parameter_name(name)) then
        call report_error(diagnostics, at, ''''//name//''' is no name of a parameter', &
                          'a name is a letter followed by letters, digits and _, at most '// &
                          to_text(name_length)//' characters')
      else if (is_reserved(name)) then
        call report_error(diagnostics, at, ''''//name//''' has a meaning of its own', &
                          'choose a name that is no function''s and not pi')
      else if (item_count(record) < 2) then
        call report_error(diagnostics, item_location(record, 2), &
                          'too few items: the value of '''//name//''' is missing', &
                          'write '//name//' = expression')
      else if (item_count(record) > 2) then
        call report_error(diagnostics, record%items(3)%at, 'too many items: '''// &
                          record%items(3)%text//'''', 'one parameter a line'// &
                          without_blanks(record))
      else
        good = .true.
      end if
    end associate
  end subroutine check_definition

  !> Advice for an expression that was written with blanks; empty if it was not.
  function without_blanks(record) result(t)
    type(record_t), intent(in) :: record !! name and more than one item
    character(:), allocatable :: t
    integer :: i

    t = ''
    if (scan(record%items(3)%text//'x', '+-*/^)') /= 1) return
    t = ', and no blanks inside an expression: '//record%items(1)%text//' = '
    do i = 2, item_count(record)
      t = t//record%items(i)%text
    end do
  end function without_blanks

  !> Whether a parameter may have this name.
  pure logical function is_parameter_name(name)
    character(*), intent(in) :: name !! the name
    integer :: i

    is_parameter_name = len(name) > 0 .and. len(name) <= name_length
    if (.not. is_parameter_name) return
    is_parameter_name = is_letter(name(1:1))
    do i = 2, len(name)
      if (.not. is_name_character(name(i:i))) is_parameter_name = .false.
    end do
  end function is_parameter_name

  !> Replaces the value by that of the command line, the last one if there are several.
  subroutine apply_overrides(reading, name, value, diagnostics)
    type(reading_t), intent(inout) :: reading !! overrides; those of this name become used
    character(*), intent(in) :: name !! name of the parameter
    real(wp), intent(inout) :: value !! its value
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(problem_t), allocatable :: problem
    type(location_t) :: command_line
    logical :: seen
    real(wp) :: given
    integer :: i, known

    known = find_parameter(reading%parameters(:reading%n_parameters), name)
    do i = 1, size(reading%overrides)
      associate (setting => reading%overrides(i))
        if (len(setting%name) /= len(name) .or. setting%name /= name) cycle
        seen = reading%used(i)
        reading%used(i) = .true.
        if (seen .and. known > 0) then
          value = reading%parameters(known)%value
          cycle
        end if
        call evaluate(setting%value, reading%parameters(:reading%n_parameters), given, problem)
        if (.not. allocated(problem)) then
          value = given
          cycle
        end if
        call report_error(diagnostics, command_line, '--set '//setting%name//'='// &
                          setting%value//': '//problem%what, problem%remedy)
      end associate
    end do
  end subroutine apply_overrides

  !> Gives a parameter its value, whether it is new or not.
  subroutine set_parameter(reading, name, value)
    type(reading_t), intent(inout) :: reading !! the parameters
    character(*), intent(in) :: name !! name of the parameter
    real(wp), intent(in) :: value !! its value
    type(parameter_t), allocatable :: more(:)
    integer :: i

    i = find_parameter(reading%parameters(:reading%n_parameters), name)
    if (i == 0) then
      if (reading%n_parameters == size(reading%parameters)) then
        allocate (more(2*reading%n_parameters))
        do i = 1, reading%n_parameters
          call move_alloc(reading%parameters(i)%name, more(i)%name)
          more(i)%value = reading%parameters(i)%value
          more(i)%key = reading%parameters(i)%key
          more(i)%below = reading%parameters(i)%below
        end do
        call move_alloc(more, reading%parameters)
      end if
      reading%n_parameters = reading%n_parameters + 1
      i = reading%n_parameters
      reading%parameters(i)%name = name
      call link_parameter(reading%parameters(:i))
    end if
    reading%parameters(i)%value = value
  end subroutine set_parameter

  !> Reports what the command line sets and the deck does not know.
  subroutine check_overrides(reading, diagnostics)
    type(reading_t), intent(in) :: reading !! parameters and overrides
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(location_t) :: command_line
    type(word_list_t) :: list
    integer :: i

    do i = 1, reading%n_parameters
      call add_candidate(list, reading%parameters(i)%name)
    end do
    do i = 1, size(reading%overrides)
      if (reading%used(i)) cycle
      associate (setting => reading%overrides(i))
        call report_error(diagnostics, command_line, '--set '//setting%name//'='// &
                          setting%value//': the deck has no parameter '''//setting%name//'''', &
                          did_you_mean(list, setting%name, 'PARAmeter data sets define them'))
      end associate
    end do
  end subroutine check_overrides
end module deck_parameters

!> Evaluates the numbers and expressions of a deck.
!!
!! sum = product {+|- product}; product = factor {*|/ factor}; factor = [+|-] factor | power;
!! power = primary [^ factor]; primary = number | name | name(sum, ...) | (sum).
module expressions
  use kinds, only: wp, pi
  use text, only: to_text, lower
  use deck_types, only: parameter_t
  use parameter_tree, only: find_parameter
  use hints, only: word_list_t, add_candidate, did_you_mean
  use numbers, only: scan_number, is_digit, is_letter, is_name_character
  use safe_math, only: safe_sum, safe_product, safe_quotient, safe_power, apply_function, &
    function_names, is_function
  implicit none
  private
  public :: problem_t, evaluate

  !> Deepest nesting of parentheses, signs and powers.
  integer, parameter :: deepest_nesting = 100

  !> Why an expression has no value.
  type :: problem_t
    integer :: position = 1 !! character of the expression it is found at
    character(:), allocatable :: what !! what is wrong
    character(:), allocatable :: remedy !! what would be right
    logical :: undefined = .false. !! whether a name in it means nothing
  end type problem_t

  !> Where the evaluation stands.
  type :: cursor_t
    integer :: i = 1 !! current character
    integer :: depth = 0 !! nesting so far
    type(problem_t), allocatable :: problem !! the first problem met
  end type cursor_t

contains

  !> Value of an expression.
  subroutine evaluate(text, parameters, value, problem)
    character(*), intent(in) :: text !! the expression, without blanks
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    real(wp), intent(out) :: value !! its value, 0 if it has none
    type(problem_t), allocatable, intent(out) :: problem !! why it has none
    type(cursor_t) :: cursor

    call parse_sum(text, parameters, cursor, value)
    if (.not. allocated(cursor%problem) .and. cursor%i <= len(text)) call report_rest(text, cursor)
    if (allocated(cursor%problem)) then
      value = 0.0_wp
      call move_alloc(cursor%problem, problem)
    end if
  end subroutine evaluate

  !> Says what is wrong with characters behind a complete expression.
  subroutine report_rest(text, cursor)
    character(*), intent(in) :: text !! the expression
    type(cursor_t), intent(inout) :: cursor !! at the first character behind it

    select case (text(cursor%i:cursor%i))
    case (')')
      call fail(cursor, cursor%i, 'a closing parenthesis without an opening one', &
                'remove it, or open the parenthesis before')
    case (',')
      call fail(cursor, cursor%i, 'a comma inside an expression', 'only max and min take a list')
    case default
      call fail(cursor, cursor%i, ''''//text//''' is neither a number nor an expression', &
                'the character '''//text(cursor%i:cursor%i)//''' cannot follow here')
    end select
  end subroutine report_rest

  !> Notes the first problem.
  subroutine fail(cursor, position, what, remedy)
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    integer, intent(in) :: position !! character of the expression
    character(*), intent(in) :: what !! what is wrong
    character(*), intent(in) :: remedy !! what would be right

    if (allocated(cursor%problem)) return
    allocate (cursor%problem)
    cursor%problem%position = position
    cursor%problem%what = what
    cursor%problem%remedy = remedy
  end subroutine fail

  !> Turns a problem of the arithmetic into one of the expression.
  subroutine settle(cursor, position, what)
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    integer, intent(in) :: position !! character the operation stands at
    character(:), allocatable, intent(in) :: what !! allocated if the operation failed

    if (allocated(what)) call fail(cursor, position, what, &
                                   'the value must be a finite number: check the operands')
  end subroutine settle

  !> Current character, NUL at the end.
  pure character(1) function peek(text, cursor)
    character(*), intent(in) :: text !! the expression
    type(cursor_t), intent(in) :: cursor !! where the evaluation stands

    peek = achar(0)
    if (cursor%i <= len(text)) peek = text(cursor%i:cursor%i)
  end function peek

  !> product {+|- product}
  recursive subroutine parse_sum(text, parameters, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    real(wp), intent(out) :: value !! value of the sum
    real(wp) :: right
    character(:), allocatable :: what
    character(1) :: operator
    integer :: at

    call parse_product(text, parameters, cursor, value)
    do while (.not. allocated(cursor%problem))
      operator = peek(text, cursor)
      if (operator /= '+' .and. operator /= '-') exit
      at = cursor%i
      cursor%i = cursor%i + 1
      call parse_product(text, parameters, cursor, right)
      if (operator == '-') right = -right
      call safe_sum((value), right, value, what)
      call settle(cursor, at, what)
    end do
  end subroutine parse_sum

  !> factor {*|/ factor}
  recursive subroutine parse_product(text, parameters, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    real(wp), intent(out) :: value !! value of the product
    real(wp) :: right
    character(:), allocatable :: what
    character(1) :: operator
    integer :: at

    call parse_factor(text, parameters, cursor, value)
    do while (.not. allocated(cursor%problem))
      operator = peek(text, cursor)
      if (operator /= '*' .and. operator /= '/') exit
      at = cursor%i
      cursor%i = cursor%i + 1
      call parse_factor(text, parameters, cursor, right)
      if (allocated(cursor%problem)) exit
      if (operator == '*') call safe_product((value), right, value, what)
      if (operator == '/') call safe_quotient((value), right, value, what)
      call settle(cursor, at, what)
    end do
  end subroutine parse_product

  !> [+|-] factor | primary [^ factor]
  recursive subroutine parse_factor(text, parameters, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    real(wp), intent(out) :: value !! value of the factor
    real(wp) :: exponent
    character(:), allocatable :: what
    integer :: at

    value = 0.0_wp
    cursor%depth = cursor%depth + 1
    if (cursor%depth > deepest_nesting) then
      call fail(cursor, cursor%i, 'an expression nested more than '// &
        to_text(deepest_nesting)//' deep', &
                'split it with the help of parameters')
      return
    end if
    at = cursor%i
    select case (peek(text, cursor))
    case ('+', '-')
      cursor%i = at + 1
      call parse_factor(text, parameters, cursor, value)
      if (text(at:at) == '-') value = -value
    case default
      call parse_primary(text, parameters, cursor, value)
      at = cursor%i
      if (.not. allocated(cursor%problem) .and. peek(text, cursor) == '^') then
        cursor%i = at + 1
        call parse_factor(text, parameters, cursor, exponent)
        if (.not. allocated(cursor%problem)) then
          call safe_power((value), exponent, value, what)
          call settle(cursor, at, what)
        end if
      end if
    end select
    cursor%depth = cursor%depth - 1
  end subroutine parse_factor

  !> number | name | name(list) | (sum)
  recursive subroutine parse_primary(text, parameters, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    real(wp), intent(out) :: value !! its value
    character(1) :: c

    value = 0.0_wp
    c = peek(text, cursor)
    if (cursor%i > len(text)) then
      call fail(cursor, max(len(text), 1), 'the expression '''//text//''' ends too early', &
                'a number, a parameter or a parenthesis is missing at its end')
    else if (is_digit(c) .or. c == '.') then
      call parse_number(text, cursor, value)
    else if (c == '(') then
      call parse_parenthesis(text, parameters, cursor, value)
    else if (is_letter(c)) then
      call parse_name(text, parameters, cursor, value)
    else
      call fail(cursor, cursor%i, ''''//text//''' is neither a number nor an expression', &
                'a number, a parameter or a parenthesis is expected here')
    end if
  end subroutine parse_primary

  !> A decimal number.
  subroutine parse_number(text, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(cursor_t), intent(inout) :: cursor !! at its first digit
    real(wp), intent(out) :: value !! its value
    character(:), allocatable :: what
    integer :: first

    first = cursor%i
    call scan_number(text, cursor%i, value, what)
    if (allocated(what)) then
      call fail(cursor, first, what//': '''//text(first:cursor%i - 1)//'''', &
                'numbers look like 1, 1.5, 1e-3 or 1d-3, and end at 1e308')
    else if (is_name_character(peek(text, cursor)) .or. peek(text, cursor) == '.') then
      call fail(cursor, first, ''''//text//''' is neither a number nor an expression', &
                'numbers look like 1, 1.5, 1e-3 or 1d-3; a product needs its *')
    end if
  end subroutine parse_number

  !> (sum)
  recursive subroutine parse_parenthesis(text, parameters, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! at the opening parenthesis
    real(wp), intent(out) :: value !! value of what stands between
    integer :: opening

    opening = cursor%i
    cursor%i = cursor%i + 1
    call parse_sum(text, parameters, cursor, value)
    call close_parenthesis(text, cursor, opening)
  end subroutine parse_parenthesis

  !> Expects a closing parenthesis.
  subroutine close_parenthesis(text, cursor, opening)
    character(*), intent(in) :: text !! the expression
    type(cursor_t), intent(inout) :: cursor !! at the closing parenthesis
    integer, intent(in) :: opening !! place of the opening one

    if (allocated(cursor%problem)) return
    if (peek(text, cursor) == ')') then
      cursor%i = cursor%i + 1
    else if (cursor%i > len(text)) then
      call fail(cursor, opening, 'a parenthesis that is not closed: '''//text//'''', &
                'close it; an expression contains no blanks')
    else
      call report_rest(text, cursor)
    end if
  end subroutine close_parenthesis

  !> pi, a parameter, or a function with its arguments.
  recursive subroutine parse_name(text, parameters, cursor, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! at the first letter
    real(wp), intent(out) :: value !! its value
    integer :: first, last, number

    value = 0.0_wp
    first = cursor%i
    do while (is_name_character(peek(text, cursor)))
      cursor%i = cursor%i + 1
    end do
    last = cursor%i - 1
    if (peek(text, cursor) == '(') then
      call parse_call(text, parameters, cursor, first, value)
      return
    end if
    number = find_parameter(parameters, text(first:last))
    if (number > 0) then
      value = parameters(number)%value
    else if (lower(text(first:last)) == 'pi') then
      value = pi
    else
      call report_undefined(cursor, first, text(first:last), parameters)
    end if
  end subroutine parse_name

  !> Says that a name means nothing, and which name is near.
  subroutine report_undefined(cursor, position, name, parameters)
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    integer, intent(in) :: position !! first character of the name
    character(*), intent(in) :: name !! the name
    type(parameter_t), intent(in) :: parameters(:) !! the parameters there are
    type(word_list_t) :: list
    integer :: i

    if (is_function(name)) then
      call fail(cursor, position, 'the function '''//name//''' without arguments', &
                'write '//lower(name)//'(...)')
      return
    end if
    do i = 1, size(parameters)
      call add_candidate(list, parameters(i)%name)
    end do
    call fail(cursor, position, 'undefined parameter '''//name//'''', &
              did_you_mean(list, name, 'define it before in a PARAmeter data set'))
    cursor%problem%undefined = .true.
  end subroutine report_undefined

  !> name(sum, ...)
  recursive subroutine parse_call(text, parameters, cursor, first, value)
    character(*), intent(in) :: text !! the expression
    type(parameter_t), intent(in) :: parameters(:) !! parameters it may use
    type(cursor_t), intent(inout) :: cursor !! at the opening parenthesis
    integer, intent(in) :: first !! first letter of the function's name
    real(wp), intent(out) :: value !! its value
    character(:), allocatable :: name, what
    integer :: opening, arguments
    real(wp) :: argument, smallest, greatest

    value = 0.0_wp
    opening = cursor%i
    name = lower(text(first:opening - 1))
    if (.not. is_function(name)) then
      call report_no_function(cursor, first, text(first:opening - 1))
      return
    end if
    arguments = 0
    smallest = huge(1.0_wp)
    greatest = -huge(1.0_wp)
    do
      cursor%i = cursor%i + 1
      call parse_sum(text, parameters, cursor, argument)
      arguments = arguments + 1
      smallest = min(smallest, argument)
      greatest = max(greatest, argument)
      if (allocated(cursor%problem) .or. peek(text, cursor) /= ',') exit
    end do
    call close_parenthesis(text, cursor, opening)
    call check_arguments(cursor, first, name, arguments)
    if (allocated(cursor%problem)) return
    select case (name)
    case ('min'); value = smallest
    case ('max'); value = greatest
    case default
      call apply_function(name, argument, value, what)
      call settle(cursor, first, what)
    end select
  end subroutine parse_call

  !> Checks the number of arguments.
  subroutine check_arguments(cursor, position, name, arguments)
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    integer, intent(in) :: position !! first letter of the name
    character(*), intent(in) :: name !! name of the function
    integer, intent(in) :: arguments !! number of arguments found

    if (name == 'min' .or. name == 'max') then
      if (arguments < 2) call fail(cursor, position, ''''//name//''' with one argument', &
                                   'write '//name//'(a,b,...)')
    else if (arguments > 1) then
      call fail(cursor, position, ''''//name//''' with '//to_text(arguments)//' arguments', &
                'it takes one: '//name//'(a)')
    end if
  end subroutine check_arguments

  !> Says that there is no such function, and which is near.
  subroutine report_no_function(cursor, position, name)
    type(cursor_t), intent(inout) :: cursor !! where the evaluation stands
    integer, intent(in) :: position !! first letter of the name
    character(*), intent(in) :: name !! the name
    type(word_list_t) :: list
    integer :: i

    do i = 1, size(function_names)
      call add_candidate(list, trim(function_names(i)))
    end do
    call fail(cursor, position, 'there is no function '''//name//'''', &
              did_you_mean(list, name, 'a product needs its *'))
  end subroutine report_no_function
end module expressions

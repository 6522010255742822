!> Names of parameters where a record names them instead of using their value: in STUDy and
!! SENSitivity.
module parameter_names
  use deck_types, only: record_t, parameter_t, item_word, item_quoted
  use records, only: item_count, is_word
  use numbers, only: is_letter
  use parameter_tree, only: find_parameter
  use keyword_types, only: keyword_t, fits_data
  use diagnostics, only: diagnostics_t, report_error
  implicit none
  private
  public :: take_bare_names, report_hidden

contains

  !> Takes the parentheses off the names of parameters: so a record may begin with one whose first
  !! four letters are a command's. Without parentheses they are names whatever they are like.
  subroutine take_bare_names(command, record)
    type(keyword_t), intent(in) :: command !! the open set
    type(record_t), intent(inout) :: record !! the record
    integer :: k, n

    if (.not. names_parameters(command)) return
    n = 1
    if (command%key == 'sens') n = item_count(record)
    if (any([is_word(record%items(1), 'young'), is_word(record%items(1), 'load'), &
             is_word(record%items(1), 'way')])) n = 0
    do k = 1, n
      associate (item => record%items(k))
        if (item%kind /= item_word) cycle
        if (.not. is_bare_name(item%text)) cycle
        item%text = item%text(2:len(item%text) - 1)
        item%kind = item_quoted
      end associate
    end do
  end subroutine take_bare_names

  !> Reports a record that begins with the name of a parameter, and as a command would end the set
  !! that it fits.
  subroutine report_hidden(open, command, record, parameters, diagnostics, hidden)
    type(keyword_t), intent(in) :: open !! the open set
    type(keyword_t), intent(in) :: command !! the command that its first item names
    type(record_t), intent(in) :: record !! the record
    type(parameter_t), intent(in) :: parameters(:) !! parameters there are
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    logical, intent(out) :: hidden !! whether it is one
    character(:), allocatable :: name

    hidden = names_parameters(open) .and. fits_data(open, item_count(record))
    if (item_count(record) == 1) hidden = hidden .and. command%has_data
    if (.not. hidden) return
    name = record%items(1)%text
    hidden = find_parameter(parameters, name) > 0
    if (hidden) call report_error(diagnostics, record%at, ''''//name//''' is a parameter, and '// &
      'the command '//trim(command%name)//', too', 'write ('//name//') for the parameter, '// &
      trim(command%name)//' in full or a blank line before it for the command')
  end subroutine report_hidden

  !> Whether the records of a set name parameters.
  pure logical function names_parameters(command)
    type(keyword_t), intent(in) :: command !! the set

    names_parameters = command%key == 'sens' .or. command%key == 'stud'
  end function names_parameters

  !> A name in parentheses and nothing else.
  pure logical function is_bare_name(text) result(bare)
    character(*), intent(in) :: text !! an item
    integer :: n

    n = len(text)
    bare = n > 2
    if (bare) bare = text(1:1) == '(' .and. text(n:n) == ')' .and. is_letter(text(2:2)) &
      .and. scan(text(2:n - 1), '+-*/^()') == 0
  end function is_bare_name
end module parameter_names

!> What items a record takes, written as text in the keyword table and kept as tokens.
!!
!! A signature is a list of alternatives parted by |; an alternative is a list of tokens parted by
!! blanks. A token is `kind:label` (kinds below), a keyword (`FROM`), or `-` for a field that must
!! stay empty; in brackets it may be missing, with `...` at its end it may be repeated, with `~`
!! before it is not available in this version.
module signatures
  use text, only: lower, to_text
  implicit none
  private
  public :: token_t, alternative_t, signature_t, compile_signature, syntax_text, token_name
  public :: kind_positive, kind_count, kind_integer, kind_axis, kind_real, kind_positive_real, &
    kind_not_negative, kind_name, kind_file_name, kind_any, kind_node_list, kind_choice, &
    kind_keyword, kind_nothing, kind_exact

  !> Kinds of tokens.
  character(1), parameter :: kind_positive = 'p' !! integer, at least 1
  character(1), parameter :: kind_count = 'n' !! integer, at least 0
  character(1), parameter :: kind_integer = 'i' !! integer
  character(1), parameter :: kind_axis = 'd' !! integer, 1 to 3
  character(1), parameter :: kind_real = 'r' !! number
  character(1), parameter :: kind_positive_real = 'q' !! number greater than 0
  character(1), parameter :: kind_not_negative = 'z' !! number not less than 0
  character(1), parameter :: kind_name = 'w' !! name of a set, region, surface, pair
  character(1), parameter :: kind_file_name = 'f' !! name of a file
  character(1), parameter :: kind_any = 'a' !! any text (a label)
  character(1), parameter :: kind_node_list = 'l' !! node number or TO
  character(1), parameter :: kind_choice = 'c' !! one of the words in the label, parted by commas
  character(1), parameter :: kind_keyword = 'k' !! the keyword itself
  character(1), parameter :: kind_nothing = '-' !! a field that stays empty
  character(1), parameter :: kind_exact = 'x' !! one certain integer

  !> One item that a record takes.
  type :: token_t
    character(1) :: kind = kind_nothing !! one of the kinds above
    character(64) :: label = '' !! what it is called, or the keyword
    character(4) :: key = '' !! first four letters of a keyword, lower case
    integer :: exact = 0 !! the integer of kind_exact
    logical :: optional = .false. !! may be missing, together with all behind it
    logical :: repeated = .false. !! may be repeated
    logical :: available = .true. !! false if this version cannot do it
  end type token_t

  !> One way to write a record.
  type :: alternative_t
    type(token_t), allocatable :: tokens(:) !! its items in order
  end type alternative_t

  !> All ways to write a record.
  type :: signature_t
    type(alternative_t), allocatable :: alternatives(:) !! the ways, in order of preference
  end type signature_t

contains

  !> Turns the text of a signature into tokens.
  function compile_signature(text) result(signature)
    character(*), intent(in) :: text !! the signature as written in the keyword table
    type(signature_t) :: signature
    integer :: i, n, first, last

    n = 1
    do i = 1, len(text)
      if (text(i:i) == '|') n = n + 1
    end do
    allocate (signature%alternatives(n))
    first = 1
    do i = 1, n
      last = index(text(first:), '|') + first - 2
      if (last < first - 1) last = len(text)
      call compile_alternative(text(first:last), signature%alternatives(i))
      first = last + 2
    end do
  end function compile_signature

  !> Turns one alternative into tokens.
  subroutine compile_alternative(text, alternative)
    character(*), intent(in) :: text !! tokens parted by blanks
    type(alternative_t), intent(out) :: alternative !! the tokens
    integer :: pass, i, n, last

    do pass = 1, 2
      n = 0
      i = 1
      do while (i <= len(text))
        if (text(i:i) == ' ') then
          i = i + 1
          cycle
        end if
        last = index(text(i:)//' ', ' ') + i - 2
        n = n + 1
        if (pass == 2) alternative%tokens(n) = compiled_token(text(i:last))
        i = last + 1
      end do
      if (pass == 1) allocate (alternative%tokens(n))
    end do
  end subroutine compile_alternative

  !> Turns the text of one token into what it means.
  pure function compiled_token(text) result(token)
    character(*), intent(in) :: text !! the token as written
    type(token_t) :: token
    integer :: first, last, colon

    first = 1
    last = len(text)
    if (text(first:first) == '[') then
      token%optional = .true.
      first = first + 1
      last = last - 1
    end if
    if (text(first:first) == '~') then
      token%available = .false.
      first = first + 1
    end if
    if (last - first > 3) token%repeated = text(last - 2:last) == '...'
    if (token%repeated) last = last - 3
    colon = index(text(first:last), ':')
    if (text(first:last) == '-') then
      token%kind = kind_nothing
    else if (colon == 0) then
      token%kind = kind_keyword
      token%label = text(first:last)
      token%key = lower(token%label(:4))
    else
      token%kind = text(first:first)
      token%label = text(first + colon:last)
      if (token%kind >= '0' .and. token%kind <= '9') then
        token%kind = kind_exact
        read (text(first:first + colon - 2), *) token%exact
      end if
    end if
  end function compiled_token

  !> A token as the user reads it.
  function token_name(token) result(t)
    type(token_t), intent(in) :: token !! the token
    character(:), allocatable :: t

    t = trim(token%label)
    if (token%kind == kind_choice) t = with_bars(t)
    if (token%kind == kind_nothing) t = 'an empty field'
    if (token%kind == kind_keyword) t = ''''//t//''''
  end function token_name

  !> The ways to write a record that are available, in the notation of the manual.
  function syntax_text(signature, head, fields) result(t)
    type(signature_t), intent(in) :: signature !! what the record takes
    character(*), intent(in) :: head !! what it begins with, may be empty
    logical, intent(in) :: fields !! fields are parted by commas, as solution commands are
    character(:), allocatable :: t, one
    integer :: i, j

    t = ''
    do i = 1, size(signature%alternatives)
      if (size(signature%alternatives) > 1) then
        if (.not. all(signature%alternatives(i)%tokens%available)) cycle
      end if
      one = head
      do j = 1, size(signature%alternatives(i)%tokens)
        if (fields) then
          one = one//','
        else if (len(one) > 0) then
          one = one//' '
        end if
        one = one//token_syntax(signature%alternatives(i)%tokens(j))
      end do
      if (len(t) > 0) t = t//' | '
      t = t//one
    end do
  end function syntax_text

  !> One token in the notation of the manual.
  function token_syntax(token) result(t)
    type(token_t), intent(in) :: token !! the token
    character(:), allocatable :: t

    t = trim(token%label)
    if (token%kind == kind_choice) t = with_bars(t)
    if (token%kind == kind_exact) t = to_text(token%exact)
    if (token%kind == kind_nothing) t = ''
    if (token%repeated) t = t//' ...'
    if (token%optional) t = '['//t//']'
  end function token_syntax

  !> A list with bars for commas.
  function with_bars(list) result(t)
    character(*), intent(in) :: list !! words parted by commas
    character(:), allocatable :: t
    integer :: i

    t = ''
    do i = 1, len(list)
      if (list(i:i) == ',') then
        t = t//'|'
      else
        t = t//list(i:i)
      end if
    end do
  end function with_bars
end module signatures

!> What stands behind a command in its own record and belongs to nothing: FEAP passes over it.
module command_tails
  use deck_types, only: record_t, item_t, item_word, item_quoted, item_empty
  use records, only: item_count, is_word
  use numbers, only: is_letter
  use signatures, only: signature_t, kind_keyword, kind_name
  use keyword_types, only: keyword_t, find_word
  use diagnostics, only: diagnostics_t, report_error, report_note
  implicit none
  private
  public :: drop_tail, drop_empty_fields

contains

  !> Takes what has no meaning off a command that takes no items (or only certain words), with a
  !! note; a word that changes FEAP's answer is an error. Three numbers or more, without a word,
  !! look like data: they stay, to be refused.
  subroutine drop_tail(record, command, diagnostics, good)
    type(record_t), intent(inout) :: record !! the record; its tail is gone then
    type(keyword_t), intent(in) :: command !! its command
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(out) :: good !! nothing in it changes the answer
    character(:), allocatable :: remedy
    integer :: first, k, n

    good = .true.
    n = item_count(record)
    first = first_unknown(record, command%head)
    if (first == 0) return
    if (n > first + 1) then
      if (.not. any([(is_remark(record%items(k)), k=first, n)])) return
    end if
    if (is_data(record, first, command)) then
      call report_error(diagnostics, record%items(first)%at, 'data behind '// &
        trim(command%name)//': '''//tail_of(record, first)//'''', &
        'its records stand on the lines below it, one a line')
      good = .false.
      return
    end if
    do k = first, n
      remedy = remedy_of(command%key, record%items(k))
      if (len(remedy) == 0) cycle
      call report_error(diagnostics, record%items(k)%at, ''''//record%items(k)%text// &
                        ''' behind '//trim(command%name)//' is not available in this program', &
                        remedy)
      good = .false.
      return
    end do
    call report_note(diagnostics, record%items(first)%at, ''''//tail_of(record, first)// &
                     ''' behind '//trim(command%name)//' is ignored')
    record%items = record%items(:first - 1)
  end subroutine drop_tail

  !> A tail that is meant as a record: a name with a number behind it, signed or with a point, or a
  !! word that begins records of the command with a name behind it. FEAP's remarks (`BOUNdary
  !! restraints 0`, `ELEMents NODEs 10`) are neither.
  logical function is_data(record, first, command) result(yes)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! first item of its tail
    type(keyword_t), intent(in) :: command !! its command
    integer :: n

    n = item_count(record)
    yes = .false.
    if (n == first) return
    yes = find_word(command, record%items(first)) > 0 .and. is_remark(record%items(n))
    if (yes .or. .not. command%has_data) return
    yes = is_remark(record%items(first)) .and. record%items(n)%kind == item_word
    if (yes) yes = scan(record%items(n)%text(1:1), '+-.0123456789') > 0 .and. &
      scan(record%items(n)%text, '+-.') > 0
  end function is_data

  !> Takes empty fields off the end of a solution command.
  subroutine drop_empty_fields(record)
    type(record_t), intent(inout) :: record !! the record
    integer :: n

    n = item_count(record)
    do while (n > 1)
      if (record%items(n)%kind /= item_empty) exit
      n = n - 1
    end do
    if (n < item_count(record)) record%items = record%items(:n)
  end subroutine drop_empty_fields

  !> The first item of a record that its command has no use for; 0 if there is none, or if the
  !! command takes more than words of its own. A number is none where only a name may stand, or not.
  pure integer function first_unknown(record, head) result(first)
    type(record_t), intent(in) :: record !! the record
    type(signature_t), intent(in) :: head !! what may follow the command
    integer :: i, k
    logical :: known

    if (may_have_name(head) .and. item_count(record) > 1) then
      first = 2
      if (record%items(2)%kind == item_word) then
        if (.not. is_letter(record%items(2)%text(1:1))) return
      end if
    end if
    do i = 1, size(head%alternatives)
      first = 0
      if (any(head%alternatives(i)%tokens%kind /= kind_keyword)) return
    end do
    do first = 2, item_count(record)
      known = .false.
      do i = 1, size(head%alternatives)
        associate (tokens => head%alternatives(i)%tokens)
          do k = 1, size(tokens)
            known = known .or. is_word(record%items(first), tokens(k)%key)
          end do
        end associate
      end do
      if (.not. known) return
    end do
    first = 0
  end function first_unknown

  !> Whether an item cannot be data: a word, or nothing.
  pure logical function is_remark(item)
    type(item_t), intent(in) :: item !! the item

    is_remark = item%kind == item_empty .or. item%kind == item_quoted
    if (item%kind /= item_word) return
    is_remark = is_letter(item%text(1:1)) .and. scan(item%text, '+*/^()0123456789') == 0
  end function is_remark

  !> The command takes a name, or nothing.
  pure logical function may_have_name(head) result(may)
    type(signature_t), intent(in) :: head !! what may follow the command

    may = size(head%alternatives) == 1
    if (may) may = size(head%alternatives(1)%tokens) == 1
    if (may) may = head%alternatives(1)%tokens(1)%kind == kind_name .and. &
      head%alternatives(1)%tokens(1)%optional
  end function may_have_name

  !> What to write instead of an option of FEAP's that would change the answer; empty for words
  !! that would not.
  pure function remedy_of(command, item) result(remedy)
    character(4), intent(in) :: command !! key of the command
    type(item_t), intent(in) :: item !! the word behind it
    character(:), allocatable :: remedy
    character(4), parameter :: loads(6) = ['forc', 'disp', 'efor', 'edis', 'cfor', 'cdis']
    character(4), parameter :: codes(3) = ['boun', 'ebou', 'cbou']

    remedy = ''
    if (any(command == loads) .and. is_word(item, 'add')) then
      remedy = 'records that end with the number of a load add (0: the sum of all)'
    else if (any(command == codes) .and. is_word(item, 'set')) then
      remedy = 'codes of several records add: leave out those that it replaces'
    else if (is_word(item, 'polar') .or. is_word(item, 'cylindrical') &
             .or. is_word(item, 'spherical')) then
      remedy = 'write Cartesian coordinates: r*cosd(a) and r*sind(a) are numbers'
    else if (command == 'cont' .and. is_word(item, 'off')) then
      remedy = 'leave the pairs out'
    end if
  end function remedy_of

  !> The tail as written, blanks between its items.
  pure function tail_of(record, first) result(t)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: first !! its first item
    character(:), allocatable :: t
    integer :: k

    t = ''
    do k = first, item_count(record)
      if (k > first) t = t//' '
      if (allocated(record%items(k)%text)) t = t//record%items(k)%text
    end do
  end function tail_of
end module command_tails

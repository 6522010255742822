!> Reads STUDy and --vary (doc/manual, "Studies").
module study_reader
  use kinds, only: wp
  use text, only: to_text, lower
  use deck_types, only: deck_t, data_set_t, record_t, location_t, item_number
  use records, only: item_count, item_name, item_real, item_location, is_word
  use hints, only: word_list_t, add_candidate, did_you_mean
  use diagnostics, only: diagnostics_t, report_error, error_count
  use study_types, only: study_t, varied_t, study_list, study_chain, make_variants
  implicit none
  private
  public :: read_study

  !> Values of one parameter, and variants of a study, at most.
  integer, parameter :: most_variants = 100000

contains

  !> Fills the study; without STUDy and --vary it stays inactive.
  subroutine read_study(deck, vary, diagnostics, study)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: vary !! name=values of all --vary, parted by blanks
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(study_t), intent(inout) :: study !! gets what it consists of
    type(location_t) :: command_line
    integer :: i, first, last

    allocate (study%varied(0))
    study%name = 'study'
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'stud') cycle
      if (study%active) then
        call report_error(diagnostics, deck%mesh(i)%head%at, 'a second STUDy', &
          'one deck has one study: join their records')
        return
      end if
      call read_set(deck, deck%mesh(i), diagnostics, study)
    end do
    first = 1
    do while (first <= len(vary))
      last = index(vary(first:)//' ', ' ') + first - 2
      study%active = .true.
      study%at = command_line
      call read_option(deck, vary(first:last), diagnostics, study)
      first = last + 2
    end do
    if (.not. study%active .or. error_count(diagnostics) > 0) return
    call check_study(diagnostics, study)
    if (error_count(diagnostics) == 0) call make_variants(study)
  end subroutine read_study

  !> One data set.
  subroutine read_set(deck, set, diagnostics, study)
    type(deck_t), intent(in) :: deck !! the deck
    type(data_set_t), intent(in) :: set !! STUDy
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(study_t), intent(inout) :: study !! gets its parts
    integer :: k

    study%active = .true.
    study%at = set%head%at
    study%name = item_name(set%head, 2)
    if (item_count(set%head) > 2) then
      if (is_word(set%head%items(3), 'list')) study%form = study_list
      if (is_word(set%head%items(3), 'chain')) study%form = study_chain
    end if
    do k = 1, set%count
      associate (record => set%records(k))
        if (is_word(record%items(1), 'from') .and. item_count(record) > 1) then
          study%from = item_real(record, 2)
          study%from_at = record%at
          study%forced = item_count(record) > 2
        else
          call read_record(deck, record, diagnostics, study)
        end if
      end associate
    end do
  end subroutine read_set

  !> A parameter with its values.
  subroutine read_record(deck, record, diagnostics, study)
    type(deck_t), intent(in) :: deck !! the deck
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(study_t), intent(inout) :: study !! gets one more
    type(varied_t) :: varied
    integer :: i

    varied%name = item_name(record, 1)
    varied%at = record%at
    allocate (varied%values(0))
    if (item_count(record) == 6) then
      if (is_word(record%items(3), 'to')) then
        call add_range(item_real(record, 2), item_real(record, 4), item_real(record, 6), &
          item_location(record, 6), diagnostics, varied)
        call add_varied(deck, varied, diagnostics, study)
        return
      end if
    end if
    do i = 2, item_count(record)
      if (record%items(i)%kind == item_number) then
        varied%values = [varied%values, item_real(record, i)]
      else
        call add_rule(item_name(record, i), item_location(record, i), diagnostics, varied)
      end if
    end do
    call add_varied(deck, varied, diagnostics, study)
  end subroutine read_record

  !> A number as the command line has it.
  subroutine read_number(text, value, good)
    character(*), intent(in) :: text !! as written
    real(wp), intent(out) :: value !! its value
    logical, intent(out) :: good !! it is one
    integer :: status

    value = 0.0_wp
    good = len(text) > 0 .and. verify(text, '0123456789.+-eEdD') == 0
    if (.not. good) return
    read (text, *, iostat=status) value
    good = status == 0
  end subroutine read_number

  !> A slip rule by its word.
  subroutine add_rule(word, at, diagnostics, varied)
    character(*), intent(in) :: word !! the word
    type(location_t), intent(in) :: at !! where it stands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(varied_t), intent(inout) :: varied !! gets a value
    character(4), parameter :: rules(0:2) = ['coll', 'tens', 'asso']
    character(4) :: key
    integer :: m

    key = lower(word)
    m = findloc(rules, key, 1) - 1
    varied%rule = .true.
    if (m >= 0) then
      varied%values = [varied%values, real(m, wp)]
    else
      call report_error(diagnostics, at, 'no slip rule '''//word//'''', &
        'write COLLinear, TENSor, ASSOciated, or 0, 1, 2')
    end if
  end subroutine add_rule

  !> --vary name=a:b:step or name=a,b,c.
  subroutine read_option(deck, text, diagnostics, study)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: text !! as written
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(study_t), intent(inout) :: study !! gets a parameter
    type(varied_t) :: varied
    type(location_t) :: command_line
    real(wp) :: ends(3), value
    integer :: equals, first, last, n
    logical :: good, ranged

    equals = index(text, '=')
    varied%name = text(:max(0, equals - 1))
    allocate (varied%values(0))
    ranged = index(text, ':') > 0
    first = equals + 1
    n = 0
    good = equals > 1 .and. equals < len(text)
    do while (good .and. first <= len(text))
      last = first + scan(text(first:)//':', ':,') - 2
      call read_number(text(first:last), value, good)
      if (.not. good .and. varied%name == 'slip') then
        good = .true.
        call add_rule(text(first:last), command_line, diagnostics, varied)
      else if (good .and. .not. ranged) then
        varied%values = [varied%values, value]
      end if
      n = n + 1
      if (ranged .and. n <= 3) ends(min(n, 3)) = value
      first = last + 2
    end do
    if (ranged) good = good .and. n == 3
    if (.not. good) then
      call report_error(diagnostics, command_line, '--vary '//text//' cannot be read', &
        'write --vary name=from:to:step or --vary name=a,b,c')
      return
    end if
    if (ranged) call add_range(ends(1), ends(2), ends(3), command_line, diagnostics, varied)
    call add_varied(deck, varied, diagnostics, study)
  end subroutine read_option

  !> Values from one to another; the last one is there to a thousandth of a step.
  subroutine add_range(from, to, step, at, diagnostics, varied)
    real(wp), intent(in) :: from !! first value
    real(wp), intent(in) :: to !! last one
    real(wp), intent(in) :: step !! difference
    type(location_t), intent(in) :: at !! where the step stands
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(varied_t), intent(inout) :: varied !! gets the values
    integer :: i, n

    n = -1
    if (abs(step) > 0.0_wp) then
      if ((to - from)/step < real(most_variants, wp)) n = floor((to - from)/step + 1.0e-3_wp)
    end if
    if (n < 0) then
      call report_error(diagnostics, at, 'from '//to_text(from)//' no step of '//to_text(step)// &
        ' leads to '//to_text(to), 'give a step in the right direction, for less than '// &
        to_text(most_variants)//' values')
      return
    end if
    varied%values = [(from + real(i, wp)*step, i=0, n)]
    if (abs(varied%values(n + 1) - to) < 1.0e-9_wp*abs(step)) varied%values(n + 1) = to
  end subroutine add_range

  !> Adds a parameter to the study, if the deck has it.
  subroutine add_varied(deck, varied, diagnostics, study)
    type(deck_t), intent(in) :: deck !! the deck
    type(varied_t), intent(inout) :: varied !! the parameter
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(study_t), intent(inout) :: study !! gets it
    type(varied_t), allocatable :: longer(:)
    type(word_list_t) :: list
    integer :: i, n
    logical :: known

    known = .false.
    do i = 1, size(deck%parameters)
      call add_candidate(list, deck%parameters(i)%name)
      if (len(deck%parameters(i)%name) /= len(varied%name)) cycle
      if (deck%parameters(i)%name == varied%name) known = .true.
    end do
    if (.not. known .and. lower(varied%name) == 'slip') varied%rule = .true.
    call add_candidate(list, 'slip')
    if (known .and. varied%rule) then
      call report_error(diagnostics, varied%at, ''''//varied%name//''' is a number of the deck', &
        'give it numbers')
      return
    else if (.not. known .and. lower(varied%name) /= 'slip') then
      call report_error(diagnostics, varied%at, 'there is no parameter '''//varied%name//'''', &
        did_you_mean(list, varied%name, 'name a PARAmeter of the deck, or slip'))
      return
    end if
    n = size(study%varied)
    do i = 1, n
      if (study%varied(i)%name /= varied%name) cycle
      call report_error(diagnostics, varied%at, ''''//varied%name//''' is varied twice', &
        'give all its values in one place')
      return
    end do
    allocate (longer(n + 1))
    longer(:n) = study%varied
    longer(n + 1) = varied
    call move_alloc(longer, study%varied)
  end subroutine add_varied

  !> Parameters, and values that go together.
  subroutine check_study(diagnostics, study)
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(study_t), intent(in) :: study !! read
    integer :: p
    real(wp) :: n

    if (size(study%varied) == 0) then
      call report_error(diagnostics, study%at, 'the study varies nothing', &
        'give it records of a parameter and its values')
      return
    end if
    n = 1.0_wp
    do p = 1, size(study%varied)
      n = n*real(size(study%varied(p)%values), wp)
      if (.not. any(study%form == [study_list, study_chain])) cycle
      if (size(study%varied(p)%values) == size(study%varied(1)%values)) cycle
      call report_error(diagnostics, study%varied(p)%at, ''''//study%varied(p)%name//''' has '// &
        to_text(size(study%varied(p)%values))//' values, and '''//study%varied(1)%name// &
        ''' has '//to_text(size(study%varied(1)%values)), 'in a LIST or a CHAIN all have as many')
    end do
    if (any(study%form == [study_list, study_chain]) .or. n <= real(most_variants, wp)) return
    call report_error(diagnostics, study%at, 'the study has more than '//to_text(most_variants)// &
      ' variants', 'give fewer values')
  end subroutine check_study
end module study_reader

!> Reads SENSitivity and --sens: which parameters, and what a unit of each of them changes
!! (doc/theory, "Parameters of the input").
module sensitivity_reader
  use kinds, only: wp
  use text, only: to_text, lower, count_noun
  use deck_types, only: deck_t, record_t, override_t, location_t
  use records, only: item_count, item_name, item_integer, item_location, is_word
  use hints, only: word_list_t, add_candidate, did_you_mean
  use diagnostics, only: diagnostics_t, report_error, error_count
  use friction_return, only: has_friction
  use model_types, only: model_t
  use facets, only: exterior_facets
  use mesh_names, only: find_nodes
  use loads, only: join_load, add_values
  use parameter_slopes, only: reading_t, read_parameter
  use sensitivity_types, only: sensitivity_t, slope_t, new_slope, add_slope
  implicit none
  private
  public :: read_sensitivities

  !> Words that name a parameter of contact.
  character(7), parameter :: words(6) = [character(7) :: 'mu1', 'mu2', 'mu', 'phi', 'slip', &
    'penalty']
  !> Shares that differ by less are the same.
  real(wp), parameter :: same_share = 1.0e-14_wp

contains

  !> Fills s%slopes; without SENSitivity and --sens it stays inactive. In a deck with errors only
  !! the names are looked up.
  subroutine read_sensitivities(deck, path, overrides, names, diagnostics, model, s)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: path !! its main file
    type(override_t), intent(in) :: overrides(:) !! parameters that the command line sets
    character(*), intent(in) :: names !! what --sens asks for, parted by commas
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets active, slopes, shown
    type(reading_t) :: reading
    type(location_t) :: command_line
    integer :: i, k, first, last

    allocate (s%slopes(0))
    reading%path = path
    reading%overrides = overrides
    reading%names_only = error_count(diagnostics) > 0
    if ((any(deck%mesh%command == 'sens') .or. len(names) > 0) .and. .not. reading%names_only) &
      call exterior_facets(model%mesh, reading%exterior)
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'sens') cycle
      s%active = .true.
      do k = 1, deck%mesh(i)%count
        call read_record(deck, deck%mesh(i)%records(k), reading, diagnostics, model, s)
      end do
    end do
    first = 1
    do while (first <= len(names))
      last = index(names(first:)//',', ',') + first - 2
      s%active = .true.
      call read_name(deck, names(first:last), '', command_line, reading, diagnostics, model, s)
      first = last + 2
    end do
    if (.not. s%active .or. error_count(diagnostics) > 0) return
    s%shown = size(s%slopes)
    call add_check(model, s)
  end subroutine read_sensitivities

  !> The two columns that Euler's sum is made of: all penalties; all moduli and forces.
  subroutine add_check(model, s)
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets euler, and slopes that are not there yet
    type(slope_t) :: penalties, moduli

    penalties = new_slope('penalties', model)
    penalties%penalty = 1.0_wp
    moduli = new_slope('moduli', model)
    moduli%modulus = 1.0_wp
    moduli%forces = 1.0_wp
    call add_column(1, penalties)
    call add_column(2, moduli)

  contains

    !> Finds a slope among those that are shown, or adds it.
    subroutine add_column(i, slope)
      integer, intent(in) :: i !! which of the two
      type(slope_t), intent(in) :: slope !! what it changes
      integer :: j

      do j = 1, s%shown
        s%euler%slope(i) = j
        s%euler%factor(i) = times_slope(model, slope, s%slopes(j))
        if (s%euler%factor(i) > 0.0_wp) return
      end do
      call add_slope(slope, s)
      s%euler%slope(i) = size(s%slopes)
      s%euler%factor(i) = 1.0_wp
    end subroutine add_column
  end subroutine add_check

  !> How many times a slope of penalties, moduli and forces is what is wanted; 0 if it is not.
  pure real(wp) function times_slope(model, wanted, slope) result(factor)
    type(model_t), intent(in) :: model !! materials, loads
    type(slope_t), intent(in) :: wanted !! what is wanted
    type(slope_t), intent(in) :: slope !! what there is
    real(wp) :: share
    logical :: elastic(size(model%materials))

    factor = 0.0_wp
    if (size(slope%loads) + size(slope%variants) > 0 .or. any(abs(slope%mu) > 0.0_wp) .or. &
      any(abs(slope%rule) > 0.0_wp) .or. any(abs(slope%angle) > 0.0_wp)) return
    elastic = .not. model%materials%rigid
    share = sum(slope%penalty) + sum(slope%modulus, elastic)
    if (share <= 0.0_wp) return
    share = (sum(wanted%penalty) + sum(wanted%modulus, elastic))/share
    if (any(abs(share*slope%penalty - wanted%penalty) > same_share)) return
    if (any(abs(share*slope%modulus - wanted%modulus) > same_share .and. elastic)) return
    if (any(model%conditions%loads%force%n > 0) .and. &
      abs(share*slope%forces - wanted%forces) > same_share) return
    factor = share
  end function times_slope

  !> One record: words with or without a pair, a material, a load, a way, parameters of the deck.
  subroutine read_record(deck, record, reading, diagnostics, model, s)
    type(deck_t), intent(in) :: deck !! the deck
    type(record_t), intent(in) :: record !! the record
    type(reading_t), intent(in) :: reading !! how the deck was read
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets slopes
    character(:), allocatable :: pair
    integer :: i, n

    n = item_count(record)
    if (names_nothing(record) .and. reading%names_only) return
    if (is_word(record%items(1), 'young') .and. n == 3) then
      call read_modulus(record, diagnostics, model, s)
    else if (is_word(record%items(1), 'load') .and. n == 2) then
      call read_load(record, diagnostics, model, s)
    else if (is_word(record%items(1), 'way') .and. n == 3) then
      call read_way(record, diagnostics, model, s)
    else
      pair = ''
      if (n > 2) then
        if (is_word(record%items(n - 1), 'pair')) then
          pair = item_name(record, n)
          n = n - 2
        end if
      end if
      do i = 1, n
        call read_name(deck, item_name(record, i), pair, item_location(record, i), reading, &
          diagnostics, model, s)
      end do
    end if
  end subroutine read_record

  !> A record of the own words that begins with no name of a parameter.
  logical function names_nothing(record) result(nothing)
    type(record_t), intent(in) :: record !! the record
    integer :: n

    n = item_count(record)
    nothing = n == 3 .and. (is_word(record%items(1), 'young') .or. is_word(record%items(1), 'way'))
    nothing = nothing .or. n == 2 .and. is_word(record%items(1), 'load')
  end function names_nothing

  !> A word of contact, or a parameter of the deck. In the deck words go first, on the command line
  !! parameters do.
  subroutine read_name(deck, name, pair, at, reading, diagnostics, model, s)
    type(deck_t), intent(in) :: deck !! the deck
    character(*), intent(in) :: name !! the name
    character(*), intent(in) :: pair !! name of a pair, empty for all
    type(location_t), intent(in) :: at !! where it stands
    type(reading_t), intent(in) :: reading !! how the deck was read
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets slopes
    type(word_list_t) :: list
    integer :: i, parameter
    logical :: is_contact

    parameter = 0
    do i = 1, size(deck%parameters)
      if (len(deck%parameters(i)%name) /= len(name)) cycle
      if (deck%parameters(i)%name == name) parameter = i
    end do
    is_contact = any(words == lower(name))
    if (at%file == 0 .and. parameter > 0) is_contact = .false.
    if (reading%names_only .and. (is_contact .or. parameter > 0)) return
    if (is_contact) then
      call read_word(lower(name), pair, at, diagnostics, model, s)
    else if (parameter > 0) then
      call read_parameter(deck, name, deck%parameters(parameter)%value, at, reading, diagnostics, &
        model, s)
    else
      do i = 1, size(words)
        call add_candidate(list, trim(words(i)))
      end do
      do i = 1, size(deck%parameters)
        call add_candidate(list, deck%parameters(i)%name)
      end do
      call report_error(diagnostics, at, 'there is no parameter '''//name//'''', did_you_mean( &
        list, name, 'name a PARAmeter of the deck, or mu1, mu2, mu, phi, slip, penalty'))
    end if
  end subroutine read_name

  !> mu1, mu2, mu, phi, slip, penalty of one pair or of all together.
  subroutine read_word(word, pair, at, diagnostics, model, s)
    character(*), intent(in) :: word !! the word
    character(*), intent(in) :: pair !! name of a pair, empty for all
    type(location_t), intent(in) :: at !! where it stands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets a slope
    type(slope_t) :: slope
    type(word_list_t) :: list
    integer :: k, found

    slope = new_slope(word, model)
    slope%at = at
    if (len(pair) > 0) slope%name = word//':'//pair
    found = 0
    do k = 1, size(model%pairs)
      call add_candidate(list, model%pairs(k)%name)
      if (len(pair) > 0 .and. model%pairs(k)%name /= pair) cycle
      found = found + 1
      if (word /= 'penalty' .and. .not. any(has_friction(model%pairs(k)%friction%mu))) then
        call report_error(diagnostics, at, 'pair '//model%pairs(k)%name//' has no friction: '// &
          word//' changes nothing there', 'give it FRICtion, or name another PAIR behind '//word)
        return
      end if
      select case (word)
      case ('mu1')
        slope%mu(1, k) = 1.0_wp
      case ('mu2')
        slope%mu(2, k) = 1.0_wp
      case ('mu')
        slope%mu(:, k) = 1.0_wp
      case ('phi')
        slope%angle(k) = 1.0_wp
      case ('slip')
        slope%rule(k) = 1.0_wp
      case default
        slope%penalty(k) = 1.0_wp/model%pairs(k)%penalty
      end select
    end do
    if (found == 0) then
      call report_error(diagnostics, at, 'there is no pair '''//pair//'''', did_you_mean(list, &
        pair, 'name a PAIR of CONTact'))
      return
    end if
    call add_slope(slope, s)
  end subroutine read_word

  !> young MATErial n.
  subroutine read_modulus(record, diagnostics, model, s)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets a slope
    type(slope_t) :: slope
    integer :: m

    m = findloc(model%materials%number, item_integer(record, 3), 1)
    if (m == 0) then
      call report_error(diagnostics, item_location(record, 3), 'there is no material '// &
        to_text(item_integer(record, 3)), 'name one that the deck defines')
      return
    end if
    if (model%materials(m)%rigid) then
      call report_error(diagnostics, item_location(record, 3), 'material '// &
        to_text(item_integer(record, 3))//' is rigid and has no modulus', &
        'name an elastic material')
      return
    end if
    slope = new_slope('young:'//to_text(item_integer(record, 3)), model)
    slope%at = record%at
    slope%modulus(m) = 1.0_wp/model%materials(m)%youngs_modulus
    call add_slope(slope, s)
  end subroutine read_modulus

  !> load n: the amplitude of a proportional load.
  subroutine read_load(record, diagnostics, model, s)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets a slope
    type(slope_t) :: slope
    integer :: i, n

    n = item_integer(record, 2)
    if (all(model%tables%number /= n)) then
      call report_error(diagnostics, item_location(record, 2), 'there is no proportional load '// &
        to_text(n), 'name a PROPortional of the deck')
      return
    end if
    slope = new_slope('load:'//to_text(n), model)
    slope%at = record%at
    deallocate (slope%variants)
    allocate (slope%variants(1))
    slope%variants(1)%tables = model%tables
    slope%variants(1)%weight = 1.0_wp
    do i = 1, size(model%tables)
      if (model%tables(i)%number == n) cycle
      associate (table => slope%variants(1)%tables(i))
        if (table%function_form) then
          table%p(1:3) = 0.0_wp
        else
          table%p = 0.0_wp
        end if
      end associate
    end do
    call add_slope(slope, s)
  end subroutine read_load

  !> way set i: the prescribed value of a set in one direction.
  subroutine read_way(record, diagnostics, model, s)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! the problem
    type(sensitivity_t), intent(inout) :: s !! gets a slope
    type(slope_t) :: slope
    type(word_list_t) :: list
    integer, allocatable :: nodes(:)
    real(wp) :: unit(3)
    integer :: i, k, dof
    logical :: found

    dof = item_integer(record, 3)
    call find_nodes(model%mesh, item_name(record, 2), nodes, found)
    if (.not. found) then
      do i = 1, size(model%mesh%sets)
        call add_candidate(list, model%mesh%sets(i)%name)
      end do
      call report_error(diagnostics, item_location(record, 2), 'there is no set '''// &
        item_name(record, 2)//'''', did_you_mean(list, item_name(record, 2), 'name a SET'))
      return
    end if
    slope = new_slope('way:'//item_name(record, 2)//':'//to_text(dof), model)
    slope%at = record%at
    unit = 0.0_wp
    unit(dof) = 1.0_wp
    do k = 1, size(model%conditions%loads)
      associate (way => model%conditions%loads(k)%displacement)
        found = .false.
        do i = 1, way%n
          if (way%dof(i) == dof .and. any(nodes == way%node(i))) found = .true.
        end do
        if (found) call join_load(slope%loads, model%conditions%loads(k)%table, i)
      end associate
    end do
    if (size(slope%loads) /= 1) then
      call report_error(diagnostics, item_location(record, 2), 'the displacement of '''// &
        item_name(record, 2)//''' in direction '//to_text(dof)//' is that of '// &
        count_noun(size(slope%loads), 'load')//', not of one', 'name a PARAmeter that its '// &
        'DISPlacement has')
      return
    end if
    do i = 1, size(nodes)
      if (model%conditions%restrained(dof, nodes(i))) &
        call add_values(slope%loads(1)%displacement, nodes(i), unit)
    end do
    call add_slope(slope, s)
  end subroutine read_way
end module sensitivity_reader

!> A deck read again with other values of its parameters, and what then differs (doc/theory,
!! "Parameters of the input").
module deck_variants
  use kinds, only: wp
  use errors, only: error_t
  use deck_types, only: deck_t, data_set_t, record_t, override_t, location_t
  use deck_reader, only: read_deck
  use diagnostics, only: diagnostics_t, error_count, diagnostics_to_error
  use facets, only: facet_table_t
  use model_types, only: model_t
  use model_reader, only: read_model, read_rest
  use records, only: is_word, item_count
  implicit none
  private
  public :: variant_t, difference_t, read_variant, read_next_variant, set_value, place_load, &
    place_other, place_mesh

  !> What of a deck a value goes into.
  integer, parameter :: place_contact = 1 !! friction, angle of the lay, penalty
  integer, parameter :: place_modulus = 2 !! Young's modulus
  integer, parameter :: place_load = 3 !! prescribed values, forces, proportional loads
  integer, parameter :: place_other = 4 !! anything else
  integer, parameter :: place_mesh = 5 !! the mesh, by another way than items

  !> Where two readings differ.
  type :: difference_t
    integer :: worst = 0 !! the place that counts most, 0 if they are the same
    type(location_t) :: at !! where it is
    character(4) :: command = '' !! its data set
  end type difference_t

  !> One reading of the deck.
  type :: variant_t
    type(deck_t) :: deck !! the deck
    type(model_t) :: model !! the problem
  end type variant_t

contains

  !> Reads the deck with the parameters that are given.
  subroutine read_variant(path, overrides, variant, error)
    character(*), intent(in) :: path !! the deck
    type(override_t), intent(in) :: overrides(:) !! parameters that are set
    type(variant_t), intent(out) :: variant !! what was read
    type(error_t), allocatable, intent(out) :: error !! what is wrong with these values
    type(diagnostics_t) :: diagnostics

    call read_deck(path, overrides, variant%deck, diagnostics, error)
    if (allocated(error)) return
    call read_model(variant%deck, diagnostics, variant%model)
    if (error_count(diagnostics) > 0) call diagnostics_to_error(diagnostics, error)
  end subroutine read_variant

  !> Reads the deck with values next to those of another reading. Where only contact, moduli and
  !! loads differ the mesh of that one is taken.
  subroutine read_next_variant(path, overrides, deck, model, exterior, variant, difference, error)
    character(*), intent(in) :: path !! the deck
    type(override_t), intent(in) :: overrides(:) !! parameters that are set
    type(deck_t), intent(in) :: deck !! the other reading
    type(model_t), intent(in) :: model !! and its problem
    type(facet_table_t), intent(in) :: exterior !! exterior facets of its mesh
    type(variant_t), intent(out) :: variant !! what was read
    type(difference_t), intent(out) :: difference !! where they differ
    type(error_t), allocatable, intent(out) :: error !! what is wrong with these values
    type(diagnostics_t) :: diagnostics

    call read_deck(path, overrides, variant%deck, diagnostics, error)
    if (allocated(variant%deck%mesh) .and. allocated(variant%deck%batch)) &
      call find_difference(deck, variant%deck, difference)
    if (allocated(error)) return
    if (difference%worst <= place_load .and. .not. any(model%pairs%fit%adjusted)) then
      variant%model%title = model%title
      variant%model%mesh = model%mesh
      call read_rest(variant%deck, diagnostics, variant%model, exterior)
    else
      call read_model(variant%deck, diagnostics, variant%model)
    end if
    if (error_count(diagnostics) > 0) call diagnostics_to_error(diagnostics, error)
  end subroutine read_next_variant

  !> Adds a parameter to those that are set.
  subroutine set_value(overrides, name, value)
    type(override_t), allocatable, intent(inout) :: overrides(:) !! gets one more
    character(*), intent(in) :: name !! name of the parameter
    real(wp), intent(in) :: value !! its value
    type(override_t), allocatable :: longer(:)
    character(26) :: text
    integer :: n

    n = size(overrides)
    allocate (longer(n + 1))
    longer(:n) = overrides
    write (text, '(es25.16e3)') value
    longer(n + 1)%name = name
    longer(n + 1)%value = trim(adjustl(text))
    call move_alloc(longer, overrides)
  end subroutine set_value

  !> Where two readings of a deck differ, from a place on: in which kind of data, and where.
  subroutine find_difference(a, b, difference)
    type(deck_t), intent(in) :: a !! one reading
    type(deck_t), intent(in) :: b !! another one
    type(difference_t), intent(out) :: difference !! that counts most

    call compare_sets(a%mesh, b%mesh, .true., difference)
    call compare_sets(a%batch, b%batch, .false., difference)
  end subroutine find_difference

  !> The differences of data sets.
  subroutine compare_sets(a, b, in_mesh, difference)
    type(data_set_t), intent(in) :: a(:) !! of one reading
    type(data_set_t), intent(in) :: b(:) !! of the other one
    logical, intent(in) :: in_mesh !! of the mesh part, not of BATCh
    type(difference_t), intent(inout) :: difference !! that counts most so far
    integer :: i, k

    do i = 1, min(size(a), size(b))
      call compare_records(a(i)%head, b(i)%head, a(i)%command, in_mesh, difference)
      do k = 1, min(a(i)%count, b(i)%count)
        call compare_records(a(i)%records(k), b(i)%records(k), a(i)%command, in_mesh, difference)
      end do
    end do
  end subroutine compare_sets

  !> The differences of two records.
  subroutine compare_records(a, b, name, in_mesh, difference)
    type(record_t), intent(in) :: a !! of one reading
    type(record_t), intent(in) :: b !! of the other one
    character(4), intent(in) :: name !! command of the data set
    logical, intent(in) :: in_mesh !! of the mesh part
    type(difference_t), intent(inout) :: difference !! that counts most so far
    integer :: j, place

    do j = 1, min(item_count(a), item_count(b))
      if (abs(a%items(j)%value - b%items(j)%value) <= 0.0_wp) cycle
      place = place_other
      if (in_mesh) place = place_of(name, a, j)
      if (place <= difference%worst) cycle
      difference = difference_t(place, a%items(j)%at, name)
    end do
  end subroutine compare_records

  !> What the value of an item is.
  pure integer function place_of(name, record, j) result(place)
    character(4), intent(in) :: name !! command of the data set
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: j !! the item

    place = place_other
    select case (name)
    case ('cont', 'pair')
      if (is_word(record%items(1), 'penalty') .or. is_word(record%items(1), 'friction')) then
        place = place_contact
      end if
      if (is_word(record%items(1), 'direction')) then
        if (is_word(record%items(j - 1), 'angle')) place = place_contact
      end if
    case ('mate')
      if (is_word(record%items(1), 'elastic') .and. j == 3) place = place_modulus
      if (is_word(record%items(1), 'density')) place = place_load
    case ('disp', 'forc', 'prop', 'trac', 'pres', 'grav')
      place = place_load
    case ('edis', 'efor')
      if (j > 2) place = place_load
    case ('cdis', 'cfor')
      if (j > 3) place = place_load
    case default
      ! The mesh, and all that goes with it.
    end select
  end function place_of
end module deck_variants

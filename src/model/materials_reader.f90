!> Reads the MATErial data sets, and finds the material of each element.
module materials_reader
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t, data_set_t, record_t, location_t, item_number
  use deck_losses, only: is_lost
  use records, only: item_location, item_count, item_integer, item_real, item_name, is_word
  use diagnostics, only: diagnostics_t, report_error, report_note
  use cells, only: has_middles
  use bulk_laws, only: laws, linear, neohooke
  use model_types, only: model_t, material_t
  implicit none
  private
  public :: read_materials, assign_materials

  !> Largest Young's modulus, and one over the smallest: energies are squared in the line search.
  real(wp), parameter :: largest_modulus = 1.0e100_wp
  !> From this Poisson's ratio on elements lock without MEAN.
  real(wp), parameter :: locking_ratio = 0.45_wp

contains

  !> Fills model%materials.
  subroutine read_materials(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! receives the materials
    integer :: i, n

    n = count(deck%mesh%command == 'mate')
    allocate (model%materials(n))
    n = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'mate') cycle
      n = n + 1
      if (finite_everywhere(deck)) model%materials(n)%law = neohooke
      call read_material(deck%mesh(i), model%materials(:n - 1), diagnostics, model%materials(n))
    end do
  end subroutine read_materials

  !> GLOBal says FINIte; the last word counts.
  pure logical function finite_everywhere(deck) result(finite)
    type(deck_t), intent(in) :: deck !! the deck
    integer :: i, k

    finite = .false.
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'glob') cycle
      do k = 1, deck%mesh(i)%count
        finite = is_word(deck%mesh(i)%records(k)%items(1), 'finite')
      end do
    end do
  end function finite_everywhere

  !> Reads one data set.
  subroutine read_material(set, others, diagnostics, material)
    type(data_set_t), intent(in) :: set !! the data set
    type(material_t), intent(in) :: others(:) !! the materials before it
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(material_t), intent(inout) :: material !! the material
    logical :: elastic
    integer :: i

    material%at = set%head%at
    material%number = item_integer(set%head, 2)
    material%label = item_name(set%head, 3)
    if (any(others%number == material%number)) then
      call report_error(diagnostics, item_location(set%head, 2), 'material '// &
        to_text(material%number)//' is defined twice', 'give the second one another number')
    end if
    elastic = .false.
    do i = 1, set%count
      call read_property(set%records(i), diagnostics, material, elastic)
    end do
    if (elastic .or. material%rigid .or. .not. set%complete) return
    call report_error(diagnostics, set%head%at, 'material '//to_text(material%number)// &
      ' has no elastic constants', 'write ELAStic ISOTropic E nu, or RIGId')
  end subroutine read_material

  !> Reads one property.
  subroutine read_property(record, diagnostics, material, elastic)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(material_t), intent(inout) :: material !! the material
    logical, intent(inout) :: elastic !! its elastic constants are known

    if (is_word(record%items(1), 'solid')) then
      call read_law(record, diagnostics, material)
    else if (is_word(record%items(1), 'finite')) then
      if (material%law == linear) material%law = neohooke
    else if (is_word(record%items(1), 'small')) then
      material%law = linear
    else if (is_word(record%items(1), 'rigid')) then
      material%rigid = .true.
    else if (is_word(record%items(1), 'density')) then
      material%density = item_real(record, 2)
      material%has_density = .true.
    else if (is_word(record%items(1), 'elastic')) then
      if (elastic) then
        call report_error(diagnostics, record%at, 'elastic constants are given twice', &
          'keep one of the two records')
      end if
      elastic = .true.
      call read_elastic(record, diagnostics, material)
    end if
  end subroutine read_property

  !> SOLId law MEAN.
  subroutine read_law(record, diagnostics, material)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(material_t), intent(inout) :: material !! gets law, mean
    integer :: k, law, i

    do k = 2, item_count(record)
      do law = 1, size(laws)
        if (.not. is_word(record%items(k), trim(laws(law)%keyword))) cycle
        material%law = law
        material%own(:laws(law)%count) = [(item_real(record, k + i), i=1, laws(law)%count)]
      end do
      material%mean = material%mean .or. is_word(record%items(k), 'mean')
      material%nodal = material%nodal .or. is_word(record%items(k), 'nodal')
      material%mean_asked = material%mean_asked .or. is_word(record%items(k), 'mean') .or. &
        is_word(record%items(k), 'full')
    end do
    if (material%mean .and. .not. laws(material%law)%may_mean) call report_error(diagnostics, &
      record%at, 'the law '//trim(laws(material%law)%keyword)//' has no MEAN', 'its energy has '// &
      'no volumetric part of its own: use NEOHookean')
    if (material%nodal .and. .not. laws(material%law)%may_mean) call report_error(diagnostics, &
      record%at, 'the law '//trim(laws(material%law)%keyword)//' has no NODAl', 'its energy '// &
      'has no volumetric part of its own: use NEOHookean')
    if (material%nodal .and. material%mean) call report_error(diagnostics, record%at, &
      'MEAN and NODAl together', 'MEAN is for elements of ten nodes, NODAl for those of four')
  end subroutine read_law

  !> ELAStic ISOTropic E nu, or NEOHookean E nu with FINIte, as FEAP writes it.
  subroutine read_elastic(record, diagnostics, material)
    type(record_t), intent(in) :: record !! the record
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(material_t), intent(inout) :: material !! the material

    if (is_word(record%items(2), 'neohookean')) material%law = neohooke
    material%youngs_modulus = item_real(record, 3)
    material%poissons_ratio = item_real(record, 4)
    if (material%youngs_modulus < 1.0_wp/largest_modulus .or. &
      material%youngs_modulus > largest_modulus) then
      call report_error(diagnostics, item_location(record, 3), 'Young''s modulus is '// &
        to_text(material%youngs_modulus, 10)//': energies made of it leave the range of numbers', &
        'use units in which it lies between 1e-100 and 1e100')
    end if
    if (material%poissons_ratio <= -1.0_wp .or. material%poissons_ratio >= 0.5_wp) then
      call report_error(diagnostics, item_location(record, 4), 'Poisson''s ratio is '// &
        to_text(material%poissons_ratio, 10), 'write a ratio above -1 and below 0.5')
    end if
  end subroutine read_elastic

  !> Fills model%element_material; mesh and materials have been read.
  subroutine assign_materials(deck, diagnostics, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! mesh and materials
    logical, allocatable :: used(:)
    integer :: e, m, missing
    logical :: known

    known = .not. is_lost(deck, 'mate')
    allocate (model%element_material(model%mesh%elements), source=0)
    allocate (used(size(model%materials)), source=.false.)
    missing = 0
    m = 0
    do e = 1, model%mesh%elements
      if (model%mesh%ix(1, e) == 0) cycle
      m = material_index(model%materials, model%mesh%material(e), m)
      model%element_material(e) = m
      if (m > 0) then
        used(m) = .true.
      else if (missing == 0 .or. model%mesh%material(e) /= missing) then
        if (known .and. first_without(model, e)) then
          call report_missing_material(deck, model, e, diagnostics)
        end if
        missing = model%mesh%material(e)
      end if
    end do
    call choose_dilatation(model, diagnostics)
    call drop_unknown(deck, model)
    do m = 1, size(used)
      if (used(m)) cycle
      call report_note(diagnostics, model%materials(m)%at, 'material '// &
        to_text(model%materials(m)%number)//' is used by no element')
    end do
  end subroutine assign_materials

  !> After an error in a material nothing is said of its elements; that it is rigid counts.
  pure subroutine drop_unknown(deck, model)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(inout) :: model !! its elements lose their material
    logical :: known(0:size(model%materials))
    integer :: i, m

    known(0) = .true.
    m = 0
    do i = 1, size(deck%mesh)
      if (deck%mesh(i)%command /= 'mate') cycle
      m = m + 1
      known(m) = deck%mesh(i)%complete .or. model%materials(m)%rigid
    end do
    if (all(known)) return
    where (.not. known(model%element_material)) model%element_material = 0
  end subroutine drop_unknown

  !> Elements of ten nodes take the mean dilatation from nu 0.45 on unless the deck says FULL; those
  !! of four nodes have none but their own.
  subroutine choose_dilatation(model, diagnostics)
    type(model_t), intent(inout) :: model !! mesh and materials; these get mean
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical, dimension(size(model%materials)) :: four, ten
    integer :: e, m

    four = .false.
    ten = .false.
    do e = 1, model%mesh%elements
      m = model%element_material(e)
      if (m == 0) cycle
      if (has_middles(model%mesh%ix(:, e))) then
        ten(m) = .true.
      else
        four(m) = .true.
      end if
    end do
    do m = 1, size(model%materials)
      associate (material => model%materials(m))
        if (material%mean .and. four(m) .and. .not. material%rigid) call report_error(diagnostics, &
          material%at, 'MEAN of material '//to_text(material%number)//' needs elements of ten '// &
          'nodes, and it has some of four', 'mesh it with TET10, or write SOLId without MEAN')
        if (material%nodal .and. ten(m) .and. .not. material%rigid) call report_error(diagnostics, &
          material%at, 'NODAl of material '//to_text(material%number)//' needs elements of '// &
          'four nodes, and it has some of ten', 'write MEAN, which is for them')
        if (material%nodal .and. four(m) .and. .not. material%rigid) call report_note(diagnostics, &
          material%at, 'NODAl of material '//to_text(material%number)//': displacements do not '// &
          'lock, but pressures scatter from node to node: average them, or mesh with TET10')
        if (ten(m) .and. .not. (material%mean_asked .or. material%nodal)) material%mean = &
          laws(material%law)%may_mean .and. material%poissons_ratio >= locking_ratio
      end associate
    end do
  end subroutine choose_dilatation

  !> Index of a material number, 0 if there is none; `guess` is tried first.
  pure integer function material_index(materials, number, guess) result(m)
    type(material_t), intent(in) :: materials(:) !! the materials
    integer, intent(in) :: number !! the number
    integer, intent(in) :: guess !! index that is likely, or 0

    if (guess > 0) then
      m = guess
      if (materials(m)%number == number) return
    end if
    do m = 1, size(materials)
      if (materials(m)%number == number) return
    end do
    m = 0
  end function material_index

  !> Whether no element before this one has its material number.
  pure logical function first_without(model, element) result(first)
    type(model_t), intent(in) :: model !! the mesh
    integer, intent(in) :: element !! element number

    associate (mesh => model%mesh)
      first = .not. any(mesh%material(:element - 1) == mesh%material(element) .and. &
        mesh%ix(1, :element - 1) > 0)
    end associate
  end function first_without

  !> Reports a material number without MATErial where the deck first uses it.
  subroutine report_missing_material(deck, model, element, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(model_t), intent(in) :: model !! mesh and materials
    integer, intent(in) :: element !! first element that has it
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(location_t) :: at
    integer :: i, number

    number = model%mesh%material(element)
    at = deck%last
    do i = size(deck%mesh), 1, -1
      call find_material_item(deck%mesh(i), number, at)
    end do
    call report_error(diagnostics, at, 'material '//to_text(number)//' of element '// &
      to_text(element)//' does not exist', 'define it with MATErial '//to_text(number)// &
      '; the deck has '//count_noun(size(model%materials), 'material'))
  end subroutine report_missing_material

  !> Where an ELEMents or BLOCk data set names a material; `at` stays if it does not.
  subroutine find_material_item(set, number, at)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: number !! material number
    type(location_t), intent(inout) :: at !! the place found
    integer :: i, k

    do i = set%count, 1, -1
      associate (record => set%records(i))
        k = material_item(set%command, record)
        if (k == 0) cycle
        if (record%items(k)%kind /= item_number) cycle
        if (nint(record%items(k)%value) == number) at = item_location(record, k)
      end associate
    end do
  end subroutine find_material_item

  !> Index of the item of a record that is a material number, 0 if there is none.
  pure integer function material_item(command, record) result(k)
    character(4), intent(in) :: command !! the data set's command
    type(record_t), intent(in) :: record !! the record
    integer :: i

    k = 0
    if (command == 'elem' .and. item_count(record) > 3) k = 3
    if (command /= 'bloc' .or. item_count(record) < 4) return
    if (.not. is_word(record%items(1), 'cart')) return
    do i = 5, item_count(record) - 1
      if (is_word(record%items(i), 'material')) k = i + 1
    end do
    if (k == 0 .and. item_count(record) > 6) k = 7
  end function material_item
end module materials_reader

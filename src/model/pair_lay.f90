!> The lay of a pair's master surface: from the deck or a field of the mesh file, checked on each
!! facet.
module pair_lay
  use kinds, only: wp
  use text, only: to_text, count_noun
  use diagnostics, only: diagnostics_t, report_error
  use deck_types, only: location_t
  use mesh_types, only: mesh_t
  use file_mesh_checks, only: place_in_file
  use file_fields, only: find_vector
  use contact_types, only: pair_t, direction_field
  use lay_directions, only: lay_on_facet, convected_lay, lay_fine, lay_normal, lay_nowhere
  implicit none
  private
  public :: set_lay

contains

  !> Checks the lay direction on each master facet, and keeps it where it is convected.
  !!
  !! Isotropic friction needs no direction: it is checked only where the deck gives one, or where
  !! the two coefficients differ.
  subroutine set_lay(given, mesh, diagnostics, pair)
    logical, intent(in) :: given !! the deck has a DIREction
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    real(wp) :: p(3)
    integer :: i, n(2), bad(2), fault
    logical :: found

    if (.not. (given .or. abs(pair%friction%mu(1) - pair%friction%mu(2)) > 0.0_wp)) return
    found = .true.
    if (pair%friction%direction == direction_field) call take_field(mesh, diagnostics, pair, found)
    if (.not. found) return
    if (pair%friction%convected) allocate (pair%surface%lay(6, size(pair%surface%facets, 2)), &
      source=0.0_wp)
    n = 0
    bad = 0
    do i = 1, size(pair%surface%facets, 2)
      associate (corners => pair%surface%facets(:, i))
        call lay_on_facet(pair, i, mesh%x(:, corners), p, fault)
        if (fault /= lay_fine) then
          if (n(fault) == 0) bad(fault) = i
          n(fault) = n(fault) + 1
        else if (pair%friction%convected) then
          pair%surface%lay(:, i) = convected_lay(pair, i, mesh%x(:, corners))
        end if
      end associate
    end do
    if (n(lay_normal) > 0) call report_facets(pair, where_given(pair, bad(lay_normal), mesh, &
      diagnostics), 'the lay direction is normal to the facet', bad(lay_normal), n(lay_normal), &
      'give a DIREction that has a part in each master facet', diagnostics)
    if (n(lay_nowhere) > 0) call report_facets(pair, where_given(pair, bad(lay_nowhere), mesh, &
      diagnostics), what_is_missing(pair), bad(lay_nowhere), n(lay_nowhere), &
      'a lay needs a direction in the middle of each master facet', diagnostics)
  end subroutine set_lay

  !> Why a facet has no direction at all.
  pure function what_is_missing(pair) result(what)
    type(pair_t), intent(in) :: pair !! the pair
    character(:), allocatable :: what

    what = 'the axis of the lay goes through the centre of the facet'
    if (pair%friction%direction == direction_field) what = 'the lay has no length on the facet'
  end function what_is_missing

  !> Where the direction of a facet is given: in the deck, or in the mesh file of its field.
  function where_given(pair, facet, mesh, diagnostics) result(at)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(in) :: diagnostics !! knows the files
    type(location_t) :: at
    integer :: field, place

    at = pair%friction%direction_at
    if (pair%friction%direction /= direction_field) return
    call find_vector(mesh, pair%friction%field, pair%surface%facets(:, facet), field, place)
    if (place > 0) at = place_in_file(diagnostics%source, mesh%fields(field)%file, &
      mesh%fields(field)%at(place))
  end function where_given

  !> Takes the vectors of the master facets from the fields of the mesh files.
  subroutine take_field(mesh, diagnostics, pair, good)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! gets facet_axis
    logical, intent(out) :: good !! each facet has a vector
    integer :: i, n, bad, field, place

    allocate (pair%surface%facet_axis(3, size(pair%surface%facets, 2)), source=0.0_wp)
    n = 0
    bad = 0
    do i = 1, size(pair%surface%facets, 2)
      call find_vector(mesh, pair%friction%field, pair%surface%facets(:, i), field, place)
      if (field == 0) exit
      if (place > 0) then
        pair%surface%facet_axis(:, i) = mesh%fields(field)%vectors(:, place)
        if (any(abs(pair%surface%facet_axis(:, i)) > 0.0_wp)) pair%surface%facet_axis(:, i) = &
          pair%surface%facet_axis(:, i)/maxval(abs(pair%surface%facet_axis(:, i)))
      else
        if (n == 0) bad = i
        n = n + 1
      end if
    end do
    good = field > 0 .and. n == 0
    if (field == 0) then
      call report_error(diagnostics, pair%friction%direction_at, &
        'no mesh file has element data '''// &
        pair%friction%field//''' of three components', 'write a vector for each triangle of '''// &
        pair%master//''' to $ElementData of a Gmsh file')
    else if (n > 0) then
      call report_facets(pair, pair%friction%direction_at, 'the element data '''// &
        pair%friction%field// &
        ''' has no vector for the facet', bad, n, 'each master facet needs one', diagnostics)
    end if
  end subroutine take_field

  !> Reports what is wrong with `n` facets, of which `facet` is the first.
  subroutine report_facets(pair, at, what, facet, n, remedy, diagnostics)
    type(pair_t), intent(in) :: pair !! the pair
    type(location_t), intent(in) :: at !! where it is given
    character(*), intent(in) :: what !! what is wrong, before the facet is named
    integer, intent(in) :: facet !! first facet
    integer, intent(in) :: n !! number of facets
    character(*), intent(in) :: remedy !! what would be right
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: more

    more = ''
    if (n > 1) more = ' and '//count_noun(n - 1, 'other facet')
    call report_error(diagnostics, at, what//' '//to_text(pair%surface%facets(1, facet))//' '// &
      to_text(pair%surface%facets(2, facet))//' '//to_text(pair%surface%facets(3, facet))// &
        ' of '''// &
      pair%master//''''//more, remedy)
  end subroutine report_facets
end module pair_lay

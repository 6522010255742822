!> The lay of a pair's master surface: from the deck or a field of the mesh file, checked on each
!! facet.
module pair_lay
  use kinds, only: wp
  use text, only: to_text, count_noun
  use diagnostics, only: diagnostics_t, report_error
  use mesh_types, only: mesh_t
  use contact_types, only: pair_t
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

    if (.not. (given .or. abs(pair%mu(1) - pair%mu(2)) > 0.0_wp)) return
    if (pair%convected) allocate (pair%lay(6, size(pair%facets, 2)), source=0.0_wp)
    n = 0
    bad = 0
    do i = 1, size(pair%facets, 2)
      associate (corners => pair%facets(:, i))
        call lay_on_facet(pair, i, mesh%x(:, corners), p, fault)
        if (fault /= lay_fine) then
          if (n(fault) == 0) bad(fault) = i
          n(fault) = n(fault) + 1
        else if (pair%convected) then
          pair%lay(:, i) = convected_lay(pair, i, mesh%x(:, corners))
        end if
      end associate
    end do
    if (n(lay_normal) > 0) call report_facets(pair, 'the lay direction is normal to the facet', &
      bad(lay_normal), n(lay_normal), 'give a DIREction that has a part in each master facet', &
      diagnostics)
    if (n(lay_nowhere) > 0) call report_facets(pair, 'the axis of the lay goes through the centre '// &
      'of the facet', bad(lay_nowhere), n(lay_nowhere), 'there is no direction around an axis on '// &
      'it: move the axis to a node, or leave the facet out of the master', diagnostics)
  end subroutine set_lay

  !> Reports what is wrong with `n` facets, of which `facet` is the first.
  subroutine report_facets(pair, what, facet, n, remedy, diagnostics)
    type(pair_t), intent(in) :: pair !! the pair
    character(*), intent(in) :: what !! what is wrong, before the facet is named
    integer, intent(in) :: facet !! first facet
    integer, intent(in) :: n !! number of facets
    character(*), intent(in) :: remedy !! what would be right
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: more

    more = ''
    if (n > 1) more = ' and '//count_noun(n - 1, 'other facet')
    call report_error(diagnostics, pair%direction_at, what//' '//to_text(pair%facets(1, facet))// &
      ' '//to_text(pair%facets(2, facet))//' '//to_text(pair%facets(3, facet))//' of '''// &
      pair%master//''''//more, remedy)
  end subroutine report_facets
end module pair_lay

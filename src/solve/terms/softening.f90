!> Friction that softens as points slip (doc/theory, "Decay and cap"): a point keeps the
!! coefficients that it had at the start of the increment until it slips with them.
module softening
  use kinds, only: wp
  use element_types, only: status_slip, routine_none
  use element_parameters, only: d03_mu, d03_law, d03_area
  use friction_laws, only: keeps_path, hold_path, n_law_values
  use friction_return, only: has_friction
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use softening_state, only: softening_t
  use element_lists, only: element_list_t
  use system_parts, only: contact_places_t
  implicit none
  private
  public :: begin_softening, hold_coefficients, find_softening

  !> Coefficients that differ by more than this share are clearly others: Newton's method finds its
  !! way from the one to the other no more where bodies jump.
  real(wp), parameter :: clearly_falling = 1.0e-4_wp
  !> Passes with coefficients that are held. They fall from one to the next, commonly to the kinetic
  !! ones in two or three; where they fall slowly nothing jumps.
  integer, parameter :: most_softening_passes = 40

contains

  !> An increment begins, or its next try: nothing has slipped in it.
  subroutine begin_softening(model, softening)
    type(model_t), intent(in) :: model !! pairs
    type(softening_t), allocatable, intent(inout) :: softening(:) !! (pairs) if some law softens
    integer :: k

    if (allocated(softening)) deallocate (softening)
    if (.not. any([(keeps_path(model%pairs(k)%law), k=1, size(model%pairs))])) return
    allocate (softening(size(model%pairs)))
    do k = 1, size(model%pairs)
      allocate (softening(k)%follows(places(model%pairs(k))), source=.false.)
      allocate (softening(k)%ahead(places(model%pairs(k))), source=0.0_wp)
    end do
  end subroutine begin_softening

  !> How many places of a pair soften each by itself: its points, or slave facets if it is cut.
  pure integer function places(pair) result(n)
    type(pair_t), intent(in) :: pair !! the pair

    n = count_points(pair)
    if (pair%segmented) n = size(pair%points%slave_facets, 2)
  end function places

  !> The place of a point; a point of a segmented pair that is idle has none.
  pure integer function place_of(pair, p) result(place)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point

    place = p
    if (pair%segmented) place = pair%history%cells(p)%slave
  end function place_of

  !> Gives the elements of points that do not follow the coefficients that they are held at.
  pure subroutine hold_coefficients(model, place, softening, contact)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    type(softening_t), allocatable, intent(in) :: softening(:) !! (pairs) if some law softens
    type(element_list_t), intent(inout) :: contact !! elements made; get coefficients
    integer :: k, p, element, n

    if (.not. allocated(softening)) return
    do k = 1, size(model%pairs)
      if (.not. keeps_path(model%pairs(k)%law)) cycle
      do p = 1, count_points(model%pairs(k))
        element = place%first_point(k) + p - 1
        if (contact%routine(element) == routine_none) cycle
        n = place_of(model%pairs(k), p)
        if (softening(k)%follows(n)) cycle
        associate (d => contact%d(:, element))
          call hold_path(contact%path1(element) + softening(k)%ahead(n), &
            d(d03_law:d03_area - 1), d(d03_mu:d03_mu + 1))
        end associate
      end do
    end do
  end subroutine hold_coefficients

  !> After a solve that has settled: points that slip with the coefficients at which they are held.
  !! As long as these would be clearly others after their slip, they are held at those; then they
  !! follow. The increment is to be solved again.
  pure subroutine find_softening(model, contact, place, softening, found)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(element_list_t), intent(in) :: contact !! contact elements, converged
    type(contact_places_t), intent(in) :: place !! where they are
    type(softening_t), allocatable, intent(inout) :: softening(:) !! (pairs) if some law softens
    integer, intent(out) :: found !! such points
    integer :: k

    found = 0
    if (.not. allocated(softening)) return
    do k = 1, size(model%pairs)
      if (keeps_path(model%pairs(k)%law)) call soften(model%pairs(k), contact, &
        place%first_point(k) - 1, softening(k), found)
    end do
  end subroutine find_softening

  !> The same for one pair.
  pure subroutine soften(pair, list, before_first, softening, found)
    type(pair_t), intent(in) :: pair !! the pair
    type(element_list_t), intent(in) :: list !! contact elements, converged
    integer, intent(in) :: before_first !! so many come before those of the pair
    type(softening_t), intent(inout) :: softening !! of the pair
    integer, intent(inout) :: found !! grows by such points
    real(wp) :: way(size(softening%ahead)), mu(2), values(n_law_values)
    logical :: far
    integer :: p, element, place, before

    way = 0.0_wp
    far = .false.
    before = found
    do p = 1, count_points(pair)
      element = before_first + p
      if (list%routine(element) == routine_none) cycle
      if (list%status(element) /= status_slip) cycle
      place = place_of(pair, p)
      associate (now => list%d(d03_mu:d03_mu + 1, element))
        if (softening%follows(place) .or. .not. any(has_friction(now))) cycle
        found = found + 1
        way(place) = max(way(place), list%path2(element) - list%path1(element))
        mu = pair%friction%mu
        values = pair%law
        call hold_path(list%path1(element) + way(place), values, mu)
        far = far .or. any(abs(mu - now) > clearly_falling*now)
      end associate
    end do
    if (found == before) return
    softening%passes = softening%passes + 1
    if (far .and. softening%passes < most_softening_passes) then
      softening%ahead = max(softening%ahead, way)
    else
      softening%follows = softening%follows .or. way > 0.0_wp .or. softening%ahead > 0.0_wp
    end if
  end subroutine soften
end module softening

!> What the first tangent of an increment expects of the contact points: those that were closed at
!! the last converged state are as far below their facets, those that slipped slip on (doc/theory,
!! "Predicted active set", eq. (11.2)).
module expected_status
  use kinds, only: wp
  use element_types, only: status_open, status_slip, routine_none
  use element_lists, only: element_list_t
  use model_types, only: model_t
  use contact_types, only: pair_t, contact_point_t
  use contact_points, only: count_points, point_position
  use contact_parameters, only: point_shift
  use contact_overlap, only: withheld_gap
  use slave_places, only: cell_position
  use smooth_normals, only: project_on_master
  use facet_geometry, only: facet_size
  use point_status, only: forget_expected
  use system_parts, only: bodies_t, contact_places_t, positions_t
  implicit none
  private
  public :: expect_status

  !> A gap below this share of the facet's size is closed for the first tangent.
  real(wp), parameter :: touching = 1.0e-9_wp

  !> What is expected of the points of one slave facet of a segmented pair.
  type :: expected_t
    real(wp) :: area = 0.0_wp !! of its points at the last converged state [length^2]
    real(wp) :: gap = 0.0_wp !! their mean gap [length]
    logical :: closed = .true. !! all of them were closed
    logical :: slips = .true. !! and slipped
  end type expected_t

contains

  !> Notes for the next tangent which points were closed, and which of them slipped.
  subroutine expect_status(model, place, position, body, contact)
    type(model_t), intent(in) :: model !! pairs with the targets of the start
    type(contact_places_t), intent(in) :: place !! where the contact elements are
    type(positions_t), intent(in) :: position !! of the last state, and of the start
    type(bodies_t), intent(in) :: body !! which of them float
    type(element_list_t), intent(inout) :: contact !! contact elements at x_now; gets keep, slide
    integer :: k, p, element

    call forget_expected(contact)
    do k = 1, size(model%pairs)
      if (model%pairs(k)%segmented) then
        call expect_on_facets(model%pairs(k), place%first_point(k), position, body, contact)
        cycle
      end if
      do p = 1, count_points(model%pairs(k))
        element = place%first_point(k) + p - 1
        if (contact%routine(element) == routine_none) cycle
        if (model%pairs(k)%history%old(p)%status <= status_open) then
          contact%keep(element) = touching_shift(model%pairs(k), p, element, position, body, &
            contact)
          cycle
        end if
        contact%slide(element) = model%pairs(k)%history%old(p)%status == status_slip
        contact%keep(element) = closing_shift(model%pairs(k), p, position)
      end do
    end do
  end subroutine expect_status

  !> The same for the points of a segmented pair, which may be others than those of the last state:
  !! what is expected of one is what all the points of its slave facet did.
  subroutine expect_on_facets(pair, first, position, body, contact)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: first !! its first contact element
    type(positions_t), intent(in) :: position !! of the last state, and of the start
    type(bodies_t), intent(in) :: body !! which of them float
    type(element_list_t), intent(inout) :: contact !! gets keep, slide
    type(expected_t) :: facets(size(pair%points%slave_facets, 2))
    real(wp) :: now
    integer :: p

    call look_back(pair, position%x_old, facets)
    do p = 1, count_points(pair)
      if (pair%history%cells(p)%slave == 0) cycle
      if (contact%routine(first + p - 1) == routine_none) cycle
      associate (facet => facets(pair%history%cells(p)%slave))
        if (.not. facet%closed .or. facet%area <= 0.0_wp) then
          contact%keep(first + p - 1) = touching_shift(pair, p, first + p - 1, position, body, &
            contact)
          cycle
        end if
        contact%slide(first + p - 1) = facet%slips
        now = shifted_gap(pair, p, pair%history%new(p), position%x_now)
        if (now > 0.0_wp) contact%keep(first + p - 1) = facet%gap - now
      end associate
    end do
  end subroutine expect_on_facets

  !> What the points of each slave facet did at the last converged state.
  pure subroutine look_back(pair, x, facets)
    type(pair_t), intent(in) :: pair !! a segmented pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    type(expected_t), intent(inout) :: facets(:) !! (slave facets)
    real(wp) :: xi(2), gap
    integer :: p

    do p = 1, size(pair%history%old)
      associate (cell => pair%history%old_cells(p), point => pair%history%old(p))
        if (cell%slave == 0 .or. cell%area <= 0.0_wp) cycle
        associate (facet => facets(cell%slave))
          facet%closed = facet%closed .and. point%status > status_open
          facet%slips = facet%slips .and. point%status == status_slip
          if (.not. facet%closed) cycle
          call project_on_master(pair, point%target, x, cell_position(pair, cell, x), xi, gap)
          facet%area = facet%area + cell%area
          facet%gap = facet%gap + (gap - facet%gap)*cell%area/facet%area
        end associate
      end associate
    end do
  end subroutine look_back

  !> The shift along the normal that closes a point which touches its facet but for round-off, which
  !! else would decide what holds a body at first; 0 for all others, and between bodies that
  !! supports hold.
  pure real(wp) function touching_shift(pair, p, element, position, body, contact) result(shift)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! an open point with a target
    integer, intent(in) :: element !! its contact element
    type(positions_t), intent(in) :: position !! positions of the nodes
    type(bodies_t), intent(in) :: body !! which of them float
    type(element_list_t), intent(in) :: contact !! contact elements
    real(wp) :: gap, tolerance

    shift = 0.0_wp
    associate (nodes => contact%ix(1:contact%nel(element), element))
      if (.not. any(body%floating(body%node_body(nodes)))) return
    end associate
    gap = shifted_gap(pair, p, pair%history%new(p), position%x_now)
    tolerance = touching*facet_size(position%x_now(:, pair%surface%facets(:, &
      pair%history%new(p)%target)))
    if (abs(gap) <= tolerance) shift = -gap - tolerance
  end function touching_shift

  !> The shift along the normal that gives a point the gap that it had at the last converged state.
  pure real(wp) function closing_shift(pair, p, position) result(shift)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! a point that was closed
    type(positions_t), intent(in) :: position !! positions
    real(wp) :: now, before

    shift = 0.0_wp
    now = shifted_gap(pair, p, pair%history%new(p), position%x_now)
    before = shifted_gap(pair, p, pair%history%old(p), position%x_old)
    if (before < 0.0_wp) shift = before - now
  end function closing_shift

  !> Normal gap of a point with the shift of its multiplier.
  pure real(wp) function shifted_gap(pair, p, point, x) result(gap)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    type(contact_point_t), intent(in) :: point !! its state, with a target
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: xi(2), kappa(3)

    call project_on_master(pair, point%target, x, point_position(pair, p, x), xi, gap)
    kappa = point_shift(pair, p, point)
    gap = gap + kappa(3) + withheld_gap(pair, p)
  end function shifted_gap
end module expected_status

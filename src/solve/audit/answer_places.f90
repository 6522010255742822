!> Contact points as forces on the candidates of the condensed form, and what they do to the gaps of
!! others (doc/theory, "Other answers", eq. (13.6)).
module answer_places
  use kinds, only: wp
  use vectors, only: cross
  use element_types, only: routine_none
  use quadratic_facet, only: facet_shapes, facet_shapes_t, facet_of_routine
  use condensed_types, only: condensed_t
  use model_types, only: model_t
  use system_types, only: form_t, system_t
  use element_lists, only: element_list_t
  implicit none
  private
  public :: place_t, list_places, coupling_of, carried, slip_of

  !> A contact point as a few forces on candidates.
  type :: place_t
    integer :: element = 0 !! place in the list of contact elements
    integer :: pair = 0, point = 0 !! the pair, and which of its points
    real(wp) :: compliance = 0.0_wp !! of its penalty [length/force]
    real(wp) :: mu(2) = 0.0_wp !! coefficients
    logical :: closed = .false. !! and carries more than round-off
    integer :: rule = 0 !! slip rule m
    integer :: n = 0 !! its nodes with a share
    integer :: candidate(3, 12) = 0 !! (3, n) candidates of its nodes, 0 for none
    integer :: body(12) = 0 !! (n) bodies of the condensed form that these belong to, 0 for none
    real(wp) :: share(12) = 0.0_wp !! (n) force on each over that on the slave point
    real(wp) :: frame(3, 3) = 0.0_wp !! normal and axes of friction
  end type place_t

contains

  !> All points with a facet: their nodes, shares and frames.
  pure subroutine list_places(model, system, form, point_state, places)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements, candidates
    type(form_t), intent(in) :: form !! what the condensed form keeps
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of the contact elements
    type(place_t), allocatable, intent(out) :: places(:) !! the points
    integer :: e, k, n

    allocate (places(count(system%contact%routine /= routine_none)))
    n = 0
    do k = 1, size(model%pairs)
      do e = system%place%first_point(k), system%place%first_point(k + 1) - 1
        if (system%contact%routine(e) == routine_none) cycle
        n = n + 1
        places(n) = place_of(system, form%condensed, e, point_state(:, e))
        places(n)%pair = k
        places(n)%point = e - system%place%first_point(k) + 1
        places(n)%mu = model%pairs(k)%friction%mu
        places(n)%rule = model%pairs(k)%friction%slip_rule
        places(n)%compliance = 1.0_wp/model%pairs(k)%points%epsilon(places(n)%point)
        if (model%pairs(k)%augmented) places(n)%compliance = places(n)%compliance &
          /model%pairs(k)%history%raise
      end do
    end do
  end subroutine list_places

  !> A point: a unit force on the slave, and its reaction on the nodes of the facet.
  pure type(place_t) function place_of(system, condensed, e, stress) result(place)
    type(system_t), intent(in) :: system !! contact elements, candidates
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    integer, intent(in) :: e !! the contact element
    real(wp), intent(in) :: stress(:) !! its state
    integer :: a, slaves

    associate (list => system%contact)
      slaves = list%slaves(e)
      place%element = e
      place%n = slaves + merge(6, 3, size(facet_weights(system%contact, e, list%h2(:, e))) > 3)
      place%share(:slaves) = 1.0_wp
      if (slaves > 1) place%share(:slaves) = list%weight(:slaves, e)
      place%share(slaves + 1:place%n) = -facet_weights(system%contact, e, list%h2(:, e))
      do a = 1, place%n
        if (list%ix(a, e) > 0) place%candidate(:, a) = condensed%place(:, list%ix(a, e))
        place%body(a) = body_of(condensed, maxval(place%candidate(:, a)))
      end do
    end associate
    place%frame(:, 1) = stress(10:12)
    place%frame(:, 2) = stress(7:9)
    place%frame(:, 3) = cross(stress(10:12), stress(7:9))
  end function place_of

  !> Shape functions of the facet below a point, of its corners or of six nodes.
  pure function facet_weights(contact, e, xi) result(weights)
    type(element_list_t), intent(in) :: contact !! contact elements
    integer, intent(in) :: e !! the contact element
    real(wp), intent(in) :: xi(2) !! place on the facet
    real(wp), allocatable :: weights(:)
    type(facet_shapes_t) :: s
    integer :: n

    s = facet_shapes(xi, facet_of_routine(contact%routine(e)))
    n = min(merge(6, 3, any(abs(s%n(4:6)) > 0.0_wp)), contact%nel(e) - contact%slaves(e))
    weights = s%n(:n)
  end function facet_weights

  !> What forces at one point do to the gap of another, in their frames (eq. (13.6)).
  pure function coupling_of(condensed, to, from, held_only) result(w)
    type(condensed_t), intent(in) :: condensed !! compliance
    type(place_t), intent(in) :: to, from !! the points
    logical, intent(in) :: held_only !! only of bodies that supports hold
    real(wp) :: w(3, 3)
    integer :: a, b, i

    w = 0.0_wp
    do b = 1, from%n
      if (from%body(b) == 0) cycle
      associate (body => condensed%bodies(from%body(b)))
        if (held_only .and. body%motions%n > 0) cycle
        do a = 1, to%n
          if (to%body(a) == from%body(b)) call add_entries(body%compliance, to%candidate(:, a) &
            - body%first, from%candidate(:, b) - body%first, to%share(a)*from%share(b), w)
        end do
      end associate
    end do
    w = matmul(transpose(to%frame), matmul(w, from%frame))
    if (to%element /= from%element) return
    do i = 1, 3
      w(i, i) = w(i, i) + to%compliance
    end do
  end function coupling_of

  !> Adds the compliance between two nodes; its lower triangle counts.
  pure subroutine add_entries(compliance, to, from, share, w)
    real(wp), intent(in) :: compliance(:, :) !! of a body [length/force]
    integer, intent(in) :: to(3), from(3) !! candidates of the nodes in it, below 1 for none
    real(wp), intent(in) :: share !! product of the shares of both
    real(wp), intent(inout) :: w(3, 3) !! grows
    integer :: i, j

    do j = 1, 3
      if (from(j) < 1) cycle
      do i = 1, 3
        if (to(i) < 1) cycle
        w(i, j) = w(i, j) + share*compliance(max(to(i), from(j)), min(to(i), from(j)))
      end do
    end do
  end subroutine add_entries

  !> The body that a candidate belongs to, 0 for none.
  pure integer function body_of(condensed, candidate) result(b)
    type(condensed_t), intent(in) :: condensed !! bodies
    integer, intent(in) :: candidate !! its number, 0 for none

    do b = size(condensed%bodies), 1, -1
      associate (body => condensed%bodies(b))
        if (candidate > body%first .and. candidate <= body%first + body%m) return
      end associate
    end do
  end function body_of

  !> What the rigid motions that nothing else holds do to the gap of a point.
  pure function carried(condensed, place, motions) result(r)
    type(condensed_t), intent(in) :: condensed !! bodies
    type(place_t), intent(in) :: place !! the point
    integer, intent(in) :: motions !! of all bodies
    real(wp) :: r(3, motions)
    integer :: a, b, i, k

    r = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%motions%n == 0) cycle
        do a = 1, place%n
          do i = 1, 3
            k = place%candidate(i, a) - body%first
            if (k <= 0 .or. k > body%m) cycle
            r(i, body%first_mode + 1:body%first_mode + body%motions%n) = r(i, body%first_mode &
              + 1:body%first_mode + body%motions%n) + place%share(a)*body%modes(k, :)
          end do
        end do
      end associate
    end do
    r = matmul(transpose(place%frame), r)
  end function carried

  !> How far the tip of a point has gone on its facet since the increment began. The slip is against
  !! the force: what a point that touches first has gone before it did, need not be.
  pure function slip_of(x, system, e) result(way)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: e !! the contact element
    real(wp) :: way(3)
    real(wp), allocatable :: change(:)
    integer :: a

    way = 0.0_wp
    associate (list => system%contact)
      change = facet_weights(system%contact, e, list%h2(:, e))
      change = change - facet_weights(system%contact, e, list%h1(:, e))
      do a = 1, size(change)
        way = way + change(a)*x(:, list%ix(list%slaves(e) + a, e))
      end do
    end associate
  end function slip_of
end module answer_places

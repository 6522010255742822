!> The contact elements of a system: targets to elements, elements to targets.
module contact_system
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_search, cost_t
  use element_types, only: status_off, status_open, routine_none
  use element_lists, only: element_list_t
  use element_parameters, only: d03_epsilon
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_position, point_lift, coupling
  use contact_parameters, only: point_parameters, point_shift
  use contact_overlap, only: withheld_gap
  use rigid_bodies, only: nothing_deforms
  use master_facets, only: is_quadratic, facet_routine
  use contact_targets, only: begin_increment, follow_apexes
  use contact_apexes, only: touches
  use smooth_normals, only: project_on_master
  use first_touch, only: withhold_friction, place_touches
  use softening, only: hold_coefficients
  use system_types, only: system_t
  use system_parts, only: positions_t, rigid_part_t
  implicit none
  private
  public :: restart_points, move_targets, load_contact

  !> Points whose gap is larger than this many search radii take no part in a solve.
  real(wp), parameter :: open_radii = 1.0_wp

contains

  !> Working points of all pairs at the start of an increment.
  subroutine restart_points(model, costs, position)
    type(model_t), intent(inout) :: model !! pairs: new is set
    type(cost_t), intent(inout) :: costs !! cost table
    type(positions_t), intent(in) :: position !! what points start from
    integer :: k

    call begin_cost(costs, cost_search)
    do k = 1, size(model%pairs)
      call begin_increment(model%pairs(k), position%x_old)
    end do
    call end_cost(costs, cost_search)
  end subroutine restart_points

  !> Lets the targets of all pairs follow the apexes. The first cells of an increment are cut where
  !! the bodies are when they are carried rigidly, so that they do not depend on the start.
  subroutine move_targets(model, system, costs, tolerance, changes)
    type(model_t), intent(inout) :: model !! pairs: targets may change
    type(system_t), intent(in) :: system !! contact elements, positions
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp), intent(in) :: tolerance !! extrapolation allowed at flat edges
    integer, intent(out) :: changes !! points with a new target
    integer :: k

    changes = 0
    call begin_cost(costs, cost_search)
    do k = 1, size(model%pairs)
      if (model%pairs(k)%segmented .and. tolerance <= 0.0_wp) then
        call follow_apexes(model%pairs(k), system%position%x_old, system%position%x_ahead, &
          tolerance, changes)
      else
        call follow_apexes(model%pairs(k), system%position%x_old, system%position%x_now, &
          tolerance, changes)
      end if
      changes = changes + overlooked(model%pairs(k), system, system%place%first_point(k))
    end do
    call place_touches(model, system, .false.)
    call end_cost(costs, cost_search)
  end subroutine move_targets

  !> Points that have come through the surface although their elements are idle.
  pure integer function overlooked(pair, system, first) result(n)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: first !! first element of the pair
    integer :: p

    n = 0
    do p = 1, count_points(pair)
      if (system%contact%routine(first + p - 1) /= routine_none) cycle
      if (touches(pair, system%position%x_now, p, pair%history%new(p)%target)) n = n + 1
    end do
  end function overlooked

  !> Makes the contact elements of the present targets; points far above the surface stay idle.
  subroutine load_contact(model, system)
    type(model_t), intent(in) :: model !! pairs with their targets
    type(system_t), intent(inout) :: system !! gets contact and its targets
    integer :: k, p, element

    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        element = system%place%first_point(k) + p - 1
        call load_point(model%pairs(k), p, system%position%x_now, element, system%contact, &
          system%place%targets(element))
        if (model%pairs(k)%history%softened) call keep_own_penalty(model%pairs(k), p, element, &
          system%equation, system%tools, system%contact)
      end do
    end do
    call hold_coefficients(model, system%place, system%softening, system%contact)
    call withhold_friction(model, system%place, system%touch, system%body, system%contact)
  end subroutine load_contact

  !> Makes one contact element.
  subroutine load_point(pair, p, x, element, list, coupled)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions at which its gap is judged [length]
    integer, intent(in) :: element !! its place in the list
    type(element_list_t), intent(inout) :: list !! gets the element
    integer, intent(out) :: coupled !! the facet that it couples, 0: it takes no part
    real(wp) :: xi(2), gap

    associate (point => pair%history%new(p))
      list%routine(element) = routine_none
      list%status(element) = status_off
      list%offset(element) = 0.0_wp
      coupled = 0
      if (point%target == 0) return
      list%status(element) = status_open
      call project_on_master(pair, point%target, x, point_position(pair, p, x), xi, gap)
      if (gap > open_radii*pair%search_radius) return
      list%routine(element) = facet_routine(pair, point%target)
      coupled = coupling(pair, p, point%target)
      call place_nodes(pair, p, point%target, element, list)
      list%d(:, element) = point_parameters(pair, p, point%target)
      list%h1(:, element) = point%apex
      list%path1(element) = point%path
      list%offset(element) = withheld_gap(pair, p)
      list%shift(:, element) = point_shift(pair, p, point)
    end associate
  end subroutine load_point

  !> Where all nodes of an element are prescribed no penalty is stiff: nothing gives way to it, and
  !! it is what the deck says.
  subroutine keep_own_penalty(pair, p, element, equation, tools, list)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: element !! its element
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(rigid_part_t), intent(in) :: tools !! rigid bodies
    type(element_list_t), intent(inout) :: list !! gets penalty and shift

    if (list%routine(element) == routine_none) return
    if (.not. nothing_deforms(equation, tools, list%ix(1:list%nel(element), element))) return
    list%d(d03_epsilon, element) = pair%points%epsilon(p)
    list%shift(:, element) = 0.0_wp
  end subroutine keep_own_penalty

  !> Nodes and weights of one contact element.
  pure subroutine place_nodes(pair, p, target, element, list)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: target !! its facet
    integer, intent(in) :: element !! its place in the list
    type(element_list_t), intent(inout) :: list !! gets ix, weight

    associate (n => pair%points%n_slaves)
      list%nel(element) = n + 3
      list%ix(1:n, element) = pair%points%point_nodes(:, p)
      list%ix(n + 1:n + 3, element) = pair%surface%facets(:, target)
      if (is_quadratic(pair, target)) then
        list%nel(element) = n + 6
        list%ix(n + 4:n + 6, element) = pair%surface%middles(:, target)
      end if
      if (n > 1) then
        list%weight(1:n, element) = pair%points%point_weights(:, p)
        list%lift(element) = point_lift(pair, p)
      end if
    end associate
  end subroutine place_nodes
end module contact_system

!> Names the contact point at which a solve hangs: pair, slave node, facet, gap, status.
module contact_report
  use kinds, only: wp
  use text, only: to_text
  use element_types, only: status_open, status_slip, status_stick
  use facet_geometry, only: project_on_facet
  use facet_tree, only: facet_tree_t, fit_tree, nearest_facet
  use element_lists, only: master_nodes
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_position, point_text
  use model_types, only: model_t
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: worst_contact, restless_point, closed_points, all_slip, has_friction

contains

  !> The contact point that tells most about a body: of its closed points the one whose nodes carry
  !! the largest residual, else the one closest to its surface; empty if the body is in no pair.
  function worst_contact(model, system, form, body) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! residual formed at u
    type(form_t), intent(in) :: form !! right
    integer, intent(in) :: body !! the body, 0 for all
    character(:), allocatable :: t
    real(wp) :: part, largest
    integer :: k, p, worst_pair, worst

    worst = 0
    worst_pair = 0
    largest = -1.0_wp
    do k = 1, size(model%pairs)
      do p = system%place%first_point(k), system%place%first_point(k + 1) - 1
        if (system%contact%status(p) <= status_open) cycle
        if (.not. is_of_body(system, p, body)) cycle
        part = residual_at(system%equation, form%right, system%contact%ix(1:system%contact%nel(p), &
          p))
        if (part <= largest) cycle
        largest = part
        worst_pair = k
        worst = p
      end do
    end do
    if (worst == 0) then
      t = closest_point(model, system, body)
    else
      t = point_line(model, system%u, worst_pair, worst - system%place%first_point(worst_pair) + &
        1, master_nodes(system%contact, worst), merge('stick', 'slip ', &
        system%contact%status(worst) == status_stick))//', residual '//to_text(largest, 4)
    end if
  end function worst_contact

  !> The slave point that is closest to the surface of its pair, where no point is closed.
  function closest_point(model, system, body) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! u given
    integer, intent(in) :: body !! the body, 0 for all
    character(:), allocatable :: t
    type(facet_tree_t) :: tree
    real(wp) :: x(3, model%mesh%nodes), distance, least
    integer :: k, p, facet, best(2), best_pair

    t = ''
    x = model%mesh%x + system%u
    least = huge(1.0_wp)
    best_pair = 0
    best = 0
    do k = 1, size(model%pairs)
      if (.not. pair_has_body(model%pairs(k), system, body)) cycle
      tree = model%pairs(k)%surface%tree
      call fit_tree(tree, model%pairs(k)%surface%facets, x)
      do p = system%place%first_point(k), system%place%first_point(k + 1) - 1
        associate (point => p - system%place%first_point(k) + 1)
          call nearest_facet(tree, model%pairs(k)%surface%facets, x, &
            point_position(model%pairs(k), point, x), facet, distance)
          if (facet == 0 .or. distance >= least) cycle
          least = distance
          best_pair = k
          best = [point, facet]
        end associate
      end do
    end do
    if (best_pair == 0) return
    t = point_line(model, system%u, best_pair, best(1), model%pairs(best_pair)%surface%facets(:, &
      best(2)), 'open')
  end function closest_point

  !> The line that names a point.
  function point_line(model, u, pair, point, facet, status) result(t)
    type(model_t), intent(in) :: model !! the model
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    integer, intent(in) :: pair !! the pair
    integer, intent(in) :: point !! slave point of the pair
    integer, intent(in) :: facet(3) !! corners of the facet
    character(*), intent(in) :: status !! status as a word
    character(:), allocatable :: t
    real(wp) :: xi(2), gap

    call project_on_facet(model%mesh%x(:, facet) + u(:, facet), &
      point_position(model%pairs(pair), point, model%mesh%x + u), xi, gap)
    t = '  worst contact point: pair '//model%pairs(pair)%name//', slave ' &
      //point_text(model%pairs(pair), point)//', '//facet_words(model%pairs(pair), facet)//': ' &
      //trim(status)//', gap '//to_text(gap, 4)
  end function point_line

  !> The point that has changed its facet most often in this increment, and between which facets.
  function restless_point(model) result(t)
    type(model_t), intent(in) :: model !! pairs: working points
    character(:), allocatable :: t
    integer :: k, p, pair, point, most

    most = 0
    pair = 1
    point = 1
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        if (model%pairs(k)%history%moves(p) <= most) cycle
        most = model%pairs(k)%history%moves(p)
        pair = k
        point = p
      end do
    end do
    associate (contact => model%pairs(pair))
      if (contact%segmented) point = max(1, findloc(contact%history%cells%slave, point, 1))
      t = 'pair '//contact%name//', slave '//point_text(contact, point) &
        //', facet of nodes '//target_text(contact, contact%history%new(point)%target) &
        //' after that of nodes '//target_text(contact, contact%history%left(point))
    end associate
  end function restless_point

  !> Closed contact points of a body (0: of all).
  pure integer function closed_points(system, body) result(n)
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: body !! the body
    integer :: p

    n = 0
    do p = 1, system%contact%n
      if (system%contact%status(p) <= status_open) cycle
      if (is_of_body(system, p, body)) n = n + 1
    end do
  end function closed_points

  !> The body has closed contact points, and all of them slip.
  pure logical function all_slip(system, body) result(yes)
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: body !! the body
    integer :: p

    yes = closed_points(system, body) > 0
    do p = 1, system%contact%n
      if (system%contact%status(p) <= status_open) cycle
      if (system%contact%status(p) == status_slip) cycle
      if (is_of_body(system, p, body)) yes = .false.
    end do
  end function all_slip

  !> Some pair of the body has friction.
  pure logical function has_friction(model, system, body) result(yes)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! bodies of the nodes
    integer, intent(in) :: body !! the body
    integer :: k

    yes = .false.
    do k = 1, size(model%pairs)
      if (.not. pair_has_body(model%pairs(k), system, body)) cycle
      if (any(model%pairs(k)%friction%mu > 0.0_wp)) yes = .true.
    end do
  end function has_friction

  !> A pair has slave nodes or facets on a body (0: any).
  pure logical function pair_has_body(pair, system, body) result(yes)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! bodies of the nodes
    integer, intent(in) :: body !! the body
    integer :: f

    yes = body == 0
    if (.not. yes) yes = any(system%body%node_body(pair%points%point_nodes(1, :)) == body)
    do f = 1, size(pair%surface%facets, 2)
      if (yes) return
      yes = system%body%node_body(pair%surface%facets(1, f)) == body
    end do
  end function pair_has_body

  !> The slave point or the facet belongs to the body (0: any).
  pure logical function is_of_body(system, element, body) result(yes)
    type(system_t), intent(in) :: system !! contact elements, bodies of the nodes
    integer, intent(in) :: element !! contact element
    integer, intent(in) :: body !! the body

    associate (nodes => system%contact%ix(1:system%contact%nel(element), element))
      yes = body == 0 .or. any(system%body%node_body(nodes) == body)
    end associate
  end function is_of_body

  !> Largest component of the residual at some nodes.
  pure real(wp) function residual_at(equation, right, nodes) result(largest)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: right(:) !! (equations+unknowns) right-hand side [force]
    integer, intent(in) :: nodes(:) !! the nodes
    integer :: i, k

    largest = 0.0_wp
    do i = 1, size(nodes)
      do k = 1, 3
        if (equation(k, nodes(i)) == 0) cycle
        largest = max(largest, abs(right(equation(k, nodes(i)))))
      end do
    end do
  end function residual_at

  !> The corner nodes of a target.
  pure function target_text(pair, target) result(t)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: target !! the facet, 0 for none
    character(:), allocatable :: t

    t = 'none'
    if (target > 0) t = facet_text(pair%surface%facets(:, target))
  end function target_text

  !> A master facet by its nodes; an exact surface has none that a deck knows.
  pure function facet_words(pair, facet) result(t)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet(3) !! corner nodes
    character(:), allocatable :: t

    t = 'facet of nodes '//facet_text(facet)
    if (pair%surface%exact) t = 'surface '//pair%master
  end function facet_words

  !> The corner nodes of a facet.
  pure function facet_text(facet) result(t)
    integer, intent(in) :: facet(3) !! corner nodes
    character(:), allocatable :: t

    t = to_text(facet(1))//', '//to_text(facet(2))//', '//to_text(facet(3))
  end function facet_text
end module contact_report

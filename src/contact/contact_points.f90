!> The points of a pair on its slave side: a slave node each, or a weighted sum of the nodes of a
!! slave facet (doc/theory, "Slave points and weights").
module contact_points
  use kinds, only: wp
  use text, only: to_text
  use vectors, only: cross
  use element_types, only: status_open
  use contact_types, only: pair_t, cell_t
  use facet_quadrature, only: make_rule
  use facet_geometry, only: corners, facet_size
  use master_facets, only: all_nodes
  use slave_places, only: place_curved, slave_nodes, slave_lift, lift_over
  implicit none
  private
  public :: is_first, first_cell, count_points, used_points, point_position, point_field, &
    point_facet, point_lift, point_text, lay_behind, &
    make_node_points, make_facet_points, corner_weights, longest_facet, smallest_facet, coupling, &
    most_coupled, coupled_nodes, is_too_deep, depth_limit

  !> Points of a slave facet that are nearer to each other, in shape functions, are at one place.
  real(wp), parameter :: one_place = 1.0e-9_wp

contains

  !> Number of points, further slots included.
  pure integer function count_points(pair) result(n)
    type(pair_t), intent(in) :: pair !! the pair

    n = size(pair%points%point_nodes, 2)
  end function count_points

  !> Number of points in use, without further slots.
  pure integer function used_points(pair) result(n)
    type(pair_t), intent(in) :: pair !! the pair

    n = count_points(pair)/pair%points%slots
    if (pair%segmented) n = count(pair%history%cells%slave > 0)
  end function used_points

  !> First point of a slave facet of a segmented pair, 0 if it has none: the points stand in the
  !! order of the facets, idle ones behind them.
  pure integer function first_cell(cells, f) result(first)
    type(cell_t), intent(in) :: cells(:) !! all points
    integer, intent(in) :: f !! the facet
    integer :: last, middle

    first = 1
    last = size(cells) + 1
    do while (first < last)
      middle = (first + last)/2
      if (cells(middle)%slave >= f .or. cells(middle)%slave == 0) then
        last = middle
      else
        first = middle + 1
      end if
    end do
    if (first > size(cells)) then
      first = 0
    else if (cells(first)%slave /= f) then
      first = 0
    end if
  end function first_cell

  !> A point of a segmented pair was open at a place of its slave facet where another one, over
  !! another facet of the master, was closed: what it saw lies behind that.
  pure logical function lay_behind(pair, p) result(behind)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point, at the last converged state
    integer :: q

    behind = .false.
    if (pair%history%old(p)%status > status_open) return
    associate (cells => pair%history%old_cells)
      q = max(1, first_cell(cells, cells(p)%slave))
      do while (q <= size(cells))
        if (cells(q)%slave /= cells(p)%slave) return
        behind = pair%history%old(q)%status > status_open .and. &
          norm2(cells(q)%weight - cells(p)%weight) <= one_place
        if (behind) return
        q = q + 1
      end do
    end associate
  end function lay_behind

  !> Where a point is: x_S = sum M_b x_b, and over that if its slave is bent.
  pure function point_position(pair, p, x) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: y(3)
    integer :: f

    y = point_field(pair, p, x)
    if (.not. allocated(pair%points%side%patch)) return
    f = point_facet(pair, p)
    if (f > 0) y = y + lift_over(pair, f, corner_weights(pair, p), x)
  end function point_position

  !> The slave facet of a point of a pair whose slave is a surface; 0 while it is not in use.
  pure integer function point_facet(pair, p) result(f)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point

    if (pair%segmented) then
      f = pair%history%cells(p)%slave
    else
      f = 1 + mod(p - 1, count_points(pair)/pair%points%slots)/pair%facet_points
    end if
  end function point_facet

  !> How high a point stands over its slave facet.
  pure real(wp) function point_lift(pair, p) result(lift)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp) :: l(3)
    integer :: f

    lift = 0.0_wp
    if (.not. allocated(pair%points%side%patch)) return
    f = point_facet(pair, p)
    if (f == 0) return
    l = corner_weights(pair, p)
    lift = slave_lift(pair, f, l(1:2))
  end function point_lift

  !> A field at a point: sum M_b u_b.
  pure function point_field(pair, p, x) result(y)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) the field
    real(wp) :: y(3)
    integer :: b

    if (pair%points%n_slaves == 1) then
      y = x(:, pair%points%point_nodes(1, p))
      return
    end if
    y = 0.0_wp
    do b = 1, pair%points%n_slaves
      y = y + pair%points%point_weights(b, p)*x(:, pair%points%point_nodes(b, p))
    end do
  end function point_field

  !> Longest edge of all master facets; of an exact surface, whose facets grow far away, of the
  !! smallest one.
  pure real(wp) function longest_facet(pair, x) result(h)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: f

    h = 0.0_wp
    do f = 1, size(pair%surface%facets, 2)
      h = max(h, facet_size(corners(x, pair%surface%facets(:, f))))
    end do
    if (pair%surface%exact) h = smallest_facet(pair, x)
  end function longest_facet

  !> A point is too far below a facet to be in contact with it: deeper than the search radius, or
  !! than the body is thick.
  pure logical function is_too_deep(pair, facet, gap) result(deep)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet
    real(wp), intent(in) :: gap !! negative below it [length]

    deep = gap < -depth_limit(pair, facet)
  end function is_too_deep

  !> How deep a point may be below a facet: as the search radius, and as the body is thick.
  pure real(wp) function depth_limit(pair, facet) result(limit)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! the facet

    limit = pair%search_radius
    if (allocated(pair%surface%depth)) limit = min(limit, pair%surface%depth(facet))
  end function depth_limit

  !> The smallest of the longest edges of the master facets of a pair.
  pure real(wp) function smallest_facet(pair, x) result(h)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer :: f

    h = huge(h)
    do f = 1, size(pair%surface%facets, 2)
      h = min(h, facet_size(corners(x, pair%surface%facets(:, f))))
    end do
  end function smallest_facet

  !> A number that tells which nodes the contact element of a point joins: its host, and where the
  !! slave nodes of a point change its slave facet as well.
  pure integer function coupling(pair, p, host)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: host !! its facet

    coupling = host
    if (pair%segmented) coupling = host + (pair%history%cells(p)%slave - &
      1)*size(pair%surface%facets, 2)
  end function coupling

  !> The largest of these numbers.
  pure integer function most_coupled(pair) result(most)
    type(pair_t), intent(in) :: pair !! the pair

    most = size(pair%surface%facets, 2)
    if (pair%segmented) most = most*size(pair%points%slave_facets, 2)
  end function most_coupled

  !> The slave nodes of a point and the corners of its host, from the number that tells them.
  pure function coupled_nodes(pair, p, number) result(nodes)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: number !! as of `coupling`, not 0
    integer, allocatable :: nodes(:)

    nodes = [pair%points%point_nodes(:, p), all_nodes(pair, 1 + mod(number - 1, &
      size(pair%surface%facets, 2)))]
    if (pair%segmented) nodes(:pair%points%n_slaves) = slave_nodes(pair, 1 + (number - &
      1)/size(pair%surface%facets, 2))
  end function coupled_nodes

  !> A point in words, behind 'slave': its node, or the facet it lies on.
  pure function point_text(pair, p) result(t)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    character(:), allocatable :: t
    integer :: b

    if (pair%points%n_slaves == 1) then
      t = 'node '//to_text(pair%points%point_nodes(1, p))
      return
    end if
    t = 'facet of nodes '//to_text(pair%points%point_nodes(1, p))
    do b = 2, pair%points%n_slaves
      t = t//', '//to_text(pair%points%point_nodes(b, p))
    end do
  end function point_text

  !> Points that are nodes.
  pure subroutine make_node_points(nodes, pair)
    integer, intent(in) :: nodes(:) !! slave nodes
    type(pair_t), intent(inout) :: pair !! gets n_slaves, point_nodes, point_weights

    pair%points%n_slaves = 1
    pair%points%point_nodes = reshape(nodes, [1, size(nodes)])
    if (allocated(pair%points%point_weights)) deallocate (pair%points%point_weights)
    allocate (pair%points%point_weights(1, size(nodes)), source=1.0_wp)
  end subroutine make_node_points

  !> Points inside of facets, and their share of the area (doc/theory, "Quadrature points",
  !! "Six-node facets").
  pure subroutine make_facet_points(facets, x, pair)
    integer, intent(in) :: facets(:, :) !! (3 or 6, facets) nodes of the slave facets, or zeros
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(pair_t), intent(inout) :: pair !! facet_points given; gets points, weights, area
    real(wp) :: shapes(3, pair%facet_points), shares(pair%facet_points)
    integer :: f, i, p, n_slaves

    call make_rule(pair%facet_points, shapes, shares)
    n_slaves = size(facets, 1)
    pair%points%n_slaves = n_slaves
    associate (n => pair%facet_points*size(facets, 2))
      if (allocated(pair%points%point_nodes)) deallocate (pair%points%point_nodes, &
        pair%points%point_weights)
      if (allocated(pair%points%area)) deallocate (pair%points%area)
      allocate (pair%points%point_nodes(n_slaves, n), pair%points%area(n))
      allocate (pair%points%point_weights(n_slaves, n), source=0.0_wp)
    end associate
    do f = 1, size(facets, 2)
      do i = 1, pair%facet_points
        p = (f - 1)*pair%facet_points + i
        if (n_slaves > 3 .and. facets(n_slaves, f) > 0) then
          call place_curved(x(:, facets(:, f)), shapes(:2, i), pair%points%point_weights(:, p), &
            pair%points%area(p))
        else
          associate (normal => cross(x(:, facets(1, f)) - x(:, facets(3, f)), &
            x(:, facets(2, f)) - x(:, facets(3, f))))
            pair%points%area(p) = 0.5_wp*norm2(normal)
          end associate
          pair%points%point_weights(:3, p) = shapes(:, i)
        end if
        pair%points%area(p) = shares(i)*pair%points%area(p)
        pair%points%point_nodes(:, p) = facets(:, f)
        if (facets(n_slaves, f) == 0) pair%points%point_nodes(4:, p) = facets(1, f)
      end do
    end do
  end subroutine make_facet_points

  !> What the corners of its slave facet weigh in a point, as linear functions: fields of
  !! multipliers and pressures live on corners.
  pure function corner_weights(pair, p) result(l)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp) :: l(3)

    l = pair%points%point_weights(:3, p)
    ! N_i + (N_ij + N_ki)/2 = L_i
    if (pair%points%n_slaves > 3) l = l + 0.5_wp*(pair%points%point_weights(4:6, p) &
      + pair%points%point_weights([6, 4, 5], p))
  end function corner_weights

  !> The point is a first slot.
  pure logical function is_first(pair, p)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point

    is_first = p <= count_points(pair)/pair%points%slots
  end function is_first
end module contact_points

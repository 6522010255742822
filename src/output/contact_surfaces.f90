!> What contact does to the two surfaces of a pair at one time: forces of points become
!! tractions of nodes and facets (doc/theory, "Contact fields", eq. (6.20)).
module contact_surfaces
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use kinds, only: wp
  use contact_types, only: pair_t, status_off, status_stick, status_slip, form_quadrature_to_surface
  use contact_points, only: corner_weights, count_points
  use master_facets, only: facet_kind
  use quadratic_facet, only: facet_shapes_t, facet_shapes
  use surface_lay, only: add_surface_lay
  use contact_sides, only: contact_surface_t, places
  use point_fields, only: point_fields_t
  implicit none
  private
  public :: find_slave_fields, find_master_fields
  public :: n_columns, at_pressure, at_traction, at_shear, at_gap, at_status, at_slip, at_energy, &
    at_lay, at_force, at_way, at_path, at_stick, at_slipping

  !> Places of the fields in a column: those with three components begin there. The force has a
  !! meaning at nodes only.
  integer, parameter :: at_pressure = 1, at_traction = 2, at_shear = 5, at_gap = 8, &
    at_status = 9, at_slip = 10, at_energy = 13, at_lay = 14, at_force = 17, at_way = 20, &
    at_path = 23, at_stick = 24, at_slipping = 25, n_columns = 25

  !> Sums over contact points at nodes or facets.
  type :: sums_t
    real(wp), allocatable :: force(:, :) !! (8, n) normal force, force, its shear part, energy
    real(wp), allocatable :: nodal(:, :) !! (3, n) force on the node itself
    real(wp), allocatable :: mean(:, :) !! (11, n) gap, slip, lay, frictional slip and its path,
    !! each times its weight
    real(wp), allocatable :: weight(:) !! (n) sum of these weights
    real(wp), allocatable :: share(:, :) !! (3, n) area of all points, of those that stick and slip
    integer, allocatable :: status(:) !! (n) largest status
  end type sums_t

contains

  !> Friction of the pair has a direction.
  pure logical function has_lay(pair)
    type(pair_t), intent(in) :: pair !! the pair

    has_lay = abs(pair%friction%mu(1) - pair%friction%mu(2)) > 0.0_wp
  end function has_lay

  !> Nothing yet.
  pure function empty_sums(n) result(sums)
    integer, intent(in) :: n !! nodes or facets
    type(sums_t) :: sums

    allocate (sums%force(8, n), sums%nodal(3, n), sums%mean(11, n), sums%weight(n), &
      sums%share(3, n), source=0.0_wp)
    allocate (sums%status(n), source=status_off)
  end function empty_sums

  !> What the slave side of a pair feels at nodes and facets.
  pure subroutine find_slave_fields(pair, surface, points, highest, at_nodes, at_facets)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_surface_t), intent(in) :: surface !! its slave side
    type(point_fields_t), intent(in) :: points !! its points
    integer, intent(in) :: highest !! highest node number
    real(wp), intent(out) :: at_nodes(:, :) !! (n_columns, nodes) fields
    real(wp), intent(out) :: at_facets(:, :) !! (n_columns, facets and lone nodes) fields
    type(sums_t) :: nodes, facets
    integer :: place(highest), p, b, n
    real(wp) :: weight(3)

    place = places(surface%nodes, highest)
    nodes = empty_sums(size(surface%nodes))
    facets = empty_sums(size(surface%facets, 2))
    n = count_points(pair)/pair%points%slots
    do p = 1, count_points(pair)
      if (points%facet(p) < 0) cycle
      weight = 0.0_wp
      weight(1) = 1.0_wp
      if (pair%points%n_slaves > 1) weight = corner_weights(pair, p)
      do b = 1, min(3, pair%points%n_slaves)
        associate (i => place(pair%points%point_nodes(b, p)))
          call add_force(points, p, weight(b), nodes, i)
          if (p <= n) call add_means(points, p, n, weight(b), nodes, i)
        end associate
      end do
      do b = 1, pair%points%n_slaves
        associate (force => nodes%nodal(:, place(pair%points%point_nodes(b, p))))
          force = force + pair%points%point_weights(b, p)*points%traction(:, p)
        end associate
      end do
      if (points%facet(p) == 0) cycle
      call add_force(points, p, 1.0_wp, facets, points%facet(p))
      if (p <= n) call add_means(points, p, n, 1.0_wp, facets, points%facet(p))
    end do
    call to_fields(nodes, surface%node_area, at_nodes)
    call fill_middles(surface, at_nodes)
    if (pair%form == form_quadrature_to_surface) then
      call to_fields(facets, surface%facet_area, at_facets(:, :size(surface%facets, 2)))
    else
      call average_corners(surface, nodes, at_nodes, at_facets)
    end if
    if (.not. has_lay(pair)) then
      at_nodes(at_lay:at_lay + 2, :) = 0.0_wp
      at_facets(at_lay:at_lay + 2, :) = 0.0_wp
    end if
  end subroutine find_slave_fields

  !> Of the slots of a point the one with the smallest gap.
  pure integer function nearest_slot(points, p, n) result(nearest)
    type(point_fields_t), intent(in) :: points !! the points of a pair
    integer, intent(in) :: p !! a first slot
    integer, intent(in) :: n !! number of first slots
    integer :: q

    nearest = p
    do q = p + n, size(points%target), n
      if (points%target(q) == 0) cycle
      if (points%target(nearest) > 0) then
        if (points%gap(q) >= points%gap(nearest)) cycle
      end if
      nearest = q
    end do
  end function nearest_slot

  !> Adds a share of the force, energy and status of a point.
  pure subroutine add_force(points, p, share, sums, i)
    type(point_fields_t), intent(in) :: points !! the points of a pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: share !! its share
    type(sums_t), intent(inout) :: sums !! the sums
    integer, intent(in) :: i !! node or facet that gets it

    associate (f => points%traction(:, p), normal => points%normal_force(p))
      sums%force(:, i) = sums%force(:, i) + share*[normal, f, f - normal*points%normal(:, p), &
        points%dissipation(p)]
    end associate
    if (points%target(p) > 0) sums%status(i) = max(sums%status(i), points%status(p))
  end subroutine add_force

  !> Adds what a point says of the area around it: of its slots the nearest to the master counts,
  !! for gap, slip and lay if it is near; the sign of the lay is free.
  pure subroutine add_means(points, first, n, share, sums, i)
    type(point_fields_t), intent(in) :: points !! the points of a pair
    integer, intent(in) :: first !! first slot of the point
    integer, intent(in) :: n !! number of first slots
    real(wp), intent(in) :: share !! its share
    type(sums_t), intent(inout) :: sums !! the sums
    integer, intent(in) :: i !! node or facet that gets it
    real(wp) :: weight
    integer :: p

    p = nearest_slot(points, first, n)
    weight = share*points%area(p)
    sums%share(1, i) = sums%share(1, i) + weight
    if (points%target(p) == 0) return
    if (points%status(p) == status_stick) sums%share(2, i) = sums%share(2, i) + weight
    if (points%status(p) == status_slip) sums%share(3, i) = sums%share(3, i) + weight
    sums%weight(i) = sums%weight(i) + weight
    sums%mean(:4, i) = sums%mean(:4, i) + weight*[points%gap(p), points%slip(:, p)]
    sums%mean(8:11, i) = sums%mean(8:11, i) + weight*[points%way(:, p), points%path(p)]
    associate (lay => sums%mean(5:7, i))
      lay = lay + sign(weight, dot_product(lay, points%lay(:, p)))*points%lay(:, p)
    end associate
  end subroutine add_means

  !> What middles of edges get: what lies half way between the ends; status is the larger one.
  pure subroutine fill_middles(surface, fields)
    type(contact_surface_t), intent(in) :: surface !! the surface
    real(wp), intent(inout) :: fields(:, :) !! (n_columns, nodes) those of corners given
    real(wp) :: force(3)
    integer :: f, k

    do f = 1, size(surface%facets, 2)
      if (surface%middles(1, f) == 0) cycle
      do k = 1, 3
        associate (middle => fields(:, surface%middles(k, f)), &
                   a => fields(:, surface%facets(k, f)), &
                   b => fields(:, surface%facets(mod(k, 3) + 1, f)))
          force = middle(at_force:at_force + 2)
          middle = 0.5_wp*(a + b)
          middle(at_force:at_force + 2) = force
          middle(at_status) = max(a(at_status), b(at_status))
          associate (p => a(at_lay:at_lay + 2), q => b(at_lay:at_lay + 2))
            middle(at_lay:at_lay + 2) = unit_vector(p + sign(1.0_wp, dot_product(p, q))*q)
          end associate
        end associate
      end do
    end do
  end subroutine fill_middles

  !> Fields from sums: forces over areas, and means. Not a number says that there is no area, or no
  !! master.
  pure subroutine to_fields(sums, area, fields)
    type(sums_t), intent(in) :: sums !! at nodes or facets
    real(wp), intent(in) :: area(:) !! (n) reference areas [length^2]
    real(wp), intent(out) :: fields(:, :) !! (n_columns, n) the fields
    integer :: i

    fields = ieee_value(1.0_wp, ieee_quiet_nan)
    do i = 1, size(area)
      fields(at_status, i) = sums%status(i)
      fields(at_force:at_force + 2, i) = sums%nodal(:, i)
      fields(at_lay:at_lay + 2, i) = 0.0_wp
      if (area(i) > 0.0_wp) then
        fields(at_pressure, i) = sums%force(1, i)/area(i)
        fields(at_traction:at_traction + 2, i) = sums%force(2:4, i)/area(i)
        fields(at_shear:at_shear + 2, i) = sums%force(5:7, i)/area(i)
        fields(at_energy, i) = sums%force(8, i)/area(i)
      end if
      if (sums%share(1, i) > 0.0_wp) fields([at_stick, at_slipping], i) = sums%share(2:3, i) &
        /sums%share(1, i)
      if (sums%weight(i) <= 0.0_wp) cycle
      fields(at_gap, i) = sums%mean(1, i)/sums%weight(i)
      fields(at_slip:at_slip + 2, i) = sums%mean(2:4, i)/sums%weight(i)
      fields(at_lay:at_lay + 2, i) = unit_vector(sums%mean(5:7, i))
      fields(at_way:at_path, i) = sums%mean(8:11, i)/sums%weight(i)
    end do
  end subroutine to_fields

  !> A vector of length 1, or zero.
  pure function unit_vector(v) result(u)
    real(wp), intent(in) :: v(3) !! any vector
    real(wp) :: u(3), length

    length = norm2(v)
    u = v
    if (length > 0.0_wp) u = v/length
  end function unit_vector

  !> The mean direction of the lay at the corners of a facet, whose signs are free.
  pure function mean_lay(lay) result(mean)
    real(wp), intent(in) :: lay(3, 3) !! a column a corner
    real(wp) :: mean(3)
    integer :: k

    mean = 0.0_wp
    do k = 1, 3
      mean = mean + sign(1.0_wp, dot_product(mean, lay(:, k)))*lay(:, k)
    end do
    mean = unit_vector(mean)
  end function mean_lay

  !> Fields of facets, and of nodes that stand alone, from those of nodes: means over the corners.
  pure subroutine average_corners(surface, nodes, at_nodes, at_facets)
    type(contact_surface_t), intent(in) :: surface !! the surface
    type(sums_t), intent(in) :: nodes !! sums at its nodes
    real(wp), intent(in) :: at_nodes(:, :) !! (n_columns, nodes) fields
    real(wp), intent(out) :: at_facets(:, :) !! (n_columns, facets and lone nodes) fields
    integer :: f, n

    n = size(surface%facets, 2)
    do f = 1, n
      associate (corners => surface%facets(:, f))
        at_facets(:, f) = sum(at_nodes(:, corners), 2)/3.0_wp
        at_facets(at_status, f) = maxval(nodes%status(corners))
        at_facets(at_lay:at_lay + 2, f) = mean_lay(at_nodes(at_lay:at_lay + 2, corners))
      end associate
    end do
    at_facets(:, n + 1:) = at_nodes(:, surface%lone)
  end subroutine average_corners

  !> What the master side of a pair feels at nodes and facets: the opposite of the forces on the
  !! slave points, which act at the apexes of their cones.
  pure subroutine find_master_fields(pair, surface, points, x, at_nodes, at_facets)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_surface_t), intent(in) :: surface !! its master side
    type(point_fields_t), intent(in) :: points !! its points
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(out) :: at_nodes(:, :) !! (n_columns, nodes) fields
    real(wp), intent(out) :: at_facets(:, :) !! (n_columns, facets) fields
    type(sums_t) :: nodes, facets
    real(wp) :: shape(3)
    integer :: p, k

    nodes = empty_sums(size(surface%nodes))
    facets = empty_sums(size(surface%facets, 2))
    do p = 1, size(points%target)
      if (points%target(p) == 0) cycle
      shape = [points%apex(:, p), 1.0_wp - sum(points%apex(:, p))]
      do k = 1, 3
        call add_force(points, p, -shape(k), nodes, surface%facets(k, points%target(p)))
      end do
      call add_nodal(pair, surface, points, p, x, nodes)
      call add_force(points, p, -1.0_wp, facets, points%target(p))
    end do
    nodes%force(1, :) = -nodes%force(1, :)
    facets%force(1, :) = -facets%force(1, :)
    call to_fields(nodes, surface%node_area, at_nodes)
    call to_fields(facets, surface%facet_area, at_facets)
    at_nodes(at_energy, :) = ieee_value(1.0_wp, ieee_quiet_nan)
    at_facets(at_energy, :) = ieee_value(1.0_wp, ieee_quiet_nan)
    call take_master_lay(pair, surface, x, at_nodes, at_facets)
    call fill_middles(surface, at_nodes)
  end subroutine find_master_fields

  !> Adds the force of a point to the nodes of its master facet, by their shape functions at the
  !! apex.
  pure subroutine add_nodal(pair, surface, points, p, x, nodes)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_surface_t), intent(in) :: surface !! its master side
    type(point_fields_t), intent(in) :: points !! its points
    integer, intent(in) :: p !! a point with a target
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    type(sums_t), intent(inout) :: nodes !! gets nodal
    real(wp) :: shape(6)
    integer :: list(6), n, k
    type(facet_shapes_t) :: s

    associate (f => points%target(p), apex => points%apex(:, p))
      n = 3
      list(:3) = surface%facets(:, f)
      shape(:3) = [apex, 1.0_wp - sum(apex)]
      if (surface%middles(1, f) > 0) then
        n = 6
        list(4:) = surface%middles(:, f)
        s = facet_shapes(apex, facet_kind(pair, f), x(:, surface%nodes(list)))
        shape = s%n
      end if
      do k = 1, n
        nodes%nodal(:, list(k)) = nodes%nodal(:, list(k)) - shape(k)*points%traction(:, p)
      end do
    end associate
  end subroutine add_nodal

  !> The lay of the master side.
  pure subroutine take_master_lay(pair, surface, x, at_nodes, at_facets)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_surface_t), intent(in) :: surface !! its master side
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(inout) :: at_nodes(:, :) !! (n_columns, nodes) fields
    real(wp), intent(inout) :: at_facets(:, :) !! (n_columns, facets) fields
    real(wp), allocatable :: lay(:, :)
    integer :: i

    allocate (lay(3, size(x, 2)), source=0.0_wp)
    if (has_lay(pair)) call add_surface_lay(pair, x, lay)
    do i = 1, size(surface%nodes)
      at_nodes(at_lay:at_lay + 2, i) = unit_vector(lay(:, surface%nodes(i)))
    end do
    do i = 1, size(surface%facets, 2)
      at_facets(at_lay:at_lay + 2, i) = mean_lay(at_nodes(at_lay:at_lay + 2, &
        surface%facets(:, i)))
    end do
  end subroutine take_master_lay
end module contact_surfaces

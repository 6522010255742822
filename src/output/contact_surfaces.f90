!> The two surfaces of a contact pair, and what contact does to them at one time: forces of points
!! become tractions of nodes and facets (doc/theory, "Contact as fields").
module contact_surfaces
  use, intrinsic :: ieee_arithmetic, only: ieee_value, ieee_quiet_nan
  use kinds, only: wp
  use vectors, only: cross
  use key_sorting, only: unique_numbers
  use contact_types, only: pair_t, status_off, form_quadrature_to_surface
  use contact_points, only: corner_weights, count_points
  use surface_lay, only: add_surface_lay
  use point_fields, only: point_fields_t
  implicit none
  private
  public :: contact_surface_t, find_slave_surface, find_master_surface, find_slave_fields, &
    find_master_fields
  public :: n_columns, at_pressure, at_traction, at_shear, at_gap, at_status, at_slip, at_energy, &
    at_lay, at_force

  !> Places of the fields in a column: those with three components begin there. The force has a
  !! meaning at nodes only.
  integer, parameter :: at_pressure = 1, at_traction = 2, at_shear = 5, at_gap = 8, &
    at_status = 9, at_slip = 10, at_energy = 13, at_lay = 14, at_force = 17, n_columns = 19

  !> One side of a pair.
  type :: contact_surface_t
    integer, allocatable :: nodes(:) !! its nodes, by the numbers of the deck
    integer, allocatable :: facets(:, :) !! (3, facets) places in nodes, seen from outside
    integer, allocatable :: lone(:) !! places in nodes of those that no facet holds
    real(wp), allocatable :: node_area(:) !! (nodes) a third of the facets around it, reference
    real(wp), allocatable :: facet_area(:) !! (facets) reference area
  end type contact_surface_t

  !> Sums over contact points at nodes or facets.
  type :: sums_t
    real(wp), allocatable :: force(:, :) !! (8, n) normal force, force, its shear part, energy
    real(wp), allocatable :: mean(:, :) !! (7, n) gap, slip, lay, each times its weight
    real(wp), allocatable :: weight(:) !! (n) sum of these weights
    integer, allocatable :: status(:) !! (n) largest status
  end type sums_t

contains

  !> The slave side of a pair; slave nodes without a facet stand alone.
  pure subroutine find_slave_surface(pair, x, surface)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(contact_surface_t), intent(out) :: surface !! the surface
    integer, allocatable :: facets(:, :), nodes(:)
    logical, allocatable :: chosen(:)

    if (allocated(pair%points%slave_facets)) then
      facets = pair%points%slave_facets
    else if (pair%form == form_quadrature_to_surface) then
      facets = pair%points%point_nodes(:3, 1:count_points(pair)/pair%points%slots:pair%facet_points)
    else
      allocate (facets(3, 0))
    end if
    allocate (chosen(size(x, 2)), source=.false.)
    if (pair%form /= form_quadrature_to_surface) chosen(pair%points%point_nodes(1, :)) = .true.
    nodes = reshape(facets, [size(facets)])
    chosen(nodes) = .true.
    call fill_surface(facets, chosen, x, surface)
  end subroutine find_slave_surface

  !> The master side of a pair.
  pure subroutine find_master_surface(pair, x, surface)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(contact_surface_t), intent(out) :: surface !! the surface
    logical, allocatable :: chosen(:)
    integer, allocatable :: nodes(:)

    allocate (chosen(size(x, 2)), source=.false.)
    nodes = reshape(pair%surface%facets, [size(pair%surface%facets)])
    chosen(nodes) = .true.
    call fill_surface(pair%surface%facets, chosen, x, surface)
  end subroutine find_master_surface

  !> Nodes, facets and areas.
  pure subroutine fill_surface(facets, chosen, x, surface)
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    logical, intent(in) :: chosen(:) !! (nodes) which belong to the surface
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(contact_surface_t), intent(inout) :: surface !! gets everything
    integer, allocatable :: place(:)
    integer :: i, f

    surface%nodes = unique_numbers(chosen)
    place = places(surface%nodes, size(chosen))
    allocate (surface%facets(3, size(facets, 2)), surface%facet_area(size(facets, 2)))
    allocate (surface%node_area(size(surface%nodes)), source=0.0_wp)
    do f = 1, size(facets, 2)
      associate (corners => facets(:, f))
        surface%facets(:, f) = place(corners)
        surface%facet_area(f) = 0.5_wp*norm2(cross(x(:, corners(1)) - x(:, corners(3)), &
          x(:, corners(2)) - x(:, corners(3))))
        do i = 1, 3
          associate (area => surface%node_area(place(corners(i))))
            area = area + surface%facet_area(f)/3.0_wp
          end associate
        end do
      end associate
    end do
    surface%lone = unique_numbers(surface%node_area <= 0.0_wp)
  end subroutine fill_surface

  !> Where each node stands in a list, 0 for those that are not in it.
  pure function places(nodes, highest) result(place)
    integer, intent(in) :: nodes(:) !! the list
    integer, intent(in) :: highest !! highest node number
    integer :: place(highest)
    integer :: i

    place = 0
    do i = 1, size(nodes)
      place(nodes(i)) = i
    end do
  end function places

  !> Friction of the pair has a direction.
  pure logical function has_lay(pair)
    type(pair_t), intent(in) :: pair !! the pair

    has_lay = abs(pair%friction%mu(1) - pair%friction%mu(2)) > 0.0_wp
  end function has_lay

  !> Nothing yet.
  pure function empty_sums(n) result(sums)
    integer, intent(in) :: n !! nodes or facets
    type(sums_t) :: sums

    allocate (sums%force(8, n), sums%mean(7, n), sums%weight(n), source=0.0_wp)
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
          if (p <= n) call add_means(points, nearest_slot(points, p, n), weight(b), nodes, i)
        end associate
      end do
      if (points%facet(p) == 0) cycle
      call add_force(points, p, 1.0_wp, facets, points%facet(p))
      if (p <= n) call add_means(points, nearest_slot(points, p, n), 1.0_wp, facets, &
        points%facet(p))
    end do
    call to_fields(nodes, surface%node_area, at_nodes)
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
    do q = p + n, size(points%host), n
      if (points%host(q) == 0) cycle
      if (points%host(nearest) > 0) then
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
    if (points%host(p) > 0) sums%status(i) = max(sums%status(i), points%status(p))
  end subroutine add_force

  !> Adds gap, slip and lay of a point that is near the master; the sign of the lay is free.
  pure subroutine add_means(points, p, share, sums, i)
    type(point_fields_t), intent(in) :: points !! the points of a pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: share !! its share
    type(sums_t), intent(inout) :: sums !! the sums
    integer, intent(in) :: i !! node or facet that gets it
    real(wp) :: weight

    if (points%host(p) == 0) return
    weight = share*points%area(p)
    sums%weight(i) = sums%weight(i) + weight
    sums%mean(:4, i) = sums%mean(:4, i) + weight*[points%gap(p), points%slip(:, p)]
    associate (lay => sums%mean(5:7, i))
      lay = lay + sign(weight, dot_product(lay, points%lay(:, p)))*points%lay(:, p)
    end associate
  end subroutine add_means

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
      fields(at_force:at_force + 2, i) = sums%force(2:4, i)
      fields(at_lay:at_lay + 2, i) = 0.0_wp
      if (area(i) > 0.0_wp) then
        fields(at_pressure, i) = sums%force(1, i)/area(i)
        fields(at_traction:at_traction + 2, i) = sums%force(2:4, i)/area(i)
        fields(at_shear:at_shear + 2, i) = sums%force(5:7, i)/area(i)
        fields(at_energy, i) = sums%force(8, i)/area(i)
      end if
      if (sums%weight(i) <= 0.0_wp) cycle
      fields(at_gap, i) = sums%mean(1, i)/sums%weight(i)
      fields(at_slip:at_slip + 2, i) = sums%mean(2:4, i)/sums%weight(i)
      fields(at_lay:at_lay + 2, i) = unit_vector(sums%mean(5:7, i))
    end do
  end subroutine to_fields

  !> A vector of length 1, or zero.
  pure function unit_vector(v) result(u)
    real(wp), intent(in) :: v(3) !! any vector
    real(wp) :: u(3)

    u = v
    if (norm2(v) > 0.0_wp) u = v/norm2(v)
  end function unit_vector

  !> Fields of facets, and of nodes that stand alone, from those of nodes: means over the corners.
  pure subroutine average_corners(surface, nodes, at_nodes, at_facets)
    type(contact_surface_t), intent(in) :: surface !! the surface
    type(sums_t), intent(in) :: nodes !! sums at its nodes
    real(wp), intent(in) :: at_nodes(:, :) !! (n_columns, nodes) fields
    real(wp), intent(out) :: at_facets(:, :) !! (n_columns, facets and lone nodes) fields
    integer :: f, n, k
    real(wp) :: v(3)

    n = size(surface%facets, 2)
    do f = 1, n
      associate (corners => surface%facets(:, f))
        at_facets(:, f) = sum(at_nodes(:, corners), 2)/3.0_wp
        at_facets(at_status, f) = maxval(nodes%status(corners))
        v = 0.0_wp
        do k = 1, 3
          associate (lay => at_nodes(at_lay:at_lay + 2, corners(k)))
            v = v + sign(1.0_wp, dot_product(v, lay))*lay
          end associate
        end do
        at_facets(at_lay:at_lay + 2, f) = unit_vector(v)
      end associate
    end do
    at_facets(:, n + 1:) = at_nodes(:, surface%lone)
  end subroutine average_corners

  !> What the master side of a pair feels at nodes and facets: the opposite of the forces on the
  !! slave points, which act at the tips of their cones.
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
    do p = 1, size(points%host)
      if (points%host(p) == 0) cycle
      shape = [points%tip(:, p), 1.0_wp - sum(points%tip(:, p))]
      do k = 1, 3
        call add_force(points, p, -shape(k), nodes, surface%facets(k, points%host(p)))
      end do
      call add_force(points, p, -1.0_wp, facets, points%host(p))
    end do
    nodes%force(1, :) = -nodes%force(1, :)
    facets%force(1, :) = -facets%force(1, :)
    call to_fields(nodes, surface%node_area, at_nodes)
    call to_fields(facets, surface%facet_area, at_facets)
    at_nodes(at_energy, :) = ieee_value(1.0_wp, ieee_quiet_nan)
    at_facets(at_energy, :) = ieee_value(1.0_wp, ieee_quiet_nan)
    call take_master_lay(pair, surface, x, at_nodes, at_facets)
  end subroutine find_master_fields

  !> The lay of the master side.
  pure subroutine take_master_lay(pair, surface, x, at_nodes, at_facets)
    type(pair_t), intent(in) :: pair !! the pair
    type(contact_surface_t), intent(in) :: surface !! its master side
    real(wp), intent(in) :: x(:, :) !! (3, nodes) current positions [length]
    real(wp), intent(inout) :: at_nodes(:, :) !! (n_columns, nodes) fields
    real(wp), intent(inout) :: at_facets(:, :) !! (n_columns, facets) fields
    real(wp), allocatable :: lay(:, :)
    real(wp) :: v(3)
    integer :: i, k

    allocate (lay(3, size(x, 2)), source=0.0_wp)
    if (has_lay(pair)) call add_surface_lay(pair, x, lay)
    do i = 1, size(surface%nodes)
      at_nodes(at_lay:at_lay + 2, i) = unit_vector(lay(:, surface%nodes(i)))
    end do
    do i = 1, size(surface%facets, 2)
      v = 0.0_wp
      do k = 1, 3
        associate (corner => lay(:, surface%nodes(surface%facets(k, i))))
          v = v + sign(1.0_wp, dot_product(v, corner))*unit_vector(corner)
        end associate
      end do
      at_facets(at_lay:at_lay + 2, i) = unit_vector(v)
    end do
  end subroutine take_master_lay
end module contact_surfaces

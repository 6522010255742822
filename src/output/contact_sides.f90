!> The two surfaces of a contact pair: their nodes, facets and areas.
module contact_sides
  use kinds, only: wp
  use cells, only: tet10, has_middles, facet_of
  use key_sorting, only: unique_numbers
  use mesh_types, only: mesh_t
  use contact_types, only: pair_t, form_quadrature_to_surface
  use contact_points, only: count_points
  use facet_geometry, only: facet_area
  implicit none
  private
  public :: contact_surface_t, find_slave_surface, find_master_surface, places

  !> One side of a pair.
  type :: contact_surface_t
    integer, allocatable :: nodes(:) !! its nodes, by the numbers of the deck
    integer, allocatable :: facets(:, :) !! (3, facets) places in nodes, seen from outside
    integer, allocatable :: middles(:, :) !! (3, facets) likewise of the nodes on the edges 12, 23,
    !! 31; 0 where an edge has none
    integer, allocatable :: lone(:) !! places in nodes of those that no facet holds
    real(wp), allocatable :: node_area(:) !! (nodes) a third of the facets around it, reference
    real(wp), allocatable :: facet_area(:) !! (facets) reference area
  end type contact_surface_t

contains

  !> The slave side of a pair; slave nodes without a facet stand alone.
  pure subroutine find_slave_surface(pair, mesh, surface)
    type(pair_t), intent(in) :: pair !! the pair
    type(mesh_t), intent(in) :: mesh !! the mesh
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
    allocate (chosen(size(mesh%x, 2)), source=.false.)
    if (pair%form /= form_quadrature_to_surface) chosen(pair%points%point_nodes(1, :)) = .true.
    nodes = reshape(facets, [size(facets)])
    chosen(nodes) = .true.
    call fill_surface(facets, chosen, mesh, surface)
  end subroutine find_slave_surface

  !> The master side of a pair.
  pure subroutine find_master_surface(pair, mesh, surface)
    type(pair_t), intent(in) :: pair !! the pair
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(contact_surface_t), intent(out) :: surface !! the surface
    logical, allocatable :: chosen(:)
    integer, allocatable :: nodes(:)

    allocate (chosen(size(mesh%x, 2)), source=.false.)
    nodes = reshape(pair%surface%facets, [size(pair%surface%facets)])
    chosen(nodes) = .true.
    call fill_surface(pair%surface%facets, chosen, mesh, surface)
  end subroutine find_master_surface

  !> Nodes, facets and areas.
  pure subroutine fill_surface(facets, corner, mesh, surface)
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    logical, intent(in) :: corner(:) !! (nodes) which belong to the surface, without middles
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(contact_surface_t), intent(inout) :: surface !! gets everything
    integer, allocatable :: place(:), middles(:, :)
    logical :: chosen(size(corner))
    integer :: i, f

    call find_middles(facets, corner, mesh, middles)
    chosen = corner
    chosen(pack(middles, middles > 0)) = .true.
    surface%nodes = unique_numbers(chosen)
    place = places(surface%nodes, size(chosen))
    allocate (surface%facets(3, size(facets, 2)), surface%facet_area(size(facets, 2)), &
      surface%middles(3, size(facets, 2)))
    allocate (surface%node_area(size(surface%nodes)), source=0.0_wp)
    surface%middles = 0
    do f = 1, size(facets, 2)
      associate (corners => facets(:, f))
        surface%facets(:, f) = place(corners)
        if (middles(1, f) > 0) surface%middles(:, f) = place(middles(:, f))
        surface%facet_area(f) = facet_area(mesh%x(:, corners))
        do i = 1, 3
          associate (area => surface%node_area(place(corners(i))))
            area = area + surface%facet_area(f)/3.0_wp
          end associate
        end do
      end associate
    end do
    surface%lone = pack([(i, i=1, size(surface%nodes))], surface%node_area <= 0.0_wp .and. &
      corner(surface%nodes))
  end subroutine fill_surface

  !> The nodes on the edges of facets, from the elements of ten nodes that have them.
  pure subroutine find_middles(facets, corner, mesh, middles)
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    logical, intent(in) :: corner(:) !! (nodes) corners of facets are among these
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, allocatable, intent(out) :: middles(:, :) !! (3, facets) nodes, zeros without
    integer :: first(size(corner)), next(size(facets, 2)), nodes(6), e, k, f

    allocate (middles(3, size(facets, 2)), source=0)
    if (size(mesh%ix, 1) < tet10%nodes) return
    ! the facets of each node that is their lowest corner
    first = 0
    do f = 1, size(facets, 2)
      k = minval(facets(:, f))
      next(f) = first(k)
      first(k) = f
    end do
    do e = 1, mesh%elements
      if (.not. has_middles(mesh%ix(:, e))) cycle
      if (count(corner(mesh%ix(:4, e))) < 3) cycle
      do k = 1, 4
        associate (three => mesh%ix(tet10%facet(:3, k), e))
          f = first(minval(three))
          do while (f > 0)
            if (sum(facets(:, f)) == sum(three) .and. maxval(facets(:, f)) == maxval(three)) then
              nodes = facet_of(mesh%ix(:, e), facets(:, f))
              middles(:, f) = nodes(4:6)
            end if
            f = next(f)
          end do
        end associate
      end do
    end do
  end subroutine find_middles

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
end module contact_sides

!> The two sides of a contact pair: facets of the master, nodes or facets of the slave.
module pair_sides
  use kinds, only: wp
  use text, only: to_text, count_noun, in_quotes
  use diagnostics, only: diagnostics_t, report_error, report_note
  use deck_types, only: location_t
  use key_sorting, only: sort_columns, ascending
  use cells, only: has_middles, most_facet_nodes, facet_of
  use mesh_types, only: mesh_t
  use mesh_names, only: find_nodes, find_surface, find_region
  use facets, only: facet_table_t, facet_neighbours, tributary_areas
  use contact_types, only: pair_t, pair_points_t, master_surface_t
  use contact_points, only: count_points, make_node_points, make_facet_points
  use node_queries, only: report_unknown_name
  implicit none
  private
  public :: take_master, take_slave, take_slave_facets, check_common_facets

  !> Least points of a slave facet of six nodes: fewer leave patterns of its motion unseen.
  integer, parameter :: least_points = 6
  !> Curved facets, in words.
  character(*), parameter :: six_nodes = 'facets of six nodes (elements of ten)', &
    round_facets = 'exact cylinders and spheres'

contains

  !> The master must be a surface.
  subroutine take_master(mesh, diagnostics, pair, found)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    logical, intent(out) :: found !! the master is known
    integer :: index, non_manifold

    call find_facets(mesh, 'master', pair%master, pair%master_at, diagnostics, index)
    found = index > 0
    if (.not. found) return
    pair%surface%facets = mesh%surfaces(index)%facets
    pair%surface%facet_elements = mesh%surfaces(index)%elements
    if (all(pair%surface%facet_elements > 0)) call order_facets(mesh, pair%surface)
    pair%surface%exact = mesh%surfaces(index)%exact
    pair%surface%round = allocated(mesh%surfaces(index)%inner)
    if (pair%surface%round) then
      pair%surface%middles = mesh%surfaces(index)%inner
      call check_curved(pair, pair%master_at, round_facets, diagnostics)
    else
      call take_middles(mesh, pair%surface%facets, pair%surface%facet_elements, &
        pair%surface%middles)
      if (allocated(pair%surface%middles)) call check_curved(pair, pair%master_at, six_nodes, &
        diagnostics)
    end if
    call facet_neighbours(pair%surface%facets, pair%surface%neighbours, non_manifold)
    if (non_manifold == 0) return
    call report_note(diagnostics, pair%master_at, 'the master '''//pair%master//''' has '// &
      count_noun(non_manifold, 'edge')//' with more than two facets; a node that slides over '// &
      'one of them is searched anew')
  end subroutine take_master

  !> Facets in the order of the elements behind them: which of several is taken for a point on
  !! their edge must not depend on the numbers of nodes (doc/theory, "Exact closure").
  pure subroutine order_facets(mesh, surface)
    type(mesh_t), intent(in) :: mesh !! elements
    type(master_surface_t), intent(inout) :: surface !! facets and facet_elements in that order
    integer :: keys(2, size(surface%facet_elements)), f, k
    integer, allocatable :: order(:)

    keys = 0
    do f = 1, size(keys, 2)
      keys(1, f) = surface%facet_elements(f)
      do k = 1, 4
        if (all(surface%facets(:, f) /= mesh%ix(k, keys(1, f)))) keys(2, f) = k
      end do
    end do
    call sort_columns(keys, order)
    surface%facets = surface%facets(:, order)
    surface%facet_elements = surface%facet_elements(order)
  end subroutine order_facets

  !> The surface of one side; what is none is reported.
  subroutine find_facets(mesh, side, name, at, diagnostics, index)
    type(mesh_t), intent(in) :: mesh !! the mesh
    character(*), intent(in) :: side !! slave or master
    character(*), intent(in) :: name !! of the surface
    type(location_t), intent(in) :: at !! where the deck names it
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer, intent(out) :: index !! into mesh%surfaces, 0 if it is no surface
    integer, allocatable :: nodes(:)
    logical :: found

    call find_surface(mesh, name, index)
    if (index > 0) return
    call find_nodes(mesh, name, nodes, found)
    if (found) then
      call report_error(diagnostics, at, 'the '//side//' '''//name//''' is no surface', &
        'define one: SURFace name FROM '//in_quotes(name)//'; only the slave of NTOS may be a set')
    else
      call report_unknown_name(mesh, at, name, diagnostics)
    end if
  end subroutine find_facets

  !> The nodes in the middle of the edges 12, 23, 31 of facets; not allocated if there are none.
  pure subroutine take_middles(mesh, facets, elements, middles)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    integer, intent(in) :: elements(:) !! (facets) elements behind them
    integer, allocatable, intent(out) :: middles(:, :) !! (3, facets) zeros where an edge has none
    integer :: f, nodes(most_facet_nodes)

    if (any(elements == 0)) return
    if (.not. any([(has_middles(mesh%ix(:, elements(f))), f=1, size(elements))])) return
    allocate (middles(3, size(facets, 2)))
    do f = 1, size(facets, 2)
      nodes = facet_of(mesh%ix(:, elements(f)), facets(:, f))
      middles(:, f) = nodes(4:6)
    end do
  end subroutine take_middles

  !> What curved facets cannot do in this version, or need not.
  subroutine check_curved(pair, at, facets, diagnostics)
    type(pair_t), intent(in) :: pair !! the pair
    type(location_t), intent(in) :: at !! where the deck names the surface
    character(*), intent(in) :: facets !! what they are
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: name

    name = 'pair '//pair%name//': '
    if (pair%smooth) call report_error(diagnostics, at, name//'SMOOth bends flat facets, and '// &
      facets//' are curved by themselves', 'delete SMOOth')
    if (pair%fit%adjusted) call report_error(diagnostics, at, name//'ADJUst does not know '// &
      facets//' in this version', 'close the gaps in the mesh')
  end subroutine check_curved

  !> A surface with nothing behind it has no stiffness to give its points.
  subroutine check_slave(mesh, pair, index, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: index !! of its slave among the surfaces, 0 if it is none
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (index == 0) return
    if (mesh%surfaces(index)%alone) call report_error(diagnostics, pair%slave_at, 'the slave '''// &
      pair%slave//''' has no elements behind it: it is rigid, and can be master only', &
      'name the other surface first')
  end subroutine check_slave

  !> Quadrature points of the slave facets and their areas.
  subroutine take_slave_facets(mesh, diagnostics, pair, found)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    logical, intent(out) :: found !! the slave is a surface
    integer, allocatable :: facets(:, :), middles(:, :), six(:, :)
    integer :: index, non_manifold

    call find_facets(mesh, 'slave', pair%slave, pair%slave_at, diagnostics, index)
    found = index > 0
    if (.not. found) return
    call check_slave(mesh, pair, index, diagnostics)
    facets = mesh%surfaces(index)%facets
    call take_middles(mesh, facets, mesh%surfaces(index)%elements, middles)
    if (allocated(middles)) then
      call check_curved(pair, pair%slave_at, six_nodes, diagnostics)
      if (pair%facet_points < least_points .and. .not. pair%segmented) call report_note( &
        diagnostics, pair%slave_at, 'pair '//pair%name//': facets of six nodes have '// &
        to_text(least_points)//' points each')
      pair%facet_points = max(pair%facet_points, least_points)
      allocate (six(6, size(facets, 2)))
      six(1:3, :) = facets
      six(4:6, :) = middles
      call move_alloc(six, facets)
    end if
    call make_facet_points(facets, mesh%x, pair)
    if (pair%smooth) then
      pair%points%side%facets = mesh%surfaces(index)%facets
      call facet_neighbours(pair%points%side%facets, pair%points%side%neighbours, non_manifold)
    end if
    if (pair%segmented) call keep_facets(mesh%x, mesh%surfaces(index)%facets, middles, pair%points)
  end subroutine take_slave_facets

  !> The slave facets that are to be cut.
  pure subroutine keep_facets(x, facets, middles, points)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    integer, allocatable, intent(in) :: middles(:, :) !! (3, facets) middles of the edges, if any
    type(pair_points_t), intent(inout) :: points !! gets slave facets, middles, shape
    integer :: f

    points%slave_facets = facets
    if (.not. allocated(middles)) return
    points%slave_middles = middles
    allocate (points%slave_shape(3, 6, size(facets, 2)), source=0.0_wp)
    do f = 1, size(facets, 2)
      if (middles(1, f) > 0) points%slave_shape(:, :, f) = x(:, [facets(:, f), middles(:, f)])
    end do
  end subroutine keep_facets

  !> Slave nodes and their tributary areas.
  subroutine take_slave(mesh, exterior, diagnostics, pair, found)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    logical, intent(out) :: found !! the slave is known
    real(wp), allocatable :: area(:)
    integer, allocatable :: nodes(:)
    integer :: index

    call find_nodes(mesh, pair%slave, nodes, found)
    if (.not. found) then
      call report_unknown_name(mesh, pair%slave_at, pair%slave, diagnostics)
      return
    end if
    if (size(elements_at(mesh, nodes)) > 0) call report_error(diagnostics, pair%slave_at, &
      'the slave '''//pair%slave//''' has nodes of elements of ten nodes, whose corners carry '// &
      'no force of an even pressure', 'write GTOS '//in_quotes(pair%slave)//' '// &
      in_quotes(pair%master)// &
      ' in place of NTOS; its slave is a surface')
    call find_surface(mesh, pair%slave, index)
    call check_slave(mesh, pair, index, diagnostics)
    if (index > 0) then
      pair%points%slave_facets = mesh%surfaces(index)%facets
    else
      pair%points%slave_facets = facets_within(mesh, exterior, nodes)
    end if
    call tributary_areas(pair%points%slave_facets, mesh%x, area)
    call find_region(mesh, pair%slave, index)
    if (index > 0) nodes = pack(nodes, area(nodes) > 0.0_wp)
    nodes = without_master(nodes, pair, mesh%nodes)
    call make_node_points(nodes, pair)
    pair%points%area = area(nodes)
  end subroutine take_slave

  !> The elements of ten nodes that hold one of the nodes.
  pure function elements_at(mesh, nodes) result(elements)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: nodes(:) !! node numbers
    integer, allocatable :: elements(:)
    logical :: inside(0:mesh%nodes)
    logical, allocatable :: holds(:)
    integer :: e

    inside = .false.
    inside(nodes) = .true.
    allocate (holds(mesh%elements), source=.false.)
    do e = 1, mesh%elements
      if (has_middles(mesh%ix(:, e))) holds(e) = any(inside(mesh%ix(:, e)))
    end do
    elements = pack([(e, e=1, mesh%elements)], holds)
  end function elements_at

  !> The exterior facets whose corners all lie among the nodes.
  pure function facets_within(mesh, exterior, nodes) result(corners)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    integer, intent(in) :: nodes(:) !! node numbers
    integer, allocatable :: corners(:, :)
    logical, allocatable :: inside(:)
    integer :: i, n

    allocate (inside(mesh%nodes), source=.false.)
    inside(nodes) = .true.
    n = 0
    do i = 1, exterior%count
      if (all(inside(exterior%corners(:, i)))) n = n + 1
    end do
    allocate (corners(3, n))
    n = 0
    do i = 1, exterior%count
      if (.not. all(inside(exterior%corners(:, i)))) cycle
      n = n + 1
      corners(:, n) = exterior%corners(:, i)
    end do
  end function facets_within

  !> A facet cannot touch itself; nodes may be on both sides, where a joint ends or a crack.
  subroutine check_common_facets(mesh, pair, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(pair_t), intent(in) :: pair !! the pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer, allocatable :: slave(:, :), keys(:, :), order(:)
    integer :: i, n, m, index, first

    call find_surface(mesh, pair%slave, index)
    if (index > 0) then
      slave = mesh%surfaces(index)%facets
    else
      slave = pair%points%slave_facets
    end if
    n = size(slave, 2)
    m = size(pair%surface%facets, 2)
    allocate (keys(3, n + m))
    do i = 1, n
      keys(:, i) = ascending(slave(:, i))
    end do
    do i = 1, m
      keys(:, n + i) = ascending(pair%surface%facets(:, i))
    end do
    call sort_columns(keys, order)
    first = 0
    m = 0
    do i = 2, size(order)
      if (any(keys(:, order(i)) /= keys(:, order(i - 1)))) cycle
      m = m + 1
      if (first == 0) first = order(i)
    end do
    if (m > 0) call report_error(diagnostics, pair%slave_at, 'slave '''//pair%slave// &
      ''' and master '''//pair%master//''' share '//count_noun(m, 'facet')//', the first has '// &
      'nodes '//to_text(keys(1, first))//' '//to_text(keys(2, first))//' '// &
      to_text(keys(3, first)), 'a facet cannot touch itself: name surfaces that share nodes at '// &
      'most, such as the two faces of a crack')
    if (m == 0 .and. count_points(pair) == 0) call report_error(diagnostics, pair%slave_at, &
      'all nodes of the slave '''//pair%slave//''' are nodes of the master '''//pair%master// &
      ''' as well', 'a node cannot touch a facet that it belongs to: name another slave')
  end subroutine check_common_facets

  !> Nodes that do not belong to the master: a node is always at the place of itself.
  pure function without_master(nodes, pair, last) result(rest)
    integer, intent(in) :: nodes(:) !! slave nodes
    type(pair_t), intent(in) :: pair !! with its master
    integer, intent(in) :: last !! highest number of a node
    integer, allocatable :: rest(:)
    logical :: master(last)

    master = .false.
    if (allocated(pair%surface%facets)) master([pair%surface%facets]) = .true.
    rest = pack(nodes, .not. master(nodes))
  end function without_master
end module pair_sides

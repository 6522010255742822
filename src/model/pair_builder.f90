!> Builds the contact pairs on the complete mesh: slave points, master facets, penalties, lay.
module pair_builder
  use kinds, only: wp
  use text, only: to_text, count_noun
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_types, only: mesh_t
  use mesh_names, only: find_nodes, find_surface, find_region
  use facets, only: facet_table_t, exterior_facets, facet_neighbours, tributary_areas
  use contact_types, only: pair_t, penalty_area, penalty_nodal
  use contact_points, only: count_points, point_text, make_node_points
  use contact_reader, only: pair_draft_t
  use model_types, only: model_t
  use node_queries, only: report_unknown_name
  use lay_directions, only: lay_on_facet, convected_lay
  use penalty_values, only: set_penalties
  implicit none
  private
  public :: build_pairs

contains

  !> Fills model%pairs from what the deck says.
  subroutine build_pairs(drafts, diagnostics, model)
    type(pair_draft_t), intent(in) :: drafts(:) !! the pairs as read
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! mesh and materials; receives the pairs
    type(facet_table_t) :: exterior
    integer :: i

    allocate (model%pairs(size(drafts)))
    if (size(drafts) == 0) return
    call exterior_facets(model%mesh, exterior)
    do i = 1, size(drafts)
      model%pairs(i) = drafts(i)%pair
      if (.not. drafts(i)%has_form) cycle
      call build_pair(drafts(i), exterior, diagnostics, model, model%pairs(i))
    end do
  end subroutine build_pairs

  !> Builds one pair.
  subroutine build_pair(draft, exterior, diagnostics, model, pair)
    type(pair_draft_t), intent(in) :: draft !! the pair as read
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(inout) :: pair !! the pair
    logical :: found_slave, found_master

    call take_master(model%mesh, diagnostics, pair, found_master)
    call take_slave(model%mesh, exterior, diagnostics, pair, found_slave)
    if (.not. (found_slave .and. found_master)) return
    call check_common_nodes(model%mesh, pair, diagnostics)
    call set_lay(draft, model%mesh, diagnostics, pair)
    call take_penalties(model, diagnostics, pair)
    allocate (pair%old(count_points(pair)), pair%new(count_points(pair)))
  end subroutine build_pair

  !> The master must be a surface.
  subroutine take_master(mesh, diagnostics, pair, found)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    logical, intent(out) :: found !! the master is known
    integer, allocatable :: nodes(:)
    integer :: index, non_manifold

    call find_surface(mesh, pair%master, index)
    found = index > 0
    if (.not. found) then
      call find_nodes(mesh, pair%master, nodes, found)
      if (found) then
        call report_error(diagnostics, pair%master_at, 'the master '''//pair%master// &
          ''' is no surface', 'define one: SURFace name FROM '//pair%master)
      else
        call report_unknown_name(mesh, pair%master_at, pair%master, diagnostics)
      end if
      found = .false.
      return
    end if
    pair%facets = mesh%surfaces(index)%facets
    pair%facet_elements = mesh%surfaces(index)%elements
    call facet_neighbours(pair%facets, pair%neighbours, non_manifold)
    if (non_manifold == 0) return
    call report_note(diagnostics, pair%master_at, 'the master '''//pair%master//''' has '// &
      count_noun(non_manifold, 'edge')//' with more than two facets; a node that slides over '// &
      'one of them is searched anew')
  end subroutine take_master

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
    call find_surface(mesh, pair%slave, index)
    if (index > 0) then
      call tributary_areas(mesh%surfaces(index)%facets, mesh%x, area)
    else
      call tributary_areas(facets_within(mesh, exterior, nodes), mesh%x, area)
    end if
    call find_region(mesh, pair%slave, index)
    if (index > 0) nodes = pack(nodes, area(nodes) > 0.0_wp)
    call make_node_points(nodes, pair)
    pair%area = area(nodes)
  end subroutine take_slave

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

  !> A node cannot touch a facet that it belongs to.
  subroutine check_common_nodes(mesh, pair, diagnostics)
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(pair_t), intent(in) :: pair !! the pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical, allocatable :: master(:), common(:)
    integer :: i, n

    allocate (master(mesh%nodes), source=.false.)
    do i = 1, size(pair%facets, 2)
      master(pair%facets(:, i)) = .true.
    end do
    allocate (common(mesh%nodes), source=.false.)
    do i = 1, count_points(pair)
      common(pair%point_nodes(:, i)) = master(pair%point_nodes(:, i))
    end do
    n = count(common)
    if (n == 0) return
    call report_error(diagnostics, pair%slave_at, 'slave '''//pair%slave//''' and master '''// &
      pair%master//''' share '//count_noun(n, 'node')//', the first is '// &
      to_text(first_true(common)), 'name sets that have no node in common')
  end subroutine check_common_nodes

  !> Index of the first true value, 0 if there is none.
  pure integer function first_true(mask) result(first)
    logical, intent(in) :: mask(:) !! any values

    do first = 1, size(mask)
      if (mask(first)) return
    end do
    first = 0
  end function first_true

  !> Checks the lay direction on each master facet, and keeps it where it is convected.
  !!
  !! Isotropic friction needs no direction: it is checked only where the deck gives one, or where
  !! the two coefficients differ.
  subroutine set_lay(draft, mesh, diagnostics, pair)
    type(pair_draft_t), intent(in) :: draft !! the pair as read
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    real(wp) :: p(3)
    integer :: i, n, bad
    logical :: found

    if (.not. (draft%has_direction .or. abs(pair%mu(1) - pair%mu(2)) > 0.0_wp)) return
    if (pair%convected) allocate (pair%lay(2, size(pair%facets, 2)), source=0.0_wp)
    n = 0
    bad = 0
    do i = 1, size(pair%facets, 2)
      associate (corners => pair%facets(:, i))
        call lay_on_facet(pair, mesh%x(:, corners), p, found)
        if (.not. found) then
          if (n == 0) bad = i
          n = n + 1
        else if (pair%convected) then
          pair%lay(:, i) = convected_lay(mesh%x(:, corners), p)
        end if
      end associate
    end do
    if (n > 0) call report_normal_lay(pair, bad, n, diagnostics)
  end subroutine set_lay

  !> The lay direction is normal to `n` facets, of which `facet` is the first.
  subroutine report_normal_lay(pair, facet, n, diagnostics)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: facet !! first facet
    integer, intent(in) :: n !! number of facets
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    character(:), allocatable :: more

    more = ''
    if (n > 1) more = ' and to '//count_noun(n - 1, 'other facet')
    call report_error(diagnostics, pair%direction_at, 'the lay direction is normal to the '// &
      'facet '//to_text(pair%facets(1, facet))//' '//to_text(pair%facets(2, facet))//' '// &
      to_text(pair%facets(3, facet))//' of '''//pair%master//''''//more, &
      'give a DIREction that has a part in each master facet')
  end subroutine report_normal_lay

  !> Penalties; those of AUTO are noted, for the log.
  subroutine take_penalties(model, diagnostics, pair)
    type(model_t), intent(in) :: model !! mesh and materials
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    logical :: found

    call set_penalties(model, pair, found)
    if (found) then
      if (pair%penalty_kind == penalty_nodal .or. size(pair%epsilon) == 0) return
      call report_note(diagnostics, pair%at, 'pair '//pair%name//': penalty '// &
        to_text(minval(pair%epsilon))//' to '//to_text(maxval(pair%epsilon))// &
        ' force per length and node')
    else if (pair%penalty_kind == penalty_area) then
      call report_error(diagnostics, pair%slave_at, 'slave '// &
        point_text(pair, first_true(pair%area <= 0.0_wp))//' of '''//pair%slave// &
        ''' has no area: no exterior facet around it lies in the set', &
        'name a surface as slave, or give the penalty per node')
    else
      call report_error(diagnostics, pair%at, 'pair '//pair%name// &
        ' has no elastic side to take its penalty from', 'write PENAlty and a value')
    end if
  end subroutine take_penalties
end module pair_builder

!> Mesh files of triangles alone (STL, two-dimensional cells of Gmsh): rigid surfaces with nothing
!! behind them.
module tool_surfaces
  use kinds, only: wp
  use text, only: to_text, count_noun
  use errors, only: error_t
  use vectors, only: cross
  use source, only: file_name
  use diagnostics, only: diagnostics_t, report_error, report_note
  use key_sorting, only: sort_columns, ascending
  use near_places, only: join_places, roundings
  use mesh_types, only: mesh_t
  use mesh_names, only: name_exists
  use mesh_building, only: reserve_nodes, place_node
  use mesh_file_types, only: file_mesh_t, group_cells, group_faces, group_done, rigid_cell
  use file_mesh_checks, only: file_place_t, resolve_nodes
  use part_lists, only: append_surface
  implicit none
  private
  public :: is_tool, place_tool, place_rigid

  !> A triangle whose area is below this share of its longest edge squared is a line.
  real(wp), parameter :: line_area_ratio = 1.0e-12_wp
  !> Corners that are closer than this share of the tool are one: no facet is so small.
  real(wp), parameter :: least_feature = 1.0e-6_wp

contains

  !> A file of triangles without a tetrahedron.
  pure logical function is_tool(file)
    type(file_mesh_t), intent(in) :: file !! what the file holds

    is_tool = maxval(file%dimension(:file%cells)) == 2
  end function is_tool

  !> Makes surfaces of the triangles: one of all under the name of `AS`, else one for each group of
  !! the file, else one that has the name of the file.
  subroutine place_tool(name, place, file, mesh, diagnostics)
    character(*), intent(in) :: name !! name of AS, empty without
    type(file_place_t), intent(inout) :: place !! knows the file; gets deck numbers of its nodes
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets nodes and surfaces
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: errors
    logical :: grouped

    errors = diagnostics%errors
    allocate (place%node(file%nodes), place%element(file%cells), source=0)
    call resolve_nodes(place, file, diagnostics)
    if (diagnostics%errors > errors) return
    allocate (place%rigid(file%cells))
    place%rigid(:) = file%dimension(:file%cells) == 2
    call place_corners(place, file, mesh, diagnostics)
    if (diagnostics%errors > errors) return
    call place_groups(name, place, file, mesh, grouped, diagnostics)
    if (grouped) return
    call add_surface(base_of(file_name(diagnostics%source, place%file)), place%rigid, place, &
      file, mesh, diagnostics)
  end subroutine place_tool

  !> Makes surfaces of the rigid facets of a file beside tetrahedra, and of each group of such.
  subroutine place_rigid(place, file, mesh, diagnostics)
    type(file_place_t), intent(inout) :: place !! knows the file; gets deck numbers of its nodes
    type(file_mesh_t), intent(inout) :: file !! what the file holds; its groups of such are done
    type(mesh_t), intent(inout) :: mesh !! gets nodes and surfaces
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: errors
    logical :: grouped

    if (.not. any(place%rigid)) return
    errors = diagnostics%errors
    call place_corners(place, file, mesh, diagnostics)
    if (diagnostics%errors > errors) return
    call place_groups('', place, file, mesh, grouped, diagnostics)
    if (.not. grouped) call add_surface(base_of(file_name(diagnostics%source, place%file)), &
      place%rigid, place, file, mesh, diagnostics)
  end subroutine place_rigid

  !> A surface of all rigid facets under the name of AS, or one for each group of such alone.
  subroutine place_groups(name, place, file, mesh, grouped, diagnostics)
    character(*), intent(in) :: name !! name of AS, empty without
    type(file_place_t), intent(in) :: place !! deck numbers, rigid facets
    type(file_mesh_t), intent(inout) :: file !! what the file holds; its groups of such are done
    type(mesh_t), intent(inout) :: mesh !! gets surfaces
    logical, intent(out) :: grouped !! there is one
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical :: chosen(file%cells)
    integer :: g

    grouped = name /= ''
    if (grouped) call add_surface(name, place%rigid, place, file, mesh, diagnostics)
    do g = 1, file%groups
      associate (group => file%group(g))
        if (name /= '' .or. group%count == 0) cycle
        if (group%kind /= group_cells .and. group%kind /= group_faces) cycle
        chosen = .false.
        chosen(group%members(:group%count)) = .true.
        if (.not. any(chosen .and. place%rigid)) cycle
        if (any(chosen .and. file%dimension(:file%cells) == 3)) cycle
        group%kind = group_done
        grouped = .true.
        call add_surface(group%name, chosen .and. place%rigid, place, file, mesh, diagnostics)
      end associate
    end do
  end subroutine place_groups

  !> The name of a file without its folder and its ending.
  pure function base_of(path) result(base)
    character(*), intent(in) :: path !! the file
    character(:), allocatable :: base
    integer :: last

    base = path(scan(path, '/', back=.true.) + 1:)
    last = scan(base, '.', back=.true.) - 1
    if (last > 0) base = base(:last)
  end function base_of

  !> Puts the corners of the triangles into the mesh, those at one place once.
  subroutine place_corners(place, file, mesh, diagnostics)
    type(file_place_t), intent(inout) :: place !! gets deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets the nodes
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(error_t), allocatable :: error
    integer, allocatable :: first(:), members(:)
    logical, allocatable :: held(:)
    integer :: c, n, before
    real(wp) :: apart

    allocate (held(file%nodes), source=.false.)
    do c = 1, file%cells
      if (.not. place%rigid(c)) cycle
      held(file%ix(:merge(4, 3, is_quadrilateral(file, c)), c)) = .true.
    end do
    held = held .and. place%node < 1
    members = pack([(n, n=1, file%nodes)], held)
    ! what the numbers of the file are rounded by must not tear the surface
    associate (x => file%x(:, members))
      call join_places(x, min(maxval(roundings(x)), least_feature*norm2(maxval(x, 2) - &
        minval(x, 2))), first)
    end associate
    before = mesh%nodes
    call reserve_nodes(mesh, before + count(held), error)
    if (allocated(error)) then
      call report_error(diagnostics, place%at, error%message, 'make the mesh coarser')
      return
    end if
    mesh%nodes = before
    do n = 1, size(members)
      associate (other => members(first(n)))
        if (place%node(other) < 1) then
          mesh%nodes = mesh%nodes + 1
          place%node(other) = mesh%nodes
          call place_node(mesh, mesh%nodes, file%x(:, other), apart)
        end if
        place%node(members(n)) = place%node(other)
      end associate
    end do
    call report_note(diagnostics, place%at, file_name(diagnostics%source, place%file)//': '// &
      count_noun(mesh%nodes - before, 'node')//', numbered from '//to_text(before + 1)// &
      ', of triangles alone: a rigid surface')
  end subroutine place_corners

  !> Adds a surface of some triangles; those without area, and second ones, are left out.
  subroutine add_surface(name, chosen, place, file, mesh, diagnostics)
    character(*), intent(in) :: name !! its name
    logical, intent(in) :: chosen(:) !! (cells) its triangles
    type(file_place_t), intent(in) :: place !! deck numbers
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(mesh_t), intent(inout) :: mesh !! gets the surface
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer, allocatable :: facets(:, :), keys(:, :), order(:)
    logical, allocatable :: kept(:)
    integer :: c, n, i, three(3), triangles

    if (name_exists(mesh, name)) then
      call report_error(diagnostics, place%at, 'the name '//name//' is taken already', &
        'write MESH file AS and another name')
      return
    end if
    allocate (facets(3, 2*count(chosen)))
    n = 0
    triangles = 0
    do c = 1, file%cells
      if (.not. chosen(c)) cycle
      do i = 1, merge(2, 1, is_quadrilateral(file, c))
        three = place%node(file%ix(:3, c))
        if (i == 2) three = place%node(file%ix([1, 3, 4], c))
        triangles = triangles + 1
        if (is_flat(mesh%x(:, three))) cycle
        n = n + 1
        facets(:, n) = three
        if (mesh%mirrors) facets(:, n) = facets([2, 1, 3], n)
      end do
    end do
    allocate (keys(3, n))
    do i = 1, n
      keys(:, i) = ascending(facets(:, i))
    end do
    call sort_columns(keys, order)
    allocate (kept(n), source=.true.)
    do i = 2, n
      kept(order(i)) = any(keys(:, order(i)) /= keys(:, order(i - 1)))
    end do
    if (count(kept) < triangles) call report_note(diagnostics, place%at, 'surface '//name// &
      ': '//count_noun(triangles - count(kept), 'triangle')//' left out, without area or '// &
      'given twice')
    if (.not. any(kept)) call report_error(diagnostics, place%at, 'surface '//name// &
      ' has no triangle with an area', 'is the file complete? write it again')
    call append_surface(mesh, name, place%at)
    associate (surface => mesh%surfaces(size(mesh%surfaces)))
      surface%facets = facets(:, pack([(i, i=1, n)], kept))
      surface%elements = spread(0, 1, count(kept))
      surface%alone = .true.
    end associate
  end subroutine add_surface

  !> A rigid facet has a fourth corner.
  pure logical function is_quadrilateral(file, c)
    type(file_mesh_t), intent(in) :: file !! what the file holds
    integer, intent(in) :: c !! the cell

    is_quadrilateral = file%mark(c) == rigid_cell .and. file%nel(c) == 4
  end function is_quadrilateral

  !> Three corners lie on a line.
  pure logical function is_flat(x)
    real(wp), intent(in) :: x(3, 3) !! corners [length]

    is_flat = .not. norm2(cross(x(:, 2) - x(:, 1), x(:, 3) - x(:, 1))) > line_area_ratio*max( &
      sum((x(:, 2) - x(:, 1))**2), sum((x(:, 3) - x(:, 1))**2), sum((x(:, 3) - x(:, 2))**2))
  end function is_flat
end module tool_surfaces

!> Faces that a TIE was to join, and that it has joined in part or not at all, because their meshes
!! do not match: what hangs at a few common nodes is far too soft.
module tie_checks
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: deck_t
  use diagnostics, only: diagnostics_t, report_error
  use facets, only: facet_table_t
  use facet_geometry, only: facet_normal, project_on_facet, barycentric, altitude
  use facet_tree, only: facet_tree_t, build_tree, facets_near
  use contact_types, only: pair_t
  use model_types, only: model_t
  implicit none
  private
  public :: check_ties

  !> Two facets lie on each other if the cosine of their normals is below this (8 degrees: those
  !! of a curved face cut in different ways differ).
  real(wp), parameter :: opposite_faces = -0.99_wp
  !> A corner lies on a facet if the point of its own facet this share of the way to its middle
  !! does: faces that meet at an edge alone do not.
  real(wp), parameter :: inwards = 0.1_wp
  !> How far a corner may lie from the facet, as a share of its own facet's lowest altitude (a long
  !! cell of a thin body is no measure of what lies near): the sag of a curved face that both sides
  !! have cut in their own way.
  real(wp), parameter :: apart = 0.02_wp
  !> Facets that are looked at beside a corner.
  integer, parameter :: most_facets_beside = 200

contains

  !> Reports corners of free facets that a TIE was to join and that lie on a free facet instead.
  subroutine check_ties(deck, exterior, model, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(facet_table_t), intent(in) :: exterior !! the free facets of the mesh
    type(model_t), intent(in) :: model !! mesh and pairs
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical :: hangs(model%mesh%nodes), joined(model%mesh%nodes)
    type(facet_tree_t) :: tree
    integer :: f, k, n, first

    associate (mesh => model%mesh)
      if (.not. allocated(mesh%to_tie) .or. exterior%count == 0) return
      joined = .false.
      do n = 1, mesh%nodes
        if (mesh%tied(n) /= n) joined(mesh%tied(n)) = .true.
      end do
      call build_tree(tree, exterior%corners, mesh%x)
      hangs = .false.
      do f = 1, exterior%count
        do k = 1, 3
          n = exterior%corners(k, f)
          if (joined(n) .or. hangs(n) .or. .not. mesh%to_tie(n)) cycle
          hangs(n) = lies_on_another(model, exterior, tree, f, k)
        end do
      end do
      n = count(hangs)
      if (n == 0) return
      first = findloc(hangs, .true., dim=1)
      call report_error(diagnostics, deck%mesh(findloc(deck%mesh%command, 'tie ', dim=1))%head%at, &
        'TIE joins faces that lie on each other '//trim(merge('in part only', 'not at all  ', &
        any(joined)))//': '//count_noun(n, 'node')//' on a face of the other side '// &
        trim(merge('has ', 'have', n == 1))//' no partner there, the first is node '// &
        to_text(first)//' at '//to_text(mesh%x(1, first), 4)//' '//to_text(mesh%x(2, first), 4)// &
        ' '//to_text(mesh%x(3, first), 4), 'TIE joins node to node: give both sides the same '// &
        'nodes there (equal cells in both BLOCks; parts fragmented or merged before they are '// &
        'meshed), or name the faces in a PAIR if they need only press on each other')
    end associate
  end subroutine check_ties

  !> A corner of a free facet lies on another free facet that looks at it, and that no pair joins
  !! it to.
  logical function lies_on_another(model, exterior, tree, f, k) result(lies)
    type(model_t), intent(in) :: model !! mesh and pairs
    type(facet_table_t), intent(in) :: exterior !! the free facets
    type(facet_tree_t), intent(in) :: tree !! over them
    integer, intent(in) :: f !! the facet
    integer, intent(in) :: k !! its corner
    integer :: near(most_facets_beside), n, i
    real(wp) :: corner(3, 3), y(3), xi(2), gap, size_of

    corner = model%mesh%x(:, exterior%corners(:, f))
    size_of = minval([(altitude(corner, i), i=1, 3)])
    y = (1.0_wp - inwards)*corner(:, k) + inwards*sum(corner, 2)/3.0_wp
    call facets_near(tree, y, apart*size_of, near, n)
    lies = .false.
    do i = 1, n
      associate (other => exterior%corners(:, near(i)))
        if (near(i) == f .or. any(other == exterior%corners(k, f))) cycle
        if (.not. all(model%mesh%to_tie(other))) cycle
        associate (x => model%mesh%x(:, other))
          if (dot_product(facet_normal(x), facet_normal(corner)) > opposite_faces) cycle
          call project_on_facet(x, y, xi, gap)
        end associate
        if (minval(barycentric(xi)) < 0.0_wp .or. abs(gap) > apart*size_of) cycle
        lies = .not. are_paired(model%pairs, exterior%corners(k, f), other)
        if (lies) return
      end associate
    end do
  end function lies_on_another

  !> A node is on one side of a pair, and the corners of a facet are on the other.
  pure logical function are_paired(pairs, node, facet)
    type(pair_t), intent(in) :: pairs(:) !! the pairs
    integer, intent(in) :: node !! the node
    integer, intent(in) :: facet(3) !! the corners
    integer :: p, k
    integer, allocatable :: slave(:, :)
    logical :: on_master, on_slave

    are_paired = .false.
    do p = 1, size(pairs)
      if (.not. allocated(pairs(p)%surface%facets)) cycle
      if (.not. allocated(pairs(p)%points%point_nodes)) cycle
      on_master = any(pairs(p)%surface%facets == node)
      slave = pairs(p)%points%point_nodes
      if (allocated(pairs(p)%points%slave_facets)) slave = pairs(p)%points%slave_facets
      on_slave = any(slave == node)
      if (on_slave) are_paired = all([(any(pairs(p)%surface%facets == facet(k)), k=1, 3)])
      if (on_master) are_paired = are_paired .or. all([(any(slave == facet(k)), k=1, 3)])
      if (are_paired) return
    end do
  end function are_paired
end module tie_checks

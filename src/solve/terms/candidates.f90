!> Candidates: the nodes that contact may touch, foreseen from the prescribed motion.
module candidates
  use kinds, only: wp
  use element_types, only: routine_none, routine_smooth
  use element_lists, only: master_nodes
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use loads, only: load_factors, add_displacement, corner_times, turned_angles, conditions_at
  use candidate_sweep, only: sweep_pair
  use predictor, only: carry_bodies, turn_bodies
  use system_types, only: system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: foresee_candidates, dense_share, list_facets, add_ring, mark_touched

  !> Nodes that turn are looked at in steps of this angle, about 5 degrees.
  real(wp), parameter :: turn_step = 0.09_wp

  !> Dense systems of so few rows cost next to nothing.
  real(wp), parameter :: rows_for_nothing = 1500.0_wp
  !> What the condensed form costs, in the unit of the cost of sparse factors over equations to the
  !! power of 1.5: a row of contact, an equation, the square and the cube of a body's candidates,
  !! and an equation of a body whose candidates may be eliminated among the others; measured. Plates
  !! have such factors, and thicker bodies dearer ones.
  real(wp), parameter :: row_cost = 160.0_wp, equation_cost = 20.0_wp, square_cost = 0.025_wp, &
    cube_cost = 8.0e-6_wp, tree_cost = 40.0_wp, power = 1.5_wp

contains

  !> Marks the slave nodes that come close to a master, and the facets below them with those around
  !! them, along the way on which the loads carry the bodies rigidly (doc/theory, "Static
  !! condensation").
  subroutine foresee_candidates(model, system, candidate)
    type(model_t), intent(in) :: model !! pairs, conditions
    type(system_t), intent(in) :: system !! equations, bodies
    logical, intent(inout) :: candidate(:) !! (nodes) marked
    real(wp), allocatable :: places(:, :, :)
    logical, allocatable :: near(:)
    integer :: k

    call foresee_places(model, system, places)
    do k = 1, size(model%pairs)
      if (follows_supports(model, system, model%pairs(k))) near = spread(.false., 1, &
        size(candidate))
      call sweep_pair(model%pairs(k), model%mesh%x, places, candidate, near)
      if (allocated(near)) then
        candidate = candidate .or. near
        deallocate (near)
      else
        call add_ring(model%pairs(k)%surface%facets, candidate)
      end if
      call add_middles(model%pairs(k), candidate)
      if (model%pairs(k)%smooth) call add_patch_rings(model%pairs(k)%surface%facets, candidate)
      if (allocated(model%pairs(k)%points%side%facets)) &
        call add_patch_rings(model%pairs(k)%points%side%facets, candidate)
    end do
  end subroutine foresee_candidates

  !> Points of a pair go where supports carry their bodies, but for small strains: no forces load
  !! the bodies, each is held by its supports alone, and its points are no cells of facets.
  pure logical function follows_supports(model, system, pair) result(follows)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! bodies
    type(pair_t), intent(in) :: pair !! the pair

    follows = .not. (pair%segmented .or. pair%smooth .or. any(system%body%floating) .or. &
      allocated(system%loads%pressed)) .and. all(model%conditions%loads%force%n == 0)
  end function follows_supports

  !> Marks the middles of the edges of quadratic facets whose corners are all marked.
  pure subroutine add_middles(pair, candidate)
    type(pair_t), intent(in) :: pair !! the pair
    logical, intent(inout) :: candidate(:) !! (nodes)
    integer :: f

    if (.not. allocated(pair%surface%middles)) return
    do f = 1, size(pair%surface%facets, 2)
      if (pair%surface%middles(1, f) == 0 .or. .not. all(candidate(pair%surface%facets(:, &
        f)))) cycle
      candidate(pair%surface%middles(:, f)) = .true.
    end do
  end subroutine add_middles

  !> Cost of the condensed form over that of factors of the whole matrix: rows, three for each point
  !! that can touch or one for each degree of freedom that it can reach, and the compliances with
  !! their products (doc/theory, "Choice of the solver", eq. (12.19)).
  pure real(wp) function dense_share(model, system, condensed) result(share)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! candidates of condensed
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp) :: rows
    integer :: k, p, points, dofs(system%body%bodies), equations(system%body%bodies)

    points = 0
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))/model%pairs(k)%points%slots
        if (any(condensed%candidate(model%pairs(k)%points%point_nodes(:, p)))) points = points + 1
      end do
    end do
    dofs = 0
    equations = 0
    do k = 1, size(system%body%node_body)
      associate (b => system%body%node_body(k), n => count(system%equation(:, k) > 0))
        if (n == 0) cycle
        equations(b) = equations(b) + n
        if (condensed%candidate(k)) dofs(b) = dofs(b) + n
      end associate
    end do
    rows = real(min(3*points, sum(dofs)), wp)
    share = (row_cost*rows + equation_cost*real(system%equations, wp) &
      + sum(body_cost(dofs, equations, system%bulk%linear .and. system%body%motions%n == 0))) &
      /real(system%equations, wp)**power
    if (max(rows, real(maxval(dofs), wp)) <= rows_for_nothing) share = min(share, 1.0_wp)
  end function dense_share

  !> Cost of the compliance of a body and of its products.
  pure elemental real(wp) function body_cost(candidates, equations, tree) result(cost)
    integer, intent(in) :: candidates, equations !! degrees of freedom
    logical, intent(in) :: tree !! candidates may be eliminated among the others

    cost = square_cost*real(candidates, wp)**2 + cube_cost*real(candidates, wp)**3
    if (tree) cost = min(cost, tree_cost*real(equations, wp))
  end function body_cost

  !> All facets of all pairs, of slaves those that are bent.
  subroutine list_facets(model, facets)
    type(model_t), intent(in) :: model !! pairs
    integer, allocatable, intent(out) :: facets(:, :) !! (3, facets) corner nodes
    integer :: k, n

    n = 0
    do k = 1, size(model%pairs)
      n = n + size(model%pairs(k)%surface%facets, 2)
      if (allocated(model%pairs(k)%points%side%facets)) n = n &
        + size(model%pairs(k)%points%side%facets, 2)
    end do
    allocate (facets(3, n))
    n = 0
    do k = 1, size(model%pairs)
      facets(:, n + 1:n + size(model%pairs(k)%surface%facets, 2)) = model%pairs(k)%surface%facets
      n = n + size(model%pairs(k)%surface%facets, 2)
      if (.not. allocated(model%pairs(k)%points%side%facets)) cycle
      associate (side => model%pairs(k)%points%side%facets)
        facets(:, n + 1:n + size(side, 2)) = side
        n = n + size(side, 2)
      end associate
    end do
  end subroutine list_facets

  !> Where the nodes are at the corners of the loads if nothing resists. Bodies of finite strain
  !! turn from one to the next.
  subroutine foresee_places(model, system, places)
    type(model_t), intent(in) :: model !! mesh, conditions
    type(system_t), intent(in) :: system !! equations, bodies
    real(wp), allocatable, intent(out) :: places(:, :, :) !! (3, nodes, corners) [length]
    real(wp), allocatable :: motion(:, :, :), times(:), u(:, :), next(:, :)
    integer :: c

    call load_corners(model, times)
    allocate (places(3, model%mesh%nodes, size(times)))
    if (system%bulk%linear) then
      call rigid_motions(model, system, motion)
      do c = 1, size(times)
        places(:, :, c) = moved(model, motion, times(c))
      end do
      return
    end if
    allocate (u(3, model%mesh%nodes), next(3, model%mesh%nodes), source=0.0_wp)
    do c = 1, size(times)
      call conditions_at(model, times(c), displacement=next)
      where (system%equation > 0) next = u
      call turn_bodies(model%mesh%x, system%equation, system%body%node_body, &
        system%body%bodies, u, next)
      u = next
      places(:, :, c) = model%mesh%x + u
    end do
  end subroutine foresee_places

  !> What a unit of each load does to the bodies if nothing resists.
  subroutine rigid_motions(model, system, motion)
    type(model_t), intent(in) :: model !! conditions
    type(system_t), intent(in) :: system !! equations, bodies
    real(wp), allocatable, intent(out) :: motion(:, :, :) !! (3, nodes, loads) [length]
    real(wp), allocatable :: rest(:, :)
    integer :: k

    allocate (motion(3, model%mesh%nodes, size(model%conditions%loads)), &
      rest(3, model%mesh%nodes), source=0.0_wp)
    do k = 1, size(model%conditions%loads)
      call add_displacement(model%conditions%loads(k), 1.0_wp, motion(:, :, k))
      where (system%equation > 0) motion(:, :, k) = 0.0_wp
      call carry_bodies(model%mesh%x, system%equation, system%body%node_body, system%body%bodies, &
        rest, motion(:, :, k))
    end do
  end subroutine rigid_motions

  !> Times at which the loads have their corners, and between these such that no rotation is larger
  !! than a few degrees from one to the next: its nodes do not go straight.
  subroutine load_corners(model, times)
    type(model_t), intent(in) :: model !! loads
    real(wp), allocatable, intent(out) :: times(:) !! ascending, at least one
    real(wp), allocatable :: corners(:)
    real(wp) :: angles(size(model%conditions%loads), 2)
    integer :: i, k, parts

    call corner_times(model%tables, corners)
    times = corners(:1)
    do i = 2, size(corners)
      do k = 1, 2
        angles(:, k) = turned_angles(model, corners(i - 2 + k))
      end do
      parts = max(1, ceiling(maxval([0.0_wp, abs(angles(:, 2) - angles(:, 1))])/turn_step))
      times = [times, [(corners(i - 1) + (corners(i) - corners(i - 1))*real(k, wp)/real(parts, &
        wp), k=1, parts)]]
    end do
  end subroutine load_corners

  !> Positions at a time.
  function moved(model, motion, time) result(x)
    type(model_t), intent(in) :: model !! mesh, loads
    real(wp), intent(in) :: motion(:, :, :) !! (3, nodes, loads) unit motions [length]
    real(wp), intent(in) :: time !! the time
    real(wp), allocatable :: x(:, :)
    real(wp) :: factors(size(motion, 3))
    integer :: k

    x = model%mesh%x
    factors = load_factors(model, time)
    do k = 1, size(factors)
      x = x + factors(k)*motion(:, :, k)
    end do
  end function moved

  !> Marks the nodes of all facets that touch a marked node.
  pure subroutine add_ring(facets, candidate)
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    logical, intent(inout) :: candidate(:) !! (nodes) marked
    logical :: before(size(candidate))
    integer :: f

    before = candidate
    do f = 1, size(facets, 2)
      if (any(before(facets(:, f)))) candidate(facets(:, f)) = .true.
    end do
  end subroutine add_ring

  !> Marks what the patch of a facet of marked nodes depends on: the facets around its corners, and
  !! around theirs, for a normal at the boundary follows from those beside it.
  pure subroutine add_patch_rings(facets, candidate)
    integer, intent(in) :: facets(:, :) !! (3, facets) corner nodes
    logical, intent(inout) :: candidate(:) !! (nodes) marked

    call add_ring(facets, candidate)
    call add_ring(facets, candidate)
  end subroutine add_patch_rings

  !> Marks the nodes of all contact elements, and of the facets that bend smooth ones.
  pure subroutine mark_touched(system, condensed)
    type(system_t), intent(in) :: system !! contact elements
    type(condensed_t), intent(inout) :: condensed !! gets candidate
    logical :: bent(size(condensed%candidate)), smooth
    integer :: k, a

    smooth = any(system%contact%routine == routine_smooth)
    if (smooth) bent = .false.
    associate (candidate => condensed%candidate, list => system%contact)
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        do a = 1, list%nel(k)
          associate (node => list%ix(a, k))
            if (.not. candidate(node)) candidate(node) = any(system%equation(:, node) > 0)
          end associate
        end do
        if (list%routine(k) /= routine_smooth) cycle
        bent(master_nodes(list, k)) = .true.
        if (list%slaves(k) > 1) bent(list%ix(1:list%slaves(k), k)) = .true.
      end do
      if (.not. smooth) return
      call add_patch_rings(condensed%facets, bent)
      candidate = candidate .or. (bent .and. any(system%equation > 0, 1))
    end associate
  end subroutine mark_touched
end module candidates

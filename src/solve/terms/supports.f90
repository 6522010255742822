!> How bodies are held: by supports, by closed contact points, or, for one iteration, by soft
!! springs (doc/theory, "Floating bodies", eq. (9.9)). In more than 400 lines, since the three of
!! them answer the same question of each motion.
module supports
  use kinds, only: wp
  use vectors, only: cross
  use element_types, only: status_open, status_stick, routine_none, routine_smooth
  use element_lists, only: slave_point, master_nodes, side_nodes, element_list_t
  use lapack_interface, only: dsyev
  use facet_geometry, only: project_on_facet, facet_normal
  use quadratic_facet, only: projection_t, project_quadratic, facet_flat, facet_of_routine
  use element_parameters, only: d04_patch
  use smooth_patch, only: project_on_patch, patch_from_values
  use block_matrix, only: find_block
  use system_types, only: form_t, system_t
  use system_parts, only: rigid_part_t, outer_t, bodies_t
  use rigid_motions, only: find_motions
  use springs, only: is_supported
  use rigid_bodies, only: drop_rigid, is_carried, rigid_force
  implicit none
  private
  public :: soft_springs, unresisted, free_motion, free_motions, model_extent, &
    find_floating_bodies, floating_with_points, unheld_bodies, regularise_bodies, &
    closing_length, close_bodies

  !> Eigenvalues of a body's support below this share of the largest belong to free motions.
  real(wp), parameter :: free_tolerance = 1.0e-12_wp

  !> Stiffness of the soft springs of a node over its own stiffness.
  real(wp), parameter :: soft_springs = 1.0e-6_wp
  !> Motions that contact resists by less than this share of the stiffest one are not resisted.
  real(wp), parameter :: unresisted = 1.0e-9_wp
  !> A body that comes to its first touch is let through the surface by this share of the size of
  !! the facets, so that the points next to the first one touch as well.
  real(wp), parameter :: overshoot = 1.0e-4_wp
  !> Loads on a body whose sum is less than this share of their magnitudes push it nowhere.
  real(wp), parameter :: in_balance = 1.0e-9_wp

contains

  !> Looks for a rigid motion of a body that no support resists (nor a closed contact point, if
  !! they count).
  subroutine free_motion(x, system, body, with_contact, free, motion, tracks)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: body !! the body
    logical, intent(in) :: with_contact !! closed contact points hold, too
    logical, intent(out) :: free !! there is such a motion
    real(wp), intent(out) :: motion(6) !! translation, and rotation times the model's size
    logical, intent(in), optional :: tracks !! points that slip hold across their tracks, too
    logical :: across
    real(wp) :: motions(6, 6)
    integer :: n

    across = .false.
    if (present(tracks)) across = tracks
    call free_motions(x, system, body, with_contact, across, n, motions)
    free = n > 0
    motion = motions(:, 1)
  end subroutine free_motion

  !> All rigid motions of a body that nothing resists: the null space of the 6 x 6 Gram matrix of
  !! what does.
  subroutine free_motions(x, system, body, with_contact, tracks, n, motions)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: body !! the body
    logical, intent(in) :: with_contact !! closed contact points hold, too
    logical, intent(in) :: tracks !! points that slip hold across their tracks, too
    integer, intent(out) :: n !! how many
    real(wp), intent(out) :: motions(6, 6) !! (6, n) translation, and rotation times the model's
    !! size, orthonormal; the others are resisted, the first the least
    real(wp) :: values(6), work(200), center(3), size_x
    integer :: i, k, info, dofs

    call model_extent(x, center, size_x)
    motions = 0.0_wp
    dofs = 0
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) /= body) cycle
      do k = 1, 3
        if (system%equation(k, i) > 0 .or. is_carried(system%tools, i)) dofs = dofs + 1
        if (is_supported(system, k, i)) then
          call add_support(motions, unit_vector(k), (x(:, i) - center)/size_x)
        end if
      end do
    end do
    call add_points(system%tools, body, center, size_x, motions)
    if (with_contact) call add_contact(x, system, body, center, size_x, tracks, motions)
    call dsyev('V', 'U', 6, motions, 6, values, work, size(work), info)
    n = count(values <= free_tolerance*max(values(6), 1.0_wp))
    if (info /= 0) n = max(n, 1)
    if (dofs == 0) n = 0
  end subroutine free_motions

  !> Where rotations of a free motion turn about, and the length that they are told by.
  pure subroutine model_extent(x, center, size_x)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(out) :: center(3) !! middle of the model [length]
    real(wp), intent(out) :: size_x !! its largest extent [length]

    center = 0.5_wp*(maxval(x, 2) + minval(x, 2))
    size_x = max(maxval(maxval(x, 2) - minval(x, 2)), tiny(1.0_wp))
  end subroutine model_extent

  !> Adds what is prescribed of the points of rigid bodies.
  pure subroutine add_points(tools, body, center, size_x, gram)
    type(rigid_part_t), intent(in) :: tools !! rigid bodies
    integer, intent(in) :: body !! connected body
    real(wp), intent(in) :: center(3) !! where rotations turn about [length]
    real(wp), intent(in) :: size_x !! size of the model [length]
    real(wp), intent(inout) :: gram(6, 6) !! sum of row row^T
    integer :: b, k

    if (.not. allocated(tools%rigid)) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        if (rigid%body /= body .or. size(rigid%unknown) == 0) cycle
        do k = 1, 3
          if (all(rigid%unknown /= k)) call add_support(gram, unit_vector(k), (rigid%point &
            - center)/size_x)
          if (all(rigid%unknown /= 3 + k)) gram(3 + k, 3 + k) = gram(3 + k, 3 + k) + 1.0_wp
        end do
      end associate
    end do
  end subroutine add_points

  !> Adds a support that resists motion of the point y along n.
  pure subroutine add_support(gram, n, y)
    real(wp), intent(inout) :: gram(6, 6) !! sum of row row^T
    real(wp), intent(in) :: n(3) !! direction
    real(wp), intent(in) :: y(3) !! the point from the center, over the size of the model
    real(wp) :: row(6)

    row = [n, cross(y, n)]
    gram = gram + spread(row, 2, 6)*spread(row, 1, 6)
  end subroutine add_support

  !> Adds what closed contact points hold: all directions in stick, the normal in slip.
  subroutine add_contact(x, system, body, center, size_x, tracks, gram)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: body !! the body
    real(wp), intent(in) :: center(3) !! where rotations turn about [length]
    real(wp), intent(in) :: size_x !! size of the model [length]
    logical, intent(in) :: tracks !! points that slip hold across their tracks, too
    real(wp), intent(inout) :: gram(6, 6) !! sum of row row^T
    real(wp) :: y(3)
    integer :: k, i

    do k = 1, system%contact%n
      if (system%contact%status(k) <= status_open) cycle
      associate (sides => side_nodes(system%contact, k))
        if (.not. any(system%body%node_body(sides) == body)) cycle
        y = (slave_point(system%contact, k, x) - center)/size_x
        if (system%contact%status(k) == status_stick .or. system%contact%hold(k)) then
          do i = 1, 3
            call add_support(gram, unit_vector(i), y)
          end do
        else
          call add_support(gram, normal_of(x, master_nodes(system%contact, k)), y)
          if (tracks) call add_track(x, system%contact, k, y, gram)
        end if
      end associate
    end do
  end subroutine add_contact

  !> A point that slips resists motion across its track: its friction turns with the track.
  subroutine add_track(x, contact, k, y, gram)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(element_list_t), intent(in) :: contact !! contact elements
    integer, intent(in) :: k !! a slipping one
    real(wp), intent(in) :: y(3) !! the point from the center, over the size of the model
    real(wp), intent(inout) :: gram(6, 6) !! sum of row row^T
    real(wp) :: across(3)

    associate (nodes => master_nodes(contact, k), slip => contact%slip(:, k))
      if (norm2(slip) <= 0.0_wp) return
      across = cross(normal_of(x, nodes), slip)
    end associate
    if (norm2(across) > 0.0_wp) call add_support(gram, across/norm2(across), y)
  end subroutine add_track

  !> Unit vector along axis k.
  pure function unit_vector(k) result(n)
    integer, intent(in) :: k !! 1, 2 or 3
    real(wp) :: n(3)

    n = 0.0_wp
    n(k) = 1.0_wp
  end function unit_vector

  !> Marks the bodies that their supports alone do not hold.
  subroutine find_floating_bodies(x, equation, loads, apart, bodies)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(outer_t), intent(in) :: loads !! springs
    logical, intent(in) :: apart !! motions that springs hold are unknowns, as those left free are
    type(bodies_t), intent(inout) :: bodies !! gets motions, floating
    integer :: held(3, size(equation, 2)), body

    held = equation
    if (allocated(loads%spring)) where (loads%spring > 0.0_wp) held = 0
    allocate (bodies%floating(bodies%bodies), bodies%regularised(bodies%bodies), source=.false.)
    allocate (bodies%motions(bodies%bodies))
    do body = 1, bodies%bodies
      call find_motions(x, held, bodies%node_body, body, bodies%motions(body))
    end do
    bodies%floating = bodies%motions%n > 0
    if (apart .and. allocated(loads%spring)) then
      do body = 1, bodies%bodies
        call find_motions(x, equation, bodies%node_body, body, bodies%motions(body))
      end do
    end if
  end subroutine find_floating_bodies

  !> The same once rigid bodies with a point are known, whose unknowns are no motions of nodes.
  function floating_with_points(x, system) result(floating)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! bodies, those that float without points; rigid bodies
    logical :: floating(system%body%bodies)
    real(wp) :: motion(6)
    integer :: body

    floating = system%body%floating
    if (system%tools%unknowns == 0) return
    do body = 1, size(system%tools%rigid)
      associate (rigid => system%tools%rigid(body))
        if (size(rigid%unknown) == 0) cycle
        call free_motion(x, system, rigid%body, .false., floating(rigid%body), motion)
      end associate
    end do
  end function floating_with_points

  !> Marks the bodies that neither supports nor closed contact points hold at present. Once points
  !! stay what they are, those that slip hold across their tracks; not in the condensed form, whose
  !! soft springs hold nothing but what contact hardly resists, and whose matrix has no digits left.
  function unheld_bodies(x, system, form) result(unheld)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! status of contact elements
    type(form_t), intent(in) :: form !! its kind answers
    logical :: unheld(system%body%bodies)
    real(wp) :: motion(6)
    integer :: body

    unheld = .false.
    if (system%body%damping > 0.0_wp) return
    do body = 1, system%body%bodies
      if (system%body%floating(body)) call free_motion(x, system, body, .true., &
        unheld(body), motion, tracks=system%body%settled .and. form%kind%knows_inside)
    end do
  end function unheld_bodies

  !> Regularises the bodies that nothing holds at present: springs in the tangent only, so that the
  !! residual, and with it the solution, does not know of them.
  subroutine regularise_bodies(system, form)
    type(system_t), intent(in) :: system !! those that nothing holds are known
    type(form_t), intent(inout) :: form !! matrix gets springs
    real(wp) :: damping(system%body%bodies)
    integer :: node, place, k

    if (system%body%damping <= 0.0_wp .and. .not. any(system%body%regularised)) return
    damping = [(system%body%damping/real(max(1, count(system%body%node_body == k)), wp), k=1, &
      system%body%bodies)]
    do node = 1, size(system%body%node_body)
      if (system%body%node_body(node) == 0) cycle
      associate (body => system%body%node_body(node))
        if (.not. system%body%floating(body) .or. is_carried(system%tools, node)) cycle
        place = find_block(form%whole%matrix, node, node)
        do k = 1, 3
          associate (stiffness => form%whole%matrix%val(k, k, place))
            if (system%body%regularised(body)) stiffness = (1.0_wp + soft_springs)*stiffness
            stiffness = stiffness + damping(body)
          end associate
        end do
      end associate
    end do
  end subroutine regularise_bodies

  !> Length of the step du that closes the first open contact point of a regularised body, so that
  !! the points next to it close, too; the largest number if none closes.
  real(wp) function closing_length(x, system, form) result(length)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! u, du, contact elements
    type(form_t), intent(in) :: form !! du
    real(wp) :: now, later
    integer :: k

    length = huge(1.0_wp)
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      if (system%contact%status(k) > status_open) cycle
      if (.not. any(system%body%regularised(system%body%node_body(side_nodes(system%contact, &
        k))))) cycle
      now = gap_of(x, 0.0_wp, k, system, form)
      later = gap_of(x, 1.0_wp, k, system, form)
      if (later < now) then
        length = min(length, (now + overshoot*size_of(x, k, system%contact))/(now - later))
      end if
    end do
  end function closing_length

  !> Drops each body that neither supports nor closed contact points hold onto the surface below
  !! it: a translation along the normal of its smallest gap, and no further. Loads that point away
  !! from every surface leave the body where it is.
  subroutine close_bodies(x, system, form, dropped)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(inout) :: system !! u is moved; residual formed
    type(form_t), intent(in) :: form !! du, its kind, right
    logical, intent(out) :: dropped !! a body was moved
    real(wp) :: way(3)
    integer :: body, node
    logical :: touching(system%body%bodies)

    dropped = .false.
    touching = touched_bodies(system)
    do body = 1, system%body%bodies
      if (.not. system%body%floating(body) .or. touching(body)) cycle
      way = way_down(x, system, form, body)
      if (all(abs(way) <= 0.0_wp)) cycle
      dropped = .true.
      do node = 1, size(system%body%node_body)
        if (system%body%node_body(node) /= body) cycle
        where (system%equation(:, node) > 0) system%u(:, node) = system%u(:, node) + way
      end do
      call drop_rigid(system%u, system%tools, body, way)
    end do
  end subroutine close_bodies

  !> Bodies with a closed contact point.
  pure function touched_bodies(system) result(touching)
    type(system_t), intent(in) :: system !! contact elements
    logical :: touching(system%body%bodies)
    integer :: k

    touching = .false.
    do k = 1, system%contact%n
      if (system%contact%status(k) <= status_open) cycle
      touching(system%body%node_body(side_nodes(system%contact, k))) = .true.
    end do
  end function touched_bodies

  !> The translation that brings a body to its first touch, zero if its loads do not push it there.
  function way_down(x, system, form, body) result(way)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! u, residual, contact elements
    type(form_t), intent(in) :: form !! du, its kind, right
    integer, intent(in) :: body !! the body
    real(wp) :: way(3), normal(3), force(3), gap, least
    integer :: k

    way = 0.0_wp
    least = huge(1.0_wp)
    force = resultant(system, form, body)
    if (norm2(force) <= in_balance*load_on(system, body)) return
    do k = 1, system%contact%n
      if (system%contact%routine(k) == routine_none) cycle
      if (.not. any(system%body%node_body(side_nodes(system%contact, k)) == body)) cycle
      gap = gap_of(x, 0.0_wp, k, system, form)
      if (gap >= least) cycle
      normal = normal_of(positions_of(x, 0.0_wp, k, system, form%du), [2, 3, 4])
      if (system%body%node_body(system%contact%ix(1, k)) == body) normal = -normal
      if (dot_product(force, normal) <= 0.0_wp) cycle
      least = gap
      way = (gap + overshoot*size_of(x, k, system%contact))*normal
    end do
  end function way_down

  !> Sum of the magnitudes of the loads on the nodes of a body.
  pure real(wp) function load_on(system, body) result(load)
    type(system_t), intent(in) :: system !! external loads
    integer, intent(in) :: body !! the body
    integer :: node

    load = 0.0_wp
    do node = 1, size(system%body%node_body)
      if (system%body%node_body(node) == body) load = load + norm2(system%loads%external(:, node))
    end do
  end function load_on

  !> Sum of the residual over a body.
  pure function resultant(system, form, body) result(force)
    type(system_t), intent(in) :: system !! residual formed
    type(form_t), intent(in) :: form !! its kind, right
    integer, intent(in) :: body !! the body
    real(wp) :: force(3), of_form(6)
    integer :: node, k

    force = 0.0_wp
    if (associated(form%kind%floating_resultant)) then
      of_form = form%kind%floating_resultant(system, form, body)
      force = of_form(1:3)
      return
    end if
    do node = 1, size(system%body%node_body)
      if (system%body%node_body(node) /= body) cycle
      do k = 1, 3
        if (system%equation(k, node) == 0) cycle
        force(k) = force(k) + form%right(system%equation(k, node))
      end do
    end do
    if (system%tools%unknowns > 0) force = force + rigid_force(system%tools, form%right, body)
  end function resultant

  !> Outward unit normal of a facet.
  pure function normal_of(x, nodes) result(n)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: nodes(3) !! corners
    real(wp) :: n(3)

    n = cross(x(:, nodes(1)) - x(:, nodes(3)), x(:, nodes(2)) - x(:, nodes(3)))
    n = n/norm2(n)
  end function normal_of

  !> Normal gap of a contact element at u + length du, its shift included.
  pure real(wp) function gap_of(x, length, k, system, form) result(gap)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: length !! share of du
    integer, intent(in) :: k !! contact element
    type(system_t), intent(in) :: system !! contact elements
    type(form_t), intent(in) :: form !! du
    real(wp) :: y(3, 4), xi(2), z(3, 6)
    type(projection_t) :: p
    integer :: i

    y = positions_of(x, length, k, system, form%du)
    if (facet_of_routine(system%contact%routine(k)) /= facet_flat) then
      do i = 1, 6
        associate (node => system%contact%ix(system%contact%slaves(k) + i, k))
          z(:, i) = x(:, node) + system%u(:, node) + length*form%du(:, node)
        end associate
      end do
      p = project_quadratic(z, y(:, 1), facet_of_routine(system%contact%routine(k)))
      gap = p%gap + system%contact%shift(3, k) + system%contact%offset(k)
      if (p%found) return
    end if
    if (system%contact%routine(k) == routine_smooth) then
      call project_on_patch(y(:, 2:4), patch_from_values(system%contact%d(d04_patch:, k)), &
        y(:, 1), xi, gap)
    else
      call project_on_facet(y(:, 2:4), y(:, 1), xi, gap)
    end if
    gap = gap + system%contact%shift(3, k) + system%contact%offset(k)
  end function gap_of

  !> Positions of the slave point and of the corners of its facet at u + length du.
  pure function positions_of(x, length, k, system, du) result(y)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: length !! share of du
    integer, intent(in) :: k !! contact element
    type(system_t), intent(in) :: system !! u, du
    real(wp), intent(in) :: du(:, :) !! (3, nodes) direction [length]
    real(wp) :: y(3, 4)
    integer :: i, nodes(3)

    y(:, 1) = slave_point(system%contact, k, x) + slave_point(system%contact, k, system%u) &
      + length*slave_point(system%contact, k, du)
    if (system%contact%slaves(k) > 1) then
      nodes = system%contact%ix(1:3, k)
      y(:, 1) = y(:, 1) + system%contact%lift(k)*facet_normal(x(:, nodes) + system%u(:, nodes) &
        + length*du(:, nodes))
    end if
    nodes = master_nodes(system%contact, k)
    do i = 1, 3
      y(:, i + 1) = x(:, nodes(i)) + system%u(:, nodes(i)) + length*du(:, nodes(i))
    end do
  end function positions_of

  !> Size of the facet of a contact element.
  pure real(wp) function size_of(x, k, contact) result(h)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: k !! contact element
    type(element_list_t), intent(in) :: contact !! contact elements
    integer :: nodes(3)

    nodes = master_nodes(contact, k)
    h = norm2(x(:, nodes(2)) - x(:, nodes(1)))
  end function size_of
end module supports

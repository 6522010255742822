!> Predictor of bodies that contact holds: they roll and glide along with what they touch
!! (doc/theory, "Start", eq. (11.1)).
module contact_carrying
  use kinds, only: wp
  use vectors, only: cross, identity, dyad
  use rotations, only: rotation_matrix
  use element_types, only: status_open, status_stick
  use lapack_interface, only: dpotrf, dtrsv
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_points, only: point_field, point_position
  use smooth_normals, only: project_on_master
  use slave_places, only: cell_position
  use facet_geometry, only: corners, facet_normal, barycentric
  use rigid_motions, only: mode_row
  use rigid_bodies, only: carry_rigid
  use system_types, only: system_t, state_t
  use system_parts, only: bodies_t, rigid_part_t, positions_t
  implicit none
  private
  public :: carry_with_contact

  !> A way along the normal counts for this share of one across it where a point sticks: what rolls
  !! lifts some points off and presses others in.
  real(wp), parameter :: normal_share = 1.0e-3_wp
  !> Bodies are carried along if this share of what points would slip and lift at most is left, in
  !! squares.
  real(wp), parameter :: fitting = 1.0e-3_wp
  !> Shallower than this share of a facet points are closed by round-off.
  real(wp), parameter :: shallow = 1.0e-10_wp
  !> Motions that no point resists stay zero: the diagonal is raised by this share of
  !! its largest entry.
  real(wp), parameter :: resting = 1.0e-9_wp
  !> Unknowns at most: their system is dense.
  integer, parameter :: most_unknowns = 600

  !> Least squares for the rigid motions of the bodies.
  type :: fit_t
    integer :: n = 0 !! unknowns
    integer, allocatable :: first(:) !! (0:bodies) unknowns before those of a body, -1: it has none
    integer, allocatable :: rigid(:) !! (0:bodies) rigid body with a point, 0: none
    real(wp), allocatable :: a(:, :) !! (n, n) normal equations
    real(wp), allocatable :: right(:) !! (n) their right-hand side, then the motions [length]
    real(wp) :: apart = 0.0_wp !! weighted squares of what points slip and lift [length^2]
  end type fit_t

  !> One side of a contact point.
  type :: side_t
    integer :: body = 0 !! connected body, 0: none
    real(wp) :: rest(3) = 0.0_wp !! its place at rest [length]
    real(wp) :: place(3) = 0.0_wp !! its last converged place [length]
    real(wp) :: way(3) = 0.0_wp !! where supports carry it in the increment [length]
  end type side_t

contains

  !> Adds to the positions of bodies that supports do not hold the rigid motion with which closed
  !! points stay closed, and sticking ones stay where they are.
  subroutine carry_with_contact(model, system, state, found)
    type(model_t), intent(in) :: model !! pairs: the last converged state of their points
    type(system_t), intent(inout) :: system !! carried given; completed
    type(state_t), intent(in) :: state !! last converged state
    logical, intent(out) :: found !! bodies go along
    type(fit_t) :: fit
    real(wp) :: way(3, model%mesh%nodes), before
    integer :: k, info

    found = .false.
    if (.not. any(system%body%floating)) return
    way = system%position%carried - state%u
    if (all(abs(way) <= 0.0_wp)) return
    call number_motions(system, fit)
    if (fit%n == 0 .or. fit%n > most_unknowns) return
    do k = 1, size(model%pairs)
      call add_pair(model%pairs(k), model%mesh%x, way, system, fit)
    end do
    if (fit%apart <= 0.0_wp .or. all(abs(fit%right) <= 0.0_wp)) return
    before = fit%apart
    call solve_fit(fit, info)
    if (info /= 0 .or. fit%apart > fitting*before) return
    call carry(model%mesh%x, state%u, fit, system%equation, system%bulk%linear, system%body, &
      system%tools, system%position)
    found = .true.
  end subroutine carry_with_contact

  !> Numbers the motions that supports leave.
  subroutine number_motions(system, fit)
    type(system_t), intent(in) :: system !! bodies
    type(fit_t), intent(inout) :: fit !! gets first, rigid, a, right
    integer :: b

    allocate (fit%first(0:system%body%bodies), source=-1)
    allocate (fit%rigid(0:system%body%bodies), source=0)
    if (system%tools%unknowns > 0) then
      do b = 1, size(system%tools%rigid)
        if (size(system%tools%rigid(b)%unknown) > 0) fit%rigid(system%tools%rigid(b)%body) = b
      end do
    end if
    do b = 1, system%body%bodies
      if (.not. system%body%floating(b)) cycle
      fit%first(b) = fit%n
      if (fit%rigid(b) > 0) then
        fit%n = fit%n + size(system%tools%rigid(fit%rigid(b))%unknown)
      else
        fit%n = fit%n + system%body%motions(b)%n
      end if
    end do
    allocate (fit%a(fit%n, fit%n), fit%right(fit%n), source=0.0_wp)
  end subroutine number_motions

  !> Adds what the closed points of a pair want, each by its share of the pair's force: these shares
  !! balance about the middle of what rolls.
  subroutine add_pair(pair, x, way, system, fit)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: way(:, :) !! (3, nodes) of what supports carry [length]
    type(system_t), intent(in) :: system !! bodies, positions
    type(fit_t), intent(inout) :: fit !! grows
    type(side_t) :: slave, master
    real(wp) :: force(size(pair%history%old)), normal(3, 3), weight(3, 3)
    integer :: p

    do p = 1, size(force)
      force(p) = force_at(pair, p, system%position%x_old, shallow*system%scale%facet_size)
    end do
    if (all(force <= 0.0_wp)) return
    force = force/sum(force)
    do p = 1, size(force)
      if (force(p) <= 0.0_wp) cycle
      call find_sides(pair, p, x, way, system, slave, master)
      if (slave%body == master%body) cycle
      if (fit%first(slave%body) < 0 .and. fit%first(master%body) < 0) cycle
      associate (point => pair%history%old(p))
        weight(:, 1) = facet_normal(corners(system%position%x_old, &
          pair%surface%facets(:, point%target)))
        normal = dyad(weight(:, 1), weight(:, 1))
        weight = normal_share*normal
        if (point%status == status_stick .and. any(pair%friction%mu > 0.0_wp)) &
          weight = weight + identity - normal
      end associate
      call add_point(system, slave, master, force(p)*weight, fit)
    end do
  end subroutine add_pair

  !> The normal force of a point at the last converged state, 0 if it is open.
  pure real(wp) function force_at(pair, p, x, least) result(force)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) last converged positions [length]
    real(wp), intent(in) :: least !! depth that is none [length]
    real(wp) :: xi(2), gap, stiffness

    force = 0.0_wp
    associate (point => pair%history%old(p))
      if (point%status <= status_open .or. point%target == 0) return
      if (pair%segmented) then
        associate (cell => pair%history%old_cells(p))
          if (cell%slave == 0 .or. cell%area <= 0.0_wp) return
          call project_on_master(pair, point%target, x, cell_position(pair, cell, x), xi, gap)
          stiffness = pair%points%density*cell%area
        end associate
      else
        call project_on_master(pair, point%target, x, point_position(pair, p, x), xi, gap)
        stiffness = pair%points%epsilon(p)
      end if
      force = -stiffness*gap
      if (pair%augmented) force = force - point%lambda(3)
      if (force <= stiffness*least) force = 0.0_wp
    end associate
  end function force_at

  !> The two sides of a closed point.
  pure subroutine find_sides(pair, p, x, way, system, slave, master)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: way(:, :) !! (3, nodes) of what supports carry [length]
    type(system_t), intent(in) :: system !! bodies, positions
    type(side_t), intent(out) :: slave, master !! the sides
    real(wp) :: share(3)

    associate (nodes => pair%surface%facets(:, pair%history%old(p)%target))
      share = barycentric(pair%history%old(p)%apex)
      master%body = system%body%node_body(nodes(1))
      master%rest = matmul(corners(x, nodes), share)
      master%place = matmul(corners(system%position%x_old, nodes), share)
      master%way = matmul(corners(way, nodes), share)
    end associate
    if (pair%segmented) then
      associate (cell => pair%history%old_cells(p))
        slave%body = system%body%node_body(pair%points%slave_facets(1, cell%slave))
        slave%rest = cell_position(pair, cell, x)
        slave%place = cell_position(pair, cell, system%position%x_old)
        slave%way = cell_position(pair, cell, system%position%x_old + way) - slave%place
      end associate
    else
      slave%body = system%body%node_body(pair%points%point_nodes(1, p))
      slave%rest = point_field(pair, p, x)
      slave%place = point_field(pair, p, system%position%x_old)
      slave%way = point_field(pair, p, way)
    end if
  end subroutine find_sides

  !> Adds what one point wants: that its two sides go the same way.
  subroutine add_point(system, slave, master, weight, fit)
    type(system_t), intent(in) :: system !! bodies
    type(side_t), intent(in) :: slave, master !! the sides
    real(wp), intent(in) :: weight(3, 3) !! of the directions in which they should
    type(fit_t), intent(inout) :: fit !! grows
    real(wp) :: row(3, 12), apart(3)
    integer :: column(12), n

    n = 0
    call add_side(slave, 1.0_wp)
    call add_side(master, -1.0_wp)
    apart = slave%way - master%way
    fit%apart = fit%apart + dot_product(apart, matmul(weight, apart))
    fit%right(column(:n)) = fit%right(column(:n)) - matmul(apart, matmul(weight, row(:, :n)))
    fit%a(column(:n), column(:n)) = fit%a(column(:n), column(:n)) + &
      matmul(transpose(row(:, :n)), matmul(weight, row(:, :n)))

  contains

    !> The columns of one side.
    subroutine add_side(side, factor)
      type(side_t), intent(in) :: side !! the side
      real(wp), intent(in) :: factor !! 1 or -1
      real(wp), allocatable :: ways(:, :)
      integer :: k

      if (fit%first(side%body) < 0) return
      ways = ways_of(system, fit, side)
      do k = 1, size(ways, 2)
        n = n + 1
        column(n) = fit%first(side%body) + k
        row(:, n) = factor*ways(:, k)
      end do
    end subroutine add_side
  end subroutine add_point

  !> Where the motions of its body take a place.
  pure function ways_of(system, fit, side) result(ways)
    type(system_t), intent(in) :: system !! bodies
    type(fit_t), intent(in) :: fit !! which body is a rigid one
    type(side_t), intent(in) :: side !! the place
    real(wp), allocatable :: ways(:, :)
    real(wp) :: middle(3)
    integer :: k

    if (fit%rigid(side%body) > 0) then
      associate (rigid => system%tools%rigid(fit%rigid(side%body)))
        middle = system%position%x_old(:, rigid%node(1)) - matmul(rigid%old_turn, rigid%reach(:, 1))
        allocate (ways(3, size(rigid%unknown)))
        do k = 1, size(rigid%unknown)
          associate (axis => identity(:, 1 + mod(rigid%unknown(k) - 1, 3)))
            ways(:, k) = axis
            if (rigid%unknown(k) > 3) ways(:, k) = cross(axis, side%place - middle)/rigid%length
          end associate
        end do
      end associate
    else
      associate (motions => system%body%motions(side%body))
        allocate (ways(3, motions%n))
        do k = 1, 3
          ways(k, :) = mode_row(motions, k, merge(side%rest, side%place, system%bulk%linear .or. &
            motions%n < 6))
        end do
      end associate
    end if
  end function ways_of

  !> The motions, and what points still slip and lift with them.
  subroutine solve_fit(fit, info)
    type(fit_t), intent(inout) :: fit !! right becomes the motions; apart
    integer, intent(out) :: info !! not zero: none found
    real(wp) :: wanted(fit%n), raise
    integer :: k

    raise = 0.0_wp
    do k = 1, fit%n
      raise = max(raise, resting*fit%a(k, k))
    end do
    do k = 1, fit%n
      fit%a(k, k) = fit%a(k, k) + raise
    end do
    wanted = fit%right
    call dpotrf('U', fit%n, fit%a, fit%n, info)
    if (info /= 0) return
    call dtrsv('U', 'T', 'N', fit%n, fit%a, fit%n, fit%right, 1)
    call dtrsv('U', 'N', 'N', fit%n, fit%a, fit%n, fit%right, 1)
    fit%apart = fit%apart - dot_product(wanted, fit%right)
  end subroutine solve_fit

  !> Moves the bodies.
  subroutine carry(x, u_old, fit, equation, linear, body, tools, position)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u_old(:, :) !! (3, nodes) last converged displacements [length]
    type(fit_t), intent(in) :: fit !! the motions
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    logical, intent(in) :: linear !! the bulk is: bodies turn by little
    type(bodies_t), intent(in) :: body !! connected bodies
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies go along
    type(positions_t), intent(inout) :: position !! carried is moved
    real(wp) :: motion(6), turn(3, 3), middle(3)
    integer :: b, i, k

    do b = 1, body%bodies
      if (fit%first(b) < 0) cycle
      if (fit%rigid(b) > 0) then
        associate (rigid => tools%rigid(fit%rigid(b)))
          call carry_rigid(rigid, fit%right(fit%first(b) + 1:fit%first(b) + &
            size(rigid%unknown)), position%carried)
        end associate
        cycle
      end if
      associate (motions => body%motions(b), u => position%carried)
        motion = matmul(motions%basis(:, :motions%n), fit%right(fit%first(b) + 1:fit%first(b) + &
          motions%n))
        turn = rotation_matrix(motion(4:6)/motions%size) - identity
        middle = middle_of(position%x_old, body%node_body == b)
        motion(:3) = motion(:3) + cross(motion(4:6)/motions%size, middle - motions%center)
        do i = 1, size(x, 2)
          if (body%node_body(i) /= b) cycle
          if (linear .or. motions%n < 6) then
            do k = 1, 3
              if (equation(k, i) > 0) u(k, i) = u(k, i) + dot_product(mode_row(motions, k, &
                x(:, i)), fit%right(fit%first(b) + 1:fit%first(b) + motions%n))
            end do
          else
            u(:, i) = u(:, i) + motion(:3) + matmul(turn, x(:, i) + u_old(:, i) - middle)
          end if
        end do
      end associate
    end do
  end subroutine carry

  !> The mean place of the nodes of a body.
  pure function middle_of(x, mine) result(middle)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    logical, intent(in) :: mine(:) !! (nodes) it is a node of the body
    real(wp) :: middle(3)
    integer :: k

    do k = 1, 3
      middle(k) = sum(x(k, :), mine)/real(max(1, count(mine)), wp)
    end do
  end function middle_of
end module contact_carrying

!> Bodies as wholes: the balance of force and moment of each, and how far it has turned
!! (doc/theory, "Strain and rotation", eq. (13.4)).
module body_measures
  use kinds, only: wp, pi
  use vectors, only: cross
  use element_types, only: routine_none, routine_finite
  use system_types, only: system_t
  implicit none
  private
  public :: measure_bodies, find_balance, find_turns, rigid_turns, angle_of, lever_ends, &
    has_finite_strain, has_small_strain
  public :: farthest_turn

  !> A turn by a is taken for strains of a^2/2, which are none: where they exceed this share a
  !! linear theory says nothing of the body any more.
  real(wp), parameter :: most_spurious = 0.05_wp
  !> That turn [radian].
  real(wp), parameter :: farthest_turn = sqrt(2.0_wp*most_spurious)
  !> Nodes that lie in a line tell nothing of turns about it: the determinant of their inertia is
  !! round-off below this share of what that of a ball would be.
  real(wp), parameter :: in_line = 1.0e-12_wp

contains

  !> Center, reach and inverse inertia of the nodes of each body, and whether it can move.
  pure subroutine measure_bodies(x, system, center, reach, inertia, moves)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! bodies of the nodes, equations
    real(wp), allocatable, intent(out) :: center(:, :) !! (3, bodies) mean of its nodes [length]
    real(wp), allocatable, intent(out) :: reach(:) !! (bodies) farthest node [length]
    real(wp), allocatable, intent(out) :: inertia(:, :, :) !! (3, 3, bodies) inverse [1/length^2]
    logical, allocatable, intent(out) :: moves(:) !! (bodies) it has free degrees of freedom
    integer :: nodes(system%body%bodies), i, b
    real(wp) :: y(3)

    allocate (center(3, system%body%bodies), reach(system%body%bodies), inertia(3, 3, &
      system%body%bodies), source=0.0_wp)
    allocate (moves(system%body%bodies), source=.false.)
    nodes = 0
    do i = 1, size(system%body%node_body)
      b = system%body%node_body(i)
      if (b == 0) cycle
      nodes(b) = nodes(b) + 1
      center(:, b) = center(:, b) + x(:, i)
      if (any(system%equation(:, i) > 0)) moves(b) = .true.
    end do
    do b = 1, system%body%bodies
      center(:, b) = center(:, b)/real(max(nodes(b), 1), wp)
    end do
    do i = 1, size(system%body%node_body)
      b = system%body%node_body(i)
      if (b == 0) cycle
      y = x(:, i) - center(:, b)
      reach(b) = max(reach(b), norm2(y))
      inertia(:, :, b) = inertia(:, :, b) + inertia_of(y)
    end do
    do b = 1, system%body%bodies
      inertia(:, :, b) = inverse(inertia(:, :, b))
    end do
  end subroutine measure_bodies

  !> y.y I - y y^T.
  pure function inertia_of(y) result(m)
    real(wp), intent(in) :: y(3) !! from the center [length]
    real(wp) :: m(3, 3)
    integer :: i

    m = -spread(y, 2, 3)*spread(y, 1, 3)
    do i = 1, 3
      m(i, i) = m(i, i) + dot_product(y, y)
    end do
  end function inertia_of

  !> Inverse of a symmetric positive definite matrix.
  pure function inverse(a) result(b)
    real(wp), intent(in) :: a(3, 3) !! the matrix
    real(wp) :: b(3, 3), determinant

    b(:, 1) = cross(a(:, 2), a(:, 3))
    b(:, 2) = cross(a(:, 3), a(:, 1))
    b(:, 3) = cross(a(:, 1), a(:, 2))
    determinant = dot_product(a(:, 1), b(:, 1))
    if (determinant > in_line*((a(1, 1) + a(2, 2) + a(3, 3))/3.0_wp)**3) then
      b = b/determinant
    else
      b = 0.0_wp
    end if
  end function inverse

  !> Sum of loads, reactions and contact forces on each body, and of their moments about its center
  !! with levers of the reference positions where strain is small, of the present ones else: what
  !! the stresses of the body balance.
  pure subroutine find_balance(x, system, center, balance, reaction)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(system_t), intent(in) :: system !! external, contact_force
    real(wp), intent(in) :: center(:, :) !! (3, bodies) where moments are taken about [length]
    real(wp), intent(out) :: balance(:, :) !! (6, bodies) sum of forces and of moments
    real(wp), intent(in), optional :: reaction(:, :) !! (3, nodes) forces of the supports [force]
    real(wp) :: f(3)
    integer :: i, b

    balance = 0.0_wp
    do i = 1, size(system%body%node_body)
      b = system%body%node_body(i)
      if (b == 0) cycle
      f = system%loads%external(:, i)
      if (present(reaction)) f = f + reaction(:, i)
      f = f - system%contact_force(:, i)
      if (all(abs(f) <= 0.0_wp)) cycle
      balance(1:3, b) = balance(1:3, b) + f
      balance(4:6, b) = balance(4:6, b) + cross(x(:, i) - center(:, b), f)
    end do
  end subroutine find_balance

  !> Angle that each body has turned as a whole: that of the rigid motion next to its displacements.
  pure subroutine find_turns(x, u, node_body, center, inertia, angle)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: node_body(:) !! (nodes) body, 0 for none
    real(wp), intent(in) :: center(:, :) !! (3, bodies) mean of its nodes [length]
    real(wp), intent(in) :: inertia(:, :, :) !! (3, 3, bodies) inverse inertia of its nodes
    real(wp), intent(out) :: angle(:) !! (bodies) [degree]
    real(wp) :: turn(3, size(angle))
    integer :: i, b

    turn = 0.0_wp
    do i = 1, size(node_body)
      b = node_body(i)
      if (b > 0) turn(:, b) = turn(:, b) + cross(x(:, i) - center(:, b), u(:, i))
    end do
    do b = 1, size(angle)
      angle(b) = angle_of(turn(:, b), inertia(:, :, b))
    end do
  end subroutine find_turns

  !> Vectors of the rigid turns next to two fields, of each body by those of its nodes that count;
  !! zero where these lie in a line.
  pure subroutine rigid_turns(x, u, v, node_body, counted, turn_u, turn_v)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :), v(:, :) !! (3, nodes) displacements [length]
    integer, intent(in) :: node_body(:) !! (nodes) body, 0 for none
    logical, intent(in) :: counted(:) !! (nodes) its displacements are known
    real(wp), intent(out) :: turn_u(:, :), turn_v(:, :) !! (3, bodies) sine of the angle is their
    !! length
    real(wp) :: center(3, size(turn_u, 2)), inertia(3, 3, size(turn_u, 2)), y(3)
    integer :: nodes(size(turn_u, 2)), i, b

    center = 0.0_wp
    inertia = 0.0_wp
    turn_u = 0.0_wp
    turn_v = 0.0_wp
    nodes = 0
    do i = 1, size(node_body)
      b = node_body(i)
      if (b == 0 .or. .not. counted(i)) cycle
      nodes(b) = nodes(b) + 1
      center(:, b) = center(:, b) + (x(:, i) - center(:, b))/real(nodes(b), wp)
    end do
    do i = 1, size(node_body)
      b = node_body(i)
      if (b == 0 .or. .not. counted(i)) cycle
      y = x(:, i) - center(:, b)
      inertia(:, :, b) = inertia(:, :, b) + inertia_of(y)
      turn_u(:, b) = turn_u(:, b) + cross(y, u(:, i))
      turn_v(:, b) = turn_v(:, b) + cross(y, v(:, i))
    end do
    do b = 1, size(nodes)
      inertia(:, :, b) = inverse(inertia(:, :, b))
      turn_u(:, b) = matmul(inertia(:, :, b), turn_u(:, b))
      turn_v(:, b) = matmul(inertia(:, :, b), turn_v(:, b))
    end do
  end subroutine rigid_turns

  !> Angle of a body from the sum of (x - center) x u over its nodes.
  pure real(wp) function angle_of(turn, inertia) result(angle)
    real(wp), intent(in) :: turn(3) !! the sum [length^2]
    real(wp), intent(in) :: inertia(3, 3) !! inverse inertia of its nodes [1/length^2]

    angle = asin(min(1.0_wp, norm2(matmul(inertia, turn))))*180.0_wp/pi
  end function angle_of

  !> Where forces act: at the reference positions in bodies whose small strains balance them
  !! there, else (finite strain, or a body that does not deform) at the present ones.
  pure function lever_ends(x, u, system) result(y)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(system_t), intent(in) :: system !! bulk elements, bodies
    real(wp) :: y(3, size(u, 2))
    logical :: small(0:system%body%bodies)

    small = has_small_strain(system)
    y = x(:, :size(u, 2)) + merge(0.0_wp, u, spread(small(system%body%node_body), 1, 3))
  end function lever_ends

  !> Bodies that deform, and whose elements are all of small strain.
  pure function has_small_strain(system) result(small)
    type(system_t), intent(in) :: system !! bulk elements, bodies, equations
    logical :: small(0:system%body%bodies)
    integer :: k, b

    small = .false.
    do k = 1, system%bulk%n
      if (system%bulk%routine(k) == routine_none) cycle
      b = system%body%node_body(system%bulk%ix(1, k))
      if (small(b)) cycle
      small(b) = any(system%equation(:, system%bulk%ix(:system%bulk%nel(k), k)) > 0)
      if (.not. small(b)) cycle
      if (all(small(1:))) exit
    end do
    small = small .and. .not. has_finite_strain(system)
  end function has_small_strain

  !> Bodies with elements of finite strain.
  pure function has_finite_strain(system) result(finite)
    type(system_t), intent(in) :: system !! bulk elements, bodies
    logical :: finite(0:system%body%bodies)
    integer :: k

    finite = .false.
    if (system%bulk%linear) return
    do k = 1, system%bulk%n
      if (system%bulk%routine(k) == routine_finite) finite(system%body%node_body(system%bulk%ix(1, &
        k))) = .true.
    end do
  end function has_finite_strain
end module body_measures

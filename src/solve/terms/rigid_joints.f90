!> The bodies that contact alone holds, taken as rigid, and the places at which contact or supports
!! may act on them (doc/theory, "Static admissibility").
module rigid_joints
  use kinds, only: wp
  use vectors, only: cross
  use loads, only: conditions_at
  use facet_geometry, only: project_on_facet, facet_normal, corners
  use facet_tree, only: facet_tree_t, fit_tree, nearest_facet
  use contact_types, only: pair_t
  use contact_points, only: is_first, count_points, point_position, longest_facet
  use model_types, only: model_t
  use springs, only: is_supported
  use system_types, only: system_t
  implicit none
  private
  public :: joint_t, assembly_t, find_parts, find_joints, keep_nearest, loads_on, wrench

  !> A point may lie outside of its facet by this share of the facet.
  real(wp), parameter :: outside_share = 1.0e-6_wp

  !> Where two bodies may press on each other, or a support holds one.
  type :: joint_t
    real(wp) :: place(3) = 0.0_wp !! where [length]
    real(wp) :: normal(3) = 0.0_wp !! unit vector: the way in which the slave is pressed
    real(wp) :: mu = 0.0_wp !! coefficient of friction, the larger of the two
    logical :: support = .false. !! a support, which has no friction
    real(wp) :: gap = 0.0_wp !! how far its sides are apart, over the longest facet of the pair
    integer :: pair = 0 !! contact pair, 0 for a support
    integer :: sides(2) = 0 !! floating bodies, slave and master, 0 for one that supports hold
  end type joint_t

  !> The floating bodies and their joints.
  type :: assembly_t
    integer, allocatable :: body(:) !! body of the system
    real(wp), allocatable :: center(:, :) !! (3, bodies) where moments are taken [length]
    real(wp), allocatable :: length(:) !! size of each body [length]
    type(joint_t), allocatable :: joints(:) !! all joints
    integer :: n = 0 !! joints in use
  end type assembly_t

contains

  !> The floating bodies, their middles and sizes.
  subroutine find_parts(system, parts)
    type(system_t), intent(in) :: system !! bodies, positions
    type(assembly_t), intent(out) :: parts !! gets body, center, length
    real(wp) :: low(3), high(3)
    integer :: b, i, k

    parts%body = pack([(b, b=1, system%body%bodies)], system%body%floating)
    allocate (parts%center(3, size(parts%body)), parts%length(size(parts%body)))
    do k = 1, size(parts%body)
      low = huge(1.0_wp)
      high = -huge(1.0_wp)
      do i = 1, size(system%body%node_body)
        if (system%body%node_body(i) /= parts%body(k)) cycle
        low = min(low, system%position%x_old(:, i))
        high = max(high, system%position%x_old(:, i))
      end do
      parts%center(:, k) = 0.5_wp*(low + high)
      parts%length(k) = max(0.5_wp*norm2(high - low), tiny(1.0_wp))
    end do
  end subroutine find_parts

  !> Place of a body among the floating ones, 0 for one that supports hold.
  pure integer function part_of(parts, body) result(k)
    type(assembly_t), intent(in) :: parts !! floating bodies
    integer, intent(in) :: body !! body of the system

    k = findloc(parts%body, body, 1)
  end function part_of

  !> Forces and moments on the floating bodies, moments over the size of the body.
  function loads_on(model, system, time, parts) result(loads)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! positions, equations
    real(wp), intent(in) :: time !! their time
    type(assembly_t), intent(in) :: parts !! floating bodies
    real(wp) :: loads(6*size(parts%body)), force(3, size(system%body%node_body))
    integer :: i, k

    loads = 0.0_wp
    call conditions_at(model, time, force=force)
    where (system%equation == 0) force = 0.0_wp
    do i = 1, size(system%body%node_body)
      k = part_of(parts, system%body%node_body(i))
      if (k == 0) cycle
      loads(6*k - 5:6*k) = loads(6*k - 5:6*k) + wrench(parts, k, system%position%x_old(:, i), &
        force(:, i))
    end do
  end function loads_on

  !> Force and moment of a force at a place on floating body k.
  pure function wrench(parts, k, place, force) result(w)
    type(assembly_t), intent(in) :: parts !! floating bodies
    integer, intent(in) :: k !! the body
    real(wp), intent(in) :: place(3) !! where [length]
    real(wp), intent(in) :: force(3) !! the force
    real(wp) :: w(6)

    w = [force, cross(place - parts%center(:, k), force)/parts%length(k)]
  end function wrench

  !> All places at which contact or supports may act on floating bodies.
  subroutine find_joints(model, system, parts)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! positions, equations
    type(assembly_t), intent(inout) :: parts !! gets the joints
    type(joint_t) :: joint
    integer :: i, k, p

    allocate (parts%joints(64))
    joint%support = .true.
    do i = 1, size(system%body%node_body)
      joint%sides = [part_of(parts, system%body%node_body(i)), 0]
      if (joint%sides(1) == 0) cycle
      joint%place = system%position%x_old(:, i)
      do k = 1, 3
        if (.not. is_supported(system, k, i)) cycle
        joint%normal = 0.0_wp
        joint%normal(k) = 1.0_wp
        call keep(parts, joint)
        joint%normal = -joint%normal
        call keep(parts, joint)
      end do
    end do
    do p = 1, size(model%pairs)
      i = parts%n
      call joints_of_pair(model%pairs(p), system, parts)
      parts%joints(i + 1:parts%n)%pair = p
    end do
  end subroutine find_joints

  !> Leaves of the joints of a pair between two bodies those that touch, or would touch first: where
  !! an edge stands on a surface the points of its facets lie a little above.
  subroutine keep_nearest(parts, within)
    type(assembly_t), intent(inout) :: parts !! loses joints
    real(wp), intent(in) :: within !! so much farther than the nearest may stay, over the facet
    logical :: stays(parts%n)
    integer :: i

    associate (joints => parts%joints(:parts%n))
      do i = 1, parts%n
        stays(i) = joints(i)%gap <= within + minval(joints%gap, joints%pair == joints(i)%pair &
          .and. joints%sides(1) == joints(i)%sides(1) .and. joints%sides(2) == joints(i)%sides(2))
      end do
    end associate
    parts%joints = pack(parts%joints(:parts%n), stays)
    parts%n = size(parts%joints)
  end subroutine keep_nearest

  !> The places of one pair: its points, or with SEGMent the corners of its slave facets.
  subroutine joints_of_pair(pair, system, parts)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! positions
    type(assembly_t), intent(inout) :: parts !! gets the joints
    type(facet_tree_t) :: tree
    real(wp) :: reach
    integer :: p, i

    tree = pair%surface%tree
    call fit_tree(tree, pair%surface%facets, system%position%x_old)
    reach = longest_facet(pair, system%position%x_old)
    if (pair%segmented) then
      do p = 1, size(pair%points%slave_facets, 2)
        do i = 1, 3
          call add_joint(pair, system, tree, reach, pair%points%slave_facets(i, p), &
            system%position%x_old(:, pair%points%slave_facets(i, p)), parts)
        end do
      end do
    else
      do p = 1, count_points(pair)
        if (is_first(pair, p)) call add_joint(pair, system, tree, reach, &
          pair%points%point_nodes(1, p), point_position(pair, p, system%position%x_old), parts)
      end do
    end if
  end subroutine joints_of_pair

  !> One place, if there is master below it. The cells of SEGMent end where the master does.
  subroutine add_joint(pair, system, tree, reach, node, y, parts)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! positions
    type(facet_tree_t), intent(in) :: tree !! of the master, fitted
    real(wp), intent(in) :: reach !! farther than this nothing touches [length]
    integer, intent(in) :: node !! a node of the slave
    real(wp), intent(in) :: y(3) !! the place [length]
    type(assembly_t), intent(inout) :: parts !! gets the joint
    type(joint_t) :: joint
    real(wp) :: xi(2), weights(3), gap, distance, x(3, 3)
    integer :: facet

    call nearest_facet(tree, pair%surface%facets, system%position%x_old, y, facet, distance)
    if (facet == 0 .or. distance > reach) return
    joint%sides = [part_of(parts, system%body%node_body(node)), &
      part_of(parts, system%body%node_body(pair%surface%facets(1, facet)))]
    if (all(joint%sides == 0)) return
    x = corners(system%position%x_old, pair%surface%facets(:, facet))
    call project_on_facet(x, y, xi, gap)
    weights = [xi, 1.0_wp - sum(xi)]
    if (any(weights < -outside_share) .and. .not. pair%segmented) return
    weights = max(weights, 0.0_wp)
    joint%place = matmul(x, weights/sum(weights))
    joint%normal = facet_normal(x)
    joint%mu = maxval(pair%friction%mu)
    joint%gap = max(gap, 0.0_wp)/reach
    call keep(parts, joint)
  end subroutine add_joint

  !> Adds a joint to the list.
  pure subroutine keep(parts, joint)
    type(assembly_t), intent(inout) :: parts !! gets the joint
    type(joint_t), intent(in) :: joint !! the joint
    type(joint_t), allocatable :: more(:)

    if (parts%n == size(parts%joints)) then
      allocate (more(2*parts%n))
      more(:parts%n) = parts%joints
      call move_alloc(more, parts%joints)
    end if
    parts%n = parts%n + 1
    parts%joints(parts%n) = joint
  end subroutine keep
end module rigid_joints

!> Forces and multipliers of the points of one pair in the axes of its multiplier field, and what
!! the field's conditions leave of them (doc/theory, "Multiplier fields", eq. (7.11)).
module point_forces
  use kinds, only: wp
  use element_types, only: status_open, routine_none
  use model_types, only: model_t
  use contact_points, only: count_points
  use element_lists, only: master_nodes
  use facet_geometry, only: facet_frame, facet_normal, facet_size, corners, project_on_facet, &
    barycentric
  use multiplier_field, only: multiplier_field_t, node_hold_t, make_field, gather_forces, &
    project_forces
  use system_types, only: system_t
  implicit none
  private
  public :: measure_field, point_forces_t, take_forces

  !> A vector whose points have less than this share of the largest stiffness counts as if it had
  !! so much: a gap over next to nothing of the surface is none.
  real(wp), parameter :: least_weight_share = 1.0e-3_wp
  !> A node whose shape function is no more than this has no part in a place.
  real(wp), parameter :: no_shape_share = 1.0e-6_wp

  !> Forces of the points of a pair at a converged state.
  type :: point_forces_t
    type(multiplier_field_t) :: field !! vectors at the slave nodes
    real(wp), allocatable :: force(:, :) !! (3, points) in global axes [force]
    real(wp), allocatable :: multiplier(:, :) !! (3, points) its part that is the multiplier [force]
    real(wp), allocatable :: frame(:, :, :) !! (3, 3, points) frames of the targets
    logical, allocatable :: near(:) !! (points) there is a facet
    real(wp) :: facet = 0.0_wp !! longest edge of the smallest facet in touch [length]
  end type point_forces_t

contains

  !> Forces, multipliers and field of the points of a pair.
  pure subroutine take_forces(model, system, k, stress, at)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! contact elements and u
    integer, intent(in) :: k !! the pair
    real(wp), intent(in) :: stress(:, :) !! (n_element_stress, points) their state
    type(point_forces_t), intent(out) :: at !! the points
    real(wp), allocatable :: normal(:, :), facing(:, :), x(:, :)
    type(node_hold_t) :: hold(3, count_points(model%pairs(k)))
    integer :: p, element, n, b

    n = count_points(model%pairs(k))
    x = model%mesh%x + system%u
    allocate (at%force(3, n), at%multiplier(3, n), at%frame(3, 3, n), source=0.0_wp)
    allocate (normal(3, n), facing(3, n), source=0.0_wp)
    allocate (at%near(n), source=.false.)
    at%facet = huge(1.0_wp)
    do p = 1, n
      element = system%place%first_point(k) + p - 1
      if (system%contact%routine(element) == routine_none) cycle
      associate (nodes => master_nodes(system%contact, element))
        at%near(p) = .true.
        at%frame(:, :, p) = facet_frame(x(:, nodes))
        at%multiplier(:, p) = matmul(at%frame(:, :, p), model%pairs(k)%history%new(p)%lambda)
        at%force(:, p) = stress(1:3, p)
        normal(:, p) = stress(10:12, p)
        facing(:, p) = facet_normal(model%mesh%x(:, nodes))
        do b = 1, 3
          hold(b, p) = hold_at(x, system, model%pairs(k)%points%point_nodes(b, p), &
            system%contact%ix(model%pairs(k)%points%n_slaves + 1:system%contact%nel(element), &
            element))
        end do
        if (system%contact%status(element) > status_open) at%facet = min(at%facet, &
          facet_size(model%mesh%x(:, nodes)))
      end associate
    end do
    call make_field(model%pairs(k), at%near, facing, normal, at%field, hold)
  end subroutine take_forces

  !> Which motions the supports leave neither to a slave node nor to the master facet below it
  !! there: of its nodes those count whose shape functions do not vanish at the node's projection.
  pure type(node_hold_t) function hold_at(x, system, node, facet) result(hold)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(system_t), intent(in) :: system !! equations, rigid bodies
    integer, intent(in) :: node !! the slave node
    integer, intent(in) :: facet(:) !! (3 or 6) nodes of the master facet, 0 for none
    real(wp) :: xi(2), gap, n(3)
    integer :: i

    call project_on_facet(corners(x, facet(1:3)), x(:, node), xi, gap)
    n = barycentric(xi)
    hold%inside = minval(n)
    hold%along = .not. moves(system, node)
    do i = 1, size(facet)
      if (facet(i) == 0) cycle
      if (n(modulo(i - 1, 3) + 1) <= no_shape_share) cycle
      if (i > 3) then
        if (n(modulo(i - 3, 3) + 1) <= no_shape_share) cycle
      end if
      hold%along = hold%along .and. .not. moves(system, facet(i))
    end do
  end function hold_at

  !> The axes along which a node may move: it is free there, or its body is rigid.
  pure function moves(system, node) result(free)
    type(system_t), intent(in) :: system !! equations, rigid bodies
    integer, intent(in) :: node !! the node
    logical :: free(3)

    free = system%equation(:, node) > 0
    if (.not. allocated(system%tools%carried_by)) return
    if (system%tools%carried_by(node) > 0) free = .true.
  end function moves

  !> The multipliers that take over the forces of a pair, and what the present ones leave to the
  !! penalty, weighed at the vectors of the field.
  pure subroutine measure_field(model, system, k, stress, multiplier, gap, change, force)
    type(model_t), intent(in) :: model !! pairs with their working points
    type(system_t), intent(in) :: system !! contact elements and u
    integer, intent(in) :: k !! the pair
    real(wp), intent(in) :: stress(:, :) !! (n_element_stress, points) state of its points
    real(wp), intent(out) :: multiplier(:, :) !! (3, points) in the frames of their targets [force]
    real(wp), intent(out) :: gap !! largest weighted gap over the facet's size
    real(wp), intent(out) :: change !! largest change of the multipliers at a vector [force]
    real(wp), intent(out) :: force !! largest force at a vector [force]
    type(point_forces_t) :: at
    integer :: i, p

    call take_forces(model, system, k, stress, at)
    call project_forces(model%pairs(k), at%field, at%force, multiplier)
    gap = 0.0_wp
    change = 0.0_wp
    force = 0.0_wp
    associate (taken => gather_forces(at%field, multiplier), &
               rest => gather_forces(at%field, multiplier - at%multiplier))
      do i = 1, at%field%n
        change = max(change, norm2(rest(:, i)))
        force = max(force, norm2(taken(:, i)))
        gap = max(gap, norm2(rest(:, i))/max(at%field%stiffness(i), least_weight_share &
          *maxval(at%field%stiffness)))
      end do
      gap = gap/(model%pairs(k)%history%raise*at%facet)
    end associate
    do p = 1, size(at%near)
      if (at%near(p)) multiplier(:, p) = matmul(multiplier(:, p), at%frame(:, :, p))
    end do
  end subroutine measure_field
end module point_forces

!> Fields of one time from the state: of the bodies, and of the contact points.
module frame_fields
  use kinds, only: wp
  use vectors, only: cross
  use contact_types, only: pair_t
  use contact_points, only: count_points, point_position, point_field
  use contact_parameters, only: point_parameters
  use facet_geometry, only: facet_frame
  use friction_axes, only: axes_t, find_axes
  use smooth_normals, only: project_on_master
  use surface_lay, only: add_surface_lay
  use model_types, only: model_t
  use master_facets, only: field_on_facet
  use system_types, only: system_t, state_t
  use body_fields, only: fields_of_bodies, n_body_fields
  use von_mises_stress, only: von_mises
  use result_types, only: frame_t
  use point_fields, only: point_fields_t, has_offset, has_lift
  use element_parameters, only: d03_epsilon
  use element_types, only: status_open
  use touch_types, only: touch_waits
  implicit none
  private
  public :: fill_frame, fill_points, fill_first_frame

contains

  !> The fields that the deck asks for.
  subroutine fill_frame(model, system, state, point_state, stress, strain, nodal, frame)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! the system
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of elmt03
    real(wp), allocatable, intent(inout) :: stress(:, :) !! (6, elements) goes to the frame
    real(wp), allocatable, intent(inout) :: strain(:, :) !! (6, elements) goes to the frame
    real(wp), allocatable, intent(in) :: nodal(:, :) !! (6 or 12, nodes) stress and strain
    type(frame_t), intent(out) :: frame !! the fields
    integer :: k

    do k = 1, n_body_fields
      if (model%output%field(k)) call fill_field(fields_of_bodies(k)%name, model, state, &
        stress, nodal, frame%body(k)%values)
    end do
    ! the last ones: others are formed from them
    do k = 1, n_body_fields
      if (.not. model%output%field(k)) cycle
      if (fields_of_bodies(k)%name == 'stress') call move_alloc(stress, frame%body(k)%values)
      if (fields_of_bodies(k)%name == 'strain') call move_alloc(strain, frame%body(k)%values)
    end do
    if (.not. model%output%contact) return
    allocate (frame%pairs(size(model%pairs)))
    if (size(model%pairs) > 0) frame%motion = state%u
    frame%began = state%began
    do k = 1, size(model%pairs)
      call fill_points(model%pairs(k), model%mesh%x, state%u, point_state(:, &
        system%place%first_point(k):system%place%first_point(k + 1) - 1), frame%pairs(k))
      call fill_begin(model%pairs(k), system, k, frame%pairs(k))
      if (touches_first(system, k)) call fill_touch(model%mesh%x, system, k, &
        frame%pairs(k))
    end do
  end subroutine fill_frame

  !> What the law of each point had besides the displacements, for those who check a result.
  subroutine fill_begin(pair, system, k, points)
    type(pair_t), intent(in) :: pair !! the pair
    type(system_t), intent(in) :: system !! its contact elements, as they have been solved
    integer, intent(in) :: k !! its number among the pairs
    type(point_fields_t), intent(inout) :: points !! gets start, offset, lift, multiplier, patch
    integer :: first, last, p

    first = system%place%first_point(k)
    last = system%place%first_point(k + 1) - 1
    associate (list => system%contact)
      points%start = list%h1(:, pack([(p, p=first, last)], points%status > status_open))
      if (has_offset(pair)) points%offset = pack(list%offset(first:last), points%target > 0)
      if (has_lift(pair)) points%lift = pack(list%lift(first:last), points%target > 0)
      if (pair%augmented) points%multiplier = list%shift(:, first:last) &
        *spread(list%d(d03_epsilon, first:last), 1, 3)
    end associate
    if (pair%smooth) points%patch = pair%surface%patch(:, targets_of(points%target, &
      size(pair%surface%facets, 2)))
  end subroutine fill_begin

  !> Whether the increment has asked where points of a pair touch first.
  pure logical function touches_first(system, k) result(touches)
    type(system_t), intent(in) :: system !! as it has been solved
    integer, intent(in) :: k !! number of the pair

    touches = .false.
    if (.not. (allocated(system%touch%waits) .and. allocated(system%touch%x_end))) return
    touches = any(system%touch%waits(:, k)) .and. system%touch%stage /= touch_waits
  end function touches_first

  !> The ways of the nodes of closed points to a first touch.
  subroutine fill_touch(x, system, k, points)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! its contact elements, as they have been solved
    integer, intent(in) :: k !! number of the pair
    type(point_fields_t), intent(inout) :: points !! gets touch_node, touch
    logical :: used(size(x, 2))
    integer :: p, i

    used = .false.
    associate (list => system%contact, first => system%place%first_point(k))
      do p = first, system%place%first_point(k + 1) - 1
        if (points%status(p - first + 1) > status_open) used(list%ix(:list%nel(p), p)) = .true.
      end do
    end associate
    points%touch_node = pack([(i, i=1, size(x, 2))], used)
    allocate (points%touch(4, size(points%touch_node)))
    do i = 1, size(points%touch_node)
      associate (n => points%touch_node(i), touch => system%touch)
        points%touch(:3, i) = touch%x_end(:, n) - x(:, n)
        points%touch(4, i) = merge(touch%start(system%body%node_body(n), k), -1.0_wp, &
          touch%waits(system%body%node_body(n), k))
      end associate
    end do
  end subroutine fill_touch

  !> The facets that hold points, in their order.
  pure function targets_of(target, facets) result(list)
    integer, intent(in) :: target(:) !! (points) facet of each, 0 for none
    integer, intent(in) :: facets !! number of facets
    integer, allocatable :: list(:)
    logical :: used(0:facets)
    integer :: f

    used = .false.
    used(target) = .true.
    list = pack([(f, f=1, facets)], used(1:))
  end function targets_of

  !> One field of the bodies, unless it is that of the elements itself.
  subroutine fill_field(name, model, state, stress, nodal, values)
    character(*), intent(in) :: name !! its name in fields_of_bodies
    type(model_t), intent(in) :: model !! the problem
    type(state_t), intent(in) :: state !! the converged state
    real(wp), allocatable, intent(in) :: stress(:, :) !! (6, elements)
    real(wp), allocatable, intent(in) :: nodal(:, :) !! (6 or 12, nodes) stress and strain
    real(wp), allocatable, intent(out) :: values(:, :) !! (components, nodes or elements)

    select case (name)
    case ('displacement')
      values = state%u
    case ('reaction')
      values = state%reaction
    case ('von_mises')
      values = von_mises(stress)
    case ('nodal_stress')
      values = nodal(:6, :)
    case ('nodal_von_mises')
      values = von_mises(nodal(:6, :))
    case ('nodal_strain')
      values = nodal(7:, :)
    case ('lay')
      call fill_lay(model, state, values)
    end select
  end subroutine fill_field

  !> The contact points of one pair.
  subroutine fill_points(pair, x, u, point_state, points)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of elmt03
    type(point_fields_t), intent(out) :: points !! the points

    call place_points(pair, points)
    points%traction = -point_state(1:3, :)
    points%gap = point_state(4, :)
    points%lay = point_state(7:9, :)
    points%normal = point_state(10:12, :)
    points%normal_force = point_state(13, :)
    points%elastic_slip = point_state(5, :)
    points%lay_traction = in_lay_frame(point_state)
    call find_slips(pair, x, u, points)
  end subroutine fill_points

  !> Where the points of a pair are, and what they remember.
  subroutine place_points(pair, points)
    type(pair_t), intent(in) :: pair !! the pair
    type(point_fields_t), intent(inout) :: points !! gets what the pair keeps
    integer :: n, p

    n = count_points(pair)
    points%target = pair%history%old%target
    points%status = pair%history%old%status
    points%dissipation = pair%history%old%dissipation
    points%path = pair%history%old%path
    points%way = reshape([(pair%history%old(p)%way, p=1, n)], [3, n])
    points%apex = reshape([pair%history%old%apex(1), pair%history%old%apex(2)], [2, n], order=[2, &
      1])
    points%area = spread(1.0_wp, 1, n)
    points%facet = spread(0, 1, n)
    if (pair%segmented) then
      points%node = pair%points%point_nodes
      points%weight = pair%points%point_weights
      points%place = reshape([(pair%history%cells(p)%place, p=1, n)], [2, n])
      points%facet = merge(pair%history%cells%slave, -1, pair%history%cells%slave > 0)
      points%area = pair%points%area
      points%cell = merge(pair%history%cells%area, 0.0_wp, pair%history%cells%slave > 0)
    else if (pair%points%n_slaves > 1) then
      points%facet = [(1 + mod(p - 1, n/pair%points%slots)/pair%facet_points, p=1, n)]
      points%area = pair%points%area
    end if
  end subroutine place_points

  !> The displacement of each point against the place of the master under it, along the master.
  subroutine find_slips(pair, x, u, points)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(point_fields_t), intent(inout) :: points !! target and normal given; gets slip
    real(wp) :: y(3), xi(2), gap
    real(wp), allocatable :: moved(:, :)
    integer :: p

    allocate (points%slip(3, count_points(pair)), source=0.0_wp)
    moved = x(:, :size(u, 2)) + u
    do p = 1, count_points(pair)
      if (points%target(p) == 0) cycle
      associate (e => points%normal(:, p))
        call project_on_master(pair, points%target(p), moved, point_position(pair, p, moved), xi, &
          gap)
        y = point_field(pair, p, u) - field_on_facet(pair, points%target(p), x, u, xi)
        points%slip(:, p) = y - dot_product(y, e)*e
      end associate
    end do
  end subroutine find_slips

  !> What there is to see before the first increment: gaps and the lay.
  subroutine fill_first_frame(model, frame)
    type(model_t), intent(in) :: model !! pairs with their first targets
    type(frame_t), intent(out) :: frame !! fields at rest
    integer :: k, n

    allocate (frame%pairs(size(model%pairs)))
    allocate (frame%motion(3, model%mesh%nodes), source=0.0_wp)
    do k = 1, size(model%pairs)
      n = count_points(model%pairs(k))
      associate (points => frame%pairs(k))
        call place_points(model%pairs(k), points)
        allocate (points%traction(3, n), points%slip(3, n), points%lay(3, n), &
          points%normal(3, n), points%gap(n), points%normal_force(n), source=0.0_wp)
        call find_first_gaps(model%pairs(k), model%mesh%x, points)
      end associate
    end do
  end subroutine fill_first_frame

  !> Gaps, normals and lay of the points of a pair at rest.
  subroutine find_first_gaps(pair, x, points)
    type(pair_t), intent(in) :: pair !! the pair with its first targets
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(point_fields_t), intent(inout) :: points !! gets gap, normal and lay
    type(axes_t) :: axes
    real(wp) :: xi(2), frame(3, 3)
    integer :: p

    do p = 1, count_points(pair)
      if (points%target(p) == 0) cycle
      associate (corners => pair%surface%facets(:, points%target(p)), y => point_position(pair, &
        p, x))
        call project_on_master(pair, points%target(p), x, y, xi, points%gap(p))
        frame = facet_frame(x(:, corners))
        points%normal(:, p) = frame(:, 3)
        call find_axes(point_parameters(pair, p, points%target(p)), x(:, corners(1)) - x(:, &
          corners(3)), x(:, corners(2)) - x(:, corners(3)), frame(:, 3), xi, y, axes)
        points%lay(:, p) = axes%p(:, 1)
      end associate
    end do
  end subroutine find_first_gaps

  !> The lay of the master surfaces at their nodes, zero elsewhere.
  pure subroutine fill_lay(model, state, lay)
    type(model_t), intent(in) :: model !! mesh and pairs
    type(state_t), intent(in) :: state !! the converged state
    real(wp), allocatable, intent(out) :: lay(:, :) !! (3, nodes) unit vectors
    integer :: k, n

    allocate (lay(3, size(state%u, 2)), source=0.0_wp)
    do k = 1, size(model%pairs)
      call add_surface_lay(model%pairs(k), model%mesh%x(:, :size(lay, 2)) + state%u, lay)
    end do
    do n = 1, size(lay, 2)
      if (any(abs(lay(:, n)) > 0.0_wp)) lay(:, n) = lay(:, n)/norm2(lay(:, n))
    end do
  end subroutine fill_lay

  !> Forces on the slave side along p1, p2 = e x p1 and e, as the law of friction has them: on a
  !! curved facet the force of a point at its apex is by s^2/(2 R) of the penalty longer along e
  !! than the depth from which the cone has its radius.
  pure function in_lay_frame(points) result(f)
    real(wp), intent(in) :: points(:, :) !! (n_element_stress, points) of elmt03
    real(wp) :: f(3, size(points, 2))
    integer :: p

    do p = 1, size(points, 2)
      associate (force => points(1:3, p), p1 => points(7:9, p), e => points(10:12, p))
        f(:, p) = [-dot_product(force, p1), -dot_product(force, cross(e, p1)), points(13, p)]
      end associate
    end do
  end function in_lay_frame
end module frame_fields

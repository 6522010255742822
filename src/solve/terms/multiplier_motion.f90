!> Multipliers that come along with Newton's iteration: displacements u and multipliers lambda of
!! one direction solve K du + G dlambda = -R and lambda + dlambda = P (f + df) together (doc/theory,
!! "Simultaneous multiplier update", eqs. (7.5), (7.6)).
module multiplier_motion
  use kinds, only: wp
  use vectors, only: product_of
  use element_types, only: element_t, task_stress, n_element_stress, routine_none
  use model_types, only: model_t
  use contact_parameters, only: shifts_gap, has_field, point_shift
  use contact_types, only: contact_point_t, pair_t
  use contact_points, only: count_points
  use assembly, only: shift_derivatives, recover
  use multiplier_field, only: project_forces
  use point_forces, only: point_forces_t, take_forces
  use rigid_bodies, only: nothing_deforms
  use gmres, only: gmres_t, begin_gmres, add_image, gmres_solution
  use system_types, only: form_t, system_t
  use element_lists, only: element_list_t
  use system_parts, only: contact_places_t, rigid_part_t
  use multiplier_types, only: multiplier_motion_t
  implicit none
  private
  public :: take_multipliers, add_multipliers, multipliers_fit, hand_back_multipliers

  !> Shares of what the multipliers lack that a direction may leave.
  real(wp), parameter :: finest_multipliers = 1.0e-8_wp, coarsest_multipliers = 1.0e-2_wp
  !> Below this share of the forces nothing is lacking, and below this share of what may be lacking
  !! when multipliers fit.
  real(wp), parameter :: least_multiplier_share = 1.0e-12_wp, share_of_fitting = 0.1_wp
  !> Where cubes meet at an edge more gaps are to be closed than forces can do something about:
  !! these patterns of multipliers meet this compliance over the penalty's.
  real(wp), parameter :: own_share = 1.0e-6_wp
  !> Projections of changes may be wrong by this share of what a direction may leave.
  real(wp), parameter :: little = 1.0e-2_wp
  !> Most iterations of GMRES for the multipliers of one direction.
  integer, parameter :: multiplier_vectors = 40
  !> What multipliers in place of a stiff penalty may lack, over the forces of their pair.
  real(wp), parameter :: softened_share = 1.0e-12_wp

contains

  !> The multipliers of the working points, at the start of a solve.
  subroutine take_multipliers(model, equation, tools, contact, place, motion)
    type(model_t), intent(in) :: model !! pairs with their working points
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(rigid_part_t), intent(in) :: tools !! rigid bodies
    type(element_list_t), intent(in) :: contact !! contact elements loaded
    type(contact_places_t), intent(in) :: place !! where they are
    type(multiplier_motion_t), intent(inout) :: motion !! begins
    type(contact_point_t) :: unit
    real(wp) :: kappa(3)
    integer :: k, p, element

    unit%lambda = 1.0_wp
    associate (n => contact%n, dofs => 3*size(contact%ix, 1))
      if (.not. allocated(motion%scale)) allocate (motion%scale(n), motion%start(3, n), &
        motion%way(3, n), motion%force(3, n), motion%by_place(3, dofs, n), &
        motion%by_shift(3, 3, n), motion%of_nodes(3, dofs, n), source=0.0_wp)
    end associate
    motion%scale = 0.0_wp
    motion%start = 0.0_wp
    motion%way = 0.0_wp
    motion%force = 0.0_wp
    motion%rest = 0.0_wp
    do k = 1, size(model%pairs)
      if (.not. shifts_gap(model%pairs(k))) cycle
      do p = 1, count_points(model%pairs(k))
        element = place%first_point(k) + p - 1
        if (contact%routine(element) == routine_none) cycle
        if (model%pairs(k)%history%softened .and. nothing_deforms(equation, tools, &
          contact%ix(1:contact%nel(element), element))) cycle
        kappa = point_shift(model%pairs(k), p, unit)
        motion%scale(element) = kappa(1)
        motion%start(:, element) = model%pairs(k)%history%new(p)%lambda
      end do
    end do
  end subroutine take_multipliers

  !> Adds to a direction with fixed multipliers the way that these go, and what it does to it.
  subroutine add_multipliers(model, system, form, anew)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(inout) :: system !! direction found; gets du, motion
    type(form_t), intent(inout) :: form !! du
    logical, intent(in) :: anew !! the derivatives of the forces belong to a new tangent
    type(point_forces_t) :: at(size(model%pairs))
    type(gmres_t) :: iteration
    real(wp), dimension(3, system%contact%n) :: lack, image
    real(wp) :: du(3, size(system%u, 2)), floor, share
    real(wp) :: way(size(lack))

    call find_fields(model, system, at)
    call form_tangent_of_forces(model%mesh%x, system%contact, system%u, system%motion, anew)
    associate (motion => system%motion)
      call project(model, system%place, at, motion%force, lack)
      lack = lack - motion%start
      floor = wanted_share(norm2(lack), motion%rest)
      motion%rest = norm2(lack)
      motion%way = 0.0_wp
      call project(model, system%place, at, change_of_forces(system, form%du), image, little*floor)
      call begin_gmres(reshape(lack + image, [size(lack)]), multiplier_vectors, iteration)
      floor = max(floor*iteration%rest, least_lack(model, system))
      share = little*floor/max(iteration%rest, tiny(1.0_wp))
      do while (iteration%rest > floor .and. iteration%n < multiplier_vectors)
        motion%way = reshape(iteration%base(:, iteration%n + 1), shape(lack))
        call form%kind%answer(system, form, -forces_of_way(system), du)
        call project(model, system%place, at, change_of_forces(system, du), image, share)
        call add_image(reshape((1.0_wp + own_share)*motion%way - image, [size(lack)]), iteration)
      end do
      call gmres_solution(iteration, way)
      motion%way = reshape(way, shape(lack))
    end associate
    call form%kind%push(system, form, -forces_of_way(system))
  end subroutine add_multipliers

  !> As many digits as Newton can use.
  pure real(wp) function wanted_share(rest, before) result(share)
    real(wp), intent(in) :: rest !! what the multipliers lack [force]
    real(wp), intent(in) :: before !! the same one iteration ago, 0 if there is none [force]

    share = coarsest_multipliers
    if (before > 0.0_wp) share &
      = max(finest_multipliers, min(coarsest_multipliers, 0.1_wp*(rest/before)**2))
  end function wanted_share

  !> What multipliers may lack when a direction need not bring more: less than when they fit, or
  !! they would stay where they are and be given up.
  pure real(wp) function least_lack(model, system) result(least)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! motion with its forces, round-off
    real(wp) :: forces
    integer :: k

    least = least_multiplier_share*norm2(system%motion%force)
    do k = 1, size(model%pairs)
      if (.not. shifts_gap(model%pairs(k))) cycle
      forces = norm2(system%motion%force(:, system%place%first_point(k): &
        system%place%first_point(k + 1) - 1))
      if (forces > 0.0_wp) least = min(least, share_of_fitting*fitting(model%pairs(k))*forces)
    end do
    least = max(least, system%scale%round_off)
  end function least_lack

  !> Fields of the multipliers at the present positions.
  subroutine find_fields(model, system, at)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements, u
    type(point_forces_t), intent(out) :: at(:) !! (pairs) that of each pair that has one
    real(wp), allocatable :: stress(:, :)
    integer :: k

    if (.not. any(has_field(model%pairs))) return
    allocate (stress(n_element_stress, system%contact%n))
    call recover(system%contact, task_stress, model%mesh%x, system%u, stress)
    do k = 1, size(model%pairs)
      if (.not. has_field(model%pairs(k))) cycle
      call take_forces(model, system, k, &
        stress(:, system%place%first_point(k):system%place%first_point(k + 1) - 1), at(k))
    end do
  end subroutine find_fields

  !> Forces of the points at the present iterate, and their derivatives.
  subroutine form_tangent_of_forces(x, contact, u, motion, anew)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(element_list_t), intent(in) :: contact !! contact elements
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(multiplier_motion_t), intent(inout) :: motion !! gets how forces depend on them
    logical, intent(in) :: anew !! or the derivatives stay what they are
    type(element_t) :: e
    integer :: k

    do k = 1, contact%n
      if (motion%scale(k) <= 0.0_wp) cycle
      call shift_derivatives(contact, k, x, u, e)
      motion%force(:, k) = e%stress(1:3)
      if (.not. anew) cycle
      motion%by_place(:, :, k) = e%s(1:3, :size(motion%by_place, 2))
      motion%of_nodes(:, :, k) = e%s(4:6, :size(motion%of_nodes, 2))
      motion%by_shift(:, :, k) = e%s(7:9, 1:3)
    end do
  end subroutine form_tangent_of_forces

  !> P f: the multipliers that forces ask for.
  subroutine project(model, place, at, force, multiplier, share)
    type(model_t), intent(in) :: model !! pairs
    type(contact_places_t), intent(in) :: place !! contact elements
    type(point_forces_t), intent(in) :: at(:) !! (pairs) fields
    real(wp), intent(in) :: force(:, :) !! (3, n) in the targets' frames [force]
    real(wp), intent(out) :: multiplier(:, :) !! (3, n) likewise [force]
    real(wp), intent(in), optional :: share !! of the forces, may be wrong; else next to nothing
    real(wp), allocatable :: global(:, :), field(:, :)
    integer :: k, p, i

    multiplier = force
    do k = 1, size(model%pairs)
      if (.not. has_field(model%pairs(k))) cycle
      associate (first => place%first_point(k) - 1, n => size(at(k)%near))
        allocate (global(3, n), field(3, n), source=0.0_wp)
        do p = 1, n
          if (at(k)%near(p)) global(:, p) = product_of(at(k)%frame(:, :, p), force(:, first + p))
        end do
        call project_forces(model%pairs(k), at(k)%field, global, field, share)
        do p = 1, n
          if (.not. at(k)%near(p)) cycle
          do i = 1, 3
            multiplier(i, first + p) = dot_product(field(:, p), at(k)%frame(:, i, p))
          end do
        end do
        deallocate (global, field)
      end associate
    end do
  end subroutine project

  !> Change of the forces of the points by displacements and by the way of the multipliers.
  function change_of_forces(system, du) result(change)
    type(system_t), intent(in) :: system !! contact elements, motion
    real(wp), intent(in) :: du(:, :) !! (3, nodes) [length]
    real(wp) :: change(3, system%contact%n), total(3)
    integer :: k, a, i

    change = 0.0_wp
    associate (motion => system%motion, list => system%contact)
      do k = 1, list%n
        if (motion%scale(k) <= 0.0_wp) cycle
        total = motion%scale(k)*product_of(motion%by_shift(:, :, k), motion%way(:, k))
        do a = 1, list%nel(k)
          do i = 1, 3
            total = total + motion%by_place(:, 3*a - 3 + i, k)*du(i, list%ix(a, k))
          end do
        end do
        change(:, k) = total
      end do
    end associate
  end function change_of_forces

  !> What the way of the multipliers adds to the nodal forces of contact.
  function forces_of_way(system) result(force)
    type(system_t), intent(in) :: system !! contact elements, motion
    real(wp) :: force(3, size(system%u, 2)), way(3)
    integer :: k, a, i

    force = 0.0_wp
    associate (motion => system%motion, list => system%contact)
      do k = 1, list%n
        if (motion%scale(k) <= 0.0_wp) cycle
        way = motion%scale(k)*motion%way(:, k)
        do a = 1, list%nel(k)
          associate (node => list%ix(a, k))
            do i = 1, 3
              force(i, node) = force(i, node) + dot_product(way, motion%of_nodes(:, 3*a - 3 + i, k))
            end do
          end associate
        end do
      end do
    end associate
  end function forces_of_way

  !> No pair has multipliers that differ from its forces by more than a share of its largest force.
  logical function multipliers_fit(model, system) result(fit)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements, u, motion
    type(point_forces_t) :: at(size(model%pairs))
    type(element_t) :: e
    real(wp), dimension(3, system%contact%n) :: force, multiplier
    integer :: k

    call find_fields(model, system, at)
    force = 0.0_wp
    do k = 1, system%contact%n
      if (system%motion%scale(k) <= 0.0_wp) cycle
      call shift_derivatives(system%contact, k, model%mesh%x, system%u, e)
      force(:, k) = e%stress(1:3)
    end do
    call project(model, system%place, at, force, multiplier)
    fit = .true.
    do k = 1, size(model%pairs)
      if (.not. shifts_gap(model%pairs(k))) cycle
      associate (first => system%place%first_point(k), last => system%place%first_point(k + 1) - 1)
        fit = fit .and. norm2(multiplier(:, first:last) - system%motion%start(:, first:last)) <= &
          max(8.0_wp*system%scale%round_off, fitting(model%pairs(k))*norm2(multiplier(:, &
            first:last)))
      end associate
    end do
  end function multipliers_fit

  !> What multipliers may lack when they fit, over the norm of the forces of the pair.
  pure real(wp) function fitting(pair) result(share)
    type(pair_t), intent(in) :: pair !! the pair

    share = 0.1_wp*pair%augment_tolerance
    if (pair%history%softened) share = softened_share
  end function fitting

  !> The multipliers to the working points.
  subroutine hand_back_multipliers(model, system)
    type(model_t), intent(inout) :: model !! pairs: lambda of the working points
    type(system_t), intent(in) :: system !! motion
    integer :: k, p

    do k = 1, size(model%pairs)
      if (.not. shifts_gap(model%pairs(k))) cycle
      do p = 1, count_points(model%pairs(k))
        model%pairs(k)%history%new(p)%lambda = system%motion%start(:, &
          system%place%first_point(k) + p - 1)
      end do
    end do
  end subroutine hand_back_multipliers
end module multiplier_motion

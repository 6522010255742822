!> What the derivatives need of a scene, once: how supports answer to contact forces, and what the
!! changed loads do (doc/theory, "Sensitivities along the path").
module sensitivity_start
  use kinds, only: wp
  use text, only: to_text, string_t
  use deck_types, only: location_t
  use diagnostics, only: diagnostics_t, report_error
  use model_types, only: model_t, load_t, form_plain
  use cells, only: corners_of
  use loads, only: add_displacement, add_force
  use mesh_names, only: find_nodes
  use contact_points, only: count_points
  use contact_parameters, only: has_field
  use block_matrix, only: multiply
  use body_solves, only: solve_condensed_body
  use lever_sums, only: levers_t, supported_nodes, loaded_nodes
  use system_types, only: form_t, system_t
  use system_parts, only: bodies_t, contact_places_t, whole_form_t
  use friction_laws, only: cone_laws, acts
  use sensitivity_types, only: sensitivity_t, slope_t
  implicit none
  private
  public :: check_slopes, begin_sensitivities, start_scene, find_levers, load_bodies, &
    remember_points

contains

  !> Reports, at the place in the deck, what derivatives do not know of yet and what a parameter
  !! cannot be.
  subroutine check_slopes(model, system, s, diagnostics)
    type(model_t), intent(in) :: model !! pairs at their start
    type(system_t), intent(in) :: system !! bodies, contact elements
    type(sensitivity_t), intent(inout) :: s !! slopes given; they get stiffness
    type(diagnostics_t), intent(inout) :: diagnostics !! gets the errors
    integer :: j

    if (.not. s%active) return
    call check_scene(model, system, s%slopes(1)%at, diagnostics)
    do j = 1, size(s%slopes)
      call find_stiffness(model, system%body, s%slopes(j), diagnostics)
    end do
  end subroutine check_slopes

  !> The state before the first increment: no parameter has changed anything.
  subroutine begin_sensitivities(model, system, s)
    type(model_t), intent(in) :: model !! pairs at their start
    type(system_t), intent(in) :: system !! bodies, contact elements
    type(sensitivity_t), intent(inout) :: s !! slopes checked; gets its state
    integer :: n, points

    n = size(s%slopes)
    points = system%contact%n
    allocate (s%target(points), s%status(points), source=0)
    allocate (s%apex(2, points), s%dtip(2, points, n), source=0.0_wp)
    allocate (s%du(3, model%mesh%nodes, n), s%force(3, model%mesh%nodes, n), source=0.0_wp)
    s%sets = model%output%reactions
    allocate (s%reaction(3, size(s%sets), n), s%contact(3, size(model%pairs), n), &
      s%total(3, size(s%sets)), source=0.0_wp)
    allocate (s%range(n, size(model%pairs)), source=huge(1.0_wp))
    allocate (s%kinks(size(model%pairs)), source=0)
    call remember_points(model, system%place, s)
  end subroutine begin_sensitivities

  !> Target facets, apexes and status of the last state.
  subroutine remember_points(model, place, s)
    type(model_t), intent(in) :: model !! pairs
    type(contact_places_t), intent(in) :: place !! where each pair begins
    type(sensitivity_t), intent(inout) :: s !! gets target, status, apex
    integer :: k, p

    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        associate (e => place%first_point(k) + p - 1, point => model%pairs(k)%history%old(p))
          s%target(e) = point%target
          s%status(e) = point%status
          s%apex(:, e) = point%apex
        end associate
      end do
    end do
  end subroutine remember_points

  !> What derivatives do not know of yet is refused by its name.
  subroutine check_scene(model, system, at, diagnostics)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! bodies
    type(location_t), intent(in) :: at !! where derivatives are asked for
    type(diagnostics_t), intent(inout) :: diagnostics !! gets what is not known
    integer :: i, k

    if (size(model%pairs) == 0) then
      call refuse('a model without contact pairs')
    end if
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (pair%segmented) call refuse('SEGMent (pair '//pair%name//')')
        if (pair%smooth) call refuse('SMOOth (pair '//pair%name//')')
        if (allocated(pair%surface%middles) .or. pair%points%n_slaves > 3) &
          call refuse('facets of six nodes (pair '//pair%name//')')
        if (pair%shrinking%shrink >= 0) call refuse('SHRInk (pair '//pair%name//')')
        if (has_field(pair)) call refuse('AUGMent with points of facets (pair '//pair%name//')')
        do i = 1, size(cone_laws)
          if (acts(i, pair%law)) call refuse(trim(cone_laws(i)%keyword)//' (pair '//pair%name//')')
        end do
        if (pair%points%slots > 1) call refuse('a master with concave edges (pair '//pair%name//')')
      end associate
    end do
    if (allocated(system%loads%spring)) call refuse('SPRIng')
    if (allocated(system%loads%pressed)) call refuse('a pressure that follows its faces')
    if (any(model%conditions%loads%form /= form_plain)) call refuse('ROTAtion')
    if (system%tools%unknowns > 0) call refuse('a rigid body with free motions')
    if (any(system%body%floating)) call refuse('a body that contact alone holds')
    if (.not. system%bulk%linear) call refuse('finite strain')

  contains

    !> Reports one thing.
    subroutine refuse(what)
      character(*), intent(in) :: what !! what it is

      call report_error(diagnostics, at, 'SENSitivity does not know '//what, &
        'leave SENSitivity out, or take differences of two runs with --set')
    end subroutine refuse
  end subroutine check_scene

  !> Changes of Young's modulus as changes of whole bodies.
  subroutine find_stiffness(model, body, slope, diagnostics)
    type(model_t), intent(in) :: model !! materials of the elements
    type(bodies_t), intent(in) :: body !! bodies of the nodes
    type(slope_t), intent(inout) :: slope !! gets stiffness
    type(diagnostics_t), intent(inout) :: diagnostics !! hears of a body of which a part changes
    logical :: seen(body%bodies)
    integer :: e, b, m

    allocate (slope%stiffness(body%bodies), source=0.0_wp)
    if (all(abs(slope%modulus) <= 0.0_wp)) return
    seen = .false.
    do e = 1, model%mesh%elements
      m = model%element_material(e)
      if (m == 0) cycle
      if (model%materials(m)%rigid) cycle
      b = maxval(body%node_body(corners_of(model%mesh%ix(:, e))))
      if (b == 0) cycle
      if (seen(b) .and. abs(slope%stiffness(b) - slope%modulus(m)) > &
        1.0e-9_wp*(abs(slope%stiffness(b)) + abs(slope%modulus(m)))) then
        call report_error(diagnostics, slope%at, 'the derivative by '//slope%name// &
          ' wants a whole body to become stiffer, and material '// &
          to_text(model%materials(m)%number)//' is a part of one', &
          'give all materials of the body the same parameter as a factor of their E')
        return
      end if
      seen(b) = .true.
      slope%stiffness(b) = slope%modulus(m)
    end do
  end subroutine find_stiffness

  !> Levers of the reaction sets, and displacements for unit changes of loads: all of them with one
  !! pass over the factors.
  subroutine start_scene(model, system, form, s)
    type(model_t), intent(in) :: model !! conditions, sets
    type(system_t), intent(in) :: system !! condensed
    type(form_t), intent(in) :: form !! condensed, matrix
    type(sensitivity_t), intent(inout) :: s !! gets levers, pushed, influence of slopes
    type(load_t), allocatable :: loads(:)
    real(wp), allocatable :: u(:, :, :), force(:, :, :)
    integer :: j, k, n, levers, own

    allocate (loads(sum([(size(s%slopes(j)%loads), j=1, size(s%slopes))])))
    n = 0
    do j = 1, size(s%slopes)
      do k = 1, size(s%slopes(j)%loads)
        n = n + 1
        loads(n) = s%slopes(j)%loads(k)
      end do
    end do
    own = size(model%conditions%loads)
    levers = own + 3*size(s%sets)
    allocate (u(3, model%mesh%nodes, levers + own + n), force(3, model%mesh%nodes, levers + own + &
      n), source=0.0_wp)
    call apply_loads(system%equation, model%conditions%loads, .true., u(:, :, :own), force(:, :, &
      :own))
    call move_sets(model, system%equation, s%sets, u(:, :, own + 1:levers))
    call apply_loads(system%equation, model%conditions%loads, .false., u(:, :, levers + 1:levers + &
      own), force(:, :, levers + 1:levers + own))
    call apply_loads(system%equation, loads, .true., u(:, :, levers + own + 1:), &
      force(:, :, levers + own + 1:))
    call find_displacements(system%body, form, force, u, form%condensed%outer%influence)
    call take_levers(model, system%equation, form%whole, loads, u(:, :, own + 1:levers), s%levers)
    s%pushed = u(:, :, levers + 1:levers + own)
    n = levers + own
    do j = 1, size(s%slopes)
      associate (slope => s%slopes(j))
        slope%influence = u(:, :, n + 1:n + size(slope%loads))
        n = n + size(slope%loads)
      end associate
    end do
    s%started = .true.
  end subroutine start_scene

  !> How supports answer to contact forces: displacements for a unit motion of each set.
  subroutine find_levers(model, system, form, sets, levers)
    type(model_t), intent(in) :: model !! sets
    type(system_t), intent(in) :: system !! factors of the bodies
    type(form_t), intent(in) :: form !! condensed, matrix
    type(string_t), intent(in) :: sets(:) !! names
    type(levers_t), intent(out) :: levers !! of these
    real(wp), allocatable :: force(:, :, :), u(:, :, :)

    allocate (u(3, model%mesh%nodes, 3*size(sets)), force(3, model%mesh%nodes, 3*size(sets)), &
      source=0.0_wp)
    call move_sets(model, system%equation, sets, u)
    call find_displacements(system%body, form, force, u)
    call take_levers(model, system%equation, form%whole, [load_t ::], u, levers)
  end subroutine find_levers

  !> Unit motions of sets, where they are held.
  subroutine move_sets(model, equation, sets, u)
    type(model_t), intent(in) :: model !! sets
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(string_t), intent(in) :: sets(:) !! names
    real(wp), intent(inout) :: u(:, :, :) !! (3, nodes, 3*sets) in: 0; out: the motions
    integer, allocatable :: nodes(:)
    integer :: i, k
    logical :: found

    do i = 1, size(sets)
      call find_nodes(model%mesh, sets(i)%s, nodes, found)
      do k = 1, 3
        u(k, nodes, 3*i + k - 3) = 1.0_wp
        where (equation > 0) u(:, :, 3*i + k - 3) = 0.0_wp
      end do
    end do
  end subroutine move_sets

  !> Levers from the displacements, and the forces at the supports.
  subroutine take_levers(model, equation, whole, others, u, levers)
    type(model_t), intent(in) :: model !! pairs, loads
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(whole_form_t), intent(in) :: whole !! matrix
    type(load_t), intent(in) :: others(:) !! loads beside those of the model
    real(wp), intent(in) :: u(:, :, :) !! (3, nodes, 3*sets) displacements
    type(levers_t), intent(inout) :: levers !! all of it
    integer :: i, k

    associate (nodes => size(u, 2), sets => size(u, 3)/3)
      levers%u = reshape(u, [3, nodes, 3, sets])
      allocate (levers%hold(3, nodes, 3, sets))
      do i = 1, sets
        do k = 1, 3
          call multiply(whole%bulk_matrix, levers%u(:, :, k, i), levers%hold(:, :, k, i))
          where (equation > 0) levers%hold(:, :, k, i) = 0.0_wp
        end do
      end do
    end associate
    levers%supports = supported_nodes(equation)
    levers%loaded = loaded_nodes(model, others)
  end subroutine take_levers

  !> Displacements of all bodies for a unit of each load, prescribed values and forces.
  subroutine load_bodies(system, form, loads, u)
    type(system_t), intent(in) :: system !! factors of the bodies
    type(form_t), intent(in) :: form !! condensed, matrix
    type(load_t), intent(in) :: loads(:) !! the loads
    real(wp), intent(out) :: u(:, :, :) !! (3, nodes, loads) [length]
    real(wp), allocatable :: force(:, :, :)

    u = 0.0_wp
    allocate (force(3, size(u, 2), size(loads)), source=0.0_wp)
    call apply_loads(system%equation, loads, .true., u, force)
    call find_displacements(system%body, form, force, u)
  end subroutine load_bodies

  !> A unit of each load.
  subroutine apply_loads(equation, loads, whole, u, force)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(load_t), intent(in) :: loads(:) !! the loads
    logical, intent(in) :: whole !! prescribed values and forces, not the forces alone
    real(wp), intent(inout) :: u(:, :, :) !! (3, nodes, loads) grow by prescribed values [length]
    real(wp), intent(inout) :: force(:, :, :) !! (3, nodes, loads) grow by theirs [force]
    integer :: k

    do k = 1, size(loads)
      if (whole) call add_displacement(loads(k), 1.0_wp, u(:, :, k))
      where (equation > 0) u(:, :, k) = 0.0_wp
      call add_force(loads(k), 1.0_wp, force(:, :, k))
    end do
  end subroutine apply_loads

  !> Displacements of all bodies under forces and prescribed values, for all columns; those that are
  !! multiples of others are solved for once, and not at all where the first ones are known.
  subroutine find_displacements(body, form, force, u, known)
    type(bodies_t), intent(in) :: body !! factors of the bodies
    type(form_t), intent(in) :: form !! condensed, matrix
    real(wp), intent(inout) :: force(:, :, :) !! (3, nodes, n) applied forces; changed [force]
    real(wp), intent(inout) :: u(:, :, :) !! (3, nodes, n) prescribed values; out: all [length]
    real(wp), optional, intent(in) :: known(:, :, :) !! (3, nodes, m) those of the first columns
    real(wp), allocatable :: internal(:, :), b(:, :, :), x(:, :, :)
    integer, allocatable :: columns(:)
    integer :: like(size(u, 3)), i, k, first
    real(wp) :: factor(size(u, 3))

    first = 1
    if (present(known)) first = size(known, 3) + 1
    do k = 1, size(u, 3)
      call find_like(force(:, :, :k), u(:, :, :k), like(:k - 1), like(k), factor(k))
    end do
    columns = pack([(k, k=first, size(u, 3))], like(first:) == [(k, k=first, size(u, 3))])
    allocate (internal(3, size(u, 2)))
    do k = 1, size(columns)
      call multiply(form%whole%bulk_matrix, u(:, :, columns(k)), internal)
      force(:, :, columns(k)) = force(:, :, columns(k)) - internal
    end do
    b = force(:, :, columns)
    x = u(:, :, columns)
    if (present(known)) u(:, :, :first - 1) = known
    do i = 1, body%bodies
      if (.not. allocated(form%condensed%bodies(i)%node)) cycle
      call solve_condensed_body(form%condensed%bodies(i), b, x)
    end do
    u(:, :, columns) = x
    do k = 1, size(u, 3)
      if (like(k) > 0 .and. like(k) < k) u(:, :, k) = factor(k)*u(:, :, like(k))
    end do
  end subroutine find_displacements

  !> The first column that the last one is a multiple of: itself, if there is none before it; 0 if
  !! it is nothing.
  pure subroutine find_like(force, u, like_before, like, factor)
    real(wp), intent(in) :: force(:, :, :) !! (3, nodes, n) applied forces [force]
    real(wp), intent(in) :: u(:, :, :) !! (3, nodes, n) prescribed values [length]
    integer, intent(in) :: like_before(:) !! (n-1) the same of the others
    integer, intent(out) :: like !! that column
    real(wp), intent(out) :: factor !! by which
    integer :: at(2), i, n
    logical :: pushed

    n = size(u, 3)
    factor = 1.0_wp
    pushed = any(abs(force(:, :, n)) > 0.0_wp)
    like = merge(n, 0, pushed .or. any(abs(u(:, :, n)) > 0.0_wp))
    if (like == 0) return
    at = maxloc(abs(u(:, :, n)))
    if (pushed) at = maxloc(abs(force(:, :, n)))
    do i = 1, n - 1
      if (like_before(i) /= i) cycle
      factor = u(at(1), at(2), i)
      if (pushed) factor = force(at(1), at(2), i)
      if (abs(factor) <= 0.0_wp) cycle
      factor = merge(force(at(1), at(2), n), u(at(1), at(2), n), pushed)/factor
      like = i
      if (is_multiple(force, factor, i) .and. is_multiple(u, factor, i)) return
    end do
    like = n
    factor = 1.0_wp
  end subroutine find_like

  !> The last column of a is a factor times another one, to round-off.
  pure logical function is_multiple(a, factor, i)
    real(wp), intent(in) :: a(:, :, :) !! (3, nodes, n) columns
    real(wp), intent(in) :: factor !! the factor
    integer, intent(in) :: i !! the other one

    is_multiple = all(abs(a(:, :, size(a, 3)) - factor*a(:, :, i)) <= &
      4.0_wp*epsilon(1.0_wp)*abs(a(:, :, size(a, 3))))
  end function is_multiple
end module sensitivity_start

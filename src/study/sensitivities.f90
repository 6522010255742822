!> Direct differentiation of an increment that has been accepted: derivatives of apexes,
!! displacements, contact forces and reactions by all parameters (doc/theory, "Sensitivities along
!! the path", eq. (14.1)).
module sensitivities
  use kinds, only: wp
  use element_types, only: status_open, routine_none
  use element_parameters, only: d03_epsilon
  use loads, only: load_factor, add_displacement
  use model_types, only: model_t
  use contact_points, only: count_points
  use facet_geometry, only: facet_size
  use target_slopes, only: projection_slope
  use late_displacements, only: complete_nodes
  use increment_elements, only: work_t, load_elements, find_causes, element_change, add_motion, &
    element_motion, add_forces
  use increment_answers, only: factor_change, add_changes
  use multiplier_slopes, only: find_shifted
  use multiplier_answers, only: solve_increment, rest_candidates
  use full_answers, only: start_full, full_reactions
  use sensitivity_start, only: start_scene, remember_points
  use lever_sums, only: sum_by_levers
  use sensitivity_types, only: sensitivity_t
  use system_types, only: form_t, system_t, state_t
  use element_lists, only: element_list_t
  implicit none
  private
  public :: follow_increment

  !> Shares of the depth, and of a facet, within which a status is at its border.
  real(wp), parameter :: border = 1.0e-9_wp, border_gap = 1.0e-12_wp

contains

  !> Takes the derivatives from the last state to the one that has just been accepted.
  subroutine follow_increment(model, system, form, state, s, trouble)
    type(model_t), intent(in) :: model !! pairs with their new history
    type(system_t), intent(inout) :: system !! contact elements as solved; its factor is used
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(in) :: state !! the new state
    type(sensitivity_t), intent(inout) :: s !! derivatives
    character(:), allocatable, intent(out) :: trouble !! empty if all went well
    type(work_t) :: work
    real(wp), allocatable :: right(:), contact_force(:, :)

    trouble = ''
    if (.not. system%bulk%linear) then
      trouble = 'SENSitivity needs a linear bulk in this version'
      return
    end if
    if (.not. s%started) then
      s%full = form%kind%knows_inside
      if (s%full .and. is_late(s)) then
        trouble = 'derivatives of a run with the condensed form go on with that form only'
        return
      end if
      if (s%full) call start_full(model, system%equation, s)
      if (.not. s%full) call start_scene(model, system, form, s)
    else if (s%full .neqv. form%kind%knows_inside) then
      trouble = 'the solver has changed between the condensed and the full form'
      return
    end if
    right = form%right
    contact_force = system%contact_force
    system%contact%hold = .false.
    system%contact%slide = .false.
    system%contact%keep = 0.0_wp
    call load_elements(model, system, work)
    call find_causes(model, system, form%condensed, s, work)
    call find_shifted(model, system, s, work)
    call change_ways(model, system%equation, form, state%time, s)
    call solve_increment(model, system, form, state%time, s, work, trouble)
    if (len(trouble) > 0) return
    call collect_forces(model, system, form, s, work)
    call settle(model, system, s, work)
    call add_reactions(model, system, form, state, s)
    form%right = right
    system%contact_force = contact_force
    if (allocated(system%contact%reached)) deallocate (system%contact%reached)
  end subroutine follow_increment

  !> Displacements of some candidates are not complete.
  pure logical function is_late(s)
    type(sensitivity_t), intent(in) :: s !! derivatives

    is_late = .false.
    if (allocated(s%answers%late)) is_late = any(s%answers%late)
  end function is_late

  !> Derivatives of the prescribed displacements; those of the candidates are not known yet.
  subroutine change_ways(model, equation, form, time, s)
    type(model_t), intent(in) :: model !! loads and their tables
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(form_t), intent(in) :: form !! what the condensed form keeps
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(inout) :: s !! gets du
    real(wp) :: ways(3, model%mesh%nodes)
    integer :: i, j, k

    ways = 0.0_wp
    do j = 1, size(s%slopes)
      ways(:, s%levers%supports) = 0.0_wp
      associate (slope => s%slopes(j))
        do k = 1, size(slope%loads)
          call add_displacement(slope%loads(k), load_factor(model%tables, slope%loads(k)%table, &
            time), ways)
        end do
        do k = 1, size(model%conditions%loads)
          associate (load => model%conditions%loads(k))
            call add_displacement(load, factor_change(slope, load%table, time), ways)
          end associate
        end do
      end associate
      do i = 1, size(s%levers%supports)
        associate (node => s%levers%supports(i))
          where (equation(:, node) == 0) s%du(:, node, j) = ways(:, node)
        end associate
      end do
    end do
    call rest_candidates(form%condensed, s)
  end subroutine change_ways

  !> Contact forces of all nodes, contact sums, and how far points are from another status.
  subroutine collect_forces(model, system, form, s, work)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(sensitivity_t), intent(inout) :: s !! du given; gets force, contact, range, kinks; du of
    !! open points
    type(work_t), intent(inout) :: work !! elements, causes; gets the whole change
    real(wp) :: dr(12), dx(12, size(s%slopes))
    integer :: k, e, j

    s%force(:, s%levers%loaded, :) = 0.0_wp
    s%contact = 0.0_wp
    s%range = huge(1.0_wp)
    s%kinks = 0
    do k = 1, size(model%pairs)
      do e = system%place%first_point(k), system%place%first_point(k) + &
        count_points(model%pairs(k)) - 1
        if (system%contact%routine(e) == routine_none) cycle
        if (work%slopes(e)%status == status_open) cycle
        do j = 1, size(s%slopes)
          dx(:, j) = element_motion(work%elements(e), s%du(:, :, j))
          call add_motion(work, e, j, dx(:, j))
          dr = element_change(work, e, j, system%contact%d(d03_epsilon, e))
          call add_forces(work%elements(e), dr, s%force(:, :, j))
          s%contact(:, k, j) = s%contact(:, k, j) - dr(1:3)
        end do
        call look_at_border(system%contact, work, e, dx, s, k)
      end do
    end do
    call look_at_open(model, system, form, s, work)
  end subroutine collect_forces

  !> The same of open points, whose displacements are not all known yet.
  subroutine look_at_open(model, system, form, s, work)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    type(form_t), intent(in) :: form !! what the condensed form keeps
    type(sensitivity_t), intent(inout) :: s !! force given; gets du, range, kinks
    type(work_t), intent(in) :: work !! elements, causes
    real(wp) :: dx(12, size(s%slopes))
    logical :: wanted(model%mesh%nodes)
    integer :: k, p, e, j

    wanted = .false.
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        e = system%place%first_point(k) + p - 1
        associate (pair => model%pairs(k), point => model%pairs(k)%history%old(p))
          if (point%target > 0 .and. point%status <= status_open) then
            wanted(pair%surface%facets(:, point%target)) = .true.
            wanted(pair%points%point_nodes(:, p)) = .true.
          end if
        end associate
        if (system%contact%routine(e) == routine_none) cycle
        if (work%slopes(e)%status == status_open) &
          wanted(work%elements(e)%ix(:work%elements(e)%nel)) = .true.
      end do
    end do
    call complete_nodes(form%condensed, wanted, s)
    do k = 1, size(model%pairs)
      do e = system%place%first_point(k), system%place%first_point(k) + &
        count_points(model%pairs(k)) - 1
        if (system%contact%routine(e) == routine_none) cycle
        if (work%slopes(e)%status /= status_open) cycle
        do j = 1, size(s%slopes)
          dx(:, j) = element_motion(work%elements(e), s%du(:, :, j))
        end do
        call look_at_border(system%contact, work, e, dx, s, k)
      end do
    end do
  end subroutine look_at_open

  !> Change of each parameter after which one point changes its status, to first order.
  subroutine look_at_border(contact, work, e, dx, s, k)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(work_t), intent(in) :: work !! elements, causes
    integer, intent(in) :: e !! the element
    real(wp), intent(in) :: dx(:, :) !! (12, parameters) motion of S, 1, 2, 3 [length]
    type(sensitivity_t), intent(inout) :: s !! gets range, kinks
    integer, intent(in) :: k !! number of the pair
    real(wp) :: slope
    integer :: j
    logical :: kink, rubs

    associate (mine => work%slopes(e), list => contact)
      rubs = mine%status > status_open .and. any(abs(mine%dover_x) > 0.0_wp)
      kink = abs(mine%rho) <= border_gap*facet_size(work%elements(e)%xl(:, list%slaves(e) + 1: &
        list%slaves(e) + 3))
      if (rubs .and. .not. kink) kink = abs(mine%over) <= border*mine%rho
      if (kink) then
        s%kinks(k) = s%kinks(k) + 1
        return
      end if
      do j = 1, size(s%slopes)
        slope = dot_product(mine%drho, work%by(:, e, j)) + dot_product(mine%drho_x, dx(:, j))
        call narrow(mine%rho, slope, s%range(j, k))
        if (.not. rubs) cycle
        slope = dot_product(mine%dover, work%by(:, e, j)) + dot_product(mine%dover_x, dx(:, j))
        call narrow(mine%over, slope, s%range(j, k))
      end do
    end associate
  end subroutine look_at_border

  !> A range becomes that in which a quantity keeps its sign.
  pure subroutine narrow(value, slope, range)
    real(wp), intent(in) :: value !! the quantity
    real(wp), intent(in) :: slope !! its derivative
    real(wp), intent(inout) :: range !! largest change
    logical :: nearer

    if (abs(slope) <= 1.0_wp) then
      nearer = abs(value) < range*abs(slope)
    else
      ! the range may be as large as numbers go
      nearer = abs(value)/abs(slope) < range
    end if
    if (nearer) range = abs(value/slope)
  end subroutine narrow

  !> Derivatives of the new apexes; open points follow their projection.
  subroutine settle(model, system, s, work)
    type(model_t), intent(in) :: model !! pairs, settled
    type(system_t), intent(in) :: system !! contact elements, positions
    type(sensitivity_t), intent(inout) :: s !! du given; gets dtip, target, apex, status
    type(work_t), intent(in) :: work !! elements, causes
    integer :: k, p, e, j

    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        e = system%place%first_point(k) + p - 1
        associate (point => model%pairs(k)%history%old(p))
          do j = 1, size(s%slopes)
            if (point%target == 0) then
              s%dtip(:, e, j) = 0.0_wp
            else if (point%status <= status_open) then
              s%dtip(:, e, j) = projection_slope(model%pairs(k), p, point%target, &
                system%position%x_now, s%du(:, :, j))
            else
              s%dtip(:, e, j) = work%change(4:5, e, j)
            end if
          end do
        end associate
      end do
    end do
    call remember_points(model, system%place, s)
  end subroutine settle

  !> Derivatives of the reactions, and Euler's sum.
  subroutine add_reactions(model, system, form, state, s)
    type(model_t), intent(in) :: model !! conditions
    type(system_t), intent(in) :: system !! equations, bodies
    type(form_t), intent(in) :: form !! matrix
    type(state_t), intent(in) :: state !! time, displacements
    type(sensitivity_t), intent(inout) :: s !! force and du given; gets reaction, total, euler

    if (s%full) then
      call full_reactions(model, system, form, state, s)
    else
      call sum_supports(model, system, state, s)
    end if
    associate (euler => s%euler)
      euler%error = 0.0_wp
      if (any(abs(s%total) > 0.0_wp)) euler%error = maxval(abs(euler%factor(1)*s%reaction(:, :, &
        euler%slope(1)) + euler%factor(2)*s%reaction(:, :, euler%slope(2)) - &
        s%total))/maxval(abs(s%total))
    end associate
  end subroutine add_reactions

  !> Reactions of the condensed form, by the levers of the sets.
  subroutine sum_supports(model, system, state, s)
    type(model_t), intent(in) :: model !! conditions
    type(system_t), intent(in) :: system !! equations, bodies
    type(state_t), intent(in) :: state !! time, displacements
    type(sensitivity_t), intent(inout) :: s !! force and du given; gets reaction, total
    real(wp) :: force(3, size(state%u, 2)), given(3, size(state%u, 2))
    integer :: i, k, j

    given = 0.0_wp
    do j = 1, size(s%slopes)
      do i = 1, size(s%levers%supports)
        associate (node => s%levers%supports(i))
          given(:, node) = s%du(:, node, j)
          if (system%body%node_body(node) > 0) given(:, node) = given(:, node) &
            + s%slopes(j)%stiffness(system%body%node_body(node))*state%u(:, node)
        end associate
      end do
      force(:, s%levers%loaded) = s%force(:, s%levers%loaded, j)
      call add_changes(model, s%slopes(j), state%time, -1.0_wp, force)
      call sum_by_levers(system%equation, s%levers, force, given, s%reaction(:, :, j))
    end do
    associate (supports => s%levers%supports)
      do i = 1, size(s%sets)
        do k = 1, 3
          s%total(k, i) = sum(state%reaction(:, supports)*s%levers%u(:, supports, k, i), &
            system%equation(:, supports) == 0)
        end do
      end do
    end associate
  end subroutine sum_supports
end module sensitivities

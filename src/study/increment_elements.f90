!> The contact elements of an increment that has been accepted: their slopes, what parameters and
!! the last increment do to them, and what they make of it (doc/theory, "Sensitivities along the
!! path").
module increment_elements
  use kinds, only: wp
  use element_types, only: element_t, status_open, routine_none
  use model_types, only: model_t
  use contact_points, only: count_points
  use touch_types, only: touch_known
  use cone_slopes, only: cone_slopes_t, find_slopes, slope_by_causes, slope_by_motion, &
    force_slope, causes, cause_apex, cause_mu, cause_rule, cause_angle
  use contact_types, only: pair_t
  use target_slopes, only: way_t, find_way, carry_slope, projection_slope
  use late_displacements, only: complete_nodes
  use sensitivity_types, only: sensitivity_t
  use system_types, only: system_t
  use system_parts, only: positions_t
  use element_lists, only: element_list_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: work_t, shifted_t, load_elements, find_causes, element_change, add_motion, &
    element_motion, add_forces

  !> The elements whose forces come from multipliers.
  type :: shifted_t
    integer :: n = 0 !! how many
    integer, allocatable :: element(:) !! (n) these
    real(wp), allocatable :: share(:) !! (n) of the force, over the penalty, that the shift is
    real(wp), allocatable :: frame(:, :, :) !! (3, 3, n) of their facets
    real(wp), allocatable :: turn(:, :, :) !! (3, 12, n) how the gap turns with the facet
    real(wp), allocatable :: own(:, :, :) !! (3, n, parameters) change of the shift beside that
    !! of the force [length]
  end type shifted_t

  !> The contact elements of an increment and what they get and give.
  type :: work_t
    type(cone_slopes_t), allocatable :: slopes(:) !! (elements) at the converged state
    type(element_t), allocatable :: elements(:) !! (elements) their data
    real(wp), allocatable :: by(:, :, :) !! (causes, elements, n) changes of the causes
    real(wp), allocatable :: change(:, :, :) !! (5, elements, n) changes of gap and apex by these
    real(wp), allocatable :: stiffer(:, :) !! (elements, n) changes of the penalty, over itself
    type(way_t), allocatable :: ways(:) !! of start apexes to their targets
    integer, allocatable :: way(:) !! (elements) which of them, 0 for none: the target is the old
    !! one
    logical, allocatable :: anew(:) !! (elements) the apex starts at its projection
    type(shifted_t) :: shifted !! those with multipliers
  end type work_t

contains

  !> Data and slopes of all contact elements.
  subroutine load_elements(model, system, work)
    type(model_t), intent(in) :: model !! reference positions
    type(system_t), intent(in) :: system !! contact elements
    type(work_t), intent(inout) :: work !! gets elements and slopes
    integer :: k, i

    associate (list => system%contact)
      allocate (work%elements(list%n), work%slopes(list%n))
      do k = 1, list%n
        if (list%routine(k) == routine_none) cycle
        associate (e => work%elements(k))
          e%nel = list%nel(k)
          e%slaves = list%slaves(k)
          e%ix(:e%nel) = list%ix(:e%nel, k)
          e%weight(1) = 1.0_wp
          if (e%slaves > 1) e%weight(:e%slaves) = list%weight(:e%slaves, k)
          do i = 1, e%nel
            e%xl(:, i) = model%mesh%x(:, e%ix(i))
            e%ul(:, i) = system%u(:, e%ix(i))
          end do
          e%h1 = list%h1(:, k)
          e%shift = list%shift(:, k)
          call find_slopes(list%d(:, k), e, work%slopes(k))
        end associate
      end do
    end associate
  end subroutine load_elements

  !> What the parameters and the last increment do to each closed element.
  subroutine find_causes(model, system, condensed, s, work)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    type(sensitivity_t), intent(inout) :: s !! state before; gets lost, touched
    type(work_t), intent(inout) :: work !! gets by, change, stiffer, ways
    integer :: k, p, e, j, n

    n = size(s%slopes)
    allocate (work%by(causes, system%contact%n, n), work%stiffer(system%contact%n, n), &
      work%change(5, system%contact%n, n), source=0.0_wp)
    call find_ways(model, system, condensed, s, work)
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        e = system%place%first_point(k) + p - 1
        if (system%contact%routine(e) == routine_none) cycle
        if (work%slopes(e)%status == status_open) cycle
        do j = 1, n
          associate (slope => s%slopes(j), by => work%by(:, e, j))
            by(cause_mu:cause_mu + 1) = slope%mu(:, k)
            by(cause_rule) = slope%rule(k)
            by(cause_angle) = slope%angle(k)
            work%stiffer(e, j) = slope%penalty(k)
          end associate
        end do
        call start_slopes(model%pairs(k), p, e, system%position, s, work)
        do j = 1, n
          work%change(:, e, j) = slope_by_causes(work%slopes(e), work%by(:, e, j))
        end do
      end do
    end do
  end subroutine find_causes

  !> How the apexes of closed elements have come to their targets, and the displacements there.
  subroutine find_ways(model, system, condensed, s, work)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements, last positions
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    type(sensitivity_t), intent(inout) :: s !! state before; gets lost, touched, du
    type(work_t), intent(inout) :: work !! gets ways, way, anew
    logical :: wanted(model%mesh%nodes), exact
    integer :: k, p, e, n, i

    allocate (work%anew(system%contact%n), source=.false.)
    allocate (work%way(system%contact%n), source=0)
    allocate (work%ways(count_moves(model, system, s, work)))
    wanted = .false.
    n = 0
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        e = system%place%first_point(k) + p - 1
        if (.not. is_closed(system%contact, work, e)) cycle
        associate (pair => model%pairs(k), target => model%pairs(k)%history%old(p)%target)
          work%anew(e) = starts_anew(pair, p, e, k, system, s)
          if (.not. work%anew(e) .and. s%target(e) /= target) then
            n = n + 1
            call find_way(pair, system%position%x_old, s%target(e), s%apex(:, e), target, &
              system%contact%h1(:, e), work%ways(n), exact)
            if (.not. exact) s%lost = s%lost + 1
            work%anew(e) = work%ways(n)%n == 0
            work%way(e) = n
            do i = 1, work%ways(n)%n
              wanted(pair%surface%facets(:, work%ways(n)%facet(i))) = .true.
            end do
          end if
          if (work%anew(e)) wanted(pair%surface%facets(:, target)) = .true.
          if (work%anew(e)) wanted(work%elements(e)%ix(:work%elements(e)%slaves)) = .true.
        end associate
      end do
    end do
    call complete_nodes(condensed, wanted, s)
  end subroutine find_ways

  !> Closed elements whose target is another one than before.
  integer function count_moves(model, system, s, work) result(n)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    type(sensitivity_t), intent(in) :: s !! targets before
    type(work_t), intent(in) :: work !! slopes
    integer :: k, p, e

    n = 0
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        e = system%place%first_point(k) + p - 1
        if (is_closed(system%contact, work, e) .and. s%target(e) /= &
          model%pairs(k)%history%old(p)%target) n = n + 1
      end do
    end do
  end function count_moves

  !> An element takes part and is closed.
  pure logical function is_closed(contact, work, e)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(work_t), intent(in) :: work !! slopes
    integer, intent(in) :: e !! the element

    is_closed = contact%routine(e) /= routine_none
    if (is_closed) is_closed = work%slopes(e)%status /= status_open
  end function is_closed

  !> An apex starts at its projection, whatever was before.
  logical function starts_anew(pair, p, e, k, system, s) result(anew)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: e !! its element
    integer, intent(in) :: k !! number of the pair
    type(system_t), intent(in) :: system !! bodies and what they touch
    type(sensitivity_t), intent(inout) :: s !! state before; gets touched

    anew = s%target(e) == 0
    if (s%status(e) > status_open .or. system%touch%stage /= touch_known) return
    if (.not. system%touch%waits(system%body%node_body(pair%points%point_nodes(1, p)), k)) return
    anew = .true.
    s%touched = s%touched + 1
  end function starts_anew

  !> Derivatives of the start apex of one point in its present target.
  subroutine start_slopes(pair, p, e, position, s, work)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: e !! its element
    type(positions_t), intent(in) :: position !! last positions
    type(sensitivity_t), intent(in) :: s !! state before
    type(work_t), intent(inout) :: work !! ways; gets by
    integer :: j

    associate (x => position%x_old)
      do j = 1, size(s%slopes)
        associate (dtip => work%by(cause_apex:cause_apex + 1, e, j))
          if (work%anew(e)) then
            dtip = projection_slope(pair, p, pair%history%old(p)%target, x, s%du(:, :, j))
          else
            dtip = s%dtip(:, e, j)
            if (work%way(e) > 0) call carry_slope(pair, x, s%du(:, :, j), &
              work%ways(work%way(e)), s%apex(:, e), dtip)
          end if
        end associate
      end do
    end associate
  end subroutine start_slopes

  !> Change of the forces of one element by its causes and by what its nodes do beside.
  pure function element_change(work, e, j, epsilon, du) result(dr)
    type(work_t), intent(in) :: work !! elements, causes
    integer, intent(in) :: e !! the element
    integer, intent(in) :: j !! the parameter
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    real(wp), optional, intent(in) :: du(:, :) !! (3, nodes) displacements that change with it
    !! [length]
    real(wp) :: dr(12), change(5), dx(12)

    change = work%change(:, e, j)
    if (present(du)) then
      dx = element_motion(work%elements(e), du)
      if (any(abs(dx) > 0.0_wp)) change = change + slope_by_motion(work%slopes(e), dx)
    end if
    dr = force_slope(work%slopes(e), epsilon, epsilon*work%stiffer(e, j), change)
  end function element_change

  !> Adds the change of the gap and of the apex that the motion of the element's nodes makes.
  pure subroutine add_motion(work, e, j, dx)
    type(work_t), intent(inout) :: work !! slopes; gets change
    integer, intent(in) :: e !! the element
    integer, intent(in) :: j !! the parameter
    real(wp), intent(in) :: dx(12) !! motion of S, 1, 2, 3 [length]

    work%change(:, e, j) = work%change(:, e, j) + slope_by_motion(work%slopes(e), dx)
  end subroutine add_motion

  !> Motion of S, 1, 2, 3.
  pure function element_motion(e, du) result(dx)
    type(element_t), intent(in) :: e !! the element
    real(wp), intent(in) :: du(:, :) !! (3, nodes) [length]
    real(wp) :: dx(12)
    integer :: b

    dx = 0.0_wp
    do b = 1, e%slaves
      dx(1:3) = dx(1:3) + e%weight(b)*du(:, e%ix(b))
    end do
    do b = 1, 3
      dx(3*b + 1:3*b + 3) = du(:, e%ix(e%slaves + b))
    end do
  end function element_motion

  !> Adds forces of S, 1, 2, 3 to those of the nodes.
  pure subroutine add_forces(e, dr, force)
    type(element_t), intent(in) :: e !! the element
    real(wp), intent(in) :: dr(12) !! [force]
    real(wp), intent(inout) :: force(:, :) !! (3, nodes) [force]
    integer :: b

    do b = 1, e%slaves
      force(:, e%ix(b)) = force(:, e%ix(b)) + e%weight(b)*dr(1:3)
    end do
    do b = 1, 3
      associate (node => e%ix(e%slaves + b))
        force(:, node) = force(:, node) + dr(3*b + 1:3*b + 3)
      end associate
    end do
  end subroutine add_forces
end module increment_elements

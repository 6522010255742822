!> The contact elements of an increment that has been accepted: their slopes, what parameters and
!! the last increment do to them, and what they make of it (doc/theory, "Derivatives along the
!! path").
module increment_elements
  use kinds, only: wp
  use element_types, only: element_t, status_open
  use elmlib, only: routine_none
  use model_types, only: model_t
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use touch_path, only: touch_known
  use cone_slopes, only: cone_slopes_t, find_slopes, slope_by_causes, slope_by_motion, &
    force_slope, causes, cause_tip, cause_mu, cause_rule, cause_angle
  use host_slopes, only: way_t, find_way, carry_slope, projection_slope
  use sensitivity_types, only: sensitivity_t
  use system_types, only: system_t
  implicit none
  private
  public :: work_t, load_elements, find_causes, element_change, tip_change, element_motion, &
    add_forces

  !> The contact elements of an increment and what they get and give.
  type :: work_t
    type(cone_slopes_t), allocatable :: slopes(:) !! (elements) at the converged state
    type(element_t), allocatable :: elements(:) !! (elements) their data
    real(wp), allocatable :: by(:, :, :) !! (causes, elements, n) changes of the causes
    real(wp), allocatable :: stiffer(:, :) !! (elements, n) changes of the penalty, over itself
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
  subroutine find_causes(model, system, s, work)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    type(sensitivity_t), intent(inout) :: s !! state before; gets lost, touched
    type(work_t), intent(inout) :: work !! gets by, stiffer
    integer :: k, p, e, j, n

    n = size(s%slopes)
    allocate (work%by(causes, system%contact%n, n), work%stiffer(system%contact%n, n), &
      source=0.0_wp)
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
        call start_slopes(model%pairs(k), p, e, k, system, s, work%by(cause_tip:cause_tip + 1, &
          e, :))
      end do
    end do
  end subroutine find_causes

  !> Derivatives of the start tip of one point in its present host.
  subroutine start_slopes(pair, p, e, k, system, s, dtip)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: p !! the point
    integer, intent(in) :: e !! its element
    integer, intent(in) :: k !! number of the pair
    type(system_t), intent(in) :: system !! contact elements, last positions
    type(sensitivity_t), intent(inout) :: s !! state before; gets lost, touched
    real(wp), intent(out) :: dtip(:, :) !! (2, n)
    type(way_t) :: way
    integer :: j
    logical :: exact, anew

    associate (host => pair%history%old(p)%host)
      anew = s%host(e) == 0
      if (s%status(e) <= status_open .and. system%touch%stage == touch_known) then
        if (system%touch%waits(system%body%node_body(pair%points%point_nodes(1, p)), k)) then
          anew = .true.
          s%touched = s%touched + 1
        end if
      end if
      if (.not. anew .and. s%host(e) /= host) then
        call find_way(pair, system%position%x_old, s%host(e), s%tip(:, e), host, &
          system%contact%h1(:, e), &
                      way, exact)
        if (.not. exact) s%lost = s%lost + 1
        anew = way%n == 0
      end if
      do j = 1, size(dtip, 2)
        if (anew) then
          dtip(:, j) = projection_slope(pair, p, host, system%position%x_old, s%du(:, :, j))
          cycle
        end if
        dtip(:, j) = s%dtip(:, e, j)
        if (s%host(e) /= host) call carry_slope(pair, system%position%x_old, s%du(:, :, j), way, &
          s%tip(:, e), dtip(:, j))
      end do
    end associate
  end subroutine start_slopes

  !> Change of the forces of one element at fixed free displacements, or with these: those of its
  !! slave point and of its corners.
  pure function element_change(work, e, j, epsilon, du) result(dr)
    type(work_t), intent(in) :: work !! elements, causes
    integer, intent(in) :: e !! the element
    integer, intent(in) :: j !! the parameter
    real(wp), intent(in) :: epsilon !! penalty [force/length]
    real(wp), intent(in) :: du(:, :) !! (3, nodes) displacements that change with it [length]
    real(wp) :: dr(12)

    dr = force_slope(work%slopes(e), epsilon, epsilon*work%stiffer(e, j), tip_change(work, e, j, &
      du))
  end function element_change

  !> Change of the gap and of the tip of one element.
  pure function tip_change(work, e, j, du) result(change)
    type(work_t), intent(in) :: work !! elements, causes
    integer, intent(in) :: e !! the element
    integer, intent(in) :: j !! the parameter
    real(wp), intent(in) :: du(:, :) !! (3, nodes) displacements that change with it [length]
    real(wp) :: change(5), dx(12)

    change = slope_by_causes(work%slopes(e), work%by(:, e, j))
    dx = element_motion(work%elements(e), du)
    if (any(abs(dx) > 0.0_wp)) change = change + slope_by_motion(work%slopes(e), dx)
  end function tip_change

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

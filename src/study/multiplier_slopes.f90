!> Derivatives of the multipliers of an increment: each is the force of its point, in the frame of
!! its facet (doc/theory, "Sensitivities along the path", eq. (14.4)).
module multiplier_slopes
  use kinds, only: wp
  use element_types, only: status_open, routine_none
  use element_parameters, only: d03_epsilon
  use model_types, only: model_t
  use contact_points, only: count_points
  use contact_parameters, only: shifts_gap
  use cone_slopes, only: slope_by_causes, slope_by_motion, force_slope, turn_of_vector, &
    cause_shift, causes
  use increment_elements, only: work_t, shifted_t, element_motion, add_forces
  use sensitivity_types, only: sensitivity_t
  use system_types, only: system_t
  use element_lists, only: element_list_t
  implicit none
  private
  public :: find_shifted, shifts_wanted, shifts_answered, forces_of_shifts, take_shifts

contains

  !> The closed elements whose forces come from multipliers. The penalty that they were solved with
  !! is no parameter; one that is stiffer than that is part of the shift.
  subroutine find_shifted(model, system, s, work)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! contact elements
    type(sensitivity_t), intent(in) :: s !! parameters
    type(work_t), intent(inout) :: work !! causes found; gets shifted, stiffer
    real(wp) :: share
    integer :: k, p, e, n

    n = 0
    call make_room(any(shifts_gap(model%pairs)))
    do k = 1, size(model%pairs)
      if (.not. shifts_gap(model%pairs(k))) cycle
      do p = 1, count_points(model%pairs(k))
        e = system%place%first_point(k) + p - 1
        if (system%contact%routine(e) == routine_none) cycle
        if (work%slopes(e)%status == status_open) cycle
        share = 1.0_wp
        if (.not. model%pairs(k)%augmented) share = 1.0_wp - system%contact%d(d03_epsilon, e) &
          /model%pairs(k)%points%epsilon(p)
        if (share <= 0.0_wp) cycle
        n = n + 1
        call add_element(share)
      end do
    end do
    work%shifted%n = n

  contains

    !> Room for all points of the pairs.
    subroutine make_room(wanted)
      logical, intent(in) :: wanted !! there are such pairs
      integer :: room

      room = merge(system%contact%n, 0, wanted)
      associate (shifted => work%shifted)
        allocate (shifted%element(room), shifted%share(room), shifted%frame(3, 3, room), &
          shifted%turn(3, 12, room), shifted%own(3, room, size(s%slopes)))
      end associate
    end subroutine make_room

    !> One more.
    subroutine add_element(share)
      real(wp), intent(in) :: share !! of the force

      associate (shifted => work%shifted, g => work%slopes(e)%g)
        shifted%element(n) = e
        shifted%share(n) = share
        call turn_of_vector(work%elements(e), g, shifted%frame(:, :, n), shifted%turn(:, :, n))
        shifted%own(:, n, :) = 0.0_wp
        if (share < 1.0_wp) shifted%own(:, n, :) = spread(matmul(g, shifted%frame(:, :, n)), 2, &
          size(s%slopes))*spread((1.0_wp - share)*work%stiffer(e, :), 1, 3)
        work%stiffer(e, :) = 0.0_wp
      end associate
    end subroutine add_element
  end subroutine find_shifted

  !> What the shifts change by when gaps do, and what facets turn.
  pure function shift_of_element(shifted, i, dg, dx) result(shift)
    type(shifted_t), intent(in) :: shifted !! elements with multipliers
    integer, intent(in) :: i !! one of them
    real(wp), intent(in) :: dg(3) !! change of the gap [length]
    real(wp), intent(in) :: dx(12) !! motion of S, 1, 2, 3 [length]
    real(wp) :: shift(3)

    shift = shifted%share(i)*matmul(dg - matmul(shifted%turn(:, :, i), dx), shifted%frame(:, :, i))
  end function shift_of_element

  !> The shifts that the forces of the present derivatives ask for.
  function shifts_wanted(work, du) result(shifts)
    type(work_t), intent(in) :: work !! elements with the changes of their causes
    real(wp), intent(in) :: du(:, :, :) !! (3, nodes, parameters) [length]
    real(wp) :: shifts(3, work%shifted%n, size(du, 3))
    real(wp) :: dx(12), change(5)
    integer :: i, j

    do j = 1, size(du, 3)
      do i = 1, work%shifted%n
        associate (e => work%shifted%element(i))
          dx = element_motion(work%elements(e), du(:, :, j))
          change = work%change(:, e, j) + slope_by_motion(work%slopes(e), dx)
          shifts(:, i, j) = shift_of_element(work%shifted, i, change(1:3), dx) &
            + work%shifted%own(:, i, j)
        end associate
      end do
    end do
  end function shifts_wanted

  !> The same of shifts and of the displacements that they make alone.
  function shifts_answered(work, shifts, du) result(answer)
    type(work_t), intent(in) :: work !! elements
    real(wp), intent(in) :: shifts(:, :, :) !! (3, n, columns) [length]
    real(wp), intent(in) :: du(:, :, :) !! (3, nodes, columns) [length]
    real(wp) :: answer(3, work%shifted%n, size(du, 3))
    real(wp) :: dx(12), change(5)
    integer :: i, j

    do j = 1, size(du, 3)
      do i = 1, work%shifted%n
        associate (e => work%shifted%element(i))
          dx = element_motion(work%elements(e), du(:, :, j))
          change = slope_by_causes(work%slopes(e), causes_of(shifts(:, i, j))) &
            + slope_by_motion(work%slopes(e), dx)
          answer(:, i, j) = shift_of_element(work%shifted, i, change(1:3), dx)
        end associate
      end do
    end do
  end function shifts_answered

  !> A shift as a change of the causes.
  pure function causes_of(shift) result(by)
    real(wp), intent(in) :: shift(3) !! [length]
    real(wp) :: by(causes)

    by = 0.0_wp
    by(cause_shift:cause_shift + 2) = shift
  end function causes_of

  !> Forces of contact that shifts change at fixed displacements.
  subroutine forces_of_shifts(contact, work, shifts, force)
    type(element_list_t), intent(in) :: contact !! contact elements
    type(work_t), intent(in) :: work !! elements
    real(wp), intent(in) :: shifts(:, :, :) !! (3, n, columns) [length]
    real(wp), intent(out) :: force(:, :, :) !! (3, nodes, columns) [force]
    integer :: i, j

    force = 0.0_wp
    do j = 1, size(force, 3)
      do i = 1, work%shifted%n
        associate (e => work%shifted%element(i))
          call add_forces(work%elements(e), force_slope(work%slopes(e), contact%d(d03_epsilon, e), &
            0.0_wp, slope_by_causes(work%slopes(e), causes_of(shifts(:, i, j)))), force(:, :, j))
        end associate
      end do
    end do
  end subroutine forces_of_shifts

  !> Shifts become causes.
  subroutine take_shifts(shifts, work)
    real(wp), intent(in) :: shifts(:, :, :) !! (3, n, parameters) [length]
    type(work_t), intent(inout) :: work !! gets by, change
    integer :: i, j

    do j = 1, size(shifts, 3)
      do i = 1, work%shifted%n
        associate (e => work%shifted%element(i))
          work%by(cause_shift:cause_shift + 2, e, j) = shifts(:, i, j)
          work%change(:, e, j) = slope_by_causes(work%slopes(e), work%by(:, e, j))
        end associate
      end do
    end do
  end subroutine take_shifts
end module multiplier_slopes

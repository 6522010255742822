!> Passes by the older factors of bodies that are not linear, with today's contact, in the mean
!! rotations of the bodies (doc/theory, "Nonlinear bulk").
module bulk_passes
  use kinds, only: wp
  use costs, only: begin_cost, end_cost, cost_solve
  use lapack_interface, only: dsymv
  use right_side, only: gather_right
  use equation_values, only: spread_values, gather_values
  use body_turns, only: follow_turns, to_frames, from_frames
  use condensation, only: reduce_body, complete_body
  use contact_answer, only: answer
  use condensed_motions, only: push_bodies, in_lengths, add_live_motion, add_motion_inside
  use contact_tangent, only: form_element_matrices
  use system_types, only: form_t, system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: begin_direction, solve_pass

  !> Share of a right-hand side that the answer of contact within a pass may leave.
  real(wp), parameter :: pass_accuracy = 1.0e-4_wp
  !> Share of it that is not passed on where it is all that stands inside a body.
  real(wp), parameter :: least_inside = 1.0e-4_wp

contains

  !> Frames of the bodies, element matrices in them, and the right-hand side.
  subroutine begin_direction(system, form, x)
    type(system_t), intent(inout) :: system !! u given; gets tangent of condensed, right
    type(form_t), intent(inout) :: form !! gets condensed, right
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]

    call follow_turns(x, system, form%condensed)
    call form_element_matrices(system, form, x)
    call gather_right(system, form, 0.0_wp, .false.)
  end subroutine begin_direction

  !> One pass: the older bulk with today's contact, solved for a right-hand side.
  subroutine solve_pass(system, form, right, most, solution, answered)
    type(system_t), intent(in) :: system !! condensed bodies, tangent of contact
    type(form_t), intent(inout) :: form !! what the condensed form keeps changes
    real(wp), intent(in) :: right(:) !! (equations) [force]
    integer, intent(in) :: most !! iterations of contact allowed
    real(wp), intent(out) :: solution(:) !! (equations) [length]
    logical, intent(out) :: answered !! contact has been solved for
    real(wp) :: field(3, size(system%equation, 2)), force(form%condensed%n)
    real(wp) :: moved(form%condensed%n), alpha(form%condensed%rigid%modes)
    integer :: b

    call spread_values(system%equation, right, field)
    call to_frames(system%body, form%condensed, field)
    call push_bodies(system%body, form%condensed, field, alpha)
    do b = 1, system%body%bodies
      associate (body => form%condensed%bodies(b))
        if (.not. allocated(body%node)) cycle
        call reduce_body(body, field, least_inside*norm2(right), form%costs)
        force(body%first + 1:body%first + body%m) = body%reduced(body%equation)
      end associate
    end do
    call begin_cost(form%costs, cost_solve)
    call answer_contact(form%condensed, pass_accuracy*norm2(right), most, force, moved, alpha, &
      answered)
    call end_cost(form%costs, cost_solve)
    do b = 1, system%body%bodies
      associate (body => form%condensed%bodies(b))
        if (.not. allocated(body%node)) cycle
        call complete_body(body, moved(body%first + 1:body%first + body%m), field, form%costs)
      end associate
    end do
    call add_motion_inside(system, form%condensed, alpha, field)
    call from_frames(system%body, form%condensed, field)
    call gather_values(system%equation, field, solution)
  end subroutine solve_pass

  !> Displacements of the candidates under forces there and the answer of contact to them, without
  !! the rigid motions that supports leave, and these.
  subroutine answer_contact(condensed, floor, most, force, moved, alpha, answered)
    type(condensed_t), intent(inout) :: condensed !! tangent of contact
    real(wp), intent(in) :: floor !! force that the answer may leave [force]
    integer, intent(in) :: most !! iterations of contact allowed
    real(wp), intent(inout) :: force(:) !! (n) in: without contact; out: with it [force]
    real(wp), intent(out) :: moved(:) !! (n) [length]
    real(wp), intent(inout) :: alpha(:) !! (modes) in: work of all forces on the rigid motions
    !! [force]; out: these [length]
    logical, intent(out) :: answered !! contact has been solved for
    real(wp), allocatable :: y(:), t(:)
    logical :: dead(size(condensed%bodies))
    integer :: b

    answered = .true.
    call apply_all(condensed, force, moved, spread(.true., 1, size(condensed%bodies)))
    if (condensed%tangent%elements == 0 .and. condensed%rigid%modes == 0) return
    allocate (y(condensed%alive%n_live), t(condensed%alive%n_live))
    do b = 1, size(dead)
      associate (body => condensed%bodies(b))
        dead(b) = any(condensed%alive%live_place(body%first + 1:body%first + body%m) == 0)
      end associate
    end do
    call answer(condensed, moved(condensed%alive%live), in_lengths(condensed, alpha), floor, &
      most, y, t, answered)
    if (condensed%rigid%modes > 0) then
      alpha = condensed%rigid%alpha_next
      call add_live_motion(condensed, -alpha, t)
    end if
    force(condensed%alive%live) = force(condensed%alive%live) - y
    call apply_all(condensed, force, moved, dead)
    moved(condensed%alive%live) = t
  end subroutine answer_contact

  !> Compliance of the bodies times forces on all candidates.
  subroutine apply_all(condensed, force, moved, wanted)
    type(condensed_t), intent(in) :: condensed !! condensed bodies
    real(wp), intent(in) :: force(:) !! (n) [force]
    real(wp), intent(inout) :: moved(:) !! (n) of other bodies they stay [length]
    logical, intent(in) :: wanted(:) !! (bodies) those that are wanted
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (wanted(b) .and. body%m > 0) call dsymv('L', body%m, 1.0_wp, body%compliance, body%m, &
          force(body%first + 1:body%first + body%m), 1, 0.0_wp, &
          moved(body%first + 1:body%first + body%m), 1)
      end associate
    end do
  end subroutine apply_all
end module bulk_passes

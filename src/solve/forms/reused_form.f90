!> The form with reused factors: the bulk is not linear, the factors of its bodies at an earlier
!! state and today's contact, exactly, precede the true tangent in GMRES (doc/theory, "Nonlinear
!! bulk", eq. (12.16)).
!!
!! Factors serve as long as `find_bulk_direction` of bulk_preconditioner does not find that their
!! `aging`, the passes that new ones would have spared, exceeds what these cost (`aged`, counted by
!! bulk_factors); whether they give directions by themselves meanwhile is said by near_steps.
module reused_form
  use kinds, only: wp
  use back_ends, only: solver_done, solver_singular
  use bulk_term, only: jumps_little
  use rigid_bodies, only: spread_rigid
  use force_scales, only: force_scale
  use equation_values, only: spread_values, spread_direction
  use bulk_preconditioner, only: find_bulk_direction, solve_by_passes, solve_in_one_pass
  use near_steps, only: find_near_again, judge_nearness, note_near_step
  use condensed_system, only: couple_condensed
  use full_form, only: full_form_of_system, free_values
  use system_types, only: form_t, form_kind_t, system_t
  implicit none
  private
  public :: reused_form_of_system

  !> Residual over right-hand side that a step with the tangent at hand may leave: a step leaves
  !! such a share anyway, and passes are long.
  real(wp), parameter :: reused_accuracy = 1.0e-2_wp
  !> Residual over forces before an iteration after which the tangent of contact serves on, where
  !! that is all that an iteration forms.
  real(wp), parameter :: close_share = 0.01_wp

contains

  !> The form: what does not ask for a direction is as in the full one.
  function reused_form_of_system() result(form)
    type(form_kind_t) :: form

    form = full_form_of_system()
    form%has_energy = .false.
    form%inexact = .true.
    form%name = 'REDUCED'
    form%begin_anew => begin_anew
    form%foresee => foresee
    form%doubt_start => doubt_start
    form%couple => couple_condensed
    nullify (form%couple_as_saved)
    form%find_direction => find_direction
    form%repeat_direction => repeat_direction
    form%may_repeat => may_repeat
    form%judge_step => judge_nearness
    form%note_repeated => note_repeated
    form%next_length => next_length
    form%next_energy => next_energy
    form%answer => answer
    form%push => push
    form%sum_terms => sum_terms
  end function reused_form_of_system

  !> The other start after a stall: its bulk may strain as it likes.
  subroutine begin_anew(form)
    type(form_t), intent(inout) :: form !! near is forgotten

    form%kind%near = .false.
  end subroutine begin_anew

  !> Where factors are near, a start that leaves no more than the forces is good enough.
  subroutine foresee(system, form, known, norm)
    type(system_t), intent(in) :: system !! near
    type(form_t), intent(inout) :: form !! its kind answers
    logical, intent(out) :: known !! factors are near
    real(wp), intent(out) :: norm !! the forces [force]

    known = form%kind%near
    norm = force_scale(system%scale)
  end subroutine foresee

  !> The start strains the bulk so much that the factors are not near.
  subroutine doubt_start(system, form, x, doubtful)
    type(system_t), intent(in) :: system !! u is the start; near may go
    type(form_t), intent(inout) :: form !! gets its kind
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(out) :: doubtful !! near has gone

    doubtful = .false.
    if (.not. form%kind%near) return
    form%kind%near = jumps_little(x, system, form%inner)
    doubtful = .not. form%kind%near
  end subroutine doubt_start

  !> Tangent and direction. Bodies that tracks alone were thought to hold are regularised if there
  !! is none.
  subroutine find_direction(system, form, x, outcome)
    type(system_t), intent(inout) :: system !! gets right, solution, du
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! one of the outcomes of the solver

    call find_bulk_direction(system, form, x, force_scale(system%scale)*form%wish%wanted, outcome)
    if (outcome == solver_singular .and. system%body%settled) then
      system%body%settled = .false.
      call find_bulk_direction(system, form, x, force_scale(system%scale)*form%wish%wanted, outcome)
    end if
    if (outcome == solver_done) call spread_direction(system, form)
  end subroutine find_direction

  !> The direction that factors and contact at hand give for the present residual: by themselves
  !! where they are near, else by GMRES.
  subroutine repeat_direction(system, form, found)
    type(system_t), intent(in) :: system !! right given
    type(form_t), intent(inout) :: form !! gets solution, du
    logical, intent(out) :: found !! there is one

    if (form%kind%near) then
      call find_near_again(system, form, found)
    else
      found = .true.
      form%condensed%norm_before = norm2(form%right)
      call solve_by_passes(system, form, form%right, form%solution, left=reused_accuracy)
    end if
    if (found) call spread_direction(system, form)
  end subroutine repeat_direction

  !> Not where the tangent was that of the last state: a new one costs less than the steps that it
  !! saves; nor, far from equilibrium, with the tangent of contact alone.
  pure logical function may_repeat(system, form, start, linearised) result(may)
    type(system_t), intent(in) :: system !! near
    type(form_t), intent(in) :: form !! its kind answers
    real(wp), intent(in) :: start !! residual before the iteration [force]
    logical, intent(in) :: linearised !! its tangent was the bulk's of the last state

    may = .not. linearised
    if (form%kind%near) may = may .and. start <= close_share*force_scale(system%scale)
  end function may_repeat

  !> A step with near factors ages them.
  subroutine note_repeated(form, left)
    type(form_t), intent(inout) :: form !! aging grows
    real(wp), intent(in) :: left !! share of the residual that it has left

    if (form%kind%near) call note_near_step(form%condensed, left)
  end subroutine note_repeated

  !> Length of the next direction, by a single pass.
  real(wp) function next_length(system, form) result(length)
    type(system_t), intent(in) :: system !! residual of the trial; next is used
    type(form_t), intent(inout) :: form !! right given; gets condensed, next

    call solve_in_one_pass(system, form, form%right, form%next)
    length = norm2(form%next)
  end function next_length

  !> Work of the residual on that direction.
  real(wp) function next_energy(system, form) result(energy)
    type(system_t), intent(in) :: system !! residual; next is used
    type(form_t), intent(inout) :: form !! right given; gets condensed, next

    energy = next_length(system, form)
    energy = abs(dot_product(form%right, form%next))
  end function next_energy

  !> Displacements that forces bring by themselves.
  subroutine answer(system, form, force, du)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! tangent at hand; next is used
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp), intent(out) :: du(:, :) !! (3, nodes) [length]

    call solve_by_passes(system, form, free_values(system, form%right, force), form%next)
    call spread_values(system%equation, form%next, du)
    call spread_rigid(system, form%next, du)
  end subroutine answer

  !> The direction with forces beside the residual.
  subroutine push(system, form, force)
    type(system_t), intent(in) :: system !! tangent at hand
    type(form_t), intent(inout) :: form !! gets solution, du
    real(wp), intent(in) :: force(:, :) !! (3, nodes) [force]
    real(wp) :: change(size(form%solution))

    call solve_by_passes(system, form, free_values(system, form%right, force), change)
    form%solution = form%solution + change
    call spread_direction(system, form)
  end subroutine push

  !> Norm of the terms that the bulk's forces sum, by the rows of its undeformed matrix.
  subroutine sum_terms(system, form, terms)
    type(system_t), intent(in) :: system !! u given; trial is used
    type(form_t), intent(inout) :: form !! gets trial
    real(wp), intent(out) :: terms !! [force]
    integer :: k

    do k = 1, size(system%u, 2)
      form%trial(:, k) = matmul(form%inner%rows(:, :, k), abs(system%u(:, k)))
    end do
    where (system%equation == 0) form%trial = 0.0_wp
    terms = norm2(form%trial)
  end subroutine sum_terms
end module reused_form

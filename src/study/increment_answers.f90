!> The linear system of an increment that has been accepted, for all parameters at once: right-hand
!! sides, and displacements of the candidates (doc/theory, "Sensitivities along the path").
module increment_answers
  use kinds, only: wp
  use element_types, only: status_open
  use element_parameters, only: d03_epsilon
  use loads, only: load_factor, add_force
  use model_types, only: model_t
  use back_ends, only: solver_done
  use linear_answers, only: prepare_answers, answer_all
  use increment_elements, only: work_t, element_change, add_forces
  use sensitivity_types, only: sensitivity_t, slope_t
  use system_types, only: form_t, system_t
  use condensed_types, only: condensed_t
  implicit none
  private
  public :: solve_all, answer_forces, factor_change, add_changes

  !> What is left of the force of a parameter, over that force; less where Euler's sum checks it.
  real(wp), parameter :: increment_residue = 5.0e-11_wp, share_of_euler = 1.0e-12_wp
  !> The same where multipliers are found from answers.
  real(wp), parameter :: share_with_multipliers = 5.0e-12_wp, share_of_multipliers = 1.0e-13_wp

contains

  !> Solves for the displacements of the candidates, all parameters at once:
  !! (I + C k) du = db - C c, and the forces c + k du.
  subroutine solve_all(model, system, form, time, s, work, trouble)
    type(model_t), intent(in) :: model !! reference positions
    type(system_t), intent(inout) :: system !! condensed
    type(form_t), intent(inout) :: form !! its kind given; gets condensed
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(inout) :: s !! du at supports given; gets it at candidates
    type(work_t), intent(in) :: work !! elements, causes
    character(:), allocatable, intent(inout) :: trouble !! not solved
    real(wp), allocatable :: u(:, :), c(:, :)
    integer :: n, outcome, attempt, j, i
    logical :: arrived, late(form%condensed%n)

    n = size(s%slopes)
    s%answers%share_left = spread(merge(increment_residue, share_with_multipliers, work%shifted%n &
      == 0), 1, n)
    s%answers%share_left(pack(s%euler%slope, s%euler%slope > &
      0)) = merge(share_of_euler, share_of_multipliers, work%shifted%n == 0)
    arrived = .false.
    do attempt = 1, 2
      u = spread(spread(0.0_wp, 1, form%condensed%n), 2, n)
      c = u
      call collect_right(model, system, form, time, s, work, u, c)
      call prepare_answers(system, form, model%mesh%x, attempt == 2, outcome)
      if (outcome /= solver_done) exit
      call answer_all(form%condensed, c, u, arrived, late, s%answers)
      if (arrived) exit
    end do
    if (.not. arrived) then
      trouble = 'the derivatives do not converge: the tangent of contact is singular at the '// &
        'converged state'
      return
    end if
    if (.not. allocated(s%answers%late)) allocate (s%answers%late(3, model%mesh%nodes))
    s%answers%late = .false.
    associate (condensed => form%condensed)
      do i = 1, condensed%n
        s%answers%late(condensed%direction(i), condensed%node(i)) = late(i)
      end do
      do j = 1, n
        do i = 1, condensed%n
          s%du(condensed%direction(i), condensed%node(i), j) = u(i, j)
        end do
      end do
    end associate
  end subroutine solve_all

  !> Displacements of the candidates that closed elements touch for forces of contact, with what
  !! contact answers, for as many columns as there are.
  subroutine answer_forces(condensed, s, force, du, arrived)
    type(condensed_t), intent(inout) :: condensed !! condensed, with the tangent of solve_all
    type(sensitivity_t), intent(inout) :: s !! room of the answers
    real(wp), intent(in) :: force(:, :, :) !! (3, nodes, columns) [force]
    real(wp), intent(out) :: du(:, :, :) !! (3, nodes, columns); 0 at all other nodes [length]
    logical, intent(out) :: arrived !! all of them
    real(wp), allocatable :: u(:, :), c(:, :)
    logical :: late(condensed%n)
    integer :: i, columns

    columns = size(force, 3)
    s%answers%share_left = spread(share_of_multipliers, 1, columns)
    du = 0.0_wp
    allocate (u(condensed%n, columns), c(condensed%n, columns), source=0.0_wp)
    do i = 1, condensed%n
      c(i, :) = force(condensed%direction(i), condensed%node(i), :)
    end do
    call answer_all(condensed, c, u, arrived, late, s%answers)
    do i = 1, condensed%n
      if (.not. late(i)) du(condensed%direction(i), condensed%node(i), :) = u(i, :)
    end do
  end subroutine answer_forces

  !> Displacements of the candidates without contact and forces of contact at fixed candidates.
  subroutine collect_right(model, system, form, time, s, work, loaded, c)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! condensed
    type(form_t), intent(in) :: form !! what the condensed form keeps
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(in) :: s !! slopes, prescribed displacements
    type(work_t), intent(in) :: work !! elements, causes
    real(wp), intent(inout) :: loaded(:, :) !! (candidates, n) [length]
    real(wp), intent(inout) :: c(:, :) !! (candidates, n) [force]
    real(wp) :: force(3, model%mesh%nodes), factor, change, stiffer
    integer :: i, j, k, e

    force = 0.0_wp
    associate (condensed => form%condensed)
      do j = 1, size(s%slopes)
        force(:, s%levers%loaded) = 0.0_wp
        do e = 1, size(work%elements)
          if (work%slopes(e)%status == status_open) cycle
          call add_forces(work%elements(e), element_change(work, e, j, &
            system%contact%d(d03_epsilon, e), s%du(:, :, j)), force)
        end do
        do i = 1, condensed%n
          c(i, j) = force(condensed%direction(i), condensed%node(i))
        end do
        associate (slope => s%slopes(j))
          do k = 1, size(slope%loads)
            factor = load_factor(model%tables, slope%loads(k)%table, time)
            do i = 1, condensed%n
              loaded(i, j) = loaded(i, j) + factor*slope%influence(condensed%direction(i), &
                condensed%node(i), k)
            end do
          end do
          do k = 1, size(model%conditions%loads)
            factor = load_factor(model%tables, model%conditions%loads(k)%table, time)
            change = factor_change(slope, model%conditions%loads(k)%table, time)
            do i = 1, condensed%n
              associate (m => condensed%direction(i), node => condensed%node(i))
                stiffer = slope%stiffness(system%body%node_body(node))
                loaded(i, j) = loaded(i, j) + change*condensed%outer%influence(m, node, k) &
                  + (slope%forces - stiffer)*factor*s%pushed(m, node, k)
              end associate
            end do
          end do
          do i = 1, condensed%n
            loaded(i, j) = loaded(i, j) + &
              slope%stiffness(system%body%node_body(condensed%node(i)))*condensed%bulk%product(i)
          end do
        end associate
      end do
    end associate
  end subroutine collect_right

  !> Adds the derivatives of the applied forces, times a factor.
  subroutine add_changes(model, slope, time, factor, force)
    type(model_t), intent(in) :: model !! loads and their tables
    type(slope_t), intent(in) :: slope !! the parameter
    real(wp), intent(in) :: time !! end of the increment
    real(wp), intent(in) :: factor !! the factor
    real(wp), intent(inout) :: force(:, :) !! (3, nodes) [force]
    integer :: k

    do k = 1, size(slope%loads)
      call add_force(slope%loads(k), factor*load_factor(model%tables, slope%loads(k)%table, time), &
        force)
    end do
    do k = 1, size(model%conditions%loads)
      associate (load => model%conditions%loads(k))
        call add_force(load, factor*(factor_change(slope, load%table, time) + slope%forces &
          *load_factor(model%tables, load%table, time)), force)
      end associate
    end do
  end subroutine add_changes

  !> Derivative of the factor of a proportional load by a parameter.
  real(wp) function factor_change(slope, table, time) result(change)
    type(slope_t), intent(in) :: slope !! the parameter
    integer, intent(in) :: table !! number of the proportional load
    real(wp), intent(in) :: time !! time
    integer :: i

    change = 0.0_wp
    do i = 1, size(slope%variants)
      change = change + slope%variants(i)%weight*load_factor(slope%variants(i)%tables, table, time)
    end do
  end function factor_change
end module increment_answers

!> Derivatives of an increment with the matrix of all nodes: its tangent at the converged state has
!! one right-hand side a parameter (doc/theory, "Sensitivities along the path", eq. (14.3)).
module full_answers
  use kinds, only: wp
  use element_types, only: status_open, routine_none
  use element_parameters, only: d03_epsilon
  use back_ends, only: solver_done
  use block_matrix, only: multiply
  use mesh_names, only: find_nodes
  use model_types, only: model_t, load_t
  use full_tangent, only: form_tangent
  use rigid_border, only: factorise_bordered, solve_bordered
  use equation_values, only: gather_values
  use increment_elements, only: work_t, element_change, add_forces
  use increment_answers, only: add_changes
  use lever_sums, only: supported_nodes, loaded_nodes
  use sensitivity_types, only: sensitivity_t
  use system_types, only: form_t, system_t, state_t
  implicit none
  private
  public :: start_full, solve_full, answer_full, full_reactions

  !> Residual over right-hand side that an iterative solver may leave.
  real(wp), parameter :: answer_residue = 1.0e-13_wp

contains

  !> Nodes with supports, and those that contact or a load may load.
  subroutine start_full(model, equation, s)
    type(model_t), intent(in) :: model !! pairs, loads
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(sensitivity_t), intent(inout) :: s !! gets supports and loaded of levers
    type(load_t), allocatable :: others(:)
    integer :: j, k, n

    allocate (others(sum([(size(s%slopes(j)%loads), j=1, size(s%slopes))])))
    n = 0
    do j = 1, size(s%slopes)
      do k = 1, size(s%slopes(j)%loads)
        n = n + 1
        others(n) = s%slopes(j)%loads(k)
      end do
    end do
    s%levers%supports = supported_nodes(equation)
    s%levers%loaded = loaded_nodes(model, others)
    s%started = .true.
  end subroutine start_full

  !> Displacements of all nodes: K du = dp - dK u - K dw - c with the tangent K of bulk and contact.
  subroutine solve_full(model, system, form, time, s, work, again, trouble)
    type(model_t), intent(in) :: model !! reference positions, loads
    type(system_t), intent(inout) :: system !! its tangent and factor are made anew
    type(form_t), intent(inout) :: form !! gets border, right, matrix
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(inout) :: s !! du at supports given; gets that of all nodes
    type(work_t), intent(in) :: work !! elements, causes
    logical, intent(in) :: again !! with the factor of the last call
    character(:), allocatable, intent(inout) :: trouble !! not solved
    real(wp) :: right(size(form%right))
    integer :: j, outcome

    outcome = solver_done
    if (.not. again) then
      call form_tangent(system, form, model%mesh%x)
      form%whole%solver%accuracy = answer_residue
      call factorise_bordered(system, form, form%whole%symmetric, outcome)
    end if
    do j = 1, size(s%slopes)
      if (outcome /= solver_done) exit
      where (system%equation > 0) s%du(:, :, j) = 0.0_wp
      call collect_forces(model, system, form, time, s, work, j, right)
      call solve_column(system, form, right, s%du(:, :, j), outcome)
    end do
    if (outcome /= solver_done) trouble = 'the tangent is singular at the converged state'
  end subroutine solve_full

  !> One right-hand side with the factor at hand; supports stay.
  subroutine solve_column(system, form, right, du, outcome)
    type(system_t), intent(in) :: system !! tangent and factor
    type(form_t), intent(inout) :: form !! gets border, matrix
    real(wp), intent(in) :: right(:) !! (equations) [force]
    real(wp), intent(inout) :: du(:, :) !! (3, nodes) free ones are given values [length]
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    real(wp) :: answer(size(right))
    integer :: i, k

    answer = 0.0_wp
    call solve_bordered(system, form, right, answer, outcome)
    do i = 1, size(du, 2)
      do k = 1, 3
        if (system%equation(k, i) > 0) du(k, i) = answer(system%equation(k, i))
      end do
    end do
  end subroutine solve_column

  !> Displacements of all nodes for forces of contact, with what contact answers.
  subroutine answer_full(system, form, force, du, arrived)
    type(system_t), intent(in) :: system !! with the factor of solve_full
    type(form_t), intent(inout) :: form !! gets border, matrix
    real(wp), intent(in) :: force(:, :, :) !! (3, nodes, columns) [force]
    real(wp), intent(out) :: du(:, :, :) !! (3, nodes, columns) [length]
    logical, intent(out) :: arrived !! all of them
    real(wp) :: right(size(form%right))
    integer :: j, outcome

    du = 0.0_wp
    arrived = .true.
    do j = 1, size(force, 3)
      right = 0.0_wp
      call gather_values(system%equation, -force(:, :, j), right)
      call solve_column(system, form, right, du(:, :, j), outcome)
      arrived = arrived .and. outcome == solver_done
    end do
  end subroutine answer_full

  !> Forces out of balance while free nodes stay where they are.
  subroutine collect_forces(model, system, form, time, s, work, j, right)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! bulk, contact elements
    type(form_t), intent(in) :: form !! matrix
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(in) :: s !! slopes, du at supports
    type(work_t), intent(in) :: work !! elements, causes
    integer, intent(in) :: j !! the parameter
    real(wp), intent(out) :: right(:) !! (equations) [force]
    real(wp) :: force(3, size(system%equation, 2))
    integer :: e

    call stretch_bulk(model, system, form, time, s, j, force)
    do e = 1, size(work%elements)
      if (system%contact%routine(e) == routine_none) cycle
      if (work%slopes(e)%status == status_open) cycle
      call add_forces(work%elements(e), element_change(work, e, j, &
        system%contact%d(d03_epsilon, e), s%du(:, :, j)), force)
    end do
    right = 0.0_wp
    call gather_values(system%equation, -force, right)
  end subroutine collect_forces

  !> Change of the forces of the bulk, less that of the loads: K du + dK u - dp.
  subroutine stretch_bulk(model, system, form, time, s, j, force)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! bulk
    type(form_t), intent(in) :: form !! matrix, forces of the bulk
    real(wp), intent(in) :: time !! end of the increment
    type(sensitivity_t), intent(in) :: s !! slopes, du
    integer, intent(in) :: j !! the parameter
    real(wp), intent(out) :: force(:, :) !! (3, nodes) [force]
    integer :: i

    call multiply(form%whole%bulk_matrix, s%du(:, :, j), force)
    do i = 1, size(force, 2)
      if (system%body%node_body(i) > 0) force(:, i) = force(:, i) &
        + s%slopes(j)%stiffness(system%body%node_body(i))*form%inner%bulk_force(:, i)
    end do
    call add_changes(model, s%slopes(j), time, -1.0_wp, force)
  end subroutine stretch_bulk

  !> Derivatives of the reactions: what bulk and contact do at the supports, less the loads there.
  subroutine full_reactions(model, system, form, state, s)
    type(model_t), intent(in) :: model !! sets, loads
    type(system_t), intent(in) :: system !! bulk
    type(form_t), intent(in) :: form !! matrix, forces of the bulk
    type(state_t), intent(in) :: state !! time, reactions
    type(sensitivity_t), intent(inout) :: s !! du and force given; gets reaction, total
    real(wp) :: force(3, size(state%u, 2))
    integer, allocatable :: nodes(:)
    integer :: j, i
    logical :: found

    do j = 1, size(s%slopes)
      call stretch_bulk(model, system, form, state%time, s, j, force)
      force(:, s%levers%loaded) = force(:, s%levers%loaded) + s%force(:, s%levers%loaded, j)
      where (system%equation > 0) force = 0.0_wp
      do i = 1, size(s%sets)
        call find_nodes(model%mesh, s%sets(i)%s, nodes, found)
        s%reaction(:, i, j) = sum(force(:, nodes), 2)
        s%total(:, i) = sum(merge(state%reaction(:, nodes), 0.0_wp, system%equation(:, nodes) &
          == 0), 2)
      end do
    end do
  end subroutine full_reactions
end module full_answers

!> Springs to ground: stiffness on the diagonal of the bulk's matrix, forces that count as reactions
!! (doc/theory, "Loads").
module springs
  use kinds, only: wp
  use model_types, only: model_t
  use block_matrix, only: find_block
  use system_types, only: system_t, state_t
  use system_parts, only: bulk_answer_t, outer_t, whole_form_t
  implicit none
  private
  public :: start_springs, add_springs, add_spring_forces, spring_reactions, is_supported

contains

  !> Takes the springs of free degrees of freedom; on the others they would act on supports alone.
  pure subroutine start_springs(model, equation, loads)
    type(model_t), intent(in) :: model !! springs
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(outer_t), intent(inout) :: loads !! gets spring, if there are such

    if (.not. allocated(model%conditions%spring)) return
    loads%spring = model%conditions%spring
    where (equation == 0) loads%spring = 0.0_wp
  end subroutine start_springs

  !> Adds them to the bulk's matrix.
  pure subroutine add_springs(loads, whole)
    type(outer_t), intent(in) :: loads !! springs
    type(whole_form_t), intent(inout) :: whole !! its bulk_matrix has been assembled
    integer :: node, place, k

    if (.not. allocated(loads%spring)) return
    do node = 1, size(loads%spring, 2)
      if (all(loads%spring(:, node) <= 0.0_wp)) cycle
      place = find_block(whole%bulk_matrix, node, node)
      do k = 1, 3
        associate (stiffness => whole%bulk_matrix%val(k, k, place))
          stiffness = stiffness + loads%spring(k, node)
        end associate
      end do
    end do
  end subroutine add_springs

  !> Adds their forces to those of the bulk.
  pure subroutine add_spring_forces(u, loads, inner)
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(outer_t), intent(in) :: loads !! springs
    type(bulk_answer_t), intent(inout) :: inner !! bulk_force grows

    if (allocated(loads%spring)) inner%bulk_force = inner%bulk_force + loads%spring*u
  end subroutine add_spring_forces

  !> Their forces on the bodies are reactions.
  pure subroutine spring_reactions(system, state)
    type(system_t), intent(in) :: system !! springs
    type(state_t), intent(inout) :: state !! u given; gets reaction on free degrees of freedom

    if (.not. allocated(system%loads%spring)) return
    where (system%equation > 0) state%reaction = -system%loads%spring*state%u
  end subroutine spring_reactions

  !> A support or a spring resists a degree of freedom.
  pure logical function is_supported(system, k, node) result(yes)
    type(system_t), intent(in) :: system !! equations, springs
    integer, intent(in) :: k !! 1, 2 or 3
    integer, intent(in) :: node !! the node

    yes = system%equation(k, node) == 0
    if (allocated(system%tools%carried_by)) yes = yes .and. system%tools%carried_by(node) == 0
    if (yes .or. .not. allocated(system%loads%spring)) return
    yes = system%loads%spring(k, node) > 0.0_wp
  end function is_supported
end module springs

!> HOLD where no pair can hold anything: what supports leave a body to move is stopped at as many of
!! its nodes. In balance these fixings carry nothing; the audit does not count them among the
!! supports (doc/theory, "Floating bodies").
module held_bodies
  use kinds, only: wp
  use model_types, only: model_t
  use rigid_motions, only: motions_t, find_motions, choose_fixings
  use system_types, only: system_t
  use system_parts, only: bodies_t, bulk_answer_t
  implicit none
  private
  public :: fix_held, fixing_reaction, supports_of

contains

  !> Chooses the fixings of the bodies that the deck holds.
  subroutine fix_held(model, numbers, bodies)
    type(model_t), intent(in) :: model !! mesh, HOLD, conditions
    integer, intent(in) :: numbers(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(bodies_t), intent(inout) :: bodies !! connected bodies; gets fixed
    type(motions_t) :: motions
    integer :: equation(3, size(numbers, 2)), body, k, b
    integer, allocatable :: node(:), direction(:)
    logical :: wanted(0:bodies%bodies)

    if (size(model%pairs) > 0 .or. .not. allocated(model%held)) return
    wanted = .false.
    wanted(pack(bodies%node_body, model%held)) = .true.
    do b = 1, size(model%conditions%rigid)
      wanted(bodies%node_body(model%conditions%rigid(b)%nodes)) = .false.
    end do
    if (.not. any(wanted(1:))) return
    equation = numbers
    if (allocated(model%conditions%spring)) where (model%conditions%spring > 0.0_wp) equation = 0
    allocate (bodies%fixed(3, size(equation, 2)), source=.false.)
    do body = 1, bodies%bodies
      if (.not. wanted(body)) cycle
      call find_motions(model%mesh%x, equation, bodies%node_body, body, motions)
      if (motions%n == 0) cycle
      call choose_fixings(model%mesh%x, equation, bodies%node_body, body, motions, node, direction)
      do k = 1, motions%n
        bodies%fixed(direction(k), node(k)) = .true.
      end do
    end do
  end subroutine fix_held

  !> What the fixings of a body carry.
  pure real(wp) function fixing_reaction(system, inner, body) result(force)
    type(system_t), intent(in) :: system !! converged
    type(bulk_answer_t), intent(in) :: inner !! forces of the bulk
    integer, intent(in) :: body !! the body
    integer :: i

    force = 0.0_wp
    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) /= body) cycle
      force = hypot(force, norm2(pack(inner%bulk_force(:, i) &
        - system%loads%external(:, i), system%body%fixed(:, i))))
    end do
  end function fixing_reaction

  !> Forces of the supports without those of fixings.
  pure function supports_of(body, reaction) result(force)
    type(bodies_t), intent(in) :: body !! fixed, if the deck holds anything
    real(wp), intent(in) :: reaction(:, :) !! (3, nodes) of all restrained directions [force]
    real(wp) :: force(3, size(reaction, 2))

    force = reaction
    if (allocated(body%fixed)) where (body%fixed) force = 0.0_wp
  end function supports_of
end module held_bodies

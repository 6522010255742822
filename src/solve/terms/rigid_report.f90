!> What is told of rigid bodies with a point: their motion, and the forces of their constraints
!! (doc/theory, "Rigid bodies").
module rigid_report
  use kinds, only: wp
  use model_types, only: model_t
  use rigid_paths, only: motion_at, load_at
  use rigid_bodies, only: wrench_on
  use system_types, only: system_t, state_t
  use system_parts, only: rigid_part_t
  implicit none
  private
  public :: rigid_rows, rigid_imbalance

contains

  !> Translation and rotation vector of each point, force and moment that the constraint exerts.
  pure function rigid_rows(model, system, state) result(rows)
    type(model_t), intent(in) :: model !! rigid bodies
    type(system_t), intent(in) :: system !! their nodes
    type(state_t), intent(in) :: state !! converged
    real(wp) :: rows(12, size(state%rigid, 2))
    integer :: b

    do b = 1, size(rows, 2)
      rows(1:6, b) = motion_at(model, b, state%time) + state%rigid(:, b)
      rows(7:12, b) = needed(model, system%tools, state, b)
      rows(6 + system%tools%rigid(b)%unknown, b) = 0.0_wp
    end do
  end function rigid_rows

  !> What no constraint and no load takes of the forces on a connected body, moments over a lever.
  pure function rigid_imbalance(model, system, state, body) result(lacking)
    type(model_t), intent(in) :: model !! rigid bodies
    type(system_t), intent(in) :: system !! their nodes
    type(state_t), intent(in) :: state !! converged
    integer, intent(in) :: body !! connected body
    real(wp) :: lacking(6), all_of_it(6)
    integer :: b

    lacking = 0.0_wp
    do b = 1, size(state%rigid, 2)
      if (system%tools%rigid(b)%body /= body) cycle
      associate (free => system%tools%rigid(b)%unknown)
        all_of_it = needed(model, system%tools, state, b)
        lacking(free) = lacking(free) - all_of_it(free)
      end associate
    end do
  end function rigid_imbalance

  !> Force and moment on the point that would balance a body.
  pure function needed(model, tools, state, b) result(w)
    type(model_t), intent(in) :: model !! rigid bodies
    type(rigid_part_t), intent(in) :: tools !! their nodes
    type(state_t), intent(in) :: state !! converged
    integer, intent(in) :: b !! the body
    real(wp) :: w(6)

    w = wrench_on(tools%rigid(b), state%u, state%rigid(1:3, b), state%reaction) &
      - load_at(model, b, state%time)
  end function needed
end module rigid_report

!> What the model prescribes at the end of an increment: displacements, loads, rigid bodies and
!! overlaps.
module increment_conditions
  use kinds, only: wp
  use loads, only: conditions_at, load_factor
  use follower_pressure, only: set_pressures
  use rigid_bodies, only: begin_rigid
  use model_types, only: model_t
  use system_parts, only: outer_t, rigid_part_t
  use system_types, only: state_t
  implicit none
  private
  public :: take_overlaps, begin_at

contains

  !> SHRInk: what of the overlaps of the start is not taken up at `time`.
  pure subroutine take_overlaps(model, time)
    type(model_t), intent(inout) :: model !! tables; pairs: withheld
    real(wp), intent(in) :: time !! end of the increment
    integer :: k

    do k = 1, size(model%pairs)
      if (model%pairs(k)%shrinking%shrink >= 0) model%pairs(k)%shrinking%withheld = 1.0_wp - &
        load_factor(model%tables, model%pairs(k)%shrinking%shrink, time)
    end do
  end subroutine take_overlaps

  !> Prescribed displacements and applied forces at `time`.
  subroutine begin_at(model, state, time, equation, u, loads, tools)
    type(model_t), intent(in) :: model !! conditions and loads
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) gets prescribed values, else the state's
    type(outer_t), intent(inout) :: loads !! gets external, pressure
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies begin there

    call conditions_at(model, time, displacement=u, force=loads%external)
    where (equation > 0) u = state%u
    call begin_rigid(model, u, tools, state, time)
    call set_pressures(model, time, loads)
  end subroutine begin_at
end module increment_conditions

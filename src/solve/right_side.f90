!> The right-hand side of Newton's equations: forces out of balance.
module right_side
  use kinds, only: wp
  use condensed_system, only: gather_condensed
  use rigid_bodies, only: add_rigid_right
  use system_types, only: system_t
  implicit none
  private
  public :: gather_right

contains

  !> right = applied - internal forces on the free degrees of freedom.
  subroutine gather_right(system, length, tried)
    type(system_t), intent(inout) :: system !! gets right
    real(wp), intent(in) :: length !! share of bulk_change
    logical, intent(in) :: tried !! forces are those of the trial
    integer :: i, k

    if (system%condensed%active) then
      call gather_condensed(system, length)
      return
    end if
    do i = 1, size(system%equation, 2)
      do k = 1, 3
        if (system%equation(k, i) == 0) cycle
        system%right(system%equation(k, i)) = system%loads%external(k, i) - &
          system%inner%bulk_force(k, i) &
          - length*system%inner%bulk_change(k, i) - system%contact_force(k, i)
      end do
    end do
    if (system%tools%border%n == 0) return
    if (tried) then
      call add_rigid_right(system, system%trial, .true., nodal_forces(system, length))
    else
      call add_rigid_right(system, system%u, .false., nodal_forces(system, length))
    end if
  end subroutine gather_right

  !> What acts on the nodes: applied - internal forces.
  pure function nodal_forces(system, length) result(force)
    type(system_t), intent(in) :: system !! forces given
    real(wp), intent(in) :: length !! share of bulk_change
    real(wp) :: force(3, size(system%equation, 2))

    force = system%loads%external - system%inner%bulk_force - length*system%inner%bulk_change - &
      system%contact_force
  end function nodal_forces
end module right_side

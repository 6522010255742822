!> The right-hand side of Newton's equations: forces out of balance.
module right_side
  use kinds, only: wp
  use condensed_system, only: gather_condensed
  use system_types, only: system_t
  implicit none
  private
  public :: gather_right

contains

  !> right = applied - internal forces on the free degrees of freedom.
  subroutine gather_right(system, length)
    type(system_t), intent(inout) :: system !! gets right
    real(wp), intent(in) :: length !! share of bulk_change
    integer :: i, k

    if (system%condensed%active) then
      call gather_condensed(system, length)
      return
    end if
    do i = 1, size(system%equation, 2)
      do k = 1, 3
        if (system%equation(k, i) == 0) cycle
        system%right(system%equation(k, i)) = system%external(k, i) - system%bulk_force(k, i) &
          - length*system%bulk_change(k, i) - system%contact_force(k, i)
      end do
    end do
  end subroutine gather_right
end module right_side

!> Contact forces that are foretold for an increment in which points touch first: those before
!! friction acts there, and those after (doc/theory, "Variants of a run").
module foretold_forces
  use kinds, only: wp
  use condensed_types, only: condensed_t, influence_t
  use compliance_products, only: find_equilibrium
  use condensed_system, only: spread_forces, restore_forces
  implicit none
  private
  public :: expect_without_friction, note_touching, take_rubbed

contains

  !> Friction waits at points that touch first: the increment starts from the forces that are
  !! expected without it, if these are foretold, and those with it come later.
  pure subroutine expect_without_friction(outer)
    type(influence_t), intent(inout) :: outer !! kept, smooth given; gets kept, rubbed

    if (.not. (outer%foretold .and. allocated(outer%smooth))) return
    call move_alloc(outer%kept, outer%rubbed)
    call move_alloc(outer%smooth, outer%kept)
  end subroutine expect_without_friction

  !> Notes the forces of an increment before friction acts at points that touch first.
  pure subroutine note_touching(condensed)
    type(condensed_t), intent(inout) :: condensed !! force given; gets touching

    if (.not. condensed%narrow) return
    if (.not. allocated(condensed%outer%touching)) allocate (condensed%outer%touching(3, &
      size(condensed%place, 2)))
    call spread_forces(condensed, condensed%outer%touching)
  end subroutine note_touching

  !> Candidates in equilibrium with the forces that are expected once friction acts.
  subroutine take_rubbed(condensed, floats, u, taken)
    type(condensed_t), intent(inout) :: condensed !! rubbed given; gets force
    logical, intent(in) :: floats !! there are bodies that contact alone holds
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]
    logical, intent(out) :: taken !! these were foretold
    real(wp) :: there(condensed%n)
    integer :: i

    taken = allocated(condensed%outer%rubbed) .and. .not. floats
    if (.not. taken) return
    call move_alloc(condensed%outer%rubbed, condensed%outer%kept)
    call restore_forces(condensed)
    call find_equilibrium(condensed, there)
    do i = 1, condensed%n
      u(condensed%direction(i), condensed%node(i)) = there(i)
    end do
  end subroutine take_rubbed
end module foretold_forces

!> Loads that have grown by a factor: where these loads alone have bent and pressed the bodies, all
!! has grown by it (doc/theory, "Start").
module grown_start
  use kinds, only: wp
  use loads, only: conditions_at
  use model_types, only: model_t
  use system_types, only: system_t, state_t
  implicit none
  private
  public :: is_pile, load_growth, grow_multipliers

  !> What is not the same multiple for all loads is less than this share of them.
  real(wp), parameter :: proportional = 1.0e-12_wp

  !> So many bodies that contact alone holds make a pile.
  integer, parameter :: many_bodies = 3

contains

  !> Bodies that contact alone holds lean on each other: their multipliers rest first, as these lead
  !! each other astray far from the solution, and their increments take many solves from a start
  !! that knows nothing of how the loads have grown.
  pure logical function is_pile(system) result(pile)
    type(system_t), intent(in) :: system !! bodies

    pile = count(system%body%weak) >= many_bodies
  end function is_pile

  !> The factor, above 1, by which all loads and prescribed displacements have grown since the last
  !! state; 1 if there is none, or if other than linear bodies and contact answer to them.
  real(wp) function load_growth(model, system, state) result(growth)
    type(model_t), intent(in) :: model !! loads
    type(system_t), intent(in) :: system !! u and external at the end of the increment
    type(state_t), intent(in) :: state !! last converged state
    real(wp), dimension(3, size(system%u, 2), 2) :: before, now
    real(wp) :: factor
    integer :: i

    growth = 1.0_wp
    if (.not. system%bulk%linear .or. system%tools%border%n > 0 .or. &
      allocated(system%loads%pressed)) return
    call conditions_at(model, state%time, displacement=before(:, :, 1), force=before(:, :, 2))
    now(:, :, 1) = system%u
    now(:, :, 2) = system%loads%external
    where (system%equation > 0)
      before(:, :, 1) = 0.0_wp
      now(:, :, 1) = 0.0_wp
    end where
    if (all(abs(before) <= 0.0_wp)) return
    i = merge(1, 2, any(abs(before(:, :, 1)) > 0.0_wp))
    factor = norm2(now(:, :, i))/norm2(before(:, :, i))
    if (factor <= 1.0_wp + proportional) return
    do i = 1, 2
      if (norm2(now(:, :, i) - factor*before(:, :, i)) > proportional*norm2(now(:, :, i))) return
    end do
    growth = factor
  end function load_growth

  !> Multipliers grow with the loads.
  pure subroutine grow_multipliers(model, growth)
    type(model_t), intent(inout) :: model !! pairs: working points
    real(wp), intent(in) :: growth !! the factor
    integer :: k, p

    do k = 1, size(model%pairs)
      do p = 1, size(model%pairs(k)%history%new)
        model%pairs(k)%history%new(p)%lambda = growth*model%pairs(k)%history%new(p)%lambda
      end do
    end do
  end subroutine grow_multipliers
end module grown_start

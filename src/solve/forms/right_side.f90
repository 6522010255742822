!> The right-hand side of Newton's equations: forces out of balance.
module right_side
  use kinds, only: wp
  use rigid_bodies, only: add_rigid_right
  use system_types, only: form_t, system_t
  use system_parts, only: bodies_t
  implicit none
  private
  public :: gather_right, gather_points, damping_shares

contains

  !> right = applied - internal forces on the free degrees of freedom.
  subroutine gather_right(system, form, length, tried)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets right
    real(wp), intent(in) :: length !! share of bulk_change
    logical, intent(in) :: tried !! forces are those of the trial
    integer :: i, k

    do i = 1, size(system%equation, 2)
      do k = 1, 3
        if (system%equation(k, i) == 0) cycle
        form%right(system%equation(k, i)) = system%loads%external(k, i) - &
          form%inner%bulk_force(k, i) - length*form%bulk_change(k, i) - system%contact_force(k, i)
      end do
    end do
    if (system%body%damping > 0.0_wp) then
      if (tried) then
        call add_damping(system, form%right, form%trial)
      else
        call add_damping(system, form%right, system%u)
      end if
    end if
    call gather_points(system, form, length, tried, nodal_forces(system, form, length))
  end subroutine gather_right

  !> The same for the unknowns of rigid bodies with a point.
  subroutine gather_points(system, form, length, tried, force)
    type(system_t), intent(in) :: system !! the problem
    type(form_t), intent(inout) :: form !! gets right behind the equations of the nodes
    real(wp), intent(in) :: length !! share of the direction
    logical, intent(in) :: tried !! forces are those of the trial
    real(wp), intent(in) :: force(:, :) !! (3, nodes) applied - internal forces

    if (system%tools%unknowns == 0) return
    if (tried) then
      call add_rigid_right(form%right, system%tools, form%trial, .true., force)
      if (system%body%damping > 0.0_wp) call add_rigid_damping(system, form%right, &
        system%body%damped_way + length*form%solution(system%equations + 1:))
    else
      call add_rigid_right(form%right, system%tools, system%u, .false., force)
      if (system%body%damping > 0.0_wp) call add_rigid_damping(system, form%right, &
        system%body%damped_way)
    end if
  end subroutine gather_points

  !> The damping's force on rigid bodies with a point.
  pure subroutine add_rigid_damping(system, right, gone)
    type(system_t), intent(in) :: system !! right changes
    real(wp), intent(inout) :: right(:) !! (equations+unknowns) right-hand side [force]
    real(wp), intent(in) :: gone(:) !! (unknowns) way since the step began [length]

    right(system%equations + 1:) = right(system%equations + 1:) - system%body%damping*gone
  end subroutine add_rigid_damping

  !> The damping's force on the nodes of bodies that supports do not hold.
  subroutine add_damping(system, right, u)
    type(system_t), intent(in) :: system !! right changes
    real(wp), intent(inout) :: right(:) !! (equations+unknowns) right-hand side [force]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp) :: share(system%body%bodies)
    integer :: i, k

    share = damping_shares(system%body)
    do i = 1, size(system%equation, 2)
      if (system%body%node_body(i) == 0) cycle
      do k = 1, 3
        if (system%equation(k, i) == 0) cycle
        right(system%equation(k, i)) = right(system%equation(k, i)) - &
          share(system%body%node_body(i))*(u(k, i) - system%body%damped_from(k, i))
      end do
    end do
  end subroutine add_damping

  !> The damping on each node of the bodies, 0 where supports hold them.
  pure function damping_shares(body) result(share)
    type(bodies_t), intent(in) :: body !! bodies, damping
    real(wp) :: share(body%bodies)
    integer :: b

    share = [(body%damping/real(max(1, count(body%node_body == b)), wp), b=1, body%bodies)]
    where (.not. body%floating) share = 0.0_wp
  end function damping_shares

  !> What acts on the nodes: applied - internal forces.
  pure function nodal_forces(system, form, length) result(force)
    type(system_t), intent(in) :: system !! loads, forces of contact
    type(form_t), intent(in) :: form !! bulk_force, bulk_change
    real(wp), intent(in) :: length !! share of bulk_change
    real(wp) :: force(3, size(system%equation, 2))

    force = system%loads%external - form%inner%bulk_force - length*form%bulk_change - &
      system%contact_force
  end function nodal_forces
end module right_side

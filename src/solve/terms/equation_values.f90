!> Between the unknowns of the equations and the degrees of freedom of the nodes.
module equation_values
  use kinds, only: wp
  use rigid_bodies, only: spread_rigid
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: spread_values, gather_values, spread_direction

contains

  !> Values of the unknowns to the nodes, zero where prescribed.
  pure subroutine spread_values(equation, values, field)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: values(:) !! (equations or more)
    real(wp), intent(out) :: field(:, :) !! (3, nodes)
    integer :: i, k

    do i = 1, size(equation, 2)
      do k = 1, 3
        field(k, i) = 0.0_wp
        if (equation(k, i) > 0) field(k, i) = values(equation(k, i))
      end do
    end do
  end subroutine spread_values

  !> Values at the free degrees of freedom of the nodes.
  pure subroutine gather_values(equation, field, values)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: field(:, :) !! (3, nodes)
    real(wp), intent(out) :: values(:) !! (equations)
    integer :: i, k

    do i = 1, size(equation, 2)
      do k = 1, 3
        if (equation(k, i) > 0) values(equation(k, i)) = field(k, i)
      end do
    end do
  end subroutine gather_values

  !> Solution vector to displacements of the nodes, those that rigid bodies carry as well.
  subroutine spread_direction(system, form)
    type(system_t), intent(in) :: system !! solution given
    type(form_t), intent(inout) :: form !! gets du

    call spread_values(system%equation, form%solution, form%du)
    call spread_rigid(system, form%solution, form%du)
  end subroutine spread_direction
end module equation_values

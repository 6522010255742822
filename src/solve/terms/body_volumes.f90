!> Volumes of the parts of bodies that small strain deforms, and how these parts turn
!! (doc/theory, "Strain and rotation", eq. (13.5)).
module body_volumes
  use kinds, only: wp
  use vectors, only: cross
  use cells, only: corners_of
  use cell_geometry, only: cell_volume, cell_growth
  use element_types, only: routine_none, routine_finite
  use system_types, only: system_t
  implicit none
  private
  public :: find_volumes, add_volume_gradient, find_part_turns

contains

  !> The element is of small strain, and can deform.
  pure logical function counts(system, k)
    type(system_t), intent(in) :: system !! elements, equations
    integer, intent(in) :: k !! the element

    counts = all(system%bulk%routine(k) /= [routine_none, routine_finite])
    if (counts) counts = any(system%equation(:, system%bulk%ix(:system%bulk%nel(k), k)) > 0)
  end function counts

  !> Volume of these elements of each body, by their corners.
  pure subroutine find_volumes(x, system, volume)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(system_t), intent(in) :: system !! elements, bodies, equations
    real(wp), intent(out) :: volume(:) !! (bodies) [length^3]
    integer :: k

    volume = 0.0_wp
    do k = 1, system%bulk%n
      if (.not. counts(system, k)) cycle
      associate (b => system%body%node_body(system%bulk%ix(1, k)))
        volume(b) = volume(b) + cell_volume(x, system%bulk%ix(:, k))
      end associate
    end do
  end subroutine find_volumes

  !> Adds what the volume of a body changes by where its nodes move: dV = sum of g.u.
  pure subroutine add_volume_gradient(x, system, body, g)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(in) :: system !! elements, bodies, equations
    integer, intent(in) :: body !! the body
    real(wp), intent(inout) :: g(:, :) !! (3, nodes) grows [length^2]
    integer :: k

    do k = 1, system%bulk%n
      if (system%body%node_body(system%bulk%ix(1, k)) /= body) cycle
      if (.not. counts(system, k)) cycle
      associate (node => system%bulk%ix(:system%bulk%nel(k), k))
        g(:, node) = g(:, node) + cell_growth(x, node)
      end associate
    end do
  end subroutine add_volume_gradient

  !> Mean rotation of these elements of each body, half the curl of the displacements: what turns
  !! the part of small strain of a body whose other elements are of finite strain.
  pure subroutine find_part_turns(x, u, system, turn)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(system_t), intent(in) :: system !! elements, bodies, equations
    real(wp), intent(out) :: turn(:, :) !! (3, bodies) [radian]
    real(wp) :: volume(size(turn, 2))
    real(wp), allocatable :: g(:, :)
    integer :: i, k

    turn = 0.0_wp
    do k = 1, system%bulk%n
      if (.not. counts(system, k)) cycle
      associate (node => corners_of(system%bulk%ix(:, k)), &
        b => system%body%node_body(system%bulk%ix(1, k)))
        g = cell_growth(x, node)
        do i = 1, size(node)
          turn(:, b) = turn(:, b) + 0.5_wp*cross(g(:, i), u(:, node(i)))
        end do
      end associate
    end do
    call find_volumes(x, system, volume)
    do i = 1, size(volume)
      if (abs(volume(i)) > 0.0_wp) turn(:, i) = turn(:, i)/volume(i)
    end do
  end subroutine find_part_turns
end module body_volumes

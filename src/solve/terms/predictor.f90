!> Predictor: every body is carried along rigidly with its prescribed increment (doc/theory,
!! "Start").
module predictor
  use kinds, only: wp
  use vectors, only: cross, find_extent, identity
  use rotations, only: rotation_matrix
  use rigid_motions, only: rigid_row
  use lapack_interface, only: dgelss
  use system_parts, only: positions_t, rigid_part_t
  implicit none
  private
  public :: carry_bodies, turn_bodies, leave_bodies, take_along

  !> Singular values below this share of the largest belong to motions nothing prescribes.
  real(wp), parameter :: rank_tolerance = 1.0e-10_wp
  !> Motions that are fitted one after the other: the digits of a turn double with each.
  integer, parameter :: most_fits = 12
  !> The last one of these, over the size of the model.
  real(wp), parameter :: well_fitted = 1.0e-13_wp

contains

  !> Moves the free nodes of each body by the rigid motion that fits its prescribed increments best
  !! (least squares, smallest motion among equals).
  subroutine carry_bodies(x, equation, node_body, bodies, u_old, u)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    integer, intent(in) :: node_body(:) !! (nodes) body of each node
    integer, intent(in) :: bodies !! number of bodies
    real(wp), intent(in) :: u_old(:, :) !! (3, nodes) last converged displacements [length]
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) in: prescribed values set; out: all [length]
    real(wp) :: motion(6), center(3), low(3), high(3), size_x
    real(wp) :: turned(3), turn(3)
    integer :: body, i, k

    call find_extent(x, low, high)
    center = 0.5_wp*(high + low)
    size_x = max(maxval(high - low), tiny(1.0_wp))
    do body = 1, bodies
      motion = best_motion(x, equation, node_body, body, u_old, u, center, size_x)
      if (all(abs(motion) <= 0.0_wp)) cycle
      turn = motion(4:6)/size_x
      do i = 1, size(x, 2)
        if (node_body(i) /= body) cycle
        turned = cross(turn, x(:, i) - center)
        do k = 1, 3
          if (equation(k, i) > 0) u(k, i) = u_old(k, i) + motion(k) + turned(k)
        end do
      end do
    end do
  end subroutine carry_bodies

  !> The same where bodies may turn by any angle: from where they are, by the motion that fits best
  !! and strains nothing. A small motion fits a turn badly, so what it has left is fitted again.
  subroutine turn_bodies(x, equation, node_body, bodies, u_old, u)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    integer, intent(in) :: node_body(:) !! (nodes) body of each node
    integer, intent(in) :: bodies !! number of bodies
    real(wp), intent(in) :: u_old(:, :) !! (3, nodes) last converged displacements [length]
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) in: prescribed values set; out: all [length]
    real(wp) :: motion(6), center(3), low(3), high(3), size_x, turned(3, 3), v(3, size(x, 2))
    integer :: body, fit, i

    call find_extent(x, low, high)
    center = 0.5_wp*(high + low)
    size_x = max(maxval(high - low), tiny(1.0_wp))
    v = u_old
    do body = 1, bodies
      do fit = 1, most_fits
        motion = best_motion(x + v, equation, node_body, body, v, u, center, size_x)
        if (maxval(abs(motion)) <= well_fitted*size_x) exit
        turned = rotation_matrix(motion(4:6)/size_x) - identity
        do i = 1, size(x, 2)
          if (node_body(i) == body) v(:, i) = v(:, i) + motion(:3) + matmul(turned, x(:, i) &
            + v(:, i) - center)
        end do
      end do
    end do
    where (equation > 0) u = v
  end subroutine turn_bodies

  !> Translation and (scaled) rotation that fit the increments of a body.
  function best_motion(x, equation, node_body, body, u_old, u, center, size_x) result(motion)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    integer, intent(in) :: node_body(:) !! (nodes) body of each node
    integer, intent(in) :: body !! the body
    real(wp), intent(in) :: u_old(:, :) !! (3, nodes) last converged displacements [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) prescribed values set [length]
    real(wp), intent(in) :: center(3) !! where rotations turn about [length]
    real(wp), intent(in) :: size_x !! size of the model [length]
    real(wp) :: motion(6), normal(6, 6), right(6, 1), row(6), values(6), work(200)
    real(wp) :: y(3), largest
    integer :: i, j, k, rank, info

    motion = 0.0_wp
    largest = 0.0_wp
    do i = 1, size(x, 2)
      if (node_body(i) /= body) cycle
      if (minval(equation(:, i)) > 0) cycle
      largest = max(largest, maxval(abs(u(:, i) - u_old(:, i)), equation(:, i) == 0))
    end do
    if (largest <= 0.0_wp) return
    normal = 0.0_wp
    right = 0.0_wp
    do i = 1, size(x, 2)
      if (node_body(i) /= body) cycle
      if (minval(equation(:, i)) > 0) cycle
      y = (x(:, i) - center)/size_x
      do k = 1, 3
        if (equation(k, i) > 0) cycle
        row = rigid_row(k, y)
        right(:, 1) = right(:, 1) + row*(u(k, i) - u_old(k, i))
        do j = 1, 6
          normal(:, j) = normal(:, j) + row*row(j)
        end do
      end do
    end do
    call dgelss(6, 6, 1, normal, 6, right, 6, values, rank_tolerance, rank, work, size(work), info)
    if (info == 0) motion = right(:, 1)
  end function best_motion

  !> Starts from where the bodies were.
  pure subroutine leave_bodies(u, position, tools)
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(positions_t), intent(in) :: position !! positions of the nodes
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point

    u = position%left
    tools%ahead = .false.
  end subroutine leave_bodies

  !> Starts from where the predictor takes the bodies.
  pure subroutine take_along(u, position, tools)
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(positions_t), intent(in) :: position !! positions of the nodes
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point

    u = position%carried
    tools%ahead = .true.
  end subroutine take_along
end module predictor

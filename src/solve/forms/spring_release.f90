!> Rigid motions of regularised bodies, freed of the soft springs where contact resists them in part
!! (doc/theory, "Floating bodies", eq. (9.10)).
module spring_release
  use kinds, only: wp
  use lapack_interface, only: dgelss
  use block_matrix, only: find_block, multiply
  use rigid_motions, only: mode_row
  use supports, only: soft_springs
  use equation_values, only: spread_values, gather_values
  use system_types, only: system_t
  implicit none
  private
  public :: release_springs, unresisted

  !> Motions that contact resists by less than this share of the stiffest one are not resisted.
  real(wp), parameter :: unresisted = 1.0e-9_wp

contains

  !> Adds to the solution with a regularised matrix the rigid motions after which the forces of the
  !! soft springs do no work on any motion that contact resists: R^T K R a = R^T G u,
  !! by least squares of minimum norm, so that what nothing resists stays where the springs have it.
  subroutine release_springs(system, x)
    type(system_t), intent(inout) :: system !! tangent, regularised, solution, which is moved
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp) :: spring(3, size(x, 2)), u(3, size(x, 2)), stiffness
    real(wp), allocatable :: a(:, :), b(:, :)
    integer :: first(system%body%bodies), n

    if (.not. any(system%body%regularised) .or. system%tools%border%n > 0) return
    call count_motions(system, first, n)
    if (n == 0) return
    call find_springs(system, spring, stiffness)
    call spread_values(system%equation, system%solution, u)
    allocate (a(n, n), b(n, 1))
    b(:, 1) = work_on_motions(system, x, first, n, spring*u)
    call form_resistance(system, x, first, spring, a)
    if (norm2(a) <= epsilon(1.0_wp)*stiffness) return
    call solve_least(max(unresisted, epsilon(1.0_wp)*stiffness/norm2(a)), a, b)
    u = u + displacement_of(system, x, first, b(:, 1))
    call gather_values(system%equation, u, system%solution)
  end subroutine release_springs

  !> The place before the first motion of each regularised body, -1 for others; how many there are.
  pure subroutine count_motions(system, first, n)
    type(system_t), intent(in) :: system !! bodies
    integer, intent(out) :: first(:) !! (bodies)
    integer, intent(out) :: n !! motions
    integer :: body

    first = -1
    n = 0
    do body = 1, system%body%bodies
      if (.not. system%body%regularised(body)) cycle
      first(body) = n
      n = n + system%body%motions(body)%n
    end do
  end subroutine count_motions

  !> The soft springs, and the sum of the stiffness of their nodes.
  pure subroutine find_springs(system, spring, stiffness)
    type(system_t), intent(in) :: system !! tangent with the springs
    real(wp), intent(out) :: spring(:, :) !! (3, nodes) 0 where there is none [force/length]
    real(wp), intent(out) :: stiffness !! [force/length]
    integer :: node, k, place

    spring = 0.0_wp
    do node = 1, size(spring, 2)
      if (system%body%node_body(node) == 0) cycle
      if (.not. system%body%regularised(system%body%node_body(node))) cycle
      place = find_block(system%whole%matrix, node, node)
      do k = 1, 3
        if (system%equation(k, node) > 0) spring(k, node) = soft_springs/(1.0_wp + soft_springs) &
          *system%whole%matrix%val(k, k, place)
      end do
    end do
    stiffness = sum(abs(spring))/soft_springs
  end subroutine find_springs

  !> Work of nodal forces on each motion: R^T f.
  pure function work_on_motions(system, x, first, n, force) result(work)
    type(system_t), intent(in) :: system !! bodies, motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: first(:) !! (bodies) place before the first motion
    integer, intent(in) :: n !! motions
    real(wp), intent(in) :: force(:, :) !! (3, nodes)
    real(wp) :: work(n)
    integer :: node, k

    work = 0.0_wp
    do node = 1, size(x, 2)
      associate (body => system%body%node_body(node))
        if (body == 0) cycle
        if (first(body) < 0) cycle
        associate (at => first(body), motions => system%body%motions(body))
          do k = 1, 3
            if (system%equation(k, node) > 0) work(at + 1:at + motions%n) = &
              work(at + 1:at + motions%n) + mode_row(motions, k, x(:, node))*force(k, node)
          end do
        end associate
      end associate
    end do
  end function work_on_motions

  !> What contact alone does against the motions: R^T K R.
  pure subroutine form_resistance(system, x, first, spring, a)
    type(system_t), intent(in) :: system !! tangent, bodies, motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: first(:) !! (bodies) place before the first motion
    real(wp), intent(in) :: spring(:, :) !! (3, nodes) G [force/length]
    real(wp), intent(out) :: a(:, :) !! (motions, motions) [force/length]
    real(wp) :: way(3, size(x, 2)), force(3, size(x, 2)), only(size(a, 1))
    integer :: j

    do j = 1, size(a, 1)
      only = 0.0_wp
      only(j) = 1.0_wp
      way = displacement_of(system, x, first, only)
      call multiply(system%whole%matrix, way, force) ! K + G
      a(:, j) = work_on_motions(system, x, first, size(a, 1), force - spring*way)
    end do
  end subroutine form_resistance

  !> Displacements of the free degrees of freedom in a sum of motions: R a.
  pure function displacement_of(system, x, first, share) result(way)
    type(system_t), intent(in) :: system !! bodies, motions
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: first(:) !! (bodies) place before the first motion
    real(wp), intent(in) :: share(:) !! (motions) of each motion [length]
    real(wp) :: way(3, size(x, 2))
    integer :: node, k

    way = 0.0_wp
    do node = 1, size(x, 2)
      associate (body => system%body%node_body(node))
        if (body == 0) cycle
        if (first(body) < 0) cycle
        associate (motions => system%body%motions(body))
          do k = 1, 3
            if (system%equation(k, node) > 0) way(k, node) = dot_product(mode_row(motions, k, &
              x(:, node)), share(first(body) + 1:first(body) + motions%n))
          end do
        end associate
      end associate
    end do
  end function displacement_of

  !> Least squares of minimum norm; singular values below a share of the largest count as none.
  subroutine solve_least(share, a, b)
    real(wp), intent(in) :: share !! of the largest singular value
    real(wp), intent(inout) :: a(:, :) !! (n, n) destroyed
    real(wp), intent(inout) :: b(:, :) !! (n, 1) in: right-hand side; out: solution, 0 if it fails
    real(wp) :: s(size(a, 1)), work(10*size(a, 1) + 64)
    integer :: rank, info

    call dgelss(size(a, 1), size(a, 1), 1, a, size(a, 1), b, size(a, 1), s, share, rank, work, &
      size(work), info)
    if (info /= 0) b = 0.0_wp
  end subroutine solve_least
end module spring_release

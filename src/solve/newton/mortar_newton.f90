!> Forces of the multipliers: Newton's method on the projection onto the cones (doc/theory, "Mortar
!! contact", eqs. (7.16), (7.17)).
module mortar_newton
  use kinds, only: wp
  use lapack_interface, only: dgetrf, dgetrs
  use mortar_cone, only: project_on_cone
  use mortar_system, only: mortar_system_t
  implicit none
  private
  public :: mortar_result_t, solve_multipliers, what_is_left

  !> Steps at most; a first touch has taken up to 8.
  integer, parameter :: most_steps = 30
  !> Halvings of a step while what is left grows.
  integer, parameter :: most_halvings = 5
  !> What may be left, over the largest force; and over the round-off of the gaps without forces.
  real(wp), parameter :: share_left = 1.0e-12_wp, noise = 8.0_wp
  !> A pivot below this share of the largest of the rigid motions says that contact leaves one free;
  !! what then stops it in the step alone, over the stiffness of a node: the others hardly feel it.
  real(wp), parameter :: no_pivot = 1.0e-10_wp, soft = 1.0e-6_wp
  !> Bodies that touch nothing go this far beyond the nearest gap.
  real(wp), parameter :: beyond = 1.5_wp

  !> How the solve ended.
  type :: mortar_result_t
    logical :: converged = .false. !! it has
    logical :: singular = .false. !! nothing can hold the bodies
    integer :: steps = 0 !! Newton steps
    real(wp), allocatable :: gap(:) !! (3 n) slip and gap [length]
    real(wp), allocatable :: force(:) !! (3 n) along the frames [force]
    real(wp), allocatable :: motion(:) !! (modes) rigid motions [length]
    logical, allocatable :: closed(:), slips(:) !! (n) status
    real(wp), allocatable :: criterion(:) !! (n) [force]
    real(wp) :: left = 0.0_wp !! largest defect [force]
  end type mortar_result_t

  !> An iterate: forces, motions, what is left of F = z - Pi(y) and of the balance of the bodies.
  type :: iterate_t
    real(wp), allocatable :: z(:), alpha(:), gap(:), defect(:), balance(:)
    real(wp), allocatable :: slope(:, :, :) !! (3, 3, n) dPi/dy
    logical, allocatable :: closed(:), slips(:)
    real(wp), allocatable :: criterion(:)
  end type iterate_t

contains

  !> Solves for forces and rigid motions.
  subroutine solve_multipliers(unknowns, start, motion, result, near)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    real(wp), intent(in) :: start(:) !! (3 n) forces to begin with [force]
    real(wp), intent(in) :: motion(:) !! (modes) rigid motions to begin with [length]
    type(mortar_result_t), intent(out) :: result !! gets all
    real(wp), intent(in), optional :: near(:) !! (3 n) gaps that say which are closed and stick to
    !! begin with [length]
    type(iterate_t) :: now, next
    real(wp) :: change(size(start) + size(motion)), allowed, length
    integer :: halving, n
    logical :: free

    n = size(start)
    call look_at(unknowns, start, motion, now, near)
    do
      allowed = max(share_left*maxval([0.0_wp, abs(now%z)]), round_off(unknowns))
      result%left = maxval([0.0_wp, abs(now%defect), abs(now%balance)])
      result%converged = result%left <= allowed .and. .not. (present(near) .and. result%steps == 0)
      if (result%converged .or. result%steps == most_steps) exit
      call find_step(unknowns, now, 0.0_wp, change, free)
      if (free) call find_step(unknowns, now, hold_of(unknowns, now), change, result%singular)
      if (result%singular) exit
      result%steps = result%steps + 1
      length = 1.0_wp
      do halving = 0, most_halvings
        call look_at(unknowns, now%z + length*change(:n), now%alpha + length*change(n + 1:), next)
        if (free .or. measure(next) < measure(now)) exit
        length = 0.5_wp*length
      end do
      now = next
    end do
    result%gap = now%gap
    result%force = now%z
    result%motion = now%alpha
    result%closed = now%closed
    result%slips = now%slips
    result%criterion = now%criterion
  end subroutine solve_multipliers

  !> What the law lacks where no force moves anything, the largest of all [force].
  pure real(wp) function what_is_left(unknowns, z) result(left)
    type(mortar_system_t), intent(in) :: unknowns !! gaps, laws
    real(wp), intent(in) :: z(:) !! (3 n) forces [force]
    real(wp) :: force(3), slope(3, 3), criterion
    integer :: i
    logical :: slips

    left = 0.0_wp
    do i = 1, unknowns%n
      associate (mine => z(3*i - 2:3*i), cone => unknowns%cone(i))
        call project_on_cone(cone, mine - cone%scale([1, 1, 2])*unknowns%gap(3*i - 2:3*i), force, &
          slope, slips, criterion)
        left = max(left, maxval(abs(mine - force)))
      end associate
    end do
  end function what_is_left

  !> What is left, as one number [force].
  pure real(wp) function measure(iterate)
    type(iterate_t), intent(in) :: iterate !! an iterate

    measure = norm2([norm2(iterate%defect), norm2(iterate%balance)])
  end function measure

  !> What round-off of the gaps without forces makes of forces.
  pure real(wp) function round_off(unknowns) result(force)
    type(mortar_system_t), intent(in) :: unknowns !! gaps and scales
    integer :: i

    force = 0.0_wp
    do i = 1, unknowns%n
      force = max(force, maxval(abs(unknowns%gap(3*i - 2:3*i)))*maxval(unknowns%cone(i)%scale))
    end do
    force = noise*epsilon(force)*force
  end function round_off

  !> Gaps, projections and what is left at given forces, eq. (7.16).
  subroutine look_at(unknowns, z, alpha, iterate, near)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    real(wp), intent(in) :: z(:) !! (3 n) forces [force]
    real(wp), intent(in) :: alpha(:) !! (modes) rigid motions [length]
    type(iterate_t), intent(out) :: iterate !! all of it
    real(wp), intent(in), optional :: near(:) !! (3 n) gaps to linearise at, else theirs [length]
    real(wp) :: y(3), force(3), off(3*unknowns%n)
    integer :: i

    associate (n => unknowns%n)
      allocate (iterate%defect(3*n), iterate%slope(3, 3, n), iterate%closed(n), iterate%slips(n), &
        iterate%criterion(n))
      iterate%z = z
      iterate%alpha = alpha
      iterate%gap = unknowns%gap + matmul(unknowns%compliance, z)
      if (size(alpha) > 0) iterate%gap = iterate%gap + matmul(unknowns%motion, alpha)
      iterate%balance = matmul(z, unknowns%push) + unknowns%load - matmul(unknowns%hold, alpha)
      off = 0.0_wp
      if (present(near)) off = iterate%gap - near
      do i = 1, n
        associate (own => 3*i - 2, cone => unknowns%cone(i))
          y = z(own:own + 2) - cone%scale([1, 1, 2])*(iterate%gap(own:own + 2) - off(own:own + 2))
          call project_on_cone(cone, y, force, iterate%slope(:, :, i), iterate%slips(i), &
            iterate%criterion(i))
          iterate%closed(i) = y(3) > 0.0_wp
          iterate%defect(own:own + 2) = z(own:own + 2) - force + matmul(iterate%slope(:, :, i), &
            cone%scale([1, 1, 2])*off(own:own + 2))
        end associate
      end do
    end associate
  end subroutine look_at

  !> What stops rigid motions in a step that contact does not: so much that bodies out of balance go
  !! to the nearest gap, and little where all are in balance.
  pure real(wp) function hold_of(unknowns, now) result(hold)
    type(mortar_system_t), intent(in) :: unknowns !! gaps, loads
    type(iterate_t), intent(in) :: now !! an iterate
    real(wp) :: way, lacking
    integer :: i

    hold = soft*mean_stiffness(unknowns)
    lacking = maxval(abs(now%balance))
    if (lacking <= soft*maxval(abs(unknowns%load)) .or. all(now%closed)) return
    way = minval([(now%gap(3*i), i=1, unknowns%n)], .not. now%closed)
    hold = max(hold, lacking/max(beyond*way, lacking/mean_stiffness(unknowns)))
  end function hold_of

  !> Stiffness of a node, on average.
  pure real(wp) function mean_stiffness(unknowns) result(unit)
    type(mortar_system_t), intent(in) :: unknowns !! scales
    integer :: i

    unit = 1.0_wp
    if (unknowns%n > 0) unit = sum([(unknowns%cone(i)%scale(2), i=1, unknowns%n)]) &
      /real(unknowns%n, wp)
  end function mean_stiffness

  !> Newton's step: open multipliers go to zero, and the others solve what is left, bordered by the
  !! rigid motions, eq. (7.17).
  subroutine find_step(unknowns, now, hold, change, singular)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    type(iterate_t), intent(in) :: now !! where it starts
    real(wp), intent(in) :: hold !! stops rigid motions in the step alone [force/length]
    real(wp), intent(out) :: change(:) !! (3 n + modes) of forces and motions
    logical, intent(out) :: singular !! there is none
    real(wp), allocatable :: matrix(:, :), right(:, :)
    integer, allocatable :: kept(:), pivot(:)
    real(wp) :: unit, slope(3, 3)
    integer :: i, k, n, m, info

    change = 0.0_wp
    kept = pack([(i, i=1, 3*unknowns%n)], [(now%closed((i + 2)/3), i=1, 3*unknowns%n)])
    n = size(kept)
    m = size(now%alpha)
    where (.not. [(now%closed((i + 2)/3), i=1, 3*unknowns%n)]) change(:3*unknowns%n) = -now%z
    singular = .false.
    if (n + m == 0) return
    ! motions in the unit of forces: their columns are as large as the others
    unit = mean_stiffness(unknowns)
    allocate (matrix(n + m, n + m), right(n + m, 1), pivot(n + m))
    associate (gone => matmul(unknowns%compliance(kept, :), change(:3*unknowns%n)))
      do k = 1, n, 3
        i = (kept(k) + 2)/3
        slope = now%slope(:, :, i)*spread(unknowns%cone(i)%scale([1, 1, 2]), 1, 3)
        matrix(k:k + 2, :n) = matmul(slope, unknowns%compliance(kept(k:k + 2), kept))
        matrix(k:k + 2, k:k + 2) = matrix(k:k + 2, k:k + 2) - now%slope(:, :, i)
        matrix(k, k) = matrix(k, k) + 1.0_wp
        matrix(k + 1, k + 1) = matrix(k + 1, k + 1) + 1.0_wp
        matrix(k + 2, k + 2) = matrix(k + 2, k + 2) + 1.0_wp
        matrix(k:k + 2, n + 1:) = matmul(slope, unknowns%motion(kept(k:k + 2), :))/unit
        right(k:k + 2, 1) = -now%defect(kept(k:k + 2)) - matmul(slope, gone(k:k + 2))
      end do
    end associate
    matrix(n + 1:, :n) = transpose(unknowns%push(kept, :))
    matrix(n + 1:, n + 1:) = -unknowns%hold/unit
    do k = n + 1, n + m
      matrix(k, k) = matrix(k, k) - hold/unit
    end do
    right(n + 1:, 1) = -now%balance - matmul(change(:3*unknowns%n), unknowns%push)
    call dgetrf(n + m, n + m, matrix, n + m, pivot, info)
    singular = info /= 0
    if (m > 0 .and. hold <= 0.0_wp .and. .not. singular) singular = minval([(abs(matrix(k, k)), &
      k=n + 1, n + m)]) <= no_pivot*maxval([(abs(matrix(k, k)), k=n + 1, n + m)])
    if (singular) return
    call dgetrs('N', n + m, 1, matrix, n + m, pivot, right, n + m, info)
    change(kept) = right(:n, 1)
    change(3*unknowns%n + 1:) = right(n + 1:, 1)/unit
  end subroutine find_step
end module mortar_newton

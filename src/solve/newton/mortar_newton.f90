!> Forces of the multipliers: Newton's method on the projection onto the cones (doc/theory, "Mortar
!! contact", eqs. (7.16), (7.17)).
!! In more than 400 lines, since an iterate, its step and what round-off leaves of it are one.
module mortar_newton
  use kinds, only: wp
  use element_types, only: status_open, status_slip
  use lapack_interface, only: dgetrf, dgetrs
  use mortar_cone, only: project_on_cone
  use mortar_unknowns, only: mortar_system_t
  implicit none
  private
  public :: mortar_result_t, mortar_factor_t, solve_multipliers, forget_factor, &
    what_is_left, what_law_lacks, all_round_off

  !> Newton's steps at most, of which a first touch has taken up to 8, and damped ones after these.
  integer, parameter :: most_plain = 20, most_damped = 30
  !> Halvings of a step while what is left grows.
  integer, parameter :: most_halvings = 5
  !> What may be left, over the largest force; and over the round-off of the gaps without forces.
  real(wp), parameter :: share_left = 1.0e-12_wp, noise = 8.0_wp, of_balance = 1.0e-3_wp
  !> A pivot below this share of the largest of the rigid motions says that contact leaves one free;
  !! what then stops it in the step alone, over the stiffness of a node: the others hardly feel it.
  real(wp), parameter :: no_pivot = 1.0e-10_wp, soft = 1.0e-6_wp
  !> A factor serves other steps while each leaves no more than this share.
  real(wp), parameter :: factor_serves = 0.1_wp
  !> Multipliers of one node on faces whose nodes are the same: their gaps are, too, and only the
  !! sum of their forces acts. This much more compliance in the step alone keeps both changes small.
  real(wp), parameter :: evens_out = 1.0e-9_wp
  !> So may those around an edge that several bodies share: where Newton's steps do not end, all get
  !! more, what is left over the forces, at most this. Springs on the motions are as stiff over a
  !! node: what slips on all sides goes along nearly without resistance.
  real(wp), parameter :: damps_at_most = 1.0e-6_wp
  !> Where Newton's method begins, one after the other: with the status of the last state, with what
  !! the gaps are, with friction that holds whatever it has to.
  integer, parameter :: from_status = 0, from_gaps = 1, from_sticking = 2
  !> Free bodies go this far, over the way to the first gap.
  real(wp), parameter :: beyond = 1.5_wp

  !> What damps Newton's steps: nothing; compliance of the multipliers; springs on the motions, too.
  integer, parameter :: plain = 0, damped = 1, sprung = 2

  !> How the solve ended.
  type :: mortar_result_t
    logical :: converged = .false. !! it has
    logical :: singular = .false. !! nothing can hold the bodies
    integer :: steps = 0 !! Newton steps, each with factors of its own
    integer :: repeated = 0 !! steps with the factors of one before
    real(wp), allocatable :: gap(:) !! (3 n) slip and gap [length]
    real(wp), allocatable :: force(:) !! (3 n) along the frames [force]
    real(wp), allocatable :: motion(:) !! (modes) rigid motions [length]
    logical, allocatable :: closed(:), slips(:) !! (n) status
    real(wp), allocatable :: criterion(:) !! (n) [force]
    real(wp) :: left = 0.0_wp !! largest defect [force]
  end type mortar_result_t

  !> The factors of Newton's matrix, while they serve.
  type :: mortar_factor_t
    logical :: known = .false. !! there are some
    integer, allocatable :: kept(:) !! rows of closed multipliers
    logical, allocatable :: slips(:) !! (n) status that they were made for
    real(wp), allocatable :: matrix(:, :) !! L and U
    integer, allocatable :: pivot(:) !! rows exchanged
  end type mortar_factor_t

  !> An iterate: forces, motions, what is left of F = z - Pi(y) and of the balance of the bodies.
  type :: iterate_t
    real(wp), allocatable :: z(:), alpha(:), gap(:), defect(:), balance(:)
    real(wp), allocatable :: slope(:, :, :) !! (3, 3, n) dPi/dy
    logical, allocatable :: closed(:), slips(:)
    real(wp), allocatable :: criterion(:)
  end type iterate_t

contains

  !> The factors are those of another compliance.
  pure subroutine forget_factor(factor)
    type(mortar_factor_t), intent(inout) :: factor !! serves no more

    factor%known = .false.
  end subroutine forget_factor

  !> Solves for forces and rigid motions.
  subroutine solve_multipliers(unknowns, start, motion, factor, result, near, status)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    real(wp), intent(in) :: start(:) !! (3 n) forces to begin with [force]
    real(wp), intent(in) :: motion(:) !! (modes) rigid motions to begin with [length]
    type(mortar_factor_t), intent(inout) :: factor !! of the same compliance, or unknown
    type(mortar_result_t), intent(out) :: result !! gets all
    real(wp), intent(in), optional :: near(:) !! (3 n) gaps that say which are closed and stick to
    !! begin with [length]
    integer, intent(in), optional :: status(:) !! (n) what they were where forces and motions began
    type(iterate_t) :: now, held, first
    logical :: moves
    integer :: begin

    ! friction of bodies that contact holds: without forces, or from those of another state, cones
    ! may be too small to hold them on the way
    begin = merge(from_gaps, from_sticking, size(motion) == 0 .or. any(abs(start) > 0.0_wp))
    if (present(status)) begin = from_status
    do begin = begin, from_sticking
      select case (begin)
      case (from_status)
        call look_at(unknowns, start, motion, .false., now, status=status)
      case (from_gaps)
        call look_at(unknowns, start, motion, .false., now, near)
      case (from_sticking)
        call look_at(unknowns, start, motion, .true., now, near)
        call follow(unknowns, .true., plain, now, factor, result, present(near))
        call forget_factor(factor)
        held = now
        call look_at(unknowns, held%z, held%alpha, .false., now)
      end select
      first = now
      moves = begin == from_status .or. present(near) .and. begin == from_gaps
      call follow(unknowns, .false., plain, now, factor, result, moves)
      if (result%converged) exit
      call forget_factor(factor)
      if (begin == from_status) cycle
      call follow(unknowns, .false., damped, now, factor, result, .false.)
      if (result%converged) exit
      if (size(motion) == 0) cycle
      ! these two may have thrown the bodies: once more from the start
      now = first
      call forget_factor(factor)
      call follow(unknowns, .false., sprung, now, factor, result, moves)
      if (result%converged) exit
    end do
    call drop_noise(unknowns, now)
    result%gap = now%gap
    result%force = now%z
    result%motion = now%alpha
    result%closed = now%closed
    result%slips = now%slips
    result%criterion = now%criterion
  end subroutine solve_multipliers

  !> Forces of a pair none of which is more than what round-off of lengths makes are none: of a body
  !! that has been lifted friction and pressure would be two such numbers, their ratio any.
  pure subroutine drop_noise(unknowns, now)
    type(mortar_system_t), intent(in) :: unknowns !! gaps, scales
    type(iterate_t), intent(inout) :: now !! a solution
    integer :: k

    do k = 1, size(unknowns%start) - 1
      associate (first => unknowns%start(k) + 1, last => unknowns%start(k + 1))
        if (any(abs(now%z(3*first - 2:3*last)) > round_off(unknowns))) cycle
        now%z(3*first - 2:3*last) = 0.0_wp
        now%closed(first:last) = .false.
        now%slips(first:last) = .false.
        now%criterion(first:last) = 0.0_wp
      end associate
    end do
  end subroutine drop_noise

  !> Newton's steps from an iterate to a solution, of the law or with all friction sticking; where
  !! they do not end, to the iterate that leaves least.
  subroutine follow(unknowns, sticks, damping, now, factor, result, moves)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    logical, intent(in) :: sticks !! friction holds whatever it has to
    integer, intent(in) :: damping !! what damps the steps: plain, damped, sprung
    type(iterate_t), intent(inout) :: now !! start; solution
    type(mortar_factor_t), intent(inout) :: factor !! of the same compliance, or unknown
    type(mortar_result_t), intent(inout) :: result !! steps, how it ended
    logical, intent(in) :: moves !! the start is linearised elsewhere: no solution
    type(iterate_t) :: next, best
    real(wp) :: change(size(now%z) + size(now%alpha)), length, least
    integer :: halving, step, last, n
    logical :: free, reused

    n = size(now%z)
    result%singular = .false.
    least = huge(least)
    last = merge(most_plain, most_damped, damping == plain)
    do step = 0, last
      result%left = maxval([0.0_wp, abs(now%defect), abs(now%balance)])
      result%converged = is_solved(unknowns, now) .and. .not. (moves .and. step == 0)
      if (result%converged) exit
      if (measure(now) < least .and. .not. (moves .and. step == 0)) then
        best = now
        least = measure(now)
      end if
      if (step == last) exit
      reused = fits(now, factor)
      call find_step(unknowns, now, damping, 0.0_wp, factor, change, free)
      if (free) call find_free_step(unknowns, now, damping, factor, change, result%singular)
      if (result%singular) exit
      result%steps = result%steps + merge(0, 1, reused)
      result%repeated = result%repeated + merge(1, 0, reused)
      length = 1.0_wp
      do halving = 0, most_halvings
        call look_at(unknowns, now%z + length*change(:n), now%alpha + length*change(n + 1:), &
          sticks, next)
        if (free .or. reused .or. (moves .and. step == 0) .or. measure(next) < measure(now)) exit
        length = 0.5_wp*length
      end do
      factor%known = measure(next) <= factor_serves*measure(now) .and. .not. free
      if (factor%known .or. .not. reused) now = next
    end do
    if (.not. result%converged .and. allocated(best%z)) now = best
  end subroutine follow

  !> What is left is round-off: of each multiplier, of the places of its own nodes. The balance of
  !! bodies knows no places, and is asked for more.
  pure logical function is_solved(unknowns, now)
    type(mortar_system_t), intent(in) :: unknowns !! scales, lengths
    type(iterate_t), intent(in) :: now !! an iterate
    real(wp) :: share, least
    integer :: i

    share = share_left*maxval([0.0_wp, abs(now%z)])
    ! what is more than the root of a round-off is none
    if (measure(now) <= sqrt(epsilon(share))*maxval([0.0_wp, abs(now%z)])) &
      share = max(share, of_factors(unknowns, now))
    is_solved = maxval([0.0_wp, abs(now%balance)]) <= max(share, of_balance*round_off(unknowns))
    least = round_off_of_gaps(unknowns)
    do i = 1, unknowns%n
      is_solved = is_solved .and. maxval(abs(now%defect(3*i - 2:3*i))) <= max(share, &
        maxval(unknowns%cone(i)%scale)*least)
    end do
  end function is_solved

  !> What round-off of factors leaves of any row: that of the largest, which is not small where
  !! bodies give way as a whole far more than a node by itself.
  pure real(wp) function of_factors(unknowns, now) result(force)
    type(mortar_system_t), intent(in) :: unknowns !! compliance, scales
    type(iterate_t), intent(in) :: now !! an iterate
    real(wp) :: row(3*unknowns%n)
    integer :: i

    row = 0.0_wp
    do i = 1, 3*unknowns%n
      if (abs(now%z(i)) > 0.0_wp) row = row + abs(unknowns%compliance(:, i)*now%z(i))
    end do
    force = epsilon(force)*maxval([0.0_wp, (maxval(unknowns%cone(i)%scale) &
      *maxval(row(3*i - 2:3*i)), i=1, unknowns%n)])
  end function of_factors

  !> What the law lacks where no force moves anything, the largest of all [force].
  pure real(wp) function what_law_lacks(unknowns, z) result(left)
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
  end function what_law_lacks

  !> What is left, as one number [force].
  pure real(wp) function measure(iterate)
    type(iterate_t), intent(in) :: iterate !! an iterate

    measure = norm2([norm2(iterate%defect), norm2(iterate%balance)])
  end function measure

  !> What forces and motions lack, as one number [force].
  pure real(wp) function what_is_left(unknowns, z, alpha) result(left)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    real(wp), intent(in) :: z(:) !! (3 n) forces [force]
    real(wp), intent(in) :: alpha(:) !! (modes) rigid motions [length]
    type(iterate_t) :: now

    call look_at(unknowns, z, alpha, .false., now)
    left = measure(now)
  end function what_is_left

  !> What round-off of lengths makes of forces.
  pure real(wp) function round_off(unknowns) result(force)
    type(mortar_system_t), intent(in) :: unknowns !! scales, lengths
    integer :: i

    force = round_off_of_gaps(unknowns)*maxval([0.0_wp, (maxval(unknowns%cone(i)%scale), &
      i=1, unknowns%n)])
  end function round_off

  !> The same of all multipliers together, as the norm of what is left: where each is at its
  !! round-off, no round lowers it any more.
  pure real(wp) function all_round_off(unknowns) result(force)
    type(mortar_system_t), intent(in) :: unknowns !! scales, lengths
    integer :: i

    force = round_off_of_gaps(unknowns)*norm2([0.0_wp, (unknowns%cone(i)%scale([1, 1, 2]), &
      i=1, unknowns%n)])
  end function all_round_off

  !> Gaps are known to this; the places that they are of, to a unit of their own round-off.
  pure real(wp) function round_off_of_gaps(unknowns) result(gap)
    type(mortar_system_t), intent(in) :: unknowns !! lengths

    gap = epsilon(gap)*max(unknowns%length, noise*maxval([0.0_wp, abs(unknowns%gap)]))
  end function round_off_of_gaps

  !> Gaps, projections and what is left at given forces, eq. (7.16).
  pure subroutine look_at(unknowns, z, alpha, sticks, iterate, near, status)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    real(wp), intent(in) :: z(:) !! (3 n) forces [force]
    real(wp), intent(in) :: alpha(:) !! (modes) rigid motions [length]
    logical, intent(in) :: sticks !! friction holds whatever it has to
    type(iterate_t), intent(out) :: iterate !! all of it
    real(wp), intent(in), optional :: near(:) !! (3 n) gaps to linearise at, else theirs [length]
    integer, intent(in), optional :: status(:) !! (n) or where these forces were found
    real(wp) :: y(3), force(3), off(3*unknowns%n)
    integer :: i, k

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
      if (present(status)) off = way_since(unknowns, z, iterate%gap, status)
      do i = 1, n
        associate (own => 3*i - 2, cone => unknowns%cone(i))
          y = z(own:own + 2) - cone%scale([1, 1, 2])*(iterate%gap(own:own + 2) - off(own:own + 2))
          call project_on_cone(cone, y, force, iterate%slope(:, :, i), iterate%slips(i), &
            iterate%criterion(i))
          iterate%closed(i) = y(3) >= 0.0_wp
          if (sticks .and. iterate%closed(i) .and. all(cone%mu > 0.0_wp)) then
            force = y
            iterate%slope(:, :, i) = reshape([(1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, k=1, 2), 1.0_wp], &
              [3, 3])
            iterate%slips(i) = .false.
          end if
          iterate%defect(own:own + 2) = z(own:own + 2) - force + matmul(iterate%slope(:, :, i), &
            cone%scale([1, 1, 2])*off(own:own + 2))
        end associate
      end do
    end associate
  end subroutine look_at

  !> What gaps differ by from those at which the forces were found: none of sticking multipliers, a
  !! way against the friction of those that slip, as long as it would be elastic.
  pure function way_since(unknowns, z, gap, status) result(way)
    type(mortar_system_t), intent(in) :: unknowns !! scales
    real(wp), intent(in) :: z(:) !! (3 n) forces [force]
    real(wp), intent(in) :: gap(:) !! (3 n) slip and gap now [length]
    integer, intent(in) :: status(:) !! (n) then; open ones are where they are now
    real(wp) :: way(size(gap))
    integer :: i

    way = 0.0_wp
    do i = 1, unknowns%n
      associate (own => 3*i - 2, end => 3*i)
        if (status(i) <= status_open) cycle
        way(own:end) = gap(own:end)
        if (status(i) == status_slip) way(own:end - 1) = gap(own:end - 1) + z(own:end - 1) &
          /unknowns%cone(i)%scale(1)
      end associate
    end do
  end function way_since

  !> A step of bodies that contact leaves free: springs in the step alone stop them a little beyond
  !! the first gap on their way, and are soft where there is none. Nodes that touch without a force
  !! are on no way.
  subroutine find_free_step(unknowns, now, damping, factor, change, singular)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    type(iterate_t), intent(in) :: now !! where it starts
    integer, intent(in) :: damping !! what damps the steps: plain, damped, sprung
    type(mortar_factor_t), intent(inout) :: factor !! made anew
    real(wp), intent(out) :: change(:) !! (3 n + modes) of forces and motions
    logical, intent(out) :: singular !! there is none
    real(wp) :: closing(unknowns%n), hold, share, least
    integer :: i

    hold = soft*mean_stiffness(unknowns)
    call find_step(unknowns, now, damping, hold, factor, change, singular)
    if (singular) return
    associate (n => 3*unknowns%n, gap => now%gap(3::3))
      closing = -matmul(unknowns%compliance(3::3, :), change(:n)) &
        - matmul(unknowns%motion(3::3, :), change(n + 1:))
      share = 1.0_wp/beyond
      least = round_off_of_gaps(unknowns)
      do i = 1, unknowns%n
        if (now%closed(i) .or. gap(i) <= least) cycle
        if (gap(i) < share*closing(i)) share = gap(i)/closing(i)
      end do
    end associate
    if (share*beyond >= 1.0_wp) return
    call find_step(unknowns, now, damping, min(hold/(beyond*share), mean_stiffness(unknowns)), &
      factor, change, singular)
  end subroutine find_free_step

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
  subroutine find_step(unknowns, now, damping, hold, factor, change, singular)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    type(iterate_t), intent(in) :: now !! where it starts
    integer, intent(in) :: damping !! what damps the steps: plain, damped, sprung
    real(wp), intent(in) :: hold !! stops rigid motions in the step alone [force/length]
    type(mortar_factor_t), intent(inout) :: factor !! made anew where it does not fit
    real(wp), intent(out) :: change(:) !! (3 n + modes) of forces and motions
    logical, intent(out) :: singular !! there is none
    real(wp) :: gone(3*unknowns%n), unit
    real(wp), allocatable :: right(:, :)
    integer :: i, k, n, m, info

    change = 0.0_wp
    do i = 1, unknowns%n
      if (.not. now%closed(i)) change(3*i - 2:3*i) = -now%z(3*i - 2:3*i)
    end do
    n = 3*count(now%closed)
    m = size(now%alpha)
    singular = .false.
    if (n + m == 0) return
    ! motions in the unit of forces: their columns are as large as the others
    unit = mean_stiffness(unknowns)
    if (hold > 0.0_wp .or. .not. fits(now, factor)) then
      call form_matrix(unknowns, now, damping, hold/unit, unit, factor)
      call dgetrf(n + m, n + m, factor%matrix, n + m, factor%pivot, info)
      singular = info /= 0
      if (m > 0 .and. hold <= 0.0_wp .and. .not. singular) singular = &
        minval([(abs(factor%matrix(k, k)), k=n + 1, n + m)]) <= no_pivot*maxval([(abs( &
        factor%matrix(k, k)), k=n + 1, n + m)])
      factor%known = .not. singular
      if (singular) return
    end if
    gone = 0.0_wp
    if (any(abs(change) > 0.0_wp)) gone = matmul(unknowns%compliance, change(:3*unknowns%n))
    allocate (right(n + m, 1))
    do k = 1, n, 3
      i = (factor%kept(k) + 2)/3
      right(k:k + 2, 1) = -now%defect(3*i - 2:3*i) - matmul(now%slope(:, :, i), &
        unknowns%cone(i)%scale([1, 1, 2])*gone(3*i - 2:3*i))
    end do
    right(n + 1:, 1) = -now%balance - matmul(change(:3*unknowns%n), unknowns%push)
    call dgetrs('N', n + m, 1, factor%matrix, n + m, factor%pivot, right, n + m, info)
    change(factor%kept) = right(:n, 1)
    change(3*unknowns%n + 1:) = right(n + 1:, 1)/unit
  end subroutine find_step

  !> The factors at hand are those of multipliers of the same status.
  pure logical function fits(now, factor)
    type(iterate_t), intent(in) :: now !! an iterate
    type(mortar_factor_t), intent(in) :: factor !! factors, or none

    fits = factor%known
    if (.not. fits) return
    fits = size(factor%slips) == size(now%slips) .and. size(factor%kept) == 3*count(now%closed)
    if (fits) fits = all(now%closed((factor%kept + 2)/3))
    if (fits) fits = all((now%slips .eqv. factor%slips) .or. .not. now%closed)
  end function fits

  !> Newton's matrix of the closed multipliers and the rigid motions, I - Pi'(I - r G).
  pure subroutine form_matrix(unknowns, now, damping, hold, unit, factor)
    type(mortar_system_t), intent(in) :: unknowns !! the system
    type(iterate_t), intent(in) :: now !! status and slopes
    integer, intent(in) :: damping !! not plain: all get more compliance, else those of shared nodes
    real(wp), intent(in) :: hold !! what stops rigid motions, over the unit
    real(wp), intent(in) :: unit !! stiffness that stands for 1 [force/length]
    type(mortar_factor_t), intent(inout) :: factor !! gets matrix, kept
    real(wp) :: slope(3, 3), lacking, even
    integer :: i, k, l, n, m
    logical :: shared

    lacking = measure(now)/max(tiny(even), norm2(now%z), measure(now))
    even = evens_out
    if (damping /= plain) even = max(even, min(damps_at_most, lacking))
    factor%kept = pack([(i, i=1, 3*unknowns%n)], [(now%closed((i + 2)/3), i=1, 3*unknowns%n)])
    factor%slips = now%slips
    n = size(factor%kept)
    m = size(now%alpha)
    if (allocated(factor%matrix)) deallocate (factor%matrix, factor%pivot)
    allocate (factor%matrix(n + m, n + m), factor%pivot(n + m))
    associate (matrix => factor%matrix, kept => factor%kept)
      do l = 1, n
        do k = 1, n, 3
          i = (kept(k) + 2)/3
          matrix(k:k + 2, l) = matmul(now%slope(:, :, i), unknowns%cone(i)%scale([1, 1, 2]) &
            *unknowns%compliance(3*i - 2:3*i, kept(l)))
        end do
      end do
      do k = 1, n, 3
        i = (kept(k) + 2)/3
        slope = now%slope(:, :, i)
        shared = damping /= plain .or. count(unknowns%rows%node == unknowns%rows%node(i)) > 1
        matrix(k:k + 2, k:k + 2) = matrix(k:k + 2, k:k + 2) - merge(1.0_wp - even, 1.0_wp, &
          shared)*slope
        do l = k, k + 2
          matrix(l, l) = matrix(l, l) + 1.0_wp
        end do
        matrix(k:k + 2, n + 1:) = matmul(slope*spread(unknowns%cone(i)%scale([1, 1, 2]), 1, 3), &
          unknowns%motion(kept(k:k + 2), :))/unit
      end do
      matrix(n + 1:, :n) = transpose(unknowns%push(kept, :))
      matrix(n + 1:, n + 1:) = -unknowns%hold/unit
      do k = n + 1, n + m
        matrix(k, k) = matrix(k, k) - max(hold, merge(lacking, 0.0_wp, damping == sprung))
      end do
    end associate
  end subroutine form_matrix
end module mortar_newton

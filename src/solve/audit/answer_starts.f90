!> Second starts: other answers of an increment than the one that is known (doc/theory, "Other
!! answers", eq. (13.6)).
module answer_starts
  use kinds, only: wp
  use lapack_interface, only: dgetrf, dgetrs
  use element_types, only: status_open, status_stick, status_slip
  use coulomb_answers, only: coulomb_t, answer_t, unknowns_t, unknowns_of, tangent_of
  implicit none
  private
  public :: find_answer, second_answers

  !> Steps of a start, and how many of them change all statuses that do not fit: then one after the
  !! other, which ends where all at once go round.
  integer, parameter :: most_answer_steps = 60, all_steps = 12
  !> Farthest turn of a slip's direction in a step [radian].
  real(wp), parameter :: most_turn = 0.5_wp
  !> Forces and gaps below these shares of the largest are none; forces that differ by more are of
  !! two answers.
  real(wp), parameter :: no_force_share = 1.0e-9_wp, another = 1.0e-5_wp

contains

  !> Looks for an answer from the statuses and forces of a start.
  subroutine find_answer(problem, answer, found)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(inout) :: answer !! the start, then what has been found
    logical, intent(out) :: found !! it is an answer
    integer :: step
    logical :: same, going

    call find_gap(problem, answer)
    found = .false.
    do step = 1, most_answer_steps
      call move(problem, answer, going)
      if (.not. going) return
      call find_gap(problem, answer)
      call change_statuses(problem, step > all_steps, answer, same)
      found = same
      if (found) found = is_met(problem, answer)
      if (found) return
    end do
  end subroutine find_answer

  !> Gaps of the forces.
  pure subroutine find_gap(problem, answer)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(inout) :: answer !! gets gap

    answer%gap = problem%b + matmul(problem%w, answer%lambda)
    if (problem%motions > 0) answer%gap = answer%gap + matmul(problem%r, answer%alpha)
  end subroutine find_gap

  !> A step of Newton's method with the statuses as they are. Open points lose their forces first.
  subroutine move(problem, answer, going)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(inout) :: answer !! its forces move
    logical, intent(out) :: going !! the tangent is not singular
    type(unknowns_t) :: z
    real(wp), allocatable :: a(:, :), y(:)
    integer, allocatable :: pivot(:)
    integer :: j, n, p, info

    n = problem%axes + 1
    do p = 1, problem%points
      associate (force => answer%lambda(n*(p - 1) + 1:n*p))
        if (answer%status(p) == status_open) force = 0.0_wp
        if (answer%status(p) == status_slip) force(2:) = answer%way(:, p)*force(1)
      end associate
    end do
    call find_gap(problem, answer)
    z = unknowns_of(problem, answer)
    a = tangent_of(problem, z, 1.0_wp)
    allocate (y(size(a, 1)), pivot(size(a, 1)))
    do j = 1, z%n
      y(j) = -dot_product(z%v(:, j), answer%gap(n*(z%point(j) - 1) + 1:n*z%point(j)))
    end do
    if (problem%motions > 0) y(z%n + 1:) = problem%push - matmul(answer%lambda, problem%r)
    info = 0
    if (size(y) > 0) call dgetrf(size(y), size(y), a, size(y), pivot, info)
    going = info == 0
    if (.not. going .or. size(y) == 0) return
    call dgetrs('N', size(y), 1, a, size(y), pivot, y, size(y), info)
    going = all(abs(y) < huge(1.0_wp))
    if (.not. going) return
    if (problem%motions > 0) answer%alpha = answer%alpha + y(z%n + 1:)
    call take_step(problem, z, y, answer)
  end subroutine move

  !> Forces after a step.
  pure subroutine take_step(problem, z, y, answer)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(unknowns_t), intent(in) :: z !! its unknowns
    real(wp), intent(in) :: y(:) !! their changes
    type(answer_t), intent(inout) :: answer !! moves
    real(wp) :: angle, mu(2)
    integer :: j, n, p

    n = problem%axes + 1
    do j = 1, z%n
      p = z%point(j)
      associate (force => answer%lambda(n*(p - 1) + 1:n*p))
        if (answer%status(p) == status_stick) then
          force = force + y(j)*z%u(:, j)
        else if (z%rubs(j)) then
          force(1) = force(1) + y(j)
          force(2:) = answer%way(:, p)*force(1)
        else
          mu = problem%mu(:, p)
          angle = atan2(answer%way(2, p)/mu(2), answer%way(1, p)/mu(1)) + max(-most_turn, &
            min(most_turn, y(j)))
          answer%way(:, p) = mu*[cos(angle), sin(angle)]
          force(2:) = answer%way(:, p)*force(1)
        end if
      end associate
    end do
  end subroutine take_step

  !> Statuses that do not fit the forces and gaps they have led to.
  pure subroutine change_statuses(problem, one_only, answer, same)
    type(coulomb_t), intent(in) :: problem !! the increment
    logical, intent(in) :: one_only !! the first of them alone
    type(answer_t), intent(inout) :: answer !! its statuses change
    logical, intent(out) :: same !! none has
    real(wp) :: least_force, least_gap, size_of
    integer :: n, p, before(problem%points)

    n = problem%axes + 1
    before = answer%status
    least_force = no_force_share*maxval(abs(answer%lambda))
    least_gap = no_force_share*maxval(abs(answer%gap) + abs(problem%b))
    do p = 1, problem%points
      if (one_only .and. any(before /= answer%status)) exit
      associate (force => answer%lambda(n*(p - 1) + 1:n*p), gap => answer%gap(n*(p - 1) + 1:n*p), &
                 status => answer%status(p), mu => problem%mu(:, p))
        if (status == status_open) then
          if (gap(1) < -least_gap) status = status_stick
          if (status == status_stick .and. all(mu <= 0.0_wp)) status = status_slip
        else if (force(1) < -least_force) then
          status = status_open
          call turn_away(problem, p, force, gap, status, answer%way(:, p))
        else if (status == status_stick) then
          size_of = 2.0_wp*max(force(1), tiny(1.0_wp))
          if (all(mu > 0.0_wp)) size_of = norm2(force(2:)/mu)
          if (size_of <= force(1) + least_force) cycle
          status = status_slip
          answer%way(:, p) = 0.0_wp
          if (all(mu > 0.0_wp)) answer%way(:, p) = force(2:)/size_of
        else if (any(mu > 0.0_wp)) then
          if (dot_product(answer%way(:, p)*(minval(mu)/mu)**problem%rule(p), gap(2:)) &
            > least_gap*norm2(mu)) status = status_stick
        end if
      end associate
    end do
    same = all(before == answer%status)
  end subroutine change_statuses

  !> A point whose pressure would be a pull stays closed if it would go through without any force:
  !! it slips against where it would be then.
  pure subroutine turn_away(problem, p, force, gap, status, way)
    type(coulomb_t), intent(in) :: problem !! the increment
    integer, intent(in) :: p !! the point
    real(wp), intent(inout) :: force(:) !! (1+axes) of it [force]
    real(wp), intent(in) :: gap(:) !! (1+axes) of it [length]
    integer, intent(inout) :: status !! open, slips if it stays closed
    real(wp), intent(inout) :: way(:) !! (axes) direction of its force
    real(wp) :: alone(size(gap)), along(size(way))
    integer :: n

    if (any(problem%mu(:, p) <= 0.0_wp)) return
    n = size(gap)
    alone = gap - matmul(problem%w(n*(p - 1) + 1:n*p, n*(p - 1) + 1:n*p), force)
    if (alone(1) >= 0.0_wp) return
    along = -alone(2:)/(minval(problem%mu(:, p))/problem%mu(:, p))**problem%rule(p)
    if (norm2(along) <= 0.0_wp) return
    way = along/norm2(along/problem%mu(:, p))
    status = status_slip
    force = 0.0_wp
  end subroutine turn_away

  !> Gaps vanish where they have to.
  pure logical function is_met(problem, answer) result(met)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! statuses, forces, gaps
    type(unknowns_t) :: z
    real(wp) :: least
    integer :: j, n

    n = problem%axes + 1
    z = unknowns_of(problem, answer)
    least = no_force_share*maxval(abs(problem%b) + abs(answer%gap) + abs(answer%gap - problem%b))
    met = .true.
    do j = 1, z%n
      met = met .and. abs(dot_product(z%v(:, j), answer%gap(n*(z%point(j) - 1) &
        + 1:n*z%point(j)))) <= least
    end do
  end function is_met

  !> Looks for more answers of the same increment: with points of the first one lifted, pressed on,
  !! or on their cones to both sides, and with all open or stuck.
  subroutine second_answers(problem, points, answers)
    type(coulomb_t), intent(in) :: problem !! the increment
    integer, intent(in) :: points(:) !! points that are tried
    type(answer_t), allocatable, intent(inout) :: answers(:) !! one is known; grows
    type(answer_t) :: start
    integer :: k, way

    do way = status_open, status_stick
      start = answers(1)
      start%status = way
      where (all(problem%mu <= 0.0_wp, 1) .and. start%status == status_stick) &
        start%status = status_slip
      call try(problem, start, answers)
    end do
    do k = 1, size(points)
      do way = 1, 2*problem%axes + 2
        start = answers(1)
        call put(problem, points(k), way, start)
        call try(problem, start, answers)
      end do
    end do
  end subroutine second_answers

  !> A start with one point otherwise: open, stuck, or on its cone along the gap of its own
  !! pressure, against it, or across.
  pure subroutine put(problem, p, way, start)
    type(coulomb_t), intent(in) :: problem !! the increment
    integer, intent(in) :: p !! the point
    integer, intent(in) :: way !! 1 to 2+2 axes
    type(answer_t), intent(inout) :: start !! its status there changes
    real(wp) :: along(problem%axes)
    integer :: n

    n = problem%axes + 1
    start%status(p) = merge(status_open, status_stick, way == 1)
    if (way < 3 .and. any(problem%mu(:, p) > 0.0_wp)) return
    if (way == 1) return
    start%status(p) = status_slip
    start%way(:, p) = 0.0_wp
    if (any(problem%mu(:, p) <= 0.0_wp)) return
    along = problem%w(n*(p - 1) + 2:n*p, n*(p - 1) + 1)*problem%mu(:, p)
    if (norm2(along) <= 0.0_wp) along(1) = 1.0_wp
    if (way > 4) along = [-along(2), along(1)]
    start%way(:, p) = problem%mu(:, p)*along/norm2(along)*(1 - 2*mod(way, 2))
  end subroutine put

  !> Keeps what a start leads to, if it is an answer that is not known.
  subroutine try(problem, start, answers)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(inout) :: start !! becomes what it leads to
    type(answer_t), allocatable, intent(inout) :: answers(:) !! may grow
    type(answer_t), allocatable :: more(:)
    real(wp) :: largest
    integer :: k
    logical :: found

    call find_answer(problem, start, found)
    if (.not. found) return
    do k = 1, size(answers)
      largest = max(maxval(abs(start%lambda)), maxval(abs(answers(k)%lambda)))
      if (maxval(abs(start%lambda - answers(k)%lambda)) <= another*largest) return
    end do
    allocate (more(size(answers) + 1))
    more(:size(answers)) = answers
    more(size(more)) = start
    call move_alloc(more, answers)
  end subroutine try
end module answer_starts

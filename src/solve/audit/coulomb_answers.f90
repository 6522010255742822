!> Answers of Coulomb's law at contact points that a linear bulk joins, g = W lambda + R alpha + b:
!! the sign of the tangent at one of them, and how much friction it bears (doc/theory, "Other
!! answers", eqs. (13.6), (13.7), (13.8), (13.9)).
!!
!! Each point has 1 + axes components: along the normal, then along the axes of friction. The gap of
!! a slip is against the force: c > 0 in g = -c kappa force, kappa_i = (mu_min/mu_i)^m.
module coulomb_answers
  use kinds, only: wp
  use lapack_interface, only: dgetrf, dgetrs, dgeev
  use element_types, only: status_open, status_slip
  implicit none
  private
  public :: coulomb_t, answer_t, unknowns_t, tangent_sign, friction_borne, point_borne, &
    unknowns_of, tangent_of

  !> An eigenvalue with less of an imaginary part is real.
  real(wp), parameter :: real_enough = 1.0e-8_wp
  !> Statuses that bear three times their friction: by how much more is not asked.
  real(wp), parameter :: far_below = 1.0_wp/3.0_wp

  !> The increment at its points.
  type :: coulomb_t
    integer :: points = 0 !! how many
    integer :: axes = 2 !! axes of friction
    integer :: motions = 0 !! rigid motions that nothing else holds
    real(wp), allocatable :: w(:, :) !! (size, size) compliance [length/force]
    real(wp), allocatable :: r(:, :) !! (size, motions) what they do to the gaps
    real(wp), allocatable :: b(:) !! (size) gaps without contact [length]
    real(wp), allocatable :: push(:) !! (motions) what contact has to carry of each [force]
    real(wp), allocatable :: mu(:, :) !! (axes, points) coefficients
    integer, allocatable :: rule(:) !! (points) slip rule m
  end type coulomb_t

  !> An answer, or what a start takes for one.
  type :: answer_t
    integer, allocatable :: status(:) !! (points) open, stick or slip
    real(wp), allocatable :: lambda(:) !! (size) forces on the slave, pressure positive [force]
    real(wp), allocatable :: alpha(:) !! (motions)
    real(wp), allocatable :: gap(:) !! (size) [length]
    real(wp), allocatable :: way(:, :) !! (axes, points) force along the axes over pressure, where
    !! it slips
  end type answer_t

  !> Unknowns of the closed points at an answer: U of its forces, V of the gaps that vanish.
  type :: unknowns_t
    integer :: n = 0 !! how many
    integer, allocatable :: point(:) !! (n) whose each is
    real(wp), allocatable :: u(:, :) !! (1+axes, n) force of each
    real(wp), allocatable :: v(:, :) !! (1+axes, n) gap of each
    real(wp), allocatable :: own(:) !! (n) what turns its gap by itself [length]
    logical, allocatable :: rubs(:) !! (n) pressure of a point that slips
  end type unknowns_t

contains

  !> Sign of the tangent at an answer, 0 where it is singular (eq. (13.7)).
  integer function tangent_sign(problem, answer) result(s)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! statuses, forces, gaps
    type(unknowns_t) :: z
    real(wp), allocatable :: a(:, :)
    integer, allocatable :: pivot(:)
    integer :: info

    z = unknowns_of(problem, answer)
    a = tangent_of(problem, z, 1.0_wp)
    allocate (pivot(size(a, 1)))
    info = 0
    if (size(a, 1) > 0) call dgetrf(size(a, 1), size(a, 1), a, size(a, 1), pivot, info)
    s = 0
    if (info == 0) s = sign_of(a, pivot)
    if (mod(problem%motions, 2) == 1) s = -s
  end function tangent_sign

  !> Sign of the determinant of a matrix that has been factorised.
  pure integer function sign_of(a, pivot) result(s)
    real(wp), intent(in) :: a(:, :) !! its factors
    integer, intent(in) :: pivot(:) !! rows exchanged
    integer :: i

    s = 1
    do i = 1, size(pivot)
      if (pivot(i) /= i) s = -s
      if (a(i, i) < 0.0_wp) s = -s
    end do
  end function sign_of

  !> Unknowns of the closed points: of one that sticks all forces, of one that slips its pressure
  !! and, where there are two axes with friction, the direction of its force.
  pure type(unknowns_t) function unknowns_of(problem, answer) result(z)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! statuses, forces, gaps
    integer :: p, k, n

    n = problem%axes + 1
    allocate (z%point(n*problem%points), z%own(n*problem%points), z%u(n, n*problem%points), &
      z%v(n, n*problem%points), z%rubs(n*problem%points))
    do p = 1, problem%points
      if (answer%status(p) == status_open) cycle
      if (answer%status(p) == status_slip) then
        call add(z, p, [1.0_wp, answer%way(:, p)], [1.0_wp, spread(0.0_wp, 1, n - 1)], .true.)
        if (n == 3 .and. any(abs(answer%way(:, p)) > 0.0_wp)) call add_turn(problem, answer, p, z)
      else
        do k = 1, n
          call add(z, p, unit(k, n), unit(k, n), .false.)
        end do
      end if
    end do
  end function unknowns_of

  !> A unit vector.
  pure function unit(k, n) result(e)
    integer, intent(in) :: k !! its component
    integer, intent(in) :: n !! of so many
    real(wp) :: e(n)

    e = 0.0_wp
    e(k) = 1.0_wp
  end function unit

  !> One more unknown.
  pure subroutine add(z, p, u, v, rubs)
    type(unknowns_t), intent(inout) :: z !! grows
    integer, intent(in) :: p !! its point
    real(wp), intent(in) :: u(:), v(:) !! (1+axes) force and gap
    logical, intent(in) :: rubs !! pressure of a point that slips

    z%n = z%n + 1
    z%point(z%n) = p
    z%u(:, z%n) = u
    z%v(:, z%n) = v
    z%own(z%n) = 0.0_wp
    z%rubs(z%n) = rubs
  end subroutine add

  !> The direction of a force on the cone: it turns by theta, and the slip has to stay against it.
  pure subroutine add_turn(problem, answer, p, z)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! forces, gaps
    integer, intent(in) :: p !! the point
    type(unknowns_t), intent(inout) :: z !! grows
    real(wp) :: kappa(2), q(2), turned(2), mu(2)

    mu = problem%mu(:, p)
    kappa = (minval(mu)/mu)**problem%rule(p)
    turned = [-answer%way(2, p)*mu(1)/mu(2), answer%way(1, p)*mu(2)/mu(1)]
    q = kappa*answer%way(:, p)
    q = q/norm2(q)
    call add(z, p, [0.0_wp, pressure(problem, answer, p)*turned], [0.0_wp, -q(2), q(1)], .false.)
    z%own(z%n) = -dot_product(q, answer%gap(3*p - 1:3*p))*(q(1)*kappa(2)*turned(2) &
      - q(2)*kappa(1)*turned(1))/norm2(kappa*answer%way(:, p))
  end subroutine add_turn

  !> Pressure of a point, or the largest force; a start may know none.
  pure real(wp) function pressure(problem, answer, p)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! forces
    integer, intent(in) :: p !! the point
    integer :: k

    k = (problem%axes + 1)*(p - 1) + 1
    pressure = answer%lambda(k)
    if (pressure <= 0.0_wp) pressure = maxval(abs(answer%lambda))
    if (pressure <= 0.0_wp) pressure = maxval(abs(problem%b))/problem%w(k, k)
  end function pressure

  !> Tangent V^T W U of the unknowns, bordered by the motions, with so much of friction where it
  !! slips (eq. (13.7)).
  pure function tangent_of(problem, z, share) result(a)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(unknowns_t), intent(in) :: z !! its unknowns
    real(wp), intent(in) :: share !! of friction
    real(wp), allocatable :: a(:, :)
    real(wp) :: column(size(problem%w, 1)), u(problem%axes + 1)
    integer :: i, j, n, k

    n = problem%axes + 1
    allocate (a(z%n + problem%motions, z%n + problem%motions), source=0.0_wp)
    do j = 1, z%n
      u = z%u(:, j)
      if (z%rubs(j)) u(2:) = share*u(2:)
      column = matmul(problem%w(:, n*(z%point(j) - 1) + 1:n*z%point(j)), u)
      do i = 1, z%n
        a(i, j) = dot_product(z%v(:, i), column(n*(z%point(i) - 1) + 1:n*z%point(i)))
      end do
      a(j, j) = a(j, j) + z%own(j)
      do k = 1, problem%motions
        associate (r => problem%r(n*(z%point(j) - 1) + 1:n*z%point(j), k))
          a(j, z%n + k) = dot_product(z%v(:, j), r)
          a(z%n + k, j) = dot_product(u, r)
        end associate
      end do
    end do
  end function tangent_of

  !> Friction over what the statuses of an answer bear: where it is more than 1, the sign of the
  !! tangent has turned; 0 if no friction turns it (eq. (13.8)).
  real(wp) function friction_borne(problem, answer) result(share)
    type(coulomb_t), intent(in) :: problem !! the increment
    type(answer_t), intent(in) :: answer !! statuses, forces, gaps
    type(unknowns_t) :: z
    real(wp), allocatable :: a(:, :), f(:, :)
    integer, allocatable :: slips(:), pivot(:)
    integer :: i, info, n

    share = 0.0_wp
    z = unknowns_of(problem, answer)
    slips = pack([(i, i=1, z%n)], z%rubs(:z%n))
    if (size(slips) == 0) return
    a = tangent_of(problem, z, 0.0_wp)
    f = tangent_of(problem, z, 1.0_wp)
    f = a(:, slips) - f(:, slips)
    n = size(a, 1)
    allocate (pivot(n))
    call dgetrf(n, n, a, n, pivot, info)
    if (info /= 0) return
    call dgetrs('N', n, size(slips), a, n, pivot, f, n, info)
    share = largest_real(f(slips, :))
  end function friction_borne

  !> Largest real eigenvalue that is positive, or 0. None is larger than the eighth root of the norm
  !! of the eighth power; where that is small no more is asked: all of them cost several times that.
  real(wp) function largest_real(a) result(largest)
    real(wp), intent(in) :: a(:, :) !! a matrix
    real(wp) :: c(size(a, 1), size(a, 1)), x(size(a, 1)), y(size(a, 1)), left(1, 1), right(1, 1)
    real(wp) :: work(8*size(a, 1))
    integer :: info, i

    c = a
    if (maxval(abs(a)) < 1.0_wp) then
      do i = 1, 3
        c = matmul(c, c)
      end do
      largest = maxval(sum(abs(c), 1))**0.125_wp
      if (largest < far_below) return
      c = a
    end if
    call dgeev('N', 'N', size(a, 1), c, size(a, 1), x, y, left, 1, right, 1, work, size(work), info)
    largest = 0.0_wp
    if (info /= 0) return
    largest = max(0.0_wp, maxval(x, abs(y) <= real_enough*maxval(abs(x))))
  end function largest_real

  !> Friction of one point over what it bears alone, whatever the others do: beyond 1 it can have
  !! several answers (eq. (13.9)).
  pure real(wp) function point_borne(w, mu) result(share)
    real(wp), intent(in) :: w(:) !! (1+axes) gaps of a unit of pressure there [length/force]
    real(wp), intent(in) :: mu(:) !! (axes) coefficients

    share = 0.0_wp
    if (w(1) > 0.0_wp) share = norm2(mu*w(2:))/w(1)
  end function point_borne
end module coulomb_answers

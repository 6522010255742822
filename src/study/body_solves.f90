!> Displacements of a condensed body under any forces: its factor lacks the part of the candidates,
!! whose place their compliance takes (doc/theory, "Derivatives along the path").
module body_solves
  use, intrinsic :: iso_c_binding, only: c_f_pointer
  use kinds, only: wp, long
  use lapack_interface, only: dgemv, dtrsv, dsymv
  use cholmod_interface, only: cholmod_factor_t
  use cholmod_solver, only: cholmod_t
  use condensed_types, only: condensed_body_t
  implicit none
  private
  public :: solve_condensed_body

  !> The supernodes of a factor.
  type :: supernodes_t
    integer(long), pointer :: super(:) => null(), pi(:) => null(), px(:) => null(), s(:) => null()
    real(wp), pointer, contiguous :: values(:) => null() !! of all of them
    integer :: n = 0 !! how many
  end type supernodes_t

contains

  !> u = K^-1 b on the free equations of a body.
  subroutine solve_condensed_body(body, b, u)
    type(condensed_body_t), intent(in) :: body !! factor and compliance
    real(wp), intent(in) :: b(:, :) !! (3, nodes) forces [force]
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) gets the displacements of the body [length]
    real(wp) :: x(size(body%node)), last(body%m)
    type(supernodes_t) :: factor
    integer :: i, inner

    do i = 1, size(x)
      x(i) = b(body%direction(i), body%node(i))
    end do
    inner = size(x) - body%m
    call look_at_factor(body%solver, factor)
    call eliminate(factor, inner, x)
    if (body%m > 0) then
      last = x(inner + 1:)
      call dsymv('L', body%m, 1.0_wp, body%compliance, body%m, last, 1, 0.0_wp, x(inner + 1:), 1)
    end if
    call substitute(factor, inner, x)
    do i = 1, size(x)
      u(body%direction(i), body%node(i)) = x(i)
    end do
  end subroutine solve_condensed_body

  !> Fortran's view of CHOLMOD's factor.
  subroutine look_at_factor(solver, nodes)
    type(cholmod_t), intent(in) :: solver !! supernodal factor
    type(supernodes_t), intent(out) :: nodes !! its parts
    type(cholmod_factor_t), pointer :: factor

    call c_f_pointer(solver%factor, factor)
    call c_f_pointer(factor%super, nodes%super, [factor%nsuper + 1])
    call c_f_pointer(factor%pi, nodes%pi, [factor%nsuper + 1])
    call c_f_pointer(factor%px, nodes%px, [factor%nsuper + 1])
    call c_f_pointer(factor%s, nodes%s, [factor%ssize])
    call c_f_pointer(factor%x, nodes%values, [factor%xsize])
    nodes%n = int(factor%nsuper)
  end subroutine look_at_factor

  !> L11^-1 on the first unknowns, and what they leave for the others.
  subroutine eliminate(factor, inner, x)
    type(supernodes_t), intent(in) :: factor !! the factor
    integer, intent(in) :: inner !! unknowns before the candidates
    real(wp), intent(inout) :: x(:) !! (n) right-hand side
    real(wp) :: below(size(x))
    integer :: k, w, rows, first
    integer(long) :: last

    do k = 1, factor%n
      first = int(factor%super(k)) + 1
      w = min(int(factor%super(k + 1)), inner) - first + 1
      if (w <= 0) cycle
      rows = int(factor%pi(k + 1) - factor%pi(k))
      last = factor%px(k) + int(rows, long)*w
      call dtrsv('L', 'N', 'N', w, factor%values(factor%px(k) + 1:last), rows, &
        x(first:first + w - 1), 1)
      if (rows == w) cycle
      call dgemv('N', rows - w, w, 1.0_wp, factor%values(factor%px(k) + w + 1:last), rows, &
        x(first:first + w - 1), 1, 0.0_wp, below, 1)
      associate (others => factor%s(factor%pi(k) + w + 1:factor%pi(k + 1)) + 1)
        x(others) = x(others) - below(:rows - w)
      end associate
    end do
  end subroutine eliminate

  !> L11^-T on the first unknowns, the others given.
  subroutine substitute(factor, inner, x)
    type(supernodes_t), intent(in) :: factor !! the factor
    integer, intent(in) :: inner !! unknowns before the candidates
    real(wp), intent(inout) :: x(:) !! (n) in: eliminated; out: the solution
    real(wp) :: below(size(x))
    integer :: k, w, rows, first
    integer(long) :: last

    do k = factor%n, 1, -1
      first = int(factor%super(k)) + 1
      w = min(int(factor%super(k + 1)), inner) - first + 1
      if (w <= 0) cycle
      rows = int(factor%pi(k + 1) - factor%pi(k))
      last = factor%px(k) + int(rows, long)*w
      below(:rows - w) = x(factor%s(factor%pi(k) + w + 1:factor%pi(k + 1)) + 1)
      if (rows > w) call dgemv('T', rows - w, w, -1.0_wp, factor%values(factor%px(k) + w + 1: &
        last), rows, below, 1, 1.0_wp, x(first:first + w - 1), 1)
      call dtrsv('L', 'T', 'N', w, factor%values(factor%px(k) + 1:last), rows, &
        x(first:first + w - 1), 1)
    end do
  end subroutine substitute
end module body_solves

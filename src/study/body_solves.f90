!> Displacements of a condensed body under any forces: its factor lacks the part of the candidates,
!! whose place their compliance takes (doc/theory, "Sensitivities along the path").
module body_solves
  use, intrinsic :: iso_c_binding, only: c_f_pointer
  use kinds, only: wp, long
  use lapack_interface, only: dgemm, dtrsm, dsymm
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

  !> u = K^-1 b on the free equations of a body, for several right-hand sides at once.
  subroutine solve_condensed_body(body, b, u)
    type(condensed_body_t), intent(in) :: body !! factor and compliance
    real(wp), intent(in) :: b(:, :, :) !! (3, nodes, columns) forces [force]
    real(wp), intent(inout) :: u(:, :, :) !! (3, nodes, columns) gets the displacements of the body
    !! [length]
    real(wp), allocatable :: x(:, :), last(:, :), low(:, :)
    type(supernodes_t) :: factor
    integer :: i, inner, columns

    columns = size(b, 3)
    allocate (x(size(body%node), columns))
    do i = 1, size(x, 1)
      x(i, :) = b(body%direction(i), body%node(i), :)
    end do
    if (all(abs(x) <= 0.0_wp)) then
      do i = 1, size(x, 1)
        u(body%direction(i), body%node(i), :) = 0.0_wp
      end do
      return
    end if
    inner = size(x, 1) - body%m
    call look_at_factor(body%solver, factor)
    call eliminate(factor, inner, size(x, 1), columns, x)
    if (body%m > 0) then
      last = x(inner + 1:, :)
      allocate (low, mold=last)
      call dsymm('L', 'L', body%m, columns, 1.0_wp, body%compliance, body%m, last, body%m, &
        0.0_wp, low, body%m)
      x(inner + 1:, :) = low
    end if
    call substitute(factor, inner, size(x, 1), columns, x)
    do i = 1, size(x, 1)
      u(body%direction(i), body%node(i), :) = x(i, :)
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
  subroutine eliminate(factor, inner, n, columns, x)
    type(supernodes_t), intent(in) :: factor !! the factor
    integer, intent(in) :: inner !! unknowns before the candidates
    integer, intent(in) :: n !! unknowns
    integer, intent(in) :: columns !! right-hand sides
    real(wp), intent(inout) :: x(n, columns) !! right-hand sides
    real(wp) :: below(n*columns)
    integer :: k, j, w, rows, first, under
    integer(long) :: last

    do k = 1, factor%n
      first = int(factor%super(k)) + 1
      w = min(int(factor%super(k + 1)), inner) - first + 1
      if (w <= 0) cycle
      rows = int(factor%pi(k + 1) - factor%pi(k))
      last = factor%px(k) + int(rows, long)*w
      call dtrsm('L', 'L', 'N', 'N', w, columns, 1.0_wp, factor%values(factor%px(k) + 1:last), &
        rows, x(first, 1), n)
      under = rows - w
      if (under == 0) cycle
      call dgemm('N', 'N', under, columns, w, 1.0_wp, factor%values(factor%px(k) + w + 1: &
        last), rows, x(first, 1), n, 0.0_wp, below, under)
      associate (others => factor%s(factor%pi(k) + w + 1:factor%pi(k + 1)) + 1)
        do j = 1, columns
          x(others, j) = x(others, j) - below((j - 1)*under + 1:j*under)
        end do
      end associate
    end do
  end subroutine eliminate

  !> L11^-T on the first unknowns, the others given.
  subroutine substitute(factor, inner, n, columns, x)
    type(supernodes_t), intent(in) :: factor !! the factor
    integer, intent(in) :: inner !! unknowns before the candidates
    integer, intent(in) :: n !! unknowns
    integer, intent(in) :: columns !! right-hand sides
    real(wp), intent(inout) :: x(n, columns) !! in: eliminated; out: the solution
    real(wp) :: below(n*columns)
    integer :: k, j, w, rows, first, under
    integer(long) :: last

    do k = factor%n, 1, -1
      first = int(factor%super(k)) + 1
      w = min(int(factor%super(k + 1)), inner) - first + 1
      if (w <= 0) cycle
      rows = int(factor%pi(k + 1) - factor%pi(k))
      last = factor%px(k) + int(rows, long)*w
      under = rows - w
      do j = 1, columns
        below((j - 1)*under + 1:j*under) = x(factor%s(factor%pi(k) + w + 1:factor%pi(k + 1)) + 1, j)
      end do
      if (under > 0) call dgemm('T', 'N', w, columns, under, -1.0_wp, factor%values( &
        factor%px(k) + w + 1:last), rows, below, under, 1.0_wp, x(first, 1), n)
      call dtrsm('L', 'L', 'T', 'N', w, columns, 1.0_wp, factor%values(factor%px(k) + 1:last), &
        rows, x(first, 1), n)
    end do
  end subroutine substitute
end module body_solves

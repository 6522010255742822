!> The two halves of a solution with the factor of a lower triangle: down to the unknowns that are
!! eliminated last, and up from these (doc/theory, "Condensed contact").
module half_solves
  use kinds, only: wp, long
  use costs, only: cost_t, begin_cost, end_cost, cost_interior
  use lapack_interface, only: dgemv, dtrsv, dgemm, dtrsm
  use cholmod_solver, only: cholmod_t, supernodes_t, supernodes_of
  implicit none
  private
  public :: reduce_right, reduce_columns, complete_solution

contains

  !> The forward substitution down to the last m unknowns: y1 of L11 y1 = b1, and b2 - L21 y1 for
  !! these (doc/theory, "Condensed contact").
  subroutine reduce_right(solver, m, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: b; out: y1 and what is left of b2
    type(cost_t), intent(inout) :: costs !! cost table
    type(supernodes_t) :: nodes
    real(wp) :: below(size(x))
    integer :: k, w, rows, first
    integer(long) :: last

    call begin_cost(costs, cost_interior)
    nodes = supernodes_of(solver)
    do k = 1, int(nodes%factor%nsuper)
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), size(x) - m) - int(nodes%super(k))
      if (w <= 0) exit
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      last = nodes%px(k) + int(rows, long)*w
      call dtrsv('L', 'N', 'N', w, nodes%x(nodes%px(k) + 1:last), rows, x(first:first + w - 1), 1)
      if (rows == w) cycle
      call dgemv('N', rows - w, w, 1.0_wp, nodes%x(nodes%px(k) + w + 1:last), rows, &
        x(first:first + w - 1), 1, 0.0_wp, below, 1)
      associate (row => nodes%s(nodes%pi(k) + w + 1:nodes%pi(k + 1)) + 1)
        x(row) = x(row) - below(:rows - w)
      end associate
    end do
    call end_cost(costs, cost_interior)
  end subroutine reduce_right

  !> The same for several right-hand sides at once: the factor is read once. Supernodes that none of
  !! them reaches are passed over.
  subroutine reduce_columns(solver, m, n, columns, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    integer, intent(in) :: n !! unknowns
    integer, intent(in) :: columns !! right-hand sides
    real(wp), intent(inout) :: x(n, columns) !! each as in reduce_right
    type(cost_t), intent(inout) :: costs !! cost table
    type(supernodes_t) :: nodes
    real(wp), allocatable :: below(:, :)
    integer :: k, w, rows, first
    integer(long) :: i, last

    call begin_cost(costs, cost_interior)
    nodes = supernodes_of(solver)
    rows = int(maxval(nodes%pi(2:) - nodes%pi(:int(nodes%factor%nsuper))))
    allocate (below(rows, columns))
    do k = 1, int(nodes%factor%nsuper)
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), n - m) - int(nodes%super(k))
      if (w <= 0) exit
      if (all(abs(x(first:first + w - 1, :)) <= 0.0_wp)) cycle
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      last = nodes%px(k) + int(rows, long)*w
      call dtrsm('L', 'L', 'N', 'N', w, columns, 1.0_wp, nodes%x(nodes%px(k) + 1:last), rows, &
        x(first, 1), n)
      if (rows == w) cycle
      call dgemm('N', 'N', rows - w, columns, w, 1.0_wp, nodes%x(nodes%px(k) + w + 1:last), &
        rows, x(first, 1), n, 0.0_wp, below, size(below, 1))
      do i = 1, rows - w
        associate (row => nodes%s(nodes%pi(k) + w + i) + 1)
          x(row, :) = x(row, :) - below(i, :)
        end associate
      end do
    end do
    call end_cost(costs, cost_interior)
  end subroutine reduce_columns

  !> Completes x, known at the last m unknowns, from what reduce_right has made of the right-hand
  !! side of all others: L11^T x1 = y1 - L21^T x2 (doc/theory, "Condensed contact").
  subroutine complete_solution(solver, m, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: y1 and the last m; out: all
    type(cost_t), intent(inout) :: costs !! cost table
    type(supernodes_t) :: nodes
    real(wp) :: below(size(x))
    integer :: k, w, rows, first
    integer(long) :: last

    call begin_cost(costs, cost_interior)
    nodes = supernodes_of(solver)
    do k = int(nodes%factor%nsuper), 1, -1
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), size(x) - m) - int(nodes%super(k))
      if (w <= 0) cycle
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      below(:rows - w) = x(nodes%s(nodes%pi(k) + w + 1:nodes%pi(k + 1)) + 1)
      last = nodes%px(k) + int(rows, long)*w
      if (rows > w) call dgemv('T', rows - w, w, -1.0_wp, nodes%x(nodes%px(k) + w + 1:last), rows, &
        below, 1, 1.0_wp, x(first:first + w - 1), 1)
      call dtrsv('L', 'T', 'N', w, nodes%x(nodes%px(k) + 1:last), rows, &
        x(first:first + w - 1), 1)
    end do
    call end_cost(costs, cost_interior)
  end subroutine complete_solution
end module half_solves

!> The two halves of a solution with the factor of a lower triangle: down to the unknowns that are
!! eliminated last, and up from these (doc/theory, "Static condensation", eq. (12.5)).
module half_solves
  use, intrinsic :: iso_c_binding, only: c_associated, c_int, c_ptr, c_char, c_loc, c_size_t, &
    c_sizeof, c_f_pointer
  use kinds, only: wp, sp, long
  use libc, only: c_memcpy
  use costs, only: cost_t, begin_cost, end_cost, count_cost, cost_interior, cost_solve
  use lapack_interface, only: dgemm, dtrsm
  use supernodes, only: supernodes_t, supernodes_of, solve_double, reduce_double, &
    complete_double, invert_blocks, reduce_single, complete_single
  use cholmod_interface, only: cholmod_l_change_factor, cholmod_l_realloc
  use cholmod_solver, only: cholmod_t, forget_half
  implicit none
  private
  public :: solve_columns, reduce_right, reduce_columns, complete_solution, solve_inside, &
    halve_factor, shrink_factor

  !> Values that are changed to single precision at a time, and bytes of one.
  integer, parameter :: part_size = 4096
  integer(long), parameter :: single_bytes = 4

contains

  !> Whole solutions for several right-hand sides at once.
  subroutine solve_columns(solver, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle, with values
    real(wp), intent(inout), contiguous :: x(:, :) !! (n, columns) right-hand sides; solutions
    type(cost_t), intent(inout) :: costs !! cost table

    call count_cost(costs, cost_solve, count(any(abs(x) > 0.0_wp, 1)) - 1)
    call begin_cost(costs, cost_solve)
    call solve_double(supernodes_of(solver%factor), x)
    call end_cost(costs, cost_solve)
  end subroutine solve_columns

  !> The forward substitution down to the last m unknowns: y1 of L11 y1 = b1, and b2 - L21 y1 for
  !! these (doc/theory, "Static condensation").
  subroutine reduce_right(solver, m, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: b; out: y1 and what is left of b2
    type(cost_t), intent(inout) :: costs !! cost table

    call begin_cost(costs, cost_interior)
    if (associated(solver%half)) then
      call reduce_single(supernodes_of(solver%factor), solver%half, m, x)
    else
      call reduce_double(supernodes_of(solver%factor), m, x)
    end if
    call end_cost(costs, cost_interior)
  end subroutine reduce_right

  !> The same for several right-hand sides at once: the factor is read once. Where threads share
  !! it, it is read once for each half of them.
  subroutine reduce_columns(solver, m, n, columns, shared, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    integer, intent(in) :: n !! unknowns
    integer, intent(in) :: columns !! right-hand sides
    logical, intent(in) :: shared !! threads share the work
    real(wp), intent(inout) :: x(n, columns) !! each as in reduce_right
    type(cost_t), intent(inout) :: costs !! cost table
    type(supernodes_t) :: nodes
    integer :: half

    call begin_cost(costs, cost_interior)
    nodes = supernodes_of(solver%factor)
    half = columns
    if (shared) half = columns/2
    !$omp task default(none) shared(nodes, m, n, half, x) if(shared)
    call reduce_some(nodes, m, n, half, x)
    !$omp end task
    if (half < columns) call reduce_some(nodes, m, n, columns - half, x(:, half + 1:))
    !$omp taskwait
    call end_cost(costs, cost_interior)
  end subroutine reduce_columns

  !> The same for some of them. Supernodes that none of them reaches are passed over.
  subroutine reduce_some(nodes, m, n, columns, x)
    type(supernodes_t), intent(in) :: nodes !! of the factor
    integer, intent(in) :: m !! unknowns at the end
    integer, intent(in) :: n !! unknowns
    integer, intent(in) :: columns !! right-hand sides
    real(wp), intent(inout) :: x(n, columns) !! each as in reduce_right
    real(wp), allocatable :: below(:, :)
    integer :: k, w, rows, first
    integer(long) :: i, last

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
  end subroutine reduce_some

  !> Completes x, known at the last m unknowns, from what reduce_right has made of the right-hand
  !! side of all others: L11^T x1 = y1 - L21^T x2 (doc/theory, "Static condensation").
  subroutine complete_solution(solver, m, x, costs)
    type(cholmod_t), intent(in) :: solver !! factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: y1 and the last m; out: all
    type(cost_t), intent(inout) :: costs !! cost table

    call begin_cost(costs, cost_interior)
    if (associated(solver%half)) then
      call complete_single(supernodes_of(solver%factor), solver%half, m, x)
    else
      call complete_double(supernodes_of(solver%factor), m, x)
    end if
    call end_cost(costs, cost_interior)
  end subroutine complete_solution

  !> Keeps a factor whose trailing block is gone in single precision alone, if its entries are
  !! numbers there, and answers of the one and the other differ by less than a share. Half the
  !! memory is half the time of a substitution.
  subroutine halve_factor(solver, m, share, costs)
    type(cholmod_t), intent(inout) :: solver !! its trailing block of m columns is gone
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(in) :: share !! most of the difference over the answer
    type(cost_t), intent(inout) :: costs !! cost table
    type(supernodes_t) :: nodes
    real(wp), allocatable :: x(:), y(:)
    integer(c_int) :: status

    if (associated(solver%half)) return
    nodes = supernodes_of(solver%factor)
    if (nodes%factor%xsize == 0 .or. .not. c_associated(nodes%factor%x)) return
    if (maxval(abs(nodes%x)) > sqrt(real(huge(1.0_sp), wp))) return
    allocate (x(nodes%factor%n), source=1.0_wp)
    y = x
    call answer_twice(solver, m, x, costs)
    allocate (solver%half, source=real(nodes%x, sp))
    call invert_blocks(nodes, m, solver%half)
    call answer_twice(solver, m, y, costs)
    if (norm2(x - y) <= share*norm2(x)) then
      status = cholmod_l_change_factor(0_c_int, 1_c_int, 1_c_int, 1_c_int, 1_c_int, &
        solver%factor, solver%common)
    else
      call forget_half(solver)
    end if
  end subroutine halve_factor

  !> The same without a test, in the memory that the factor has: no more is taken at any time. What
  !! is answered with it must be mended (inside_refinement). A factor whose entries would not be
  !! numbers stays.
  subroutine shrink_factor(solver, m, most)
    type(cholmod_t), intent(inout) :: solver !! its trailing block of m columns is gone
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(in) :: most !! no entry of the factor is larger
    type(supernodes_t) :: nodes
    real(sp), target :: part(part_size)
    integer(long) :: k, n, last
    type(c_ptr) :: done

    nodes = supernodes_of(solver%factor)
    n = int(nodes%factor%xsize, long)
    if (n == 0 .or. .not. c_associated(nodes%factor%x) .or. associated(solver%half)) return
    if (.not. fits_single(nodes, m, most)) return
    do k = 0, n - 1, part_size
      last = min(k + part_size, n)
      part(:last - k) = real(nodes%x(k + 1:last), sp)
      done = c_memcpy(byte_of(nodes%factor%x, single_bytes*k), c_loc(part), &
        int(single_bytes*(last - k), c_size_t))
    end do
    nodes%factor%x = cholmod_l_realloc(int((n + 1)/2, c_size_t), c_sizeof(1.0_wp), &
      nodes%factor%x, nodes%factor%xsize, solver%common)
    call c_f_pointer(nodes%factor%x, solver%half, [n])
    solver%half_inside = .true.
    call invert_blocks(nodes, m, solver%half)
  end subroutine shrink_factor

  !> The entries of a factor are numbers in single precision, and so are the inverses of its pivots.
  logical function fits_single(nodes, m, most) result(fits)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(in) :: most !! no entry of the factor is larger
    real(wp), parameter :: limit = sqrt(real(huge(1.0_sp), wp))
    integer(long) :: k, j, rows

    fits = most <= limit
    if (.not. fits) fits = maxval(abs(nodes%x)) <= limit
    do k = 1, int(nodes%factor%nsuper, long)
      rows = nodes%pi(k + 1) - nodes%pi(k)
      do j = 0, min(nodes%super(k + 1), int(nodes%factor%n, long) - m) - nodes%super(k) - 1
        if (nodes%x(nodes%px(k) + rows*j + j + 1) < 1.0_wp/limit) fits = .false.
      end do
    end do
  end function fits_single

  !> The address of a byte of a block.
  type(c_ptr) function byte_of(block, byte) result(address)
    type(c_ptr), intent(in) :: block !! where it begins
    integer(long), intent(in) :: byte !! from 0
    character(kind=c_char), pointer :: bytes(:)

    call c_f_pointer(block, bytes, [byte + 1])
    address = c_loc(bytes(byte + 1))
  end function byte_of

  !> The answer inside to a right-hand side while the last m unknowns are held.
  subroutine solve_inside(solver, m, x, costs)
    type(cholmod_t), intent(in) :: solver !! its trailing block of m columns may be gone
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: right-hand side; out: answer, then 0
    type(cost_t), intent(inout) :: costs !! cost table

    call reduce_right(solver, m, x, costs)
    x(size(x) - m + 1:) = 0.0_wp
    call complete_solution(solver, m, x, costs)
  end subroutine solve_inside

  !> That answer, and the answer to it, in which soft motions stand out; both scaled to length 1.
  subroutine answer_twice(solver, m, x, costs)
    type(cholmod_t), intent(in) :: solver !! its trailing block of m columns is gone
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: right-hand side; out: the second answer
    type(cost_t), intent(inout) :: costs !! cost table
    integer :: time

    do time = 1, 2
      call solve_inside(solver, m, x, costs)
      x = x/max(norm2(x), tiny(1.0_wp))
    end do
  end subroutine answer_twice
end module half_solves

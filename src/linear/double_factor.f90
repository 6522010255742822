!> Cholesky factor of a lower triangle in the supernodes of CHOLMOD's analysis: left-looking, each
!! product as long as its rows allow and put where it belongs (doc/theory, "Linear systems").
module double_factor
  use kinds, only: wp, long
  use lapack_interface, only: dgemm, dsyrk, dtrsm, dpotrf
  use costs, only: cost_t, begin_cost, end_cost, cost_symmetric_factor
  use csc_matrix, only: csc_matrix_t
  use back_ends, only: solver_done, solver_not_definite
  use cholmod_solver, only: cholmod_t, make_room
  use supernodes, only: supernodes_t, supernodes_of
  use waiting_supernodes, only: waiting_t, begin_waiting, wait_for_next, columns_within, &
    place_rows
  implicit none
  private
  public :: factorise_lower

  !> Columns that are eliminated at once; of more the first half takes its product off the second.
  integer, parameter :: few_columns = 24
  !> A square of so many rows is formed as a whole, though half of it counts.
  integer, parameter :: small_square = 64
  !> So many rows that follow each other are worth a product of their own.
  integer, parameter :: long_run = 192

contains

  !> Factorises the lower triangle of a matrix whose equations are in the order of elimination. The
  !! factor is CHOLMOD's.
  subroutine factorise_lower(solver, a, costs, outcome)
    type(cholmod_t), intent(inout) :: solver !! analysed; gets values
    type(csc_matrix_t), intent(in) :: a !! its lower triangle
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes, or not definite
    type(supernodes_t) :: nodes

    call begin_cost(costs, cost_symmetric_factor)
    call make_room(solver, outcome)
    if (outcome == solver_done) then
      nodes = supernodes_of(solver%factor)
      call factorise_double(nodes, a, nodes%x, solver%definite)
      if (.not. solver%definite) outcome = solver_not_definite
    end if
    call end_cost(costs, cost_symmetric_factor)
  end subroutine factorise_lower

  !> L of A = L L^T, as CHOLMOD stores it: rows of a supernode by its columns. What stands above the
  !! diagonal has no meaning.
  subroutine factorise_double(nodes, a, x, definite)
    type(supernodes_t), intent(in) :: nodes !! analysed
    type(csc_matrix_t), intent(in) :: a !! lower triangle, in the order of elimination
    real(wp), intent(inout), contiguous :: x(:) !! gets the values
    logical, intent(out) :: definite !! no pivot was zero or negative
    type(waiting_t) :: waiting
    integer :: place(a%n), k, d, after, w, rows
    real(wp), allocatable :: update(:)
    integer(long) :: first, last

    call begin_waiting(nodes, int(a%n), waiting)
    allocate (update(max(1_long, int(nodes%factor%maxcsize, long))))
    definite = .true.
    do k = 1, int(nodes%factor%nsuper)
      w = int(nodes%super(k + 1) - nodes%super(k))
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      first = nodes%px(k) + 1
      last = nodes%px(k) + int(rows, long)*w
      call place_rows(nodes, k, place)
      call gather_columns(nodes, a, k, place, x(first:last))
      d = waiting%head(k)
      do while (d > 0)
        after = waiting%next(d)
        call subtract(nodes, d, k, place, waiting%from(d), x, update)
        call wait_for_next(nodes, d, waiting)
        d = after
      end do
      call eliminate(rows, w, rows, x(first:last), definite)
      if (.not. definite) return
      if (rows == w) cycle
      waiting%from(k) = w + 1
      call wait_for_next(nodes, k, waiting)
    end do
  end subroutine factorise_double

  !> The columns of a supernode in the matrix.
  pure subroutine gather_columns(nodes, a, k, place, panel)
    type(supernodes_t), intent(in) :: nodes !! analysed
    type(csc_matrix_t), intent(in) :: a !! lower triangle
    integer, intent(in) :: k !! the supernode
    integer, intent(in) :: place(:) !! (n) places of its rows
    real(wp), intent(out) :: panel(:) !! (rows*columns) its values
    integer(long) :: i, j, entry, rows

    rows = nodes%pi(k + 1) - nodes%pi(k)
    panel = 0.0_wp
    do j = nodes%super(k), nodes%super(k + 1) - 1
      do entry = a%ptr(j + 1) + 1, a%ptr(j + 2)
        i = (j - nodes%super(k))*rows + place(a%row(entry) + 1)
        panel(i) = panel(i) + a%val(entry)
      end do
    end do
  end subroutine gather_columns

  !> Subtracts from supernode k what supernode d has in its columns: the rows from `from` on, times
  !! those of them that are columns of k. `from` goes on behind these. Where they follow each other
  !! in k, too, long runs of rows that do so get their product in its place.
  subroutine subtract(nodes, d, k, place, from, x, update)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: d, k !! the supernodes
    integer, intent(in) :: place(:) !! (n) places of the rows of k
    integer, intent(inout) :: from !! first row of d that is not yet dealt with
    real(wp), intent(inout), contiguous :: x(:) !! values
    real(wp), intent(inout), contiguous :: update(:) !! room
    integer :: rows, w, columns, in_k, i, j
    integer(long) :: first, last, at
    logical :: in_place

    rows = int(nodes%pi(d + 1) - nodes%pi(d))
    w = int(nodes%super(d + 1) - nodes%super(d))
    columns = columns_within(nodes, d, k, from)
    first = nodes%px(d) + from
    last = nodes%px(d) + int(rows, long)*w
    in_k = int(nodes%pi(k + 1) - nodes%pi(k))
    associate (to => place(nodes%s(nodes%pi(d) + from:nodes%pi(d + 1)) + 1))
      i = 1
      do while (i <= size(to))
        call find_stretch(to, columns, i, j, in_place)
        if (in_place) then
          at = nodes%px(k) + int(in_k, long)*(to(1) - 1) + to(i)
          call take_product(i, j, columns, w, x(first:last), rows, 1.0_wp, &
            x(at:nodes%px(k + 1)), in_k)
        else
          call take_product(i, j, columns, w, x(first:last), rows, 0.0_wp, update, j - i + 1)
          call scatter(to, i, j, columns, update, in_k, x(nodes%px(k) + 1:nodes%px(k + 1)))
        end if
        i = j + 1
      end do
    end associate
    from = from + columns
  end subroutine subtract

  !> The next rows that are dealt with together: a run that is long, or all up to the next one. The
  !! first rows are the columns; where they do not follow each other no product is in place.
  pure subroutine find_stretch(to, columns, first, last, in_place)
    integer, intent(in) :: to(:) !! places of the rows
    integer, intent(in) :: columns !! the first of them
    integer, intent(in) :: first !! row that is the first one
    integer, intent(out) :: last !! the last one
    logical, intent(out) :: in_place !! it is a run
    integer :: i, run

    in_place = .false.
    last = size(to)
    if (to(columns) - to(1) /= columns - 1) return
    i = first
    do while (i <= size(to))
      run = i
      do while (run < size(to))
        if (to(run + 1) /= to(run) + 1) exit
        run = run + 1
      end do
      in_place = run - i + 1 >= long_run .or. run - i + 1 == size(to)
      if (in_place) exit
      i = run + 1
    end do
    if (in_place) last = merge(run, i - 1, i == first)
    in_place = in_place .and. i == first
  end subroutine find_stretch

  !> C = beta C - A A1^T for some rows of A, which has the rows A1 at its beginning. Where rows are
  !! those of A1, too, the lower triangle.
  subroutine take_product(first, last, columns, w, a, in_a, beta, c, in_c)
    integer, intent(in) :: first, last !! rows: those after A1, or all from its first on
    integer, intent(in) :: columns !! of C, rows of A1
    integer, intent(in) :: w !! columns of A
    integer, intent(in) :: in_a, in_c !! rows that A and C are stored with
    real(wp), intent(in), contiguous :: a(:) !! A, from its first entry on
    real(wp), intent(in) :: beta !! 0 or 1
    real(wp), intent(inout), contiguous :: c(:) !! C, from its entry in the first row on
    integer :: square

    square = 0
    if (first == 1 .and. columns > small_square) then
      square = columns
      call dsyrk('L', 'N', columns, w, -1.0_wp, a, in_a, beta, c, in_c)
    end if
    if (last - first + 1 > square) call dgemm('N', 'T', last - first + 1 - square, columns, w, &
      -1.0_wp, a(first + square:), in_a, a, in_a, beta, c(1 + square:), in_c)
  end subroutine take_product

  !> Adds rows of a product to the places where they belong, run by run of rows that follow each
  !! other there: its lower triangle.
  pure subroutine scatter(to, first, last, columns, update, rows, panel)
    integer, intent(in) :: to(:) !! place of each row in the panel; the first are the columns
    integer, intent(in) :: first, last !! those that are added
    integer, intent(in) :: columns !! of the product: the first rows
    real(wp), intent(in) :: update(first:last, columns) !! the product
    integer, intent(in) :: rows !! of the panel
    real(wp), intent(inout) :: panel(rows, *) !! values of a supernode
    integer :: run(last - first + 2), runs, i, j, k, lead

    runs = 1
    run(1) = first
    do i = first + 1, last
      if (to(i) == to(i - 1) + 1) cycle
      runs = runs + 1
      run(runs) = i
    end do
    run(runs + 1) = last + 1
    lead = 1
    do j = 1, columns
      if (run(lead + 1) <= j) lead = lead + 1
      i = max(j, run(lead))
      do k = lead, runs
        panel(to(i):to(i) + run(k + 1) - 1 - i, to(j)) = &
          panel(to(i):to(i) + run(k + 1) - 1 - i, to(j)) + update(i:run(k + 1) - 1, j)
        i = run(k + 1)
      end do
    end do
  end subroutine scatter

  !> Eliminates some columns of a supernode: the first half, what it takes off the second, and that
  !! half; few of them at once.
  recursive subroutine eliminate(rows, w, in_x, x, definite)
    integer, intent(in) :: rows !! from the first of these columns on
    integer, intent(in) :: w !! the columns
    integer, intent(in) :: in_x !! rows that they are stored with
    real(wp), intent(inout) :: x(in_x, *) !! values
    logical, intent(out) :: definite !! no pivot was zero or negative
    integer :: half, info

    if (w <= few_columns) then
      call dpotrf('L', w, x, in_x, info)
      definite = info == 0
      if (definite .and. rows > w) call dtrsm('R', 'L', 'T', 'N', rows - w, w, 1.0_wp, x, in_x, &
        x(w + 1, 1), in_x)
      return
    end if
    half = (w/2 + few_columns - 1)/few_columns*few_columns
    call eliminate(rows, half, in_x, x, definite)
    if (.not. definite) return
    call dgemm('N', 'T', rows - half, w - half, half, -1.0_wp, x(half + 1, 1), in_x, &
      x(half + 1, 1), in_x, 1.0_wp, x(half + 1, half + 1), in_x)
    call eliminate(rows - half, w - half, in_x, x(half + 1, half + 1), definite)
  end subroutine eliminate
end module double_factor

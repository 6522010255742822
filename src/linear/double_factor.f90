!> Cholesky factor of a lower triangle in the supernodes of CHOLMOD's analysis: left-looking, each
!! product as long as its rows allow and put where it belongs (doc/theory, "Sparse factorisation",
!! eq. (12.1)).
module double_factor
  use kinds, only: wp, long
  use lapack_interface, only: dgemm, dsyrk, dtrsm, dpotrf
  use costs, only: cost_t, begin_cost, end_cost, cost_symmetric_factor
  use ordered_blocks, only: ordered_blocks_t, gather_columns
  use back_ends, only: solver_done, solver_not_definite
  use cholmod_solver, only: cholmod_t, make_room, factor_work
  use supernodes, only: supernodes_t, supernodes_of
  use waiting_supernodes, only: waiting_t, begin_waiting, find_givers, pass_givers, &
    wait_for_next, place_rows
  implicit none
  private
  public :: factorise_lower

  !> Columns that are eliminated at once; of more the first half takes its product off the second.
  integer, parameter :: columns_at_once = 24
  !> A square of so many rows is formed as a whole, though half of it counts.
  integer, parameter :: small_square = 64
  !> So many rows that follow each other are worth a product of their own.
  integer, parameter :: rows_in_a_run = 192
  !> Rows of a supernode are dealt with in so many parts at most, if its products and sums are more
  !! than this; a part has so many rows at least.
  integer, parameter :: most_row_parts = 2, least_rows = 128
  real(wp), parameter :: shared_work = 1.0e7_wp

contains

  !> Factorises the lower triangle of a matrix whose equations are in the order of elimination. The
  !! factor is CHOLMOD's.
  subroutine factorise_lower(solver, a, costs, outcome, shared_from)
    type(cholmod_t), intent(inout) :: solver !! analysed; gets values
    type(ordered_blocks_t), intent(in) :: a !! in the order of elimination
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes, or not definite
    real(wp), intent(in), optional :: shared_from !! share from where on threads share the work, 1
    !! for never
    real(wp) :: alone, entries
    type(supernodes_t) :: nodes

    call begin_cost(costs, cost_symmetric_factor)
    call make_room(solver, outcome)
    if (outcome == solver_done) then
      nodes = supernodes_of(solver%factor)
      alone = huge(1.0_wp)
      if (present(shared_from)) then
        if (shared_from < 1.0_wp) then
          call factor_work(solver, alone, entries)
          alone = shared_from*alone
        end if
      end if
      call factorise_double(nodes, a, alone, nodes%x, solver%definite)
      if (.not. solver%definite) outcome = solver_not_definite
    end if
    call end_cost(costs, cost_symmetric_factor)
  end subroutine factorise_lower

  !> L of A = L L^T, as CHOLMOD stores it: rows of a supernode by its columns. What stands above the
  !! diagonal has no meaning.
  subroutine factorise_double(nodes, a, alone, x, definite)
    type(supernodes_t), intent(in) :: nodes !! analysed
    type(ordered_blocks_t), intent(in) :: a !! in the order of elimination
    real(wp), intent(in) :: alone !! products and sums before threads share the others
    real(wp), intent(inout), contiguous :: x(:) !! gets the values
    logical, intent(out) :: definite !! no pivot was zero or negative
    type(waiting_t) :: waiting
    integer :: place(size(a%node)), k, j, w, rows, part, parts(most_row_parts + 1), n
    real(wp) :: done
    real(wp), allocatable :: update(:, :)
    integer(long) :: first, last

    call begin_waiting(nodes, size(place), waiting)
    allocate (update(max(1_long, int(nodes%factor%maxcsize, long)), most_row_parts))
    definite = .true.
    done = 0.0_wp
    do k = 1, int(nodes%factor%nsuper)
      w = int(nodes%super(k + 1) - nodes%super(k))
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      first = nodes%px(k) + 1
      last = nodes%px(k) + int(rows, long)*w
      call place_rows(nodes, k, place)
      call gather_columns(a, int(nodes%super(k)) + 1, int(nodes%super(k + 1)), place, rows, &
        x(first:last))
      call find_givers(nodes, k, waiting)
      call divide_rows(rows, w, waiting%work, done >= alone, parts, n)
      done = done + sum([(real(rows - j, wp)**2, j=0, w - 1)])
      do part = 1, n
        !$omp task default(none) firstprivate(part) &
        !$omp& shared(nodes, k, place, waiting, parts, x, update) if(n > 1)
        call subtract_all(nodes, k, place, waiting, parts(part:part + 1), x, update(:, part))
        !$omp end task
      end do
      !$omp taskwait
      call pass_givers(nodes, waiting)
      call eliminate(w, rows, x(first:last), definite)
      if (.not. definite) return
      if (rows == w) cycle
      call divide_below(rows, w, done >= alone, parts, n)
      do part = 1, n
        !$omp task default(none) firstprivate(part) shared(rows, w, parts, x, first, last) if(n > 1)
        call solve_rows(parts(part + 1) - parts(part), w, rows, x(first:last), &
          x(first + parts(part):last))
        !$omp end task
      end do
      !$omp taskwait
      waiting%from(k) = w + 1
      call wait_for_next(nodes, k, waiting)
    end do
  end subroutine factorise_double

  !> Rows of a supernode that are a task of their own while products are taken off it: about half
  !! of its entries, if threads share the work and much is to be done.
  pure subroutine divide_rows(rows, w, work, shared, parts, n)
    integer, intent(in) :: rows, w !! of the supernode, and its columns
    real(wp), intent(in) :: work !! products and sums that are taken off it
    logical, intent(in) :: shared !! threads share it
    integer, intent(out) :: parts(:) !! last row of each, after 0
    integer, intent(out) :: n !! how many

    n = 1
    parts = rows
    parts(1) = 0
    if (.not. shared .or. work < shared_work) return
    parts(2) = max(w, rows/2 + w/4)
    if (rows - parts(2) >= least_rows) n = 2
    if (n == 1) parts(2) = rows
  end subroutine divide_rows

  !> Rows below the square of a supernode that are a task of their own while they are solved for:
  !! half of them.
  pure subroutine divide_below(rows, w, shared, parts, n)
    integer, intent(in) :: rows, w !! of the supernode, and its columns
    logical, intent(in) :: shared !! threads share it
    integer, intent(out) :: parts(:) !! last row of each, after w
    integer, intent(out) :: n !! how many

    n = 1
    parts = rows
    parts(1) = w
    if (.not. shared .or. real(rows - w, wp)*real(w, wp)**2 < shared_work) return
    if (rows - w >= 2*least_rows) n = 2
    if (n == 2) parts(2) = (rows + w)/2
  end subroutine divide_below

  !> Subtracts from some rows of supernode k what all givers have in its columns.
  subroutine subtract_all(nodes, k, place, waiting, part, x, update)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: k !! the supernode
    integer, intent(in) :: place(:) !! (n) places of its rows
    type(waiting_t), intent(in) :: waiting !! givers
    integer, intent(in) :: part(2) !! the row before the first, and the last
    real(wp), intent(inout), contiguous :: x(:) !! values
    real(wp), intent(inout), contiguous :: update(:) !! room
    integer(long) :: first, last
    integer :: i, d, begin

    do i = 1, waiting%givers
      d = waiting%giver(i)
      first = nodes%pi(d) + waiting%from(d)
      last = nodes%pi(d + 1)
      do while (last >= first)
        if (place(nodes%s(last) + 1) <= part(2)) exit
        last = last - 1
      end do
      begin = 1
      do while (begin <= last - first + 1)
        if (place(nodes%s(first + begin - 1) + 1) > part(1)) exit
        begin = begin + 1
      end do
      call subtract(nodes, i, k, waiting, place(nodes%s(first:last) + 1), begin, x, update)
    end do
  end subroutine subtract_all

  !> Subtracts from supernode k what a giver has in its columns: rows of it, times those that are
  !! columns of k. Where these follow each other in k, too, long runs of rows that do so get their
  !! product in its place.
  subroutine subtract(nodes, giver, k, waiting, to, begin, x, update)
    type(supernodes_t), intent(in) :: nodes !! analysed
    integer, intent(in) :: giver !! which of the givers
    integer, intent(in) :: k !! the supernode
    type(waiting_t), intent(in) :: waiting !! givers
    integer, intent(in) :: to(:) !! places in k of its rows, from the first that is a column of k on
    integer, intent(in) :: begin !! the first of them that is dealt with
    real(wp), intent(inout), contiguous :: x(:) !! values
    real(wp), intent(inout), contiguous :: update(:) !! room
    integer :: d, columns, rows, w, in_k, i, j
    integer(long) :: first, last, at
    logical :: in_place

    d = waiting%giver(giver)
    columns = waiting%columns(giver)
    rows = int(nodes%pi(d + 1) - nodes%pi(d))
    w = int(nodes%super(d + 1) - nodes%super(d))
    in_k = int(nodes%pi(k + 1) - nodes%pi(k))
    last = nodes%px(d) + int(rows, long)*w
    first = nodes%px(d) + waiting%from(d)
    i = begin
    do while (i <= size(to))
      call find_stretch(to, columns, i, j, in_place)
      if (in_place) then
        at = nodes%px(k) + int(in_k, long)*(to(1) - 1) + to(i)
        call take_product(i, j, columns, w, x(first:last), rows, 1.0_wp, x(at:nodes%px(k + 1)), &
          in_k)
      else
        call take_product(i, j, columns, w, x(first:last), rows, 0.0_wp, update, j - i + 1)
        call scatter(to, i, j, columns, update, in_k, x(nodes%px(k) + 1:nodes%px(k + 1)))
      end if
      i = j + 1
    end do
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
      in_place = run - i + 1 >= rows_in_a_run .or. run - i + 1 == size(to)
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

  !> Eliminates the columns of a square: the first half, what it takes off the second, and that
  !! half; few of them at once.
  recursive subroutine eliminate(w, in_x, x, definite)
    integer, intent(in) :: w !! columns
    integer, intent(in) :: in_x !! rows that they are stored with
    real(wp), intent(inout) :: x(in_x, *) !! values; the lower triangle counts
    logical, intent(out) :: definite !! no pivot was zero or negative
    integer :: half, info

    if (w <= columns_at_once) then
      call dpotrf('L', w, x, in_x, info)
      definite = info == 0
      return
    end if
    half = half_of(w)
    call eliminate(half, in_x, x, definite)
    if (.not. definite) return
    call solve_rows(w - half, half, in_x, x, x(half + 1, 1))
    call dgemm('N', 'T', w - half, w - half, half, -1.0_wp, x(half + 1, 1), in_x, &
      x(half + 1, 1), in_x, 1.0_wp, x(half + 1, half + 1), in_x)
    call eliminate(w - half, in_x, x(half + 1, half + 1), definite)
  end subroutine eliminate

  !> What the columns of a square that are eliminated make of rows below it: X L^T = B, half by
  !! half.
  recursive subroutine solve_rows(rows, w, in_x, l, b)
    integer, intent(in) :: rows !! below
    integer, intent(in) :: w !! columns
    integer, intent(in) :: in_x !! rows that both are stored with
    real(wp), intent(in) :: l(in_x, *) !! the square, eliminated
    real(wp), intent(inout) :: b(in_x, *) !! in: B; out: X
    integer :: half

    if (w <= columns_at_once) then
      call dtrsm('R', 'L', 'T', 'N', rows, w, 1.0_wp, l, in_x, b, in_x)
      return
    end if
    half = half_of(w)
    call solve_rows(rows, half, in_x, l, b)
    call dgemm('N', 'T', rows, w - half, half, -1.0_wp, b, in_x, l(half + 1, 1), in_x, 1.0_wp, &
      b(1, half + 1), in_x)
    call solve_rows(rows, w - half, in_x, l(half + 1, half + 1), b(1, half + 1))
  end subroutine solve_rows

  !> The first half of some columns: blocks of few.
  pure integer function half_of(w) result(half)
    integer, intent(in) :: w !! columns

    half = (w/2 + columns_at_once - 1)/columns_at_once*columns_at_once
  end function half_of
end module double_factor

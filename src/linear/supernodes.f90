!> The supernodes of a factor of CHOLMOD's, and substitutions that end at the last unknowns, in
!! double and in single precision (doc/theory, "Static condensation").
module supernodes
  use, intrinsic :: iso_c_binding, only: c_ptr, c_f_pointer
  use kinds, only: wp, sp, long
  use lapack_interface, only: dgemv, dtrsv, sgemv
  use cholmod_interface, only: cholmod_factor_t
  implicit none
  private
  public :: supernodes_t, supernodes_of, values_before, place_last, solve_double, reduce_double, &
    complete_double, invert_blocks, reduce_single, complete_single, block_width

  !> Columns of a block on the diagonal.
  integer, parameter :: block_width = 64

  !> The supernodes of a factor: columns that have the same rows. Numbers are 0-based.
  type :: supernodes_t
    type(cholmod_factor_t), pointer :: factor !! sizes, number of supernodes
    integer(long), pointer :: super(:) !! (supernodes+1) first column of each
    integer(long), pointer :: pi(:) !! (supernodes+1) where its rows begin in s
    integer(long), pointer :: px(:) !! (supernodes+1) where its values begin in x
    integer(long), pointer :: s(:) !! rows
    real(wp), pointer, contiguous :: x(:) !! values, by columns; not there before factorise
  end type supernodes_t

contains

  !> A view of the supernodes.
  function supernodes_of(handle) result(nodes)
    type(c_ptr), intent(in) :: handle !! a factor of CHOLMOD's, analysed
    type(supernodes_t) :: nodes

    call c_f_pointer(handle, nodes%factor)
    associate (factor => nodes%factor)
      call c_f_pointer(factor%super, nodes%super, [factor%nsuper + 1])
      call c_f_pointer(factor%pi, nodes%pi, [factor%nsuper + 1])
      call c_f_pointer(factor%px, nodes%px, [factor%nsuper + 1])
      call c_f_pointer(factor%s, nodes%s, [factor%ssize])
      call c_f_pointer(factor%x, nodes%x, [factor%xsize])
    end associate
  end function supernodes_of

  !> How many values stand before those of the last m columns, which are the last ones of a factor.
  pure integer(long) function values_before(nodes, m) result(before)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: m !! columns
    integer(long) :: k, first

    first = int(nodes%factor%n, long) - m
    do k = 1, int(nodes%factor%nsuper, long)
      if (nodes%super(k + 1) > first) exit
    end do
    before = int(nodes%factor%xsize, long)
    if (k <= int(nodes%factor%nsuper, long)) before = nodes%px(k) &
      + (first - nodes%super(k))*(nodes%pi(k + 1) - nodes%pi(k))
  end function values_before

  !> The last rows and columns of a factor, L22, from the values of these columns.
  pure subroutine place_last(nodes, values, before, block)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    real(wp), intent(in) :: values(:) !! of its last columns
    integer(long), intent(in) :: before !! values that stand before them
    real(wp), intent(out) :: block(:, :) !! (m, m) its lower triangle; zero above
    integer(long) :: k, i, j, first, rows, place

    first = int(nodes%factor%n, long) - size(block, 1, long)
    do k = int(nodes%factor%nsuper, long), 1, -1
      if (nodes%super(k + 1) <= first) exit
      rows = nodes%pi(k + 1) - nodes%pi(k)
      do j = max(nodes%super(k), first), nodes%super(k + 1) - 1
        place = nodes%px(k) + rows*(j - nodes%super(k)) - before
        block(:, j - first + 1) = 0.0_wp
        do i = j - nodes%super(k) + 1, rows
          block(nodes%s(nodes%pi(k) + i) - first + 1, j - first + 1) = values(place + i)
        end do
      end do
    end do
  end subroutine place_last

  !> L L^T x = b for several right-hand sides: a supernode is read once for all of them. Forward,
  !! those that a right-hand side does not reach are passed over.
  subroutine solve_double(nodes, x)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    real(wp), intent(inout), contiguous :: x(:, :) !! (n, columns) in: b; out: x
    real(wp) :: below(size(x, 1))
    integer :: k, c

    do k = 1, int(nodes%factor%nsuper)
      do c = 1, size(x, 2)
        call solve_supernode(nodes, k, .true., x(:, c), below)
      end do
    end do
    do k = int(nodes%factor%nsuper), 1, -1
      do c = 1, size(x, 2)
        call solve_supernode(nodes, k, .false., x(:, c), below)
      end do
    end do
  end subroutine solve_double

  !> One supernode's part of that.
  subroutine solve_supernode(nodes, k, forward, x, below)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: k !! the supernode
    logical, intent(in) :: forward !! with L, else with L^T
    real(wp), intent(inout), contiguous :: x(:) !! (n) right-hand side; solution
    real(wp), intent(inout), contiguous :: below(:) !! work space
    integer :: w, rows, first, next
    integer(long) :: last

    first = int(nodes%super(k)) + 1
    w = int(nodes%super(k + 1) - nodes%super(k))
    rows = int(nodes%pi(k + 1) - nodes%pi(k))
    last = nodes%px(k) + int(rows, long)*w
    next = int(nodes%super(k + 1))
    if (forward) then
      if (all(abs(x(first:next)) <= 0.0_wp)) return
      call dtrsv('L', 'N', 'N', w, nodes%x(nodes%px(k) + 1:last), rows, x(first:next), 1)
    end if
    associate (row => nodes%s(nodes%pi(k) + w + 1:nodes%pi(k + 1)) + 1)
      below(:rows - w) = x(row)
      if (forward .and. rows > w) then
        call dgemv('N', rows - w, w, -1.0_wp, nodes%x(nodes%px(k) + w + 1:last), rows, &
          x(first:next), 1, 1.0_wp, below, 1)
        x(row) = below(:rows - w)
      else if (rows > w) then
        call dgemv('T', rows - w, w, -1.0_wp, nodes%x(nodes%px(k) + w + 1:last), rows, below, 1, &
          1.0_wp, x(first:next), 1)
      end if
    end associate
    if (.not. forward) call dtrsv('L', 'T', 'N', w, nodes%x(nodes%px(k) + 1:last), rows, &
      x(first:next), 1)
  end subroutine solve_supernode

  !> A supernode does not count, because no right-hand side reaches it on its way up the elimination
  !! tree, and nobody asks for its unknowns.
  pure logical function is_passed_over(k, reached) result(passed)
    integer, intent(in) :: k !! the supernode
    logical, intent(in), optional :: reached(:) !! (supernodes) those that count, else all

    passed = .false.
    if (present(reached)) passed = .not. reached(k)
  end function is_passed_over

  !> Forward: y1 of L11 y1 = b1, and b2 - L21 y1 for the last m unknowns.
  subroutine reduce_double(nodes, m, x, reached)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: b; out: y1 and what is left of b2
    logical, intent(in), optional :: reached(:) !! (supernodes) those that count, else all
    real(wp) :: below(size(x))
    integer :: k, w, rows, first, i
    integer(long) :: last

    do k = 1, int(nodes%factor%nsuper)
      if (is_passed_over(k, reached)) cycle
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), size(x) - m) - int(nodes%super(k))
      if (w <= 0) exit
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      last = nodes%px(k) + int(rows, long)*w
      call dtrsv('L', 'N', 'N', w, nodes%x(nodes%px(k) + 1:last), rows, x(first:first + w - 1), 1)
      if (rows == w) cycle
      call dgemv('N', rows - w, w, 1.0_wp, nodes%x(nodes%px(k) + w + 1:last), rows, &
        x(first:first + w - 1), 1, 0.0_wp, below, 1)
      do i = 1, rows - w
        associate (row => nodes%s(nodes%pi(k) + w + i) + 1)
          x(row) = x(row) - below(i)
        end associate
      end do
    end do
  end subroutine reduce_double

  !> Back: x1 of L11^T x1 = y1 - L21^T x2.
  subroutine complete_double(nodes, m, x, reached)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: y1 and the last m; out: all
    logical, intent(in), optional :: reached(:) !! (supernodes) those that count, else all
    real(wp) :: below(size(x))
    integer :: k, w, rows, first, i
    integer(long) :: last

    do k = int(nodes%factor%nsuper), 1, -1
      if (is_passed_over(k, reached)) cycle
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), size(x) - m) - int(nodes%super(k))
      if (w <= 0) cycle
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      do i = 1, rows - w
        below(i) = x(nodes%s(nodes%pi(k) + w + i) + 1)
      end do
      last = nodes%px(k) + int(rows, long)*w
      if (rows > w) call dgemv('T', rows - w, w, -1.0_wp, nodes%x(nodes%px(k) + w + 1:last), rows, &
        below, 1, 1.0_wp, x(first:first + w - 1), 1)
      call dtrsv('L', 'T', 'N', w, nodes%x(nodes%px(k) + 1:last), rows, &
        x(first:first + w - 1), 1)
    end do
  end subroutine complete_double

  !> Puts the inverses of their triangles in place of the blocks on the diagonal: a product is read
  !! as fast as a rectangle is, a substitution goes column by column.
  subroutine invert_blocks(nodes, m, half)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: m !! unknowns at the end; their blocks are left alone
    real(sp), intent(inout), contiguous :: half(:) !! values in single precision
    integer :: k, w, rows, c, columns
    integer(long) :: first, last

    do k = 1, int(nodes%factor%nsuper)
      w = min(int(nodes%super(k + 1)), int(nodes%factor%n) - m) - int(nodes%super(k))
      if (w <= 0) exit
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      last = nodes%px(k) + int(rows, long)*w
      do c = 1, w, block_width
        columns = min(block_width, w - c + 1)
        first = nodes%px(k) + int(rows, long)*(c - 1) + c
        call invert_triangle(columns, rows, half(first:last))
      end do
    end do
  end subroutine invert_blocks

  !> The inverse of a lower triangle in its place, zero above: column by column from the last one,
  !! each by those behind it. Of LAPACK's STRTRI each column is a call, which takes twice as long.
  pure subroutine invert_triangle(n, rows, l)
    integer, intent(in) :: n !! its rows, a block at most
    integer, intent(in) :: rows !! rows that it is stored with
    real(sp), intent(inout) :: l(rows, *) !! the triangle; its inverse
    real(sp) :: column(block_width)
    integer :: j, k

    do j = n, 1, -1
      l(:j - 1, j) = 0.0_sp
      l(j, j) = 1.0_sp/l(j, j)
      column(j + 1:n) = 0.0_sp
      do k = j + 1, n
        column(k:n) = column(k:n) - l(k, j)*l(k:n, k)
      end do
      l(j + 1:n, j) = l(j, j)*column(j + 1:n)
    end do
  end subroutine invert_triangle

  !> reduce_double in single precision, with inverse blocks on the diagonal.
  subroutine reduce_single(nodes, half, m, x, reached)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle, its values aside
    real(sp), intent(in), contiguous :: half(:) !! these
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: b; out: y1 and what is left of b2
    logical, intent(in), optional :: reached(:) !! (supernodes) those that count, else all
    real(sp) :: y(size(x)), below(size(x))
    integer :: k, w, rows, first, i
    integer(long) :: last

    y = real(x, sp)
    do k = 1, int(nodes%factor%nsuper)
      if (is_passed_over(k, reached)) cycle
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), size(x) - m) - int(nodes%super(k))
      if (w <= 0) exit
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      last = nodes%px(k) + int(rows, long)*w
      call reduce_triangle(w, rows, half(nodes%px(k) + 1:last), y(first:first + w - 1))
      if (rows == w) cycle
      call sgemv('N', rows - w, w, 1.0_sp, half(nodes%px(k) + w + 1:last), rows, &
        y(first:first + w - 1), 1, 0.0_sp, below, 1)
      do i = 1, rows - w
        associate (row => nodes%s(nodes%pi(k) + w + i) + 1)
          y(row) = y(row) - below(i)
        end associate
      end do
    end do
    x = real(y, wp)
  end subroutine reduce_single

  !> y = L^-1 y for the triangle of a supernode.
  subroutine reduce_triangle(w, rows, l, y)
    integer, intent(in) :: w !! its columns
    integer, intent(in) :: rows !! rows of the supernode
    real(sp), intent(in) :: l(rows, w) !! its values, inverse blocks on the diagonal
    real(sp), intent(inout) :: y(w) !! right-hand side; solution
    real(sp) :: part(block_width)
    integer :: c, columns, next

    do c = 1, w, block_width
      columns = min(block_width, w - c + 1)
      next = c + columns
      part(:columns) = y(c:next - 1)
      call sgemv('N', columns, columns, 1.0_sp, l(c, c), rows, part, 1, 0.0_sp, y(c), 1)
      if (next <= w) call sgemv('N', w - next + 1, columns, -1.0_sp, l(next, c), rows, y(c), 1, &
        1.0_sp, y(next), 1)
    end do
  end subroutine reduce_triangle

  !> complete_double in single precision, with inverse blocks on the diagonal.
  subroutine complete_single(nodes, half, m, x, reached)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle, its values aside
    real(sp), intent(in), contiguous :: half(:) !! these
    integer, intent(in) :: m !! unknowns at the end
    real(wp), intent(inout), contiguous :: x(:) !! (n) in: y1 and the last m; out: all
    logical, intent(in), optional :: reached(:) !! (supernodes) those that count, else all
    real(sp) :: y(size(x)), below(size(x))
    integer :: k, w, rows, first, i
    integer(long) :: last

    y = real(x, sp)
    do k = int(nodes%factor%nsuper), 1, -1
      if (is_passed_over(k, reached)) cycle
      first = int(nodes%super(k)) + 1
      w = min(int(nodes%super(k + 1)), size(x) - m) - int(nodes%super(k))
      if (w <= 0) cycle
      rows = int(nodes%pi(k + 1) - nodes%pi(k))
      do i = 1, rows - w
        below(i) = y(nodes%s(nodes%pi(k) + w + i) + 1)
      end do
      last = nodes%px(k) + int(rows, long)*w
      if (rows > w) call sgemv('T', rows - w, w, -1.0_sp, &
        half(nodes%px(k) + w + 1:last), rows, below, 1, 1.0_sp, y(first:first + w - 1), 1)
      call complete_triangle(w, rows, half(nodes%px(k) + 1:last), y(first:first + w - 1))
    end do
    x(:size(x) - m) = real(y(:size(x) - m), wp)
  end subroutine complete_single

  !> y = L^-T y for the triangle of a supernode.
  subroutine complete_triangle(w, rows, l, y)
    integer, intent(in) :: w !! its columns
    integer, intent(in) :: rows !! rows of the supernode
    real(sp), intent(in) :: l(rows, w) !! its values, inverse blocks on the diagonal
    real(sp), intent(inout) :: y(w) !! right-hand side; solution
    real(sp) :: part(block_width)
    integer :: c, columns, next

    do c = (w - 1)/block_width*block_width + 1, 1, -block_width
      columns = min(block_width, w - c + 1)
      next = c + columns
      part(:columns) = y(c:next - 1)
      if (next <= w) call sgemv('T', w - next + 1, columns, -1.0_sp, l(next, c), rows, y(next), 1, &
        1.0_sp, part, 1)
      call sgemv('T', columns, columns, 1.0_sp, l(c, c), rows, part, 1, 0.0_sp, y(c), 1)
    end do
  end subroutine complete_triangle
end module supernodes

!> The ways of equations up the elimination tree of a factor of CHOLMOD's, and columns of its
!! inverse there (doc/theory, "Implicit compliance").
module elimination_paths
  use kinds, only: sp, long
  use lapack_interface, only: sgemm
  use supernodes, only: supernodes_t, block_width
  implicit none
  private
  public :: path_t, find_path, list_path, reduce_path

  !> Supernodes above some equations, with their columns side by side.
  type :: path_t
    integer, allocatable :: supernode(:) !! (n) ascending
    integer, allocatable :: before(:) !! (n+1) columns before those of each
  end type path_t

contains

  !> The supernodes that some equations reach: their own, and those above.
  subroutine find_path(nodes, equation, reached)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: equation(:) !! the equations
    logical, intent(out) :: reached(:) !! (supernodes)
    integer(long) :: k, w
    logical :: asked(nodes%factor%n)

    asked = .false.
    asked(equation) = .true.
    reached = .false.
    do k = 1, size(reached, kind=long)
      if (.not. reached(k)) reached(k) = any(asked(nodes%super(k) + 1:nodes%super(k + 1)))
      w = nodes%super(k + 1) - nodes%super(k)
      if (.not. reached(k) .or. nodes%pi(k + 1) - nodes%pi(k) == w) cycle
      reached(supernode_of(nodes, nodes%s(nodes%pi(k) + w + 1))) = .true.
    end do
  end subroutine find_path

  !> The supernode of a column, by halving.
  pure integer(long) function supernode_of(nodes, column) result(low)
    type(supernodes_t), intent(in) :: nodes !! of a factor
    integer(long), intent(in) :: column !! 0-based
    integer(long) :: high, middle

    low = 1
    high = size(nodes%super, kind=long)
    do while (high - low > 1)
      middle = (low + high)/2
      if (nodes%super(middle) <= column) then
        low = middle
      else
        high = middle
      end if
    end do
  end function supernode_of

  !> The path of some equations.
  subroutine list_path(nodes, equation, path)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer, intent(in) :: equation(:) !! the equations
    type(path_t), intent(out) :: path !! the supernodes above them
    logical :: reached(nodes%factor%nsuper)
    integer :: k

    call find_path(nodes, equation, reached)
    path%supernode = pack([(k, k=1, size(reached))], reached)
    allocate (path%before(size(path%supernode) + 1))
    path%before(1) = 0
    do k = 1, size(path%supernode)
      associate (supernode => path%supernode(k))
        path%before(k + 1) = path%before(k) + int(nodes%super(supernode + 1) &
          - nodes%super(supernode))
      end associate
    end do
  end subroutine list_path

  !> First column of a supernode, how many, its rows, and where its values end.
  pure subroutine look_at(nodes, k, first, w, rows, last)
    type(supernodes_t), intent(in) :: nodes !! of a factor
    integer, intent(in) :: k !! the supernode
    integer, intent(out) :: first, w, rows !! first column, columns, rows
    integer(long), intent(out) :: last !! its last value

    first = int(nodes%super(k)) + 1
    w = int(nodes%super(k + 1) - nodes%super(k))
    rows = int(nodes%pi(k + 1) - nodes%pi(k))
    last = nodes%px(k) + int(rows, long)*w
  end subroutine look_at

  !> X = L^-1 E on a path, for the columns of the unit matrix that belong to some equations below.
  subroutine reduce_path(nodes, values, path, equation, x)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle, its values aside
    real(sp), intent(in), contiguous :: values(:) !! these, inverse blocks on the diagonal
    type(path_t), intent(in) :: path !! of the equations
    integer, intent(in) :: equation(:) !! (n) the equations
    real(sp), allocatable, intent(out) :: x(:, :) !! (columns of the path, n)
    real(sp), allocatable :: below(:, :)
    integer :: place(nodes%factor%n), j, k, w, rows, first, widest, n
    integer(long) :: last

    n = size(equation)
    widest = 0
    do k = 1, size(path%supernode)
      call look_at(nodes, path%supernode(k), first, w, rows, last)
      place(first:first + w - 1) = [(path%before(k) + j, j=1, w)]
      widest = max(widest, rows - w)
    end do
    allocate (x(path%before(size(path%before)), n), source=0.0_sp)
    allocate (below(widest, n))
    do j = 1, n
      x(place(equation(j)), j) = 1.0_sp
    end do
    do k = 1, size(path%supernode)
      call look_at(nodes, path%supernode(k), first, w, rows, last)
      associate (from => nodes%px(path%supernode(k)), row => place(nodes%s(nodes%pi( &
        path%supernode(k)) + w + 1:nodes%pi(path%supernode(k) + 1)) + 1))
        call reduce_square(w, rows, values(from + 1:last), n, size(x, 1), x(path%before(k) + 1, 1))
        if (rows == w) cycle
        call sgemm('N', 'N', rows - w, n, w, 1.0_sp, values(from + w + 1:last), rows, &
          x(path%before(k) + 1, 1), size(x, 1), 0.0_sp, below, widest)
        do j = 1, n
          x(row, j) = x(row, j) - below(:rows - w, j)
        end do
      end associate
    end do
  end subroutine reduce_path

  !> Y = L^-1 Y for the triangle of a supernode.
  subroutine reduce_square(w, rows, l, n, in_y, y)
    integer, intent(in) :: w !! its columns
    integer, intent(in) :: rows !! rows of the supernode
    real(sp), intent(in) :: l(rows, w) !! its values, inverse blocks on the diagonal
    integer, intent(in) :: n !! right-hand sides
    integer, intent(in) :: in_y !! rows that they are stored with
    real(sp), intent(inout) :: y(in_y, n) !! right-hand sides; solutions
    real(sp) :: part(block_width, n)
    integer :: c, columns, next

    do c = 1, w, block_width
      columns = min(block_width, w - c + 1)
      next = c + columns
      part(:columns, :) = y(c:next - 1, :)
      call sgemm('N', 'N', columns, n, columns, 1.0_sp, l(c, c), rows, part, block_width, 0.0_sp, &
        y(c, 1), in_y)
      if (next <= w) call sgemm('N', 'N', w - next + 1, n, columns, -1.0_sp, l(next, c), rows, &
        y(c, 1), in_y, 1.0_sp, y(next, 1), in_y)
    end do
  end subroutine reduce_square
end module elimination_paths

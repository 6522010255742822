!> Points at the same place: which they are, and how exactly a file tells where a point is.
module near_places
  use, intrinsic :: iso_fortran_env, only: real32
  use kinds, only: wp
  use key_sorting, only: sort_columns
  implicit none
  private
  public :: join_places, roundings, grid_t, start_grid, sort_grid

  !> Cells in which points are looked for, as a part of the size of all, and as a multiple of what
  !! two points at one place may be apart.
  real(wp), parameter :: cell_share = 1.0e-6_wp, cell_tolerances = 4.0_wp
  !> Files whose numbers have so many digits at most were written in single precision or short;
  integer, parameter :: most_digits = 9
  !> with fewer, each number was rounded by itself;
  integer, parameter :: least_single = 6
  !> with fewer still, the mesh is one of exact decimals (a gap of 0.01 beside 0.5 is meant).
  integer, parameter :: least_rounded = 4
  !> Digits of single precision.
  integer, parameter :: single_digits = 7
  !> What such a file is off by: a turn of the mesh in single precision costs four units in the last
  !! binary place of the largest coordinate.
  real(wp), parameter :: single_error = 4.0_wp*real(epsilon(1.0_real32), wp)
  !> Numbers of ten digits and more tell one of single precision to this part of it.
  real(wp), parameter :: written = 1.0e-9_wp
  !> A number has nine digits if nine of them leave less than this.
  real(wp), parameter :: left_over = 1.0e-5_wp

  !> Eight grids of cells, half a cell apart: points that are close share a cell of one at least.
  type :: grid_t
    real(wp) :: low(3) = 0.0_wp !! corner of the box around the points [length]
    real(wp) :: cell = 1.0_wp !! size of a cell [length]
  end type grid_t

contains

  !> Cells for points at most so far apart.
  pure type(grid_t) function start_grid(x, tolerance) result(grid)
    real(wp), intent(in) :: x(:, :) !! (3, n) the points [length]
    real(wp), intent(in) :: tolerance !! points closer than this are at one place [length]
    real(wp) :: extent

    if (size(x, 2) == 0) return
    grid%low = minval(x, 2)
    extent = norm2(maxval(x, 2) - grid%low)
    grid%cell = max(cell_share*extent, cell_tolerances*tolerance, tiny(1.0_wp))
  end function start_grid

  !> Cells of the points in one of the eight grids, and the order of the points by them.
  pure subroutine sort_grid(grid, number, x, keys, order)
    type(grid_t), intent(in) :: grid !! the cells
    integer, intent(in) :: number !! 0 to 7
    real(wp), intent(in) :: x(:, :) !! (3, n) the points [length]
    integer, intent(out) :: keys(:, :) !! (3, n) cell of each
    integer, allocatable, intent(out) :: order(:) !! (n) points of one cell stand together
    real(wp) :: half(3)
    integer :: i

    half = 0.5_wp*[(real(ibits(number, i, 1), wp), i=0, 2)]
    do i = 1, size(x, 2)
      keys(:, i) = int((x(:, i) - grid%low)/grid%cell + half)
    end do
    call sort_columns(keys, order)
  end subroutine sort_grid

  !> The first of the points at the place of each.
  pure subroutine join_places(x, tolerance, first)
    real(wp), intent(in) :: x(:, :) !! (3, n) points [length]
    real(wp), intent(in) :: tolerance !! closer points are at one place [length]
    integer, allocatable, intent(out) :: first(:) !! (n) lowest number at the place
    type(grid_t) :: grid
    integer, allocatable :: keys(:, :), order(:)
    integer :: number, i, j, a, b

    first = [(i, i=1, size(x, 2))]
    allocate (keys(3, size(x, 2)))
    grid = start_grid(x, tolerance)
    ! the same coordinates are in the same cell of any grid
    do number = 0, merge(7, 0, tolerance > 0.0_wp)
      call sort_grid(grid, number, x, keys, order)
      do i = 2, size(order)
        do j = i - 1, 1, -1
          if (any(keys(:, order(j)) /= keys(:, order(i)))) exit
          a = root(first, order(i))
          b = root(first, order(j))
          if (a == b) cycle
          if (norm2(x(:, order(i)) - x(:, order(j))) <= tolerance) first(max(a, b)) = min(a, b)
        end do
      end do
    end do
    do i = 1, size(first)
      first(i) = root(first, i)
    end do
  end subroutine join_places

  !> The point at the end of a chain.
  pure integer function root(first, i)
    integer, intent(in) :: first(:) !! next point of the chain
    integer, intent(in) :: i !! where it begins

    root = i
    do while (first(root) /= root)
      root = first(root)
    end do
  end function root

  !> What each coordinate may be off by, by the digits that all numbers of a file have. Long
  !! numbers: nothing. Six to nine digits: a unit in the last place of the largest coordinate, for
  !! such meshes are made or turned in single precision. Four or five: half a unit of each number,
  !! and what single precision leaves of a zero.
  pure function roundings(x) result(rounding)
    real(wp), intent(in) :: x(:, :) !! (3, n) coordinates as written [length]
    real(wp) :: rounding(3, size(x, 2)), largest
    integer :: digits, i, k

    rounding = 0.0_wp
    digits = digits_of(x)
    if (digits < least_rounded .or. digits > most_digits) return
    largest = maxval(abs(x))
    rounding = single_error*largest
    if (digits >= least_single) then
      rounding = max(rounding, unit_of(largest, digits))
      return
    end if
    do i = 1, size(x, 2)
      do k = 1, 3
        ! a number just below a power of ten may have been rounded from just above
        rounding(k, i) = max(rounding(k, i), 0.5_wp*unit_of(abs(x(k, i))*(1.0_wp + 10.0_wp**( &
          2 - digits)), digits))
      end do
    end do
  end function roundings

  !> One in the last place of a number of so many digits.
  pure real(wp) function unit_of(value, digits) result(unit)
    real(wp), intent(in) :: value !! at least 0
    integer, intent(in) :: digits !! significant ones

    unit = 0.0_wp
    if (value > tiny(1.0_wp)) unit = 10.0_wp**(floor(log10(value)) + 1 - digits)
  end function unit_of

  !> The digits of the longest number; ten if it has more than nine, and seven if all numbers are
  !! of single precision.
  pure integer function digits_of(x) result(digits)
    real(wp), intent(in) :: x(:, :) !! coordinates as written
    real(wp) :: scaled
    integer :: i, k, whole, n

    digits = 0
    do i = 1, size(x, 2)
      do k = 1, 3
        if (abs(x(k, i)) <= tiny(1.0_wp)) cycle
        scaled = abs(x(k, i))*10.0_wp**(most_digits - 1 - floor(log10(abs(x(k, i)))))
        whole = nint(scaled)
        n = most_digits + 1
        if (abs(scaled - real(whole, wp)) <= left_over) n = most_digits - zeros_of(whole)
        digits = max(digits, n)
        if (digits > most_digits) then
          if (is_single(x)) digits = single_digits
          return
        end if
      end do
    end do
  end function digits_of

  !> Zeros at the end of a number.
  pure integer function zeros_of(whole) result(n)
    integer, intent(in) :: whole !! above 0
    integer :: rest

    n = 0
    rest = whole
    do while (mod(rest, 10) == 0 .and. rest > 0)
      rest = rest/10
      n = n + 1
    end do
  end function zeros_of

  !> All numbers are of single precision, written with more digits than that has.
  pure logical function is_single(x)
    real(wp), intent(in) :: x(:, :) !! coordinates as written

    is_single = maxval(abs(x)) < real(huge(1.0_real32), wp)
    if (is_single) is_single = all(abs(real(real(x, real32), wp) - x) <= written*abs(x))
  end function is_single
end module near_places

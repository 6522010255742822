!> Products with the compliance of a body whose candidates are eliminated among its other nodes, by
!! its factor (doc/theory, "Implicit compliance", eqs. (12.8), (12.10)).
module tree_compliance
  use kinds, only: wp, sp, long
  use cholmod_solver, only: factor_work
  use supernodes, only: supernodes_of, supernodes_t, invert_blocks, reduce_double, &
    complete_double, reduce_single, complete_single
  use elimination_paths, only: find_path
  use near_field, only: form_near_field, near_diagonal, bytes_of_near_field
  use condensed_types, only: condensed_t, condensed_body_t
  implicit none
  private
  public :: may_pay, pays, form_tree, tree_bytes, has_trees, apply_tree, apply_tree_single

  !> Products and sums that a dense matrix takes in the time of an entry that is read, and products
  !! with the compliance of a run: what a body costs either way, in entries.
  real(wp), parameter :: work_of_entry = 25.0_wp, products = 300.0_wp
  !> Work of the near field over the columns of the factor above a candidate, for each candidate.
  real(wp), parameter :: patches_met = 600.0_wp
  !> Dense matrices with so few rows cost next to nothing.
  integer, parameter :: dense_rows = 2000
  !> Entries of a factor for each of its rows, at least, where bodies are large.
  real(wp), parameter :: least_row = 100.0_wp

contains

  !> Some body is such a one.
  pure logical function has_trees(condensed) result(has)
    type(condensed_t), intent(in) :: condensed !! its bodies

    has = any(condensed%bodies%tree%used)
  end function has_trees

  !> A body is worth to be analysed so: it cannot be told yet that a dense matrix costs less.
  pure logical function may_pay(n, m) result(may)
    integer, intent(in) :: n !! equations of the body
    integer, intent(in) :: m !! of its candidates

    may = m > dense_rows
    if (may) may = 2.0_wp*products*least_row*real(n, wp) < dense_cost(m)
  end function may_pay

  !> What a dense compliance costs: its factor, inverse, and products.
  pure real(wp) function dense_cost(m) result(cost)
    integer, intent(in) :: m !! candidates

    cost = real(m, wp)**3/work_of_entry + 0.5_wp*products*real(m, wp)**2
  end function dense_cost

  !> A body that is analysed so costs less than with a dense matrix.
  logical function pays(body) result(less)
    type(condensed_body_t), intent(in) :: body !! analysed, its candidates among the others
    real(wp) :: work, entries

    call factor_work(body%solver, work, entries)
    less = work/work_of_entry + 2.0_wp*products*entries + patches_met*real(body%m, wp)**2 &
      /work_of_entry < dense_cost(body%m)
  end function pays

  !> Memory that factor and near field will take [byte]: values in double and single precision.
  real(wp) function tree_bytes(body) result(bytes)
    type(condensed_body_t), intent(in) :: body !! analysed

    bytes = 1.5_wp*body%solver%factor_bytes() + bytes_of_near_field(body%m)
  end function tree_bytes

  !> The factor in single precision, and the compliance between candidates that are near each other.
  !! Values are over the largest pivot, so that no unit of the deck leaves the range of single
  !! precision.
  subroutine form_tree(x, body)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference coordinates [length]
    type(condensed_body_t), intent(inout) :: body !! factorised; gets tree, diagonal, softness
    type(supernodes_t) :: nodes

    nodes = supernodes_of(body%solver%factor)
    associate (tree => body%tree)
      if (allocated(tree%reached)) deallocate (tree%reached, tree%values)
      allocate (tree%reached(nodes%factor%nsuper))
      call find_path(nodes, body%equation, tree%reached)
      tree%root = 1.0_wp/largest_pivot(nodes)
      tree%values = real(tree%root*nodes%x, sp)
      call invert_blocks(nodes, 0, tree%values)
      call form_near_field(nodes, tree%values, tree%root**2, body%equation, &
        x(:, body%node(body%equation)), tree%near)
      body%diagonal = near_diagonal(tree%near)
      body%softness = sum(body%diagonal)/real(body%m, wp)
    end associate
  end subroutine form_tree

  !> The largest value on the diagonal of a factor: what stands above it has no meaning.
  pure real(wp) function largest_pivot(nodes) result(largest)
    type(supernodes_t), intent(in) :: nodes !! of the factor of a lower triangle
    integer(long) :: k, j, rows

    largest = 0.0_wp
    do k = 1, size(nodes%super, kind=long) - 1
      rows = nodes%pi(k + 1) - nodes%pi(k)
      do j = 0, nodes%super(k + 1) - nodes%super(k) - 1
        largest = max(largest, nodes%x(nodes%px(k) + rows*j + j + 1))
      end do
    end do
  end function largest_pivot

  !> y = C x between some candidates.
  subroutine apply_tree(body, candidate, x, y)
    type(condensed_body_t), intent(in) :: body !! its factor and tree
    integer, intent(in) :: candidate(:) !! (n) which
    real(wp), intent(in) :: x(:) !! (n) [force]
    real(wp), intent(out) :: y(:) !! (n) [length]
    type(supernodes_t) :: nodes
    real(wp) :: values(size(body%node))

    nodes = supernodes_of(body%solver%factor)
    values = 0.0_wp
    values(body%equation(candidate)) = x
    call reduce_double(nodes, 0, values, body%tree%reached)
    call complete_double(nodes, 0, values, body%tree%reached)
    y = values(body%equation(candidate))
  end subroutine apply_tree

  !> The same in single precision, in the unit of the body's softness.
  subroutine apply_tree_single(body, candidate, x, y)
    type(condensed_body_t), intent(in) :: body !! its tree
    integer, intent(in) :: candidate(:) !! (n) which
    real(sp), intent(in) :: x(:) !! (n)
    real(sp), intent(out) :: y(:) !! (n)
    type(supernodes_t) :: nodes
    real(wp) :: values(size(body%node))

    nodes = supernodes_of(body%solver%factor)
    values = 0.0_wp
    values(body%equation(candidate)) = x
    call reduce_single(nodes, body%tree%values, 0, values, body%tree%reached)
    call complete_single(nodes, body%tree%values, 0, values, body%tree%reached)
    y = real(body%tree%root**2/body%softness*values(body%equation(candidate)), sp)
  end subroutine apply_tree_single
end module tree_compliance

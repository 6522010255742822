!> Element matrices of contact summed at the live candidates, by columns, and the few columns for
!! each node, or each element, that count (doc/theory, "Contact operator of low rank").
module contact_sums
  use kinds, only: wp
  use lapack_interface, only: dsyev
  use vectors, only: identity
  use condensed_types, only: condensed_t, contact_tangent_t, columns_t
  use sparse_columns, only: append, number_new, add_product, take_product
  use low_rank, only: peel, largest_weighed
  implicit none
  private
  public :: sum_elements, add_whole_rest, live_roots, peel_nodes, peel_elements, &
    take_held, take_shares, add_leading, is_loose

  !> Columns that an element matrix may have.
  integer, parameter :: most_element_columns = 6

contains

  !> The sum of the element matrices at hand. Points that act on the same degrees of freedom one
  !! after the other, as those of a cell do, are added up first.
  subroutine sum_elements(tangent, n_live, sum)
    type(contact_tangent_t), intent(in) :: tangent !! closed elements and their matrices
    integer, intent(in) :: n_live !! live candidates
    type(columns_t), intent(inout) :: sum !! gets the columns that elements touch
    integer :: first(n_live + 1), mark(n_live), rows(n_live), j, l, n
    integer, allocatable :: owner(:), local(:), element(:)
    real(wp), allocatable :: s(:, :, :)
    real(wp) :: w(n_live)

    call add_runs(tangent, element, s)
    call list_by_dof(tangent%dofs, element, first, owner, local)
    sum%column = pack([(j, j=1, n_live)], first(2:) > first(:n_live))
    sum%n = size(sum%column)
    sum%start = spread(1, 1, sum%n + 1)
    mark = 0
    do j = 1, sum%n
      n = 0
      do l = first(sum%column(j)), first(sum%column(j) + 1) - 1
        call add_column(tangent%dofs(:, element(owner(l))), s(:, local(l), owner(l)), j, mark, &
          rows, n, w)
      end do
      call append(sum, j, rows(:n), w(rows(:n)))
    end do
  end subroutine sum_elements

  !> Adds a column of an element's matrix to that of the sum.
  pure subroutine add_column(dofs, column, j, mark, rows, n, w)
    integer, intent(in), contiguous :: dofs(:) !! live candidates of its rows, 0 for none
    real(wp), intent(in), contiguous :: column(:) !! its entries
    integer, intent(in) :: j !! number of the column of the sum
    integer, intent(inout) :: mark(:) !! (live) the last column that has had a row there
    integer, intent(inout) :: rows(:) !! rows of this one, n of them
    integer, intent(inout) :: n !! how many
    real(wp), intent(inout) :: w(:) !! (live) the column of the sum
    integer :: i

    do i = 1, size(dofs)
      associate (k => dofs(i))
        if (k == 0) cycle
        if (mark(k) == j) then
          w(k) = w(k) + column(i)
        else
          mark(k) = j
          n = n + 1
          rows(n) = k
          w(k) = column(i)
        end if
      end associate
    end do
  end subroutine add_column

  !> The sums of the matrices of closed elements one after the other that act on the same degrees of
  !! freedom: a run.
  subroutine add_runs(tangent, element, s)
    type(contact_tangent_t), intent(in) :: tangent !! closed elements, their matrices
    integer, allocatable, intent(out) :: element(:) !! (runs) place in the list of one of the run
    real(wp), allocatable, intent(out) :: s(:, :, :) !! (dofs, dofs, runs) sums
    integer :: e, runs, run(tangent%elements)

    runs = 0
    do e = 1, tangent%elements
      associate (k => tangent%element(e), before => tangent%element(max(1, e - 1)))
        if (e == 1 .or. any(tangent%dofs(:, k) /= tangent%dofs(:, before))) runs = runs + 1
      end associate
      run(e) = runs
    end do
    allocate (element(runs), s(size(tangent%dofs, 1), size(tangent%dofs, 1), runs))
    do e = 1, tangent%elements
      associate (r => run(e), before => run(max(1, e - 1)))
        element(r) = tangent%element(e)
        if (e == 1 .or. r > before) then
          s(:, :, r) = tangent%s(:, :, element(r))
        else
          s(:, :, r) = s(:, :, r) + tangent%s(:, :, element(r))
        end if
      end associate
    end do
  end subroutine add_runs

  !> The places in the runs of each live candidate.
  subroutine list_by_dof(dofs, element, first, owner, local)
    integer, intent(in) :: dofs(:, :) !! (dofs of an element, list) live candidates, 0 for none
    integer, intent(in) :: element(:) !! (runs) place in the list of one of the run
    integer, intent(out) :: first(:) !! (live+1) where the places of each begin
    integer, allocatable, intent(out) :: owner(:) !! run
    integer, allocatable, intent(out) :: local(:) !! number in its elements
    integer :: r, i, next(size(first) - 1)

    first = 0
    do r = 1, size(element)
      do i = 1, size(dofs, 1)
        associate (dof => dofs(i, element(r)))
          if (dof > 0) first(dof + 1) = first(dof + 1) + 1
        end associate
      end do
    end do
    first(1) = 1
    do i = 1, size(next)
      first(i + 1) = first(i) + first(i + 1)
    end do
    next = first(:size(next))
    allocate (owner(first(size(first)) - 1), local(first(size(first)) - 1))
    do r = 1, size(element)
      do i = 1, size(dofs, 1)
        associate (dof => dofs(i, element(r)))
          if (dof == 0) cycle
          owner(next(dof)) = r
          local(next(dof)) = i
          next(dof) = next(dof) + 1
        end associate
      end do
    end do
  end subroutine list_by_dof

  !> Roots of the compliances of the live candidates, which weigh what is peeled.
  pure function live_roots(condensed) result(root)
    type(condensed_t), intent(in) :: condensed !! live compliances
    real(wp) :: root(condensed%alive%n_live)
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%n_live > 0) root(body%first_live + 1:body%first_live + body%n_live) = &
          sqrt(body%diagonal(body%gathered))
      end associate
    end do
  end function live_roots

  !> Live candidates of bodies that supports do not hold: a rigid motion has no compliance against
  !! which a contact point could be too soft to count.
  pure elemental logical function is_loose(condensed, candidate) result(loose)
    type(condensed_t), intent(in) :: condensed !! bodies with their motions
    integer, intent(in) :: candidate !! live candidate, 0 for none
    integer :: b

    loose = .false.
    do b = 1, size(condensed%bodies)
      associate (first => condensed%bodies(b)%first_live, n => condensed%bodies(b)%n_live)
        if (candidate > first .and. candidate <= first + n) loose = &
          condensed%bodies(b)%motions%n > 0
      end associate
    end do
  end function is_loose

  !> The leading columns of the sum: at each node those of its directions, on principal axes, in
  !! which contact resists by more than the tolerance, each entry weighed with the roots of the
  !! compliances of its row and column.
  subroutine peel_nodes(condensed, tangent, tolerance)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! sum given; gets rank, lead, held, hold
    real(wp), intent(in) :: tolerance !! weighed columns below this do not count
    real(wp) :: root(condensed%alive%n_live)
    logical :: loose(condensed%alive%n_live)
    integer :: first, last, place(condensed%alive%n_live)

    root = live_roots(condensed)
    loose = is_loose(condensed, [(first, first=1, condensed%alive%n_live)])
    associate (sum => tangent%sum, node => condensed%node(condensed%alive%live(tangent%sum%column)))
      tangent%rank = 0
      tangent%held = reshape([integer ::], [3, sum%n], [0])
      tangent%hold = reshape([real(wp) ::], [3, sum%n], [0.0_wp])
      tangent%lead%start = spread(1, 1, sum%n + 1)
      place = 0
      first = 1
      do while (first <= sum%n)
        last = first
        do while (last < sum%n)
          if (node(last + 1) /= node(first)) exit
          last = last + 1
        end do
        call peel_node(first, last, root, loose, tolerance, place, tangent)
        first = last + 1
      end do
      tangent%lead%n = tangent%rank
      tangent%complete = tangent%rank == sum%n
    end associate
  end subroutine peel_nodes

  !> The leading columns of one node; all of them as they are, if all count.
  subroutine peel_node(first, last, root, loose, tolerance, place, tangent)
    integer, intent(in) :: first, last !! its columns of the sum, at most 3
    real(wp), intent(in) :: root(:) !! (live) root of the compliance [(length/force)^1/2]
    logical, intent(in) :: loose(:) !! (live) of bodies that supports do not hold
    real(wp), intent(in) :: tolerance !! weighed columns below this do not count
    integer, intent(inout) :: place(:) !! (live) zeros
    type(contact_tangent_t), intent(inout) :: tangent !! sum given; rank, lead, held, hold grow
    integer, allocatable :: row(:)
    real(wp), allocatable :: column(:, :), weighed(:, :)
    real(wp) :: axes(3, 3), square(3), scale(last - first + 1), work(20), least
    integer :: n, k, info

    n = last - first + 1
    call gather_rows(tangent%sum, first, last, place, row, column)
    associate (mine => tangent%sum%column(first:last))
      weighed = column*spread(root(row), 2, n)*spread(root(mine), 1, size(row))
      axes(:n, :n) = matmul(transpose(weighed), weighed)
      call dsyev('V', 'U', n, axes, 3, square, work, size(work), info)
      least = tolerance**2
      if (any(loose(row))) least = least*min(1.0_wp, square(n))
      scale = root(mine)
      if (minval(square(:n)) > least) then
        scale = 1.0_wp
        axes = identity
      end if
      do k = 1, n
        if (square(k) <= least) cycle
        tangent%rank = tangent%rank + 1
        tangent%held(:n, tangent%rank) = mine
        tangent%hold(:n, tangent%rank) = axes(:n, k)/scale
        call append(tangent%lead, tangent%rank, row, matmul(column, scale*axes(:n, k)))
      end do
    end associate
  end subroutine peel_node

  !> Some columns as full ones on the rows that any of them has.
  subroutine gather_rows(sum, first, last, place, row, column)
    type(columns_t), intent(in) :: sum !! the columns
    integer, intent(in) :: first, last !! those wanted
    integer, intent(inout) :: place(:) !! (live) zeros
    integer, allocatable, intent(out) :: row(:) !! live candidates of the rows
    real(wp), allocatable, intent(out) :: column(:, :) !! (rows, columns)
    integer :: i, j, n

    associate (all => sum%row(sum%start(first):sum%start(last + 1) - 1))
      allocate (row(size(all)))
      n = 0
      call number_new(all, place, row, n)
    end associate
    row = row(:n)
    allocate (column(n, last - first + 1), source=0.0_wp)
    do j = first, last
      do i = sum%start(j), sum%start(j + 1) - 1
        column(place(sum%row(i)), j - first + 1) = sum%value(i)
      end do
    end do
    place(row) = 0
  end subroutine gather_rows

  !> z = V^T d of the columns of nodes.
  pure subroutine take_held(tangent, d, z)
    type(contact_tangent_t), intent(in) :: tangent !! held, hold
    real(wp), intent(in) :: d(:) !! (live) [length]
    real(wp), intent(out) :: z(:) !! (rank)
    integer :: j, i

    do j = 1, tangent%rank
      z(j) = 0.0_wp
      do i = 1, 3
        if (tangent%held(i, j) > 0) z(j) = z(j) + tangent%hold(i, j)*d(tangent%held(i, j))
      end do
    end do
  end subroutine take_held

  !> z = V^T d of the whole form.
  pure subroutine take_whole(tangent, d, z)
    type(contact_tangent_t), intent(in) :: tangent !! its columns
    real(wp), intent(in) :: d(:) !! (live) [length]
    real(wp), intent(out) :: z(:) !! (rank)

    if (tangent%parts%grouped) then
      call take_product(tangent%taken, d, z)
    else
      call take_held(tangent, d, z)
    end if
  end subroutine take_whole

  !> Adds K x - U V^T x with the sum K of the present element matrices.
  pure subroutine add_whole_rest(tangent, x, y, shares)
    type(contact_tangent_t), intent(in) :: tangent !! sums, columns
    real(wp), intent(in) :: x(:) !! (live) [length]
    real(wp), intent(inout) :: y(:) !! (live) [force]
    real(wp), intent(in), optional :: shares(:) !! (rank) V^T x, if it is known [length]
    real(wp) :: z(tangent%rank)

    if (tangent%fresh) then
      if (tangent%complete) return
      call add_product(tangent%sum, x(tangent%sum%column), y)
    else
      call add_product(tangent%now, x(tangent%now%column), y)
    end if
    if (present(shares)) then
      z = shares
    else
      call take_whole(tangent, x, z)
    end if
    call add_product(tangent%lead, -z, y)
  end subroutine add_whole_rest

  !> z = V^T d.
  pure subroutine take_shares(tangent, d, z)
    type(contact_tangent_t), intent(in) :: tangent !! its columns
    real(wp), intent(in) :: d(:) !! (live) [length]
    real(wp), intent(out) :: z(:) !! (rank)
    real(wp) :: moved(0:size(d))
    integer :: j

    if (tangent%whole) then
      call take_whole(tangent, d, z)
      return
    end if
    moved(0) = 0.0_wp
    moved(1:) = d
    do j = 1, tangent%rank
      z(j) = share_of(size(tangent%dofs, 1), tangent%dofs(:, tangent%owner(j)), tangent%v(:, j), &
        moved)
    end do
  end subroutine take_shares

  !> A column of V^T d.
  pure real(wp) function share_of(n, dofs, v, moved) result(share)
    integer, intent(in) :: n !! degrees of freedom of an element
    integer, intent(in) :: dofs(n) !! live candidates, 0 for none
    real(wp), intent(in) :: v(n) !! the column
    real(wp), intent(in) :: moved(0:) !! (0:live) d, and 0 for none [length]
    integer :: i

    share = 0.0_wp
    do i = 1, n
      share = share + v(i)*moved(dofs(i))
    end do
  end function share_of

  !> Adds U z to y.
  pure subroutine add_leading(tangent, z, y)
    type(contact_tangent_t), intent(in) :: tangent !! its columns
    real(wp), intent(in) :: z(:) !! (rank)
    real(wp), intent(inout) :: y(:) !! (live) [force]
    integer :: j, i

    if (tangent%whole) then
      call add_product(tangent%lead, z(:tangent%rank), y)
      return
    end if
    do j = 1, tangent%rank
      associate (dofs => tangent%dofs(:, tangent%owner(j)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) y(dofs(i)) = y(dofs(i)) + tangent%u(i, j)*z(j)
        end do
      end associate
    end do
  end subroutine add_leading

  !> Takes the leading columns of each element matrix.
  subroutine peel_elements(condensed, tangent, negligible)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! gets rank, owner, u, v
    real(wp), intent(in) :: negligible !! matrix times compliance that may be left
    real(wp) :: weight(size(tangent%s, 1)), root(condensed%alive%n_live), tolerance
    integer :: e, i, rank

    if (.not. allocated(tangent%owner)) then
      allocate (tangent%owner(most_element_columns*size(tangent%element)), &
        tangent%u(size(tangent%s, 1), most_element_columns*size(tangent%element)), &
        tangent%v(size(tangent%s, 1), most_element_columns*size(tangent%element)))
    end if
    root = live_roots(condensed)
    tangent%rank = 0
    do e = 1, tangent%elements
      weight = 0.0_wp
      associate (n => tangent%rank, dofs => tangent%dofs(:, tangent%element(e)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) weight(i) = root(dofs(i))
        end do
        tolerance = negligible
        if (any(is_loose(condensed, dofs))) tolerance = negligible*min(1.0_wp, &
          largest_weighed(tangent%s(:, :, tangent%element(e)), weight))
        call peel(tangent%s(:, :, tangent%element(e)), weight, tolerance, tangent%u(:, n + 1:n + &
          most_element_columns), tangent%v(:, n + 1:n + most_element_columns), rank)
        tangent%owner(n + 1:n + rank) = tangent%element(e)
        n = n + rank
      end associate
    end do
  end subroutine peel_elements
end module contact_sums

!> The columns of contact for overlapping blocks. Where points are many for the nodes they act on,
!! those near each other form a group: the sum of their matrices has fewer columns than these have
!! together (doc/theory, "Contact operator of low rank").
module contact_groups
  use kinds, only: wp
  use low_rank, only: peel, largest_weighed
  use condensed_types, only: condensed_t, contact_tangent_t, columns_t
  use contact_sums, only: live_roots, is_loose
  use sparse_columns, only: append, number_new
  use part_halving, only: split_part
  use system_types, only: system_t
  implicit none
  private
  public :: peel_groups, list_columns, place_elements, place_rows

  !> Degrees of freedom that the points of a group act on, at most.
  integer, parameter :: most_dofs = 96
  !> Weighed entries of a column that are left to the rest, over those columns that do not count.
  real(wp), parameter :: faint = 0.1_wp

contains

  !> Where the closed elements are: the mean of their nodes.
  pure subroutine place_elements(system, condensed, x, place)
    type(system_t), intent(in) :: system !! contact elements, closed ones listed
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(out) :: place(:, :) !! (3, elements) [length]
    integer :: e

    associate (list => system%contact)
      do e = 1, condensed%tangent%elements
        associate (k => condensed%tangent%element(e))
          associate (nodes => list%ix(1:list%nel(k), k))
            place(:, e) = sum(x(:, nodes) + system%u(:, nodes), 2)/real(size(nodes), wp)
          end associate
        end associate
      end do
    end associate
  end subroutine place_elements

  !> Where each row is: at the node where its column of U is largest.
  pure subroutine place_rows(u, condensed, x, place)
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(out) :: place(:, :) !! (3, rank) [length]
    integer :: j

    associate (lead => condensed%tangent%lead)
      do j = 1, lead%n
        associate (row => lead%row(lead%start(j):lead%start(j + 1) - 1))
          associate (node => condensed%node(condensed%alive%live(row(maxloc( &
            abs(lead%value(lead%start(j):lead%start(j + 1) - 1)), 1)))))
            place(:, j) = x(:, node) + u(:, node)
          end associate
        end associate
      end do
    end associate
  end subroutine place_rows

  !> The leading columns of groups of elements side by side, halved until they touch few degrees of
  !! freedom.
  subroutine peel_groups(condensed, tangent, place, negligible)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! elements; gets rank, lead, taken
    real(wp), intent(in) :: place(:, :) !! (3, elements) [length]
    real(wp), intent(in) :: negligible !! weighed entries below this do not count
    integer :: order(tangent%elements), ends(tangent%elements), mark(condensed%alive%n_live)
    real(wp) :: root(condensed%alive%n_live)
    integer :: e, k, first, groups

    order = [(e, e=1, size(order))]
    groups = 0
    mark = 0
    if (size(order) > 0) call halve_elements(tangent, place, 1, size(order), order, mark, ends, &
      groups)
    root = live_roots(condensed)
    call begin_columns(tangent%lead)
    call begin_columns(tangent%taken)
    first = 1
    do k = 1, groups
      call peel_group(condensed, tangent, order(first:ends(k)), root, negligible, mark)
      first = ends(k) + 1
    end do
    tangent%rank = tangent%lead%n
    tangent%complete = .false.
  end subroutine peel_groups

  !> No column.
  pure subroutine begin_columns(columns)
    type(columns_t), intent(inout) :: columns !! begins

    columns%n = 0
    columns%start = [1]
  end subroutine begin_columns

  !> Halves a part until its elements touch few degrees of freedom.
  pure recursive subroutine halve_elements(tangent, place, first, last, order, mark, ends, groups)
    type(contact_tangent_t), intent(in) :: tangent !! elements
    real(wp), intent(in) :: place(:, :) !! (3, elements) [length]
    integer, intent(in) :: first, last !! the part in order
    integer, intent(inout) :: order(:) !! (elements) is sorted
    integer, intent(inout) :: mark(:) !! (live) zeros
    integer, intent(inout) :: ends(:) !! where finished groups end in order
    integer, intent(inout) :: groups !! finished groups
    integer, allocatable :: touched(:)
    integer :: split

    split = last
    call list_touched(tangent, order(first:last), mark, touched)
    mark(touched) = 0
    if (size(touched) > most_dofs) call split_part(place, first, last, order, split)
    if (split == last) then
      groups = groups + 1
      ends(groups) = last
    else
      call halve_elements(tangent, place, first, split, order, mark, ends, groups)
      call halve_elements(tangent, place, split + 1, last, order, mark, ends, groups)
    end if
  end subroutine halve_elements

  !> The live candidates that some elements touch, numbered.
  pure subroutine list_touched(tangent, mine, mark, touched)
    type(contact_tangent_t), intent(in) :: tangent !! elements
    integer, intent(in) :: mine(:) !! numbers of the elements
    integer, intent(inout) :: mark(:) !! (live) zeros; gets the number in touched
    integer, allocatable, intent(out) :: touched(:) !! live candidates
    integer :: e, n

    allocate (touched(size(tangent%dofs, 1)*size(mine)))
    n = 0
    do e = 1, size(mine)
      call number_new(tangent%dofs(:, tangent%element(mine(e))), mark, touched, n)
    end do
    touched = touched(:n)
  end subroutine list_touched

  !> The leading columns of the sum of some elements.
  subroutine peel_group(condensed, tangent, mine, root, negligible, mark)
    type(condensed_t), intent(in) :: condensed !! bodies
    type(contact_tangent_t), intent(inout) :: tangent !! elements; lead and taken grow
    integer, intent(in) :: mine(:) !! numbers of the elements
    real(wp), intent(in) :: root(:) !! (live) root of the compliance [(length/force)^1/2]
    real(wp), intent(in) :: negligible !! weighed entries below this do not count
    integer, intent(inout) :: mark(:) !! (live) zeros
    integer, allocatable :: touched(:)
    real(wp), allocatable :: sum(:, :), u(:, :), v(:, :)
    real(wp) :: tolerance
    integer :: k, rank

    call list_touched(tangent, mine, mark, touched)
    allocate (sum(size(touched), size(touched)), source=0.0_wp)
    do k = 1, size(mine)
      call add_matrix(tangent, tangent%element(mine(k)), mark, sum)
    end do
    mark(touched) = 0
    tolerance = negligible
    if (any(is_loose(condensed, touched))) tolerance = negligible*min(1.0_wp, &
      largest_weighed(sum, root(touched)))
    allocate (u(size(touched), size(touched)), v(size(touched), size(touched)))
    call peel(sum, root(touched), tolerance, u, v, rank)
    associate (w => root(touched), least => faint*tolerance)
      do k = 1, rank
        call add_column(tangent%lead, merge(touched, 0, abs(u(:, k))*w*maxval(abs(v(:, k))*w) &
          > least), u(:, k))
        call add_column(tangent%taken, merge(touched, 0, abs(v(:, k))*w*maxval(abs(u(:, k))*w) &
          > least), v(:, k))
      end do
    end associate
  end subroutine peel_group

  !> Adds the matrix of an element to that of its group.
  pure subroutine add_matrix(tangent, k, mark, sum)
    type(contact_tangent_t), intent(in) :: tangent !! element matrices
    integer, intent(in) :: k !! place of the element in the list
    integer, intent(in) :: mark(:) !! (live) number in the group
    real(wp), intent(inout) :: sum(:, :) !! grows [force/length]
    integer :: i, j

    associate (dofs => tangent%dofs(:, k))
      do j = 1, size(dofs)
        if (dofs(j) == 0) cycle
        do i = 1, size(dofs)
          if (dofs(i) > 0) sum(mark(dofs(i)), mark(dofs(j))) = &
            sum(mark(dofs(i)), mark(dofs(j))) + tangent%s(i, j, k)
        end do
      end do
    end associate
  end subroutine add_matrix

  !> One column more.
  subroutine add_column(columns, row, value)
    type(columns_t), intent(inout) :: columns !! grows
    integer, intent(in) :: row(:) !! live candidates, 0 for none
    real(wp), intent(in) :: value(:) !! entries
    integer, allocatable :: start(:)

    if (columns%n + 2 > size(columns%start)) then
      allocate (start(2*size(columns%start) + 1))
      start(:columns%n + 1) = columns%start(:columns%n + 1)
      call move_alloc(start, columns%start)
    end if
    columns%n = columns%n + 1
    call append(columns, columns%n, pack(row, row > 0), pack(value, row > 0))
  end subroutine add_column

  !> The columns of single elements in the same form.
  subroutine list_columns(tangent)
    type(contact_tangent_t), intent(inout) :: tangent !! u, v given; gets lead, taken
    integer :: j

    call begin_columns(tangent%lead)
    call begin_columns(tangent%taken)
    do j = 1, tangent%rank
      associate (dofs => tangent%dofs(:, tangent%owner(j)))
        call add_column(tangent%lead, dofs, tangent%u(:, j))
        call add_column(tangent%taken, dofs, tangent%v(:, j))
      end associate
    end do
  end subroutine list_columns
end module contact_groups

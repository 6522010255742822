!> Overlapping blocks of the rows of contact: where these are many, the inverses of the blocks stand
!! in for that of the whole matrix I + V^T C U (doc/theory, "Condensed contact").
module contact_blocks
  use kinds, only: wp
  use lapack_interface, only: dgetrf, dgetrs
  use back_ends, only: solver_done, solver_singular
  use condensed_types, only: condensed_t, contact_tangent_t, contact_block_t
  use system_types, only: system_t
  implicit none
  private
  public :: form_blocks, precondition

  !> Rows of a block without its overlap: one in forty of all, within these bounds.
  integer, parameter :: fewest_rows = 64, most_rows = 256, share_of_rows = 40
  !> How far a block reaches beyond its own points, in distances of points.
  real(wp), parameter :: overlap = 2.0_wp
  !> Rows of a block with its overlap over those without, at most; the reach is lessened until then.
  integer, parameter :: most_growth = 3
  real(wp), parameter :: shrinkage = 0.8_wp

contains

  !> Divides the rows of the tangent, factorises the blocks and what they make of the rigid motions.
  subroutine form_blocks(system, x, outcome)
    type(system_t), intent(inout) :: system !! columns of its tangent given; gets blocks
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! done or singular
    real(wp) :: place(3, system%condensed%tangent%elements)
    integer :: k, worst

    associate (condensed => system%condensed, tangent => system%condensed%tangent)
      call start_rows(system, x, place)
      call divide_rows(tangent, place, system%scale%facet_size)
      if (allocated(tangent%parts%weight)) deallocate (tangent%parts%weight)
      allocate (tangent%parts%weight(tangent%rank), source=1.0_wp)
      worst = solver_done
      do k = 1, size(tangent%parts%blocks)
        call factorise_block(condensed, tangent, tangent%parts%blocks(k), outcome)
        worst = max(worst, outcome)
      end do
      outcome = worst
      if (outcome == solver_done .and. tangent%modes > 0) call border_blocks(condensed, tangent, &
        outcome)
    end associate
  end subroutine form_blocks

  !> Where the rows of each element begin, and where the element is.
  pure subroutine start_rows(system, x, place)
    type(system_t), intent(inout) :: system !! contact elements; tangent gets start
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(out) :: place(:, :) !! (3, elements) mean of its nodes [length]
    integer :: e, j

    associate (tangent => system%condensed%tangent, list => system%contact)
      tangent%parts%start = spread(0, 1, tangent%elements + 1)
      j = 0
      do e = 1, tangent%elements
        tangent%parts%start(e) = j
        do while (j < tangent%rank)
          if (tangent%owner(j + 1) /= tangent%element(e)) exit
          j = j + 1
        end do
        associate (nodes => list%ix(1:list%nel(tangent%element(e)), tangent%element(e)))
          place(:, e) = sum(x(:, nodes) + system%u(:, nodes), 2)/real(size(nodes), wp)
        end associate
      end do
      tangent%parts%start(tangent%elements + 1) = j
    end associate
  end subroutine start_rows

  !> Elements side by side, halved until a part has few rows; a block is a part with what is near.
  pure subroutine divide_rows(tangent, place, size_of_facet)
    type(contact_tangent_t), intent(inout) :: tangent !! start given; gets blocks
    real(wp), intent(in) :: place(:, :) !! (3, elements) [length]
    real(wp), intent(in) :: size_of_facet !! mean [length]
    integer :: order(size(place, 2)), last(size(place, 2)), parts, k, first, e
    real(wp) :: low(3), high(3), reach

    order = [(e, e=1, size(order))]
    parts = 0
    call halve(place, tangent%parts%start, max(fewest_rows, min(most_rows, &
      tangent%rank/share_of_rows)), &
      1, size(order), order, last, parts)
    if (allocated(tangent%parts%blocks)) deallocate (tangent%parts%blocks)
    allocate (tangent%parts%blocks(parts))
    first = 1
    do k = 1, parts
      associate (own => order(first:last(k)))
        low = minval(place(:, own), 2)
        high = maxval(place(:, own), 2)
        reach = overlap*max(maxval(high - low)/sqrt(real(size(own), wp)), 0.5_wp*size_of_facet)
        do
          call list_rows(tangent, place, low - reach, high + reach, own, tangent%parts%blocks(k))
          if (size(tangent%parts%blocks(k)%row) <= &
            most_growth*count(tangent%parts%blocks(k)%own)) exit
          reach = shrinkage*reach
        end do
      end associate
      first = last(k) + 1
    end do
  end subroutine divide_rows

  !> Halves a part across its longest side until it has few rows.
  pure recursive subroutine halve(place, start, most, first, last, order, ends, parts)
    real(wp), intent(in) :: place(:, :) !! (3, elements) [length]
    integer, intent(in) :: start(:) !! (elements+1) rows before each element
    integer, intent(in) :: most !! rows
    integer, intent(in) :: first, last !! the part in order
    integer, intent(inout) :: order(:) !! (elements) is sorted
    integer, intent(inout) :: ends(:) !! where finished parts end in order
    integer, intent(inout) :: parts !! finished parts
    real(wp) :: low(3), high(3), middle
    integer :: axis, split

    associate (mine => order(first:last))
      low = minval(place(:, mine), 2)
      high = maxval(place(:, mine), 2)
      axis = maxloc(high - low, 1)
      middle = 0.5_wp*(low(axis) + high(axis))
      split = first - 1 + count(place(axis, mine) <= middle)
      if (sum(start(mine + 1) - start(mine)) > most .and. split < last) then
        order(first:last) = [pack(mine, place(axis, mine) <= middle), &
          pack(mine, place(axis, mine) > middle)]
      else
        split = last
      end if
    end associate
    if (split == last) then
      parts = parts + 1
      ends(parts) = last
    else
      call halve(place, start, most, first, split, order, ends, parts)
      call halve(place, start, most, split + 1, last, order, ends, parts)
    end if
  end subroutine halve

  !> The rows of all elements within a box.
  pure subroutine list_rows(tangent, place, low, high, own, block)
    type(contact_tangent_t), intent(in) :: tangent !! start given
    real(wp), intent(in) :: place(:, :) !! (3, elements) [length]
    real(wp), intent(in) :: low(3), high(3) !! the box [length]
    integer, intent(in) :: own(:) !! elements of the block itself
    type(contact_block_t), intent(out) :: block !! gets row, own
    logical :: within(size(place, 2)), is_own(size(place, 2))
    integer :: e, j, n

    within = all(place >= spread(low, 2, size(within)) .and. place <= spread(high, 2, &
      size(within)), 1)
    is_own = .false.
    is_own(own) = .true.
    n = sum(tangent%parts%start(2:) - tangent%parts%start(:size(within)), within)
    allocate (block%row(n), block%own(n), block%pivot(n), block%factor(n, n))
    n = 0
    do e = 1, size(within)
      if (.not. within(e)) cycle
      do j = tangent%parts%start(e) + 1, tangent%parts%start(e + 1)
        n = n + 1
        block%row(n) = j
        block%own(n) = is_own(e)
      end do
    end do
  end subroutine list_rows

  !> The block's part of I + V^T C U, transposed and factorised.
  subroutine factorise_block(condensed, tangent, block, outcome)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! columns; gets weights
    type(contact_block_t), intent(inout) :: block !! row given; gets factor
    integer, intent(out) :: outcome !! done or singular
    integer :: local(condensed%alive%n_live), j, i, info
    real(wp), allocatable :: c(:, :), cu(:, :)

    call find_block_dofs(tangent, block, local)
    allocate (c(maxval(local), maxval(local)), cu(maxval(local), size(block%row)))
    call gather_block(condensed, local, c)
    do j = 1, size(block%row)
      associate (row => block%row(j), dofs => tangent%dofs(:, tangent%owner(block%row(j))))
        cu(:, j) = 0.0_wp
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) cu(:, j) = cu(:, j) + tangent%u(i, row)*c(:, local(dofs(i)))
        end do
      end associate
    end do
    c = transpose(cu)
    block%factor = 0.0_wp
    do j = 1, size(block%row)
      associate (row => block%row(j), dofs => tangent%dofs(:, tangent%owner(block%row(j))), &
        column => block%factor(:, j))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) column = column + tangent%v(i, row)*c(:, local(dofs(i)))
        end do
        column(j) = column(j) + 1.0_wp
        if (block%own(j)) tangent%parts%weight(row) = maxval(abs(tangent%u(:, row)))/abs(column(j))
      end associate
    end do
    call dgetrf(size(block%row), size(block%row), block%factor, size(block%row), block%pivot, info)
    outcome = merge(solver_done, solver_singular, info == 0)
  end subroutine factorise_block

  !> Numbers the live candidates that the rows of a block touch.
  pure subroutine find_block_dofs(tangent, block, local)
    type(contact_tangent_t), intent(in) :: tangent !! columns
    type(contact_block_t), intent(in) :: block !! its rows
    integer, intent(out) :: local(:) !! (live) number in the block, 0 for none
    integer :: j, i, n

    local = 0
    do j = 1, size(block%row)
      associate (dofs => tangent%dofs(:, tangent%owner(block%row(j))))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) > 0) local(dofs(i)) = 1
        end do
      end associate
    end do
    n = 0
    do i = 1, size(local)
      if (local(i) == 0) cycle
      n = n + 1
      local(i) = n
    end do
  end subroutine find_block_dofs

  !> The compliance between the live candidates of a block.
  pure subroutine gather_block(condensed, local, c)
    type(condensed_t), intent(in) :: condensed !! live compliances
    integer, intent(in) :: local(:) !! (live) number in the block, ascending, 0 for none
    real(wp), intent(out) :: c(:, :) !! (block, block) [length/force]
    integer :: b, i, j

    c = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_live)
        associate (mine => pack([(i, i=1, body%n_live)], local(first + 1:first + body%n_live) > 0))
          do j = 1, size(mine)
            c(local(first + mine), local(first + mine(j))) = body%live(mine, mine(j))
          end do
        end associate
      end associate
    end do
  end subroutine gather_block

  !> What the rigid motions of the bodies are to the rows, and the small matrix that is left for
  !! them when the blocks answer.
  subroutine border_blocks(condensed, tangent, outcome)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    type(contact_tangent_t), intent(inout) :: tangent !! blocks given; gets raised, pushed, border
    integer, intent(out) :: outcome !! done or singular
    real(wp) :: risen(tangent%rank, tangent%modes)
    integer :: b, j, i, k, info

    if (allocated(tangent%parts%raised)) deallocate (tangent%parts%raised, tangent%parts%pushed, &
      tangent%parts%border, &
      tangent%parts%border_pivot)
    allocate (tangent%parts%raised(tangent%rank, tangent%modes), &
      tangent%parts%pushed(tangent%modes, &
      tangent%rank), source=0.0_wp)
    allocate (tangent%parts%border(tangent%modes, tangent%modes), &
      tangent%parts%border_pivot(tangent%modes))
    risen = 0.0_wp
    do j = 1, tangent%rank
      associate (dofs => tangent%dofs(:, tangent%owner(j)))
        do i = 1, size(tangent%dofs, 1)
          if (dofs(i) == 0) cycle
          b = body_of(condensed, dofs(i))
          associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_mode)
            do k = 1, body%motions%n
              associate (mode => body%modes(body%gathered(dofs(i) - body%first_live), k))
                risen(j, first + k) = risen(j, first + k) + tangent%v(i, j)*mode
                tangent%parts%pushed(first + k, j) = tangent%parts%pushed(first + k, j) &
                  + body%softness*tangent%u(i, j)*mode
              end associate
            end do
          end associate
        end do
      end associate
    end do
    do k = 1, tangent%modes
      call apply_blocks(tangent, risen(:, k), tangent%parts%raised(:, k))
    end do
    tangent%parts%border = matmul(tangent%parts%pushed, tangent%parts%raised) + condensed%rigid%hold
    call dgetrf(tangent%modes, tangent%modes, tangent%parts%border, tangent%modes, &
      tangent%parts%border_pivot, info)
    outcome = merge(solver_done, solver_singular, info == 0)
  end subroutine border_blocks

  !> The body of a live candidate.
  pure integer function body_of(condensed, dof) result(b)
    type(condensed_t), intent(in) :: condensed !! live candidates of the bodies
    integer, intent(in) :: dof !! the candidate

    do b = 1, size(condensed%bodies)
      if (dof <= condensed%bodies(b)%first_live + condensed%bodies(b)%n_live) return
    end do
  end function body_of

  !> z = A^-1 r by the blocks: each answers for its own rows.
  subroutine apply_blocks(tangent, r, z)
    type(contact_tangent_t), intent(in) :: tangent !! its blocks
    real(wp), intent(in) :: r(:) !! (rank) [length]
    real(wp), intent(out) :: z(:) !! (rank)
    real(wp) :: answer(tangent%rank)
    integer :: k, j, info

    do k = 1, size(tangent%parts%blocks)
      associate (block => tangent%parts%blocks(k))
        answer(:size(block%row)) = r(block%row)
        call dgetrs('T', size(block%row), 1, block%factor, size(block%row), block%pivot, &
          answer, size(block%row), info)
        do j = 1, size(block%row)
          if (block%own(j)) z(block%row(j)) = answer(j)
        end do
      end associate
    end do
  end subroutine apply_blocks

  !> Answers to rows and to what is asked of the rigid motions, by the blocks.
  subroutine precondition(tangent, r, z)
    type(contact_tangent_t), intent(in) :: tangent !! its blocks and border
    real(wp), intent(in) :: r(:) !! (rank+modes) [length]
    real(wp), intent(out) :: z(:) !! (rank+modes) shares and rigid motions
    integer :: info

    associate (n => tangent%rank, m => tangent%modes)
      call apply_blocks(tangent, r(:n), z(:n))
      if (m == 0) return
      z(n + 1:n + m) = r(n + 1:n + m) - matmul(tangent%parts%pushed, z(:n))
      call dgetrs('N', m, 1, tangent%parts%border, m, tangent%parts%border_pivot, z(n + 1:n + &
        m), m, info)
      z(:n) = z(:n) + matmul(tangent%parts%raised, z(n + 1:n + m))
    end associate
  end subroutine precondition
end module contact_blocks

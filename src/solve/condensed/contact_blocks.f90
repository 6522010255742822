!> Overlapping blocks of the rows of contact: where these are many, the inverses of the blocks stand
!! in for that of the whole matrix I + V^T C U (doc/theory, "Condensed contact").
module contact_blocks
  use kinds, only: wp
  use lapack_interface, only: dgetrf, dgetrs, dgemv, dgemm
  use back_ends, only: solver_done, solver_singular
  use condensed_types, only: condensed_t, contact_tangent_t, contact_block_t, columns_t
  use condensed_motions, only: add_live_motion, push_live
  use carried_motions, only: part_motions, add_carried, carry
  use contact_groups, only: place_rows, split_part
  use sparse_columns, only: take_product, add_product
  use system_types, only: system_t
  implicit none
  private
  public :: form_blocks, precondition

  !> Rows of a block without its overlap: one in forty of all, within these bounds; where bodies
  !! that contact alone holds lean on each other, small blocks that reach far.
  integer, parameter :: fewest_rows = 64, most_rows = 256, share_of_rows = 40
  !> How far a block reaches beyond its own rows, in distances of points.
  real(wp), parameter :: overlap = 2.0_wp
  !> Rows of a block with its overlap over those without, at most; the reach is lessened until then.
  integer, parameter :: most_growth = 3, growth_leaning = 8
  real(wp), parameter :: shrinkage = 0.8_wp
  !> Rows that a closed point gives, mostly.
  real(wp), parameter :: rows_of_point = 3.0_wp

contains

  !> Divides the rows of the tangent, inverts the blocks and finds what they make of the rigid
  !! motions.
  subroutine form_blocks(system, x, outcome)
    type(system_t), intent(inout) :: system !! columns of its tangent given; gets blocks
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! done or singular
    real(wp) :: place(3, system%condensed%tangent%rank)
    integer :: k, worst

    associate (condensed => system%condensed, tangent => system%condensed%tangent)
      call place_rows(system, x, place)
      call divide_rows(tangent, place, system%scale%facet_size)
      call part_motions(condensed, tangent%parts%carried)
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

  !> Rows side by side, halved until a part has few; a block is a part with what is near.
  pure subroutine divide_rows(tangent, place, size_of_facet)
    type(contact_tangent_t), intent(inout) :: tangent !! gets blocks
    real(wp), intent(in) :: place(:, :) !! (3, rank) [length]
    real(wp), intent(in) :: size_of_facet !! mean [length]
    integer :: order(size(place, 2)), ends(size(place, 2)), parts, k, first, e, rows, growth
    real(wp) :: low(3), high(3), reach

    order = [(e, e=1, size(order))]
    parts = 0
    rows = merge(fewest_rows, max(fewest_rows, min(most_rows, tangent%rank/share_of_rows)), &
      tangent%modes > 0)
    growth = merge(growth_leaning, most_growth, tangent%modes > 0)
    call halve(place, rows, 1, size(order), order, ends, parts)
    if (allocated(tangent%parts%blocks)) deallocate (tangent%parts%blocks)
    allocate (tangent%parts%blocks(parts))
    first = 1
    do k = 1, parts
      associate (own => order(first:ends(k)))
        low = minval(place(:, own), 2)
        high = maxval(place(:, own), 2)
        reach = overlap*max(maxval(high - low)/sqrt(real(size(own), wp)/rows_of_point), &
          0.5_wp*size_of_facet)
        do
          call list_rows(place, low - reach, high + reach, own, tangent%parts%blocks(k))
          if (size(tangent%parts%blocks(k)%row) <= growth*size(own)) exit
          reach = shrinkage*reach
        end do
      end associate
      first = ends(k) + 1
    end do
  end subroutine divide_rows

  !> Halves a part across its longest side until it has few rows.
  pure recursive subroutine halve(place, most, first, last, order, ends, parts)
    real(wp), intent(in) :: place(:, :) !! (3, rank) [length]
    integer, intent(in) :: most !! rows
    integer, intent(in) :: first, last !! the part in order
    integer, intent(inout) :: order(:) !! (rank) is sorted
    integer, intent(inout) :: ends(:) !! where finished parts end in order
    integer, intent(inout) :: parts !! finished parts
    integer :: split

    split = last
    if (last - first + 1 > most) call split_part(place, first, last, order, split)
    if (split == last) then
      parts = parts + 1
      ends(parts) = last
    else
      call halve(place, most, first, split, order, ends, parts)
      call halve(place, most, split + 1, last, order, ends, parts)
    end if
  end subroutine halve

  !> The rows within a box.
  pure subroutine list_rows(place, low, high, own, block)
    real(wp), intent(in) :: place(:, :) !! (3, rank) [length]
    real(wp), intent(in) :: low(3), high(3) !! the box [length]
    integer, intent(in) :: own(:) !! rows of the block itself
    type(contact_block_t), intent(inout) :: block !! gets row, own
    logical :: is_own(size(place, 2))
    integer :: row(size(place, 2)), j, n

    is_own = .false.
    is_own(own) = .true.
    n = 0
    do j = 1, size(place, 2)
      if (.not. is_own(j)) then
        if (any(place(:, j) < low) .or. any(place(:, j) > high)) cycle
      end if
      n = n + 1
      row(n) = j
    end do
    block%row = row(:n)
    block%own = is_own(block%row)
  end subroutine list_rows

  !> The block's part of I + V^T C' U, transposed, and from it what the block answers.
  subroutine factorise_block(condensed, tangent, block, outcome)
    type(condensed_t), intent(in) :: condensed !! live compliances
    type(contact_tangent_t), intent(inout) :: tangent !! columns, carried; gets weights
    type(contact_block_t), intent(inout) :: block !! row, own given; gets inverse
    integer, intent(out) :: outcome !! done or singular
    integer :: local(condensed%alive%n_live), j, i
    integer, allocatable :: first(:), last(:)
    real(wp), allocatable :: c(:, :), cu(:, :)
    real(wp) :: a(size(block%row), size(block%row))

    call find_block_dofs(tangent, block, local)
    allocate (c(maxval(local), maxval(local)), cu(maxval(local), size(block%row)))
    allocate (first(size(c, 1)), last(size(c, 1)))
    call gather_block(condensed, tangent%parts%carried, local, c, first, last)
    associate (lead => tangent%lead, taken => tangent%taken)
      do j = 1, size(block%row)
        cu(:, j) = 0.0_wp
        do i = lead%start(block%row(j)), lead%start(block%row(j) + 1) - 1
          associate (k => local(lead%row(i)))
            cu(first(k):last(k), j) = cu(first(k):last(k), j) &
              + lead%value(i)*c(first(k):last(k), k)
          end associate
        end do
      end do
      c = transpose(cu)
      a = 0.0_wp
      do j = 1, size(block%row)
        associate (row => block%row(j), column => a(:, j))
          do i = taken%start(row), taken%start(row + 1) - 1
            column = column + taken%value(i)*c(:, local(taken%row(i)))
          end do
          column(j) = column(j) + 1.0_wp
          if (block%own(j)) tangent%parts%weight(row) = maxval(abs(lead%value(lead%start(row): &
            lead%start(row + 1) - 1)))/abs(column(j))
        end associate
      end do
    end associate
    call invert_block(a, block, outcome)
  end subroutine factorise_block

  !> The rows of the inverse that the block answers for.
  subroutine invert_block(a, block, outcome)
    real(wp), intent(inout) :: a(:, :) !! (n, n) its matrix, transposed; is factorised
    type(contact_block_t), intent(inout) :: block !! row, own given; gets inverse
    integer, intent(out) :: outcome !! done or singular
    integer :: pivot(size(a, 1)), i, j, n, info

    n = size(a, 1)
    block%inverse = reshape([real(wp) ::], [n, count(block%own)], [0.0_wp])
    j = 0
    do i = 1, n
      if (.not. block%own(i)) cycle
      j = j + 1
      block%inverse(i, j) = 1.0_wp
    end do
    call dgetrf(n, n, a, n, pivot, info)
    outcome = merge(solver_done, solver_singular, info == 0)
    if (info == 0) call dgetrs('N', n, j, a, n, pivot, block%inverse, n, info)
  end subroutine invert_block

  !> Numbers the live candidates that the rows of a block touch.
  pure subroutine find_block_dofs(tangent, block, local)
    type(contact_tangent_t), intent(in) :: tangent !! columns
    type(contact_block_t), intent(in) :: block !! its rows
    integer, intent(out) :: local(:) !! (live) number in the block, 0 for none
    integer :: j, i, n

    local = 0
    do j = 1, size(block%row)
      associate (row => block%row(j))
        local(tangent%lead%row(tangent%lead%start(row):tangent%lead%start(row + 1) - 1)) = 1
        local(tangent%taken%row(tangent%taken%start(row):tangent%taken%start(row + 1) - 1)) = 1
      end associate
    end do
    n = 0
    do i = 1, size(local)
      if (local(i) == 0) cycle
      n = n + 1
      local(i) = n
    end do
  end subroutine find_block_dofs

  !> The compliance between the live candidates of a block, without what is carried by rigid
  !! motions.
  pure subroutine gather_block(condensed, carried, local, c, first_of, last_of)
    type(condensed_t), intent(in) :: condensed !! live compliances
    real(wp), intent(in) :: carried(:, :) !! (live, 6) X
    integer, intent(in) :: local(:) !! (live) number in the block, ascending, 0 for none
    real(wp), intent(out) :: c(:, :) !! (block, block) [length/force]
    integer, intent(out) :: first_of(:), last_of(:) !! (block) those of the body of each
    real(wp), dimension(size(c, 1), 6) :: motion, x
    real(wp) :: column(size(c, 1))
    integer :: b, i, j, k, n

    c = 0.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_live)
        associate (mine => pack([(i, i=1, body%n_live)], local(first + 1:first + body%n_live) > 0))
          n = size(mine)
          if (n == 0) cycle
          first_of(local(first + mine)) = local(first + mine(1))
          last_of(local(first + mine)) = local(first + mine(n))
          do k = 1, body%motions%n
            motion(:n, k) = body%modes(body%gathered(mine), k)
            x(:n, k) = carried(first + mine, k)
          end do
          do j = 1, n
            column(:n) = body%live(mine, mine(j))
            do k = 1, body%motions%n
              column(:n) = column(:n) - motion(:n, k)*x(j, k) - x(:n, k)*motion(j, k)
            end do
            c(local(first + mine), local(first + mine(j))) = column(:n)
          end do
        end associate
      end associate
    end do
  end subroutine gather_block

  !> What the rigid motions of the bodies are to the rows, and the small matrix that is left for
  !! them when the blocks answer.
  subroutine border_blocks(condensed, tangent, outcome)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    type(contact_tangent_t), intent(inout) :: tangent !! blocks given; these get raised; border
    integer, intent(out) :: outcome !! done or singular
    real(wp) :: way(condensed%alive%n_live), only(tangent%modes)
    real(wp), allocatable :: risen(:, :)
    integer :: k, info

    allocate (risen(tangent%rank, tangent%modes))
    do k = 1, tangent%modes
      only = 0.0_wp
      only(k) = 1.0_wp
      way = 0.0_wp
      call add_live_motion(condensed, only, way)
      call add_carried(condensed, tangent%parts%carried, condensed%rigid%hold(:, k), way)
      call take_product(tangent%taken, way, risen(:, k))
    end do
    associate (parts => tangent%parts)
      parts%border = condensed%rigid%hold
      do k = 1, size(parts%blocks)
        call raise_modes(condensed, tangent%lead, risen, parts%blocks(k), parts%border)
      end do
      parts%border_pivot = spread(0, 1, tangent%modes)
      call dgetrf(tangent%modes, tangent%modes, parts%border, tangent%modes, parts%border_pivot, &
        info)
    end associate
    outcome = merge(solver_done, solver_singular, info == 0)
  end subroutine border_blocks

  !> What a block answers to the motions that show in its rows, and what that does to all of them.
  subroutine raise_modes(condensed, lead, risen, block, border)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    type(columns_t), intent(in) :: lead !! U
    real(wp), intent(in) :: risen(:, :) !! (rank, modes) what each motion is to the rows [length]
    type(contact_block_t), intent(inout) :: block !! inverse given; gets mode, raised
    real(wp), intent(inout) :: border(:, :) !! (modes, modes) grows [length]
    real(wp), allocatable :: asked(:, :), pushed(:, :)
    integer :: j, n, m

    block%mode = pack([(j, j=1, size(risen, 2))], any(abs(risen(block%row, :)) > 0.0_wp, 1))
    asked = risen(block%row, block%mode)
    n = size(block%inverse, 1)
    m = size(block%inverse, 2)
    block%raised = reshape([real(wp) ::], [m, size(block%mode)], [0.0_wp])
    call dgemm('T', 'N', m, size(block%mode), n, 1.0_wp, block%inverse, n, asked, n, 0.0_wp, &
      block%raised, m)
    allocate (pushed(size(border, 1), m))
    associate (own => pack(block%row, block%own))
      do j = 1, m
        associate (first => lead%start(own(j)), last => lead%start(own(j) + 1) - 1)
          call push_few(condensed, lead%row(first:last), lead%value(first:last), pushed(:, j))
        end associate
      end do
    end associate
    border(:, block%mode) = border(:, block%mode) + matmul(pushed, block%raised)
  end subroutine raise_modes

  !> What a few forces do to the rigid motions, in the unit of displacements.
  pure subroutine push_few(condensed, row, value, push)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    integer, intent(in) :: row(:) !! live candidates
    real(wp), intent(in) :: value(:) !! forces there [force]
    real(wp), intent(out) :: push(:) !! (modes) [length]
    integer :: b, i, k

    push = 0.0_wp
    do i = 1, size(row)
      b = body_of(condensed, row(i))
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_mode)
        do k = 1, body%motions%n
          push(first + k) = push(first + k) + body%softness*value(i) &
            *body%modes(body%gathered(row(i) - body%first_live), k)
        end do
      end associate
    end do
  end subroutine push_few

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
    integer :: k, n, m

    do k = 1, size(tangent%parts%blocks)
      associate (block => tangent%parts%blocks(k))
        n = size(block%inverse, 1)
        m = size(block%inverse, 2)
        call dgemv('T', n, m, 1.0_wp, block%inverse, n, r(block%row), 1, 0.0_wp, answer, 1)
        z(pack(block%row, block%own)) = answer(:m)
      end associate
    end do
  end subroutine apply_blocks

  !> Answers to rows and to what is asked of the rigid motions, by the blocks. These have C' in
  !! place of C: what the motions are asked for, p, shows in the rows as V^T X p, and the motions
  !! that come are less by X^T U z.
  subroutine precondition(condensed, r, z)
    type(condensed_t), intent(in) :: condensed !! tangent with its blocks and border
    real(wp), intent(in) :: r(:) !! (rank+modes) [length]
    real(wp), intent(out) :: z(:) !! (rank+modes) shares and rigid motions
    real(wp), dimension(condensed%alive%n_live) :: way, force
    real(wp) :: rows(condensed%tangent%rank)
    integer :: k, info

    associate (tangent => condensed%tangent, parts => condensed%tangent%parts, &
      n => condensed%tangent%rank, m => condensed%tangent%modes)
      if (m == 0) then
        call apply_blocks(tangent, r(:n), z(:n))
        return
      end if
      way = 0.0_wp
      call add_carried(condensed, parts%carried, r(n + 1:n + m), way)
      call take_product(tangent%taken, way, rows)
      call apply_blocks(tangent, r(:n) - rows, z(:n))
      force = 0.0_wp
      call add_product(tangent%lead, z(:n), force)
      call push_live(condensed, force, z(n + 1:n + m))
      z(n + 1:n + m) = r(n + 1:n + m) - z(n + 1:n + m)
      call dgetrs('N', m, 1, parts%border, m, parts%border_pivot, z(n + 1:n + m), m, info)
      do k = 1, size(parts%blocks)
        associate (block => parts%blocks(k))
          associate (own => pack(block%row, block%own))
            z(own) = z(own) + matmul(block%raised, z(n + block%mode))
          end associate
        end associate
      end do
      force = 0.0_wp
      call add_product(tangent%lead, z(:n), force)
      call carry(condensed, parts%carried, force, z(n + 1:n + m))
    end associate
  end subroutine precondition
end module contact_blocks

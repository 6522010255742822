!> Overlapping blocks of the rows of contact: where these are many, the inverses of the blocks stand
!! in for that of the whole matrix I + V^T C U (doc/theory, "Contact operator of low rank").
module contact_blocks
  use kinds, only: wp, sp
  use lapack_interface, only: dgetrf, dgetrs, sgemv, sgemm
  use back_ends, only: solver_done, solver_singular
  use condensed_types, only: condensed_t, contact_tangent_t, contact_block_t, columns_t
  use condensed_motions, only: push_live
  use carried_motions, only: part_motions, add_carried, carry
  use contact_groups, only: place_rows
  use part_halving, only: halve_parts
  use block_inverses, only: factorise_block, is_of, body_of
  use contact_sums, only: add_leading
  use sparse_columns, only: take_product, add_product
  use system_types, only: system_t
  implicit none
  private
  public :: form_blocks, precondition

  !> Rows of a block without its overlap: one in forty of all, within these bounds; where bodies
  !! that contact alone holds lean on each other, blocks that reach far for their size.
  integer, parameter :: fewest_rows = 64, most_block_rows = 256, share_of_rows = 40, &
    rows_leaning = 128
  !> How far a block reaches beyond its own rows, in distances of points.
  real(wp), parameter :: block_overlap = 2.0_wp, overlap_leaning = 1.5_wp
  !> Rows of a block with its overlap over those without, at most; the reach is lessened until then.
  integer, parameter :: most_row_growth = 3, growth_leaning = 5
  real(wp), parameter :: shrinkage = 0.8_wp
  !> Rows that a closed point gives, mostly.
  real(wp), parameter :: mean_point_rows = 3.0_wp

contains

  !> Divides the rows of the tangent, inverts the blocks and finds what they make of the rigid
  !! motions.
  subroutine form_blocks(system, condensed, x, outcome)
    type(system_t), intent(in) :: system !! columns of its tangent given
    type(condensed_t), intent(inout) :: condensed !! gets blocks
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(out) :: outcome !! done or singular
    real(wp) :: place(3, condensed%tangent%rank)
    integer :: k, worst

    associate (tangent => condensed%tangent)
      call place_rows(system%u, condensed, x, place)
      call divide_rows(tangent, place, system%scale%facet_size)
      call part_motions(condensed)
      if (allocated(tangent%parts%weight)) deallocate (tangent%parts%weight)
      allocate (tangent%parts%weight(tangent%rank), source=1.0_wp)
      worst = solver_done
      do k = 1, size(tangent%parts%blocks)
        call factorise_block(condensed, tangent%parts%blocks(k), outcome)
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
    real(wp) :: low(3), high(3), reach, distances

    order = [(e, e=1, size(order))]
    parts = 0
    rows = merge(rows_leaning, max(fewest_rows, min(most_block_rows, tangent%rank/share_of_rows)), &
      tangent%modes > 0)
    growth = merge(growth_leaning, most_row_growth, tangent%modes > 0)
    distances = merge(overlap_leaning, block_overlap, tangent%modes > 0)
    call halve_parts(place, rows, 1, size(order), order, ends, parts)
    if (allocated(tangent%parts%blocks)) deallocate (tangent%parts%blocks)
    allocate (tangent%parts%blocks(parts))
    first = 1
    do k = 1, parts
      associate (own => order(first:ends(k)))
        low = minval(place(:, own), 2)
        high = maxval(place(:, own), 2)
        reach = distances*max(maxval(high - low)/sqrt(real(size(own), wp)/mean_point_rows), &
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

  !> The rows within a box.
  pure subroutine list_rows(place, low, high, own, block)
    real(wp), intent(in) :: place(:, :) !! (3, rank) [length]
    real(wp), intent(in) :: low(3), high(3) !! the box, around the own rows [length]
    integer, intent(in) :: own(:) !! rows of the block itself
    type(contact_block_t), intent(inout) :: block !! gets row, own
    logical :: is_own(size(place, 2))
    integer :: row(size(place, 2)), j, n

    n = 0
    do j = 1, size(place, 2)
      if (place(1, j) < low(1) .or. place(1, j) > high(1)) cycle
      if (place(2, j) < low(2) .or. place(2, j) > high(2)) cycle
      if (place(3, j) < low(3) .or. place(3, j) > high(3)) cycle
      n = n + 1
      row(n) = j
      is_own(j) = .false.
    end do
    is_own(own) = .true.
    block%row = row(:n)
    block%own = is_own(block%row)
  end subroutine list_rows

  !> What the rigid motions of the bodies are to the rows, and the small matrix that is left for
  !! them when the blocks answer.
  subroutine border_blocks(condensed, tangent, outcome)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    type(contact_tangent_t), intent(inout) :: tangent !! blocks given; these get raised; border
    integer, intent(out) :: outcome !! done or singular
    real(wp), allocatable :: risen(:, :)
    integer :: k, info

    allocate (risen(tangent%modes, tangent%rank))
    call raise_rows(condensed, tangent%taken, risen)
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

  !> V^T (R + X hold): what each rigid motion is to the rows, transposed.
  pure subroutine raise_rows(condensed, taken, risen)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies, near
    type(columns_t), intent(in) :: taken !! V
    real(wp), intent(out) :: risen(:, :) !! (modes, rank) [length]
    real(wp) :: carried(size(risen, 1))
    integer :: j, i, b, dof
    logical :: held

    held = any(abs(condensed%rigid%hold) > 0.0_wp)
    risen = 0.0_wp
    do j = 1, taken%n
      carried = 0.0_wp
      b = 1
      do i = taken%start(j), taken%start(j + 1) - 1
        if (.not. is_of(condensed%bodies(b), taken%row(i))) b = body_of(condensed, taken%row(i))
        associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_mode + 1, &
          last => condensed%bodies(b)%first_mode + condensed%bodies(b)%motions%n)
          dof = taken%row(i) - body%first_live
          risen(first:last, j) = risen(first:last, j) + taken%value(i)*body%near%modes(dof, :)
          if (held) carried(first:last) = carried(first:last) &
            + taken%value(i)/body%softness*body%near%carried(dof, :)
        end associate
      end do
      if (held) risen(:, j) = risen(:, j) + matmul(carried, condensed%rigid%hold)
    end do
  end subroutine raise_rows

  !> What a block answers to the motions that show in its rows, and what that does to all of them.
  subroutine raise_modes(condensed, lead, risen, block, border)
    type(condensed_t), intent(in) :: condensed !! motions of the bodies
    type(columns_t), intent(in) :: lead !! U
    real(wp), intent(in) :: risen(:, :) !! (modes, rank) what each motion is to the rows [length]
    type(contact_block_t), intent(inout) :: block !! inverse given; gets mode, raised
    real(wp), intent(inout) :: border(:, :) !! (modes, modes) grows [length]
    real(sp), allocatable :: asked(:, :), raised(:, :)
    real(wp), allocatable :: pushed(:, :)
    logical :: shows(size(risen, 1))
    integer :: j, n, m

    shows = .false.
    do j = 1, size(block%row)
      shows = shows .or. abs(risen(:, block%row(j))) > 0.0_wp
    end do
    block%mode = pack([(j, j=1, size(risen, 1))], shows)
    n = size(block%inverse, 1)
    m = size(block%inverse, 2)
    allocate (asked(size(block%mode), n), raised(m, size(block%mode)))
    do j = 1, n
      asked(:, j) = real(risen(block%mode, block%row(j)), sp)
    end do
    call sgemm('T', 'T', m, size(block%mode), n, 1.0_sp, block%inverse, n, asked, &
      size(block%mode), 0.0_sp, raised, m)
    block%raised = raised
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
    b = 1
    do i = 1, size(row)
      if (.not. is_of(condensed%bodies(b), row(i))) b = body_of(condensed, row(i))
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_mode)
        do k = 1, body%motions%n
          push(first + k) = push(first + k) + body%softness*value(i) &
            *body%near%modes(row(i) - body%first_live, k)
        end do
      end associate
    end do
  end subroutine push_few

  !> z = A^-1 r by the blocks: each answers for its own rows. What goes to and from single
  !! precision is of the size of one.
  subroutine apply_blocks(tangent, r, z)
    type(contact_tangent_t), intent(in) :: tangent !! its blocks
    real(wp), intent(in) :: r(:) !! (rank) [length]
    real(wp), intent(out) :: z(:) !! (rank)
    real(sp) :: asked(tangent%rank), answer(tangent%rank)
    real(wp) :: unit
    integer :: k, n, m

    z = 0.0_wp
    unit = maxval(abs(r))
    if (.not. unit > 0.0_wp) return
    asked = real(r/unit, sp)
    do k = 1, size(tangent%parts%blocks)
      associate (block => tangent%parts%blocks(k))
        n = size(block%inverse, 1)
        m = size(block%inverse, 2)
        call sgemv('T', n, m, 1.0_sp, block%inverse, n, asked(block%row), 1, 0.0_sp, answer, 1)
        z(pack(block%row, block%own)) = unit*answer(:m)
      end associate
    end do
  end subroutine apply_blocks

  !> Answers to rows and to what is asked of the rigid motions, by the blocks. These have C' in
  !! place of C: what the motions are asked for, p, shows in the rows as V^T X p, and the motions
  !! that come are less by X^T U z.
  subroutine precondition(condensed, r, z, force)
    type(condensed_t), intent(in) :: condensed !! tangent with its blocks and border
    real(wp), intent(in) :: r(:) !! (rank+modes) [length]
    real(wp), intent(out) :: z(:) !! (rank+modes) shares and rigid motions
    real(wp), intent(out) :: force(:) !! (live) U z [force]
    real(wp) :: way(condensed%alive%n_live), rows(condensed%tangent%rank)
    integer :: k, info

    associate (tangent => condensed%tangent, parts => condensed%tangent%parts, &
      n => condensed%tangent%rank, m => condensed%tangent%modes)
      if (m > 0) then
        way = 0.0_wp
        call add_carried(condensed, r(n + 1:n + m), way)
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
      else
        call apply_blocks(tangent, r(:n), z(:n))
      end if
      force = 0.0_wp
      call add_leading(tangent, z(:n), force)
      if (m > 0) call carry(condensed, force, z(n + 1:n + m))
    end associate
  end subroutine precondition
end module contact_blocks

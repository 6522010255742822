!> The inverses of blocks of rows of contact. They only precede the iteration that asks them, so
!! that single precision is enough (doc/theory, "Contact operator of low rank").
module block_inverses
  use kinds, only: wp, sp
  use lapack_interface, only: sgetrf, sgetrs, saxpy
  use back_ends, only: solver_done, solver_singular
  use near_field, only: take_near
  use condensed_types, only: condensed_t, condensed_body_t, contact_tangent_t, contact_block_t
  implicit none
  private
  public :: factorise_block, is_of, body_of

contains

  !> The block's part of I + V^T C' U, transposed, and from it what the block answers.
  subroutine factorise_block(condensed, block, outcome)
    type(condensed_t), intent(inout) :: condensed !! near compliances; its tangent gets weights
    type(contact_block_t), intent(inout) :: block !! row, own given; gets inverse
    integer, intent(out) :: outcome !! done or singular
    integer :: local(condensed%alive%n_live)
    integer, allocatable :: first(:), last(:)
    real(sp), allocatable :: c(:, :), moved(:, :), a(:, :)

    call find_block_dofs(condensed%tangent, block, local)
    associate (n => maxval(local))
      allocate (c(n, n), first(n), last(n), moved(n, size(block%row)))
    end associate
    call gather_block(condensed, local, c, first, last)
    call move_columns(condensed, block, local, first, last, c, moved)
    call take_rows(condensed%tangent, block, local, transposed(moved), a)
    call weigh_rows(block, a, condensed%tangent)
    call invert_block(a, block, outcome)
  end subroutine factorise_block

  !> C' U of the block.
  subroutine move_columns(condensed, block, local, first, last, c, moved)
    type(condensed_t), intent(in) :: condensed !! columns, bodies
    type(contact_block_t), intent(in) :: block !! its rows
    integer, intent(in) :: local(:) !! (live) number in the block
    integer, intent(in) :: first(:), last(:) !! (block) those of the body of each
    real(sp), contiguous, intent(in) :: c(:, :) !! (block, block) in the unit of each softness
    real(sp), contiguous, intent(out) :: moved(:, :) !! (block, n)
    integer :: i, j, b

    moved = 0.0_sp
    associate (lead => condensed%tangent%lead, bodies => condensed%bodies)
      do j = 1, size(block%row)
        b = 1
        do i = lead%start(block%row(j)), lead%start(block%row(j) + 1) - 1
          associate (dof => lead%row(i))
            if (.not. is_of(bodies(b), dof)) b = body_of(condensed, dof)
            associate (k => local(dof))
              call saxpy(last(k) - first(k) + 1, real(bodies(b)%softness*lead%value(i), sp), &
                c(first(k):, k), 1, moved(first(k):, j), 1)
            end associate
          end associate
        end do
      end do
    end associate
  end subroutine move_columns

  !> A live candidate is one of the body.
  pure logical function is_of(body, dof) result(yes)
    type(condensed_body_t), intent(in) :: body !! its live candidates numbered
    integer, intent(in) :: dof !! the candidate

    yes = dof > body%first_live .and. dof <= body%first_live + body%n_live
  end function is_of

  !> The body of a live candidate.
  pure integer function body_of(condensed, dof) result(b)
    type(condensed_t), intent(in) :: condensed !! live candidates of the bodies
    integer, intent(in) :: dof !! the candidate

    do b = 1, size(condensed%bodies)
      if (is_of(condensed%bodies(b), dof)) return
    end do
  end function body_of

  !> The transpose of a matrix, by squares that fit the nearest memory.
  pure function transposed(a) result(b)
    real(sp), intent(in) :: a(:, :) !! the matrix
    real(sp) :: b(size(a, 2), size(a, 1))
    integer, parameter :: side = 16
    integer :: i, j, k, l

    do k = 1, size(a, 2), side
      do l = 1, size(a, 1), side
        do i = l, min(l + side - 1, size(a, 1))
          do j = k, min(k + side - 1, size(a, 2))
            b(j, i) = a(i, j)
          end do
        end do
      end do
    end do
  end function transposed

  !> I + V^T C' U of the block, transposed.
  subroutine take_rows(tangent, block, local, moved, a)
    type(contact_tangent_t), intent(in) :: tangent !! columns
    type(contact_block_t), intent(in) :: block !! its rows
    integer, intent(in) :: local(:) !! (live) number in the block
    real(sp), contiguous, intent(in) :: moved(:, :) !! (n, dofs of the block) C' U, transposed
    real(sp), allocatable, intent(out) :: a(:, :) !! (n, n)
    integer :: i, j, n

    n = size(block%row)
    allocate (a(n, n), source=0.0_sp)
    associate (taken => tangent%taken)
      do j = 1, n
        do i = taken%start(block%row(j)), taken%start(block%row(j) + 1) - 1
          call saxpy(n, real(taken%value(i), sp), moved(:, local(taken%row(i))), 1, a(:, j), 1)
        end do
        a(j, j) = a(j, j) + 1.0_sp
      end do
    end associate
  end subroutine take_rows

  !> From what is left of the block's own rows to forces.
  pure subroutine weigh_rows(block, a, tangent)
    type(contact_block_t), intent(in) :: block !! its rows
    real(sp), intent(in) :: a(:, :) !! (n, n) its matrix
    type(contact_tangent_t), intent(inout) :: tangent !! columns; gets weights
    integer :: j

    do j = 1, size(block%row)
      if (.not. block%own(j)) cycle
      associate (lead => tangent%lead, row => block%row(j))
        tangent%parts%weight(row) = maxval(abs(lead%value(lead%start(row):lead%start(row + 1) &
          - 1)))/real(abs(a(j, j)), wp)
      end associate
    end do
  end subroutine weigh_rows

  !> The rows of the inverse that the block answers for.
  subroutine invert_block(a, block, outcome)
    real(sp), intent(inout) :: a(:, :) !! (n, n) its matrix, transposed; is factorised
    type(contact_block_t), intent(inout) :: block !! row, own given; gets inverse
    integer, intent(out) :: outcome !! done or singular
    integer :: pivot(size(a, 1)), i, j, n, info

    n = size(a, 1)
    if (allocated(block%inverse)) deallocate (block%inverse)
    allocate (block%inverse(n, count(block%own)), source=0.0_sp)
    j = 0
    do i = 1, n
      if (.not. block%own(i)) cycle
      j = j + 1
      block%inverse(i, j) = 1.0_sp
    end do
    call sgetrf(n, n, a, n, pivot, info)
    outcome = merge(solver_done, solver_singular, info == 0)
    if (info == 0) call sgetrs('N', n, j, a, n, pivot, block%inverse, n, info)
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
  pure subroutine gather_block(condensed, local, c, first_of, last_of)
    type(condensed_t), intent(in) :: condensed !! near compliances
    integer, intent(in) :: local(:) !! (live) number in the block, ascending, 0 for none
    real(sp), intent(out) :: c(:, :) !! (block, block) in the unit of each body's softness
    integer, intent(out) :: first_of(:), last_of(:) !! (block) those of the body of each
    integer :: b, i, j, n

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_live)
        associate (mine => pack([(i, i=1, body%n_live)], local(first + 1:first + body%n_live) > 0))
          n = size(mine)
          if (n == 0) cycle
          associate (low => local(first + mine(1)), high => local(first + mine(n)))
            first_of(low:high) = low
            last_of(low:high) = high
            if (body%tree%used) then
              call take_near(body%tree%near, body%gathered(mine), real(1.0_wp/body%softness, sp), &
                c(low:high, low:high))
            else
              do j = 1, n
                c(low:high, low + j - 1) = body%near%c(mine, mine(j))
              end do
            end if
          end associate
        end associate
      end associate
    end do
  end subroutine gather_block
end module block_inverses

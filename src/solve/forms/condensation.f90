!> Condenses a body on its candidate nodes: ordered last in its factor, their Schur complement is
!! the trailing block L22 L22^T, whose inverse is the compliance (doc/theory, "Static condensation",
!! eq. (12.2)).
module condensation
  use kinds, only: wp
  use memory, only: memory_left
  use costs, only: cost_t, begin_cost, end_cost, count_cost, cost_compliance
  use product_inverse, only: invert_product
  use lapack_interface, only: dgetrf, dgetrs
  use block_matrix, only: block_matrix_t, find_block
  use ordered_blocks, only: ordered_blocks_t
  use back_ends, only: solver_done, solver_failed, solver_not_definite, solver_out_of_memory, &
    solver_singular
  use cholmod_solver, only: trailing_block, drop_trailing_block, factor_work
  use elimination_order, only: order_equations
  use half_solves, only: solve_columns, reduce_right, complete_solution, halve_factor, shrink_factor
  use coarse_factor, only: factorise_coarsely
  use double_factor, only: factorise_lower
  use condensed_types, only: condensed_body_t, near_compliance_t, tree_t
  use tree_compliance, only: may_pay, pays, form_tree, tree_bytes
  implicit none
  private
  public :: condense_body, prepare_body, factorise_body, form_compliance, &
    solve_body, spread_body, push_body, reduce_body, complete_body, halve_body, shrink_body, &
    body_work, needed_bytes, is_worth_sharing, take_shift_out, drop_live, free_body

  !> Share of an answer of the factor that its values in single precision may change.
  real(wp), parameter :: near_enough = 1.0e-3_wp
  !> Products and sums of a factor that threads share.
  real(wp), parameter :: large_work = 1.0e10_wp

contains

  !> Factorises the free equations of one body with its candidates last.
  subroutine condense_body(blocks, equation, queue, body, costs, outcome)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    integer, intent(in) :: equation(:, :) !! (3, nodes) equations of this body, 0 elsewhere
    integer, intent(in) :: queue(:) !! (nodes) place among its candidates, 0 for no candidate
    type(condensed_body_t), intent(inout) :: body !! filled; first stays, compliance goes
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    type(ordered_blocks_t) :: matrix

    call prepare_body(blocks, equation, queue, body, .false., matrix, costs, outcome)
    if (outcome /= solver_done) return
    if (needed_bytes(body) > memory_left()) outcome = solver_out_of_memory
    if (outcome == solver_done) call factorise_body(blocks, matrix, body, .false., costs, outcome)
  end subroutine condense_body

  !> Orders the equations of a body and analyses its matrix: the candidates among the other nodes,
  !! where that is allowed and costs less, or last.
  subroutine prepare_body(blocks, equation, queue, body, by_tree, matrix, costs, outcome)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    integer, intent(in) :: equation(:, :) !! (3, nodes) equations of this body, 0 elsewhere
    integer, intent(in) :: queue(:) !! (nodes) place among its candidates, 0 for no candidate
    type(condensed_body_t), intent(inout) :: body !! analysed; first stays, compliance goes
    logical, intent(in) :: by_tree !! candidates may be among the others
    type(ordered_blocks_t), intent(out) :: matrix !! its columns in the order of elimination
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends

    allocate (matrix%equation(3, size(equation, 2)))
    call drop_compliance(body)
    body%tree%used = by_tree
    if (by_tree) body%tree%used = may_pay(count(equation > 0), count(equation > 0 .and. &
      spread(queue > 0, 1, 3)))
    call order_equations(blocks, equation, queue, body, matrix%equation, costs, outcome)
    if (outcome == solver_done .and. body%tree%used) then
      body%tree%used = pays(body)
      if (.not. body%tree%used) call order_equations(blocks, equation, queue, body, &
        matrix%equation, costs, outcome)
    end if
    if (outcome == solver_done) call add_fixings(body, matrix)
  end subroutine prepare_body

  !> The factor of a body that has been prepared; its matrix goes. One that only precedes an
  !! iteration is made in single precision, if it stays near; L22 is beside it then. Its place is
  !! taken before that of a factor in double precision: what the factor gives back when it shrinks
  !! lies at the end of the heap and serves the next body.
  subroutine factorise_body(blocks, matrix, body, precedes, costs, outcome, shared_from)
    type(block_matrix_t), intent(in), target :: blocks !! stiffness of all bodies
    type(ordered_blocks_t), intent(inout) :: matrix !! as prepared
    type(condensed_body_t), intent(inout), target :: body !! analysed
    logical, intent(in) :: precedes !! it only precedes an iteration
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    real(wp), intent(in), optional :: shared_from !! share of it from where on threads share it
    logical :: done

    matrix%blocks => blocks
    matrix%node => body%node
    matrix%direction => body%direction
    done = precedes
    if (.not. body%tree%used) allocate (body%trailing(body%m, body%m))
    if (precedes) call factorise_coarsely(body%solver, matrix, near_enough, body%trailing, costs, &
      done)
    outcome = solver_done
    if (.not. done) call factorise_lower(body%solver, matrix, costs, outcome, shared_from)
    matrix = ordered_blocks_t()
  end subroutine factorise_body

  !> Springs at the fixings, as stiff as the body is there. Under balanced forces they carry
  !! nothing, so that displacements with them are exact but for a rigid motion (doc/theory,
  !! "Condensed floating bodies").
  pure subroutine add_fixings(body, matrix)
    type(condensed_body_t), intent(in) :: body !! its fixings
    type(ordered_blocks_t), intent(inout) :: matrix !! ordered; gets the springs
    integer :: fixing

    matrix%doubled = spread(.false., 1, size(body%node))
    do fixing = 1, body%motions%n
      matrix%doubled(matrix%equation(body%fixing_direction(fixing), body%fixing_node(fixing))) &
        = .true.
    end do
  end subroutine add_fixings

  !> Memory that the factor and the compliance of a body will take [byte].
  real(wp) function needed_bytes(body) result(bytes)
    type(condensed_body_t), intent(in) :: body !! analysed, its candidates counted

    bytes = body%solver%factor_bytes() + 8.0_wp*real(body%m, wp)**2
    if (body%tree%used) bytes = tree_bytes(body)
  end function needed_bytes

  !> C = (L22 L22^T)^-1, the lower triangle. L22 goes: the body cannot be solved any more, only
  !! completed from its candidates. Where these are among the others, the factor is C.
  subroutine form_compliance(x, body, costs, outcome, shared_from)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference coordinates [length]
    type(condensed_body_t), intent(inout) :: body !! factorised; gets compliance
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! done or failed
    real(wp), intent(in), optional :: shared_from !! threads share the work if that is not 1
    integer :: info, i
    logical :: shared

    outcome = solver_done
    if (body%m == 0) body%diagonal = [real(wp) ::]
    if (body%m == 0 .or. associated(body%compliance)) return
    call begin_cost(costs, cost_compliance)
    if (body%tree%used) then
      call form_tree(x, body)
      call end_cost(costs, cost_compliance)
      return
    end if
    body%compliance => body%trailing
    nullify (body%trailing)
    if (.not. associated(body%solver%half)) then
      call trailing_block(body%solver, body%compliance)
      call drop_trailing_block(body%solver, body%m)
    end if
    shared = .false.
    if (present(shared_from)) shared = shared_from < 1.0_wp
    call invert_product(body%m, shared, body%compliance, info)
    call end_cost(costs, cost_compliance)
    call count_cost(costs, cost_compliance, body%m - 1)
    body%diagonal = [(body%compliance(i, i), i=1, body%m)]
    body%softness = sum(body%diagonal)/real(body%m, wp)
    if (info /= 0) outcome = solver_failed
  end subroutine form_compliance

  !> C = (I - C' D)^-1 C' from the compliance C' with springs D on the candidates, eq. (7.20).
  !! Fixings stay: they are springs that the motions of the body know of.
  subroutine take_shift_out(blocks, body, outcome)
    type(block_matrix_t), intent(in) :: blocks !! stiffness of all bodies
    type(condensed_body_t), intent(inout) :: body !! compliance with springs given; without them
    integer, intent(out) :: outcome !! done or singular
    real(wp), allocatable :: matrix(:, :)
    integer :: i, j, info, pivot(body%m)

    outcome = solver_done
    if (body%m == 0) return
    allocate (matrix(body%m, body%m))
    do i = 1, body%m
      body%compliance(i, i + 1:) = body%compliance(i + 1:, i)
    end do
    do j = 1, body%m
      associate (node => body%node(body%equation(j)), k => body%direction(body%equation(j)))
        matrix(:, j) = 0.0_wp
        if (.not. any(body%fixing_node == node .and. body%fixing_direction == k)) matrix(:, j) = &
          -body%compliance(:, j)*blocks%val(k, k, find_block(blocks, node, node))
        matrix(j, j) = matrix(j, j) + 1.0_wp
      end associate
    end do
    call dgetrf(body%m, body%m, matrix, body%m, pivot, info)
    if (info /= 0) outcome = solver_singular
    if (info == 0) call dgetrs('N', body%m, body%m, matrix, body%m, pivot, body%compliance, &
      body%m, info)
    body%diagonal = [(abs(body%compliance(i, i)), i=1, body%m)]
  end subroutine take_shift_out

  !> Forgets the compliance of the live candidates.
  subroutine drop_live(body)
    type(condensed_body_t), intent(inout) :: body !! the body

    if (body%copied) deallocate (body%live)
    nullify (body%live)
    body%skipped = 0
    if (allocated(body%gathered)) deallocate (body%gathered)
    body%near = near_compliance_t()
    body%copied = .false.
  end subroutine drop_live

  !> Forgets the compliance.
  subroutine drop_compliance(body)
    type(condensed_body_t), intent(inout) :: body !! the body

    call drop_live(body)
    if (associated(body%compliance)) deallocate (body%compliance)
    if (associated(body%trailing)) deallocate (body%trailing)
    body%mirrored = .false.
    body%near = near_compliance_t()
    body%tree = tree_t()
  end subroutine drop_compliance

  !> x = K^-1 b on all free equations of a body, for several b.
  subroutine solve_body(body, b, x, costs, outcome)
    type(condensed_body_t), intent(in) :: body !! factorised
    real(wp), intent(in) :: b(:, :, :) !! (3, nodes, columns) forces [force]
    real(wp), intent(inout) :: x(:, :, :) !! (3, nodes, columns) get the displacements of the body
    !! [length]
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! done or not definite
    real(wp) :: columns(size(body%node), size(b, 3))
    integer :: i

    do i = 1, size(body%node)
      columns(i, :) = b(body%direction(i), body%node(i), :)
    end do
    outcome = solver_done
    if (any(abs(columns) > 0.0_wp)) then
      if (.not. body%solver%definite) outcome = solver_not_definite
      if (outcome == solver_done) call solve_columns(body%solver, columns, costs)
    end if
    do i = 1, size(body%node)
      x(body%direction(i), body%node(i), :) = columns(i, :)
    end do
  end subroutine solve_body

  !> Displacements of all free equations of a body from those of its candidates, if forces act at
  !! these alone.
  subroutine spread_body(body, moved, x, costs)
    type(condensed_body_t), intent(in) :: body !! factorised
    real(wp), intent(in) :: moved(:) !! (m) displacements of the candidates [length]
    real(wp), intent(inout) :: x(:, :) !! (3, nodes) gets the displacements of the body [length]
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp) :: left(size(body%node))
    integer :: i

    if (body%m == 0) return
    left = 0.0_wp
    left(body%equation) = moved
    call complete_solution(body%solver, body%m, left, costs)
    do i = 1, size(left)
      x(body%direction(i), body%node(i)) = left(i)
    end do
  end subroutine spread_body

  !> Displacements of all free equations of a body whose candidates are among the others, from the
  !! forces there.
  subroutine push_body(body, force, x, costs)
    type(condensed_body_t), intent(in) :: body !! factorised
    real(wp), intent(in) :: force(:) !! (m) on the candidates [force]
    real(wp), intent(inout) :: x(:, :) !! (3, nodes) gets the displacements of the body [length]
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp) :: left(size(body%node), 1)
    integer :: i

    left = 0.0_wp
    left(body%equation, 1) = force
    call solve_columns(body%solver, left, costs)
    do i = 1, size(left, 1)
      x(body%direction(i), body%node(i)) = left(i, 1)
    end do
  end subroutine push_body

  !> The first half of a solve: a right-hand side, eliminated down to the candidates.
  subroutine reduce_body(body, b, floor, costs)
    type(condensed_body_t), intent(inout) :: body !! condensed; gets reduced
    real(wp), intent(in) :: b(:, :) !! (3, nodes) forces [force]
    real(wp), intent(in) :: floor !! forces inside that are smaller together are none [force]
    type(cost_t), intent(inout) :: costs !! cost table
    real(wp) :: outside(body%m)
    integer :: i

    if (.not. allocated(body%reduced)) allocate (body%reduced(size(body%node)))
    do i = 1, size(body%reduced)
      body%reduced(i) = b(body%direction(i), body%node(i))
    end do
    outside = body%reduced(body%equation)
    body%reduced(body%equation) = 0.0_wp
    if (norm2(body%reduced) <= floor) then
      body%reduced = 0.0_wp
      body%reduced(body%equation) = outside
      return
    end if
    body%reduced(body%equation) = outside
    call reduce_right(body%solver, body%m, body%reduced, costs)
  end subroutine reduce_body

  !> The second half: displacements of all free equations from those of the candidates and from
  !! what the first half has left of the right-hand side; that goes.
  subroutine complete_body(body, moved, x, costs)
    type(condensed_body_t), intent(inout) :: body !! reduced given
    real(wp), intent(in) :: moved(:) !! (m) displacements of the candidates [length]
    real(wp), intent(inout) :: x(:, :) !! (3, nodes) gets the displacements of the body [length]
    type(cost_t), intent(inout) :: costs !! cost table
    integer :: i

    body%reduced(body%equation) = moved
    call complete_solution(body%solver, body%m, body%reduced, costs)
    do i = 1, size(body%reduced)
      x(body%direction(i), body%node(i)) = body%reduced(i)
    end do
  end subroutine complete_body

  !> A factor that only precedes an iteration is kept in single precision, if it stays near.
  subroutine halve_body(body, costs)
    type(condensed_body_t), intent(inout) :: body !! condensed
    type(cost_t), intent(inout) :: costs !! cost table

    call halve_factor(body%solver, body%m, near_enough, costs)
  end subroutine halve_body

  !> The factor of a body of which displacements inside are seldom asked for is kept in single
  !! precision. The squares of a row of a factor make the entry of the matrix on the diagonal; with
  !! springs at fixings that is up to twice what it is without.
  subroutine shrink_body(body, stiffest)
    type(condensed_body_t), intent(inout) :: body !! condensed
    real(wp), intent(in) :: stiffest !! largest entry of the stiffness of all bodies [force/length]

    if (body%m > 0) call shrink_factor(body%solver, body%m, sqrt(2.0_wp*stiffest))
  end subroutine shrink_body

  !> Work of condensing a body, the inverse of its Schur complement with it, over that of one solve.
  real(wp) function body_work(body) result(solves)
    type(condensed_body_t), intent(in) :: body !! analysed
    real(wp) :: work, entries

    call factor_work(body%solver, work, entries)
    solves = (work + 2.0_wp/3.0_wp*real(body%m, wp)**3)/max(4.0_wp*entries, 1.0_wp)
  end function body_work

  !> The factor of a body is worth that threads share it: small ones are the same, to the last
  !! digit, with any number of threads.
  logical function is_worth_sharing(body) result(worth)
    type(condensed_body_t), intent(in) :: body !! analysed
    real(wp) :: work, entries

    call factor_work(body%solver, work, entries)
    worth = work >= large_work
  end function is_worth_sharing

  !> Releases the factor.
  subroutine free_body(body)
    type(condensed_body_t), intent(inout) :: body !! the body

    call drop_compliance(body)
    call body%solver%free()
  end subroutine free_body
end module condensation

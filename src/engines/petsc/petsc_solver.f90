!> Linear systems through PETSc: GMRES to the accuracy that is asked for, on multigrid of the bulk
!! and the exact solution of what contact holds; conjugate gradients where nothing is in contact
!! (doc/theory, "Iterative solution in parallel").
module petsc_solver
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_double, c_null_char, &
    c_associated, c_loc, c_funloc
  use kinds, only: wp
  use costs, only: cost_t, begin_cost, end_cost, count_cost, keep_largest, cost_multigrid, &
    cost_solve, cost_krylov, cost_longest
  use block_matrix, only: block_matrix_t
  use csc_matrix, only: csc_matrix_t
  use back_ends, only: nodal_back_end_t, nodes_t, solver_done, solver_singular, solver_failed
  use petsc_interface, only: petsc_comm_world, vec_destroy
  use petsc_matrix_interface, only: mat_destroy, mat_duplicate, mat_axpy, &
    mat_create_shell, mat_shell_set_operation, with_values, different_pattern, operation_multiply
  use petsc_solver_interface, only: ksp_create, ksp_set_operators, ksp_set_prefix, &
    ksp_from_options, ksp_set_tolerances, ksp_solve, ksp_reason, ksp_iterations, ksp_get_pc, &
    ksp_destroy, pc_set_type, pc_shell_set_apply, pc_shell_set_context
  use petsc_matrices, only: layout_t, make_layout, free_layout, fits_layout, make_matrix, &
    keep_places, tell_modes, make_vector, put_vector, take_vector, multiply_rows, add_ring
  use petsc_faults, only: note
  use petsc_preconditioner, only: preconditioner_t, make_whole, make_block, free_whole, &
    drop_block, free_preconditioner, apply_preconditioner, begin_with_block, end_with_block, &
    multiply_sum
  use petsc_options, only: way_kept, way_renewed, way_algebraic, n_ways
  implicit none
  private
  public :: petsc_t

  !> Iterations after which a way of preconditioning is given up for the next.
  integer(c_int), parameter :: most_petsc_iterations = 120_c_int
  !> Multigrid of a bulk that is not linear is made anew after a solve that took this many
  !! iterations, and this many times those of the first solve with it.
  real(wp), parameter :: aged_share = 1.5_wp
  integer, parameter :: aged_least = 10

  !> Memory of the matrix, multigrid and the vectors of GMRES for one row [byte].
  real(wp), parameter :: row_bytes = 1800.0_wp

  !> Matrices, vectors and what precedes the iterations.
  type, extends(nodal_back_end_t) :: petsc_t
    type(layout_t) :: layout !! whose rows
    type(preconditioner_t), pointer :: precon => null() !! PETSc keeps its address
    type(c_ptr) :: tangent = c_null_ptr !! the matrix; with shares it multiplies and nothing else
    type(c_ptr) :: bulk = c_null_ptr !! that of the bulk
    type(c_ptr) :: contact = c_null_ptr !! contact's share, if it comes apart
    type(c_ptr) :: sum = c_null_ptr !! the sum of the shares, where it is wanted
    logical :: apart = .false. !! the matrix comes as shares
    type(c_ptr) :: method = c_null_ptr !! GMRES or conjugate gradients
    type(c_ptr) :: right = c_null_ptr !! right-hand side
    type(c_ptr) :: answer = c_null_ptr !! solution
    logical, allocatable :: inside(:) !! (mesh nodes) in the block of contact
    logical :: symmetric = .false. !! the matrix is
    logical :: loose = .false. !! the bulk alone is singular
    integer :: way = way_kept !! one of the ways of preconditioning
    integer :: first_count = 0 !! iterations of the first solve with this multigrid, 0: none yet
    logical :: aged = .false. !! it is to be made anew
    integer(c_int) :: fault = 0_c_int !! first error of PETSc
  contains
    procedure :: describe
    procedure :: has_bulk
    procedure :: multiply
    procedure :: analyse
    procedure :: is_analysed
    procedure :: factor_bytes
    procedure :: factorise
    procedure :: solve
    procedure :: forget_pattern
    procedure :: drop_factor
    procedure :: free
  end type petsc_t

contains

  !> Takes a tangent, and the bulk's where multigrid of it is to be made.
  subroutine describe(solver, matrix, bulk, equation, nodes, costs)
    class(petsc_t), intent(inout) :: solver !! gets the matrices
    type(block_matrix_t), intent(in) :: matrix !! tangent of bulk and contact; apart: contact's
    type(block_matrix_t), intent(in) :: bulk !! tangent of the bulk
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(nodes_t), intent(in) :: nodes !! what is known of the nodes
    type(cost_t), intent(inout) :: costs !! cost table
    type(block_matrix_t) :: none

    call begin_cost(costs, cost_solve)
    if (.not. associated(solver%precon)) allocate (solver%precon)
    if (solver%apart .neqv. nodes%apart) call drop_all(solver)
    solver%apart = nodes%apart
    if (nodes%apart) call prepare_layout(solver, bulk, matrix, equation)
    if (.not. nodes%apart) call prepare_layout(solver, matrix, none, equation)
    if (solver%fault /= 0_c_int) return
    solver%symmetric = nodes%symmetric
    solver%loose = nodes%loose
    call keep_places(nodes%x, solver%layout, solver%fault)
    call drop_tangent(solver)
    if (.not. nodes%apart) call make_matrix(solver%layout, matrix, equation, .false., &
      solver%tangent, solver%fault)
    if (nodes%loose) solver%way = max(solver%way, way_renewed)
    if (solver%fault == 0_c_int .and. (.not. c_associated(solver%bulk) .or. (solver%aged .and. &
      .not. nodes%linear)) .and. (solver%way == way_kept .or. nodes%apart)) then
      call free_whole(solver%precon)
      call make_matrix(solver%layout, bulk, equation, .false., solver%bulk, solver%fault)
    end if
    if (nodes%apart .and. solver%fault == 0_c_int) call join_shares(solver, matrix, equation)
    solver%precon%tangent = solver%tangent
    solver%inside = nodes%touched
    call add_ring(matrix, nodes%touched, solver%inside)
    if (nodes%apart) call add_ring(bulk, nodes%touched, solver%inside)
    call end_cost(costs, cost_solve)
  end subroutine describe

  !> Whose rows are whose, anew where other nodes have rows.
  subroutine prepare_layout(solver, graph, more, equation)
    class(petsc_t), intent(inout) :: solver !! gets layout and its vectors
    type(block_matrix_t), intent(in) :: graph !! of the nodes that have rows
    type(block_matrix_t), intent(in) :: more !! more edges of it, if it has nodes
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained

    if (fits_layout(solver%layout, graph)) return
    call drop_all(solver)
    call make_layout(graph, more, equation, solver%layout, solver%fault)
    if (solver%fault == 0_c_int) call make_vector(solver%layout, solver%right, solver%fault)
    if (solver%fault == 0_c_int) call make_vector(solver%layout, solver%answer, solver%fault)
  end subroutine prepare_layout

  !> The tangent as a matrix that multiplies by its shares.
  subroutine join_shares(solver, matrix, equation)
    class(petsc_t), intent(inout) :: solver !! bulk given; gets contact, tangent
    type(block_matrix_t), intent(in) :: matrix !! tangent of contact, without nodes if there is none
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained

    associate (fault => solver%fault, own => int(3*solver%layout%own, c_int), &
               all_rows => int(3*solver%layout%nodes, c_int))
      if (matrix%nodes > 0) call make_matrix(solver%layout, matrix, equation, .true., &
        solver%contact, fault)
      solver%precon%bulk = solver%bulk
      solver%precon%contact = solver%contact
      call note(fault, mat_create_shell(petsc_comm_world, own, own, all_rows, all_rows, &
        c_loc(solver%precon), solver%tangent))
      if (fault == 0_c_int) call note(fault, mat_shell_set_operation(solver%tangent, &
        operation_multiply, c_funloc(multiply_sum)))
    end associate
  end subroutine join_shares

  !> The tangent as one matrix.
  subroutine find_sum(solver, matrix)
    class(petsc_t), intent(inout) :: solver !! may get sum
    type(c_ptr), intent(out) :: matrix !! the tangent

    matrix = solver%tangent
    if (.not. solver%apart) return
    matrix = solver%bulk
    if (.not. c_associated(solver%contact)) return
    associate (fault => solver%fault)
      if (.not. c_associated(solver%sum)) then
        call note(fault, mat_duplicate(solver%bulk, with_values, solver%sum))
        if (fault == 0_c_int) call note(fault, mat_axpy(solver%sum, 1.0_c_double, solver%contact, &
          different_pattern))
      end if
    end associate
    matrix = solver%sum
  end subroutine find_sum

  !> It keeps the bulk's share of a tangent that comes apart.
  logical function has_bulk(solver) result(has)
    class(petsc_t), intent(in) :: solver !! handles

    has = solver%apart .and. c_associated(solver%bulk) .and. solver%fault == 0_c_int
  end function has_bulk

  !> y = A x, or |A| |x|, with A that share.
  subroutine multiply(solver, equation, x, absolute, y)
    class(petsc_t), intent(inout) :: solver !! has it; right is used
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    logical, intent(in) :: absolute !! |A| |x|
    real(wp), intent(out) :: y(:, :) !! (3, nodes) 0 where restrained

    y = 0.0_wp
    call multiply_rows(solver%layout, solver%bulk, equation, x, absolute, solver%right, y, &
      solver%fault)
  end subroutine multiply

  !> There is nothing to analyse: patterns come with the values.
  subroutine analyse(solver, a, costs, outcome)
    class(petsc_t), intent(inout) :: solver !! handles
    type(csc_matrix_t), intent(in), target :: a !! not used: describe has the matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes

    outcome = solver_done
    if (solver%fault /= 0_c_int .or. a%n < 0 .or. costs%count(1) < 0) outcome = solver_failed
  end subroutine analyse

  !> The matrix has been described.
  logical function is_analysed(solver)
    class(petsc_t), intent(in) :: solver !! handles

    is_analysed = c_associated(solver%method)
  end function is_analysed

  !> Memory of matrix, multigrid and vectors on this rank [byte].
  real(wp) function factor_bytes(solver) result(bytes)
    class(petsc_t), intent(in) :: solver !! described

    bytes = 3.0_wp*row_bytes*real(solver%layout%own, wp)
  end function factor_bytes

  !> Makes ready what precedes the iterations.
  subroutine factorise(solver, a, costs, outcome)
    class(petsc_t), intent(inout) :: solver !! described
    type(csc_matrix_t), intent(in), target :: a !! not used: describe has the matrix
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    logical :: failed

    call solver%analyse(a, costs, outcome)
    if (outcome /= solver_done) return
    call make_block(solver%layout, solver%inside .and. solver%way < way_algebraic, solver%precon, &
      failed, solver%fault)
    if (failed) solver%way = max(solver%way, way_algebraic)
    if (solver%fault == 0_c_int) call make_method(solver)
    call prepare_way(solver, costs, outcome)
    if (solver%fault /= 0_c_int) outcome = solver_failed
  end subroutine factorise

  !> What stands for the inverse of the whole matrix, by the first way that has one.
  subroutine prepare_way(solver, costs, outcome)
    class(petsc_t), intent(inout) :: solver !! way may go on
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! done, or singular
    type(c_ptr) :: matrix
    logical :: failed

    outcome = solver_done
    do while (solver%way <= n_ways)
      if (solver%way == way_kept .and. c_associated(solver%precon%whole)) return
      if (solver%way >= way_algebraic) solver%precon%has_block = .false.
      call begin_cost(costs, cost_multigrid)
      matrix = solver%bulk
      if (solver%way /= way_kept) call find_sum(solver, matrix)
      call tell_modes(solver%layout, matrix, .true., solver%fault)
      call make_whole(solver%way, solver%layout, matrix, solver%precon, failed, solver%fault)
      call tell_modes(solver%layout, matrix, .false., solver%fault)
      call end_cost(costs, cost_multigrid)
      solver%first_count = 0
      solver%aged = .false.
      if (.not. failed) return
      solver%way = solver%way + 1
    end do
    solver%way = n_ways
    outcome = solver_singular
  end subroutine prepare_way

  !> The iterative method: conjugate gradients without contact, if the matrix is symmetric.
  subroutine make_method(solver)
    class(petsc_t), intent(inout) :: solver !! gets method
    type(c_ptr) :: pc
    integer(c_int) :: ignored

    associate (fault => solver%fault)
      if (c_associated(solver%method)) ignored = ksp_destroy(solver%method)
      solver%method = c_null_ptr
      call note(fault, ksp_create(petsc_comm_world, solver%method))
      if (fault /= 0_c_int) return
      call note(fault, ksp_set_operators(solver%method, solver%tangent, solver%tangent))
      if (solver%symmetric .and. .not. any(solver%inside)) then
        call note(fault, ksp_set_prefix(solver%method, 'mfec_cg_'//c_null_char))
      else
        call note(fault, ksp_set_prefix(solver%method, 'mfec_gmres_'//c_null_char))
      end if
      call note(fault, ksp_get_pc(solver%method, pc))
      if (fault /= 0_c_int) return
      call note(fault, pc_set_type(pc, 'shell'//c_null_char))
      call note(fault, pc_shell_set_context(pc, c_loc(solver%precon)))
      call note(fault, pc_shell_set_apply(pc, c_funloc(apply_preconditioner)))
      call note(fault, ksp_from_options(solver%method))
    end associate
  end subroutine make_method

  !> x = A^-1 b to the accuracy; a way that does not get there gives way to the next.
  subroutine solve(solver, a, b, x, costs, outcome)
    class(petsc_t), intent(inout) :: solver !! ready
    type(csc_matrix_t), intent(in), target :: a !! not used: describe has the matrix
    real(wp), intent(in), target, contiguous :: b(:) !! (n) right-hand side
    real(wp), intent(inout), target, contiguous :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! one of the outcomes
    logical :: arrived

    call solver%analyse(a, costs, outcome)
    do while (outcome == solver_done)
      call iterate(solver, b, x, costs, arrived)
      if (solver%fault /= 0_c_int) outcome = solver_failed
      if (arrived .or. outcome /= solver_done) exit
      if (solver%way == n_ways) outcome = solver_singular
      if (outcome /= solver_done) exit
      solver%way = solver%way + 1
      call prepare_way(solver, costs, outcome)
    end do
    if (outcome == solver_done .and. .not. all(abs(x) <= huge(1.0_wp))) outcome = solver_singular
  end subroutine solve

  !> The iterations of one solve.
  subroutine iterate(solver, b, x, costs, arrived)
    class(petsc_t), intent(inout) :: solver !! ready
    real(wp), intent(in) :: b(:) !! (n) right-hand side
    real(wp), intent(inout) :: x(:) !! (n) solution
    type(cost_t), intent(inout) :: costs !! cost table
    logical, intent(out) :: arrived !! at the accuracy
    integer(c_int) :: reason, n

    reason = 0_c_int
    n = 0_c_int
    call begin_cost(costs, cost_solve)
    associate (fault => solver%fault)
      call put_vector(solver%layout, b, solver%right, fault)
      call begin_with_block(solver%precon, solver%right, solver%answer, fault)
      call note(fault, ksp_set_tolerances(solver%method, tiny(1.0_c_double), &
        solver%accuracy*norm2(b), 1.0e10_c_double, most_petsc_iterations))
      ! tests ask for more digits by PETSC_OPTIONS
      call note(fault, ksp_from_options(solver%method))
      if (fault == 0_c_int) call note(fault, ksp_solve(solver%method, solver%right, solver%answer))
      if (fault == 0_c_int) call note(fault, ksp_reason(solver%method, reason))
      if (fault == 0_c_int) call note(fault, ksp_iterations(solver%method, n))
      call end_with_block(solver%precon, solver%answer, fault)
      if (fault == 0_c_int) call take_vector(solver%layout, solver%answer, x, fault)
    end associate
    call end_cost(costs, cost_solve)
    call count_cost(costs, cost_krylov, int(n))
    call keep_largest(costs, cost_longest, int(n))
    arrived = reason > 0_c_int
    if (solver%first_count == 0) solver%first_count = int(n)
    solver%aged = solver%aged .or. n > max(aged_least, int(aged_share*real(solver%first_count, wp)))
  end subroutine iterate

  !> Another pattern needs nothing here: it comes with the values.
  subroutine forget_pattern(solver)
    class(petsc_t), intent(inout) :: solver !! handles

    call solver%drop_factor()
  end subroutine forget_pattern

  !> Releases method and block; matrices are made anew with the next values.
  subroutine drop_factor(solver)
    class(petsc_t), intent(inout) :: solver !! handles
    integer(c_int) :: ignored

    if (c_associated(solver%method)) ignored = ksp_destroy(solver%method)
    solver%method = c_null_ptr
    if (associated(solver%precon)) call drop_block(solver%precon)
  end subroutine drop_factor

  !> Releases the tangent, and the method, which would keep it.
  subroutine drop_tangent(solver)
    class(petsc_t), intent(inout) :: solver !! keeps the bulk's
    integer(c_int) :: ignored

    call solver%drop_factor()
    if (c_associated(solver%tangent)) ignored = mat_destroy(solver%tangent)
    if (c_associated(solver%contact)) ignored = mat_destroy(solver%contact)
    if (c_associated(solver%sum)) ignored = mat_destroy(solver%sum)
    solver%tangent = c_null_ptr
    solver%contact = c_null_ptr
    solver%sum = c_null_ptr
  end subroutine drop_tangent

  !> Releases all that depends on whose rows are whose.
  subroutine drop_all(solver)
    class(petsc_t), intent(inout) :: solver !! keeps its way
    integer(c_int) :: ignored

    call drop_tangent(solver)
    call free_preconditioner(solver%precon)
    if (c_associated(solver%bulk)) ignored = mat_destroy(solver%bulk)
    if (c_associated(solver%right)) ignored = vec_destroy(solver%right)
    if (c_associated(solver%answer)) ignored = vec_destroy(solver%answer)
    solver%bulk = c_null_ptr
    solver%right = c_null_ptr
    solver%answer = c_null_ptr
    call free_layout(solver%layout)
  end subroutine drop_all

  !> Releases everything.
  subroutine free(solver)
    class(petsc_t), intent(inout) :: solver !! handles

    if (.not. associated(solver%precon)) return
    call drop_all(solver)
    deallocate (solver%precon)
  end subroutine free
end module petsc_solver

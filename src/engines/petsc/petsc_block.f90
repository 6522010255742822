!> The exact solution of some nodes of a matrix, those that contact holds and one ring around them:
!! each rank has all of it, factorises it and adds what belongs to its own nodes (doc/theory,
!! "Iterative solution in parallel").
module petsc_block
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_double, c_null_char, &
    c_associated, c_f_pointer
  use petsc_interface, only: petsc_comm_world, object_comm, vec_axpy, vec_get_array, &
    vec_restore_array, vec_destroy, is_create, is_create_stride, is_destroy, scatter_create, &
    scatter_to_all, scatter_begin, scatter_end, scatter_destroy, copy_values, insert_values, &
    add_values, scatter_forward, scatter_backward
  use petsc_matrix_interface, only: mat_create_submatrix, mat_create_submatrices, &
    mat_destroy_submatrices, mat_duplicate, mat_axpy, mat_mult, mat_create_vectors, mat_destroy, &
    initial_matrix, with_values, different_pattern
  use petsc_solver_interface, only: pc_create, pc_set_operators, pc_set_prefix, &
    pc_from_options, pc_set_up, pc_failed, pc_apply, pc_destroy
  use petsc_matrices, only: layout_t, make_nodal_vector
  use petsc_faults, only: note
  implicit none
  private
  public :: block_t, gather_block, keep_rows, factorise_block, pick_block, take_rows, &
    answer_block, put_block, free_block

  !> The block; its vectors have the rows of this rank unless said.
  type :: block_t
    type(c_ptr) :: pick = c_null_ptr !! brings the rows of the block together
    type(c_ptr) :: asked = c_null_ptr !! right-hand side
    type(c_ptr) :: answer = c_null_ptr !! solution
    type(c_ptr) :: start = c_null_ptr !! solution with which iterations begin
    type(c_ptr) :: rows = c_null_ptr !! rows of the block of the bulk's share
    type(c_ptr) :: taken = c_null_ptr !! what these answer
    type(c_ptr) :: gather = c_null_ptr !! brings asked to all ranks
    type(c_ptr) :: question = c_null_ptr !! (all rows) to there
    type(c_ptr) :: reply = c_null_ptr !! (all rows) solution
    type(c_ptr) :: matrix = c_null_ptr !! (all rows)
    type(c_ptr) :: inverse = c_null_ptr !! its factor
    integer :: first = 0 !! rows of the ranks before this one
    integer :: own = 0 !! rows of this rank
  end type block_t

contains

  !> The rows and columns of some nodes of a matrix, with those of another one added, and the way of
  !! vectors to it and back.
  subroutine gather_block(layout, inside, a, more, block, fault)
    type(layout_t), intent(in) :: layout !! whose rows; has rest
    logical, intent(in) :: inside(:) !! (mesh nodes) in the block
    type(c_ptr), intent(in) :: a !! the matrix
    type(c_ptr), intent(in) :: more !! the other one, or null
    type(block_t), intent(inout) :: block !! without anything; gets matrix and vectors
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: set, ignored
    integer :: nodes, own

    nodes = count(inside(layout%node))
    own = count(inside(layout%node(layout%first + 1:layout%first + layout%own)))
    block%first = 3*count(inside(layout%node(:layout%first)))
    block%own = 3*own
    call make_nodal_vector(own, nodes, block%asked, fault)
    call make_nodal_vector(own, nodes, block%answer, fault)
    call make_nodal_vector(own, nodes, block%start, fault)
    if (fault == 0_c_int) call note(fault, scatter_to_all(block%asked, block%gather, &
      block%question))
    call sum_parts(layout, inside, a, more, block, fault)
    if (fault /= 0_c_int) return
    call note(fault, mat_create_vectors(block%matrix, block%reply, ignored))
    if (fault == 0_c_int) call note(fault, vec_destroy(ignored))
    call make_set(petsc_comm_world, layout, inside, layout%first, layout%own, set, fault)
    if (fault /= 0_c_int) return
    call note(fault, scatter_create(layout%rest, set, block%asked, c_null_ptr, block%pick))
    call note(fault, is_destroy(set))
  end subroutine gather_block

  !> The matrix, all rows on each rank.
  subroutine sum_parts(layout, inside, a, more, block, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    logical, intent(in) :: inside(:) !! (mesh nodes) in the block
    type(c_ptr), intent(in) :: a !! the matrix
    type(c_ptr), intent(in) :: more !! the other one, or null
    type(block_t), intent(inout) :: block !! has question; gets matrix
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: set, comm, parts
    type(c_ptr), pointer :: part

    if (fault == 0_c_int) call note(fault, object_comm(block%question, comm))
    if (fault /= 0_c_int) return
    call make_set(comm, layout, inside, 0, layout%nodes, set, fault)
    if (fault /= 0_c_int) return
    call note(fault, mat_create_submatrices(a, 1_c_int, set, set, initial_matrix, parts))
    if (fault /= 0_c_int) return
    call c_f_pointer(parts, part)
    call note(fault, mat_duplicate(part, with_values, block%matrix))
    call note(fault, mat_destroy_submatrices(1_c_int, parts))
    if (fault == 0_c_int .and. c_associated(more)) then
      call note(fault, mat_create_submatrices(more, 1_c_int, set, set, initial_matrix, parts))
      if (fault /= 0_c_int) return
      call c_f_pointer(parts, part)
      call note(fault, mat_axpy(block%matrix, 1.0_c_double, part, different_pattern))
      call note(fault, mat_destroy_submatrices(1_c_int, parts))
    end if
    call note(fault, is_destroy(set))
  end subroutine sum_parts

  !> Keeps the rows of the block of the bulk's share, for take_rows.
  subroutine keep_rows(layout, inside, bulk, block, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    logical, intent(in) :: inside(:) !! (mesh nodes) in the block
    type(c_ptr), intent(in) :: bulk !! that share
    type(block_t), intent(inout) :: block !! gets rows, taken
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: set, columns, ignored

    if (fault /= 0_c_int) return
    call make_set(petsc_comm_world, layout, inside, layout%first, layout%own, set, fault)
    if (fault == 0_c_int) call note(fault, is_create_stride(petsc_comm_world, &
      int(3*layout%own, c_int), int(3*layout%first, c_int), 1_c_int, columns))
    if (fault == 0_c_int) call note(fault, mat_create_submatrix(bulk, set, columns, &
      initial_matrix, block%rows))
    if (fault == 0_c_int) call note(fault, mat_create_vectors(block%rows, ignored, block%taken))
    if (fault /= 0_c_int) return
    call note(fault, vec_destroy(ignored))
    call note(fault, is_destroy(columns))
    call note(fault, is_destroy(set))
  end subroutine keep_rows

  !> The rows of those of some nodes that are in the block.
  subroutine make_set(comm, layout, inside, first, n, set, fault)
    type(c_ptr), intent(in) :: comm !! whose set
    type(layout_t), intent(in) :: layout !! whose rows
    logical, intent(in) :: inside(:) !! (mesh nodes) in the block
    integer, intent(in) :: first !! nodes before these, in the order of the rows
    integer, intent(in) :: n !! how many
    type(c_ptr), intent(out) :: set !! the rows
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int), allocatable :: rows(:)
    integer :: i, k

    associate (node => layout%node(first + 1:first + n))
      rows = pack([((int(3*(first + i - 1) + k, c_int), k=0, 2), i=1, n)], &
        [((inside(node(i)), k=0, 2), i=1, n)])
    end associate
    call note(fault, is_create(comm, size(rows, kind=c_int), rows, copy_values, set))
  end subroutine make_set

  !> Its factor.
  subroutine factorise_block(block, failed, fault)
    type(block_t), intent(inout) :: block !! gathered; gets inverse
    logical, intent(out) :: failed !! it is singular
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int) :: status, reason
    type(c_ptr) :: comm

    failed = .false.
    if (fault == 0_c_int) call note(fault, object_comm(block%question, comm))
    if (fault == 0_c_int) call note(fault, pc_create(comm, block%inverse))
    if (fault /= 0_c_int) return
    call note(fault, pc_set_operators(block%inverse, block%matrix, block%matrix))
    call note(fault, pc_set_prefix(block%inverse, 'mfec_block_'//c_null_char))
    call note(fault, pc_from_options(block%inverse))
    if (fault /= 0_c_int) return
    status = pc_set_up(block%inverse)
    reason = 1_c_int
    if (status == 0_c_int) status = pc_failed(block%inverse, reason)
    failed = status /= 0_c_int .or. reason /= 0_c_int
  end subroutine factorise_block

  !> Asks it about a residual.
  subroutine pick_block(block, r, fault)
    type(block_t), intent(in) :: block !! gets asked
    type(c_ptr), intent(in) :: r !! residual of all rows
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, scatter_begin(block%pick, r, block%asked, insert_values, scatter_forward))
    call note(fault, scatter_end(block%pick, r, block%asked, insert_values, scatter_forward))
  end subroutine pick_block

  !> Takes away from what it is asked what the bulk answers to z.
  subroutine take_rows(block, z, fault)
    type(block_t), intent(in) :: block !! has rows; asked becomes less
    type(c_ptr), intent(in) :: z !! of all rows
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, mat_mult(block%rows, z, block%taken))
    call note(fault, vec_axpy(block%asked, -1.0_c_double, block%taken))
  end subroutine take_rows

  !> Its answer to what it has been asked.
  subroutine answer_block(block, answer, fault)
    type(block_t), intent(in) :: block !! has been asked
    type(c_ptr), intent(in) :: answer !! becomes it
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    real(c_double), pointer :: mine(:), all_rows(:)
    type(c_ptr) :: from, to

    call note(fault, scatter_begin(block%gather, block%asked, block%question, insert_values, &
      scatter_forward))
    call note(fault, scatter_end(block%gather, block%asked, block%question, insert_values, &
      scatter_forward))
    call note(fault, pc_apply(block%inverse, block%question, block%reply))
    if (fault /= 0_c_int) return
    call note(fault, vec_get_array(block%reply, from))
    if (fault == 0_c_int) call note(fault, vec_get_array(answer, to))
    if (fault /= 0_c_int) return
    call c_f_pointer(from, all_rows, [block%first + block%own])
    call c_f_pointer(to, mine, [block%own])
    mine = all_rows(block%first + 1:)
    call note(fault, vec_restore_array(answer, to))
    call note(fault, vec_restore_array(block%reply, from))
  end subroutine answer_block

  !> Adds an answer.
  subroutine put_block(block, answer, z, fault)
    type(block_t), intent(in) :: block !! handles
    type(c_ptr), intent(in) :: answer !! an answer of the block
    type(c_ptr), intent(in) :: z !! of all rows; grows by it
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, scatter_begin(block%pick, answer, z, add_values, scatter_backward))
    call note(fault, scatter_end(block%pick, answer, z, add_values, scatter_backward))
  end subroutine put_block

  !> Releases it.
  subroutine free_block(block)
    type(block_t), intent(inout) :: block !! starts anew
    integer(c_int) :: ignored

    if (c_associated(block%inverse)) ignored = pc_destroy(block%inverse)
    if (c_associated(block%matrix)) ignored = mat_destroy(block%matrix)
    if (c_associated(block%rows)) ignored = mat_destroy(block%rows)
    if (c_associated(block%pick)) ignored = scatter_destroy(block%pick)
    if (c_associated(block%gather)) ignored = scatter_destroy(block%gather)
    if (c_associated(block%asked)) ignored = vec_destroy(block%asked)
    if (c_associated(block%answer)) ignored = vec_destroy(block%answer)
    if (c_associated(block%start)) ignored = vec_destroy(block%start)
    if (c_associated(block%taken)) ignored = vec_destroy(block%taken)
    if (c_associated(block%question)) ignored = vec_destroy(block%question)
    if (c_associated(block%reply)) ignored = vec_destroy(block%reply)
    block = block_t()
  end subroutine free_block
end module petsc_block

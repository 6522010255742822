!> What precedes each iteration of GMRES: multigrid, and after it the exact solution of the nodes
!! that contact holds with one ring of nodes around them (doc/theory, "Iterative solution in
!! parallel", eq. (12.18)).
module petsc_preconditioner
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_double, c_null_char, &
    c_associated, c_f_pointer
  use petsc_interface, only: petsc_comm_world, vec_aypx, vec_axpy, vec_zero, vec_destroy
  use petsc_matrix_interface, only: mat_mult, mat_mult_add, mat_shell_get_context, &
    mat_product_clear
  use petsc_solver_interface, only: pc_create, pc_set_operators, pc_set_prefix, &
    pc_from_options, pc_set_up, pc_failed, pc_apply, pc_destroy, pc_shell_get_context, pc_levels, &
    pc_smoother, ksp_operators
  use petsc_matrices, only: layout_t, make_vector
  use petsc_block, only: block_t, gather_block, keep_rows, factorise_block, pick_block, take_rows, &
    answer_block, put_block, free_block
  use petsc_options, only: is_scarce, choose_products, way_renewed, prefixes
  use petsc_faults, only: note
  use parallel, only: any_rank
  implicit none
  private
  public :: preconditioner_t, make_whole, make_block, free_whole, drop_block, &
    free_preconditioner, apply_preconditioner, begin_with_block, end_with_block, multiply_sum

  !> The parts; PETSc knows it by its address.
  type :: preconditioner_t
    type(c_ptr) :: tangent = c_null_ptr !! the matrix, not ours
    type(c_ptr) :: bulk = c_null_ptr !! the bulk's share of it, not ours
    type(c_ptr) :: contact = c_null_ptr !! contact's share of it, not ours; null if there is none
    type(c_ptr) :: whole = c_null_ptr !! what stands for its inverse
    type(block_t) :: block !! what contact holds
    type(c_ptr) :: rest = c_null_ptr !! residual within a pass
    logical :: has_block = .false. !! there is a block
  end type preconditioner_t

contains

  !> What stands for the inverse of a matrix; an older one is released.
  subroutine make_whole(way, layout, a, precon, failed, fault)
    integer, intent(in) :: way !! one of the ways
    type(layout_t), intent(in) :: layout !! whose rows
    type(c_ptr), intent(in) :: a !! the matrix
    type(preconditioner_t), intent(inout) :: precon !! gets whole
    logical, intent(out) :: failed !! there is none
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int) :: status, reason

    failed = .true.
    call free_whole(precon)
    call note(fault, pc_create(petsc_comm_world, precon%whole))
    if (fault /= 0_c_int) return
    call note(fault, pc_set_operators(precon%whole, a, a))
    if (way <= way_renewed) call choose_products(any_rank(is_scarce(layout%nodes)), fault)
    call note(fault, pc_set_prefix(precon%whole, trim(prefixes(way))//c_null_char))
    call note(fault, pc_from_options(precon%whole))
    if (fault /= 0_c_int) return
    ! a matrix that it cannot take is no fault of ours
    status = pc_set_up(precon%whole)
    reason = 1_c_int
    if (status == 0_c_int) status = pc_failed(precon%whole, reason)
    failed = status /= 0_c_int .or. reason /= 0_c_int
    if (failed) call free_whole(precon)
    if (.not. failed .and. way <= way_renewed) call free_products(precon, fault)
  end subroutine make_whole

  !> The matrices of coarser levels keep what they were formed with, for other values: these never
  !! come, for multigrid is made anew then.
  subroutine free_products(precon, fault)
    type(preconditioner_t), intent(in) :: precon !! its multigrid
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: smoother, a, b
    integer(c_int) :: n, level

    n = 0_c_int
    call note(fault, pc_levels(precon%whole, n))
    do level = 0_c_int, n - 2_c_int
      if (fault /= 0_c_int) return
      call note(fault, pc_smoother(precon%whole, level, smoother))
      if (fault == 0_c_int) call note(fault, ksp_operators(smoother, a, b))
      if (fault == 0_c_int) call note(fault, mat_product_clear(b))
    end do
  end subroutine free_products

  !> The block of some nodes of the matrix, and its factor.
  subroutine make_block(layout, inside, precon, failed, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    logical, intent(in) :: inside(:) !! (mesh nodes) in the block
    type(preconditioner_t), intent(inout) :: precon !! tangent, or its shares; gets the block
    logical, intent(out) :: failed !! it is singular
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    failed = .false.
    call drop_block(precon)
    precon%has_block = any(inside)
    if (.not. c_associated(precon%rest)) call make_vector(layout, precon%rest, fault)
    if (.not. precon%has_block .or. fault /= 0_c_int) return
    if (c_associated(precon%bulk)) then
      call gather_block(layout, inside, precon%bulk, precon%contact, precon%block, fault)
      call keep_rows(layout, inside, precon%bulk, precon%block, fault)
    else
      call gather_block(layout, inside, precon%tangent, c_null_ptr, precon%block, fault)
    end if
    call factorise_block(precon%block, failed, fault)
  end subroutine make_block

  !> z = M r, called by PETSc: the whole, and the block on what that leaves.
  integer(c_int) function apply_preconditioner(pc, r, z) bind(c) result(fault)
    type(c_ptr), value :: pc !! the preconditioner
    type(c_ptr), value :: r !! residual
    type(c_ptr), value :: z !! answer
    type(c_ptr) :: address
    type(preconditioner_t), pointer :: precon

    fault = pc_shell_get_context(pc, address)
    if (fault /= 0_c_int) return
    call c_f_pointer(address, precon)
    fault = pc_apply(precon%whole, r, z)
    if (.not. precon%has_block) return
    call ask_block(precon, r, z, fault)
    call answer_block(precon%block, precon%block%answer, fault)
    call put_block(precon%block, precon%block%answer, z, fault)
  end function apply_preconditioner

  !> The iterations begin at the answer of the block, so that no residual has a share in its rows,
  !! then and later.
  subroutine begin_with_block(precon, right, answer, fault)
    type(preconditioner_t), intent(inout) :: precon !! gets start, if there is a block
    type(c_ptr), intent(in) :: right !! right-hand side; becomes the residual there
    type(c_ptr), intent(in) :: answer !! becomes zero
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, vec_zero(answer))
    if (.not. precon%has_block .or. fault /= 0_c_int) return
    call pick_block(precon%block, right, fault)
    call answer_block(precon%block, precon%block%start, fault)
    call put_block(precon%block, precon%block%start, answer, fault)
    call note(fault, mat_mult(precon%tangent, answer, precon%rest))
    call note(fault, vec_axpy(right, -1.0_c_double, precon%rest))
    call note(fault, vec_zero(answer))
  end subroutine begin_with_block

  !> Adds where they have begun.
  subroutine end_with_block(precon, answer, fault)
    type(preconditioner_t), intent(in) :: precon !! has start, if there is a block
    type(c_ptr), intent(in) :: answer !! grows by it
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    if (.not. precon%has_block .or. fault /= 0_c_int) return
    call put_block(precon%block, precon%block%start, answer, fault)
  end subroutine end_with_block

  !> Asks the block about r - A z.
  subroutine ask_block(precon, r, z, fault)
    type(preconditioner_t), intent(in) :: precon !! its block is asked; rest is used
    type(c_ptr), intent(in) :: r !! residual
    type(c_ptr), intent(in) :: z !! answer so far
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    if (.not. c_associated(precon%bulk)) then
      call find_rest(precon, precon%tangent, r, z, fault)
      call pick_block(precon%block, precon%rest, fault)
      return
    end if
    if (c_associated(precon%contact)) then
      call find_rest(precon, precon%contact, r, z, fault)
      call pick_block(precon%block, precon%rest, fault)
    else
      call pick_block(precon%block, r, fault)
    end if
    call take_rows(precon%block, z, fault)
  end subroutine ask_block

  !> y = A x, called by PETSc: the bulk's share and that of contact.
  integer(c_int) function multiply_sum(a, x, y) bind(c) result(fault)
    type(c_ptr), value :: a !! the matrix
    type(c_ptr), value :: x !! vector
    type(c_ptr), value :: y !! product
    type(c_ptr) :: address
    type(preconditioner_t), pointer :: precon

    fault = mat_shell_get_context(a, address)
    if (fault /= 0_c_int) return
    call c_f_pointer(address, precon)
    fault = mat_mult(precon%bulk, x, y)
    if (c_associated(precon%contact)) call note(fault, mat_mult_add(precon%contact, x, y, y))
  end function multiply_sum

  !> rest = r - A z.
  subroutine find_rest(precon, a, r, z, fault)
    type(preconditioner_t), intent(in) :: precon !! gets rest
    type(c_ptr), intent(in) :: a !! the matrix
    type(c_ptr), intent(in) :: r !! residual
    type(c_ptr), intent(in) :: z !! answer so far
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, mat_mult(a, z, precon%rest))
    call note(fault, vec_aypx(precon%rest, -1.0_c_double, r))
  end subroutine find_rest

  !> Releases what stands for the inverse of the whole matrix.
  subroutine free_whole(precon)
    type(preconditioner_t), intent(inout) :: precon !! keeps the rest
    integer(c_int) :: ignored

    if (c_associated(precon%whole)) ignored = pc_destroy(precon%whole)
    precon%whole = c_null_ptr
  end subroutine free_whole

  !> Releases the block.
  subroutine drop_block(precon)
    type(preconditioner_t), intent(inout) :: precon !! keeps the rest

    call free_block(precon%block)
    precon%has_block = .false.
  end subroutine drop_block

  !> Releases everything.
  subroutine free_preconditioner(precon)
    type(preconditioner_t), intent(inout) :: precon !! starts anew
    integer(c_int) :: ignored

    call free_whole(precon)
    call drop_block(precon)
    if (c_associated(precon%rest)) ignored = vec_destroy(precon%rest)
    precon = preconditioner_t()
  end subroutine free_preconditioner
end module petsc_preconditioner

!> What precedes each iteration of GMRES: multigrid, and after it the exact solution of the nodes
!! that contact holds with one ring of nodes around them (doc/theory, "Beyond one machine").
module petsc_preconditioner
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_double, c_null_char, &
    c_associated, c_f_pointer
  use petsc_interface, only: petsc_comm_world, petsc_options_set, vec_aypx, vec_axpy, vec_zero, &
    vec_destroy, is_create, is_create_stride, is_destroy, scatter_create, scatter_begin, &
    scatter_end, scatter_destroy
  use petsc_matrix_interface, only: mat_create_submatrix, mat_destroy, mat_mult, mat_mult_add, &
    mat_axpy, mat_shell_get_context, mat_create_vectors, mat_product_clear
  use petsc_solver_interface, only: pc_create, pc_set_operators, pc_set_prefix, &
    pc_from_options, pc_set_up, pc_failed, pc_apply, pc_destroy, pc_shell_get_context, pc_levels, &
    pc_smoother, ksp_operators
  use petsc_matrices, only: layout_t, make_vector
  use petsc_faults, only: note
  implicit none
  private
  public :: preconditioner_t, set_options, make_whole, make_block, free_whole, free_block, &
    free_preconditioner, apply_preconditioner, begin_with_block, end_with_block, multiply_sum, &
    different_pattern
  public :: way_kept, way_renewed, way_algebraic, way_direct, n_ways

  !> What stands for the inverse of the whole matrix, the cheapest first.
  integer, parameter :: way_kept = 1 !! multigrid of the bulk, kept
  integer, parameter :: way_renewed = 2 !! multigrid of the tangent
  integer, parameter :: way_algebraic = 3 !! BoomerAMG of the tangent
  integer, parameter :: way_direct = 4 !! a factor of the tangent
  integer, parameter :: n_ways = 4
  !> What the options of each begin with.
  character(14), parameter :: prefixes(n_ways) = [character(14) :: 'mfec_kept_', 'mfec_renewed_', &
    'mfec_boomer_', 'mfec_direct_']

  ! petscmat.h, petscvec.h, petscsystypes.h
  integer(c_int), parameter :: initial_matrix = 0_c_int, copy_values = 0_c_int
  integer(c_int), parameter :: different_pattern = 0_c_int
  integer(c_int), parameter :: insert_values = 1_c_int, add_values = 2_c_int
  integer(c_int), parameter :: forward = 0_c_int, backward = 1_c_int

  !> The parts; PETSc knows it by its address.
  type :: preconditioner_t
    type(c_ptr) :: tangent = c_null_ptr !! the matrix, not ours
    type(c_ptr) :: bulk = c_null_ptr !! the bulk's share of it, not ours
    type(c_ptr) :: contact = c_null_ptr !! contact's share of it, not ours; null if there is none
    type(c_ptr) :: whole = c_null_ptr !! what stands for its inverse
    type(c_ptr) :: pick = c_null_ptr !! brings the rows of the block together
    type(c_ptr) :: asked = c_null_ptr !! right-hand side of the block
    type(c_ptr) :: answer = c_null_ptr !! solution of the block
    type(c_ptr) :: block = c_null_ptr !! the block
    type(c_ptr) :: inverse = c_null_ptr !! its factor
    type(c_ptr) :: rows = c_null_ptr !! its rows of the bulk's share
    type(c_ptr) :: taken = c_null_ptr !! what these answer
    type(c_ptr) :: rest = c_null_ptr !! residual within a pass
    type(c_ptr) :: start = c_null_ptr !! answer of the block, with which iterations begin
    logical :: has_block = .false. !! there is a block
  end type preconditioner_t

contains

  !> All options, once.
  subroutine set_options(ranks, fault)
    integer, intent(in) :: ranks !! how many
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer :: k

    do k = way_kept, way_renewed
      call set(trim(prefixes(k))//'pc_type', 'gamg')
    end do
    call set(trim(prefixes(way_algebraic))//'pc_type', 'hypre')
    call set(trim(prefixes(way_algebraic))//'pc_hypre_type', 'boomeramg')
    call set(trim(prefixes(way_direct))//'pc_type', 'lu')
    call set(trim(prefixes(way_direct))//'pc_factor_mat_solver_type', 'mumps')
    if (ranks == 1) then
      call set('mfec_block_pc_type', 'lu')
    else
      ! coarser matrices without the product in between, which would stay beside them; matrices of
      ! one rank know no such way
      call set('matptap_via', 'allatonce')
      call set('mfec_block_pc_type', 'redundant')
      call set('mfec_block_redundant_pc_type', 'lu')
    end if
    call set('mfec_gmres_ksp_type', 'gmres')
    call set('mfec_gmres_ksp_pc_side', 'right')
    call set('mfec_gmres_ksp_gmres_restart', '30')
    call set('mfec_gmres_ksp_gmres_modifiedgramschmidt', '1')
    call set('mfec_cg_ksp_type', 'cg')
    call set('mfec_cg_ksp_norm_type', 'unpreconditioned')

  contains

    !> One option.
    subroutine set(name, value)
      character(*), intent(in) :: name !! without the dash
      character(*), intent(in) :: value !! its value

      call note(fault, petsc_options_set(c_null_ptr, '-'//name//c_null_char, value//c_null_char))
    end subroutine set
  end subroutine set_options

  !> What stands for the inverse of a matrix; an older one is released.
  subroutine make_whole(way, a, precon, failed, fault)
    integer, intent(in) :: way !! one of the ways
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
    integer(c_int) :: status, reason

    call free_block(precon)
    failed = .false.
    precon%has_block = any(inside)
    if (.not. c_associated(precon%rest)) call make_vector(layout, precon%rest, fault)
    if (.not. precon%has_block .or. fault /= 0_c_int) return
    call gather_block(layout, inside, precon, fault)
    call note(fault, pc_create(petsc_comm_world, precon%inverse))
    if (fault /= 0_c_int) return
    call note(fault, pc_set_operators(precon%inverse, precon%block, precon%block))
    call note(fault, pc_set_prefix(precon%inverse, 'mfec_block_'//c_null_char))
    call note(fault, pc_from_options(precon%inverse))
    if (fault /= 0_c_int) return
    status = pc_set_up(precon%inverse)
    reason = 1_c_int
    if (status == 0_c_int) status = pc_failed(precon%inverse, reason)
    failed = status /= 0_c_int .or. reason /= 0_c_int
  end subroutine make_block

  !> The block itself, and the way of vectors to it and back.
  subroutine gather_block(layout, inside, precon, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    logical, intent(in) :: inside(:) !! (mesh nodes) in the block
    type(preconditioner_t), intent(inout) :: precon !! gets block, pick, asked, answer, start
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int), allocatable :: rows(:)
    type(c_ptr) :: set, a, part, ignored
    integer :: i, k

    a = precon%tangent
    if (c_associated(precon%bulk)) a = precon%bulk
    associate (own => layout%node(layout%first + 1:layout%first + layout%own))
      rows = pack([((int(3*(layout%first + i - 1) + k, c_int), k=0, 2), i=1, size(own))], &
        [((inside(own(i)), k=0, 2), i=1, size(own))])
    end associate
    call note(fault, is_create(petsc_comm_world, size(rows, kind=c_int), rows, copy_values, set))
    if (fault /= 0_c_int) return
    call note(fault, mat_create_submatrix(a, set, set, initial_matrix, precon%block))
    if (fault == 0_c_int .and. c_associated(precon%contact)) then
      part = c_null_ptr
      call note(fault, mat_create_submatrix(precon%contact, set, set, initial_matrix, part))
      if (fault == 0_c_int) call note(fault, mat_axpy(precon%block, 1.0_c_double, part, &
        different_pattern))
      if (fault == 0_c_int) call note(fault, mat_destroy(part))
    end if
    if (fault /= 0_c_int) return
    call note(fault, mat_create_vectors(precon%block, precon%answer, precon%asked))
    if (fault == 0_c_int) call note(fault, mat_create_vectors(precon%block, precon%start, ignored))
    if (fault == 0_c_int) call note(fault, vec_destroy(ignored))
    if (fault /= 0_c_int) return
    call note(fault, scatter_create(precon%rest, set, precon%asked, c_null_ptr, precon%pick))
    if (c_associated(precon%bulk)) call pick_rows(layout, set, precon, fault)
    call note(fault, is_destroy(set))
  end subroutine gather_block

  !> The rows of the block, of the bulk's share.
  subroutine pick_rows(layout, set, precon, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    type(c_ptr), intent(in) :: set !! those of the block
    type(preconditioner_t), intent(inout) :: precon !! bulk given; gets rows, taken
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: columns, ignored

    call note(fault, is_create_stride(petsc_comm_world, int(3*layout%own, c_int), &
      int(3*layout%first, c_int), 1_c_int, columns))
    if (fault /= 0_c_int) return
    call note(fault, mat_create_submatrix(precon%bulk, set, columns, initial_matrix, precon%rows))
    if (fault /= 0_c_int) return
    call note(fault, mat_create_vectors(precon%rows, ignored, precon%taken))
    call note(fault, vec_destroy(ignored))
    call note(fault, is_destroy(columns))
  end subroutine pick_rows

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
    call answer_block(precon, precon%answer, z, fault)
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
    call pick_block(precon, right, fault)
    call answer_block(precon, precon%start, answer, fault)
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
    call put_block(precon, precon%start, answer, fault)
  end subroutine end_with_block

  !> asked = r - A z in the rows of the block.
  subroutine ask_block(precon, r, z, fault)
    type(preconditioner_t), intent(in) :: precon !! gets asked; rest is used
    type(c_ptr), intent(in) :: r !! residual
    type(c_ptr), intent(in) :: z !! answer so far
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    if (.not. c_associated(precon%rows)) then
      call find_rest(precon, precon%tangent, r, z, fault)
      call pick_block(precon, precon%rest, fault)
      return
    end if
    if (c_associated(precon%contact)) then
      call find_rest(precon, precon%contact, r, z, fault)
      call pick_block(precon, precon%rest, fault)
    else
      call pick_block(precon, r, fault)
    end if
    call note(fault, mat_mult(precon%rows, z, precon%taken))
    call note(fault, vec_axpy(precon%asked, -1.0_c_double, precon%taken))
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

  !> Asks the block about a residual.
  subroutine pick_block(precon, r, fault)
    type(preconditioner_t), intent(in) :: precon !! gets asked
    type(c_ptr), intent(in) :: r !! residual
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, scatter_begin(precon%pick, r, precon%asked, insert_values, forward))
    call note(fault, scatter_end(precon%pick, r, precon%asked, insert_values, forward))
  end subroutine pick_block

  !> Adds the block's answer to what it has been asked.
  subroutine answer_block(precon, answer, z, fault)
    type(preconditioner_t), intent(in) :: precon !! block, asked
    type(c_ptr), intent(in) :: answer !! (rows of the block) becomes it
    type(c_ptr), intent(in) :: z !! grows
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, pc_apply(precon%inverse, precon%asked, answer))
    call put_block(precon, answer, z, fault)
  end subroutine answer_block

  !> Adds what the block has answered.
  subroutine put_block(precon, answer, z, fault)
    type(preconditioner_t), intent(in) :: precon !! has a block
    type(c_ptr), intent(in) :: answer !! (rows of the block)
    type(c_ptr), intent(in) :: z !! grows by it
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call note(fault, scatter_begin(precon%pick, answer, z, add_values, backward))
    call note(fault, scatter_end(precon%pick, answer, z, add_values, backward))
  end subroutine put_block

  !> Releases what stands for the inverse of the whole matrix.
  subroutine free_whole(precon)
    type(preconditioner_t), intent(inout) :: precon !! keeps the rest
    integer(c_int) :: ignored

    if (c_associated(precon%whole)) ignored = pc_destroy(precon%whole)
    precon%whole = c_null_ptr
  end subroutine free_whole

  !> Releases the block.
  subroutine free_block(precon)
    type(preconditioner_t), intent(inout) :: precon !! keeps the rest
    integer(c_int) :: ignored

    if (c_associated(precon%inverse)) ignored = pc_destroy(precon%inverse)
    if (c_associated(precon%block)) ignored = mat_destroy(precon%block)
    if (c_associated(precon%rows)) ignored = mat_destroy(precon%rows)
    if (c_associated(precon%taken)) ignored = vec_destroy(precon%taken)
    if (c_associated(precon%pick)) ignored = scatter_destroy(precon%pick)
    if (c_associated(precon%asked)) ignored = vec_destroy(precon%asked)
    if (c_associated(precon%answer)) ignored = vec_destroy(precon%answer)
    if (c_associated(precon%start)) ignored = vec_destroy(precon%start)
    precon%inverse = c_null_ptr
    precon%block = c_null_ptr
    precon%rows = c_null_ptr
    precon%taken = c_null_ptr
    precon%pick = c_null_ptr
    precon%asked = c_null_ptr
    precon%answer = c_null_ptr
    precon%start = c_null_ptr
    precon%has_block = .false.
  end subroutine free_block

  !> Releases everything.
  subroutine free_preconditioner(precon)
    type(preconditioner_t), intent(inout) :: precon !! starts anew
    integer(c_int) :: ignored

    call free_whole(precon)
    call free_block(precon)
    if (c_associated(precon%rest)) ignored = vec_destroy(precon%rest)
    precon = preconditioner_t()
  end subroutine free_preconditioner
end module petsc_preconditioner

!> Prototypes of the PETSc routines in use, and nothing else. All of them return 0 when all is well;
!! handles are pointers, by reference where made or freed.
module petsc_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_char, c_funptr
  implicit none
  private
  public :: petsc_comm_world, mpi_comm_rank, mpi_comm_size, mpi_comm_dup, mpi_ibarrier, &
    mpi_test, mpi_abort
  public :: petsc_options_set, petsc_initialize, petsc_finalize, petsc_push_error_handler, &
    petsc_return_error
  public :: mat_create, mat_set_sizes, mat_set_type, mat_set_block_size, mat_preallocate, &
    mat_preallocate_parallel, mat_destroy, mat_set_near_null_space, mat_create_submatrix, &
    mat_get_near_null_space, mat_get_row, mat_restore_row, mat_mult, &
    mat_mult_add, mat_mult_transpose, mat_create_vectors, mat_duplicate, mat_axpy, &
    mat_create_shell, mat_shell_set_operation, mat_shell_get_context
  public :: null_space_rigid_body, null_space_destroy
  public :: vec_create, vec_set_sizes, vec_set_type, vec_set_block_size, &
    vec_destroy, vec_get_array, vec_restore_array, vec_aypx, vec_axpy, vec_zero, vec_max
  public :: scatter_to_all, scatter_create, scatter_begin, scatter_end, scatter_destroy
  public :: is_create, is_create_stride, is_destroy

  !> All ranks: PETSc's own variable, there once it has been initialised.
  type(c_ptr), bind(c, name='PETSC_COMM_WORLD') :: petsc_comm_world

  interface
    !> Number of this rank, from 0.
    integer(c_int) function mpi_comm_rank(comm, rank) bind(c, name='MPI_Comm_rank')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), intent(out) :: rank
    end function mpi_comm_rank

    !> Number of ranks.
    integer(c_int) function mpi_comm_size(comm, ranks) bind(c, name='MPI_Comm_size')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), intent(out) :: ranks
    end function mpi_comm_size

    !> The same ranks, for messages of their own.
    integer(c_int) function mpi_comm_dup(comm, copy) bind(c, name='MPI_Comm_dup')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: copy
    end function mpi_comm_dup

    !> Begins to wait for all ranks.
    integer(c_int) function mpi_ibarrier(comm, request) bind(c, name='MPI_Ibarrier')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: request
    end function mpi_ibarrier

    !> They have come.
    integer(c_int) function mpi_test(request, flag, status) bind(c, name='MPI_Test')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: request
      integer(c_int), intent(out) :: flag
      type(c_ptr), value :: status
    end function mpi_test

    !> Ends all ranks.
    integer(c_int) function mpi_abort(comm, code) bind(c, name='MPI_Abort')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), value :: code
    end function mpi_abort

    !> Sets an option; before or after PetscInitialize.
    integer(c_int) function petsc_options_set(options, name, value) &
      bind(c, name='PetscOptionsSetValue')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: options
      character(kind=c_char), intent(in) :: name(*), value(*)
    end function petsc_options_set

    !> Starts MPI and PETSc.
    integer(c_int) function petsc_initialize() bind(c, name='PetscInitializeNoArguments')
      import :: c_int
      implicit none
    end function petsc_initialize

    !> Ends PETSc and MPI.
    integer(c_int) function petsc_finalize() bind(c, name='PetscFinalize')
      import :: c_int
      implicit none
    end function petsc_finalize

    !> Makes a procedure the one that hears of errors.
    integer(c_int) function petsc_push_error_handler(handler, context) &
      bind(c, name='PetscPushErrorHandler')
      import :: c_int, c_funptr, c_ptr
      implicit none
      type(c_funptr), value :: handler
      type(c_ptr), value :: context
    end function petsc_push_error_handler

    !> The handler that prints nothing and hands the error on.
    integer(c_int) function petsc_return_error(comm, line, fun, file, n, p, message, context) &
      bind(c, name='PetscReturnErrorHandler')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm, fun, file, message, context
      integer(c_int), value :: line, n, p
    end function petsc_return_error

    !> A matrix, empty.
    integer(c_int) function mat_create(comm, a) bind(c, name='MatCreate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: a
    end function mat_create

    !> Rows and columns here and in all.
    integer(c_int) function mat_set_sizes(a, m, n, all_rows, all_columns) &
      bind(c, name='MatSetSizes')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: m, n, all_rows, all_columns
    end function mat_set_sizes

    !> Its format.
    integer(c_int) function mat_set_type(a, name) bind(c, name='MatSetType')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: a
      character(kind=c_char), intent(in) :: name(*)
    end function mat_set_type

    !> Degrees of freedom of a node.
    integer(c_int) function mat_set_block_size(a, n) bind(c, name='MatSetBlockSize')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: n
    end function mat_set_block_size

    !> Copies compressed rows, where there is one rank; else nothing.
    integer(c_int) function mat_preallocate(a, ptr, column, val) &
      bind(c, name='MatSeqAIJSetPreallocationCSR')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: a
      integer(c_int), intent(in) :: ptr(*), column(*)
      real(c_double), intent(in) :: val(*)
    end function mat_preallocate

    !> The same where there are more ranks.
    integer(c_int) function mat_preallocate_parallel(a, ptr, column, val) &
      bind(c, name='MatMPIAIJSetPreallocationCSR')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: a
      integer(c_int), intent(in) :: ptr(*), column(*)
      real(c_double), intent(in) :: val(*)
    end function mat_preallocate_parallel

    !> Releases a matrix.
    integer(c_int) function mat_destroy(a) bind(c, name='MatDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: a
    end function mat_destroy

    !> What multigrid must reproduce.
    integer(c_int) function mat_set_near_null_space(a, space) bind(c, name='MatSetNearNullSpace')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a, space
    end function mat_set_near_null_space

    !> The same, asked for; not to be released.
    integer(c_int) function mat_get_near_null_space(a, space) bind(c, name='MatGetNearNullSpace')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      type(c_ptr), intent(out) :: space
    end function mat_get_near_null_space

    !> One of the rows here.
    integer(c_int) function mat_get_row(a, row, n, columns, values) bind(c, name='MatGetRow')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: row
      integer(c_int), intent(out) :: n
      type(c_ptr), intent(out) :: columns, values
    end function mat_get_row

    !> Gives it back.
    integer(c_int) function mat_restore_row(a, row, n, columns, values) &
      bind(c, name='MatRestoreRow')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: row
      integer(c_int), intent(inout) :: n
      type(c_ptr), intent(inout) :: columns, values
    end function mat_restore_row

    !> Some rows and columns.
    integer(c_int) function mat_create_submatrix(a, rows, columns, reuse, part) &
      bind(c, name='MatCreateSubMatrix')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a, rows, columns
      integer(c_int), value :: reuse
      type(c_ptr), intent(inout) :: part
    end function mat_create_submatrix

    !> y = A x.
    integer(c_int) function mat_mult(a, x, y) bind(c, name='MatMult')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a, x, y
    end function mat_mult

    !> z = y + A x.
    integer(c_int) function mat_mult_add(a, x, y, z) bind(c, name='MatMultAdd')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a, x, y, z
    end function mat_mult_add

    !> y = A^T x.
    integer(c_int) function mat_mult_transpose(a, x, y) bind(c, name='MatMultTranspose')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a, x, y
    end function mat_mult_transpose

    !> A matrix of the same pattern, or a copy.
    integer(c_int) function mat_duplicate(a, what, copy) bind(c, name='MatDuplicate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: what
      type(c_ptr), intent(out) :: copy
    end function mat_duplicate

    !> Y = Y + a X.
    integer(c_int) function mat_axpy(y, a, x, pattern) bind(c, name='MatAXPY')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: y
      real(c_double), value :: a
      type(c_ptr), value :: x
      integer(c_int), value :: pattern
    end function mat_axpy

    !> A matrix that we multiply by ourselves: rows and columns here and in all, what to know.
    integer(c_int) function mat_create_shell(comm, m, n, all_rows, all_columns, context, a) &
      bind(c, name='MatCreateShell')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), value :: m, n, all_rows, all_columns
      type(c_ptr), value :: context
      type(c_ptr), intent(out) :: a
    end function mat_create_shell

    !> The procedure that does something with it.
    integer(c_int) function mat_shell_set_operation(a, what, procedure) &
      bind(c, name='MatShellSetOperation')
      import :: c_int, c_ptr, c_funptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: what
      type(c_funptr), value :: procedure
    end function mat_shell_set_operation

    !> What it is to know; the place to put it.
    integer(c_int) function mat_shell_get_context(a, context) bind(c, name='MatShellGetContext')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      type(c_ptr), intent(out) :: context
    end function mat_shell_get_context

    !> The six rigid motions from coordinates.
    integer(c_int) function null_space_rigid_body(coordinates, space) &
      bind(c, name='MatNullSpaceCreateRigidBody')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: coordinates
      type(c_ptr), intent(out) :: space
    end function null_space_rigid_body

    !> Releases it.
    integer(c_int) function null_space_destroy(space) bind(c, name='MatNullSpaceDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: space
    end function null_space_destroy

    !> A vector, empty.
    integer(c_int) function vec_create(comm, x) bind(c, name='VecCreate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: x
    end function vec_create

    !> Rows here and in all.
    integer(c_int) function vec_set_sizes(x, n, all_rows) bind(c, name='VecSetSizes')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x
      integer(c_int), value :: n, all_rows
    end function vec_set_sizes

    !> Its format.
    integer(c_int) function vec_set_type(x, name) bind(c, name='VecSetType')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: x
      character(kind=c_char), intent(in) :: name(*)
    end function vec_set_type

    !> Degrees of freedom of a node.
    integer(c_int) function vec_set_block_size(x, n) bind(c, name='VecSetBlockSize')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x
      integer(c_int), value :: n
    end function vec_set_block_size

    !> Releases a vector.
    integer(c_int) function vec_destroy(x) bind(c, name='VecDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: x
    end function vec_destroy

    !> Its values here.
    integer(c_int) function vec_get_array(x, values) bind(c, name='VecGetArray')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x
      type(c_ptr), intent(out) :: values
    end function vec_get_array

    !> Gives them back.
    integer(c_int) function vec_restore_array(x, values) bind(c, name='VecRestoreArray')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x
      type(c_ptr), intent(inout) :: values
    end function vec_restore_array

    !> y = x + a y.
    integer(c_int) function vec_aypx(y, a, x) bind(c, name='VecAYPX')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: y, x
      real(c_double), value :: a
    end function vec_aypx

    !> y = y + a x.
    integer(c_int) function vec_axpy(y, a, x) bind(c, name='VecAXPY')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: y, x
      real(c_double), value :: a
    end function vec_axpy

    !> Its largest value, on all ranks.
    integer(c_int) function vec_max(x, place, value) bind(c, name='VecMax')
      import :: c_int, c_ptr, c_double
      implicit none
      type(c_ptr), value :: x, place
      real(c_double), intent(out) :: value
    end function vec_max

    !> x = 0.
    integer(c_int) function vec_zero(x) bind(c, name='VecZeroEntries')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x
    end function vec_zero

    !> The vectors that fit a matrix, from its columns and from its rows.
    integer(c_int) function mat_create_vectors(a, x, y) bind(c, name='MatCreateVecs')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      type(c_ptr), intent(out) :: x, y
    end function mat_create_vectors

    !> What brings some rows of x to y; no rows of y: all of them.
    integer(c_int) function scatter_create(x, rows_of_x, y, rows_of_y, scatter) &
      bind(c, name='VecScatterCreate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x, rows_of_x, y, rows_of_y
      type(c_ptr), intent(out) :: scatter
    end function scatter_create

    !> What brings a vector to all ranks, and the vector that it comes to.
    integer(c_int) function scatter_to_all(x, scatter, whole) bind(c, name='VecScatterCreateToAll')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: x
      type(c_ptr), intent(out) :: scatter, whole
    end function scatter_to_all

    !> Begins to do so.
    integer(c_int) function scatter_begin(scatter, x, y, insert, direction) &
      bind(c, name='VecScatterBegin')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: scatter, x, y
      integer(c_int), value :: insert, direction
    end function scatter_begin

    !> Ends doing so.
    integer(c_int) function scatter_end(scatter, x, y, insert, direction) &
      bind(c, name='VecScatterEnd')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: scatter, x, y
      integer(c_int), value :: insert, direction
    end function scatter_end

    !> Releases it.
    integer(c_int) function scatter_destroy(scatter) bind(c, name='VecScatterDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: scatter
    end function scatter_destroy

    !> A range of rows.
    integer(c_int) function is_create_stride(comm, n, first, step, set) &
      bind(c, name='ISCreateStride')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), value :: n, first, step
      type(c_ptr), intent(out) :: set
    end function is_create_stride

    !> A set of rows.
    integer(c_int) function is_create(comm, n, rows, copy, set) bind(c, name='ISCreateGeneral')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), value :: n, copy
      integer(c_int), intent(in) :: rows(*)
      type(c_ptr), intent(out) :: set
    end function is_create

    !> Releases it.
    integer(c_int) function is_destroy(set) bind(c, name='ISDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: set
    end function is_destroy
  end interface
end module petsc_interface

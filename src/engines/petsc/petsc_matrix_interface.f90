!> Prototypes of PETSc's matrices (Mat) and null spaces in use, and nothing else; what holds for
!! petsc_interface holds here.
module petsc_matrix_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_char, c_funptr
  implicit none
  private
  public :: mat_create, mat_set_sizes, mat_set_type, mat_set_block_size, mat_preallocate, &
    mat_preallocate_parallel, mat_destroy, mat_set_near_null_space, &
    mat_get_row, mat_restore_row, mat_create_submatrix, mat_create_submatrices, &
    mat_destroy_submatrices, mat_mult, mat_mult_add, &
    mat_duplicate, mat_axpy, mat_create_shell, mat_shell_set_operation, &
    mat_shell_get_context, mat_product_clear, null_space_rigid_body, null_space_destroy, &
    mat_create_vectors
  public :: initial_matrix, with_values, different_pattern, operation_multiply

  !> Values of PETSc's enumerations: MatReuse, MatDuplicateOption, MatStructure and MatOperation.
  integer(c_int), parameter :: initial_matrix = 0_c_int, with_values = 1_c_int, &
    different_pattern = 0_c_int, operation_multiply = 3_c_int

  interface
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

    !> Some sets of rows and columns, each whole on this rank.
    integer(c_int) function mat_create_submatrices(a, n, rows, columns, reuse, parts) &
      bind(c, name='MatCreateSubMatrices')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      integer(c_int), value :: n, reuse
      type(c_ptr), intent(in) :: rows, columns
      type(c_ptr), intent(out) :: parts
    end function mat_create_submatrices

    !> Releases these.
    integer(c_int) function mat_destroy_submatrices(n, parts) &
      bind(c, name='MatDestroySubMatrices')
      import :: c_int, c_ptr
      implicit none
      integer(c_int), value :: n
      type(c_ptr), intent(inout) :: parts
    end function mat_destroy_submatrices

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

    !> Gives back what a product of matrices keeps for its next values.
    integer(c_int) function mat_product_clear(a) bind(c, name='MatProductClear')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
    end function mat_product_clear

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

    !> The vectors that fit a matrix, from its columns and from its rows.
    integer(c_int) function mat_create_vectors(a, x, y) bind(c, name='MatCreateVecs')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: a
      type(c_ptr), intent(out) :: x, y
    end function mat_create_vectors
  end interface
end module petsc_matrix_interface

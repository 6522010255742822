!> Prototypes of the PETSc routines in use, and nothing else. All of them return 0 when all is well;
!! handles are pointers, by reference where made or freed.
module petsc_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_double, c_char, c_funptr
  implicit none
  private
  public :: petsc_comm_world, mpi_comm_rank, mpi_comm_size, mpi_comm_dup, mpi_ibarrier, &
    mpi_test, mpi_abort
  public :: petsc_options_set, petsc_initialize, petsc_finalize, petsc_push_error_handler, &
    petsc_return_error, object_comm
  public :: vec_create, vec_set_sizes, vec_set_type, vec_set_block_size, &
    vec_destroy, vec_get_array, vec_restore_array, vec_aypx, vec_axpy, vec_zero, vec_max
  public :: scatter_to_all, scatter_create, scatter_begin, scatter_end, scatter_destroy
  public :: is_create, is_create_stride, is_destroy
  public :: copy_values, insert_values, add_values, scatter_forward, scatter_backward

  !> Values of PETSc's enumerations: CopyMode, InsertMode and ScatterMode.
  integer(c_int), parameter :: copy_values = 0_c_int, insert_values = 1_c_int, &
    add_values = 2_c_int, scatter_forward = 0_c_int, scatter_backward = 1_c_int

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

    !> The ranks that something is shared by.
    integer(c_int) function object_comm(object, comm) bind(c, name='PetscObjectGetComm')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: object
      type(c_ptr), intent(out) :: comm
    end function object_comm

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

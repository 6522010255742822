!> Prototypes of the PETSc routines that part a graph, and nothing else. All of them return 0 when
!! all is well.
module petsc_partition_interface
  use, intrinsic :: iso_c_binding, only: c_ptr, c_int, c_char, c_size_t
  implicit none
  private
  public :: petsc_options_get, mpi_comm_split, mpi_comm_free, is_get, is_restore
  public :: partitioning_create, partitioning_set_adjacency, partitioning_set_type, &
    partitioning_set_parts, partitioning_apply, partitioning_destroy

  interface
    !> An option's text, if it is set.
    integer(c_int) function petsc_options_get(options, before, name, text, length, is_set) &
      bind(c, name='PetscOptionsGetString')
      import :: c_int, c_ptr, c_char, c_size_t
      implicit none
      type(c_ptr), value :: options, before
      character(kind=c_char), intent(in) :: name(*)
      character(kind=c_char), intent(out) :: text(*)
      integer(c_size_t), value :: length
      integer(c_int), intent(inout) :: is_set
    end function petsc_options_get

    !> Ranks of one color among themselves.
    integer(c_int) function mpi_comm_split(comm, color, key, part) bind(c, name='MPI_Comm_split')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      integer(c_int), value :: color, key
      type(c_ptr), intent(out) :: part
    end function mpi_comm_split

    !> Releases them.
    integer(c_int) function mpi_comm_free(comm) bind(c, name='MPI_Comm_free')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: comm
    end function mpi_comm_free

    !> Address of its numbers.
    integer(c_int) function is_get(set, numbers) bind(c, name='ISGetIndices')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: set
      type(c_ptr), intent(out) :: numbers
    end function is_get

    !> Gives the address back.
    integer(c_int) function is_restore(set, numbers) bind(c, name='ISRestoreIndices')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: set
      type(c_ptr), intent(inout) :: numbers
    end function is_restore

    !> What parts a graph.
    integer(c_int) function partitioning_create(comm, parting) &
      bind(c, name='MatPartitioningCreate')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: comm
      type(c_ptr), intent(out) :: parting
    end function partitioning_create

    !> The graph.
    integer(c_int) function partitioning_set_adjacency(parting, graph) &
      bind(c, name='MatPartitioningSetAdjacency')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: parting, graph
    end function partitioning_set_adjacency

    !> Who does it.
    integer(c_int) function partitioning_set_type(parting, name) &
      bind(c, name='MatPartitioningSetType')
      import :: c_int, c_ptr, c_char
      implicit none
      type(c_ptr), value :: parting
      character(kind=c_char), intent(in) :: name(*)
    end function partitioning_set_type

    !> How many parts.
    integer(c_int) function partitioning_set_parts(parting, n) &
      bind(c, name='MatPartitioningSetNParts')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: parting
      integer(c_int), value :: n
    end function partitioning_set_parts

    !> The part of each row.
    integer(c_int) function partitioning_apply(parting, set) bind(c, name='MatPartitioningApply')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), value :: parting
      type(c_ptr), intent(out) :: set
    end function partitioning_apply

    !> Releases it.
    integer(c_int) function partitioning_destroy(parting) &
      bind(c, name='MatPartitioningDestroy')
      import :: c_int, c_ptr
      implicit none
      type(c_ptr), intent(inout) :: parting
    end function partitioning_destroy
  end interface
end module petsc_partition_interface

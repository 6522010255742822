!> Which rank owns which node: parts of equal size with few edges between them (doc/theory,
!! "Iterative solution in parallel").
!!
!! Every rank parts the whole graph by itself, and all take what the first one has found: what is
!! decided once cannot differ. Results do not hang on it, only the messages that ranks send.
module petsc_partition
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_double, c_char, c_size_t, &
    c_null_char, c_f_pointer
  use process, only: set_variable
  use block_matrix, only: block_matrix_t
  use petsc_faults, only: note
  use petsc_interface, only: petsc_comm_world, mpi_comm_rank, is_destroy, vec_create, &
    vec_set_sizes, vec_set_type, vec_get_array, vec_restore_array, vec_destroy, scatter_to_all, &
    scatter_begin, scatter_end, scatter_destroy, insert_values, scatter_forward
  use petsc_matrix_interface, only: mat_create, mat_set_sizes, mat_set_type, mat_preallocate, &
    mat_destroy
  use petsc_partition_interface, only: petsc_options_get, mpi_comm_split, mpi_comm_free, is_get, &
    is_restore, partitioning_create, partitioning_set_adjacency, partitioning_set_type, &
    partitioning_set_parts, partitioning_apply, partitioning_destroy
  implicit none
  private
  public :: find_owners

  !> Names a file with the owner of each node of the mesh, in their order: for tests.
  character(*), parameter :: option = '-mfec_owners'
  !> Scotch asks this variable for its threads. With more than one it finds another partition each
  !! time.
  character(*), parameter :: threads_of_scotch = 'SCOTCH_PTHREAD_NUMBER'
  !> PETSc's numbers for lack of memory, and for a file that cannot be read.
  integer(c_int), parameter :: out_of_memory = 55_c_int, no_file = 66_c_int

contains

  !> The rank of each node that has rows.
  subroutine find_owners(blocks, more, node, ranks, owner, fault)
    type(block_matrix_t), intent(in) :: blocks !! graph of all nodes of the mesh
    type(block_matrix_t), intent(in) :: more !! more edges of it, if it has nodes
    integer, intent(in) :: node(:) !! (n) those with rows, ascending
    integer, intent(in) :: ranks !! how many
    integer, intent(out) :: owner(:) !! (n) from 0
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    character(:), allocatable :: file

    owner = 0
    if (ranks == 1) return
    call read_option(file, fault)
    if (len(file) > 0) then
      call read_owners(file, blocks%nodes, ranks, node, owner, fault)
    else
      call part_graph(blocks, more, node, ranks, owner, fault)
    end if
    if (fault == 0_c_int) call take_from_first(owner, fault)
  end subroutine find_owners

  !> The file that the option names; empty without it.
  subroutine read_option(file, fault)
    character(:), allocatable, intent(out) :: file !! its path
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer, parameter :: longest_line = 1024
    character(kind=c_char) :: text(longest_line)
    integer(c_int) :: is_set
    integer :: i

    file = ''
    is_set = 0_c_int
    call note(fault, petsc_options_get(c_null_ptr, c_null_ptr, option//c_null_char, text, &
      int(longest_line, c_size_t), is_set))
    if (is_set == 0_c_int) return
    do i = 1, longest_line
      if (text(i) == c_null_char) exit
      file = file//text(i)
    end do
  end subroutine read_option

  !> Owners from a file with one number for each node of the mesh.
  subroutine read_owners(file, nodes, ranks, node, owner, fault)
    character(*), intent(in) :: file !! its path
    integer, intent(in) :: nodes !! of the mesh
    integer, intent(in) :: ranks !! how many
    integer, intent(in) :: node(:) !! (n) those with rows
    integer, intent(out) :: owner(:) !! (n) from 0
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer :: unit, status, all_owners(nodes)

    owner = 0
    open (newunit=unit, file=file, action='read', status='old', iostat=status)
    if (status == 0) then
      read (unit, *, iostat=status) all_owners
      close (unit)
    end if
    if (status /= 0) then
      fault = no_file
      return
    end if
    owner = min(ranks - 1, max(0, all_owners(node)))
  end subroutine read_owners

  !> Owners by Scotch.
  subroutine part_graph(blocks, more, node, ranks, owner, fault)
    type(block_matrix_t), intent(in) :: blocks !! graph of all nodes of the mesh
    type(block_matrix_t), intent(in) :: more !! more edges of it, if it has nodes
    integer, intent(in) :: node(:) !! (n) those with rows
    integer, intent(in) :: ranks !! how many
    integer, intent(out) :: owner(:) !! (n) from 0
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: alone, graph, parting, set, address
    integer(c_int), pointer :: found(:)
    integer(c_int) :: rank
    logical :: set_now

    owner = 0
    call set_variable(threads_of_scotch, '1', set_now)
    if (.not. set_now) call note(fault, out_of_memory)
    call note(fault, mpi_comm_rank(petsc_comm_world, rank))
    call note(fault, mpi_comm_split(petsc_comm_world, rank, 0_c_int, alone))
    if (fault == 0_c_int) call make_graph(blocks, more, node, alone, graph, fault)
    if (fault == 0_c_int) call note(fault, partitioning_create(alone, parting))
    if (fault /= 0_c_int) return
    call note(fault, partitioning_set_adjacency(parting, graph))
    call note(fault, partitioning_set_type(parting, 'ptscotch'//c_null_char))
    call note(fault, partitioning_set_parts(parting, int(ranks, c_int)))
    if (fault == 0_c_int) call note(fault, partitioning_apply(parting, set))
    if (fault /= 0_c_int) return
    call note(fault, is_get(set, address))
    if (fault /= 0_c_int) return
    call c_f_pointer(address, found, [size(owner)])
    owner = int(found)
    call note(fault, is_restore(set, address))
    call note(fault, is_destroy(set))
    call note(fault, partitioning_destroy(parting))
    call note(fault, mat_destroy(graph))
    call note(fault, mpi_comm_free(alone))
  end subroutine part_graph

  !> The graph as a matrix of this rank alone.
  subroutine make_graph(blocks, more, node, alone, graph, fault)
    type(block_matrix_t), intent(in) :: blocks !! graph of all nodes of the mesh
    type(block_matrix_t), intent(in) :: more !! more edges of it, if it has nodes
    integer, intent(in) :: node(:) !! (n) those with rows
    type(c_ptr), intent(in) :: alone !! this rank alone
    type(c_ptr), intent(out) :: graph !! the matrix
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int) :: ptr(size(node) + 1), n
    integer(c_int), allocatable :: column(:)
    real(c_double), allocatable :: val(:)
    integer, allocatable :: around(:)
    integer :: place(blocks%nodes), pass, i

    place = 0
    place(node) = [(i, i=1, size(node))]
    ptr(1) = 0_c_int
    do pass = 1, 2
      do i = 1, size(node)
        around = neighbours(blocks, more, place, node(i))
        ptr(i + 1) = ptr(i) + size(around, kind=c_int)
        if (pass == 2) column(ptr(i) + 1:ptr(i + 1)) = int(around - 1, c_int)
      end do
      if (pass == 1) allocate (column(ptr(size(node) + 1)))
    end do
    allocate (val(size(column)), source=1.0_c_double)
    n = size(node, kind=c_int)
    graph = c_null_ptr
    call note(fault, mat_create(alone, graph))
    if (fault /= 0_c_int) return
    call note(fault, mat_set_sizes(graph, n, n, n, n))
    call note(fault, mat_set_type(graph, 'seqaij'//c_null_char))
    if (fault == 0_c_int) call note(fault, mat_preallocate(graph, ptr, column, val))
  end subroutine make_graph

  !> Places of the nodes around one, itself among them, ascending.
  pure function neighbours(blocks, more, place, node) result(around)
    type(block_matrix_t), intent(in) :: blocks !! graph of all nodes of the mesh
    type(block_matrix_t), intent(in) :: more !! more edges of it, if it has nodes
    integer, intent(in) :: place(:) !! (nodes) ascending, 0 for those without rows
    integer, intent(in) :: node !! the node
    integer, allocatable :: around(:)
    integer :: k, other

    around = place(blocks%row(blocks%ptr(node):blocks%ptr(node + 1) - 1))
    if (more%nodes == 0) return
    do k = more%ptr(node), more%ptr(node + 1) - 1
      other = place(more%row(k))
      if (other == 0 .or. any(around == other)) cycle
      around = [pack(around, around < other), other, pack(around, around > other)]
    end do
  end function neighbours

  !> All ranks take the numbers of the first one.
  subroutine take_from_first(numbers, fault)
    integer, intent(inout) :: numbers(:) !! those of this rank; then of the first
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: x, scatter, whole, address
    real(c_double), pointer :: values(:)
    integer(c_int) :: rank, own, n

    n = size(numbers, kind=c_int)
    call note(fault, mpi_comm_rank(petsc_comm_world, rank))
    own = merge(n, 0_c_int, rank == 0_c_int)
    call note(fault, vec_create(petsc_comm_world, x))
    if (fault /= 0_c_int) return
    call note(fault, vec_set_sizes(x, own, n))
    call note(fault, vec_set_type(x, 'standard'//c_null_char))
    call note(fault, vec_get_array(x, address))
    if (fault /= 0_c_int) return
    call c_f_pointer(address, values, [own])
    values = real(numbers(:own), c_double)
    call note(fault, vec_restore_array(x, address))
    call note(fault, scatter_to_all(x, scatter, whole))
    if (fault /= 0_c_int) return
    call note(fault, scatter_begin(scatter, x, whole, insert_values, scatter_forward))
    call note(fault, scatter_end(scatter, x, whole, insert_values, scatter_forward))
    call note(fault, vec_get_array(whole, address))
    if (fault /= 0_c_int) return
    call c_f_pointer(address, values, [n])
    numbers = nint(values)
    call note(fault, vec_restore_array(whole, address))
    call note(fault, scatter_destroy(scatter))
    call note(fault, vec_destroy(whole))
    call note(fault, vec_destroy(x))
  end subroutine take_from_first
end module petsc_partition

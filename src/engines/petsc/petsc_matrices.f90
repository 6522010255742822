!> Matrices and vectors of nodal blocks on the ranks of PETSc: who owns which node, and the way of
!! values there and back.
!!
!! Every rank holds all of mfec's values; each hands on the rows of its own nodes. Restrained
!! degrees of freedom stay as rows with nothing but their diagonal, so that each node has three.
module petsc_matrices
  use, intrinsic :: iso_c_binding, only: c_ptr, c_null_ptr, c_int, c_double, c_null_char, &
    c_associated, c_f_pointer
  use kinds, only: wp
  use block_matrix, only: block_matrix_t
  use petsc_interface, only: petsc_comm_world, mpi_comm_rank, mpi_comm_size, vec_create, &
    vec_set_sizes, vec_set_type, vec_set_block_size, vec_destroy, vec_get_array, &
    vec_restore_array, vec_zero, scatter_to_all, scatter_begin, scatter_end, scatter_destroy, &
    insert_values, scatter_forward
  use petsc_matrix_interface, only: mat_create, mat_set_sizes, mat_set_type, mat_set_block_size, &
    mat_preallocate, mat_preallocate_parallel, mat_get_row, mat_restore_row, mat_destroy, &
    mat_set_near_null_space, null_space_rigid_body, null_space_destroy
  use petsc_faults, only: note
  use petsc_partition, only: find_owners
  implicit none
  private
  public :: layout_t, make_layout, free_layout, fits_layout, make_matrix, keep_places, &
    tell_modes, make_vector, make_nodal_vector, put_vector, take_vector, multiply_rows, add_ring

  !> Which rows are whose.
  type :: layout_t
    integer :: nodes = 0 !! nodes with rows, in all
    integer :: first = 0 !! nodes of the ranks before this one
    integer :: own = 0 !! nodes of this rank
    integer, allocatable :: place(:) !! (mesh nodes) number from 1 in the order of the rows, or 0
    integer, allocatable :: node(:) !! (nodes) mesh node of each
    integer, allocatable :: row(:) !! (equations) row of each, from 0
    type(c_ptr) :: scatter = c_null_ptr !! brings a vector to all ranks
    type(c_ptr) :: whole = c_null_ptr !! the vector that it comes to
    type(c_ptr) :: rest = c_null_ptr !! (rows) the nodes at rest [length]
  end type layout_t

contains

  !> Gives each rank its part of the nodes: numbered part by part, within a part in their order.
  subroutine make_layout(blocks, more, equation, layout, fault)
    type(block_matrix_t), intent(in) :: blocks !! graph
    type(block_matrix_t), intent(in) :: more !! more edges of it, if it has nodes
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(layout_t), intent(inout) :: layout !! made anew
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int) :: rank, ranks
    type(c_ptr) :: x
    integer, allocatable :: owner(:)
    integer :: i, k

    call free_layout(layout)
    call note(fault, mpi_comm_rank(petsc_comm_world, rank))
    call note(fault, mpi_comm_size(petsc_comm_world, ranks))
    if (fault /= 0_c_int) return
    layout%node = pack([(i, i=1, blocks%nodes)], blocks%ptr(2:) > blocks%ptr(:blocks%nodes))
    layout%nodes = size(layout%node)
    allocate (owner(layout%nodes))
    call find_owners(blocks, more, layout%node, int(ranks), owner, fault)
    if (fault /= 0_c_int) return
    layout%node = [(pack(layout%node, owner == i), i=0, int(ranks) - 1)]
    layout%first = count(owner < rank)
    layout%own = count(owner == rank)
    allocate (layout%place(blocks%nodes), layout%row(maxval(equation)), source=0)
    do i = 1, layout%nodes
      layout%place(layout%node(i)) = i
      do k = 1, 3
        if (equation(k, layout%node(i)) > 0) layout%row(equation(k, layout%node(i))) = &
          3*(i - 1) + k - 1
      end do
    end do
    call make_vector(layout, x, fault)
    if (fault /= 0_c_int) return
    call note(fault, scatter_to_all(x, layout%scatter, layout%whole))
    call note(fault, vec_destroy(x))
  end subroutine make_layout

  !> The nodes with rows are those of a matrix.
  pure logical function fits_layout(layout, blocks) result(fits)
    type(layout_t), intent(in) :: layout !! whose rows
    type(block_matrix_t), intent(in) :: blocks !! graph

    fits = allocated(layout%place)
    if (fits) fits = all((layout%place > 0) .eqv. (blocks%ptr(2:) > blocks%ptr(:blocks%nodes)))
  end function fits_layout

  !> Releases what is PETSc's.
  subroutine free_layout(layout)
    type(layout_t), intent(inout) :: layout !! starts anew
    integer(c_int) :: ignored

    if (c_associated(layout%scatter)) ignored = scatter_destroy(layout%scatter)
    if (c_associated(layout%whole)) ignored = vec_destroy(layout%whole)
    if (c_associated(layout%rest)) ignored = vec_destroy(layout%rest)
    layout = layout_t()
  end subroutine free_layout

  !> The rows of this rank of a matrix of blocks; an older matrix is released. What is added to
  !! another one has nothing where restrained, nor at nodes without rows: they are.
  subroutine make_matrix(layout, blocks, equation, added, a, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    type(block_matrix_t), intent(in) :: blocks !! values
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    logical, intent(in) :: added !! it is added to another one
    type(c_ptr), intent(inout) :: a !! the matrix
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int), allocatable :: ptr(:), column(:)
    real(c_double), allocatable :: val(:)

    if (c_associated(a)) call note(fault, mat_destroy(a))
    a = c_null_ptr
    call compress_rows(layout, blocks, equation, added, ptr, column, val)
    call note(fault, mat_create(petsc_comm_world, a))
    if (fault /= 0_c_int) return
    call note(fault, mat_set_sizes(a, int(3*layout%own, c_int), int(3*layout%own, c_int), &
      int(3*layout%nodes, c_int), int(3*layout%nodes, c_int)))
    call note(fault, mat_set_block_size(a, 3_c_int))
    call note(fault, mat_set_type(a, 'aij'//c_null_char))
    if (fault /= 0_c_int) return
    call note(fault, mat_preallocate(a, ptr, column, val))
    call note(fault, mat_preallocate_parallel(a, ptr, column, val))
  end subroutine make_matrix

  !> Compressed rows of the nodes of this rank.
  subroutine compress_rows(layout, blocks, equation, added, ptr, column, val)
    type(layout_t), intent(in) :: layout !! whose rows
    type(block_matrix_t), intent(in) :: blocks !! values, by columns; its graph is symmetric
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    logical, intent(in) :: added !! it is added to another one
    integer(c_int), allocatable, intent(out) :: ptr(:) !! first entry of each row, from 0
    integer(c_int), allocatable, intent(out) :: column(:) !! column of each entry, from 0
    real(c_double), allocatable, intent(out) :: val(:) !! values
    integer :: next(layout%own), i, j, k, r, c, node, at, least

    least = merge(0, 1, added)
    allocate (ptr(3*layout%own + 1))
    ptr(1) = 0_c_int
    do i = 1, layout%own
      node = layout%node(layout%first + i)
      associate (around => blocks%row(blocks%ptr(node):blocks%ptr(node + 1) - 1))
        do r = 1, 3
          ptr(3*(i - 1) + r + 1) = ptr(3*(i - 1) + r) + int(3*max(least, &
            count(layout%place(around) > 0)), c_int)
        end do
      end associate
    end do
    allocate (column(ptr(3*layout%own + 1)))
    allocate (val(ptr(3*layout%own + 1)), source=0.0_c_double)
    next = 0
    do j = 1, layout%nodes
      do k = blocks%ptr(layout%node(j)), blocks%ptr(layout%node(j) + 1) - 1
        node = blocks%row(k)
        i = layout%place(node) - layout%first
        if (i < 1 .or. i > layout%own) cycle
        do r = 1, 3
          do c = 1, 3
            at = ptr(3*(i - 1) + r) + next(i) + c
            column(at) = int(3*(j - 1) + c - 1, c_int)
            val(at) = blocks%val(r, c, k)
            if (equation(r, node) > 0 .and. equation(c, layout%node(j)) > 0) cycle
            if (node == layout%node(j) .and. r == c .and. .not. added) cycle
            val(at) = 0.0_c_double
          end do
        end do
        next(i) = next(i) + 3
      end do
    end do
    if (added) return
    do i = 1, layout%own
      if (next(i) > 0) cycle
      do r = 1, 3
        column(ptr(3*(i - 1) + r) + 1:ptr(3*(i - 1) + r) + 3) = &
          [(int(3*(layout%first + i - 1) + c, c_int), c=0, 2)]
      end do
    end do
    call keep_regular(layout, equation, ptr, column, val)
  end subroutine compress_rows

  !> Restrained degrees of freedom without stiffness get some: their rows ask for nothing. So do
  !! those of nodes without an element.
  pure subroutine keep_regular(layout, equation, ptr, column, val)
    type(layout_t), intent(in) :: layout !! whose rows
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    integer(c_int), intent(in) :: ptr(:) !! first entry of each row, from 0
    integer(c_int), intent(in) :: column(:) !! column of each entry, from 0
    real(c_double), intent(inout) :: val(:) !! values
    integer :: i, r, at

    do i = 1, layout%own
      do r = 1, 3
        if (equation(r, layout%node(layout%first + i)) > 0 .and. any(abs(val(ptr(3*(i - 1) + r) &
          + 1:ptr(3*(i - 1) + r + 1))) > 0.0_c_double)) cycle
        do at = ptr(3*(i - 1) + r) + 1, ptr(3*(i - 1) + r + 1)
          if (column(at) == 3*(layout%first + i - 1) + r - 1 .and. val(at) <= 0.0_c_double) &
            val(at) = 1.0_c_double
        end do
      end do
    end do
  end subroutine keep_regular

  !> Keeps where the nodes are at rest, for the rigid motions.
  subroutine keep_places(x, layout, fault)
    real(wp), intent(in) :: x(:, :) !! (3, mesh nodes) positions [length]
    type(layout_t), intent(inout) :: layout !! gets rest
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    real(c_double), pointer :: values(:)
    type(c_ptr) :: array
    integer :: i

    if (c_associated(layout%rest)) return
    call make_vector(layout, layout%rest, fault)
    call note(fault, vec_get_array(layout%rest, array))
    if (fault /= 0_c_int) return
    call c_f_pointer(array, values, [3*layout%own])
    do i = 1, layout%own
      values(3*i - 2:3*i) = x(:, layout%node(layout%first + i))
    end do
    call note(fault, vec_restore_array(layout%rest, array))
  end subroutine keep_places

  !> Tells a matrix the six rigid motions of its nodes, or takes them back: six vectors, which
  !! multigrid asks for only while it is made.
  subroutine tell_modes(layout, a, told, fault)
    type(layout_t), intent(in) :: layout !! has rest
    type(c_ptr), intent(in) :: a !! the matrix
    logical, intent(in) :: told !! it shall know them
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    type(c_ptr) :: space

    space = c_null_ptr
    if (told) call note(fault, null_space_rigid_body(layout%rest, space))
    if (fault /= 0_c_int) return
    call note(fault, mat_set_near_null_space(a, space))
    if (told) call note(fault, null_space_destroy(space))
  end subroutine tell_modes

  !> A vector of the rows, zero.
  subroutine make_vector(layout, x, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    type(c_ptr), intent(out) :: x !! the vector
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    call make_nodal_vector(layout%own, layout%nodes, x, fault)
  end subroutine make_vector

  !> A vector of three rows a node, zero.
  subroutine make_nodal_vector(own, nodes, x, fault)
    integer, intent(in) :: own !! nodes of this rank
    integer, intent(in) :: nodes !! nodes in all
    type(c_ptr), intent(out) :: x !! the vector
    integer(c_int), intent(inout) :: fault !! 0, or the first error

    x = c_null_ptr
    if (fault /= 0_c_int) return
    call note(fault, vec_create(petsc_comm_world, x))
    if (fault /= 0_c_int) return
    call note(fault, vec_set_sizes(x, int(3*own, c_int), int(3*nodes, c_int)))
    call note(fault, vec_set_block_size(x, 3_c_int))
    call note(fault, vec_set_type(x, 'standard'//c_null_char))
    if (fault == 0_c_int) call note(fault, vec_zero(x))
  end subroutine make_nodal_vector

  !> Values of the equations to a vector; it asks for nothing where restrained.
  subroutine put_vector(layout, b, x, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    real(wp), intent(in) :: b(:) !! (equations) values
    type(c_ptr), intent(in) :: x !! the vector
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    real(c_double), pointer :: values(:)
    type(c_ptr) :: array
    integer :: i, at

    call note(fault, vec_get_array(x, array))
    if (fault /= 0_c_int) return
    call c_f_pointer(array, values, [3*layout%own])
    values = 0.0_c_double
    do i = 1, size(layout%row)
      at = layout%row(i) - 3*layout%first
      if (at >= 0 .and. at < 3*layout%own) values(at + 1) = b(i)
    end do
    call note(fault, vec_restore_array(x, array))
  end subroutine put_vector

  !> y = A x, or |A| |x|, row by row, the same on all ranks; 0 where restrained.
  subroutine multiply_rows(layout, a, equation, x, absolute, work, y, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    type(c_ptr), intent(in) :: a !! the matrix
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    real(wp), intent(in) :: x(:, :) !! (3, nodes)
    logical, intent(in) :: absolute !! |A| |x|
    type(c_ptr), intent(in) :: work !! a vector of the rows, destroyed
    real(wp), intent(inout) :: y(:, :) !! (3, nodes)
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    real(c_double), allocatable :: along(:)
    real(c_double), pointer :: values(:)
    type(c_ptr) :: array
    integer :: i

    allocate (along(3*layout%nodes))
    do i = 1, layout%nodes
      along(3*i - 2:3*i) = x(:, layout%node(i))
      where (equation(:, layout%node(i)) == 0) along(3*i - 2:3*i) = 0.0_c_double
    end do
    if (absolute) along = abs(along)
    call note(fault, vec_get_array(work, array))
    if (fault /= 0_c_int) return
    call c_f_pointer(array, values, [3*layout%own])
    do i = 1, 3*layout%own
      values(i) = row_product(a, 3*layout%first + i - 1, along, absolute, fault)
    end do
    call note(fault, vec_restore_array(work, array))
    call note(fault, scatter_begin(layout%scatter, work, layout%whole, insert_values, &
      scatter_forward))
    call note(fault, scatter_end(layout%scatter, work, layout%whole, insert_values, &
      scatter_forward))
    call note(fault, vec_get_array(layout%whole, array))
    if (fault /= 0_c_int) return
    call c_f_pointer(array, values, [3*layout%nodes])
    y = 0.0_wp
    do i = 1, layout%nodes
      where (equation(:, layout%node(i)) > 0) y(:, layout%node(i)) = values(3*i - 2:3*i)
    end do
    call note(fault, vec_restore_array(layout%whole, array))
  end subroutine multiply_rows

  !> One row times a vector, or the sizes of both.
  real(c_double) function row_product(a, row, along, absolute, fault) result(product)
    type(c_ptr), intent(in) :: a !! the matrix
    integer, intent(in) :: row !! one of this rank, from 0
    real(c_double), intent(in) :: along(:) !! (rows) the vector
    logical, intent(in) :: absolute !! sizes
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    integer(c_int), pointer :: column(:)
    real(c_double), pointer :: val(:)
    type(c_ptr) :: columns, vals
    integer(c_int) :: n

    product = 0.0_c_double
    call note(fault, mat_get_row(a, int(row, c_int), n, columns, vals))
    if (fault /= 0_c_int) return
    call c_f_pointer(columns, column, [n])
    call c_f_pointer(vals, val, [n])
    if (absolute) then
      product = sum(abs(val)*along(column + 1))
    else
      product = sum(val*along(column + 1))
    end if
    call note(fault, mat_restore_row(a, int(row, c_int), n, columns, vals))
  end function row_product

  !> Adds the neighbours of some nodes.
  pure subroutine add_ring(matrix, touched, inside)
    type(block_matrix_t), intent(in) :: matrix !! graph, without nodes if there is none
    logical, intent(in) :: touched(:) !! (nodes) these
    logical, intent(inout) :: inside(:) !! (nodes) gets their neighbours
    integer :: j

    if (matrix%nodes == 0) return
    do j = 1, size(touched)
      if (touched(j)) inside(matrix%row(matrix%ptr(j):matrix%ptr(j + 1) - 1)) = .true.
    end do
  end subroutine add_ring

  !> A vector to values of the equations, the same on all ranks.
  subroutine take_vector(layout, x, b, fault)
    type(layout_t), intent(in) :: layout !! whose rows
    type(c_ptr), intent(in) :: x !! the vector
    real(wp), intent(inout) :: b(:) !! (equations) values
    integer(c_int), intent(inout) :: fault !! 0, or the first error
    real(c_double), pointer :: values(:)
    type(c_ptr) :: array

    call note(fault, scatter_begin(layout%scatter, x, layout%whole, insert_values, &
      scatter_forward))
    call note(fault, scatter_end(layout%scatter, x, layout%whole, insert_values, &
      scatter_forward))
    call note(fault, vec_get_array(layout%whole, array))
    if (fault /= 0_c_int) return
    call c_f_pointer(array, values, [3*layout%nodes])
    b = values(layout%row + 1)
    call note(fault, vec_restore_array(layout%whole, array))
  end subroutine take_vector
end module petsc_matrices

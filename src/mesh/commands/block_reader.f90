!> BLOCk: a regular mesh between master points.
module block_reader
  use kinds, only: wp
  use text, only: to_text
  use errors, only: error_t
  use deck_types, only: data_set_t, record_t, location_t, item_number, item_empty
  use records, only: item_integer, item_real, item_count, is_word
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_types, only: mesh_t
  use mesh_building, only: element_origin_t, reserve_nodes, reserve_elements, place_node, &
    place_element, most_mesh_nodes, max_elements, max_coordinate
  use mesh_generation, only: block_t, complete_block, block_nodes, block_elements, block_point, &
    block_tetrahedron, block_fits, check_block
  use cells, only: mirrored, brick
  use cell_geometry, only: left_handed, no_volume
  use coordinates_reader, only: report_second_place
  implicit none
  private
  public :: read_block

  !> What the records of a BLOCk say.
  type :: block_request_t
    type(block_t) :: block !! cells and master points
    integer :: first_node = 0 !! 0: behind the highest so far
    integer :: first_element = 0 !! 0: behind the highest so far
    integer :: material = 0 !! 0: that of the last block, or 1
    integer :: record = 0 !! index of the CART record, 0 if there is none
    logical :: good = .true. !! nothing wrong so far
  end type block_request_t

contains

  !> Reads one BLOCk: `CART n1 n2 n3 ...` and 8 to 27 master points; the elements go to region
  !! `region`.
  subroutine read_block(set, index, region, last_material, mesh, origin, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: index !! its index among the mesh commands
    integer, intent(in) :: region !! region of its elements
    integer, intent(inout) :: last_material !! material of the last block
    type(mesh_t), intent(inout) :: mesh !! the mesh it adds to
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(block_request_t) :: request
    integer :: i, orientation, cell

    if (.not. set%complete) return
    do i = 1, set%count
      if (is_word(set%records(i)%items(1), 'cart')) then
        call read_layout(set%records(i), i, diagnostics, request)
      end if
    end do
    if (request%record == 0) then
      call report_error(diagnostics, set%head%at, 'BLOCk without a CART record', &
        'say CART n1 n2 n3 MATErial m TET4, the cells along the three edges')
      return
    end if
    call read_points(set, diagnostics, request)
    if (.not. request%good) return
    call check_block(request%block, orientation, cell)
    if (orientation == no_volume) then
      call report_error(diagnostics, set%head%at, 'the block is flat, twisted or folded: its '// &
        'Jacobian is zero or changes sign in cell '//to_text(cell), 'master points 1-4 run '// &
        'round the lower face, 5-8 stand above them')
      return
    end if
    if (request%material == 0) request%material = max(1, last_material)
    last_material = request%material
    call put_nodes(set, request, mesh, diagnostics)
    if (request%good .and. request%first_element >= 0) call put_elements(set, index, region, &
      request, orientation == left_handed, mesh, origin, diagnostics)
  end subroutine read_block

  !> Reads `CART n1 n2 n3 [node1 elmt1 mat btype] [MATErial m] [TET4]`.
  subroutine read_layout(record, i, diagnostics, request)
    type(record_t), intent(in) :: record !! the record
    integer, intent(in) :: i !! its index
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(block_request_t), intent(inout) :: request !! what the block asks for
    integer :: numbers(7), n, k

    if (request%record /= 0) call refuse(record%at, 'a second CART record', &
      'give each block its own BLOCk', diagnostics, request)
    request%record = i
    numbers = 0
    n = 0
    do k = 2, item_count(record)
      if (record%items(k)%kind /= item_number .and. record%items(k)%kind /= item_empty) exit
      n = n + 1
      if (n <= 7) numbers(n) = item_integer(record, k)
    end do
    request%block%cells = numbers(:3)
    request%first_node = numbers(4)
    request%first_element = numbers(5)
    request%material = numbers(6)
    if (is_word(record%items(item_count(record)), 'tet10')) request%block%order = 2
    do k = n + 2, item_count(record) - 1
      if (is_word(record%items(k), 'mate')) request%material = item_integer(record, k + 1)
    end do
    if (any(numbers(:3) < 1)) then
      call refuse(record%at, 'a block needs at least one cell along each edge', &
        'say CART n1 n2 n3', diagnostics, request)
    else if (.not. block_fits(request%block, most_mesh_nodes, max_elements)) then
      call refuse(record%at, 'the block is too large', 'a mesh has at most '// &
        to_text(most_mesh_nodes)//' nodes and '//to_text(max_elements)//' elements', diagnostics, &
        request)
    else if (numbers(4) < 0 .or. request%material < 0) then
      call refuse(record%at, 'first node and material of a block cannot be negative', &
        'say CART n1 n2 n3 node1 element1 material 11', diagnostics, request)
    else if (numbers(7) /= 0 .and. numbers(7) /= 11) then
      call refuse(record%at, 'block type '//to_text(numbers(7))//' is not available in this '// &
        'version', 'type 11 makes six tetrahedra of each cell, as TET4 does', diagnostics, request)
    end if
  end subroutine read_layout

  !> Reads the master points; all eight corners must be there.
  subroutine read_points(set, diagnostics, request)
    type(data_set_t), intent(in) :: set !! the data set
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(block_request_t), intent(inout) :: request !! what the block asks for
    logical :: there(27)
    character(:), allocatable :: missing
    integer :: i, c, k

    there = .false.
    do i = 1, set%count
      associate (record => set%records(i))
        if (i == request%record) cycle
        c = item_integer(record, 1)
        if (c < 1 .or. c > 27) then
          call refuse(record%items(1)%at, 'master point '//to_text(c), &
            'points 1 to 8 are the corners, 9 to 27 edges, faces and centre', diagnostics, request)
          cycle
        end if
        if (there(c)) call refuse(record%items(1)%at, 'master point '//to_text(c)// &
          ' is given twice', 'give each once', diagnostics, request)
        there(c) = .true.
        do k = 1, 3
          request%block%point(k, c) = item_real(record, k + 1)
          if (abs(request%block%point(k, c)) > max_coordinate) call refuse(record%at, &
            'a coordinate of master point '//to_text(c)//' is absurdly large', &
            'coordinates lie between -1e100 and 1e100', diagnostics, request)
        end do
      end associate
    end do
    call complete_block(request%block, there)
    if (all(there(:8)) .or. .not. request%good) return
    missing = ''
    do c = 1, 8
      if (.not. there(c)) missing = missing//' '//to_text(c)
    end do
    call refuse(set%head%at, 'master points'//missing//' of the block are missing', &
      'give all eight corners: number x1 x2 x3', diagnostics, request)
  end subroutine read_points

  !> Makes the nodes.
  subroutine put_nodes(set, request, mesh, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    type(block_request_t), intent(inout) :: request !! what the block asks for
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(error_t), allocatable :: error
    integer :: n, count
    real(wp) :: apart

    if (request%first_node == 0) request%first_node = mesh%nodes + 1
    count = block_nodes(request%block)
    ! request%first_node <= 2**31 - 1 - count is not sure yet
    call reserve_nodes(mesh, min(request%first_node, most_mesh_nodes + 1) + count - 1, error)
    if (allocated(error)) then
      call refuse(set%records(request%record)%at, error%message, &
        'give the block a lower first node, or fewer cells', diagnostics, request)
      return
    end if
    do n = 1, count
      call place_node(mesh, request%first_node + n - 1, block_point(request%block, n), apart)
      if (apart > 0.0_wp) then
        call report_second_place(set%records(request%record)%at, request%first_node + n - 1, &
          apart, diagnostics)
        request%good = .false.
        return
      end if
    end do
  end subroutine put_nodes

  !> Makes the elements.
  subroutine put_elements(set, index, region, request, reorder, mesh, origin, diagnostics)
    type(data_set_t), intent(in) :: set !! the data set
    integer, intent(in) :: index !! its index among the mesh commands
    integer, intent(in) :: region !! region of its elements
    type(block_request_t), intent(inout) :: request !! what the block asks for
    logical, intent(in) :: reorder !! the block is left-handed
    type(mesh_t), intent(inout) :: mesh !! the mesh
    type(element_origin_t), intent(inout) :: origin !! where its elements come from
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(error_t), allocatable :: error
    integer :: c, t, e, count
    integer, allocatable :: nodes(:)
    logical :: twice

    if (request%first_element == 0) request%first_element = mesh%elements + 1
    count = block_elements(request%block%cells)
    e = min(request%first_element, max_elements + 1) - 1
    call reserve_elements(mesh, origin, e + count, error)
    if (allocated(error)) then
      call refuse(set%records(request%record)%at, error%message, &
        'give the block a lower first element, or fewer cells', diagnostics, request)
      return
    end if
    do c = 1, product(request%block%cells)
      do t = 1, brick%pieces
        e = e + 1
        nodes = block_tetrahedron(request%block, c, t) + request%first_node - 1
        if (reorder .neqv. mesh%mirrors) nodes = mirrored(nodes)
        call place_element(mesh, origin, e, nodes, request%material, index, request%record, twice)
        if (twice) then
          call report_error(diagnostics, set%records(request%record)%at, 'element '// &
            to_text(e)//' is defined twice', 'give the block another first element')
          return
        end if
        mesh%region(e) = region
      end do
    end do
    if (reorder) call report_note(diagnostics, set%head%at, 'the block is left-handed: '// &
      to_text(count)//' tetrahedra reordered')
  end subroutine put_elements

  !> Reports an error and marks the block as unusable.
  subroutine refuse(at, what, remedy, diagnostics, request)
    type(location_t), intent(in) :: at !! where
    character(*), intent(in) :: what !! what is wrong
    character(*), intent(in) :: remedy !! what would be right
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(block_request_t), intent(inout) :: request !! what the block asks for

    call report_error(diagnostics, at, what, remedy)
    request%good = .false.
  end subroutine refuse
end module block_reader

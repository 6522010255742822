!> ELEMents SPLIt: bricks of eight nodes, each cut into six tetrahedra as a cell of BLOCk is.
module brick_cutting
  use kinds, only: wp
  use text, only: to_text
  use deck_types, only: deck_t, data_set_t
  use records, only: is_word, item_count
  use diagnostics, only: diagnostics_t, report_error
  use key_sorting, only: sort_columns
  use mesh_types, only: mesh_t
  use tetrahedra, only: relative_volume, flat_limit
  use mesh_building, only: element_origin_t
  use mesh_generation, only: cell_tetrahedra
  implicit none
  private
  public :: is_split, brick_tetrahedron, check_bricks, brick_nodes, tetrahedra_of_brick

  !> Nodes of a brick, and tetrahedra it is cut into.
  integer, parameter :: brick_nodes = 8
  integer, parameter :: tetrahedra_of_brick = 6
  !> The faces of a brick; the cut runs from the first corner of each to the third.
  integer, parameter :: face(4, 6) = reshape([1, 2, 3, 4, 5, 6, 7, 8, 1, 2, 6, 5, 4, 3, 7, 8, &
    1, 4, 8, 5, 2, 3, 7, 6], [4, 6])

contains

  !> Whether a data set is an ELEMents SPLIt.
  pure logical function is_split(set)
    type(data_set_t), intent(in) :: set !! the data set

    is_split = .false.
    if (set%command /= 'elem' .or. item_count(set%head) < 2) return
    is_split = is_word(set%head%items(2), 'split')
  end function is_split

  !> Nodes of a tetrahedron of a brick.
  pure function brick_tetrahedron(nodes, t) result(corners)
    integer, intent(in) :: nodes(brick_nodes) !! the brick, numbered as a cell of BLOCk
    integer, intent(in) :: t !! which one, 1 to 6
    integer :: corners(4)

    corners = nodes(cell_tetrahedra(:, t))
  end function brick_tetrahedron

  !> Bricks are neither twisted nor folded, and those that share a face cut it along the same
  !! diagonal, or the mesh would gape there. To be asked before left-handed tetrahedra are turned
  !! round.
  subroutine check_bricks(deck, origin, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    integer, allocatable :: keys(:, :), cuts(:, :), bricks(:), order(:)
    integer :: i, n

    call check_folds(deck, origin, mesh, diagnostics)
    call list_faces(deck, origin, mesh, keys, cuts, bricks)
    call sort_columns(keys, order)
    do i = 2, size(order)
      if (any(keys(:, order(i)) /= keys(:, order(i - 1)))) cycle
      if (all(cuts(:, order(i)) == cuts(:, order(i - 1)))) cycle
      n = bricks(order(i))
      call report_error(diagnostics, deck%mesh(origin%set(n))%records(origin%record(n))%at, &
        'two bricks cut their common face of nodes '//to_text(keys(1, order(i)))//' '// &
        to_text(keys(2, order(i)))//' '//to_text(keys(3, order(i)))//' '// &
        to_text(keys(4, order(i)))//' along different diagonals', 'number all bricks alike, '// &
        'corner 1 of each on the same side, as a cell of BLOCk; or mesh with tetrahedra')
      return
    end do
  end subroutine check_bricks

  !> The tetrahedra of a brick are all right-handed, or all left-handed: else it is twisted or
  !! folded, and they overlap.
  subroutine check_folds(deck, origin, mesh, diagnostics)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    real(wp) :: volume(tetrahedra_of_brick)
    integer :: e, t

    do e = 1, mesh%elements, tetrahedra_of_brick
      if (origin%set(e) == 0) cycle
      if (.not. is_split(deck%mesh(origin%set(e)))) cycle
      associate (ix => mesh%ix(:4, e:e + tetrahedra_of_brick - 1))
        if (any(ix < 1 .or. ix > mesh%nodes)) cycle
        volume = [(relative_volume(mesh%x(:, ix(:, t))), t=1, tetrahedra_of_brick)]
      end associate
      if (all(volume > -flat_limit) .or. all(volume < flat_limit)) cycle
      call report_error(diagnostics, deck%mesh(origin%set(e))%records(origin%record(e))%at, &
        'brick '//to_text(1 + e/tetrahedra_of_brick)//' is twisted or folded', 'corners 1 to 4 '// &
        'run round the lower face, 5 to 8 stand above them')
      return
    end do
  end subroutine check_folds

  !> The faces of all bricks: their nodes in order, and the ends of their cuts.
  subroutine list_faces(deck, origin, mesh, keys, cuts, bricks)
    type(deck_t), intent(in) :: deck !! the deck
    type(element_origin_t), intent(in) :: origin !! where the elements come from
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, allocatable, intent(out) :: keys(:, :) !! (4, faces) nodes, ascending
    integer, allocatable, intent(out) :: cuts(:, :) !! (2, faces) ends of the cut, ascending
    integer, allocatable, intent(out) :: bricks(:) !! (faces) first element of the brick
    logical, allocatable :: split(:)
    integer :: e, f, i, n, nodes(brick_nodes)

    allocate (split(0:size(deck%mesh)), source=.false.)
    do i = 1, size(deck%mesh)
      split(i) = is_split(deck%mesh(i))
    end do
    n = count(split(origin%set(:mesh%elements)))
    allocate (keys(4, n), cuts(2, n), bricks(n))
    n = 0
    do e = 1, mesh%elements, tetrahedra_of_brick
      if (.not. split(origin%set(e))) cycle
      associate (ix => mesh%ix(:, e:e + tetrahedra_of_brick - 1))
        nodes = [ix(1:3, 1), ix(2, 3), ix(2:3, 5), ix(4, 1), ix(3, 3)]
      end associate
      do f = 1, size(face, 2)
        n = n + 1
        keys(:, n) = nodes(face(:, f))
        cuts(:, n) = [minval(keys([1, 3], n)), maxval(keys([1, 3], n))]
        keys(:, n) = in_order(keys(:, n))
        bricks(n) = e
      end do
    end do
  end subroutine list_faces

  !> Four numbers in ascending order.
  pure function in_order(a) result(b)
    integer, intent(in) :: a(4) !! any numbers
    integer :: b(4), i, least

    b = a
    do i = 1, 3
      least = i - 1 + minloc(b(i:), dim=1)
      b([i, least]) = b([least, i])
    end do
  end function in_order
end module brick_cutting

!> ELEMents SPLIt: bricks of eight nodes, each cut into six tetrahedra as a cell of BLOCk is.
module brick_cutting
  use text, only: to_text
  use deck_types, only: deck_t, data_set_t
  use records, only: is_word, item_count
  use diagnostics, only: diagnostics_t, report_error
  use cells, only: brick
  use key_sorting, only: sort_columns, in_order
  use mesh_types, only: mesh_t
  use cell_geometry, only: cell_orientation, right_handed, left_handed
  use mesh_building, only: element_origin_t
  implicit none
  private
  public :: is_split, check_bricks

contains

  !> Whether a data set is an ELEMents SPLIt.
  pure logical function is_split(set)
    type(data_set_t), intent(in) :: set !! the data set

    is_split = .false.
    if (set%command /= 'elem' .or. item_count(set%head) < 2) return
    is_split = is_word(set%head%items(2), 'split')
  end function is_split

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
    integer :: e, t, orientation(brick%pieces)

    do e = 1, mesh%elements, brick%pieces
      if (origin%set(e) == 0) cycle
      if (.not. is_split(deck%mesh(origin%set(e)))) cycle
      associate (ix => mesh%ix(:4, e:e + brick%pieces - 1))
        if (any(ix < 1 .or. ix > mesh%nodes)) cycle
        orientation = [(cell_orientation(mesh%x, ix(:, t)), t=1, brick%pieces)]
      end associate
      if (.not. (any(orientation == right_handed) .and. any(orientation == left_handed))) cycle
      call report_error(diagnostics, deck%mesh(origin%set(e))%records(origin%record(e))%at, &
        'brick '//to_text(1 + e/brick%pieces)//' is twisted or folded', 'corners 1 to 4 '// &
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
    integer :: e, f, i, n, nodes(brick%nodes)

    allocate (split(0:size(deck%mesh)), source=.false.)
    do i = 1, size(deck%mesh)
      split(i) = is_split(deck%mesh(i))
    end do
    n = count(split(origin%set(:mesh%elements)))
    allocate (keys(4, n), cuts(2, n), bricks(n))
    n = 0
    do e = 1, mesh%elements, brick%pieces
      if (.not. split(origin%set(e))) cycle
      associate (ix => mesh%ix(:, e:e + brick%pieces - 1))
        nodes = [ix(1:3, 1), ix(2, 3), ix(2:3, 5), ix(4, 1), ix(3, 3)]
      end associate
      do f = 1, brick%facets
        n = n + 1
        keys(:, n) = nodes(brick%facet(:4, f))
        cuts(:, n) = [minval(keys([1, 3], n)), maxval(keys([1, 3], n))]
        keys(:, n) = in_order(keys(:, n))
        bricks(n) = e
      end do
    end do
  end subroutine list_faces
end module brick_cutting

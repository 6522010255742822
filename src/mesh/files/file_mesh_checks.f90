!> Checks what a mesh file holds, and finds what of it joins the mesh.
module file_mesh_checks
  use kinds, only: wp
  use text, only: to_text, count_noun
  use deck_types, only: location_t
  use source, only: source_t
  use diagnostics, only: diagnostics_t, report_error, report_note
  use mesh_file_types, only: file_mesh_t, rigid_cell
  use tag_table, only: tag_table_t, build_table, find_tag
  use key_sorting, only: sort_columns, in_order
  use near_places, only: join_places
  use cells, only: mirrored, corners_of, shapes
  use cell_geometry, only: cell_orientation, left_handed, no_volume
  implicit none
  private
  public :: file_place_t, check_file_mesh, resolve_nodes, place_in_file

  !> Errors of one kind that are reported one by one.
  integer, parameter :: most_errors = 5

  !> Where a mesh file stands among the files of a deck, and how its parts are numbered.
  type :: file_place_t
    integer :: file = 0 !! number of the file in the source
    type(location_t) :: at !! where the deck names it
    integer, allocatable :: node(:) !! (nodes) deck number, 0 for one that no tetrahedron holds
    integer, allocatable :: element(:) !! (cells) deck number, 0 for what is no tetrahedron
    logical, allocatable :: rigid(:) !! (cells) a rigid facet with nothing behind it
    logical, allocatable :: turned(:) !! (cells) its nodes no longer have the order of the file
  end type file_place_t

contains

  !> Line and column of a character of a file.
  pure recursive type(location_t) function place_in_file(source, file, at) result(place)
    type(source_t), intent(in) :: source !! all files
    integer, intent(in) :: file !! number of the file
    integer, intent(in) :: at !! the character
    integer :: low, high, middle, piece

    place = location_t(file, 1, 1)
    associate (text => source%files(file))
      if (allocated(text%piece_start)) then
        piece = max(1, count(text%piece_start <= at))
        place = place_in_file(source, text%piece_file(piece), at - text%piece_start(piece) &
          + text%piece_at(piece))
        return
      end if
      low = 1
      high = text%lines
      if (high == 0) return
      do while (low < high)
        middle = (low + high + 1)/2
        if (text%first(middle) <= at) then
          low = middle
        else
          high = middle - 1
        end if
      end do
      place%line = low
      place%column = max(1, at - text%first(low) + 1)
    end associate
  end function place_in_file

  !> Replaces node numbers by places in the list of nodes, turns left-handed tetrahedra round, and
  !! reports what is wrong. Afterwards the nodes and elements that join the mesh are marked by 1 in
  !! `place`; a tetrahedron that an MSH 2.2 file repeats points to the first by a negative place.
  subroutine check_file_mesh(place, file, diagnostics, good)
    type(file_place_t), intent(inout) :: place !! gets what joins the mesh
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    logical, intent(out) :: good !! nothing is wrong
    integer :: errors

    errors = diagnostics%errors
    allocate (place%node(file%nodes), place%element(file%cells), source=0)
    allocate (place%turned(file%cells), source=.false.)
    call resolve_nodes(place, file, diagnostics)
    good = diagnostics%errors == errors
    if (.not. good) return
    where (file%dimension(:file%cells) == 3) place%element = 1
    if (.not. any(place%element == 1)) call report_error(diagnostics, &
      place_in_file(diagnostics%source, place%file, 1), 'the file has no tetrahedra', &
      'generate the volume mesh; with physical groups, Gmsh writes only what is in one')
    call check_tetrahedra(place, file, diagnostics)
    call check_doubles(place, file, diagnostics)
    good = diagnostics%errors == errors
    if (good) call mark_nodes(place, file, diagnostics)
  end subroutine check_file_mesh

  !> Replaces the node numbers of the cells by places in the list of nodes.
  subroutine resolve_nodes(place, file, diagnostics)
    type(file_place_t), intent(in) :: place !! knows the file
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! errors
    type(tag_table_t) :: table
    integer :: c, k, n, first, wrong

    call build_table(file%node_tag(:file%nodes), table)
    wrong = 0
    do n = 1, file%nodes
      first = find_tag(table, file%node_tag(n))
      if (first == n) cycle
      if (.not. any(abs(file%x(:, n) - file%x(:, first)) > 0.0_wp)) cycle
      call report(place, file%node_at(n), 'node '//to_text(file%node_tag(n))// &
        ' is defined twice, at different places', 'give each node once', wrong, diagnostics)
    end do
    wrong = 0
    do c = 1, file%cells
      do k = 1, file%nel(c)
        n = find_tag(table, file%ix(k, c))
        if (n == 0) call report(place, file%cell_at(c), 'element '//to_text(file%cell_tag(c))// &
          ' has node '//to_text(file%ix(k, c))//', which the file does not define', &
          'is the file complete? write it again', wrong, diagnostics)
        file%ix(k, c) = n
      end do
    end do
  end subroutine resolve_nodes

  !> Refuses flat tetrahedra, and turns left-handed ones round with a note.
  subroutine check_tetrahedra(place, file, diagnostics)
    type(file_place_t), intent(inout) :: place !! knows the file; gets turned
    type(file_mesh_t), intent(inout) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    integer :: c, wrong, turned, first, orientation

    wrong = 0
    turned = 0
    first = 0
    do c = 1, file%cells
      if (file%dimension(c) < 3) cycle
      orientation = cell_orientation(file%x, file%ix(:, c))
      if (orientation == no_volume) then
        call report(place, file%cell_at(c), 'tetrahedron '//to_text(file%cell_tag(c))// &
          ' is flat', 'its four corners lie in one plane; mesh the volume anew', wrong, &
          diagnostics)
      else if (orientation == left_handed) then
        turned = turned + 1
        if (turned == 1) first = c
      end if
      place%turned(c) = orientation == left_handed
      if (place%turned(c)) file%ix(:, c) = mirrored(file%ix(:, c))
    end do
    if (turned > 0) call report_note(diagnostics, place_in_file(diagnostics%source, place%file, &
      file%cell_at(first)), to_text(turned)//' left-handed tetrahedra reordered, '// &
      'the first is element '//to_text(file%cell_tag(first)))
  end subroutine check_tetrahedra

  !> Finds element numbers that come twice and tetrahedra with the same nodes.
  subroutine check_doubles(place, file, diagnostics)
    type(file_place_t), intent(inout) :: place !! marks what joins the mesh
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! errors and notes
    type(tag_table_t) :: table
    integer, allocatable :: keys(:, :), cells(:), order(:)
    integer :: c, i, n, first, wrong, merged

    call build_table(file%cell_tag(:file%cells), table)
    allocate (cells(count(place%element == 1)))
    allocate (keys(maxval(shapes%corners), size(cells)), source=0)
    n = 0
    wrong = 0
    do c = 1, file%cells
      first = find_tag(table, file%cell_tag(c))
      if (first /= c) call report(place, file%cell_at(c), 'element '// &
        to_text(file%cell_tag(c))//' is defined twice', 'give each element its own number', &
        wrong, diagnostics)
      if (file%dimension(c) < 3) cycle
      n = n + 1
      cells(n) = c
      associate (corners => corners_of(file%ix(:, c)))
        keys(:size(corners), n) = in_order(corners)
      end associate
    end do
    call sort_columns(keys, order)
    wrong = 0
    merged = 0
    first = 1
    do i = 2, n
      if (any(keys(:, order(i)) /= keys(:, order(first)))) then
        first = i
      else if (file%merges .and. file%mark(cells(order(i))) /= file%mark(cells(order(first)))) then
        place%element(cells(order(i))) = -cells(order(first))
        merged = merged + 1
      else
        call report(place, file%cell_at(cells(order(i))), 'tetrahedron '// &
          to_text(file%cell_tag(cells(order(i))))//' has the same nodes as '// &
          to_text(file%cell_tag(cells(order(first)))), 'remove one of the two', wrong, diagnostics)
      end if
    end do
    if (merged > 0) call report_note(diagnostics, place%at, to_text(merged)// &
      ' tetrahedra given once for each of their groups, counted once')
  end subroutine check_doubles

  !> Marks the nodes that tetrahedra hold.
  subroutine mark_nodes(place, file, diagnostics)
    type(file_place_t), intent(inout) :: place !! marks what joins the mesh
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! notes
    integer :: c, n, lost, first

    do c = 1, file%cells
      if (file%dimension(c) == 3) place%node(file%ix(:file%nel(c), c)) = 1
    end do
    call mark_rigid(place, file)
    call note_coincident(place, file, diagnostics)
    lost = count(place%node == 0)
    if (lost == 0) return
    first = 0
    do n = 1, file%nodes
      if (place%node(n) == 0 .and. first == 0) first = n
    end do
    call report_note(diagnostics, place_in_file(diagnostics%source, place%file, &
      file%node_at(first)), count_noun(lost, 'node')//' that no tetrahedron holds left out, '// &
      'the first is node '//to_text(file%node_tag(first)))
  end subroutine mark_nodes

  !> Marks rigid triangles and quadrilaterals that do not lie on tetrahedra, and their nodes by -1.
  subroutine mark_rigid(place, file)
    type(file_place_t), intent(inout) :: place !! marks what joins the mesh; gets rigid
    type(file_mesh_t), intent(in) :: file !! what the file holds
    integer :: c, k

    place%rigid = file%mark(:file%cells) == rigid_cell
    do c = 1, file%cells
      if (.not. place%rigid(c)) cycle
      place%rigid(c) = any(place%node(file%ix(:3, c)) == 0)
    end do
    do c = 1, file%cells
      if (.not. place%rigid(c)) cycle
      do k = 1, file%nel(c)
        associate (node => place%node(file%ix(k, c)))
          if (node == 0) node = -1
        end associate
      end do
    end do
  end subroutine mark_rigid

  !> Notes nodes that lie exactly where another one lies: the bodies around them are parted there.
  subroutine note_coincident(place, file, diagnostics)
    type(file_place_t), intent(in) :: place !! marks what joins the mesh
    type(file_mesh_t), intent(in) :: file !! what the file holds
    type(diagnostics_t), intent(inout) :: diagnostics !! notes
    integer, allocatable :: place_of(:)
    integer :: n, found, first

    call join_places(file%x(:, :file%nodes), 0.0_wp, place_of)
    found = 0
    first = 0
    do n = 1, file%nodes
      if (place_of(n) == n .or. place%node(n) == 0 .or. place%node(place_of(n)) == 0) cycle
      found = found + 1
      if (found == 1) first = n
    end do
    if (found > 0) call report_note(diagnostics, place_in_file(diagnostics%source, place%file, &
      file%node_at(first)), count_noun(found, 'node')//' at the place of another node, the '// &
      'first is node '//to_text(file%node_tag(first))//': the bodies are not joined there')
  end subroutine note_coincident

  !> Reports an error of a kind of which there may be many.
  subroutine report(place, at, what, remedy, wrong, diagnostics)
    type(file_place_t), intent(in) :: place !! knows the file
    integer, intent(in) :: at !! character of the file
    character(*), intent(in) :: what !! what is wrong
    character(*), intent(in) :: remedy !! what would be right
    integer, intent(inout) :: wrong !! errors of this kind so far
    type(diagnostics_t), intent(inout) :: diagnostics !! errors

    wrong = wrong + 1
    if (wrong > most_errors) return
    call report_error(diagnostics, place_in_file(diagnostics%source, place%file, at), what, remedy)
  end subroutine report
end module file_mesh_checks

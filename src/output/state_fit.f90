!> Whether a file of states is one of this deck: the same nodes, elements, pairs, points and facets.
module state_fit
  use, intrinsic :: ieee_arithmetic, only: ieee_is_finite
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text, count_noun
  use contact_types, only: pair_t
  use contact_points, only: count_points
  use model_types, only: model_t
  use hdf5_io, only: hdf5_file_t
  use hdf5_data, only: read_block, series_shape
  use results_state, only: pair_group, defined_coordinates, slave_nodes
  implicit none
  private
  public :: check_fit

  !> Root of this part of the file.
  character(*), parameter :: state_root = '/state/'
  !> Nodes further apart than this share of the model's size are at different places.
  real(wp), parameter :: same_node_share = 1.0e-10_wp
  !> Line end within messages.
  character(1), parameter :: nl = new_line('a')

contains

  !> Refuses a file of another mesh or of other pairs.
  subroutine check_fit(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! what differs

    call check_mesh(file, model, error)
    if (.not. allocated(error)) call check_pairs(file, model, error)
  end subroutine check_fit

  !> Checks that nodes and elements are those of the deck.
  subroutine check_mesh(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! another mesh
    real(wp), allocatable :: x(:, :), here(:, :)
    integer, allocatable :: ix(:, :)
    integer :: dims(3), rank, i

    call series_shape(file, state_root//'coordinates', dims, rank)
    if (dims(2) /= model%mesh%nodes) then
      call raise_other(file, count_noun(dims(2), 'node'), count_noun(model%mesh%nodes, 'node'), &
        error)
      return
    end if
    allocate (x(3, dims(2)))
    call read_block(file, state_root//'coordinates', x, 1, error)
    if (allocated(error)) return
    here = defined_coordinates(model%mesh)
    i = findloc(all(ieee_is_finite(x), 1), .false., 1)
    if (i > 0) then
      call raise_other(file, 'a coordinate of node '//to_text(i)//' that is no number', &
        place(here(:, i)), error)
      return
    end if
    i = maxloc(maxval(abs(x - here), 1), 1)
    if (maxval(abs(x(:, i) - here(:, i))) > same_node_share*maxval(maxval(here, 2) &
      - minval(here, 2))) &
      then
      call raise_other(file, 'node '//to_text(i)//' at '//place(x(:, i)), 'it at '// &
        place(here(:, i)), error)
      return
    end if
    call series_shape(file, state_root//'elements', dims, rank)
    if (dims(2) /= size(model%mesh%ix, 2)) then
      call raise_other(file, count_noun(dims(2), 'element'), &
        count_noun(size(model%mesh%ix, 2), 'element'), error)
      return
    end if
    allocate (ix(dims(1), dims(2)))
    call read_block(file, state_root//'elements', ix, 1, error)
    if (allocated(error)) return
    i = first_other(ix, model%mesh%ix)
    if (i > 0) call raise_other(file, 'other nodes in element '//to_text(i), 'its own', error)
  end subroutine check_mesh

  !> The first element that has other nodes, or 0; lists may have room for more nodes than elements
  !! have.
  pure integer function first_other(ix, other) result(e)
    integer, intent(in) :: ix(:, :), other(:, :) !! nodes of the elements, zeros behind the last
    integer :: n

    n = min(size(ix, 1), size(other, 1))
    do e = 1, size(ix, 2)
      if (any(ix(:n, e) /= other(:n, e)) .or. any(ix(n + 1:, e) > 0) .or. &
        any(other(n + 1:, e) > 0)) return
    end do
    e = 0
  end function first_other

  !> A position as text.
  function place(x) result(t)
    real(wp), intent(in) :: x(3) !! the position [length]
    character(:), allocatable :: t

    t = '('//to_text(x(1))//', '//to_text(x(2))//', '//to_text(x(3))//')'
  end function place

  !> Checks that the contact pairs are those of the deck.
  subroutine check_pairs(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! other pairs
    integer, allocatable :: numbers(:)
    integer :: dims(3), rank, i

    call series_shape(file, state_root//'pairs', dims, rank)
    allocate (numbers(dims(1)))
    call read_block(file, state_root//'pairs', numbers, 1, error)
    if (allocated(error)) return
    do i = 1, size(numbers)
      if (any(model%pairs%number == numbers(i))) cycle
      call raise_other(file, 'a contact pair '//to_text(numbers(i)), 'none of that number', error)
      return
    end do
    do i = 1, size(model%pairs)
      if (any(numbers == model%pairs(i)%number)) then
        call check_pair(file, model%pairs(i), error)
      else
        call raise_other(file, 'no contact pair '//to_text(model%pairs(i)%number), 'one', error)
      end if
      if (allocated(error)) return
    end do
  end subroutine check_pairs

  !> Checks that points and facets of a pair are those of the deck.
  subroutine check_pair(file, pair, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    type(error_t), allocatable, intent(out) :: error !! other points or facets
    integer, allocatable :: nodes(:), facets(:, :)
    character(:), allocatable :: where_it_is
    integer :: dims(3), rank

    where_it_is = ' in pair '//to_text(pair%number)
    call series_shape(file, pair_group(pair%number)//'/host', dims, rank)
    if (dims(1) /= count_points(pair)) then
      call raise_other(file, count_noun(dims(1), 'point')//where_it_is, &
        count_noun(count_points(pair), 'point'), error)
      return
    end if
    call series_shape(file, pair_group(pair%number)//'/nodes', dims, rank)
    if (dims(1) /= size(slave_nodes(pair))) then
      call raise_other(file, 'other slave nodes'//where_it_is, 'its own', error)
      return
    end if
    allocate (nodes(dims(1)))
    call read_block(file, pair_group(pair%number)//'/nodes', nodes, 1, error)
    if (allocated(error)) return
    call series_shape(file, pair_group(pair%number)//'/facets', dims, rank)
    if (dims(2) /= size(pair%surface%facets, 2)) then
      call raise_other(file, count_noun(dims(2), 'master facet')//where_it_is, &
        count_noun(size(pair%surface%facets, 2), 'master facet'), error)
      return
    end if
    allocate (facets(3, dims(2)))
    call read_block(file, pair_group(pair%number)//'/facets', facets, 1, error)
    if (allocated(error)) return
    if (any(nodes /= slave_nodes(pair))) then
      call raise_other(file, 'other slave nodes'//where_it_is, 'its own', error)
    else if (any(facets /= pair%surface%facets)) then
      call raise_other(file, 'other master facets'//where_it_is, 'its own', error)
    end if
  end subroutine check_pair

  !> The error of a file that does not fit the deck.
  subroutine raise_other(file, theirs, ours, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    character(*), intent(in) :: theirs !! what the file has
    character(*), intent(in) :: ours !! what the deck has
    type(error_t), allocatable, intent(out) :: error !! filled

    call raise(error, exit_deck, 'error: '//file%path//' does not fit this deck: it has '// &
      theirs//', the deck has '//ours//nl//'  restart with the mesh and the pairs of the run '// &
      'that wrote the file; loads, supports, materials and friction may differ')
  end subroutine raise_other
end module state_fit

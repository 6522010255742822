!> The restart part of a results file: all that a run needs to go on, bit for bit.
!!
!! Of `STATe LAST` two are kept in turn, so that a run killed while it writes leaves one of them.
module results_state
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck
  use text, only: to_text
  use contact_types, only: pair_t
  use model_types, only: model_t, state_last, state_none
  use result_types, only: saved_state_t
  use hdf5_io, only: hdf5_file_t, open_hdf5, close_hdf5, make_group
  use hdf5_data, only: make_series, write_block, read_block, series_shape, at_end, stored_real, &
    stored_integer
  implicit none
  private
  public :: create_state_part, write_state, read_state

  !> Root of this part of the file.
  character(*), parameter :: root = '/state/'

contains

  !> Makes the empty data sets.
  subroutine create_state_part(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: i

    if (model%output%state == state_none) return
    call make_group(file, '/state', error)
    if (allocated(error)) return
    call make_series(file, root//'step', stored_integer, [integer ::], 1, '1', &
      'number of the end time; 0 or below: not complete', error)
    if (allocated(error)) return
    call make_series(file, root//'time', stored_real, [integer ::], 1, 'time', 'its time', error)
    if (allocated(error)) return
    call make_series(file, root//'increment', stored_real, [integer ::], 1, 'time', &
      'increment size to go on with', error)
    if (allocated(error)) return
    call make_series(file, root//'displacement', stored_real, [3, model%mesh%nodes], 1, 'length', &
      'displacement of all node numbers from 1', error)
    if (allocated(error)) return
    call make_group(file, root//'contact', error)
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call create_pair(file, model%pairs(i), error)
    end do
  end subroutine create_state_part

  !> Makes the empty data sets of one pair.
  subroutine create_pair(file, pair, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(:), allocatable :: group
    integer :: points

    group = pair_group(pair%number)
    points = size(pair%nodes)
    call make_group(file, group, error)
    if (allocated(error)) return
    call make_series(file, group//'/host', stored_integer, [points], 1, '1', &
      'facet of the pair that holds the tip, from 1, 0 for none', error)
    if (allocated(error)) return
    call make_series(file, group//'/status', stored_integer, [points], 1, '1', &
      '-1 off, 0 open, 1 stick, 2 slip', error)
    if (allocated(error)) return
    call make_series(file, group//'/tip', stored_real, [2, points], 1, '1', &
      '(xi, eta) of the tip in its facet', error)
  end subroutine create_pair

  !> Writes one state.
  subroutine write_state(file, model, written, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: written !! states written before this one
    type(saved_state_t), intent(in) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: slot, i

    if (model%output%state == state_none) return
    slot = written + 1
    if (model%output%state == state_last) slot = mod(written, 2) + 1
    call write_block(file, root//'step', [0], slot, error)
    if (allocated(error)) return
    call write_block(file, root//'time', [state%time], slot, error)
    if (allocated(error)) return
    call write_block(file, root//'increment', [state%increment], slot, error)
    if (allocated(error)) return
    call write_block(file, root//'displacement', state%displacement, slot, error)
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call write_pair(file, model%pairs(i)%number, state, i, slot, error)
    end do
    if (allocated(error)) return
    call write_block(file, root//'step', [state%step], slot, error)
  end subroutine write_state

  !> Writes the contact history of one pair.
  subroutine write_pair(file, number, state, pair, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: number !! number of the pair
    type(saved_state_t), intent(in) :: state !! the state
    integer, intent(in) :: pair !! index of the pair
    integer, intent(in) :: slot !! place of the state in the file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: tip(2, size(state%pairs(pair)%points))
    integer :: host(size(tip, 2)), status(size(tip, 2)), i

    associate (points => state%pairs(pair)%points)
      do i = 1, size(points)
        host(i) = points(i)%host
        status(i) = points(i)%status
        tip(:, i) = points(i)%tip
      end do
    end associate
    call write_block(file, pair_group(number)//'/host', host, slot, error)
    if (allocated(error)) return
    call write_block(file, pair_group(number)//'/status', status, slot, error)
    if (allocated(error)) return
    call write_block(file, pair_group(number)//'/tip', tip, slot, error)
  end subroutine write_pair

  !> Reads the state of one end time from a results file.
  subroutine read_state(path, model, step, state, error)
    character(*), intent(in) :: path !! results file
    type(model_t), intent(in) :: model !! the problem; the file must be one of its runs
    integer, intent(in) :: step !! number of the end time, 0 for the last
    type(saved_state_t), intent(out) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! no such file or step, another mesh
    type(error_t), allocatable :: ignored
    type(hdf5_file_t) :: file
    integer :: slot

    call open_hdf5(file, path, error)
    if (allocated(error)) return
    call find_state(file, step, slot, error)
    if (.not. allocated(error)) call check_shapes(file, model, error)
    if (.not. allocated(error)) call read_slot(file, model, slot, state, error)
    call close_hdf5(file, ignored)
  end subroutine read_state

  !> Finds the place of a state.
  subroutine find_state(file, step, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: step !! number of the end time, 0 for the last
    integer, intent(out) :: slot !! its place
    type(error_t), allocatable, intent(out) :: error !! no such step
    integer, allocatable :: steps(:)
    integer :: dims(3), rank

    slot = 0
    call series_shape(file, root//'step', dims, rank)
    allocate (steps(dims(1)))
    call read_block(file, root//'step', steps, 1, error)
    if (allocated(error)) return
    if (size(steps) > 0) then
      slot = maxloc(steps, 1)
      if (step > 0) slot = findloc(steps, step, 1)
      if (slot > 0) then
        if (steps(slot) < 1) slot = 0
      end if
    end if
    if (slot == 0 .and. maxval([0, steps]) == 0) then
      call raise(error, exit_deck, 'error: '//file%path//' holds no state to restart from.'// &
        new_line('a')//'  The run that wrote it had OUTPut STATe NONE, or no end time yet.')
    else if (slot == 0) then
      call raise(error, exit_deck, 'error: '//file%path//' holds no state of step '// &
        to_text(step)//'.'//new_line('a')//'  It holds '//step_list(steps)// &
        '; without --step the last one is taken.')
    end if
  end subroutine find_state

  !> The steps that are there, as text.
  function step_list(steps) result(t)
    integer, intent(in) :: steps(:) !! numbers of end times
    character(:), allocatable :: t
    integer, parameter :: most = 12
    integer :: i

    t = 'step'
    if (size(steps) > 1) t = 'steps'
    do i = 1, min(size(steps), most)
      if (steps(i) > 0) t = t//' '//to_text(steps(i))
    end do
    if (size(steps) > most) t = t//' ... '//to_text(steps(size(steps)))
  end function step_list

  !> Checks that the file belongs to this problem.
  subroutine check_shapes(file, model, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(out) :: error !! another mesh or other pairs
    integer :: dims(3), rank, i

    call series_shape(file, root//'displacement', dims, rank)
    if (dims(2) /= model%mesh%nodes) then
      call raise(error, exit_deck, 'error: '//file%path//' was written with '//to_text(dims(2))// &
        ' nodes, this deck has '//to_text(model%mesh%nodes)//'.'//new_line('a')// &
        '  Restart with the deck that wrote the file; its text is in the file, /run/deck.')
      return
    end if
    do i = 1, size(model%pairs)
      call series_shape(file, pair_group(model%pairs(i)%number)//'/host', dims, rank)
      if (dims(1) == size(model%pairs(i)%nodes)) cycle
      call raise(error, exit_deck, 'error: '//file%path//' was written with '// &
        to_text(dims(1))//' points in pair '//to_text(model%pairs(i)%number)// &
        ', this deck has '//to_text(size(model%pairs(i)%nodes))//'.'//new_line('a')// &
        '  Restart with the deck that wrote the file; its text is in the file, /run/deck.')
      return
    end do
  end subroutine check_shapes

  !> Reads the state at one place.
  subroutine read_slot(file, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! place of the state
    type(saved_state_t), intent(inout) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: step(1), i
    real(wp) :: values(1)

    call read_block(file, root//'step', step, slot, error)
    if (allocated(error)) return
    state%step = step(1)
    call read_block(file, root//'time', values, slot, error)
    if (allocated(error)) return
    state%time = values(1)
    call read_block(file, root//'increment', values, slot, error)
    if (allocated(error)) return
    state%increment = values(1)
    allocate (state%displacement(3, model%mesh%nodes))
    call read_block(file, root//'displacement', state%displacement, slot, error)
    allocate (state%pairs(size(model%pairs)))
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call read_pair(file, model%pairs(i), slot, state, i, error)
    end do
  end subroutine read_slot

  !> Reads the contact history of one pair.
  subroutine read_pair(file, pair, slot, state, index, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: slot !! place of the state
    type(saved_state_t), intent(inout) :: state !! the state
    integer, intent(in) :: index !! index of the pair
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: tip(2, size(pair%nodes))
    integer :: host(size(pair%nodes)), status(size(pair%nodes)), i

    call read_block(file, pair_group(pair%number)//'/host', host, slot, error)
    if (allocated(error)) return
    call read_block(file, pair_group(pair%number)//'/status', status, slot, error)
    if (allocated(error)) return
    call read_block(file, pair_group(pair%number)//'/tip', tip, slot, error)
    if (allocated(error)) return
    allocate (state%pairs(index)%points(size(host)))
    do i = 1, size(host)
      state%pairs(index)%points(i)%host = host(i)
      state%pairs(index)%points(i)%status = status(i)
      state%pairs(index)%points(i)%tip = tip(:, i)
    end do
  end subroutine read_pair

  !> Group of a pair.
  function pair_group(number) result(group)
    integer, intent(in) :: number !! number of the pair
    character(:), allocatable :: group

    group = root//'contact/'//to_text(number)
  end function pair_group
end module results_state

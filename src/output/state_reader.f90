!> Reads the restart part of a results file, and refuses one that does not fit the deck.
module state_reader
  use kinds, only: wp
  use errors, only: error_t, raise, exit_deck, exit_resources
  use text, only: to_text
  use friction_laws, only: keeps_path, path_state
  use contact_types, only: pair_t
  use contact_parameters, only: has_multipliers
  use contact_points, only: count_points, most_coupled
  use model_types, only: model_t
  use result_types, only: saved_state_t, pair_history_t
  use hdf5_io, only: hdf5_file_t, open_hdf5, close_hdf5, exists_in
  use hdf5_data, only: read_block, series_shape
  use results_state, only: pair_group, state_mark
  use state_checks, only: check_state
  use state_fit, only: check_fit
  use cell_state, only: read_cells
  use path_state, only: read_before
  use factor_state, only: read_factor
  use scene_state, only: read_scene
  use rigid_state, only: read_rigid_motions
  implicit none
  private
  public :: read_state

  !> Root of this part of the file.
  character(*), parameter :: root = '/state/'
  !> Line end within messages.
  character(1), parameter :: nl = new_line('a')

contains

  !> Reads the state of one end time from a results file; of a run that has been stopped before its
  !! first one the step is 0, and that is all.
  subroutine read_state(path, model, step, state, error)
    character(*), intent(in) :: path !! results file, or one that SAVE has written
    type(model_t), intent(in) :: model !! the problem; the file must be one of its runs
    integer, intent(in) :: step !! number of the end time, 0 for the last
    type(saved_state_t), intent(out) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! no such file or step, another mesh
    type(error_t), allocatable :: ignored
    type(hdf5_file_t) :: file
    integer :: slot

    call open_states(path, file, error)
    if (allocated(error)) return
    call find_state(file, step, slot, error)
    if (.not. allocated(error)) then
      call check_fit(file, model, error)
      if (allocated(error)) then
        if (error%code == exit_resources) call raise_damaged(path, error)
      end if
    end if
    if (.not. allocated(error) .and. slot > 0) then
      call read_whole(file, model, slot, state, error)
      if (allocated(error) .and. step == 0) call read_earlier(file, model, slot, state, error)
      if (.not. allocated(error)) call check_state(path, model, state, error)
    end if
    call close_hdf5(file, ignored)
  end subroutine read_state

  !> Reads the state at one place and holds it against its sum.
  subroutine read_whole(file, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! place of the state
    type(saved_state_t), intent(out) :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! it is not whole

    call read_slot(file, model, slot, state, error)
    if (.not. allocated(error)) call check_sum(file, slot, state%step, error)
    if (allocated(error)) call raise_damaged(file%path, error)
  end subroutine read_whole

  !> Reads the last of the earlier states that is whole: while HDF5 splits a list of blocks, a run
  !! that is killed may take the last states with it.
  subroutine read_earlier(file, model, last, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: last !! place of the last state, which is not whole
    type(saved_state_t), intent(inout) :: state !! the state; its note says that it is not the last
    type(error_t), allocatable, intent(inout) :: error !! that of the last; stays if none is whole
    type(error_t), allocatable :: trouble
    integer, allocatable :: steps(:)
    integer :: dims(3), rank, slot, bound

    call series_shape(file, root//'step', dims, rank)
    allocate (steps(dims(1)), source=0)
    call read_block(file, root//'step', steps, 1, trouble)
    bound = steps(last)
    do
      slot = maxloc(steps, 1, mask=steps > 0 .and. steps < bound)
      if (slot == 0) return
      call read_whole(file, model, slot, state, trouble)
      if (.not. allocated(trouble)) exit
      bound = steps(slot)
    end do
    state%note = 'the state of step '//to_text(steps(last))//' in '//file%path//' is not whole '// &
      '(its run was killed while it wrote, or something has changed the file): that of step '// &
      to_text(state%step)//' is taken'
    deallocate (error)
  end subroutine read_earlier

  !> Says that a state cannot be taken, and why.
  subroutine raise_damaged(path, error)
    character(*), intent(in) :: path !! the file
    type(error_t), allocatable, intent(inout) :: error !! what was wrong; then the whole message
    character(:), allocatable :: why

    why = error%message
    if (index(why, 'error: ') == 1) why = why(8:)
    if (index(why, nl) > 0) why = why(:index(why, nl) - 1)
    call raise(error, exit_deck, 'error: the state in '//path//' cannot be read: the file is '// &
      'damaged or cut off, or something has changed it'//nl//'  '//why//nl// &
      '  restart from an earlier --step')
  end subroutine raise_damaged

  !> Opens a file and says why it cannot serve.
  subroutine open_states(path, file, error)
    character(*), intent(in) :: path !! the file
    type(hdf5_file_t), intent(out) :: file !! open if there is no error
    type(error_t), allocatable, intent(out) :: error !! no such file, no HDF5, no states
    type(error_t), allocatable :: ignored
    logical :: there

    inquire (file=path, exist=there)
    if (.not. there) then
      call raise(error, exit_deck, 'error: there is no file '//path//' to restart from'//nl// &
        '  name the .h5 file of a run, or one that SAVE has written')
      return
    end if
    call open_hdf5(file, path, error)
    if (allocated(error)) then
      call raise(error, exit_deck, 'error: '//path//' is no HDF5 file that can be read: '// &
        'something else, cut off, or still being written'//nl// &
        '  name the .h5 file of a run that has ended')
    else if (.not. exists_in(file, '/state')) then
      call raise(error, exit_deck, 'error: '//path//' holds no state to restart from'//nl// &
        '  the run that wrote it had OUTPut STATe NONE')
      call close_hdf5(file, ignored)
    end if
  end subroutine open_states

  !> Finds the place of a state.
  subroutine find_state(file, step, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: step !! number of the end time, 0 for the last
    integer, intent(out) :: slot !! its place, 0 if the file has none and the last is wanted
    type(error_t), allocatable, intent(out) :: error !! no such step
    integer, allocatable :: steps(:)
    integer :: dims(3), rank

    slot = 0
    call series_shape(file, root//'step', dims, rank)
    allocate (steps(dims(1)), source=0)
    call read_block(file, root//'step', steps, 1, error)
    if (allocated(error)) then
      call raise(error, exit_deck, 'error: the states in '//file%path//' cannot be read: '// &
        'the file is damaged or cut off')
      return
    end if
    if (all(steps < 1) .and. step == 0) return
    slot = maxloc(steps, 1)
    if (step > 0) slot = findloc(steps, step, 1)
    if (slot > 0) return
    if (all(steps < 1)) then
      call raise(error, exit_deck, 'error: '//file%path//' holds no state of step '// &
        to_text(step)//nl//'  the run that wrote it ended before its first end time (or the '// &
        'first of OUTPut EVERy)')
    else
      call raise(error, exit_deck, 'error: '//file%path// &
        ' holds no state of step '//to_text(step)//nl//'  it holds '//step_list(steps)// &
        '; without --step the last one is taken')
    end if
  end subroutine find_state

  !> The steps that are there, as text: `steps 1 to 7, 9, 11 to 30`.
  function step_list(steps) result(t)
    integer, intent(in) :: steps(:) !! numbers of end times, 0 or below for none
    character(:), allocatable :: t
    integer, allocatable :: present_steps(:)
    integer :: first, last, stride

    present_steps = pack(steps, steps > 0)
    if (size(present_steps) == 2) present_steps = [minval(present_steps), maxval(present_steps)]
    t = 'step'
    if (size(present_steps) > 1) t = 'steps'
    first = 1
    do while (first <= size(present_steps))
      last = first
      if (first < size(present_steps)) then
        stride = present_steps(first + 1) - present_steps(first)
        do while (last < size(present_steps))
          if (present_steps(last + 1) - present_steps(last) /= stride) exit
          last = last + 1
        end do
      end if
      if (first > 1) t = t//','
      t = t//' '//to_text(present_steps(first))
      if (last > first + 1) then
        t = t//' to '//to_text(present_steps(last))
        if (stride > 1) t = t//' by '//to_text(stride)
      else
        last = first
      end if
      first = last + 1
    end do
  end function step_list

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
    file%sum = state_mark(state%step)
    call read_block(file, root//'time', values, slot, error)
    if (allocated(error)) return
    state%time = values(1)
    call read_block(file, root//'increment', values, slot, error)
    if (allocated(error)) return
    state%increment = values(1)
    allocate (state%displacement(3, model%mesh%nodes), state%reaction(3, model%mesh%nodes))
    call read_block(file, root//'displacement', state%displacement, slot, error)
    if (allocated(error)) return
    call read_block(file, root//'reaction', state%reaction, slot, error)
    if (.not. allocated(error)) call read_before(file, root, slot, state, error)
    if (.not. allocated(error)) call read_factor(file, root, slot, state, error)
    if (.not. allocated(error)) call read_scene(file, root, slot, state, error)
    if (.not. allocated(error)) call read_rigid_motions(file, root, model, slot, state, error)
    if (.not. allocated(error)) call read_condensed(file, model, slot, state, error)
    allocate (state%pairs(size(model%pairs)))
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call read_pair(file, model%pairs(i), slot, state, i, error)
      if (allocated(error)) return
      call read_multipliers(file, model%pairs(i), slot, state%pairs(i), error)
      if (allocated(error)) return
      call read_paths(file, model%pairs(i), slot, state%pairs(i), error)
      if (allocated(error)) return
      if (.not. model%pairs(i)%segmented) cycle
      allocate (state%pairs(i)%cells(count_points(model%pairs(i))))
      call read_cells(file, pair_group(model%pairs(i)%number), &
        size(model%pairs(i)%points%slave_facets, 2), slot, state%pairs(i)%cells, error)
    end do
  end subroutine read_slot

  !> Compares the sum over what was read with the one that was written.
  subroutine check_sum(file, slot, step, error)
    type(hdf5_file_t), intent(inout) :: file !! open file; its sum is that of the state
    integer, intent(in) :: slot !! place of the state
    integer, intent(in) :: step !! number of its end time
    type(error_t), allocatable, intent(out) :: error !! they differ
    integer :: written(2), found(2)

    found = transfer(file%sum, found)
    call read_block(file, root//'checksum', written, slot, error)
    if (allocated(error)) return
    if (any(written /= found)) call raise(error, exit_deck, 'the sum over the state of step '// &
      to_text(step)//' is not the one that was written')
  end subroutine check_sum

  !> Reads what belongs to the condensed form, if it was in use.
  subroutine read_condensed(file, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! place of the state
    type(saved_state_t), intent(inout) :: state !! gets candidate, contact_force
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: dims(3), rank

    if (.not. exists_in(file, root//'candidate')) return
    call series_shape(file, root//'candidate', dims, rank)
    if (dims(rank) < slot) return
    allocate (state%candidate(model%mesh%nodes), state%contact_force(3, model%mesh%nodes))
    call read_block(file, root//'candidate', state%candidate, slot, error)
    if (.not. allocated(error)) call read_block(file, root//'contact_force', &
      state%contact_force, slot, error)
    if (.not. allocated(error) .and. any(state%candidate /= 0)) return
    deallocate (state%candidate, state%contact_force)
  end subroutine read_condensed

  !> Reads the contact history of one pair.
  subroutine read_pair(file, pair, slot, state, index, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: slot !! place of the state
    type(saved_state_t), intent(inout) :: state !! the state
    integer, intent(in) :: index !! index of the pair
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: tip(2, count_points(pair)), dissipation(count_points(pair))
    integer :: host(count_points(pair)), status(count_points(pair)), i

    allocate (state%pairs(index)%coupled(size(host)))
    call read_block(file, pair_group(pair%number)//'/host', host, slot, error)
    if (allocated(error)) return
    call read_block(file, pair_group(pair%number)//'/status', status, slot, error)
    if (allocated(error)) return
    call read_block(file, pair_group(pair%number)//'/tip', tip, slot, error)
    if (allocated(error)) return
    call read_block(file, pair_group(pair%number)//'/dissipation', dissipation, slot, error)
    if (allocated(error)) return
    call read_block(file, pair_group(pair%number)//'/coupled', state%pairs(index)%coupled, slot, &
      error)
    if (allocated(error)) return
    if (any(host < 0 .or. host > size(pair%surface%facets, 2)) .or. &
      any(state%pairs(index)%coupled < 0 .or. &
      state%pairs(index)%coupled > most_coupled(pair))) then
      call raise(error, exit_deck, 'facet out of range')
      return
    end if
    allocate (state%pairs(index)%points(size(host)))
    do i = 1, size(host)
      state%pairs(index)%points(i)%host = host(i)
      state%pairs(index)%points(i)%status = status(i)
      state%pairs(index)%points(i)%tip = tip(:, i)
      state%pairs(index)%points(i)%dissipation = dissipation(i)
    end do
  end subroutine read_pair

  !> Reads the multipliers of a pair; a run without AUGMent has left none, and one may use none.
  subroutine read_multipliers(file, pair, slot, history, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: slot !! place of the state
    type(pair_history_t), intent(inout) :: history !! its history, points allocated
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: lambda(3, size(history%points))
    integer :: i

    if (.not. exists_in(file, pair_group(pair%number)//'/multiplier')) return
    call read_block(file, pair_group(pair%number)//'/multiplier', lambda, slot, error)
    if (allocated(error) .or. .not. has_multipliers(pair)) return
    do i = 1, size(history%points)
      history%points(i)%lambda = lambda(:, i)
    end do
  end subroutine read_multipliers

  !> Reads the slip paths of a pair, if the run has kept them and this one asks for them.
  subroutine read_paths(file, pair, slot, history, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: slot !! place of the state
    type(pair_history_t), intent(inout) :: history !! its history, points allocated
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp) :: path(size(history%points))
    character(:), allocatable :: name

    name = pair_group(pair%number)//'/'//trim(path_state%name)
    if (.not. exists_in(file, name)) return
    call read_block(file, name, path, slot, error)
    if (allocated(error) .or. .not. keeps_path(pair%law)) return
    history%points%path = path
  end subroutine read_paths
end module state_reader

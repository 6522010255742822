!> Reads the restart part of a results file, and refuses one that does not fit the deck.
module state_reader
  use kinds, only: wp
  use file_identity, only: identify, obstacle_of
  use errors, only: error_t, raise, exit_deck, exit_resources
  use text, only: to_text
  use contact_types, only: pair_t
  use contact_points, only: count_points, most_coupled
  use model_types, only: model_t
  use rigid_paths, only: count_rigid
  use result_types, only: saved_state_t, pair_history_t
  use hdf5_io, only: hdf5_file_t, open_hdf5, close_hdf5, exists_in
  use hdf5_data, only: read_block, move_block, series_shape, stored_real
  use results_state, only: pair_group, state_mark
  use state_checks, only: check_state
  use results_names, only: bodies_ending, contact_ending
  use state_fit, only: check_fit
  use result_fields, only: field_t, field_shape, native_type, entries_of, over_nodes, over_bodies
  use state_fields, only: fields_of_state, fields_of_pair, is_mark, is_optional, in_use, &
    forget_unused, address_of, real_component, integer_component
  implicit none
  private
  public :: read_state

  !> Root of this part of the file.
  character(*), parameter :: state_root = '/state/'
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

    call series_shape(file, state_root//'step', dims, rank)
    allocate (steps(dims(1)), source=0)
    call read_block(file, state_root//'step', steps, 1, trouble)
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
    character(:), allocatable :: obstacle
    logical :: there

    inquire (file=path, exist=there)
    if (.not. there) then
      call raise(error, exit_deck, 'error: there is no file '//path//' to restart from'//nl// &
        '  name the .vtkhdf file of a run, or one that SAVE has written')
      return
    end if
    obstacle = obstacle_of(identify(path))
    if (len(obstacle) > 0) then
      call raise(error, exit_deck, 'error: '//path//' cannot be restarted from: '//obstacle//nl// &
        '  name the .h5 file of a run, or one that SAVE has written')
      return
    end if
    call open_hdf5(file, path, error)
    if (allocated(error)) then
      call raise(error, exit_deck, 'error: '//path//' is no HDF5 file that can be read: '// &
        'something else, cut off, or still being written'//nl// &
        '  name the .vtkhdf file of a run that has ended')
    else if (.not. exists_in(file, '/state')) then
      call raise_stateless(file, error)
      call close_hdf5(file, ignored)
    end if
  end subroutine open_states

  !> Says why a file has no states: it holds contact surfaces, or its run kept none.
  subroutine raise_stateless(file, error)
    type(hdf5_file_t), intent(in) :: file !! open file
    type(error_t), allocatable, intent(out) :: error !! filled
    integer :: at

    at = index(file%path, contact_ending, back=.true.)
    if (at > 0) then
      if (exists_in(file, '/run')) at = 0
    end if
    if (at > 0) then
      call raise(error, exit_deck, 'error: '//file%path//' holds contact surfaces and no state '// &
        'to restart from'//nl//'  name the file of the bodies: '// &
        file%path(:at - 1)//bodies_ending)
    else
      call raise(error, exit_deck, 'error: '//file%path//' holds no state to restart from'//nl// &
        '  the run that wrote it had OUTPut STATe NONE')
    end if
  end subroutine raise_stateless

  !> Finds the place of a state.
  subroutine find_state(file, step, slot, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    integer, intent(in) :: step !! number of the end time, 0 for the last
    integer, intent(out) :: slot !! its place, 0 if the file has none and the last is wanted
    type(error_t), allocatable, intent(out) :: error !! no such step
    integer, allocatable :: steps(:)
    integer :: dims(3), rank

    slot = 0
    call series_shape(file, state_root//'step', dims, rank)
    allocate (steps(dims(1)), source=0)
    call read_block(file, state_root//'step', steps, 1, error)
    if (allocated(error)) then
      call raise(error, exit_deck, 'error: the states in '//file%path//' cannot be read: '// &
        'the file is damaged or cut off'//nl//'  run the deck anew, or restart from a copy')
      return
    end if
    if (all(steps < 1) .and. step == 0) return
    slot = maxloc(steps, 1)
    if (step > 0) slot = findloc(steps, step, 1)
    if (slot > 0) return
    if (all(steps < 1)) then
      call raise(error, exit_deck, 'error: '//file%path//' holds no state of step '// &
        to_text(step)//nl//'  the run that wrote it ended before its first output time (or the '// &
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
    ! written in turn: behind the last stands the first
    if (size(present_steps) > 1) present_steps = cshift(present_steps, maxloc(present_steps, 1))
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
    type(saved_state_t), intent(inout), target :: state !! the state
    type(error_t), allocatable, intent(out) :: error !! file trouble
    integer :: step(1), i

    call read_block(file, state_root//'step', step, slot, error)
    if (allocated(error)) return
    state%step = step(1)
    file%sum = state_mark(state%step)
    do i = 1, size(fields_of_state)
      if (is_mark(fields_of_state(i))) cycle
      call read_field(file, fields_of_state(i), model, slot, state, error)
      if (allocated(error)) return
    end do
    call forget_unused(state)
    call check_bodies(model, state, error)
    allocate (state%pairs(size(model%pairs)))
    do i = 1, size(model%pairs)
      if (allocated(error)) return
      call read_pair(file, model%pairs(i), slot, state%pairs(i), error)
    end do
  end subroutine read_slot

  !> Reads one field of a state, if it is there: its sum counts also where the deck has no use for
  !! it.
  subroutine read_field(file, field, model, slot, state, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(field_t), intent(in) :: field !! the field
    type(model_t), intent(in) :: model !! the problem
    integer, intent(in) :: slot !! place of the state
    type(saved_state_t), intent(inout), target :: state !! gets it
    type(error_t), allocatable, intent(out) :: error !! file trouble
    character(:), allocatable :: path
    integer, allocatable :: dims(:)
    integer :: counts(7), found(3), rank

    path = state_root//trim(field%name)
    if (is_optional(field)) then
      if (entries_of(file, path) < slot) return
    end if
    counts = 0
    counts(over_nodes) = model%mesh%nodes
    if (field%over >= over_bodies) then
      call series_shape(file, path, found, rank)
      counts(field%over) = found(rank - 1)
    end if
    dims = field_shape(field, counts)
    call move_block(file, path, native_type(field), address_of(state, field%name, dims, .true.), &
      product(dims), slot, .false., error)
  end subroutine read_field

  !> The rigid bodies of a state are those of the deck; a deck without any drops them.
  subroutine check_bodies(model, state, error)
    type(model_t), intent(in) :: model !! rigid bodies
    type(saved_state_t), intent(inout) :: state !! rigid
    type(error_t), allocatable, intent(out) :: error !! other bodies
    integer :: found

    found = 0
    if (allocated(state%rigid)) found = size(state%rigid, 2)
    if (count_rigid(model) > 0 .and. found /= count_rigid(model)) then
      call raise(error, exit_deck, 'it has '//to_text(found)//' rigid bodies (RIGId), the '// &
        'deck '//to_text(count_rigid(model)))
    else if (count_rigid(model) == 0) then
      if (allocated(state%rigid)) deallocate (state%rigid)
      allocate (state%rigid(6, 0))
    end if
  end subroutine check_bodies

  !> Compares the sum over what was read with the one that was written.
  subroutine check_sum(file, slot, step, error)
    type(hdf5_file_t), intent(inout) :: file !! open file; its sum is that of the state
    integer, intent(in) :: slot !! place of the state
    integer, intent(in) :: step !! number of its end time
    type(error_t), allocatable, intent(out) :: error !! they differ
    integer :: written(2), found(2)

    found = transfer(file%sum, found)
    call read_block(file, state_root//'checksum', written, slot, error)
    if (allocated(error)) return
    if (any(written /= found)) call raise(error, exit_deck, 'the sum over the state of step '// &
      to_text(step)//' is not the one that was written')
  end subroutine check_sum

  !> Reads the contact history of one pair: what its run has kept and this one asks for.
  subroutine read_pair(file, pair, slot, history, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: slot !! place of the state
    type(pair_history_t), intent(inout), target :: history !! its history
    type(error_t), allocatable, intent(out) :: error !! file trouble, not one of this pair
    character(:), allocatable :: path
    integer :: i

    allocate (history%points(count_points(pair)), history%coupled(count_points(pair)))
    if (pair%segmented) allocate (history%cells(count_points(pair)))
    if (pair%mortar) allocate (history%multipliers(count_points(pair)))
    do i = 1, size(fields_of_pair)
      associate (field => fields_of_pair(i))
        path = pair_group(pair%number)//'/'//trim(field%name)
        if (is_optional(field)) then
          if (.not. exists_in(file, path)) cycle
        else if (.not. in_use(field, pair)) then
          cycle
        end if
        call read_points(file, path, field, slot, in_use(field, pair), history, error)
        if (allocated(error)) return
      end associate
    end do
    if (any(history%points%target < 0 .or. history%points%target > size(pair%surface%facets, &
      2)) .or. any(history%coupled < 0 .or. history%coupled > most_coupled(pair))) then
      call raise(error, exit_deck, 'facet out of range')
    else if (pair%segmented) then
      associate (slave => history%cells%slave)
        if (any(slave < 0 .or. slave > size(pair%points%slave_facets, 2))) call raise(error, &
          exit_deck, 'slave facet out of range')
      end associate
    end if
  end subroutine read_pair

  !> Reads one field of the points of a pair.
  subroutine read_points(file, path, field, slot, keep, history, error)
    type(hdf5_file_t), intent(inout) :: file !! open file
    character(*), intent(in) :: path !! data set
    type(field_t), intent(in) :: field !! the field
    integer, intent(in) :: slot !! place of the state
    logical, intent(in) :: keep !! else it is read for its sum alone
    type(pair_history_t), intent(inout), target :: history !! room given; gets it
    type(error_t), allocatable, intent(out) :: error !! file trouble
    real(wp), pointer :: component(:)
    integer, pointer :: number(:)
    real(wp) :: values(field%components, size(history%points))
    integer :: numbers(size(history%points)), k

    if (field%stored == stored_real) then
      call read_block(file, path, values, slot, error)
      if (allocated(error) .or. .not. keep) return
      do k = 1, field%components
        component => real_component(history, field%name, k)
        component = values(k, :)
      end do
    else
      call read_block(file, path, numbers, slot, error)
      if (allocated(error) .or. .not. keep) return
      number => integer_component(history, field%name)
      number = numbers
    end if
  end subroutine read_points
end module state_reader

!> States that a run goes back to or goes on from: SAVE, REST and --restart.
module saved_states
  use errors, only: error_t, raise, exit_deck, exit_resources
  use ranks, only: this_rank
  use parallel, only: any_rank
  use text, only: string_t, append_string
  use version, only: program_version
  use kinds, only: wp
  use model_types, only: model_t
  use system_types, only: form_t, system_t, state_t
  use contact_cells, only: begin_cells
  use mortar_types, only: multipliers_of
  use form_choice, only: take_full_form
  use back_ends, only: solver_unknown
  use result_types, only: saved_state_t
  use results_state, only: save_state
  use state_reader, only: read_state
  use run_files, only: fill_state
  use results_names, only: bodies_ending, state_ending, find_results, without_ending
  use text_files, only: real_path
  implicit none
  private
  public :: saved_states_t, keep_state, read_kept_state, take_state, note_passed, restart_base, &
    file_of

  !> Where states are kept.
  type :: saved_states_t
    character(:), allocatable :: base !! path of this run's files without their endings
    character(:), allocatable :: deck !! name of the deck without its ending
    character(:), allocatable :: restart !! file that was restarted from, empty for none
    integer :: step = 0 !! step of the state in it, 0 without a restart
    real(wp) :: time = 0.0_wp !! its time
    character(:), allocatable :: note !! what its reader had to say of it
    integer :: n_passed = 0 !! SAVE commands that were passed over
    type(string_t), allocatable :: passed(:) !! their names, and some room
  end type saved_states_t

  !> The name of a state that has none.
  character(*), parameter :: default_name = 'save'

contains

  !> SAVE: writes the present state to its file; returns the file's name.
  subroutine keep_state(states, name, model, system, form, state, increment, path, error)
    type(saved_states_t), intent(in) :: states !! where to
    character(*), intent(in) :: name !! name of the state, may be empty
    type(model_t), intent(in) :: model !! contact history
    type(system_t), intent(in) :: system !! pattern of its matrix
    type(form_t), intent(in) :: form !! condensed, its kind
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: increment !! DT
    character(:), allocatable, intent(out) :: path !! the file
    type(error_t), allocatable, intent(out) :: error !! file trouble
    type(saved_state_t) :: saved

    path = file_of(states%base, name)
    call fill_state(model, system, form, state, increment, saved)
    saved%step = max(1, saved%step)
    if (this_rank() == 0) call save_state(path, model, saved, 'mfec '//program_version, error)
    ! nobody reads it before it is there
    if (any_rank(allocated(error)) .and. .not. allocated(error)) call raise(error, exit_resources, &
      'error: the first process cannot write '//path)
  end subroutine keep_state

  !> REST: reads the state that has been saved under a name, or that of a file.
  subroutine read_kept_state(states, name, step, model, saved, path, error)
    type(saved_states_t), intent(in) :: states !! where from
    character(*), intent(in) :: name !! name of the state or file, may be empty
    integer, intent(in) :: step !! number of the end time in the file, 0 for the last
    type(model_t), intent(in) :: model !! the problem
    type(saved_state_t), intent(out) :: saved !! the state
    character(:), allocatable, intent(out) :: path !! the file
    type(error_t), allocatable, intent(out) :: error !! no such file or step, another mesh

    path = path_of(states, name)
    call read_state(path, model, step, saved, error)
    if (allocated(error) .or. saved%step > 0) return
    call raise(error, exit_deck, 'error: '//path//' holds no state to go back to'//new_line('a')// &
      '  the run that wrote it ended before its first output time (or the first of OUTPut EVERy)')
  end subroutine read_kept_state

  !> Makes a saved state the present one; the number of its step is left to the caller.
  subroutine take_state(saved, model, system, form, state)
    type(saved_state_t), intent(in) :: saved !! the state
    type(model_t), intent(inout) :: model !! gets its contact history
    type(system_t), intent(inout) :: system !! gets the pattern of its matrix
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! becomes the state
    integer :: targets(system%contact%n), k

    state%time = saved%time
    state%u = saved%displacement
    state%reaction = saved%reaction
    state%rigid = saved%rigid
    state%slopes = saved%slopes
    if (allocated(saved%memory)) system%bulk%memory = reshape(saved%memory, &
      shape(system%bulk%memory))
    if (allocated(system%touch%u_before)) deallocate (system%touch%u_before)
    if (allocated(saved%displacement_before)) system%touch%u_before = saved%displacement_before
    system%touch%span_before = saved%span_before
    do k = 1, size(model%pairs)
      model%pairs(k)%history%old = saved%pairs(k)%points
      model%pairs(k)%history%new = saved%pairs(k)%points
      if (model%pairs(k)%segmented) then
        model%pairs(k)%history%old_cells = saved%pairs(k)%cells
        call begin_cells(model%pairs(k))
      end if
      if (model%pairs(k)%mortar) model%pairs(k)%old_nodes = multipliers_of( &
        saved%pairs(k)%multipliers)
      model%pairs(k)%nodes = model%pairs(k)%old_nodes
      targets(system%place%first_point(k):system%place%first_point(k + 1) - 1) = &
        saved%pairs(k)%coupled
    end do
    call take_condensed_state(saved, form)
    if (associated(form%kind%couple_as_saved)) call form%kind%couple_as_saved(model, system, form, &
      targets)
  end subroutine take_state

  !> Forces and candidates of the condensed form; other candidates than the present ones mean that
  !! it begins anew.
  subroutine take_condensed_state(saved, form)
    type(saved_state_t), intent(in) :: saved !! the state
    type(form_t), intent(inout) :: form !! its condensed form

    form%condensed%goes_on = .false.
    if (form%kind%inexact) then
      call take_full_form(form)
      form%whole%choice = solver_unknown
    else if (.not. form%kind%knows_inside) then
      if (.not. allocated(saved%candidate)) then
        if (allocated(form%condensed%outer%kept)) deallocate (form%condensed%outer%kept)
        return
      end if
      if (any(form%condensed%candidate .neqv. saved%candidate > 0)) then
        call take_full_form(form)
        form%whole%choice = solver_unknown
      end if
    end if
    if (.not. allocated(saved%candidate)) return
    form%condensed%candidate = saved%candidate > 0
    form%condensed%outer%kept = saved%contact_force
    form%condensed%aging = saved%factor_aging(1)
    form%condensed%refusals = nint(saved%factor_aging(2))
    if (allocated(saved%factor_displacement)) form%condensed%made_at = saved%factor_displacement
  end subroutine take_condensed_state

  !> Remembers a SAVE that a restart passes over: its file belongs to the run before.
  subroutine note_passed(states, name)
    type(saved_states_t), intent(inout) :: states !! gets the name
    character(*), intent(in) :: name !! name of the state, may be empty

    if (.not. is_passed(states, name)) call append_string(states%passed, states%n_passed, name)
  end subroutine note_passed

  !> Whether a SAVE of this name was passed over.
  pure logical function is_passed(states, name)
    type(saved_states_t), intent(in) :: states !! the names
    character(*), intent(in) :: name !! name of a state
    integer :: i

    is_passed = .false.
    do i = 1, states%n_passed
      if (states%passed(i)%s == name) is_passed = .true.
    end do
  end function is_passed

  !> The file that REST reads: a name is that of a state, anything with a dot or slash a file. The
  !! run's own file is the one that it writes now, whatever an earlier one has left beside it.
  function path_of(states, name) result(path)
    type(saved_states_t), intent(in) :: states !! where states are kept
    character(*), intent(in) :: name !! name of a state or file, may be empty
    character(:), allocatable :: path
    logical :: there

    if (name == states%base//state_ending .or. name == states%base//bodies_ending) then
      path = states%base//bodies_ending
    else if (scan(name, './') > 0) then
      path = find_results(name)
    else if (is_passed(states, name)) then
      path = file_of(without_ending(states%restart), name)
      inquire (file=path, exist=there)
      if (.not. there) path = file_of(folder_of(states%restart)//states%deck, name)
    else
      path = file_of(states%base, name)
    end if
  end function path_of

  !> The file of a state.
  pure function file_of(base, name) result(path)
    character(*), intent(in) :: base !! path without ending
    character(*), intent(in) :: name !! name of the state, may be empty
    character(:), allocatable :: path

    if (len(name) == 0) then
      path = base//'.'//default_name//state_ending
    else
      path = base//'.'//name//state_ending
    end if
  end function file_of

  !> The folder of a path with its slash, empty for the working directory.
  pure function folder_of(path) result(folder)
    character(*), intent(in) :: path !! any path
    character(:), allocatable :: folder

    folder = path(:index(path, '/', back=.true.))
  end function folder_of

  !> Base of the files of a restarted run: the one it would have, but with `-restart` behind it if
  !! the file restarted from, or what stands beside it, begins with that.
  function restart_base(base, restart) result(safe)
    character(*), intent(in) :: base !! path of the run's files without their endings
    character(*), intent(in) :: restart !! results file that is restarted from
    character(:), allocatable :: safe, file, here

    safe = base
    file = real_path(restart)
    here = folder_of(base)
    if (len(here) == 0) here = './'
    here = real_path(here)
    if (len(here) == 0 .or. folder_of(file) /= here//'/') return
    here = here//'/'//base(len(folder_of(base)) + 1:)
    do while (index(file, here//'.') == 1 .or. index(file, here//'-restart') == 1)
      here = here//'-restart'
      safe = safe//'-restart'
    end do
  end function restart_base
end module saved_states

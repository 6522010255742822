!> That a run can write its files and destroys none that it reads. Looked at before any file is
!! touched, and by what is behind the names, not by the names: links lead elsewhere.
module output_checks
  use errors, only: error_t, raise, exit_deck, exit_resources
  use text, only: string_t, append_string
  use model_types, only: model_t
  use rigid_paths, only: count_rigid
  use hdf5_io, only: unfinished
  use batch_types, only: batch_command_t
  use results_names, only: bodies_ending, contact_ending
  use saved_states, only: file_of
  use deck_types, only: location_t
  use diagnostics, only: diagnostics_t, report_error
  use source, only: file_name
  use file_identity, only: file_identity_t, identify, are_one, obstacle_of, kind_file
  implicit none
  private
  public :: written_files, guard_files, refuse_pipes

contains

  !> All files that the run writes, the unfinished ones included; with --check what that writes.
  function written_files(base, model, commands, derives, varies, check) result(names)
    character(*), intent(in) :: base !! path of the run's files without their endings
    type(model_t), intent(in) :: model !! what it writes
    type(batch_command_t), intent(in) :: commands(:) !! its solution commands
    logical, intent(in) :: derives !! derivatives are asked for
    logical, intent(in) :: varies !! a study is asked for
    logical, intent(in) :: check !! nothing is solved
    type(string_t), allocatable :: names(:)
    character(:), allocatable :: path
    integer :: i, n

    if (check) then
      names = result_names(base//'.check', model, derives=.false., varies=.false.)
      return
    end if
    names = result_names(base, model, derives, varies)
    n = size(names)
    do i = 1, size(commands)
      if (commands(i)%command /= 'save') cycle
      path = file_of(base, commands(i)%text)
      if (is_among(path, names(:n))) cycle
      call append_string(names, n, path)
      call append_string(names, n, path//unfinished)
    end do
    names = names(:n)
  end function written_files

  !> A name is in a list.
  pure logical function is_among(name, names)
    character(*), intent(in) :: name !! a path
    type(string_t), intent(in) :: names(:) !! paths
    integer :: i

    is_among = .false.
    do i = 1, size(names)
      is_among = is_among .or. names(i)%s == name
    end do
  end function is_among

  !> The files of a run, those that derivatives and variants write and the unfinished ones included.
  function result_names(base, model, derives, varies) result(names)
    character(*), intent(in) :: base !! path of the run's files without their endings
    type(model_t), intent(in) :: model !! what it writes
    logical, intent(in) :: derives !! derivatives are asked for
    logical, intent(in) :: varies !! a study is asked for
    type(string_t), allocatable :: names(:)
    integer :: n

    n = 0
    call append_string(names, n, base//'.log')
    call append_string(names, n, base//'.rea')
    call append_string(names, n, base//'.con')
    call append_string(names, n, base//bodies_ending)
    call append_string(names, n, base//bodies_ending//unfinished)
    if (size(model%output%history) > 0) call append_string(names, n, base//'.his')
    if (size(model%output%points) > 0) call append_string(names, n, base//'.pts')
    if (count_rigid(model) > 0) call append_string(names, n, base//'.rig')
    if (model%output%contact) call append_string(names, n, base//contact_ending)
    if (model%output%contact) call append_string(names, n, base//contact_ending//unfinished)
    if (derives) call append_string(names, n, base//'.sen')
    if (varies) call append_string(names, n, base//'.study')
    names = names(:n)
  end function result_names

  !> Looks at what stands where the files of a run will be written: none is an input, each is a
  !! regular file or not there yet, and no two are one.
  subroutine guard_files(names, restart, diagnostics, error)
    type(string_t), intent(in) :: names(:) !! files that the run writes
    character(*), intent(in) :: restart !! file that it goes on from, empty for none
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's files; gets errors
    type(error_t), allocatable, intent(out) :: error !! a file that cannot be written
    type(file_identity_t) :: found(size(names)), inputs(diagnostics%source%count), state
    integer :: i, k

    do k = 1, size(inputs)
      inputs(k) = identify(file_name(diagnostics%source, k))
    end do
    if (len(restart) > 0) state = identify(restart)
    do i = 1, size(names)
      found(i) = identify(names(i)%s)
      if (found(i)%kind < kind_file) cycle ! whoever creates it says why, if that fails
      do k = 1, size(inputs)
        if (are_one(found(i), inputs(k))) call report_input(k, names(i)%s, diagnostics)
      end do
      if (are_one(found(i), state)) then
        call raise(error, exit_deck, 'error: the run would write over '//restart// &
          ', which it goes on from'//new_line('a')//'  '//names(i)%s//' is that file: '// &
          'remove this name, or choose another folder: --out DIR')
      else if (len(obstacle_of(found(i))) > 0) then
        call raise(error, exit_resources, 'error: cannot write to '//names(i)%s//': '// &
          obstacle_of(found(i))//new_line('a')//'  Remove it, or choose another folder for '// &
          'the files of the run: --out DIR')
      else
        call compare_outputs(names(:i), found(:i), error)
      end if
      if (allocated(error)) return
    end do
  end subroutine guard_files

  !> Derivatives and studies read the deck once more for each value of a parameter: what came
  !! through a pipe is gone by then.
  subroutine refuse_pipes(diagnostics)
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's files; gets errors
    integer :: k

    do k = 1, diagnostics%source%count
      if (diagnostics%source%files(k)%piped) call report_error(diagnostics, location_t(k, 1, 1), &
        'derivatives and studies read the deck again, and '//file_name(diagnostics%source, k)// &
        ' is a pipe', 'keep it in a file')
    end do
  end subroutine refuse_pipes

  !> The last of some files must be none of those before.
  subroutine compare_outputs(names, found, error)
    type(string_t), intent(in) :: names(:) !! files that the run writes
    type(file_identity_t), intent(in) :: found(:) !! what is behind them
    type(error_t), allocatable, intent(out) :: error !! two of them are one
    integer :: i, k

    i = size(names)
    do k = 1, i - 1
      if (.not. are_one(found(k), found(i))) cycle
      call raise(error, exit_resources, 'error: '//names(k)%s//' and '//names(i)%s// &
        ' are one file'//new_line('a')//'  One of them is a link: remove it, or choose '// &
        'another folder for the files of the run: --out DIR')
      return
    end do
  end subroutine compare_outputs

  !> Reports a file of the deck that would be written over.
  subroutine report_input(file, name, diagnostics)
    integer, intent(in) :: file !! its number in the source
    character(*), intent(in) :: name !! what the run calls it
    type(diagnostics_t), intent(inout) :: diagnostics !! gets the error
    character(:), allocatable :: input

    input = file_name(diagnostics%source, file)
    if (name == input) then
      call report_error(diagnostics, location_t(file, 1, 1), 'the run would write over '//input, &
        'its files have the name of the deck: rename this one, or choose a folder for them, '// &
        '--out DIR')
    else
      call report_error(diagnostics, location_t(file, 1, 1), 'the run would write over '//input// &
        ': its file '//name//' is that one by another name', 'remove the link '//name// &
        ', or choose another folder for the files of the run: --out DIR')
    end if
  end subroutine report_input
end module output_checks

!> What --json tells of a run as a whole (doc/manual, "Output for programs"): how it starts, what is
!! wrong with its deck, what it cost, how it ends.
module json_report
  use errors, only: error_t, exit_done, exit_deck, exit_no_convergence, exit_resources
  use json_lines, only: item, list_item, object, print_record
  use version, only: program_version, program_commit
  use memory, only: peak_memory
  use costs, only: cost_names, n_costs, cost_reading, wall_seconds
  use diagnostics, only: diagnostics_t, problem_t, list_problems
  use batch_types, only: batch_command_t
  use batch_position, only: count_steps
  use run_context, only: context_t
  implicit none
  private
  public :: tell_start, tell_problems, tell_costs, tell_end

contains

  !> The first record of a run.
  subroutine tell_start(context, base, deck, commands)
    type(context_t), intent(in) :: context !! the problem; its log has counted the dofs
    character(*), intent(in) :: base !! path of the files without their endings
    character(*), intent(in) :: deck !! path of the deck
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    character(:), allocatable :: pairs
    integer :: k

    pairs = ''
    associate (model => context%model)
      do k = 1, size(model%pairs)
        pairs = pairs//object(item('name', model%pairs(k)%name)//item('slave', &
          model%pairs(k)%slave)//item('master', model%pairs(k)%master))
      end do
      call print_record('start', item('version', program_version)//item('commit', &
        program_commit)//item('title', model%title)//item('deck', deck)//item('files', base)// &
        item('nodes', count(model%mesh%defined))//item('elements', &
        count(model%mesh%ix(1, :) > 0))//item('free_dofs', context%files%log%free_dofs)// &
        item('end_times', count_steps(commands))//list_item('pairs', pairs))
    end associate
  end subroutine tell_start

  !> What is wrong with the deck, a record each.
  subroutine tell_problems(diagnostics)
    type(diagnostics_t), intent(in) :: diagnostics !! what was gathered
    type(problem_t), allocatable :: problems(:)
    integer :: i

    call list_problems(diagnostics, problems)
    do i = 1, size(problems)
      associate (p => problems(i))
        call print_record('problem', item('file', p%file)//item('line', p%line)//item('column', &
          p%column)//item('what', p%what)//item('text', p%text)//item('remedy', p%remedy))
      end associate
    end do
  end subroutine tell_problems

  !> The cost table of the log.
  subroutine tell_costs(context)
    type(context_t), intent(in) :: context !! its log and its form have counted
    character(:), allocatable :: rows
    integer :: i

    rows = ''
    associate (log => context%files%log, costs => context%form%costs)
      do i = 1, n_costs
        rows = rows//object(item('name', trim(cost_names(i)))//item('count', costs%count(i))// &
          item('seconds', costs%seconds(i)))
      end do
      call print_record('costs', item('increments', log%increments)//item('iterations', &
        log%iterations)//item('cuts', log%cuts)//item('warnings', log%warnings)// &
        item('seconds', wall_seconds() - costs%started(cost_reading))//item('peak_memory', &
        peak_memory())//list_item('costs', rows))
    end associate
  end subroutine tell_costs

  !> The last record: exit code, and of an error what it says first and what comes after that.
  subroutine tell_end(error)
    type(error_t), intent(in), optional :: error !! what ended the run
    integer :: code, first

    code = exit_done
    if (present(error)) code = error%code
    if (code == exit_done) then
      call print_record('end', item('code', code)//item('reason', 'done'))
      return
    end if
    first = index(error%message//new_line('a'), new_line('a')) - 1
    call print_record('end', item('code', code)//item('reason', reason_of(code))//item('what', &
      error%message(:first))//item('more', error%message(min(first + 2, len(error%message) + 1):)))
  end subroutine tell_end

  !> A word for an exit code.
  pure function reason_of(code) result(word)
    integer, intent(in) :: code !! of `errors`
    character(:), allocatable :: word

    select case (code)
    case (exit_deck)
      word = 'deck'
    case (exit_no_convergence)
      word = 'no_convergence'
    case (exit_resources)
      word = 'resources'
    case default
      word = 'stopped'
    end select
  end function reason_of
end module json_report

!> What --check says of a deck without errors: what is in it, and what can be known before the first
!! solve (doc/manual, "The audit").
module check_report
  use errors, only: error_t
  use text, only: count_noun
  use contact_gaps, only: describe_gaps
  use batch_types, only: batch_command_t
  use batch_position, only: count_steps
  use system_building, only: outline_system
  use diagnosis, only: check_supports
  use audit_types, only: check_facets, check_moved, check_locking, verdict_warning
  use scene_audit, only: begin_audit
  use audit_text, only: audit_finding, audit_warning
  use run_context, only: context_t
  use blas_info, only: start_blas
  use ranks, only: count_ranks
  use memory, only: memory_left, memory_text
  use run_estimate, only: estimate_t, estimate_run, tell_estimate
  use terminal, only: print_line
  implicit none
  private
  public :: print_check, report_gaps

contains

  !> Counts, notes, gaps, bodies that nothing or contact alone holds, coarse facets, locking, moved
  !! nodes, and what a run will take. Bodies are found, points get their facets, and the matrix of
  !! the bulk is made and analysed, not factorised.
  subroutine print_check(commands, context, error)
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(context_t), target, intent(inout) :: context !! the problem; its terminal is written to
    type(error_t), allocatable, intent(out) :: error !! what would end a run at once
    integer, parameter :: warned_checks(3) = [check_facets, check_locking, check_moved]
    type(error_t), allocatable :: no_memory
    type(estimate_t) :: estimate
    integer :: k

    associate (model => context%model, system => context%system, form => context%form)
      call outline_system(model, system, form, context%state)
      call check_supports(model, system, form, error=error)
      call print_line(context%terminal, trim(merge('the deck can be read ', &
        'no errors in the deck', allocated(error)))//': '//count_noun(count(model%mesh%defined), &
        'node')//', '//count_noun(count(model%mesh%ix(1, :) > 0), 'element')//', '// &
        count_noun(size(model%materials), 'material')//', '//count_noun(size(model%pairs), &
        'contact pair')//', '//count_noun(count_steps(commands), 'output time'))
      do k = 1, size(model%notes)
        call print_line(context%terminal, model%notes(k)%s)
      end do
      context%monitor%terminal => context%terminal
      do k = 1, size(model%warnings)
        call context%monitor%warning(model%warnings(k)%s)
      end do
      call report_gaps(context, .true.)
      if (.not. allocated(error)) call check_supports(model, system, form, context%monitor, error)
      call begin_audit(model, system, context%state, context%audit)
      do k = 1, size(warned_checks)
        if (context%audit%verdict(warned_checks(k)) == verdict_warning) then
          call context%monitor%warning(audit_warning(model, system, context%audit, &
            warned_checks(k)))
        else
          call print_line(context%terminal, audit_finding(model, system, context%audit, &
            warned_checks(k)))
        end if
      end do
      call start_blas(no_memory)
      if (count_ranks() > 1) return
      if (allocated(error) .or. allocated(no_memory)) return
      call estimate_run(model, system, form, count_steps(commands), estimate)
      call tell_estimate(estimate, context%terminal)
      if (estimate%memory > memory_left()) call context%monitor%warning('the run may need more '// &
        'memory than the '//memory_text(memory_left())//' that there are: make the mesh '// &
        'coarser, or let ./mfec-petsc share it (make PETSC=1)')
    end associate
  end subroutine print_check

  !> Tells the gaps of all pairs at the start; penetrations are worth a warning.
  subroutine report_gaps(context, to_terminal)
    type(context_t), target, intent(inout) :: context !! pairs with their first targets; log,
    !! terminal
    logical, intent(in) :: to_terminal !! gaps go to the terminal, else to the log
    character(:), allocatable :: line
    logical :: penetrates
    integer :: k

    associate (model => context%model)
      do k = 1, size(model%pairs)
        call describe_gaps(model%pairs(k), model%mesh%x, line, penetrates)
        if (penetrates) then
          call context%monitor%warning(line)
        else if (to_terminal) then
          call print_line(context%terminal, line)
        else
          call context%monitor%event(line)
        end if
      end do
    end associate
  end subroutine report_gaps
end module check_report

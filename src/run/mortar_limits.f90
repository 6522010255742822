!> What MORTar does not go with in this version: refused when the deck is read, never solved in some
!! other way (doc/manual, "Contact").
module mortar_limits
  use deck_types, only: location_t
  use diagnostics, only: diagnostics_t, report_error
  use contact_types, only: pair_t
  use command_line, only: options_t
  use batch_types, only: batch_command_t
  use bulk_laws, only: laws
  use linear_solver, only: solver_of
  use back_ends, only: solver_unknown, solver_auto, solver_reduced
  use model_types, only: model_t
  use ranks, only: count_ranks
  implicit none
  private
  public :: check_mortar

contains

  !> Reports what a scene with MORTar cannot have.
  subroutine check_mortar(model, commands, options, asks, diagnostics)
    type(model_t), intent(in) :: model !! the problem
    type(batch_command_t), intent(in) :: commands(:) !! its solution commands
    type(options_t), intent(in) :: options !! the command line
    logical, intent(in) :: asks !! derivatives are asked for
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: k, first

    if (.not. allocated(model%pairs)) return
    first = findloc(model%pairs%mortar, .true., 1)
    if (first == 0) return
    associate (at => model%pairs(first)%at)
      if (asks) call refuse(at, 'MORTar does not know derivatives in this version', &
        'leave SENSitivity out, or write GTOS', diagnostics)
      if (all(options%solver /= [solver_unknown, solver_auto, solver_reduced])) call refuse(at, &
        'MORTar wants the solver REDUced', 'leave --solver out', diagnostics)
      if (count_ranks() > 1) call refuse(at, 'MORTar works on one rank', 'run it without mpirun', &
        diagnostics)
    end associate
    call check_commands(commands, diagnostics)
    do k = 1, size(model%pairs)
      call check_bodies(model, model%pairs(k), model%pairs(first)%name, diagnostics)
    end do
  end subroutine check_mortar

  !> Reports one thing.
  subroutine refuse(at, what, remedy, diagnostics)
    type(location_t), intent(in) :: at !! where
    character(*), intent(in) :: what !! what does not go
    character(*), intent(in) :: remedy !! what to do
    type(diagnostics_t), intent(inout) :: diagnostics !! gets it

    call report_error(diagnostics, at, what, remedy)
  end subroutine refuse

  !> Solution commands that MORTar has no way for.
  subroutine check_commands(commands, diagnostics)
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i

    do i = 1, size(commands)
      select case (commands(i)%command)
      case ('tang', 'utan')
        call refuse(commands(i)%at, 'MORTar has no TANG: its forces are unknowns of an increment', &
          'write STEP,,n in place of TIME, TANG and SOLV', diagnostics)
      case ('solv')
        if (commands(i)%solves) cycle
        if (all(solver_of(commands(i)%option) /= [solver_auto, solver_reduced])) call refuse( &
          commands(i)%at, 'MORTar wants the solver REDUced', 'write SOLVer REDUced or leave '// &
          'SOLVer out', diagnostics)
      end select
    end do
  end subroutine check_commands

  !> A pair beside others that is no row by row, a bulk that is not linear.
  subroutine check_bodies(model, pair, name, diagnostics)
    type(model_t), intent(in) :: model !! materials, supports
    type(pair_t), intent(in) :: pair !! one of the pairs
    character(*), intent(in) :: name !! of a pair with MORTar
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: i

    if (.not. pair%mortar) then
      if (pair%augmented) call refuse(pair%at, 'pair '//pair%name//' has AUGMent, and pair '//name &
        //' has MORTar', 'delete AUGMent, or write MORTar in this pair, too', diagnostics)
      ! three cones on each of its cells are more than Newton's method settles beside the nodes'
      if (pair%segmented) call refuse(pair%at, 'pair '//pair%name//' has SEGMent, and pair '//name &
        //' has MORTar', 'write MORTar in this pair, too, or GTOS without SEGMent', diagnostics)
      if (pair%smooth) call refuse(pair%at, 'pair '//pair%name//' has SMOOth, and pair '//name// &
        ' has MORTar', 'delete SMOOth, or write GTOS in place of MORTar', diagnostics)
      return
    end if
    if (any([(is_finite(model, i), i=1, size(model%materials))])) then
      if (.not. all(model%pairs%mortar)) call refuse(pair%at, 'MORTar beside other forms knows '// &
        'small strain alone in this version', 'write SOLId LINEar, or MORTar in all pairs', &
        diagnostics)
      do i = 1, size(model%conditions%rigid)
        if (.not. any(model%conditions%rigid(i)%free)) cycle
        call refuse(pair%at, 'MORTar in finite strain does not know rigid bodies with free '// &
          'motions in this version: body '//model%conditions%rigid(i)%name//' has some', &
          'prescribe all its motions by MOVE and TURN, or write GTOS', diagnostics)
        exit
      end do
    end if
  end subroutine check_bodies

  !> Elements of a material are of finite strain.
  pure logical function is_finite(model, material)
    type(model_t), intent(in) :: model !! materials, elements
    integer, intent(in) :: material !! its number

    is_finite = .not. model%materials(material)%rigid .and. &
      laws(model%materials(material)%law)%finite .and. any(model%element_material == material)
  end function is_finite
end module mortar_limits

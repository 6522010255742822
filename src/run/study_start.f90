!> Where the variants of a study begin: end times, and the state that they have in common
!! (doc/theory, "Variants of a run").
module study_start
  use kinds, only: wp
  use text, only: to_text, upper
  use diagnostics, only: diagnostics_t, report_error
  use solution_settings, only: take_setting
  use errors, only: error_t, raise, exit_deck
  use loads, only: conditions_at
  use rigid_paths, only: count_rigid
  use model_types, only: model_t
  use contact_types, only: contact_point_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use touch_types, only: touch_t
  use condensed_types, only: condensed_t
  use stepping, only: advance
  use monitors, only: monitor_t
  use variant_system, only: set_back
  use study_types, only: study_t
  use batch_types, only: batch_command_t
  implicit none
  private
  public :: plan_t, read_plan, common_t, foresee_common, begin_common, begin_variant, acts_before

  !> End times of a run, with their tolerances.
  type :: plan_t
    real(wp), allocatable :: times(:) !! (end times)
    type(settings_t), allocatable :: settings(:) !! (end times)
  end type plan_t

  !> History of one pair.
  type :: history_t
    type(contact_point_t), allocatable :: points(:) !! at the last converged state
  end type history_t

  !> The state at FROM.
  type :: common_t
    integer :: step = 0 !! its end time, 0 if variants begin at rest
    type(state_t) :: state !! displacements
    type(history_t), allocatable :: pairs(:) !! contact points
    real(wp), allocatable :: kept(:, :) !! (3, nodes) contact forces [force]
    real(wp), allocatable :: u_before(:, :) !! (3, nodes) displacements one increment before
    real(wp) :: span_before = 0.0_wp !! length of that [time]
    real(wp), allocatable :: given(:, :, :) !! (3, nodes, 2 step) prescribed values and forces
    real(wp), allocatable :: times(:) !! end times up to there
  end type common_t

contains

  !> End times from DT, TOL and STEP; other commands are refused.
  subroutine read_plan(commands, plan, diagnostics)
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(plan_t), intent(out) :: plan !! end times
    type(diagnostics_t), intent(inout) :: diagnostics !! hears of commands that studies do not know
    type(settings_t) :: settings
    real(wp) :: dt, begin
    integer :: i, k
    logical :: taken

    allocate (plan%times(0), plan%settings(0))
    dt = 0.0_wp
    do i = 1, size(commands)
      select case (commands(i)%command)
      case ('dt')
        dt = commands(i)%v(1)
      case ('step')
        begin = 0.0_wp
        if (size(plan%times) > 0) begin = plan%times(size(plan%times))
        plan%times = [plan%times, (begin + real(k, wp)*dt, k=1, nint(commands(i)%v(1)))]
        plan%settings = [plan%settings, (settings, k=1, nint(commands(i)%v(1)))]
      case ('disp', 'reac', 'solv', 'prop')
        ! Nothing that variants would do another way.
      case default
        call take_setting(commands(i)%command, commands(i)%option, commands(i)%v(1), &
          settings%asked, taken)
        if (taken) cycle
        call report_error(diagnostics, commands(i)%at, 'a study knows DT, TOL and STEP, not '// &
          upper(trim(commands(i)%command)), 'write the run with STEP,,n')
        return
      end select
    end do
  end subroutine read_plan

  !> Loads and prescribed values up to FROM, which must be an end time.
  subroutine foresee_common(study, plan, base, common, diagnostics)
    type(study_t), intent(in) :: study !! FROM
    type(plan_t), intent(in) :: plan !! end times
    type(model_t), intent(in) :: base !! the problem as the deck has it
    type(common_t), intent(out) :: common !! gets step, times, given
    type(diagnostics_t), intent(inout) :: diagnostics !! hears of a time that is none
    integer :: i

    if (study%from <= 0.0_wp .or. size(plan%times) == 0) return
    i = minloc(abs(plan%times - study%from), 1)
    if (abs(plan%times(i) - study%from) > 1.0e-9_wp*study%from) then
      call report_error(diagnostics, study%from_at, 'FROM '//to_text(study%from)// &
        ' is no output time of the run', 'the next one is '//to_text(plan%times(i)))
      return
    end if
    common%step = i
    common%times = plan%times(:common%step)
    allocate (common%given(3, base%mesh%nodes, 2*common%step))
    do i = 1, common%step
      call conditions_at(base, common%times(i), displacement=common%given(:, :, 2*i - 1), &
        force=common%given(:, :, 2*i))
    end do
  end subroutine foresee_common

  !> Solves what all variants have in common, once.
  subroutine begin_common(study, plan, base, system, form, monitor, common, error)
    type(study_t), intent(in) :: study !! FROM
    type(plan_t), intent(in) :: plan !! end times
    type(model_t), intent(in) :: base !! the problem as the deck has it
    type(system_t), intent(inout) :: system !! its system
    type(form_t), intent(inout) :: form !! the linearised system in its form
    class(monitor_t), intent(inout) :: monitor !! hears of it
    type(common_t), intent(out) :: common !! the state there
    type(error_t), allocatable, intent(out) :: error !! no convergence
    type(model_t) :: model
    type(diagnostics_t) :: unheard
    integer :: i, k

    if (study%from <= 0.0_wp) return
    if (form%kind%knows_inside .or. any(base%pairs%segmented) .or. any(base%pairs%smooth)) then
      call raise(error, exit_deck, 'error: FROM wants the solver REDUced, and pairs without '// &
        'SEGMent and SMOOth'//new_line('a')//'  leave FROM out')
      return
    end if
    call foresee_common(study, plan, base, common, unheard)
    model = base
    allocate (common%state%u(3, model%mesh%nodes), common%state%reaction(3, model%mesh%nodes), &
      common%state%rigid(6, count_rigid(model)))
    call set_back(model, system, form, common%state)
    do i = 1, common%step
      call advance(model, system, form, common%state, plan%times(i), plan%settings(i), monitor, &
        error)
      if (allocated(error)) return
      common%state%step = i
    end do
    allocate (common%pairs(size(model%pairs)))
    do k = 1, size(model%pairs)
      common%pairs(k)%points = model%pairs(k)%history%old
    end do
    common%kept = form%condensed%outer%kept
    if (allocated(system%touch%u_before)) common%u_before = system%touch%u_before
    common%span_before = system%touch%span_before
  end subroutine begin_common

  !> Puts a variant into the common state.
  subroutine begin_variant(common, model, u, touch, condensed, state)
    type(common_t), intent(in) :: common !! the state there
    type(model_t), intent(inout) :: model !! its problem; gets the history
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(touch_t), intent(inout) :: touch !! first touches of the increment
    type(condensed_t), intent(inout) :: condensed !! what the condensed form keeps
    type(state_t), intent(inout) :: state !! becomes the common state
    integer :: k

    if (common%step == 0) return
    do k = 1, size(model%pairs)
      model%pairs(k)%history%old = common%pairs(k)%points
      model%pairs(k)%history%new = common%pairs(k)%points
    end do
    state%time = common%state%time
    state%step = common%state%step
    state%u = common%state%u
    state%reaction = common%state%reaction
    u = state%u
    condensed%outer%kept = common%kept
    if (allocated(common%u_before)) touch%u_before = common%u_before
    touch%span_before = common%span_before
  end subroutine begin_variant

  !> Contact, or loads up to the common state, are not those of the base.
  pure logical function acts_before(common, base, model) result(acts)
    type(common_t), intent(in) :: common !! loads up to there
    type(model_t), intent(in) :: base !! the problem as the deck has it
    type(model_t), intent(in) :: model !! the variant
    real(wp) :: displacement(3, model%mesh%nodes), force(3, model%mesh%nodes)
    integer :: i, k

    acts = .false.
    do k = 1, size(model%pairs)
      associate (a => base%pairs(k), b => model%pairs(k))
        acts = acts .or. any(abs([a%friction%mu - b%friction%mu, a%law - b%law]) > 0.0_wp) .or. &
          abs(a%friction%angle - b%friction%angle) > 0.0_wp .or. a%friction%slip_rule /= &
          b%friction%slip_rule .or. any(abs(a%points%epsilon - b%points%epsilon) > 0.0_wp)
      end associate
    end do
    do i = 1, common%step
      call conditions_at(model, common%times(i), displacement=displacement, force=force)
      acts = acts .or. any(abs(displacement - common%given(:, :, 2*i - 1)) > 0.0_wp) .or. &
        any(abs(force - common%given(:, :, 2*i)) > 0.0_wp)
    end do
  end function acts_before
end module study_start

!> Carries out a study: one variant after the other on the factors of the run before
!! (doc/theory, "Variants of a run").
module study_run
  use kinds, only: wp
  use text, only: to_text, count_noun
  use errors, only: error_t, raise, exit_deck, exit_done, exit_no_convergence
  use costs, only: wall_seconds, add_costs, n_costs
  use deck_types, only: override_t, name_length
  use diagnostics, only: diagnostics_t, report_error, error_count
  use friction_return, only: has_friction
  use facets, only: facet_table_t, exterior_facets
  use mesh_names, only: find_nodes
  use model_types, only: model_t
  use newton_settings, only: settings_t
  use system_types, only: form_t, system_t, state_t
  use system_building, only: build_system
  use linear_solver, only: free_solver
  use condensed_bodies, only: free_condensed
  use stepping, only: advance
  use deck_variants, only: variant_t, difference_t, read_variant, read_next_variant, set_value, &
    place_load
  use sensitivity_start, only: find_levers
  use lever_sums, only: levers_t
  use variant_system, only: set_back, change_influence, reactions_by_levers, same_loads
  use variant_starts, only: starts_t, begin_starts, choose_neighbours, guess_forces, keep_forces_of
  use study_types, only: study_t
  use study_table, only: result_t, create_study_table, write_variant, write_reactions
  use text_files, only: text_file_t, close_text_file
  use study_start, only: common_t, foresee_common, begin_common, begin_variant, acts_before, &
    plan_t, read_plan
  use study_monitor, only: study_monitor_t
  use variant_limits, only: check_shapes
  use terminal, only: print_line
  use result_types, only: variant_row_t
  use results_file, only: begin_variants, append_variant_row
  use signals, only: stop_requested
  use batch_types, only: batch_command_t
  use run_context, only: context_t
  use command_line, only: options_t
  implicit none
  private
  public :: run_study, check_run

  !> What all variants share.
  type :: shared_t
    type(variant_t) :: base !! the deck as it stands
    type(facet_table_t) :: exterior !! exterior facets of its mesh
    type(plan_t) :: plan !! end times and tolerances
    type(common_t) :: common !! the state at FROM
    type(levers_t) :: levers !! of the reaction sets
    type(starts_t) :: starts !! contact forces of the variants so far
    real(wp), allocatable :: energy(:) !! (end times) with which an iteration has begun, 0 unknown
    !! [force length]
    integer :: with_factors = 0 !! variants that use the factors of the run
    logical :: changed_loads = .false. !! the influence is that of another variant
  end type shared_t

contains

  !> All variants; the context has made the run of the deck's own values.
  subroutine run_study(options, commands, base, study, context, seconds, error)
    type(options_t), intent(in) :: options !! the command line
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    character(*), intent(in) :: base !! path of the files without ending
    type(study_t), intent(in) :: study !! the variants
    type(context_t), target, intent(inout) :: context !! its system is used
    real(wp), allocatable, intent(out) :: seconds(:) !! (n_costs+1) what a variant costs: each kind
    !! of work, and all of it; only if there is a study that has begun [s]
    type(error_t), allocatable, intent(out) :: error !! file trouble, variants that have failed
    type(shared_t) :: shared
    type(text_file_t) :: table
    type(result_t) :: result
    type(diagnostics_t) :: unheard
    integer :: k, failed
    real(wp) :: began, before(n_costs)

    call read_plan(commands, shared%plan, unheard)
    call read_variant(options%deck, options%overrides, shared%base, error)
    if (allocated(error)) return
    call exterior_facets(shared%base%model%mesh, shared%exterior)
    call begin_common(study, shared%plan, shared%base%model, context%system, context%form, &
      context%monitor, shared%common, error)
    if (allocated(error)) return
    if (.not. context%form%kind%knows_inside) call find_levers(shared%base%model, &
      context%system, context%form, shared%base%model%output%reactions, shared%levers)
    call create_study_table(table, base//'.study', context%model%title, study, &
      context%model%output%reactions, error)
    if (allocated(error)) return
    call begin_variants(context%files%results, names_of(study), sets_of(context%model), error)
    if (allocated(error)) return
    call begin_starts(study, context%model, size(shared%plan%times), shared%common%step + 1, &
      shared%starts)
    allocate (shared%energy(size(shared%plan%times)), source=0.0_wp)
    failed = 0
    began = wall_seconds()
    before = context%form%costs%seconds
    do k = 1, size(study%order)
      if (stop_requested()) exit
      call run_variant(options, study, study%order(k), shared, context, base, result, error)
      if (allocated(error)) return
      if (result%code /= exit_done) failed = failed + 1
      call write_variant(table, study, study%order(k), result, error)
      call append_variant_row(context%files%results, variant_row_t(study%order(k), &
        study%variants(:, study%order(k)), result%code, result%step, result%reactions), error)
      if (allocated(error)) return
      call print_line(context%terminal, 'variant '//to_text(k)//' of '// &
        to_text(size(study%order))//'  '//values_text(study, study%order(k))//'  '// &
        count_noun(result%iterations, 'solve')//left_text(k, size(study%order), wall_seconds() &
        - began))
    end do
    call close_text_file(table, error)
    seconds = [context%form%costs%seconds - before, wall_seconds() &
      - began]/real(size(study%order), wp)
    call context%monitor%event('study '//study%name//': factor, compliance, influence: '// &
      'shared by '//to_text(shared%with_factors)//' of '//to_text(size(study%order))//'; '// &
      to_text(seconds(n_costs + 1), 3)//' s a variant')
    if (failed > 0 .and. .not. allocated(error)) call raise(error, exit_no_convergence, &
      'error: '//count_noun(failed, 'variant')//' of '//to_text(size(study%order))// &
      ' failed'//new_line('a')//'  '//base//'.study says which and how far they went')
  end subroutine run_study

  !> Names of what a study varies.
  pure function names_of(study) result(names)
    type(study_t), intent(in) :: study !! parameters
    character(name_length) :: names(size(study%varied))
    integer :: i

    do i = 1, size(names)
      names(i) = study%varied(i)%name
    end do
  end function names_of

  !> Names of the sets of the reactions.
  pure function sets_of(model) result(names)
    type(model_t), intent(in) :: model !! what it writes
    character(name_length) :: names(size(model%output%reactions))
    integer :: i

    do i = 1, size(names)
      names(i) = model%output%reactions(i)%s
    end do
  end function sets_of

  !> What a study asks of the run: commands that it knows, and up to FROM nothing that varies.
  !! Looked up before any file is touched.
  subroutine check_run(options, commands, study, diagnostics, error)
    type(options_t), intent(in) :: options !! the command line
    type(batch_command_t), intent(in) :: commands(:) !! the solution commands
    type(study_t), intent(in) :: study !! the variants
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(error_t), allocatable, intent(out) :: error !! the deck cannot be read again
    type(shared_t) :: shared
    type(variant_t) :: variant
    type(error_t), allocatable :: trouble
    integer :: k, errors
    logical :: sharing

    errors = error_count(diagnostics)
    call read_plan(commands, shared%plan, diagnostics)
    if (study%from <= 0.0_wp .or. error_count(diagnostics) > errors) return
    call read_variant(options%deck, options%overrides, shared%base, error)
    if (allocated(error)) return
    call exterior_facets(shared%base%model%mesh, shared%exterior)
    call foresee_common(study, shared%plan, shared%base%model, shared%common, diagnostics)
    do k = 1, size(study%order)
      if (error_count(diagnostics) > errors) return
      call read_values(options, study, k, shared, variant, sharing, trouble)
      if (allocated(trouble)) cycle ! its row says so
      if (.not. sharing) then
        call report_error(diagnostics, study%from_at, 'FROM '//to_text(study%from)// &
          ': variant '//to_text(k)//' ('//values_text(study, k)//') has a factor of its own '// &
          'and no part in common with the others', 'leave FROM out')
      else if (.not. study%forced) then
        if (acts_before(shared%common, shared%base%model, variant%model)) call report_error( &
          diagnostics, study%from_at, 'FROM '//to_text(study%from)//': '//names(study)// &
          ' of variant '//to_text(k)//' acts before that time', 'leave FROM out, or write FROM '// &
          to_text(study%from)//' FORCE to press all variants with the values of the deck')
      end if
    end do
  end subroutine check_run

  !> The names of what a study varies.
  function names(study) result(t)
    type(study_t), intent(in) :: study !! parameters
    character(:), allocatable :: t
    integer :: p

    t = study%varied(1)%name
    do p = 2, size(study%varied)
      t = t//', '//study%varied(p)%name
    end do
  end function names

  !> What the rest may take, in words.
  function left_text(done, all, seconds) result(t)
    integer, intent(in) :: done !! variants done
    integer, intent(in) :: all !! of so many
    real(wp), intent(in) :: seconds !! so far [s]
    character(:), allocatable :: t

    t = ''
    if (seconds < 10.0_wp .or. done == all) return
    t = ', about '//to_text(nint(seconds*real(all - done, wp)/real(done, wp)))//' s left'
  end function left_text

  !> Parameters of a variant and their values.
  function values_text(study, number) result(t)
    type(study_t), intent(in) :: study !! parameters
    integer, intent(in) :: number !! the variant
    character(:), allocatable :: t
    integer :: p

    t = ''
    do p = 1, size(study%varied)
      if (p > 1) t = t//' '
      t = t//study%varied(p)%name//'='//to_text(study%variants(p, number), 6)
    end do
  end function values_text

  !> One variant: read, solved, its reactions kept.
  subroutine run_variant(options, study, number, shared, context, base, result, error)
    type(options_t), intent(in) :: options !! the command line
    type(study_t), intent(in) :: study !! the variants
    integer, intent(in) :: number !! which one
    type(shared_t), intent(inout) :: shared !! what variants share
    type(context_t), target, intent(inout) :: context !! system and log
    character(*), intent(in) :: base !! path of the files without ending
    type(result_t), intent(out) :: result !! what it has come to
    type(error_t), allocatable, intent(out) :: error !! trouble that ends the study
    type(variant_t) :: variant
    type(system_t) :: own
    type(form_t) :: own_form
    type(state_t) :: state
    type(error_t), allocatable :: trouble
    logical :: sharing

    call read_values(options, study, number, shared, variant, sharing, trouble)
    allocate (result%reactions(3, size(shared%base%model%output%reactions), &
      size(shared%plan%times)), source=0.0_wp)
    if (allocated(trouble)) then
      result%code = trouble%code
      call context%monitor%event('variant '//to_text(number)//': '//trouble%message)
      return
    end if
    sharing = sharing .and. .not. context%form%kind%knows_inside
    if (sharing) then
      shared%with_factors = shared%with_factors + 1
      call set_back(variant%model, context%system, context%form, context%state)
      if (shared%changed_loads .or. .not. same_loads(variant%model, shared%base%model)) then
        call change_influence(variant%model, context%system, context%form)
        shared%changed_loads = .not. same_loads(variant%model, shared%base%model)
      end if
      call begin_variant(shared%common, variant%model, context%system%u, context%system%touch, &
        context%form%condensed, context%state)
      context%form%condensed%surface_only = .true.
      context%form%condensed%narrow = .true.
      call choose_neighbours(shared%starts, number)
      call solve_variant(variant%model, context%system, context%form, context%state, shared, &
        .true., result, trouble)
      context%form%condensed%surface_only = .false.
      context%form%condensed%outer%foretold = .false.
    else
      if (study%from > 0.0_wp) then
        call raise(error, exit_deck, 'error: FROM '//to_text(study%from)//': variant '// &
          to_text(number)//' ('//values_text(study, number)//') has a factor of its own and no ' &
          //'part in common with the others'//new_line('a')//'  leave FROM out')
        return
      end if
      own_form%whole%forced = context%form%whole%forced
      call build_system(variant%model, own, own_form, state)
      call solve_variant(variant%model, own, own_form, state, shared, .false., result, trouble)
      call add_costs(context%form%costs, own_form%costs)
      call free_condensed(own_form%condensed)
      call free_solver(own_form%whole%solver)
    end if
    if (allocated(trouble)) then
      result%code = trouble%code
      call context%monitor%event('variant '//to_text(number)//' ('//values_text(study, number)// &
        '): '//trouble%message)
    end if
    if (shared%base%model%output%all_tables) call write_reactions(base, number, &
      shared%base%model%title, shared%base%model%output%reactions, shared%plan%times, result, error)
  end subroutine run_variant

  !> The problem of a variant. Where only contact and loads differ it keeps the mesh of the base,
  !! and what has been factorised.
  subroutine read_values(options, study, number, shared, variant, sharing, trouble)
    type(options_t), intent(in) :: options !! the command line
    type(study_t), intent(in) :: study !! the variants
    integer, intent(in) :: number !! which one
    type(shared_t), intent(in) :: shared !! the deck as it stands
    type(variant_t), intent(out) :: variant !! this one
    logical, intent(out) :: sharing !! its bodies are those of the base
    type(error_t), allocatable, intent(out) :: trouble !! the deck does not take these values
    type(override_t), allocatable :: overrides(:)
    type(difference_t) :: difference
    integer :: p, k

    overrides = options%overrides
    do p = 1, size(study%varied)
      if (.not. study%varied(p)%rule) call set_value(overrides, study%varied(p)%name, &
        study%variants(p, number))
    end do
    call read_next_variant(options%deck, overrides, shared%base%deck, shared%base%model, &
      shared%exterior, variant, difference, trouble)
    sharing = difference%worst <= place_load .and. .not. any(shared%base%model%pairs%fit%adjusted)
    if (allocated(trouble)) return
    if (sharing) sharing = all(abs(shared%base%model%materials%youngs_modulus &
      - variant%model%materials%youngs_modulus) <= 0.0_wp)
    do p = 1, size(study%varied)
      if (.not. study%varied(p)%rule) cycle
      do k = 1, size(variant%model%pairs)
        if (any(has_friction(variant%model%pairs(k)%friction%mu))) &
          variant%model%pairs(k)%friction%slip_rule = nint(study%variants(p, number))
      end do
    end do
  end subroutine read_values

  !> From end time to end time; each starts from the contact forces of the variants before. What
  !! has converged is measured by the start of the first of them, not by a better one.
  subroutine solve_variant(model, system, form, state, shared, sharing, result, trouble)
    type(model_t), intent(inout) :: model !! the problem
    type(system_t), intent(inout) :: system !! its system
    type(form_t), intent(inout) :: form !! the linearised system in its form
    type(state_t), intent(inout) :: state !! where it begins
    type(shared_t), intent(inout) :: shared !! plan, levers, forces of the variants before
    logical, intent(in) :: sharing !! it uses them
    type(result_t), intent(inout) :: result !! what it comes to
    type(error_t), allocatable, intent(out) :: trouble !! why it ended early
    type(study_monitor_t) :: monitor
    type(settings_t) :: settings
    real(wp) :: before
    integer :: i

    result%step = state%step
    before = state%time
    do i = state%step + 1, size(shared%plan%times)
      settings = shared%plan%settings(i)
      if (sharing) then
        if (.not. allocated(form%condensed%outer%kept)) allocate (form%condensed%outer%kept(3, &
          model%mesh%nodes), source=0.0_wp)
        call guess_forces(shared%starts, i, form%condensed)
        settings%first_energy = shared%energy(i)
      end if
      monitor%first_energy = 0.0_wp
      call advance(model, system, form, state, shared%plan%times(i), settings, monitor, trouble)
      if (.not. allocated(trouble)) call check_shapes(model, system, form, state, before, trouble)
      if (allocated(trouble)) exit
      before = state%time
      state%step = i
      result%step = i
      if (sharing) then
        if (shared%energy(i) <= 0.0_wp) shared%energy(i) = monitor%first_energy
        call keep_forces_of(shared%starts, i, form%condensed)
        call reactions_by_levers(model, system, state%time, shared%levers, &
          result%reactions(:, :, i))
      else
        call sum_reactions(model, system%equation, state, result%reactions(:, :, i))
      end if
    end do
    result%iterations = monitor%solves
    result%cuts = monitor%cuts
  end subroutine solve_variant

  !> Sums of the reactions over the sets.
  subroutine sum_reactions(model, equation, state, reactions)
    type(model_t), intent(in) :: model !! sets
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(state_t), intent(in) :: state !! reactions
    real(wp), intent(out) :: reactions(:, :) !! (3, sets) [force]
    integer, allocatable :: nodes(:)
    integer :: i
    logical :: found

    do i = 1, size(model%output%reactions)
      call find_nodes(model%mesh, model%output%reactions(i)%s, nodes, found)
      reactions(:, i) = sum(merge(state%reaction(:, nodes), 0.0_wp, equation(:, nodes) == 0), 2)
    end do
  end subroutine sum_reactions
end module study_run

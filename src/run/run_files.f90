!> The files of a run: tables, log and results; rows are written when an increment has converged.
module run_files
  use kinds, only: wp
  use mortar_rows, only: sum_multipliers
  use mortar_types, only: kept_multipliers
  use vectors, only: cross
  use errors, only: error_t
  use element_types, only: n_element_stress, status_stick, status_slip, status_open
  use element_parameters, only: d03_epsilon
  use mesh_names, only: find_nodes
  use model_types, only: model_t, state_none
  use contact_points, only: count_points, point_field
  use slave_points, only: lift_forces
  use smooth_patch, only: patch_frame
  use system_types, only: form_t, system_t, state_t
  use system_parts, only: contact_places_t
  use audit_types, only: audit_t
  use body_measures, only: lever_ends
  use costs, only: cost_t
  use tables, only: table_t, create_reaction_table, create_contact_table, write_contacts, &
    create_history_table, write_history, create_point_table, write_points, create_rigid_table, &
    write_rows, close_table
  use contact_sides, only: contact_surface_t, find_slave_surface
  use point_rows, only: point_row_t, find_point_rows
  use run_log, only: log_t, create_log, close_log
  use results_file, only: results_t, create_results, append_results, close_results, fields_due
  use results_contact, only: contact_file_t, create_contact_file, append_contact_frame, &
    close_contact_file
  use ranks, only: this_rank
  use rigid_paths, only: count_rigid
  use result_types, only: origin_t, end_row_t, contact_row_t, frame_t, saved_state_t, &
    derivative_rows_t
  use point_fields, only: point_fields_t
  use element_fields, only: nodal_fields_t
  use frame_fields, only: fill_frame, fill_points
  use rigid_report, only: rigid_rows
  use results_names, only: bodies_ending, contact_ending
  use text_files, only: make_folder
  use scene_marks, only: mark_scene, mark_time
  use restored_balance, only: residual_share_of
  implicit none
  private
  public :: run_files_t, create_files, write_row, fill_state, close_files

  !> Open files.
  type :: run_files_t
    logical :: open = .false. !! they have been created
    type(table_t) :: reactions !! .rea
    type(table_t) :: contacts !! .con
    type(table_t) :: history !! .his, with OUTPut HISTory only
    type(table_t) :: points !! .pts, with OUTPut POINts only
    type(contact_surface_t), allocatable :: slaves(:) !! slave sides of its pairs
    type(table_t) :: rigid !! .rig, with RIGId only
    type(log_t) :: log !! .log
    type(results_t) :: results !! .vtkhdf
    type(contact_file_t) :: surfaces !! .contact.vtkhdf, with the field contact
    real(wp), allocatable :: point_state(:, :) !! (n_element_stress, points) of the last row
    real(wp), allocatable :: stress(:, :) !! (6, elements) of a row not written, if it is due
    real(wp), allocatable :: strain(:, :) !! (6, elements) likewise
    type(nodal_fields_t) :: nodal !! stress and strain at the nodes, likewise
  end type run_files_t

contains

  !> Creates all files; nothing is created before a deck has been accepted.
  subroutine create_files(files, base, folder, model, system, origin, error)
    type(run_files_t), intent(out) :: files !! open files
    character(*), intent(in) :: base !! path without extension
    character(*), intent(in) :: folder !! folder to make first, empty for none
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! the system
    type(origin_t), intent(in) :: origin !! what makes them
    type(error_t), allocatable, intent(out) :: error !! file trouble

    if (len(folder) > 0) call make_folder(folder, error)
    if (allocated(error)) return
    call create_log(files%log, base//'.log', model, origin, system%equations, error)
    call create_reaction_table(files%reactions, base//'.rea', model%title, &
      model%output%reactions, error)
    call create_contact_table(files%contacts, base//'.con', model%title, model%pairs, error)
    if (size(model%output%history) > 0) call create_history_table(files%history, base//'.his', &
      model%title, model%output%history, error)
    if (size(model%output%points) > 0) call create_points(files, base//'.pts', model, error)
    if (count_rigid(model) > 0) call create_rigid_table(files%rigid, base//'.rig', &
      model%title, model%conditions%rigid, error)
    if (this_rank() == 0) call create_results(files%results, base//bodies_ending, model, &
      system%body%bodies, origin, error)
    if (this_rank() == 0 .and. model%output%contact .and. size(model%pairs) > 0) &
      call create_contact_file(files%surfaces, base//contact_ending, model, origin%end_times, error)
    if (allocated(error)) return
    allocate (files%point_state(n_element_stress, system%contact%n), source=0.0_wp)
    files%open = .true.
  end subroutine create_files

  !> Creates the table of contact points.
  subroutine create_points(files, path, model, error)
    type(run_files_t), intent(inout) :: files !! gets points, slaves
    character(*), intent(in) :: path !! its name
    type(model_t), intent(in) :: model !! the problem
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    integer :: i

    allocate (files%slaves(size(model%output%points)))
    do i = 1, size(files%slaves)
      call find_slave_surface(model%pairs(model%output%points(i)), model%mesh, files%slaves(i))
    end do
    call create_point_table(files%points, path, model%title, model%pairs(model%output%points), &
      error)
  end subroutine create_points

  !> Writes and flushes the rows of an end time.
  subroutine write_row(files, model, system, form, state, increment, audit, derivatives, error)
    type(run_files_t), intent(inout) :: files !! open files, fields recovered
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! the system
    type(form_t), intent(in) :: form !! condensed, its kind
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: increment !! its increment of time
    type(audit_t), intent(in) :: audit !! its audit
    type(derivative_rows_t), intent(in), optional :: derivatives !! if they are asked for
    type(error_t), allocatable, intent(out) :: error !! file trouble
    type(end_row_t) :: row
    real(wp), allocatable :: ends(:, :)
    integer :: k

    row%step = state%step
    row%time = state%time
    if (present(derivatives)) row%derivatives = derivatives
    allocate (row%reactions(3, size(model%output%reactions)), row%pairs(size(model%pairs)))
    do k = 1, size(model%output%reactions)
      if (state%whole) then
        row%reactions(:, k) = reaction_of(model, state, model%output%reactions(k)%s)
      else
        row%reactions(:, k) = form%condensed%sums%value(3*k - 2:3*k)
      end if
    end do
    if (size(model%pairs) > 0) ends = lever_ends(model%mesh%x, state%u, system)
    do k = 1, size(model%pairs)
      call sum_points(model, system, ends, files%point_state, k, row%pairs(k))
    end do
    if (count_rigid(model) > 0) row%rigid = rigid_rows(model, system, state)
    call write_rows(files%reactions, state%step, state%time, row%reactions, error)
    call write_contacts(files%contacts, state%step, state%time, row%pairs, error)
    if (size(model%output%history) > 0) call write_history(files%history, state%step, state%time, &
      [(state%u(model%output%history(k)%dof, model%output%history(k)%node), k=1, &
      size(model%output%history))], error)
    call write_point_rows(files, model, system%place, state, error)
    if (allocated(row%rigid)) call write_rows(files%rigid, state%step, state%time, row%rigid, error)
    call write_fields(files, model, system, form, state, increment, row, audit, error)
  end subroutine write_row

  !> Appends the rows of the table of contact points.
  subroutine write_point_rows(files, model, place, state, error)
    type(run_files_t), intent(inout) :: files !! open files
    type(model_t), intent(in) :: model !! the problem
    type(contact_places_t), intent(in) :: place !! contact elements
    type(state_t), intent(in) :: state !! the converged state
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(point_fields_t) :: points
    type(point_row_t), allocatable :: rows(:)
    integer :: i, k

    do i = 1, size(model%output%points)
      k = model%output%points(i)
      call fill_points(model%pairs(k), model%mesh%x, state%u, files%point_state(:, &
        place%first_point(k):place%first_point(k + 1) - 1), points)
      call find_point_rows(model%pairs(k), files%slaves(i), points, model%mesh%nodes, rows)
      call write_points(files%points, state%step, state%time, i, rows, error)
    end do
  end subroutine write_point_rows

  !> Appends fields and state to the results, those that are due and asked for.
  subroutine write_fields(files, model, system, form, state, increment, row, audit, error)
    type(run_files_t), intent(inout) :: files !! open files
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! the system
    type(form_t), intent(in) :: form !! condensed, its kind
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: increment !! its increment of time
    type(end_row_t), intent(in) :: row !! sums of the end time
    type(audit_t), intent(in) :: audit !! the audit of the end time
    type(error_t), allocatable, intent(inout) :: error !! file trouble
    type(frame_t) :: frame
    type(saved_state_t) :: saved

    if (this_rank() > 0) return
    if (.not. fields_due(model%output, state%step)) then
      call append_results(files%results, model, row, audit, error=error)
      return
    end if
    call fill_frame(model, system, state, files%point_state, files%stress, &
      files%strain, files%nodal%values, frame)
    if (model%output%state == state_none) then
      call append_results(files%results, model, row, audit, frame, error=error)
    else
      call fill_state(model, system, form, state, increment, saved)
      call append_results(files%results, model, row, audit, frame, saved, error)
    end if
    if (allocated(error) .or. .not. allocated(frame%motion)) return
    call append_contact_frame(files%surfaces, model, state%time, frame, error)
  end subroutine write_fields

  !> Sum of the reactions over the nodes of a set.
  function reaction_of(model, state, name) result(r)
    type(model_t), intent(in) :: model !! the problem
    type(state_t), intent(in) :: state !! the converged state
    character(*), intent(in) :: name !! the set
    real(wp) :: r(3)
    integer, allocatable :: nodes(:)
    logical :: found

    call find_nodes(model%mesh, name, nodes, found)
    r = sum(state%reaction(:, nodes), 2)
  end function reaction_of

  !> Sums of one pair over its points (doc/manual, "Contact table").
  subroutine sum_points(model, system, ends, point_state, k, row)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! contact elements
    real(wp), intent(in) :: ends(:, :) !! (3, nodes) where forces act [length]
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of elmt03
    integer, intent(in) :: k !! the pair
    type(contact_row_t), intent(out) :: row !! its sums
    real(wp) :: f(3), x(3), share
    integer :: p, element

    share = 1.0_wp
    row%max_criterion = -huge(1.0_wp)
    do p = 1, count_points(model%pairs(k))
      element = system%place%first_point(k) + p - 1
      associate (point => point_state(:, element), &
        status => model%pairs(k)%history%old(p)%status)
        if (status <= status_open) cycle
        if (status == status_stick) row%stick = row%stick + 1
        if (status == status_slip) row%slip = row%slip + 1
        f = -point(1:3)
        x = point_field(model%pairs(k), p, ends)
        row%normal = row%normal + point(13)
        row%tangential = row%tangential + point(14)
        row%force = row%force + f
        row%moment = row%moment + cross(x, f) + lift_moment(ends, system, element, f)
        row%max_penetration = max(row%max_penetration, -point(4))
        row%max_elastic_slip = max(row%max_elastic_slip, point(5))
        ! a stiff penalty is solved for by multipliers on a softer one
        if (model%pairs(k)%history%softened) share = system%contact%d(d03_epsilon, element) &
          /model%pairs(k)%points%epsilon(p)
        row%max_criterion = max(row%max_criterion, share*point(6))
      end associate
    end do
    row%active = row%stick + row%slip
    if (row%active == 0) row%max_criterion = 0.0_wp
    if (model%pairs(k)%mortar) then
      call sum_multipliers(model%pairs(k), row)
    else if (row%tangential > 0.0_wp) then
      row%lumped = lumped_friction(model, system, point_state, k)
    end if
  end subroutine sum_points

  !> Moment of the couple that holds a point over its slave facet, with the same lever arms.
  pure function lift_moment(ends, system, element, force) result(moment)
    real(wp), intent(in) :: ends(:, :) !! (3, nodes) where forces act [length]
    type(system_t), intent(in) :: system !! contact elements
    integer, intent(in) :: element !! one of them
    real(wp), intent(in) :: force(3) !! on its point
    real(wp) :: moment(3), r(3, 3)
    integer :: nodes(3), k

    moment = 0.0_wp
    if (system%contact%slaves(element) == 1) return
    nodes = system%contact%ix(1:3, element)
    r = reshape(lift_forces(patch_frame(system%position%x_now(:, nodes)), &
      system%contact%lift(element), force), [3, 3])
    do k = 1, 3
      moment = moment + cross(ends(:, nodes(k)), r(:, k))
    end do
  end function lift_moment

  !> Sum of the magnitudes of the friction forces of a pair after they have been handed on to its
  !! slave nodes with the weights of the points.
  pure real(wp) function lumped_friction(model, system, point_state, k) result(lumped)
    type(model_t), intent(in) :: model !! the problem
    type(system_t), intent(in) :: system !! contact elements
    real(wp), intent(in) :: point_state(:, :) !! (n_element_stress, points) of elmt03
    integer, intent(in) :: k !! the pair
    real(wp) :: friction(3), sums(3, model%mesh%nodes)
    integer :: p, b, element

    sums = 0.0_wp
    associate (pair => model%pairs(k))
      do p = 1, count_points(pair)
        element = system%place%first_point(k) + p - 1
        if (pair%history%old(p)%status <= status_open) cycle
        associate (f => point_state(1:3, element), e => point_state(10:12, element))
          friction = f - dot_product(f, e)*e
        end associate
        do b = 1, pair%points%n_slaves
          associate (node => pair%points%point_nodes(b, p))
            sums(:, node) = sums(:, node) + pair%points%point_weights(b, p)*friction
          end associate
        end do
      end do
    end associate
    lumped = sum(norm2(sums, 1))
  end function lumped_friction

  !> What a restart needs.
  subroutine fill_state(model, system, form, state, increment, saved)
    type(model_t), intent(in) :: model !! contact history
    type(system_t), intent(in) :: system !! pattern of its matrix
    type(form_t), intent(in) :: form !! condensed, its kind
    type(state_t), intent(in) :: state !! the converged state
    real(wp), intent(in) :: increment !! increment of time
    type(saved_state_t), intent(out) :: saved !! the state
    integer :: k

    saved%step = state%step
    saved%time = state%time
    saved%increment = increment
    saved%displacement = state%u
    saved%reaction = state%reaction
    saved%rigid = state%rigid
    saved%scene = [mark_scene(model, system, state%time), mark_time(state%time)]
    saved%residual = residual_share_of(system, form)
    if (.not. form%kind%knows_inside .and. allocated(form%condensed%outer%kept)) then
      saved%candidate = merge(1, 0, form%condensed%candidate)
      saved%contact_force = form%condensed%outer%kept
    else if (form%kind%inexact) then
      saved%candidate = merge(1, 0, form%condensed%candidate)
      saved%contact_force = 0.0_wp*state%u
      saved%factor_aging = [form%condensed%aging, real(form%condensed%refusals, wp)]
      if (allocated(form%condensed%made_at)) saved%factor_displacement = form%condensed%made_at
    end if
    if (allocated(system%touch%u_before)) then
      saved%span_before = system%touch%span_before
      saved%displacement_before = system%touch%u_before
    end if
    saved%slopes = state%slopes
    if (allocated(system%bulk%memory)) saved%memory = reshape(system%bulk%memory, &
      [size(system%bulk%memory)])
    allocate (saved%pairs(size(model%pairs)))
    do k = 1, size(model%pairs)
      saved%pairs(k)%points = model%pairs(k)%history%old
      if (model%pairs(k)%segmented) saved%pairs(k)%cells = model%pairs(k)%history%old_cells
      if (model%pairs(k)%mortar) saved%pairs(k)%multipliers = kept_multipliers( &
        model%pairs(k)%old_nodes, size(saved%pairs(k)%points))
      saved%pairs(k)%coupled = system%place%coupled_targets(system%place%first_point(k): &
        system%place%first_point(k + 1) - 1)
    end do
  end subroutine fill_state

  !> Closes whatever is open; the first trouble is reported.
  subroutine close_files(files, costs, error)
    type(run_files_t), intent(inout) :: files !! the files
    type(cost_t), intent(in) :: costs !! cost table
    type(error_t), allocatable, intent(inout) :: error !! file trouble, unless some came before

    if (.not. files%open) return
    if (this_rank() == 0) call close_results(files%results, costs, error)
    if (this_rank() == 0) call close_contact_file(files%surfaces, error)
    call close_table(files%reactions, error)
    call close_table(files%contacts, error)
    call close_table(files%points, error)
    call close_table(files%history, error)
    call close_table(files%rigid, error)
    call close_log(files%log, error)
    files%open = .false.
  end subroutine close_files
end module run_files

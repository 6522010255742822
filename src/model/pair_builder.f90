!> Builds the contact pairs on the complete mesh: slave points, master facets, penalties, lay.
module pair_builder
  use kinds, only: wp
  use text, only: to_text, range_text, count_noun
  use diagnostics, only: diagnostics_t, report_error, report_note, error_count
  use mesh_types, only: mesh_t
  use facets, only: facet_table_t, exterior_facets
  use friction_laws, only: cone_laws, acts
  use contact_types, only: pair_t, penalty_area, penalty_nodal, form_quadrature_to_surface
  use contact_parameters, only: is_round_off, has_field
  use contact_points, only: count_points, point_text
  use contact_cells, only: prepare_cells
  use contact_reader, only: pair_draft_t
  use model_types, only: model_t
  use loads, only: has_load
  use pair_sides, only: take_master, take_slave, take_slave_facets, check_common_facets
  use pair_lay, only: set_lay
  use penalty_values, only: set_penalties
  use bodies, only: find_bodies
  use facet_depths, only: body_facets_t, measure_depths
  use tool_sides, only: face_tools
  use gap_adjustment, only: adjust_gaps, adjustment_t
  implicit none
  private
  public :: build_pairs

contains

  !> Fills model%pairs from what the deck says. After errors what may hang on them is left out.
  subroutine build_pairs(drafts, elastic, diagnostics, model, known)
    type(pair_draft_t), intent(inout) :: drafts(:) !! the pairs as read; get what ADJUst has done
    logical, intent(in) :: elastic !! the materials are without error
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(inout) :: model !! mesh and materials; receives the pairs
    type(facet_table_t), intent(in) :: known !! exterior facets, if they are at hand
    type(facet_table_t) :: exterior
    type(body_facets_t) :: outside
    integer, allocatable :: body(:), body_of_node(:)
    integer :: i, bodies
    logical :: sound

    sound = error_count(diagnostics) == 0
    allocate (model%pairs(size(drafts)))
    if (size(drafts) == 0) return
    if (allocated(known%corners)) then
      exterior = known
    else
      call exterior_facets(model%mesh, exterior)
    end if
    if (sound) call face_tools(drafts, exterior, diagnostics, model%mesh)
    do i = 1, size(drafts)
      if (.not. (sound .and. drafts(i)%has_form .and. drafts(i)%pair%fit%adjusted)) cycle
      call adjust_pair(drafts(i)%pair, exterior, diagnostics, model%mesh)
    end do
    call find_bodies(model%mesh, body, body_of_node, bodies)
    do i = 1, size(drafts)
      model%pairs(i) = drafts(i)%pair
      if (.not. drafts(i)%has_form) cycle
      call build_pair(drafts(i), exterior, elastic, outside, diagnostics, model, &
        model%pairs(i))
      call keep_bodies(body_of_node, model%pairs(i))
    end do
  end subroutine build_pairs

  !> Keeps the bodies of points and facets where both sides of a pair belong to one body; not with
  !! SHRInk, whose overlaps are meant.
  pure subroutine keep_bodies(body_of_node, pair)
    integer, intent(in) :: body_of_node(:) !! (nodes) body of each
    type(pair_t), intent(inout) :: pair !! gets bodies
    integer, allocatable :: of_points(:), of_facets(:)
    logical :: met(0:maxval([0, body_of_node]))

    if (.not. (allocated(pair%surface%facets) .and. allocated(pair%points%point_nodes))) return
    if (pair%shrinking%shrink >= 0) return
    if (pair%segmented) then
      if (.not. allocated(pair%points%slave_facets)) return
      of_points = body_of_node(pair%points%slave_facets(1, :))
    else
      of_points = body_of_node(pair%points%point_nodes(1, :))
    end if
    of_facets = body_of_node(pair%surface%facets(1, :))
    met = .false.
    met(of_facets) = .true.
    if (.not. any(met(of_points))) return
    call move_alloc(of_points, pair%points%body)
    call move_alloc(of_facets, pair%surface%body)
  end subroutine keep_bodies

  !> Moves the slave nodes of a pair that are next to the master onto it, and notes what was done.
  !! What is wrong with the pair is reported when it is built.
  subroutine adjust_pair(asked, exterior, diagnostics, mesh)
    type(pair_t), intent(inout) :: asked !! the pair as read; gets moved, farthest, farthest_way
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    type(diagnostics_t), intent(inout) :: diagnostics !! gets a note
    type(mesh_t), intent(inout) :: mesh !! its nodes are moved
    type(pair_t) :: pair
    type(diagnostics_t) :: later
    type(adjustment_t) :: done
    character(:), allocatable :: t
    logical :: found_slave, found_master

    pair = asked
    call take_master(mesh, later, pair, found_master)
    call take_slave(mesh, exterior, later, pair, found_slave)
    if (.not. (found_slave .and. found_master)) return
    call check_common_facets(mesh, pair, later)
    if (error_count(later) > 0) return
    call adjust_gaps(pair%points%point_nodes(1, :), pair%points%slave_facets, &
      pair%surface%facets, pair%surface%neighbours, &
      pair%fit%adjust, mesh, done)
    asked%fit%moved = done%moved
    asked%fit%farthest = done%farthest
    asked%fit%farthest_way = done%largest
    t = 'pair '//pair%name//': '//count_noun(done%moved, 'slave node')//' moved onto the master'
    if (done%moved > 0) t = t//', at most by '//to_text(done%largest, 4)//' (node '// &
      to_text(done%farthest)//')'
    if (done%left > 0) t = t//'; '//to_text(done%left)// &
      ' left where they are, the first is node '//to_text(done%left_node)//': element '// &
      to_text(done%left_element)//' would lose its shape'
    call report_note(diagnostics, pair%at, t)
  end subroutine adjust_pair

  !> Builds one pair.
  subroutine build_pair(draft, exterior, elastic, outside, diagnostics, model, pair)
    type(pair_draft_t), intent(in) :: draft !! the pair as read
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    logical, intent(in) :: elastic !! the materials are without error
    type(body_facets_t), intent(inout) :: outside !! the same for rays; made when it is needed
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(inout) :: pair !! the pair
    logical :: found_slave, found_master

    call take_master(model%mesh, diagnostics, pair, found_master)
    if (pair%form == form_quadrature_to_surface) then
      call take_slave_facets(model%mesh, diagnostics, pair, found_slave)
    else
      call take_slave(model%mesh, exterior, diagnostics, pair, found_slave)
    end if
    if (found_master .and. (draft%complete .or. draft%has_direction)) call set_lay( &
      draft%has_direction, model%mesh, diagnostics, pair)
    if (.not. (found_slave .and. found_master)) return
    if (error_count(diagnostics) > 0) then
      if (size(pair%surface%facets, 2) == 0 .or. count_points(pair) == 0) return
    end if
    call check_common_facets(model%mesh, pair, diagnostics)
    if (pair%shrinking%shrink >= 0) call check_shrink(model, pair, diagnostics)
    if (.not. (elastic .and. draft%complete)) return
    if (.not. pair%mortar) call take_penalties(model, diagnostics, pair)
    call measure_depths(model%mesh, exterior, outside, pair)
    if (pair%segmented) call prepare_cells(model%mesh%x, pair)
    allocate (pair%history%old(count_points(pair)), pair%history%new(count_points(pair)))
  end subroutine build_pair

  !> Index of the first true value, 0 if there is none.
  pure integer function first_true(mask) result(first)
    logical, intent(in) :: mask(:) !! any values

    do first = 1, size(mask)
      if (mask(first)) return
    end do
    first = 0
  end function first_true

  !> Penalties; those of AUTO are noted, for the log.
  subroutine take_penalties(model, diagnostics, pair)
    type(model_t), intent(in) :: model !! mesh and materials
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    type(pair_t), intent(inout) :: pair !! the pair
    character(:), allocatable :: point_noun
    logical :: found

    point_noun = 'node'
    if (pair%points%n_slaves > 1) point_noun = 'point'
    call set_penalties(model, pair, found)
    call check_areas(pair, diagnostics)
    if (found .and. pair%points%n_slaves > 1 .and. is_round_off(pair)) then
      call report_note(diagnostics, pair%at, 'pair '//pair%name//': with '// &
        to_text(pair%points%relative, 3)// &
          ' E/h the penalty makes forces of the round-off of a gap '// &
        'where bodies yield: a factor of AUTO up to 1000 serves GTOS; NTOS or AUGMent take any')
    end if
    if (found) then
      if (has_field(pair) .and. pair%points%relative > 0.0_wp) call report_note(diagnostics, &
        pair%at, &
        'pair '//pair%name//': AUGMent on slave facets has a penalty of its own, the deck''s '// &
        'does not count: multipliers close the gaps on average, it only evens out the points')
      if (pair%penalty_kind == penalty_nodal .or. size(pair%points%epsilon) == 0) return
      if (pair%segmented) then
        call report_note(diagnostics, pair%at, 'pair '//pair%name//': penalty '// &
          to_text(pair%points%epsilon(1)/pair%points%area(1))//' force per length and area'// &
          expected_penetration(pair))
        return
      end if
      call report_note(diagnostics, pair%at, 'pair '//pair%name//': penalty '// &
        range_text(pair%points%epsilon)//' force per length and '//point_noun// &
          expected_penetration(pair))
    else if (pair%penalty_kind == penalty_area) then
      call report_error(diagnostics, pair%slave_at, 'slave '// &
        point_text(pair, first_true(pair%points%area <= 0.0_wp))//' of '''//pair%slave// &
        ''' has no area: no exterior facet around it lies in the set', &
        'name a surface as slave, or give the penalty per node')
    else
      call report_error(diagnostics, pair%at, 'pair '//pair%name// &
        ' has no elastic side to take its penalty from', 'write PENAlty and a value')
    end if
  end subroutine take_penalties

  !> Laws that ask for an area need it at every point.
  subroutine check_areas(pair, diagnostics)
    type(pair_t), intent(in) :: pair !! the pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: k

    if (pair%segmented .or. pair%penalty_kind == penalty_area) return
    if (all(pair%points%area > 0.0_wp)) return
    do k = 1, size(cone_laws)
      if (.not. (cone_laws(k)%needs_area .and. acts(k, pair%law))) cycle
      call report_error(diagnostics, pair%slave_at, 'slave '// &
        point_text(pair, first_true(pair%points%area <= 0.0_wp))//' of '''//pair%slave// &
        ''' has no area, which '//trim(cone_laws(k)%keyword)//' needs', &
        'name a surface as slave')
    end do
  end subroutine check_areas

  !> What the penalty means: over E/h, and how deep an ordinary pressure goes.
  pure function expected_penetration(pair) result(t)
    type(pair_t), intent(in) :: pair !! penalties set
    character(:), allocatable :: t
    real(wp) :: depth

    t = ''
    if (pair%points%relative <= 0.0_wp) return
    depth = 1.0e-3_wp*pair%points%cell
    if (pair%points%relative < 1.0_wp) depth = min(depth, 0.5_wp*huge(depth)*pair%points%relative)
    t = ', '//to_text(pair%points%relative, 3)//' E/h with h = '//to_text(pair%points%cell, 3)// &
      '; a pressure of E/1000 penetrates by '// &
      to_text(depth/pair%points%relative, 2)//' [length]'
    if (pair%augmented) t = ', '//to_text(pair%points%relative, 3)//' E/h with h = '// &
      to_text(pair%points%cell, 3)//'; AUGMent closes the gap it leaves'
  end function expected_penetration

  !> SHRInk wants a table, and goes neither with multipliers nor with gaps that are closed.
  subroutine check_shrink(model, pair, diagnostics)
    type(model_t), intent(in) :: model !! tables
    type(pair_t), intent(in) :: pair !! the pair
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (.not. has_load(model%tables, pair%shrinking%shrink)) then
      call report_error(diagnostics, pair%shrinking%shrink_at, 'proportional load '// &
        to_text(pair%shrinking%shrink)//' has no table', 'define it with PROPortional '// &
        to_text(pair%shrinking%shrink)//', or write 0 for the sum of all tables')
    else if (pair%augmented) then
      call report_error(diagnostics, pair%shrinking%shrink_at, 'SHRInk does not go with AUGMent', &
        'leave AUGMent out; a penalty of AUTO 100 leaves little of the overlap')
    else if (pair%fit%adjusted) then
      call report_error(diagnostics, pair%shrinking%shrink_at, &
        'SHRInk does not go with ADJUst, which '// &
        'takes the overlap away', 'leave one of them out')
    end if
  end subroutine check_shrink
end module pair_builder

!> The audit in the reader's words: the table of the log, warnings with what to do, and the message
!! of a body out of balance (doc/manual, "The audit").
module audit_text
  use kinds, only: wp, pi
  use text, only: to_text, count_noun, lower
  use json_lines, only: item, list_item, object
  use model_types, only: model_t
  use system_types, only: system_t
  use diagnosis, only: body_name
  use bulk_laws, only: laws
  use statics, only: verdict_t, judge_at_rest, statics_carried
  use statics_report, only: motion_text, turned_text
  use body_measures, only: farthest_turn
  use shape_audit, only: most_swelling
  use answers_text, only: answers_finding, answers_advice
  use audit_types, only: audit_t, most_lost, verdict_failed, check_names, n_checks, &
    check_balance, check_work, check_strain, check_rotation, check_turning, check_volume, &
    check_penetration, check_elastic_slip, check_facets, check_locking, check_moved, &
    check_edges, check_penalty, check_answers
  implicit none
  private
  public :: audit_table, audit_record, audit_finding, audit_warning, balance_message, shape_message

  character(7), parameter :: verdict_words(0:2) = [character(7) :: 'ok', 'warning', 'FAILED']
  character(1), parameter :: nl = new_line('a')

contains

  !> The table of an end time; unless it is wanted in full, its head and the lines whose verdict has
  !! changed.
  function audit_table(model, system, audit, full) result(table)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies
    type(audit_t), intent(in) :: audit !! an audited end time
    logical, intent(in) :: full !! all lines
    character(:), allocatable :: table
    character(15) :: name
    integer :: i

    table = 'audit: step '//to_text(audit%step)//' time '//to_text(audit%time)//' '// &
      trim(verdict_words(maxval(audit%verdict)))
    if (.not. full .and. all(audit%verdict == audit%before)) then
      table = table//', balance within '//to_text(audit%value(check_balance), 2)// &
        round_off_text(audit)
      return
    end if
    do i = 1, n_checks
      if (.not. full .and. audit%verdict(i) == audit%before(i)) cycle
      name = check_names(i)
      table = table//nl//'  '//name//verdict_words(audit%verdict(i))//'  '// &
        finding(model, system, audit, i)
    end do
  end function audit_table

  !> The table of an end time, as items of a record.
  function audit_record(model, system, audit) result(t)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies
    type(audit_t), intent(in) :: audit !! an audited end time
    character(:), allocatable :: t, checks
    integer :: i

    checks = ''
    do i = 1, n_checks
      checks = checks//object(item('name', trim(check_names(i)))//item('verdict', &
        trim(lower(verdict_words(audit%verdict(i)))))//item('value', audit%value(i))// &
        item('finding', finding(model, system, audit, i)))
    end do
    t = item('step', audit%step)//item('time', audit%time)//item('verdict', &
      trim(lower(verdict_words(maxval(audit%verdict)))))//list_item('checks', checks)
  end function audit_record

  !> A check that is ok, in a line of its own.
  function audit_finding(model, system, audit, check) result(t)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies
    type(audit_t), intent(in) :: audit !! begun
    integer, intent(in) :: check !! the check
    character(:), allocatable :: t

    t = trim(check_names(check))//': '//finding(model, system, audit, check)
  end function audit_finding

  !> What a check has found.
  function finding(model, system, audit, check) result(t)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies
    type(audit_t), intent(in) :: audit !! an audited end time
    integer, intent(in) :: check !! the check
    character(:), allocatable :: t

    associate (value => audit%value(check), worst => audit%worst(check))
      select case (check)
      case (check_balance)
        t = 'forces and moments of '//count_noun(system%body%bodies, 'body')// &
          ' are in equilibrium to '//to_text(value, 2)//' of the force scale '// &
          to_text(audit%scale, 4)
        if (system%body%bodies > 1) t = 'forces and moments of each of '// &
          to_text(system%body%bodies)// &
          ' bodies are in equilibrium to '//to_text(value, 2)//' of the force scale '// &
          to_text(audit%scale, 4)
        t = t//round_off_text(audit)
      case (check_work)
        t = 'work '//to_text(audit%sum%work, 4)//' is in strain '//to_text(audit%strain_energy, &
          4)// &
          ', penalty '//to_text(audit%penalty_energy, 4)//', friction '// &
          to_text(audit%dissipation, 4)//'; '//work_text(audit)
      case (check_strain, check_rotation)
        t = field_finding(model, audit, check)
      case (check_turning)
        t = 'no body can move'
        if (any(audit%fixed%moves)) t = 'not limited: what moves is of finite strain'
        if (worst > 0) t = 'at most '//to_text(value, 3)//' degrees as a whole, '// &
          body_name(model, system, worst)
      case (check_volume)
        t = 'no body of small strain deforms'
        if (worst > 0) t = 'changes by at most '//to_text(100.0_wp*value, 3)//' %, '// &
          body_name(model, system, worst)
      case (check_penetration, check_elastic_slip, check_edges)
        t = 'none'
        if (worst > 0) t = 'at most '//to_text(value, 3)//' of a facet, pair '// &
          model%pairs(worst)%name
      case (check_answers)
        t = answers_finding(model, audit)
      case default
        t = scene_finding(model, audit, check)
      end select
    end associate
  end function finding

  !> How much of the balance is round-off of what is stiffer than the forces are worth, where that
  !! is more than is allowed otherwise.
  function round_off_text(audit) result(t)
    type(audit_t), intent(in) :: audit !! an audited end time
    character(:), allocatable :: t

    t = ''
    if (audit%lacking <= audit%asked .or. audit%lacking > audit%allowed) return
    if (audit%scale <= 0.0_wp) return
    t = ': round-off of what is far stiffer than the forces, which may make '// &
      to_text(audit%allowed/audit%scale, 2)
  end function round_off_text

  !> What of the work is missing, or too much; and why that is no warning where it is much.
  function work_text(audit) result(t)
    type(audit_t), intent(in) :: audit !! an audited end time
    character(:), allocatable :: t

    t = 'energy imbalance '//to_text(100.0_wp*audit%value(check_work), 2)//' % of the work, '
    if (audit%sum%work >= audit%strain_energy + audit%penalty_energy + audit%dissipation) then
      t = t//'lost'
    else
      t = t//'gained'
    end if
    if (audit%value(check_work) <= most_lost .or. audit%verdict(check_work) /= 0) return
    if (audit%depends_on_path) then
      t = t//' so far (judged at the last output time)'
    else
      t = t//' (long increments; without friction the state does not depend on the path)'
    end if
  end function work_text

  !> Materials of elements that deform, of small or of finite strain.
  pure logical function deforms(model, finite)
    type(model_t), intent(in) :: model !! materials and elements
    logical, intent(in) :: finite !! of finite strain
    integer :: e, m

    deforms = .false.
    do e = 1, size(model%element_material)
      m = model%element_material(e)
      if (m <= 0) cycle
      deforms = .not. model%materials(m)%rigid .and. (laws(model%materials(m)%law)%finite .eqv. &
        finite)
      if (deforms) return
    end do
  end function deforms

  !> What a check of the fields has found.
  function field_finding(model, audit, check) result(t)
    type(model_t), intent(in) :: model !! regions
    type(audit_t), intent(in) :: audit !! an audited end time
    integer, intent(in) :: check !! the check
    character(:), allocatable :: t

    t = 'not measured: no field is due'
    if (audit%fields_known) t = 'no element deforms'
    if (audit%fields_known .and. deforms(model, .true.)) t = 'not limited: what deforms is of '// &
      'finite strain'
    if (.not. audit%fields_known .or. audit%worst(check) == 0) return
    t = 'at most '//to_text(audit%value(check), 3)
    if (check == check_rotation) t = t//' degrees'
    t = t//', element '//to_text(audit%worst(check))//region_text(model, audit%worst(check))
  end function field_finding

  !> The region of an element, in brackets.
  function region_text(model, element) result(t)
    type(model_t), intent(in) :: model !! regions
    integer, intent(in) :: element !! the element
    character(:), allocatable :: t

    t = ''
    if (model%mesh%region(element) == 0) return
    associate (region => model%mesh%regions(model%mesh%region(element)))
      if (len(region%name) > 0) t = ' (region '//region%name//')'
    end associate
  end function region_text

  !> What a check of the scene has found.
  function scene_finding(model, audit, check) result(t)
    type(model_t), intent(in) :: model !! names
    type(audit_t), intent(in) :: audit !! begun
    integer, intent(in) :: check !! the check
    character(:), allocatable :: t

    associate (worst => audit%worst(check))
      select case (check)
      case (check_facets)
        t = 'not known'
        if (size(model%pairs) == 0) t = 'no contact'
        if (any(model%pairs%segmented)) t = 'segments fit any'
        if (worst > 0) t = 'those of the slave are '//to_text(audit%fixed%ratio(worst), 3)// &
          ' times as large as those of the master, pair '//model%pairs(worst)%name
      case (check_locking)
        t = 'no element deforms'
        if (deforms(model, .false.) .or. deforms(model, .true.)) t = 'none: elements take the '// &
          'dilatation as a mean'
        if (worst > 0) t = 'Poisson''s ratio is at most '//to_text(audit%value(check), 4)
      case (check_moved)
        t = 'none'
        if (worst > 0) t = count_noun(model%pairs(worst)%fit%moved, 'node')//' by at most '// &
          to_text(model%pairs(worst)%fit%farthest_way, 4)//' (node '// &
          to_text(model%pairs(worst)%fit%farthest)//'), '//to_text(audit%value(check), 3)// &
          ' of a facet, pair '//model%pairs(worst)%name
      case (check_penalty)
        t = 'takes nothing'
        if (size(model%pairs) == 0) t = 'no contact'
        if (worst > 0) t = 'takes about '//to_text(100.0_wp*audit%value(check), 2)// &
          ' % of forces or displacements, most of it pair '//model%pairs(worst)%name
      case default
        t = 'enough'
        if (worst > 0) t = 'too little for the points of pair '// &
          model%pairs(worst)%name
      end select
    end associate
  end function scene_finding

  !> The warning of a check: what was found, what it means, what to do.
  function audit_warning(model, system, audit, check) result(t)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies
    type(audit_t), intent(in) :: audit !! an audited end time
    integer, intent(in) :: check !! the check
    character(:), allocatable :: t

    t = trim(check_names(check))//': '//finding(model, system, audit, check)//': '// &
      advice(check)
    if (audit%step > 0) t = 'step '//to_text(audit%step)//', '//t
  end function audit_warning

  !> What a finding means, and what to do.
  pure function advice(check) result(t)
    integer, intent(in) :: check !! the check
    character(:), allocatable :: t

    select case (check)
    case (check_work)
      t = 'increments are long for what happens in them (a body drops, touches or snaps), and '// &
        'friction depends on the path: halve DT and compare'
    case (check_strain)
      t = 'small strain is a linear theory, wrong by about the strain itself: lower the load, '// &
        'or look for a sharp edge or a single node that carries it'
    case (check_rotation, check_turning)
      t = 'in small strain a rotation by a produces a spurious strain a^2/2 and stresses: '// &
        'rotate the mesh beforehand, or restrain the body'
    case (check_penetration)
      t = 'the bodies overlap visibly: MORTar, a stiffer PENAlty, or AUGMent'
    case (check_edges)
      t = 'points lie inside of slave facets, and an edge or a node of one body goes into the '// &
        'other between them: refine there, or make the body with the edge the slave of a '// &
        'second pair NTOS'
    case (check_elastic_slip)
      t = 'points that stick give way visibly: a stiffer PENAlty, or AUGMent'
    case (check_facets)
      t = 'master nodes between slave nodes go through, and force is lost: swap slave and '// &
        'master, or write GTOS slave master SEGMent'
    case (check_locking)
      t = 'linear tetrahedra lock above 0.45, stresses and stiffness are far too large: refine '// &
        'and compare, or take 0.45'
    case (check_penalty)
      t = 'without penetration forces are larger where displacements are prescribed, '// &
        'displacements smaller where forces are: write MORTar, which has no penalty, '// &
        'or a stiffer PENAlty (AUTO 100 takes a tenth to a third of what AUTO 10 does)'
    case (check_answers)
      t = answers_advice
    case (check_moved)
      t = 'ADJUst has changed the shape of the slave: give it a smaller tolerance, or mesh finer'
    case default
      t = 'make the coarser surface the master'
    end select
  end function advice

  !> Which body lacks what, for the error that ends the run.
  function balance_message(model, system, audit, before) result(t)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies
    type(audit_t), intent(in) :: audit !! an end time that has failed
    real(wp), intent(in) :: before !! last end time on disk
    character(:), allocatable :: t
    character(13), parameter :: what(2) = [character(13) :: 'forces along', 'moments about']
    integer :: body

    body = audit%worst(check_balance)
    t = 'error: the audit of time '//to_text(audit%time, 12)//' has found a body out of balance'//nl
    if (body == 0) then
      t = t//'  forces are not numbers'//nl
    else
      t = t//'  '//body_name(model, system, body)//': '//trim(what(merge(1, 2, &
        audit%component <= 3)))//' x'//to_text(1 + mod(audit%component - 1, 3))// &
        ' leave '//to_text(audit%balance(audit%component, body), 4)//', where '// &
        to_text(audit%allowed*merge(1.0_wp, audit%fixed%reach(body), audit%component <= 3), 3)// &
        ' is allowed; the force scale is '//to_text(audit%scale, 4)//nl
    end if
    if (body > 0 .and. audit%lacking <= audit%noise) then
      t = t//'  this is round-off of material that is far stiffer than what carries the '// &
        'forces: make'//nl//'  it rigid (MATErial RIGId), lower its modulus, or let what is '// &
        'soft move and what is'//nl//'  stiff stand still'//nl//'  everything up to time '// &
        to_text(before, 12)//' is on disk'
      return
    end if
    if (is_fixed(system, body)) then
      t = t//'  HOLD alone stops it there, and may carry nothing: balance the loads, or '// &
        'restrain the body with BOUNdary'//nl//'  everything up to time '//to_text(before, 12)// &
        ' is on disk'
      return
    end if
    t = t//'  this is no solution: ask for more by TOL,RESI,1e-10, or for another SOLVer; see '// &
      'that supports, friction or a closed contact hold the body'//nl// &
      '  everything up to time '//to_text(before, 12)//' is on disk'
  end function balance_message

  !> Which body has left small strain, for the error that ends the run: what statics says of the
  !! loads on it comes first.
  function shape_message(model, system, audit, before) result(t)
    type(model_t), intent(in) :: model !! names
    type(system_t), intent(in) :: system !! bodies, positions of the increment before
    type(audit_t), intent(in) :: audit !! an end time whose turning or volume has failed
    real(wp), intent(in) :: before !! last end time on disk
    character(:), allocatable :: t
    type(verdict_t) :: verdict

    t = 'error: the audit of time '//to_text(audit%time, 12)//' has found what small strain '// &
      'cannot mean'//nl
    call judge_at_rest(model, system, audit%time, verdict)
    if (verdict%kind > statics_carried) t = t//motion_text(body_name(model, system, &
      verdict%body), verdict)//nl
    if (audit%verdict(check_turning) == verdict_failed) then
      t = t//turned_text(body_name(model, system, audit%worst(check_turning)), &
        audit%value(check_turning), farthest_turn*180.0_wp/pi)//nl
    else
      t = t//'  the volume of '//body_name(model, system, audit%worst(check_volume))// &
        ' has changed by '//to_text(100.0_wp*audit%value(check_volume), 3)//' %, and may by '// &
        to_text(100.0_wp*most_swelling, 3)//':'//nl//'  lower the load, look at the units of '// &
        'loads and moduli, or give it a law of finite strain (SOLId NEOHookean)'//nl
    end if
    t = t//'  everything up to time '//to_text(before, 12)//' is on disk'
  end function shape_message

  !> HOLD stops the body at fixings.
  pure logical function is_fixed(system, body) result(fixed)
    type(system_t), intent(in) :: system !! fixed, if there are such bodies
    integer, intent(in) :: body !! the body, 0 for none

    fixed = body > 0 .and. allocated(system%body%fixed)
    if (fixed) fixed = any(spread(system%body%node_body == body, 1, 3) .and. system%body%fixed)
  end function is_fixed
end module audit_text

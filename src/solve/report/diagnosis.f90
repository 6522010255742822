!> Why a solve failed: unrestrained bodies, and where the residual sticks.
!! In more than 400 lines, since each way in which a solve fails has its words here.
module diagnosis
  use kinds, only: wp, pi
  use text, only: to_text, count_noun
  use errors, only: error_t, raise, exit_no_convergence
  use contact_types, only: form_node_to_surface
  use contact_points, only: count_points
  use contact_parameters, only: shifts_gap, stiffest_plain
  use supports, only: free_motion, free_motions
  use rigid_bodies, only: is_carried
  use model_types, only: model_t
  use monitors, only: monitor_t
  use newton, only: newton_t, outcome_singular, outcome_open, outcome_gaps, outcome_restless, &
    outcome_inverted, outcome_turned
  use lost_contact, only: find_turned
  use body_measures, only: farthest_turn
  use contact_report, only: worst_contact, restless_point, closed_points, all_slip, has_friction
  use statics, only: verdict_t, judge_statics, judge_at_rest, statics_unknown, statics_carried, &
    statics_slides, statics_turns, statics_tips
  use statics_report, only: motion_text, reserve_text, turned_text
  use remedies, only: what_may_help, settle_advice
  use force_scales, only: in_bounds
  use system_types, only: form_t, system_t
  use system_parts, only: bulk_answer_t
  implicit none
  private
  public :: explain_failure, unrestrained_bodies, has_flying_body, check_supports, body_name, &
    named_motion, is_held

  !> Friction below this share of what there is cannot be used up, however it is pressed.
  real(wp), parameter :: least_used = 0.1_wp

contains

  !> What can be said about a failed solve, in lines that begin with two blanks.
  subroutine explain_failure(model, system, form, progress, time, cut, text, goal)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system at the failed iterate
    type(form_t), intent(in) :: form !! its kind, right
    type(newton_t), intent(in) :: progress !! how it ended
    real(wp), intent(in) :: time !! the time that was tried
    logical, intent(in) :: cut !! increments have been cut as far as it goes
    character(:), allocatable, intent(out) :: text !! the explanation
    real(wp), intent(in), optional :: goal !! the end time that it leads to
    character(1), parameter :: nl = new_line('a')
    type(verdict_t) :: verdict
    integer :: body

    if (progress%outcome == outcome_turned) then
      text = turned_lines(model, system, form, time, goal)
      return
    end if
    text = '  tried: an increment to time '//to_text(time, 12)//' with '// &
      count_noun(progress%solves, 'linear solve')
    if (cut) text = '  tried: ever smaller increments, the last one to time '// &
      to_text(time, 12)//' with '//count_noun(progress%solves, 'linear solve')
    if (progress%outcome == outcome_open) text = '  tried: '//to_text(progress%solves)// &
      ' times TANG; write LOOP,,n TANG,,1 NEXT behind TIME, or STEP,,n instead'
    if (progress%outcome == outcome_open .and. progress%solves == 0) return
    if (progress%outcome == outcome_restless) text = text//nl//'  between two facets: ' &
      //restless_point(model)//nl//settle_advice(model, cut)
    if (progress%outcome == outcome_inverted) then
      text = text//nl//inverted_element(model, form%inner)
      return
    end if
    if (progress%outcome == outcome_gaps) then
      text = text//nl//'  pairs with multipliers:'//with_multipliers(model)// &
        '; the log tells what each update has left'//nl// &
        '  allow more updates or wider gaps: AUGMent tol max, in the deck''s '// &
        'PAIR;'//nl//'  or, without AUGMent, a penalty of at most '// &
        to_text(stiffest_plain, 4)//' times E/h'
      text = text//nl//worst_node(model, system, form, cut)
      return
    end if
    if (.not. in_bounds(system)) text = text//nl//'  displacements of '// &
      to_text(maxval(abs(system%u)), 3)//' were tried, more than twice the size of the model '// &
      'and what'//nl//'  is prescribed: look at the units of loads and moduli'
    call judge_both(model, system, time, verdict, goal)
    if (verdict%kind > statics_carried) text = text//nl// &
      motion_text(body_name(model, system, verdict%body), verdict)
    if (verdict%kind == statics_tips) text = text//edge_advice(model, system, verdict%body)
    body = unrestrained_bodies(model, system)
    if (body > 0) then
      text = text//nl//describe_body(model, system, form, body, verdict%kind)
    else
      text = text//nl//worst_node(model, system, form, cut)
      if (progress%outcome == outcome_singular) text = text//nl// &
        '  look for parts that hang on a single node or edge, or for a Poisson ratio close to 1/2'
    end if
    if (verdict%kind == statics_carried) text = text//nl//reserve_text(body_name(model, system, &
      max(verdict%body, 1)), verdict, verdict%friction >= least_used .and. all_slip(system, &
      max(verdict%body, 1)), &
      .not. all(model%pairs%mortar))
  end subroutine explain_failure

  !> What statics says of the loads of a time, or of the end time that it leads to; where places
  !! that do not touch yet might carry them, whether friction at those that touch does meanwhile.
  subroutine judge_both(model, system, time, verdict, goal)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the last converged positions
    real(wp), intent(in) :: time !! the time that was tried
    type(verdict_t), intent(out) :: verdict !! what statics says
    real(wp), intent(in), optional :: goal !! the end time that it leads to
    type(verdict_t) :: ahead

    call judge_statics(model, system, time, verdict)
    if (present(goal) .and. verdict%kind <= statics_carried) then
      call judge_statics(model, system, goal, ahead)
      if (ahead%kind > statics_carried) verdict = ahead
    end if
    if (verdict%kind <= statics_carried) then
      call judge_at_rest(model, system, time, ahead)
      if (any(ahead%kind == [statics_slides, statics_turns])) verdict = ahead
    end if
    if (verdict%kind == statics_carried .and. verdict%friction <= 0.0_wp) then
      verdict%kind = statics_unknown
    end if
  end subroutine judge_both

  !> What statics says of a body that has turned too far, then how far it has.
  function turned_lines(model, system, form, time, goal) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! as converged, with the last accepted positions
    type(form_t), intent(in) :: form !! its kind answers
    real(wp), intent(in) :: time !! the time that was tried
    real(wp), intent(in), optional :: goal !! the end time that it leads to
    character(:), allocatable :: t
    type(verdict_t) :: verdict
    real(wp) :: angle
    integer :: body

    call judge_both(model, system, time, verdict, goal)
    if (verdict%kind <= statics_carried) call judge_at_rest(model, system, time, verdict)
    t = ''
    if (verdict%kind > statics_carried) t = motion_text(body_name(model, system, verdict%body), &
      verdict)//new_line('a')
    call find_turned(model, system, form, body, angle)
    t = t//turned_text(body_name(model, system, max(body, 1)), angle, farthest_turn*180.0_wp/pi)
  end function turned_lines

  !> Which element has no answer, and what may help.
  function inverted_element(model, inner) result(t)
    type(model_t), intent(in) :: model !! the model
    type(bulk_answer_t), intent(in) :: inner !! inverted given
    character(:), allocatable :: t

    t = '  element '//to_text(inner%inverted)//' of material '//to_text(model%materials( &
      model%element_material(inner%inverted))%number)//': look at loads, units and mesh '// &
      'there;'//new_line('a')//'  a regular mesh, MEAN or another law may bear more'
  end function inverted_element

  !> Names of the pairs whose forces come partly from multipliers.
  pure function with_multipliers(model) result(names)
    type(model_t), intent(in) :: model !! pairs
    character(:), allocatable :: names
    integer :: k

    names = ''
    do k = 1, size(model%pairs)
      if (shifts_gap(model%pairs(k))) names = names//' '//model%pairs(k)%name
    end do
  end function with_multipliers

  !> Before the first solve: a body that no support holds and no contact pair can hold is an error,
  !! one that only contact can hold is worth a warning.
  subroutine check_supports(model, system, form, monitor, error)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    type(form_t), intent(in) :: form !! right
    class(monitor_t), intent(inout), optional :: monitor !! hears of bodies held by contact alone
    type(error_t), allocatable, intent(out) :: error !! an unrestrained body
    integer :: b, n
    real(wp) :: motions(6, 6)

    do b = 1, system%body%bodies
      call free_motions(model%mesh%x, system, b, .false., .false., n, motions)
      if (n == 0) cycle
      if (in_a_pair(model, system, b)) then
        if (present(monitor)) call monitor%warning(body_name(model, system, b)// &
          held_text(n, motions(:, 1)))
      else
        call raise(error, exit_no_convergence, 'error: the system is singular'//new_line('a')// &
          describe_body(model, system, form, b, statics_unknown))
        return
      end if
    end do
  end subroutine check_supports

  !> What contact alone holds of a body: all of it, or the motions that its supports leave.
  pure function held_text(n, motion) result(t)
    integer, intent(in) :: n !! rigid motions that supports leave
    real(wp), intent(in) :: motion(6) !! one of them
    character(:), allocatable :: t

    t = ' has 6 unconstrained rigid body modes: contact alone holds it'
    if (n == 6) return
    t = ' has an unconstrained rigid body mode: that it does not '//named_motion(maxloc( &
      abs(motion), 1))//' is left to contact alone'
    if (n > 1) t = ' has '//to_text(n)//' unconstrained rigid body modes: these are left to '// &
      'contact alone'
  end function held_text

  !> A body takes part in a contact pair.
  pure logical function in_a_pair(model, system, body) result(yes)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: body !! the body
    integer :: k

    yes = .false.
    do k = 1, size(model%pairs)
      yes = yes .or. is_of_pair(model, system, k, body)
    end do
  end function in_a_pair

  !> Contact points or master facets of a pair are on the body.
  pure logical function is_of_pair(model, system, k, body) result(yes)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: k !! the pair
    integer, intent(in) :: body !! the body
    integer :: f, p

    yes = .false.
    do p = 1, count_points(model%pairs(k))
      if (system%body%node_body(model%pairs(k)%points%point_nodes(1, p)) == body) yes = .true.
    end do
    do f = 1, size(model%pairs(k)%surface%facets, 2)
      if (system%body%node_body(model%pairs(k)%surface%facets(1, f)) == body) yes = .true.
    end do
  end function is_of_pair

  !> What may help a body that tips over an edge which its pairs do not reach: their points carry it
  !! nowhere else, and most of them lie inside of the edge. A line for each such pair.
  function edge_advice(model, system, body) result(t)
    type(model_t), intent(in) :: model !! pairs
    type(system_t), intent(in) :: system !! bodies
    integer, intent(in) :: body !! the body that tips
    character(:), allocatable :: t
    integer :: k

    t = ''
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (pair%segmented) cycle
        if (.not. is_of_pair(model, system, k, body)) cycle
        t = t//new_line('a')//'  pair '//pair%name
        if (pair%form == form_node_to_surface) then
          t = t//' carries it at nodes of the slave alone: if the load passes just inside of '// &
            'the edge, write GTOS with SEGMent'
        else
          t = t//' carries it at '//count_noun(pair%facet_points, 'point')//' a facet, which '// &
            'end short of the edge: if the load passes just inside of that, write SEGMent or '// &
            'more points'
        end if
      end associate
    end do
  end function edge_advice

  !> The first body that neither supports nor closed contact points hold; 0 if all are held.
  integer function unrestrained_bodies(model, system) result(body)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    real(wp) :: motion(6)
    logical :: free
    integer :: b

    body = 0
    do b = 1, system%body%bodies
      call free_motion(model%mesh%x, system, b, .true., free, motion)
      if (free .and. .not. is_held(model, system, b)) then
        body = b
        return
      end if
    end do
  end function unrestrained_bodies

  !> A body is in flight: neither supports nor closed contact points hold it, and there are none.
  logical function has_flying_body(model, system) result(flies)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    integer :: body

    body = unrestrained_bodies(model, system)
    flies = body > 0
    if (flies) flies = closed_points(system, body) == 0
  end function has_flying_body

  !> Names a body that can move freely, and how.
  function describe_body(model, system, form, body, kind) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    type(form_t), intent(in) :: form !! right
    integer, intent(in) :: body !! the body
    integer, intent(in) :: kind !! what statics says
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')
    real(wp) :: motion(6)
    character(:), allocatable :: contact
    logical :: free
    integer :: node, dof, k, closed

    call free_motion(model%mesh%x, system, body, .true., free, motion)
    k = maxloc(abs(motion), 1)
    dof = mod(k - 1, 3) + 1
    node = 0
    do k = 1, size(system%body%node_body)
      if (system%body%node_body(k) /= body) cycle
      if (system%equation(dof, k) == 0 .and. .not. is_carried(system%tools, k)) cycle
      node = k
      exit
    end do
    k = maxloc(abs(motion), 1)
    t = '  unrestrained body: '//body_name(model, system, body)//' can '//named_motion(k) &
      //' (node '//to_text(max(node, 1))//', dof '//to_text(dof)//')'
    closed = closed_points(system, body)
    if (closed > 0) then
      t = t//': no support resists, and its closed contact points ('//to_text(closed)// &
        ') do not hold it'
    else
      t = t//'; no support and no closed contact point resists'
    end if
    contact = worst_contact(model, system, form, body)
    if (len(contact) > 0) t = t//nl//contact
    if (kind == statics_unknown) t = t//nl//what_holds(closed, has_friction(model, system, body))
  end function describe_body

  !> A motion in words, from the number of its largest component.
  pure function named_motion(k) result(t)
    integer, intent(in) :: k !! 1 to 3: translations, 4 to 6: rotations
    character(:), allocatable :: t

    t = 'move along x'//to_text(k)
    if (k > 3) t = 'turn about x'//to_text(k - 3)
  end function named_motion

  !> The deck holds a body (HOLD).
  pure logical function is_held(model, system, body) result(held)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! bodies of the nodes
    integer, intent(in) :: body !! the body

    held = .false.
    if (allocated(model%held)) held = any(model%held .and. system%body%node_body == body)
  end function is_held

  !> What to change for a body that can move.
  pure function what_holds(closed, friction) result(t)
    integer, intent(in) :: closed !! its closed contact points
    logical, intent(in) :: friction !! one of its pairs has friction
    character(:), allocatable :: t

    if (closed == 0) then
      t = '  restrain it with BOUNdary, or let it touch another body before it is loaded'
    else if (.not. friction) then
      t = '  without friction it glides or tips until it lies in a hollow: restrain it with '// &
        'BOUNdary, or give the pair FRICtion'
    else
      t = '  friction does not carry the load: lower it, raise the coefficient, or restrain '// &
        'the body'
    end if
  end function what_holds

  !> Name of a body: its region, or its lowest element.
  function body_name(model, system, body) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: body !! the body
    character(:), allocatable :: t
    integer :: e, node

    t = 'body '//to_text(body)
    do e = 1, model%mesh%elements
      node = model%mesh%ix(1, e)
      if (node == 0) cycle
      if (system%body%node_body(node) /= body) cycle
      t = 'the body of element '//to_text(e)
      if (model%mesh%region(e) > 0) then
        if (len(model%mesh%regions(model%mesh%region(e))%name) > 0) then
          t = t//' (region '//model%mesh%regions(model%mesh%region(e))%name//')'
        end if
      end if
      return
    end do
  end function body_name

  !> Names the node and dof with the largest residual, and the worst contact point of its body.
  function worst_node(model, system, form, cut) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! residual formed
    type(form_t), intent(in) :: form !! right
    logical, intent(in) :: cut !! increments have been cut as far as it goes
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')
    character(:), allocatable :: contact
    real(wp) :: residual
    integer :: node, dof

    t = '  no free degree of freedom'
    call form%kind%find_worst(system, form, node, dof, residual)
    if (node == 0) return
    t = '  the largest residual, '//to_text(residual)//', is at node ' &
      //to_text(node)//', dof '//to_text(dof)
    contact = worst_contact(model, system, form, max(system%body%node_body(node), 0))
    if (len(contact) == 0) contact = worst_contact(model, system, form, 0)
    if (len(contact) > 0) t = t//nl//contact//nl//what_may_help(model, system, cut)
  end function worst_node
end module diagnosis

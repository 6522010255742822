!> Why a solve failed: unrestrained bodies, and where the residual sticks.
module diagnosis
  use kinds, only: wp
  use text, only: to_text
  use errors, only: error_t, raise, exit_no_convergence
  use element_types, only: status_open
  use element_lists, only: master_nodes
  use contact_points, only: count_points, point_text
  use supports, only: free_motion, touched_bodies
  use model_types, only: model_t
  use monitors, only: monitor_t
  use newton, only: newton_t, outcome_singular, outcome_open
  use system_types, only: system_t
  implicit none
  private
  public :: explain_failure, unrestrained_bodies, check_supports

contains

  !> What can be said about a failed solve, in lines that begin with two blanks.
  subroutine explain_failure(model, system, progress, time, text)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system at the failed iterate
    type(newton_t), intent(in) :: progress !! how it ended
    real(wp), intent(in) :: time !! the time that was tried
    character(:), allocatable, intent(out) :: text !! the explanation
    character(1), parameter :: nl = new_line('a')
    integer :: body

    text = '  tried: increments down to the last cut before time '//to_text(time, 12)//', '// &
      to_text(progress%solves)//' linear solves in the last'
    if (progress%outcome == outcome_open) text = '  tried: '//to_text(progress%solves)// &
      ' times TANG; write LOOP,,n TANG,,1 NEXT behind TIME, or STEP,,n instead'
    if (progress%outcome == outcome_open .and. progress%solves == 0) return
    body = unrestrained_bodies(model, system)
    if (body > 0) then
      text = text//nl//describe_body(model, system, body)
    else
      text = text//nl//worst_node(model, system)
      if (progress%outcome == outcome_singular) text = text//nl// &
        '  look for parts that hang on a single node or edge, or for a Poisson ratio close to 1/2'
    end if
  end subroutine explain_failure

  !> Before the first solve: a body that no support holds and no contact pair can hold is an error,
  !! one that only contact can hold is worth a warning.
  subroutine check_supports(model, system, monitor, error)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    class(monitor_t), intent(inout) :: monitor !! hears of bodies held by contact alone
    type(error_t), allocatable, intent(out) :: error !! an unrestrained body
    real(wp) :: motion(6)
    logical :: free
    integer :: b

    do b = 1, system%bodies
      call free_motion(model%mesh%x, system, b, .false., free, motion)
      if (.not. free) cycle
      if (in_a_pair(model, system, b)) then
        call monitor%warning(body_name(model, system, b)//' is held by contact alone')
      else
        call raise(error, exit_no_convergence, 'error: the system is singular'//new_line('a')// &
          describe_body(model, system, b))
        return
      end if
    end do
  end subroutine check_supports

  !> A body takes part in a contact pair.
  pure logical function in_a_pair(model, system, body) result(yes)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: body !! the body
    integer :: k, f, p

    yes = .false.
    do k = 1, size(model%pairs)
      do p = 1, count_points(model%pairs(k))
        if (system%node_body(model%pairs(k)%point_nodes(1, p)) == body) yes = .true.
      end do
      do f = 1, size(model%pairs(k)%facets, 2)
        if (system%node_body(model%pairs(k)%facets(1, f)) == body) yes = .true.
      end do
    end do
  end function in_a_pair

  !> The first body that neither supports nor closed contact points hold; 0 if all are held.
  integer function unrestrained_bodies(model, system) result(body)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    real(wp) :: motion(6)
    logical :: free
    integer :: b

    body = 0
    do b = 1, system%bodies
      call free_motion(model%mesh%x, system, b, .true., free, motion)
      if (free) then
        body = b
        return
      end if
    end do
  end function unrestrained_bodies

  !> Names a body that can move freely, and how.
  function describe_body(model, system, body) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! the system
    integer, intent(in) :: body !! the body
    character(:), allocatable :: t
    character(11), parameter :: axes(6) = ['move along ', 'move along ', 'move along ', &
      'turn about ', 'turn about ', 'turn about ']
    character(1), parameter :: nl = new_line('a')
    real(wp) :: motion(6)
    logical :: free, touching(system%bodies)
    integer :: node, dof, k

    call free_motion(model%mesh%x, system, body, .true., free, motion)
    k = maxloc(abs(motion), 1)
    dof = mod(k - 1, 3) + 1
    node = 0
    do k = 1, size(system%node_body)
      if (system%node_body(k) /= body) cycle
      if (system%equation(dof, k) == 0) cycle
      node = k
      exit
    end do
    k = maxloc(abs(motion), 1)
    t = '  unrestrained body: '//body_name(model, system, body)//' can '//trim(axes(k))//' x' &
      //to_text(dof)//' (node '//to_text(max(node, 1))//', dof '//to_text(dof)//')'
    touching = touched_bodies(system)
    if (touching(body)) then
      t = t//': no support resists, and its closed contact points slip'//nl// &
        '  friction does not carry the load: lower it, raise the coefficient, or restrain the body'
    else
      t = t//'; no support and no closed contact point resists'//nl// &
        '  restrain it with BOUNdary, or let it touch another body before it is loaded'
    end if
  end function describe_body

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
      if (system%node_body(node) /= body) cycle
      t = 'the body of element '//to_text(e)
      if (model%mesh%region(e) > 0) then
        if (len(model%mesh%regions(model%mesh%region(e))%name) > 0) then
          t = t//' (region '//model%mesh%regions(model%mesh%region(e))%name//')'
        end if
      end if
      return
    end do
  end function body_name

  !> Names the node and dof with the largest residual, and the contact point next to it.
  function worst_node(model, system) result(t)
    type(model_t), intent(in) :: model !! the model
    type(system_t), intent(in) :: system !! residual formed
    character(:), allocatable :: t
    character(1), parameter :: nl = new_line('a')
    integer :: i, k, node, dof, largest, nodes(3)

    t = '  no free degree of freedom'
    if (system%equations == 0) return
    largest = maxloc(abs(system%right), 1)
    node = 0
    dof = 0
    do i = 1, size(system%equation, 2)
      do k = 1, 3
        if (system%equation(k, i) /= largest) cycle
        node = i
        dof = k
      end do
    end do
    t = '  the largest residual, '//to_text(system%right(largest))//', is at node ' &
      //to_text(node)//', dof '//to_text(dof)
    do k = 1, size(model%pairs)
      do i = 1, count_points(model%pairs(k))
        associate (element => system%first_point(k) + i - 1)
          if (system%contact%status(element) <= status_open) cycle
          if (.not. any(system%contact%ix(:, element) == node)) cycle
          nodes = master_nodes(system%contact, element)
          t = t//nl//'  there pair '//model%pairs(k)%name//' has slave '// &
            point_text(model%pairs(k), i)//' on the facet of nodes '//to_text(nodes(1))//', '// &
            to_text(nodes(2))//', '//to_text(nodes(3))//nl// &
            '  try smaller steps (DT) or a softer penalty'
          return
        end associate
      end do
    end do
  end function worst_node
end module diagnosis

!> Rigid bodies with a point: where they are, what acts on their unknowns, and how these move their
!! nodes (doc/theory, "Rigid bodies", eqs. (9.5), (9.7)).
module rigid_bodies
  use kinds, only: wp
  use vectors, only: identity, cross
  use rotations, only: rotation_matrix, rotation_vector, spin
  use model_types, only: model_t
  use rigid_paths, only: count_rigid, motion_at, load_at
  use rigid_types, only: rigid_t
  use system_types, only: form_t, system_t, state_t
  use system_parts, only: rigid_part_t
  implicit none
  private
  public :: start_rigid, begin_rigid, return_rigid, try_rigid, take_rigid, drop_rigid, &
    spread_rigid, add_rigid_right, keep_rigid, lever, wrench_on, is_carried, nothing_deforms, &
    rigid_values, rigid_force, rigid_loads, carry_rigid, forget_carrying, rigid_motion, &
    loads_on_rigid, move_rigid

contains

  !> Lists the bodies and numbers their unknowns; bodies of the nodes are known.
  subroutine start_rigid(model, equations, node_body, tools)
    type(model_t), intent(in) :: model !! rigid bodies
    integer, intent(in) :: equations !! free degrees of freedom of the nodes
    integer, intent(in) :: node_body(:) !! (nodes) connected body, 0 for none
    type(rigid_part_t), intent(inout) :: tools !! gets rigid, carried_by, unknowns
    integer :: b, i, k

    if (count_rigid(model) == 0) return
    allocate (tools%rigid(count_rigid(model)))
    allocate (tools%carried_by(model%mesh%nodes), source=0)
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b), body => model%conditions%rigid(b))
        rigid%node = body%nodes
        rigid%point = body%point
        rigid%unknown = pack([(k, k=1, 6)], body%free)
        rigid%first = equations + tools%unknowns
        rigid%body = node_body(body%nodes(1))
        tools%unknowns = tools%unknowns + size(rigid%unknown)
        allocate (rigid%reach(3, size(rigid%node)), rigid%base(3, size(rigid%node)))
        do i = 1, size(rigid%node)
          rigid%reach(:, i) = model%mesh%x(:, rigid%node(i)) - rigid%point
        end do
        rigid%length = maxval(norm2(rigid%reach, 1))
        rigid%turn = identity
        rigid%old_turn = rigid%turn
        if (size(rigid%unknown) > 0) tools%carried_by(rigid%node) = b
      end associate
    end do
  end subroutine start_rigid

  !> A node moves with the unknowns of a rigid body.
  elemental logical function is_carried(tools, node) result(yes)
    type(rigid_part_t), intent(in) :: tools !! rigid bodies
    integer, intent(in) :: node !! the node

    yes = .false.
    if (allocated(tools%carried_by)) yes = tools%carried_by(node) > 0
  end function is_carried

  !> All nodes of a contact element are prescribed.
  pure logical function nothing_deforms(equation, tools, nodes) result(yes)
    integer, intent(in) :: equation(:, :) !! (3, nodes) equation numbers, 0 where restrained
    type(rigid_part_t), intent(in) :: tools !! rigid bodies
    integer, intent(in) :: nodes(:) !! of the element

    yes = all(equation(:, nodes) == 0) .and. .not. any(is_carried(tools, nodes))
  end function nothing_deforms

  !> Start of an increment: prescribed motions and loads at its end, the free ones where they were.
  subroutine begin_rigid(model, u, tools, state, time)
    type(model_t), intent(in) :: model !! rigid bodies and tables
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) given at prescribed nodes; completed [length]
    type(rigid_part_t), intent(inout) :: tools !! get the state that they start from
    type(state_t), intent(in) :: state !! last converged state
    real(wp), intent(in) :: time !! end of the increment
    real(wp) :: motion(6)
    integer :: b

    if (.not. allocated(tools%rigid)) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        motion = motion_at(model, b, time)
        rigid%given = motion(1:3)
        rigid%load = load_at(model, b, time)
        rigid%base = u(:, rigid%node)
        rigid%old_move = state%rigid(1:3, b)
        rigid%old_turn = rotation_matrix(state%rigid(4:6, b))
      end associate
    end do
    call forget_carrying(tools)
    call return_rigid(u, tools)
  end subroutine begin_rigid

  !> Displacements of the nodes of a body.
  pure subroutine place_nodes(rigid, move, turn, u)
    type(rigid_t), intent(in) :: rigid !! the body
    real(wp), intent(in) :: move(3) !! free translation [length]
    real(wp), intent(in) :: turn(3, 3) !! free rotation
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements [length]
    integer :: i

    do i = 1, size(rigid%node)
      u(:, rigid%node(i)) = rigid%base(:, i) + move
      if (any(rigid%unknown > 3)) u(:, rigid%node(i)) = u(:, rigid%node(i)) &
        + matmul(turn, rigid%reach(:, i)) - rigid%reach(:, i)
    end do
  end subroutine place_nodes

  !> The predictor leaves all bodies where they are but for what is prescribed.
  pure subroutine forget_carrying(tools)
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies
    integer :: b

    tools%ahead = .false.
    if (.not. allocated(tools%rigid)) return
    do b = 1, size(tools%rigid)
      tools%rigid(b)%ahead_move = tools%rigid(b)%old_move
      tools%rigid(b)%ahead_turn = tools%rigid(b)%old_turn
    end do
  end subroutine forget_carrying

  !> Moves a body by values of its unknowns, where the predictor takes it.
  pure subroutine carry_rigid(rigid, values, u)
    type(rigid_t), intent(inout) :: rigid !! the body: gets ahead_move, ahead_turn
    real(wp), intent(in) :: values(:) !! (unknowns) [length]
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements with predictor [length]
    real(wp) :: step(6)

    step = 0.0_wp
    step(rigid%unknown) = values
    rigid%ahead_move = rigid%old_move + step(1:3)
    rigid%ahead_turn = matmul(rotation_matrix(step(4:6)/rigid%length), rigid%old_turn)
    call place_nodes(rigid, rigid%ahead_move, rigid%ahead_turn, u)
  end subroutine carry_rigid

  !> Back to the start of the increment.
  subroutine return_rigid(u, tools)
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of their nodes are set [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point
    integer :: b

    if (.not. allocated(tools%rigid)) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        rigid%move = merge(rigid%ahead_move, rigid%old_move, tools%ahead)
        rigid%turn = merge(rigid%ahead_turn, rigid%old_turn, tools%ahead)
        if (size(rigid%unknown) > 0) call place_nodes(rigid, rigid%move, rigid%turn, u)
      end associate
    end do
  end subroutine return_rigid

  !> The unknowns of a solution at one body: translation and spin.
  pure function step_of(rigid, solution) result(step)
    type(rigid_t), intent(in) :: rigid !! the body
    real(wp), intent(in) :: solution(:) !! (equations+n) [length]
    real(wp) :: step(6)

    step = 0.0_wp
    step(rigid%unknown) = solution(rigid%first + 1:rigid%first + size(rigid%unknown))
    step(4:6) = step(4:6)/rigid%length
  end function step_of

  !> Direction of the nodes of all bodies from a solution, to first order.
  pure subroutine spread_rigid(system, solution, du)
    type(system_t), intent(in) :: system !! rigid bodies, u
    real(wp), intent(in) :: solution(:) !! (equations+n) [length]
    real(wp), intent(inout) :: du(:, :) !! (3, nodes) gets those of their nodes [length]
    real(wp) :: step(6)
    integer :: b, i

    if (system%tools%unknowns == 0) return
    do b = 1, size(system%tools%rigid)
      associate (rigid => system%tools%rigid(b))
        if (size(rigid%unknown) == 0) cycle
        step = step_of(rigid, solution)
        do i = 1, size(rigid%node)
          du(:, rigid%node(i)) = step(1:3) + cross(step(4:6), lever(rigid, i, system%u, rigid%move))
        end do
      end associate
    end do
  end subroutine spread_rigid

  !> Node i of a body as seen from its point.
  pure function lever(rigid, i, u, move) result(r)
    type(rigid_t), intent(in) :: rigid !! the body
    integer, intent(in) :: i !! which of its nodes
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: move(3) !! its free translation [length]
    real(wp) :: r(3)

    r = rigid%reach(:, i) + (u(:, rigid%node(i)) - rigid%given - move)
  end function lever

  !> A trial: the nodes go where the exponential map of a share of the step takes them.
  subroutine try_rigid(tools, solution, share, trial)
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point; get their trial
    real(wp), intent(in) :: solution(:) !! (equations+unknowns) the step [length]
    real(wp), intent(in) :: share !! of the step
    real(wp), intent(inout) :: trial(:, :) !! (3, nodes) displacements of their nodes [length]
    real(wp) :: step(6)
    integer :: b

    if (tools%unknowns == 0) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        if (size(rigid%unknown) == 0) cycle
        step = share*step_of(rigid, solution)
        rigid%trial_move = rigid%move + step(1:3)
        rigid%trial_turn = matmul(rotation_matrix(step(4:6)), rigid%turn)
        call place_nodes(rigid, rigid%trial_move, rigid%trial_turn, trial)
      end associate
    end do
  end subroutine try_rigid

  !> Moves to the trial.
  subroutine take_rigid(u, tools)
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of their nodes are set [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point
    integer :: b

    if (tools%unknowns == 0) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        if (size(rigid%unknown) == 0) cycle
        rigid%move = rigid%trial_move
        rigid%turn = rigid%trial_turn
        call place_nodes(rigid, rigid%move, rigid%turn, u)
      end associate
    end do
  end subroutine take_rigid

  !> Moves what is free of a connected body by a translation.
  subroutine drop_rigid(u, tools, body, way)
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) moved at their nodes [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point; moved
    integer, intent(in) :: body !! connected body
    real(wp), intent(in) :: way(3) !! the translation [length]
    integer :: b, k

    if (tools%unknowns == 0) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        if (rigid%body /= body .or. size(rigid%unknown) == 0) cycle
        do k = 1, 3
          if (any(rigid%unknown == k)) rigid%move(k) = rigid%move(k) + way(k)
        end do
        call place_nodes(rigid, rigid%move, rigid%turn, u)
      end associate
    end do
  end subroutine drop_rigid

  !> Sum of forces on the nodes of a body, and of their moments about its point.
  pure function wrench_on(rigid, u, move, force) result(w)
    type(rigid_t), intent(in) :: rigid !! the body
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: move(3) !! its free translation [length]
    real(wp), intent(in) :: force(:, :) !! (3, nodes) forces [force]
    real(wp) :: w(6)
    integer :: i

    w = 0.0_wp
    do i = 1, size(rigid%node)
      associate (f => force(:, rigid%node(i)))
        w = w + [f, cross(lever(rigid, i, u, move), f)]
      end associate
    end do
  end function wrench_on

  !> What forces on the nodes are to the unknowns.
  pure function rigid_values(system, force) result(values)
    type(system_t), intent(in) :: system !! rigid bodies, u
    real(wp), intent(in) :: force(:, :) !! (3, nodes) forces [force]
    real(wp) :: values(system%tools%unknowns), w(6)
    integer :: b

    if (system%tools%unknowns == 0) return
    do b = 1, size(system%tools%rigid)
      associate (rigid => system%tools%rigid(b), first => system%tools%rigid(b)%first - &
        system%equations)
        w = wrench_on(rigid, system%u, rigid%move, force)
        w(4:6) = w(4:6)/rigid%length
        values(first + 1:first + size(rigid%unknown)) = w(rigid%unknown)
      end associate
    end do
  end function rigid_values

  !> How the unknowns of all bodies move a node that one of them carries.
  pure function rigid_motion(system, node) result(motion)
    type(system_t), intent(in) :: system !! rigid bodies, positions
    integer, intent(in) :: node !! the node
    real(wp) :: motion(3, system%tools%unknowns), own(3, 6)

    motion = 0.0_wp
    associate (rigid => system%tools%rigid(system%tools%carried_by(node)))
      own(:, 1:3) = identity
      own(:, 4:6) = -spin(system%position%x_now(:, node) - rigid%point - rigid%given &
        - rigid%move)/rigid%length
      motion(:, rigid%first - system%equations + 1:rigid%first - system%equations + &
        size(rigid%unknown)) = own(:, rigid%unknown)
    end associate
  end function rigid_motion

  !> What acts on the unknowns of all bodies but for contact.
  pure function loads_on_rigid(system) result(load)
    type(system_t), intent(in) :: system !! rigid bodies, loads
    real(wp), allocatable :: load(:)
    real(wp) :: w(6)
    integer :: b

    load = [real(wp) ::]
    do b = 1, size(system%tools%rigid)
      associate (rigid => system%tools%rigid(b))
        w = rigid%load + wrench_on(rigid, system%u, rigid%move, system%loads%external)
        load = [load, w(rigid%unknown)/merge(1.0_wp, rigid%length, rigid%unknown <= 3)]
      end associate
    end do
  end function loads_on_rigid

  !> Moves all bodies by values of their unknowns.
  subroutine move_rigid(equations, u, tools, form, values)
    integer, intent(in) :: equations !! free degrees of freedom
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(rigid_part_t), intent(inout) :: tools !! rigid bodies with a point
    type(form_t), intent(inout) :: form !! gets solution, trial
    real(wp), intent(in) :: values(:) !! (unknowns) [length]

    if (size(values) > 0) form%solution(equations + 1:) = values
    call try_rigid(tools, form%solution, 1.0_wp, form%trial)
    call take_rigid(u, tools)
  end subroutine move_rigid

  !> Residual of the unknowns: what acts on the nodes of a body and on its point.
  subroutine add_rigid_right(right, tools, u, tried, force)
    real(wp), intent(inout) :: right(:) !! right-hand side behind the equations of the nodes [force]
    type(rigid_part_t), intent(in) :: tools !! rigid bodies with a point
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements, of the iterate or a trial [length]
    logical, intent(in) :: tried !! those of the trial
    real(wp), intent(in) :: force(:, :) !! (3, nodes) what acts on the nodes [force]
    real(wp) :: w(6), move(3)
    integer :: b

    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        move = rigid%move
        if (tried) move = rigid%trial_move
        w = rigid%load + wrench_on(rigid, u, move, force)
        w(4:6) = w(4:6)/rigid%length
        right(rigid%first + 1:rigid%first + size(rigid%unknown)) = w(rigid%unknown)
      end associate
    end do
  end subroutine add_rigid_right

  !> Residual of the free translations of a connected body.
  pure function rigid_force(tools, right, body) result(force)
    type(rigid_part_t), intent(in) :: tools !! rigid bodies with a point
    real(wp), intent(in) :: right(:) !! (equations+unknowns) residual [force]
    integer, intent(in) :: body !! connected body
    real(wp) :: force(3)
    integer :: b, k

    force = 0.0_wp
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        if (rigid%body /= body) cycle
        do k = 1, count(rigid%unknown <= 3)
          force(rigid%unknown(k)) = force(rigid%unknown(k)) + right(rigid%first + k)
        end do
      end associate
    end do
  end function rigid_force

  !> Norm of the loads on points, as forces.
  pure real(wp) function rigid_loads(tools) result(norm)
    type(rigid_part_t), intent(in) :: tools !! rigid bodies, their loads
    integer :: b

    norm = 0.0_wp
    if (.not. allocated(tools%rigid)) return
    do b = 1, size(tools%rigid)
      norm = norm2([norm, tools%rigid(b)%load(1:3), tools%rigid(b)%load(4:6)/tools%rigid(b)%length])
    end do
  end function rigid_loads

  !> The converged iterate becomes the new state: its free translations and rotation vectors.
  subroutine keep_rigid(tools, state)
    type(rigid_part_t), intent(in) :: tools !! rigid bodies, converged
    type(state_t), intent(inout) :: state !! gets rigid
    integer :: b

    if (tools%unknowns == 0) return
    do b = 1, size(tools%rigid)
      associate (rigid => tools%rigid(b))
        state%rigid(1:3, b) = rigid%move
        if (any(rigid%unknown > 3)) state%rigid(4:6, b) = rotation_vector(rigid%turn, &
          state%rigid(4:6, b))
      end associate
    end do
  end subroutine keep_rigid
end module rigid_bodies

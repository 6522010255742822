!> The multipliers of all pairs as unknowns of the condensed form: what their weighted gaps are
!! without them, and their compliance (doc/theory, "Mortar contact", eqs. (7.17), (7.18)).
!! In more than 400 lines, since gaps, compliance and motions are sums over the same rows.
module mortar_system
  use kinds, only: wp
  use model_types, only: model_t
  use mortar_types, only: turned_way
  use mortar_cone, only: cone_of_node_t
  use condensed_types, only: condensed_t, condensed_body_t
  use rigid_bodies, only: rigid_motion, loads_on_rigid
  use live_candidates, only: gather_compliance, complete_compliance
  use tree_compliance, only: apply_tree
  use system_types, only: system_t
  implicit none
  private
  public :: mortar_system_t, build_mortar, join_rows, find_gaps, take_cones, spread_multipliers, &
    local_forces

  !> The rows of all pairs, one after the other.
  type :: mortar_rows_t
    integer, allocatable :: node(:) !! (n) slave node
    integer, allocatable :: first(:) !! (n+1) where the row of each begins
    integer, allocatable :: column(:) !! nodes of the rows
    real(wp), allocatable :: now(:) !! weights there
    real(wp), allocatable :: before(:) !! the same for slip
    real(wp), allocatable :: frame(:, :, :) !! (3, 3, n) p1, p2 and the normal
  end type mortar_rows_t

  !> The system of the multipliers, three to each, along its frame.
  type :: mortar_system_t
    integer :: n = 0 !! multipliers
    integer, allocatable :: start(:) !! (pairs+1) those of the pairs before
    type(mortar_rows_t) :: rows !! their rows
    real(wp), allocatable :: gap(:) !! (3 n) slip and gap without contact forces [length]
    real(wp), allocatable :: compliance(:, :) !! (3 n, 3 n) G, what they are by a force
    !! [length/force]
    real(wp), allocatable :: motion(:, :) !! (3 n, modes) by rigid motions of the bodies
    real(wp), allocatable :: push(:, :) !! (3 n, modes) work of the forces on these
    real(wp), allocatable :: load(:) !! (modes) that of the loads [force]
    real(wp), allocatable :: hold(:, :) !! (modes, modes) what resists them in a bulk that is not
    !! linear [force/length]
    type(cone_of_node_t), allocatable :: cone(:) !! (n) laws
    logical, allocatable :: yields(:) !! (n) by a penalty
  end type mortar_system_t

contains

  !> Gaps, compliance, rigid motions and cones of all multipliers.
  subroutine build_mortar(model, system, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(inout) :: system !! loaded displacements, prescribed u; compliances
    type(mortar_system_t), intent(out) :: unknowns !! the system
    integer :: b

    call join_rows(model, unknowns)
    call find_gaps(model, system, unknowns)
    call gather_compliance(system%condensed)
    call complete_compliance(system%condensed)
    allocate (unknowns%compliance(3*unknowns%n, 3*unknowns%n), source=0.0_wp)
    associate (modes => system%condensed%rigid%modes)
      allocate (unknowns%motion(3*unknowns%n, modes), unknowns%push(3*unknowns%n, modes), &
        source=0.0_wp)
      allocate (unknowns%load(modes), source=0.0_wp)
      if (modes > 0) unknowns%load = matmul(system%condensed%outer%pushes, &
        system%condensed%outer%factors)
      allocate (unknowns%hold(modes, modes), source=0.0_wp)
      if (modes > 0 .and. .not. system%bulk%linear) unknowns%hold = system%condensed%rigid%hold
    end associate
    if (system%tools%border%n > 0) call add_rigid(system, unknowns)
    do b = 1, size(system%condensed%bodies)
      if (system%condensed%bodies(b)%n_live > 0) call add_body(system%condensed, &
        system%condensed%bodies(b), unknowns)
    end do
    call add_penalties(model, unknowns)
    call drop_supported(system%equation, unknowns)
    call take_cones(model, unknowns)
  end subroutine build_mortar

  !> The rows of the pairs, one after the other.
  pure subroutine join_rows(model, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(mortar_system_t), intent(inout) :: unknowns !! gets start, rows
    integer :: k, n, entries

    allocate (unknowns%start(size(model%pairs) + 1))
    unknowns%start(1) = 0
    entries = 0
    do k = 1, size(model%pairs)
      unknowns%start(k + 1) = unknowns%start(k) + model%pairs(k)%nodes%n
      entries = entries + size(model%pairs(k)%nodes%column)
    end do
    n = unknowns%start(size(model%pairs) + 1)
    unknowns%n = n
    associate (rows => unknowns%rows)
      allocate (rows%node(n), rows%first(n + 1), rows%column(entries), rows%now(entries), &
        rows%before(entries), rows%frame(3, 3, n))
      rows%first(1) = 1
      do k = 1, size(model%pairs)
        associate (nodes => model%pairs(k)%nodes, i => unknowns%start(k))
          associate (e => rows%first(i + 1) - 1)
            rows%node(i + 1:i + nodes%n) = nodes%node
            rows%frame(:, :, i + 1:i + nodes%n) = nodes%frame
            rows%column(e + 1:e + size(nodes%column)) = nodes%column
            rows%now(e + 1:e + size(nodes%column)) = nodes%now
            rows%before(e + 1:e + size(nodes%column)) = nodes%before
            rows%first(i + 2:i + nodes%n + 1) = e + nodes%first(2:)
          end associate
        end associate
      end do
    end associate
  end subroutine join_rows

  !> Slip and gap of all multipliers under the loads alone. Rows add up to zero, so that places may
  !! be seen from the slave node: that saves digits.
  pure subroutine find_gaps(model, system, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(in) :: system !! loaded displacements, prescribed u
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets gap
    real(wp) :: x(3, size(system%u, 2)), from(3, size(system%u, 2)), slip(3), gap(3), way(3)
    integer :: c, i, k, m, e

    x = model%mesh%x + system%u
    associate (condensed => system%condensed)
      do c = 1, condensed%n
        x(condensed%direction(c), condensed%node(c)) = model%mesh%x(condensed%direction(c), &
          condensed%node(c)) + condensed%outer%loaded(c)
      end do
    end associate
    allocate (unknowns%gap(3*unknowns%n))
    from = 0.0_wp
    do k = 1, size(model%pairs)
      do m = 1, model%pairs(k)%nodes%n
        i = unknowns%start(k) + m
        associate (rows => unknowns%rows, frame => unknowns%rows%frame(:, :, i), &
          node => unknowns%rows%node(i), share => model%pairs(k)%nodes%from(:, m))
          slip = 0.0_wp
          way = 0.0_wp
          gap = 0.0_wp
          do e = rows%first(i), rows%first(i + 1) - 1
            associate (j => rows%column(e))
              gap = gap + rows%now(e)*(x(:, j) - x(:, node))
              slip = slip + rows%before(e)*((x(:, j) - x(:, node)) - way_from(system, share, j, &
                node))
              way = way + rows%before(e)*(system%position%x_old(:, j) - system%position%x_old(:, &
                node))
            end associate
          end do
          slip = slip - share(1)*(turned_way(model%pairs(k)%old_nodes, model%pairs(k)%nodes, m, &
            way) - way)
          unknowns%gap(3*i - 2:3*i - 1) = matmul(slip, frame(:, 1:2))
          unknowns%gap(3*i) = dot_product(gap, frame(:, 3)) + model%pairs(k)%nodes%offset(m)
        end associate
      end do
    end do
  end subroutine find_gaps

  !> Where slip counts from, seen from another node.
  pure function way_from(system, share, j, node) result(way)
    type(system_t), intent(in) :: system !! positions on the way
    real(wp), intent(in) :: share(3) !! of the last state, the free way, and the first pass
    integer, intent(in) :: j !! the node
    integer, intent(in) :: node !! where it is seen from
    real(wp) :: way(3)

    way = share(1)*(system%position%x_old(:, j) - system%position%x_old(:, node))
    if (abs(share(2)) > 0.0_wp) way = way + share(2)*(system%touch%x_free(:, j) &
      - system%touch%x_free(:, node))
    if (abs(share(3)) > 0.0_wp) way = way + share(3)*(system%touch%x_end(:, j) &
      - system%touch%x_end(:, node))
  end function way_from

  !> What a body adds to compliance and rigid motions: G = B C B_f^T, eq. (7.17).
  subroutine add_body(condensed, body, unknowns)
    type(condensed_t), intent(in) :: condensed !! live candidates
    type(condensed_body_t), intent(in) :: body !! its compliance
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets compliance, motion, push
    real(wp) :: moved(body%n_live, 3), now(3, 3), before(3, 3)
    integer :: own(3, size(unknowns%rows%column)), i, l, e, k
    logical :: touches(unknowns%n)

    associate (rows => unknowns%rows)
      do e = 1, size(rows%column)
        do k = 1, 3
          own(k, e) = 0
          if (condensed%place(k, rows%column(e)) == 0) cycle
          i = condensed%alive%live_place(condensed%place(k, rows%column(e))) - body%first_live
          if (i >= 1 .and. i <= body%n_live) own(k, e) = i
        end do
      end do
      do i = 1, unknowns%n
        touches(i) = any(own(:, rows%first(i):rows%first(i + 1) - 1) > 0)
      end do
      !$omp parallel do schedule(dynamic, 8) default(none) shared(unknowns, body, own, touches) &
      !$omp& private(l, i, moved, now, before)
      do l = 1, unknowns%n
        if (.not. touches(l)) cycle
        call yield_to(body, own, unknowns%rows, l, moved)
        do i = 1, unknowns%n
          if (.not. touches(i)) cycle
          call weigh_ways(own, unknowns%rows, i, moved, now, before)
          call add_block(unknowns%rows, i, l, now, before, unknowns%compliance)
        end do
        if (body%motions%n > 0) call add_motions(body, own, l, unknowns)
      end do
      !$omp end parallel do
    end associate
  end subroutine add_body

  !> What a body does where it is live under forces 1 along x, y and z of one multiplier.
  subroutine yield_to(body, own, rows, l, moved)
    type(condensed_body_t), intent(in) :: body !! its compliance
    integer, intent(in) :: own(:, :) !! (3, entries) its live candidates, 0 for none
    type(mortar_rows_t), intent(in) :: rows !! rows of all multipliers
    integer, intent(in) :: l !! the multiplier
    real(wp), intent(out) :: moved(:, :) !! (n_live, 3) [length/force]
    real(wp) :: force(size(moved, 1))
    integer :: e, k

    do k = 1, 3
      if (body%tree%used) then
        force = 0.0_wp
        do e = rows%first(l), rows%first(l + 1) - 1
          if (own(k, e) > 0) force(own(k, e)) = rows%now(e)
        end do
        moved(:, k) = 0.0_wp
        if (any(abs(force) > 0.0_wp)) call apply_tree(body, body%gathered, force, moved(:, k))
        cycle
      end if
      moved(:, k) = 0.0_wp
      do e = rows%first(l), rows%first(l + 1) - 1
        if (own(k, e) > 0) moved(:, k) = moved(:, k) + rows%now(e) &
          *body%live(body%skipped + 1:body%skipped + size(moved, 1), own(k, e))
      end do
    end do
  end subroutine yield_to

  !> Weighted ways of a multiplier, from those of a body.
  pure subroutine weigh_ways(own, rows, i, moved, now, before)
    integer, intent(in) :: own(:, :) !! (3, entries) live candidates of the body, 0 for none
    type(mortar_rows_t), intent(in) :: rows !! rows of all multipliers
    integer, intent(in) :: i !! the multiplier
    real(wp), intent(in) :: moved(:, :) !! (n_live, 3) ways of the body
    real(wp), intent(out) :: now(3, 3) !! (direction, force) by present weights
    real(wp), intent(out) :: before(3, 3) !! by those for slip
    integer :: e, k

    now = 0.0_wp
    before = 0.0_wp
    do e = rows%first(i), rows%first(i + 1) - 1
      do k = 1, 3
        if (own(k, e) == 0) cycle
        now(k, :) = now(k, :) + rows%now(e)*moved(own(k, e), :)
        before(k, :) = before(k, :) + rows%before(e)*moved(own(k, e), :)
      end do
    end do
  end subroutine weigh_ways

  !> Adds the weighted ways of one multiplier by the forces of another, along their frames.
  pure subroutine add_block(rows, i, l, now, before, compliance)
    type(mortar_rows_t), intent(in) :: rows !! frames
    integer, intent(in) :: i !! the one that moves
    integer, intent(in) :: l !! the one whose force acts
    real(wp), intent(in) :: now(3, 3) !! (direction, force) by present weights [length/force]
    real(wp), intent(in) :: before(3, 3) !! by those for slip [length/force]
    real(wp), intent(inout) :: compliance(:, :) !! (3 n, 3 n) gets them
    real(wp) :: block(3, 3)

    block(1:2, :) = matmul(transpose(rows%frame(:, 1:2, i)), before)
    block(3, :) = matmul(rows%frame(:, 3, i), now)
    associate (mine => compliance(3*i - 2:3*i, 3*l - 2:3*l))
      mine = mine + matmul(block, rows%frame(:, :, l))
    end associate
  end subroutine add_block

  !> What rigid motions of a body do to a multiplier, and its force to them.
  pure subroutine add_motions(body, own, i, unknowns)
    type(condensed_body_t), intent(in) :: body !! its motions
    integer, intent(in) :: own(:, :) !! (3, entries) its live candidates, 0 for none
    integer, intent(in) :: i !! the multiplier
    type(mortar_system_t), intent(inout) :: unknowns !! gets motion, push
    real(wp) :: now(3, body%motions%n), before(3, body%motions%n)
    integer :: e, k

    now = 0.0_wp
    before = 0.0_wp
    associate (rows => unknowns%rows, first => body%first_mode + 1, last => body%first_mode &
      + body%motions%n)
      do e = rows%first(i), rows%first(i + 1) - 1
        do k = 1, 3
          if (own(k, e) == 0) cycle
          now(k, :) = now(k, :) + rows%now(e)*body%modes(body%gathered(own(k, e)), :)
          before(k, :) = before(k, :) + rows%before(e)*body%modes(body%gathered(own(k, e)), :)
        end do
      end do
      now = matmul(transpose(rows%frame(:, :, i)), now)
      before = matmul(transpose(rows%frame(:, :, i)), before)
      unknowns%push(3*i - 2:3*i, first:last) = unknowns%push(3*i - 2:3*i, first:last) + now
      before(3, :) = now(3, :)
      unknowns%motion(3*i - 2:3*i, first:last) = unknowns%motion(3*i - 2:3*i, first:last) + before
    end associate
  end subroutine add_motions

  !> Free motions of rigid bodies with a point, behind those of the others, to first order about
  !! where they are; what acts on them but for contact (doc/theory, "Rigid bodies", eq. (9.7)).
  pure subroutine add_rigid(system, unknowns)
    type(system_t), intent(in) :: system !! rigid bodies, loads
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets motion, push, load
    real(wp), dimension(3, system%tools%border%n) :: now, before, of_node
    real(wp), allocatable :: none(:, :), hold(:, :)
    integer :: i, e

    allocate (none(3*unknowns%n, system%tools%border%n), source=0.0_wp)
    associate (rows => unknowns%rows, n => size(unknowns%load), m => system%tools%border%n)
      unknowns%motion = reshape([unknowns%motion, none], [3*unknowns%n, n + m])
      unknowns%push = reshape([unknowns%push, none], [3*unknowns%n, n + m])
      allocate (hold(n + m, n + m), source=0.0_wp)
      hold(:n, :n) = unknowns%hold
      call move_alloc(hold, unknowns%hold)
      unknowns%load = [unknowns%load, loads_on_rigid(system)]
      do i = 1, unknowns%n
        now = 0.0_wp
        before = 0.0_wp
        do e = rows%first(i), rows%first(i + 1) - 1
          if (system%tools%carried_by(rows%column(e)) == 0) cycle
          of_node = rigid_motion(system, rows%column(e))
          now = now + rows%now(e)*of_node
          before = before + rows%before(e)*of_node
        end do
        now = matmul(transpose(rows%frame(:, :, i)), now)
        before = matmul(transpose(rows%frame(:, :, i)), before)
        before(3, :) = now(3, :)
        unknowns%push(3*i - 2:3*i, n + 1:) = now
        unknowns%motion(3*i - 2:3*i, n + 1:) = before
      end do
    end associate
  end subroutine add_rigid

  !> Points of other forms yield by their penalties, eq. (7.22).
  pure subroutine add_penalties(model, unknowns)
    type(model_t), intent(in) :: model !! pairs with their rows
    type(mortar_system_t), intent(inout) :: unknowns !! compliance grows; gets yields
    integer :: k, m, i, c

    allocate (unknowns%yields(unknowns%n), source=.false.)
    do k = 1, size(model%pairs)
      do m = 1, model%pairs(k)%nodes%n
        i = unknowns%start(k) + m
        unknowns%yields(i) = model%pairs(k)%nodes%compliance(m) > 0.0_wp
        do c = 3*i - 2, 3*i
          unknowns%compliance(c, c) = unknowns%compliance(c, c) &
            + model%pairs(k)%nodes%compliance(m)
        end do
      end do
    end do
  end subroutine add_penalties

  !> A slave node whose own motion along an axis is prescribed has no compliance there: its
  !! multiplier carries no force along it, eq. (7.18).
  pure subroutine drop_supported(equation, unknowns)
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    type(mortar_system_t), intent(inout) :: unknowns !! loses what supports carry
    real(wp) :: q(3, 3), d(3), stiff
    integer :: i, k

    do i = 1, unknowns%n
      associate (free => equation(:, unknowns%rows%node(i)) > 0, r => 3*i - 2)
        if (all(free) .or. unknowns%yields(i)) cycle
        q = 0.0_wp
        stiff = 0.0_wp
        do k = 1, 3
          q(k, k) = 1.0_wp
          stiff = max(stiff, unknowns%compliance(r + k - 1, r + k - 1))
        end do
        do k = 1, 3
          if (free(k)) cycle
          d = unknowns%rows%frame(k, :, i)
          q = q - spread(d, 2, 3)*spread(d, 1, 3)
        end do
        unknowns%compliance(r:r + 2, :) = matmul(q, unknowns%compliance(r:r + 2, :))
        unknowns%compliance(:, r:r + 2) = matmul(unknowns%compliance(:, r:r + 2), q)
        unknowns%gap(r:r + 2) = matmul(q, unknowns%gap(r:r + 2))
        unknowns%motion(r:r + 2, :) = matmul(q, unknowns%motion(r:r + 2, :))
        unknowns%push(r:r + 2, :) = matmul(q, unknowns%push(r:r + 2, :))
        do k = 1, 3
          associate (own => unknowns%compliance(r:r + 2, r + k - 1))
            own = own - stiff*q(:, k)
            own(k) = own(k) + stiff
          end associate
        end do
      end associate
    end do
  end subroutine drop_supported

  !> Laws of the multipliers; scales are their own compliances, one for both tangents.
  pure subroutine take_cones(model, unknowns)
    type(model_t), intent(in) :: model !! pairs
    type(mortar_system_t), intent(inout) :: unknowns !! compliance given; gets cone
    integer :: k, m, i

    allocate (unknowns%cone(unknowns%n))
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        do m = 1, pair%nodes%n
          i = unknowns%start(k) + m
          associate (cone => unknowns%cone(i), compliance => unknowns%compliance)
            if (.not. pair%nodes%waits(m)) cone%mu = pair%friction%mu
            cone%law = pair%law
            cone%rule = pair%friction%slip_rule
            cone%area = pair%nodes%weight(m)
            cone%path = pair%nodes%path(m)
            cone%scale = [2.0_wp/(abs(compliance(3*i - 2, 3*i - 2)) &
              + abs(compliance(3*i - 1, 3*i - 1))), 1.0_wp/abs(compliance(3*i, 3*i))]
          end associate
        end do
      end associate
    end do
  end subroutine take_cones

  !> The forces of the multipliers along their present frames.
  pure function local_forces(model, unknowns) result(z)
    type(model_t), intent(in) :: model !! pairs with forces in space
    type(mortar_system_t), intent(in) :: unknowns !! frames
    real(wp) :: z(3*unknowns%n)
    integer :: k, m, i

    do k = 1, size(model%pairs)
      do m = 1, model%pairs(k)%nodes%n
        i = unknowns%start(k) + m
        z(3*i - 2:3*i) = matmul(model%pairs(k)%nodes%force(:, m), unknowns%rows%frame(:, :, i))
      end do
    end do
  end function local_forces

  !> Hands the forces of the multipliers to the nodes: what contact asks of the bulk.
  pure subroutine spread_multipliers(unknowns, z, system)
    type(mortar_system_t), intent(in) :: unknowns !! rows and frames
    real(wp), intent(in) :: z(:) !! (3 n) forces along the frames [force]
    type(system_t), intent(inout) :: system !! gets contact_force, and force of condensed
    real(wp) :: force(3)
    integer :: i, e, c

    system%contact_force = 0.0_wp
    associate (rows => unknowns%rows)
      do i = 1, unknowns%n
        force = matmul(rows%frame(:, :, i), z(3*i - 2:3*i))
        do e = rows%first(i), rows%first(i + 1) - 1
          associate (at => system%contact_force(:, rows%column(e)))
            at = at - rows%now(e)*force
          end associate
        end do
      end do
    end associate
    associate (condensed => system%condensed)
      do c = 1, condensed%n
        condensed%bulk%force(c) = system%contact_force(condensed%direction(c), condensed%node(c))
      end do
    end associate
  end subroutine spread_multipliers
end module mortar_system

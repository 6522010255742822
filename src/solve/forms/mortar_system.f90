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
  public :: mortar_system_t, build_mortar, anchor_mortar, join_rows, find_gaps, take_cones, &
    spread_multipliers, local_forces

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
    real(wp), allocatable :: stiff(:) !! (n) compliance along supported axes, 0 for none
    real(wp), allocatable :: motion(:, :) !! (3 n, modes) by rigid motions of the bodies
    real(wp), allocatable :: push(:, :) !! (3 n, modes) work of the forces on these
    real(wp), allocatable :: load(:) !! (modes) that of the loads [force]
    real(wp), allocatable :: hold(:, :) !! (modes, modes) what resists them in a bulk that is not
    !! linear [force/length]
    type(cone_of_node_t), allocatable :: cone(:) !! (n) laws
    logical, allocatable :: gives_way(:) !! (n) by a penalty
  end type mortar_system_t

contains

  !> Gaps, compliance, rigid motions and cones of all multipliers.
  subroutine build_mortar(model, system, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(inout) :: system !! loaded displacements, prescribed u; compliances
    type(mortar_system_t), intent(out) :: unknowns !! the system
    real(wp) :: x(3, size(system%u, 2))
    integer :: b, c

    call join_rows(model, unknowns)
    x = model%mesh%x + system%u
    associate (condensed => system%condensed)
      do c = 1, condensed%n
        x(condensed%direction(c), condensed%node(c)) = model%mesh%x(condensed%direction(c), &
          condensed%node(c)) + condensed%outer%loaded(c)
      end do
    end associate
    call find_gaps(model, system, x, unknowns)
    call gather_compliance(system%condensed)
    call complete_compliance(system%condensed)
    allocate (unknowns%compliance(3*unknowns%n, 3*unknowns%n), source=0.0_wp)
    do b = 1, size(system%condensed%bodies)
      if (system%condensed%bodies(b)%n_live > 0) call add_body(system%condensed, &
        system%condensed%bodies(b), unknowns)
    end do
    call find_motions(system%condensed, unknowns)
    allocate (unknowns%hold(size(unknowns%load), size(unknowns%load)), source=0.0_wp)
    if (size(unknowns%load) > 0 .and. .not. system%bulk%linear) unknowns%hold = &
      system%condensed%rigid%hold
    if (system%tools%border%n > 0) call add_rigid(system, unknowns)
    call add_penalties(model, unknowns)
    call drop_supported(system%equation, unknowns)
    call drop_compliance(system%equation, unknowns)
    call take_cones(model, unknowns)
  end subroutine build_mortar

  !> The same system with other rows: its gaps are the true ones at the forces and motions so far,
  !! and change with them by the compliance that is at hand.
  subroutine anchor_mortar(model, system, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers, the same as before
    type(system_t), intent(in) :: system !! where forces and motions so far have put the bodies
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets gap, motion, push, cones
    integer :: i

    call find_gaps(model, system, system%position%x_now, unknowns)
    call find_motions(system%condensed, unknowns)
    call drop_supported(system%equation, unknowns)
    associate (z => local_forces(model, unknowns), alpha => system%condensed%rigid%alpha)
      unknowns%gap = unknowns%gap - matmul(unknowns%compliance, z)
      if (size(alpha) > 0) unknowns%gap = unknowns%gap - matmul(unknowns%motion, alpha)
      do i = 1, unknowns%n
        associate (own => unknowns%gap(3*i - 2:3*i), mine => z(3*i - 2:3*i))
          own = own + unknowns%stiff(i)*(mine - matmul(across(system%equation(:, &
            unknowns%rows%node(i)) > 0, unknowns%rows%frame(:, :, i)), mine))
        end associate
      end do
    end associate
    call take_cones(model, unknowns)
  end subroutine anchor_mortar

  !> The rows of the pairs, one after the other.
  pure subroutine join_rows(model, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(mortar_system_t), intent(inout) :: unknowns !! gets start, rows
    integer :: k, n, entries

    unknowns%rows = mortar_rows_t()
    unknowns%start = spread(0, 1, size(model%pairs) + 1)
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

  !> Slip and gap of all multipliers with the nodes at x. Rows add up to zero, so that places may be
  !! seen from the slave node: that saves digits.
  pure subroutine find_gaps(model, system, x, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(in) :: system !! where slip counts from
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets gap
    real(wp) :: slip(3), gap(3), way(3)
    integer :: i, k, m, e

    unknowns%gap = spread(0.0_wp, 1, 3*unknowns%n)
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

  !> What a body adds to the compliance: G = B C B_f^T, eq. (7.17).
  subroutine add_body(condensed, body, unknowns)
    type(condensed_t), intent(in) :: condensed !! live candidates
    type(condensed_body_t), intent(in) :: body !! its compliance
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets compliance
    real(wp) :: moved(3, body%n_live)
    integer :: own(3, size(unknowns%rows%column)), i, l
    logical :: touches(unknowns%n)

    associate (rows => unknowns%rows)
      own = own_candidates(condensed, body, rows%column)
      do i = 1, unknowns%n
        touches(i) = any(own(:, rows%first(i):rows%first(i + 1) - 1) > 0)
      end do
      !$omp parallel do schedule(dynamic, 8) default(none) shared(unknowns, body, own, touches) &
      !$omp& private(l, i, moved)
      do l = 1, unknowns%n
        if (.not. touches(l)) cycle
        call product_with(body, own, unknowns%rows, l, moved)
        do i = 1, unknowns%n
          if (touches(i)) call add_block(own, unknowns%rows, i, l, moved, &
            unknowns%compliance(3*i - 2:3*i, 3*l - 2:3*l))
        end do
      end do
      !$omp end parallel do
    end associate
  end subroutine add_body

  !> Live candidates of a body at nodes, 0 for none.
  pure function own_candidates(condensed, body, node) result(own)
    type(condensed_t), intent(in) :: condensed !! live candidates
    type(condensed_body_t), intent(in) :: body !! one of its bodies
    integer, intent(in) :: node(:) !! (entries) nodes
    integer :: own(3, size(node)), e, k, i

    own = 0
    do e = 1, size(node)
      do k = 1, 3
        if (condensed%place(k, node(e)) == 0) cycle
        i = condensed%alive%live_place(condensed%place(k, node(e))) - body%first_live
        if (i >= 1 .and. i <= body%n_live) own(k, e) = i
      end do
    end do
  end function own_candidates

  !> What a body does where it is live under forces 1 along x, y and z of one multiplier.
  subroutine product_with(body, own, rows, l, moved)
    type(condensed_body_t), intent(in) :: body !! its compliance
    integer, intent(in) :: own(:, :) !! (3, entries) its live candidates, 0 for none
    type(mortar_rows_t), intent(in) :: rows !! rows of all multipliers
    integer, intent(in) :: l !! the multiplier
    real(wp), intent(out) :: moved(:, :) !! (force, n_live) [length/force]
    real(wp) :: force(size(moved, 2)), way(size(moved, 2))
    integer :: e, k

    do k = 1, 3
      way = 0.0_wp
      if (body%tree%used) then
        force = 0.0_wp
        do e = rows%first(l), rows%first(l + 1) - 1
          if (own(k, e) > 0) force(own(k, e)) = rows%now(e)
        end do
        if (any(abs(force) > 0.0_wp)) call apply_tree(body, body%gathered, force, way)
      else
        do e = rows%first(l), rows%first(l + 1) - 1
          if (own(k, e) > 0) way = way + rows%now(e) &
            *body%live(body%skipped + 1:body%skipped + size(way), own(k, e))
        end do
      end if
      moved(k, :) = way
    end do
  end subroutine product_with

  !> Adds the weighted ways of one multiplier by the forces of another, along their frames.
  pure subroutine add_block(own, rows, i, l, moved, block)
    integer, intent(in) :: own(:, :) !! (3, entries) live candidates of the body, 0 for none
    type(mortar_rows_t), intent(in) :: rows !! rows of all multipliers
    integer, intent(in) :: i !! the one that moves
    integer, intent(in) :: l !! the one whose force acts
    real(wp), intent(in) :: moved(:, :) !! (force, n_live) ways of the body [length/force]
    real(wp), intent(inout) :: block(3, 3) !! (frame of i, frame of l) of the compliance
    real(wp) :: now(3, 3), before(3, 3), ways(3, 3)
    integer :: e, k

    now = 0.0_wp
    before = 0.0_wp
    do e = rows%first(i), rows%first(i + 1) - 1
      do k = 1, 3
        if (own(k, e) == 0) cycle
        now(:, k) = now(:, k) + rows%now(e)*moved(:, own(k, e))
        before(:, k) = before(:, k) + rows%before(e)*moved(:, own(k, e))
      end do
    end do
    ways(:, 1:2) = matmul(before, rows%frame(:, 1:2, i))
    ways(:, 3) = matmul(now, rows%frame(:, 3, i))
    block = block + matmul(transpose(ways), rows%frame(:, :, l))
  end subroutine add_block

  !> What rigid motions of the bodies do to the multipliers, work of the forces on these, and that
  !! of the loads.
  pure subroutine find_motions(condensed, unknowns)
    type(condensed_t), intent(in) :: condensed !! bodies, loads
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets motion, push, load
    integer :: b, i

    associate (modes => condensed%rigid%modes)
      unknowns%motion = reshape([real(wp) ::], [3*unknowns%n, modes], [0.0_wp])
      unknowns%push = unknowns%motion
      unknowns%load = spread(0.0_wp, 1, modes)
      if (modes == 0) return
      unknowns%load = matmul(condensed%outer%pushes, condensed%outer%factors)
    end associate
    do b = 1, size(condensed%bodies)
      if (condensed%bodies(b)%n_live == 0 .or. condensed%bodies(b)%motions%n == 0) cycle
      associate (own => own_candidates(condensed, condensed%bodies(b), unknowns%rows%column))
        do i = 1, unknowns%n
          call add_motions(condensed%bodies(b), own, i, unknowns)
        end do
      end associate
    end do
  end subroutine find_motions

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

  !> Points of other forms give way by their penalties, eq. (7.22).
  pure subroutine add_penalties(model, unknowns)
    type(model_t), intent(in) :: model !! pairs with their rows
    type(mortar_system_t), intent(inout) :: unknowns !! compliance grows; gets product
    integer :: k, m, i, c

    allocate (unknowns%gives_way(unknowns%n), source=.false.)
    do k = 1, size(model%pairs)
      do m = 1, model%pairs(k)%nodes%n
        i = unknowns%start(k) + m
        unknowns%gives_way(i) = model%pairs(k)%nodes%compliance(m) > 0.0_wp
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
    type(mortar_system_t), intent(inout) :: unknowns !! gap, motion, push lose what supports carry
    real(wp) :: q(3, 3)
    integer :: i

    do i = 1, unknowns%n
      associate (free => equation(:, unknowns%rows%node(i)) > 0, r => 3*i - 2)
        if (all(free) .or. unknowns%gives_way(i)) cycle
        q = across(free, unknowns%rows%frame(:, :, i))
        unknowns%gap(r:r + 2) = matmul(q, unknowns%gap(r:r + 2))
        unknowns%motion(r:r + 2, :) = matmul(q, unknowns%motion(r:r + 2, :))
        unknowns%push(r:r + 2, :) = matmul(q, unknowns%push(r:r + 2, :))
      end associate
    end do
  end subroutine drop_supported

  !> The same for the compliance.
  pure subroutine drop_compliance(equation, unknowns)
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where prescribed
    type(mortar_system_t), intent(inout) :: unknowns !! compliance loses what supports carry
    real(wp) :: q(3, 3)
    integer :: i, k

    unknowns%stiff = spread(0.0_wp, 1, unknowns%n)
    do i = 1, unknowns%n
      associate (free => equation(:, unknowns%rows%node(i)) > 0, r => 3*i - 2)
        if (all(free) .or. unknowns%gives_way(i)) cycle
        q = across(free, unknowns%rows%frame(:, :, i))
        unknowns%stiff(i) = maxval([(unknowns%compliance(r + k, r + k), k=0, 2)])
        unknowns%compliance(r:r + 2, :) = matmul(q, unknowns%compliance(r:r + 2, :))
        unknowns%compliance(:, r:r + 2) = matmul(unknowns%compliance(:, r:r + 2), q)
        do k = 1, 3
          associate (own => unknowns%compliance(r:r + 2, r + k - 1))
            own = own - unknowns%stiff(i)*q(:, k)
            own(k) = own(k) + unknowns%stiff(i)
          end associate
        end do
      end associate
    end do
  end subroutine drop_compliance

  !> What is left of a vector along a frame without its parts along the axes that are not free.
  pure function across(free, frame) result(q)
    logical, intent(in) :: free(3) !! axes x, y, z
    real(wp), intent(in) :: frame(3, 3) !! the frame
    real(wp) :: q(3, 3)
    integer :: k

    q = reshape([1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp, 0.0_wp, 0.0_wp, 0.0_wp, 1.0_wp], [3, 3])
    do k = 1, 3
      if (.not. free(k)) q = q - spread(frame(k, :), 2, 3)*spread(frame(k, :), 1, 3)
    end do
  end function across

  !> Laws of the multipliers; scales are their own compliances, one for both tangents.
  pure subroutine take_cones(model, unknowns)
    type(model_t), intent(in) :: model !! pairs
    type(mortar_system_t), intent(inout) :: unknowns !! compliance given; gets cone
    integer :: k, m, i

    if (.not. allocated(unknowns%cone)) allocate (unknowns%cone(unknowns%n))
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

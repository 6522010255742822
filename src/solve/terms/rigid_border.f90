!> The unknowns of rigid bodies beside those of the nodes: rows and columns of the tangent, and the
!! solution of both by the factor of the nodes (doc/theory, "Rigid bodies", eq. (9.8)).
module rigid_border
  use kinds, only: wp
  use rotations, only: spin
  use vectors, only: identity
  use lapack_interface, only: dgetrf, dgetrs
  use element_parameters, only: d03_epsilon
  use back_ends, only: nodes_t, solver_done, solver_singular
  use element_types, only: status_open, routine_none
  use linear_solver, only: factorise_matrix, solve_system, describe_matrix
  use block_matrix, only: block_matrix_t, find_block
  use bulk_products, only: give_bulk
  use rigid_bodies, only: lever
  use system_types, only: form_t, system_t
  implicit none
  private
  public :: form_border, factorise_bordered, solve_bordered, motion_of, turning_of, hold_of

  !> Stiffness of what holds a body that nothing else holds, over the largest of the scene.
  real(wp), parameter :: soft_springs = 1.0e-6_wp

contains

  !> Derivatives of the residual of the unknowns, and of that of the nodes by the unknowns, from the
  !! matrix of all nodes and from what acts on the nodes of rigid bodies. Their sign is that of the
  !! tangent: of internal forces.
  subroutine form_border(system, form)
    type(system_t), intent(in) :: system !! matrix, forces, rigid given
    type(form_t), intent(inout) :: form !! gets border
    integer :: b, k
    real(wp) :: hold(system%tools%unknowns)

    if (system%tools%unknowns == 0) return
    associate (border => form%border, n => system%tools%unknowns, equations => system%equations)
      if (.not. allocated(border%corner)) allocate (border%columns(equations, n), &
        border%rows(equations, n), border%answers(equations, n), border%corner(n, n), &
        border%pivot(n))
      border%columns = 0.0_wp
      border%rows = 0.0_wp
      border%corner = 0.0_wp
    end associate
    do b = 1, size(system%tools%rigid)
      if (size(system%tools%rigid(b)%unknown) == 0) cycle
      if (system%contact%n > 0) then
        call add_blocks(form%whole%matrix, b, system, form)
      else
        call add_blocks(form%whole%bulk_matrix, b, system, form)
      end if
      associate (corner => form%border%corner(system%tools%rigid(b)%first - system%equations + &
        1:system%tools%rigid(b)%first - system%equations + size(system%tools%rigid(b)%unknown), &
        system%tools%rigid(b)%first - system%equations + 1:system%tools%rigid(b)%first - &
        system%equations + size(system%tools%rigid(b)%unknown)))
        corner = corner + turning_of(system, form, b)
      end associate
    end do
    hold = hold_of(system)
    do k = 1, system%tools%unknowns
      form%border%corner(k, k) = form%border%corner(k, k) + hold(k)
    end do
  end subroutine form_border

  !> How the unknowns of a body move node i of it.
  pure function motion_of(system, b, i) result(m)
    type(system_t), intent(in) :: system !! rigid bodies, u
    integer, intent(in) :: b !! the body
    integer, intent(in) :: i !! which of its nodes
    real(wp), allocatable :: m(:, :)
    real(wp) :: all_motions(3, 6)

    associate (rigid => system%tools%rigid(b))
      all_motions(:, 1:3) = identity
      all_motions(:, 4:6) = -spin(lever(rigid, i, system%u, rigid%move))/rigid%length
      m = all_motions(:, rigid%unknown)
    end associate
  end function motion_of

  !> What the blocks of the nodes of a body are to its unknowns.
  subroutine add_blocks(matrix, b, system, form)
    type(block_matrix_t), intent(in) :: matrix !! of all nodes
    integer, intent(in) :: b !! the body
    type(system_t), intent(in) :: system !! border grows
    type(form_t), intent(inout) :: form !! the linearised system in its form
    real(wp), allocatable :: motion(:, :)
    integer :: i, k, other

    do i = 1, size(system%tools%rigid(b)%node)
      motion = motion_of(system, b, i)
      associate (node => system%tools%rigid(b)%node(i))
        do k = matrix%ptr(node), matrix%ptr(node + 1) - 1
          other = matrix%row(k)
          call add_block(matmul(matrix%val(:, :, k), motion), &
            matmul(transpose(matrix%val(:, :, find_block(matrix, node, other))), motion))
        end do
      end associate
    end do

  contains

    !> Column and row of another node; nodes of rigid bodies hand on to their unknowns.
    subroutine add_block(column, row)
      real(wp), intent(in) :: column(:, :) !! (3, unknowns) force there by the unknowns
      real(wp), intent(in) :: row(:, :) !! (3, unknowns) resultants by its displacement
      integer :: c, first, n

      first = system%tools%rigid(b)%first - system%equations
      n = size(column, 2)
      associate (border => form%border)
        do c = 1, 3
          associate (equation => system%equation(c, other))
            if (equation == 0) cycle
            border%columns(equation, first + 1:first + n) = &
              border%columns(equation, first + 1:first + n) + column(c, :)
            border%rows(equation, first + 1:first + n) = &
              border%rows(equation, first + 1:first + n) + row(c, :)
          end associate
        end do
        if (system%tools%carried_by(other) == 0) return
        associate (next => system%tools%rigid(system%tools%carried_by(other)), &
          at => system%tools%rigid(system%tools%carried_by(other))%first - system%equations)
          border%corner(at + 1:at + size(next%unknown), first + 1:first + n) = border%corner(at + &
            1:at + size(next%unknown), first + 1:first + n) + matmul(transpose(motion_of(system, &
            system%tools%carried_by(other), findloc(next%node, other, 1))), column)
        end associate
      end associate
    end subroutine add_block
  end subroutine add_blocks

  !> Levers turn with a body: -sum [f] [r] of the forces on its nodes.
  pure function turning_of(system, form, b) result(mine)
    type(system_t), intent(in) :: system !! forces, rigid bodies, u
    type(form_t), intent(in) :: form !! its kind answers
    integer, intent(in) :: b !! the body
    real(wp) :: mine(size(system%tools%rigid(b)%unknown), size(system%tools%rigid(b)%unknown))
    real(wp) :: turning(6, 6), force(3)
    integer :: i

    turning = 0.0_wp
    associate (rigid => system%tools%rigid(b))
      do i = 1, size(rigid%node)
        associate (node => rigid%node(i))
          force = system%loads%external(:, node) - system%contact_force(:, node)
          if (form%kind%knows_inside) force = force - form%inner%bulk_force(:, node)
          turning(4:6, 4:6) = turning(4:6, 4:6) - matmul(spin(force), spin(lever(rigid, i, &
            system%u, rigid%move)))/rigid%length**2
        end associate
      end do
      mine = turning(rigid%unknown, rigid%unknown)
    end associate
  end function turning_of

  !> Soft springs and damping of bodies that contact does not hold, or not well.
  pure function hold_of(system) result(hold)
    type(system_t), intent(in) :: system !! regularised, damping
    real(wp) :: hold(system%tools%unknowns)
    integer :: b

    do b = 1, size(system%tools%rigid)
      associate (rigid => system%tools%rigid(b), first => system%tools%rigid(b)%first &
        - system%equations)
        hold(first + 1:first + size(rigid%unknown)) = system%body%damping + merge(soft_springs* &
          stiffest(system), 0.0_wp, system%body%regularised(rigid%body))
      end associate
    end do
  end function hold_of

  !> A stiffness of the scene: of the bulk, of contact where all is rigid.
  pure real(wp) function stiffest(system)
    type(system_t), intent(in) :: system !! its matrices

    stiffest = system%scale%stiffest
    if (stiffest <= 0.0_wp .and. system%contact%n > 0) stiffest = &
      maxval(system%contact%d(d03_epsilon, :))
    if (stiffest <= 0.0_wp) stiffest = 1.0_wp
  end function stiffest

  !> Factorises the matrix of the nodes and what it leaves of the corner.
  subroutine factorise_bordered(system, form, symmetric, outcome)
    type(system_t), intent(in) :: system !! its unknowns
    type(form_t), intent(inout) :: form !! csc and border given; factor and answers made
    logical, intent(in) :: symmetric !! the matrix of the nodes may be taken for symmetric
    integer, intent(out) :: outcome !! one of the outcomes of the solver
    integer :: k, info

    outcome = solver_done
    if (form%whole%solver%by_nodes .and. form%whole%csc%changed) &
      call describe_tangent(system, form, symmetric)
    if (system%equations > 0 .or. system%tools%unknowns == 0) call &
      factorise_matrix(form%whole%solver, form%whole%csc, symmetric, form%costs, outcome)
    if (system%tools%unknowns == 0 .or. outcome /= solver_done) return
    associate (border => form%border, n => system%tools%unknowns)
      border%answers = 0.0_wp
      do k = 1, n
        if (all(abs(border%columns(:, k)) <= 0.0_wp)) cycle
        call solve_system(form%whole%solver, form%whole%csc, border%columns(:, k), &
          border%answers(:, k), form%costs, outcome)
        if (outcome /= solver_done) return
      end do
      border%corner = border%corner - matmul(transpose(border%rows), border%answers)
      call dgetrf(n, n, border%corner, n, border%pivot, info)
      if (info /= 0) outcome = solver_singular
    end associate
  end subroutine factorise_bordered

  !> Hands on the tangent by nodes, and which of them contact holds.
  subroutine describe_tangent(system, form, symmetric)
    type(system_t), intent(in) :: system !! tangent formed; the solver takes it
    type(form_t), intent(inout) :: form !! gets matrix
    logical, intent(in) :: symmetric !! it may be taken for symmetric
    type(nodes_t) :: nodes
    type(block_matrix_t) :: none
    integer :: k

    nodes%apart = form%whole%apart
    nodes%x = system%position%x_now - system%u
    nodes%linear = system%bulk%linear
    nodes%loose = any(system%body%floating)
    nodes%symmetric = symmetric
    allocate (nodes%touched(size(system%equation, 2)), source=.false.)
    associate (list => system%contact, whole => form%whole)
      do k = 1, list%n
        if (list%routine(k) == routine_none .or. list%status(k) <= status_open) cycle
        nodes%touched(list%ix(:list%nel(k), k)) = .true.
      end do
      if (list%n > 0) then
        call describe_matrix(whole%solver, whole%matrix, whole%bulk_matrix, system%equation, &
          nodes, form%costs)
      else if (nodes%apart) then
        call describe_matrix(whole%solver, none, whole%bulk_matrix, system%equation, nodes, &
          form%costs)
      else
        call describe_matrix(whole%solver, whole%bulk_matrix, whole%bulk_matrix, &
          system%equation, nodes, form%costs)
      end if
    end associate
    if (nodes%apart) call give_bulk(system%equation, form%whole)
  end subroutine describe_tangent

  !> Solves for nodes and rigid bodies with the last factor.
  subroutine solve_bordered(system, form, b, x, outcome)
    type(system_t), intent(in) :: system !! factor, border
    type(form_t), intent(inout) :: form !! gets border, matrix
    real(wp), intent(in) :: b(:) !! (equations+n) right-hand side
    real(wp), intent(inout) :: x(:) !! (equations+n) solution
    integer, intent(out) :: outcome !! one of the outcomes
    real(wp) :: rest(system%tools%unknowns, 1)
    real(wp), allocatable :: part(:), answer(:)
    integer :: info

    outcome = solver_done
    associate (border => form%border, n => system%equations, m => system%tools%unknowns)
      part = b(:n)
      answer = x(:n)
      if (n > 0 .or. m == 0) call solve_system(form%whole%solver, form%whole%csc, part, answer, &
        form%costs, outcome)
      x(:n) = answer
      if (m == 0 .or. outcome /= solver_done) return
      rest(:, 1) = b(n + 1:) - matmul(answer, border%rows)
      call dgetrs('N', m, 1, border%corner, m, border%pivot, rest, m, info)
      x(n + 1:) = rest(:, 1)
      x(:n) = answer - matmul(border%answers, rest(:, 1))
      if (.not. all(abs(rest) <= huge(1.0_wp))) outcome = solver_singular
    end associate
  end subroutine solve_bordered
end module rigid_border

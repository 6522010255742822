!> The rigid motions of the bodies of a condensed system that contact holds (doc/theory, "Condensed
!! floating bodies", eqs. (12.11), (12.12)).
module condensed_motions
  use kinds, only: wp
  use text, only: to_text
  use rigid_motions, only: choose_fixings, mode_row
  use condensed_types, only: condensed_t, condensed_body_t
  use block_matrix, only: find_block
  use costs, only: cost_t
  use condensation, only: solve_body
  use system_types, only: form_t, system_t
  use system_parts, only: bodies_t
  implicit none
  private
  public :: fix_body, fixing_stiffness, find_ways, push_bodies, place_modes, add_motion, &
    add_motion_inside, find_imbalance, sum_forces, push_live, in_lengths, add_live_motion, &
    lost_digits, set_center

  !> Compliances of a body that contact alone holds may differ by this factor: the digits that it
  !! costs are missing where the body touches.
  real(wp), parameter :: most_slender = 1.0e5_wp

contains

  !> The rigid motions that the supports leave a body, and the fixings that stop them.
  subroutine fix_body(system, condensed, b)
    type(system_t), intent(in) :: system !! the problem
    type(condensed_t), intent(inout) :: condensed !! gets motions and fixings of a body of condensed
    integer, intent(in) :: b !! the body

    associate (body => condensed%bodies(b))
      if (allocated(body%fixing_node)) return
      body%motions = system%body%motions(b)
      allocate (body%fixing_node(0), body%fixing_direction(0))
      if (body%motions%n == 0) return
      call choose_fixings(condensed%rigid%x, system%equation, system%body%node_body, b, &
        body%motions, body%fixing_node, body%fixing_direction)
    end associate
  end subroutine fix_body

  !> Why the condensed form would lack digits where a body that contact alone holds touches: its
  !! compliances differ too much. Empty if they do not.
  function lost_digits(condensed) result(why)
    type(condensed_t), intent(in) :: condensed !! bodies with their compliances
    character(:), allocatable :: why
    real(wp) :: slenderness
    integer :: b

    slenderness = 1.0_wp
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%motions%n == 0 .or. body%m == 0) cycle
        slenderness = max(slenderness, maxval(body%diagonal)/max(minval(body%diagonal), &
          tiny(1.0_wp)))
      end associate
    end do
    why = ''
    if (slenderness > most_slender) why = 'it would cost digits: a body that contact alone '// &
      'holds is '//to_text(slenderness, 2)//' times softer in one place than in another'
  end function lost_digits

  !> Stiffness of the springs at the fixings of a body.
  pure function fixing_stiffness(form, b) result(spring)
    type(form_t), intent(in) :: form !! the matrix that was condensed
    integer, intent(in) :: b !! the body
    real(wp) :: spring(form%condensed%bodies(b)%motions%n)
    integer :: k

    associate (body => form%condensed%bodies(b), blocks => form%whole%bulk_matrix)
      do k = 1, size(spring)
        spring(k) = blocks%val(body%fixing_direction(k), body%fixing_direction(k), &
          find_block(blocks, body%fixing_node(k), body%fixing_node(k)))
      end do
    end associate
  end function fixing_stiffness

  !> Motions of a body that springs hold, eq. (7.21): what a unit at each fixing makes of it, the
  !! work of the loads on that, and what resists it.
  subroutine find_ways(form, b, first, force, costs, outcome)
    type(form_t), intent(inout) :: form !! factor of the body; gets its ways, pushes, spring
    integer, intent(in) :: b !! the body
    integer, intent(in) :: first !! motions of the bodies before
    real(wp), intent(in) :: force(:, :, :) !! (3, nodes, loads) of a unit of each [force]
    type(cost_t), intent(inout) :: costs !! cost table
    integer, intent(out) :: outcome !! as in back_ends
    real(wp), allocatable :: unit(:, :, :)
    real(wp) :: stiffness(form%condensed%bodies(b)%motions%n)
    integer :: k, l

    associate (body => form%condensed%bodies(b), rigid => form%condensed%rigid, &
      n => form%condensed%bodies(b)%motions%n, pushes => form%condensed%outer%pushes)
      allocate (unit(3, size(force, 2), n), source=0.0_wp)
      stiffness = fixing_stiffness(form, b)
      do k = 1, n
        unit(body%fixing_direction(k), body%fixing_node(k), k) = stiffness(k)
      end do
      if (.not. allocated(body%ways)) allocate (body%ways, mold=unit)
      body%ways = 0.0_wp
      call solve_body(body, unit, body%ways, costs, outcome)
      do k = 1, n
        pushes(first + k, :) = [(sum(body%ways(:, :, k)*force(:, :, l)), l=1, size(force, 3))]
        do l = 1, n
          rigid%spring(first + l, first + k) = merge(stiffness(k), 0.0_wp, k == l) - stiffness(l) &
            *body%ways(body%fixing_direction(l), body%fixing_node(l), k)
        end do
      end do
    end associate
  end subroutine find_ways

  !> Work of nodal forces on the rigid motions that supports leave.
  pure subroutine push_bodies(body, condensed, force, push)
    type(bodies_t), intent(in) :: body !! bodies of condensed
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(in) :: force(:, :) !! (3, nodes) zero where prescribed [force]
    real(wp), intent(out) :: push(:) !! (modes) [force]
    integer :: i, k, b, first(body%bodies)

    push = 0.0_wp
    first = [(sum(body%motions(:b - 1)%n), b=1, body%bodies)]
    do i = 1, size(body%node_body)
      b = body%node_body(i)
      if (b == 0) cycle
      if (body%motions(b)%n == 0) cycle
      do k = 1, 3
        if (abs(force(k, i)) <= 0.0_wp) cycle
        associate (mine => push(first(b) + 1:first(b) + body%motions(b)%n))
          mine = mine + force(k, i)*mode_row(body%motions(b), k, condensed%rigid%x(:, i))
        end associate
      end do
    end do
  end subroutine push_bodies

  !> What each motion of a body does to a node: rigid, or with what springs do to the body then.
  pure function way_at(condensed, body, k, node) result(way)
    type(condensed_t), intent(in) :: condensed !! reference positions
    type(condensed_body_t), intent(in) :: body !! one of its bodies
    integer, intent(in) :: k !! 1, 2 or 3
    integer, intent(in) :: node !! the node
    real(wp) :: way(body%motions%n)

    if (allocated(body%ways)) then
      way = body%ways(k, node, :)
    else
      way = mode_row(body%motions, k, condensed%rigid%x(:, node))
    end if
  end function way_at

  !> What the rigid motions of each body do to its candidates.
  pure subroutine place_modes(condensed)
    type(condensed_t), intent(inout) :: condensed !! candidates numbered; gets modes
    integer :: b, i

    condensed%rigid%modes = 0
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        body%first_mode = condensed%rigid%modes
        condensed%rigid%modes = condensed%rigid%modes + body%motions%n
        if (body%motions%n == 0) cycle
        body%modes = reshape([real(wp) ::], [body%m, body%motions%n], [0.0_wp])
        do i = 1, body%m
          associate (n => body%first + i)
            body%modes(i, :) = way_at(condensed, body, condensed%direction(n), condensed%node(n))
          end associate
        end do
      end associate
    end do
    if (.not. allocated(condensed%rigid%alpha)) then
      allocate (condensed%rigid%alpha(condensed%rigid%modes), &
        condensed%rigid%alpha_change(condensed%rigid%modes), &
        condensed%rigid%imbalance(condensed%rigid%modes), &
        condensed%rigid%imbalance_change(condensed%rigid%modes), source=0.0_wp)
    end if
  end subroutine place_modes

  !> Adds rigid motions of the bodies to displacements of the candidates.
  pure subroutine add_motion(condensed, alpha, u)
    type(condensed_t), intent(in) :: condensed !! modes of its bodies
    real(wp), intent(in) :: alpha(:) !! (modes) [length]
    real(wp), intent(inout) :: u(:) !! (n) [length]
    integer :: b

    if (condensed%rigid%modes == 0) return
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%motions%n == 0) cycle
        associate (mine => u(body%first + 1:body%first + body%m))
          mine = mine + matmul(body%modes, alpha(body%first_mode + 1:body%first_mode &
            + body%motions%n))
        end associate
      end associate
    end do
  end subroutine add_motion

  !> What contact forces and loads do to the rigid motions: zero in equilibrium.
  pure subroutine find_imbalance(condensed)
    type(condensed_t), intent(inout) :: condensed !! force and factors given; gets imbalance

    if (condensed%rigid%modes == 0) return
    call sum_forces(condensed, condensed%bulk%force, condensed%rigid%imbalance)
    condensed%rigid%imbalance = condensed%rigid%imbalance - matmul(condensed%outer%pushes, &
      condensed%outer%factors)
    if (allocated(condensed%rigid%spring)) condensed%rigid%imbalance = condensed%rigid%imbalance &
      + matmul(condensed%rigid%spring, condensed%rigid%alpha)
    if (condensed%rigid%damping > 0.0_wp) condensed%rigid%imbalance = condensed%rigid%imbalance &
      + condensed%rigid%damping*(condensed%rigid%alpha - condensed%rigid%center)
  end subroutine find_imbalance

  !> Measures damping on the rigid motions from where they are: it has no force there.
  pure subroutine set_center(condensed, damping)
    type(condensed_t), intent(inout) :: condensed !! gets damping, center; imbalance follows
    real(wp), intent(in) :: damping !! 0: none [force/length]

    associate (rigid => condensed%rigid)
      if (rigid%modes == 0) return
      if (rigid%damping > 0.0_wp) rigid%imbalance = rigid%imbalance - rigid%damping*(rigid%alpha &
        - rigid%center)
      rigid%damping = damping
      rigid%center = rigid%alpha
    end associate
  end subroutine set_center

  !> Work of forces at the candidates on the rigid motions.
  pure subroutine sum_forces(condensed, force, push)
    type(condensed_t), intent(in) :: condensed !! modes of its bodies
    real(wp), intent(in) :: force(:) !! (n) [force]
    real(wp), intent(out) :: push(:) !! (modes) [force]
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b))
        if (body%motions%n == 0) cycle
        push(body%first_mode + 1:body%first_mode + body%motions%n) = &
          matmul(force(body%first + 1:body%first + body%m), body%modes)
      end associate
    end do
  end subroutine sum_forces

  !> Adds rigid motions of the bodies to the displacements of all nodes.
  pure subroutine add_motion_inside(system, condensed, alpha, u)
    type(system_t), intent(in) :: system !! bodies of condensed
    type(condensed_t), intent(in) :: condensed !! what the condensed form keeps
    real(wp), intent(in) :: alpha(:) !! (modes) [length]
    real(wp), intent(inout) :: u(:, :) !! (3, nodes) [length]
    integer :: i, k

    if (condensed%rigid%modes == 0) return

    do i = 1, size(system%body%node_body)
      if (system%body%node_body(i) == 0) cycle
      associate (body => condensed%bodies(system%body%node_body(i)))
        if (body%motions%n == 0) cycle
        associate (mine => alpha(body%first_mode + 1:body%first_mode + body%motions%n))
          do k = 1, 3
            u(k, i) = u(k, i) + dot_product(way_at(condensed, body, k, i), mine)
          end do
        end associate
      end associate
    end do
  end subroutine add_motion_inside

  !> What forces at the live candidates do to the rigid motions, in the unit of displacements.
  pure subroutine push_live(condensed, force, push)
    type(condensed_t), intent(in) :: condensed !! live candidates, motions
    real(wp), intent(in) :: force(:) !! (live) [force]
    real(wp), intent(out) :: push(:) !! (modes) [length]
    integer :: b, i

    push = 0.0_wp
    if (condensed%rigid%modes == 0) return
    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), mine => push(condensed%bodies(b)%first_mode + 1: &
        condensed%bodies(b)%first_mode + condensed%bodies(b)%motions%n))
        if (body%motions%n == 0) cycle
        do i = 1, body%n_live
          mine = mine + force(body%first_live + i)*body%modes(body%gathered(i), :)
        end do
      end associate
    end do
    push = in_lengths(condensed, push)
  end subroutine push_live

  !> Forces on the rigid motions times the compliance of their bodies.
  pure function in_lengths(condensed, push) result(way)
    type(condensed_t), intent(in) :: condensed !! bodies
    real(wp), intent(in) :: push(:) !! (modes) [force]
    real(wp) :: way(size(push))
    integer :: b

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), first => condensed%bodies(b)%first_mode + 1, &
        last => condensed%bodies(b)%first_mode + condensed%bodies(b)%motions%n)
        way(first:last) = body%softness*push(first:last)
      end associate
    end do
  end function in_lengths

  !> Adds rigid motions of the bodies to displacements of the live candidates.
  pure subroutine add_live_motion(condensed, alpha, t)
    type(condensed_t), intent(in) :: condensed !! modes of its bodies, live candidates
    real(wp), intent(in) :: alpha(:) !! (modes) [length]
    real(wp), intent(inout) :: t(:) !! (live) [length]
    integer :: b, i

    do b = 1, size(condensed%bodies)
      associate (body => condensed%bodies(b), mine => alpha(condensed%bodies(b)%first_mode + 1: &
        condensed%bodies(b)%first_mode + condensed%bodies(b)%motions%n))
        if (body%motions%n == 0) cycle
        do i = 1, body%n_live
          t(body%first_live + i) = t(body%first_live + i) &
            + dot_product(body%modes(body%gathered(i), :), mine)
        end do
      end associate
    end do
  end subroutine add_live_motion
end module condensed_motions

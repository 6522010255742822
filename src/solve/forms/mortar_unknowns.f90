!> The multipliers of all pairs as unknowns: their rows, gaps and laws, one pair after the other
!! (doc/theory, "Mortar contact").
module mortar_unknowns
  use kinds, only: wp
  use exact_touch, only: round_off
  use model_types, only: model_t
  use mortar_types, only: turned_way
  use mortar_cone, only: cone_of_node_t
  use system_types, only: system_t
  implicit none
  private
  public :: mortar_rows_t, mortar_system_t, join_rows, find_gaps, take_cones, local_forces, across

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
    real(wp) :: length = 0.0_wp !! largest coordinate that gaps are of [length]
    real(wp), allocatable :: near(:) !! (3 n) the same where the increment begins, if motions are
    !! free [length]
    real(wp), allocatable :: compliance(:, :) !! (3 n, 3 n) G, what they are by a force
    !! [length/force]
    real(wp), allocatable :: stiff(:) !! (n) compliance along supported axes, 0 for none
    real(wp), allocatable :: motion(:, :) !! (3 n, modes) by rigid motions: those of bodies that
    !! deform, then those of rigid bodies with a point
    real(wp), allocatable :: push(:, :) !! (3 n, modes) work of the forces on these
    real(wp), allocatable :: load(:) !! (modes) that of the loads [force]
    real(wp), allocatable :: hold(:, :) !! (modes, modes) what springs and stress do against them
    !! [force/length]
    type(cone_of_node_t), allocatable :: cone(:) !! (n) laws
    real(wp), allocatable :: penalty(:) !! (n) compliance of a penalty, 0 for none [length/force]
  end type mortar_system_t

contains

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

  !> Slip and gap of all multipliers with the nodes at x, eqs. (7.13), (7.15). Rows add up to zero:
  !! places are seen from the slave node, which saves digits. A gap that the places do not know is
  !! none, whatever its sign, as in eq. (10.4).
  pure subroutine find_gaps(model, system, x, unknowns)
    type(model_t), intent(in) :: model !! pairs with their multipliers
    type(system_t), intent(in) :: system !! where slip counts from
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    type(mortar_system_t), intent(inout) :: unknowns !! rows given; gets gap
    real(wp) :: slip(3), gap(3), way(3)
    integer :: i, k, m, e

    unknowns%gap = spread(0.0_wp, 1, 3*unknowns%n)
    unknowns%length = maxval(abs(x))
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
          if (abs(unknowns%gap(3*i)) <= round_off(x(:, rows%column(rows%first(i):rows%first(i + 1) &
            - 1)), x(:, node))) unknowns%gap(3*i) = 0.0_wp
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
end module mortar_unknowns

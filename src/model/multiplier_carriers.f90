!> Which slave nodes have multipliers (MORTar), and which hand their dual functions to another node
!! since supports hold them (doc/theory, "Mortar contact", eq. (7.23)).
module multiplier_carriers
  use kinds, only: wp
  use text, only: count_noun
  use diagnostics, only: diagnostics_t, report_error, report_warning
  use contact_types, only: pair_t
  use contact_points, only: longest_facet
  use facet_geometry, only: corners, facet_normal
  use mortar_functions, only: corners_of_parts
  use slave_places, only: is_bent, slave_nodes
  use model_types, only: model_t
  implicit none
  private
  public :: find_carriers

  !> A support acts along the normal of a facet if it has at least this part there: those of planes
  !! of symmetry have none.
  real(wp), parameter :: along_normal = 0.5_wp
  !> Nodes in one plane, over the longest facet: meshes from files have seven digits.
  real(wp), parameter :: in_plane = 1.0e-4_wp
  !> Edges from a node at a rim that is held to one that gives way: a corner has two. Farther ones
  !! lie inside of what is held.
  integer, parameter :: at_rim = 2

contains

  !> The carriers of all slave nodes of the pairs with multipliers.
  subroutine find_carriers(model, diagnostics)
    type(model_t), intent(inout) :: model !! pairs get carriers
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    logical :: still(3, model%mesh%nodes)
    integer :: k

    if (.not. any(model%pairs%mortar)) return
    still = model%conditions%restrained .and. .not. moved_dofs(model)
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        if (.not. pair%mortar .or. .not. allocated(pair%points%slave_facets)) cycle
        call find_pair(model%mesh%x, model%conditions%restrained, still, pair, diagnostics)
      end associate
    end do
  end subroutine find_carriers

  !> Degrees of freedom that DISPlacement moves, or a rigid body that moves.
  pure function moved_dofs(model) result(moved)
    type(model_t), intent(in) :: model !! loads, rigid bodies
    logical :: moved(3, model%mesh%nodes)
    logical :: moves(6)
    integer :: i, k

    moved = .false.
    do i = 1, size(model%conditions%loads)
      associate (given => model%conditions%loads(i)%displacement)
        do k = 1, given%n
          if (abs(given%value(k)) > 0.0_wp) moved(given%dof(k), given%node(k)) = .true.
        end do
      end associate
    end do
    do i = 1, size(model%conditions%rigid)
      associate (body => model%conditions%rigid(i))
        moves = body%free
        do k = 1, size(body%motions)
          moves = moves .or. abs(body%motions(k)%value) > 0.0_wp
        end do
        do k = 1, 3
          moved(k, body%nodes) = moves(k) .or. any(moves(4:6))
        end do
      end associate
    end do
  end function moved_dofs

  !> The carriers of one pair: of each node that gives way itself, of the others the nearest such
  !! node.
  subroutine find_pair(x, held, still, pair, diagnostics)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(in) :: held(:, :) !! (3, nodes) prescribed
    logical, intent(in) :: still(:, :) !! (3, nodes) prescribed, and never moved
    type(pair_t), intent(inout) :: pair !! gets carrier
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors
    integer :: part(3, 4*size(pair%points%slave_facets, 2)), ring(size(x, 2)), parts, k
    logical, dimension(size(x, 2)) :: slave, pressed, rubbed

    call split_facets(pair, part, parts)
    call find_held(x, held, part(:, :parts), slave, pressed)
    rubbed = .false.
    if (any(pair%friction%mu > 0.0_wp)) call find_rubbed(pair, x, held, still, slave, rubbed)
    rubbed = rubbed .and. .not. pressed
    call find_nearest(x, part(:, :parts), slave .and. .not. (pressed .or. rubbed), pair%carrier, &
      ring)
    call tell(pair, count(pressed .and. ring < 0), count(rubbed .and. ring < 0), count(pressed &
      .and. ring > at_rim), diagnostics)
    where (pair%carrier == 0) pair%carrier = [(k, k=1, size(ring))]
  end subroutine find_pair

  !> Says what supports leave of the slave that multipliers cannot do there.
  subroutine tell(pair, pressed, rubbed, far, diagnostics)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: pressed !! nodes that are held along the normal, without a carrier
    integer, intent(in) :: rubbed !! the same across it
    integer, intent(in) :: far !! nodes that are held along the normal far from their carriers
    type(diagnostics_t), intent(inout) :: diagnostics !! the deck's errors

    if (pressed > 0) then
      call report_error(diagnostics, pair%slave_at, 'the slave '''//pair%slave//''' does not '// &
        'deform: '//count_noun(pressed, 'node')//' held along the normal by supports or '// &
        'DISPlacement, and none beside that gives way: multipliers there would be more than '// &
        'the master can follow', 'exchange slave and master, leave what is held out of the '// &
        'slave, or write GTOS')
    else if (rubbed > 0) then
      call report_error(diagnostics, pair%slave_at, 'the slave '''//pair%slave//''' does not '// &
        'deform along an axis that the master may go: '//count_noun(rubbed, 'node')//' held '// &
        'there, and none beside that gives way: nothing would rub along it', 'exchange slave '// &
        'and master, hold the master along that axis, too, or write GTOS')
    else if (far > 0) then
      call report_warning(diagnostics, pair%slave_at, 'pair '//pair%name//': '// &
        count_noun(far, 'slave node')//' held along the normal far from any that gives way: '// &
        'the pressure there is carried on average; exchange slave and master to see where it is')
    end if
  end subroutine tell

  !> The facets of the slave, those of six nodes in four parts.
  pure subroutine split_facets(pair, part, parts)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(out) :: part(:, :) !! (3, parts or more) corners of each
    integer, intent(out) :: parts !! how many
    integer :: f, k

    parts = 0
    do f = 1, size(pair%points%slave_facets, 2)
      associate (nodes => slave_nodes(pair, f))
        if (is_bent(pair, f)) then
          do k = 1, size(corners_of_parts, 2)
            part(:, parts + k) = nodes(corners_of_parts(:, k))
          end do
          parts = parts + size(corners_of_parts, 2)
        else
          parts = parts + 1
          part(:, parts) = nodes(:3)
        end if
      end associate
    end do
  end subroutine split_facets

  !> Nodes of the slave, and those of them that supports hold along a normal there.
  pure subroutine find_held(x, held, part, slave, pressed)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(in) :: held(:, :) !! (3, nodes) prescribed
    integer, intent(in) :: part(:, :) !! (3, parts) of the slave facets
    logical, intent(out) :: slave(:), pressed(:) !! (nodes)
    real(wp) :: normal(3)
    integer :: f, k

    slave = .false.
    pressed = .false.
    do f = 1, size(part, 2)
      normal = facet_normal(corners(x, part(:, f)))
      slave(part(:, f)) = .true.
      do k = 1, 3
        if (any(held(:, part(k, f)) .and. abs(normal) > along_normal)) pressed(part(k, f)) = .true.
      end do
    end do
  end subroutine find_held

  !> Slave nodes that supports hold along an axis along which the master under them may go: friction
  !! would lack their share. On a plane of symmetry both are held, and a master that is held
  !! everywhere is held under each node.
  pure subroutine find_rubbed(pair, x, held, still, slave, rubbed)
    type(pair_t), intent(in) :: pair !! its master
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    logical, intent(in) :: held(:, :) !! (3, nodes) prescribed
    logical, intent(in) :: still(:, :) !! (3, nodes) prescribed, and never moved
    logical, intent(in) :: slave(:) !! (nodes) of the slave
    logical, intent(inout) :: rubbed(:) !! (nodes) become true
    logical :: master(size(x, 2))
    real(wp), allocatable :: plane(:)
    real(wp) :: apart
    integer :: i, k

    master = .false.
    do i = 1, size(pair%surface%facets, 2)
      master(pair%surface%facets(:, i)) = .true.
    end do
    apart = in_plane*longest_facet(pair, x)
    do k = 1, 3
      if (all(still(k, :) .or. .not. master)) then
        rubbed = rubbed .or. (slave .and. held(k, :) .and. .not. still(k, :))
        cycle
      end if
      plane = pack(x(k, :), master .and. still(k, :))
      do i = 1, size(slave)
        if (.not. slave(i) .or. .not. held(k, i)) cycle
        rubbed(i) = rubbed(i) .or. .not. still(k, i) .or. all(abs(plane - x(k, i)) > apart)
      end do
    end do
  end subroutine find_rubbed

  !> Edge by edge from the nodes that give way: each of the others has the nearest of the carriers
  !! that its neighbours have.
  pure subroutine find_nearest(x, part, gives, carrier, ring)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    integer, intent(in) :: part(:, :) !! (3, parts) of the slave facets
    logical, intent(in) :: gives(:) !! (nodes) of the slave that give way
    integer, allocatable, intent(out) :: carrier(:) !! (nodes) 0: there is none
    integer, intent(out) :: ring(:) !! (nodes) edges to it, -1: there is none
    integer :: r, f, k, l
    logical :: better

    ring = merge(0, -1, gives)
    carrier = merge([(k, k=1, size(gives))], 0, gives)
    r = 0
    do while (any(ring == r))
      do f = 1, size(part, 2)
        do k = 1, 3
          do l = 1, 3
            associate (own => part(k, f), next => part(l, f))
              if (ring(next) /= r .or. (ring(own) >= 0 .and. ring(own) <= r)) cycle
              better = ring(own) < 0
              if (.not. better) better = norm2(x(:, carrier(next)) - x(:, own)) &
                < norm2(x(:, carrier(own)) - x(:, own))
              if (better) carrier(own) = carrier(next)
              ring(own) = r + 1
            end associate
          end do
        end do
      end do
      r = r + 1
    end do
  end subroutine find_nearest
end module multiplier_carriers

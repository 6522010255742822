!> Resultants of sets of supports by virtual work: from forces and prescribed values alone
!! (doc/theory, "Sensitivities along the path", eq. (14.5)).
module lever_sums
  use kinds, only: wp
  use model_types, only: model_t, load_t
  implicit none
  private
  public :: levers_t, supported_nodes, contact_nodes, loaded_nodes, sum_by_levers

  !> How supports answer to forces.
  type :: levers_t
    real(wp), allocatable :: u(:, :, :, :) !! (3, nodes, 3, sets) displacements for a unit motion of
    !! the set
    real(wp), allocatable :: hold(:, :, :, :) !! (3, nodes, 3, sets) what it takes at the supports;
    !! zero at free directions
    integer, allocatable :: supports(:) !! nodes with a direction that is prescribed
    integer, allocatable :: loaded(:) !! nodes that contact or a load may load
  end type levers_t

contains

  !> Nodes with a direction that is prescribed.
  pure function supported_nodes(equation) result(nodes)
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where it is
    integer, allocatable :: nodes(:)
    integer :: i

    nodes = pack([(i, i=1, size(equation, 2))], any(equation == 0, 1))
  end function supported_nodes

  !> Nodes that contact may load.
  pure function contact_nodes(model) result(nodes)
    type(model_t), intent(in) :: model !! pairs
    integer, allocatable :: nodes(:)
    logical :: touched(model%mesh%nodes)
    integer :: k

    touched = .false.
    do k = 1, size(model%pairs)
      associate (pair => model%pairs(k))
        touched(reshape(pair%surface%facets, [size(pair%surface%facets)])) = .true.
        if (allocated(pair%points%point_nodes)) touched(reshape(pair%points%point_nodes, &
          [size(pair%points%point_nodes)])) = .true.
        if (allocated(pair%points%slave_facets)) touched(reshape(pair%points%slave_facets, &
          [size(pair%points%slave_facets)])) = .true.
        if (allocated(pair%surface%middles)) touched(pack(pair%surface%middles, &
          pair%surface%middles > 0)) = .true.
      end associate
    end do
    nodes = pack([(k, k=1, size(touched))], touched)
  end function contact_nodes

  !> Nodes that contact or a load may load.
  pure function loaded_nodes(model, others) result(nodes)
    type(model_t), intent(in) :: model !! pairs, loads
    type(load_t), intent(in) :: others(:) !! more loads
    integer, allocatable :: nodes(:)
    logical :: loaded(model%mesh%nodes)
    integer :: k

    loaded = .false.
    loaded(contact_nodes(model)) = .true.
    do k = 1, size(model%conditions%loads)
      associate (force => model%conditions%loads(k)%force)
        if (force%n > 0) loaded(force%node(:force%n)) = .true.
      end associate
    end do
    do k = 1, size(others)
      associate (force => others(k)%force)
        if (force%n > 0) loaded(force%node(:force%n)) = .true.
      end associate
    end do
    nodes = pack([(k, k=1, size(loaded))], loaded)
  end function loaded_nodes

  !> Resultants from forces and from prescribed values.
  pure subroutine sum_by_levers(equation, levers, force, given, reaction)
    integer, intent(in) :: equation(:, :) !! (3, nodes) 0 where a direction is prescribed
    type(levers_t), intent(in) :: levers !! of the sets
    real(wp), intent(in) :: force(:, :) !! (3, nodes) where there may be some [force]
    real(wp), intent(in) :: given(:, :) !! (3, nodes) prescribed values at supports [length]
    real(wp), intent(out) :: reaction(:, :) !! (3, sets) [force]
    integer :: i, j, k, m
    real(wp) :: by_forces, by_ways

    do i = 1, size(reaction, 2)
      do k = 1, 3
        by_forces = 0.0_wp
        do j = 1, size(levers%loaded)
          do m = 1, 3
            by_forces = by_forces + levers%u(m, levers%loaded(j), k, i)*force(m, levers%loaded(j))
          end do
        end do
        by_ways = 0.0_wp
        do j = 1, size(levers%supports)
          do m = 1, 3
            if (equation(m, levers%supports(j)) == 0) by_ways = by_ways &
              + levers%hold(m, levers%supports(j), k, i)*given(m, levers%supports(j))
          end do
        end do
        reaction(k, i) = by_forces + by_ways
      end do
    end do
  end subroutine sum_by_levers
end module lever_sums

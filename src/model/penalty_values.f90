!> Penalty parameters and tributary areas of the slave nodes of a pair (doc/theory, "Penalty").
!!
!! AUTO with a factor takes on each side the mean cell size h = (6 V)^(1/3) and the smallest Young's
!! modulus E of the elastic elements next to the pair, and the softer side's E/h; a node gets
!! factor E/h A with its tributary area A, or with A = h^2 where no facet lies in the slave set.
!! AUTO alone takes the stiffness of the layer of elements that is pressed, at each point.
module penalty_values
  use kinds, only: wp
  use contact_types, only: pair_t, penalty_nodal, penalty_area, penalty_own
  use contact_points, only: count_points
  use contact_parameters, only: has_field, field_penalty
  use model_types, only: model_t
  use cell_geometry, only: cell_volume
  use pressed_layers, only: pressed_stiffness
  implicit none
  private
  public :: set_penalties

  !> Stiffness of one side of a pair.
  type :: side_t
    integer :: elements = 0 !! elastic elements next to the pair, 0 if the side is rigid
    real(wp) :: modulus = 0.0_wp !! smallest Young's modulus
    real(wp) :: h = 0.0_wp !! mean cell size [length]
  end type side_t

contains

  !> Fills pair%epsilon from pair%area; a pair with a field of multipliers gets the penalty that
  !! suits it. `found` is false where AUTO meets two rigid sides.
  subroutine set_penalties(model, pair, found)
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(inout) :: pair !! the pair
    logical, intent(out) :: found !! the penalties are known
    logical, allocatable :: behind_slave(:), behind_master(:)
    real(wp), allocatable :: unit(:), layer(:)
    type(side_t) :: side

    found = .true.
    behind_slave = slave_elements(model, pair)
    behind_master = master_elements(model, pair)
    side = softer_side(side_of(model, behind_slave), side_of(model, behind_master))
    if (side%elements > 0) unit = unit_penalties(pair, side)
    select case (pair%penalty_kind)
    case (penalty_nodal)
      allocate (pair%points%epsilon(count_points(pair)), source=pair%penalty)
    case (penalty_area)
      pair%points%epsilon = pair%penalty*pair%points%area
      found = all(pair%points%area > 0.0_wp)
    case default
      found = side%elements > 0
      if (.not. found) return
      layer = unit
      if (pair%penalty_kind == penalty_own) layer = areas(pair, side)* &
        pressed_stiffness(model, pair, behind_slave, behind_master)
      pair%points%epsilon = pair%penalty*layer
    end select
    if (side%elements == 0 .or. size(pair%points%epsilon) == 0 .or. side%modulus <= 0.0_wp) return
    if (has_field(pair)) pair%points%epsilon = field_penalty*unit
    pair%points%relative = maxval(pair%points%epsilon)/maxval(unit)
    pair%points%cell = side%h
  end subroutine set_penalties

  !> E/h A of each point.
  pure function unit_penalties(pair, side) result(epsilon)
    type(pair_t), intent(in) :: pair !! the pair
    type(side_t), intent(in) :: side !! its softer side, an elastic one
    real(wp) :: epsilon(size(pair%points%area))

    epsilon = (side%modulus/side%h)*areas(pair, side)
  end function unit_penalties

  !> A of each point, h^2 where it has none.
  pure function areas(pair, side) result(area)
    type(pair_t), intent(in) :: pair !! the pair
    type(side_t), intent(in) :: side !! its softer side, an elastic one
    real(wp) :: area(size(pair%points%area))

    area = merge(pair%points%area, side%h**2, pair%points%area > 0.0_wp)
  end function areas

  !> The side with the smaller E/h; a rigid side is ignored.
  pure function softer_side(a, b) result(side)
    type(side_t), intent(in) :: a !! one side
    type(side_t), intent(in) :: b !! the other side
    type(side_t) :: side

    side = a
    if (a%elements == 0) side = b
    if (a%elements == 0 .or. b%elements == 0) return
    if (b%modulus/b%h < a%modulus/a%h) side = b
  end function softer_side

  !> The elements that hold a slave node.
  function slave_elements(model, pair) result(near)
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(in) :: pair !! the pair
    logical, allocatable :: is_slave(:), near(:)
    integer :: e, k, p

    allocate (is_slave(model%mesh%nodes), source=.false.)
    allocate (near(model%mesh%elements), source=.false.)
    do p = 1, count_points(pair)
      is_slave(pair%points%point_nodes(:, p)) = .true.
    end do
    do e = 1, model%mesh%elements
      do k = 1, size(model%mesh%ix, 1)
        if (model%mesh%ix(k, e) == 0) exit
        if (is_slave(model%mesh%ix(k, e))) near(e) = .true.
      end do
    end do
  end function slave_elements

  !> The elements behind the master facets.
  function master_elements(model, pair) result(near)
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(in) :: pair !! the pair
    logical, allocatable :: near(:)

    allocate (near(model%mesh%elements), source=.false.)
    near(pack(pair%surface%facet_elements, pair%surface%facet_elements > 0)) = .true.
  end function master_elements

  !> Smallest modulus and mean cell size of the elastic elements among those marked.
  pure function side_of(model, near) result(side)
    type(model_t), intent(in) :: model !! mesh and materials
    logical, intent(in) :: near(:) !! (elements) next to the pair
    type(side_t) :: side
    real(wp) :: volume
    integer :: e

    do e = 1, size(near)
      if (.not. near(e) .or. model%element_material(e) == 0) cycle
      associate (material => model%materials(model%element_material(e)))
        if (material%rigid) cycle
        if (side%elements == 0) side%modulus = material%youngs_modulus
        side%modulus = min(side%modulus, material%youngs_modulus)
      end associate
      volume = abs(cell_volume(model%mesh%x, model%mesh%ix(:, e)))
      side%h = side%h + (6.0_wp*volume)**(1.0_wp/3.0_wp)
      side%elements = side%elements + 1
    end do
    if (side%elements > 0) side%h = side%h/real(side%elements, wp)
  end function side_of
end module penalty_values

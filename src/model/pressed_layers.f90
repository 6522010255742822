!> The stiffness of the layer of elements that a pair presses: what the penalty of AUTO is a
!! multiple of (doc/theory, "Penalty", eq. (7.1)).
module pressed_layers
  use kinds, only: wp
  use bodies, only: find_bodies
  use contact_types, only: pair_t
  use model_types, only: model_t, material_t
  use cell_geometry, only: cell_volume, cell_height
  use facet_geometry, only: facet_area
  implicit none
  private
  public :: pressed_stiffness

  !> Modulus of a layer that keeps its volume over E where it is as high as wide: that of a punch on
  !! a half-space, 1/(1 - nu^2), at nu = 1/2.
  real(wp), parameter :: least_confined = 4.0_wp/3.0_wp

  !> Elastic elements on one side of a pair.
  type :: layer_t
    real(wp) :: modulus = huge(1.0_wp) !! the smallest pressure over strain of a layer of them
    real(wp) :: height = 0.0_wp !! their mean least height, 0 for a rigid side [length]
    real(wp), allocatable :: heights(:) !! (nodes) the same of those around a node [length]
  end type layer_t

contains

  !> Force per length and area at each point: that of the softer side. On the slave's it is local,
  !! but for the cells of a segmented pair, which move.
  function pressed_stiffness(model, pair, behind_slave, behind_master) result(stiffness)
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(in) :: pair !! the pair
    logical, intent(in) :: behind_slave(:) !! (elements) elements that hold a slave node
    logical, intent(in) :: behind_master(:) !! (elements) elements behind a master facet
    real(wp) :: stiffness(size(pair%points%area))
    type(layer_t) :: slave, master
    integer :: p

    slave = layer_of(model, behind_slave, sum(pair%points%area)/real(pair%points%slots, wp))
    master = layer_of(model, behind_master, master_area(model, pair))
    if (slave%height <= 0.0_wp .or. (master%height > 0.0_wp .and. &
      master%modulus*slave%height < slave%modulus*master%height)) then
      stiffness = master%modulus/master%height
      return
    end if
    stiffness = slave%modulus/slave%height
    if (pair%segmented) return
    do p = 1, size(stiffness)
      associate (nodes => pair%points%point_nodes(:, p))
        stiffness(p) = slave%modulus*real(size(nodes), wp)/sum(slave%heights(nodes))
      end associate
    end do
  end function pressed_stiffness

  !> Area of the facets of the master that are faces of elements.
  pure real(wp) function master_area(model, pair) result(area)
    type(model_t), intent(in) :: model !! mesh
    type(pair_t), intent(in) :: pair !! the pair
    integer :: f

    area = 0.0_wp
    do f = 1, size(pair%surface%facets, 2)
      if (pair%surface%facet_elements(f) > 0) area = area + facet_area(model%mesh%x(:, &
        pair%surface%facets(:, f)))
    end do
  end function master_area

  !> Smallest modulus and heights of the elastic elements among those marked.
  function layer_of(model, near, area) result(layer)
    type(model_t), intent(in) :: model !! mesh and materials
    logical, intent(in) :: near(:) !! (elements) next to the pair
    real(wp), intent(in) :: area !! of the surface that is pressed [length^2]
    type(layer_t) :: layer
    real(wp) :: squareness, height
    integer :: count_of(model%mesh%nodes), e, k

    squareness = 0.0_wp
    if (any(model%materials%mean .or. model%materials%nodal)) squareness = shape_factor(model, &
      near, area)
    allocate (layer%heights(model%mesh%nodes), source=0.0_wp)
    count_of = 0
    do e = 1, size(near)
      if (.not. near(e) .or. model%element_material(e) == 0) cycle
      associate (material => model%materials(model%element_material(e)), ix => model%mesh%ix(:, e))
        if (material%rigid) cycle
        layer%modulus = min(layer%modulus, layer_modulus(material, squareness))
        height = cell_height(model%mesh%x, ix)
        do k = 1, size(ix)
          if (ix(k) == 0) exit
          layer%heights(ix(k)) = layer%heights(ix(k)) + height
          count_of(ix(k)) = count_of(ix(k)) + 1
        end do
      end associate
    end do
    if (any(count_of > 0)) layer%height = sum(layer%heights)/real(sum(count_of), wp)
    where (count_of > 0)
      layer%heights = layer%heights/real(count_of, wp)
    else where
      layer%heights = layer%height
    end where
  end function layer_of

  !> Pressure over strain of a layer whose material cannot go aside: the confined modulus. Elements
  !! that keep their volume as wholes, or by nodes, let it go aside as far as the layer's shape does
  !! (Gent's bonded layer), however incompressible it is.
  pure real(wp) function layer_modulus(material, squareness) result(modulus)
    type(material_t), intent(in) :: material !! of the layer
    real(wp), intent(in) :: squareness !! shape factor of the body
    real(wp) :: nu

    nu = material%poissons_ratio
    ! -1 and 1/2 are refused, in the same report as all else
    modulus = material%youngs_modulus*(1.0_wp - nu)/max((1.0_wp + nu)*(1.0_wp - 2.0_wp*nu), &
      epsilon(nu))
    if (material%mean .or. material%nodal) modulus = min(modulus, material%youngs_modulus &
      *(least_confined + 2.0_wp*squareness**2))
  end function layer_modulus

  !> Loaded over free surface of a square layer that has area and volume of the bodies pressed:
  !! sqrt(A)/(4 H) with the height H = V/A.
  function shape_factor(model, near, area) result(factor)
    type(model_t), intent(in) :: model !! mesh and materials
    logical, intent(in) :: near(:) !! (elements) next to the pair
    real(wp), intent(in) :: area !! of the surface that is pressed [length^2]
    real(wp) :: factor, volume
    integer, allocatable :: element_body(:), node_body(:)
    logical, allocatable :: pressed(:)
    integer :: e, n

    call find_bodies(model%mesh, element_body, node_body, n)
    allocate (pressed(0:n), source=.false.)
    pressed(pack(element_body, near)) = .true.
    pressed(0) = .false.
    volume = 0.0_wp
    do e = 1, size(near)
      if (pressed(element_body(e))) volume = volume &
        + abs(cell_volume(model%mesh%x, model%mesh%ix(:, e)))
    end do
    factor = 0.0_wp
    if (volume > 0.0_wp) factor = 0.25_wp*area*sqrt(area)/volume
  end function shape_factor
end module pressed_layers

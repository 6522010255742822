!> The stiffness of the layers of elements that a pair presses: what the penalty of AUTO is a
!! multiple of (doc/theory, "Penalty").
module pressed_layers
  use kinds, only: wp, pi
  use vectors, only: cross
  use bodies, only: find_bodies
  use contact_types, only: pair_t
  use model_types, only: model_t, material_t
  use tetrahedra, only: tetrahedron_volume
  use facet_geometry, only: facet_area, facet_normal
  implicit none
  private
  public :: pressed_stiffness, narrowness

  !> Modulus of a layer that keeps its volume over E where it is as high as wide: that of a punch on
  !! a half-space, 1/(1 - nu^2), at nu = 1/2.
  real(wp), parameter :: least_confined = 4.0_wp/3.0_wp

  !> Normals of a surface that is flat differ by no more than this [radian].
  real(wp), parameter :: flat = 1.0e-3_wp
  !> A flat joint, or a fit, has at least this share of the penalty of two bodies that touch in a
  !! point: far from edges it is a layer, whose stiffness does not fall with its area.
  real(wp), parameter :: least_narrow = 0.36_wp

contains

  !> What a pair needs of the penalty of two bodies that touch in a point or a line. Where two flat
  !! surfaces lie on each other the patch is known, and yields by its radius: a cell over that.
  pure real(wp) function narrowness(pair, x, h) result(share)
    type(pair_t), intent(in) :: pair !! the pair
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: h !! mean cell size of the softer side [length]
    real(wp) :: normal(3), other(3), area
    integer :: f
    logical :: flat_master, flat_slave

    share = 1.0_wp
    if (pair%shrinking%shrink >= 0) share = least_narrow ! a fit lies on all of its area
    if (pair%surface%round .or. pair%smooth .or. pair%shrinking%shrink >= 0) return
    area = 0.0_wp
    do f = 1, size(pair%surface%facets, 2)
      area = area + facet_area(x(:, pair%surface%facets(:, f)))
    end do
    area = min(area, sum(pair%points%area)/real(pair%points%slots, wp))
    if (area <= 0.0_wp) return
    call find_normal(pair%surface%facets, x, normal, flat_master)
    flat_slave = .false.
    if (allocated(pair%points%slave_facets)) then
      call find_normal(pair%points%slave_facets, x, other, flat_slave)
    else if (pair%points%n_slaves >= 3) then
      call find_normal(pair%points%point_nodes(1:3, :), x, other, flat_slave)
    end if
    if (.not. (flat_master .and. flat_slave)) return
    if (norm2(cross(normal, other)) > flat) return
    share = min(1.0_wp, max(least_narrow, h/sqrt(area/pi)))
  end function narrowness

  !> The normal of the first facet, and whether all have this one.
  pure subroutine find_normal(facets, x, normal, is_flat)
    integer, intent(in) :: facets(:, :) !! (3, facets) corners
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(out) :: normal(3) !! unit; 0 without a facet
    logical, intent(out) :: is_flat !! all have it
    integer :: f

    normal = 0.0_wp
    is_flat = size(facets, 2) > 0
    do f = 1, size(facets, 2)
      if (f == 1) normal = facet_normal(x(:, facets(:, f)))
      is_flat = norm2(cross(normal, facet_normal(x(:, facets(:, f))))) <= flat
      if (.not. is_flat) return
    end do
  end subroutine find_normal

  !> Force per length and area at each point: that of the elements behind the slave there, or of
  !! those behind the master in the mean, if these are softer. Cells of a segmented pair move, so
  !! all have that of the mean slave.
  function pressed_stiffness(model, pair, behind_slave, behind_master) result(stiffness)
    type(model_t), intent(in) :: model !! mesh and materials
    type(pair_t), intent(in) :: pair !! the pair
    logical, intent(in) :: behind_slave(:) !! (elements) elements that hold a slave node
    logical, intent(in) :: behind_master(:) !! (elements) elements behind a master facet
    real(wp) :: stiffness(size(pair%points%area))
    real(wp) :: of_nodes(model%mesh%nodes), of_master, here
    integer :: p, k

    stiffness = huge(1.0_wp)
    call find_stiffness(model, behind_slave, sum(pair%points%area)/real(pair%points%slots, wp), &
      of_nodes)
    do p = 1, size(stiffness)
      do k = 1, pair%points%n_slaves
        here = of_nodes(pair%points%point_nodes(k, p))
        if (here > 0.0_wp) stiffness(p) = min(stiffness(p), here)
      end do
    end do
    if (pair%segmented) stiffness = mean(of_nodes)
    call find_stiffness(model, behind_master, master_area(model, pair), of_nodes)
    of_master = mean(of_nodes)
    stiffness = min(stiffness, of_master)
  end function pressed_stiffness

  !> Mean of what is known, else a huge one.
  pure real(wp) function mean(values)
    real(wp), intent(in) :: values(:) !! zero where it is not known

    mean = huge(1.0_wp)
    if (any(values > 0.0_wp)) mean = sum(values)/real(count(values > 0.0_wp), wp)
  end function mean

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

  !> Modulus over height of the elastic elements around each node: the mean modulus over the mean
  !! height, so that a sliver beside others counts little.
  subroutine find_stiffness(model, near, area, of_nodes)
    type(model_t), intent(in) :: model !! mesh and materials
    logical, intent(in) :: near(:) !! (elements) next to the pair
    real(wp), intent(in) :: area !! of the surface that is pressed [length^2]
    real(wp), intent(out) :: of_nodes(:) !! (nodes) 0 where nothing yields [force/length^3]
    real(wp) :: heights(size(of_nodes)), squareness, height
    integer :: e, k

    of_nodes = 0.0_wp
    heights = 0.0_wp
    squareness = shape_factor(model, near, area)
    do e = 1, size(near)
      if (.not. near(e) .or. model%element_material(e) == 0) cycle
      associate (material => model%materials(model%element_material(e)), ix => model%mesh%ix(:, e))
        if (material%rigid) cycle
        height = least_height(model%mesh%x(:, ix(1:4)))
        do k = 1, size(ix)
          if (ix(k) == 0) exit
          of_nodes(ix(k)) = of_nodes(ix(k)) + layer_modulus(material, squareness)
          heights(ix(k)) = heights(ix(k)) + height
        end do
      end associate
    end do
    where (of_nodes > 0.0_wp) of_nodes = of_nodes/heights
  end subroutine find_stiffness

  !> Pressure over strain of a layer whose material cannot go aside: the confined modulus. Elements
  !! that keep their volume as wholes, or by nodes, let it go aside as far as the layer's shape does
  !! (Gent's bonded layer), however incompressible it is.
  pure real(wp) function layer_modulus(material, squareness) result(modulus)
    type(material_t), intent(in) :: material !! of the layer
    real(wp), intent(in) :: squareness !! shape factor of the body
    real(wp) :: nu

    nu = material%poissons_ratio
    modulus = material%youngs_modulus*(1.0_wp - nu)/((1.0_wp + nu)*(1.0_wp - 2.0_wp*nu))
    if (material%mean .or. material%nodal) modulus = min(modulus, material%youngs_modulus &
      *(least_confined + 2.0_wp*squareness**2))
  end function layer_modulus

  !> Loaded over free surface of a square layer that has area and volume of what is pressed:
  !! sqrt(A)/(4 H) with the height H = V/A.
  function shape_factor(model, near, area) result(factor)
    type(model_t), intent(in) :: model !! mesh and materials
    logical, intent(in) :: near(:) !! (elements) next to the pair
    real(wp), intent(in) :: area !! of the surface that is pressed [length^2]
    real(wp) :: factor, volume
    integer, allocatable :: element_body(:), node_body(:)
    logical, allocatable :: pressed(:)
    integer :: e, n

    factor = 0.0_wp
    if (.not. any(near .and. keeps_volume(model))) return
    call find_bodies(model%mesh, element_body, node_body, n)
    allocate (pressed(0:n), source=.false.)
    pressed(pack(element_body, near)) = .true.
    pressed(0) = .false.
    volume = 0.0_wp
    do e = 1, size(near)
      if (pressed(element_body(e))) volume = volume &
        + abs(tetrahedron_volume(model%mesh%x(:, model%mesh%ix(1:4, e))))
    end do
    if (volume > 0.0_wp) factor = 0.25_wp*area*sqrt(area)/volume
  end function shape_factor

  !> Elements whose volumetric part is on a mean dilatation.
  pure function keeps_volume(model) result(keeps)
    type(model_t), intent(in) :: model !! mesh and materials
    logical :: keeps(model%mesh%elements)
    integer :: e

    keeps = .false.
    do e = 1, size(keeps)
      if (model%element_material(e) == 0) cycle
      associate (material => model%materials(model%element_material(e)))
        keeps(e) = .not. material%rigid .and. (material%mean .or. material%nodal)
      end associate
    end do
  end function keeps_volume

  !> Least height of a tetrahedron: three times its volume over its largest face.
  pure real(wp) function least_height(x) result(height)
    real(wp), intent(in) :: x(3, 4) !! corners [length]

    height = 3.0_wp*abs(tetrahedron_volume(x))/max(facet_area(x(:, [1, 2, 3])), &
      facet_area(x(:, [1, 2, 4])), facet_area(x(:, [1, 3, 4])), facet_area(x(:, [2, 3, 4])))
  end function least_height
end module pressed_layers

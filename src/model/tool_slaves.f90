!> Where the slaves of a tool of triangles are: their facets, and points inside their bodies.
module tool_slaves
  use kinds, only: wp
  use mesh_types, only: mesh_t
  use mesh_names, only: find_nodes, find_surface
  use facets, only: facet_table_t
  use facet_geometry, only: facet_normal
  use cell_geometry, only: facet_vector, cell_volume, cell_middle
  use bodies, only: find_bodies
  implicit none
  private
  public :: slave_t, add_slave

  !> Elements of a body that tell where it lies, at most.
  integer, parameter :: most_samples = 1000

  !> Where a slave is: its facets, and points inside its body.
  type :: slave_t
    character(:), allocatable :: name !! its name
    real(wp), allocatable :: x(:, :) !! (3, n) middles of its facets [length]
    real(wp), allocatable :: normal(:, :) !! (3, n) outward
    real(wp), allocatable :: area(:) !! (n) [length^2]
    integer, allocatable :: body(:) !! (n) of them
    real(wp), allocatable :: height(:) !! (n) of the element behind [length]
    real(wp), allocatable :: inside(:, :) !! (3, m) middles of elements [length]
    real(wp), allocatable :: volume(:) !! (m) of them [length^3]
  end type slave_t

contains

  !> Adds what is known of a slave, if it has elements.
  subroutine add_slave(name, exterior, mesh, slaves)
    character(*), intent(in) :: name !! of a surface or a set
    type(facet_table_t), intent(in) :: exterior !! exterior facets of the mesh
    type(mesh_t), intent(in) :: mesh !! the mesh
    type(slave_t), allocatable, intent(inout) :: slaves(:) !! gets one more
    type(slave_t) :: slave
    integer, allocatable :: nodes(:), facets(:, :), elements(:), places(:)
    logical :: mask(mesh%nodes), found
    integer :: index, f

    call find_surface(mesh, name, index)
    if (index > 0) then
      facets = mesh%surfaces(index)%facets
      elements = mesh%surfaces(index)%elements
    else
      call find_nodes(mesh, name, nodes, found)
      mask = .false.
      mask(nodes) = .true.
      places = pack([(f, f=1, exterior%count)], [(all(mask(exterior%corners(:, f))), f=1, &
        exterior%count)])
      facets = exterior%corners(:, places)
      elements = exterior%elements(places)
    end if
    if (size(elements) == 0) return
    if (any(elements == 0)) return
    slave%name = name
    call take_facets(mesh, facets, elements, slave)
    call take_bodies(mesh, elements, slave)
    slaves = [slaves, slave]
  end subroutine add_slave

  !> Middles, normals, areas of slave facets, and heights of the elements behind them.
  subroutine take_facets(mesh, facets, elements, slave)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: facets(:, :) !! (3, n) corners
    integer, intent(in) :: elements(:) !! (n) elements behind
    type(slave_t), intent(inout) :: slave !! gets them
    integer :: f, n

    n = size(elements)
    allocate (slave%x(3, n), slave%normal(3, n), slave%area(n), slave%height(n))
    do f = 1, n
      associate (x => mesh%x(:, facets(:, f)), cell => mesh%ix(:, elements(f)))
        slave%x(:, f) = sum(x, 2)/3.0_wp
        slave%normal(:, f) = facet_normal(x)
        slave%area(f) = norm2(facet_vector(x))
        slave%height(f) = 3.0_wp*abs(cell_volume(mesh%x, cell))/slave%area(f)
      end associate
    end do
  end subroutine take_facets

  !> Middles and volumes of some elements of the bodies that a slave belongs to.
  subroutine take_bodies(mesh, elements, slave)
    type(mesh_t), intent(in) :: mesh !! the mesh
    integer, intent(in) :: elements(:) !! elements behind the slave's facets
    type(slave_t), intent(inout) :: slave !! gets inside, volume
    integer, allocatable :: body(:), body_of_node(:), members(:)
    logical, allocatable :: chosen(:)
    integer :: bodies, e, i, n

    call find_bodies(mesh, body, body_of_node, bodies)
    allocate (chosen(0:bodies), source=.false.)
    slave%body = body(elements)
    chosen(slave%body) = .true.
    members = pack([(e, e=1, mesh%elements)], chosen(body))
    n = min(most_samples, size(members))
    allocate (slave%inside(3, n), slave%volume(n))
    do i = 1, n
      e = members(1 + int((i - 1)*(real(size(members), wp)/real(n, wp))))
      slave%inside(:, i) = cell_middle(mesh%x, mesh%ix(:, e))
      slave%volume(i) = abs(cell_volume(mesh%x, mesh%ix(:, e)))
    end do
  end subroutine take_bodies
end module tool_slaves

!> SOLId NODAl: the volumetric energy of tetrahedra of four nodes on the dilatation of their nodes,
!! which keeps them from locking (doc/theory, "Near incompressibility", eqs. (8.6), (8.7)).
!!
!! The elements have the energy without its volumetric part. A node takes its share, a quarter, of
!! the elements around it that have one material: J_n = sum V_e J_e/(4 V_n).
module nodal_dilatation
  use kinds, only: wp
  use vectors, only: invert
  use cells, only: tet4
  use bulk_laws, only: laws
  use solid_shapes, only: flat_gradients
  use law_linear, only: lame
  use law_neohooke, only: neohooke_volume
  use deformation, only: volume_growth
  use element_lists, only: volume_list_t, bulk_list_t
  use model_types, only: model_t
  use block_matrix, only: find_block
  use system_types, only: system_t
  use system_parts, only: whole_form_t, bulk_answer_t
  implicit none
  private
  public :: list_volumes, add_volume_forces, add_volume_tangent, add_nodal_pressure

  !> What an element gives to the volumes of its nodes.
  type :: part_t
    real(wp) :: growth = 0.0_wp !! V (J - 1), in small strain V tr e [length^3]
    real(wp) :: volume = 0.0_wp !! V J, in finite strain [length^3]
    real(wp) :: gradient(3, 4) = 0.0_wp !! its derivative by the displacements [length^2]
    real(wp) :: c(3, 4) = 0.0_wp !! F^-T grad N_a, in finite strain [1/length]
  end type part_t

contains

  !> Lists the volumes: one for each node and material, with the nodes of the elements around it.
  subroutine list_volumes(model, list)
    type(model_t), intent(in) :: model !! mesh and materials
    type(volume_list_t), intent(inout) :: list !! gets all of it, if a material asks
    integer, allocatable :: entry_of(:)
    integer :: m, e, a

    if (.not. any(model%materials%nodal)) return
    allocate (list%corner(4, model%mesh%elements), source=0)
    allocate (list%lambda(size(model%materials)), list%finite(size(model%materials)))
    list%n = 0
    do m = 1, size(model%materials)
      call read_law(m)
      if (.not. model%materials(m)%nodal .or. model%materials(m)%rigid) cycle
      if (allocated(entry_of)) deallocate (entry_of)
      allocate (entry_of(model%mesh%nodes), source=0)
      do e = 1, model%mesh%elements
        if (model%element_material(e) /= m) cycle
        do a = 1, 4
          associate (number => entry_of(model%mesh%ix(a, e)))
            if (number == 0) then
              list%n = list%n + 1
              number = list%n
            end if
            list%corner(a, e) = number
          end associate
        end do
      end do
    end do
    call collect_patches(model, list)

  contains

    !> Lame's constant of the volumetric energy, and its kind.
    subroutine read_law(k)
      integer, intent(in) :: k !! the material
      real(wp) :: g

      associate (material => model%materials(k))
        call lame(material%youngs_modulus, material%poissons_ratio, list%lambda(k), g)
        list%finite(k) = laws(material%law)%finite
      end associate
    end subroutine read_law
  end subroutine list_volumes

  !> Nodes around each volume, its size and material, and where each element finds its nodes there.
  subroutine collect_patches(model, list)
    type(model_t), intent(in) :: model !! mesh
    type(volume_list_t), intent(inout) :: list !! corner given; gets the rest
    integer :: around(list%n), e, a, b, k
    real(wp) :: gradient(3, 4), volume

    around = 0
    do e = 1, size(list%corner, 2)
      if (list%corner(1, e) == 0) cycle
      around(list%corner(:, e)) = around(list%corner(:, e)) + 3
    end do
    allocate (list%ix(1 + maxval(around), list%n), list%nel(list%n), source=0)
    allocate (list%routine(list%n), list%set(list%n), source=1)
    allocate (list%size(list%n), source=0.0_wp)
    allocate (list%place(4, 4, size(list%corner, 2)), source=0)
    do e = 1, size(list%corner, 2)
      if (list%corner(1, e) == 0) cycle
      call flat_gradients(model%mesh%x(:, model%mesh%ix(:tet4%nodes, e)), gradient, volume)
      do a = 1, 4
        associate (v => list%corner(a, e))
          list%size(v) = list%size(v) + 0.25_wp*volume
          list%set(v) = model%element_material(e)
          do b = 1, 4
            k = findloc(list%ix(:list%nel(v), v), model%mesh%ix(b, e), 1)
            if (k == 0) then
              k = list%nel(v) + 1
              list%nel(v) = k
              list%ix(k, v) = model%mesh%ix(b, e)
            end if
            list%place(b, a, e) = k
          end do
        end associate
      end do
    end do
  end subroutine collect_patches

  !> What an element gives.
  pure function part_of(x, u, finite) result(part)
    real(wp), intent(in) :: x(3, 4) !! reference positions of its nodes [length]
    real(wp), intent(in) :: u(3, 4) !! their displacements [length]
    logical, intent(in) :: finite !! strain is finite
    type(part_t) :: part
    real(wp) :: gradient(3, 4), volume, f(3, 3), h(3, 3), j
    integer :: i

    call flat_gradients(x, gradient, volume)
    if (finite) then
      f = matmul(u, transpose(gradient))
      part%growth = volume*volume_growth(f)
      do i = 1, 3
        f(i, i) = f(i, i) + 1.0_wp
      end do
      call invert(f, h, j)
      part%c = matmul(transpose(h), gradient)
      part%volume = volume*j
      part%gradient = part%volume*part%c
    else
      part%growth = volume*sum(gradient*u)
      part%gradient = volume*gradient
    end if
  end function part_of

  !> Pressure (positive in tension) and its slope by J of all volumes, and their energy.
  subroutine find_pressures(list, ix, x, u, pressure, slope, energy)
    type(volume_list_t), intent(in) :: list !! volumes
    integer, intent(in) :: ix(:, :) !! (at least 4, elements) nodes
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(out) :: pressure(:) !! (n) U' [force/length^2]
    real(wp), intent(out) :: slope(:) !! (n) U'' [force/length^2]
    real(wp), intent(out) :: energy !! sum of V U [force length]
    real(wp) :: growth(list%n), density
    type(part_t) :: part
    integer :: e, v

    growth = 0.0_wp
    do e = 1, size(list%corner, 2)
      if (list%corner(1, e) == 0) cycle
      associate (corners => list%corner(:, e), nodes => ix(:4, e))
        part = part_of(x(:, nodes), u(:, nodes), list%finite(list%set(corners(1))))
        growth(corners) = growth(corners) + 0.25_wp*part%growth
      end associate
    end do
    energy = 0.0_wp
    do v = 1, list%n
      associate (lambda => list%lambda(list%set(v)))
        growth(v) = growth(v)/list%size(v)
        if (list%finite(list%set(v))) then
          call neohooke_volume(lambda, growth(v), density, pressure(v), slope(v))
        else
          density = 0.5_wp*lambda*growth(v)**2
          pressure(v) = lambda*growth(v)
          slope(v) = lambda
        end if
      end associate
      energy = energy + list%size(v)*density
    end do
  end subroutine find_pressures

  !> Adds forces and energy of the volumes.
  subroutine add_volume_forces(x, u, bulk, volumes, inner)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements, no element inverted [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(bulk_answer_t), intent(inout) :: inner !! the bulk's answer; gets bulk_force, bulk_energy
    real(wp), dimension(volumes%n) :: pressure, slope
    real(wp) :: energy
    type(part_t) :: part
    integer :: e

    if (volumes%n == 0) return
    associate (list => volumes)
      call find_pressures(list, bulk%ix, x, u, pressure, slope, energy)
      inner%bulk_energy = inner%bulk_energy + energy
      do e = 1, size(list%corner, 2)
        if (list%corner(1, e) == 0) cycle
        associate (corners => list%corner(:, e), nodes => bulk%ix(:4, e))
          part = part_of(x(:, nodes), u(:, nodes), list%finite(list%set(corners(1))))
          inner%bulk_force(:, nodes) = inner%bulk_force(:, nodes) &
            + 0.25_wp*sum(pressure(corners))*part%gradient
        end associate
      end do
    end associate
  end subroutine add_volume_forces

  !> Adds their tangent to the bulk's matrix.
  subroutine add_volume_tangent(x, u, bulk, volumes, whole)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements, no element inverted [length]
    type(bulk_list_t), intent(in) :: bulk !! bulk elements
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(whole_form_t), intent(inout) :: whole !! gets bulk_matrix
    real(wp), dimension(volumes%n) :: pressure, slope
    real(wp), allocatable :: b(:, :, :)
    real(wp) :: energy
    type(part_t) :: part
    integer :: e, a

    if (volumes%n == 0) return
    associate (list => volumes)
      call find_pressures(list, bulk%ix, x, u, pressure, slope, energy)
      allocate (b(3, size(list%ix, 1), list%n), source=0.0_wp)
      do e = 1, size(list%corner, 2)
        if (list%corner(1, e) == 0) cycle
        associate (corners => list%corner(:, e), nodes => bulk%ix(:4, e))
          part = part_of(x(:, nodes), u(:, nodes), list%finite(list%set(corners(1))))
          do a = 1, 4
            b(:, list%place(:, a, e), corners(a)) = b(:, list%place(:, a, e), corners(a)) &
              + 0.25_wp*part%gradient
          end do
          if (list%finite(list%set(corners(1)))) call add_turning(0.25_wp*sum(pressure(corners)) &
            *part%volume, part%c, nodes, whole)
        end associate
      end do
      call add_products(slope/list%size, b, volumes, whole)
    end associate
  end subroutine add_volume_tangent

  !> factor (c_a c_b^T - c_b c_a^T) of one element.
  subroutine add_turning(factor, c, nodes, whole)
    real(wp), intent(in) :: factor !! p V J [force length]
    real(wp), intent(in) :: c(3, 4) !! F^-T grad N_a [1/length]
    integer, intent(in) :: nodes(4) !! its nodes
    type(whole_form_t), intent(inout) :: whole !! gets bulk_matrix
    integer :: a, b, place, k

    do b = 1, 4
      do a = 1, 4
        if (a == b) cycle
        place = find_block(whole%bulk_matrix, nodes(a), nodes(b))
        do k = 1, 3
          whole%bulk_matrix%val(:, k, place) = whole%bulk_matrix%val(:, k, place) &
            + factor*(c(:, a)*c(k, b) - c(:, b)*c(k, a))
        end do
      end do
    end do
  end subroutine add_turning

  !> sum_n U''/V_n B_n B_n^T.
  subroutine add_products(factor, b, volumes, whole)
    real(wp), intent(in) :: factor(:) !! (n) U''/V_n
    real(wp), intent(in) :: b(:, :, :) !! (3, most nodes, n) B_n at the nodes of each volume
    type(volume_list_t), intent(in) :: volumes !! volumes of nodes
    type(whole_form_t), intent(inout) :: whole !! gets bulk_matrix
    integer :: v, i, j, place, k

    associate (list => volumes, val => whole%bulk_matrix%val)
      do v = 1, list%n
        do j = 1, list%nel(v)
          do i = 1, list%nel(v)
            place = find_block(whole%bulk_matrix, list%ix(i, v), list%ix(j, v))
            do k = 1, 3
              val(:, k, place) = val(:, k, place) + factor(v)*b(:, i, v)*b(k, j, v)
            end do
          end do
        end do
      end do
    end associate
  end subroutine add_products

  !> Adds the pressure, the mean over the nodes, to the stresses of the elements.
  subroutine add_nodal_pressure(x, u, system, stress)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(system_t), intent(in) :: system !! volumes
    real(wp), intent(inout) :: stress(:, :) !! (6, elements) xx yy zz xy yz zx
    real(wp), dimension(system%volumes%n) :: pressure, slope
    real(wp) :: energy
    integer :: e

    if (system%volumes%n == 0) return
    associate (list => system%volumes)
      call find_pressures(list, system%bulk%ix, x, u, pressure, slope, energy)
      do e = 1, size(list%corner, 2)
        if (list%corner(1, e) == 0) cycle
        stress(1:3, e) = stress(1:3, e) + 0.25_wp*sum(pressure(list%corner(:, e)))
      end do
    end associate
  end subroutine add_nodal_pressure
end module nodal_dilatation

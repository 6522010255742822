!> Pressures that follow the facets of regions of finite strain: forces that change with the
!! displacements, and their tangent (doc/theory, "Loads", eq. (9.3)). They count with the forces of
!! the bulk while Newton iterates, and with the loads once a state is accepted.
module follower_pressure
  use kinds, only: wp
  use vectors, only: cross
  use rotations, only: spin
  use cells, only: facet_of, most_facet_nodes
  use consistent_loads, only: facet_points, place_facet_points
  use loads, only: load_factor
  use block_matrix, only: find_block
  use model_types, only: model_t
  use system_parts, only: outer_t, whole_form_t, bulk_answer_t
  implicit none
  private
  public :: list_pressures, set_pressures, add_pressure_force, add_pressure_tangent, &
    take_pressure_force

  !> A facet under pressure where it is now.
  type :: pressed_t
    real(wp) :: pressure = 0.0_wp !! [force/length^2]
    integer :: points = 0 !! points of its rule, none without pressure
    real(wp) :: n(most_facet_nodes, facet_points) !! shape functions
    real(wp) :: slopes(2, most_facet_nodes, facet_points) !! their slopes by xi and eta
    real(wp) :: weights(facet_points) !! of the points
    real(wp) :: tangents(3, 2, facet_points) !! derivatives of the position by xi and eta [length]
  end type pressed_t

contains

  !> Lists the facets under pressure.
  pure subroutine list_pressures(model, loads)
    type(model_t), intent(in) :: model !! pressures and surfaces
    type(outer_t), intent(inout) :: loads !! gets pressed, pressure
    integer :: k, f, n

    n = 0
    do k = 1, size(model%conditions%pressures)
      n = n + size(model%mesh%surfaces(model%conditions%pressures(k)%surface)%facets, 2)
    end do
    allocate (loads%pressed(most_facet_nodes, n), loads%pressed_by(n), source=0)
    allocate (loads%pressure(size(model%conditions%pressures)), source=0.0_wp)
    n = 0
    do k = 1, size(model%conditions%pressures)
      associate (faces => model%mesh%surfaces(model%conditions%pressures(k)%surface))
        do f = 1, size(faces%facets, 2)
          n = n + 1
          loads%pressed(:, n) = facet_of(model%mesh%ix(:, faces%elements(f)), faces%facets(:, f))
          loads%pressed_by(n) = k
        end do
      end associate
    end do
  end subroutine list_pressures

  !> Pressures at a time.
  pure subroutine set_pressures(model, time, loads)
    type(model_t), intent(in) :: model !! pressures and tables
    real(wp), intent(in) :: time !! the time
    type(outer_t), intent(inout) :: loads !! gets pressure
    integer :: k

    if (.not. allocated(loads%pressure)) return
    do k = 1, size(loads%pressure)
      associate (load => model%conditions%pressures(k))
        loads%pressure(k) = load%value*load_factor(model%tables, load%table, time)
      end associate
    end do
  end subroutine set_pressures

  !> Places a facet under pressure.
  pure subroutine place_pressed(x, u, loads, f, facet)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(outer_t), intent(in) :: loads !! facets and pressures
    integer, intent(in) :: f !! number of the facet
    type(pressed_t), intent(out) :: facet !! the facet
    real(wp) :: y(3, most_facet_nodes)
    integer :: nodes, q, i

    nodes = count(loads%pressed(:, f) > 0)
    facet%pressure = loads%pressure(loads%pressed_by(f))
    if (abs(facet%pressure) <= 0.0_wp) return
    associate (ix => loads%pressed(:nodes, f))
      y(:, :nodes) = x(:, ix) + u(:, ix)
    end associate
    call place_facet_points(nodes, facet%points, facet%n, facet%slopes, facet%weights)
    do q = 1, facet%points
      do i = 1, 2
        facet%tangents(:, i, q) = matmul(y(:, :nodes), facet%slopes(i, :nodes, q))
      end do
    end do
  end subroutine place_pressed

  !> Adds a share of their forces.
  pure subroutine add_pressure_force(x, u, share, loads, force)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: share !! 1, or -1 for what stands with the internal forces
    type(outer_t), intent(in) :: loads !! facets and pressures
    real(wp), intent(inout) :: force(:, :) !! (3, nodes) forces [force]
    type(pressed_t) :: facet
    real(wp) :: t(3)
    integer :: f, q, a

    if (.not. allocated(loads%pressed)) return
    do f = 1, size(loads%pressed, 2)
      call place_pressed(x, u, loads, f, facet)
      associate (ix => loads%pressed(:, f))
        do q = 1, facet%points
          t = -share*facet%pressure*facet%weights(q)*cross(facet%tangents(:, 1, q), &
            facet%tangents(:, 2, q))
          do a = 1, count(ix > 0)
            force(:, ix(a)) = force(:, ix(a)) + facet%n(a, q)*t
          end do
        end do
      end associate
    end do
  end subroutine add_pressure_force

  !> Adds the derivatives of what stands with the internal forces to the bulk's tangent:
  !! `K_ab = p int N_a (N_b,2 [t1]x - N_b,1 [t2]x)`.
  pure subroutine add_pressure_tangent(x, u, loads, whole)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(outer_t), intent(in) :: loads !! facets and pressures
    type(whole_form_t), intent(inout) :: whole !! bulk_matrix grows
    type(pressed_t) :: facet
    integer :: f, q, a, b, nodes

    if (.not. allocated(loads%pressed)) return
    do f = 1, size(loads%pressed, 2)
      call place_pressed(x, u, loads, f, facet)
      nodes = count(loads%pressed(:, f) > 0)
      associate (ix => loads%pressed(:nodes, f))
        do q = 1, facet%points
          do b = 1, nodes
            do a = 1, nodes
              associate (k => whole%bulk_matrix%val(:, :, &
                find_block(whole%bulk_matrix, ix(a), ix(b))))
                k = k + facet%pressure*facet%weights(q)*facet%n(a, q) &
                  *(facet%slopes(2, b, q)*spin(facet%tangents(:, 1, q)) &
                  - facet%slopes(1, b, q)*spin(facet%tangents(:, 2, q)))
              end associate
            end do
          end do
        end do
      end associate
    end do
  end subroutine add_pressure_tangent

  !> At an accepted state the forces of the pressures stand with the loads.
  pure subroutine take_pressure_force(x, u, loads, inner)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements of the iterate [length]
    type(outer_t), intent(inout) :: loads !! loads and springs
    type(bulk_answer_t), intent(inout) :: inner !! the bulk's answer

    call add_pressure_force(x, u, 1.0_wp, loads, loads%external)
    call add_pressure_force(x, u, 1.0_wp, loads, inner%bulk_force)
  end subroutine take_pressure_force
end module follower_pressure

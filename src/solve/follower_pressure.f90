!> Pressures that follow the facets of regions of finite strain: forces that change with the
!! displacements, and their tangent (doc/theory, "Loads"). They count with the forces of the bulk
!! while Newton iterates, and with the loads once a state is accepted.
module follower_pressure
  use kinds, only: wp
  use vectors, only: cross
  use cells, only: facet_of, most_facet_nodes
  use consistent_loads, only: facet_points, place_facet_points
  use loads, only: load_factor
  use block_matrix, only: find_block
  use model_types, only: model_t
  use system_types, only: system_t
  implicit none
  private
  public :: list_pressures, set_pressures, add_pressure_force, add_pressure_tangent, &
    take_pressure_force

contains

  !> Lists the facets under pressure.
  pure subroutine list_pressures(model, system)
    type(model_t), intent(in) :: model !! pressures and surfaces
    type(system_t), intent(inout) :: system !! gets pressed, pressure
    integer :: k, f, n

    n = 0
    do k = 1, size(model%conditions%pressures)
      n = n + size(model%mesh%surfaces(model%conditions%pressures(k)%surface)%facets, 2)
    end do
    allocate (system%loads%pressed(most_facet_nodes, n), system%loads%pressed_by(n), source=0)
    allocate (system%loads%pressure(size(model%conditions%pressures)), source=0.0_wp)
    n = 0
    do k = 1, size(model%conditions%pressures)
      associate (faces => model%mesh%surfaces(model%conditions%pressures(k)%surface))
        do f = 1, size(faces%facets, 2)
          n = n + 1
          system%loads%pressed(:, n) = facet_of(model%mesh%ix(:, faces%elements(f)), &
            faces%facets(:, f))
          system%loads%pressed_by(n) = k
        end do
      end associate
    end do
  end subroutine list_pressures

  !> Pressures at a time.
  pure subroutine set_pressures(model, time, system)
    type(model_t), intent(in) :: model !! pressures and tables
    real(wp), intent(in) :: time !! the time
    type(system_t), intent(inout) :: system !! gets pressure
    integer :: k

    if (.not. allocated(system%loads%pressure)) return
    do k = 1, size(system%loads%pressure)
      associate (load => model%conditions%pressures(k))
        system%loads%pressure(k) = load%value*load_factor(model%tables, load%table, time)
      end associate
    end do
  end subroutine set_pressures

  !> Adds a share of their forces.
  pure subroutine add_pressure_force(x, u, share, system, force)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    real(wp), intent(in) :: share !! 1, or -1 for what stands with the internal forces
    type(system_t), intent(in) :: system !! facets and pressures
    real(wp), intent(inout) :: force(:, :) !! (3, nodes) forces [force]
    real(wp) :: y(3, most_facet_nodes), n(most_facet_nodes, facet_points), &
      slopes(2, most_facet_nodes, facet_points), weights(facet_points), t(3)
    integer :: f, q, a, nodes, points

    if (.not. allocated(system%loads%pressed)) return
    do f = 1, size(system%loads%pressed, 2)
      nodes = count(system%loads%pressed(:, f) > 0)
      associate (p => system%loads%pressure(system%loads%pressed_by(f)), &
        ix => system%loads%pressed(:nodes, f))
        if (abs(p) <= 0.0_wp) cycle
        y(:, :nodes) = x(:, ix) + u(:, ix)
        call place_facet_points(nodes, points, n, slopes, weights)
        do q = 1, points
          t = -share*p*weights(q)*cross(matmul(y(:, :nodes), slopes(1, :nodes, q)), &
            matmul(y(:, :nodes), slopes(2, :nodes, q)))
          do a = 1, nodes
            force(:, ix(a)) = force(:, ix(a)) + n(a, q)*t
          end do
        end do
      end associate
    end do
  end subroutine add_pressure_force

  !> Adds the derivatives of what stands with the internal forces to the bulk's tangent:
  !! `K_ab = p int N_a (N_b,2 [t1]x - N_b,1 [t2]x)`.
  pure subroutine add_pressure_tangent(x, u, system)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    real(wp), intent(in) :: u(:, :) !! (3, nodes) displacements [length]
    type(system_t), intent(inout) :: system !! bulk_matrix grows
    real(wp) :: y(3, most_facet_nodes), n(most_facet_nodes, facet_points), &
      slopes(2, most_facet_nodes, facet_points), weights(facet_points), t1(3), t2(3)
    integer :: f, q, a, b, nodes, points, place

    if (.not. allocated(system%loads%pressed)) return
    do f = 1, size(system%loads%pressed, 2)
      nodes = count(system%loads%pressed(:, f) > 0)
      associate (p => system%loads%pressure(system%loads%pressed_by(f)), &
        ix => system%loads%pressed(:nodes, f))
        if (abs(p) <= 0.0_wp) cycle
        y(:, :nodes) = x(:, ix) + u(:, ix)
        call place_facet_points(nodes, points, n, slopes, weights)
        do q = 1, points
          t1 = matmul(y(:, :nodes), slopes(1, :nodes, q))
          t2 = matmul(y(:, :nodes), slopes(2, :nodes, q))
          do b = 1, nodes
            do a = 1, nodes
              place = find_block(system%whole%bulk_matrix, ix(a), ix(b))
              associate (k => system%whole%bulk_matrix%val(:, :, place))
                k = k + p*weights(q)*n(a, q)*(slopes(2, b, q)*spin(t1) - slopes(1, b, q)*spin(t2))
              end associate
            end do
          end do
        end do
      end associate
    end do
  end subroutine add_pressure_tangent

  !> At an accepted state the forces of the pressures stand with the loads.
  pure subroutine take_pressure_force(x, system)
    real(wp), intent(in) :: x(:, :) !! (3, nodes) reference positions [length]
    type(system_t), intent(inout) :: system !! u, forces given; external and bulk_force change

    call add_pressure_force(x, system%u, 1.0_wp, system, system%loads%external)
    call add_pressure_force(x, system%u, 1.0_wp, system, system%inner%bulk_force)
  end subroutine take_pressure_force

  !> The matrix that takes a vector to the product a x v.
  pure function spin(a) result(m)
    real(wp), intent(in) :: a(3) !! a vector
    real(wp) :: m(3, 3)

    m = reshape([0.0_wp, a(3), -a(2), -a(3), 0.0_wp, a(1), a(2), -a(1), 0.0_wp], [3, 3])
  end function spin
end module follower_pressure

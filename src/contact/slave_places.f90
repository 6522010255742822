!> Places on slave facets of three nodes or six: what their nodes weigh there, where the points of a
!! segmented pair are, and their areas (doc/theory, "Six-node facets", "Segmentation", eq. (6.4)).
module slave_places
  use kinds, only: wp
  use vectors, only: cross
  use contact_types, only: pair_t, cell_t
  use facet_geometry, only: corners, facet_normal, project_points
  use smooth_patch, only: patch_point_t, patch_at, patch_from_values
  use quadratic_facet, only: facet_shapes_t, facet_shapes, facet_weights, facet_bent
  implicit none
  private
  public :: is_bent, slave_nodes, slave_positions, slave_weights, cell_position, place_of, &
    place_curved, share_of_area, project_into, slave_lift, lift_over

  !> Steps of the way into a curved facet, and the last of them [shape functions].
  integer, parameter :: most_way_steps = 60
  real(wp), parameter :: last_way_step = 1.0e-15_wp

contains

  !> A slave facet of a segmented pair has six nodes.
  pure logical function is_bent(pair, f)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! its slave facet

    is_bent = .false.
    if (allocated(pair%points%slave_middles)) is_bent = pair%points%slave_middles(1, f) > 0
  end function is_bent

  !> The nodes that the points of a slave facet are made of; where others of the pair have six and
  !! this one three, its first corner stands for the rest, without a weight.
  pure function slave_nodes(pair, f) result(nodes)
    type(pair_t), intent(in) :: pair !! a segmented pair
    integer, intent(in) :: f !! the slave facet
    integer :: nodes(pair%points%n_slaves)

    nodes = pair%points%slave_facets(1, f)
    nodes(:3) = pair%points%slave_facets(:, f)
    if (is_bent(pair, f)) nodes(4:) = pair%points%slave_middles(:, f)
  end function slave_nodes

  !> Positions of the corners of a slave facet, and of the middles of its edges if it has them.
  pure function slave_positions(pair, f, x) result(y)
    type(pair_t), intent(in) :: pair !! a segmented pair
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: y(3, 6)

    y = 0.0_wp
    y(:, :3) = corners(x, pair%points%slave_facets(:, f))
    if (is_bent(pair, f)) y(:, 4:) = corners(x, pair%points%slave_middles(:, f))
  end function slave_positions

  !> What the nodes of a slave facet weigh at a place.
  pure function slave_weights(pair, f, place) result(weights)
    type(pair_t), intent(in) :: pair !! a segmented pair
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: place(3) !! shape functions of the corners alone
    real(wp) :: weights(pair%points%n_slaves)

    weights = 0.0_wp
    weights(:3) = place
    if (.not. is_bent(pair, f)) return
    weights = facet_weights(place(1:2), facet_bent)
  end function slave_weights

  !> The place of a point of a cell.
  pure function cell_position(pair, cell, x) result(y)
    type(pair_t), intent(in) :: pair !! a segmented pair
    type(cell_t), intent(in) :: cell !! where the point is, of a slave facet
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: y(3)
    integer :: k

    if (is_bent(pair, cell%slave)) then
      y = matmul(slave_positions(pair, cell%slave, x), facet_weights(cell%weight(1:2), facet_bent))
    else
      y = 0.0_wp
      do k = 1, 3
        y = y + x(:, pair%points%slave_facets(k, cell%slave))*cell%weight(k)
      end do
      if (allocated(pair%points%side%patch)) y = y + lift_over(pair, cell%slave, cell%weight, x)
    end if
  end function cell_position

  !> How high a bent slave facet stands over its flat one (doc/theory, "Surface smoothing").
  pure real(wp) function slave_lift(pair, f, xi) result(lift)
    type(pair_t), intent(in) :: pair !! the pair
    integer, intent(in) :: f !! its slave facet
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    type(patch_point_t) :: point

    lift = 0.0_wp
    if (.not. allocated(pair%points%side%patch)) return
    point = patch_at(patch_from_values(pair%points%side%patch(:, f)), xi)
    lift = point%x(3)
  end function slave_lift

  !> The same as a way along the facet's normal.
  pure function lift_over(pair, f, place, x) result(way)
    type(pair_t), intent(in) :: pair !! a pair whose slave is bent
    integer, intent(in) :: f !! its slave facet
    real(wp), intent(in) :: place(3) !! shape functions of the corners
    real(wp), intent(in) :: x(:, :) !! (3, nodes) positions [length]
    real(wp) :: way(3)

    way = slave_lift(pair, f, place(1:2))*facet_normal(corners(x, pair%points%side%facets(:, f)))
  end function lift_over

  !> A place of a slave facet whose nodes are at y.
  pure function place_of(y, bent, xi) result(z)
    real(wp), intent(in) :: y(3, 6) !! nodes, the middles only if it is bent [length]
    logical, intent(in) :: bent !! it has six nodes
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: z(3)

    if (bent) then
      z = matmul(y, facet_weights(xi, facet_bent))
    else
      z = y(:, 3) + xi(1)*(y(:, 1) - y(:, 3)) + xi(2)*(y(:, 2) - y(:, 3))
    end if
  end function place_of

  !> A point of a facet of six nodes: what its nodes weigh, and half the size of its tangents'
  !! product, which times its share is its area.
  pure subroutine place_curved(y, xi, weights, area)
    real(wp), intent(in) :: y(3, 6) !! reference positions of its nodes [length]
    real(wp), intent(in) :: xi(2) !! place
    real(wp), intent(out) :: weights(6) !! M_b
    real(wp), intent(out) :: area !! [length^2]
    type(facet_shapes_t) :: s
    real(wp) :: t(3, 2)

    s = facet_shapes(xi, facet_bent)
    weights = s%n
    t = matmul(y, s%d)
    area = 0.5_wp*norm2(cross(t(:, 1), t(:, 2)))
  end subroutine place_curved

  !> Reference area of a slave facet that a share of its unit triangle has around a place.
  pure real(wp) function share_of_area(pair, f, xi) result(area)
    type(pair_t), intent(in) :: pair !! a segmented pair
    integer, intent(in) :: f !! the slave facet
    real(wp), intent(in) :: xi(2) !! (xi, eta)
    real(wp) :: weights(6)

    if (is_bent(pair, f)) then
      call place_curved(pair%points%slave_shape(:, :, f), xi, weights, area)
    else
      area = pair%points%slave_area(f)
    end if
  end function share_of_area

  !> (xi, eta) of points in a facet of six nodes, seen along the normal of its corners. With o_m
  !! from the middle of the straight edge m to its node, in the (xi, eta) of the corners, and L
  !! pulled into the facet: xi = xi_flat - sum 4 L_a L_b o_m, by substitution. Inside that is the
  !! facet itself, outside its edges go on straight: two points never change sides.
  pure subroutine project_into(x, n_points, y, xi)
    real(wp), intent(in) :: x(3, 6) !! nodes [length]
    integer, intent(in) :: n_points !! how many
    real(wp), intent(in) :: y(3, n_points) !! the points [length]
    real(wp), intent(out) :: xi(2, n_points) !! (xi, eta)
    real(wp) :: offset(2, 3), gaps(max(3, n_points)), flat(2, n_points), l(3), next(2)
    real(wp), parameter :: edge_middles(2, 3) = reshape([0.5_wp, 0.5_wp, 0.0_wp, 0.5_wp, 0.5_wp, &
      0.0_wp], [2, 3])
    integer :: k, step

    call project_points(x(:, 1:3), 3, x(:, 4:6), offset, gaps(:3))
    offset = offset - edge_middles
    call project_points(x(:, 1:3), n_points, y, flat, gaps(:n_points))
    xi = flat
    do k = 1, n_points
      do step = 1, most_way_steps
        l = max(0.0_wp, [xi(:, k), 1.0_wp - sum(xi(:, k))])
        l = l/sum(l)
        next = flat(:, k) - matmul(offset, 4.0_wp*l*l([2, 3, 1]))
        if (maxval(abs(next - xi(:, k))) <= last_way_step) exit
        xi(:, k) = next
      end do
    end do
  end subroutine project_into
end module slave_places
